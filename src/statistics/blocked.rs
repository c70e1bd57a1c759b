//! Cholesky's factor of a large covariance and solutions by it, block by block: most of the work is products of matrices,
//! which the library does several times faster than its own factor, column by column. The numbers are the same.

use nalgebra::DMatrix;

/// Rows of a block; the share of the work done column by column is this over the size of the matrix.
const ROWS: usize = 32;

/// Lower factor of a positive definite matrix, of which the lower triangle is read; `None` where it is not.
pub(crate) fn cholesky(mut matrix: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let n = matrix.nrows();
    for start in (0..n).step_by(ROWS) {
        let size = ROWS.min(n - start);
        let (next, rest) = (start + size, n - start - size);
        let own = matrix.view((start, start), (size, size)).into_owned().cholesky()?.unpack();
        matrix.view_mut((start, start), (size, size)).copy_from(&own);
        if rest == 0 {
            break;
        }
        let mut below = matrix.view((next, start), (rest, size)).transpose();
        own.solve_lower_triangular_mut(&mut below);
        let left = below.transpose();
        matrix.view_mut((next, start), (rest, size)).copy_from(&left);
        // the upper triangle is changed, too, and taken out below
        matrix.view_mut((next, next), (rest, rest)).gemm(-1.0, &left, &below, 1.0);
    }
    matrix.fill_upper_triangle(0.0, 1);
    Some(matrix)
}

/// Solves `factor x = sides` in place, for a lower factor without zeros on its diagonal.
pub(crate) fn solve_lower(factor: &DMatrix<f64>, sides: &mut DMatrix<f64>) {
    let (n, columns) = sides.shape();
    for start in (0..n).step_by(ROWS) {
        let size = ROWS.min(n - start);
        let (next, rest) = (start + size, n - start - size);
        let mut own = sides.view((start, 0), (size, columns)).into_owned();
        factor.view((start, start), (size, size)).solve_lower_triangular_mut(&mut own);
        sides.view_mut((start, 0), (size, columns)).copy_from(&own);
        if rest > 0 {
            let below = factor.view((next, start), (rest, size));
            sides.view_mut((next, 0), (rest, columns)).gemm(-1.0, &below, &own, 1.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_the_librarys_column_by_column() {
        for n in [1, 31, 32, 33, 70, 129] {
            let of = |i: usize, j: usize| {
                let lag = i.abs_diff(j) as f64;
                (-lag / 9.0).exp() * (1.0 + (i + j) as f64 / 50.0) + f64::from(i == j)
            };
            let matrix = DMatrix::from_fn(n, n, of);
            let usual = matrix.clone().cholesky().expect("positive definite").unpack();
            let factor = cholesky(matrix).expect("positive definite");
            assert!((&factor - &usual).amax() < 1e-12, "{n}");
            let sides = DMatrix::from_fn(n, 7, |i, j| (i as f64 * 0.7 + j as f64).sin());
            let mut solved = sides.clone();
            solve_lower(&factor, &mut solved);
            assert!((&usual * &solved - &sides).amax() < 1e-11, "{n}");
        }
        // not positive definite behind the first block
        let mut matrix = DMatrix::<f64>::identity(40, 40);
        matrix[(39, 39)] = -1.0;
        assert!(cholesky(matrix).is_none());
    }
}
