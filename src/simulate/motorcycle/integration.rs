//! Integration of the reduced-order motorcycle over time: the classical Runge-Kutta scheme.

use super::equations::SLIP_SPEED;
use super::plant::Plant;
use super::state::{Action, N, Response, State};
use crate::GRAVITY;

impl Plant {
    /// How many Runge-Kutta steps a span `dt` needs: the stiffest mode is a wheel's slip.
    fn substeps(&self, s: &State, dt: f64) -> usize {
        let load = 0.7 * self.mass * GRAVITY; // the more loaded wheel, braking hard
        let fastest = (0..2)
            .map(|i| {
                let tyre = &self.tyres[i];
                tyre.friction.steepest() * load * tyre.rolling_radius.powi(2)
                    / (self.wheel_inertia[i] * s.vx.abs().max(SLIP_SPEED))
            })
            .fold(0.0, f64::max);
        // 2.2 is inside the stability bound 2.78 of the classical scheme
        ((dt * fastest / 2.2).ceil() as usize).clamp(2, 60)
    }

    /// Advances the state by `dt` with the action held; gives what followed from them before.
    pub fn advance(&self, state: &mut State, action: &Action, dt: f64) -> Response {
        self.advance_between(state, [action, action], dt, None)
    }

    /// Advances the state by `dt` with an action that goes evenly from one to another (classical
    /// Runge-Kutta, sub-stepped); gives what followed from them before. `load` are the loads of an instant
    /// before, N, where they are known.
    pub fn advance_between(
        &self,
        state: &mut State,
        [from, to]: [&Action; 2],
        dt: f64,
        load: Option<[f64; 2]>,
    ) -> Response {
        let n = self.substeps(state, dt);
        let h = dt / n as f64;
        let caster = self.caster_angle.sin_cos();
        let (mut k1, response) = self.derivative(caster, state, from, load);
        // what loads do to radii changes little within a step
        let mut load = response.load;
        for step in 0..n {
            let y = state.to_array();
            let at = |k: &[f64; N], f: f64| {
                State::from_array(&std::array::from_fn(|i| y[i] + f * h * k[i]))
            };
            let action = |f: f64| from.towards(to, (step as f64 + f) / n as f64);
            let [begin, middle, end] = [0.0, 0.5, 1.0].map(action);
            if step > 0 {
                let (rates, response) = self.derivative(caster, state, &begin, Some(load));
                (k1, load) = (rates, response.load);
            }
            let slopes = |at: &State, action| self.derivative(caster, at, action, Some(load)).0;
            let k2 = slopes(&at(&k1, 0.5), &middle);
            let k3 = slopes(&at(&k2, 0.5), &middle);
            let k4 = slopes(&at(&k3, 1.0), &end);
            *state = State::from_array(&std::array::from_fn(|i| {
                y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            }));
        }
        response
    }
}
