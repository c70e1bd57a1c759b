//! What drives, brakes and slips, on the 0.2 s means: common ground of the checks for exchanged channels.
//!
//! ```text
//! (1)  f = dv/dt + c_drag v² / m + g c_rol              force of the tyres per mass, drive positive
//! (2)  D = ln(omega_f / omega_r) = D0 + D1 f + D2 v²    no brake: the rear tyre alone, D1 = -1 / (g K n_r)
//! (3)  n_f = b / l - (f / g) h / l,  n_r = 1 - n_f      loads, parts of the weight
//! ```
//! `K` is the slip stiffness per load. `D0` holds the ratio of the radii, `D2` the tyres' growth. Engine
//! braking obeys (2) as drive does: only the rear tyre feels the engine.

use super::view::{View, quantile};
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::motorcycle::balance::{
    LARGEST_FRICTION, front_load_line, rear_braking_limit, tyre_force_per_mass,
};
use crate::statistics::clustered_fit;

/// Lateral acceleration below which it is straight, m/s²: 11 deg of lean.
const STRAIGHT: f64 = 2.0;
/// A throttle of this much above its least is closed.
const CLOSED: f64 = 0.03;
/// A pressure by which a brake is on, Pa above rest.
const ON: f64 = 1e5;
/// A pressure by which it is off, Pa above rest, and share of its range where that is more.
const OFF: (f64, f64) = (2.5e4, 0.02);
/// Means before and after one that its rate of change and a late velocity reach to.
const REACH: (usize, usize) = (5, 3);
/// Samples of one cluster of (2): 5 s.
const CLUSTER: usize = 25;

/// A brake by its line pressure.
pub(crate) struct Brake {
    /// Where it is on.
    pub on: Vec<bool>,
    /// Where it is off, and was and stays so for as long as rates of change reach.
    pub off: Vec<bool>,
}

/// Forces, slip and who brakes.
pub(crate) struct Motion<'a> {
    bike: &'a Bike,
    pub v: &'a [f64],
    /// (1), m/s².
    pub force: Vec<f64>,
    /// `D`, where both wheels and the straight are known; NaN elsewhere.
    pub slip: Vec<f64>,
    /// Front and rear.
    pub brakes: [Option<Brake>; 2],
    /// Where the throttle is closed, if there is one.
    pub closed: Option<Vec<bool>>,
}

/// The unbraked wheels, (2).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Free {
    pub zero: f64,
    /// `D1`, s²/m.
    pub by_force: f64,
    pub by_speed: f64,
    /// Standard error of `D1`; infinite where it is not known.
    pub error: f64,
    /// 5 to 95 % of `f`, m/s².
    pub range: [f64; 2],
    pub n: usize,
}

impl<'a> Motion<'a> {
    pub(crate) fn new(view: &'a View, bike: &'a Bike) -> Option<Self> {
        let v = view.get(Channel::VelocityX)?;
        let force =
            view.rate_of(v).iter().zip(v).map(|(a, v)| tyre_force_per_mass(bike, *v, *a)).collect();
        let wheels = view.get(Channel::WheelSpeedFront).zip(view.get(Channel::WheelSpeedRear));
        let nominal = (bike.front.radius / bike.rear.radius).ln();
        let lateral = view.lateral();
        let slip = (0..view.len())
            .map(|i| match (wheels, &lateral) {
                (Some((front, rear)), Some(lateral))
                    // a missing sample is no straight
                    if lateral[i].abs() < STRAIGHT && front[i] > 0.0 && rear[i] > 0.0 =>
                {
                    (front[i] / rear[i]).ln() + nominal
                }
                _ => f64::NAN,
            })
            .collect();
        let brakes =
            [Channel::BrakePressureFront, Channel::BrakePressureRear].map(|c| brake(view, c));
        let closed = view.get(Channel::Throttle).map(|t| {
            let least = quantile(&mut view.moving(|i| t[i]), 0.02);
            t.iter().map(|t| *t < least + CLOSED).collect()
        });
        Some(Motion { bike, v, force, slip, brakes, closed })
    }

    /// Whether neither brake is on, as far as they are known.
    pub(crate) fn unbraked(&self, i: usize) -> bool {
        self.brakes.iter().flatten().all(|b| b.off[i])
    }

    /// Whether one brake is on and the other is off.
    pub(crate) fn alone(&self, i: usize) -> Option<usize> {
        let [Some(front), Some(rear)] = &self.brakes else { return None };
        match (front.on[i] && rear.off[i], rear.on[i] && front.off[i]) {
            (true, false) => Some(0),
            (false, true) => Some(1),
            _ => None,
        }
    }

    /// Loads in front and behind as parts of the weight, (3).
    pub(crate) fn loads(&self, force: f64) -> [f64; 2] {
        let (at_rest, loss) = front_load_line(self.bike);
        let front = (at_rest - loss * force / GRAVITY).clamp(0.1, 0.9);
        [front, 1.0 - front]
    }

    /// [`rear_braking_limit`] on the best tyre, m/s².
    pub(crate) fn rear_limit(&self) -> f64 {
        rear_braking_limit(self.bike, LARGEST_FRICTION)
    }

    /// Fits (2) to the unbraked samples; without both pressures to those that drive, where nobody brakes.
    pub(crate) fn free(&self, view: &View) -> Option<Free> {
        let known = self.brakes.iter().all(Option::is_some);
        let wanted = |i: usize| {
            (self.force[i] > 0.3 || known) && self.unbraked(i) && self.slip[i].abs() < 0.2
        };
        let at: Vec<f64> = view.moving(|i| if wanted(i) { i as f64 } else { f64::NAN });
        let at: Vec<usize> = at.into_iter().map(|i| i as usize).collect();
        let at: Vec<usize> = at.into_iter().filter(|&i| self.force[i].is_finite()).collect();
        if at.len() < super::view::MIN_MEANS {
            return None;
        }
        let of = |f: &dyn Fn(usize) -> f64| at.iter().map(|&i| f(i)).collect::<Vec<f64>>();
        let (ones, force) = (vec![1.0; at.len()], of(&|i| self.force[i]));
        let (speed, slip) = (of(&|i| self.v[i].powi(2)), of(&|i| self.slip[i]));
        let clusters: Vec<usize> = at.iter().map(|i| i / CLUSTER).collect();
        let fitted = clustered_fit::fit(&[&ones, &force, &speed], &slip, &clusters, 1e-3)?;
        let error = match &fitted.covariance {
            Some(c) if c.covariance[(1, 1)] > 0.0 => c.covariance[(1, 1)].sqrt(),
            _ => f64::INFINITY,
        };
        let range = [0.05, 0.95].map(|q| quantile(&mut force.clone(), q));
        let [zero, by_force, by_speed] = fitted.theta[..] else { return None };
        Some(Free { zero, by_force, by_speed, error, range, n: at.len() })
    }
}

fn brake(view: &View, channel: Channel) -> Option<Brake> {
    let pressure = view.get(channel)?;
    let mut known = view.moving(|i| pressure[i]);
    if known.len() < super::view::MIN_MEANS {
        return None;
    }
    let (rest, full) = (quantile(&mut known, 0.2), quantile(&mut known, 0.998));
    let off = OFF.0.max(OFF.1 * (full - rest));
    let quiet: Vec<bool> = pressure.iter().map(|p| *p < rest + off).collect();
    let (before, after) = REACH;
    let off = (0..quiet.len())
        .map(|i| {
            quiet[i.saturating_sub(before)..(i + after + 1).min(quiet.len())].iter().all(|q| *q)
        })
        .collect();
    Some(Brake { on: pressure.iter().map(|p| *p > rest + ON).collect(), off })
}
