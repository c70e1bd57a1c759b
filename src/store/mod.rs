//! Where bytes and rows lie: files and objects, and the tables in them.

pub mod objects;
pub mod tables;
