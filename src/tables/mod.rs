//! Output tables: what each is ([`registry`]), its [`rows`], how they are written whole as Parquet
//! ([`mod@file`]) and read back ([`read`], [`by_session`]), the [`names`] of their files, and the rule for paths that a user
//! names ([`mod@output`]).

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
