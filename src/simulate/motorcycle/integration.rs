//! Integration of the reduced-order motorcycle over time: the classical Runge-Kutta scheme, and for the many
//! replays of a diagnosis an exponential one of second order at a fourth of its cost.

use super::equations::{SLIP_SPEED, STEER_LAG};
use super::plant::Plant;
use super::state::{Action, N, Response, State};
use crate::GRAVITY;
use crate::tyre::kinematics::below_mass_centre;
use crate::tyre::pair::both;

impl Plant {
    /// Number of Runge-Kutta steps of a span `dt`: the stiffest mode is a wheel's slip.
    fn substeps(&self, s: &State, dt: f64) -> usize {
        let load = 0.7 * self.vehicle.mass * GRAVITY; // the more loaded wheel, braking hard
        let fastest = (0..2)
            .map(|i| {
                let tyre = &self.tyres[i];
                tyre.friction.steepest() * load * tyre.rolling_radius.powi(2)
                    / (self.vehicle.wheel_inertia[i] * s.vx.abs().max(SLIP_SPEED))
            })
            .fold(0.0, f64::max);
        // 2.2 is inside the stability bound 2.78 of the classical scheme
        ((dt * fastest / 2.2).ceil() as usize).clamp(2, 60)
    }

    /// Advances the state by `dt` with the action held; gives what followed from them before.
    pub fn advance(&self, state: &mut State, action: &Action, dt: f64) -> Response {
        let n = self.substeps(state, dt);
        let h = dt / n as f64;
        let caster = self.vehicle.caster_angle.sin_cos();
        let (mut k1, response) = self.derivative(caster, state, action, None);
        // what loads do to radii changes little within a step
        let mut load = response.load;
        for step in 0..n {
            let y = state.to_array();
            let at = |k: &[f64; N], f: f64| State::from_array(&plus(&y, f * h, k));
            if step > 0 {
                let (rates, response) = self.derivative(caster, state, action, Some(load));
                (k1, load) = (rates, response.load);
            }
            let slopes = |at: &State| self.derivative(caster, at, action, Some(load)).0;
            let k2 = slopes(&at(&k1, 0.5));
            let k3 = slopes(&at(&k2, 0.5));
            let k4 = slopes(&at(&k3, 1.0));
            *state = State::from_array(&std::array::from_fn(|i| {
                y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            }));
        }
        response
    }

    /// How fast a wheel's slip settles per load over speed, 1/kg.
    fn slip_settling(&self) -> [f64; 2] {
        both(|i| {
            let tyre = &self.tyres[i];
            tyre.rolling_radius.powi(2) / self.vehicle.wheel_inertia[i]
        })
    }
}

/// Longest step of the exponential scheme, s: a hundredth, give or take a grid's rounding.
const LONGEST: f64 = 0.0105;

/// Places of what is stiff: the handlebar, the wheels' spins, the tyres' lagged slip angles.
const STIFF: [usize; 5] = [10, 6, 7, 8, 9];

/// Data known at the start of a step.
struct Step {
    h: f64,
    slope: [f64; N],
    phi: [[f64; 2]; STIFF.len()],
    drawn: [f64; STIFF.len()],
    load: [f64; 2],
}

/// The exponential Runge-Kutta scheme of second order (Cox and Matthews 2002, ETD2RK): what is stiff - the wheels'
/// slip, the tyres' lag, the rider's arms - relaxes at a rate that is about right to where the rest of the state
/// draws it, and the rest is integrated by Heun's rule.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exponential<'a> {
    plant: &'a Plant,
    caster: (f64, f64),
    slip_settling: [f64; 2],
}

impl<'a> Exponential<'a> {
    /// For a motorcycle.
    pub(crate) fn new(plant: &'a Plant) -> Self {
        let caster = plant.vehicle.caster_angle.sin_cos();
        Exponential { plant, caster, slip_settling: plant.slip_settling() }
    }

    /// Rates of the stiff modes, 1/s, not positive, in the order of [`STIFF`].
    fn rates(&self, s: &State, response: &Response) -> [f64; STIFF.len()] {
        let speed = s.vx.abs().max(SLIP_SPEED);
        let slip = |i: usize| {
            let slope = self.plant.tyres[i].friction.slope(response.slip_ratio[i]).max(0.0);
            -slope * self.slip_settling[i] * response.load[i] / speed
        };
        let lag = |i: usize| self.plant.tyres[i].slip_angle_rate(s.omega[i], 0.0, 1.0);
        [-1.0 / STEER_LAG, slip(0), slip(1), lag(0), lag(1)]
    }

    /// About where the rest of the state draws the stiff modes, in the order of [`STIFF`]: wheels to rolling, lags to
    /// where the contacts go.
    fn drawn_to(&self, s: &State, load: [f64; 2]) -> [f64; STIFF.len()] {
        let p = self.plant;
        let vehicle = &p.vehicle;
        let (sin_phi, cos_phi) = s.roll.sin_cos();
        let (speed, still) = (s.vx.max(SLIP_SPEED), vehicle.static_loads());
        let contact = both(|i| {
            below_mass_centre(vehicle.cg_height, p.crown[i], vehicle.sag[i], (sin_phi, cos_phi))
        });
        let spin = |i: usize| {
            let along = s.vx - s.yaw_rate * contact[i][0];
            along / p.carcass(i, still[i]).rolling_radius(load[i], 1.0 - cos_phi)
        };
        let angle = |i: usize, ahead: f64| {
            (s.vy + contact[i][1] * s.roll_rate + ahead * s.yaw_rate) / speed
        };
        let front = angle(0, vehicle.cg_to_front) - s.steer * self.caster.1 / cos_phi;
        [0.0, spin(0), spin(1), front, angle(1, vehicle.cg_to_front - vehicle.wheelbase)]
    }

    /// A state whose stiff modes have followed, over `h` s at some rates, what drew them; `rise` is what their slopes
    /// rise by until its end.
    fn follow(
        &self,
        y: &[f64; N],
        mut to: [f64; N],
        step: &Step,
        rise: Option<&[f64; N]>,
    ) -> State {
        let Step { h, slope, phi, drawn, load } = step;
        // the handlebar first: it draws the front tyre
        for (k, i) in STIFF.into_iter().enumerate() {
            let moved = self.drawn_to(&State::from_array(&to), *load)[k] - drawn[k];
            to[i] = y[i] + moved + phi[k][0] * (h * slope[i] - moved);
            if let Some(rise) = rise {
                to[i] += h * phi[k][1] * rise[i];
            }
        }
        State::from_array(&to)
    }

    /// Advances the state by `dt` with an action that goes evenly from one to another; gives what followed from
    /// them before. `load` are the loads of an instant before, N, where they are known.
    pub(crate) fn advance(
        &self,
        state: &mut State,
        [from, to]: [&Action; 2],
        dt: f64,
        load: Option<[f64; 2]>,
    ) -> Response {
        let n = (dt / LONGEST).ceil().max(1.0);
        let h = dt / n;
        let at = |share: f64| from.towards(to, share / n);
        let (mut slope, mut response) = self.plant.derivative(self.caster, state, from, load);
        let before = response;
        for step in 0..n as usize {
            let step = step as f64;
            if step > 0.0 {
                let load = Some(response.load);
                (slope, response) = self.plant.derivative(self.caster, state, &at(step), load);
            }
            let y = state.to_array();
            let rates = self.rates(state, &response);
            let step_of = Step {
                h,
                slope,
                phi: rates.map(|r| phi(r * h)),
                drawn: self.drawn_to(state, response.load),
                load: response.load,
            };
            let first = plus(&y, h, &slope);
            let predicted = self.follow(&y, first, &step_of, None);
            let end = self
                .plant
                .derivative(self.caster, &predicted, &at(step + 1.0), Some(response.load))
                .0;
            let mut rise = plus(&end, -1.0, &slope);
            let second = plus(&y, h, &plus(&slope, 0.5, &rise));
            let (there, drawn) = (predicted.to_array(), self.drawn_to(&predicted, response.load));
            for (k, i) in STIFF.into_iter().enumerate() {
                // what is relaxed already does not count again
                rise[i] -= rates[k] * (there[i] - y[i] - (drawn[k] - step_of.drawn[k]));
            }
            *state = self.follow(&y, second, &step_of, Some(&rise));
        }
        before
    }
}

/// `x + by * y`.
#[inline(always)]
fn plus(x: &[f64; N], by: f64, y: &[f64; N]) -> [f64; N] {
    let mut sum = *x;
    sum.iter_mut().zip(y).for_each(|(sum, y)| *sum += by * y);
    sum
}

/// `(e^z - 1)/z` and `(e^z - 1 - z)/z²`, z not positive.
fn phi(z: f64) -> [f64; 2] {
    if z > -1e-3 {
        return [1.0 + z / 2.0 + z * z / 6.0, 0.5 + z / 6.0 + z * z / 24.0];
    }
    let first = z.exp_m1() / z;
    [first, (first - 1.0) / z]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phi_is_smooth_where_its_series_ends() {
        for (a, b) in phi(-0.999e-3).into_iter().zip(phi(-1.001e-3)) {
            assert!((a - b).abs() < 2e-6, "{a} {b}");
        }
        assert!((phi(-2.0)[0] - 0.432_332_358_381_693_6).abs() < 1e-14);
        assert!((phi(-2.0)[1] - 0.283_833_820_809_153_2).abs() < 1e-14);
    }
}
