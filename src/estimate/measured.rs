//! What sensors of a wheel measure that the balance of forces and the motion of the frame do not know, or know worse:
//!
//! - how both tyres share a braking, by longitudinal forces or brake torques: such braking manoeuvres are used then;
//! - a tyre's slip angle, which needs neither lateral velocity nor handlebar then;
//! - a tyre's own overturning moment, and so the crown of each.
//!
//! Their sums (loads, longitudinal and side force of both tyres) stay those of the balance: masses are known to half a
//! per cent and a force over a load has none of them, while each sensor has a scale of its own ([`FORCE_SCALE`]).
//! Measured in a study: with forces and loads of sensors of 1 % the interval of `ct` was 3.0 % instead of 1.7 %, that
//! of `mf_d` 3.9 % instead of 3.2 % (`examples/wheel_sensors`). The page shows both beside each other.
//!
//! Channels are of `session.v1`: forces of the road on the tyre at its contact, along and across the wheel's trace. A
//! scale is an upstream error of every coefficient that depends on it; the zero of a slip angle is that of straight
//! running.

use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::session::Session;

use super::samples::{
    BRAKE_TORQUE, FORCE_X, FORCE_Y, LOAD, MOMENT_X, SLIP_ANGLE, Samples, between,
};

/// Scale of a measuring wheel's force or moment, or of a brake's torque, standard deviation: makers state 1 % with
/// crosstalk.
const FORCE_SCALE: f64 = 0.01;
/// Zero of a slip angle's sensor that straight running does not show, standard deviation, rad: 0.1 degrees of mounting.
pub(crate) const SLIP_ANGLE_ZERO: f64 = 0.002;

/// Quantity of a wheel's sensor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Slip angle, rad.
    SlipAngle,
    /// Longitudinal force, N.
    ForceX,
    /// Side force, N.
    ForceY,
    /// Vertical load, N.
    Load,
    /// Overturning moment, N m.
    MomentX,
    /// Brake torque, N m.
    BrakeTorque,
}

impl Quantity {
    pub(crate) const ALL: [Quantity; 6] = [
        Quantity::SlipAngle,
        Quantity::ForceX,
        Quantity::ForceY,
        Quantity::Load,
        Quantity::MomentX,
        Quantity::BrakeTorque,
    ];

    /// Channels, front and rear.
    pub(crate) fn channels(self) -> [Channel; 2] {
        match self {
            Quantity::SlipAngle => SLIP_ANGLE,
            Quantity::ForceX => FORCE_X,
            Quantity::ForceY => FORCE_Y,
            Quantity::Load => LOAD,
            Quantity::MomentX => MOMENT_X,
            Quantity::BrakeTorque => BRAKE_TORQUE,
        }
    }

    /// Whether the scale of its sensor moves any coefficient: the sums of forces are those of the balance.
    pub(crate) fn has_scale(self) -> bool {
        matches!(self, Quantity::ForceX | Quantity::MomentX | Quantity::BrakeTorque)
    }

    fn column(self, x: &Samples, k: usize) -> &[f64] {
        match self {
            Quantity::SlipAngle => &x.measured_slip_angle[k],
            Quantity::ForceX => &x.measured_force_x[k],
            Quantity::ForceY => &x.measured_force_y[k],
            Quantity::Load => &x.measured_load[k],
            Quantity::MomentX => &x.measured_moment_x[k],
            Quantity::BrakeTorque => &x.brake_torque[k],
        }
    }
}

/// Relative errors of the wheels' sensors that are taken off, front and rear. All zero but where one is varied.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SensorErrors([[f64; 2]; Quantity::ALL.len()]);

impl SensorErrors {
    /// With one standard deviation of one sensor.
    pub(crate) fn of(quantity: Quantity, axle: Axle) -> Self {
        let mut out = SensorErrors::default();
        out.0[quantity as usize][axle as usize] = FORCE_SCALE;
        out
    }

    /// Reading of sensor `k` (0 front, 1 rear) of a quantity at a sample; `None` without sensor or value.
    pub(crate) fn read(&self, quantity: Quantity, x: &Samples, k: usize, i: usize) -> Option<f64> {
        let shown = quantity.column(x, k).get(i).copied().filter(|v| v.is_finite())?;
        Some(shown * (1.0 - self.0[quantity as usize][k]))
    }
}

/// The wheels' sensors of a session, by quantity and axle.
pub(crate) fn sensors(session: &Session) -> Vec<(Quantity, Axle)> {
    let of = |quantity: Quantity| {
        let channels = Axle::BOTH.into_iter().zip(quantity.channels());
        channels.filter(|(_, c)| session.has(*c)).map(move |(axle, _)| (quantity, axle))
    };
    Quantity::ALL.into_iter().flat_map(of).collect()
}

/// Lateral velocity of the centre of mass (m/s) by a measured slip angle of the rear tyre, where the log has none:
/// `v_y = u tan(alpha_r) + l_r psi' - h cos(phi) phi'`, (29) turned round. As late as the log's velocities are, by
/// `latency` s.
pub(crate) fn lateral_velocity(session: &Session, bike: &Bike, latency: f64) -> Option<Vec<f64>> {
    use Channel as C;
    if session.has(C::VelocityY) {
        return None;
    }
    let get = |c| session.get(c);
    let (alpha, v, turn) = (get(C::SlipAngleRear)?, get(C::VelocityX)?, get(C::YawRate)?);
    let (roll, rolling) = (get(C::Roll)?, get(C::RollRate)?);
    let late = latency * session.rate;
    let of = |i: usize| {
        let (sin_phi, cos_phi) = roll[i].sin_cos();
        // the contact line lies outside the track of the centre of mass and is faster
        let u = between(v, i as f64 + late) - turn[i] * bike.cg_height * sin_phi;
        u * alpha[i].tan() + bike.cg_to_rear() * turn[i] - bike.cg_height * cos_phi * rolling[i]
    };
    let drift: Vec<f64> = (0..session.len).map(of).collect();
    if late == 0.0 {
        return Some(drift);
    }
    Some((0..session.len).map(|i| between(&drift, i as f64 - late)).collect())
}
