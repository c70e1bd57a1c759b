//! Numbers as people read them, where a table's are those of the formulas.
//!
//! The key `peak_slip` is the normalised slip of the paper's eq. 3, `sigma = kappa / (1 - kappa)`; charts, riders and other
//! programs have the slip ratio `kappa`, so pages and terminal say that: `kappa = sigma / (1 + sigma)`.

use crate::contract::coefficient::Coefficient as C;
use crate::store::tables::rows::{Coefficient, FleetRow, PooledRow};
use crate::tyre::magic_formula::slip_ratio;

/// Slope of the slip ratio over the normalised slip there.
fn slope(sigma: f64) -> f64 {
    (1.0 + sigma).powi(-2)
}

/// Whether a coefficient's key is the normalised slip.
fn is_normalised(coefficient: &str) -> bool {
    coefficient == C::PeakSlip.name()
}

/// A value of a coefficient and its standard error.
pub(crate) fn number(coefficient: &str, value: f64, std_error: Option<f64>) -> (f64, Option<f64>) {
    match is_normalised(coefficient) {
        true => (slip_ratio(value), std_error.map(|x| slope(value) * x)),
        false => (value, std_error),
    }
}

fn end(sigma: f64) -> f64 {
    // no interval that reaches so far down says anything
    if sigma > -0.9 { slip_ratio(sigma) } else { f64::NEG_INFINITY }
}

/// A row of `coefficients`.
pub(crate) fn coefficient(row: &mut Coefficient) {
    let (true, Some(sigma)) = (is_normalised(&row.coefficient), row.value) else { return };
    let by = slope(sigma);
    row.value = Some(slip_ratio(sigma));
    row.std_error = row.std_error.map(|x| by * x);
    row.dispersion = row.dispersion.map(|x| by * x);
    row.ci95_low = row.ci95_low.map(end).filter(|x| x.is_finite());
    row.ci95_high = row.ci95_high.map(end).filter(|x| x.is_finite());
    row.symbol = "kappa_max".to_owned();
    row.explain_ends();
}

/// A row of `fleet`.
pub(crate) fn fleet(row: &mut FleetRow) {
    let (true, Some(sigma)) = (is_normalised(&row.coefficient), row.median) else { return };
    let by = slope(sigma);
    for value in [&mut row.median, &mut row.quartile_1, &mut row.quartile_3] {
        *value = value.map(slip_ratio);
    }
    let widths = [
        &mut row.robust_sd,
        &mut row.within_sd,
        &mut row.between_sd,
        &mut row.drift_per_day,
        &mut row.between_sd_settled,
        &mut row.between_ci95_low,
        &mut row.between_ci95_high,
        &mut row.between_sd_fleet,
        &mut row.drift_settled_per_day,
        &mut row.drift_ci95_low,
        &mut row.drift_ci95_high,
    ];
    widths.into_iter().for_each(|width| *width = width.map(|x| by * x));
}

/// A row of `fleet_pooled`.
pub(crate) fn pooled(row: &mut PooledRow) {
    if !is_normalised(&row.coefficient) {
        return;
    }
    row.std_error *= slope(row.value);
    row.pooled_std_error *= slope(row.pooled);
    for value in
        [&mut row.value, &mut row.pooled, &mut row.pooled_ci95_low, &mut row.pooled_ci95_high]
    {
        *value = end(*value);
    }
    row.ci95_low = row.ci95_low.map(end);
    row.ci95_high = row.ci95_high.map(end);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::reason::Reason;

    #[test]
    fn the_peaks_slip_is_read_as_a_slip_ratio_and_nothing_else_changes() {
        let row = |c: C| Coefficient {
            coefficient: c.name().into(),
            value: Some(0.346),
            std_error: Some(0.018),
            ci95_low: Some(0.25),
            ci95_high: Some(1.0),
            ..Coefficient::default()
        };
        let mut read = row(C::PeakSlip);
        coefficient(&mut read);
        let near = |x: Option<f64>, y: f64| assert!((x.expect("known") - y).abs() < 1e-3, "{x:?}");
        near(read.value, 0.257);
        near(read.std_error, 0.018 / 1.346_f64.powi(2));
        near(read.ci95_low, 0.2);
        near(read.ci95_high, 0.5);
        let mut other = row(C::MfD);
        coefficient(&mut other);
        near(other.value, 0.346);
    }

    #[test]
    fn a_wide_interval_has_the_ends_of_the_row_in_the_table_and_on_pages() {
        let mut row = Coefficient {
            coefficient: C::PeakSlip.name().into(),
            value: Some(0.346),
            ci95_low: Some(0.25),
            ci95_high: Some(1.0),
            ..Coefficient::default()
        };
        row.explain(Some(Reason::wide_interval(0.25, 1.0).with_advice("brake")));
        assert_eq!(row.reason.as_deref(), Some("the interval is wide, 0.250 to 1.000"));
        coefficient(&mut row);
        assert_eq!(row.reason.as_deref(), Some("the interval is wide, 0.200 to 0.500"));
        assert_eq!(row.advice.as_deref(), Some("brake"));
    }
}
