//! What is declared of a candidate.

use super::curve::Curve;
use super::residuals::Residuals;
use crate::diagnose::cause::Candidate;
use crate::estimate::offroad::Estimate;
use crate::estimate::offroad::rider;

/// A candidate with the change of the residuals that it makes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Declaration {
    /// Its name, words and bounds; its place is that in [`ALL`](super::candidates::ALL).
    pub candidate: Candidate,
    /// Candidates that flights, where they show best, cannot tell apart; only one of them is identified.
    pub family: Option<&'static str>,
    /// How it changes the residuals of a ride.
    pub curve: fn(&Ride<'_>) -> Curve,
}

/// Data from which candidates compute their residuals.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ride<'a> {
    /// Block residuals of the equations of motion.
    pub residuals: &'a Residuals,
    /// Tyre forces and rider motion, sample by sample.
    pub estimate: &'a Estimate,
    pub rider: &'a rider::Config,
    /// Highest frequency that the filter leaves, Hz.
    pub high_cut: f64,
}
