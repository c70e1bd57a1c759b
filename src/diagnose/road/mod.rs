//! What the model of a road ride gets wrong, and why.
//!
//! ```text
//! session -> samples -> residuals of the nominal model -> base fit -> scan of every effect
//!                                                        |              |
//!                     replay + noise = fault-free simulations -> the same -> calibration -> identification
//! ```
//!
//! The nominal model is the one that [`fit`](crate::fit) characterises, written as eight residuals that
//! vanish when it is right ([`residuals`]): block means of 0.3 s, channel by channel. [`parameters`] are
//! every number that enters them, those of the base and those of the [`effects`](crate::simulate::effects) that the
//! base leaves out. The score that identifies a candidate is not computed but measured: on the same
//! ride, simulated on the nominal model alone, and once a cause is identified on the model that has it
//! ([`null_simulation`]).
//!
//! A misfit without an explanation is searched over the variables of the ride ([`structure`]); what
//! to ride next is computed in [`advice`].

pub(crate) mod advice;
pub(crate) mod around;
pub(crate) mod attitude;
pub(crate) mod base;
pub(crate) mod dive;
pub(crate) mod engine;
pub(crate) mod estimates;
pub(crate) mod extended_model;
pub(crate) mod gram;
pub(crate) mod kept;
pub(crate) mod left_out;
pub(crate) mod null_calibration;
pub(crate) mod null_simulation;
#[cfg(feature = "internals")]
pub(crate) mod oracle;
pub(crate) mod other_machines;
pub(crate) mod parameters;
pub(crate) mod problem;
pub(crate) mod replay;
pub(crate) mod replays;
pub(crate) mod residuals;
pub(crate) mod ride_plan;
pub(crate) mod samples;
pub(crate) mod scan;
pub(crate) mod scatter;
pub(crate) mod sensor_drift;
pub(crate) mod sensors;
pub(crate) mod session;
pub(crate) mod simulation_errors;
pub(crate) mod stage;
pub(crate) mod structure;
pub(crate) mod white_noise;
pub(crate) mod workings;

pub(crate) use session::{Estimated, RoadDiagnosis, diagnose, estimated};
