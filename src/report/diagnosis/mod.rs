//! The pages of diagnosed sessions.

pub mod bars;
pub mod cause_labels;
pub mod extended_model;
pub mod misfits;
pub mod outcome;
pub mod overlays;
pub mod page;
pub mod sessions;
pub mod simulation;
pub mod tables;
