//! Robust fits and their uncertainty.
//!
//! [`bisquare`] fits what is linear in its coefficients, [`nonlinear`] what is not; both weigh
//! samples by Tukey's bisquare ([`loss`]) from a start that outliers cannot choose
//! ([`start`]). [`cluster`] turns a fit into a covariance that knows that samples within a
//! manoeuvre are correlated, [`interval`] turns that into intervals, also of ratios.

pub mod bisquare;
pub mod bounds;
pub mod cluster;
pub mod interval;
pub mod loss;
pub mod nonlinear;
pub mod search;
pub mod start;
