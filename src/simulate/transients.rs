//! Transient riding within a plan: slalom passes and lane changes, which separate cornering stiffness
//! from camber stiffness.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::swing::{Form, Swing};
use crate::segment::manoeuvre::Direction;
use crate::statistics::random::Random;

/// How many of each a plan has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Transients {
    /// Slalom passes at 0.2 to 0.3 Hz with 20 degrees of lean.
    pub slow_passes: usize,
    /// Slalom passes at 0.6 to 0.8 Hz with 8 to 12 degrees of lean.
    pub fast_passes: usize,
    /// Lane changes of 2 to 4 s.
    pub lane_changes: usize,
}

impl Transients {
    /// Draws those that are due in one of several equal parts of a plan.
    pub(super) fn part(
        &self,
        part: usize,
        parts: usize,
        random: &mut Random,
        rides: &mut Vec<(Swing, f64)>,
    ) {
        let due =
            |count: usize| -> Range<usize> { part * count / parts..(part + 1) * count / parts };
        for i in due(self.slow_passes) {
            let frequency = random.between(0.2, 0.3);
            let lean = random.between(19.0, 21.0).to_radians();
            pass(i, frequency, lean, random, rides);
        }
        for i in due(self.fast_passes) {
            let frequency = random.between(0.6, 0.8);
            let lean = random.between(8.0, 12.0).to_radians();
            pass(i, frequency, lean, random, rides);
        }
        for i in due(self.lane_changes) {
            let swing = Swing {
                first: side(i),
                lean: random.between(0.16, 0.30),
                duration: random.between(2.0, 4.0),
                form: Form::LaneChange,
            };
            rides.push((swing, random.between(10.0, 24.0)));
        }
    }
}

/// Left and right in turn.
fn side(number: usize) -> Direction {
    if number.is_multiple_of(2) { Direction::Left } else { Direction::Right }
}

fn pass(
    number: usize,
    frequency: f64,
    lean: f64,
    random: &mut Random,
    rides: &mut Vec<(Swing, f64)>,
) {
    let form = Form::Slalom { frequency };
    let swing = Swing { first: side(number), lean, duration: random.between(15.0, 17.0), form };
    rides.push((swing, random.between(16.0, 24.0)));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;
    use crate::simulate::effects::ModelError;
    use crate::simulate::manoeuvre::Manoeuvre;
    use crate::simulate::multibody_ride;
    use crate::simulate::plan::{Phase, Plan, PlanKind};
    use crate::simulate::population::Machine;
    use crate::simulate::population::bike::BikeFile;
    use crate::simulate::reduced;
    use crate::simulate::ride::Sample;
    use crate::simulate::scenario::Scenario;
    use crate::simulate::tour::Tour;

    /// Slow and fast passes and lane changes: speed (m/s), frequency (Hz; none is a lane change), lean (rad),
    /// duration (s).
    const ASKED: [(f64, Option<f64>, f64, f64); 6] = [
        (16.0, Some(0.2), 0.35, 20.0),
        (24.0, Some(0.3), 0.35, 15.0),
        (16.0, Some(0.6), 0.21, 10.0),
        (24.0, Some(0.8), 0.16, 10.0),
        (10.0, None, 0.20, 2.0),
        (24.0, None, 0.30, 4.0),
    ];

    fn manoeuvre((speed, frequency, lean, duration): (f64, Option<f64>, f64, f64)) -> Manoeuvre {
        match frequency {
            Some(_) => Manoeuvre::Slalom { speed, frequency, cones: None, lean, duration },
            None => Manoeuvre::Swerve { direction: Direction::Right, speed, lean, duration },
        }
    }

    /// Frequency (Hz) and amplitude (rad) of the roll of a ride that ends with a swing, over those asked.
    fn found(roll: &[f64], rate: f64, asked: &Manoeuvre) -> [f64; 2] {
        let phases = asked.phases(&mut Random::new(1, "no draw"));
        let Some(Phase::Swing { swing, .. }) = phases.last() else { panic!("no swing") };
        let length = (swing.length() * rate) as usize;
        let roll = &roll[roll.len() - length..];
        let at = |k: usize| k as f64 / rate;
        if let Form::Slalom { frequency } = swing.form {
            // without the first and the last period
            let period = (rate / frequency) as usize;
            let full = period..length - period;
            let ups: Vec<f64> = full
                .clone()
                .filter(|&k| roll[k - 1] < 0.0 && roll[k] >= 0.0)
                .map(|k| at(k) - roll[k] / (roll[k] - roll[k - 1]) / rate)
                .collect();
            let seen = (ups.len() - 1) as f64 / (ups[ups.len() - 1] - ups[0]);
            let w = std::f64::consts::TAU * frequency;
            let part = |f: fn(f64) -> f64| {
                let sum: f64 = full.clone().map(|k| roll[k] * f(w * at(k))).sum();
                2.0 * sum / full.len() as f64
            };
            [seen / frequency, part(f64::sin).hypot(part(f64::cos)) / swing.lean]
        } else {
            let largest = |sign: f64| {
                let of = |k: &usize| sign * roll[*k];
                (0..length).max_by(|a, b| of(a).total_cmp(&of(b))).map(|k| (at(k), of(&k)))
            };
            let (Some(right), Some(left)) = (largest(1.0), largest(-1.0)) else { panic!("empty") };
            // the largest leans are a third of the duration apart
            [swing.duration / 3.0 / (left.0 - right.0), 0.5 * (left.1 + right.1) / swing.lean]
        }
    }

    fn near(what: &str, asked: (f64, Option<f64>, f64, f64), [frequency, lean]: [f64; 2]) {
        println!("{what} {asked:?}: frequency {frequency:.3}, lean {lean:.3} of those asked");
        assert!((frequency - 1.0).abs() < 0.15, "{what} {asked:?}: frequency {frequency}");
        assert!((lean - 1.0).abs() < 0.15, "{what} {asked:?}: lean {lean}");
    }

    #[test]
    fn a_plan_has_as_many_as_asked_of_either_plan() {
        let transients = Transients { slow_passes: 4, fast_passes: 3, lane_changes: 7 };
        for kind in [PlanKind::Paper, PlanKind::Naturalistic] {
            let plan = Plan { kind, coasts: 2, brakings: 1, laps: 3, transients };
            let (mut slow, mut fast, mut changes, mut to_the_left) = (0, 0, 0, 0);
            for phase in plan.phases(&mut Random::new(5, "plan")) {
                let Phase::Swing { swing, .. } = phase else { continue };
                to_the_left += usize::from(swing.first == Direction::Left);
                match swing.form {
                    Form::Slalom { frequency } if frequency < 0.4 => slow += 1,
                    Form::Slalom { .. } => fast += 1,
                    Form::LaneChange => changes += 1,
                }
            }
            assert_eq!([slow, fast, changes, to_the_left], [4, 3, 7, 8], "{kind:?}");
        }
    }

    #[test]
    fn the_reduced_motorcycle_leans_as_asked() {
        let scenario = Scenario::builtin("naturalistic").expect("scenario");
        for number in 0..2 {
            let plant = scenario.machine(number).plant;
            for asked in ASKED {
                let manoeuvre = manoeuvre(asked);
                let mut random = Random::new(1, "ride");
                let mut phases = vec![Phase::Accelerate { to: asked.0, ramp: 2.0, peak: 3.0 }];
                phases.extend(manoeuvre.phases(&mut random));
                let (calm, rate) = (scenario.disturbance, scenario.rate);
                let meta = Meta::default();
                let ride =
                    reduced::simulate_phases(&plant, &phases, calm, random, rate, 300.0, meta);
                let roll: Vec<f64> = ride.states.iter().map(|s| s.roll).collect();
                near("reduced", asked, found(&roll, rate, &manoeuvre));
            }
        }
    }

    #[test]
    fn multibody_motorcycles_lean_as_asked() {
        let scenario = Scenario::builtin("naturalistic").expect("scenario");
        let mut tours = vec![Tour::load("slalom").expect("built in").expect("nonlinear")];
        for number in 0..2 {
            let machine = Machine::draw(1, number, 0).expect("built in");
            let tour = machine.tour(&scenario, &ModelError::default(), BikeFile::Full);
            tours.push(tour.expect("stands"));
        }
        for tour in &mut tours {
            for asked in ASKED {
                let manoeuvre = manoeuvre(asked);
                tour.start_speed = asked.0;
                tour.manoeuvres = vec![manoeuvre];
                let name = &tour.bike.bike_id;
                let ride = multibody_ride::ridden(tour, 0).expect("rides");
                assert_eq!(ride.fall, None, "{name} {asked:?}");
                let roll = |s: &Sample| {
                    let r = &s.motion.rotation;
                    r[(2, 1)].atan2(r[(2, 2)])
                };
                let roll: Vec<f64> = ride.samples.iter().map(roll).collect();
                near(name, asked, found(&roll, tour.rate, &manoeuvre));
            }
        }
    }
}
