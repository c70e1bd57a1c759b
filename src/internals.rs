//! What this project's own tests, benches and studies use beyond the library's interface: one list, behind the
//! feature `internals`. Nothing in it is promised to stay.

#![allow(missing_docs)]

pub use crate::{GRAVITY, VERSION};

pub mod batch {
    pub use crate::batch::error::Error;
    pub use crate::batch::jobs::work::Work;
    pub use crate::batch::settings::{Maps, Settings};
    pub use crate::batch::workers::scheduler::Accounts;
    pub use crate::batch::workers::watch::{Finished, State, Watch};
    pub mod fleet {
        pub mod compare {
            pub use crate::batch::fleet::compare::{Comparison, compare};
        }
        pub mod tables {
            pub use crate::batch::fleet::tables::write;
        }
    }
    pub mod jobs {
        pub mod bikes {
            pub use crate::batch::jobs::bikes::{BikeFile, hash_settings};
        }
        pub mod distributed {
            pub use crate::batch::jobs::distributed::{Answer, Driver, Task, Terms, Worker};
            pub use crate::batch::jobs::job_kind::JobKind;
        }
        pub mod in_memory {
            pub use crate::batch::jobs::in_memory::{Log, run};
        }
        pub mod run {
            pub use crate::batch::jobs::run::{RunWork, finish, output};
        }
        pub mod work {
            pub use crate::batch::jobs::work::{Output, SessionFile};
        }
    }
    pub mod store {
        pub mod contents {
            pub use crate::batch::store::contents::Contents;
        }
        pub mod folder {
            pub use crate::batch::store::folder::Store;
        }
        pub mod forget {
            pub use crate::batch::store::forget::{Selection, forget};
        }
        pub mod kind {
            pub use crate::batch::store::kind::{DIAGNOSE, Kind, RUN};
        }
        pub mod mark {
            pub use crate::batch::store::mark::is_output;
        }
        pub mod marker {
            pub use crate::batch::store::marker::Key;
        }
        pub mod reading {
            pub use crate::batch::store::reading::Reading;
        }
        pub mod verify {
            pub use crate::batch::store::verify::{FindingKind, mend, verify};
        }
    }
    pub mod workers {
        pub mod scheduler {
            pub use crate::batch::workers::scheduler::{dry_run, run};
        }
    }
}
pub mod cli {
    pub use crate::cli::command;
}
pub mod contract {
    pub mod geodesy {
        pub use crate::contract::geodesy::metres_per_degree;
    }
    pub mod bike {
        pub use crate::contract::bike::{Axle, Bike, schema};
    }
    pub mod channel {
        pub use crate::contract::channel::Channel;
    }
    pub mod coefficient {
        pub use crate::contract::coefficient::{
            Coefficient, Id, Part, Source, Values, shows_coasting,
        };
    }
    pub mod file_kind {
        pub use crate::contract::file_kind::FileKind;
    }
    pub mod fleet_event {
        pub use crate::contract::fleet_event::{Affected, EventKind};
    }
    pub mod instant {
        pub use crate::contract::instant::parse;
    }
    pub mod reason {
        pub use crate::contract::reason::ReasonCode;
    }
    pub mod rejection {
        pub use crate::contract::rejection::{RejectionCode, Stage};
    }
    pub mod residual_channel {
        pub use crate::contract::residual_channel::ResidualChannel;
    }
    pub mod schema {
        pub use crate::contract::schema::{Column, Key, KeyTable, Table};
    }
    pub mod session {
        pub use crate::contract::session::{Markers, Meta, Session};
    }
    pub mod status {
        pub use crate::contract::status::Status;
    }
    pub mod verdict {
        pub use crate::contract::verdict::{UNEXPLAINED, Verdict};
    }
    pub mod warning {
        pub use crate::contract::warning::Warning;
    }
}
pub mod diagnose {
    pub use crate::diagnose::settings::Settings;
    pub mod calibration {
        pub use crate::diagnose::calibration::rms;
    }
    pub mod cause {
        pub use crate::diagnose::cause::{Cause, Identification, Objection, Refusal};
    }
    pub mod levels {
        pub use crate::diagnose::levels::{Member, Pooling};
    }
    pub mod offroad {
        pub use crate::diagnose::offroad::session::{OffroadDiagnosis, diagnose, log};
    }
    pub mod reference {
        pub use crate::diagnose::reference::numbers::Ride;
        pub use crate::diagnose::reference::{changes, clearness};
    }
    pub mod road {
        pub use crate::diagnose::road::session::{
            Fitted, Prepared, RoadDiagnosis, diagnose, fitted, log,
        };
        pub mod advice {
            pub use crate::diagnose::road::advice::ranking::{ALIKE, Advice, known};
            pub mod sets {
                pub use crate::diagnose::road::advice::sets::{SETS, after, leaning};
            }
        }
        pub mod attitude {
            pub use crate::diagnose::road::attitude::{Attitude, Posture};
        }
        pub mod base {
            pub use crate::diagnose::road::base::{Base, fit, fit_with, noise};
        }
        pub mod estimates {
            pub use crate::diagnose::road::estimates::{Nominal, estimates};
        }
        pub mod null_calibration {
            pub use crate::diagnose::road::null_calibration::{calibrate, cells};
        }
        pub mod null_simulation {
            pub use crate::diagnose::road::null_simulation::NullSimulation;
        }
        pub mod oracle {
            pub use crate::diagnose::road::oracle::errors_with_the_truth;
        }
        pub mod other_machines {
            pub use crate::diagnose::road::other_machines::shown;
        }
        pub mod parameters {
            pub use crate::diagnose::road::parameters::{BASE, Parameter, Parameters, Place};
        }
        pub mod problem {
            pub use crate::diagnose::road::problem::Problem;
        }
        pub mod replay {
            pub use crate::diagnose::road::replay::{From, replay};
        }
        pub mod residuals {
            pub use crate::diagnose::road::residuals::{Blocks, CHANNELS, blocks};
        }
        pub mod samples {
            pub use crate::diagnose::road::samples::{Samples, picks};
        }
        pub mod scan {
            pub use crate::diagnose::road::scan::scan;
        }
        pub mod sensors {
            pub use crate::diagnose::road::sensors::{as_recorded, as_ridden};
        }
        pub mod structure {
            pub use crate::diagnose::road::structure::terms;
        }
        pub mod workings {
            pub use crate::diagnose::road::workings::LinearisationCache;
        }
    }
    pub mod summary {
        pub use crate::diagnose::summary::session;
    }
    pub mod tuning {
        pub use crate::diagnose::tuning::{
            OFFROAD, OffroadTuning, ROAD, RoadTuning, reference, row,
        };
    }
}
pub mod estimate {
    pub use crate::estimate::Config;
    pub mod offroad {
        pub use crate::estimate::offroad::{Config, Estimate, run};
        pub mod contact {
            pub use crate::estimate::offroad::contact::Contact;
        }
        pub mod kinematics {
            pub use crate::estimate::offroad::kinematics::Kinematics;
        }
        pub mod nnls {
            pub use crate::estimate::offroad::nnls::solve;
        }
        pub mod rider {
            pub use crate::estimate::offroad::rider::forces;
            pub use crate::estimate::offroad::rider::types::{Base, Config, Rider};
            pub mod a {
                pub use crate::estimate::offroad::rider::a::{Instant, Standing};
            }
            pub mod b {
                pub use crate::estimate::offroad::rider::b::force;
            }
            pub mod c {
                pub use crate::estimate::offroad::rider::c::{Biquad, butterworth};
            }
        }
        pub mod solve {
            pub use crate::estimate::offroad::solve::{
                BRAKING, Config, DRIVING, RowWeights, Solver,
            };
        }
        pub mod weights {
            pub use crate::estimate::offroad::weights::Weights;
        }
    }
    pub mod signals {
        pub use crate::estimate::signals::Inputs;
    }
    pub mod zeros {
        pub use crate::estimate::zeros::{Zeros, run};
    }
}
pub mod filter {
    pub use crate::filter::band::high_cut;
    pub use crate::filter::{Config, run};
}
pub mod fit {
    pub use crate::fit::config::Config;
    pub use crate::fit::data::Data;
    pub use crate::fit::solution::Solution;
    pub mod chain {
        pub use crate::fit::chain::solve;
    }
    pub mod coasting {
        pub use crate::fit::coasting::{Coasting, fit};
    }
    pub mod coefficients {
        pub use crate::fit::coefficients::rows;
    }
    pub mod cornering {
        pub use crate::fit::cornering::{Parameters, fit, fit_overturning};
    }
    pub mod friction {
        pub use crate::fit::friction::{Rows, fit, is_of_curve};
    }
    pub mod in_gear {
        pub use crate::fit::in_gear::config::Config;
        pub use crate::fit::in_gear::{InGear, run};
        pub mod by_lap {
            pub use crate::fit::in_gear::by_lap::{ByLap, OfLap, run};
        }
        pub mod columns {
            pub use crate::fit::in_gear::columns::columns;
        }
        pub mod lap_rows {
            pub use crate::fit::in_gear::lap_rows::rows;
        }
        pub mod model {
            pub use crate::fit::in_gear::model::{A, B, C, D, Held, Model, Split};
        }
        pub mod parameters {
            pub use crate::fit::in_gear::parameters::*;
        }
        pub mod rows {
            pub use crate::fit::in_gear::rows::{fill, lacking};
        }
        pub mod solve {
            pub use crate::fit::in_gear::solve::held_at;
        }
    }
    pub mod outlying {
        pub use crate::fit::outlying::comparison::Compared;
        pub use crate::fit::outlying::quantity::{Fitted, Outlying};
        pub use crate::fit::outlying::{comparisons, find};
    }
    pub mod refit {
        pub use crate::fit::refit::{MOST_CORNER, Refit};
    }
    pub mod transients {
        pub use crate::fit::transients::join::law;
        pub use crate::fit::transients::parameters::{OF_TYRE, QUANTITIES};
        pub use crate::fit::transients::{Config, Fitted, Transients, run};
    }
    pub mod variation {
        pub use crate::fit::variation::variations;
    }
}
pub mod fleet {
    pub use crate::fleet::analysis::{BikeAnalysis, analyse};
    pub use crate::fleet::observation::Observation;
    pub mod compare {
        pub use crate::fleet::compare::{Compared, Difference, Session, Verdict, compare};
    }
    pub mod events {
        pub use crate::fleet::events::{Event, Moved};
    }
    pub mod evidence {
        pub use crate::fleet::evidence::Piece;
    }
    pub mod history {
        pub use crate::fleet::history::History;
    }
    pub mod ratio {
        pub use crate::fleet::ratio::{Ratio, ratios};
    }
    pub mod scan {
        pub use crate::fleet::scan::Shape;
    }
    pub mod tyres {
        pub use crate::fleet::tyres::{BikeTyres, models, of_bike};
    }
}
pub mod ingest {
    pub use crate::ingest::checks::check;
    pub use crate::ingest::checks::switches::{CHECKS, Check};
    pub use crate::ingest::config::Config;
    pub use crate::ingest::error::Error;
    pub use crate::ingest::formats::detect::format_of;
    pub use crate::ingest::raw::{Identified, Raw, Track};
    pub use crate::ingest::write::write_session;
    pub use crate::ingest::{identify, map_for, read, run};
    pub mod checks {
        pub mod aids {
            pub use crate::ingest::checks::aids::Aids;
        }
        pub mod judge {
            pub use crate::ingest::checks::judge::{by_motion, draft};
        }
    }
    pub mod formats {
        pub use crate::ingest::formats::FORMATS;
        pub mod listing {
            pub use crate::ingest::formats::listing::Listing;
        }
        pub mod survey {
            pub use crate::ingest::formats::survey::survey;
        }
    }
    pub mod maps {
        pub use crate::ingest::maps::{ChannelMap, Entry};
        pub mod file {
            pub use crate::ingest::maps::file::{shipped, with_aids};
        }
        pub mod propose {
            pub mod compare {
                pub use crate::ingest::maps::propose::compare::{compare, mend};
                pub use crate::ingest::maps::propose::finding::FindingKind;
            }
            pub mod physics {
                pub use crate::ingest::maps::propose::physics::verdict::{Verdict, Verdicts};
            }
        }
        pub mod units {
            pub use crate::ingest::maps::units::same;
        }
    }
    pub mod motion {
        pub mod navigation {
            pub use crate::ingest::motion::navigation::level::OUTPUTS;
            pub use crate::ingest::motion::navigation::log::Log;
            pub use crate::ingest::motion::navigation::output::NAMES;
            pub use crate::ingest::motion::navigation::run::{Navigation, run};
        }
        pub mod yaw {
            pub use crate::ingest::motion::yaw::trace_angle;
        }
    }
}
pub mod motorcycle {
    pub mod catalogue {
        pub use crate::motorcycle::catalogue::classes::Catalogue;
        pub use crate::motorcycle::catalogue::owner::Owner;
        pub mod file {
            pub use crate::motorcycle::catalogue::file::text;
        }
    }
    pub mod offroad {
        pub mod body {
            pub use crate::motorcycle::offroad::body::Body;
        }
        pub mod chain {
            pub use crate::motorcycle::offroad::chain::{Chain, Run, lever};
        }
        pub mod equations {
            pub use crate::motorcycle::offroad::equations::{Equations, Motion, RigidBodies};
        }
        pub mod planar {
            pub use crate::motorcycle::offroad::planar::PlanarMotorcycle;
        }
    }
}
pub mod pipeline {
    pub use crate::pipeline::outcome::{Input, Outcome, Rejection};
    pub mod predicted {
        pub use crate::pipeline::predicted::{Planned, Predicted, predict};
    }
    pub use crate::pipeline::settings::{BUILTIN, Pipeline};
    pub use crate::pipeline::stages::{Characterised, characterise, prepare};
    pub use crate::pipeline::{run, run_raw};
}
pub mod report {
    pub use crate::report::assets::Pages;
    pub use crate::report::build::{build, update, write};
    pub use crate::report::error::Error;
    pub use crate::report::open::open;
    pub mod diagnosis {
        pub mod outcome {
            pub use crate::report::diagnosis::outcome::{Outcome, outcome};
        }
        pub mod page {
            pub use crate::report::diagnosis::page::build;
        }
    }
    pub mod export {
        pub mod check {
            pub use crate::report::export::check::largest_errors;
        }
        pub mod effects {
            pub use crate::report::export::effects::{Place, lines};
        }
        pub mod ends {
            pub use crate::report::export::ends::Ends;
        }
        pub mod fitted {
            pub use crate::report::export::fitted::Fitted;
        }
        pub mod grid {
            pub use crate::report::export::grid::longitudinal;
        }
        pub mod motorcycle {
            pub use crate::report::export::motorcycle::write;
        }
        pub mod parameters {
            pub use crate::report::export::row_tyre::tyre;
        }
        pub mod reduced {
            pub use crate::report::export::reduced::write;
        }
        pub mod tyre {
            pub use crate::report::export::tyre::{Characterised, Setting};
        }
        pub mod written {
            pub use crate::report::export::written::{Format, Request, Set, Tyre, Written, write};
        }
    }
    pub mod labels {
        pub use crate::report::labels::riding;
    }
    pub mod page_names {
        pub use crate::report::page_names::sessions;
    }
    pub mod plots {
        pub mod catalogue {
            pub use crate::report::plots::catalogue::FITS;
        }
        pub mod road {
            pub use crate::report::plots::road::rows;
        }
    }
    pub mod static_figures {
        pub mod write {
            pub use crate::report::static_figures::write::{Format, figures};
        }
    }
    pub mod summary {
        pub use crate::report::summary::markdown;
    }
    pub mod tables {
        pub use crate::report::tables::{coefficients, rejected, sessions, warnings};
    }
    pub mod terminal {
        pub use crate::report::terminal::{batch_summary, summary};
    }
}
pub mod segment {
    pub use crate::segment::manoeuvre::Config;
    pub use crate::segment::run;
    pub use crate::segment::segments::Segment;
    pub mod laps {
        pub use crate::segment::laps::config::Config;
        pub use crate::segment::laps::{detect, look};
        pub mod find {
            pub use crate::segment::laps::find::{DetectedLaps, Kind};
        }
    }
    pub mod manoeuvre {
        pub use crate::segment::manoeuvre::ManoeuvreKind;
        pub use crate::segment::manoeuvre::declaration::{Course, Direction, Terrain};
    }
    pub mod offroad {
        pub use crate::segment::manoeuvre::means::Ride;
        pub use crate::segment::offroad::run;
    }
}
pub mod simulate {
    pub use crate::simulate::reduced::{session, session_with, simulate_phases};
    pub use crate::simulate::simulated::Simulated;
    pub mod builtin {
        pub use crate::simulate::builtin::names;
    }
    pub mod compare {
        pub use crate::simulate::compare::peaks;
    }
    pub mod effects {
        pub use crate::simulate::effects::{ALL, Effect, ModelError};
        pub mod extended_model {
            pub use crate::simulate::effects::extended_model::{Estimate, ExtendedModel};
        }
        pub mod extended_tyre {
            pub use crate::simulate::effects::extended_tyre::ExtendedTyre;
        }
        pub mod models {
            pub use crate::simulate::effects::models::Models;
        }
        pub mod physics {
            pub use crate::simulate::effects::physics::{Multibody, Reach};
        }
        pub mod remove {
            pub use crate::simulate::effects::remove::remove;
        }
        pub mod tyre_file {
            pub use crate::simulate::effects::tyre_file::{extended, load, parse};
        }
    }
    pub mod hidden {
        pub use crate::simulate::hidden::{Case, Kind, PLANS, TRANSIENT_PLANS, plan_named};
    }
    pub mod hidden_offroad {
        pub use crate::simulate::hidden_offroad::{Hidden, OffroadCase};
    }
    pub mod imu {
        pub use crate::simulate::imu::{Attitude, Imu, Motion, Satellite, Triad, measure};
    }
    pub mod loggers {
        pub use crate::simulate::loggers::board::Foreign;
        pub use crate::simulate::loggers::profile::Profile;
        pub use crate::simulate::loggers::write;
    }
    pub mod manoeuvre {
        pub use crate::simulate::manoeuvre::{Braked, Manoeuvre};
    }
    pub mod motocross {
        pub use crate::simulate::motocross::{MotocrossRide, ride};
        pub mod machine {
            pub use crate::simulate::motocross::machine::{ForwardModel, Levers, Touching};
        }
        pub mod pilot {
            pub use crate::simulate::motocross::pilot::{Decision, decide};
        }
        pub mod scenario {
            pub use crate::simulate::motocross::scenario::{BUILTIN, Motocross};
        }
    }
    pub mod motorcycle {
        pub use crate::simulate::motorcycle::plant::Plant;
    }
    pub mod multibody {
        pub use crate::simulate::multibody::description::Motorcycle;
        pub use crate::simulate::multibody::model::{Model, Scratch};
        pub use crate::simulate::multibody::road::Road;
        pub use crate::simulate::multibody::state::{Action, State, joint};
        pub mod bodies {
            pub use crate::simulate::multibody::bodies::spatial::Motion;
        }
        pub mod modes {
            pub use crate::simulate::multibody::modes::{eigenvalues, linearise};
        }
        pub mod road {
            pub use crate::simulate::multibody::road::Patch;
        }
        pub mod rolling {
            pub use crate::simulate::multibody::rolling::{compatible, linearise, rates, steady};
        }
        pub mod run {
            pub use crate::simulate::multibody::run::Run;
        }
        pub mod trim {
            pub use crate::simulate::multibody::trim::steady;
        }
    }
    pub mod multibody_ride {
        pub use crate::simulate::multibody_ride::{motorcycle, ridden, session, tour};
    }
    pub mod pilot {
        pub use crate::simulate::pilot::Skill;
    }
    pub mod plan {
        pub use crate::simulate::plan::{Phase, Plan, PlanKind};
    }
    pub mod odd_manoeuvre {
        pub use crate::simulate::odd_manoeuvre::{OddKind, OddManoeuvre};
    }
    pub mod population {
        pub use crate::simulate::population::machine::DrawnMachine;
        pub mod bike {
            pub use crate::simulate::population::bike::{BikeFile, bike};
        }
        pub mod ride {
            pub use crate::simulate::population::ride::{Ridden, case, ride, write};
        }
    }
    pub mod prescribed {
        pub use crate::simulate::prescribed::Prescribed;
    }
    pub mod reduced {
        pub use crate::simulate::reduced::session;
    }
    pub mod replay {
        pub use crate::simulate::replay::{braking, steering};
    }
    pub mod ride {
        pub use crate::simulate::ride::{MultibodyRide, Sample, period, ride};
    }
    pub mod rider {
        pub use crate::simulate::rider::Disturbance;
    }
    pub mod scenario {
        pub use crate::simulate::scenario::{BUILTIN, Machine, Scenario};
    }
    pub mod sensors {
        pub use crate::simulate::sensors::{Sensor, Sensors, clamp_physical, measure};
    }
    pub mod strapdown {
        pub use crate::simulate::strapdown::{Axes, Receiver, Unit, crabbing, record, truth};
    }
    pub mod tour {
        pub use crate::simulate::tour::Tour;
    }
    pub mod track {
        pub use crate::simulate::track::ridden::{ORIGIN, TrackRide, position};
        pub use crate::simulate::track::ride;
        pub use crate::simulate::track::scenario::Track;
        pub use crate::simulate::track::truth::{doings, notes};
    }
    pub mod swing {
        pub use crate::simulate::swing::Form;
    }
    pub mod transients {
        pub use crate::simulate::transients::Transients;
    }
    pub mod wheel_sensors {
        pub use crate::simulate::wheel_sensors::of_multibody;
    }
    pub mod truth {
        pub use crate::simulate::truth::{coefficients, of_corners};
    }
    pub mod tyre_truth {
        pub use crate::simulate::tyre_truth::{Bench, bench, coefficients};
    }
}
pub mod statistics {
    pub mod bisquare {
        pub use crate::statistics::bisquare::{Options, Start, linear};
    }
    pub mod cluster_covariance {
        pub use crate::statistics::cluster_covariance::{Scores, sandwich};
    }
    pub mod interval {
        pub use crate::statistics::interval::t95;
    }
    pub mod loss {
        pub use crate::statistics::loss::TUNING;
    }
    pub mod nonlinear {
        pub use crate::statistics::nonlinear::{Model, Options, fit};
    }
    pub mod order {
        pub use crate::statistics::order::{median, median_of_finite, upper_median_of};
    }
    pub mod random {
        pub use crate::statistics::random::{Coloured, Random};
    }
    pub mod smooth {
        pub use crate::statistics::smooth::smooth;
    }
}
pub mod store {
    pub mod objects {
        pub use crate::store::objects::location::Location;
    }
    pub mod tables {
        pub mod file {
            pub use crate::store::tables::file::{
                Error, batch, batch_to_bytes, to_bytes, write, write_batch, write_bytes,
            };
        }
        pub mod names {
            pub use crate::store::tables::names::file_name;
        }
        pub mod read {
            pub use crate::store::tables::read::{batches_of, file_rows, files, rows};
        }
        pub mod registry {
            pub use crate::store::tables::registry::{
                ALL, Command, LAPS, REJECTED, Row, SESSIONS, SIGNALS, Scope, TRUTH, TRUTH_SEGMENTS,
                TableSpec, find, of_fleet, of_session, schema_files,
            };
        }
        pub mod rows {
            pub use crate::contract::status::Status;
            pub use crate::store::tables::ident::{Circumstances, Ident};
            pub use crate::store::tables::lap_rows::{
                LapCoefficientRow, LapCornerRow, LapPointRow, LapRow, LapTrendRow,
            };
            pub use crate::store::tables::outlying_rows::OutlyingManoeuvre;
            pub use crate::store::tables::parameter_rows::TyreParameters;
            pub use crate::store::tables::rows::{
                CauseRow, ChangeRow, Coefficient, ComparisonRow, DiscrepancyRow, EffectTrace,
                EstimateRow, EventRow, EvidenceRow, FleetRow, Manoeuvre, PeakRow, PlotPoint,
                PooledRow, Provenance, RatioRow, Rejected, SessionRow, SimulatedSample,
                SimulationError, Truth, TruthSegment, TyreRow, WarningRow,
            };
        }
    }
}
pub mod tyre {
    pub use crate::tyre::magic_formula::MagicFormula;
    pub use crate::tyre::paper::Stiffness;
    pub mod custom {
        pub use crate::tyre::custom::Custom;
    }
    pub mod formulation {
        pub use crate::tyre::formulation::Formulation;
    }
    pub mod magic_formula {
        pub use crate::tyre::magic_formula::MagicFormula;
    }
    pub mod published {
        pub use crate::tyre::published::{SETS, text};
    }
    pub mod tir {
        pub use crate::tyre::tir::{load, parse};
    }
    pub mod tydex {
        pub use crate::tyre::tydex::{Bench, Point};
        pub mod read {
            pub use crate::tyre::tydex::read::{parse, read};
        }
        pub mod write {
            pub use crate::tyre::tydex::write::{Head, write};
        }
    }
    pub mod paper {
        pub use crate::tyre::paper::{Input, Output, Tyre, slip_stiffness_under};
    }
    pub mod tyre_model {
        pub use crate::tyre::tyre_model::{Carcass, Reference, Relaxation, TyreModel};
    }
}
