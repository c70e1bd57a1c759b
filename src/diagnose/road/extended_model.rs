//! The extended model that a diagnosis leaves behind.

use super::base::Base;
use super::parameters::BASE;
use crate::diagnose::cause::Naming;
use crate::effects::extended_model::{Estimate, ExtendedModel};
use crate::tables::rows::Ident;

/// The named and ambiguous causes of a diagnosis with the base parameters fitted along with them.
pub fn extended_model(naming: &Naming<Base>, ident: &Ident) -> ExtendedModel {
    let effects = naming.named().map(|cause| {
        let unit = cause.candidate.unit.to_owned();
        let estimate = Estimate { value: cause.value(), std_error: cause.std_error(), unit };
        (cause.candidate.name.to_owned(), estimate)
    });
    let parameters = &naming.extended.values;
    let base = BASE.iter().map(|p| (p.name.to_owned(), p.get(parameters)));
    ExtendedModel {
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        effects: effects.collect(),
        base: base.collect(),
    }
}
