//! The page of one session.

pub mod bench;
pub mod forces;
pub mod page;
pub mod write;
