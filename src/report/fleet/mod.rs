//! The page over all sessions, and what changed on each motorcycle.

pub(crate) mod comparison;
pub(crate) mod event_kind;
pub(crate) mod history;
pub(crate) mod lists;
pub(crate) mod page;
pub(crate) mod ratios;
pub(crate) mod tables;
pub(crate) mod tyres;
pub(crate) mod what_changed;
pub(crate) mod write;
