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
    /// Candidates that flights, where they show best, cannot tell apart; one of them alone is named.
    pub family: Option<&'static str>,
    /// How it changes the residuals of a ride.
    pub curve: fn(&Ride<'_>) -> Curve,
}

/// What candidates are made from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Ride<'a> {
    /// The residuals.
    pub residuals: &'a Residuals,
    /// The estimate.
    pub estimate: &'a Estimate,
    /// The riders' settings.
    pub rider: &'a rider::Config,
    /// Highest frequency that the filter leaves, Hz.
    pub high_cut: f64,
}
