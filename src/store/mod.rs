//! Where bytes and rows lie: files and objects, and the tables in them.

pub(crate) mod objects;
pub(crate) mod tables;
