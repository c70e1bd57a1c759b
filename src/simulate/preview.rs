//! Steering torque by optimal preview: a rider who sees the road, or knows the lean to come.
//!
//! The lateral motion of straight running is linearised at several speeds and steered with the
//! torque that minimises
//!
//! ```text
//! sum over time of  q (y - y_wanted)^2 + torque^2
//! ```
//!
//! with `y` the lateral position (following a path) or the roll (following a lean). The wanted
//! values ahead enter through gains of their own (Sharp and Valtetsiotis 2001; Sharp 2007, *Optimal
//! stabilization and path-following controls for a bicycle*):
//!
//! ```text
//! P = Q + A'PA - A'PB (1 + B'PB)^-1 B'PA        torque = -K x + sum_i g_i y_wanted(t + i T)
//! K = (1 + B'PB)^-1 B'PA      g_i = (1 + B'PB)^-1 B' ((A - BK)')^(i-1) C' q
//! ```

use nalgebra::{DMatrix, DVector};

use crate::simulate::multibody::modes;
use crate::simulate::multibody::modes::Linear;
use crate::simulate::multibody::trim;
use crate::simulate::multibody::trim::NoTrim;
use crate::simulate::multibody::{Model, State};

/// How far ahead is looked, s.
const HORIZON: f64 = 2.5;
/// Speeds at which the gains are worked out, m/s.
const SPEEDS: [f64; 9] = [3.5, 5.0, 7.0, 9.5, 13.0, 18.0, 25.0, 35.0, 50.0];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Target {
    /// Lateral position of the rear contact, m.
    Path,
    /// Roll, rad.
    Roll,
}

impl Target {
    /// Weight of the squared error over that of the squared torque.
    fn weight(self) -> f64 {
        match self {
            Target::Path => (10.0_f64 / 0.02).powi(2),
            Target::Roll => (10.0_f64 / 0.01).powi(2),
        }
    }
}

/// Gains at one speed.
#[derive(Debug, Clone)]
struct Gains {
    feedback: Vec<f64>,
    preview: Vec<f64>,
    /// Of a value that holds for ever beyond the horizon.
    tail: f64,
}

/// A steering rider of one motorcycle.
#[derive(Debug, Clone)]
pub struct Preview {
    target: Target,
    index: Vec<usize>,
    gains: Vec<Gains>,
    /// Speeds of the gains, m/s.
    speeds: Vec<f64>,
    /// Spacing of the wanted values, s.
    pub period: f64,
}

impl Preview {
    /// Gains for a motorcycle; `period` is the span between decisions, s.
    ///
    /// # Errors
    /// The motorcycle cannot run straight.
    pub fn new(model: &Model, target: Target, period: f64) -> Result<Self, NoTrim> {
        let mut index = Vec::new();
        let mut gains = Vec::new();
        for speed in SPEEDS {
            let trim = trim::steady(model, speed, 0.0, None)?;
            let lateral = modes::linearise(model, &trim.state, &trim.action).lateral();
            gains.push(work_out(&lateral, speed, target, period));
            index = lateral.index;
        }
        Ok(Preview { target, index, gains, speeds: SPEEDS.to_vec(), period })
    }

    /// Number of values ahead that [`Preview::torque`] reads.
    pub fn horizon(&self) -> usize {
        (HORIZON / self.period) as usize
    }

    /// Steering torque; `wanted(i)` is the target `i` periods ahead (1 is the next decision), for
    /// a path to the left of the rear contact in its present heading.
    pub fn torque(&self, state: &State, speed: f64, wanted: impl Fn(usize) -> f64) -> f64 {
        let rates = state.angle_rates();
        let sideways = state.level_velocity(&nalgebra::Vector3::zeros())[1];
        let array = state.to_array();
        let value = |i: usize| match i {
            13 => rates[1],
            15 => rates[0],
            17 => sideways,
            _ => array[i],
        };
        let upper = self.speeds.iter().position(|&s| s >= speed).unwrap_or(self.speeds.len() - 1);
        let upper = upper.max(1);
        let (low, high) = (self.speeds[upper - 1], self.speeds[upper]);
        let part = ((speed - low) / (high - low)).clamp(0.0, 1.0);
        let (a, b) = (&self.gains[upper - 1], &self.gains[upper]);
        let mix = |x: f64, y: f64| x + part * (y - x);
        let mut torque = 0.0;
        for (k, &i) in self.index.iter().enumerate() {
            torque -= mix(a.feedback[k], b.feedback[k]) * value(i);
        }
        let horizon = self.horizon();
        let mut last = 0.0;
        for i in 0..horizon {
            last = wanted(i + 1);
            torque += mix(a.preview[i], b.preview[i]) * last;
        }
        if self.target == Target::Roll {
            torque += mix(a.tail, b.tail) * last;
        }
        torque
    }
}

/// The gains of one speed.
fn work_out(lateral: &Linear, speed: f64, target: Target, period: f64) -> Gains {
    let n = lateral.index.len();
    let at = |i: usize| lateral.index.iter().position(|&k| k == i);
    // two more states where a path is followed: heading, and position of the rear contact
    let more = if target == Target::Path { 2 } else { 0 };
    let size = n + more;
    let mut a = DMatrix::zeros(size + 1, size + 1);
    a.view_mut((0, 0), (n, n)).copy_from(&lateral.a);
    for (k, b) in lateral.by_steer.iter().enumerate() {
        a[(k, size)] = *b;
    }
    let mut c = DVector::zeros(size);
    match target {
        Target::Path => {
            if let (Some(yaw_rate), Some(sideways)) = (at(15), at(17)) {
                a[(n, yaw_rate)] = 1.0;
                a[(n + 1, sideways)] = 1.0;
            }
            a[(n + 1, n)] = speed;
            c[n + 1] = 1.0;
        }
        Target::Roll => {
            if let Some(roll) = at(4) {
                c[roll] = 1.0;
            }
        }
    }
    // the torque is held between decisions
    let step = (a * period).exp();
    let a = step.view((0, 0), (size, size)).into_owned();
    let b = step.view((0, size), (size, 1)).into_owned();
    let q = target.weight();
    let p = riccati(&a, &b, &(&c * c.transpose() * q));
    let scale = 1.0 / (1.0 + (b.transpose() * &p * &b)[(0, 0)]);
    let k = (b.transpose() * &p * &a) * scale;
    let closed = (&a - &b * &k).transpose();
    let mut v = &c * q;
    let mut preview = Vec::new();
    for _ in 0..(HORIZON / period) as usize {
        preview.push(scale * (b.transpose() * &v)[(0, 0)]);
        v = &closed * v;
    }
    let rest = (DMatrix::identity(size, size) - &closed).lu().solve(&v);
    let tail = rest.map_or(0.0, |rest| scale * (b.transpose() * rest)[(0, 0)]);
    // heading and position are zero in the motorcycle's own axes
    Gains { feedback: k.iter().take(n).copied().collect(), preview, tail }
}

/// Stabilising solution of the discrete Riccati equation with unit torque weight, by doubling
/// (Chu, Fan, Lin, Wang 2004).
fn riccati(a: &DMatrix<f64>, b: &DMatrix<f64>, q: &DMatrix<f64>) -> DMatrix<f64> {
    let n = a.nrows();
    let (mut a, mut g, mut h) = (a.clone(), b * b.transpose(), q.clone());
    for _ in 0..60 {
        let Some(w) = (DMatrix::identity(n, n) + &g * &h).try_inverse() else { break };
        let next = &h + a.transpose() * &h * &w * &a;
        let g_next = &g + &a * &w * &g * a.transpose();
        a = &a * &w * &a;
        let change = (&next - &h).amax() / next.amax().max(1e-300);
        (h, g) = ((&next + next.transpose()) * 0.5, (&g_next + g_next.transpose()) * 0.5);
        if change < 1e-13 {
            break;
        }
    }
    h
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn riccati_of_a_double_integrator() {
        // x'' = u sampled at 0.1 s, position weight 1: scipy 1.14, solve_discrete_are
        let a = DMatrix::from_row_slice(2, 2, &[1.0, 0.1, 0.0, 1.0]);
        let b = DMatrix::from_row_slice(2, 1, &[0.005, 0.1]);
        let q = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 0.0]);
        let p = riccati(&a, &b, &q);
        let s = 1.0 / (1.0 + (b.transpose() * &p * &b)[(0, 0)]);
        let rest = &q + a.transpose() * &p * &a
            - a.transpose() * &p * &b * (b.transpose() * &p * &a) * s
            - &p;
        assert!(rest.amax() < 1e-10, "{rest}");
        let k = (b.transpose() * &p * &a) * s;
        let closed = (&a - &b * k).complex_eigenvalues();
        assert!(closed.iter().all(|e| e.norm() < 0.97), "{closed}");
    }
}
