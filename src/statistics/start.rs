//! A start for robust linear fits that outliers cannot choose.
//!
//! The bisquare has local minima: from a least-squares start a third of one-sided or
//! high-leverage outliers can capture it. Here many small subsets are fitted exactly, each is
//! improved by a step that keeps the better half of the samples (the C-step of fast-LTS), the
//! best few by more such steps, and the one with the smallest S-scale wins. Half of the samples may be bad.
//!
//! The subsets are drawn by a generator with a fixed seed: the same data, the same start.
//! Large data are thinned first; a start need not be precise.
//!
//! Source: Rousseeuw & Van Driessen (2006), Data Mining and Knowledge Discovery 12; the
//! choice by S-scale: Salibián-Barrera & Yohai (2006), JCGS 15.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use super::loss::s_scale;
use super::order::median;

/// Samples that take part in the search.
const MAX_ROWS: usize = 300;
/// Subsets that are improved until they rest.
const KEEP: usize = 3;

/// Robust first coefficients of `y = X b`, or `None` where no subset was solvable.
///
/// `x` are the columns, `root_weight` scales each sample (1 where there is none); all as long
/// as `y`, and finite.
pub(crate) fn coefficients(
    x: &[&[f64]],
    y: &[f64],
    root_weight: Option<&[f64]>,
) -> Option<Vec<f64>> {
    let (n, p) = (y.len(), x.len());
    let mut rng = Pcg64::seed_from_u64(0x5eed_b159);
    let rows: Vec<usize> = if n <= MAX_ROWS {
        (0..n).collect()
    } else {
        // one random row of each of MAX_ROWS equal stretches: spread over the whole ride
        (0..MAX_ROWS).map(|k| rng.random_range(k * n / MAX_ROWS..(k + 1) * n / MAX_ROWS)).collect()
    };
    let m = rows.len();
    let scale = |i: usize| root_weight.map_or(1.0, |w| w[i]);
    let design = DMatrix::from_fn(m, p, |k, j| x[j][rows[k]] * scale(rows[k]));
    let target = DVector::from_fn(m, |k, _| y[rows[k]] * scale(rows[k]));

    let mut work = Work::new(m, p);
    let mut best: Vec<(f64, DVector<f64>)> = Vec::with_capacity(KEEP + 1);
    for _ in 0..subsets(p) {
        work.subset.clear();
        while work.subset.len() < (p + 1).min(m) {
            let k = rng.random_range(0..m);
            if !work.subset.contains(&k) {
                work.subset.push(k);
            }
        }
        let Some(mut b) = work.solve(&design, &target) else { continue };
        // one concentration step, then the median says which are worth more
        work.keep_better_half(&design, &target, &b);
        if let Some(next) = work.solve(&design, &target) {
            b = next;
        }
        let value = work.keep_better_half(&design, &target, &b);
        let at = best.partition_point(|(v, _)| *v <= value);
        if at < KEEP && value.is_finite() {
            best.insert(at, (value, b));
            best.truncate(KEEP);
        }
    }
    for (value, b) in &mut best {
        *value = work.quality(&design, &target, b);
        for _ in 0..20 {
            work.keep_better_half(&design, &target, b);
            let Some(next) = work.solve(&design, &target) else { break };
            let found = work.quality(&design, &target, &next);
            if found.is_nan() || found >= *value * (1.0 - 1e-9) {
                break;
            }
            (*value, *b) = (found, next);
        }
    }
    best.into_iter().min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, b)| b.as_slice().to_vec())
}

/// Subsets that hold, with 99.9 % certainty, one of `p + 1` samples of which none is among
/// the 40 % bad ones.
fn subsets(p: usize) -> usize {
    let clean = 0.6_f64.powi(p as i32 + 1);
    ((0.001_f64.ln() / (1.0 - clean).ln()).ceil() as usize).clamp(20, 400)
}

struct Work {
    subset: Vec<usize>,
    residuals: Vec<f64>,
    scratch: Vec<f64>,
    normal: DMatrix<f64>,
    right: DVector<f64>,
}

impl Work {
    fn new(m: usize, p: usize) -> Self {
        Work {
            subset: Vec::with_capacity(m),
            residuals: vec![0.0; m],
            scratch: vec![0.0; m],
            normal: DMatrix::zeros(p, p),
            right: DVector::zeros(p),
        }
    }

    /// Least squares over the subset.
    fn solve(&mut self, x: &DMatrix<f64>, y: &DVector<f64>) -> Option<DVector<f64>> {
        let p = x.ncols();
        for a in 0..p {
            for b in 0..=a {
                let sum: f64 = self.subset.iter().map(|&k| x[(k, a)] * x[(k, b)]).sum();
                self.normal[(a, b)] = sum;
                self.normal[(b, a)] = sum;
            }
            self.right[a] = self.subset.iter().map(|&k| x[(k, a)] * y[k]).sum();
        }
        let d: Vec<f64> = (0..p).map(|a| self.normal[(a, a)].sqrt()).collect();
        if d.iter().any(|d| d.is_nan() || *d == 0.0) {
            return None;
        }
        let scaled = DMatrix::from_fn(p, p, |a, b| self.normal[(a, b)] / (d[a] * d[b]));
        let cholesky = scaled.cholesky()?;
        if (0..p).any(|a| cholesky.l_dirty()[(a, a)] < 1e-6) {
            return None;
        }
        let right = DVector::from_fn(p, |a, _| self.right[a] / d[a]);
        let mut b = cholesky.solve(&right);
        for a in 0..p {
            b[a] /= d[a];
        }
        Some(b)
    }

    fn residuals(&mut self, x: &DMatrix<f64>, y: &DVector<f64>, b: &DVector<f64>) {
        self.residuals.copy_from_slice(y.as_slice());
        for (j, column) in x.column_iter().enumerate() {
            for (r, v) in self.residuals.iter_mut().zip(column.iter()) {
                *r -= v * b[j];
            }
        }
    }

    fn quality(&mut self, x: &DMatrix<f64>, y: &DVector<f64>, b: &DVector<f64>) -> f64 {
        self.residuals(x, y, b);
        s_scale(&self.residuals, &mut self.scratch)
    }

    /// Makes the better half of the samples the subset; the median of all |residuals|.
    fn keep_better_half(&mut self, x: &DMatrix<f64>, y: &DVector<f64>, b: &DVector<f64>) -> f64 {
        self.residuals(x, y, b);
        for (s, r) in self.scratch.iter_mut().zip(&self.residuals) {
            *s = r.abs();
        }
        let limit = median(&mut self.scratch).unwrap_or(f64::NAN);
        self.subset.clear();
        let residuals = &self.residuals;
        self.subset.extend((0..residuals.len()).filter(|&k| residuals[k].abs() <= limit));
        limit
    }
}
