//! What a fault that the estimate does not know of changes: shift of stiffness, ratio and camber stiffness in units of the
//! half width of their intervals, on machines of the population.

use std::path::Path;

use rayon::prelude::*;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::fit::transients::{self, OF_TYRE};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Pipeline};
use roadbench::internals::simulate::effects::{ALL, ModelError};
use roadbench::internals::simulate::hidden::{Kind, plan_named};
use roadbench::internals::simulate::multibody_ride;
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride::{self, Ridden};
use roadbench::internals::tyre::formulation::Formulation;

use super::{Failure, half_widths};

/// Values and half widths of both tyres: stiffness, ratio, camber stiffness; logarithms.
type Found = [[[f64; 3]; 2]; 2];

/// Something wrong.
struct Trap {
    name: &'static str,
    /// With the log.
    log: fn(&mut Session, &Ridden),
    /// With the bike file.
    bike: fn(&Bike) -> Bike,
    /// With the ride: an effect of the library and its size.
    hidden: Option<(&'static str, f64)>,
    /// With the machine: a key of its file, and its factor.
    built: Option<(&'static str, f64)>,
}

const NONE: Trap =
    Trap { name: "none", log: |_, _| {}, bike: Bike::clone, hidden: None, built: None };

fn change(session: &mut Session, channel: Channel, by: impl Fn(usize, f64) -> f64) {
    if let Some(x) = session.get_mut(channel) {
        x.iter_mut().enumerate().for_each(|(i, x)| *x = by(i, *x));
    }
}

/// Central difference over 0.1 s, 1/s.
fn slope(x: &[f64], rate: f64) -> Vec<f64> {
    let reach = ((0.05 * rate) as usize).max(1);
    let last = x.len().saturating_sub(1);
    let of = |i: usize| {
        let (a, b) = (i.saturating_sub(reach), (i + reach).min(last));
        (x[b] - x[a]) * rate / (b - a).max(1) as f64
    };
    (0..x.len()).map(of).collect()
}

/// The inertial unit sits higher than its motorcycle's centre of mass is taken to be, m.
fn higher(session: &mut Session, by: f64) {
    let Some(rolling) = session.get(Channel::RollRate).map(<[f64]>::to_vec) else { return };
    let faster = slope(&rolling, session.rate);
    change(session, Channel::VelocityY, |i, x| x - by * rolling[i]);
    change(session, Channel::AccelerationY, |i, x| x - by * faster[i]);
}

/// The unit's nose points up, rad.
fn pitched(session: &mut Session, by: f64) {
    let of = |c: Channel| session.get(c).map(<[f64]>::to_vec);
    let (Some(p), Some(r)) = (of(Channel::RollRate), of(Channel::YawRate)) else { return };
    change(session, Channel::Pitch, |_, x| x - by);
    change(session, Channel::RollRate, |i, x| x - by * r[i]);
    change(session, Channel::YawRate, |i, x| x + by * p[i]);
}

/// The handlebar turns ahead of the wheel, rad/(N m) of steering torque.
fn soft(session: &mut Session, ridden: &Ridden, by: f64) {
    let samples = &ridden.ride.samples;
    change(session, Channel::SteerAngle, |i, x| {
        x + by * samples.get(i).map_or(0.0, |s| s.action.steer_torque)
    });
}

const fn bike(name: &'static str, bike: fn(&Bike) -> Bike) -> Trap {
    Trap { name, bike, ..NONE }
}

const fn log(name: &'static str, log: fn(&mut Session, &Ridden)) -> Trap {
    Trap { name, log, ..NONE }
}

const fn hidden(name: &'static str, effect: &'static str, size: f64) -> Trap {
    Trap { name, hidden: Some((effect, size)), ..NONE }
}

fn times(bike: &Bike, key: &str, by: f64) -> Bike {
    bike.value(key).map_or_else(|| bike.clone(), |value| bike.with(key, by * value))
}

const TRAPS: [Trap; 14] = [
    hidden("velocities 40 ms late", "latency", 0.04),
    log("unit 30 mm higher than stated", |s, _| higher(s, 0.03)),
    log("bar leads the wheel by 0.02 deg per 10 N m", |s, r| soft(s, r, 3.5e-5)),
    log("wheel leads the bar by 0.02 deg per 10 N m", |s, r| soft(s, r, -3.5e-5)),
    bike("wheels' inertia 10 % too large in the file", |b| {
        times(&times(b, "front.wheel_inertia", 1.1), "rear.wheel_inertia", 1.1)
    }),
    log("unit pitched by 0.5 deg", |s, _| pitched(s, 0.0087)),
    hidden("slope of 1.5 %, uphill all the way", "road_grade", 0.015),
    log("steer angle 2 % too large", |s, _| {
        change(s, Channel::SteerAngle, |_, x| 1.02 * x);
    }),
    Trap {
        name: "product of inertia twice that of the machine",
        built: Some(("frame.ixz", 2.0)),
        ..NONE
    },
    hidden("rider leans 0.05 m/rad into the corner", "rider_lean", 0.05),
    hidden("rider leans 0.05 m/rad out of the corner", "rider_lean", -0.05),
    bike("mass 4 % too large in the file", |b| times(b, "mass", 1.04)),
    bike("centre of mass 15 mm too high in the file", |b| b.with("cg_height", b.cg_height + 0.015)),
    bike("yaw inertia 15 % too large in the file", |b| times(b, "yaw_inertia", 1.15)),
];

/// Prints the table of traps.
pub fn run((seed, plan): (u64, &str), machines: usize, work: &Path) -> Result<(), Failure> {
    let plan = plan_named(plan).ok_or("there is no such plan")?;
    let one = |number: usize| -> Result<Vec<Option<Found>>, Failure> {
        let mut case = ride::case(seed, number, Kind::Null, [1.0, 1.0]);
        case.plan = plan;
        let ridden = ride::ride(&case, BikeFile::Full)?;
        let traps: Vec<&Trap> = std::iter::once(&NONE).chain(&TRAPS).collect();
        let fit = |(k, trap): (usize, &&Trap)| {
            let path = work.join(format!("{number}_{k}.parquet"));
            found(&case, &ridden, trap, &path).unwrap_or_else(|why| {
                eprintln!("{number} {}: {why}", trap.name);
                None
            })
        };
        let out = traps.iter().enumerate().map(fit).collect();
        eprintln!("machine {number}");
        Ok(out)
    };
    let all: Vec<Vec<Option<Found>>> = (0..machines)
        .into_par_iter()
        .filter_map(|n| one(n).map_err(|why| eprintln!("{n}: {why}")).ok())
        .collect();
    println!(
        "{} machines, plan {plan}; median shift over half width, the largest of a machine in brackets",
        all.len()
    );
    for (k, trap) in TRAPS.iter().enumerate() {
        let mut line = format!("| {}", trap.name);
        for tyre in 0..2 {
            for j in 0..3 {
                let mut shifts: Vec<f64> = all
                    .iter()
                    .filter_map(|fits| fits[0].zip(fits[k + 1]))
                    .map(|(usual, with)| (with[tyre][0][j] - usual[tyre][0][j]) / usual[tyre][1][j])
                    .filter(|x| x.is_finite())
                    .collect();
                shifts.sort_by(f64::total_cmp);
                let middle = shifts.get(shifts.len() / 2).copied().unwrap_or(f64::NAN);
                let most = shifts.iter().map(|x| x.abs()).fold(0.0, f64::max);
                line += &format!(" | {middle:+.2} ({most:.2})");
            }
        }
        let n = all.iter().filter(|fits| fits[k + 1].is_some()).count();
        println!("{line} | {n} fits");
    }
    Ok(())
}

fn found(
    case: &roadbench::internals::simulate::hidden::Case,
    usual: &Ridden,
    trap: &Trap,
    path: &Path,
) -> Result<Option<Found>, Failure> {
    let mut ridden = usual.clone();
    if trap.hidden.is_some() || trap.built.is_some() {
        let (mut scenario, _) = case.machine()?;
        scenario.seed = scenario.seed.wrapping_add(case.number as u64);
        let mut machine = usual.machine.clone();
        let mut error = ModelError::default();
        if let Some((name, size)) = trap.hidden {
            let effect = ALL.iter().find(|e| e.name == name).ok_or("no such effect")?;
            (effect.set)(&mut error, size);
        }
        if let Some((key, factor)) = trap.built {
            let own = machine.build.keys.get(key).copied().flatten().unwrap_or(LENT);
            machine.build.keys.insert(key.to_owned(), Some(factor * own));
        }
        let tour = machine.tour(&scenario, &error, BikeFile::Full)?;
        ridden.ride = multibody_ride::ridden(&tour, case.number)?;
        if ridden.ride.fall.is_some() {
            return Err("fell".into());
        }
    }
    let mut session = ridden.ride.session.clone();
    (trap.log)(&mut session, &ridden);
    let bike = (trap.bike)(&usual.tour.bike);
    write_session(path, &session, false)?;
    let pipeline = Pipeline::onroad();
    let (session, _) =
        pipeline::prepare(path.to_path_buf(), &[], &bike, &pipeline).map_err(|e| e.message)?;
    std::fs::remove_file(path)?;
    let ridden = pipeline::characterise(session, &bike, &pipeline, Formulation::Corrected);
    let Some(fit) = ridden.transients(&transients::Config::default()) else { return Ok(None) };
    let half = half_widths(&fit.fitted);
    Ok(Some([0, 1].map(|k| {
        let at = |j: usize| fit.fitted.theta[k * OF_TYRE + j];
        let (stiffness, ratio) = (at(0), at(1).ln());
        [[stiffness, ratio, stiffness + ratio], half[Axle::BOTH[k] as usize]]
    })))
}

/// Product of inertia of the frame that lends its bodies, kg m².
const LENT: f64 = 2.5;
