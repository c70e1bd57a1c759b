//! What rides know of effects, once the base is fitted along: small dense algebra on sums over
//! manoeuvres (`book/src/diagnosis.md`, section 2.7).
//!
//! ```text
//! I = S_ee - S_eb (S_bb + priors)^-1 S_be          S = sum of J'J over manoeuvres
//! C_ij = I_ij / sqrt(I_ii I_jj)                    separation = sqrt(I_ii - I_iR I_RR^-1 I_Ri)
//! ```
//! Sizes are in usual ones: `sqrt(I_ii)` is how many standard deviations of the noise an effect of
//! usual size is from nothing, the separation how many it is from its rivals `R`, of whatever size.

use nalgebra::DMatrix;

use crate::diagnose::road::base::Base;
use crate::diagnose::road::parameters::{Parameter, Parameters};
use crate::diagnose::road::problem::{Linear, Problem};
use crate::diagnose::road::samples::Samples;

/// Curvature of a ride in the base's parameters and the effects, `base` of the first.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Curvature {
    matrix: DMatrix<f64>,
}

impl Curvature {
    /// That of samples at some values; `parameters` are the base's and then the effects'.
    pub(crate) fn of(
        samples: &Samples,
        base: &Base,
        values: &Parameters,
        parameters: &[Parameter],
    ) -> Self {
        let problem = Problem::new(samples, &base.start, base.sigma, parameters);
        let linear: Linear = problem.linear(values);
        let (matrix, _) = problem.accumulate(&linear);
        Curvature { matrix }
    }

    /// That of both rides together.
    #[must_use]
    pub(crate) fn and(&self, other: &Curvature) -> Self {
        Curvature { matrix: &self.matrix + &other.matrix }
    }

    /// That of a ride of which the last parameters are its own, and weakly known: they are fitted along.
    #[must_use]
    pub(crate) fn without(&self, own: &[Parameter]) -> Self {
        let (kept, n) = (self.matrix.nrows() - own.len(), own.len());
        let mut inner = self.matrix.view((kept, kept), (n, n)).into_owned();
        for (k, parameter) in own.iter().enumerate() {
            inner[(k, k)] += 1.0 / (parameter.prior * parameter.prior);
        }
        let whole = self.matrix.view((0, 0), (kept, kept)).into_owned();
        let cross = self.matrix.view((kept, 0), (n, kept)).into_owned();
        // a ride of NaN knows nothing
        let Some(inner) = inner.cholesky() else {
            return Curvature { matrix: DMatrix::zeros(kept, kept) };
        };
        Curvature { matrix: whole - cross.transpose() * inner.solve(&cross) }
    }

    /// Information on the effects, whose columns follow those of the nominal parameters; the latter have their priors.
    pub(crate) fn information(&self, base: &[Parameter]) -> Information {
        let (b, p) = (base.len(), self.matrix.nrows());
        let mut inner = self.matrix.view((0, 0), (b, b)).into_owned();
        for (k, parameter) in base.iter().enumerate() {
            inner[(k, k)] += 1.0 / (parameter.prior * parameter.prior);
        }
        let cross = self.matrix.view((0, b), (b, p - b)).into_owned();
        let whole = self.matrix.view((b, b), (p - b, p - b)).into_owned();
        // priors make it positive; a ride of NaN knows nothing
        let Some(inner) = inner.cholesky() else {
            return Information { matrix: DMatrix::zeros(p - b, p - b), taken: vec![None; p - b] };
        };
        let weights = inner.solve(&cross);
        let matrix = whole - cross.transpose() * &weights;
        let spread = inner.inverse();
        let taken = (0..p - b)
            .map(|j| {
                let own = matrix[(j, j)].max(0.0);
                (0..b)
                    .map(|k| {
                        let by = weights[(k, j)];
                        let size = (own * spread[(k, k)] + by * by).sqrt();
                        (base[k].name, if size > 0.0 { by / size } else { 0.0 })
                    })
                    .max_by(|x, y| x.1.abs().total_cmp(&y.1.abs()))
            })
            .collect();
        Information { matrix, taken }
    }
}

/// Information of rides on effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Information {
    matrix: DMatrix<f64>,
    /// Per effect the parameter of the base that can best take its place, and the cosine of their
    /// responses once the rest of the base is fitted.
    pub taken: Vec<Option<(&'static str, f64)>>,
}

impl Information {
    /// Standard deviations that a usual size of effect `j` is from nothing.
    pub fn size(&self, j: usize) -> f64 {
        self.matrix[(j, j)].max(0.0).sqrt()
    }

    /// Cosine of the responses of two effects: 1 or -1 where one ride shows the same of both.
    pub fn cosine(&self, i: usize, j: usize) -> f64 {
        let sizes = self.size(i) * self.size(j);
        if sizes > 0.0 { (self.matrix[(i, j)] / sizes).clamp(-1.0, 1.0) } else { 0.0 }
    }

    /// Standard deviations that a usual size of effect `i` is from its rivals, of whatever sizes.
    pub fn separation(&self, i: usize, rivals: &[usize]) -> f64 {
        let own: Vec<usize> = std::iter::once(i).chain(rivals.iter().copied()).collect();
        let mut left = DMatrix::from_fn(own.len(), own.len(), |a, b| self.matrix[(own[a], own[b])]);
        // one rival after the other is projected out; what earlier ones leave nothing of is skipped
        for k in 1..own.len() {
            let pivot = left[(k, k)];
            if pivot > 1e-9 * self.matrix[(own[k], own[k])].max(f64::MIN_POSITIVE) {
                let column = left.column(k).into_owned();
                left -= &column * column.transpose() / pivot;
            }
        }
        left[(0, 0)].max(0.0).sqrt()
    }

    /// Share of effect `i`'s response that its rivals can make too: 0 to 1, with one rival the size
    /// of the cosine.
    pub fn likeness(&self, i: usize, rivals: &[usize]) -> f64 {
        let size = self.size(i);
        if size == 0.0 {
            return 1.0;
        }
        (1.0 - (self.separation(i, rivals) / size).powi(2)).max(0.0).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn with_one_rival_it_is_the_cosines_formula_and_a_copy_separates_nothing() {
        // the third is twice the first
        let rows = DMatrix::from_row_slice(
            4,
            3,
            &[
                1.0, 0.5, 2.0, //
                0.3, -1.0, 0.6, //
                2.0, 1.0, 4.0, //
                0.1, 0.7, 0.2,
            ],
        );
        let information = Information { matrix: rows.transpose() * &rows, taken: Vec::new() };
        let (i, c) = (information.size(0), information.cosine(0, 1));
        let expected = i * (1.0 - c * c).sqrt();
        assert!((information.separation(0, &[1]) - expected).abs() < 1e-12);
        assert!((information.likeness(0, &[1]) - c.abs()).abs() < 1e-12);
        assert!(information.separation(0, &[2]) < 1e-6);
        assert!((information.cosine(0, 2) - 1.0).abs() < 1e-12);
        // a copy more is no rival more
        let two = information.separation(1, &[0, 2]);
        assert!((two - information.separation(1, &[0])).abs() < 1e-9);
    }

    /// An unknown of one ride alone takes with it what only it and that ride tell.
    #[test]
    fn what_a_ride_fits_for_itself_it_does_not_tell() {
        let rows = DMatrix::from_row_slice(3, 3, &[1.0, 0.0, 1.0, 0.0, 2.0, 0.0, 1.0, 0.0, 1.0]);
        let curvature = Curvature { matrix: rows.transpose() * &rows * 1e6 };
        let own = [crate::diagnose::road::parameters::BASE[0]];
        let left = curvature.without(&own).matrix;
        assert!(left[(0, 0)] < 1.0 && (left[(1, 1)] - 4e6).abs() < 1.0, "{left}");
    }

    #[test]
    fn what_the_base_explains_is_not_known() {
        // one base parameter and one effect with the same response, one of its own beside it
        let rows = DMatrix::from_row_slice(3, 3, &[1.0, 1.0, 0.0, 2.0, 2.0, 0.0, 0.0, 0.0, 3.0]);
        let curvature = Curvature { matrix: rows.transpose() * &rows * 1e6 };
        let base = [crate::diagnose::road::parameters::BASE[0]];
        let information = curvature.information(&base);
        assert!(information.size(0) < 1.1, "{}", information.size(0));
        assert!((information.size(1) - 3e3).abs() < 1e-2);
        let (name, cosine) = information.taken[0].expect("base");
        assert!(name == base[0].name && cosine > 0.99, "{name} {cosine}");
    }
}
