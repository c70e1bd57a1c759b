//! One simulated session.

use super::motorcycle::{Response, State};
use crate::contract::session::Session;
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};

/// Manoeuvres: kind, start and end (s), direction.
pub(crate) type Label = (ManoeuvreKind, f64, f64, Option<Direction>);

/// One simulated session with everything known about it.
#[derive(Debug, Clone)]
pub struct Simulated {
    pub session: Session,
    /// Manoeuvres: kind, start and end (s), direction.
    pub labels: Vec<Label>,
    /// The true signals of the recording, sample by sample.
    pub trace: Vec<Response>,
    /// The true states, sample by sample.
    pub states: Vec<State>,
    /// The road under each sample: grade, uphill positive, and what was climbed since the start, m.
    pub road: Vec<[f64; 2]>,
}

/// Labels of the runs of one kind and direction in samples at `rate` Hz.
pub(crate) fn labels(kinds: &[(ManoeuvreKind, Option<Direction>)], rate: f64) -> Vec<Label> {
    let mut labels = Vec::new();
    let mut start = 0;
    for i in 1..=kinds.len() {
        if i == kinds.len() || kinds[i] != kinds[start] {
            let (kind, direction) = kinds[start];
            labels.push((kind, start as f64 / rate, i as f64 / rate, direction));
            start = i;
        }
    }
    labels
}
