//! The extended model that a diagnosis leaves behind.

use super::name::{Cause, Naming};
use super::parameters::BASE;
use crate::contract::verdict::Verdict;
use crate::effects::extended_model::{Estimate, ExtendedModel};
use crate::tables::rows::Ident;

/// The named and ambiguous causes of a diagnosis with the base parameters fitted along with them.
pub fn extended_model(naming: &Naming, ident: &Ident) -> ExtendedModel {
    let named = |c: &&Cause| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous);
    let effects = naming.causes.iter().filter(named).map(|c| {
        let unit = c.effect.unit.to_owned();
        let estimate = Estimate { value: c.value, std_error: c.std_error, unit };
        (c.effect.name.to_owned(), estimate)
    });
    let parameters = &naming.extended.world;
    let base = BASE.iter().map(|p| (p.name.to_owned(), p.get(parameters)));
    ExtendedModel {
        session_id: ident.session_id.clone(),
        bike_id: ident.bike_id.clone(),
        effects: effects.collect(),
        base: base.collect(),
    }
}
