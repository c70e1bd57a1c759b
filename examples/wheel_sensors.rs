//! What sensors of the wheels are worth: the same rides read without them and with each kind.
//!
//! ```text
//! cargo run --release --example wheel_sensors -- --rides 40 --seed 1
//! cargo run --release --example wheel_sensors -- --rides 40 --plan paper
//! ```
//!
//! Every ride is on a machine of its own of the population: the nonlinear motorcycle, whose construction is not the
//! model's. Prints for each coefficient and kind of sensor how many values are `ok`, how wide their intervals are, how far
//! off the values, and how often the interval contains the true value.

use std::collections::BTreeMap;

use rayon::prelude::*;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::channel::Channel as C;
use roadbench::internals::contract::coefficient::{Coefficient, Id, Source};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::hidden::{self, Case, Kind};
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride;
use roadbench::internals::simulate::ride::MultibodyRide;
use roadbench::internals::simulate::sensors::{self, Sensor, Sensors};
use roadbench::internals::simulate::track::{self, Track};
use roadbench::internals::simulate::truth::of_corners;
use roadbench::internals::simulate::tyre_truth;
use roadbench::internals::simulate::wheel_sensors::of_multibody;
use roadbench::internals::store::objects::Location;

/// A kind of sensor: what it is called, and its channels with their errors.
pub type Set = (&'static str, Vec<(C, Sensor)>);

/// Every kind that is compared.
pub fn sets() -> Vec<Set> {
    // an optical sensor: 0.1 degrees of mounting and of noise
    let optical = Sensor { white: 0.002, bias: 0.002, ..Sensor::default() };
    // a measuring wheel: 1 % with its crosstalk
    let force = Sensor { white: 20.0, bias: 3.0, scale: 0.01, ..Sensor::default() };
    let moment = Sensor { white: 2.0, bias: 0.3, scale: 0.01, ..Sensor::default() };
    let angles = vec![(C::SlipAngleFront, optical), (C::SlipAngleRear, optical)];
    let forces: Vec<(C, Sensor)> = [
        C::WheelForceXFront,
        C::WheelForceXRear,
        C::WheelForceYFront,
        C::WheelForceYRear,
        C::WheelForceZFront,
        C::WheelForceZRear,
    ]
    .map(|c| (c, force))
    .into();
    let moments = vec![(C::WheelMomentXFront, moment), (C::WheelMomentXRear, moment)];
    let torque = Sensor { white: 2.0, bias: 0.3, scale: 0.01, ..Sensor::default() };
    let brakes = vec![(C::BrakeTorqueFront, torque), (C::BrakeTorqueRear, torque)];
    let wheels = [forces, moments].concat();
    vec![
        ("none", Vec::new()),
        ("brake torques", brakes),
        ("slip angles", angles.clone()),
        ("measuring wheels", wheels.clone()),
        ("measuring wheels and slip angles", [wheels, angles].concat()),
    ]
}

/// One coefficient of all rides with one kind of sensor.
#[derive(Debug, Clone, Default)]
pub struct Tally {
    /// Value over truth less one, of every `ok` value.
    pub errors: Vec<f64>,
    /// Half width of the interval over the truth, of every `ok` value.
    pub widths: Vec<f64>,
    /// `ok` values whose interval contains the true value.
    pub inside: usize,
    /// Rides.
    pub rides: usize,
}

/// Tallies by coefficient and place of the set.
pub type Tallies = BTreeMap<(Id, usize), Tally>;

/// Values, intervals and truths of one ride with one set of sensors.
type Row = (Id, usize, Option<[f64; 3]>, f64);

/// A ride with what is true of it.
pub struct Known {
    /// Log and what the simulator knows.
    pub ride: MultibodyRide,
    /// Bike file.
    pub bike: Bike,
    /// True coefficients.
    pub truth: Vec<(Id, f64)>,
    /// Number of the ride.
    pub number: usize,
}

/// The circuit instead of a plan of straights and corners.
pub const TRACK: &str = "track";

/// The ride of a number by a plan.
pub fn known(seed: u64, number: usize, plan: &'static str) -> Result<Known, String> {
    let config = Pipeline::onroad().estimate;
    if plan == TRACK {
        let mut track = Track::load(TRACK).map_err(|e| e.to_string())?.ok_or("no such track")?;
        track.seed = seed;
        track.laps = 2;
        let ridden = track::ride(&track, number).map_err(|e| e.to_string())?;
        let model = &ridden.entry.model;
        let mut truth = tyre_truth::coefficients(model);
        let ratio = Axle::BOTH.map(|axle| {
            let id = Id::from((axle, Coefficient::SideForceRatio));
            truth.iter().find(|(known, _)| *known == id).map_or(f64::NAN, |(_, value)| *value)
        });
        let weight = model.motorcycle.mass() * model.motorcycle.gravity;
        let cornered = of_corners(&ridden.ride, weight, ratio, &config);
        truth.retain(|(id, _)| cornered.iter().all(|(known, _)| known != id));
        truth.extend(cornered);
        return Ok(Known { bike: ridden.entry.bike, ride: ridden.ride, truth, number });
    }
    let drawn = ride::case(seed, number, Kind::Null, [1.0, 1.0]);
    let ridden = ride::ride(&Case { plan, ..drawn }, BikeFile::Full).map_err(|e| e.to_string())?;
    let truth = ridden.truth(&config);
    Ok(Known { bike: ridden.tour.bike, ride: ridden.ride, truth, number })
}

fn one(
    known: Known,
    sets: &[Set],
    missing: &[C],
    work: &std::path::Path,
) -> Result<Vec<Row>, String> {
    let Known { ride, bike, mut truth, number } = known;
    let pipeline = Pipeline::onroad();
    truth.retain(|(id, value)| {
        value.is_finite()
            && (id.coefficient.spec().source == Source::OnRoad
                || matches!(
                    id.coefficient,
                    Coefficient::SideForceRatio | Coefficient::SlipStiffness
                ))
    });
    let mut out = Vec::new();
    for (place, (_, channels)) in sets.iter().enumerate() {
        let named: Sensors =
            channels.iter().map(|(c, sensor)| (c.name().to_owned(), *sensor)).collect();
        let mut log = ride.session.clone();
        for channel in missing {
            log.remove(*channel);
        }
        let seen = ride.samples.iter().map(|s| (s.wheels, s.action));
        of_multibody(&mut log, seen, &named);
        sensors::measure(&mut log, &named, number as u64);
        let path = work.join(format!("{number}_{place}.parquet"));
        write_session(&path, &log, false).map_err(|e| e.to_string())?;
        let input = Input {
            log: Location::from(path.as_path()),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        let outcome = pipeline::run(&input, &bike, &pipeline).map_err(|e| e.message)?;
        for (id, truth) in &truth {
            let row = outcome
                .coefficients
                .iter()
                .find(|c| c.tyre == id.part.name() && c.coefficient == id.coefficient.name());
            let known = row
                .filter(|c| c.status.name() == "ok")
                .and_then(|c| Some([c.value?, c.ci95_low?, c.ci95_high?]));
            out.push((*id, place, known, *truth));
        }
        std::fs::remove_file(&path).map_err(|e| e.to_string())?;
    }
    Ok(out)
}

/// As many rides by a plan, with every set.
pub fn ridden(rides: usize, seed: u64, plan: &'static str, sets: &[Set], missing: &[C]) -> Tallies {
    let work = tempfile::tempdir().expect("a folder for the logs");
    let of = |number: usize| {
        let rows =
            known(seed, number, plan).and_then(|known| one(known, sets, missing, work.path()));
        rows.inspect_err(|why| eprintln!("{number}: {why}")).unwrap_or_default()
    };
    let all: Vec<Vec<Row>> = (0..rides).into_par_iter().map(of).collect();
    let mut out = Tallies::new();
    for (id, place, known, truth) in all.into_iter().flatten() {
        let tally = out.entry((id, place)).or_default();
        tally.rides += 1;
        if let Some([value, low, high]) = known {
            tally.errors.push(value / truth - 1.0);
            tally.widths.push((0.5 * (high - low) / truth).abs());
            tally.inside += usize::from((low..=high).contains(&truth));
        }
    }
    out
}

/// Median of absolute values.
pub fn median(x: &[f64]) -> f64 {
    let mut x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
    x.sort_by(f64::total_cmp);
    x.get(x.len() / 2).copied().unwrap_or(f64::NAN)
}

#[derive(clap::Parser)]
struct Arguments {
    /// Rides, each on a motorcycle of its own.
    #[arg(long, default_value_t = 40)]
    rides: usize,
    /// Seed of all randomness.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Plan of the rides: paper, naturalistic, "mixed + 2 fast passes", "full transient programme", or track: two laps.
    #[arg(long, default_value = "naturalistic")]
    plan: String,
    /// Logs without lateral velocity and handlebar angle, as most track loggers write.
    #[arg(long)]
    track: bool,
}

#[allow(dead_code)] // the tests use the rest
fn main() {
    let Arguments { rides, seed, plan, track } = clap::Parser::parse();
    let on_track = (plan == TRACK).then_some(TRACK);
    let Some(plan) = on_track.or_else(|| hidden::plan_named(&plan)) else {
        eprintln!("no plan `{plan}`");
        return;
    };
    let sets = sets();
    let missing: &[C] = if track { &[C::VelocityY, C::SteerAngle] } else { &[] };
    let tallies = ridden(rides, seed, plan, &sets, missing);
    println!(
        "{plan}, {}\n",
        if track { "without lateral velocity and handlebar" } else { "all usual channels" }
    );
    let names: Vec<&str> = sets.iter().map(|(name, _)| *name).collect();
    println!("| coefficient | {} |", names.join(" | "));
    println!("|---|{}", "---|".repeat(names.len()));
    let ids: std::collections::BTreeSet<Id> = tallies.keys().map(|(id, _)| *id).collect();
    for id in ids {
        let cell = |place: usize| {
            let Some(t) = tallies.get(&(id, place)).filter(|t| !t.widths.is_empty()) else {
                return "-".to_owned();
            };
            format!(
                "{}/{}: ±{:.1} %, off {:.1} %, holds {}",
                t.widths.len(),
                t.rides,
                100.0 * median(&t.widths),
                100.0 * median(&t.errors),
                t.inside
            )
        };
        let cells: Vec<String> = (0..sets.len()).map(cell).collect();
        println!("| {id} | {} |", cells.join(" | "));
    }
}
