//! The state of the reduced-order motorcycle, its inputs and its response.

use crate::tyre::pair::both;
use crate::tyre::paper::Output;

#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    /// Forward velocity of the centre of mass.
    pub vx: f64,
    /// Lateral velocity of the centre of mass.
    pub vy: f64,
    pub yaw_rate: f64,
    pub yaw: f64,
    pub roll: f64,
    pub roll_rate: f64,
    /// Wheel spins, front and rear.
    pub omega: [f64; 2],
    /// Lagged slip angles, front and rear.
    pub alpha: [f64; 2],
    /// Handlebar angle.
    pub steer: f64,
}

/// Numbers in a state.
pub(super) const N: usize = 11;

impl State {
    pub(super) fn to_array(self) -> [f64; N] {
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

    pub(super) fn from_array(a: &[f64; N]) -> Self {
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

/// Action of rider, road and air during a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Action {
    /// Commanded handlebar angle.
    pub steer: f64,
    /// Brake torques, front and rear.
    pub brake: [f64; 2],
    /// Drive torque at the rear wheel.
    pub drive: f64,
    /// Extra forward force on the centre of mass: slope, gusts.
    pub force_x: f64,
    /// Extra lateral force on the centre of mass.
    pub force_y: f64,
    /// Extra yaw moment.
    pub moment_z: f64,
    /// Share of the road's friction that is lost.
    pub lost_grip: f64,
    /// Time since the ride began, s.
    pub time: f64,
    /// How far the centre of mass has moved ahead of its place over the wheels, m: a diving frame.
    pub ahead: f64,
    /// Rate of the dive, rad/s.
    pub dive_rate: f64,
    /// Acceleration of the dive, rad/s².
    pub dive_acceleration: f64,
}

impl Action {
    /// On the way to another, a share of it gone; the time stays.
    pub(super) fn towards(&self, to: &Action, share: f64) -> Action {
        let between = |a: f64, b: f64| a + share * (b - a);
        Action {
            steer: between(self.steer, to.steer),
            brake: both(|k| between(self.brake[k], to.brake[k])),
            drive: between(self.drive, to.drive),
            force_x: between(self.force_x, to.force_x),
            force_y: between(self.force_y, to.force_y),
            moment_z: between(self.moment_z, to.moment_z),
            lost_grip: between(self.lost_grip, to.lost_grip),
            time: self.time,
            ahead: between(self.ahead, to.ahead),
            dive_rate: between(self.dive_rate, to.dive_rate),
            dive_acceleration: between(self.dive_acceleration, to.dive_acceleration),
        }
    }
}

/// Quantities that follow from a state and an action.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Response {
    /// Acceleration of the centre of mass, level frame.
    pub acceleration: [f64; 2],
    pub roll_acceleration: f64,
    /// Wheel loads.
    pub load: [f64; 2],
    pub slip_ratio: [f64; 2],
    /// Camber angles.
    pub camber: [f64; 2],
    /// Tyre outputs, wheel frame; without rolling resistance.
    pub tyre: [Output; 2],
    /// Kinematic steering angle on the road.
    pub kinematic_steer: f64,
}
