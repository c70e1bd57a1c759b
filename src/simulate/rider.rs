//! The rider: phases to handlebar, brakes and throttle.
//!
//! Steering inverts the roll balance: the lateral force that gives the wanted roll
//! acceleration, less what the rear tyre already gives, is asked of the front tyre by turning
//! its slip angle. Riders feel that force through the seat; the formula stands for the skill.

use super::motorcycle::{Action, Plant, Response, State};
use super::plan::Phase;
use super::programme::{Controls, Lean, Perceived, Programme};
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::segment::manoeuvre::{Direction, ManoeuvreKind};
use crate::simulate::effects::ride::Brakes;
use crate::statistics::random::{Coloured, Random};

/// How unsteady rider, road and air are.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Disturbance {
    /// Longitudinal gusts, N (correlation 1.5 s).
    pub gust_x: f64,
    /// Lateral gusts, N.
    pub gust_y: f64,
    /// Yaw moment, N m.
    pub moment_z: f64,
    /// Brake pad gain, relative scatter from stop to stop.
    pub brake_gain: f64,
    /// Slope, scatter from run to run (rise over run).
    pub grade: f64,
    /// Distance over which the road bends from one slope to the next, m.
    pub bend: f64,
    /// Lean the rider fails to hold, rad (correlation 1 s).
    pub lean: f64,
}

impl Default for Disturbance {
    fn default() -> Self {
        Disturbance {
            gust_x: 0.0,
            gust_y: 0.0,
            moment_z: 0.0,
            brake_gain: 0.0,
            grade: 0.0,
            bend: 0.0,
            lean: 0.0,
        }
    }
}

/// The rider on one session.
#[derive(Debug)]
pub(crate) struct Rider<'a> {
    plant: &'a Plant,
    programme: Programme<'a>,
    pressure: [f64; 2],
    gain: [f64; 2],
    grade: f64,
    next_grade: f64,
    /// Climbed since the start, m.
    height: f64,
    disturbance: Disturbance,
    noise: [Coloured; 4],
    random: Random,
    brakes: Brakes,
    time: f64,
    dt: f64,
}

impl<'a> Rider<'a> {
    /// A rider about to start; `dt` is the span between decisions.
    pub(crate) fn new(
        plant: &'a Plant,
        phases: &'a [Phase],
        disturbance: Disturbance,
        mut random: Random,
        dt: f64,
    ) -> Self {
        let d = disturbance;
        let noise = [
            Coloured::new(d.gust_x, 1.5, dt, &mut random),
            Coloured::new(d.gust_y, 1.5, dt, &mut random),
            Coloured::new(d.moment_z, 0.7, dt, &mut random),
            Coloured::new(d.lean, 1.0, dt, &mut random),
        ];
        let grade = d.grade * random.normal();
        Rider {
            plant,
            programme: Programme::new(phases, dt),
            pressure: [0.0; 2],
            gain: plant.vehicle.brake_gain,
            grade,
            next_grade: grade,
            height: 0.0,
            disturbance,
            noise,
            random,
            brakes: Brakes::default(),
            time: 0.0,
            dt,
        }
    }

    /// The phase under way; `None` at the end of the ride.
    pub(crate) fn phase(&self) -> Option<&Phase> {
        self.programme.phase()
    }

    /// Grade of the road, uphill positive, and what was climbed since the start, m.
    pub(crate) fn road(&self) -> [f64; 2] {
        [self.grade, self.height]
    }

    /// Kind and direction of the phase under way; `lean` in rad.
    pub(crate) fn label(&self, lean: f64) -> (ManoeuvreKind, Option<Direction>) {
        self.programme.label(lean)
    }

    /// Road and pads differ from run to run.
    fn vary(&mut self) {
        self.next_grade = self.disturbance.grade * self.random.normal();
        for i in 0..2 {
            let scatter = 1.0 + self.disturbance.brake_gain * self.random.normal();
            self.gain[i] = self.plant.vehicle.brake_gain[i] * scatter;
        }
    }

    /// One decision: what is done for the next `dt` seconds. `response` is the instant's.
    pub(crate) fn act(&mut self, state: &State, response: &Response) -> (Action, Controls) {
        let demand = self.programme.decide(&Perceived {
            speed: state.vx,
            yaw: state.yaw,
            yaw_rate: state.yaw_rate,
            roll: state.roll,
            position: [0.0; 2],
            load: response.load,
            slip_ratio: response.slip_ratio,
            slip_angle: state.alpha,
        });
        if demand.done {
            self.vary();
        }
        let mut controls = Controls { gear: demand.gear, ..Controls::default() };
        let mut lean = demand.lean;
        let (target, acceleration) = (demand.pressure, demand.acceleration);
        let mut action = Action::default();
        // pads bite within a tenth of a second and let go as fast
        for i in 0..2 {
            let rate = if target[i] > 0.0 { 0.02 } else { 0.06 };
            self.pressure[i] += (target[i] - self.pressure[i]) * (self.dt / rate).min(1.0);
            if target[i] == 0.0 && self.pressure[i] < 2e3 {
                self.pressure[i] = 0.0;
            }
        }
        self.brakes.update(state.vx, self.pressure, self.dt);
        let (mass, error) = (self.plant.vehicle.mass, &self.plant.model_error);
        let Brakes { whole, each } = self.brakes;
        for (i, axle) in Axle::BOTH.into_iter().enumerate() {
            let gain = error.brake_gain(1.0, mass, each[i]);
            let drag = error.brake_drag(0.0, mass, whole, axle);
            action.brake[i] = self.gain[i] * gain * self.pressure[i] + drag;
        }
        self.time += self.dt;
        action.time = self.time;
        action.lost_grip = demand.conditions.lost_grip;
        if let Some(wanted) = acceleration {
            let p = self.plant;
            let resist = p.vehicle.drag * state.vx * state.vx
                + p.tyres[1].rolling_resistance * mass * GRAVITY;
            let force = p.moving_mass() * wanted + resist;
            // a little engine braking with the throttle shut
            action.drive = force.max(-0.1 * mass * GRAVITY) * p.tyres[1].rolling_radius;
            controls.throttle = (force / (mass * 8.0)).clamp(0.0, 1.0);
        }
        let jitter = self.noise[3].next(&mut self.random);
        lean.angle += jitter;
        action.steer = steer(self.plant, state, response, &lean);
        let ridden = state.vx * self.dt;
        // without a corner at once, also where nothing is ridden
        let share = match self.disturbance.bend {
            bend if bend > 0.0 => (ridden.abs() / bend).min(1.0),
            _ => 1.0,
        };
        self.grade += (self.next_grade - self.grade) * share;
        self.height += ridden * self.grade;
        let running = (state.vx / 2.0).clamp(0.0, 1.0);
        action.force_x = running
            * (self.noise[0].next(&mut self.random)
                - self.plant.vehicle.mass * GRAVITY * self.grade);
        action.force_x -= self.plant.vehicle.drag * demand.conditions.pressure_gain(state.vx);
        action.force_y = running * self.noise[1].next(&mut self.random);
        action.moment_z = running * self.noise[2].next(&mut self.random);
        controls.pressure = self.pressure;
        (action, controls)
    }
}

/// Below this speed nobody steers by leaning, m/s.
const SLOWEST: f64 = 2.5;

/// Roll acceleration that brings the wanted roll motion about, rad/s².
fn wanted(state: &State, lean: &Lean) -> f64 {
    const BANDWIDTH: f64 = 4.0; // rad/s
    const DAMPING: f64 = 0.9;
    lean.acceleration
        + 2.0 * DAMPING * BANDWIDTH * (lean.rate - state.roll_rate)
        + BANDWIDTH * BANDWIDTH * (lean.angle - state.roll)
}

/// Handlebar angle that gives the wanted roll motion of a motorcycle that is nothing but the plain one: a rider
/// who does not know what is hidden in it, but for how he leans himself.
pub(crate) fn steer(p: &Plant, state: &State, response: &Response, lean: &Lean) -> f64 {
    let vehicle = &p.vehicle;
    if state.vx < SLOWEST {
        return 0.0;
    }
    let (sin_phi, cos_phi) = state.roll.sin_cos();
    let wanted = wanted(state, lean);
    let load = response.load[0] + response.load[1];
    let moment_x = response.tyre[0].moment_x + response.tyre[1].moment_x;
    let spin: f64 = (0..2).map(|i| vehicle.wheel_inertia[i] * state.omega[i]).sum();
    let gyroscopic = spin * state.yaw_rate * cos_phi;
    let height = p.height_in_plane(cos_phi);
    let steered = vehicle.normal_trail * state.steer.sin() / cos_phi * response.load[0];
    let aside = p.model_error.mass_centre_aside(height * sin_phi, state.roll);
    let force = (vehicle.roll_inertia * wanted - load * aside - moment_x - gyroscopic + steered)
        / (height * cos_phi);
    let front = force - response.tyre[1].force_y;
    let tyre = &p.tyres[0];
    let ratio = tyre.side_force_ratio;
    let k = tyre.stiffness.k_alpha(response.camber[0], ratio);
    let alpha = -(front / response.load[0].max(100.0) / k) - ratio * response.camber[0];
    handlebar(p, state, alpha, 0.0)
}

/// Handlebar angle that gives the wanted roll motion of whatever motorcycle answered last as `response` says: what
/// is missing in its roll acceleration is asked of the front tyre.
pub(crate) fn steer_as_felt(p: &Plant, state: &State, response: &Response, lean: &Lean) -> f64 {
    if state.vx < SLOWEST {
        return 0.0;
    }
    let cos_phi = state.roll.cos();
    let height = p.height_in_plane(cos_phi);
    let missing = p.vehicle.roll_inertia * (wanted(state, lean) - response.roll_acceleration);
    let tyre = &p.tyres[0];
    let k = tyre.stiffness.k_alpha(response.camber[0], tyre.side_force_ratio);
    let more = missing / (height * cos_phi) / response.load[0].max(100.0);
    // the side force turns a yielding front
    let turned = p.model_error.compliance(0.0) * response.tyre[0].force_y;
    handlebar(p, state, state.alpha[0] - more / k, turned)
}

/// Handlebar angle that brings the front tyre's slip angle to `alpha`, rad, where the front is `turned` back by
/// that much.
fn handlebar(p: &Plant, state: &State, alpha: f64, turned: f64) -> f64 {
    let vehicle = &p.vehicle;
    let (sin_phi, cos_phi) = state.roll.sin_cos();
    // ahead of the tyre's relaxation
    let alpha = (state.alpha[0] + 2.0 * (alpha - state.alpha[0])).clamp(-0.12, 0.12);
    let u = state.vx - state.yaw_rate * vehicle.cg_height * sin_phi;
    let w = state.vy
        + vehicle.cg_height * cos_phi * state.roll_rate
        + vehicle.cg_to_front * state.yaw_rate;
    let delta = w.atan2(u) - alpha + turned;
    // eq. 30 solved for the handlebar angle
    let tan_delta = delta.tan();
    let (sin_eps, cos_eps) = vehicle.caster_angle.sin_cos();
    (tan_delta * cos_phi / (cos_eps - tan_delta * sin_phi * sin_eps)).atan().clamp(-0.7, 0.7)
}
