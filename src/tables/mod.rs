//! Output tables: their rows, how they are encoded as Parquet and written whole, how they are read
//! back, the names of their files.

pub mod file;
pub mod names;
pub mod read;
pub mod rows;
