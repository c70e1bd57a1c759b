//! What is measured, and what the state says it should be.

use nalgebra::Vector3;

use super::jacobian::gradient;
use super::level::{euler_rates, roll_pitch, trace, velocity};
use super::state::{
    ANTENNA, CROWN, DELAY, DOPPLER, Errors, FORCE, GYRO, LEAN, MOUNT, P, RADIUS, STRAIGHT, State,
    THETA, USUAL_RADIUS, V,
};
use super::strapdown::gravity;
use crate::GRAVITY;

/// Centre of mass above the road, m, for what depends on it weakly.
const HEIGHT: f64 = 0.6;
/// Centre of mass from the rear wheel, m, likewise.
const TO_REAR: f64 = 0.7;
/// Wheelbase, m, likewise.
const WHEELBASE: f64 = 1.4;

/// Where a measurement comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Source {
    Velocity,
    Place,
    Wheels,
    /// Another sensor's lean.
    Lean,
    /// Constraint of straight running.
    Straight,
}

impl Source {
    pub(super) const ALL: [Source; 5] =
        [Source::Velocity, Source::Place, Source::Wheels, Source::Lean, Source::Straight];

    /// Square of the largest innovation over its standard deviation.
    pub(super) fn gate(self) -> f64 {
        match self {
            Source::Straight => 9.0,
            Source::Place | Source::Lean => 25.0,
            Source::Velocity | Source::Wheels => 14.0,
        }
    }

    pub(super) fn name(self) -> &'static str {
        match self {
            Source::Velocity => "satellite velocity",
            Source::Place => "satellite position",
            Source::Wheels => "wheel speeds",
            Source::Lean => "lean",
            Source::Straight => "straight running",
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Measurement {
    /// Kind of the measurement.
    pub kind: Kind,
    pub value: f64,
    pub variance: f64,
    /// Rate of the unit then, body axes, low-passed, rad/s.
    pub rate: Vector3<f64>,
    /// Its specific force, likewise, m/s².
    pub force: Vector3<f64>,
    /// How much later than the step it was taken, s, but for the state's delay.
    pub ahead: f64,
    /// Centre of mass from the unit, main frame, m.
    pub arm: Vector3<f64>,
}

/// Kind of a measured number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// Antenna's velocity along a direction of the world.
    Along(Vector3<f64>),
    /// Antenna's horizontal speed.
    Speed,
    /// A coordinate of the antenna.
    Place(usize),
    /// Spin of the front (0) or rear (1) wheel.
    Wheel(usize),
    /// Lean, of another sensor.
    Lean,
    /// Roll in straight running beyond that of the turn.
    Roll,
    /// Pitch in straight running.
    Pitch,
    /// Lateral velocity of the rear contact in straight running.
    Side,
}

impl Kind {
    /// Where it comes from.
    pub(super) fn source(self) -> Source {
        match self {
            Kind::Along(_) | Kind::Speed => Source::Velocity,
            Kind::Place(_) => Source::Place,
            Kind::Wheel(_) => Source::Wheels,
            Kind::Lean => Source::Lean,
            Kind::Roll | Kind::Pitch | Kind::Side => Source::Straight,
        }
    }

    /// The errors that it depends on.
    fn parts(self) -> &'static [usize] {
        const fn blocks<const M: usize>(at: &[(usize, usize)]) -> [usize; M] {
            let mut out = [0; M];
            let (mut n, mut b) = (0, 0);
            while b < at.len() {
                let mut i = 0;
                while i < at[b].1 {
                    out[n] = at[b].0 + i;
                    (n, i) = (n + 1, i + 1);
                }
                b += 1;
            }
            assert!(n == M);
            out
        }
        const MOVING: [usize; 19] = blocks(&[
            (V, 3),
            (THETA, 3),
            (GYRO, 3),
            (FORCE, 3),
            (ANTENNA, 3),
            (DELAY, 1),
            (DOPPLER, 3),
        ]);
        const PLACE: [usize; 13] = blocks(&[(P, 3), (V, 3), (THETA, 3), (ANTENNA, 3), (DELAY, 1)]);
        const WHEEL: [usize; 16] =
            blocks(&[(V, 3), (THETA, 3), (GYRO, 3), (MOUNT, 3), (RADIUS, 2), (CROWN, 2)]);
        const STANDING: [usize; 16] =
            blocks(&[(V, 3), (THETA, 3), (GYRO, 3), (MOUNT, 3), (LEAN, 1), (STRAIGHT, 3)]);
        match self {
            Kind::Along(_) | Kind::Speed => &MOVING,
            Kind::Place(_) => &PLACE,
            Kind::Wheel(_) => &WHEEL,
            _ => &STANDING,
        }
    }
}

impl Measurement {
    /// Value predicted by the state.
    pub(super) fn predicted(&self, state: &State) -> f64 {
        let ahead = self.ahead - state.other[DELAY];
        match self.kind {
            Kind::Along(direction) => direction.dot(&self.antenna(state, ahead)),
            Kind::Speed => self.antenna(state, ahead).xy().norm(),
            Kind::Place(k) => {
                let at = state.position + state.attitude * state.three(ANTENNA);
                (at + state.velocity * ahead)[k]
            }
            Kind::Wheel(k) => self.wheel(state, k),
            Kind::Lean => roll_pitch(&state.frame())[0] + state.other[LEAN],
            Kind::Roll => {
                let frame = state.frame();
                let angles = roll_pitch(&frame);
                let [_, yaw_rate] = turning(state, &self.rate);
                let speed = state.velocity.xy().norm();
                angles[0] + (speed * yaw_rate / GRAVITY).atan() - state.other[STRAIGHT]
            }
            Kind::Pitch => roll_pitch(&state.frame())[1] - state.other[STRAIGHT + 1],
            Kind::Side => {
                let [speed, side] = velocity(state, &self.rate, &self.arm);
                let angles = roll_pitch(&state.frame());
                let [roll_rate, yaw_rate] = turning(state, &self.rate);
                side - TO_REAR * yaw_rate + HEIGHT * angles[0].cos() * roll_rate
                    - state.other[STRAIGHT + 2] * speed
            }
        }
    }

    /// Measured less predicted, and the derivatives of the predicted.
    pub(super) fn innovation(&self, state: &State) -> (f64, Errors) {
        let slopes = gradient(&|s| self.predicted(s), state, self.kind.parts());
        (self.value - self.predicted(state), slopes)
    }

    /// Velocity of the antenna as the receiver sees it, world. It is not sampled at the step: the
    /// acceleration that takes it there is low-passed, or its noise would count as knowledge of the delay.
    fn antenna(&self, state: &State, ahead: f64) -> Vector3<f64> {
        let lever = state.rate(&self.rate).cross(&state.three(ANTENNA));
        let acceleration = state.attitude * state.force(&self.force) + gravity();
        state.velocity + state.attitude * lever + acceleration * ahead + state.three(DOPPLER)
    }

    /// Spin in main frame axes.
    fn spin(&self, state: &State) -> Vector3<f64> {
        state.frame().inverse() * (state.attitude * state.rate(&self.rate))
    }

    /// The contact runs outside the centre of mass, on a radius that shrinks with the lean.
    fn wheel(&self, state: &State, k: usize) -> f64 {
        let [speed, _] = velocity(state, &self.rate, &self.arm);
        let angles = roll_pitch(&state.frame());
        let [_, _, yaw_rate] = euler_rates(angles, &self.spin(state));
        let crown = state.other[CROWN + k];
        let (sin, cos) = angles[0].sin_cos();
        let rolling = speed - yaw_rate * (HEIGHT - crown) * sin;
        let rolling = if k == 0 { rolling.hypot(WHEELBASE * yaw_rate) } else { rolling };
        rolling / (USUAL_RADIUS * state.other[RADIUS + k].exp() - crown * (1.0 - cos))
    }
}

/// Rates about the level x and about the vertical, rad/s. Unlike Euler rates they do not depend on the pitch of the main
/// frame in the body: rolling into a corner, lean and turn do not belong together, and would be explained by it.
fn turning(state: &State, rate: &Vector3<f64>) -> [f64; 2] {
    let spin = state.attitude * state.rate(rate);
    let [x, y] = trace(&state.frame());
    [spin.x * x + spin.y * y, spin.z]
}

/// Straight running by a state: speed, forward acceleration, whether it is.
pub(super) fn running(
    state: &State,
    rate: &Vector3<f64>,
    force: &Vector3<f64>,
) -> (f64, f64, bool) {
    let frame = state.frame();
    let [roll, _] = roll_pitch(&frame);
    let [roll_rate, yaw_rate] = turning(state, rate);
    let speed = state.velocity.xy().norm();
    let [x, y] = trace(&frame);
    let a = state.attitude * state.force(force) + gravity();
    let straight = yaw_rate.abs() < 0.04
        && speed * yaw_rate.abs() < 0.5
        && roll_rate.abs() < 0.06
        && roll.abs() < 5_f64.to_radians()
        && speed > 5.0;
    (speed, a.x * x + a.y * y, straight)
}
