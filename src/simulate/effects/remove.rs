//! Taking what was found out of a session, so that the nominal model holds for it: how the extended
//! model is used by `run` (`--model`).

use super::{ALL, ModelError};
use crate::contract::bike::Bike;
use crate::contract::session::Session;

/// Takes a model error out of a session and a bike. What cannot be taken out is returned by name: it
/// stays in the tyres' coefficients.
pub fn remove(error: &ModelError, session: &mut Session, bike: &mut Bike) -> Vec<&'static str> {
    let mut left = Vec::new();
    for effect in ALL {
        let size = (effect.get)(error);
        if size == 0.0 {
            continue;
        }
        match effect.remove {
            Some(remove) => remove(session, bike, size),
            None => left.push(effect.name),
        }
    }
    bike.sync_keys();
    left
}
