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

// Rooms from the ground up: each uses only those before it. What leaves them stands below.
mod batch;
mod cli;
mod contract;
mod diagnose;
mod estimate;
mod filter;
mod fit;
mod fleet;
mod ingest;
mod motorcycle;
mod pipeline;
mod report;
mod segment;
mod simulate;
mod statistics;
mod store;
mod tyre;

#[cfg(feature = "internals")]
pub mod internals;

// A log, from its bytes to one session on one clean clock.
pub use contract::bike::{Bike, Error as BikeError};
pub use contract::channel::Channel;
pub use contract::session::{Meta, Session};
pub use contract::warning::Warning;
pub use ingest::maps::ChannelMap;
pub use ingest::{
    Config as IngestConfig, Error as IngestError, Identified, Raw, check, identify, map_for, read,
    read_table, run as clean, session_batch, session_bytes, write_session,
};
pub use store::objects::Location;
pub use store::objects::files::read_text;

// From a session to the coefficients of its tyres.
pub use contract::verdict::Verdict;
pub use pipeline::{Input, Outcome, Pipeline, Rejection, run as run_log, run_raw};
pub use segment::laps::Laps;
pub use segment::manoeuvre::ManoeuvreKind;
pub use store::tables::rows::{
    Coefficient, EvidenceRow, ForceRow, Manoeuvre, PlotPoint, SessionRow, WarningRow,
};

// Tyre models.
pub use tyre::{MagicFormula, Stiffness, Tyre};

// Tables: their definitions, and the files they are in.
pub use contract::schema::{Table as TableSchema, closest as closest_name};
pub use store::tables::file::Error as TableError;
pub use store::tables::registry::{schema_files, schema_text};

// Archives: many sessions, here or over many machines.
pub use batch::jobs::bikes::{BikeFile, hash_settings};
pub use batch::jobs::diagnose::{DiagnoseWork, finish as finish_diagnose};
pub use batch::jobs::distributed::{Answer, Driver, Task, Terms, What, Worker};
pub use batch::jobs::in_memory::{
    Log, NO_PATH, Tables, diagnose as diagnose_session, run as run_session,
};
pub use batch::jobs::run::{RunWork, finish as finish_run};
pub use batch::jobs::work::{Work, guarded};
pub use batch::store::folder::Store;
pub use batch::store::reading::Reading;
pub use batch::summary::Summary;
pub use batch::workers::fence::{Asked, Fenced, WORKER, started_by};
pub use batch::workers::scheduler::{Accounts, run as run_batch};
pub use batch::{Error as BatchError, Maps, Settings as BatchSettings};
pub use report::Pages;

// Diagnosis, plans and simulation.
pub use diagnose::road::ride_plan::{RidePlan, plan as plan_ride, scenario as plan_scenario};
pub use diagnose::{Diagnosis, Settings as DiagnosisSettings};
pub use simulate::tables::Rideable;

// Tyres for other programs.
pub use batch::jobs::models::read as read_models;
pub use report::export::written::{
    Format as ExportFormat, Request as ExportRequest, Set as CoefficientSet, Tyre as ExportTyre,
    Written, write as export_tyre,
};

// The program `roadbench`.
pub use cli::{main as command, main_with as command_with};

/// Version written to every row.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;
