//! Every sample's forces, slips and four residuals.
//!
//! ```text
//! Fz_f = m g b/l - m ax' h cos(phi)/l,  Fz_r = m g - Fz_f            ax' is ax, 75 ms late
//! R_i(phi, Fz, v) = R_i (1 + g_i v^2) - rho_i (1 - cos phi) - e (Fz_i - Fz_i0)
//! F = m ax + c_drag u v^2 + c_rol m g                                slip forces of both wheels
//! K_i(Fz) = K_i (1 + k_N,i (Fz/Fz0 - 1))                              slip stiffness per load
//! T_i = t k_t,i Fz_i phi sin(phi)/r_i                                the twisting moment's part along the axle
//! Fx_f(free)  = -I_f w_f' / R_f - T_f
//! Fx_r(model) = -(e0 + e1 n) i/r_r - J i^2 w_r'/r_r - k_r (p_r - p0)/r_r - I_r w_r'/R_r - T_r
//! Fx_f(model) = Fx_f(free) - k_f (p_f - p0)/r_f
//!
//! A  v(t + L) - v_f (1 - (h_a - rho) k sin(phi))                     everywhere
//! B  v_r - v_f / (1 + (l/r)^2/2),  v_i = w_i R_i / (1 + s_i(Fx_i))   everywhere
//! C  Fx_f - Fx_f(model)                                              front brake, throttle closed
//! D  Fx_r - Fx_r(model)                                              throttle closed, front brake off
//! k = g (h - rho) sin(phi) / (rho + (h - rho + sum(I_i/R_i)/m) cos(phi)) / v^2    path's curvature: balance of roll
//! ```
//! A tyre's crown stands on its side in a corner and the wheels' spin rights the motorcycle: it is leant by a tenth to a
//! fifth more than `v^2 k/g` says. Without front brake the front wheel is free and the rear one takes the rest of
//! `F`; under the front brake with closed throttle the rear one is the engine's and its own brake's, and the front one
//! takes the rest. Rolling resistance needs no slip, because radii are those of a freely rolling wheel: it is in
//! the balance and not in the slip forces.

use super::columns::{Columns, FREE_PRESSURE};
use super::curve::Slip;
use super::parameters::*;
use crate::GRAVITY;
use crate::contract::bike::{Axle, Bike};
use crate::motorcycle::balance::{Lengths, pitching};
use crate::tyre::paper::slip_stiffness_under;

pub(crate) const KINDS: usize = 4;
/// Velocity against the front wheel.
pub const A: usize = 0;
/// Rear against front wheel.
pub const B: usize = 1;
/// Front brake.
pub const C: usize = 2;
/// Engine and rear brake.
pub const D: usize = 3;

/// Lag of the loads, s.
const LOAD_LAG: f64 = 0.075;
/// Loaded over rolling radius.
const LOADED: f64 = 0.985;
/// Lean from which a rider is out in the wind, rad.
const OUT: f64 = 0.349;
/// Braking that is surely braking where there is no pressure, N.
const SURELY: f64 = 500.0;
/// Least load of the rear wheel over the weight, for B.
const LEAST_LOAD: f64 = 0.15;
/// Steepness of the curve below which braking tells nothing of the stiffness.
const FLAT: f64 = 0.4;
/// Lean up to which forces are compared, rad.
const UPRIGHT: f64 = 0.698;

/// How the forces of a sample are split between the wheels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Split {
    /// The front wheel is free.
    Free,
    /// The front wheel takes what the rear wheel's model leaves.
    Braked,
    /// The same without pressures: a share of the excess is the rear brake's.
    Guessed,
}

/// Quantities of a sample that are held fixed while the parameters move.
#[derive(Debug, Clone, Copy)]
pub struct Held {
    pub at: usize,
    /// Split of the forces.
    pub split: Split,
    /// Forward acceleration that forces have to give, on a slope with gravity's part, and 75 ms late, m/s².
    pub acceleration: [f64; 2],
    /// Its rate, m/s³.
    pub jerk: f64,
    /// Speed of the contact line, m/s.
    pub speed: f64,
    /// Expected error of each residual; infinite where it is not used.
    pub sigma: [f64; KINDS],
}

/// A sample under some parameters.
#[derive(Debug, Clone, Copy)]
pub struct Evaluation {
    /// Residuals in their own units.
    pub residual: [f64; KINDS],
    /// Loads, N.
    pub load: [f64; 2],
    /// Slip forces, N.
    pub force: [f64; 2],
    pub slip: [Slip; 2],
    /// Friction, load and lean taken out: what an upright tyre at its static load would have.
    pub used: [f64; 2],
    /// Rolling radius of the front, over `1 + s`: velocity over wheel speed, m.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub scale: f64,
    /// Engine's drag, N.
    pub engine: f64,
    /// Excess force of the balance without any brake, N; negative when braking.
    pub excess: f64,
}

/// A ride and its motorcycle.
#[derive(Debug)]
pub struct Model<'a> {
    pub columns: &'a Columns,
    /// Spin inertia of the wheels, kg m².
    pub inertia: [f64; 2],
    /// Twisting stiffness of the tyres, m/rad.
    pub twisting: [f64; 2],
    /// Wheelbase, m.
    pub wheelbase: f64,
    /// Largest lean that counts, rad.
    pub max_lean: f64,
}

impl<'a> Model<'a> {
    /// Of a bike's ride.
    pub fn new(columns: &'a Columns, bike: &Bike, max_lean: f64) -> Self {
        let inertia = Axle::BOTH.map(|axle| bike.wheel_inertia(axle));
        let twisting = Axle::BOTH.map(|axle| bike.wheel(axle).twisting_stiffness);
        Model { columns, inertia, twisting, wheelbase: bike.wheelbase, max_lean }
    }

    /// Lean without its zero.
    fn lean(&self, theta: &Theta, i: usize) -> f64 {
        self.columns.roll[i] - theta[LEAN_ZERO]
    }

    fn gear(&self, i: usize) -> Option<f64> {
        self.columns.gear.as_ref().map(|gear| gear[i])
    }

    fn neutral(&self, i: usize) -> bool {
        self.gear(i).is_some_and(|gear| gear < 0.5)
    }

    /// The velocity at a time, late as it is.
    fn velocity(&self, at: f64) -> f64 {
        let x = &self.columns.speed;
        let (i, f) = (at.floor().max(0.0) as usize, at - at.floor());
        if i + 1 >= x.len() {
            return f64::NAN;
        }
        x[i] + f * (x[i + 1] - x[i])
    }

    /// Forces, slips and residuals of a sample.
    pub fn evaluate(&self, theta: &Theta, held: &Held) -> Evaluation {
        let (c, i) = (self.columns, held.at);
        let (v, [ax, ax_late]) = (held.speed, held.acceleration);
        let lean = self.lean(theta, i);
        let (cos, tan) = (lean.cos(), lean.tan());
        let (mass, l) = (theta[MASS], self.wheelbase);
        let weight = mass * GRAVITY;
        let lengths = Lengths::new(theta[ARM], l);
        let load_0 = lengths.loads(weight, 0.0, 0.0);
        let load = lengths.loads(weight, 0.0, pitching(mass * ax_late, theta[HEIGHT], 0.0, cos));
        let radius = [0, 1].map(|k| {
            theta[R_F + k] * (1.0 + 1e-6 * theta[GROWTH_F + k] * v * v)
                - theta[RHO_F + k] * (1.0 - cos)
                - 1e-6 * theta[SINK] * (load[k] - load_0[k])
        });
        let arm = [0, 1].map(|k| LOADED * theta[R_F + k] - theta[RHO_F + k] * (1.0 - cos));
        let sitting = c.closed[i] || lean.abs() > OUT;
        let posture = if sitting { theta[SIT_UP] } else { 1.0 };
        let total = mass * ax + theta[DRAG] * posture * v * v + theta[ROLLING] * weight;
        let torque = |k: usize| match &c.pressure[k] {
            Some(p) => theta[BRAKE_F + k].exp() * (p[i] - FREE_PRESSURE).max(0.0) / BAR,
            None => 0.0,
        };
        let spin = [0, 1].map(|k| -self.inertia[k] * c.omega_rate[k][i] / theta[R_F + k]);
        // the moment that twists a leant tyre about the vertical turns the wheel backwards
        let twist =
            [0, 1].map(|k| theta[TWIST] * self.twisting[k] * load[k] * lean * lean.sin() / arm[k]);
        let free = spin[0] - twist[0];
        let gear = ratio(self.gear(i));
        let turns = gear * c.omega[1][i] * 60.0 / std::f64::consts::TAU / 1000.0;
        let drag_torque = if gear == 0.0 { 0.0 } else { theta[ENGINE_0] + theta[ENGINE_1] * turns };
        let engine = drag_torque * gear / arm[1];
        let rear_unbraked = spin[1]
            - twist[1]
            - engine
            - theta[ENGINE_INERTIA] * gear * gear * c.omega_rate[1][i] / arm[1];
        let rear_model = rear_unbraked - torque(1) / arm[1];
        let excess = total - free - rear_unbraked;
        let force = match held.split {
            Split::Free => [free, total - free],
            Split::Braked => [total - rear_model, rear_model],
            Split::Guessed => {
                let rear = rear_unbraked + theta[REAR_SHARE] * excess;
                [total - rear, rear]
            }
        };
        let friction =
            [0, 1].map(|k| force[k] / load[k] * (load[k] / load_0[k]).max(0.05).powf(theta[LOAD]));
        let slip = [0, 1].map(|k| {
            let over = load[k] / load_0[k];
            let gain = slip_stiffness_under(theta[GAIN_F + k], over - 1.0);
            let stiffer = gain * over.max(0.05).powf(theta[LOAD]);
            curve(theta, k, force[k] > 0.0).slip(friction[k], tan).of_stiffer(stiffer)
        });
        let speed = [0, 1].map(|k| c.omega[k][i] * radius[k] / (1.0 + slip[k].value).max(0.3));
        let curvature = self.lateral(theta, lean) / (v * v);
        let reference = 1.0 - (theta[ANTENNA] - theta[RHO_F]) * curvature * lean.sin();
        let longer = 1.0 + 0.5 * (l * curvature).powi(2);
        Evaluation {
            residual: [
                self.velocity(i as f64 + theta[LATENCY] * super::columns::RATE)
                    - speed[0] * reference,
                speed[1] - speed[0] / longer,
                force[0] - (free - torque(0) / arm[0]),
                force[1] - rear_model,
            ],
            load,
            force,
            slip,
            used: [0, 1].map(|k| friction[k] / slip[k].left),
            scale: radius[0] / (1.0 + slip[0].value.clamp(-0.15, 0.15)),
            engine,
            excess,
        }
    }

    /// Lateral acceleration of a steady corner at a lean, m/s²: the weight at the centre of mass about the crowns' line
    /// against its centrifugal force and the wheels' gyroscopic moment.
    pub fn lateral(&self, theta: &Theta, lean: f64) -> f64 {
        let on_front = (self.wheelbase - theta[ARM]) / self.wheelbase;
        let crown = on_front * theta[RHO_F] + (1.0 - on_front) * theta[RHO_R];
        let above = theta[HEIGHT] - crown;
        let spinning = (self.inertia[0] / theta[R_F] + self.inertia[1] / theta[R_R]) / theta[MASS];
        GRAVITY * above * lean.sin() / (crown + (above + spinning) * lean.cos())
    }

    /// Split of a sample's forces; `None` where they are not known.
    fn split(&self, theta: &Theta, held: &Held) -> Option<Split> {
        let (c, i) = (self.columns, held.at);
        if c.pressure[0].is_some() {
            return match (c.braked[0][i], c.closed[i]) {
                (false, _) => Some(Split::Free),
                (true, true) => Some(Split::Braked),
                (true, false) => None,
            };
        }
        if !c.closed[i] || self.neutral(i) {
            return Some(Split::Free);
        }
        let found = self.evaluate(theta, &Held { split: Split::Free, ..*held });
        (found.excess < -SURELY).then_some(Split::Guessed)
    }

    /// Splits and expected errors of a sample at parameters; `None` where it is not used.
    pub fn hold(&self, theta: &Theta, mut held: Held) -> Option<Held> {
        let (c, i) = (self.columns, held.at);
        let lean = self.lean(theta, i);
        if lean.abs() > self.max_lean || !c.settled[i] {
            return None;
        }
        held.split = self.split(theta, &held)?;
        let found = self.evaluate(theta, &held);
        let (mass, v) = (theta[MASS], held.speed);
        let weight = mass * GRAVITY;
        let [ax, _] = held.acceleration;
        let jerk = 0.02 * mass * held.jerk.abs();
        let no_gear = if c.gear.is_none() { 0.3 * found.engine } else { 0.0 };
        let balance = |f: f64| 0.2 * mass + 0.02 * f.abs() + jerk;
        let modelled = |f: f64| (60.0 + 0.15 * f.abs()).hypot(no_gear);
        let force_error = match held.split {
            Split::Free => [20.0, balance(found.force[1])],
            Split::Braked | Split::Guessed => {
                let rear = modelled(found.force[1]);
                [balance(found.force[0]).hypot(rear), rear]
            }
        };
        let load_error = 0.012 * weight + 0.02 * mass * ax.abs() + 0.4 * jerk;
        let slip_error: [f64; 2] = [0, 1].map(|k| {
            let friction = found.force[k] / found.load[k];
            let sigma =
                (force_error[k] / found.load[k]).hypot(friction * load_error / found.load[k]);
            v * found.slip[k].slope * sigma
        });
        let tan = lean.tan();
        held.sigma[A] = [0.075, slip_error[0], 0.004 * v * tan, 0.05 * ax]
            .iter()
            .fold(0.0, |s: f64, x| s.hypot(*x));
        held.sigma[B] = [0.025, slip_error[0], slip_error[1], 0.003 * v * tan * tan]
            .iter()
            .fold(0.0, |s: f64, x| s.hypot(*x));
        let braking = held.split != Split::Free;
        let flat = (0..2).any(|k| found.slip[k].steepness < FLAT);
        let unloaded = found.load[1] < LEAST_LOAD * weight || found.load[0] < 0.02 * weight;
        if unloaded || !c.steady[i] || (braking && flat) {
            held.sigma[B] = f64::INFINITY;
        }
        let compared = c.closed[i] && c.steady[i] && lean.abs() < UPRIGHT;
        if compared && held.split == Split::Braked {
            held.sigma[C] = 80.0 + 0.08 * found.force[0].abs() + jerk;
        }
        if compared && held.split == Split::Free {
            let floor = if self.neutral(i) { 35.0 } else { 60.0 };
            held.sigma[D] = floor + 0.1 * found.force[1].abs() + jerk + no_gear;
        }
        found.residual[A].is_finite().then_some(held)
    }

    /// Held parts of every sample before the first round: nothing slips.
    pub fn late(acceleration: &[f64], jerk: &[f64], i: usize) -> [f64; 2] {
        [acceleration[i], acceleration[i] - LOAD_LAG * jerk[i]]
    }
}
