//! From fits to the rows of the `coefficients` table: standard errors, intervals and status.

use super::config::Config;
use super::solution::{Solution, Upstream};
use super::verdict::{Case, is_of_rule};
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::{Coefficient as C, Id, RULE};
use crate::contract::reason::Reason;
use crate::statistics::clustered_fit::Uncertainty;
use crate::statistics::interval::{Interval, combined_dof, delta, ratio, ratio_se};
use crate::store::tables::rows::{Coefficient, Ident, Provenance, Status};

/// The rows of one session. `missing` gives the reason where a channel that a coefficient needs is not there.
pub fn rows(
    solution: &Solution,
    bike: &Bike,
    config: &Config,
    missing: &dyn Fn(Id) -> Option<Reason>,
    ident: &Ident,
    provenance: &Provenance,
) -> Vec<Coefficient> {
    let upstream: Vec<&Upstream> = solution.upstream.iter().collect();
    Id::onroad()
        .map(|id| {
            let value = solution.found.values[id];
            let own = solution.uncertainty(id);
            let estimate = estimate(solution, &upstream, bike, id, &own);
            let interval = estimate.interval;
            let case = Case { solution, config, id, own: &own, interval };
            let (status, reason) = case.verdict(missing(id));
            let available = status != Status::NotAvailable && value.is_finite();
            let finite = |x: f64| Some(x).filter(|x| x.is_finite() && available);
            let fitted = own.quality.n_samples > 0 && available;
            let spec = id.coefficient.spec();
            let mut row = Coefficient {
                ident: ident.clone(),
                tyre: id.part.name().to_owned(),
                coefficient: spec.name.to_owned(),
                term: Some(spec.term.to_owned()),
                symbol: spec.symbol.to_owned(),
                value: finite(value),
                unit: spec.unit.to_owned(),
                std_error: finite(estimate.std_error),
                ci95_low: interval.ends().and_then(|e| finite(e.0)),
                ci95_high: interval.ends().and_then(|e| finite(e.1)),
                dispersion: own.dispersion.and_then(finite),
                n_manoeuvres: if fitted { own.quality.n_clusters as i64 } else { 0 },
                n_samples: if fitted { own.quality.n_samples as i64 } else { 0 },
                residual_scale: fitted.then_some(own.quality.scale).and_then(finite),
                outlier_fraction: fitted.then_some(own.quality.outlier_fraction).and_then(finite),
                r_squared: fitted.then_some(own.quality.r_squared).and_then(finite),
                status,
                provenance: provenance.clone(),
                ..Coefficient::default()
            };
            row.explain(reason);
            row
        })
        .collect()
}

/// How well a coefficient is known.
pub(super) struct Estimate {
    /// In the coefficient's unit; NaN where it is not known.
    pub(super) std_error: f64,
    /// Degrees of freedom of the standard error.
    pub(super) dof: f64,
    /// 95 %.
    pub(super) interval: Interval,
}

/// Of what nothing is known.
const UNKNOWN: Estimate = Estimate { std_error: f64::NAN, dof: 0.0, interval: Interval::Unbounded };

/// Estimate from a rule, with the width of the rule, whatever its inputs are known to.
fn of_rule(value: f64) -> Estimate {
    let [low, high] = RULE.map(|share| share * value);
    let interval = Interval::Bounded { low, high };
    Estimate { std_error: 0.25 * (high - low), dof: f64::INFINITY, interval }
}

/// Sum of squares of the upstream changes of a coefficient.
fn upstream_variance(upstream: &[&Upstream], id: Id) -> f64 {
    let changes = upstream.iter().map(|u| u.change.values[id]);
    changes.filter(|d| d.is_finite()).map(|d| d * d).sum()
}

/// Standard error and interval of a coefficient, with what is upstream of it.
pub(super) fn estimate(
    solution: &Solution,
    upstream: &[&Upstream],
    bike: &Bike,
    id: Id,
    own: &Uncertainty,
) -> Estimate {
    if let C::CorneringStiffness0 | C::CamberStiffness0 = id.coefficient {
        return stiffness(solution, upstream, bike, id, own);
    }
    if is_of_rule(bike, id) {
        return of_rule(solution.found.values[id]);
    }
    let (std_error, dof) = together(own, upstream_variance(upstream, id));
    if std_error == 0.0 {
        return UNKNOWN;
    }
    Estimate { std_error, dof, interval: delta(solution.found.values[id], std_error, dof) }
}

/// Standard error and degrees of freedom of a fit's own variance and that of what is upstream.
pub(super) fn together(own: &Uncertainty, outside: f64) -> (f64, f64) {
    let std_error = (own.variance + outside).sqrt();
    let dof = if own.dof > 0.0 {
        combined_dof(&[(own.variance.sqrt(), own.dof), (outside.sqrt(), f64::INFINITY)])
    } else if own.quality.n_samples > 0 {
        0.0 // fitted, but from too few manoeuvres to know how well
    } else {
        f64::INFINITY
    };
    (std_error, dof)
}

/// `k_alpha0` or `k_gamma0 = C k_alpha0` as the table has it: upright.
fn stiffness(
    solution: &Solution,
    upstream: &[&Upstream],
    bike: &Bike,
    id: Id,
    own: &Uncertainty,
) -> Estimate {
    let Some(axle) = id.part.axle() else {
        return UNKNOWN;
    };
    let camber = id.coefficient == C::CamberStiffness0;
    let quotient_of = solution.found.stiffness[axle as usize];
    let value = solution.found.values[id];
    // own variance is that of the quotient: as if all of it were the denominator's
    let sd = own.variance.sqrt() / value.abs() * quotient_of.denominator.abs();
    quotient(solution, upstream, bike, (axle, camber), 0.0, (sd, own.dof))
}

/// Cornering stiffness of a tyre at a camber (rad), or that of camber: a quotient of two uncertain numbers, so its interval
/// is Fieller's, which opens where the denominator may vanish. `own` is the standard error that the fit gives the denominator, and
/// its degrees of freedom.
pub(super) fn quotient(
    solution: &Solution,
    upstream: &[&Upstream],
    bike: &Bike,
    (axle, of_camber): (Axle, bool),
    camber: f64,
    own: (f64, f64),
) -> Estimate {
    let k = axle as usize;
    let (square, tangent) =
        (camber * camber, if camber.abs() < 1e-6 { 1.0 } else { camber.tan() / camber });
    // upright the growth does not matter, whether it is known or not
    let grown = |growth: f64| if square > 0.0 { growth * square } else { 0.0 };
    let found = solution.found.stiffness[k];
    let denominator = found.denominator + grown(solution.found.growth[k]);
    let c = bike.wheel(axle).side_force_ratio;
    let scale = if of_camber { c } else { 1.0 };
    let numerator = tangent * found.numerator;
    let value = scale * numerator / denominator;
    let own_relative = own.0 / denominator.abs();
    let mut covariance = [0.0, 0.0, own.0 * own.0];
    for change in upstream.iter().map(|u| &u.change) {
        let mut d_n = tangent * change.stiffness[k].numerator;
        let d_d = change.stiffness[k].denominator + grown(change.growth[k]);
        if of_camber {
            d_n = c * d_n + numerator * change.values[(axle, C::SideForceRatio)];
        }
        if d_n.is_finite() && d_d.is_finite() {
            covariance[0] += d_n * d_n;
            covariance[1] += d_n * d_d;
            covariance[2] += d_d * d_d;
        }
    }
    let std_error = ratio_se(scale * numerator, denominator, covariance);
    let relative = std_error / value.abs();
    let outside = (relative * relative - own_relative * own_relative).max(0.0).sqrt();
    let dof = combined_dof(&[(own_relative, own.1), (outside, f64::INFINITY)]);
    Estimate { std_error, dof, interval: ratio(scale * numerator, denominator, covariance, dof) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_interval_of_a_rule_is_the_rules() {
        let Estimate { std_error, interval, .. } = of_rule(0.3);
        let (low, high) = interval.ends().expect("bounded");
        assert!((low - 0.09).abs() < 1e-3 && (high - 0.6).abs() < 1e-3, "{low} to {high}");
        assert!((std_error - 0.425 * 0.3).abs() < 1e-12, "{std_error}");
    }
}
