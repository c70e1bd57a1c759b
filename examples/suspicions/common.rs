//! What every study needs: a ride, its characterisation, its diagnosis, a lane change.

use std::path::Path;

use roadbench::GRAVITY;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::Coefficient;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::road::{RoadDiagnosis, diagnose};
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Outcome, Pipeline};
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::multibody::{Model, Motorcycle};
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::ride::{self, MultibodyRide, Sample};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::tyre::custom::Custom;
use roadbench::internals::tyre::tyre_model::TyreModel;

/// A scenario and its machine that hides some effects from its bike file.
pub fn machine(plan: &'static str, number: usize, hidden: &[(&str, f64)]) -> (Scenario, Machine) {
    let hidden = hidden.iter().map(|(n, v)| (Effect::named(n).expect("known"), *v)).collect();
    let case =
        Case { seed: 0, number, kind: Kind::Single, plan, hidden, foreign: None, odd: Vec::new() };
    case.machine().expect("built in")
}

/// Rides a tour once; after a fall another one of its kind.
pub fn ride(tour: &Tour, number: usize) -> MultibodyRide {
    let skill = Skill::learn(&tour.model, ride::period(tour.rate)).expect("stands");
    let rides = (0..5).map(|again| ride::ride(tour, &skill, number + 1000 * again));
    let mut stood = rides.filter(|ridden| {
        if let Some(fall) = ridden.fall {
            println!("    ({}: {fall}; ridden again)", ridden.session.meta.session_id);
        }
        ridden.fall.is_none()
    });
    stood.next().expect("a rider who stays on")
}

/// Coefficients of a ride.
pub fn characterise(ridden: &MultibodyRide, bike: &Bike) -> Outcome {
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("log.parquet");
    write_session(&path, &ridden.session, false).expect("written");
    let input = pipeline::Input {
        log: Path::new(&path).into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    pipeline::run(&input, bike, &Pipeline::onroad()).expect("characterised")
}

/// A coefficient.
pub fn value(outcome: &Outcome, tyre: &str, name: &str) -> Option<f64> {
    outcome.coefficients.iter().find(|c| c.tyre == tyre && c.coefficient == name)?.value
}

/// Static loads that a bike file implies, N.
pub fn loads(bike: &Bike) -> [f64; 2] {
    [bike.cg_to_rear(), bike.cg_to_front].map(|l| bike.mass * GRAVITY * l / bike.wheelbase)
}

/// The characterised tyres for the simulator; `friction` is the road's.
pub fn tyres(outcome: &Outcome, bike: &Bike, friction: f64) -> [Custom; 2] {
    let load = loads(bike);
    let rolling = value(outcome, "vehicle", "rolling_resistance").expect("coasted");
    [0, 1].map(|k| {
        let axle = Axle::BOTH[k];
        let of = |c: Coefficient| value(outcome, axle.name(), c.name());
        Custom::characterised(of, bike.wheel(axle), load[k], rolling, friction).expect("a tyre")
    })
}

/// The paper's lane change on a motorcycle.
pub fn lane_change(motorcycle: Motorcycle, friction: f64) -> MultibodyRide {
    let mut tour = Tour::load("lane_change").expect("built in").expect("nonlinear");
    let road =
        roadbench::internals::simulate::multibody::Road { friction, ..tour.model.road.clone() };
    tour.model = Model::new(motorcycle, road);
    ride(&tour, 0)
}

/// Boxes a pair of tyres.
pub fn boxed<T: TyreModel + 'static>(tyres: [T; 2]) -> [Box<dyn TyreModel>; 2] {
    let [front, rear] = tyres;
    [Box::new(front), Box::new(rear)]
}

/// Rms difference over the reference's rms, of a signal of two rides; and how far the peak is off.
pub fn off(reference: &MultibodyRide, other: &MultibodyRide, signal: Signal) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let mut peaks = [0.0_f64; 2];
    for (a, b) in reference.samples.iter().zip(&other.samples) {
        let (a, b) = (signal(a), signal(b));
        sums[0] += (a - b) * (a - b);
        sums[1] += a * a;
        if a.abs() > peaks[0].abs() {
            peaks = [a, b];
        }
    }
    [(sums[0] / sums[1]).sqrt(), peaks[1] / peaks[0] - 1.0]
}

/// A signal's value at a sample.
pub type Signal = fn(&Sample) -> f64;

/// Signals of a lane change, with names.
#[rustfmt::skip]
pub const SIGNALS: [(&str, Signal); 7] = [
    ("slip angle front", |s| s.wheels[0].slip[1]),
    ("slip angle rear", |s| s.wheels[1].slip[1]),
    ("yaw moment front", |s| s.wheels[0].moment_z),
    ("yaw moment rear", |s| s.wheels[1].moment_z),
    ("side force front", |s| s.wheels[0].force[1]),
    ("side force rear", |s| s.wheels[1].force[1]),
    ("steering torque", |s| s.action.steer_torque),
];

/// Prints signals of lane changes against the reference: rms difference, and at the peak, in percent.
pub fn table(reference: &MultibodyRide, others: &[(&str, &MultibodyRide)]) {
    for (name, other) in others {
        let cells: Vec<String> = SIGNALS
            .iter()
            .map(|(name, signal)| {
                let [rms, peak] = off(reference, other, *signal);
                format!("{name} {:.1} ({:+.1})", 100.0 * rms, 100.0 * peak)
            })
            .collect();
        println!("    {name:28} {}", cells.join(", "));
    }
}

/// Diagnoses a ride.
pub fn diagnosed(ridden: &MultibodyRide, bike: &Bike) -> RoadDiagnosis {
    diagnose(&ridden.session, bike, &Pipeline::onroad(), &Settings::default()).expect("diagnosed")
}

/// The identified causes, in a line.
pub fn told(d: &RoadDiagnosis) -> String {
    let mut said: Vec<String> = d
        .identification
        .causes
        .iter()
        .filter(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
        .map(|c| {
            let or = c.equivalent.iter().map(|e| format!(" or {e}")).collect::<String>();
            format!("{}{or} {:.4} +- {:.4}", c.candidate.name, c.value(), c.std_error())
        })
        .collect();
    if d.identification.unexplained {
        let over = d.identification.structure.as_ref().map_or("", |s| s.description.as_str());
        said.push(format!("unexplained ({over})"));
    }
    if said.is_empty() { "nothing".into() } else { said.join("; ") }
}

/// Size, standard error, verdict and detection limit of one effect.
pub fn about(d: &RoadDiagnosis, effect: &str) -> String {
    let j = roadbench::internals::simulate::effects::ALL.iter().position(|e| e.name == effect);
    let cause = d.identification.causes.iter().find(|c| c.candidate.name == effect);
    match (j, cause) {
        (Some(j), Some(c)) => format!(
            "{effect} {:.4} +- {:.4}, {}, score {:.2}, limit {:.4}",
            c.value(),
            c.std_error(),
            c.verdict.name(),
            c.score,
            d.calibration.limit(j) * c.candidate.typical.abs()
        ),
        _ => format!("{effect} is not among the candidates"),
    }
}
