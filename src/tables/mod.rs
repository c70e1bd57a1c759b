//! Output tables: their rows, how they are encoded as Parquet and written whole, the names of their files.

pub mod file;
pub mod names;
pub mod rows;
