//! The charts of the pages and of the static figures.

pub mod chart;
pub mod figures;
pub mod pack;
pub mod resolution;
