//! Output tables: what each is ([`registry`]), its [`rows`], how they are written whole as Parquet
//! ([`mod@file`]) and read back ([`read`], [`by_session`]), and the [`names`] of their files.
//!
//! [`mod@output`] has the rule for paths that a user names.

pub mod by_session;
mod columns;
pub mod file;
mod ident;
mod lap_rows;
pub mod names;
pub mod output;
pub mod read;
pub mod registry;
pub mod rows;
