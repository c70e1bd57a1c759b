//! The page of a run: all sessions, and the bikes, each on a page of its own where there are many.

pub(crate) mod bikes;
pub(crate) mod lists;
pub(crate) mod notable;
pub(crate) mod page;
pub(crate) mod small_curves;
pub(crate) mod write;
