//! The small curves of a tyre's card: friction over slip ratio, and side force over camber or slip angle.
//!
//! METHOD: the tyre's model at the load at rest on the road that was ridden. Solid where the slip was ridden, dashed beyond;
//! the peak is marked where it was ridden.

use crate::report::export::row_tyre;
use crate::report::inline_svg::{self, Stroke};
use crate::store::tables::rows::TyreParameters;
use crate::tyre::paper::Input;
use crate::tyre::tyre_model::TyreModel;

/// Largest slip ratio of a curve, braking.
const SLIP: f64 = 0.3;
/// Largest slip angle, rad.
const ANGLE: f64 = 0.105;
/// Points of a curve.
const POINTS: usize = 49;
/// Ordinate's end, force over load: both tyres of a motorcycle have the same.
const FRICTION: f64 = 1.5;

/// Friction over slip ratio while braking, as SVG with its words. Empty where braking was not ridden.
pub(crate) fn friction(row: &TyreParameters) -> Option<String> {
    let ridden = -row.ridden_slip_low.filter(|low| row.longitudinal && *low < 0.0)?;
    let tyre = row_tyre::tyre(row);
    let load = row.load_at_rest;
    let at = |slip: f64| {
        let input = Input { slip_ratio: -slip, slip_angle: 0.0, camber: 0.0, load, friction: 1.0 };
        -tyre.forces(&input).force_x / load
    };
    let points = points(SLIP, at);
    let peak = points.iter().copied().max_by(|a, b| a[1].total_cmp(&b[1]))?;
    let marked = (peak[0] < ridden && peak[0] < SLIP).then_some(peak);
    let words = format!(
        "Braking force over load, 0 to {:.0} % slip, at {load:.0} N{}",
        100.0 * SLIP,
        marked.map_or(String::new(), |peak| format!(
            ": peak {:.2} at {:.0} % slip",
            peak[1],
            100.0 * peak[0]
        ))
    );
    Some(drawn(&points, ridden, marked, "0 to 30 % slip", &words))
}

/// Side force over slip angle of the upright tyre. Empty where the model has none.
pub(crate) fn side_force(row: &TyreParameters) -> Option<String> {
    let ridden = row.ridden_slip_angle.filter(|_| row.lateral)?.abs();
    let tyre = row_tyre::tyre(row);
    let load = row.load_at_rest;
    let at = |slip_angle: f64| {
        let input = Input { slip_ratio: 0.0, slip_angle, camber: 0.0, load, friction: 1.0 };
        tyre.forces(&input).force_y.abs() / load
    };
    let words = format!(
        "Side force over load, 0 to {:.0} degrees of slip angle, upright, at {load:.0} N",
        ANGLE.to_degrees()
    );
    Some(drawn(&points(ANGLE, at), ridden, None, "0 to 6° slip angle", &words))
}

fn points(end: f64, at: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    (0..POINTS).map(|i| end * i as f64 / (POINTS - 1) as f64).map(|x| [x, at(x)]).collect()
}

fn drawn(
    points: &[[f64; 2]],
    ridden: f64,
    peak: Option<[f64; 2]>,
    abscissa: &str,
    words: &str,
) -> String {
    let end = points[points.len() - 1][0];
    let stroke = |x: f64| if x <= ridden { Stroke::Solid } else { Stroke::Dashed };
    let of: Vec<([f64; 2], Stroke)> =
        points.iter().map(|[x, y]| ([x / end, y / FRICTION], stroke(*x))).collect();
    inline_svg::curve(&of, peak.map(|[x, y]| [x / end, y / FRICTION]), abscissa, words)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row() -> TyreParameters {
        TyreParameters {
            longitudinal: true,
            lateral: true,
            load_at_rest: 1200.0,
            mf_b: 12.0,
            mf_c: 1.4,
            mf_d: 1.1,
            ridden_slip_low: Some(-0.25),
            ridden_slip_high: Some(0.05),
            ridden_slip_angle: Some(0.02),
            peak_slip: 0.2,
            lateral_friction_ct: -0.8,
            slip_camber_c1: -0.01,
            slip_camber_c3: 0.04,
            side_force_ratio: 0.09,
            lateral_peak: 1.0,
            effective_rolling_radius: 0.3,
            vertical_stiffness: 1.3e5,
            deflection_share: 0.33,
            relaxation_length: 0.3,
            longitudinal_relaxation: 0.07,
            overturning_stiffness: 0.04,
            ..TyreParameters::default()
        }
    }

    #[test]
    fn the_peak_is_marked_where_it_was_ridden() {
        let curve = friction(&row()).expect("a curve");
        assert!(curve.contains("peak 1.1") && curve.contains("class=\"dot\""), "{curve}");
        let short = TyreParameters { ridden_slip_low: Some(-0.02), ..row() };
        let curve = friction(&short).expect("a curve");
        assert!(!curve.contains("peak") && !curve.contains("class=\"dot\""), "{curve}");
        assert_eq!(friction(&TyreParameters { ridden_slip_low: None, ..row() }), None);
    }

    #[test]
    fn the_side_force_is_solid_where_it_was_ridden() {
        let curve = side_force(&row()).expect("a curve");
        assert!(curve.contains("solid") && curve.contains("dashed"), "{curve}");
        let all = TyreParameters { ridden_slip_angle: Some(0.2), ..row() };
        assert!(!side_force(&all).expect("a curve").contains("dashed"));
        assert_eq!(side_force(&TyreParameters { lateral: false, ..row() }), None);
    }
}
