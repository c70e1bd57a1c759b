//! "Beyond 20 degrees the model gave less side force than the bench: the machine's track has possibly
//! more friction than the asphalt" (Discussion).

use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::simulate::manoeuvre::{Braked, Manoeuvre};
use roadbench::internals::simulate::multibody::{Model, Road};
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::replay;
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::tyre::paper::Input;
use roadbench::internals::tyre::tir;

use super::common::*;

/// Braking manoeuvres on the other track.
const BRAKINGS: usize = 8;

/// Errors of braking manoeuvres on another track, without and with the friction scale: largest deceleration, and
/// deepest slip over the measured, means over braking manoeuvres that the scale was not fitted to.
pub fn study(friction: f64, number: usize) -> ([f64; 2], [f64; 2], f64) {
    let (scenario, machine) = machine("paper", number, &[]);
    let home = multibody::tour(&scenario, &machine, number).expect("stands");
    let given = tyres(&characterise(&ride(&home, number), &home.bike), &home.bike, 1.0);
    let mut away = home.clone();
    let road = Road { friction, ..home.model.road.clone() };
    away.model = Model::new(home.model.motorcycle.clone(), road);
    let brake = |i: usize| Manoeuvre::Brake {
        wheels: Braked::Front,
        from: 18.0 + 0.5 * i as f64,
        rise: 1.2e6 + 0.1e6 * i as f64,
        slip: -0.28,
        until: 4.0,
    };
    away.manoeuvres = (0..BRAKINGS).map(brake).collect();
    let there = ride(&away, number + 1);
    let brakings: Vec<_> = there
        .labels
        .iter()
        .filter(|(kind, ..)| *kind == ManoeuvreKind::FrontBraking)
        .map(|(_, start, end, _)| {
            let at = |t: f64| (t * there.session.rate) as usize;
            at(*start).saturating_sub(20)..at(*end)
        })
        .collect();
    let [front, rear] = boxed(given);
    let motorcycle = home.model.motorcycle.with_tyres(front, rear);
    let again = |friction: f64, which: usize| {
        let own = brakings.iter().skip(which).step_by(2);
        let model = Model::new(motorcycle.clone(), Road { friction, ..Road::default() });
        let steering = replay::steering(&model, there.session.rate).expect("steers");
        let mut sums = [0.0; 3];
        for range in own {
            let Ok(replay) = replay::braking(&model, &steering, &there.session, range.clone())
            else {
                continue;
            };
            let p = replay.peaks(0);
            sums[0] += p.deceleration[1] / p.deceleration[0] - 1.0;
            sums[1] += replay.rms(0)[1];
            sums[2] += 1.0;
        }
        [sums[0] / sums[2], sums[1] / sums[2]]
    };
    // the scale whose slips come nearest, on every other braking
    let scales: Vec<f64> = (0..=30).map(|i| 0.6 + 0.025 * f64::from(i)).collect();
    let fitted = scales
        .into_iter()
        .map(|s| (s, again(s, 0)[1]))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .map_or(1.0, |(s, _)| s);
    (again(1.0, 1), again(fitted, 1), fitted)
}

/// Prints the study.
pub fn print() {
    println!("4. Friction of another track?");
    for friction in [0.7, 1.0, 1.15] {
        let (before, after, scale) = study(friction, 0);
        println!(
            "  track of {friction}: front brakings held out, largest deceleration {:+.1} %, slip off by \
             {:.4}; with the fitted friction {scale:.2}: {:+.1} %, {:.4}",
            100.0 * before[0],
            before[1],
            100.0 * after[0],
            after[1]
        );
    }
    // the paper's own comparison: characterised on asphalt of 0.75, side force on a bench track of 1
    let tour = Tour::load("characterise").expect("built in").expect("nonlinear");
    let mut tour = tour;
    for (end, truth) in [("front", 0.0436), ("rear", 0.0313)] {
        tour.bike = tour.bike.with(&format!("{end}.side_force_ratio"), truth);
    }
    let outcome = characterise(&ride(&tour, 0), &tour.bike);
    let load = tour.model.motorcycle.static_loads();
    for (k, (end, name)) in [("front", "sharp2004_front_120_70"), ("rear", "sharp2004_rear_180_55")]
        .into_iter()
        .enumerate()
    {
        let bench = tir::load(name).expect("published");
        let of = |name: &str| value(&outcome, end, name).expect("cornered");
        let (c1, c3) = (of("slip_camber_c1"), of("slip_camber_c3"));
        let ct = of("lateral_friction_ct");
        for degrees in [10.0_f64, 20.0, 30.0, 40.0] {
            let g = -degrees.to_radians();
            let alpha = c1 * g + c3 * g * g * g;
            let on = |friction: f64| {
                let input = Input {
                    slip_ratio: 0.0,
                    slip_angle: alpha,
                    camber: g,
                    load: load[k],
                    friction,
                };
                bench.forces(&input).force_y / load[k]
            };
            println!(
                "  {end}, {degrees:.0} deg: model {:.3}, bench at the ride's friction {:.3}, bench at 1: {:.3}",
                ct * g.tan(),
                on(0.75),
                on(1.0)
            );
        }
    }
}
