//! Kinds of events between sessions.

use crate::contract::fleet_event::EventKind;

/// A kind of event as people read it, by its name in the table `fleet_events`; the name itself where
/// this version does not know it.
pub(crate) fn label(name: &str) -> &str {
    EventKind::from_name(name).map_or(name, |kind| kind.words())
}
