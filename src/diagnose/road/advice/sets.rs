//! Sets of manoeuvres that could be ridden to tell more: what each is, phase by phase.
//!
//! They are short (a minute or two), ridden along the session's strip, and safe to ask of somebody who
//! has just ridden the session. Adding one is one entry of [`SETS`].

use std::f64::consts::{PI, TAU};

use crate::GRAVITY;
use crate::segment::manoeuvre::Direction;
use crate::segment::manoeuvre::Direction::{Left, Right};
use crate::simulate::plan::Phase;

/// Pressure that no brake is limited by, Pa.
const FULL: f64 = 30e6;
/// Speed of a turn on the spot, m/s.
const WALK: f64 = 5.6;

/// Some manoeuvres that could be ridden.
#[derive(Debug, Clone, Copy)]
pub struct Set {
    /// Name of the riding, as the subject of a sentence in the plural.
    pub words: &'static str,
    /// The riding, from a standstill at heading zero.
    pub phases: fn() -> Vec<Phase>,
    /// How the rider leans, m of the centre of mass per rad of roll: the riding is ridden once with each, in a session
    /// of its own. Nothing: as in the session.
    pub leans: &'static [f64],
}

impl Set {
    /// Riding that goes on where the session ends.
    const fn new(words: &'static str, phases: fn() -> Vec<Phase>) -> Self {
        Set { words, phases, leans: &[] }
    }
}

/// Lean of a body that hangs off, m/rad, and one that leans out: 45 mm at 26 degrees of roll.
const HUNG: f64 = 0.1;

pub const SETS: &[Set] = &[
    Set::new("6 right-hand corners", || corners([Right; 6])),
    Set::new("6 left-hand corners", || corners([Left; 6])),
    Set::new("6 corners to both sides, braked into with the front brake", braked),
    Set::new("6 corners to both sides on the throttle", driven),
    Set::new("6 wide corners to both sides at 70 to 100 km/h", wide),
    Set::new("6 tight corners to both sides below 25 km/h", tight),
    Set::new("6 corners to both sides, leant into quickly", quick),
    Set::new("4 coasts from 110 and 6 from 30 km/h, both ways", coasts),
    Set::new("6 stops with the front brake to the limit, both ways", || {
        stops(|k| [[1.2e6, 1.8e6, 2.4e6][k % 3], 0.0])
    }),
    Set::new("6 stops with the rear brake to the limit, both ways", || {
        stops(|k| [0.0, [0.9e6, 1.3e6, 1.8e6][k % 3]])
    }),
    Set::new("6 stops with both brakes, both ways", || {
        stops(|k| [[0.8e6, 0.4e6], [0.5e6, 0.8e6], [1.4e6, 0.4e6]][k % 3])
    }),
    Set::new("3 short hard and 3 long gentle stops with either brake", hard_and_gentle),
    Set {
        words: "6 corners to both sides with the body hung off and 6 with it leaning out, each six in a session \
                of its own",
        phases: || corners([Left, Right, Left, Right, Left, Right]),
        leans: &[HUNG, -HUNG],
    },
];

/// Riding of a set after something that ended at a heading (rad): first back to the strip.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn after(set: &Set, heading: f64) -> Vec<Phase> {
    let mut phases = Vec::new();
    let mut turn = (-heading).rem_euclid(TAU);
    if turn > 0.1 && turn < TAU - 0.1 {
        // a corner takes some turning to lean into and out of
        turn += if turn < 1.0 { TAU } else { 0.0 };
        phases.extend([
            Phase::Accelerate { to: 8.0, ramp: 1.5, peak: 2.5 },
            corner(Left, 8.0, 15.0, turn, 1.8),
        ]);
    }
    phases.extend((set.phases)());
    phases
}

/// The same riding with a rider who leans by so much (m/rad) on a centre of mass of a height (m): as fast round the same
/// corners, in which the motorcycle leans less the more he hangs off.
pub fn leaning(phases: Vec<Phase>, by: f64, height: f64) -> Vec<Phase> {
    let share = height / (height + by);
    let leant = |phase| match phase {
        Phase::Corner { direction, lean, ramp, turn, speed } => {
            Phase::Corner { direction, lean: lean * share, ramp, turn, speed }
        }
        other => other,
    };
    phases.into_iter().map(leant).collect()
}

/// A corner at constant speed (m/s), of a radius (m) and a turn (rad), leant into for `ramp` s.
fn corner(direction: Direction, speed: f64, radius: f64, turn: f64, ramp: f64) -> Phase {
    Phase::Corner { direction, lean: lean(speed, radius), ramp, turn, speed: Some(speed) }
}

/// Lean of a steady corner, with what round tyres and spinning wheels add.
fn lean(speed: f64, radius: f64) -> f64 {
    1.13 * (speed * speed / radius / GRAVITY).atan()
}

/// Turns round on the spot.
fn round(phases: &mut Vec<Phase>) {
    phases
        .extend([Phase::Cruise { speed: WALK, duration: 1.5 }, corner(Left, WALK, 11.0, PI, 1.8)]);
}

fn corners(directions: [Direction; 6]) -> Vec<Phase> {
    let run = |k: usize| {
        let radius = [14.0, 20.0, 28.0][k % 3];
        let speed = f64::sqrt(radius * [4.0, 5.5, 6.2, 3.2, 4.8, 5.8][k]);
        let to = Phase::Accelerate { to: speed, ramp: 2.0, peak: 3.0 };
        let steady = Phase::Cruise { speed, duration: 1.5 };
        [to, steady, corner(directions[k], speed, radius, PI, 2.2)]
    };
    (0..6).flat_map(run).collect()
}

fn braked() -> Vec<Phase> {
    let run = |k: usize| {
        let speed: f64 = [11.0, 13.0, 15.0][k % 3];
        let from = speed + [4.0, 5.0][k % 2];
        [
            Phase::Accelerate { to: from, ramp: 2.0, peak: 3.5 },
            Phase::Cruise { speed: from, duration: 1.0 },
            Phase::TrailBraked {
                direction: [Left, Right][k / 3],
                lean: [0.35, 0.45, 0.5][k % 3],
                ramp: 2.0,
                turn: 1.15 * PI,
                pressure: [0.55e6, 0.8e6][k % 2],
                until: speed,
            },
        ]
    };
    (0..6).flat_map(run).collect()
}

fn driven() -> Vec<Phase> {
    let run = |k: usize| {
        let speed: f64 = [8.0, 10.0, 12.0][k % 3];
        [
            Phase::Accelerate { to: speed, ramp: 2.0, peak: 3.0 },
            Phase::Cruise { speed, duration: 2.0 },
            Phase::Corner {
                direction: [Left, Right][k % 2],
                lean: [0.35, 0.45, 0.5][k % 3],
                ramp: 2.0,
                turn: 0.8 * PI,
                // never reached: the throttle stays open
                speed: Some(speed + 15.0),
            },
        ]
    };
    (0..6).flat_map(run).collect()
}

fn wide() -> Vec<Phase> {
    let run = |k: usize| {
        let speed = [20.0, 24.0, 27.5][k % 3];
        let radius = speed * speed / [5.0, 6.0][k % 2];
        [
            Phase::Accelerate { to: speed, ramp: 2.0, peak: 4.0 },
            Phase::Cruise { speed, duration: 1.5 },
            corner([Left, Right][k / 3], speed, radius, 0.5 * PI, 2.4),
        ]
    };
    (0..6).flat_map(run).collect()
}

fn tight() -> Vec<Phase> {
    let run = |k: usize| {
        let speed = [5.2, 5.8, 6.4][k % 3];
        [
            Phase::Cruise { speed, duration: 1.5 },
            corner([Left, Right][k / 3], speed, speed * speed / [4.0, 5.0][k % 2], TAU, 1.8),
        ]
    };
    (0..6).flat_map(run).collect()
}

fn quick() -> Vec<Phase> {
    let run = |k: usize| {
        let speed = [9.0, 11.0, 13.0][k % 3];
        [
            Phase::Accelerate { to: speed, ramp: 2.0, peak: 3.0 },
            Phase::Cruise { speed, duration: 1.5 },
            corner([Left, Right][k % 2], speed, speed * speed / 5.0, 0.7 * PI, 0.9),
        ]
    };
    (0..6).flat_map(run).collect()
}

fn coasts() -> Vec<Phase> {
    let mut phases = Vec::new();
    // fast and slow, each there and back: effects of speed are separated from others
    for k in 0..10 {
        let (to, until) = if k < 4 { (110.0 / 3.6, 20.0) } else { (30.0 / 3.6, 4.2) };
        phases.extend([
            Phase::Accelerate { to, ramp: 2.0, peak: 5.0 },
            Phase::Coast { duration: 20.0, until },
            Phase::Brake { ramp: [3e5, 2e5], peak: [6e5, 4e5], until: WALK, slip: -0.2 },
        ]);
        round(&mut phases);
    }
    phases
}

/// Stops from 70 km/h; `rise` is that of the pressures, Pa/s.
fn stops(rise: fn(usize) -> [f64; 2]) -> Vec<Phase> {
    let mut phases = Vec::new();
    for k in 0..6 {
        phases.extend([
            Phase::Accelerate { to: 70.0 / 3.6, ramp: 2.0, peak: 5.0 },
            Phase::Coast { duration: 1.5, until: 5.0 },
            Phase::Brake { ramp: rise(k), peak: [FULL; 2], until: 4.5, slip: -0.25 },
        ]);
        round(&mut phases);
    }
    phases
}

fn hard_and_gentle() -> Vec<Phase> {
    let mut phases = Vec::new();
    for k in 0..6 {
        let mut ramp = [0.0; 2];
        let hard = k % 2 == 0;
        ramp[usize::from(k >= 3)] = if hard { 6e6 } else { 0.25e6 };
        let peak = if hard { [2.2e6, 1.2e6] } else { [0.5e6; 2] };
        let from = if hard { 14.0 } else { 20.0 };
        phases.extend([
            Phase::Accelerate { to: from, ramp: 2.0, peak: 5.0 },
            Phase::Coast { duration: 1.5, until: 5.0 },
            Phase::Brake { ramp, peak, until: WALK, slip: -0.25 },
        ]);
        round(&mut phases);
    }
    phases
}
