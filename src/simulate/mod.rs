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

pub(crate) mod bench_points;
pub(crate) mod builtin;
pub(crate) mod compare;
pub(crate) mod conditions;
pub(crate) mod effects;
pub(crate) mod error;
#[cfg(feature = "internals")]
pub(crate) mod hidden;
#[cfg(feature = "internals")]
pub(crate) mod hidden_offroad;
pub(crate) mod imu;
pub(crate) mod lateral_bench;
pub(crate) mod loggers;
pub(crate) mod manoeuvre;
pub(crate) mod motocross;
pub(crate) mod motorcycle;
pub(crate) mod multibody;
pub(crate) mod multibody_ride;
pub(crate) mod odd_manoeuvre;
pub(crate) mod path;
pub(crate) mod pilot;
pub(crate) mod plan;
pub(crate) mod population;
#[cfg(feature = "internals")]
pub(crate) mod prescribed;
pub(crate) mod preview;
pub(crate) mod programme;
pub(crate) mod reduced;
pub(crate) mod replay;
pub(crate) mod ride;
pub(crate) mod rider;
pub(crate) mod scenario;
pub(crate) mod sensors;
pub(crate) mod simulated;
#[cfg(feature = "internals")]
pub(crate) mod strapdown;
pub(crate) mod swing;
pub(crate) mod tables;
pub(crate) mod tour;
pub(crate) mod track;
pub(crate) mod transients;
pub(crate) mod truth;
pub(crate) mod tyre_truth;
pub(crate) mod unsteady;
pub(crate) mod wheel_sensors;

pub(crate) use reduced::{session, simulate_phases};
pub(crate) use simulated::Label;
