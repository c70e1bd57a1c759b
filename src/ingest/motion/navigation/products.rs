//! Products of the filter's matrices, written out: nalgebra's own of fixed sizes go through strided loops that are
//! neither unrolled nor vectorised, and took nine tenths of the navigation's time. Sums are in the same order.

use nalgebra::{SMatrix, SVector};

/// `a b`.
pub(super) fn product<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, R, K>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    let mut out = SMatrix::zeros();
    for (to, by) in columns(&mut out).iter_mut().zip(&b.data.0) {
        for (column, x) in a.data.0.iter().zip(by) {
            add(to, *x, column);
        }
    }
    out
}

/// `a' b`.
pub(super) fn product_transposed<const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<f64, K, R>,
    b: &SMatrix<f64, K, C>,
) -> SMatrix<f64, R, C> {
    product(&a.transpose(), b)
}

/// `m v`; of most slopes of a measurement few are not nil.
pub(super) fn times<const R: usize, const C: usize>(
    m: &SMatrix<f64, R, C>,
    v: &SVector<f64, C>,
) -> SVector<f64, R> {
    let mut out = [0.0; R];
    for (column, x) in m.data.0.iter().zip(&v.data.0[0]) {
        if *x != 0.0 {
            add(&mut out, *x, column);
        }
    }
    SVector::from(out)
}

/// Adds `factor x y'` to `m`.
pub(super) fn add_outer<const R: usize, const C: usize>(
    m: &mut SMatrix<f64, R, C>,
    factor: f64,
    x: &SVector<f64, R>,
    y: &SVector<f64, C>,
) {
    for (column, y) in columns(m).iter_mut().zip(&y.data.0[0]) {
        if *y != 0.0 {
            add(column, factor * y, &x.data.0[0]);
        }
    }
}

fn columns<const R: usize, const C: usize>(m: &mut SMatrix<f64, R, C>) -> &mut [[f64; R]; C] {
    &mut m.data.0
}

/// Adds `factor x` to `to`.
#[inline]
fn add<const R: usize>(to: &mut [f64; R], factor: f64, x: &[f64; R]) {
    to.iter_mut().zip(x).for_each(|(to, x)| *to += factor * x);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn they_are_those_of_the_library() {
        let mut random = Random::new(1, "products");
        let a = SMatrix::<f64, 9, 42>::from_fn(|_, _| random.normal());
        let b = SMatrix::<f64, 42, 42>::from_fn(|_, _| random.normal());
        let c = SMatrix::<f64, 9, 42>::from_fn(|_, _| random.normal());
        let v = SVector::<f64, 42>::from_fn(|i, _| if i % 3 == 0 { random.normal() } else { 0.0 });
        assert_eq!(product(&a, &b), a * b);
        assert!((product_transposed(&a, &c) - a.tr_mul(&c)).abs().max() < 1e-13);
        assert!((times(&b, &v) - b * v).abs().max() < 1e-13);
        let (mut sum, mut expected) = (b, b);
        add_outer(&mut sum, -0.3, &b.column(1).into_owned(), &v);
        expected.ger(-0.3, &b.column(1), &v, 1.0);
        assert!((sum - expected).abs().max() < 1e-13);
    }
}
