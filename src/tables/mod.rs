//! Output tables: what each is ([`registry`]), its [`rows`], how they are written whole as Parquet
//! ([`file`]) and read back ([`read`]), and the [`names`] of their files.

pub mod file;
pub mod names;
pub mod read;
pub mod registry;
pub mod rows;
