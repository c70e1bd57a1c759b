//! What every stage relies on: the channels of a session, the session itself, the bike file, the
//! coefficients, verdicts, warnings, and the schemas of tables and files as declared in
//! `schemas/`.

pub mod bike;
pub mod channel;
pub mod coefficient;
pub mod error_source;
pub mod file_kind;
pub mod fleet_event;
pub mod instant;
pub mod reason;
pub mod residual_channel;
pub mod schema;
pub mod session;
pub mod status;
pub mod verdict;
pub mod warning;
