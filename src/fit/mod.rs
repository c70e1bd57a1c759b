//! Tyre and vehicle coefficients with their uncertainty.
//!
//! [`coasting`], [`friction`] and [`cornering`] are the paper's fits. [`chain`] runs them in their
//! order on the samples of a session ([`data`], [`selection`], [`rows`]) and again for every upstream quantity
//! that is uncertain ([`variation`], [`refit`]); [`assemble`] makes the coefficients of what was
//! fitted, [`coefficients`] the rows of the table, with the status of [`verdict`], [`missing`] what the
//! numbers cost that the bike file does not have, [`bands`] how well the curves are known that charts draw.

pub mod assemble;
pub mod bands;
pub mod by_course;
pub mod chain;
pub mod coasting;
pub mod coefficients;
pub mod config;
pub mod contradicted;
pub mod cornering;
pub mod data;
pub mod evidence;
pub mod friction;
pub mod in_gear;
pub mod missing;
pub mod refit;
pub mod rows;
pub mod selection;
pub mod slip_stiffness_load;
pub mod solution;
pub mod variation;
pub mod verdict;
pub mod wheel_scale;

pub use config::{Config, FrictionConfig};
pub use data::Data;
pub use solution::Solution;
