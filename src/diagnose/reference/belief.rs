//! How much numbers of fault-free rides of one motorcycle are believed to scatter, before any is compared.

use super::numbers::Number;

/// A number's scatter between rides.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Belief {
    /// Over the standard error.
    pub ratio: f64,
    /// Beside that, in the number's unit.
    pub natural: f64,
}

/// Scatter over the usual standard error, of effects and of nominal parameters: on 44 rides of four machines of the population
/// and six of the independent simulator 0.1 to 2.6, and 0.1 to 2.
const EFFECT: f64 = 1.5;
const NOMINAL: f64 = 2.0;
/// That of the numbers that scatter more there: zeros of sensors, and what a rider, warmth and pads change.
const WIDE: &[(&str, f64)] = &[
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
/// Natural scatter, as a share of the value: posture, warmth of the tyres and of the pads.
const NATURAL: &[(&str, f64)] = &[
    ("drag", 0.05),
    ("rolling_resistance", 0.1),
    ("brake_gain_front", 0.03),
    ("brake_gain_rear", 0.03),
];

impl Belief {
    /// Of a number with a usual value.
    pub(crate) fn of(number: &Number, usual: f64) -> Self {
        let of = |list: &[(&str, f64)]| {
            list.iter().find(|(name, _)| *name == number.name).map(|(_, value)| *value)
        };
        let plain = if number.effect.is_some() { EFFECT } else { NOMINAL };
        Belief {
            ratio: of(WIDE).unwrap_or(plain),
            natural: of(NATURAL).map_or(0.0, |share| (share * usual).abs()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::road::parameters::BASE;

    #[test]
    fn every_number_that_is_listed_is_one_of_the_nominal_model() {
        for (name, _) in WIDE.iter().chain(NATURAL) {
            assert!(BASE.iter().any(|p| p.name == *name), "{name}");
        }
    }
}
