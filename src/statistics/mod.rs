//! Robust statistics that know nothing of motorcycles: losses, linear and nonlinear fits, covariance of
//! clustered samples, intervals, medians and quantiles, searches in one dimension, smoothing, random numbers.
//!
//! Ground floor: imports nothing of the other rooms.

pub mod bisquare;
pub mod bounds;
pub mod cluster_covariance;
pub mod clustered_fit;
pub mod interval;
pub mod loss;
pub mod nonlinear;
pub mod order;
pub mod random;
pub mod runs;
pub mod search;
pub mod smooth;
pub mod start;
