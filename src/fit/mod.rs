//! Tyre and vehicle coefficients with their uncertainty.
//!
//! [`coasting`], [`friction`] and [`cornering`] are the paper's fits. [`chain`] runs them in their
//! order on the samples of a session ([`data`], [`selection`], [`rows`]) and again for every upstream quantity
//! that is uncertain ([`variation`], [`refit`]); [`assemble`] makes the coefficients of what was
//! fitted, [`coefficients`] the rows of the table, with the status of [`verdict`], [`missing`] what the
//! numbers cost that the bike file does not have, [`bands`] how well the curves are known that charts draw, [`outlying`]
//! which manoeuvres are not as the others.

pub(crate) mod assemble;
pub(crate) mod bands;
pub(crate) mod by_course;
pub(crate) mod chain;
pub(crate) mod coasting;
pub(crate) mod coefficients;
pub(crate) mod config;
pub(crate) mod contradicted;
pub(crate) mod cornering;
pub(crate) mod data;
pub(crate) mod evidence;
pub(crate) mod friction;
pub(crate) mod in_gear;
pub(crate) mod measured;
pub(crate) mod missing;
pub(crate) mod outlying;
pub(crate) mod refit;
pub(crate) mod rows;
pub(crate) mod selection;
pub(crate) mod slip_stiffness_load;
pub(crate) mod solution;
pub(crate) mod transients;
pub(crate) mod variation;
pub(crate) mod verdict;
pub(crate) mod wheel_scale;

pub(crate) use config::Config;
pub(crate) use data::Data;
pub(crate) use solution::Solution;
