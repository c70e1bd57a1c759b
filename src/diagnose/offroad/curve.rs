//! What the base model (rider B, the bike file's fork) may leave out: one file per candidate or family.
//!
//! Every candidate adds to the residuals; none changes what another adds (to first order). So a
//! candidate is the change of every block as its number goes from that of the base to any other:
//! a line, or nodes between which is interpolated.

pub mod rider_motion;
pub mod suspension;

use super::residuals::Residuals;
use crate::estimate::offroad::Estimate;
use crate::estimate::offroad::rider;

/// A candidate cause.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// In the tables.
    pub name: &'static str,
    /// Its number.
    pub parameter: &'static str,
    /// Unit of the number.
    pub unit: &'static str,
    /// In words.
    pub sentence: &'static str,
    /// The riding or channel that tells it from others.
    pub separate_by: &'static str,
    /// A usual size, in the unit.
    pub usual: f64,
    /// Sizes that can be.
    pub possible: [f64; 2],
    /// Candidates that flights, where they show best, cannot tell apart; one of them alone is named.
    pub family: Option<&'static str>,
    /// What it changes.
    make: fn(&Ride<'_>) -> Curve,
}

/// What candidates are made from.
#[derive(Debug, Clone, Copy)]
pub struct Ride<'a> {
    /// The residuals.
    pub residuals: &'a Residuals,
    /// The estimate.
    pub estimate: &'a Estimate,
    /// The riders' settings.
    pub rider: &'a rider::Config,
    /// Highest frequency that the filter leaves, Hz.
    pub high_cut: f64,
}

/// Every candidate.
pub const ALL: &[Effect] = &[
    rider_motion::VERTICAL,
    rider_motion::HORIZONTAL,
    suspension::FORK_FRICTION,
    suspension::FORK_PRELOAD,
    suspension::SHOCK_FRICTION,
];

/// Change of every block from the base.
#[derive(Debug, Clone)]
pub enum Curve {
    /// Per unit of the number; the base is zero.
    Line(Vec<f64>),
    /// At rising numbers; between them linear in their logarithm. The base is none of them.
    Nodes {
        /// Logarithms of the numbers.
        at: Vec<f64>,
        /// One column per number.
        columns: Vec<Vec<f64>>,
    },
}

impl Effect {
    /// The candidate on a ride.
    pub fn curve(&self, ride: &Ride<'_>) -> Curve {
        (self.make)(ride)
    }
}

impl Curve {
    /// Adds the change at `value` to every block.
    pub fn add(&self, value: f64, r: &mut [f64]) {
        match self {
            Curve::Line(column) => r.iter_mut().zip(column).for_each(|(r, c)| *r += value * c),
            Curve::Nodes { at, columns } => {
                let (k, share) = place(at, value.ln());
                let (low, high) = (&columns[k], &columns[k + 1]);
                for ((r, a), b) in r.iter_mut().zip(low).zip(high) {
                    *r += a + share * (b - a);
                }
            }
        }
    }

    /// Derivative with respect to the number (a line) or to its logarithm (nodes).
    pub fn slope(&self, value: f64) -> Vec<f64> {
        match self {
            Curve::Line(column) => column.clone(),
            Curve::Nodes { at, columns } => {
                // over two steps: the interpolation has kinks
                let (k, _) = place(at, value.ln());
                let (low, high) = (k.saturating_sub(1), (k + 2).min(at.len() - 1));
                let by = 1.0 / (at[high] - at[low]);
                columns[low].iter().zip(&columns[high]).map(|(a, b)| by * (b - a)).collect()
            }
        }
    }

    /// Whether the number is a frequency whose logarithm has the interval.
    pub fn logarithmic(&self) -> bool {
        matches!(self, Curve::Nodes { .. })
    }
}

/// The node below and the share of the way to the next.
fn place(at: &[f64], x: f64) -> (usize, f64) {
    let k = at.partition_point(|a| *a <= x).clamp(1, at.len() - 1) - 1;
    (k, ((x - at[k]) / (at[k + 1] - at[k])).clamp(0.0, 1.0))
}
