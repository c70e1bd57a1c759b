//! The page of a run: all sessions, by bike.

pub mod page;
