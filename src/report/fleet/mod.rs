//! The page over all sessions.

pub mod page;
pub mod ratios;
pub mod tables;
pub mod write;
