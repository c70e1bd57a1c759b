//! Transient riding within a plan: slalom passes and lane changes, which separate cornering stiffness
//! from camber stiffness.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::swing::{Form, Swing};
use crate::segment::manoeuvre::Direction;
use crate::statistics::random::Random;

/// Number of each in a plan.
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
    use crate::simulate::plan::{Phase, Plan, PlanKind};

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
}
