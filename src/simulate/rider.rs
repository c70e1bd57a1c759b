//! The rider: phases to handlebar, brakes and throttle.
//!
//! Steering inverts the roll balance: the lateral force that gives the wanted roll
//! acceleration, less what the rear tyre already gives, is asked of the front tyre by turning
//! its slip angle. Riders feel that force through the seat; the formula stands for the skill.

use super::motorcycle::{Action, Plant, Response, State};
use super::plan::Phase;
use super::random::{Coloured, Random};
use crate::GRAVITY;
use crate::segment::{Direction, Kind};

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
            lean: 0.0,
        }
    }
}

/// What the rider's hands and feet show to the loggers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Controls {
    /// Line pressures, Pa, front and rear.
    pub pressure: [f64; 2],
    /// 0 to 1.
    pub throttle: f64,
    /// 0 is neutral.
    pub gear: f64,
}

/// A lean over time: up, held, down; smooth to the second derivative.
#[derive(Debug, Clone, Copy, Default)]
struct Lean {
    angle: f64,
    rate: f64,
    acceleration: f64,
}

/// Quintic step from 0 to 1 over unit time, with its derivatives.
fn quintic(x: f64) -> (f64, f64, f64) {
    if x <= 0.0 {
        (0.0, 0.0, 0.0)
    } else if x >= 1.0 {
        (1.0, 0.0, 0.0)
    } else {
        (
            x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
            30.0 * x * x * (1.0 - x) * (1.0 - x),
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
    }
}

/// The rider on one session.
#[derive(Debug)]
pub struct Rider<'a> {
    plant: &'a Plant,
    phases: &'a [Phase],
    next: usize,
    since: f64,
    heading: f64,
    start_yaw: f64,
    lean_out: Option<f64>,
    demand: f64,
    pressure: [f64; 2],
    gain: [f64; 2],
    grade: f64,
    disturbance: Disturbance,
    noise: [Coloured; 4],
    random: Random,
    dt: f64,
}

impl<'a> Rider<'a> {
    /// A rider about to start; `dt` is the span between decisions.
    pub fn new(
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
            phases,
            next: 0,
            since: 0.0,
            heading: 0.0,
            start_yaw: 0.0,
            lean_out: None,
            demand: 0.0,
            pressure: [0.0; 2],
            gain: plant.brake_gain,
            grade,
            disturbance,
            noise,
            random,
            dt,
        }
    }

    /// The phase under way; `None` at the end of the ride.
    pub fn phase(&self) -> Option<&Phase> {
        self.phases.get(self.next)
    }

    /// What the phase under way is called, and which way it goes.
    pub fn label(&self, lean: f64) -> (Kind, Option<Direction>) {
        match self.phase() {
            Some(Phase::Accelerate { .. } | Phase::Cruise { .. }) => (Kind::Driving, None),
            Some(Phase::Coast { .. }) => (Kind::Coasting, None),
            Some(Phase::Brake { ramp, .. }) => {
                let kind = match (ramp[0] > 0.0, ramp[1] > 0.0) {
                    (true, false) => Kind::FrontBraking,
                    (false, true) => Kind::RearBraking,
                    _ => Kind::CombinedBraking,
                };
                (kind, None)
            }
            // the first and last degrees of lean are nobody's corner
            Some(Phase::Corner { direction, .. }) if lean.abs() > 0.07 => {
                (Kind::Cornering, Some(*direction))
            }
            _ => (Kind::Other, None),
        }
    }

    fn finish(&mut self, state: &State) {
        if let Some(Phase::Corner { direction, turn, .. }) = self.phase().copied() {
            let sign = if direction == Direction::Left { 1.0 } else { -1.0 };
            self.heading = self.start_yaw + sign * turn;
        }
        self.next += 1;
        self.since = 0.0;
        self.start_yaw = state.yaw;
        self.lean_out = None;
        self.demand = 0.0;
        self.grade = self.disturbance.grade * self.random.normal();
        for i in 0..2 {
            let scatter = 1.0 + self.disturbance.brake_gain * self.random.normal();
            self.gain[i] = self.plant.brake_gain[i] * scatter;
        }
    }

    /// One decision: what is done for the next `dt` seconds. `response` is the instant's.
    pub fn act(&mut self, state: &State, response: &Response) -> (Action, Controls) {
        let mut controls = Controls { gear: 1.0, ..Controls::default() };
        let mut acceleration = None;
        let mut lean = self.straight(state);
        let mut target = [0.0_f64; 2];
        let mut done = false;
        let t = self.since;
        match self.phase().copied() {
            None => {}
            Some(Phase::Stand { duration }) => {
                controls.gear = 0.0;
                target = [3e5; 2];
                done = t >= duration;
            }
            Some(Phase::Accelerate { to, ramp, peak }) => {
                self.demand = (self.demand + ramp * self.dt).min(peak);
                // ease off near the wheelie
                let limit = if response.load[0] < 150.0 { 0.7 } else { 1.0 };
                acceleration = Some(self.demand * limit);
                done = state.vx >= to;
            }
            Some(Phase::Cruise { speed, duration }) => {
                acceleration = Some((1.2 * (speed - state.vx)).clamp(-1.8, 2.5));
                done = t >= duration && (state.vx - speed).abs() < 0.6;
            }
            Some(Phase::Coast { duration, until }) => {
                controls.gear = 0.0;
                done = t >= duration || state.vx <= until;
            }
            Some(Phase::Brake { ramp, peak, until, slip }) => {
                controls.gear = 0.0;
                target = std::array::from_fn(|i| (ramp[i] * (t + self.dt)).min(peak[i]));
                let slipping = (0..2).any(|i| response.slip_ratio[i] < slip);
                let lifting = response.load[1] < 40.0;
                done = state.vx <= until || slipping || lifting;
            }
            Some(Phase::Corner { direction, lean: angle, ramp, turn, speed }) => {
                let sign = if direction == Direction::Left { -1.0 } else { 1.0 };
                match speed {
                    Some(speed) => {
                        acceleration = Some((0.8 * (speed - state.vx)).clamp(-1.0, 1.5));
                    }
                    None => controls.gear = 0.0,
                }
                let turned = (state.yaw - self.start_yaw).abs();
                // leaning out turns about as far as the same lean held for 45 % of the time
                let reserve = state.yaw_rate.abs() * ramp * 0.45;
                if self.lean_out.is_none() && t >= ramp && turned + reserve >= turn {
                    self.lean_out = Some(t);
                }
                let (up, up_rate, up_acceleration) = quintic(t / ramp);
                let out = self.lean_out.map_or(0.0, |from| (t - from) / ramp);
                let (down, down_rate, down_acceleration) = quintic(out);
                lean = Lean {
                    angle: sign * angle * (up - down),
                    rate: sign * angle * (up_rate - down_rate) / ramp,
                    acceleration: sign * angle * (up_acceleration - down_acceleration)
                        / (ramp * ramp),
                };
                done = out >= 1.0 || t > 40.0;
            }
        }
        self.since += self.dt;
        if done {
            self.finish(state);
        }
        let mut action = Action::default();
        // pads bite within a tenth of a second and let go as fast
        for i in 0..2 {
            let rate = if target[i] > 0.0 { 0.02 } else { 0.06 };
            self.pressure[i] += (target[i] - self.pressure[i]) * (self.dt / rate).min(1.0);
            if target[i] == 0.0 && self.pressure[i] < 2e3 {
                self.pressure[i] = 0.0;
            }
            action.brake[i] = self.gain[i] * self.pressure[i];
        }
        if let Some(wanted) = acceleration {
            let p = self.plant;
            let resist =
                p.drag * state.vx * state.vx + p.tyres[1].rolling_resistance * p.mass * GRAVITY;
            let rotating: f64 =
                (0..2).map(|i| p.wheel_inertia[i] / p.tyres[i].rolling_radius.powi(2)).sum();
            let force = (p.mass + rotating) * wanted + resist;
            // a little engine braking with the throttle shut
            action.drive = force.max(-0.1 * p.mass * GRAVITY) * p.tyres[1].rolling_radius;
            controls.throttle = (force / (p.mass * 8.0)).clamp(0.0, 1.0);
        }
        let jitter = self.noise[3].next(&mut self.random);
        lean.angle += jitter;
        action.steer = self.steer(state, response, &lean);
        let running = (state.vx / 2.0).clamp(0.0, 1.0);
        action.force_x = running
            * (self.noise[0].next(&mut self.random) - self.plant.mass * GRAVITY * self.grade);
        action.force_y = running * self.noise[1].next(&mut self.random);
        action.moment_z = running * self.noise[2].next(&mut self.random);
        controls.pressure = self.pressure;
        (action, controls)
    }

    /// Keeps the heading with a degree or two of lean.
    fn straight(&self, state: &State) -> Lean {
        let error = state.yaw - self.heading;
        Lean { angle: (0.25 * error).clamp(-0.035, 0.035), ..Lean::default() }
    }

    /// Handlebar angle that gives the wanted roll motion.
    fn steer(&self, state: &State, response: &Response, lean: &Lean) -> f64 {
        const BANDWIDTH: f64 = 4.0; // rad/s
        const DAMPING: f64 = 0.9;
        if state.vx < 2.5 {
            return 0.0;
        }
        let p = self.plant;
        let (sin_phi, cos_phi) = state.roll.sin_cos();
        let wanted = lean.acceleration
            + 2.0 * DAMPING * BANDWIDTH * (lean.rate - state.roll_rate)
            + BANDWIDTH * BANDWIDTH * (lean.angle - state.roll);
        let load = response.load[0] + response.load[1];
        let moment_x = response.tyre[0].moment_x + response.tyre[1].moment_x;
        let spin: f64 = (0..2).map(|i| p.wheel_inertia[i] * state.omega[i]).sum();
        let gyroscopic = spin * state.yaw_rate * cos_phi;
        let force =
            (p.roll_inertia * wanted - load * p.cg_height * sin_phi - moment_x - gyroscopic)
                / (p.cg_height * cos_phi);
        let front = force - response.tyre[1].force_y;
        let tyre = &p.tyres[0];
        let ratio = tyre.side_force_ratio;
        let k = tyre.stiffness.k_alpha(response.camber[0], ratio);
        let alpha = -(front / response.load[0].max(100.0) / k) - ratio * response.camber[0];
        // ahead of the tyre's relaxation
        let alpha = (state.alpha[0] + 2.0 * (alpha - state.alpha[0])).clamp(-0.12, 0.12);
        let u = state.vx - state.yaw_rate * p.cg_height * sin_phi;
        let w = state.vy + p.cg_height * cos_phi * state.roll_rate + p.cg_to_front * state.yaw_rate;
        let delta = w.atan2(u) - alpha;
        // eq. 30 solved for the handlebar angle
        let tan_delta = delta.tan();
        let (sin_eps, cos_eps) = p.caster_angle.sin_cos();
        (tan_delta * cos_phi / (cos_eps - tan_delta * sin_phi * sin_eps)).atan().clamp(-0.7, 0.7)
    }
}
