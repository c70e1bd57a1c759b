//! What the model of a road ride gets wrong, and why.
//!
//! ```text
//! session -> samples -> residuals of the base model -> base fit -> scan of every effect
//!                                                        |              |
//!                     replay + noise = null simulations -> the same -> calibration -> naming
//! ```
//!
//! The base model is the one that [`fit`](crate::fit) characterises, written as eight residuals that
//! vanish when it is right ([`residuals`]): block means of 0.3 s, channel by channel. [`parameters`] are
//! every number that enters them, those of the base and those of the [`effects`](crate::simulate::effects) that the
//! base leaves out. What a candidate must score to be named is not computed but measured: on the same
//! ride, simulated on the base model alone, and once a cause is named on the model that has it
//! ([`null_simulation`]).
//!
//! What is left without an explanation is looked for over the variables of the ride ([`structure`]); what
//! to ride next is computed in [`advice`].

pub mod advice;
pub mod attitude;
pub mod base;
pub mod dive;
pub mod engine;
pub mod extended_model;
pub mod gram;
pub mod kept;
pub mod left_out;
pub mod null_calibration;
pub mod null_simulation;
pub mod oracle;
pub mod other_machines;
pub mod parameters;
pub mod problem;
pub mod replay;
pub mod replays;
pub mod residuals;
pub mod ride_plan;
pub mod samples;
pub mod scan;
pub mod scatter;
pub mod sensor_drift;
pub mod sensors;
pub mod session;
pub mod simulation_errors;
pub mod stage;
pub mod structure;
pub mod white_noise;
pub mod workings;

pub use session::{Fitted, Prepared, RoadDiagnosis, diagnose, fitted, log};
