//! Gauss and Newton with priors as rows; intervals by leaving out manoeuvre after manoeuvre.
//!
//! ```text
//! H = sum w J'J + P,   step = -H^-1 (sum w J'r + P (theta - mean))
//! cov = (G-1)/G sum_g d_g d_g' + H^-1 P H^-1,   d_g = (H - H_g)^-1 sum_g w J'r;   never below H^-1
//! ```

use nalgebra::{SMatrix, SVector};

use super::columns::{Columns, STEP, difference, neighbours};
use super::model::{A, C, Evaluation, Held, KINDS, Model, Split};
use super::parameters::*;
use crate::statistics::loss::{TUNING, mad, weight};

type Matrix = SMatrix<f64, COUNT, COUNT>;
type Vector = SVector<f64, COUNT>;

/// Rounds at most.
const ROUNDS: usize = 40;
/// Rounds at least: the acceleration has to come to rest.
const LEAST_ROUNDS: usize = 8;
/// Largest step in prior standard deviations.
const LARGEST_STEP: f64 = 0.7;
/// Step at rest, in prior standard deviations.
const REST: f64 = 0.02;
/// Round from which on the same samples take part with the same acceleration and expected errors: samples
/// at a limit, and the slip of a front wheel near its peak, would come and go for ever.
const SETTLED: usize = 16;
/// Share of the way that the acceleration goes in a round: at first, and from which round on less.
const DAMPED: [(usize, f64); 2] = [(0, 0.5), (6, 0.2)];
/// Least load of a wheel over the weight, for the friction that it used: below it the error of the load transfer decides.
const LEAST_SHARE: f64 = 0.3;
/// Samples one after the other that must have reached a friction.
const KEPT: usize = 3;
/// Manoeuvres that must have reached a friction.
const REACHED_BY: usize = 3;
/// Neighbouring samples that count as one, of A and of the others.
const SHARED: [f64; KINDS] = [6.0, 3.0, 3.0, 3.0];

#[derive(Debug, Clone)]
pub struct Fitted {
    pub theta: Theta,
    pub covariance: Box<Matrix>,
    /// The samples that took part, as they were held last.
    pub held: Vec<Held>,
    pub clusters: usize,
    /// Scale of each residual over what was expected.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub scale: [f64; KINDS],
    /// Samples of each residual.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub counts: [usize; KINDS],
    /// Share of residuals that were left out as outliers.
    pub outliers: f64,
    /// Whether it came to rest.
    pub converged: bool,
}

pub(crate) fn fit(model: &Model<'_>, prior: &Prior, min_speed: f64) -> Option<Fitted> {
    let columns = model.columns;
    let mut theta = prior.mean;
    start_radii(columns, prior, &mut theta, min_speed)?;
    let precision = Vector::from_fn(|k, _| prior.sd[k].powi(-2));
    let mut acceleration = first_acceleration(columns, &theta);
    let (mut held, mut rows, mut scale) = (Vec::new(), Vec::new(), [1.0; KINDS]);
    let mut system = None;
    let mut converged = false;
    for round in 0..ROUNDS {
        if round < SETTLED {
            held = hold(model, &theta, &acceleration, min_speed);
        }
        if held.len() < 100 {
            return None;
        }
        rows = linearise(model, &theta, &held);
        scale = weigh(&mut rows);
        let step = system.insert(System::new(&rows, &theta, prior, &precision)).step()?;
        let size = (0..COUNT).map(|k| (step[k] / prior.sd[k]).abs()).fold(0.0, f64::max);
        if !size.is_finite() {
            return None;
        }
        if size < REST && round >= LEAST_ROUNDS {
            converged = true;
            break;
        }
        let share = (LARGEST_STEP / size).min(1.0);
        for k in 0..COUNT {
            theta[k] += share * step[k];
        }
        let share = if round < DAMPED[1].0 { DAMPED[0].1 } else { DAMPED[1].1 };
        renew(model, &theta, &mut acceleration, share, min_speed);
    }
    let (covariance, clusters) = covariance(&rows, &system?, &precision, columns)?;
    let counts = std::array::from_fn(|kind| rows.iter().filter(|r| r.kind == kind).count());
    let outliers = rows.iter().filter(|r| r.weight == 0.0).count() as f64 / rows.len() as f64;
    Some(Fitted {
        theta,
        covariance: Box::new(covariance),
        held,
        clusters,
        scale,
        counts,
        outliers,
        converged,
    })
}

/// Radii from which the descent starts: medians of velocity over wheel speed. A log whose circumference is
/// not the bike file's starts where it is.
fn start_radii(columns: &Columns, prior: &Prior, theta: &mut Theta, min_speed: f64) -> Option<()> {
    for k in 0..2 {
        let of = |i: usize| columns.speed[i] / columns.omega[k][i];
        let straight = |i: &usize| columns.speed[*i] > min_speed && columns.roll[*i].abs() < 0.2;
        let values: Vec<f64> = (0..columns.len).filter(straight).map(of).collect();
        let middle = crate::statistics::order::median_of_finite(&values)?;
        let (mean, sd) = (prior.mean[R_F + k], prior.sd[R_F + k]);
        theta[R_F + k] = middle.clamp(mean - 2.0 * sd, mean + 2.0 * sd);
    }
    Some(())
}

/// Velocity of the front wheel from its columns before averaging, and its central difference.
fn first_acceleration(columns: &Columns, theta: &Theta) -> Vec<f64> {
    let scale: Vec<f64> = (0..columns.len)
        .map(|i| theta[R_F] - theta[RHO_F] * (1.0 - columns.roll_sharp[i].cos()))
        .collect();
    accelerate(columns, &scale)
}

fn accelerate(columns: &Columns, scale: &[f64]) -> Vec<f64> {
    let speed: Vec<f64> = columns.omega_sharp.iter().zip(scale).map(|(w, s)| w * s).collect();
    difference(&speed)
}

/// Fixed quantities of column `i`, before any sample is judged.
fn bare(model: &Model<'_>, theta: &Theta, acceleration: &[f64], jerk: &[f64], i: usize) -> Held {
    let lean = model.columns.roll[i] - theta[LEAN_ZERO];
    let radius = theta[R_F] - theta[RHO_F] * (1.0 - lean.cos());
    let uphill = crate::GRAVITY * model.columns.grade[i];
    Held {
        at: i,
        split: Split::Free,
        acceleration: Model::late(acceleration, jerk, i).map(|a| a + uphill),
        jerk: jerk[i],
        speed: model.columns.omega[0][i] * radius,
        sigma: [f64::INFINITY; KINDS],
    }
}

/// Whether a column has all it needs.
fn whole(columns: &Columns, held: &Held) -> bool {
    let i = held.at;
    let known = [columns.omega_rate[0][i], columns.omega_rate[1][i], columns.omega[1][i]];
    let pressed = columns.pressure.iter().flatten().all(|p| p[i].is_finite());
    let geared = columns.gear.as_ref().is_none_or(|g| g[i].is_finite());
    let moved = held.acceleration.iter().chain([&held.jerk, &held.speed]);
    known.iter().chain(moved).all(|x| x.is_finite()) && pressed && geared
}

fn hold(model: &Model<'_>, theta: &Theta, acceleration: &[f64], min_speed: f64) -> Vec<Held> {
    let jerk = difference(acceleration);
    (0..model.columns.len)
        .step_by(STEP)
        .map(|i| bare(model, theta, acceleration, &jerk, i))
        .filter(|held| held.speed > min_speed && whole(model.columns, held))
        .filter_map(|held| model.hold(theta, held))
        .collect()
}

/// The acceleration with the slip of the front wheel taken out; a share of the way, or it swings up.
fn renew(model: &Model<'_>, theta: &Theta, acceleration: &mut [f64], share: f64, min_speed: f64) {
    let columns = model.columns;
    let jerk = difference(acceleration);
    let mut slip = vec![0.0; columns.len];
    for (i, slip) in slip.iter_mut().enumerate() {
        let mut held = bare(model, theta, acceleration, &jerk, i);
        if held.speed <= min_speed || !whole(columns, &held) {
            continue;
        }
        held.split = match model.hold(theta, held) {
            Some(held) => held.split,
            None if columns.braked[0][i] => Split::Braked,
            None => continue,
        };
        let value = model.evaluate(theta, &held).slip[0].value;
        *slip = if value.is_finite() { value.clamp(-0.15, 0.15) } else { 0.0 };
    }
    let smooth = neighbours(&slip, |a, b, c| 0.25 * (a + 2.0 * b + c));
    let scale: Vec<f64> = (0..columns.len)
        .map(|i| {
            let lean = columns.roll_sharp[i] - theta[LEAN_ZERO];
            let v = columns.omega_sharp[i] * theta[R_F];
            let radius = theta[R_F] * (1.0 + 1e-6 * theta[GROWTH_F] * v * v)
                - theta[RHO_F] * (1.0 - lean.cos());
            let slip = if smooth[i].is_finite() { smooth[i] } else { slip[i] };
            radius / (1.0 + slip)
        })
        .collect();
    for (old, new) in acceleration.iter_mut().zip(accelerate(columns, &scale)) {
        *old += share * (new - *old);
    }
}

/// One residual with its derivatives, in expected errors.
pub(super) struct Row {
    pub kind: usize,
    pub at: usize,
    pub residual: f64,
    pub weight: f64,
    pub by: Vector,
}

/// Residuals and their derivatives by central differences, splits and errors held.
pub(super) fn linearise(model: &Model<'_>, theta: &Theta, held: &[Held]) -> Vec<Row> {
    let steps: Theta = std::array::from_fn(|k| 1e-5 * theta[k].abs().max(0.01));
    let mut rows = Vec::with_capacity(3 * held.len());
    for sample in held {
        let at = model.evaluate(theta, sample).residual;
        let mut by = [Vector::zeros(); KINDS];
        for k in 0..COUNT {
            let mut moved = *theta;
            moved[k] += steps[k];
            let above = model.evaluate(&moved, sample).residual;
            moved[k] = theta[k] - steps[k];
            let below = model.evaluate(&moved, sample).residual;
            for kind in 0..KINDS {
                by[kind][k] = (above[kind] - below[kind]) / (2.0 * steps[k]);
            }
        }
        for kind in 0..KINDS {
            let sigma = sample.sigma[kind];
            if sigma.is_finite() && at[kind].is_finite() && by[kind].iter().all(|x| x.is_finite()) {
                rows.push(Row {
                    kind,
                    at: sample.at,
                    residual: at[kind] / sigma,
                    weight: 1.0,
                    by: by[kind] / sigma,
                });
            }
        }
    }
    rows
}

/// Bisquare weights on each residual's own scale, never below what was expected.
pub(super) fn weigh(rows: &mut [Row]) -> [f64; KINDS] {
    std::array::from_fn(|kind| {
        let residuals: Vec<f64> =
            rows.iter().filter(|r| r.kind == kind).map(|r| r.residual).collect();
        if residuals.is_empty() {
            return f64::NAN;
        }
        let mut scratch = vec![0.0; residuals.len()];
        let found = mad(&residuals, &mut scratch);
        let scale = found.max(1.0);
        for row in rows.iter_mut().filter(|r| r.kind == kind) {
            let own = weight(row.residual / scale, TUNING);
            row.weight = own / (scale * scale * SHARED[kind]);
        }
        found
    })
}

struct System {
    hessian: Matrix,
    gradient: Vector,
}

impl System {
    fn new(rows: &[Row], theta: &Theta, prior: &Prior, precision: &Vector) -> Self {
        let mut system =
            System { hessian: Matrix::from_diagonal(precision), gradient: Vector::zeros() };
        for k in 0..COUNT {
            system.gradient[k] = precision[k] * (theta[k] - prior.mean[k]);
        }
        for row in rows {
            system.hessian.syger(row.weight, &row.by, &row.by, 1.0);
            system.gradient.axpy(row.weight * row.residual, &row.by, 1.0);
        }
        system.hessian.fill_upper_triangle_with_lower_triangle();
        system
    }

    fn step(&self) -> Option<Vector> {
        Some(-self.hessian.cholesky()?.solve(&self.gradient))
    }
}

/// See the head of the file; and the number of manoeuvres.
fn covariance(
    rows: &[Row],
    system: &System,
    precision: &Vector,
    columns: &Columns,
) -> Option<(Matrix, usize)> {
    let inverse = system.hessian.cholesky()?.inverse();
    let groups = columns.cluster.last().map_or(0, |last| last + 1);
    let mut parts = vec![(Matrix::zeros(), Vector::zeros(), false); groups];
    for row in rows {
        let part = &mut parts[columns.cluster[row.at]];
        part.0.syger(row.weight, &row.by, &row.by, 1.0);
        part.1.axpy(row.weight * row.residual, &row.by, 1.0);
        part.2 |= row.kind != A;
    }
    parts.retain(|part| part.2);
    let n = parts.len() as f64;
    let mut jackknife = Matrix::zeros();
    for (own, gradient, _) in &mut parts {
        own.fill_upper_triangle_with_lower_triangle();
        let change = (system.hessian - *own).cholesky()?.solve(gradient);
        jackknife += change * change.transpose();
    }
    let with_prior =
        jackknife * ((n - 1.0) / n) + inverse * Matrix::from_diagonal(precision) * inverse;
    // never below the inverse: what is below it in variance is scaled up, correlations kept
    let grow = Vector::from_fn(|k, _| (inverse[(k, k)] / with_prior[(k, k)]).max(1.0).sqrt());
    let grow = Matrix::from_diagonal(&grow);
    Some((grow * with_prior * grow, parts.len()))
}

/// Level that each manoeuvre kept up: of [`KEPT`] samples one after the other the least, where that is largest.
fn kept_up<'a>(values: &[(f64, &'a Held)], columns: &Columns) -> Vec<(f64, &'a Held)> {
    values
        .chunk_by(|a, b| columns.cluster[a.1.at] == columns.cluster[b.1.at])
        .filter_map(|manoeuvre| {
            let whole = |w: &&[(f64, &Held)]| w[KEPT - 1].1.at - w[0].1.at == STEP * (KEPT - 1);
            let least =
                |w: &[(f64, &'a Held)]| w.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0));
            let windows = manoeuvre.windows(KEPT).filter(whole);
            windows.filter_map(least).max_by(|a, b| a.0.total_cmp(&b.0))
        })
        .collect()
}

/// The lower bound of the peak friction: what several manoeuvres kept up, upright, less its error.
///
/// METHOD: one sample of a log at 10 Hz is an impulse of the suspension as often as a force of the tyre.
pub(crate) fn bound(model: &Model<'_>, fitted: &Fitted, wheel: usize, driven: bool) -> Option<f64> {
    let sign = if driven { 1.0 } else { -1.0 };
    let theta = &fitted.theta;
    let near = |held: &&Held| {
        let lean = (model.columns.roll[held.at] - theta[LEAN_ZERO]).abs();
        let free_front = wheel == 0 && held.split == Split::Free;
        let [front, rear] = model.evaluate(theta, held).load;
        // what a wheel in the air would have to do says nothing
        let loaded = [front, rear][wheel] > LEAST_SHARE * theta[MASS] * crate::GRAVITY;
        lean < 25_f64.to_radians() && !free_front && loaded && model.columns.steady[held.at]
    };
    // of the front brake both the balance and the pressure must say so: near the peak slip and
    // acceleration of the front wheel feed each other
    let used = |theta: &Theta, held: &Held| {
        let found = model.evaluate(theta, held);
        let witness = match held.split {
            Split::Braked if wheel == 0 => 1.0 - found.residual[C] / found.force[0],
            _ => 1.0,
        };
        sign * found.used[wheel] * witness.clamp(0.0, 1.0)
    };
    let values: Vec<(f64, &Held)> = fitted
        .held
        .iter()
        .filter(near)
        .map(|held| (used(theta, held), held))
        .filter(|(x, _)| x.is_finite() && *x > 0.0)
        .collect();
    let mut kept = kept_up(&values, model.columns);
    kept.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (middle, held) = *kept.get(REACHED_BY - 1)?;
    let steps: Theta = std::array::from_fn(|k| 1e-5 * theta[k].abs().max(0.01));
    let by = Vector::from_fn(|k, _| {
        let mut moved = *theta;
        moved[k] += steps[k];
        (used(&moved, held) - middle) / steps[k]
    });
    let Evaluation { load, .. } = model.evaluate(theta, held);
    let single = 0.2 * theta[MASS] / load[wheel].max(1.0);
    let error = ((by.transpose() * *fitted.covariance * by)[0] + single * single).sqrt();
    let bound = middle - 1.645 * error;
    (bound > 0.05).then_some(bound)
}

/// The samples at given parameters, once the acceleration is at rest: at the truth of an exact ride residuals vanish
/// there.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn held_at(model: &Model<'_>, theta: &Theta, min_speed: f64) -> Vec<Held> {
    let mut acceleration = first_acceleration(model.columns, theta);
    for _ in 0..12 {
        renew(model, theta, &mut acceleration, 0.5, min_speed);
    }
    hold(model, theta, &acceleration, min_speed)
}
