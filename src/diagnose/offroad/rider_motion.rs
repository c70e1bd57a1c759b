//! The rider's own motion: he follows the chassis slowly, not at once and not never.
//!
//! Rider B stands still against the bike's going up and down (`L_z = m g`) and goes with it fore and
//! aft (`A_x = -m x_s''`). A body on legs and arms does neither: it follows what is slow. Both
//! motions are low-passes of the chassis' acceleration, causal, of second order (rider C,
//! `book/src/offroad.md`, section 9); the cut-off towards zero is B for the vertical one, towards infinity for
//! the horizontal one.

use super::curve::Curve;
use super::declaration::{Declaration, Ride};
use crate::GRAVITY;
use crate::diagnose::cause::Candidate;
use crate::estimate::offroad::rider::c::low_passed;

/// Up and down.
pub(crate) const VERTICAL: Declaration = Declaration {
    candidate: Candidate {
        place: 0,
        name: "rider_vertical_motion",
        parameter: "cut_off",
        sentence: "below this frequency the rider follows the chassis up and down",
        opposite: "below this frequency the rider follows the chassis up and down",
        unit: "Hz",
        separate_by: "jumps and whoops at several speeds, with fork and shock travel logged",
        typical: 1.5,
        bounds: [0.1, 8.0],
    },
    family: None,
    curve: vertical,
};

/// Fore and aft.
pub(crate) const HORIZONTAL: Declaration = Declaration {
    candidate: Candidate {
        place: 0,
        name: "rider_horizontal_motion",
        parameter: "horizontal_cut_off",
        sentence: "below this frequency the rider follows the chassis fore and aft",
        opposite: "below this frequency the rider follows the chassis fore and aft",
        unit: "Hz",
        separate_by: "hard braking and driving on level ground, jumps with a kicker",
        typical: 1.0,
        bounds: [0.1, 8.0],
    },
    family: None,
    curve: horizontal,
};

/// Cut-offs, Hz.
const RANGE: [f64; 2] = [0.1, 8.0];
const NODES: usize = 45;

fn nodes(column: impl Fn(f64) -> Vec<f64>) -> Curve {
    let [low, high] = RANGE.map(f64::ln);
    let at: Vec<f64> =
        (0..NODES).map(|k| low + (high - low) * k as f64 / (NODES - 1) as f64).collect();
    let columns = at.iter().map(|a| column(a.exp())).collect();
    Curve::Nodes { at, columns }
}

fn vertical(ride: &Ride<'_>) -> Curve {
    let r = ride.residuals;
    let mass = ride.estimate.machine.rider.mass;
    nodes(|cut_off| {
        let own = low_passed(&r.acceleration[1], r.rate, cut_off, false);
        r.response(|i, _| {
            // less than his weight, never pulling
            let more = r.hold[i] * mass * -own[i].min(GRAVITY);
            [0.0, -more, -r.levers[i][1] * more, 0.0, 0.0]
        })
    })
}

fn horizontal(ride: &Ride<'_>) -> Curve {
    let r = ride.residuals;
    let (mass, arms) = (ride.estimate.machine.rider.mass, ride.rider.arms);
    nodes(|cut_off| {
        let own = low_passed(&r.acceleration[0], r.rate, cut_off, false);
        r.response(|i, _| {
            let more = -r.hold[i] * mass * (own[i] - r.acceleration[0][i]);
            let lever = arms * r.levers[i][2] + (1.0 - arms) * r.levers[i][0];
            [-more, 0.0, -lever * more, 0.0, 0.0]
        })
    })
}
