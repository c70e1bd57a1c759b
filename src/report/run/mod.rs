//! The page of a run: all sessions, and the bikes, each on a page of its own where there are many.

pub mod bikes;
pub mod lists;
pub mod notable;
pub mod page;
pub(crate) mod write;
