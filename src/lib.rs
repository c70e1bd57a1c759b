//! roadbench makes the road the tyre test bench: it reads recorded riding logs and gives back
//! each tyre's model coefficients with honest uncertainty.
//!
//! ```text
//!            pipelines/*.toml
//!                   |
//! log -> ingest -> filter -> segment -> estimate -> fit -> tables -> report
//!         Session   Session   Segments   Signals    Coefficients
//!            ^
//! simulate --+  (a motorcycle whose tyres are known, through the same door)
//! ```
//!
//! Off-road ([`estimate::offroad`]) the forces come before the segments, by inverse dynamics instead
//! of fits.
//!
//! Data flows one way; a folder is a stage and only [`pipeline`] knows their order.
//! [`model`] holds the tyre and is used by `simulate`, `estimate` and `fit`.
//!
//! # Frames and signs
//!
//! ISO 8855 everywhere: x forward, y left, z up in the *level* frame that turns with the
//! heading. SI units, angles in radians. In a left-hand corner roll and camber are negative,
//! lateral force and yaw rate positive; a slip angle is positive anticlockwise seen from above.
//!
//! # Symbols
//!
//! | symbol | name in the tables | unit | positive when |
//! |---|---|---|---|
//! | `R_rol` | `effective_rolling_radius` | m | |
//! | `s` | slip ratio | 1 | driving |
//! | `alpha` | slip angle | rad | wheel plane to velocity, anticlockwise |
//! | `gamma` | camber | rad | leaning right |
//! | `phi` | roll | rad | leaning right |
//! | `mu_x`, `mu_y` | engaged friction `Fx/Fz`, `Fy/Fz` | 1 | forward, left |
//! | `k_alpha`, `k_gamma` | cornering, camber stiffness per load | 1/rad | |
//! | `C` | `side_force_ratio` `k_gamma / k_alpha` | 1 | |
//! | `k_x` | `overturning_stiffness` | m | always |
//! | `k_t` | `twisting_stiffness` | m/rad | always |
//!
//! # Example
//!
//! The paper's front tyre, upright: `k_alpha0 = -ct / (c1 + C)`.
//!
//! ```
//! use roadbench::tyre::Stiffness;
//!
//! let front = Stiffness { ct: -0.84, c1: -0.0279, c3: 0.0 };
//! assert!((front.k_alpha(0.0, 0.095) - 12.5).abs() < 0.1);
//! ```
//!
//! The source is Bartolozzi, Massaro, Mottola, Savino (2024), "An enhanced motorcycle tyre
//! model characterised through experimental riding data"; equation numbers are its own.

#![forbid(unsafe_code)]

// from the ground up: each uses only those above it in this list
pub mod contract;

pub mod store;

pub mod statistics;

pub mod tyre;

pub mod motorcycle;

pub mod filter;

pub mod ingest;

pub mod segment;

pub mod estimate;

pub mod fit;

pub mod simulate;

pub mod report;

pub mod fleet;

pub mod pipeline;

pub mod diagnose;

pub mod batch;

pub mod cli;

/// Version written to every row.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;
