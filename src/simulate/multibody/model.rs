//! The motorcycle's equations of motion: forces on the tree of bodies, accelerations from it.
//!
//! ```text
//! frame (6 degrees of freedom)
//! +- swing arm - rear wheel
//! +- steering head (twist) - handlebar and upper fork (steer) - lower fork (travel) - front wheel
//! +- rider's upper body (lean, follows its command)
//! ```
//!
//! What a machine does not have (suspension, twist, a leaning rider) is a locked joint.

use nalgebra::{Unit, Vector3};

use super::contact::{self, Surroundings};
use super::description::{Contact, Motorcycle};
use super::link;
use super::road::Road;
use super::state::{Action, State, Wheel, angle_rates, joint};
use crate::simulate::effects::ModelError;
use crate::simulate::multibody::bodies::spatial::times;
use crate::simulate::multibody::bodies::{Body, Joint, Motion, Rigid, Tree, Work};

/// Natural frequency and damping ratio with which the rider's body follows its command.
const LEAN: (f64, f64) = (10.0, 1.0);
/// A locked wheel's remaining spin dies with this rate, 1/s.
const LOCK_RATE: f64 = 200.0;

/// A motorcycle on a road, ready to be simulated.
#[derive(Debug, Clone)]
pub struct Model {
    /// Description of the motorcycle.
    pub motorcycle: Motorcycle,
    pub road: Road,
    pub tree: Tree,
    /// Effects beyond all that and is not in its description or its tyres.
    pub model_error: ModelError,
    locked: [bool; joint::COUNT],
}

/// Scratch memory, and what the last evaluation found.
#[derive(Debug, Clone)]
pub struct Scratch {
    pub work: Work,
    /// Both wheels, front first.
    pub wheels: [Wheel; 2],
    /// Wheels that the brake holds.
    pub held: [bool; 2],
    /// Drag, lift and pitch moment.
    pub air: [f64; 3],
    /// Gravity where the motorcycle is, world axes, with [`pull`](Scratch::pull).
    pub gravity: Vector3<f64>,
    /// The part of it that an inertial unit knows of: slope and bank of a
    /// [`ModelError`], world axes, m/s².
    pub pull: Vector3<f64>,
}

impl Model {
    /// A motorcycle on a road.
    pub fn new(motorcycle: Motorcycle, road: Road) -> Self {
        let m = &motorcycle;
        let relative = |r: &Rigid, origin: &Vector3<f64>| {
            // about another origin: through the centre of mass and back
            let skew = crate::simulate::multibody::bodies::spatial::skew;
            let c = skew(&r.centre);
            let own = r.about_origin + c * c * r.mass;
            Rigid::new(r.mass, r.centre - origin, own)
        };
        let (sin, cos) = m.caster_angle.sin_cos();
        let steer_axis = Unit::new_normalize(Vector3::new(-sin, 0.0, cos));
        let twist_axis = Unit::new_normalize(Vector3::new(cos, 0.0, sin));
        let twist = m.twist.map_or(m.steering_axis, |(point, _, _)| point);
        let massless = Rigid::new(0.0, Vector3::zeros(), nalgebra::Matrix3::zeros());
        let lean_axis = Vector3::new(0.0, 0.0, m.rider.as_ref().map_or(0.0, |r| r.1));
        let body = |parent: usize, joint: Joint, offset: Vector3<f64>, inertia: Rigid| Body {
            parent,
            joint,
            offset,
            inertia,
        };
        let y = Joint::Revolute(Vector3::y_axis());
        let bodies = vec![
            body(link::FRAME, y, m.pivot, relative(&m.swing_arm, &m.pivot)),
            body(link::SWING, y, m.centres[1] - m.pivot, m.wheels[1]),
            body(link::FRAME, Joint::Revolute(twist_axis), twist, massless),
            body(
                3,
                Joint::Revolute(steer_axis),
                m.steering_axis - twist,
                relative(&m.steering, &m.steering_axis),
            ),
            body(
                link::STEER,
                Joint::Prismatic(steer_axis),
                Vector3::zeros(),
                relative(&m.fork, &m.steering_axis),
            ),
            body(link::FORK, y, m.centres[0] - m.steering_axis, m.wheels[0]),
            body(
                link::FRAME,
                Joint::Revolute(Vector3::x_axis()),
                lean_axis,
                m.rider.as_ref().map_or(massless, |(r, _)| relative(r, &lean_axis)),
            ),
        ];
        let mut locked = [false; joint::COUNT];
        locked[joint::SWING] = m.rear_suspension.is_none();
        locked[joint::FORK] = m.front_suspension.is_none();
        locked[joint::TWIST] = m.twist.is_none();
        let tree = Tree { base: m.frame, bodies };
        Model { motorcycle, road, tree, model_error: ModelError::default(), locked }
    }

    /// The same with a model error beyond what its description and its tyres have of it.
    #[must_use]
    pub fn with(mut self, error: &ModelError) -> Self {
        self.model_error = *error;
        self
    }

    /// Scratch memory for it.
    pub fn scratch(&self) -> Scratch {
        Scratch {
            work: self.tree.work(),
            wheels: [Wheel::default(); 2],
            held: [false; 2],
            air: [0.0; 3],
            gravity: Vector3::new(0.0, 0.0, -self.motorcycle.gravity),
            pull: Vector3::zeros(),
        }
    }

    /// Joints that cannot move on this machine.
    pub fn locked(&self, joint: usize) -> bool {
        self.locked[joint]
    }

    /// Upright at rest at a forward speed, wheels rolling, tyres carrying the static load.
    pub fn straight(&self, speed: f64) -> State {
        let m = &self.motorcycle;
        let mut state = State::default();
        state.velocity.linear.x = speed;
        let loads = m.static_loads();
        let mut sink = [0.0; 2];
        for i in 0..2 {
            let radius = match &m.tyres {
                Some(tyres) => {
                    let carcass = tyres[i].carcass();
                    let deflection = loads[i] / carcass.stiffness;
                    sink[i] = carcass.radius - deflection - m.centres[i].z;
                    carcass.rolling_radius(loads[i], 0.0)
                }
                None => m.centres[i].z,
            };
            state.rates[link::WHEEL_JOINTS[i]] = speed / radius;
        }
        state.angles[2] = (sink[1] - sink[0]) / m.wheelbase();
        state.position.z = sink[1];
        state
    }

    /// Positions and velocities of all bodies.
    pub fn kinematics(&self, state: &State, scratch: &mut Scratch) {
        // wheels are round: their angle changes nothing
        let mut joints = state.joints;
        (joints[joint::FRONT], joints[joint::REAR]) = (0.0, 0.0);
        self.tree.kinematics(
            &state.rotation(),
            &state.position,
            &state.velocity,
            &joints,
            &state.rates,
            &mut scratch.work,
        );
    }

    /// Rates of the state; `scratch` holds loads, slips and forces afterwards.
    ///
    /// A state that is not finite gives rates that are not: the caller looks at its result.
    pub fn rates(&self, state: &State, action: &Action, scratch: &mut Scratch) -> State {
        self.kinematics(state, scratch);
        self.prepare(state, action, scratch);
        let mut lag = [[0.0; 3]; 2];
        let around = Surroundings {
            road: &self.road,
            error: &self.model_error,
            lost_grip: action.lost_grip,
            time: action.time,
            along: self.along(state),
        };
        if let (Some(tyres), Contact::Tyre) = (&self.motorcycle.tyres, self.motorcycle.contact) {
            for i in 0..2 {
                let (wheel, rates) = contact::roll(
                    tyres[i].as_ref(),
                    &mut scratch.work.links,
                    i,
                    state.rates[link::WHEEL_JOINTS[i]],
                    &state.lag[i],
                    &around,
                );
                scratch.wheels[i] = wheel;
                lag[i] = rates;
            }
        }
        self.solve(state, lag, scratch)
    }

    /// Cosine of the heading; zero where no effect depends on it.
    fn along(&self, state: &State) -> f64 {
        if self.model_error.needs_heading() { state.angles[0].cos() } else { 0.0 }
    }

    /// Acceleration of the motorcycle by the effects: slope and bank, world axes, m/s².
    fn pull(&self, state: &State) -> Vector3<f64> {
        let g = self.motorcycle.gravity;
        let ahead = -self.model_error.uphill(0.0, g, self.along(state));
        let left = g * self.model_error.weight_across(0.0);
        let (sin, cos) = state.angles[0].sin_cos();
        Vector3::new(ahead * cos - left * sin, ahead * sin + left * cos, 0.0)
    }

    /// Moments of the effects on the frame: of a centre of mass beside the plane of symmetry, and of more
    /// spin than the wheels'. The spin's own rate is left out.
    fn twist(&self, state: &State, work: &mut Work) {
        let m = &self.motorcycle;
        let aside = self.model_error.mass_centre_aside(0.0, state.angles[1]);
        let spin = self.model_error.spin(0.0);
        if aside == 0.0 && spin == 0.0 {
            return;
        }
        let wheels: f64 = (0..2)
            .map(|i| m.wheels[i].about_origin[(1, 1)] * state.rates[link::WHEEL_JOINTS[i]])
            .sum();
        let (sin, cos) = state.angles[0].sin_cos();
        let frame = &mut work.links[link::FRAME];
        let momentum = frame.rotation.column(1) * (spin * wheels);
        let gravity = Vector3::new(cos, sin, 0.0) * (m.mass() * m.gravity * aside);
        frame.twist(&(gravity - frame.spin().cross(&momentum)));
    }

    /// Everything that acts but the road: suspension, brakes, drive, air, rider.
    pub(super) fn prepare(&self, state: &State, action: &Action, scratch: &mut Scratch) {
        let m = &self.motorcycle;
        let Scratch { work, held, air, gravity, pull, .. } = scratch;
        *pull = self.pull(state);
        *gravity = self.road.gravity_at(state.position.x, m.gravity) + *pull;
        let (q, qd) = (&state.joints, &state.rates);
        for j in 0..joint::COUNT {
            work.driven[j] = self.locked[j];
            work.acceleration[j] = 0.0;
            work.torque[j] = 0.0;
            work.armature[j] = 0.0;
        }
        if let Some(s) = &m.rear_suspension {
            work.torque[joint::SWING] = -s.force(q[joint::SWING], qd[joint::SWING]);
        }
        if let Some(s) = &m.front_suspension {
            work.torque[joint::FORK] = -s.force(q[joint::FORK], qd[joint::FORK]);
        }
        if let Some((_, stiffness, damping)) = m.twist {
            work.torque[joint::TWIST] = -stiffness * q[joint::TWIST] - damping * qd[joint::TWIST];
        }
        work.torque[joint::STEER] = action.steer_torque - m.steering_damping * qd[joint::STEER];
        work.driven[joint::RIDER] = true;
        let (frequency, ratio) = LEAN;
        work.acceleration[joint::RIDER] = frequency
            * (frequency * (action.lean - q[joint::RIDER]) - 2.0 * ratio * qd[joint::RIDER]);
        for i in 0..2 {
            let j = link::WHEEL_JOINTS[i];
            if held[i] {
                work.driven[j] = true;
                work.acceleration[j] = -LOCK_RATE * qd[j];
            } else {
                work.torque[j] -= action.brake[i] * qd[j].signum();
            }
        }
        work.armature[joint::REAR] = action.engine_inertia;
        self.drive(action.drive, work);
        *air = self.air(action, work);
        self.twist(state, work);
        if action.support != 0.0 {
            let frame = &mut work.links[link::FRAME];
            let x = frame.rotation.column(0) * action.support;
            frame.twist(&x.into_owned());
        }
    }

    /// Drive torque on the rear wheel: through the chain, or as a shaft in the swing arm.
    fn drive(&self, torque: f64, work: &mut Work) {
        let Some(chain) = &self.motorcycle.chain else {
            work.torque[joint::REAR] += torque;
            return;
        };
        if torque == 0.0 {
            return;
        }
        let (frame, wheel) = (&work.links[link::FRAME], &work.links[link::REAR]);
        let engine = frame.position + times(&frame.rotation, &chain.engine);
        let y = frame.rotation.column(1).into_owned();
        let between = engine - wheel.position;
        let length = between.norm();
        let along = between / length;
        // downwards: the run that pulls in drive lies above
        let normal = y.cross(&along);
        // the run that pulls: the upper one in drive, the lower one in engine braking
        let side = torque.signum();
        let lean = ((chain.wheel_radius - chain.engine_radius) / length).clamp(-0.9, 0.9).asin();
        // the tangent line falls from the larger to the smaller sprocket
        let (sin, cos) = lean.sin_cos();
        let out = -normal * (side * cos) + along * sin;
        let pull = along * cos + normal * (side * sin);
        let tension = torque.abs() / chain.wheel_radius;
        let at_wheel = wheel.position + out * chain.wheel_radius;
        let at_engine = engine + out * chain.engine_radius;
        work.links[link::REAR].push(&(pull * tension), &at_wheel);
        work.links[link::FRAME].push(&(-pull * tension), &at_engine);
    }

    /// Drag, lift and pitch moment at the aerodynamic centre.
    fn air(&self, action: &Action, work: &mut Work) -> [f64; 3] {
        let m = &self.motorcycle;
        let [drag, lift, pitch] = m.aerodynamics;
        let frame = &mut work.links[link::FRAME];
        let at = frame.position + times(&frame.rotation, &m.aerodynamic_centre);
        let wind = Vector3::new(action.wind[0], action.wind[1], 0.0);
        let v = frame.velocity_at(&at) - wind;
        let speed = v.norm();
        let half = 0.5 * m.air_density * speed;
        let up = frame.rotation.column(2).into_owned();
        let force = v * (-half * drag) + up * (half * speed * lift);
        let ahead = frame.rotation.column(0);
        let (cos, sin) = (ahead.x / ahead.x.hypot(ahead.y), ahead.y / ahead.x.hypot(ahead.y));
        let [along, left] = action.gust;
        let gust = Vector3::new(along * cos - left * sin, along * sin + left * cos, 0.0);
        frame.push(&(force + gust), &at);
        let nose_up = frame.rotation.column(1) * (-half * speed * pitch);
        frame.twist(&nose_up.into_owned());
        [half * speed * drag, half * speed * lift, half * speed * pitch]
    }

    /// Accelerations from all that has been set, as rates of the state.
    pub(super) fn solve(&self, state: &State, lag: [[f64; 3]; 2], scratch: &mut Scratch) -> State {
        let gravity = scratch.gravity;
        let work = &mut scratch.work;
        let nowhere = Vector3::repeat(f64::NAN);
        let base = self.tree.dynamics(&gravity, work).unwrap_or(Motion::new(nowhere, nowhere));
        State {
            position: times(&work.links[0].rotation, &state.velocity.linear),
            angles: angle_rates(&state.angles, &state.velocity.angular),
            joints: state.rates,
            velocity: base,
            rates: std::array::from_fn(|j| work.acceleration[j]),
            lag,
        }
    }

    /// Decides which wheels the brakes hold from here on: a wheel that the brake would bring to
    /// rest within `dt` is held until the road pulls harder than the brake.
    pub fn decide_held(&self, state: &State, action: &Action, dt: f64, scratch: &mut Scratch) {
        for i in 0..2 {
            let j = link::WHEEL_JOINTS[i];
            let within = action.brake[i] * dt / self.motorcycle.wheels[i].about_origin[(1, 1)];
            if action.brake[i] <= 0.0 || (!scratch.held[i] && state.rates[j].abs() > within) {
                scratch.held[i] = false;
                continue;
            }
            scratch.held[i] = true;
            self.rates(state, action, scratch);
            scratch.held[i] = scratch.work.torque[j].abs() <= action.brake[i];
        }
    }

    /// Energy of motion, height and springs, J; what dissipation and drive change, and no more.
    pub fn energy(&self, state: &State, scratch: &mut Scratch) -> f64 {
        self.kinematics(state, scratch);
        let m = &self.motorcycle;
        let gravity = self.road.gravity_at(state.position.x, m.gravity);
        let height = self.tree.centre(&scratch.work);
        let spring = |s: &Option<super::description::Suspension>, q: f64| {
            s.as_ref().map_or(0.0, |s| q * (s.preload + 0.5 * s.stiffness * q))
        };
        self.tree.kinetic(&scratch.work) - self.tree.mass() * gravity.dot(&height)
            + spring(&m.rear_suspension, state.joints[joint::SWING])
            + spring(&m.front_suspension, state.joints[joint::FORK])
            + m.twist.map_or(0.0, |(_, k, _)| 0.5 * k * state.joints[joint::TWIST].powi(2))
    }
}
