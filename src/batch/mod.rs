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

pub(crate) mod discover;
pub(crate) mod error;
pub(crate) mod fleet;
pub(crate) mod jobs;
pub(crate) mod log_hash;
pub(crate) mod plan;
pub(crate) mod settings;
pub(crate) mod store;
pub(crate) mod summary;
pub(crate) mod workers;

pub(crate) use error::Error;
pub(crate) use jobs::work::Work;
pub(crate) use settings::{Maps, Settings};
pub(crate) use workers::watch::{Finished, State, Watch};
