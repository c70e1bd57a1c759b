//! The charts of the pages and of the static figures.

pub mod catalogue;
pub mod chart;
pub mod pack;
