//! What the rider does with throttle and brakes: the speed he wants, the grip he has, the attitude
//! in the air.

use super::machine::{ForwardModel, Levers, Response, State};
use crate::GRAVITY;

/// His decision of the moment.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Decision {
    /// Torques, N m.
    pub levers: Levers,
    /// The forward acceleration he leans against, m/s².
    pub commanded: f64,
}

/// Hardest acceleration and braking that he asks for, m/s².
const HARDEST: [f64; 2] = [4.5, 6.5];
/// Speed error to acceleration, 1/s.
const EAGERNESS: f64 = 2.5;
/// Front's share of the braking torque.
const FRONT: f64 = 0.68;
/// Slip at which he gives way.
const SLIP: f64 = 0.2;
/// Pitch beyond the ground's at which he gives way, rad.
const ATTITUDE: f64 = 0.22;
/// Torque per pitch error and rate in the air, N m.
const IN_THE_AIR: [f64; 2] = [180.0, 60.0];

/// Decides from the state and what the bike does.
pub fn decide(plant: &ForwardModel, s: &State, response: &Response, airborne: bool) -> Decision {
    let p = plant.parameters();
    let (q, qd) = (s.q(), s.qd());
    let (x, v, mu, mud) = (q[0], qd[0], q[2], qd[2]);
    let wheels = s.wheels();
    if airborne {
        // the nose to where he lands: a little down; the wheel's spin turns the bike
        let error = -0.08 - mu;
        let turn = IN_THE_AIR[0] * error - IN_THE_AIR[1] * mud;
        let drive = if wheels[1] * p.r_r < 1.5 * v { turn.clamp(0.0, 120.0) } else { 0.0 };
        let rear = if wheels[1] > 5.0 { (-turn).clamp(0.0, 90.0) } else { 0.0 };
        return Decision { levers: Levers { drive, front: 0.0, rear }, commanded: 0.0 };
    }
    let wanted = EAGERNESS * (plant.ground.speed(x) - v);
    let wanted = wanted.clamp(-HARDEST[1], HARDEST[0]);
    let mass = plant.machine.weight() / GRAVITY;
    let slope = plant.ground.seen_slope(x + 0.5 * p.w - p.b);
    // against slope and air
    let force = mass * (wanted + GRAVITY * slope.atan().sin()) + plant.machine.drag * v * v;
    let up = mu - slope.atan();
    let give = |beyond: f64, range: f64| (1.0 - beyond / range).clamp(0.0, 1.0);
    let [front, rear] = response.tyres;
    if force > 0.0 {
        let grip = give(rear.slip - SLIP, 0.2) * give(up + 0.25 * mud - ATTITUDE, 0.2);
        let drive = (force * p.r_r * grip).min(450.0);
        return Decision {
            levers: Levers { drive, front: 0.0, rear: 0.0 },
            commanded: drive / (p.r_r * mass),
        };
    }
    let torque = -force * p.r_f;
    let front_grip = give(-front.slip - SLIP, 0.15) * give(-up - 0.25 * mud - ATTITUDE, 0.2);
    let rear_grip = give(-rear.slip - SLIP, 0.15);
    let engine = if wanted < -0.5 { -25.0 } else { 0.0 };
    Decision {
        levers: Levers {
            drive: engine,
            front: (FRONT * torque * front_grip).min(500.0),
            rear: ((1.0 - FRONT) * torque * rear_grip + engine).clamp(0.0, 220.0),
        },
        commanded: (force / mass).max(-HARDEST[1]),
    }
}
