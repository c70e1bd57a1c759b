//! Manoeuvres of a ride on the nonlinear motorcycle, as a scenario lists them.
//!
//! Adding one is one variant with its keys and one arm in [`Manoeuvre::phases`].

use serde::{Deserialize, Serialize};

use super::path::LaneChange;
use super::plan::{Phase, Plan};
use super::swing::{Form, Swing};
use crate::contract::key_error::KeyError;
use crate::segment::manoeuvre::Direction;
use crate::statistics::random::Random;

const FULL: f64 = 30e6;

/// Which wheels are braked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Braked {
    Front,
    Rear,
    /// Both, the front with two thirds.
    Both,
}

/// One entry of a scenario's `manoeuvres`. Speeds in m/s.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum Manoeuvre {
    /// A whole plan of mixed riding, as the reduced-order motorcycle rides it.
    Plan {
        /// Which, and how much of it.
        plan: Plan,
    },
    /// Straight on at constant speed.
    Cruise {
        /// Speed, m/s.
        speed: f64,
        /// Duration, s.
        duration: f64,
    },
    /// In neutral from one speed to another.
    Coast {
        /// From, m/s.
        from: f64,
        /// Until, m/s.
        until: f64,
    },
    /// In neutral, pressure rising evenly up to the limit of grip.
    Brake {
        wheels: Braked,
        /// From, m/s.
        from: f64,
        /// Rise of the pressure, Pa/s.
        rise: f64,
        /// Released at this slip ratio (negative).
        slip: f64,
        /// Released at this speed, m/s.
        until: f64,
    },
    /// On the throttle from one speed to another, opened progressively.
    Accelerate {
        /// From, m/s.
        from: f64,
        /// To, m/s.
        to: f64,
        /// Rise of the acceleration, m/s³.
        rise: f64,
        /// Largest acceleration, m/s².
        peak: f64,
        /// Gear; the engine gives what it can in it.
        #[serde(default = "first")]
        gear: u8,
    },
    /// Leans in, holds, leans out.
    Corner {
        /// Direction, left or right.
        direction: Direction,
        /// Centre line, m.
        radius: f64,
        /// Speed, m/s.
        speed: f64,
        /// Heading change, rad.
        turn: f64,
    },
    /// At constant speed with a lean that grows steadily up to the grip limit.
    DecreasingRadius {
        /// Direction, left or right.
        direction: Direction,
        /// Speed, m/s.
        speed: f64,
        /// Lean rate, rad/s.
        rate: f64,
        /// Largest lean, rad.
        lean: f64,
        /// Slip angle of either wheel that counts as the limit, rad.
        grip: f64,
    },
    /// Two left corners on two short straights, over and over.
    TwoCornerLap {
        laps: usize,
        /// Centre lines, m.
        radii: [f64; 2],
        /// Lateral accelerations, from and to over the laps, m/s².
        lateral: [f64; 2],
    },
    /// Over to the next lane as fast as an ellipse of accelerations allows.
    LaneChange {
        /// The path and its limits.
        path: LaneChange,
        /// Straight run before it, m.
        ahead: f64,
        /// Straight run after it, m.
        beyond: f64,
    },
    /// From side to side at constant speed, a whole number of periods; first to the left. The lean builds up
    /// in the first period and dies away in the last.
    Slalom {
        /// Speed, m/s.
        speed: f64,
        /// Hz; or `cones`.
        #[serde(default)]
        frequency: Option<f64>,
        /// From cone to cone, m: half a wave.
        #[serde(default)]
        cones: Option<f64>,
        /// Largest lean, rad.
        lean: f64,
        /// About this long, s.
        duration: f64,
    },
    /// A lane change by its lean, at constant speed: once to one side, once to the other.
    Swerve {
        /// Side of the first lean.
        direction: Direction,
        /// Speed, m/s.
        speed: f64,
        /// Largest lean, rad.
        lean: f64,
        /// From upright to upright, s.
        duration: f64,
    },
    /// Brakes to a stop and stands.
    Stop {
        /// Duration, s.
        duration: f64,
    },
}

fn first() -> u8 {
    1
}

/// Lean of a steady turn, with what round tyres and spinning wheels add.
fn lean(speed: f64, radius: f64) -> f64 {
    (speed * speed / radius / crate::GRAVITY).atan() * 1.13
}

/// Straight on until the speed is steady, then a swing.
fn swing(swing: Swing, speed: f64) -> Vec<Phase> {
    vec![Phase::Cruise { speed, duration: 2.0 }, Phase::Swing { swing, speed }]
}

/// Waves of a slalom per second: two cones are a wave.
fn waves(speed: f64, frequency: Option<f64>, cones: Option<f64>) -> f64 {
    frequency.or(cones.map(|apart| speed / (2.0 * apart))).unwrap_or(f64::NAN)
}

/// Speed of the slalom passes that tell most of cornering and camber stiffness, m/s.
const PASSED_AT: f64 = 16.0;
/// From cone to cone of a slow and of a fast pass, m, and the largest lean in it, rad.
const PASSES: [[f64; 2]; 2] = [[27.0, 0.35], [11.0, 0.17]];
/// How long each takes, s.
const PASS: f64 = 15.0;

/// Four slalom passes, two slow and two fast, as the advice of the coefficients has them.
pub(crate) fn advised_passes() -> impl Iterator<Item = Manoeuvre> {
    let of = |[cones, lean]: [f64; 2]| Manoeuvre::Slalom {
        speed: PASSED_AT,
        frequency: None,
        cones: Some(cones),
        lean,
        duration: PASS,
    };
    PASSES.into_iter().flat_map(move |pass| [of(pass); 2])
}

impl Manoeuvre {
    /// Phases of the rider, one after the other.
    pub fn phases(&self, random: &mut Random) -> Vec<Phase> {
        let to = |speed: f64| Phase::Accelerate { to: speed, ramp: 2.0, peak: 4.0 };
        match *self {
            Manoeuvre::Plan { plan } => plan.phases(random),
            Manoeuvre::Cruise { speed, duration } => vec![Phase::Cruise { speed, duration }],
            Manoeuvre::Coast { from, until } => {
                vec![to(from), Phase::Coast { duration: 120.0, until }]
            }
            Manoeuvre::Brake { wheels, from, rise, slip, until } => {
                let ramp = match wheels {
                    Braked::Front => [rise, 0.0],
                    Braked::Rear => [0.0, rise],
                    Braked::Both => [rise * 2.0 / 3.0, rise / 3.0],
                };
                vec![
                    to(from),
                    Phase::Coast { duration: 1.5, until },
                    Phase::Brake { ramp, peak: [FULL; 2], until, slip },
                ]
            }
            Manoeuvre::Accelerate { from, to, rise, peak, gear } => vec![
                Phase::Cruise { speed: from, duration: 2.0 },
                Phase::Shift { gear },
                Phase::Accelerate { to, ramp: rise, peak },
                Phase::Shift { gear: 1 },
            ],
            Manoeuvre::Corner { direction, radius, speed, turn } => vec![
                Phase::Cruise { speed, duration: 2.0 },
                Phase::Corner {
                    direction,
                    lean: lean(speed, radius),
                    ramp: 2.2,
                    turn,
                    speed: Some(speed),
                },
            ],
            Manoeuvre::DecreasingRadius { direction, speed, rate, lean, grip } => vec![
                Phase::Cruise { speed, duration: 2.0 },
                Phase::Spiral { direction, rate, lean, grip, speed },
            ],
            Manoeuvre::TwoCornerLap { laps, radii, lateral } => {
                let mut phases = Vec::new();
                for lap in 0..laps {
                    let share = lap as f64 / (laps.max(2) - 1) as f64;
                    let lateral = lateral[0] + share * (lateral[1] - lateral[0]);
                    for radius in radii {
                        let speed = (lateral * radius).sqrt();
                        phases.extend([
                            Phase::Cruise { speed, duration: 2.0 },
                            Phase::Corner {
                                direction: Direction::Left,
                                lean: lean(speed, radius),
                                ramp: 2.2,
                                turn: std::f64::consts::PI,
                                speed: Some(speed),
                            },
                        ]);
                    }
                }
                phases
            }
            Manoeuvre::LaneChange { path, ahead, beyond } => vec![
                Phase::Cruise { speed: path.entry, duration: 1.0 },
                Phase::Follow { shape: path, ahead, beyond },
            ],
            Manoeuvre::Slalom { speed, frequency, cones, lean, duration } => {
                let form = Form::Slalom { frequency: waves(speed, frequency, cones) };
                swing(Swing { first: Direction::Left, lean, duration, form }, speed)
            }
            Manoeuvre::Swerve { direction, speed, lean, duration } => {
                swing(Swing { first: direction, lean, duration, form: Form::LaneChange }, speed)
            }
            Manoeuvre::Stop { duration } => {
                let slow = [0.6e6, 0.3e6];
                vec![
                    Phase::Brake { ramp: slow, peak: slow, until: 0.3, slip: -0.3 },
                    Phase::Stand { duration },
                ]
            }
        }
    }

    /// Error in its numbers, if there is one.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        let within = |name: &str, x: f64, low: f64, high: f64| {
            let ok = (low..=high).contains(&x);
            let fail = || format!("manoeuvre: `{name}` = {x} is not between {low} and {high}");
            if ok { Ok(()) } else { Err(KeyError::Values(fail())) }
        };
        let speed = |name: &str, x: f64| within(name, x, 0.0, 90.0);
        match *self {
            Manoeuvre::Plan { .. } => Ok(()),
            Manoeuvre::Cruise { speed: v, duration } => {
                speed("speed", v).and(within("duration", duration, 0.0, 3600.0))
            }
            Manoeuvre::Coast { from, until } => speed("from", from).and(speed("until", until)),
            Manoeuvre::Brake { from, rise, slip, until, .. } => speed("from", from)
                .and(within("rise", rise, 1e4, 1e8))
                .and(within("slip", slip, -1.0, 0.0))
                .and(speed("until", until)),
            Manoeuvre::Accelerate { from, to, rise, peak, gear } => speed("from", from)
                .and(speed("to", to))
                .and(within("gear", f64::from(gear), 1.0, 6.0))
                .and(within("rise", rise, 0.01, 100.0))
                .and(within("peak", peak, 0.01, 15.0)),
            Manoeuvre::Corner { radius, speed: v, turn, .. } => within("radius", radius, 3.0, 1e4)
                .and(within("speed", v, 3.0, 90.0))
                .and(within("turn", turn, 0.05, 100.0)),
            Manoeuvre::DecreasingRadius { speed: v, rate, lean, grip, .. } => {
                within("speed", v, 4.0, 90.0)
                    .and(within("rate", rate, 1e-3, 1.0))
                    .and(within("lean", lean, 0.02, 1.0))
                    .and(within("grip", grip, 0.005, 1.0))
            }
            Manoeuvre::TwoCornerLap { laps, radii, lateral } => {
                within("laps", laps as f64, 1.0, 1000.0)
                    .and(within("radii", radii[0].min(radii[1]), 5.0, 1e3))
                    .and(within("lateral", lateral[0].min(lateral[1]), 0.5, 12.0))
                    .and(within("lateral", lateral[0].max(lateral[1]), 0.5, 12.0))
            }
            Manoeuvre::LaneChange { path, ahead, beyond } => {
                within("path.length", path.length, 5.0, 500.0)
                    .and(within("path.entry", path.entry, 4.0, 90.0))
                    .and(within("path.drive", path.drive, 0.1, 15.0))
                    .and(within("path.brake", path.brake, 0.1, 15.0))
                    .and(within("path.lateral", path.lateral, 0.1, 15.0))
                    .and(within("path.front_share", path.front_share, 0.0, 1.0))
                    .and(within("ahead", ahead, 0.0, 1e4))
                    .and(within("beyond", beyond, 0.0, 1e4))
            }
            Manoeuvre::Slalom { frequency, cones, .. }
                if frequency.is_some() == cones.is_some() =>
            {
                let words = "manoeuvre: a slalom has either `frequency` or `cones`";
                Err(KeyError::Values(words.to_owned()))
            }
            Manoeuvre::Slalom { speed: v, frequency, cones, lean, duration } => {
                let name = if cones.is_some() { "speed / (2 cones)" } else { "frequency" };
                within("speed", v, 6.0, 90.0)
                    .and(within("cones", cones.unwrap_or(1.0), 1.0, 1e3))
                    .and(within(name, waves(v, frequency, cones), 0.05, 2.0))
                    .and(within("lean", lean, 0.01, 1.0))
                    .and(within("duration", duration, 1.0, 3600.0))
            }
            Manoeuvre::Swerve { speed: v, lean, duration, .. } => within("speed", v, 6.0, 90.0)
                .and(within("lean", lean, 0.01, 1.0))
                .and(within("duration", duration, 0.5, 20.0)),
            Manoeuvre::Stop { duration } => within("duration", duration, 0.0, 3600.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::coefficient::SLALOM;

    #[test]
    fn the_advice_says_what_is_ridden_for_it() {
        let [slow, fast] = PASSES.map(|[cones, _]| cones);
        let words = format!(
            "ride four slalom passes at {PASSED_AT:.0} m/s: two with cones {slow:.0} m apart, two with cones {fast:.0} m \
             apart"
        );
        assert_eq!(SLALOM, words);
        for pass in advised_passes() {
            pass.check().expect("sound");
        }
        assert_eq!(advised_passes().count(), 4);
    }

    #[test]
    fn a_slalom_has_waves_or_cones() {
        let slalom = |more: &str| {
            let text =
                format!("kind = \"slalom\"\nspeed = 16.0\nlean = 0.2\nduration = 9.0\n{more}");
            toml::from_str::<Manoeuvre>(&text).expect("reads")
        };
        assert!(slalom("cones = 11.0").check().is_ok());
        assert!(slalom("frequency = 0.7").check().is_ok());
        for wrong in ["", "cones = 11.0\nfrequency = 0.7", "cones = 2.0", "cones = 0.5"] {
            assert!(slalom(wrong).check().is_err(), "{wrong}");
        }
        let phases = slalom("cones = 20.0").phases(&mut Random::new(1, "no draw"));
        let swings: Vec<_> = phases.iter().filter(|p| matches!(p, Phase::Swing { .. })).collect();
        let form = Form::Slalom { frequency: 0.4 };
        assert!(matches!(swings[..], [Phase::Swing { swing, .. }] if swing.form == form));
    }
}
