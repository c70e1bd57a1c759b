//! The page over all sessions.

pub mod comparison;
pub mod event_kind;
pub mod history;
pub mod lists;
pub mod page;
pub mod ratios;
pub mod tables;
pub mod tyres;
pub mod write;
