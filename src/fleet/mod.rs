//! Statistics over many sessions of a fleet: what no single session shows.
//!
//! ```text
//! observations -> per bike: history (sessions in order of time x coefficients)
//!                  common   season and site that all bikes share, which are no bike's event
//!                  changes  events: swaps, wrong bike files, drifts, outlying sessions
//!                  levels   each coefficient's level, event by event
//!                  components, drift   spread between sessions, slope, with intervals
//!                  pool     each session's value with its siblings' help
//!                  ratio    the side force ratio, which no session determines
//! evidence     -> combine  one estimate per tyre and motorcycle: shared errors stay, others average out
//!                 tyres    which tyre was on when; each tyre model over the motorcycles
//!                 compare  two sets of sessions: differences, without the errors that both share
//! ```
//!
//! Plain functions over slices; assumes values with standard errors that are honest, and spread
//! between sessions that is near Gaussian once events are taken out. The same observations in any
//! order give the same result.

pub(crate) mod analysis;
pub(crate) mod changes;
pub(crate) mod combine;
pub(crate) mod common;
pub(crate) mod compare;
pub(crate) mod components;
pub(crate) mod drift;
pub(crate) mod events;
pub(crate) mod evidence;
pub(crate) mod history;
pub(crate) mod levels;
pub(crate) mod observation;
pub(crate) mod pool;
pub(crate) mod ratio;
pub(crate) mod scan;
mod slopes;
pub(crate) mod threshold;
pub(crate) mod tyres;

pub(crate) use analysis::{BikeAnalysis, analyse};
pub(crate) use observation::Observation;
