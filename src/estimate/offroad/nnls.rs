//! Non-negative least squares of a handful of unknowns, from the normal equations, on the stack.
//!
//! `minimise x' G x / 2 - c' x, x >= 0` with `G = A'A`, `c = A'b`. Lawson and Hanson (1974),
//! chapter 23, in the form of Bro and de Jong (1997) that needs `G` and `c` only. The columns
//! here have condition numbers below ten, so that squaring them costs nothing.
//!
//! Nearly always every unknown is positive: that is tried first, and its optimality checked.

/// Unknowns.
pub(crate) const N: usize = 5;

/// A pivot smaller than this share of its diagonal is a column that the others already span: its
/// unknown stays zero.
const RANK: f64 = 1e-11;

/// Solves for the unknowns that are `free`; the others are zero.
#[inline]
pub fn solve(g: &[[f64; N]; N], c: &[f64; N], free: [bool; N]) -> [f64; N] {
    let x = restricted(g, c, free);
    if x.iter().all(|v| *v >= 0.0) {
        return x; // every column is in: nothing outside to be pulled in
    }
    lawson_hanson(g, c, free)
}

#[cold]
fn lawson_hanson(g: &[[f64; N]; N], c: &[f64; N], free: [bool; N]) -> [f64; N] {
    let scale = (0..N).filter(|&i| free[i]).fold(0.0_f64, |s, i| s.max(c[i].abs()));
    let mut passive = [false; N];
    let mut x = [0.0; N];
    // each round enlarges the passive set or lowers the objective: it ends; the bound guards
    // against rounding
    for _ in 0..4 * N {
        let mut best: Option<(usize, f64)> = None;
        for i in 0..N {
            if passive[i] || !free[i] {
                continue;
            }
            let slope = c[i] - (0..N).map(|j| g[i][j] * x[j]).sum::<f64>();
            if slope > 1e-13 * scale && best.is_none_or(|(_, s)| slope > s) {
                best = Some((i, slope));
            }
        }
        let Some((enter, _)) = best else { break };
        passive[enter] = true;
        loop {
            let s = restricted(g, c, passive);
            let mut step = 1.0_f64;
            for i in 0..N {
                if passive[i] && s[i] <= 0.0 {
                    step = step.min(x[i] / (x[i] - s[i]).max(f64::MIN_POSITIVE));
                }
            }
            if step >= 1.0 {
                x = s;
                break;
            }
            for i in 0..N {
                if passive[i] {
                    x[i] += step * (s[i] - x[i]);
                    if s[i] <= 0.0 && x[i] <= 1e-14 * scale.max(1.0) {
                        x[i] = 0.0;
                        passive[i] = false;
                    }
                }
            }
            if passive.iter().all(|p| !p) {
                break;
            }
        }
    }
    x
}

/// Least squares over the chosen unknowns by Cholesky; the others are zero.
#[inline]
fn restricted(g: &[[f64; N]; N], c: &[f64; N], chosen: [bool; N]) -> [f64; N] {
    let mut l = [[0.0; N]; N];
    let mut y = [0.0; N];
    let mut kept = [false; N];
    for j in 0..N {
        if !chosen[j] {
            continue;
        }
        let mut pivot = g[j][j];
        for k in 0..j {
            pivot -= l[j][k] * l[j][k];
        }
        if pivot.is_nan() || pivot <= RANK * g[j][j] {
            for k in 0..j {
                l[j][k] = 0.0;
            }
            continue;
        }
        kept[j] = true;
        let root = pivot.sqrt();
        l[j][j] = root;
        let mut right = c[j];
        for k in 0..j {
            right -= l[j][k] * y[k];
        }
        y[j] = right / root;
        for i in j + 1..N {
            if !chosen[i] {
                continue;
            }
            let mut v = g[i][j];
            for k in 0..j {
                v -= l[i][k] * l[j][k];
            }
            l[i][j] = v / root;
        }
    }
    let mut x = [0.0; N];
    for j in (0..N).rev() {
        if !kept[j] {
            continue;
        }
        let mut v = y[j];
        for i in j + 1..N {
            v -= l[i][j] * x[i];
        }
        x[j] = v / l[j][j];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn normal(a: &[[f64; N]], b: &[f64]) -> ([[f64; N]; N], [f64; N]) {
        let mut g = [[0.0; N]; N];
        let mut c = [0.0; N];
        for (row, b) in a.iter().zip(b) {
            for i in 0..N {
                c[i] += row[i] * b;
                for j in 0..N {
                    g[i][j] += row[i] * row[j];
                }
            }
        }
        (g, c)
    }

    proptest! {
        /// The conditions of Kuhn and Tucker: they hold at the minimum and nowhere else.
        #[test]
        fn the_minimum_is_the_minimum(
            a in proptest::collection::vec(proptest::array::uniform5(-1.0..1.0_f64), 7),
            b in proptest::collection::vec(-10.0..10.0_f64, 7),
            free in proptest::array::uniform5(any::<bool>()),
        ) {
            let (g, c) = normal(&a, &b);
            let x = solve(&g, &c, free);
            for i in 0..N {
                let slope = c[i] - (0..N).map(|j| g[i][j] * x[j]).sum::<f64>();
                prop_assert!(x[i] >= 0.0);
                if !free[i] {
                    prop_assert_eq!(x[i], 0.0);
                } else if x[i] > 0.0 {
                    prop_assert!(slope.abs() < 1e-7, "{i}: {slope}");
                } else {
                    prop_assert!(slope < 1e-7, "{i}: {slope}");
                }
            }
        }
    }

    #[test]
    fn two_equal_columns_do_not_divide_by_zero() {
        let mut a = [[0.0; N]; N];
        for (k, row) in a.iter_mut().enumerate() {
            row[k] = 1.0;
            row[4] = if k == 3 { -1.0 } else { 0.0 }; // the opposite of column 3, and nothing else
        }
        a[4] = [0.0; N];
        for (right, expected) in
            [(5.0, [1.0, 2.0, 3.0, 5.0, 0.0]), (-5.0, [1.0, 2.0, 3.0, 0.0, 5.0])]
        {
            let (g, c) = normal(&a, &[1.0, 2.0, 3.0, right, 0.0]);
            assert_eq!(solve(&g, &c, [true; N]), expected);
        }
    }
}
