//! Many rides of the same tyres: width and coverage of the pooled estimates of the table `tyres`.

use std::collections::BTreeMap;
use std::path::Path;

use rayon::prelude::*;
use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::coefficient::{Coefficient, Id};
use roadbench::internals::fleet::evidence::Piece;
use roadbench::internals::fleet::{Observation, analyse, tyres};
use roadbench::internals::pipeline::{self, Outcome, Pipeline};
use roadbench::internals::simulate::hidden::Kind;
use roadbench::internals::simulate::manoeuvre::Manoeuvre;
use roadbench::internals::simulate::multibody_ride;
use roadbench::internals::simulate::plan::{Plan, PlanKind};
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride;
use roadbench::internals::simulate::transients::Transients;
use roadbench::internals::store::tables::rows::Status;

use super::{Failure, logged};

/// Rides that are pooled.
const NUMBERS: [usize; 4] = [1, 3, 10, 30];
/// What is pooled.
const ASKED: [Coefficient; 3] =
    [Coefficient::CorneringStiffness0, Coefficient::SideForceRatio, Coefficient::CamberStiffness0];

/// The rides of one machine, what they gave, and the truth of its tyres.
struct Ridden {
    outcomes: Vec<Outcome>,
    truth: BTreeMap<(String, String), f64>,
}

/// Error and half width of a pooled estimate, over the truth; whether the interval contains it.
type Case = [f64; 3];

/// Rides `each` rides of each of `machines`, pools them and prints.
pub fn run(seed: u64, machines: usize, each: usize, work: &Path) -> Result<(), Failure> {
    let one = |number: usize| match machine(seed, number, each, work) {
        Ok(ridden) => Some(ridden),
        Err(why) => {
            eprintln!("{number}: {why}");
            None
        }
    };
    let all: Vec<Ridden> = (0..machines).into_par_iter().filter_map(one).collect();
    println!("{} machines, {each} short mixed rides of each, bike file of level A", all.len());
    for rides in NUMBERS.into_iter().filter(|n| *n <= each) {
        let mut cases: BTreeMap<(&str, &str), Vec<Case>> = BTreeMap::new();
        for ridden in &all {
            // groups of rides that have none in common
            for group in ridden.outcomes.chunks_exact(rides) {
                for (key, case) in pooled(group, &ridden.truth) {
                    cases.entry(key).or_default().push(case);
                }
            }
        }
        for ((tyre, coefficient), cases) in cases {
            let median = |k: usize| {
                let mut x: Vec<f64> = cases.iter().map(|c| c[k].abs()).collect();
                x.sort_by(f64::total_cmp);
                100.0 * x[x.len() / 2]
            };
            let hold = cases.iter().filter(|c| c[2] == 1.0).count();
            println!(
                "{rides:3} rides {tyre:5} {coefficient:22} |error| {:5.1} % half width {:5.1} % hold {hold} of {}",
                median(0),
                median(1),
                cases.len()
            );
        }
    }
    Ok(())
}

fn machine(seed: u64, number: usize, each: usize, work: &Path) -> Result<Ridden, Failure> {
    let mut case = ride::case(seed, number, Kind::Null, [1.0, 1.0]);
    case.plan = "naturalistic";
    let mut first = ride::ride(&case, BikeFile::Tutorial)?;
    // short rides: three minutes of mixed riding each
    let plan = Plan {
        kind: PlanKind::Naturalistic,
        coasts: 3,
        brakings: 2,
        laps: 5,
        transients: Transients::default(),
    };
    first.tour.manoeuvres = vec![Manoeuvre::Plan { plan }];
    let first = first;
    let mut truth = BTreeMap::new();
    let known = first.truth(&Pipeline::onroad().estimate);
    for axle in Axle::BOTH {
        let of = |c: Coefficient| {
            let id = Id::from((axle, c));
            known.iter().find(|(k, _)| *k == id).map_or(f64::NAN, |(_, value)| *value)
        };
        let [k, g] = [of(Coefficient::CorneringStiffness0), of(Coefficient::CamberStiffness0)];
        for (c, value) in ASKED.into_iter().zip([k, g / k, g]) {
            truth.insert((axle.name().to_owned(), c.name().to_owned()), value);
        }
    }
    let outcomes: Result<Vec<Option<Outcome>>, Failure> = (0..each)
        .into_par_iter()
        .map(|k| {
            let ridden = multibody_ride::ridden(&first.tour, 1000 * number + k)?;
            if ridden.fall.is_some() {
                return Ok(None);
            }
            let log = work.join(format!("{number}_{k}.parquet"));
            let mut outcome = logged(&ridden.session, &log, &first.tour.bike, &Pipeline::onroad())?;
            outcome.plots.clear();
            std::fs::remove_file(log)?;
            Ok(Some(outcome))
        })
        .collect();
    let outcomes: Vec<Outcome> = outcomes?.into_iter().flatten().collect();
    eprintln!("machine {number}: {} rides", outcomes.len());
    Ok(Ridden { outcomes, truth })
}

/// The pooled estimates of some rides, as the stage of the fleet makes them.
fn pooled(
    rides: &[pipeline::Outcome],
    truth: &BTreeMap<(String, String), f64>,
) -> Vec<((&'static str, &'static str), Case)> {
    let stated = |status: Status| matches!(status, Status::Ok | Status::PoorlyDetermined);
    let observations: Vec<Observation> = rides
        .iter()
        .flat_map(|r| &r.coefficients)
        .filter(|c| stated(c.status))
        .filter_map(|c| {
            Some(Observation {
                bike: c.ident.bike_id.clone(),
                tyre: c.tyre.clone(),
                coefficient: c.coefficient.clone(),
                session: c.ident.session_id.clone(),
                value: c.value?,
                error: c.std_error?,
                determined: c.status == Status::Ok,
                ..Observation::default()
            })
        })
        .collect();
    let pieces: Vec<Piece> = rides
        .iter()
        .flat_map(|r| &r.evidence)
        .filter(|e| e.status == Status::Ok && e.value.is_finite() && e.sensitivity.is_finite())
        .map(|e| Piece {
            session: e.ident.session_id.clone(),
            tyre: e.tyre.clone(),
            tyre_model: e.tyre_model.clone(),
            coefficient: e.coefficient.clone(),
            unit: e.unit.clone(),
            value: e.value,
            source: e.source.clone(),
            shared: e.shared,
            shift: e.sensitivity,
            taken: e.source_value.zip(e.source_std_error).map(|(value, sd)| [value, sd]),
        })
        .collect();
    let Some(bike) = analyse(&observations).into_iter().next() else { return Vec::new() };
    let found = tyres::of_bike(&bike, &pieces);
    let mut out = Vec::new();
    for tyre in &found.tyres {
        let estimate = &tyre.estimate;
        let key = (estimate.key.tyre.clone(), estimate.key.coefficient.clone());
        let Some(truth) = truth.get(&key) else { continue };
        let axle = Axle::BOTH.into_iter().find(|axle| axle.name() == key.0);
        let coefficient = ASKED.into_iter().find(|c| c.name() == key.1);
        let (Some(axle), Some(coefficient)) = (axle, coefficient) else { continue };
        let [low, high] = estimate.interval;
        let holds = f64::from(u8::from((low..=high).contains(truth)));
        let case = [estimate.value / truth - 1.0, 0.5 * (high - low) / truth, holds];
        out.push(((axle.name(), coefficient.name()), case));
    }
    out
}
