//! The rider of the multibody motorcycle: demands to steering torque, throttle and brakes.

use super::conditions::Conditions;
use super::preview::{Preview, Target};
use super::programme::{Controls, Demand, Lean, Perceived, Programme};
use crate::simulate::multibody::trim::NoTrim;
use crate::simulate::multibody::{Action, Model, Scratch, State, joint};

/// Below this speed the feet help, fully at 2 m/s less.
const FEET: f64 = 3.0;

/// A rider on one motorcycle.
#[derive(Debug)]
pub(crate) struct Pilot<'a> {
    model: &'a Model,
    /// Programme to ride.
    pub programme: Programme<'a>,
    roll: Preview,
    path: Preview,
    pressure: [f64; 2],
    period: f64,
    /// Lean that the rider fails to hold at this decision, rad.
    pub sway: f64,
}

/// The steering skills of a rider; they take a while to work out and serve many rides.
#[derive(Debug, Clone)]
pub struct Skill {
    roll: Preview,
    path: Preview,
}

impl Skill {
    /// Learns to steer a motorcycle.
    ///
    /// # Errors
    /// It cannot run straight.
    pub fn learn(model: &Model, period: f64) -> Result<Self, NoTrim> {
        Ok(Skill {
            roll: Preview::new(model, Target::Roll, period)?,
            path: Preview::new(model, Target::Path, period)?,
        })
    }
}

impl<'a> Pilot<'a> {
    /// A rider about to start.
    pub(crate) fn new(model: &'a Model, programme: Programme<'a>, skill: &Skill) -> Self {
        let period = skill.roll.period;
        Pilot {
            model,
            programme,
            roll: skill.roll.clone(),
            path: skill.path.clone(),
            pressure: [0.0; 2],
            period,
            sway: 0.0,
        }
    }

    /// The state as the rider perceives it.
    pub(crate) fn perceive(&self, state: &State, scratch: &Scratch) -> Perceived {
        let centre = self.model.motorcycle.frame.centre;
        Perceived {
            speed: state.level_velocity(&centre)[0],
            yaw: state.angles[0],
            yaw_rate: state.angle_rates()[0],
            roll: state.angles[1],
            position: [state.position.x, state.position.y],
            load: scratch.wheels.map(|w| w.load),
            slip_ratio: scratch.wheels.map(|w| w.slip[0]),
            slip_angle: scratch.wheels.map(|w| w.slip[1]),
        }
    }

    /// One decision, held until the next.
    pub(crate) fn act(&mut self, state: &State, scratch: &Scratch) -> (Action, Controls, bool) {
        let seen = self.perceive(state, scratch);
        let demand = self.programme.decide(&seen);
        let Conditions { lost_grip, head_wind } = demand.conditions;
        // a head wind blows against the heading
        let wind = [-head_wind * seen.yaw.cos(), -head_wind * seen.yaw.sin()];
        let mut action = Action { lost_grip, wind, ..Action::default() };
        let mut controls = Controls { gear: demand.gear, ..Controls::default() };
        self.drive(&demand, &seen, scratch, &mut action, &mut controls);
        self.brake(&demand, &mut action);
        controls.pressure = self.pressure;
        let feet = ((FEET - seen.speed) / 2.0).clamp(0.0, 1.0);
        action.steer_torque = (1.0 - feet) * self.steer(&demand, state, &seen);
        if feet > 0.0 {
            // feet hold the bike up as its weight would tip it, and more
            let m = &self.model.motorcycle;
            let tip = m.mass() * m.gravity * m.centre().z;
            let (roll, rate) = (state.angles[1], state.angle_rates()[1]);
            action.support = -feet * tip * (3.0 * roll + 0.5 * rate);
            action.steer_torque -=
                feet * (40.0 * state.joints[joint::STEER] + 6.0 * state.rates[joint::STEER]);
        }
        (action, controls, demand.done)
    }

    fn steer(&self, demand: &Demand, state: &State, seen: &Perceived) -> f64 {
        let speed = seen.speed.max(FEET);
        let torque = match demand.path {
            Some(course) => {
                let (sin, cos) = seen.yaw.sin_cos();
                let here = course.along(seen.position);
                // along the course at the pace of the present speed
                let pace = speed * (seen.yaw - course.heading).cos();
                self.path.torque(state, speed, |i| {
                    let p = course.path(here + pace * self.period * i as f64);
                    let (dx, dy) = (p[0] - seen.position[0], p[1] - seen.position[1]);
                    dy * cos - dx * sin
                })
            }
            None => {
                let Lean { angle, rate, acceleration } = demand.lean;
                let angle = angle + self.sway;
                self.roll.torque(state, speed, |i| {
                    let ahead = self.period * i as f64;
                    match demand.swing {
                        Some((swing, since)) => swing.at(since + ahead).angle + self.sway,
                        // what is known of the lean to come; it will not swing beyond a third of a second
                        None => {
                            let t = ahead.min(0.3);
                            angle + rate * t + 0.5 * acceleration * t * t
                        }
                    }
                })
            }
        };
        torque.clamp(-150.0, 150.0)
    }

    /// Throttle, and the brakes where the demand is a deceleration with a share of the front brake.
    fn drive(
        &mut self,
        demand: &Demand,
        seen: &Perceived,
        scratch: &Scratch,
        action: &mut Action,
        controls: &mut Controls,
    ) {
        let Some(wanted) = demand.acceleration else { return };
        let m = &self.model.motorcycle;
        let radius = |i: usize| scratch.wheels[i].rolling_radius.max(0.2);
        let gear = (controls.gear as usize).clamp(1, 6);
        let ratio = m.ratios[gear - 1];
        action.engine_inertia = m.engine_inertia * ratio * ratio;
        let spinning: f64 =
            (0..2).map(|i| m.wheels[i].about_origin[(1, 1)] / radius(i).powi(2)).sum::<f64>()
                + action.engine_inertia / radius(1).powi(2);
        let tyres = m.tyres.as_ref();
        let rolling: f64 = (0..2)
            .map(|i| {
                let input = crate::tyre::paper::Input {
                    slip_ratio: 0.0,
                    slip_angle: 0.0,
                    camber: scratch.wheels[i].camber,
                    load: seen.load[i],
                    friction: 1.0,
                };
                tyres.map_or(0.0, |t| t[i].rolling_resistance(&input, seen.speed) / radius(i))
            })
            .sum();
        let force = (m.mass() + spinning) * wanted + scratch.air[0] * seen.speed.signum() + rolling;
        let most = m.engine_torque * ratio;
        match demand.front_share {
            Some(share) if force < 0.0 => {
                let shares = [share, 1.0 - share];
                for i in 0..2 {
                    self.pressure[i] = -force * shares[i] * radius(i) / m.brake_gain[i];
                }
            }
            _ => {
                // a little engine braking with the throttle shut
                let torque =
                    (force * radius(1)).clamp(-0.1 * m.mass() * m.gravity * radius(1), most);
                action.drive = torque;
                controls.throttle = (torque / most).clamp(0.0, 1.0);
                if demand.front_share.is_some() {
                    self.pressure = [0.0; 2];
                }
            }
        }
    }

    /// Pads bite within a tenth of a second and let go as fast.
    fn brake(&mut self, demand: &Demand, action: &mut Action) {
        for i in 0..2 {
            if demand.front_share.is_none() {
                let target = demand.pressure[i];
                let lag = if target > 0.0 { 0.02 } else { 0.06 };
                self.pressure[i] += (target - self.pressure[i]) * (self.period / lag).min(1.0);
                if target == 0.0 && self.pressure[i] < 2e3 {
                    self.pressure[i] = 0.0;
                }
            }
            action.brake[i] = self.model.motorcycle.brake_gain[i] * self.pressure[i];
        }
    }
}
