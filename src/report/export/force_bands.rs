//! Ends of a tyre's forces in look-up tables, from the intervals of the charts ([`curve_bands`](super::curve_bands)) and of
//! the crown.

use super::curve_bands::{Curves, Off};
use super::fitted::Fitted;
use super::tyre::Characterised;
use crate::contract::coefficient::Coefficient as C;
use crate::simulate::effects::ModelError;
use crate::store::tables::rows::Status;
use crate::tyre::paper::{Input, slip_stiffness_under};

/// Share of the friction circle from which a side force is the circle's, not the stiffness's.
const AT_CIRCLE: f64 = 0.999;

/// Factor by which a load may be beyond those under which the wheel was braked: friction then changes by less than the
/// band is wide.
const NEAR_LOAD: f64 = 1.15;

/// Least and largest load, N, at which a longitudinal force has an interval, of the loads under which the wheel was braked.
pub(crate) fn bounded_loads([least, most]: [f64; 2]) -> [f64; 2] {
    [least / NEAR_LOAD, most * NEAR_LOAD]
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

    /// Ends of the longitudinal force, N, of an upright tyre without a slip angle; `None` where they are not known: far
    /// from the loads under which the wheel was braked, too, as the change with load is assumed.
    pub(crate) fn force_x(&self, input: &Input) -> Option<[f64; 2]> {
        let [least, most] = self.tyre.braked_loads.map_or([0.0, f64::INFINITY], bounded_loads);
        if !(least..=most).contains(&input.load) {
            return None;
        }
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
