//! Prior of the scatter of numbers between fault-free rides of one motorcycle.
//!
//! It is stated here for a motorcycle alone; [`learnt`](super::learnt) puts it right by other motorcycles.

use super::numbers::{History, Number};
use crate::statistics::moderated::{BELIEF, Scatter};
use crate::statistics::order::median_of_finite;

/// A number's scatter between rides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Belief {
    /// Scatter over the standard error.
    pub ratio: f64,
    /// Natural scatter in addition, in the number's unit.
    pub natural: f64,
    /// Degrees of freedom of this.
    pub freedom: f64,
}

/// Scatter over the usual standard error, of effects and of nominal parameters. It is 0.1 to 2.6 and 0.1 to 2 on 44 rides:
/// of four machines of the population and six of the independent simulator.
const EFFECT_SCATTER: f64 = 1.5;
const NOMINAL_SCATTER: f64 = 2.0;
/// Scatter of the numbers that scatter more: zeros of sensors, and those that rider, warmth and pads change.
const WIDE_SCATTER: &[(&str, f64)] = &[
    ("acceleration_x_zero", 8.0),
    ("acceleration_y_zero", 4.0),
    ("yaw_rate_zero", 3.5),
    ("velocity_y_zero", 3.0),
    ("drag", 4.0),
    ("rolling_resistance", 4.0),
    ("brake_gain_front", 4.0),
    ("brake_gain_rear", 4.0),
    ("mf_e1_front", 4.0),
];
/// Natural scatter, as a share of the value, by posture and by the warmth of tyres and pads.
const NATURAL_SHARE: &[(&str, f64)] = &[
    ("drag", 0.05),
    ("rolling_resistance", 0.1),
    ("brake_gain_front", 0.03),
    ("brake_gain_rear", 0.03),
];

impl Belief {
    /// What is believed of a number of a motorcycle.
    pub(crate) fn of(history: &History, number: usize) -> Self {
        Self::stated(history, number).learnt(history.scatter[number])
    }

    /// The same before other motorcycles are seen.
    pub(crate) fn stated(history: &History, number: usize) -> Self {
        let usual = median_of_finite(&history.values[number]).unwrap_or(0.0);
        Self::of_number(&history.numbers[number], usual)
    }

    /// With what other motorcycles teach.
    pub(crate) fn learnt(self, scatter: Scatter) -> Self {
        Belief {
            ratio: self.ratio * scatter.factor,
            natural: self.natural * scatter.factor,
            freedom: scatter.freedom,
        }
    }

    /// Prior of a number with a usual value.
    fn of_number(number: &Number, usual: f64) -> Self {
        let of = |list: &[(&str, f64)]| {
            list.iter().find(|(name, _)| *name == number.name).map(|(_, value)| *value)
        };
        let plain = if number.effect.is_some() { EFFECT_SCATTER } else { NOMINAL_SCATTER };
        Belief {
            ratio: of(WIDE_SCATTER).unwrap_or(plain),
            natural: of(NATURAL_SHARE).map_or(0.0, |share| (share * usual).abs()),
            freedom: BELIEF,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::road::parameters::BASE;

    #[test]
    fn every_number_that_is_listed_is_one_of_the_nominal_model() {
        for (name, _) in WIDE_SCATTER.iter().chain(NATURAL_SHARE) {
            assert!(BASE.iter().any(|p| p.name == *name), "{name}");
        }
    }
}
