//! Angles on a circle.

use std::f64::consts::{PI, TAU};

/// An angle within half a turn, rad: `-pi` to `pi`, the upper end excluded.
pub(crate) fn wrapped(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}

/// Takes out the jumps of a whole turn, rad. Missing samples stay missing and the turns are kept over them.
pub(crate) fn unwrap(angles: &mut [f64]) {
    unwrap_circle(angles, TAU);
}

/// The same of a column in any unit; `circle` is a whole turn in it.
pub(crate) fn unwrap_circle(x: &mut [f64], circle: f64) {
    let (mut turns, mut last) = (0.0, f64::NAN);
    for v in x.iter_mut().filter(|v| v.is_finite()) {
        let step = *v - last;
        if step.abs() > 0.5 * circle {
            turns -= (step / circle).round();
        }
        last = *v;
        *v += turns * circle;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_angle_is_within_half_a_turn() {
        for (angle, expected) in [(0.0, 0.0), (3.5, 3.5 - TAU), (-4.0, TAU - 4.0), (7.0, 7.0 - TAU)]
        {
            assert!((wrapped(angle) - expected).abs() < 1e-12, "{angle}");
        }
        assert_eq!(wrapped(PI), -PI);
    }

    #[test]
    fn turns_run_on_and_survive_what_is_missing() {
        let wanted: Vec<f64> = (0..40).map(|i| 0.5 * f64::from(i)).collect();
        let mut x: Vec<f64> = wanted.iter().map(|a| wrapped(*a)).collect();
        x[13] = f64::NAN;
        unwrap(&mut x);
        for (i, (x, wanted)) in x.iter().zip(&wanted).enumerate() {
            assert!(i == 13 && x.is_nan() || (x - wanted).abs() < 1e-12, "{i}: {x}");
        }
        let mut degrees = [350.0, 10.0, 30.0, -300.0];
        unwrap_circle(&mut degrees, 360.0);
        assert_eq!(degrees, [350.0, 370.0, 390.0, 420.0]);
    }
}
