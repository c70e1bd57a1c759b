//! 95 % bands of the forces of an exported tyre, made from the bands of its session's charts.
//!
//! The rule is that of the tyre explorer (`reports/charts/explorer.js`); tests hold the two against each other. The source
//! is the table `plots`, whose bands are those of [`crate::fit::bands`].
//!
//! METHOD: a longitudinal force has the band of the friction at the slip ratio that counts under its load, times that load.
//! A side force `-(k_alpha alpha + k_gamma gamma)` has the errors of both stiffnesses. These come from one
//! fit and add up. Where the two pull against each other their errors do not cancel, as their ratio is assumed: they are
//! then added as squares.

use super::fitted::Fitted;
use super::tyre::Characterised;
use crate::contract::coefficient::Coefficient as C;
use crate::report::plots::fits::{FRICTION_X, K_ALPHA, K_GAMMA, STIFFNESS};
use crate::report::plots::plot::{FIT, Plot, Series};
use crate::simulate::effects::ModelError;
use crate::store::tables::rows::{PlotPoint, Status};
use crate::tyre::paper::{Input, slip_stiffness_under};

/// Share of the friction circle from which a side force is the circle's, not the stiffness's.
const AT_CIRCLE: f64 = 0.999;

/// A curve of a chart with its band, SI units, by rising abscissa.
#[derive(Debug, Clone, Default)]
pub struct Curve {
    /// Abscissae.
    pub x: Vec<f64>,
    /// Values.
    pub y: Vec<f64>,
    /// Lower ends; `None` where the ride does not bound the curve.
    pub low: Vec<Option<f64>>,
    /// Upper ends, likewise.
    pub high: Vec<Option<f64>>,
}

/// How far the band of a curve reaches below and above it.
#[derive(Debug, Clone, Copy)]
struct Off {
    below: f64,
    above: f64,
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
    fn at(&self, x: f64) -> Option<Off> {
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

/// The bands of one exported tyre.
#[derive(Debug)]
pub(crate) struct ForceBands<'a> {
    tyre: &'a Characterised,
    curves: Option<&'a Curves>,
    /// Crown radius less its interval's lower end, and the upper end less it, m.
    crown: Option<[f64; 2]>,
}

impl<'a> ForceBands<'a> {
    /// Of a tyre. It has no bands where a diagnosis added effects to it: no chart bounds that tyre.
    pub(crate) fn new(fitted: &'a Fitted, tyre: &'a Characterised) -> Self {
        let is_plain = tyre.error == ModelError::default();
        let crown = || {
            let row = fitted.row(tyre.axle, C::OverturningStiffness)?;
            let value = row.value.filter(|_| row.status == Status::Ok)?;
            Some([value - row.ci95_low?, row.ci95_high? - value])
        };
        ForceBands {
            tyre,
            curves: is_plain.then(|| fitted.curves_of(tyre.axle)),
            crown: is_plain.then(crown).flatten(),
        }
    }

    /// Ends of the longitudinal force, N, of an upright tyre without a slip angle; `None` where they are not known.
    pub(crate) fn force_x(&self, input: &Input) -> Option<[f64; 2]> {
        let custom = &self.tyre.tyre;
        let extra = input.load / custom.nominal_load - 1.0;
        let stiffer = slip_stiffness_under(custom.slip_stiffness_load, extra);
        let off = self.curves?.friction.at(input.slip_ratio * stiffer)?;
        let force = self.tyre.forces(input).force_x;
        Some([force - input.load * off.below, force + input.load * off.above])
    }

    /// Ends of the side force, N, of a tyre without a slip ratio; `None` where they are not known.
    pub(crate) fn force_y(&self, input: &Input) -> Option<[f64; 2]> {
        let curves = self.curves?;
        let tyre = &self.tyre.tyre.tyre;
        let (angle, camber) = (input.slip_angle, input.camber);
        let cornering = curves.stiffness.at(camber.abs())?;
        let leaning = curves.camber.at(camber.abs())?;
        let most = tyre.circle(input.friction) * input.load;
        let force = self.tyre.forces(input).force_y;
        if force.abs() >= AT_CIRCLE * most {
            return None;
        }
        // a larger stiffness makes a negative force of a positive angle larger
        let of = |x: f64, off: Off| match x > 0.0 {
            true => [x * off.above, x * off.below],
            false => [-x * off.below, -x * off.above],
        };
        let (a, g) = (of(angle, cornering), of(camber, leaning));
        let is_apart = angle * camber < 0.0;
        let [below, above] = [0, 1].map(|i| {
            let sum = if is_apart { a[i].hypot(g[i]) } else { a[i] + g[i] };
            sum * input.load
        });
        // no more than the road holds
        Some([force - below.min(force + most), force + above.min(most - force)])
    }

    /// Ends of the overturning moment, N m, of a tyre without a slip ratio; `None` where they are not known.
    pub(crate) fn moment_x(&self, input: &Input) -> Option<[f64; 2]> {
        let [below, above] = self.crown?;
        let lever = input.load * input.camber.tan();
        let moment = self.tyre.forces(input).moment_x;
        // the moment is minus the crown radius times the lever
        let (one, other) = (moment - lever * above, moment + lever * below);
        Some([one.min(other), one.max(other)])
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
