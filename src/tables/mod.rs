//! TODO room

pub mod file;
pub mod names;
pub mod rows;
