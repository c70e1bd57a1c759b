//! How much each row of the equations counts, and which forces the remaining rows determine.

use nalgebra::{DMatrix, Matrix5, Vector5};

use crate::motorcycle::offroad::equations::{Equations, Matrices, Motion};
use crate::motorcycle::offroad::planar::{Noise, PlanarMotorcycle};

/// Rows mixed and scaled: `B_d` of the paper, lower triangular; zero in lost rows and columns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// `B_d` of the paper: 5 x 5, rows by equation.
    pub b_d: [[f64; 5]; 5],
    /// Whether only its diagonal is used.
    pub diagonal: bool,
}

/// Smallest singular value over the largest at which a combination of forces counts as
/// determined; with all five rows it is 0.16 or more.
const DETERMINED: f64 = 0.03;

/// Force of the rest posture in which weights and determinacy are judged.
fn posture(equations: &Equations) -> Matrices {
    equations.at(&Motion { z_f: 0.1, a_r: 0.17, ..Motion::default() })
}

impl Weights {
    /// `diag(1, 1, 1/w, 1, 1/l_r)`: everything in newtons.
    pub fn lengths(equations: &Equations, lost: [bool; 5]) -> Self {
        let p = &equations.p;
        let mut b_d = [[0.0; 5]; 5];
        for (k, weight) in [1.0, 1.0, 1.0 / p.w, 1.0, 1.0 / p.l_r].into_iter().enumerate() {
            b_d[k][k] = if lost[k] { 0.0 } else { weight };
        }
        Weights { b_d, diagonal: true }
    }

    /// The inverse Cholesky factor of the covariance of the known side,
    /// `M S_q M' + A_s S_s A_s' + A_r S_r A_r'`, scaled to one in its largest entry.
    pub fn whitening(equations: &Equations, noise: &Noise, lost: [bool; 5]) -> Self {
        let at = posture(equations);
        let m = Matrix5::from_fn(|i, j| at.m[i][j]);
        let q = Matrix5::from_diagonal(&Vector5::from(noise.qdd).map(|s| s * s));
        let mut covariance = m * q * m.transpose();
        covariance[(3, 3)] += noise.fs[0] * noise.fs[0];
        covariance[(4, 4)] += noise.fs[1] * noise.fs[1];
        let rider = [[1.0, 0.0, at.ar[0]], [0.0, 1.0, at.ar[1]], [1.0, 0.0, at.ar[2]]];
        for column in rider.into_iter().chain([[0.0, 1.0, at.ar[3]]]) {
            for i in 0..3 {
                for j in 0..3 {
                    covariance[(i, j)] += noise.fr * noise.fr * column[i] * column[j];
                }
            }
        }
        let kept: Vec<usize> = (0..5).filter(|&k| !lost[k]).collect();
        let small = DMatrix::from_fn(kept.len(), kept.len(), |i, j| covariance[(kept[i], kept[j])]);
        let inverse = small.cholesky().and_then(|c| c.l().try_inverse());
        let Some(inverse) = inverse else { return Self::lengths(equations, lost) };
        let scale = inverse.amax().max(f64::MIN_POSITIVE);
        let mut b_d = [[0.0; 5]; 5];
        for (i, &row) in kept.iter().enumerate() {
            for (j, &column) in kept.iter().enumerate() {
                b_d[row][column] = inverse[(i, j)] / scale;
            }
        }
        Weights { b_d, diagonal: false }
    }

    /// `B_d x`.
    #[inline]
    pub fn apply(&self, x: &[f64; 5]) -> [f64; 5] {
        let d = &self.b_d;
        if self.diagonal {
            return std::array::from_fn(|i| d[i][i] * x[i]);
        }
        std::array::from_fn(|i| (0..=i).map(|j| d[i][j] * x[j]).sum())
    }
}

/// Which of the forces of a branch the remaining rows determine.
pub(crate) fn determined(
    machine: &PlanarMotorcycle,
    lost: [bool; 5],
    free: [bool; 5],
) -> [bool; 5] {
    let equations = &machine.equations;
    let weights = Weights::lengths(equations, lost);
    let mut at = posture(equations).at;
    at[4][4] += machine.chain.kappa(equations, 0.17) * equations.p.r_r;
    let columns: Vec<usize> = (0..5).filter(|&j| free[j]).collect();
    // five rows or more, so that the decomposition has every right singular vector
    let a = DMatrix::from_fn(5, columns.len(), |i, j| weights.b_d[i][i] * at[i][columns[j]]);
    let svd = a.svd(false, true);
    let mut out = [false; 5];
    let Some(v_t) = svd.v_t else { return out };
    let least = DETERMINED * svd.singular_values.max();
    for (j, &column) in columns.iter().enumerate() {
        let vague: f64 = (0..columns.len())
            .filter(|&k| svd.singular_values[k] <= least)
            .map(|k| v_t[(k, j)] * v_t[(k, j)])
            .sum();
        out[column] = vague < 1e-3;
    }
    out
}
