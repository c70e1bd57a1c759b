//! Sizes as people read them: fixed-point, angles in degrees, shares in per cent, short times in ms.

use crate::simulate::effects::Effect;
use crate::statistics::number_format::{self, decimals_of, fixed};
use crate::store::tables::rows::CauseRow;

/// Units and what they are read in: SI, shown, factor.
const READ: [(&str, &str, f64); 7] = [
    ("1", " %", 1e2),
    ("rad", "°", 180.0 / std::f64::consts::PI),
    ("s", " ms", 1e3),
    ("m", " mm", 1e3),
    ("s/m", " ms/m", 1e3),
    ("1/kN", " %/kN", 1e2),
    ("rad/N", "°/kN", 180e3 / std::f64::consts::PI),
];

/// The unit that the SI unit of an effect is read in, with the blank before it, and the factor to it. Of what is no effect, and
/// of what is added to a ratio, a number of unit 1 stays as it is: per cent of it would be read as relative.
pub(crate) fn unit(effect: &str, si: &str) -> (String, f64) {
    let in_per_cent = Effect::named(effect).is_ok_and(|effect| effect.in_per_cent);
    if si == "1" && !in_per_cent {
        return (String::new(), 1.0);
    }
    let read = READ.iter().find(|(of, ..)| *of == si);
    read.map_or_else(
        || (format!(" {si}"), 1.0),
        |(_, shown, factor)| ((*shown).to_owned(), *factor),
    )
}

/// A size of an effect with two digits and its unit.
pub(crate) fn size(value: f64, effect: &str, si: &str) -> String {
    let (shown, factor) = unit(effect, si);
    let x = value * factor;
    let decimals = if x == 0.0 || !x.is_finite() { 0.0 } else { 1.0 - x.abs().log10().floor() };
    format!("{x:.*}{shown}", decimals.clamp(0.0, 6.0) as usize)
}

/// The size of a cause and its 95 % interval, with the digits that the interval leaves; `None` where either is not known.
pub(crate) fn sized(row: &CauseRow) -> Option<(String, String)> {
    let (unit, factor) = unit(&row.effect, &row.unit);
    let of = |x: Option<f64>| x.map(|x| x * factor);
    let (value, low, high) = (of(row.value)?, of(row.ci95_low)?, of(row.ci95_high)?);
    let digits = decimals_of(value, number_format::uncertainty(None, Some(low), Some(high)));
    let [low, high] = [low, high].map(|x| fixed(x, digits));
    Some((format!("{}{unit}", fixed(value, digits)), format!("{low} to {high}{unit}")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_fixed_point_in_a_persons_units() {
        let of = [
            (1.75e-3, "brake_fade", "1"),
            (5.92e-3, "road_bank", "rad"),
            (3.06e-3, "latency", "s"),
            (0.308, "wind", "m/s"),
            (9.23, "brake_drag", "N m"),
        ];
        let said = of.map(|(x, effect, unit)| size(x, effect, unit));
        assert_eq!(said, ["0.18 %", "0.34°", "3.1 ms", "0.31 m/s", "9.2 N m"]);
        assert_eq!(size(10.9, "gyroscopic", "1"), "1090 %");
        assert_eq!(size(0.0, "radius_camber", "m"), "0 mm");
    }

    /// The terminal gave a change of `C` by 0.0276, which is 0.095, as 2.8 %.
    #[test]
    fn what_is_added_to_a_ratio_is_no_per_cent() {
        assert_eq!(size(0.0276, "side_force_ratio_front", "1"), "0.028");
        assert_eq!(size(0.0031, "road_grade", "1"), "0.31 %");
        assert_eq!(unit("not_yet", "1"), (String::new(), 1.0));
        let row = CauseRow {
            effect: "side_force_ratio_rear".into(),
            unit: "1".into(),
            value: Some(-0.0066),
            ci95_low: Some(-0.0248),
            ci95_high: Some(0.0115),
            ..CauseRow::default()
        };
        let said = Some(("-0.0066".to_owned(), "-0.0248 to 0.0115".to_owned()));
        assert_eq!(sized(&row), said);
    }
}
