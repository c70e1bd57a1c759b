//! The pages of diagnosed sessions.

pub(crate) mod answer;
pub(crate) mod bars;
pub(crate) mod cause_labels;
pub(crate) mod changes;
pub(crate) mod extended_model;
pub(crate) mod misfits;
pub(crate) mod outcome;
pub(crate) mod overlays;
pub(crate) mod page;
pub(crate) mod sessions;
pub(crate) mod simulation;
pub(crate) mod tables;
