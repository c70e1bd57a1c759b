//! Many sessions: discovery, parallel work, whole files.
//!
//! ```text
//! inputs -> discover -> plan -> engine (a session per worker) -> store -> fleet, pooling, report
//!            files      who, bike,      Work::run                files
//!                       duplicates
//! ```
//!
//! What is done with each session is a [`work::Work`]: [`run`] characterises tyres, [`diagnose`] looks
//! for the causes of misfit; all else is shared. [`distributed`] is `run` over many machines,
//! [`in_memory`] one session without files.
//!
//! Assumes nothing of the inputs. Every one of them ends as a session in the tables or as a row
//! of `rejected`: *sessions in = sessions out + rejected*, checked at the end of every batch.
//!
//! A batch may be stopped at any time, gently or not: only whole files are left, and the same
//! command carries on with the sessions that are not there yet. A session is there when its commit
//! marker names the same input, the same settings and the same roadbench (see [`store`]). The files'
//! bytes depend on inputs and settings only, not on the number of workers, the time or the machine's
//! load.

pub mod bikes;
pub mod blame;
pub mod contents;
pub mod diagnose;
pub mod discover;
#[cfg(feature = "fleet")]
pub mod dispersion;
pub mod distributed;
mod empty;
pub mod engine;
pub mod error;
pub mod fence;
#[cfg(feature = "fleet")]
pub mod fleet;
pub mod fleet_rows;
pub mod forget;
pub mod in_memory;
pub mod in_order;
pub mod kind;
pub mod local_copy;
pub mod lock;
pub mod log_hash;
pub mod manifest;
pub mod mark;
pub mod marker;
pub mod merge;
pub mod migrate;
pub mod models;
pub mod parts;
pub mod plan;
mod pooled;
pub mod progress;
pub mod reading;
pub mod run;
pub mod session;
pub mod settings;
mod settle;
pub mod staged;
pub mod store;
pub mod summary;
pub mod switch;
pub mod threads;
#[cfg(feature = "fleet")]
mod tyres;
pub mod verify;
pub mod watch;
pub mod what;
pub mod work;

pub use engine::{Accounts, Intended};
pub use error::Error;
pub use settings::{Maps, Settings};
pub use watch::{Finished, State, Watch};
pub use work::Work;
