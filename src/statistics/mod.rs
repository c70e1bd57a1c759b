//! Robust statistics that know nothing of motorcycles: losses, linear and nonlinear fits, covariance of
//! clustered samples, intervals, medians and quantiles, searches in one dimension, smoothing, random numbers.
//!
//! Ground floor: imports nothing of the other rooms.

pub(crate) mod angles;
pub(crate) mod bisquare;
pub(crate) mod blocked;
pub(crate) mod bounds;
pub(crate) mod cluster_covariance;
pub(crate) mod clustered_fit;
pub(crate) mod discovery;
pub(crate) mod interval;
pub(crate) mod loss;
pub(crate) mod moderated;
pub(crate) mod nonlinear;
pub(crate) mod number_format;
pub(crate) mod order;
pub(crate) mod random;
pub(crate) mod runs;
pub(crate) mod search;
pub(crate) mod smooth;
pub(crate) mod start;
