//! What every stage relies on: the channels of a session, the session itself, the bike file, the
//! coefficients, verdicts, warnings, and the schemas of tables and files as declared in
//! `schemas/`.

pub(crate) mod bike;
pub(crate) mod channel;
pub(crate) mod coefficient;
pub(crate) mod error_source;
pub(crate) mod file_error;
pub(crate) mod file_kind;
pub(crate) mod fleet_event;
pub(crate) mod geodesy;
pub(crate) mod instant;
pub(crate) mod key_error;
pub(crate) mod reason;
pub(crate) mod rejection;
pub(crate) mod residual_channel;
pub(crate) mod schema;
pub(crate) mod sentence_error;
pub(crate) mod session;
pub(crate) mod status;
pub(crate) mod verdict;
pub(crate) mod warning;
