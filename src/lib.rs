//! roadbench makes the road the tyre test bench: it reads recorded riding logs and gives back
//! each tyre's model coefficients with confidence intervals.
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
//! Off-road (`estimate/offroad`) the forces come before the segments, by inverse dynamics instead of fits.
//!
//! Data flows one way; a folder is a stage and only `pipeline` knows their order. `tyre` holds the tyre and is
//! used by `simulate`, `estimate` and `fit`. Modules are private: what stands on this page is the interface.
//!
//! # Ways in
//!
//! | what | with |
//! |---|---|
//! | a log as columns on one clean clock | [`read`], [`clean`], [`check`]: a [`Session`] |
//! | the tyres of one log | [`fit_log`]: an [`Outcome`] of rows; [`run_session`]: [`Tables`] in Arrow |
//! | the causes of misfit | [`diagnose_session`] |
//! | an archive | [`run_batch`] with [`RunWork`] or [`DiagnoseWork`], then [`finish_run`] or [`finish_diagnose`] |
//! | many machines | [`Driver`] and [`Worker`] |
//! | a tyre for a simulator | [`export_tyre`] |
//! | rides with known truth | [`Rideable`] |
//! | the definition of a table | [`schema_text`] |
//! | the command line | [`command_with`] |
//!
//! A log, read and cleaned:
//!
//! ```no_run
//! use roadbench::{Channel, IngestConfig, clean, read};
//!
//! let raw = read(std::path::Path::new("ride.csv"), &[])?;
//! let (session, warnings) = clean(raw, &IngestConfig::default())?;
//! let speed = session.get(Channel::VelocityX);
//! println!("{:.0} s, {} warnings, speed: {}", session.duration(), warnings.len(), speed.is_some());
//! # Ok::<(), roadbench::IngestError>(())
//! ```
//!
//! `examples/read_log.rs`, `examples/fit_ride.rs` and `examples/export_tyre.rs` are whole programs; the book explains
//! them (chapter "From Rust").
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
//! use roadbench::Stiffness;
//!
//! let front = Stiffness { ct: -0.84, c1: -0.0279, c3: 0.0 };
//! assert!((front.k_alpha(0.0, 0.095) - 12.5).abs() < 0.1);
//! ```
//!
//! The source is Bartolozzi, Massaro, Mottola, Savino (2024), "An enhanced motorcycle tyre
//! model characterised through experimental riding data"; equation numbers are its own.

#![forbid(unsafe_code)]
#![allow(rustdoc::private_intra_doc_links)] // documentation of the inside is for this project
#![cfg_attr(feature = "internals", deny(unreachable_pub))]
// every item of the interface is described; what only tests and studies reach is where its name does not say enough
#![cfg_attr(feature = "internals", allow(missing_docs))]

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
pub use contract::bike::{Axle, Bike, Error as BikeError};
pub use contract::channel::Channel;
pub use contract::session::{Meta, Session};
pub use contract::warning::Warning;
pub use ingest::checks::check;
pub use ingest::config::Config as IngestConfig;
pub use ingest::error::Error as IngestError;
pub use ingest::formats::table::read_table;
pub use ingest::maps::ChannelMap;
pub use ingest::raw::{Identified, Raw};
pub use ingest::write::{session_batch, session_bytes, write_session};
pub use ingest::{identify, map_for, read, run as clean};
pub use store::objects::files::read_text;
pub use store::objects::location::Location;

// From a session to the coefficients of its tyres.
pub use contract::file_error::FileError;
pub use contract::key_error::KeyError;
pub use contract::rejection::{RejectionCode, Stage};
pub use contract::status::Status;
pub use contract::verdict::Verdict;
pub use pipeline::outcome::{Input, Outcome, Rejection};
pub use pipeline::settings::Pipeline;
pub use pipeline::{fit_log, run as run_log, run_raw};
pub use segment::laps::rows::Laps;
pub use segment::manoeuvre::ManoeuvreKind;
pub use store::tables::ident::Ident;
pub use store::tables::rows::{
    Coefficient, EvidenceRow, ForceRow, Manoeuvre, PlotPoint, SessionRow, WarningRow,
};

// Tyre models.
pub use tyre::magic_formula::MagicFormula;
pub use tyre::paper::{Stiffness, Tyre};

// Tables: their definitions, and the files they are in.
pub use contract::schema::{Table as TableSchema, closest as closest_name};
pub use store::tables::file::Error as TableError;
pub use store::tables::registry::{schema_files, schema_text};

// Sessions in memory, archives on this machine or on many.
pub use batch::error::Error as BatchError;
pub use batch::jobs::bikes::{BikeFile, hash_settings};
pub use batch::jobs::diagnose::{DiagnoseWork, finish as finish_diagnose};
pub use batch::jobs::distributed::{Answer, Driver, Task, Terms, Worker};
pub use batch::jobs::in_memory::{
    Log, NO_PATH, Tables, diagnose as diagnose_session, run as run_session,
};
pub use batch::jobs::job_kind::JobKind;
pub use batch::jobs::pooled::OverAll;
pub use batch::jobs::run::{RunWork, finish as finish_run};
pub use batch::jobs::work::{Work, guarded};
pub use batch::settings::{Maps, Settings as BatchSettings};
pub use batch::store::folder::Store;
pub use batch::store::reading::Reading;
pub use batch::summary::Summary;
pub use batch::workers::fence::limits::LimitOptions;
pub use batch::workers::fence::{Sandboxed, WORKER, started_by};
pub use batch::workers::scheduler::{Accounts, run as run_batch};
pub use report::assets::Pages;

// Two sets of sessions against each other.
pub use batch::fleet::compare::{Chosen, Comparison, compare as compare_sets};
pub use store::tables::rows::ComparisonRow;

// Diagnosis, plans and simulation.
pub use diagnose::diagnosis::Diagnosis;
pub use diagnose::road::ride_plan::{RidePlan, plan as plan_ride};
pub use diagnose::settings::Settings as DiagnosisSettings;
pub use simulate::tables::Rideable;

// Tyres for other programs.
pub use batch::jobs::models::read as read_models;
pub use report::export::error::Error as ExportError;
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
