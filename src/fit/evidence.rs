//! What a session tells of each coefficient, error by error: all that combining sessions needs.
//!
//! ```text
//! y = theta + sum_shared shift_j d_j + sum_own shift_k e_k        d_j, e_k ~ N(0, 1)
//! ```
//!
//! `d_j` are the same in every ride of the motorcycle (the bike file's numbers, the rule of the trail, how far the model is
//! wrong for this motorcycle): they do not average out. `e_k` are drawn anew in every ride. The sum of their squares is the
//! variance that the row of `coefficients` states, with more for the scatter of few manoeuvres and for the peak slip.

use super::solution::{Solution, Upstream};
use super::variation::Source;
use crate::contract::bike::Bike;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::contract::error_source::{MODEL, OWN};
use crate::contract::session::Meta;
use crate::store::tables::rows::{Coefficient, EvidenceRow, Ident, Status};

/// An error of less than this share of the standard error goes to the scatter, or the model's error.
const SMALL: f64 = 0.05;
/// The slip of the peak is a nonlinear function of what was fitted, and too large: by 11 to 15 % on 240 simulated rides. A share.
const PEAK_SLIP: f64 = 0.12;
/// Most by which few manoeuvres widen the scatter's variance.
const FEW: f64 = 3.0;

/// The rows of a session, from its final rows of `coefficients`.
pub(crate) fn rows(
    solution: &Solution,
    bike: &Bike,
    coefficients: &[Coefficient],
    meta: &Meta,
) -> Vec<EvidenceRow> {
    let mut out = Vec::new();
    for row in coefficients {
        let stated = matches!(row.status, Status::Ok | Status::PoorlyDetermined);
        let (Some(value), Some(std_error), true) = (row.value, row.std_error, stated) else {
            continue;
        };
        let part = Part::ALL.into_iter().find(|p| p.name() == row.tyre);
        let coefficient = C::from_name(&row.coefficient);
        let (Some(part), Some(coefficient), true) = (part, coefficient, std_error > 0.0) else {
            continue;
        };
        let errors = errors(solution, bike, Id::from((part, coefficient)), value, std_error);
        out.extend(errors.into_iter().map(|(source, sensitivity)| EvidenceRow {
            ident: Ident::from(meta),
            tyre: row.tyre.clone(),
            tyre_model: row.tyre_model.clone(),
            site: meta.site.clone(),
            coefficient: row.coefficient.clone(),
            unit: row.unit.clone(),
            status: row.status,
            value,
            source: source.name,
            shared: source.shared,
            sensitivity,
            source_value: source.taken.map(|t| t[0]),
            source_std_error: source.taken.map(|t| t[1]),
        }));
    }
    out
}

/// The errors of one coefficient, which together make its standard error.
fn errors(
    solution: &Solution,
    bike: &Bike,
    id: Id,
    value: f64,
    std_error: f64,
) -> Vec<(Source, f64)> {
    let found = solution.found.values[id];
    // METHOD: of a value that the ride in gear gave no parts are known; counted as shared it does not average out
    if (found - value).abs().partial_cmp(&(1e-9 * value.abs())) != Some(std::cmp::Ordering::Less) {
        return vec![(Source::of_motorcycle(MODEL, None), std_error)];
    }
    let uncertainty = solution.uncertainty(id);
    let few = match uncertainty.dof {
        dof if dof > 2.0 => (dof / (dof - 2.0)).min(FEW),
        _ => FEW,
    };
    let all = std_error * std_error;
    let mut explained = uncertainty.variance;
    let (mut own, mut model) = (few * uncertainty.variance, 0.0);
    let mut out = Vec::new();
    for upstream in &solution.upstream {
        let shift = shift(solution, upstream, bike, id);
        if !shift.is_finite() || shift == 0.0 {
            continue;
        }
        explained += shift * shift;
        let small = shift * shift < (SMALL * std_error).powi(2);
        match &upstream.source {
            source if source.shared && (small || source.name == MODEL) => model += shift * shift,
            _ if small => own += shift * shift,
            source => out.push((source.clone(), shift)),
        }
    }
    // what was added to the row after the fit
    let left = all - explained;
    if left > 0.0 {
        model += left;
    }
    if id.coefficient == C::PeakSlip {
        model += (PEAK_SLIP * value).powi(2);
    }
    if own > 0.0 {
        out.push((Source::of_ride(OWN), own.sqrt()));
    }
    if model > 1e-6 * all {
        out.push((Source::of_motorcycle(MODEL, None), model.sqrt()));
    }
    out
}

/// Change of a coefficient by one standard error of an upstream quantity.
fn shift(solution: &Solution, upstream: &Upstream, bike: &Bike, id: Id) -> f64 {
    let change = &upstream.change;
    let camber = id.coefficient == C::CamberStiffness0;
    let (true, Some(axle)) = (camber || id.coefficient == C::CorneringStiffness0, id.part.axle())
    else {
        return change.values[id];
    };
    let (of, by) = (solution.found.stiffness[axle as usize], change.stiffness[axle as usize]);
    let stiffness = of.numerator / of.denominator;
    let relative = by.numerator / of.numerator - by.denominator / of.denominator;
    match camber {
        false => stiffness * relative,
        true => {
            let ratio = bike.wheel(axle).side_force_ratio;
            let of_ratio = change.values[(axle, C::SideForceRatio)];
            stiffness * (ratio * relative + if of_ratio.is_finite() { of_ratio } else { 0.0 })
        }
    }
}
