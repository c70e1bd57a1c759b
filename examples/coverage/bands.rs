//! Do the bands that a session's page draws around its fits hold the true curves?

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::hidden::Case;
use roadbench::internals::simulate::population::bike::{self, BikeFile};
use roadbench::internals::simulate::population::ride::{self, Ridden};
use roadbench::internals::simulate::tyre_truth::bench;
use roadbench::internals::store::tables::rows::{Coefficient, PlotPoint};
use roadbench::internals::tyre::paper::Input;
use roadbench::internals::tyre::paper::slip_stiffness_under;

use super::{Failure, outcome};

/// Points of one line on one page: how many, and how many of their bands contain the true value.
type Held = (String, bool, usize, usize);

/// Prints a line per chart: rides, and the share of its points whose band contains the true value.
pub fn print(rides: usize, case: impl Fn(usize) -> Case + Sync, pipeline: &Pipeline, work: &Path) {
    let of = |number: usize| {
        of_ride(number, &case(number), pipeline, work)
            .map_err(|why| eprintln!("{number}: {why}"))
            .ok()
    };
    let all: Vec<Held> = (0..rides).into_par_iter().filter_map(of).flatten().collect();
    let mut table: BTreeMap<(&str, bool), [usize; 4]> = BTreeMap::new();
    for (plot, determined, points, held) in &all {
        let sums = table.entry((plot, *determined)).or_default();
        sums[0] += 1;
        sums[1] += points;
        sums[2] += held;
        sums[3] += usize::from(2 * held > *points);
    }
    println!("| chart | coefficient | rides | points in the band | rides with most points in it |");
    println!("|---|---|---:|---:|---:|");
    for ((plot, determined), [rides, points, held, most]) in table {
        let status = if determined { "determined" } else { "not determined" };
        let share = 100.0 * held as f64 / points as f64;
        println!("| {plot} | {status} | {rides} | {share:.1} % | {most} of {rides} |");
    }
}

fn of_ride(
    number: usize,
    case: &Case,
    pipeline: &Pipeline,
    work: &Path,
) -> Result<Vec<Held>, Failure> {
    let ridden = ride::ride(case, BikeFile::Full)?;
    let log = work.join(format!("bands_{number}.parquet"));
    write_session(&log, &ridden.ride.session, false)?;
    let usual = ridden.machine.motorcycle(&ModelError::default())?;
    let bike = bike::bike(&ridden.machine, &usual, BikeFile::Full)?;
    let outcome = outcome(&log, &bike, pipeline)?;
    std::fs::remove_file(&log)?;
    let known = ridden.truth(&pipeline.estimate);
    let of = |id: Id| known.iter().find(|k| k.0 == id).map_or(f64::NAN, |k| k.1);
    let static_load = Axle::BOTH.map(|axle| bike.static_load(axle));
    let weight = bike.mass * roadbench::GRAVITY;
    let row = |id: Id| {
        let is_own = |r: &&Coefficient| Id::from_names(&r.tyre, &r.coefficient) == Some(id);
        outcome.coefficients.iter().find(is_own)
    };
    let mut all: BTreeMap<(String, bool), [usize; 2]> = BTreeMap::new();
    for p in outcome.plots.iter().filter(|p| p.series != "data") {
        let Some((id, truth)) = truth(p, &ridden, &of, static_load, weight) else { continue };
        let row = row(id);
        let truth = match id.coefficient {
            // the lever of the line is not in the table: the coefficient's part of the ordinate
            C::OverturningStiffness => {
                truth / row.and_then(|r| r.value).unwrap_or(f64::NAN) * p.y.unwrap_or(f64::NAN)
            }
            _ => truth,
        };
        let (Some(low), Some(high), true) = (p.y_low, p.y_high, truth.is_finite()) else {
            continue;
        };
        if high <= low {
            continue; // where the curve goes through nil
        }
        let determined = row.is_some_and(|r| r.status.name() == "ok");
        let sums = all.entry((format!("{} {}", p.plot, p.series), determined)).or_default();
        sums[0] += 1;
        sums[1] += usize::from((low..=high).contains(&truth));
    }
    Ok(all.into_iter().map(|((plot, ok), [n, held])| (plot, ok, n, held)).collect())
}

/// The coefficient that a line belongs to, and the true ordinate; of the overturning line the true coefficient.
fn truth(
    p: &PlotPoint,
    ridden: &Ridden,
    of: &impl Fn(Id) -> f64,
    static_load: [f64; 2],
    weight: f64,
) -> Option<(Id, f64)> {
    let vehicle = |c: C| Id::from((Part::Vehicle, c));
    match &*p.plot {
        "coast_down" => {
            let [drag, rolling] = [C::Drag, C::RollingResistance].map(|c| of(vehicle(c)));
            return Some((vehicle(C::Drag), drag * p.x + rolling * weight));
        }
        "overturning" => {
            let id = Id::from((Axle::Front, C::OverturningStiffness));
            return Some((id, of(id)));
        }
        _ => {}
    }
    let (plot, wheel) = p.plot.rsplit_once('_')?;
    let axle = Axle::BOTH.into_iter().find(|a| a.name() == wheel)?;
    let id = |c: C| Id::from((axle, c));
    match (plot, &*p.series) {
        ("slip_angle", _) => {
            let [c1, c3] = [C::SlipCamberC1, C::SlipCamberC3].map(|c| of(id(c)));
            Some((id(C::SlipCamberC1), c1 * p.x + c3 * p.x.powi(3)))
        }
        ("friction_y", _) => {
            Some((id(C::LateralFrictionCt), of(id(C::LateralFrictionCt)) * p.x.tan()))
        }
        ("stiffness", name) if p.x == 0.0 => {
            let camber = name == "k_gamma";
            let c = if camber { C::CamberStiffness0 } else { C::CorneringStiffness0 };
            Some((id(c), of(id(c))))
        }
        ("friction_x", _) if p.x < -0.002 => {
            let gain = of(id(C::SlipStiffnessLoad));
            Some((id(C::MfD), friction(ridden, axle as usize, p.x, gain, static_load)?))
        }
        _ => None,
    }
}

/// True longitudinal friction at a slip that the tyre would have under its load at rest, as an estimate counts it:
/// beyond the rolling resistance, from free rolling on, under the load of hard braking.
fn friction(ridden: &Ridden, k: usize, slip: f64, gain: f64, static_load: [f64; 2]) -> Option<f64> {
    let model = &ridden.tour.model;
    let tyre = model.motorcycle.tyres.as_ref()?[k].as_ref();
    let used = |i: usize| {
        let wheel = &ridden.ride.samples[i].wheels[k];
        (-wheel.force[0] / wheel.load.max(100.0), wheel.load)
    };
    let samples = ridden.ride.samples.len();
    let most = (0..samples).map(|i| used(i).0).fold(0.0, f64::max);
    let hard = (0..samples).map(used).filter(|u| u.0 > 0.7 * most);
    let (n, sum) = hard.fold((0.0, 0.0), |(n, sum), u| (n + 1.0, sum + u.1));
    let load = sum / n;
    let road = model.road.friction;
    let bench = bench(tyre, load, road);
    let stiffer = slip_stiffness_under(gain, load / static_load[k] - 1.0);
    let locked = (1.0 - slip.abs() / stiffer) * bench.rolling_radius / bench.free_rolling_radius;
    let input =
        Input { slip_ratio: locked - 1.0, slip_angle: 0.0, camber: 0.0, load, friction: road };
    Some(tyre.forces(&input).force_x / load + bench.rolling_resistance)
}
