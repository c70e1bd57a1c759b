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
use crate::motorcycle::balance::{Lengths, pitching};
use crate::tyre::dive::{PITCH_GYRATION, above_axles, contact_arms};
use crate::tyre::kinematics::{FrontWheel, front_wheel};
use crate::tyre::paper::trail_0;
use crate::tyre::tyre_model::{USUAL_SHARE, load_lead};

use super::measured::{Quantity, SensorErrors};
use super::relaxation::SlipLag;
use super::rolling_front::{LEAST_LOAD, RollingFront};
use super::samples::Samples;
use super::zeros::Zeros;
use crate::tyre::formulation::Formulation;

/// Longitudinal force of both tyres from which its shares are measured, N.
const LEAST_FORCE: f64 = 100.0;
/// Pitch accelerations count no further, rad/s²: more is a bump's.
const MOST_PITCH: f64 = 15.0;

/// Motorcycle and sensors of one ride, as the algebra of its samples needs them.
///
/// Apart from the bike file, which it holds: radii, drag, zeros and sensor errors are the ride's, and change as fits
/// follow one another.
#[derive(Debug, Clone)]
pub struct Inputs {
    pub bike: Bike,
    /// Which form of the equations.
    pub formulation: Formulation,
    /// Sensor zeros; the latency here is what remains of it after gathering.
    pub zeros: Zeros,
    /// Rolling radii, front and rear, m.
    pub radius: [f64; 2],
    /// Drag, kg/m.
    pub drag: f64,
    /// Rolling resistance coefficient.
    pub rolling: f64,
    /// Pneumatic trail over that of the rule (12).
    pub trail_ratio: f64,
    /// Pitch inertia over mass, m².
    pub pitch_gyration: f64,
    /// True over measured lean.
    pub roll_scale: f64,
    /// Where no handlebar was measured: front slip angle beyond the rear one per sine of the lean, rad.
    pub slip_difference: f64,
    /// The front wheel where it measures the rear one's slip, instead of the velocity.
    pub rolling_front: Option<RollingFront>,
    /// Errors of the wheels' own sensors.
    pub sensors: SensorErrors,
}

/// Estimated signals, one value per sample; pairs are front and rear.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    /// Forward speed of the centre of mass, m/s.
    pub speed: Vec<f64>,
    /// Slip ratio by wheel and sample, positive under drive.
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
    /// Factor of the front tyre's `k_x` in the overturning moment, N.
    pub overturning_lever: Vec<f64>,
    /// Overturning moments that measuring wheels show, N m; NaN without.
    pub moment_x: [Vec<f64>; 2],
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
            moment_x: pair(),
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
    /// Both wheels brake; sensors of theirs tell the share of each.
    Measured,
}

impl Inputs {
    /// With the bike file's radii, drag and rolling resistance.
    pub fn nominal(bike: &Bike, formulation: Formulation, zeros: Zeros) -> Self {
        Inputs {
            bike: bike.clone(),
            formulation,
            zeros,
            radius: [bike.front.radius, bike.rear.radius],
            drag: bike.drag,
            rolling: bike.rolling_resistance,
            trail_ratio: 1.0,
            pitch_gyration: PITCH_GYRATION[0],
            roll_scale: 1.0,
            slip_difference: 0.0,
            rolling_front: None,
            sensors: SensorErrors::default(),
        }
    }

    /// Reading of a wheel's own sensor at a sample, less its zero, in the corrected form.
    fn measured(&self, quantity: Quantity, x: &Samples, k: usize, i: usize) -> Option<f64> {
        let shown = self.sensors.read(quantity, x, k, i).filter(|_| self.is_corrected())?;
        let zero = if quantity == Quantity::SlipAngle { self.zeros.slip_angle[k] } else { 0.0 };
        Some(shown - zero)
    }

    fn is_corrected(&self) -> bool {
        self.formulation == Formulation::Corrected
    }

    /// Mass that the wheels add to the longitudinal balance, kg; nothing in the printed form.
    pub fn rotating_mass(&self) -> [f64; 2] {
        Axle::BOTH.map(|axle| {
            let k = axle as usize;
            self.inertia()[k] / self.radius[k].powi(2)
        })
    }

    /// Relaxation lengths: the bike file's, else the wheel's radius, m.
    fn relaxation_lengths(&self) -> [f64; 2] {
        Axle::BOTH.map(|axle| {
            self.bike.wheel(axle).relaxation_length.unwrap_or(self.radius[axle as usize])
        })
    }

    /// Spin inertia of the wheels, kg m²; nothing in the printed form.
    fn inertia(&self) -> [f64; 2] {
        Axle::BOTH.map(|a| if self.is_corrected() { self.bike.wheel_inertia(a) } else { 0.0 })
    }

    /// Speed of wheel `k`, rad/s; a wheel without a sensor rolls as fast as the motorcycle.
    fn wheel_speed(&self, x: &Samples, i: usize, k: usize) -> f64 {
        let omega = x.omega[k][i];
        if omega.is_finite() { omega } else { x.velocity_x[i] / self.radius[k] }
    }

    /// Its rate, rad/s².
    fn wheel_rate(&self, x: &Samples, i: usize, k: usize) -> f64 {
        let rate = x.omega_rate[k][i];
        if rate.is_finite() { rate } else { x.velocity_x_rate[i] / self.radius[k] }
    }

    /// Forward speed of the centre of mass for a sample.
    fn speed(&self, x: &Samples, i: usize) -> f64 {
        let late = self.zeros.latency * x.velocity_x_rate[i];
        let turn = x.yaw_rate[i] - self.zeros.yaw_rate;
        let roll = self.roll(x, i);
        // a point above the leaned centre of mass runs inside of it
        let beside = turn * self.bike.velocity_sensor_z * roll.sin();
        x.velocity_x[i] + late - if beside.is_finite() { beside } else { 0.0 }
    }

    /// Forward acceleration that forces have to give, m/s²: on a slope more or less than the speed shows.
    fn acceleration(&self, x: &Samples, i: usize) -> f64 {
        let uphill = if self.is_corrected() { GRAVITY * x.grade[i] } else { 0.0 };
        x.acceleration_x[i] - self.zeros.acceleration_x + uphill
    }

    /// Lean of a sample, rad.
    fn roll(&self, x: &Samples, i: usize) -> f64 {
        self.roll_scale * (x.roll[i] - self.zeros.roll)
    }

    /// How far the centre of mass has moved forward over the wheels, m: a diving front turns the
    /// frame about the axles, which stay above their contacts. Eq. 25 leaves it out: 3 to 5 % of
    /// the front load in hard braking. What the fork takes off the wheelbase and the dive off the
    /// height of the centre of mass about cancel.
    fn dive(&self, x: &Samples, i: usize) -> f64 {
        let pitch = x.pitch[i] - self.zeros.pitch;
        if !self.is_corrected() || !pitch.is_finite() {
            return 0.0;
        }
        above_axles(self.bike.cg_height, self.nominal_radii()) * pitch.clamp(-0.2, 0.2)
    }

    /// How far ahead of the axles the loads act, m; the printed form leaves it out.
    fn load_lead(&self) -> f64 {
        match self.is_corrected() {
            true => load_lead(self.rolling, 0.5 * (self.radius[0] + self.radius[1])),
            false => 0.0,
        }
    }

    /// Moment of the frame's pitch acceleration, N m: by it the wheels' loads lag the deceleration.
    fn pitch_moment(&self, x: &Samples, i: usize) -> f64 {
        let rate = x.pitch_acceleration[i];
        if !self.is_corrected() || !rate.is_finite() {
            return 0.0;
        }
        self.bike.mass * self.pitch_gyration * rate.clamp(-MOST_PITCH, MOST_PITCH)
    }

    /// Radii of the bike file, m.
    fn nominal_radii(&self) -> [f64; 2] {
        [self.bike.front.radius, self.bike.rear.radius]
    }

    /// Forward speeds of the contacts, m/s: a diving frame carries the velocity sensor ahead of them.
    fn contact_speeds(&self, x: &Samples, i: usize, v: f64) -> [f64; 2] {
        let (b, rate) = (&self.bike, x.pitch_rate[i]);
        if !self.is_corrected() || !rate.is_finite() {
            return [v; 2];
        }
        contact_arms(b.cg_height, self.nominal_radii(), b.wheelbase, b.caster_angle)
            .map(|arm| v - (arm + b.velocity_sensor_z) * rate.clamp(-1.0, 1.0))
    }

    /// Forward speed of the rear contact, m/s, by a front wheel that rolls freely with a force (N) under a load (N);
    /// `None` where it tells nothing.
    fn rear_speed(&self, x: &Samples, i: usize, force: f64, load: f64) -> Option<f64> {
        let front = self.rolling_front.filter(|_| self.is_corrected())?;
        let omega = x.omega[0][i];
        if !omega.is_finite() || load < LEAST_LOAD * self.standing()[0] {
            return None;
        }
        let v = front.speed(omega, self.loaded_radius(0, load), force / load);
        let [ahead, behind] = self.contact_speeds(x, i, v);
        Some(v + behind - ahead)
    }

    /// Loads at rest, N.
    fn standing(&self) -> [f64; 2] {
        self.loads(0.0, 0.0, 1.0, 0.0, 0.0)
    }

    /// Rolling radius of wheel `k` under a load, m: it falls by a share of the deflection.
    pub(crate) fn loaded_radius(&self, k: usize, load: f64) -> f64 {
        if !self.is_corrected() {
            return self.radius[k];
        }
        let wheel = self.bike.wheel(Axle::BOTH[k]);
        let share = wheel.deflection_share.unwrap_or(USUAL_SHARE);
        self.radius[k] - share * (load - self.standing()[k]) / wheel.vertical_stiffness
    }

    /// Wheel loads with their transfer, eq. 25.
    /// `lift` is the upward acceleration of the centre of mass over gravity, `ahead` how far it has moved
    /// forward, m.
    pub(crate) fn loads(
        &self,
        total_x: f64,
        spin_rate: f64,
        cos_phi: f64,
        lift: f64,
        ahead: f64,
    ) -> [f64; 2] {
        let b = &self.bike;
        let weight = b.mass * GRAVITY * (1.0 + lift);
        let pitching = pitching(total_x, b.cg_height, spin_rate, cos_phi);
        Lengths::of(b).loads(weight, ahead - self.load_lead(), pitching)
    }

    /// Longitudinal signals of straight samples; `action` by sample.
    pub fn straight(&self, x: &Samples, action: &[Action]) -> Signals {
        let n = x.len();
        let corrected = self.is_corrected();
        let rotating = self.rotating_mass();
        let inertia = self.inertia();
        let m = self.bike.mass;
        // to first order the tyre's slip lags the wheel's by it
        let lag =
            Axle::BOTH.map(|a| if corrected { self.bike.longitudinal_relaxation(a) } else { 0.0 });
        let mut out = Signals::with_room(n);
        for i in 0..n {
            let v = self.speed(x, i);
            let roll = self.roll(x, i);
            let roll = if roll.is_finite() { roll } else { 0.0 };
            let cos_phi = roll.cos();
            let a = self.acceleration(x, i);
            let total = m * a + self.drag * v * v; // m a_x - F_drag
            let spin_rate: f64 = (0..2)
                .map(|k| if inertia[k] > 0.0 { inertia[k] * self.wheel_rate(x, i, k) } else { 0.0 })
                .sum();
            let turning = spin_rate + self.pitch_moment(x, i);
            let load = self.loads(total, turning, cos_phi, 0.0, self.dive(x, i));
            let mut speeds = self.contact_speeds(x, i, v);
            let rolling = [-self.rolling * load[0], -self.rolling * load[1]];
            // an undriven, unbraked wheel is pushed by its own inertia only
            let free = |k: usize| {
                if rotating[k] > 0.0 {
                    -inertia[k] * self.wheel_rate(x, i, k) / self.radius[k]
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
                Action::Measured => self.shared(x, i, slip, [free(0), free(1)], load),
            };
            if matches!(action[i], Action::Driving) || action[i] == Action::Braking(0.0) {
                speeds[1] = self.rear_speed(x, i, force[0], load[0]).unwrap_or(speeds[1]);
            }
            for k in 0..2 {
                let s = x.omega[k][i] * self.loaded_radius(k, load[k]) / speeds[k] - 1.0; // (24)
                let spinning = self.wheel_rate(x, i, k) * self.radius[k];
                let rate = (spinning - (1.0 + s) * x.velocity_x_rate[i]) / speeds[k];
                out.slip_ratio[k].push(s - lag[k] / speeds[k] * rate);
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

    /// Slip forces of both tyres while both brake, N: sensors of the wheels tell their shares, the balance their sum
    /// `slip`, which it knows better than sensors of 1 % do. NaN where neither wheel's sensor shows anything.
    ///
    /// A measuring wheel has rolling resistance besides, which is no slip's. A brake's torque acts about the axle,
    /// whose height is the contact force's arm.
    fn shared(&self, x: &Samples, i: usize, slip: f64, free: [f64; 2], load: [f64; 2]) -> [f64; 2] {
        let by = |k: usize| {
            let force = self.sensors.read(Quantity::ForceX, x, k, i);
            let torque = || self.sensors.read(Quantity::BrakeTorque, x, k, i);
            let by_brake = || Some(free[k] - torque()? / self.axle_height(k, load[k]));
            force.map(|f| f + self.rolling * load[k]).or_else(by_brake)
        };
        match [by(0), by(1)] {
            [Some(front), Some(rear)] if (front + rear).abs() > LEAST_FORCE => {
                let share = front / (front + rear);
                [share * slip, (1.0 - share) * slip]
            }
            [Some(front), None] => [front, slip - front],
            [None, Some(rear)] => [slip - rear, rear],
            _ => [f64::NAN; 2],
        }
    }

    /// Height of an axle above the road under a load, m: the carcass gives way by more than the rolling radius does.
    fn axle_height(&self, k: usize, load: f64) -> f64 {
        let wheel = self.bike.wheel(Axle::BOTH[k]);
        let share = wheel.deflection_share.unwrap_or(USUAL_SHARE);
        self.loaded_radius(k, load) - (1.0 - share) * load / wheel.vertical_stiffness
    }

    /// Kinematic slip angles (29) of one sample, and how its front wheel stands (30, 31); `phi`
    /// is sine and cosine of roll, `caster` of the caster angle.
    fn angles(
        &self,
        x: &Samples,
        i: usize,
        v: f64,
        phi: (f64, f64),
        caster: (f64, f64),
    ) -> ([f64; 2], FrontWheel) {
        let b = &self.bike;
        let z = &self.zeros;
        let turn = x.yaw_rate[i] - z.yaw_rate;
        let (sin_phi, cos_phi) = phi;
        let handlebar = self.handlebar(x, i, v, phi);
        let front = front_wheel(handlebar, phi, caster, self.formulation);
        // of a handlebar that follows from equal slips no slip follows
        let delta = if x.steer[i].is_finite() { front.steer() } else { f64::NAN };
        let height = b.cg_height + b.velocity_sensor_z;
        let vy = x.velocity_y[i] + z.latency * x.velocity_y_rate[i] - b.velocity_sensor_x * turn;
        let w = vy + height * cos_phi * x.roll_rate[i];
        let (wf, wr) = (w + b.cg_to_front * turn, w - b.cg_to_rear() * turn);
        match self.formulation {
            Formulation::Paper => ([wf / v - delta, wr / v], front), // (29)
            Formulation::Corrected => {
                // the contact line lies outside the track of the centre of mass and is faster
                let u = v - turn * b.cg_height * sin_phi;
                let leaning = z.slip_of_lean * sin_phi * u;
                let wf = wf - z.front.constant - z.front.angle * v - leaning;
                let wr = wr - z.rear.constant - z.rear.angle * v - leaning;
                ([(wf / u).atan() - delta, (wr / u).atan()], front)
            }
        }
    }

    /// Handlebar angle of a sample, rad. METHOD: where none was measured the front wheel points along the corner, with the
    /// rear one's slip angle: `tan(Delta) = l psi' / u`, (30) solved for the handlebar. Camber and forces hardly depend
    /// on it: a degree of difference between the slips is 0.4 degrees of front camber.
    fn handlebar(&self, x: &Samples, i: usize, v: f64, (sin_phi, cos_phi): (f64, f64)) -> f64 {
        if x.steer[i].is_finite() || !self.is_corrected() {
            return x.steer[i];
        }
        let b = &self.bike;
        let turn = x.yaw_rate[i] - self.zeros.yaw_rate;
        let u = v - turn * b.cg_height * sin_phi;
        let along = (b.wheelbase * turn / u).atan();
        let steer = (along - self.slip_difference * sin_phi).tan();
        let (sin_eps, cos_eps) = b.caster_angle.sin_cos();
        (steer * cos_phi).atan2(cos_eps - steer * sin_phi * sin_eps)
    }

    /// Lateral signals of cornering samples. `rate` is that of the samples, Hz; `front_k_x` the front
    /// tyre's overturning stiffness (m), where it is known already.
    pub fn corner(&self, x: &Samples, rate: f64, front_k_x: Option<f64>) -> Signals {
        let mut lag = SlipLag::new(self.relaxation_lengths(), rate);
        self.corner_with(x, front_k_x, |i, speed, kinematic| lag.next(x, i, speed, kinematic))
    }

    /// How far the slip angles of some cornering samples lag behind the kinematic ones. Out of their context their own
    /// lag is not known any more; this one goes with them.
    pub fn held_lag(&self, x: &Samples, rate: f64, some: &[usize]) -> HeldLag {
        let whole = self.corner(x, rate, None);
        let kinematic = self.corner_with(&x.select(some), None, |_, _, kinematic| kinematic);
        let behind = |k: usize| {
            let pairs = some.iter().zip(&kinematic.slip_angle[k]);
            pairs.map(|(&i, kinematic)| whole.slip_angle[k][i] - kinematic).collect()
        };
        HeldLag { relaxation: self.relaxation_lengths(), behind: [behind(0), behind(1)] }
    }

    /// As [`Inputs::corner`] of samples out of their context, for inputs that differ a little from those of the lag: in
    /// quasi-static corners it is proportional to the relaxation length, and hardly depends on anything else.
    pub fn corner_with_lag(&self, x: &Samples, lag: &HeldLag, front_k_x: Option<f64>) -> Signals {
        let now = self.relaxation_lengths();
        let share = [0, 1].map(|k| now[k] / lag.relaxation[k]);
        self.corner_with(x, front_k_x, |i, _, kinematic| {
            [0, 1].map(|k| kinematic[k] + share[k] * lag.behind[k][i])
        })
    }

    /// `lagged` makes the slip angles of a sample from its speed and the kinematic ones.
    fn corner_with(
        &self,
        x: &Samples,
        front_k_x: Option<f64>,
        mut lagged: impl FnMut(usize, f64, [f64; 2]) -> [f64; 2],
    ) -> Signals {
        let mut out = Signals::with_room(x.len());
        let fixed = Fixed::of(&self.bike);
        for i in 0..x.len() {
            let state = self.corner_state(x, i, &fixed, &mut lagged);
            let force = self.lateral_forces(x, i, &state, &fixed, front_k_x);
            for k in 0..2 {
                out.slip_angle[k].push(state.slip_angle[k]);
                out.camber[k].push(state.camber[k]);
                out.load[k].push(state.load[k]);
                out.slip_ratio[k].push(f64::NAN); // the straight-line radius does not hold here
                out.force_y[k].push(force[k]);
            }
            out.speed.push(state.speed);
            out.roll.push(state.roll);
            out.overturning.push(self.overturning(x, i, &state, &fixed));
            out.overturning_lever.push(self.overturning_lever(&state));
            for k in 0..2 {
                out.moment_x[k].push(self.measured(Quantity::MomentX, x, k, i).unwrap_or(f64::NAN));
            }
            out.total_x.push(state.total_x);
        }
        out
    }

    /// How the motorcycle moves in one corner sample.
    fn corner_state(
        &self,
        x: &Samples,
        i: usize,
        fixed: &Fixed,
        lagged: &mut impl FnMut(usize, f64, [f64; 2]) -> [f64; 2],
    ) -> CornerState {
        let b = &self.bike;
        let speed = self.speed(x, i);
        let roll = self.roll(x, i);
        let turn = x.yaw_rate[i] - self.zeros.yaw_rate;
        let (sin_roll, cos_roll) = roll.sin_cos();
        let (kinematic, front) = self.angles(x, i, speed, (sin_roll, cos_roll), fixed.caster);
        let slip_angle = if self.is_corrected() { lagged(i, speed, kinematic) } else { kinematic };
        // a sensor shows the wheel's angle as the frame's motion does: the carcass lags both
        let lag = [0, 1].map(|k| slip_angle[k] - kinematic[k]);
        let slip_angle = [0, 1].map(|k| {
            let shown = self.measured(Quantity::SlipAngle, x, k, i);
            let lag = if lag[k].is_finite() { lag[k] } else { 0.0 };
            shown.map_or(slip_angle[k], |shown| shown + lag)
        });
        let a = self.acceleration(x, i);
        let total_x = b.mass * a + self.drag * speed * speed;
        // leaning in the centre of mass sinks, leaning out it rises: the printed form is static
        let lift = -b.cg_height
            * (sin_roll * x.roll_acceleration[i] + cos_roll * x.roll_rate[i].powi(2))
            / GRAVITY;
        let lift = if self.is_corrected() && lift.is_finite() { lift } else { 0.0 };
        // quasi-static is never quite static: the printed form has m v psi' alone
        let drift = x.velocity_y_rate[i];
        let drift = if self.is_corrected() && drift.is_finite() { drift } else { 0.0 };
        CornerState {
            speed,
            roll,
            sin_roll,
            cos_roll,
            turn,
            slip_angle,
            camber: [front.camber, roll],
            front,
            total_x,
            lift,
            load: self.loads(total_x, 0.0, cos_roll, lift, 0.0),
            lateral: speed * turn + drift,
        }
    }

    /// Trails of both tyres, with the share of the side force that slip makes (33a), m.
    fn slip_trails(&self, s: &CornerState) -> [f64; 2] {
        Axle::BOTH.map(|axle| {
            let (k, wheel) = (axle as usize, self.bike.wheel(axle));
            let C = wheel.side_force_ratio;
            let whole = s.slip_angle[k] + C * s.camber[k];
            let part = if self.is_corrected() {
                // bounded where the denominator vanishes
                let floor = 0.3 * (C * s.camber[k]).abs() + 1e-4;
                s.slip_angle[k] / whole.abs().max(floor) * whole.signum()
            } else {
                s.slip_angle[k] / whole
            };
            // without a lateral velocity the trails are left out: a per cent of the forces
            let part = if part.is_finite() { part } else { 0.0 };
            let trail = trail_0(self.radius[k], wheel.vertical_stiffness, s.load[k]);
            part.clamp(-3.0, 3.0) * self.trail_ratio * trail
        })
    }

    /// Side forces of both tyres from the lateral and the yaw balance (32), N.
    fn lateral_forces(
        &self,
        x: &Samples,
        i: usize,
        s: &CornerState,
        fixed: &Fixed,
        front_k_x: Option<f64>,
    ) -> [f64; 2] {
        let b = &self.bike;
        let corrected = self.is_corrected();
        let (lf, lr) = (b.cg_to_front, b.cg_to_rear());
        let wheels = [&b.front, &b.rear];
        let trail = self.slip_trails(s);
        let twist: f64 =
            (0..2).map(|k| -wheels[k].twisting_stiffness * s.load[k] * s.camber[k]).sum(); // (16)
        let along = -b.cg_height * s.sin_roll * s.total_x; // (33b)
        let side = b.mass * s.lateral;
        let (sin_d, cos_d) = if corrected { s.front.steer_sin_cos } else { (0.0, 1.0) };
        // rolling resistance of the front wheel, seen from the frame
        let front_x = if corrected { -self.rolling * s.load[0] } else { 0.0 };
        // the driven rear wheel pulls beside the plane, where its crown touches (19)
        let rear_k_x = match front_k_x {
            Some(k_x) if corrected => k_x * b.rear.width / b.front.width,
            _ => 0.0,
        };
        let slip_force = s.total_x - front_x * cos_d + self.rolling * s.load[1];
        let pull = rear_k_x * slip_force * s.camber[1].tan();
        // a corner taken slower and slower is not steady: the bike's own yaw inertia
        let yaw = if corrected { fixed.yaw_inertia * x.yaw_acceleration[i] } else { 0.0 };
        let yaw = if yaw.is_finite() { yaw } else { 0.0 };
        let moment = twist + along + pull + lf * front_x * sin_d - yaw;
        let force = side - front_x * sin_d;
        // lateral balance: cos(D) Ff + Fr = force
        // yaw balance: (lf cos(D) - tf) Ff - (lr + tr) Fr = -moment      (32)
        let determinant = cos_d * (lr + trail[1]) + lf * cos_d - trail[0];
        let front = (force * (lr + trail[1]) - moment) / determinant;
        [front, force - cos_d * front]
    }

    /// Total overturning moment (34), N m.
    fn overturning(&self, x: &Samples, i: usize, s: &CornerState, fixed: &Fixed) -> f64 {
        let b = &self.bike;
        let (m, h) = (b.mass, b.cg_height);
        match self.formulation {
            Formulation::Corrected => {
                let inertia = self.inertia();
                let spin: f64 = (0..2)
                    .map(|k| {
                        if inertia[k] > 0.0 { inertia[k] * self.wheel_speed(x, i, k) } else { 0.0 }
                    })
                    .sum();
                // the steered front wheel stands beside the frame's plane by its trail, to the right
                // in a left corner: its load rights the bike less than the crown does
                let aside = fixed.normal_trail * x.steer[i].sin() * s.load[0] / s.cos_roll;
                let steered = if aside.is_finite() { aside } else { 0.0 };
                -m * h * (GRAVITY * (1.0 + s.lift) * s.sin_roll + s.lateral * s.cos_roll)
                    - spin * s.turn * s.cos_roll // (34a)
                    + steered
            }
            Formulation::Paper => {
                let lenticular = -(s.turn * s.speed / GRAVITY).atan(); // (34b)
                m * h
                    * (s.turn * s.speed * (lenticular.cos() - s.cos_roll)
                        - GRAVITY * (lenticular.sin() - s.sin_roll)) // (34a) as printed
            }
        }
    }

    /// Factor of `k_x` in the overturning moment (35), N.
    fn overturning_lever(&self, s: &CornerState) -> f64 {
        let b = &self.bike;
        match self.formulation {
            // both crowns, the rear's by the ratio of widths (36b)
            Formulation::Corrected => {
                let ratio = b.rear.width / b.front.width;
                let tilted = -(GRAVITY * (1.0 + s.lift) * s.sin_roll + s.lateral * s.cos_roll);
                // on its crowns the centre of mass is farther from the ground along the leaned plane
                let farther = b.mass * (1.0 / s.cos_roll - 1.0) * tilted;
                let crowns = (s.load[0] + ratio * s.load[1]) / (s.load[0] + s.load[1]);
                -(s.load[0] * s.front.camber_tan + ratio * s.load[1] * s.sin_roll / s.cos_roll)
                    - crowns * farther
            }
            Formulation::Paper => b.mass * GRAVITY * s.roll.tan(), // (35) as printed
        }
    }
}

/// Numbers of a bike file that are computed once for all samples.
struct Fixed {
    /// Sine and cosine of the caster angle.
    caster: (f64, f64),
    /// Yaw inertia, kg m².
    yaw_inertia: f64,
    /// Normal trail, m.
    normal_trail: f64,
}

impl Fixed {
    fn of(bike: &Bike) -> Self {
        Fixed {
            caster: bike.caster_angle.sin_cos(),
            yaw_inertia: bike.yaw_inertia(),
            normal_trail: bike.normal_trail(),
        }
    }
}

/// See [`Inputs::held_lag`].
#[derive(Debug, Clone)]
pub struct HeldLag {
    /// Relaxation lengths that it is of, m.
    relaxation: [f64; 2],
    /// Lagged less kinematic slip angles, front and rear, by sample, rad.
    behind: [Vec<f64>; 2],
}

/// How the motorcycle moves in a corner sample, and what it weighs on its tyres.
struct CornerState {
    /// Forward speed of the centre of mass, m/s.
    speed: f64,
    /// Roll, rad.
    roll: f64,
    sin_roll: f64,
    cos_roll: f64,
    /// Yaw rate, rad/s.
    turn: f64,
    /// Slip angle, rad.
    slip_angle: [f64; 2],
    /// Camber, rad.
    camber: [f64; 2],
    front: FrontWheel,
    /// Longitudinal force of both tyres, N.
    total_x: f64,
    /// Upward acceleration of the centre of mass over gravity.
    lift: f64,
    /// Load, N.
    load: [f64; 2],
    /// Lateral acceleration of the centre of mass, m/s².
    lateral: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;
    use crate::contract::session::{Meta, Session};
    use crate::estimate::Config;
    use crate::estimate::samples::gather;
    use crate::segment::Segment;
    use crate::segment::manoeuvre::ManoeuvreKind;
    use std::path::Path;

    const BIKE: &str = "mass = 200.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
        caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nrear.radius = 0.3\n\
        rear.width = 0.18\n";

    /// Loads in a ride at 20 m/s whose frame dives faster and faster, by `pitching` rad/s².
    fn loads(formulation: Formulation, pitching: f64, rolling: f64) -> [f64; 2] {
        let mut session = Session::new(Meta::default(), 100.0, 200);
        let time = |i: i32| f64::from(i) / 100.0 - 1.0;
        let column = |f: &dyn Fn(f64) -> f64| (0..200).map(|i| f(time(i))).collect::<Vec<f64>>();
        session.set(Channel::VelocityX, vec![20.0; 200]);
        session.set(Channel::AccelerationX, vec![0.0; 200]);
        session.set(Channel::Roll, vec![0.0; 200]);
        session.set(Channel::PitchRate, column(&|t| pitching * t));
        let braking = Segment {
            kind: ManoeuvreKind::FrontBraking,
            start: 0,
            end: 200,
            direction: None,
            quality: 1.0,
            used: true,
            reason: None,
        };
        let samples = gather(
            &session,
            &[braking],
            &[ManoeuvreKind::FrontBraking],
            100.0,
            0.0,
            &Config::default(),
        );
        let bike = Bike::parse(BIKE, "b", Path::new("b.toml")).expect("bike");
        let mut inputs = Inputs::nominal(&bike, formulation, Zeros::default());
        (inputs.drag, inputs.rolling) = (0.0, rolling);
        let signals = inputs.straight(&samples, &vec![Action::Braking(1.0); samples.len()]);
        let middle = samples.len() / 2;
        [0, 1].map(|k| signals.load[k][middle])
    }

    #[test]
    fn a_frame_that_dives_ever_faster_has_its_load_behind() {
        let weight = 200.0 * GRAVITY;
        let still = loads(Formulation::Corrected, 0.0, 0.0);
        assert!((still[0] - 0.5 * weight).abs() < 1e-9 && (still[1] - 0.5 * weight).abs() < 1e-9);
        // the pitch inertia of 40 kg m² over the wheelbase
        let diving = loads(Formulation::Corrected, 3.0, 0.0);
        assert!((still[0] - diving[0] - 40.0 * 3.0 / 1.4).abs() < 1e-6, "{still:?} {diving:?}");
        assert!((diving[0] + diving[1] - weight).abs() < 1e-9);
        let printed = loads(Formulation::Paper, 3.0, 0.0);
        assert!((printed[0] - 0.5 * weight).abs() < 1e-9);
    }

    /// Readings of some channels' sensors for given inputs and loads.
    type Shown<'a> = &'a dyn Fn(&Inputs, [f64; 2]) -> Vec<(Channel, f64)>;

    /// Slip forces of a braking with both brakes at 10 m/s², with sensors of some channels that show these values.
    fn shared(sensors: Shown<'_>) -> [f64; 2] {
        let bike = Bike::parse(BIKE, "b", Path::new("b.toml")).expect("bike");
        let mut inputs = Inputs::nominal(&bike, Formulation::Corrected, Zeros::default());
        (inputs.drag, inputs.rolling) = (0.0, 0.0);
        let transfer = 200.0 * 10.0 * 0.6 / 1.4;
        let load = [100.0 * GRAVITY + transfer, 100.0 * GRAVITY - transfer];
        let mut session = Session::new(Meta::default(), 100.0, 200);
        session.set(Channel::VelocityX, vec![20.0; 200]);
        session.set(Channel::AccelerationX, vec![-10.0; 200]);
        session.set(Channel::WheelSpeedFront, vec![66.0; 200]);
        session.set(Channel::WheelSpeedRear, vec![66.0; 200]);
        for (channel, value) in sensors(&inputs, load) {
            session.set(channel, vec![value; 200]);
        }
        let kind = ManoeuvreKind::CombinedBraking;
        let braking = Segment {
            kind,
            start: 0,
            end: 200,
            direction: None,
            quality: 1.0,
            used: true,
            reason: None,
        };
        let samples = gather(&session, &[braking], &[kind], 100.0, 0.0, &Config::default());
        let signals = inputs.straight(&samples, &vec![Action::Measured; samples.len()]);
        let middle = samples.len() / 2;
        [0, 1].map(|k| signals.force_x[k][middle])
    }

    #[test]
    fn sensors_of_the_wheels_share_a_braking_with_both_brakes() {
        let near = |found: [f64; 2], truth: [f64; 2]| {
            assert!(found.iter().zip(truth).all(|(f, t)| (f - t).abs() < 1.0), "{found:?}");
        };
        // 2000 N in all: the balance keeps the sum, whatever the scale of both sensors
        for scale in [1.0, 1.02] {
            let forces = shared(&|_, _| {
                let (x, y) = (Channel::WheelForceXFront, Channel::WheelForceXRear);
                vec![(x, -1500.0 * scale), (y, -500.0 * scale)]
            });
            near(forces, [-1500.0, -500.0]);
        }
        // a torque acts about the axle, which stands lower than the wheel rolls
        let torques = shared(&|inputs, load| {
            let height = [0, 1].map(|k| inputs.axle_height(k, load[k]));
            assert!(height[0] < inputs.radius[0] - 0.005, "{height:?}");
            let (x, y) = (Channel::BrakeTorqueFront, Channel::BrakeTorqueRear);
            vec![(x, 1500.0 * height[0]), (y, 500.0 * height[1])]
        });
        near(torques, [-1500.0, -500.0]);
        near(shared(&|_, _| vec![(Channel::WheelForceXRear, -500.0)]), [-1500.0, -500.0]);
        assert!(shared(&|_, _| Vec::new()).iter().all(|f| f.is_nan()));
    }

    #[test]
    fn rolling_wheels_carry_ahead_of_their_axles() {
        let [front, rear] = loads(Formulation::Corrected, 0.0, 0.02);
        // 0.02 times 0.3 m ahead: the front stands as much too far ahead of the centre of mass
        let weight = 200.0 * GRAVITY;
        assert!((front - weight * (0.7 - 0.006) / 1.4).abs() < 1e-9, "{front}");
        assert!((front + rear - weight).abs() < 1e-9);
    }

    #[test]
    fn a_handlebar_that_was_not_measured_points_the_wheel_along_the_bend() {
        let bike = Bike::parse(BIKE, "b", Path::new("b.toml")).expect("bike");
        let mut inputs = Inputs::nominal(&bike, Formulation::Corrected, Zeros::default());
        let (speed, turn, roll) = (20.0_f64, 0.35_f64, -0.7_f64);
        let x = Samples { steer: vec![f64::NAN], yaw_rate: vec![turn], ..Samples::default() };
        let (leaning, caster) = (roll.sin_cos(), bike.caster_angle.sin_cos());
        let ground = speed - turn * bike.cg_height * leaning.0;
        let angle = |inputs: &Inputs| {
            let found = inputs.handlebar(&x, 0, speed, leaning);
            front_wheel(found, leaning, caster, Formulation::Corrected).steer()
        };
        let along = (bike.wheelbase * turn / ground).atan();
        assert!((angle(&inputs) - along).abs() < 1e-12);
        // a front wheel that slips more than the rear one points that much less into the corner
        inputs.slip_difference = 0.05;
        assert!((angle(&inputs) - (along - 0.05 * leaning.0)).abs() < 1e-12);
        let measured = Samples { steer: vec![0.02], ..x.clone() };
        assert_eq!(inputs.handlebar(&measured, 0, speed, leaning), 0.02);
    }
}
