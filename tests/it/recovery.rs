//! Estimates against a simulator whose truth is known.

use roadbench::channel::Channel;
use roadbench::estimate::{Config, Formulation, zeros};
use roadbench::filter;
use roadbench::fit;
use roadbench::fit::chain::{ALL, Data, Solution, solve};
use roadbench::fit::coefficients::{self, name};
use roadbench::rows::Coefficient;
use roadbench::segment::{Direction, Kind, Segment};
use roadbench::simulate::scenario::{Machine, Scenario};
use roadbench::simulate::{Simulated, session, truth};

/// The simulator's own labels as segments: what the estimates reach with perfect segmentation.
pub fn labelled(simulated: &Simulated) -> Vec<Segment> {
    let rate = simulated.session.rate;
    let yaw = simulated.session.get(Channel::Yaw);
    simulated
        .labels
        .iter()
        .map(|&(kind, start, end, direction)| {
            let (a, b) = ((start * rate).round() as usize, (end * rate).round() as usize);
            let heading = yaw.map(|y| (y[a] / std::f64::consts::PI).round() as i64);
            let along = match heading {
                Some(h) if h.rem_euclid(2) == 0 => Some(Direction::Outbound),
                Some(_) => Some(Direction::Inbound),
                None => None,
            };
            Segment {
                kind,
                start: a,
                end: b,
                direction: direction.or(along),
                quality: 1.0,
                used: kind != Kind::Other,
                reason: None,
            }
        })
        .collect()
}

pub fn characterise(
    simulated: &Simulated,
    machine: &Machine,
    formulation: Formulation,
) -> (Solution, Vec<Coefficient>) {
    let mut log = simulated.session.clone();
    filter::run(&mut log, &filter::Config::default());
    let segments = labelled(simulated);
    let config = Config { formulation, ..Config::default() };
    let (zeros, _) = match formulation {
        Formulation::Corrected => zeros::run(&log, &machine.bike),
        Formulation::Paper => (zeros::Zeros::default(), Vec::new()),
    };
    let data = Data::gather(&log, &segments, &machine.bike, zeros, &config);
    let settings = fit::Config::default();
    let solution = solve(&data, &machine.bike, formulation, &settings);
    let rows = coefficients::rows(
        &solution,
        &machine.bike,
        &settings,
        &|_, _| None,
        &Default::default(),
        &Default::default(),
    );
    (solution, rows)
}

#[test]
fn noise_free() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let simulated = session(&scenario, &machine, 0);
    let truth = truth::coefficients(&machine.plant, &simulated);
    let t0 = std::time::Instant::now();
    let (solution, rows) = characterise(&simulated, &machine, Formulation::Corrected);
    eprintln!("took {:?}, zeros {:?}", t0.elapsed(), solution.given.zeros);
    for at in 0..ALL {
        let (tyre, name, ..) = name(at);
        let t = truth.iter().find(|t| t.0 == tyre && t.1 == name).expect("truth").2;
        let r = &rows[at];
        eprintln!(
            "{tyre:8} {name:26} {:10.5} true {:10.5} {:8.3} %  ci {:?} {:?} {:?}",
            solution.values[at],
            t,
            100.0 * (solution.values[at] / t - 1.0),
            r.ci95_low,
            r.ci95_high,
            r.status
        );
    }
}
