//! The motorcycle's state, what the rider does, and what follows.

use nalgebra::{Matrix3, Vector3};

use crate::simulate::multibody::bodies::Motion;

/// Joints, in the order of [`State::joints`].
pub mod joint {
    /// Swing arm on the frame, rad, positive when the wheel rises.
    pub const SWING: usize = 0;
    /// Rear wheel on the swing arm, rad.
    pub const REAR: usize = 1;
    /// Steering head on the frame, about an axis square to the steering axis, rad.
    pub const TWIST: usize = 2;
    /// Handlebar and upper fork, rad, positive to the left.
    pub const STEER: usize = 3;
    /// Fork travel, m, positive in compression.
    pub const FORK: usize = 4;
    /// Front wheel on the fork, rad.
    pub const FRONT: usize = 5;
    /// Rider's upper body on the frame, rad, positive to the right.
    pub const RIDER: usize = 6;
    /// How many there are.
    pub const COUNT: usize = 7;
}

/// Length of the state as an array.
pub(crate) const N: usize = 32;

/// The integrated state. Parameters axes: x and y on the road, z along its normal.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Frame-fixed point that is the nominal rear contact, m.
    pub position: Vector3<f64>,
    /// Yaw, then roll, then pitch of the frame, rad. In this order yaw is the heading of the
    /// frame plane's trace on the road and roll its camber.
    pub angles: [f64; 3],
    pub joints: [f64; joint::COUNT],
    /// Velocity of the frame in its own axes, about `position`.
    pub velocity: Motion,
    pub rates: [f64; joint::COUNT],
    /// Lagged slip ratio, slip angle and camber, front and rear.
    pub lag: [[f64; 3]; 2],
}

impl State {
    /// All numbers in a fixed order.
    pub fn to_array(self) -> [f64; N] {
        let mut a = [0.0; N];
        a[0..3].copy_from_slice(self.position.as_slice());
        a[3..6].copy_from_slice(&self.angles);
        a[6..13].copy_from_slice(&self.joints);
        a[13..16].copy_from_slice(self.velocity.angular.as_slice());
        a[16..19].copy_from_slice(self.velocity.linear.as_slice());
        a[19..26].copy_from_slice(&self.rates);
        a[26..29].copy_from_slice(&self.lag[0]);
        a[29..32].copy_from_slice(&self.lag[1]);
        a
    }

    /// The inverse of [`State::to_array`].
    pub fn from_array(a: &[f64; N]) -> Self {
        let vector = |i: usize| Vector3::new(a[i], a[i + 1], a[i + 2]);
        State {
            position: vector(0),
            angles: [a[3], a[4], a[5]],
            joints: std::array::from_fn(|i| a[6 + i]),
            velocity: Motion::new(vector(13), vector(16)),
            rates: std::array::from_fn(|i| a[19 + i]),
            lag: [[a[26], a[27], a[28]], [a[29], a[30], a[31]]],
        }
    }

    /// Frame axes to world.
    pub fn rotation(&self) -> Matrix3<f64> {
        rotation(&self.angles)
    }

    /// Rates of yaw, roll and pitch, rad/s.
    pub fn angle_rates(&self) -> [f64; 3] {
        angle_rates(&self.angles, &self.velocity.angular)
    }

    /// Accelerations of yaw, roll and pitch, rad/s², from the state's own rates.
    pub fn angle_accelerations(&self, rates: &State) -> [f64; 3] {
        let ((sr, cr), (sp, cp)) = (self.angles[1].sin_cos(), self.angles[2].sin_cos());
        let [yaw_rate, roll_rate, pitch_rate] = self.angle_rates();
        let (w, a) = (&self.velocity.angular, &rates.velocity.angular);
        let roll = cp * a.x + sp * a.z + pitch_rate * (cp * w.z - sp * w.x);
        let down = cp * a.z - sp * a.x - pitch_rate * (sp * w.z + cp * w.x);
        let yaw = (down + yaw_rate * sr * roll_rate) / cr;
        [yaw, roll, a.y - yaw * sr - yaw_rate * cr * roll_rate]
    }

    /// Forward and lateral velocity, along and across the frame plane's trace, of a frame-fixed
    /// point, m/s.
    pub fn level_velocity(&self, point: &Vector3<f64>) -> [f64; 2] {
        let v = self.rotation() * self.velocity.at(point);
        let (sin, cos) = self.angles[0].sin_cos();
        [v.x * cos + v.y * sin, v.y * cos - v.x * sin]
    }

    /// Yaw, pitch and roll in the order that inertial units give them (yaw, then pitch, then
    /// roll), rad.
    pub fn euler(&self) -> [f64; 3] {
        let r = self.rotation();
        [r[(1, 0)].atan2(r[(0, 0)]), (-r[(2, 0)]).asin(), r[(2, 1)].atan2(r[(2, 2)])]
    }
}

/// Axes of a frame that is yawed, then rolled, then pitched.
pub(crate) fn rotation(angles: &[f64; 3]) -> Matrix3<f64> {
    let [(sy, cy), (sr, cr), (sp, cp)] = angles.map(f64::sin_cos);
    Matrix3::new(
        cy * cp - sy * sr * sp,
        -sy * cr,
        cy * sp + sy * sr * cp,
        sy * cp + cy * sr * sp,
        cy * cr,
        sy * sp - cy * sr * cp,
        -cr * sp,
        sr,
        cr * cp,
    )
}

/// Rates of yaw, roll and pitch from the angular velocity in frame axes.
pub(crate) fn angle_rates(angles: &[f64; 3], spin: &Vector3<f64>) -> [f64; 3] {
    let ((sr, cr), (sp, cp)) = (angles[1].sin_cos(), angles[2].sin_cos());
    let (along, down) = (cp * spin.x + sp * spin.z, cp * spin.z - sp * spin.x);
    let yaw = down / cr;
    [yaw, along, spin.y - yaw * sr]
}

/// Angular velocity in frame axes from the rates of yaw, roll and pitch.
pub(crate) fn spin(angles: &[f64; 3], rates: &[f64; 3]) -> Vector3<f64> {
    let ((sr, cr), (sp, cp)) = (angles[1].sin_cos(), angles[2].sin_cos());
    let [yaw, roll, pitch] = *rates;
    let down = yaw * cr;
    Vector3::new(cp * roll - sp * down, yaw * sr + pitch, cp * down + sp * roll)
}

/// Action of rider, road and air at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Action {
    /// On the handlebar, N m, positive to the left.
    pub steer_torque: f64,
    /// Brake torques, front and rear, N m, not negative.
    pub brake: [f64; 2],
    /// Drive torque at the rear wheel, N m.
    pub drive: f64,
    /// Engine inertia felt at the rear wheel, kg m² (zero in neutral).
    pub engine_inertia: f64,
    /// Where the rider's upper body is wanted, rad.
    pub lean: f64,
    /// Feet on the road: moment about the frame's x axis, N m.
    pub support: f64,
    /// Wind, world axes, m/s.
    pub wind: [f64; 2],
    /// Forces of gusts on the aerodynamic centre beside the wind's drag: along the heading and to the left, N.
    pub gust: [f64; 2],
    /// Share of the road's friction that is lost.
    pub lost_grip: f64,
    /// Since the ride began, s.
    pub time: f64,
}

/// Motion and forces of one wheel at an instant. Contact axes: x along the wheel plane's trace, y to the
/// left on the road, z up.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wheel {
    /// Lowest point of the carcass on the road, m.
    pub contact: [f64; 2],
    /// Heading of the wheel plane's trace, rad.
    pub heading: f64,
    /// Camber, rad.
    pub camber: f64,
    /// Vertical deflection, m; negative in the air.
    pub deflection: f64,
    /// Load, N.
    pub load: f64,
    /// Effective rolling radius, m.
    pub rolling_radius: f64,
    /// Velocity of the contact along and across the wheel, m/s.
    pub velocity: [f64; 2],
    /// Slip ratio and slip angle as they follow from the motion, before the tyre's lag.
    pub kinematic: [f64; 2],
    /// Lagged slip ratio and slip angle: what the tyre acts on.
    pub slip: [f64; 2],
    /// Longitudinal and lateral force, N.
    pub force: [f64; 2],
    /// Overturning moment about the point where the wheel plane meets the road, N m.
    pub moment_x: f64,
    /// Yaw moment about the same point, N m.
    pub moment_z: f64,
}
