//! "The slip angle underestimation was likely caused by tyre load sensitivity" (Discussion).

use roadbench::internals::contract::bike::Axle;
use roadbench::internals::pipeline::Outcome;
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::effects::extended_tyre::ExtendedTyre;
use roadbench::internals::simulate::multibody::Motorcycle;
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::tyre::custom::Custom;
use roadbench::internals::tyre::paper::Input;

use super::common::*;

/// Luggage and pillion, kg.
const LUGGAGE: f64 = 80.0;
/// Camber at which stiffnesses are compared: the middle of what is ridden, rad.
const CAMBER: f64 = 0.35;
/// Rides at each load; at least two give a standard error.
const RIDES: usize = 3;

/// The same machine with luggage; its tyres stay those of the light one.
fn heavier(scenario: &Scenario, machine: &Machine, number: usize) -> Tour {
    let light = multibody::motorcycle(&machine.plant).expect("stands");
    let mut heavy = machine.clone();
    heavy.plant.vehicle.mass += LUGGAGE;
    heavy.bike = heavy.bike.with("mass", machine.bike.mass + LUGGAGE);
    let mut tour = multibody::tour(scenario, &heavy, number).expect("stands");
    let [front, rear] = light.tyres.expect("tyres");
    tour.fit(Some(front), Some(rear));
    tour
}

/// Side force per load over the side angle that the paper's tyre would need, at [`CAMBER`].
fn stiffness(outcome: &Outcome, axle: Axle) -> f64 {
    let of = |name: &str| value(outcome, axle.name(), name).expect("cornered");
    let (g, c) = (CAMBER, of("side_force_ratio"));
    let alpha = of("slip_camber_c1") * g + of("slip_camber_c3") * g * g * g;
    -of("lateral_friction_ct") * g.tan() / (alpha + c * g)
}

fn mean(x: &[f64]) -> (f64, f64) {
    let n = x.len() as f64;
    let mean = x.iter().sum::<f64>() / n;
    let square: f64 = x.iter().map(|x| (x - mean).powi(2)).sum();
    (mean, (square / (n - 1.0) / n).sqrt())
}

/// What a study found.
#[derive(Debug, Clone, Copy)]
pub struct Found {
    /// Loss of stiffness per relative load, front and rear, with standard errors.
    pub sensitivity: [(f64, f64); 2],
    /// Slip-angle error of the lane change with luggage, front and rear, before and after.
    pub error: [[f64; 2]; 2],
}

/// Characterised light and heavy, refitted, ridden through a lane change with luggage; `prepare` may
/// change the scenario.
pub fn study(truth: f64, rides: usize, prepare: fn(&mut Scenario)) -> Found {
    let hidden = [("stiffness_load", truth)];
    let hidden = if truth == 0.0 { &[][..] } else { &hidden[..] };
    let mut k = [[Vec::new(), Vec::new()], [Vec::new(), Vec::new()]];
    let mut given = None;
    let mut machines = None;
    for number in 0..rides {
        // one machine, other rides
        let (mut scenario, machine) = machine("paper", 0, hidden);
        prepare(&mut scenario);
        let light = multibody::tour(&scenario, &machine, number).expect("stands");
        let heavy = heavier(&scenario, &machine, number + 100);
        for (which, tour) in [&light, &heavy].into_iter().enumerate() {
            let outcome = characterise(&ride(tour, number + 100 * which), &tour.bike);
            for axle in 0..2 {
                k[which][axle].push(stiffness(&outcome, Axle::BOTH[axle]));
            }
            if which == 0 && number == 0 {
                given = Some(tyres(&outcome, &tour.bike, 1.0));
            }
        }
        machines = Some((light, heavy));
    }
    let ((light, heavy), given) = (machines.expect("ridden"), given.expect("characterised"));
    let load = loads(&light.bike);
    let more = LUGGAGE / light.bike.mass;
    let sensitivity = [0, 1].map(|axle| {
        let ((a, sa), (b, sb)) = (mean(&k[0][axle]), mean(&k[1][axle]));
        ((b / a - 1.0) / more, (sa / a).hypot(sb / b) / more)
    });
    let own: Motorcycle = heavy.model.motorcycle.clone();
    let reference = lane_change(own.clone(), 1.0);
    let [front, rear] = boxed(given);
    let before = lane_change(own.with_tyres(front, rear), 1.0);
    let [front, rear] = [0, 1].map(|k| {
        let error = ModelError { stiffness_load: sensitivity[k].0, ..ModelError::default() };
        ExtendedTyre::boxed(Custom { nominal_load: load[k], ..given[k] }, &error, 1.0)
    });
    let after = lane_change(own.with_tyres(front, rear), 1.0);
    table(&reference, &[("as characterised light", &before), ("with load sensitivity", &after)]);
    let error = [0, 1].map(|k| {
        let signal = SIGNALS[k].1;
        [off(&reference, &before, signal)[0], off(&reference, &after, signal)[0]]
    });
    Found { sensitivity, error }
}

/// Prints the study.
pub fn print() {
    println!("1. Slip angles under a heavier load: load sensitivity of the cornering stiffness?");
    for truth in [-0.3, 0.0] {
        println!("  true sensitivity {truth} (per relative load), {LUGGAGE} kg of luggage");
        let found = study(truth, RIDES, |_| {});
        for (k, end) in ["front", "rear"].into_iter().enumerate() {
            let ((value, sd), [before, after]) = (found.sensitivity[k], found.error[k]);
            println!(
                "    {end}: sensitivity {value:.3} +- {sd:.3}; slip angle off by {:.0} %, refitted {:.0} %",
                100.0 * before,
                100.0 * after
            );
        }
    }
    for (plan, number) in [("paper", 0), ("naturalistic", 1)] {
        let (scenario, machine) = machine(plan, number, &[("stiffness_load", -0.3)]);
        let tour = multibody::tour(&scenario, &machine, number).expect("stands");
        let d = diagnosed(&ride(&tour, number), &tour.bike);
        println!("  one {plan} ride, one load: {}; {}", told(&d), about(&d, "stiffness_load"));
    }
    // the paper's own pair of machines and the tyre it was characterised from
    let small = Tour::load("characterise").expect("built in").expect("nonlinear");
    let large = Tour::load("lane_change").expect("built in").expect("nonlinear");
    let (a, b) = (small.model.motorcycle.static_loads(), large.model.motorcycle.static_loads());
    let reference = large.model.motorcycle.tyres.clone().expect("tyres");
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        let side = |load: f64| {
            let slip = |slip_angle: f64| Input {
                slip_ratio: 0.0,
                slip_angle,
                camber: 0.0,
                load,
                friction: 0.75,
            };
            let t = &reference[k];
            (t.forces(&slip(-1e-3)).force_y - t.forces(&slip(1e-3)).force_y) / 2e-3 / load
        };
        let braked = if k == 0 { 1.5 * b[0] } else { 0.7 * b[1] };
        println!(
            "  the reference tyre, {end}: {:.2} /rad at {:.0} N (characterised), {:.2} at {:.0} N \
             (touring), {:.2} at {braked:.0} N (touring, braking)",
            side(a[k]),
            a[k],
            side(b[k]),
            b[k],
            side(braked)
        );
    }
}
