//! 95 % bands of the forces of an exported tyre, made from the bands of its session's charts.
//!
//! The rule is that of the tyre explorer (`reports/charts/explorer.js`); tests hold the two against each other. The source
//! is the table `plots`, whose bands are those of [`crate::fit::bands`].
//!
//! METHOD: a longitudinal force has the band of the friction at the slip ratio that counts under its load, times that load.
//! A side force `-(k_alpha alpha + k_gamma gamma)` has the errors of both stiffnesses. These come from one
//! fit and add up. Where the two pull against each other their errors do not cancel, as their ratio is assumed: they are
//! then added as squares.

use crate::report::plots::fits::{FRICTION_X, K_ALPHA, K_GAMMA, STIFFNESS};
use crate::report::plots::plot::{FIT, Plot, Series};
use crate::store::tables::rows::PlotPoint;

/// A curve of a chart with its band, SI units, by rising abscissa.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    /// Lower ends; `None` where the ride does not bound the curve.
    pub low: Vec<Option<f64>>,
    /// Upper ends, likewise.
    pub high: Vec<Option<f64>>,
}

/// How far the band of a curve reaches below and above it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Off {
    pub(super) below: f64,
    pub(super) above: f64,
}

impl Curve {
    /// One series of a plot, from a session's rows of the table `plots`.
    pub(crate) fn of(points: &[PlotPoint], plot: &Plot, series: &Series) -> Self {
        let mut curve = Curve::default();
        for p in points.iter().filter(|p| p.plot == plot.name && p.series == series.name) {
            let Some(y) = p.y else { continue };
            curve.x.push(p.x);
            curve.y.push(y);
            curve.low.push(p.y_low);
            curve.high.push(p.y_high);
        }
        curve
    }

    /// The curve between its points; `None` outside of them and where the band has no ends.
    pub(super) fn at(&self, x: f64) -> Option<Off> {
        let (first, last) = (*self.x.first()?, *self.x.last()?);
        if !(first..=last).contains(&x) || self.x.len() < 2 {
            return None;
        }
        let i = self.x.partition_point(|v| *v < x).clamp(1, self.x.len() - 1);
        let width = self.x[i] - self.x[i - 1];
        let share = if width > 0.0 { (x - self.x[i - 1]) / width } else { 0.0 };
        let between = |a: f64, b: f64| a + share * (b - a);
        let y = between(self.y[i - 1], self.y[i]);
        let low = between(self.low[i - 1]?, self.low[i]?);
        let high = between(self.high[i - 1]?, self.high[i]?);
        Some(Off { below: y - low, above: high - y })
    }
}

/// The curves of one tyre whose bands bound its forces.
#[derive(Debug, Clone, Default)]
pub struct Curves {
    /// Longitudinal friction over slip ratio.
    pub friction: Curve,
    /// Cornering stiffness per load over camber, 1/rad.
    pub stiffness: Curve,
    /// Camber stiffness per load over camber, 1/rad.
    pub camber: Curve,
}

impl Curves {
    /// Of the front and the rear tyre, from a session's rows of the table `plots`.
    pub(crate) fn of(points: &[PlotPoint]) -> [Self; 2] {
        [0, 1].map(|k| Curves {
            friction: Curve::of(points, &FRICTION_X[k], &FIT),
            stiffness: Curve::of(points, &STIFFNESS[k], &K_ALPHA),
            camber: Curve::of(points, &STIFFNESS[k], &K_GAMMA),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curve_is_known_between_its_points_and_nowhere_else() {
        let curve = Curve {
            x: vec![0.0, 1.0, 2.0],
            y: vec![10.0, 20.0, 20.0],
            low: vec![Some(9.0), Some(18.0), None],
            high: vec![Some(12.0), Some(24.0), None],
        };
        let off = curve.at(0.5).expect("known");
        assert_eq!([off.below, off.above], [1.5, 3.0]);
        let end = curve.at(0.0).expect("the end is part of it");
        assert_eq!([end.below, end.above], [1.0, 2.0]);
        for x in [-0.1, 1.5, 2.1, f64::NAN] {
            assert!(curve.at(x).is_none(), "{x}");
        }
        assert!(Curve::default().at(0.0).is_none());
    }
}
