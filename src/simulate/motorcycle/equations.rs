//! The equations of motion of the reduced-order motorcycle, from the pose over the tyres' forces to the
//! rates of the state.

use nalgebra::{Matrix3, Vector3};

use super::plant::Plant;
use super::state::{Action, N, Response, State};
use crate::GRAVITY;
use crate::simulate::effects::composed::Acting;
use crate::simulate::effects::physics::Rolling;
use crate::tyre::formulation::Formulation::Corrected;
use crate::tyre::kinematics::{below_mass_centre, front_wheel, steering_rate};
use crate::tyre::pair::both;
use crate::tyre::paper::{Input, Output, slip_stiffness_under};
use crate::tyre::tyre_model::load_lead;

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

/// Tyre forces per unit of load: all but the trail are proportional to it.
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
    /// Rolling resistance.
    rolling: [f64; 2],
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
pub(super) const SLIP_SPEED: f64 = 1.0;
/// Below this speed the rider's feet hold the bike up.
const FEET_DOWN: f64 = 2.5;
/// Lag of the rider's arms on the handlebar, s.
pub(super) const STEER_LAG: f64 = 0.01;

impl Plant {
    /// Longitudinal and lateral velocity of the contact points in their wheels' frames.
    fn contact_velocity(
        &self,
        s: &State,
        (sin_phi, cos_phi): (f64, f64),
        (sin_d, cos_d): (f64, f64),
        cos_caster: f64,
        dive_rate: f64,
    ) -> [(f64, f64); 2] {
        let vehicle = &self.vehicle;
        let contact = both(|k| {
            below_mass_centre(vehicle.cg_height, self.crown[k], vehicle.sag[k], (sin_phi, cos_phi))
        });
        let u = |k: usize| s.vx - vehicle.dive_arm[k] * dive_rate - s.yaw_rate * contact[k][0];
        let w = |k: usize, ahead: f64| s.vy + contact[k][1] * s.roll_rate + ahead * s.yaw_rate;
        // not that of the arms, which wobble
        let rate = steering_rate(vehicle.wheelbase, cos_caster, cos_phi, s.roll_rate, s.vx);
        let (uf, wf) = (u(0), w(0, vehicle.cg_to_front) - vehicle.normal_trail * cos_phi * rate);
        let (ur, wr) = (u(1), w(1, vehicle.cg_to_front - vehicle.wheelbase));
        [(uf * cos_d + wf * sin_d, wf * cos_d - uf * sin_d), (ur, wr)]
    }

    /// Derivative of the state, and everything on the way.
    ///
    /// `caster` is the sine and cosine of the caster angle, `known` the load of an instant before.
    pub(super) fn derivative(
        &self,
        caster: (f64, f64),
        s: &State,
        action: &Action,
        known: Option<[f64; 2]>,
    ) -> ([f64; N], Response) {
        let pose = self.pose(caster, s, action.dive_rate);
        let mut forces =
            self.with_load(&pose, s, action, known.unwrap_or_else(|| self.vehicle.static_loads()));
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

    /// How the motorcycle lies and where its wheels point and go.
    #[inline]
    fn pose(&self, caster: (f64, f64), s: &State, dive_rate: f64) -> Pose {
        let error = &self.model_error;
        let (sin_phi, cos_phi) = s.roll.sin_cos();
        let wheel = front_wheel(s.steer, (sin_phi, cos_phi), caster, Corrected);
        let level = [wheel.camber, s.roll];
        let known = [wheel.camber_tan, sin_phi / cos_phi];
        let camber = both(|k| error.camber(level[k]));
        let tan_camber = both(|k| match camber[k] == level[k] {
            true => known[k],
            false => camber[k].tan(),
        });
        let (mut steer, mut steer_sin_cos) = (wheel.steer(), wheel.steer_sin_cos);
        let compliance = error.compliance(0.0);
        if compliance != 0.0 {
            let tyre = &self.tyres[0];
            let ratio = tyre.side_force_ratio;
            let k_alpha = tyre.stiffness.k_alpha(camber[0], ratio);
            let side = -k_alpha * self.vehicle.static_loads()[0] * (s.alpha[0] + ratio * camber[0]);
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
            velocity: self.contact_velocity(
                s,
                (sin_phi, cos_phi),
                steer_sin_cos,
                caster.1,
                dive_rate,
            ),
        }
    }

    /// Tyre outputs per load, tyres as they are under an assumed load.
    #[inline]
    fn tyres_under(&self, pose: &Pose, s: &State, action: &Action, assumed: [f64; 2]) -> PerLoad {
        let error = &self.model_error;
        let static_load = self.vehicle.static_loads();
        let friction =
            self.friction * (1.0 - action.lost_grip) * error.grip(1.0, action.time, pose.along);
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
            let crown = if self.crown[0] > 0.0 { self.crown[i] / self.crown[0] } else { 1.0 };
            let rolling = Rolling { speed: s.vx, extra_load, versine, crown };
            let carcass = self.carcass(i, static_load[i]);
            let radius = error.radius(carcass.rolling_radius(assumed[i], versine), rolling);
            lever_arm[i] = carcass.lever_arm(assumed[i], versine);
            slip_ratio[i] = (radius * s.omega[i] - vx) / reference;
            let alpha_kin = vy.atan2(reference);
            alpha_rate[i] = tyre.slip_angle_rate(s.omega[i], alpha_kin, s.alpha[i]);
            let stiffer =
                slip_stiffness_under(self.vehicle.slip_stiffness_load, extra_load / static_load[i]);
            let input = Input {
                slip_ratio: stiffer * slip_ratio[i],
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
        let rolling = [rolling(0), rolling(1)];
        let ax = [unit[0].force_x + rolling[0], unit[1].force_x + rolling[1]];
        let x = [ax[0] * cos_d - unit[0].force_y * sin_d, ax[1]];
        let across = [ax[0] * sin_d + unit[0].force_y * cos_d, unit[1].force_y];
        let y = both(|i| error.weight_across(across[i]));
        PerLoad { slip_ratio, alpha_rate, lever_arm, unit, x, y, rolling }
    }

    /// Loads and roll acceleration that balance the tyres' forces under an assumed load.
    #[inline]
    fn with_load(&self, pose: &Pose, s: &State, action: &Action, assumed: [f64; 2]) -> Forces {
        let vehicle = &self.vehicle;
        let error = &self.model_error;
        let m = vehicle.mass;
        let (lf, lr) = (
            vehicle.cg_to_front - action.ahead,
            vehicle.wheelbase - vehicle.cg_to_front + action.ahead,
        );
        let (sin_phi, cos_phi) = pose.roll;
        let h = self.height_in_plane(cos_phi);
        // the crown's centre stays where it is, the frame comes down onto its springs
        let rising = vehicle.cg_height - self.loaded_crown() + self.loaded_sag();
        let per_load = self.tyres_under(pose, s, action, assumed);
        let PerLoad { unit, x, y, lever_arm, .. } = &per_load;
        let torque = both(|i| {
            let drive = if i == 1 { action.drive } else { 0.0 };
            match action.brake[i] == 0.0 {
                true => drive,
                false => drive - action.brake[i] * (s.omega[i] / 0.5).tanh(),
            }
        });
        let spin =
            error.spin(1.0) * (0..2).map(|i| vehicle.wheel_inertia[i] * s.omega[i]).sum::<f64>();
        let drive_per_load = both(|i| lever_arm[i] * unit[i].force_x);

        let diving = vehicle.pitch_inertia() * action.dive_acceleration;
        let drag = error.drag(vehicle.drag, s.vx, pose.along);
        let lift = error.lift(0.0, s.vx);
        let aside = error.mass_centre_aside(h * sin_phi, s.roll);
        // the steered front wheel stands beside the plane
        let beside = [vehicle.normal_trail * s.steer.sin() / cos_phi, 0.0];
        let arm = |i: usize| aside + h * cos_phi * y[i] + unit[i].moment_x - beside[i];
        let lead = |i: usize| load_lead(-per_load.rolling[i], lever_arm[i]);
        let a = Matrix3::new(
            1.0,
            1.0,
            m * rising * sin_phi,
            -lf - lead(0) - h * cos_phi * x[0] + cos_phi * drive_per_load[0],
            lr - lead(1) - h * cos_phi * x[1] + cos_phi * drive_per_load[1],
            0.0,
            -arm(0),
            -arm(1),
            vehicle.roll_inertia,
        );
        let b = Vector3::new(
            m * (GRAVITY - rising * cos_phi * s.roll_rate * s.roll_rate) - 2.0 * lift,
            error.pitch_moment(cos_phi * (torque[0] + torque[1] + diving), drag) + (lf - lr) * lift,
            // the extra lateral force acts at the centre of mass: no moment
            spin * s.yaw_rate * cos_phi,
        );
        let solution = match a.try_inverse() {
            Some(inverse) => inverse * b,
            None => {
                let [front, rear] = vehicle.static_loads(); // held
                Vector3::new(front, rear, 0.0)
            }
        };
        let load = [solution[0].max(0.0), solution[1].max(0.0)];
        let tyre = both(|i| Output {
            force_x: unit[i].force_x * load[i],
            force_y: unit[i].force_y * load[i],
            moment_x: unit[i].moment_x * load[i],
            moment_z: unit[i].moment_z * load[i],
        });
        Forces { per_load, torque, drag, load, roll_acceleration: solution[2], tyre }
    }

    /// Acceleration of the centre of mass, level frame.
    fn acceleration(&self, pose: &Pose, forces: &Forces, action: &Action) -> [f64; 2] {
        let m = self.vehicle.mass;
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
        let vehicle = &self.vehicle;
        let (lf, lr) = (vehicle.cg_to_front, vehicle.wheelbase - vehicle.cg_to_front);
        let (sin_phi, cos_phi) = pose.roll;
        let Forces { per_load, torque, load, tyre, .. } = forces;
        let PerLoad { x, y, alpha_rate, lever_arm, .. } = per_load;
        let omega_rate =
            both(|i| (torque[i] - lever_arm[i] * tyre[i].force_x) / vehicle.wheel_inertia[i]);
        let spin_moment: f64 = (0..2)
            .map(|i| {
                vehicle.wheel_inertia[i]
                    * (omega_rate[i] * sin_phi + s.omega[i] * cos_phi * s.roll_rate)
            })
            .sum::<f64>()
            * self.model_error.spin(1.0);
        let total_x: f64 = x[0] * load[0] + x[1] * load[1];
        let yaw_acceleration =
            (lf * y[0] * load[0] - lr * y[1] * load[1] + tyre[0].moment_z + tyre[1].moment_z
                - self.height_in_plane(cos_phi) * sin_phi * total_x
                - spin_moment
                + action.moment_z)
                / vehicle.yaw_inertia;
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
        self.derivative(self.vehicle.caster_angle.sin_cos(), state, action, load).1
    }

    /// Rates of the state at this instant: zero in a steady turn but for the heading.
    pub fn rates(&self, state: &State, action: &Action) -> State {
        State::from_array(
            &self.derivative(self.vehicle.caster_angle.sin_cos(), state, action, None).0,
        )
    }
}
