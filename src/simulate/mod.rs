//! Motorcycles whose tyres are known: they make the archives that the estimates are tested on.
//!
//! ```text
//! scenario -> machine (bike file + truth) -> plan -> rider + motorcycle -> sensors -> session
//! tour -> nonlinear motorcycle -> manoeuvres -> pilot + model -> imu, sensors -> session
//! ```
//!
//! The first is the reduced-order motorcycle on the paper's tyre ([`motorcycle`]), for archives
//! of thousands of sessions; the second is the multibody one ([`crate::simulate::multibody`]) on any tyre.
//!
//! Seeded and deterministic: a session depends on the scenario and its own number only.

pub mod bench_points;
pub mod builtin;
pub mod compare;
pub mod effects;
pub mod hidden;
pub mod hidden_offroad;
pub mod imu;
pub mod lateral_bench;
pub mod loggers;
pub mod manoeuvre;
pub mod motocross;
pub mod motorcycle;
pub mod multibody;
pub mod multibody_ride;
pub mod path;
pub mod pilot;
pub mod plan;
pub mod population;
pub mod prescribed;
pub mod preview;
pub mod programme;
pub mod reduced;
pub mod replay;
pub mod ride;
pub mod rider;
pub mod scenario;
pub mod sensors;
pub mod simulated;
pub mod strapdown;
pub mod tables;
pub mod tour;
pub mod track;
pub mod truth;
pub mod tyre_truth;
pub mod unsteady;

pub use reduced::{session, session_with, simulate_phases};
pub use simulated::{Label, Simulated};
