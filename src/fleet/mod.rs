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
//! ```
//!
//! Plain functions over slices; assumes values with standard errors that are honest, and spread
//! between sessions that is near Gaussian once events are taken out. The same observations in any
//! order give the same result.

pub mod analysis;
pub mod changes;
pub mod combine;
pub mod common;
pub mod components;
pub mod drift;
pub mod events;
pub mod evidence;
pub mod history;
pub mod levels;
pub mod observation;
pub mod pool;
pub mod ratio;
pub mod scan;
mod slopes;
pub mod threshold;
pub mod tyres;

pub use analysis::{BikeAnalysis, Series, analyse};
pub use observation::Observation;
