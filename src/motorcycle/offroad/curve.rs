//! Curves of the bike file: forces by straight lines, the linkage by monotone cubics.

/// Beyond the ends of a curve.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Beyond {
    /// The last slope goes on at both ends.
    Both,
    /// The first slope goes on below, zero above: a top-out stop.
    Below,
    /// Zero below, the last slope goes on above: a bump stop.
    Above,
}

/// Straight lines through pairs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Lines {
    rows: Vec<[f64; 2]>,
    beyond: Beyond,
}

impl Lines {
    /// A curve of at least two rows whose first column increases, as the bike file's check leaves
    /// them.
    pub(crate) fn new(rows: &[[f64; 2]], beyond: Beyond) -> Self {
        Lines { rows: rows.to_vec(), beyond }
    }

    /// The ordinate at `x`.
    #[inline]
    pub(crate) fn at(&self, x: f64) -> f64 {
        let rows = &self.rows;
        let last = rows.len() - 1;
        if x < rows[0][0] && self.beyond == Beyond::Above {
            return 0.0;
        }
        if x > rows[last][0] && self.beyond == Beyond::Below {
            return 0.0;
        }
        let k = rows[1..last].partition_point(|r| r[0] < x);
        let ([x_0, y_0], [x_1, y_1]) = (rows[k], rows[k + 1]);
        y_0 + (y_1 - y_0) * (x - x_0) / (x_1 - x_0)
    }
}

/// Shock travel to swing-arm angle: cubic pieces that rise with the rows and have a continuous
/// slope (Fritsch and Carlson 1980).
#[derive(Debug, Clone, PartialEq)]
pub struct Linkage {
    rows: Vec<[f64; 2]>,
    slopes: Vec<f64>,
}

impl Linkage {
    /// From rows that increase in both columns.
    pub fn new(rows: &[[f64; 2]]) -> Self {
        let secant: Vec<f64> =
            rows.windows(2).map(|w| (w[1][1] - w[0][1]) / (w[1][0] - w[0][0])).collect();
        let n = rows.len();
        let mut slopes = vec![0.0; n];
        for k in 1..n - 1 {
            let (left, right) = (rows[k][0] - rows[k - 1][0], rows[k + 1][0] - rows[k][0]);
            let (a, b) = (2.0 * right + left, right + 2.0 * left);
            slopes[k] = (a + b) / (a / secant[k - 1] + b / secant[k]);
        }
        // at the ends the parabola through three points, kept rising
        let end = |d: f64, next: f64| (1.5 * d - 0.5 * next).clamp(0.3 * d, 3.0 * d);
        slopes[0] = end(secant[0], if n > 2 { slopes[1] } else { secant[0] });
        slopes[n - 1] = end(secant[n - 2], if n > 2 { slopes[n - 2] } else { secant[n - 2] });
        Linkage { rows: rows.to_vec(), slopes }
    }

    /// Angle, its slope and its second derivative at a travel; straight beyond the ends.
    pub fn at(&self, travel: f64) -> [f64; 3] {
        let (rows, last) = (&self.rows, self.rows.len() - 1);
        for end in [0, last] {
            let outside = if end == 0 { travel < rows[0][0] } else { travel > rows[last][0] };
            if outside {
                let slope = self.slopes[end];
                return [rows[end][1] + slope * (travel - rows[end][0]), slope, 0.0];
            }
        }
        let k = rows[1..last].partition_point(|r| r[0] < travel);
        let ([x_0, y_0], [x_1, y_1]) = (rows[k], rows[k + 1]);
        let (d_0, d_1) = (self.slopes[k], self.slopes[k + 1]);
        let h = x_1 - x_0;
        let t = (travel - x_0) / h;
        let rise = (y_1 - y_0) / h;
        let (c, d) = (3.0 * rise - 2.0 * d_0 - d_1, d_0 + d_1 - 2.0 * rise);
        [
            y_0 + h * t * (d_0 + t * (c + t * d)),
            d_0 + t * (2.0 * c + 3.0 * d * t),
            (2.0 * c + 6.0 * d * t) / h,
        ]
    }

    /// The travel at an angle: Newton's method from the straight line between two rows.
    pub fn travel(&self, angle: f64) -> f64 {
        let rows = &self.rows;
        let last = rows.len() - 1;
        let k = rows[1..last].partition_point(|r| r[1] < angle);
        let ([x_0, y_0], [x_1, y_1]) = (rows[k], rows[k + 1]);
        let mut travel = x_0 + (x_1 - x_0) * (angle - y_0) / (y_1 - y_0);
        for _ in 0..20 {
            let [y, slope, _] = self.at(travel);
            let step = (angle - y) / slope;
            travel += step;
            if step.abs() < 1e-14 {
                break;
            }
        }
        travel
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// scipy 1.17.1: `PchipInterpolator(x, y)`, its first and second derivative; the ends differ.
    #[test]
    fn linkage_agrees_with_scipy_inside() {
        let rows = [[0.0, 0.0], [0.03, 0.13], [0.06, 0.25], [0.1, 0.4], [0.13, 0.49]];
        let linkage = Linkage::new(&rows);
        for (x, expected) in SCIPY {
            let got = linkage.at(x);
            for k in 0..3 {
                let scale = [1.0, 4.0, 20.0][k];
                assert!((got[k] - expected[k]).abs() < 1e-6 * scale, "{x} {k}: {got:?}");
            }
            assert!((linkage.travel(got[0]) - x).abs() < 1e-12);
        }
    }

    const SCIPY: [(f64, [f64; 3]); 2] = [
        (0.04, [0.17098461538461543, 4.041025641025641, -10.666666666666677]),
        (0.08, [0.3278056680161943, 3.826821862348178, -14.028340080971663]),
    ];

    #[test]
    fn stops_act_on_their_side_only() {
        let top = Lines::new(&[[-0.01, -1000.0], [0.0, 0.0]], Beyond::Below);
        assert_eq!((top.at(-0.005), top.at(0.1)), (-500.0, 0.0));
        assert!((top.at(-0.02) + 2000.0).abs() < 1e-9);
        let bump = Lines::new(&[[0.25, 0.0], [0.3, 5000.0]], Beyond::Above);
        assert!(bump.at(0.2) == 0.0 && (bump.at(0.275) - 2500.0).abs() < 1e-9);
        let spring = Lines::new(&[[0.0, 200.0], [0.1, 700.0], [0.3, 2700.0]], Beyond::Both);
        assert!((spring.at(-0.1) + 300.0).abs() < 1e-9);
        assert!((spring.at(0.2) - 1700.0).abs() < 1e-9 && (spring.at(0.4) - 3700.0).abs() < 1e-9);
    }
}
