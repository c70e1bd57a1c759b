//! Output tables: what each is ([`registry`]), its [`rows`], how they are written whole as Parquet
//! ([`mod@file`]) and read back ([`read`], [`by_session`]), and the [`names`] of their files. On their way there they are an
//! [`arrow_stream`].
//!
//! [`mod@output`] has the rule for paths that a user names.

pub(crate) mod arrow_stream;
pub(crate) mod by_session;
pub(crate) mod changes;
mod columns;
pub(crate) mod file;
pub(crate) mod ident;
pub(crate) mod lap_rows;
pub(crate) mod mismatch;
pub(crate) mod names;
pub(crate) mod outlying_rows;
pub(crate) mod output;
pub(crate) mod parameter_rows;
pub(crate) mod read;
pub(crate) mod registry;
pub(crate) mod rows;
