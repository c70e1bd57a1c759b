//! The rider of the track: along the line by lean, as fast as the profile by throttle and brakes.

use super::circuit::{Circuit, Limits, profile};
use super::drivetrain::Drivetrain;
use crate::GRAVITY;
use crate::simulate::multibody::{Action, Model, Scratch, State, joint};
use crate::simulate::preview::Preview;
use crate::statistics::angles::wrapped;
use crate::statistics::random::Random;

/// How fast the line is come back to, m/s: the faster, the slower. With more the steering's own transient, by which
/// the frame first turns the wrong way, is chased until it throws the rider (seen from 15 m/s on).
const RETURN: f64 = 5.0;
/// Not faster than this, rad/s.
const QUICKEST: f64 = 0.25;
/// How fast the rider makes up for a lean that does not come, 1/s.
const TRIM: f64 = 0.4;
/// Lag of the hands on throttle and brakes, s.
const HANDS: f64 = 0.09;
/// From the shut throttle to the brake, s.
const REACH: f64 = 0.25;
/// How far ahead of the profile the hands act, s.
const AHEAD: f64 = 0.2;
/// Lean over that of a wheel without width: what round tyres and spinning wheels add.
const FATTER: f64 = 1.10;

/// Pace of a rider.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pace {
    /// Lateral acceleration in corners, m/s².
    pub lateral: f64,
    /// Deceleration, m/s².
    pub brake: f64,
    /// Acceleration, m/s².
    pub drive: f64,
    /// Fastest, m/s.
    pub fastest: f64,
}

/// Approach of the rider to a corner of one lap.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Approach {
    /// Share of the pace's deceleration.
    brake: f64,
    /// Whether the throttle is shut and the brakes are left alone.
    rolled: bool,
    /// Share of the pace's lateral acceleration.
    lateral: f64,
    /// Share of the pace's acceleration.
    drive: f64,
    /// Pressure of the rear brake while the front one is on, Pa.
    dab: f64,
}

/// Levers, gear and engine at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Hands {
    /// Line pressures, Pa.
    pub pressure: [f64; 2],
    /// Throttle, 0 to 1.
    pub throttle: f64,
    /// Gear, 1 to 6.
    pub gear: usize,
    /// Revolutions, rev/min.
    pub revolutions: f64,
    /// Whether the gear is being changed: neither drive nor drag.
    pub shifting: bool,
    /// Along the line since the start line was first crossed, m.
    pub along: f64,
    /// To the left of it, m.
    pub left: f64,
}

/// A rider on the track.
#[derive(Debug)]
pub(crate) struct Rider<'a> {
    model: &'a Model,
    circuit: &'a Circuit,
    drivetrain: Drivetrain,
    steering: Preview,
    speeds: Vec<f64>,
    approaches: Vec<Approach>,
    /// Levers and engine.
    pub hands: Hands,
    wanted: f64,
    braking: bool,
    shut: f64,
    least: f64,
    shift_left: f64,
    since_shift: f64,
    lean_error: f64,
    traction: f64,
    lift: f64,
    period: f64,
    /// Lean that the rider fails to hold, rad.
    pub sway: f64,
}

impl<'a> Rider<'a> {
    /// A rider on the start line for some laps; every corner of every lap is ridden a little differently.
    pub(crate) fn new(
        model: &'a Model,
        circuit: &'a Circuit,
        drivetrain: Drivetrain,
        steering: Preview,
        (pace, laps, start): (Pace, usize, f64),
        random: &mut Random,
    ) -> Self {
        let approaches = approaches(circuit.corners(), laps, random);
        let m = &model.motorcycle;
        // the last lap is followed by half a straight, so that it is ridden to its end
        let count = laps * circuit.len() + 150;
        let of = |i: usize| {
            let (lap, k) = (i / circuit.len(), i % circuit.len());
            // beyond the last corner of a lap comes the first of the next
            let next = circuit.next_corner[k];
            let wrapped_round = next == 0 && k > circuit.len() / 2;
            approaches[((lap + usize::from(wrapped_round)) * circuit.corners() + next)
                .min(approaches.len() - 1)]
        };
        let limits = Limits {
            lateral: (0..count).map(|i| pace.lateral * of(i).lateral).collect(),
            brake: (0..count).map(|i| pace.brake * of(i).brake).collect(),
            rolled: (0..count).map(|i| of(i).rolled).collect(),
            drive: (0..count).map(|i| pace.drive * of(i).drive).collect(),
            reserve: 1.12,
            fastest: pace.fastest,
        };
        let radius = m.tyres.as_ref().map_or(0.3, |t| t[1].carcass().radius);
        let mass = m.mass();
        let drag = 0.5 * m.air_density * m.aerodynamics[0];
        let engine = |v: f64| {
            let spin = v / radius;
            let gear = drivetrain.usual_gear(spin);
            0.9 * drivetrain.wheel_torque(gear, spin, 1.0) / radius / mass - drag * v * v / mass
        };
        let closed = |v: f64| {
            let spin = v / radius;
            let gear = drivetrain.usual_gear(spin);
            drag * v * v / mass - drivetrain.wheel_torque(gear, spin, 0.0) / radius / mass
        };
        let speeds = profile(circuit, &limits, start, engine, closed);
        let gear = drivetrain.usual_gear(start / radius);
        Rider {
            model,
            circuit,
            drivetrain,
            period: steering.period,
            steering,
            speeds,
            approaches,
            hands: Hands { gear, ..Hands::default() },
            wanted: 0.0,
            braking: false,
            shut: 0.0,
            least: -1.05 * pace.brake,
            shift_left: 0.0,
            since_shift: 10.0,
            lean_error: 0.0,
            traction: 1.0,
            lift: 1.0,
            sway: 0.0,
        }
    }

    /// The lap under way, counted from 0.
    pub(crate) fn lap(&self) -> usize {
        (self.hands.along / self.circuit.length).max(0.0) as usize
    }

    fn speed_at(&self, along: f64) -> f64 {
        let place = (along / self.circuit.spacing).clamp(0.0, (self.speeds.len() - 2) as f64);
        let (i, part) = (place as usize, place.fract());
        self.speeds[i] + part * (self.speeds[i + 1] - self.speeds[i])
    }

    /// One decision, held until the next.
    pub(crate) fn act(&mut self, state: &State, scratch: &Scratch) -> Action {
        let speed = state.level_velocity(&self.model.motorcycle.frame.centre)[0];
        let position = [state.position.x, state.position.y];
        (self.hands.along, self.hands.left) = self.circuit.place(position, self.hands.along);
        let mut action = Action { steer_torque: self.steer(state, speed), ..Action::default() };
        self.accelerate(speed, state, scratch, &mut action);
        action
    }

    /// Lean in the corner that comes at a distance along the line.
    fn lean_at(&self, along: f64, speed: f64) -> f64 {
        let lateral = self.circuit.value(&self.circuit.curvature, along) * speed * speed;
        -FATTER * (lateral / GRAVITY).atan()
    }

    fn steer(&mut self, state: &State, speed: f64) -> f64 {
        let Hands { along, left, .. } = self.hands;
        let roll = state.angles[1];
        let astray = wrapped(state.angles[0] - self.circuit.heading_at(along));
        let haste = (RETURN / speed.max(1.0)).min(QUICKEST);
        let back = haste * haste * left + 1.8 * haste * speed * astray.sin();
        // to the left of the line it is leant to the right
        let more = (back / GRAVITY * roll.cos().powi(2)).clamp(-0.2, 0.2);
        let here = self.lean_at(along, speed) + more;
        self.lean_error = (self.lean_error + TRIM * (here - roll) * self.period).clamp(-0.3, 0.3);
        let offset = more + self.lean_error + self.sway;
        let (mut ahead, mut v, mut last) = (along, speed, (0, 0.0));
        let leans: Vec<f64> = (0..self.steering.horizon())
            .map(|i| {
                ahead += v * self.period;
                // the wanted speed, come to within half a second
                let share = (self.period * i as f64 / 0.5).min(1.0);
                if i % 5 == 0 {
                    v = speed + share * (self.speed_at(ahead) - speed);
                    last = (i, self.lean_at(ahead, v));
                }
                last.1 + offset
            })
            .collect();
        self.steering.torque(state, speed.max(6.0), |i| leans[i - 1]).clamp(-200.0, 200.0)
    }

    /// Throttle, gear and brakes.
    fn accelerate(&mut self, speed: f64, state: &State, scratch: &Scratch, action: &mut Action) {
        let m = &self.model.motorcycle;
        let along = self.hands.along;
        let ahead = along + AHEAD * speed;
        let slope = (self.speed_at(ahead + 1.0) - self.speed_at(ahead - 1.0)) / 2.0;
        let aim = slope * speed + 2.0 * (self.speed_at(along) - speed);
        let aim = aim.max(self.least);
        self.wanted += (aim - self.wanted) * (self.period / HANDS).min(1.0);
        let [front, rear] = scratch.wheels;
        let radius = [front, rear].map(|w| w.rolling_radius.max(0.2));
        let spin = state.rates[joint::REAR];
        let lean = state.angles[1].abs();
        // gears: not while leant over far
        self.since_shift += self.period;
        self.shift_left -= self.period;
        if self.since_shift > 0.35 && lean < 0.6 {
            let driving = self.hands.throttle > 0.3;
            if let Some(gear) = self.drivetrain.change(self.hands.gear, spin, driving) {
                self.hands.gear = gear;
                self.shift_left = self.drivetrain.shift_time;
                self.since_shift = 0.0;
            }
        }
        self.hands.shifting = self.shift_left > 0.0;
        let gear = self.hands.gear;
        let ratio = self.drivetrain.ratios[gear - 1];
        action.engine_inertia = self.drivetrain.inertia * ratio * ratio;
        let spinning =
            (0..2).map(|i| m.wheels[i].about_origin[(1, 1)] / radius[i].powi(2)).sum::<f64>()
                + action.engine_inertia / radius[1].powi(2);
        let grade = self.circuit.value(&self.circuit.grade, along);
        let force = (m.mass() + spinning) * self.wanted
            + scratch.air[0]
            + 0.015 * m.mass() * GRAVITY
            + m.mass() * GRAVITY * grade;
        let closed = self.drivetrain.wheel_torque(gear, spin, 0.0) / radius[1];
        // electronics as such machines have: traction and wheelie control, engine brake control
        let ease = |x: f64, from: f64, to: f64| ((to - x) / (to - from)).clamp(0.0, 1.0);
        let slipping = ease(rear.slip[0], 0.07, 0.16).min(ease(-front.load, -350.0, -60.0));
        self.traction += (slipping - self.traction) * (self.period / 0.03).min(1.0);
        let hopping = ease(-rear.slip[0], 0.05, 0.12).min(ease(-rear.load, -250.0, -60.0));
        let throttle = if self.braking {
            0.0
        } else {
            self.drivetrain.throttle(gear, spin, force * radius[1])
        };
        let rate = (self.period / 0.05).min(1.0);
        self.hands.throttle += (throttle - self.hands.throttle) * rate;
        if self.hands.throttle < 0.004 {
            self.hands.throttle = 0.0;
        }
        let mut drive = self.drivetrain.wheel_torque(gear, spin, self.hands.throttle);
        drive *= if drive > 0.0 { self.traction } else { hopping };
        if self.hands.shifting {
            drive = 0.0;
        }
        action.drive = drive;
        self.hands.revolutions = self.drivetrain.revolutions(gear, spin);
        // brakes where the closed engine is not enough, and for a while longer
        let rest = closed - force;
        self.braking = if self.braking { rest > 0.0 } else { rest > 0.10 * m.mass() * GRAVITY };
        let lap = self.lap();
        let corner = self.circuit.next_corner[self.circuit.index(along)];
        let approach =
            self.approaches[(lap * self.circuit.corners() + corner).min(self.approaches.len() - 1)];
        self.shut = if self.hands.throttle < 0.02 { self.shut + self.period } else { 0.0 };
        let mut target = [0.0; 2];
        // the fingers reach for the lever when the throttle is shut
        if self.braking && self.shut > REACH {
            // never over the handlebar, nor a locked front wheel
            let holding = ease(-front.slip[0], 0.06, 0.14).min(ease(-rear.load, -200.0, 0.0));
            self.lift += (holding - self.lift) * (self.period / 0.02).min(1.0);
            // a dab of the rear brake while it brakes hard and upright
            if lean < 0.45 && rest > 700.0 {
                target[1] = approach.dab * ease(-rear.slip[0], 0.05, 0.1);
            }
            let behind = target[1] * m.brake_gain[1] / radius[1];
            target[0] = (rest - behind).max(0.0) * radius[0] / m.brake_gain[0] * self.lift;
        }
        for i in 0..2 {
            let lag = if target[i] > self.hands.pressure[i] { 0.06 } else { 0.05 };
            let p = &mut self.hands.pressure[i];
            *p += (target[i] - *p) * (self.period / lag).min(1.0);
            if target[i] == 0.0 && *p < 8e3 {
                *p = 0.0;
            }
            action.brake[i] = m.brake_gain[i] * *p;
        }
    }
}

/// Every corner of every lap: one in nine without the brakes, one in three with a dab of the rear one.
fn approaches(corners: usize, laps: usize, random: &mut Random) -> Vec<Approach> {
    (0..(laps + 1) * corners)
        .map(|k| {
            let (lap, corner) = (k / corners, k % corners);
            // another corner each lap is rolled into with the throttle shut
            let rolled = (corner + 4 * lap) % corners == 1;
            let hard = random.between(0.75, 1.0);
            let dabbed = random.between(0.0, 1.0) < 0.34;
            let pressure = random.between(2e5, 7e5);
            Approach {
                brake: hard,
                rolled,
                lateral: random.between(0.88, 1.0),
                drive: random.between(0.7, 1.0),
                dab: if dabbed { pressure } else { 0.0 },
            }
        })
        .collect()
}
