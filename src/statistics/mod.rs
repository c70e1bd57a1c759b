//! TODO room

pub mod bisquare;
pub mod bounds;
pub mod cluster_covariance;
pub mod clustered_fit;
pub mod interval;
pub mod loss;
pub mod nonlinear;
pub mod random;
pub mod search;
pub mod start;
