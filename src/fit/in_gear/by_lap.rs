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
//! the lap's number. The errors that the fit expects of its samples are for the largest part such as laps share, too, so
//! that the formal errors `sigma_l` of `x` are bounds: laps scatter less. How much less is the ride's own word, drawn to
//! what simulated sessions have:
//!
//! ```text
//! s²      = sum_l ((x_l - line_l)/sigma_l)² / (n - 2)
//! factor² = (n0 s0² + (n - 2) s²) / (n0 + n - 2)          s0 = 0.4, n0 = 6
//! ```
//! Student's t has the `n0 + n - 2` degrees of freedom. An error that runs evenly through the session is a trend and in
//! none of this.
//!
//! Under drive a tyre of less stiffness and one of a smaller radius turn alike. The radii of laps are found with stiffness
//! free; the stiffness of laps with radii that keep still, as those of warm tyres do. What a drift of [`DRIFT`] of both
//! would look like is part of its error: `s = cov(d_K, d_R)/var(d_R)` of a lap with all free, times the drift. With all
//! free the stiffness takes the part of a fade that a misfit of the model leaves to it, half in the worst of four rides.

use nalgebra::{DMatrix, DVector};

use super::InGear;
use super::columns::{RATE, columns};
use super::config::Config;
use super::model::Model;
use super::parameters::*;
use super::solve::{Row, linearise, weigh};
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::session::Session;
use crate::statistics::interval::{t_quantile, t95};

/// Fewest laps of a trend.
pub(crate) const MIN_LAPS: usize = 6;
/// How far a tyre may change from lap to lap, one standard deviation, a share: what laps tell is much finer, or nothing.
const TAU: f64 = 0.2;
/// The same of a rolling radius.
const TAU_RADIUS: f64 = 0.02;
/// Scatter of laps over their formal errors before the session says it, and what that is worth in degrees of freedom. Tuned
/// on simulated track sessions that serve for nothing else (seed 1: 0.23 to 0.44 of ten sessions, one 0.9).
const SCATTER: f64 = 0.4;
const SCATTER_DOF: f64 = 6.0;
/// Drift of warm tyres' rolling radii over a session, one standard deviation, a share: assumed, a fifteenth of a millimetre.
const DRIFT: f64 = 2e-4;
/// How wrong the slip may be that a change of stiffness is read from, a share of the change: what laps say of a change goes
/// with the slip of the fit, whose stiffness is wrong by about as much on simulated rides.
const SCALE_ERROR: f64 = 0.15;
/// Share of that prior below which a lap's deviation is determined.
const DETERMINED: f64 = 0.5;

/// One lap of one coefficient.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OfLap {
    pub lap: i64,
    /// Over the mean of the laps, less one.
    pub change: f64,
    /// Its standard deviation by the laps' scatter; none of it is shared by the laps.
    pub std_error: f64,
    /// Samples of the lap.
    pub samples: usize,
}

/// A coefficient over the laps.
#[derive(Debug, Clone, PartialEq)]
pub struct ByLap {
    /// Of which tyre.
    pub axle: Axle,
    pub coefficient: C,
    /// Its value for the session, SI.
    pub value: f64,
    pub laps: Vec<OfLap>,
    /// Change per lap, a share of the value.
    pub per_lap: f64,
    /// Its standard deviation where nothing changes.
    pub std_error: f64,
    /// Degrees of freedom of its interval.
    pub dof: f64,
    /// Scatter of the laps about the line over their formal errors, which are bounds.
    pub scatter: f64,
    /// Error of the size of a change, a share of it.
    pub scale_error: f64,
}

impl ByLap {
    /// Half of the interval of a probability about no change per lap.
    pub fn half(&self, probability: f64) -> f64 {
        t_quantile(0.5 + 0.5 * probability, self.dof) * self.std_error
    }

    /// Standard deviation of the change per lap that was found, its size's own error included.
    pub fn error(&self) -> f64 {
        self.std_error.hypot(self.scale_error * self.per_lap)
    }

    /// Half of its 95 % interval.
    pub fn half_95(&self) -> f64 {
        t95(self.dof) * self.error()
    }
}

/// Change from lap to lap: a direction of the parameters, a share of the coefficient per unit of it.
struct Direction {
    axle: Axle,
    coefficient: C,
    /// Derivative of the parameters by a relative change.
    along: Vec<(usize, f64)>,
    value: f64,
    tau: f64,
}

/// A tyre that gives less force at every slip has less stiffness and less peak in the same measure: where the peak was not
/// reached nothing separates the two, and both are one direction.
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

/// Coefficients over laps (number, start and end in s); empty where there are fewer than [`MIN_LAPS`] or the ride lacks
/// what the fit takes.
pub fn run(
    session: &Session,
    bike: &Bike,
    config: &Config,
    fit: &InGear,
    laps: &[(i64, f64, f64)],
) -> Vec<ByLap> {
    if laps.len() < MIN_LAPS {
        return Vec::new();
    }
    let Some(columns) = columns(session, config) else { return Vec::new() };
    let model = Model::new(&columns, bike, config.max_lean);
    let theta = &fit.fitted.theta;
    let mut rows = linearise(&model, theta, &fit.fitted.held);
    weigh(&mut rows);
    let all = directions(theta);
    let (radii, stiffnesses): (Vec<Direction>, Vec<Direction>) =
        directions(theta).into_iter().partition(|d| d.coefficient == C::EffectiveRollingRadius);
    let (Some(free), Some(still)) =
        (Solved::new(&rows, fit, laps, &all), Solved::new(&rows, fit, laps, &stiffnesses))
    else {
        return Vec::new();
    };
    let place = |of: &Direction| all.iter().position(|d| d.is(of));
    let over = (laps[laps.len() - 1].0 - laps[0].0) as f64;
    let mut out = Vec::new();
    for radius in &radii {
        let found = place(radius).and_then(|j| free.of(j, laps, radius));
        out.extend(found.map(|laps| trend(radius, laps, [0.0; 2])));
    }
    for (j, stiffness) in stiffnesses.iter().enumerate() {
        let Some(found) = still.of(j, laps, stiffness) else { continue };
        let slope = |radius: &Direction| match (place(stiffness), place(radius)) {
            (Some(a), Some(b)) => free.slope(a, b),
            _ => 0.0,
        };
        let drift = radii.iter().map(slope).fold(0.0, f64::hypot) * DRIFT / over;
        out.push(trend(stiffness, found, [drift, SCALE_ERROR]));
    }
    out.sort_by_key(|o| o.axle as usize);
    out
}

impl Direction {
    fn is(&self, other: &Direction) -> bool {
        (self.axle, self.coefficient) == (other.axle, other.coefficient)
    }
}

/// The deviations of all laps for some directions, beside what they share.
struct Solved {
    directions: usize,
    solution: DVector<f64>,
    covariance: DMatrix<f64>,
    samples: Vec<usize>,
}

impl Solved {
    fn new(
        rows: &[Row],
        fit: &InGear,
        laps: &[(i64, f64, f64)],
        directions: &[Direction],
    ) -> Option<Self> {
        let theta = &fit.fitted.theta;
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
        for row in rows {
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
        let covariance = hessian.cholesky()?.inverse();
        let solution = -(&covariance * gradient);
        Some(Solved { directions: d, solution, covariance, samples })
    }

    fn place(&self, lap: usize, direction: usize) -> usize {
        COUNT + lap * self.directions + direction
    }

    /// Error of one direction by an error of another in every lap: the mean over the laps.
    fn slope(&self, of: usize, by: usize) -> f64 {
        let n = self.samples.len();
        let each = (0..n).map(|l| {
            let (a, b) = (self.place(l, of), self.place(l, by));
            self.covariance[(a, b)] / self.covariance[(b, b)]
        });
        each.sum::<f64>() / n as f64
    }

    /// The laps of a direction, each less the mean of all; `None` where one of them is not determined.
    fn of(&self, j: usize, laps: &[(i64, f64, f64)], direction: &Direction) -> Option<Vec<OfLap>> {
        let n = laps.len();
        let mean = (0..n).map(|l| self.solution[self.place(l, j)]).sum::<f64>() / n as f64;
        let between = |l: usize, m: usize| self.covariance[(self.place(l, j), self.place(m, j))];
        let to_mean = |l: usize| (0..n).map(|m| between(l, m)).sum::<f64>() / n as f64;
        let of_mean = (0..n).map(to_mean).sum::<f64>() / n as f64;
        let of = |(l, lap): (usize, &(i64, f64, f64))| OfLap {
            lap: lap.0,
            change: self.solution[self.place(l, j)] - mean,
            std_error: (between(l, l) - 2.0 * to_mean(l) + of_mean).max(0.0).sqrt(),
            samples: self.samples[l],
        };
        let laps: Vec<OfLap> = laps.iter().enumerate().map(of).collect();
        let determined = |l: &OfLap| {
            l.std_error > 0.0 && l.std_error < DETERMINED * direction.tau && l.samples > 0
        };
        laps.iter().all(determined).then_some(laps)
    }
}

/// The weighted line through the laps. The last argument is a drift per lap that looks like a change, one standard
/// deviation, and the error of a change's size, a share.
fn trend(direction: &Direction, mut laps: Vec<OfLap>, [drift, scale_error]: [f64; 2]) -> ByLap {
    let weight = |l: &OfLap| l.std_error.powi(-2);
    let sum = |of: &dyn Fn(&OfLap) -> f64| laps.iter().map(|l| weight(l) * of(l)).sum::<f64>();
    let total = sum(&|_| 1.0);
    let (middle, mean) = (sum(&|l| l.lap as f64) / total, sum(&|l| l.change) / total);
    let spread = sum(&|l| (l.lap as f64 - middle).powi(2));
    let per_lap = sum(&|l| (l.lap as f64 - middle) * (l.change - mean)) / spread;
    let own = laps.len() as f64 - 2.0;
    let off = |l: &OfLap| (l.change - mean - per_lap * (l.lap as f64 - middle)).powi(2);
    let scatter = (sum(&off) / own).sqrt();
    let dof = SCATTER_DOF + own;
    let factor = ((SCATTER_DOF * SCATTER * SCATTER + own * scatter * scatter) / dof).sqrt();
    laps.iter_mut().for_each(|l| l.std_error *= factor);
    ByLap {
        axle: direction.axle,
        coefficient: direction.coefficient,
        value: direction.value,
        per_lap,
        std_error: drift.hypot(factor / spread.sqrt()),
        scale_error,
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
        trend(&direction, scatter.iter().enumerate().map(lap).collect(), [0.0, 0.1])
    }

    #[test]
    fn a_line_has_its_slope_and_the_error_of_the_laps_scatter() {
        let found = line(-0.003, &[0.0; 10]);
        assert!((found.per_lap + 0.003).abs() < 1e-12, "{found:?}");
        // no scatter of eight degrees of freedom, and 0.4 of six
        let factor = (6.0 * 0.16 / 14.0_f64).sqrt();
        // over the root of the sum of squares about the middle, 82.5
        assert!((found.std_error - factor * 0.01 / 82.5_f64.sqrt()).abs() < 1e-9);
        assert!((found.laps[3].std_error - factor * 0.01).abs() < 1e-12 && found.dof == 14.0);
        assert!((found.error() - found.std_error.hypot(0.0003)).abs() < 1e-12);
        let wild = line(0.0, &[0.05, -0.05, 0.05, -0.05, 0.05, -0.05, 0.05, -0.05]);
        assert!(wild.scatter > 4.0 && wild.std_error > 3.0 * 0.01 / 42_f64.sqrt(), "{wild:?}");
        assert!(wild.per_lap.abs() < wild.half(0.95));
    }
}
