//! A reduced-order motorcycle on the paper's tyres: planar motion of the mass centre, yaw,
//! roll, both wheel spins, lagged slip angles, steering.
//!
//! Wheel loads and roll acceleration follow from the same instant's balances (tyre forces are
//! proportional to load, so this is a 3x3 linear solve, not a lag):
//!
//! ```text
//! vertical  Nf + Nr                       = m (g + z''),  z = h cos(phi)
//! pitch     -lf Nf + lr Nr - h cos(phi) X = cos(phi) sum(I omega')
//! roll      Ix phi''  = N h sin(phi) + h cos(phi) Y + Mx + sum(I omega) r cos(phi)
//! yaw       Iz r'     = lf Yf - lr Yr + Mz - h sin(phi) X - d/dt sum(I omega sin(phi))
//! plane     m (vx' - r vy) = X - drag + Fx,   m (vy' + r vx) = Y + Fy
//! ```
//!
//! Level frame on the trace of the bike's plane, ISO 8855; `X, Y` are tyre forces in that frame,
//! `v` is the mass centre's velocity. Left out: pitch and bounce dynamics, products of inertia,
//! the difference of yaw and pitch inertia. Tyres are toroids on springs ([`Carcass`]): rolling radius and
//! lever arm of the longitudinal force follow load and camber.

use nalgebra::{Matrix3, Vector3};

use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::effects::ModelError;
use crate::effects::composed::Acting;
use crate::effects::physics::Rolling;
use crate::model::formulation::Formulation::Corrected;
use crate::model::kinematics::front_wheel;
use crate::model::tyre::{Input, Output, Tyre};
use crate::model::tyre_model::Carcass;

/// Everything true about the simulated bike. SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Mass with rider.
    pub mass: f64,
    /// Front contact to mass centre.
    pub cg_to_front: f64,
    /// Wheelbase.
    pub wheelbase: f64,
    /// Mass centre height.
    pub cg_height: f64,
    /// Caster angle.
    pub caster_angle: f64,
    /// Roll inertia about the mass centre.
    pub roll_inertia: f64,
    /// Yaw inertia about the mass centre.
    pub yaw_inertia: f64,
    /// Wheel spin inertias, front and rear.
    pub wheel_inertia: [f64; 2],
    /// Tyres, front and rear.
    pub tyres: [Tyre; 2],
    /// Drag `F = c v^2`.
    pub drag: f64,
    /// Road friction.
    pub friction: f64,
    /// Brake torque per pressure, front and rear.
    pub brake_gain: [f64; 2],
    /// Crown radii of the unloaded tyres, m.
    pub crown: [f64; 2],
    /// Share of a tyre's deflection by which it rolls shorter.
    pub deflection_share: f64,
    /// How fast the contacts fall behind the mass centre per rate of dive, m.
    pub dive_arm: [f64; 2],
    /// What it has beyond all that; put in by [`Plant::with`].
    pub model_error: ModelError,
}

/// The integrated state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Mass centre forward velocity.
    pub vx: f64,
    /// Mass centre lateral velocity.
    pub vy: f64,
    /// Yaw rate.
    pub yaw_rate: f64,
    /// Heading.
    pub yaw: f64,
    /// Roll.
    pub roll: f64,
    /// Roll rate.
    pub roll_rate: f64,
    /// Wheel spins, front and rear.
    pub omega: [f64; 2],
    /// Lagged slip angles, front and rear.
    pub alpha: [f64; 2],
    /// Handlebar angle.
    pub steer: f64,
}

const N: usize = 11;

impl State {
    fn to_array(self) -> [f64; N] {
        let s = self;
        [
            s.vx,
            s.vy,
            s.yaw_rate,
            s.yaw,
            s.roll,
            s.roll_rate,
            s.omega[0],
            s.omega[1],
            s.alpha[0],
            s.alpha[1],
            s.steer,
        ]
    }

    fn from_array(a: &[f64; N]) -> Self {
        State {
            vx: a[0],
            vy: a[1],
            yaw_rate: a[2],
            yaw: a[3],
            roll: a[4],
            roll_rate: a[5],
            omega: [a[6], a[7]],
            alpha: [a[8], a[9]],
            steer: a[10],
        }
    }
}

/// What rider, road and air do during a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Action {
    /// Commanded handlebar angle.
    pub steer: f64,
    /// Brake torques, front and rear.
    pub brake: [f64; 2],
    /// Drive torque at the rear wheel.
    pub drive: f64,
    /// Extra forward force on the mass centre: slope, gusts.
    pub force_x: f64,
    /// Extra lateral force on the mass centre.
    pub force_y: f64,
    /// Extra yaw moment.
    pub moment_z: f64,
    /// Time since the ride began, s.
    pub time: f64,
    /// How far the mass centre has moved ahead of its place over the wheels, m: a diving frame.
    pub ahead: f64,
    /// Rate of the dive, rad/s.
    pub dive_rate: f64,
}

impl Action {
    /// On the way to another, a share of it gone; the time stays.
    fn towards(&self, to: &Action, share: f64) -> Action {
        let between = |a: f64, b: f64| a + share * (b - a);
        Action {
            steer: between(self.steer, to.steer),
            brake: [0, 1].map(|k| between(self.brake[k], to.brake[k])),
            drive: between(self.drive, to.drive),
            force_x: between(self.force_x, to.force_x),
            force_y: between(self.force_y, to.force_y),
            moment_z: between(self.moment_z, to.moment_z),
            time: self.time,
            ahead: between(self.ahead, to.ahead),
            dive_rate: between(self.dive_rate, to.dive_rate),
        }
    }
}

/// What follows from a state and an action.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Mass centre acceleration, level frame.
    pub acceleration: [f64; 2],
    /// Roll acceleration.
    pub roll_acceleration: f64,
    /// Wheel loads.
    pub load: [f64; 2],
    /// Slip ratios.
    pub slip_ratio: [f64; 2],
    /// Camber angles.
    pub camber: [f64; 2],
    /// Tyre outputs, wheel frame; without rolling resistance.
    pub tyre: [Output; 2],
    /// Kinematic steering angle on the road.
    pub kinematic_steer: f64,
}

/// How the motorcycle lies at an instant. Pairs are front and rear.
struct Pose {
    /// Sine and cosine of the roll.
    roll: (f64, f64),
    /// Cosine of the heading; zero where no effect depends on it.
    along: f64,
    camber: [f64; 2],
    tan_camber: [f64; 2],
    /// Steering angle on the road, and its sine and cosine.
    steer: f64,
    steer_sin_cos: (f64, f64),
    /// Of the contacts, along and across their wheels.
    velocity: [(f64, f64); 2],
}

/// What tyres do per unit of load: all but the trail are proportional to it.
struct PerLoad {
    slip_ratio: [f64; 2],
    alpha_rate: [f64; 2],
    /// Of the longitudinal forces about the axles, m.
    lever_arm: [f64; 2],
    /// Wheel frame.
    unit: [Output; 2],
    /// Level frame, rolling resistance included.
    x: [f64; 2],
    y: [f64; 2],
}

/// Forces and loads that balance.
struct Forces {
    per_load: PerLoad,
    /// Of drive and brakes on the wheels.
    torque: [f64; 2],
    drag: f64,
    load: [f64; 2],
    roll_acceleration: f64,
    tyre: [Output; 2],
}

/// Below this speed slips are formed with this speed: no division by a standstill.
const SLIP_SPEED: f64 = 1.0;
/// Below this speed the rider's feet hold the bike up.
const FEET_DOWN: f64 = 2.5;
/// Lag of the rider's arms on the handlebar, s.
const STEER_LAG: f64 = 0.01;

impl Plant {
    /// The plant with a model error in it.
    #[must_use]
    pub fn with(mut self, error: &ModelError) -> Self {
        for (tyre, axle) in self.tyres.iter_mut().zip(Axle::BOTH) {
            let change = error.side_force_ratio(0.0, axle);
            tyre.side_force_ratio += change;
            tyre.stiffness.c1 -= change; // k_alpha stays what it is
            tyre.twisting_stiffness = error.twisting_stiffness(tyre.twisting_stiffness);
            tyre.relaxation_length = error.relaxation_length(tyre.relaxation_length);
        }
        self.wheel_inertia = self.wheel_inertia.map(|i| error.wheel_inertia(i));
        self.model_error = *error;
        self
    }

    /// Longitudinal and lateral velocity of the contact points in their wheels' frames.
    fn contact_velocity(
        &self,
        s: &State,
        (sin_phi, cos_phi): (f64, f64),
        (sin_d, cos_d): (f64, f64),
        dive_rate: f64,
    ) -> [(f64, f64); 2] {
        // the contact line lies beside the leaned mass centre, by a crown less than its height
        let beside = |k: usize| (self.cg_height - self.crown[k]) * sin_phi;
        let u = |k: usize| s.vx - self.dive_arm[k] * dive_rate - s.yaw_rate * beside(k);
        let height = |k: usize| self.cg_height * cos_phi + self.crown[k] * (1.0 - cos_phi);
        let w = |k: usize, ahead: f64| s.vy + height(k) * s.roll_rate + ahead * s.yaw_rate;
        let (uf, wf) = (u(0), w(0, self.cg_to_front));
        let (ur, wr) = (u(1), w(1, self.cg_to_front - self.wheelbase));
        [(uf * cos_d + wf * sin_d, wf * cos_d - uf * sin_d), (ur, wr)]
    }

    /// Derivative of the state, and everything on the way.
    ///
    /// `caster` is the sine and cosine of the caster angle, `known` the load of an instant before.
    fn derivative(
        &self,
        caster: (f64, f64),
        s: &State,
        action: &Action,
        known: Option<[f64; 2]>,
    ) -> ([f64; N], Response) {
        let pose = self.pose(caster, s, action.dive_rate);
        let mut forces =
            self.with_load(&pose, s, action, known.unwrap_or_else(|| self.static_load()));
        if known.is_none() {
            // loads depend on the forces and the forces on the loads: weakly, so twice is enough
            for _ in 0..2 {
                forces = self.with_load(&pose, s, action, forces.load);
            }
        }
        let acceleration = self.acceleration(&pose, &forces, action);
        let rates = self.rates_of(&pose, &forces, s, action, acceleration);
        let response = Response {
            acceleration,
            roll_acceleration: forces.roll_acceleration,
            load: forces.load,
            slip_ratio: forces.per_load.slip_ratio,
            camber: pose.camber,
            tyre: forces.tyre,
            kinematic_steer: pose.steer,
        };
        (rates, response)
    }

    /// The carcass of tyre `k`.
    fn carcass(&self, k: usize, static_load: f64) -> Carcass {
        let Tyre { rolling_radius, vertical_stiffness, .. } = self.tyres[k];
        let (crown, share) = (self.crown[k], self.deflection_share);
        Carcass::of_rolling(rolling_radius, static_load, vertical_stiffness, crown, share)
    }

    /// Wheel loads at rest.
    fn static_load(&self) -> [f64; 2] {
        let weight = self.mass * GRAVITY / self.wheelbase;
        [weight * (self.wheelbase - self.cg_to_front), weight * self.cg_to_front]
    }

    /// How the motorcycle lies and where its wheels point and go.
    #[inline]
    fn pose(&self, caster: (f64, f64), s: &State, dive_rate: f64) -> Pose {
        let error = &self.model_error;
        let (sin_phi, cos_phi) = s.roll.sin_cos();
        let wheel = front_wheel(s.steer, (sin_phi, cos_phi), caster, Corrected);
        let level = [wheel.camber, s.roll];
        let known = [wheel.camber_tan, sin_phi / cos_phi];
        let camber = level.map(|g| error.camber(g));
        let tan_camber = [0, 1].map(|k| match camber[k] == level[k] {
            true => known[k],
            false => camber[k].tan(),
        });
        let (mut steer, mut steer_sin_cos) = (wheel.steer, wheel.steer_sin_cos);
        let compliance = error.compliance(0.0);
        if compliance != 0.0 {
            let tyre = &self.tyres[0];
            let ratio = tyre.side_force_ratio;
            let k_alpha = tyre.stiffness.k_alpha(camber[0], ratio);
            let side = -k_alpha * self.static_load()[0] * (s.alpha[0] + ratio * camber[0]);
            steer -= compliance * side;
            steer_sin_cos = steer.sin_cos();
        }
        Pose {
            roll: (sin_phi, cos_phi),
            along: if error.needs_heading() { s.yaw.cos() } else { 0.0 },
            camber,
            tan_camber,
            steer,
            steer_sin_cos,
            velocity: self.contact_velocity(s, (sin_phi, cos_phi), steer_sin_cos, dive_rate),
        }
    }

    /// Tyre outputs per load, tyres as they are under an assumed load.
    #[inline]
    fn tyres_under(&self, pose: &Pose, s: &State, time: f64, assumed: [f64; 2]) -> PerLoad {
        let error = &self.model_error;
        let static_load = self.static_load();
        let friction = self.friction * error.grip(1.0, time, pose.along);
        let mut slip_ratio = [0.0; 2];
        let mut alpha_rate = [0.0; 2];
        let mut lever_arm = [0.0; 2];
        let mut unit = [Output::default(); 2];
        for i in 0..2 {
            let tyre = &self.tyres[i];
            let (vx, vy) = pose.velocity[i];
            let camber = pose.camber[i];
            let reference = vx.abs().max(SLIP_SPEED);
            let extra_load = assumed[i] - static_load[i];
            let versine = 1.0 - 1.0 / (1.0 + pose.tan_camber[i] * pose.tan_camber[i]).sqrt();
            let rolling = Rolling { speed: s.vx, extra_load, versine };
            let carcass = self.carcass(i, static_load[i]);
            let radius = error.radius(carcass.rolling_radius(assumed[i], versine), rolling);
            lever_arm[i] = carcass.lever_arm(assumed[i], versine);
            slip_ratio[i] = (radius * s.omega[i] - vx) / reference;
            let alpha_kin = vy.atan2(reference);
            alpha_rate[i] = tyre.slip_angle_rate(s.omega[i], alpha_kin, s.alpha[i]);
            let input = Input {
                slip_ratio: slip_ratio[i],
                slip_angle: s.alpha[i],
                camber,
                load: static_load[i],
                friction,
            };
            let out = tyre.forces_at(&input, pose.tan_camber[i]);
            let per = 1.0 / static_load[i];
            let per_load = Output {
                force_x: out.force_x * per,
                force_y: out.force_y * per,
                moment_x: out.moment_x * per,
                moment_z: out.moment_z * per,
            };
            let acting = Acting {
                tyre,
                slip_angle: s.alpha[i],
                camber,
                load: 1.0,
                reference_load: static_load[i],
                extra_load: extra_load / static_load[i],
            };
            unit[i] = error.tyre_output(per_load, &acting);
        }

        // forces per load in the level frame
        let rolling = |i: usize| {
            let fade = (pose.velocity[i].0 / 0.3).tanh(); // nothing resists a standing wheel
            -error.rolling_resistance(self.tyres[i].rolling_resistance, s.vx) * fade
        };
        let (sin_d, cos_d) = pose.steer_sin_cos;
        let ax = [unit[0].force_x + rolling(0), unit[1].force_x + rolling(1)];
        let x = [ax[0] * cos_d - unit[0].force_y * sin_d, ax[1]];
        let y = [ax[0] * sin_d + unit[0].force_y * cos_d, unit[1].force_y]
            .map(|y| error.weight_across(y));
        PerLoad { slip_ratio, alpha_rate, lever_arm, unit, x, y }
    }

    /// Loads and roll acceleration that balance the tyres' forces under an assumed load.
    #[inline]
    fn with_load(&self, pose: &Pose, s: &State, action: &Action, assumed: [f64; 2]) -> Forces {
        let error = &self.model_error;
        let (m, h) = (self.mass, self.cg_height);
        let (lf, lr) =
            (self.cg_to_front - action.ahead, self.wheelbase - self.cg_to_front + action.ahead);
        let (sin_phi, cos_phi) = pose.roll;
        let per_load = self.tyres_under(pose, s, action.time, assumed);
        let PerLoad { unit, x, y, lever_arm, .. } = &per_load;
        let torque: [f64; 2] = std::array::from_fn(|i| {
            let drive = if i == 1 { action.drive } else { 0.0 };
            match action.brake[i] == 0.0 {
                true => drive,
                false => drive - action.brake[i] * (s.omega[i] / 0.5).tanh(),
            }
        });
        let spin =
            error.spin(1.0) * (0..2).map(|i| self.wheel_inertia[i] * s.omega[i]).sum::<f64>();
        let drive_per_load: [f64; 2] = std::array::from_fn(|i| lever_arm[i] * unit[i].force_x);

        let drag = error.drag(self.drag, s.vx, pose.along);
        let lift = error.lift(0.0, s.vx);
        let aside = error.mass_centre_aside(h * sin_phi, s.roll);
        let arm = |i: usize| aside + h * cos_phi * y[i] + unit[i].moment_x;
        let a = Matrix3::new(
            1.0,
            1.0,
            m * h * sin_phi,
            -lf - h * cos_phi * x[0] + cos_phi * drive_per_load[0],
            lr - h * cos_phi * x[1] + cos_phi * drive_per_load[1],
            0.0,
            -arm(0),
            -arm(1),
            self.roll_inertia,
        );
        let b = Vector3::new(
            m * (GRAVITY - h * cos_phi * s.roll_rate * s.roll_rate) - 2.0 * lift,
            error.pitch_moment(cos_phi * (torque[0] + torque[1]), drag) + (lf - lr) * lift,
            // the extra lateral force acts at the mass centre: no moment
            spin * s.yaw_rate * cos_phi,
        );
        let solution = match a.try_inverse() {
            Some(inverse) => inverse * b,
            None => {
                let [front, rear] = self.static_load(); // held
                Vector3::new(front, rear, 0.0)
            }
        };
        let load = [solution[0].max(0.0), solution[1].max(0.0)];
        let tyre = [0, 1].map(|i| Output {
            force_x: unit[i].force_x * load[i],
            force_y: unit[i].force_y * load[i],
            moment_x: unit[i].moment_x * load[i],
            moment_z: unit[i].moment_z * load[i],
        });
        Forces { per_load, torque, drag, load, roll_acceleration: solution[2], tyre }
    }

    /// Acceleration of the mass centre, level frame.
    fn acceleration(&self, pose: &Pose, forces: &Forces, action: &Action) -> [f64; 2] {
        let m = self.mass;
        let Forces { per_load: PerLoad { x, y, .. }, drag, load, .. } = forces;
        let total_x: f64 = x[0] * load[0] + x[1] * load[1];
        let total_y: f64 = y[0] * load[0] + y[1] * load[1];
        let uphill = self.model_error.uphill(0.0, m * GRAVITY, pose.along);
        [(total_x - drag - uphill + action.force_x) / m, (total_y + action.force_y) / m]
    }

    /// Rates of the state.
    #[inline]
    fn rates_of(
        &self,
        pose: &Pose,
        forces: &Forces,
        s: &State,
        action: &Action,
        acceleration: [f64; 2],
    ) -> [f64; N] {
        let (lf, lr) = (self.cg_to_front, self.wheelbase - self.cg_to_front);
        let (sin_phi, cos_phi) = pose.roll;
        let Forces { per_load, torque, load, tyre, .. } = forces;
        let PerLoad { x, y, alpha_rate, lever_arm, .. } = per_load;
        let omega_rate: [f64; 2] = std::array::from_fn(|i| {
            (torque[i] - lever_arm[i] * tyre[i].force_x) / self.wheel_inertia[i]
        });
        let spin_moment: f64 = (0..2)
            .map(|i| {
                self.wheel_inertia[i]
                    * (omega_rate[i] * sin_phi + s.omega[i] * cos_phi * s.roll_rate)
            })
            .sum::<f64>()
            * self.model_error.spin(1.0);
        let total_x: f64 = x[0] * load[0] + x[1] * load[1];
        let yaw_acceleration =
            (lf * y[0] * load[0] - lr * y[1] * load[1] + tyre[0].moment_z + tyre[1].moment_z
                - self.cg_height * sin_phi * total_x
                - spin_moment
                + action.moment_z)
                / self.yaw_inertia;
        let mut d = [
            acceleration[0] + s.yaw_rate * s.vy,
            acceleration[1] - s.yaw_rate * s.vx,
            yaw_acceleration,
            s.yaw_rate,
            s.roll_rate,
            forces.roll_acceleration,
            omega_rate[0],
            omega_rate[1],
            alpha_rate[0],
            alpha_rate[1],
            (action.steer - s.steer) / STEER_LAG,
        ];
        if s.vx < FEET_DOWN {
            let settle = |value: f64| -value / 0.2;
            d[1] = settle(s.vy);
            d[2] = settle(s.yaw_rate);
            d[5] = -10.0 * s.roll_rate - 25.0 * s.roll;
            d[8] = settle(s.alpha[0]);
            d[9] = settle(s.alpha[1]);
            d[10] = settle(s.steer);
        }
        d
    }

    /// Everything that follows from a state and an action at this instant.
    pub fn response(&self, state: &State, action: &Action) -> Response {
        self.response_near(state, action, None)
    }

    /// The same where the loads of an instant before, N, are known.
    pub fn response_near(
        &self,
        state: &State,
        action: &Action,
        load: Option<[f64; 2]>,
    ) -> Response {
        self.derivative(self.caster_angle.sin_cos(), state, action, load).1
    }

    /// Rates of the state at this instant: zero in a steady turn but for the heading.
    pub fn rates(&self, state: &State, action: &Action) -> State {
        State::from_array(&self.derivative(self.caster_angle.sin_cos(), state, action, None).0)
    }

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::simulate::scenario::Scenario;

    fn plant() -> Plant {
        Scenario::builtin("perfect").expect("scenario").nominal_plant()
    }

    #[test]
    fn coasting_follows_the_closed_form() {
        // m* v' = -c v^2 - c_rol m g with m* = m + sum(I/(R R_l)), R_l the lever arm:
        // v(t) = sqrt(r/c) tan(atan(v0 sqrt(c/r)) - sqrt(r c)/m* t)
        let p = plant();
        let mut s = State { vx: 20.0, ..State::default() };
        s.omega = [20.0 / p.tyres[0].rolling_radius, 20.0 / p.tyres[1].rolling_radius];
        for _ in 0..1000 {
            p.advance(&mut s, &Action::default(), 0.01);
        }
        let effective = p.mass
            + (0..2)
                .map(|i| {
                    let load = p.static_load()[i];
                    let lever = p.carcass(i, load).lever_arm(load, 0.0);
                    p.wheel_inertia[i] / (p.tyres[i].rolling_radius * lever)
                })
                .sum::<f64>();
        let resist = p.tyres[0].rolling_resistance * p.mass * GRAVITY;
        let root = (resist / p.drag).sqrt();
        let v = root * ((20.0 / root).atan() - (resist * p.drag).sqrt() / effective * 10.0).tan();
        assert!((s.vx - v).abs() < 2e-3, "{} {v}", s.vx);
    }

    #[test]
    fn loads_carry_the_weight_and_the_load_transfer() {
        let p = plant();
        let s = State { vx: 15.0, omega: [50.0, 48.0], ..State::default() };
        let action = Action { brake: [400.0, 0.0], ..Action::default() };
        let r = p.response(&s, &action);
        assert!((r.load[0] + r.load[1] - p.mass * GRAVITY).abs() < 1e-6);
        // pitch balance about the front contact with drag at the mass centre
        let rates = p.rates(&s, &action);
        let spin: f64 = (0..2).map(|i| p.wheel_inertia[i] * rates.omega[i]).sum();
        let x = p.mass * r.acceleration[0] + p.drag * s.vx * s.vx;
        let rear = (p.mass * GRAVITY * p.cg_to_front + x * p.cg_height + spin) / p.wheelbase;
        assert!((r.load[1] - rear).abs() < 1e-6, "{} {rear}", r.load[1]);
    }

    #[test]
    fn a_finer_step_changes_nothing_visible() {
        let p = plant();
        let start = State { vx: 12.0, omega: [41.0, 39.5], roll: -0.2, ..State::default() };
        let action = Action { steer: 0.02, brake: [150.0, 40.0], ..Action::default() };
        let (mut a, mut b) = (start, start);
        for _ in 0..50 {
            p.advance(&mut a, &action, 0.01);
            for _ in 0..8 {
                p.advance(&mut b, &action, 0.00125);
            }
        }
        let (a, b) = (a.to_array(), b.to_array());
        for i in 0..N {
            // a hundredth of what the best velocity sensor sees
            assert!((a[i] - b[i]).abs() < 2e-4 * (1.0 + b[i].abs()), "{i}: {} {}", a[i], b[i]);
        }
    }
}
