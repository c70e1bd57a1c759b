//! Both sides of a comparison on one motorcycle, fitted together: the values of each group of sessions, their joint
//! covariance, and what it is made of.
//!
//! As [`super::super::combine`], but for the spread between rides: both sides have one, and of few rides it leans on the
//! assumed one,
//!
//! ```text
//! sum r_i^2 / (v_i + tau^2) + 3 tau_0^2 / tau^2 = n - groups + 3
//! ```
//!
//! which is `tau_0` of two rides and the rides' own of many.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use crate::contract::coefficient::Coefficient as C;
use crate::fleet::combine::{Key, PooledSolution, Problem, Ride, Scale};

/// Rides that the assumed spread counts for.
pub(super) const ASSUMED: f64 = 3.0;
/// Rounds of the spread between rides.
const ROUNDS: usize = 8;
/// Assumed spread of what describes tyre and course together, a share: slip over camber, and side force by lean.
// METHOD: assumed, so that true values of 40 simulated tyres on two courses, some 25 and 10 % apart, are within intervals
const OF_COURSE: [(C, f64); 3] =
    [(C::SlipCamberC1, 0.15), (C::SlipCamberC3, 0.15), (C::LateralFrictionCt, 0.05)];

/// The groups of one motorcycle.
#[derive(Debug)]
pub(super) struct JointEstimate {
    /// Key of each value.
    pub keys: Vec<Key>,
    pub scales: Vec<Scale>,
    /// Values on their scales.
    pub values: Vec<f64>,
    /// Their covariance, shared errors included.
    pub covariance: DMatrix<f64>,
    /// Variance of each if the shared errors were known.
    pub own: Vec<f64>,
    /// The part of that which the spread between rides makes.
    pub drawn: Vec<f64>,
    /// Degrees of freedom of the spread.
    pub dof: Vec<f64>,
    /// Spread between rides.
    pub tau: Vec<f64>,
    pub rides: Vec<usize>,
    /// Names of the shared errors.
    pub sources: Vec<String>,
    /// By key and shared error: what one standard deviation that is left of it makes of the value.
    pub loadings: DMatrix<f64>,
}

/// Fits them; `None` where their equations have no solution.
pub(super) fn joint(rides: &[Ride<'_>], scale: impl Fn(&Key) -> Scale) -> Option<JointEstimate> {
    let problem = Problem::new(rides, |key, _| scale(key))?;
    let n = problem.keys.len();
    let mut together: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
    for (k, key) in problem.keys.iter().enumerate() {
        together.entry((&key.tyre, &key.coefficient)).or_default().push(k);
    }
    let (mut tau, mut dof) = (vec![0.0; n], vec![ASSUMED; n]);
    let mut found = problem.solve(&tau)?;
    for _ in 0..ROUNDS {
        for keys in together.values() {
            let (spread, free) = between(&problem, &found, keys);
            keys.iter().for_each(|k| (tau[*k], dof[*k]) = (spread, free));
        }
        found = problem.solve(&tau)?;
    }
    if !found.x.iter().all(|x| x.is_finite()) {
        return None;
    }
    let drawn = |k: usize| {
        let variances = problem.places[k].iter().map(|p| problem.residual(&found, k, *p).1);
        let weights: Vec<f64> = variances.map(|v| 1.0 / (v + tau[k] * tau[k]).max(1e-30)).collect();
        let sum: f64 = weights.iter().sum();
        tau[k] * tau[k] * weights.iter().map(|w| (w / sum).powi(2)).sum::<f64>()
    };
    let loading = |k: usize, j: usize| {
        let at = n + j;
        found.covariance[(k, at)] / found.covariance[(at, at)].sqrt()
    };
    Some(JointEstimate {
        values: found.x.iter().take(n).copied().collect(),
        covariance: found.covariance.view((0, 0), (n, n)).clone_owned(),
        own: (0..n).map(|k| found.alone[(k, k)]).collect(),
        drawn: (0..n).map(|k| drawn(k).min(found.alone[(k, k)])).collect(),
        rides: problem.places.iter().map(Vec::len).collect(),
        loadings: DMatrix::from_fn(n, problem.sources.len(), loading),
        sources: problem.sources.iter().map(|s| s.0.clone()).collect(),
        scales: problem.scales,
        keys: problem.keys,
        dof,
        tau,
    })
}

/// Spread between rides of one coefficient in all its groups, and its degrees of freedom.
fn between(problem: &Problem, found: &PooledSolution, keys: &[usize]) -> (f64, f64) {
    let of = |k: &usize| {
        let k = *k;
        problem.places[k].iter().map(move |place| problem.residual(found, k, *place))
    };
    let all: Vec<(f64, f64)> = keys.iter().flat_map(of).collect();
    let free = all.len().saturating_sub(keys.len()) as f64;
    let size = |k: &usize| {
        let name = problem.keys[*k].coefficient.as_str();
        let of_course = OF_COURSE.iter().find(|(c, _)| c.name() == name).map(|(_, share)| *share);
        match (of_course, problem.scales[*k]) {
            (None, _) => problem.few(found, *k),
            (Some(share), Scale::Log(_)) => share,
            (Some(share), Scale::Linear) => share * found.x[*k].abs(),
        }
    };
    let sizes = keys.iter().map(size);
    let assumed = sizes.fold(0.0, f64::max).max(1e-12);
    // of rides that are each alone in their group nothing is left
    let excess = |t2: f64| {
        let left: f64 = all.iter().map(|(r, v)| r * r / (v + t2)).sum();
        left + ASSUMED * assumed * assumed / t2 - free - ASSUMED
    };
    let (mut low, mut high) = (1e-6 * assumed * assumed, assumed * assumed);
    high += all.iter().map(|(r, _)| r * r).sum::<f64>();
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        if excess(middle) > 0.0 { low = middle } else { high = middle }
    }
    (high.sqrt(), free + ASSUMED)
}
