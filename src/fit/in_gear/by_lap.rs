//! The fit of a ride in gear, lap by lap: what each lap says a tyre has changed by, and the trend over the laps.
//!
//! The ride is fitted as a whole. About that solution the residuals are linear, and every lap gets deviations of its
//! own for some directions of the parameters, beside those that all laps share:
//!
//! ```text
//! r_i + J_i (shared + sum_j e_j d_lj) ~ 0     sample i of lap l
//! shared ~ N(theta's prior),  d_lj ~ N(0, tau_j²)
//! x_lj = d_lj - mean over laps
//! ```
//! What laps have in common (mass, heights, scales of sensors, drag, the model's own errors at the same corner) is in
//! `shared`: it cancels in `x`, and the variance of `x` has none of it. The trend is the weighted line through `x` over
//! the lap's number. Its variance is that of the laps' formal errors, times the scatter of the laps about the line where
//! that is more, with Student's t of `n - 2`: so it holds for errors that the formal ones do not know, as long as they
//! are not themselves a trend.

use nalgebra::{DMatrix, DVector};

use super::InGear;
use super::columns::{RATE, columns};
use super::config::Config;
use super::model::Model;
use super::parameters::*;
use super::solve::{linearise, weigh};
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::session::Session;
use crate::statistics::interval::t_quantile;

/// Fewest laps of a trend.
pub(crate) const FEWEST: usize = 6;
/// How far a tyre may change from lap to lap, one standard deviation, a share: what laps tell is much finer, or nothing.
const TAU: f64 = 0.2;
/// The same of a rolling radius.
const TAU_RADIUS: f64 = 0.02;
/// Share of that prior below which a lap's deviation is determined.
const DETERMINED: f64 = 0.5;

/// One lap of one coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfLap {
    /// Number of the lap.
    pub lap: i64,
    /// Over the mean of the laps, less one.
    pub change: f64,
    /// Its standard deviation; none of it is shared by the laps.
    pub std_error: f64,
    /// Samples of the lap.
    pub samples: usize,
}

/// A coefficient over the laps.
#[derive(Debug, Clone, PartialEq)]
pub struct ByLap {
    /// Of which tyre.
    pub axle: Axle,
    /// Which.
    pub coefficient: C,
    /// Its value for the session, SI.
    pub value: f64,
    /// Lap by lap.
    pub laps: Vec<OfLap>,
    /// Change per lap, a share of the value.
    pub per_lap: f64,
    /// Its standard deviation.
    pub std_error: f64,
    /// Degrees of freedom of its interval.
    pub dof: f64,
    /// Scatter of the laps about the line over their formal errors.
    pub scatter: f64,
}

impl ByLap {
    /// Half of the interval of a probability of the change per lap.
    pub fn half(&self, probability: f64) -> f64 {
        t_quantile(0.5 + 0.5 * probability, self.dof) * self.std_error
    }
}

/// What may change from lap to lap: a direction of the parameters, a share of the coefficient per unit of it.
struct Direction {
    axle: Axle,
    coefficient: C,
    /// Derivative of the parameters by a relative change.
    along: Vec<(usize, f64)>,
    value: f64,
    tau: f64,
}

/// A tyre that gives less force at every slip has less stiffness and less peak in the same measure: where the peak was not
/// reached the two cannot be told apart, and both are one direction.
fn directions(theta: &Theta) -> Vec<Direction> {
    let mut out = Vec::new();
    for axle in Axle::BOTH {
        let k = axle as usize;
        let radius = theta[R_F + k];
        out.push(Direction {
            axle,
            coefficient: C::EffectiveRollingRadius,
            along: vec![(R_F + k, radius)],
            value: radius,
            tau: TAU_RADIUS,
        });
        let mut along = vec![(K_F + k, 1.0), (D_F + k, 1.0)];
        if axle == Axle::Rear {
            along.push((K_D, 1.0));
        }
        let value = theta[K_F + k].exp();
        out.push(Direction { axle, coefficient: C::SlipStiffness, along, value, tau: TAU });
    }
    out
}

/// Coefficients over laps (number, start and end in s); empty where there are fewer than [`FEWEST`] or the ride lacks
/// what the fit takes.
pub fn run(
    session: &Session,
    bike: &Bike,
    config: &Config,
    fit: &InGear,
    laps: &[(i64, f64, f64)],
) -> Vec<ByLap> {
    if laps.len() < FEWEST {
        return Vec::new();
    }
    let Some(columns) = columns(session, config) else { return Vec::new() };
    let model = Model::new(&columns, bike, config.max_lean);
    let theta = &fit.fitted.theta;
    let mut rows = linearise(&model, theta, &fit.fitted.held);
    weigh(&mut rows);
    let directions = directions(theta);
    let (n, d) = (laps.len(), directions.len());
    let size = COUNT + n * d;
    let mut hessian = DMatrix::<f64>::zeros(size, size);
    let mut gradient = DVector::<f64>::zeros(size);
    for k in 0..COUNT {
        let precision = fit.prior.sd[k].powi(-2);
        hessian[(k, k)] += precision;
        gradient[k] += precision * (theta[k] - fit.prior.mean[k]);
    }
    for (j, direction) in directions.iter().enumerate() {
        for l in 0..n {
            let at = COUNT + l * d + j;
            hessian[(at, at)] += direction.tau.powi(-2);
        }
    }
    let mut samples = vec![0; n];
    for row in &rows {
        let time = row.at as f64 / RATE;
        let lap = laps.iter().position(|(_, start, end)| (*start..*end).contains(&time));
        // shared parameters and the lap's own, by their places
        let mut by: Vec<(usize, f64)> = row.by.iter().copied().enumerate().collect();
        if let Some(l) = lap {
            samples[l] += 1;
            by.extend(directions.iter().enumerate().map(|(j, direction)| {
                let slope = direction.along.iter().map(|(k, share)| row.by[*k] * share).sum();
                (COUNT + l * d + j, slope)
            }));
        }
        for (a, x) in &by {
            gradient[*a] += row.weight * row.residual * x;
            for (b, y) in &by {
                hessian[(*a, *b)] += row.weight * x * y;
            }
        }
    }
    let Some(inverse) = hessian.cholesky().map(|h| h.inverse()) else { return Vec::new() };
    let solution = -(&inverse * gradient);
    let place = |l: usize, j: usize| COUNT + l * d + j;
    directions
        .iter()
        .enumerate()
        .filter_map(|(j, direction)| {
            let mean = (0..n).map(|l| solution[place(l, j)]).sum::<f64>() / n as f64;
            // of a lap less the mean of all
            let variance = |l: usize| {
                let to_mean: f64 = (0..n).map(|m| inverse[(place(l, j), place(m, j))]).sum();
                let of_mean: f64 = (0..n)
                    .flat_map(|m| (0..n).map(move |k| (m, k)))
                    .map(|(m, k)| inverse[(place(m, j), place(k, j))])
                    .sum();
                let n = n as f64;
                inverse[(place(l, j), place(l, j))] - 2.0 * to_mean / n + of_mean / (n * n)
            };
            let of = |(l, lap): (usize, &(i64, f64, f64))| OfLap {
                lap: lap.0,
                change: solution[place(l, j)] - mean,
                std_error: variance(l).max(0.0).sqrt(),
                samples: samples[l],
            };
            let laps: Vec<OfLap> = laps.iter().enumerate().map(of).collect();
            let determined = laps.iter().all(|l| {
                l.std_error > 0.0 && l.std_error < DETERMINED * direction.tau && l.samples > 0
            });
            determined.then(|| trend(direction, laps))
        })
        .collect()
}

/// The weighted line through the laps.
fn trend(direction: &Direction, laps: Vec<OfLap>) -> ByLap {
    let weight = |l: &OfLap| l.std_error.powi(-2);
    let sum = |of: &dyn Fn(&OfLap) -> f64| laps.iter().map(|l| weight(l) * of(l)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let (middle, mean) = (sum(&|l| l.lap as f64) / total, sum(&|l| l.change) / total);
    let spread = sum(&|l| (l.lap as f64 - middle).powi(2));
    let per_lap = sum(&|l| (l.lap as f64 - middle) * (l.change - mean)) / spread;
    let dof = laps.len() as f64 - 2.0;
    let off = |l: &OfLap| (l.change - mean - per_lap * (l.lap as f64 - middle)).powi(2);
    let scatter = (sum(&off) / dof).sqrt();
    ByLap {
        axle: direction.axle,
        coefficient: direction.coefficient,
        value: direction.value,
        per_lap,
        std_error: scatter.max(1.0) / spread.sqrt(),
        dof,
        scatter,
        laps,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(slope: f64, scatter: &[f64]) -> ByLap {
        let direction = Direction {
            axle: Axle::Rear,
            coefficient: C::SlipStiffness,
            along: Vec::new(),
            value: 20.0,
            tau: TAU,
        };
        let lap = |(k, off): (usize, &f64)| OfLap {
            lap: k as i64 + 1,
            change: slope * k as f64 + off,
            std_error: 0.01,
            samples: 100,
        };
        trend(&direction, scatter.iter().enumerate().map(lap).collect())
    }

    #[test]
    fn a_line_has_its_slope_and_no_less_than_the_formal_error() {
        let found = line(-0.003, &[0.0; 10]);
        assert!((found.per_lap + 0.003).abs() < 1e-12, "{found:?}");
        // 0.01 over the root of the sum of squares about the middle, 82.5
        assert!((found.std_error - 0.01 / 82.5_f64.sqrt()).abs() < 1e-9);
        assert_eq!(found.dof, 8.0);
        let wild = line(0.0, &[0.05, -0.05, 0.05, -0.05, 0.05, -0.05, 0.05, -0.05]);
        assert!(wild.scatter > 4.0 && wild.std_error > 4.0 * 0.01 / 42_f64.sqrt(), "{wild:?}");
        assert!(wild.per_lap.abs() < wild.half(0.95));
    }
}
