//! Ride plans: what the rider does, phase by phase.
//!
//! Adding a plan is one function and one line in [`Plan::phases`].

use serde::{Deserialize, Serialize};

use super::conditions::Conditions;
use super::path::LaneChange;
use super::swing::Swing;
use super::transients::Transients;
use crate::segment::manoeuvre::Direction;
use crate::statistics::random::Random;

/// One thing the rider does, with its end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Phase {
    /// Stands still.
    Stand {
        /// For this long, s.
        duration: f64,
    },
    /// Opens the throttle until a speed is reached, straight on.
    Accelerate {
        /// Final speed, m/s.
        to: f64,
        /// Rise of the acceleration, m/s³.
        ramp: f64,
        /// Largest acceleration, m/s².
        peak: f64,
    },
    /// Holds the speed, straight on.
    Cruise {
        /// Speed, m/s.
        speed: f64,
        /// For this long, s.
        duration: f64,
    },
    /// In neutral, straight on.
    Coast {
        /// For at most this long, s.
        duration: f64,
        /// Down to this speed, m/s.
        until: f64,
    },
    /// In neutral, straight on, pressure rising evenly.
    Brake {
        /// Share of the rise on front and rear, Pa/s.
        ramp: [f64; 2],
        /// Largest pressures, Pa.
        peak: [f64; 2],
        /// Released at this speed, m/s.
        until: f64,
        /// Released at this slip ratio (negative) of either wheel.
        slip: f64,
    },
    /// Leans in, holds, leans out.
    Corner {
        /// Side of the corner.
        direction: Direction,
        /// Largest lean, rad, positive number.
        lean: f64,
        /// Lean-in and lean-out take this long, s.
        ramp: f64,
        /// Heading change in all, rad, positive number.
        turn: f64,
        /// Speed held, m/s; `None` coasts through in neutral.
        speed: Option<f64>,
    },
    /// Leans in, holds, leans out, the front brake on from half the lean until a speed is reached,
    /// which is held from there.
    TrailBraked {
        /// Side of the corner.
        direction: Direction,
        /// Largest lean, rad, positive number.
        lean: f64,
        /// Lean-in and lean-out take this long, s.
        ramp: f64,
        /// Heading change in all, rad, positive number.
        turn: f64,
        /// Line pressure of the front brake, Pa.
        pressure: f64,
        /// Speed after it, m/s.
        until: f64,
    },
    /// Leans in steadily at constant speed, so that the radius shrinks, until the lean or the
    /// grip is used up; then comes back. Nonlinear motorcycle.
    Spiral {
        /// Side of the corner.
        direction: Direction,
        /// Lean rate, rad/s.
        rate: f64,
        /// Largest lean, rad.
        lean: f64,
        /// Slip angle of either wheel that counts as the limit, rad.
        grip: f64,
        /// Speed held, m/s.
        speed: f64,
    },
    /// Leans to both sides at constant speed: a slalom pass or a lane change.
    Swing {
        swing: Swing,
        /// Speed held, m/s.
        speed: f64,
    },
    /// Shifts; everything driven after it is in this gear.
    Shift {
        /// Gear, 1 to 6.
        gear: u8,
    },
    /// From here on road and air are others.
    Meet { conditions: Conditions },
    /// Follows a path with its own speed profile. Nonlinear motorcycle.
    Follow {
        shape: LaneChange,
        /// Straight run before it, m.
        ahead: f64,
        /// Straight run after it, m.
        beyond: f64,
    },
}

/// Heading after some phases that began at heading zero, rad; spirals and paths end anywhere.
pub(crate) fn heading(phases: &[Phase]) -> f64 {
    let turned = |phase: &Phase| match *phase {
        Phase::Corner { direction, turn, .. } | Phase::TrailBraked { direction, turn, .. } => {
            if direction == Direction::Left {
                turn
            } else {
                -turn
            }
        }
        _ => 0.0,
    };
    phases.iter().map(turned).sum()
}

/// A ride plan by its name, and its size.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Plan {
    pub kind: PlanKind,
    /// Coasting runs (paper: 16, half of them slow; half of each in each direction).
    pub coasts: usize,
    /// Front and as many rear stops to the limit (paper: 6).
    pub brakings: usize,
    /// Laps of two left corners (paper: 20), or mixed corners of the naturalistic ride.
    pub laps: usize,
    /// Slalom passes and lane changes: among the rest of the naturalistic ride, at the end of the paper's.
    #[serde(default)]
    pub transients: Transients,
}

/// The plans there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PlanKind {
    /// Bartolozzi et al. 2024: coasting, braking manoeuvres to the limit, laps of two left corners.
    Paper,
    /// Mixed riding: both directions, varied speed and radius.
    Naturalistic,
}

const FULL: f64 = 30e6;
const KMH: f64 = 1.0 / 3.6;

impl Plan {
    /// The phases of one session; riders vary, so they are drawn.
    pub fn phases(&self, random: &mut Random) -> Vec<Phase> {
        let mut phases = vec![Phase::Stand { duration: 3.0 }];
        match self.kind {
            PlanKind::Paper => paper(self, random, &mut phases),
            PlanKind::Naturalistic => naturalistic(self, random, &mut phases),
        }
        let slow = [0.4e6, 0.2e6];
        phases.extend([
            Phase::Cruise { speed: 6.0, duration: 2.0 },
            Phase::Brake { ramp: slow, peak: slow, until: 0.3, slip: -0.2 },
            Phase::Stand { duration: 3.0 },
        ]);
        phases
    }
}

/// Turns round at walking pace and a half.
fn turn_round(random: &mut Random, phases: &mut Vec<Phase>) {
    phases.extend([
        Phase::Cruise { speed: 5.6, duration: 2.5 },
        Phase::Corner {
            direction: Direction::Left,
            lean: random.between(0.24, 0.30),
            ramp: 1.8,
            turn: std::f64::consts::PI,
            speed: Some(5.6),
        },
    ]);
}

fn paper(plan: &Plan, random: &mut Random, phases: &mut Vec<Phase>) {
    let coasts = |slow: bool, count: usize, random: &mut Random, phases: &mut Vec<Phase>| {
        for _ in 0..count {
            let (from, until, duration) = if slow {
                (random.between(20.0, 23.0) * KMH, 3.2, 10.0)
            } else {
                (random.between(49.0, 53.0) * KMH, 34.0 * KMH, 14.0)
            };
            phases.extend([
                Phase::Accelerate { to: from, ramp: 1.5, peak: 2.5 },
                Phase::Coast { duration, until },
            ]);
            turn_round(random, phases);
        }
    };
    coasts(true, plan.coasts / 2, random, phases);
    coasts(false, plan.coasts - plan.coasts / 2, random, phases);
    for wheel in [0, 1] {
        for _ in 0..plan.brakings {
            let seconds = random.between(2.2, 3.4); // from nothing to the limit
            let limit = if wheel == 0 { 4.2e6 } else { 3.2e6 };
            let mut ramp = [0.0; 2];
            ramp[wheel] = limit / seconds;
            phases.extend([
                Phase::Accelerate {
                    to: random.between(69.0, 75.0) * KMH,
                    ramp: random.between(1.8, 2.6),
                    peak: random.between(5.5, 6.8),
                },
                Phase::Coast { duration: 1.5, until: 5.0 },
                Phase::Brake {
                    ramp,
                    peak: [FULL; 2],
                    until: 3.5,
                    slip: random.between(-0.34, -0.24),
                },
            ]);
            turn_round(random, phases);
        }
    }
    for _ in 0..plan.laps {
        for radius in [12.5, 15.0] {
            let lateral: f64 = random.between(2.5, 6.8);
            let speed = (lateral * radius).sqrt().max(5.5);
            phases.extend([
                Phase::Cruise { speed, duration: 2.2 },
                Phase::Corner {
                    direction: Direction::Left,
                    lean: (lateral / crate::GRAVITY).atan() * 1.13,
                    ramp: random.between(2.0, 2.6),
                    turn: std::f64::consts::PI,
                    speed: Some(speed),
                },
            ]);
        }
    }
    swings(plan, (0, 1), random, phases);
}

/// Up to the speed, straight on until it is steady, then the swing, and straight on for a moment; each of a part's.
fn swings(
    plan: &Plan,
    (part, parts): (usize, usize),
    random: &mut Random,
    phases: &mut Vec<Phase>,
) {
    let mut rides = Vec::new();
    plan.transients.part(part, parts, random, &mut rides);
    for (swing, speed) in rides {
        phases.extend([
            Phase::Accelerate { to: speed, ramp: 2.0, peak: 3.0 },
            Phase::Cruise { speed, duration: 3.0 },
            Phase::Swing { swing, speed },
            Phase::Cruise { speed, duration: 1.5 },
        ]);
    }
}

fn naturalistic(plan: &Plan, random: &mut Random, phases: &mut Vec<Phase>) {
    // the kinds are dealt out evenly over the ride rather than block by block
    let rounds = plan.laps.max(1);
    let due = |count: usize, round: usize| (round + 1) * count / rounds - round * count / rounds;
    for round in 0..rounds {
        for _ in 0..due(plan.coasts, round) {
            let from = random.between(8.0, 24.0);
            phases.extend([
                Phase::Accelerate { to: from, ramp: 1.6, peak: random.between(2.0, 4.0) },
                Phase::Cruise { speed: from, duration: random.between(0.5, 2.0) },
                Phase::Coast { duration: random.between(7.0, 12.0), until: (from - 5.0).max(4.0) },
            ]);
        }
        for i in 0..due(2 * plan.brakings, round) {
            let from = random.between(15.0, 24.0);
            let seconds = random.between(1.8, 3.4);
            // front and rear in turn, every third one with both below the limit
            let (ramp, peak) = match (round + i) % 3 {
                0 => ([4.2e6 / seconds, 0.0], [FULL; 2]),
                1 => ([0.0, 3.2e6 / seconds], [FULL; 2]),
                _ => ([1.3e6 / seconds, 0.8e6 / seconds], [1.7e6, 1.0e6]),
            };
            phases.extend([
                Phase::Accelerate { to: from, ramp: 2.2, peak: random.between(4.0, 6.5) },
                Phase::Coast { duration: 1.2, until: 5.0 },
                Phase::Brake { ramp, peak, until: 5.0, slip: random.between(-0.32, -0.2) },
            ]);
        }
        for direction in [Direction::Left, Direction::Right] {
            let radius = random.between(15.0, 80.0);
            let lateral: f64 = random.between(2.5, 6.8);
            let speed = (lateral * radius).sqrt().max(5.5);
            phases.extend([
                Phase::Accelerate { to: speed, ramp: 2.0, peak: random.between(2.0, 4.0) },
                Phase::Cruise { speed, duration: 2.0 },
                Phase::Corner {
                    direction,
                    lean: (lateral / crate::GRAVITY).atan() * 1.13,
                    ramp: random.between(1.6, 2.6),
                    turn: random.between(1.2, 2.8),
                    speed: Some(speed),
                },
            ]);
        }
        swings(plan, (round, rounds), random, phases);
    }
}
