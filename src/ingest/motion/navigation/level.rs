//! The contract's quantities of a state.

use nalgebra::{Rotation3, Vector3};

use super::state::State;
use super::strapdown::gravity;

/// How many there are.
pub const OUTPUTS: usize = 10;

/// Measurement of the unit at an instant, body axes, low-passed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Felt {
    /// Rate, rad/s.
    pub rate: Vector3<f64>,
    /// Derivative of the rate, rad/s².
    pub rate_rate: Vector3<f64>,
    /// Specific force, m/s².
    pub force: Vector3<f64>,
}

/// Direction of the level frame's x, north and west, of a main frame: the trace of its plane on the road. It depends
/// on the frame's y alone.
pub(super) fn trace(frame: &Rotation3<f64>) -> [f64; 2] {
    let left = frame * Vector3::y();
    let size = left.x.hypot(left.y).max(1e-9);
    [left.y / size, -left.x / size]
}

/// Roll and pitch of a main frame, Euler angles, rad.
pub(super) fn roll_pitch(frame: &Rotation3<f64>) -> [f64; 2] {
    let m = frame.matrix();
    [m[(2, 1)].atan2(m[(2, 2)]), (-m[(2, 0)]).clamp(-1.0, 1.0).asin()]
}

/// Rates of roll, pitch and yaw of a spin in main frame axes, rad/s.
pub(super) fn euler_rates([roll, pitch]: [f64; 2], spin: &Vector3<f64>) -> [f64; 3] {
    let (sin, cos) = roll.sin_cos();
    let down = spin.y * sin + spin.z * cos;
    [spin.x + pitch.tan() * down, spin.y * cos - spin.z * sin, down / pitch.cos().max(1e-3)]
}

/// Velocity of the point `arm` (main frame, m) from the unit, along and across the level x, m/s.
pub(super) fn velocity(state: &State, rate: &Vector3<f64>, arm: &Vector3<f64>) -> [f64; 2] {
    let frame = state.frame();
    let to_main = frame.inverse() * state.attitude;
    let spin = to_main * state.rate(rate);
    let v = state.velocity + frame * spin.cross(arm);
    let [x, y] = trace(&frame);
    [v.x * x + v.y * y, v.y * x - v.x * y]
}

/// `velocity_x`, `velocity_y`, `acceleration_x`, `acceleration_y`, `roll`, `pitch`, `yaw`, `roll_rate`, `pitch_rate`,
/// `yaw_rate` of the point `arm` (main frame, m) from the unit.
pub(super) fn outputs(state: &State, felt: &Felt, arm: &Vector3<f64>) -> [f64; OUTPUTS] {
    let frame = state.frame();
    let to_main = frame.inverse() * state.attitude;
    let spin = to_main * state.rate(&felt.rate);
    let spin_rate = to_main * felt.rate_rate;
    let lever = spin_rate.cross(arm) + spin.cross(&spin.cross(arm));
    let a = state.attitude * state.force(&felt.force) + frame * lever + gravity();
    let [x, y] = trace(&frame);
    let [vx, vy] = velocity(state, &felt.rate, arm);
    let angles = roll_pitch(&frame);
    let [roll_rate, pitch_rate, yaw_rate] = euler_rates(angles, &spin);
    [
        vx,
        vy,
        a.x * x + a.y * y,
        a.y * x - a.x * y,
        angles[0],
        angles[1],
        y.atan2(x),
        roll_rate,
        pitch_rate,
        yaw_rate,
    ]
}
