//! The charts of the pages and of the static figures.

pub(crate) mod chart;
pub(crate) mod figures;
pub(crate) mod pack;
pub(crate) mod resolution;
mod ridden;
