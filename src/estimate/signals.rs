//! The algebra: slips, camber, loads and forces of every sample (eqs. 24-36).
//!
//! ```text
//! (24) s = omega R / v - 1
//! (25) Fz = m g l_r,f/l -+ dFz,  dFz = (m a_x - F_drag) h cos(phi) / l
//! (26) Fx,f = rho (m a_x - F_drag - F_rol) + F_rol,f     braking, F_rol,f otherwise
//! (27) Fx,r = (1 - rho)(...) + F_rol,r                   braking, m a_x - F_drag - F_rol,f otherwise
//! (29) alpha = (v_y + h cos(phi) phi' +- l_f,r psi') / v_x - Delta
//! (30) Delta, (31) gamma: see model::kinematics
//! (32) Fy from lateral and yaw balance, (33) with the slip share of the trail
//! (34) Mx_tot = -m h (g sin(phi) + v_x psi' cos(phi)) - sum(I omega) psi' cos(phi)
//! ```
//!
//! The corrected form also knows what the printed one leaves out: wheel inertia in loads and
//! forces, the contact line's own speed, the front wheel's heading in the balances, relaxation.
#![allow(non_snake_case)] // symbols keep the capitals of the source

use crate::GRAVITY;
use crate::contract::bike::{Axle, Bike};
use crate::model::kinematics::{FrontWheel, front_wheel};
use crate::model::tyre::trail_0;

use super::samples::Samples;
use super::zeros::Zeros;
use crate::model::formulation::Formulation;

/// What the algebra is given besides the samples. Any of it may be varied to see what depends
/// on it.
#[derive(Debug, Clone)]
pub struct Given {
    /// The bike file.
    pub bike: Bike,
    /// Which form of the equations.
    pub formulation: Formulation,
    /// Sensor zeros; the latency here is what is left of it after gathering.
    pub zeros: Zeros,
    /// Rolling radii, front and rear, m.
    pub radius: [f64; 2],
    /// Drag, kg/m.
    pub drag: f64,
    /// Rolling resistance coefficient.
    pub rolling: f64,
}

/// Estimated signals, one value per sample; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    /// Forward speed of the mass centre, m/s.
    pub speed: Vec<f64>,
    /// Slip ratios.
    pub slip_ratio: [Vec<f64>; 2],
    /// Slip angles, lagged in the corrected form, rad.
    pub slip_angle: [Vec<f64>; 2],
    /// Camber, rad.
    pub camber: [Vec<f64>; 2],
    /// Loads, N.
    pub load: [Vec<f64>; 2],
    /// Longitudinal slip forces, N.
    pub force_x: [Vec<f64>; 2],
    /// Lateral forces, N.
    pub force_y: [Vec<f64>; 2],
    /// Total overturning moment, N m.
    pub overturning: Vec<f64>,
    /// What multiplies the front tyre's `k_x` in the overturning moment, N.
    pub overturning_lever: Vec<f64>,
    /// Roll with its zero taken off, rad.
    pub roll: Vec<f64>,
    /// Longitudinal tyre force of both wheels, N.
    pub total_x: Vec<f64>,
}

impl Signals {
    /// None yet, with room for `n`.
    fn with_room(n: usize) -> Self {
        let room = || Vec::with_capacity(n);
        let pair = || [room(), room()];
        Signals {
            speed: room(),
            slip_ratio: pair(),
            slip_angle: pair(),
            camber: pair(),
            load: pair(),
            force_x: pair(),
            force_y: pair(),
            overturning: room(),
            overturning_lever: room(),
            roll: room(),
            total_x: room(),
        }
    }
}

/// Which wheels act on a straight sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Action {
    /// Braking with this share on the front.
    Braking(f64),
    /// Driven by the rear wheel.
    Driving,
}

impl Given {
    /// Mass that the wheels add to the longitudinal balance, kg; nothing in the printed form.
    pub fn rotating_mass(&self) -> [f64; 2] {
        let corrected = self.formulation == Formulation::Corrected;
        [Axle::Front, Axle::Rear].map(|axle| {
            let i = axle as usize;
            let inertia = self.bike.wheel(axle).wheel_inertia.filter(|_| corrected);
            inertia.map_or(0.0, |inertia| inertia / self.radius[i].powi(2))
        })
    }

    fn inertia(&self) -> [f64; 2] {
        let corrected = self.formulation == Formulation::Corrected;
        [Axle::Front, Axle::Rear]
            .map(|a| self.bike.wheel(a).wheel_inertia.filter(|_| corrected).unwrap_or(0.0))
    }

    /// Forward speed of the mass centre for a sample.
    fn speed(&self, x: &Samples, i: usize) -> f64 {
        let late = self.zeros.latency * x.velocity_x_rate[i];
        let turn = x.yaw_rate[i] - self.zeros.yaw_rate;
        let roll = x.roll[i] - self.zeros.roll;
        // a point above the leaned mass centre runs inside of it
        let beside = turn * self.bike.velocity_sensor_z * roll.sin();
        x.velocity_x[i] + late - if beside.is_finite() { beside } else { 0.0 }
    }

    /// How far the mass centre has moved forward over the wheels, m: a diving front turns the
    /// frame about the axles, which stay above their contacts. Eq. 25 leaves it out: 3 to 5 % of
    /// the front load in hard braking. What the fork takes off the wheelbase and the dive off the
    /// height of the mass centre about cancel.
    fn dive(&self, x: &Samples, i: usize) -> f64 {
        let pitch = x.pitch[i] - self.zeros.pitch;
        if self.formulation != Formulation::Corrected || !pitch.is_finite() {
            return 0.0;
        }
        self.above_axles() * pitch.clamp(-0.2, 0.2)
    }

    /// Height of the mass centre above the axles, m.
    fn above_axles(&self) -> f64 {
        let b = &self.bike;
        (b.cg_height - 0.5 * (b.front.radius + b.rear.radius)).max(0.0)
    }

    /// Forward speed of the axles, m/s: a diving frame carries the velocity sensor ahead of them.
    fn axle_speed(&self, x: &Samples, i: usize, v: f64) -> f64 {
        let rate = x.pitch_rate[i];
        if self.formulation != Formulation::Corrected || !rate.is_finite() {
            return v;
        }
        v - (self.above_axles() + self.bike.velocity_sensor_z) * rate.clamp(-1.0, 1.0)
    }

    /// Rolling radius of wheel `k` under a load, m: it falls by a share of the deflection, where
    /// the bike file gives one.
    fn loaded_radius(&self, k: usize, load: f64) -> f64 {
        let wheel = self.bike.wheel(Axle::BOTH[k]);
        match wheel.deflection_share {
            Some(share) if self.formulation == Formulation::Corrected => {
                let standing = self.loads(0.0, 0.0, 1.0, 0.0, 0.0)[k];
                self.radius[k] - share * (load - standing) / wheel.vertical_stiffness
            }
            _ => self.radius[k],
        }
    }

    /// Wheel loads with their transfer, eq. 25.
    /// `lift` is the mass centre's upward acceleration over gravity, `ahead` how far it has moved
    /// forward, m.
    fn loads(&self, total_x: f64, spin_rate: f64, cos_phi: f64, lift: f64, ahead: f64) -> [f64; 2] {
        let b = &self.bike;
        let weight = b.mass * GRAVITY * (1.0 + lift) / b.wheelbase;
        let transfer = (total_x * b.cg_height + spin_rate) * cos_phi / b.wheelbase; // (25b)
        let (rear, front) = (b.cg_to_rear() + ahead, b.cg_to_front - ahead);
        [weight * rear - transfer, weight * front + transfer] // (25a)
    }

    /// Longitudinal signals of straight samples; `action` by sample.
    pub fn straight(&self, x: &Samples, action: &[Action]) -> Signals {
        let n = x.len();
        let corrected = self.formulation == Formulation::Corrected;
        let rotating = self.rotating_mass();
        let inertia = self.inertia();
        let m = self.bike.mass;
        let mut out = Signals::with_room(n);
        for i in 0..n {
            let v = self.speed(x, i);
            let roll = x.roll[i] - self.zeros.roll;
            let roll = if roll.is_finite() { roll } else { 0.0 };
            let cos_phi = roll.cos();
            let a = x.acceleration_x[i] - self.zeros.acceleration_x;
            let total = m * a + self.drag * v * v; // m a_x - F_drag
            let spin_rate: f64 = (0..2)
                .map(|k| if inertia[k] > 0.0 { inertia[k] * x.omega_rate[k][i] } else { 0.0 })
                .sum();
            let load = self.loads(total, spin_rate, cos_phi, 0.0, self.dive(x, i));
            let axle = self.axle_speed(x, i, v);
            let rolling = [-self.rolling * load[0], -self.rolling * load[1]];
            // an undriven, unbraked wheel is pushed by its own inertia only
            let free = |k: usize| {
                if rotating[k] > 0.0 {
                    -inertia[k] * x.omega_rate[k][i] / self.radius[k]
                } else {
                    0.0
                }
            };
            let slip = total - rolling[0] - rolling[1];
            let force = match action[i] {
                Action::Braking(rho) if rho >= 1.0 => [slip - free(1), free(1)],
                Action::Braking(rho) if rho <= 0.0 => [free(0), slip - free(0)],
                Action::Braking(rho) => [rho * slip, (1.0 - rho) * slip], // (26), (27)
                Action::Driving => [free(0), slip - free(0)],             // (27)
            };
            for k in 0..2 {
                let s = x.omega[k][i] * self.loaded_radius(k, load[k]) / axle - 1.0; // (24)
                out.slip_ratio[k].push(s);
                out.load[k].push(load[k]);
                // the printed form counts rolling resistance as slip force
                let printed = if corrected { 0.0 } else { rolling[k] };
                out.force_x[k].push(force[k] + printed);
            }
            out.speed.push(v);
            out.roll.push(roll);
            out.total_x.push(total);
        }
        out
    }

    /// Kinematic slip angles (29) of one sample, and how its front wheel stands (30, 31); `phi`
    /// is sine and cosine of roll.
    fn angles(&self, x: &Samples, i: usize, v: f64, phi: (f64, f64)) -> ([f64; 2], FrontWheel) {
        let b = &self.bike;
        let z = &self.zeros;
        let turn = x.yaw_rate[i] - z.yaw_rate;
        let (sin_phi, cos_phi) = phi;
        let front = front_wheel(x.steer[i], phi, b.caster_angle.sin_cos(), self.formulation);
        let delta = front.steer;
        let height = b.cg_height + b.velocity_sensor_z;
        let vy = x.velocity_y[i] + z.latency * x.velocity_y_rate[i] - b.velocity_sensor_x * turn;
        let w = vy + height * cos_phi * x.roll_rate[i];
        let (wf, wr) = (w + b.cg_to_front * turn, w - b.cg_to_rear() * turn);
        match self.formulation {
            Formulation::Paper => ([wf / v - delta, wr / v], front), // (29)
            Formulation::Corrected => {
                // the contact line lies outside the mass centre's track and is faster
                let u = v - turn * b.cg_height * sin_phi;
                let wf = wf - z.front.constant - z.front.angle * v;
                let wr = wr - z.rear.constant - z.rear.angle * v;
                ([(wf / u).atan() - delta, (wr / u).atan()], front)
            }
        }
    }

    /// Lateral signals of cornering samples. `rate` is that of the samples, Hz.
    pub fn corner(&self, x: &Samples, rate: f64, crown: Option<f64>) -> Signals {
        let n = x.len();
        let corrected = self.formulation == Formulation::Corrected;
        let b = &self.bike;
        let inertia = self.inertia();
        let (m, h) = (b.mass, b.cg_height);
        let (lf, lr) = (b.cg_to_front, b.cg_to_rear());
        let wheels = [&b.front, &b.rear];
        let relaxation = [0, 1].map(|k| wheels[k].relaxation_length.unwrap_or(self.radius[k]));
        let mut out = Signals::with_room(n);
        let mut lagged = [0.0_f64; 2];
        let mut previous = [0.0_f64; 2];
        for i in 0..n {
            let v = self.speed(x, i);
            let phi = x.roll[i] - self.zeros.roll;
            let turn = x.yaw_rate[i] - self.zeros.yaw_rate;
            let (sin_phi, cos_phi) = phi.sin_cos();
            let (alpha_kin, wheel) = self.angles(x, i, v, (sin_phi, cos_phi));
            let gamma = [wheel.camber, phi];
            let alpha = if corrected {
                let first = i == 0
                    || x.segment[i] != x.segment[i - 1]
                    || (x.time[i] - x.time[i - 1]) * rate > 1.5;
                for k in 0..2 {
                    lagged[k] = if first || lagged[k].is_nan() {
                        alpha_kin[k]
                    } else {
                        let span = (v / relaxation[k] / rate).max(1e-6);
                        hold(lagged[k], previous[k], alpha_kin[k], span) // (1)
                    };
                }
                previous = alpha_kin;
                lagged
            } else {
                alpha_kin
            };
            let a = x.acceleration_x[i] - self.zeros.acceleration_x;
            let total = m * a + self.drag * v * v;
            let spin: f64 = (0..2)
                .map(|k| if inertia[k] > 0.0 { inertia[k] * x.omega[k][i] } else { 0.0 })
                .sum();
            // leaning in the mass centre sinks, leaning out it rises: the printed form is static
            let lift = -h * (sin_phi * x.roll_acceleration[i] + cos_phi * x.roll_rate[i].powi(2))
                / GRAVITY;
            let lift = if corrected && lift.is_finite() { lift } else { 0.0 };
            let load = self.loads(total, 0.0, cos_phi, lift, 0.0);

            // trails, with the share of the side force that slip makes (33a)
            let mut share = [0.0; 2];
            for k in 0..2 {
                let C = wheels[k].side_force_ratio;
                let whole = alpha[k] + C * gamma[k];
                let part = if corrected {
                    // bounded where the denominator vanishes
                    let floor = 0.3 * (C * gamma[k]).abs() + 1e-4;
                    alpha[k] / whole.abs().max(floor) * whole.signum()
                } else {
                    alpha[k] / whole
                };
                // without a lateral velocity the trails are left out: a per cent of the forces
                let part = if part.is_finite() { part } else { 0.0 };
                share[k] = part.clamp(-3.0, 3.0)
                    * trail_0(self.radius[k], wheels[k].vertical_stiffness, load[k]);
            }
            let twist: f64 =
                (0..2).map(|k| -wheels[k].twisting_stiffness * load[k] * gamma[k]).sum(); // (16)
            let along = -h * sin_phi * total; // (33b)
            // quasi-static is never quite static: the printed form has m v psi' alone
            let drift = x.velocity_y_rate[i];
            let drift = if corrected && drift.is_finite() { drift } else { 0.0 };
            let lateral = v * turn + drift;
            let side = m * lateral;
            let (sin_d, cos_d) = if corrected { wheel.steer_sin_cos } else { (0.0, 1.0) };
            // rolling resistance of the front wheel, seen from the frame
            let front_x = if corrected { -self.rolling * load[0] } else { 0.0 };
            // the driven rear wheel pulls beside the plane, where its crown touches (19)
            let crown_rear = match crown {
                Some(k_x) if corrected => k_x * b.rear.width / b.front.width,
                _ => 0.0,
            };
            let slip_force = total - front_x * cos_d + self.rolling * load[1];
            let pull = crown_rear * slip_force * gamma[1].tan();
            // a bend taken slower and slower is not steady: the bike's own yaw inertia
            let yaw = if corrected { b.yaw_inertia() * x.yaw_acceleration[i] } else { 0.0 };
            let yaw = if yaw.is_finite() { yaw } else { 0.0 };
            let moment = twist + along + pull + lf * front_x * sin_d - yaw;
            let force = side - front_x * sin_d;
            // lateral balance: cos(D) Ff + Fr = force
            // yaw balance: (lf cos(D) - tf) Ff - (lr + tr) Fr = -moment      (32)
            let determinant = cos_d * (lr + share[1]) + lf * cos_d - share[0];
            let front = (force * (lr + share[1]) - moment) / determinant;
            let rear = force - cos_d * front;

            // the steered front wheel stands beside the frame's plane by its trail, to the right in
            // a left corner: its load rights the bike less than the crown does
            let aside = b.normal_trail() * x.steer[i].sin() * load[0] / cos_phi;
            let steered = if aside.is_finite() { aside } else { 0.0 };
            let Mx = match self.formulation {
                Formulation::Corrected => {
                    -m * h * (GRAVITY * (1.0 + lift) * sin_phi + lateral * cos_phi)
                        - spin * turn * cos_phi // (34a)
                        + steered
                }
                Formulation::Paper => {
                    let lenticular = -(turn * v / GRAVITY).atan(); // (34b)
                    m * h
                        * (turn * v * (lenticular.cos() - cos_phi)
                            - GRAVITY * (lenticular.sin() - sin_phi)) // (34a) as printed
                }
            };
            let lever = match self.formulation {
                // both crowns, the rear's by the ratio of widths (36b)
                Formulation::Corrected => {
                    let ratio = b.rear.width / b.front.width;
                    -(load[0] * wheel.camber_tan + ratio * load[1] * sin_phi / cos_phi)
                }
                Formulation::Paper => m * GRAVITY * phi.tan(), // (35) as printed
            };
            for k in 0..2 {
                out.slip_angle[k].push(alpha[k]);
                out.camber[k].push(gamma[k]);
                out.load[k].push(load[k]);
                out.slip_ratio[k].push(f64::NAN); // the straight-line radius does not hold here
            }
            out.force_y[0].push(front);
            out.force_y[1].push(rear);
            out.speed.push(v);
            out.roll.push(phi);
            out.overturning.push(Mx);
            out.overturning_lever.push(lever);
            out.total_x.push(total);
        }
        out
    }
}

/// Exact step of the first-order lag (1) for an input that runs straight from one sample to
/// the next; `span` is the distance travelled over the relaxation length.
fn hold(state: f64, from: f64, to: f64, span: f64) -> f64 {
    let keep = (-span).exp();
    let mean = (1.0 - keep) / span;
    keep * state + (1.0 - mean) * to + (mean - keep) * from
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lag_is_exact_for_a_ramp() {
        // x' = (u - x)/T with u = t: x = t - T (1 - exp(-t/T))
        let (mut x, step, lag) = (0.0, 0.3, 0.5_f64);
        for i in 0..10 {
            x = hold(x, step * f64::from(i), step * f64::from(i + 1), step / lag);
        }
        let t = 3.0;
        assert!((x - (t - lag * (1.0 - (-t / lag).exp()))).abs() < 1e-12);
    }
}
