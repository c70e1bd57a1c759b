//! How fast and how well the nonlinear motorcycle is integrated: the lane change, on one core.
//!
//! `cargo bench --no-default-features --bench ride`

use std::time::Instant;

use roadbench::internals::simulate::multibody::run::Run;
use roadbench::internals::simulate::multibody::trim;
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::ride::{self, MultibodyRide};
use roadbench::internals::simulate::tour::Tour;

fn main() {
    let tour = Tour::load("lane_change").expect("built in").expect("nonlinear");
    let skill = Skill::learn(&tour.model, ride::period(tour.rate)).expect("rides");
    println!("lane change, with rider, road, tyres with lag; classical Runge-Kutta, 4 right-hand");
    println!("sides a step; error: largest difference from a step of 0.125 ms\n");
    println!(
        "{:>9} {:>8} {:>10} {:>11} {:>11} {:>10} {:>10}",
        "step, ms", "steps", "x real", "us / rhs", "y, m", "roll, rad", "torque, Nm"
    );
    let at = |step: f64| {
        let tour = Tour { step, ..tour.clone() };
        // the best of a few runs: other work on the machine only ever slows down
        let mut best = f64::INFINITY;
        let mut ridden = ride::ride(&tour, &skill, 0);
        for _ in 0..5 {
            let begin = Instant::now();
            ridden = ride::ride(&tour, &skill, 0);
            best = best.min(begin.elapsed().as_secs_f64());
        }
        (ridden, best)
    };
    let (fine, _) = at(1.25e-4);
    let off = |a: &MultibodyRide, f: fn(&ride::Sample) -> f64| {
        let pairs = a.samples.iter().zip(&fine.samples);
        pairs.map(|(a, b)| (f(a) - f(b)).abs()).fold(0.0, f64::max)
    };
    for step in [2.5e-3, 2e-3, 1e-3, 5e-4] {
        let (ridden, seconds) = at(step);
        let simulated = ridden.session.duration();
        println!(
            "{:9.3} {:8} {:10.0} {:11.2} {:11.1e} {:10.1e} {:10.1e}",
            step * 1e3,
            ridden.steps,
            simulated / seconds,
            seconds / (4 * ridden.steps) as f64 * 1e6,
            off(&ridden, |s| s.position[1]),
            off(&ridden, |s| s.wheels[1].camber),
            off(&ridden, |s| s.action.steer_torque),
        );
    }
    // without rider and log: what the model itself costs
    let trim = trim::steady(&tour.model, 15.0, 0.2, None).expect("turn");
    let mut run = Run::new(&tour.model, trim.state);
    let steps = 20_000;
    let begin = Instant::now();
    for _ in 0..steps {
        run.step(&trim.action, 2e-3);
    }
    let seconds = begin.elapsed().as_secs_f64();
    println!(
        "\nmodel alone, 2 ms: {:.0} x real time, {:.2} us a right-hand side",
        f64::from(steps) * 2e-3 / seconds,
        seconds / f64::from(4 * steps) * 1e6
    );
}
