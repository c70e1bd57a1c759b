//! What can be measured at home: two scales, a lifted axle, a swung wheel. Each with the standard deviation that
//! follows from that of the readings.

use super::numbers::ValueWithSd;
use crate::GRAVITY;
use crate::contract::key_error::KeyError;

/// A reading of a bathroom or luggage scale under a wheel, standard deviation, kg.
pub(crate) const SCALE_SD: f64 = 0.7;
/// A height by a tape, standard deviation, m.
const TAPE_SD: f64 = 0.003;
/// Share by which a rider sits otherwise the second time, of the height of the centre of mass.
const POSTURE: f64 = 0.015;
/// The period of ten swings by a watch, over ten, standard deviation, s.
const PERIOD_SD: f64 = 0.01;
/// A wheel on a kitchen or luggage scale, standard deviation, kg.
const WHEEL_SD: f64 = 0.1;

/// Mass (kg) and distance of the centre of mass from the front contact (m) from the loads (kg) of the wheels on two
/// scales, rider seated, and the wheelbase.
///
/// # Errors
/// A load is not positive.
pub(crate) fn two_scales(
    [front, rear]: [f64; 2],
    wheelbase: ValueWithSd,
) -> Result<[ValueWithSd; 2], KeyError> {
    if !(front > 0.0 && rear > 0.0 && front.is_finite() && rear.is_finite()) {
        return Err(KeyError::Values(format!(
            "loads of the wheels must be positive, in kg: {front}, {rear}"
        )));
    }
    let mass = front + rear;
    let share = rear / mass;
    let share_sd = SCALE_SD * front.hypot(rear) / (mass * mass);
    let arm = wheelbase.value * share;
    Ok([
        ValueWithSd { value: mass, sd: SCALE_SD * 2.0_f64.sqrt() },
        ValueWithSd { value: arm, sd: (wheelbase.value * share_sd).hypot(share * wheelbase.sd) },
    ])
}

/// Height of the centre of mass (m): with the rear axle `lift` (m) above its height on the ground, the front scale
/// shows `loads[1]` instead of `loads[0]` (kg); `radius` is that of the wheels, m.
///
/// ```text
/// z = (F1 - F0) l / (m tan a),  sin a = lift / l,  height = z + radius
/// ```
///
/// # Errors
/// The front wheel did not become heavier, or the lift is none.
pub(crate) fn lifted_axle(
    lift: f64,
    loads: [f64; 2],
    mass: ValueWithSd,
    wheelbase: ValueWithSd,
    radius: ValueWithSd,
) -> Result<ValueWithSd, KeyError> {
    let l = wheelbase.value;
    if !(lift > 0.02 && lift < 0.9 * l) {
        return Err(KeyError::Values(format!(
            "the axle was lifted by {lift} m: give 0.02 m to 0.9 wheelbases"
        )));
    }
    let change = loads[1] - loads[0];
    if !(change > 0.0 && change.is_finite()) {
        let [before, after] = loads;
        return Err(KeyError::Values(format!(
            "with the rear axle lifted the front scale shows more: {before} kg, then {after} kg"
        )));
    }
    let tangent = lift / (l * l - lift * lift).sqrt();
    let above = change * l / (mass.value * tangent);
    let relative = (SCALE_SD * 2.0_f64.sqrt() / change)
        .hypot(TAPE_SD / lift)
        .hypot(mass.sd / mass.value)
        .hypot(2.0 * wheelbase.sd / l);
    let value = above + radius.value;
    Ok(ValueWithSd { value, sd: (above * relative).hypot(radius.sd).hypot(POSTURE * value) })
}

/// Spin inertia (kg m²) of a wheel of `mass` (kg) that swings about a bar inside its rim, `arm` (m) from the axle,
/// with a period (s).
///
/// ```text
/// I = m g a T^2 / (4 pi^2) - m a^2
/// ```
///
/// # Errors
/// No wheel swings so.
pub(crate) fn swung_wheel(mass: f64, arm: f64, period: f64) -> Result<ValueWithSd, KeyError> {
    let of = |mass: f64, arm: f64, period: f64| {
        mass * arm * (GRAVITY * (period / std::f64::consts::TAU).powi(2) - arm)
    };
    let value = of(mass, arm, period);
    if !(mass > 0.0 && arm > 0.0 && period > 0.0 && value > 0.0 && value < mass) {
        return Err(KeyError::Values(format!(
            "no wheel of {mass} kg swings {arm} m from its axle with a period of {period} s"
        )));
    }
    let moved = [
        of(mass + WHEEL_SD, arm, period),
        of(mass, arm + 0.5 * TAPE_SD, period),
        of(mass, arm, period + PERIOD_SD),
    ];
    let sd = moved.iter().map(|m| (m - value).powi(2)).sum::<f64>().sqrt();
    Ok(ValueWithSd { value, sd })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_give_mass_and_place() {
        let wheelbase = ValueWithSd { value: 1.4, sd: 0.005 };
        let [mass, arm] = two_scales([130.0, 150.0], wheelbase).expect("loads");
        assert!((mass.value - 280.0).abs() < 1e-12 && (arm.value - 0.75).abs() < 1e-12);
        assert!(arm.sd > 0.002 && arm.sd < 0.01, "{arm:?}");
        assert!(two_scales([0.0, 150.0], wheelbase).is_err());
    }

    /// The load that statics puts on the front wheel gives the height back.
    #[test]
    fn a_lifted_axle_gives_the_height() {
        let (mass, l, arm, radius, height, lift) = (270.0, 1.42, 0.72, 0.31, 0.61, 0.4);
        let slope = f64::asin(lift / l);
        let front = mass * (l - arm) / l;
        let lifted = mass * ((l - arm) + (height - radius) * slope.tan()) / l;
        let exact = |value| ValueWithSd { value, sd: 0.0 };
        let found = lifted_axle(lift, [front, lifted], exact(mass), exact(l), exact(radius));
        let found = found.expect("a lift");
        assert!((found.value - height).abs() < 1e-12 && found.sd < 0.03, "{found:?}");
        assert!(lifted_axle(lift, [front, front], exact(mass), exact(l), exact(radius)).is_err());
    }

    /// A pendulum of known inertia has the period that gives it back.
    #[test]
    fn a_swung_wheel_gives_its_inertia() {
        let (mass, arm, inertia): (f64, f64, f64) = (11.5, 0.19, 0.47);
        let about = inertia + mass * arm * arm;
        let period = std::f64::consts::TAU * (about / (mass * GRAVITY * arm)).sqrt();
        let found = swung_wheel(mass, arm, period).expect("a wheel");
        assert!((found.value - inertia).abs() < 1e-12 && found.sd / inertia < 0.05, "{found:?}");
        assert!(swung_wheel(mass, arm, 0.1).is_err());
    }
}
