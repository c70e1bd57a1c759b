//! A tyre model at the points that a bench measured.

use crate::statistics::order::median_or_zero;
use crate::tyre::paper::{Input, Output};
use crate::tyre::tydex::Point;
use crate::tyre::tyre_model::TyreModel;

/// A tyre at measured points.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BenchPoints<'a> {
    pub tyre: &'a dyn TyreModel,
    pub points: &'a [Point],
    /// Friction of the bench, 1.
    pub friction: f64,
}

/// A number of both.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Both {
    /// Points that say it.
    pub points: usize,
    pub measured: f64,
    /// Of the tyre at the same points.
    pub model: f64,
}

/// How far a force is off at the points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Difference {
    /// Points that have it.
    pub points: usize,
    pub rms: f64,
    pub largest: f64,
    /// Largest measured one.
    pub peak: f64,
}

/// A force or moment of a point, and of a tyre.
pub(crate) type Quantity = (fn(&Point) -> Option<f64>, fn(&Output) -> f64);

/// Longitudinal force over load.
pub(crate) const FRICTION_X: Quantity = (|p| Some(p.force_x? / p.load), |o| o.force_x);
/// Lateral force over load.
pub(crate) const FRICTION_Y: Quantity = (|p| Some(p.force_y? / p.load), |o| o.force_y);
/// Overturning moment over load, m.
pub(crate) const MOMENT_X: Quantity = (|p| Some(p.moment_x? / p.load), |o| o.moment_x);
/// Yaw moment over load, m.
pub(crate) const MOMENT_Z: Quantity = (|p| Some(p.moment_z? / p.load), |o| o.moment_z);

/// Within so much of zero a slip angle (rad) or a camber (rad) is none, or a force is linear in it.
const ANGLE: f64 = 0.0175;
/// Slip angle (rad) within which side forces are proportional to camber alone.
const NO_ANGLE: f64 = 0.0045;
/// Camber (rad) up to which the side force is linear in it.
const CAMBER: f64 = 0.26;
/// The same of a slip ratio.
const SLIP: f64 = 0.02;
const NO_SLIP: f64 = 0.005;
/// Fewest points of a slope.
const MIN_POINTS: usize = 3;

impl BenchPoints<'_> {
    /// A force of the tyre at a point, over load.
    pub(crate) fn model(&self, p: &Point, of: fn(&Output) -> f64) -> f64 {
        let Point { slip_ratio, slip_angle, camber, load, .. } = *p;
        let input = Input { slip_ratio, slip_angle, camber, load, friction: self.friction };
        of(&self.tyre.forces(&input)) / load
    }

    /// How far a force over load is off; none where it was not measured.
    pub(crate) fn difference(&self, (measured, of): Quantity) -> Option<Difference> {
        let (mut n, mut squares, mut largest, mut peak) = (0, 0.0, 0.0_f64, 0.0_f64);
        for p in self.points {
            let Some(wanted) = measured(p) else { continue };
            let off = self.model(p, of) - wanted;
            n += 1;
            squares += off * off;
            largest = largest.max(off.abs());
            peak = peak.max(wanted.abs());
        }
        (n > 0).then(|| Difference { points: n, rms: (squares / n as f64).sqrt(), largest, peak })
    }

    /// `-d(Fy/Fz)/d(slip angle)` upright, 1/rad.
    pub(crate) fn cornering_stiffness(&self) -> Option<Both> {
        let is_meant = |p: &Point| {
            let small = p.slip_angle.abs() <= ANGLE && p.camber.abs() <= ANGLE;
            small && p.slip_ratio.abs() <= NO_SLIP
        };
        self.slope(is_meant, |p| -p.slip_angle, FRICTION_Y)
    }

    /// `-d(Fy/Fz)/d(camber)` without slip, 1/rad.
    pub(crate) fn camber_stiffness(&self) -> Option<Both> {
        let is_meant = |p: &Point| {
            let small = p.slip_angle.abs() <= NO_ANGLE && p.camber.abs() <= CAMBER;
            small && p.slip_ratio.abs() <= NO_SLIP
        };
        self.slope(is_meant, |p| -p.camber, FRICTION_Y)
    }

    /// `d(Fx/Fz)/d(slip ratio)` upright, 1.
    pub(crate) fn slip_stiffness(&self) -> Option<Both> {
        let is_meant = |p: &Point| {
            let small = p.slip_angle.abs() <= NO_ANGLE && p.camber.abs() <= ANGLE;
            small && p.slip_ratio.abs() <= SLIP
        };
        self.slope(is_meant, |p| p.slip_ratio, FRICTION_X)
    }

    /// The largest force over load that was measured, and that of the tyre at the same points.
    pub(crate) fn peak(&self, (measured, of): Quantity) -> Option<Both> {
        let found: Vec<(f64, f64)> = self
            .points
            .iter()
            .filter_map(|p| Some((measured(p)?.abs(), self.model(p, of).abs())))
            .collect();
        let most = |x: fn(&(f64, f64)) -> f64| found.iter().map(x).fold(0.0, f64::max);
        (!found.is_empty()).then(|| Both {
            points: found.len(),
            measured: most(|f| f.0),
            model: most(|f| f.1),
        })
    }

    /// Slopes of the lines through the measured points and through the tyre's at the same.
    fn slope(
        &self,
        is_meant: impl Fn(&Point) -> bool,
        x: impl Fn(&Point) -> f64,
        (measured, of): Quantity,
    ) -> Option<Both> {
        let meant = self.points.iter().filter(|p| is_meant(p));
        let found: Vec<[f64; 3]> =
            meant.filter_map(|p| Some([x(p), measured(p)?, self.model(p, of)])).collect();
        if found.len() < MIN_POINTS {
            return None;
        }
        let n = found.len() as f64;
        let mean = |i: usize| found.iter().map(|f| f[i]).sum::<f64>() / n;
        let means = [0, 1, 2].map(mean);
        let product =
            |i: usize| -> f64 { found.iter().map(|f| (f[0] - means[0]) * (f[i] - means[i])).sum() };
        let spread = product(0);
        (spread > 1e-12).then(|| Both {
            points: found.len(),
            measured: product(1) / spread,
            model: product(2) / spread,
        })
    }

    /// Median load, N.
    pub(crate) fn load(&self) -> f64 {
        let loads: Vec<f64> = self.points.iter().map(|p| p.load).collect();
        median_or_zero(&loads)
    }

    /// Cambers, degrees, at which slip angles were swept, each with its points; the fullest first.
    pub(crate) fn sweeps(&self) -> Vec<(i64, Vec<Point>)> {
        let mut at: std::collections::BTreeMap<i64, Vec<Point>> = Default::default();
        for p in self.points.iter().filter(|p| p.slip_ratio.abs() <= NO_SLIP) {
            at.entry(p.camber.to_degrees().round() as i64).or_default().push(*p);
        }
        let spread = |points: &[Point]| {
            let angles = || points.iter().map(|p| p.slip_angle);
            angles().fold(f64::MIN, f64::max) - angles().fold(f64::MAX, f64::min)
        };
        let mut sweeps: Vec<_> = at
            .into_iter()
            .filter(|(_, points)| points.len() >= MIN_POINTS && spread(points) > NO_ANGLE)
            .collect();
        sweeps.sort_by_key(|(camber, points)| (std::cmp::Reverse(points.len()), *camber));
        sweeps
    }

    /// Points at which the slip ratio was swept, upright and straight on.
    pub(crate) fn braked(&self) -> Vec<Point> {
        let straight = |p: &&Point| p.slip_angle.abs() <= NO_ANGLE && p.camber.abs() <= ANGLE;
        self.points.iter().filter(straight).copied().collect()
    }
}
