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
#![cfg_attr(feature = "internals", deny(unreachable_pub))]

// Rooms from the ground up: each uses only those before it.
mod contract;

mod store;

mod statistics;

mod tyre;

mod motorcycle;

mod filter;

mod ingest;

mod segment;

mod estimate;

mod fit;

mod simulate;

mod report;

mod fleet;

mod pipeline;

mod diagnose;

mod batch;

mod cli;

#[cfg(feature = "internals")]
pub mod internals;

// A log, from its bytes to one session on one clean clock.
pub use contract::bike::Bike;
pub use contract::bike::Error as BikeError;
pub use contract::channel::Channel;
pub use contract::session::Meta;
pub use contract::session::Session;
pub use contract::warning::Warning;
pub use ingest::checks::check;
pub use ingest::config::Config as IngestConfig;
pub use ingest::error::Error as IngestError;
pub use ingest::formats::table::read_table;
pub use ingest::identify;
pub use ingest::map_for;
pub use ingest::maps::ChannelMap;
pub use ingest::raw::Identified;
pub use ingest::raw::Raw;
pub use ingest::read;
pub use ingest::run as clean;
pub use ingest::write::session_batch;
pub use ingest::write::session_bytes;
pub use ingest::write::write_session;
pub use store::objects::files::read_text;
pub use store::objects::location::Location;

// From a session to the coefficients of its tyres.
pub use contract::verdict::Verdict;
pub use pipeline::outcome::Input;
pub use pipeline::outcome::Outcome;
pub use pipeline::outcome::Rejection;
pub use pipeline::run as run_log;
pub use pipeline::run_raw;
pub use pipeline::settings::Pipeline;
pub use segment::laps::rows::Laps;
pub use segment::manoeuvre::ManoeuvreKind;
pub use store::tables::rows::Coefficient;
pub use store::tables::rows::EvidenceRow;
pub use store::tables::rows::ForceRow;
pub use store::tables::rows::Manoeuvre;
pub use store::tables::rows::PlotPoint;
pub use store::tables::rows::SessionRow;
pub use store::tables::rows::WarningRow;

// Tyre models.
pub use tyre::magic_formula::MagicFormula;
pub use tyre::tyre::Stiffness;
pub use tyre::tyre::Tyre;

// Tables: their definitions, and the files they are in.
pub use contract::schema::Table as TableSchema;
pub use contract::schema::closest as closest_name;
pub use store::tables::file::Error as TableError;
pub use store::tables::registry::schema_files;
pub use store::tables::registry::schema_text;

// Archives: many sessions, here or over many machines.
pub use batch::error::Error as BatchError;
pub use batch::jobs::bikes::BikeFile;
pub use batch::jobs::bikes::hash_settings;
pub use batch::jobs::diagnose::DiagnoseWork;
pub use batch::jobs::diagnose::finish as finish_diagnose;
pub use batch::jobs::distributed::Answer;
pub use batch::jobs::distributed::Driver;
pub use batch::jobs::distributed::Task;
pub use batch::jobs::distributed::Terms;
pub use batch::jobs::distributed::Worker;
pub use batch::jobs::in_memory::Log;
pub use batch::jobs::in_memory::NO_PATH;
pub use batch::jobs::in_memory::Tables;
pub use batch::jobs::in_memory::diagnose as diagnose_session;
pub use batch::jobs::in_memory::run as run_session;
pub use batch::jobs::run::RunWork;
pub use batch::jobs::run::finish as finish_run;
pub use batch::jobs::what::What;
pub use batch::jobs::work::Work;
pub use batch::jobs::work::guarded;
pub use batch::settings::Maps;
pub use batch::settings::Settings as BatchSettings;
pub use batch::store::folder::Store;
pub use batch::store::reading::Reading;
pub use batch::summary::Summary;
pub use batch::workers::fence::Fenced;
pub use batch::workers::fence::WORKER;
pub use batch::workers::fence::limits::Asked;
pub use batch::workers::fence::started_by;
pub use batch::workers::scheduler::Accounts;
pub use batch::workers::scheduler::run as run_batch;
pub use report::assets::Pages;

// Diagnosis, plans and simulation.
pub use diagnose::diagnosis::Diagnosis;
pub use diagnose::road::ride_plan::RidePlan;
pub use diagnose::road::ride_plan::plan as plan_ride;
pub use diagnose::road::ride_plan::scenario as plan_scenario;
pub use diagnose::settings::Settings as DiagnosisSettings;
pub use simulate::tables::Rideable;

// Tyres for other programs.
pub use batch::jobs::models::read as read_models;
pub use report::export::written::Format as ExportFormat;
pub use report::export::written::Request as ExportRequest;
pub use report::export::written::Set as CoefficientSet;
pub use report::export::written::Tyre as ExportTyre;
pub use report::export::written::Written;
pub use report::export::written::write as export_tyre;

// The program `roadbench`.
pub use cli::main as command;
pub use cli::main_with as command_with;

/// Version written to every row.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Standard gravity, m/s².
pub const GRAVITY: f64 = 9.80665;
