//! The extended model that a diagnosis writes.

use super::base::Base;
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::diagnose::cause::Identification;
use crate::fit::{Solution, coefficients};
use crate::pipeline::{Characterised, Pipeline, characterise};
use crate::simulate::effects::extended_model::{Coefficient, Estimate, ExtendedModel};
use crate::store::tables::rows::{Ident, Provenance};
use crate::tyre::formulation::Formulation;

/// The identified and ambiguous causes of a diagnosis, and the coefficients of its clean, unfiltered session
/// without them: the same that `run --model` finds. `ridden` is the session as it was characterised, where it was.
pub(crate) fn extended_model(
    identification: &Identification<Base>,
    ident: &Ident,
    (session, ridden): (&Session, Option<&Characterised>),
    bike: &Bike,
    pipeline: &Pipeline,
) -> ExtendedModel {
    let effects = identification.named().map(|cause| {
        let unit = cause.candidate.unit.to_owned();
        let estimate = Estimate { value: cause.value(), std_error: cause.std_error(), unit };
        (cause.candidate.name.to_owned(), estimate)
    });
    let mut model = ExtendedModel {
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        effects: effects.collect(),
        ..ExtendedModel::default()
    };
    let mut bike = bike.clone();
    let solution = match ridden {
        Some(ridden) if model.effects.is_empty() => {
            let upstream = ridden.upstream(&bike, pipeline);
            Solution { upstream, ..ridden.solution.clone() }
        }
        _ => {
            let mut ride = session.clone();
            model.apply(&mut ride, &mut bike);
            characterise(ride, &bike, pipeline, Formulation::Corrected).solution
        }
    };
    let none = Provenance::default();
    for row in coefficients::rows(&solution, &bike, &pipeline.fit, &|_| None, ident, &none) {
        let Some(value) = row.value else { continue };
        let ci95 = row.ci95_low.zip(row.ci95_high).map(|(low, high)| [low, high]);
        let own = Coefficient { value, ci95, unit: row.unit, status: row.status.to_string() };
        model.coefficients.entry(row.tyre).or_default().insert(row.coefficient, own);
    }
    model
}
