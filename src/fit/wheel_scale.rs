//! Rolling radii of logs that do not say how they turned a wheel's turns into a speed.
//!
//! A speed in km/h hides the circumference it was computed with. Every slip is a ratio of speeds in the log's own scale
//! and is not touched; the radius in metres is uncertain by that of the scale.

use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::store::tables::rows::Coefficient;

/// 95 % of a normal distribution.
const NORMAL: f64 = 1.96;

/// Widens the intervals of the rolling radii by the scales' relative standard deviations, front and rear.
pub(crate) fn widen(rows: &mut [Coefficient], scale_sd: [f64; 2]) {
    for (axle, share) in Axle::BOTH.into_iter().zip(scale_sd) {
        let own = |row: &&mut Coefficient| {
            row.tyre == Part::from(axle).name()
                && row.coefficient == C::EffectiveRollingRadius.name()
        };
        for row in rows.iter_mut().filter(own).filter(|_| share > 0.0) {
            widen_by_share(row, share);
        }
    }
}

/// Widens what is said of a coefficient by an independent relative error, one standard deviation.
pub(super) fn widen_by_share(row: &mut Coefficient, share: f64) {
    let Some(value) = row.value else { return };
    let by = share * value.abs();
    let half = |end: f64| (end - value).hypot(NORMAL * by);
    row.std_error = row.std_error.map(|sd| sd.hypot(by));
    row.ci95_low = row.ci95_low.map(|low| value - half(low));
    row.ci95_high = row.ci95_high.map(|high| value + half(high));
    row.explain_ends();
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_radius_of_the_wheel_is_widened() {
        let row = |tyre: &str, coefficient: C| Coefficient {
            tyre: tyre.into(),
            coefficient: coefficient.name().into(),
            value: Some(0.3),
            std_error: Some(0.0004),
            ci95_low: Some(0.2992),
            ci95_high: Some(0.3008),
            ..Coefficient::default()
        };
        let before = [
            row("front", C::EffectiveRollingRadius),
            row("rear", C::EffectiveRollingRadius),
            row("front", C::OverturningStiffness),
        ];
        let mut rows = before.clone();
        widen(&mut rows, [0.01, 0.0]);
        for (row, before) in rows.iter().zip(&before).skip(1) {
            assert_eq!((row.ci95_low, row.ci95_high), (before.ci95_low, before.ci95_high));
        }
        assert!((rows[0].std_error.expect("known") - 0.003_026_5).abs() < 1e-6);
        let [low, high] = [rows[0].ci95_low, rows[0].ci95_high].map(|x| x.expect("known"));
        assert!((low - 0.294_066).abs() < 1e-5 && (high - 0.305_934).abs() < 1e-5, "{low} {high}");
    }
}
