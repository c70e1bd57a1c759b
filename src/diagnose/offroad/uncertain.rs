//! What the bike file may be wrong by, as changes of the residuals.
//!
//! A bike that is not quite as its file says leaves residuals of its own, the same in every jump: no
//! scatter between manoeuvres shows them. So every fault-free simulation is of another bike, drawn from
//! what the file is uncertain by: its `[uncertainty]` where given, usual workshop accuracy
//! otherwise. How the rider shares his weight and his pull between pegs and bar is as unknown. Motion and tyre forces
//! stay; to first order the residual moves by `w . (b_1' - b_1 - (A_t' - A_t) f_t)`.

use super::residuals::Residuals;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::estimate::offroad::Estimate;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;

/// Key, standard uncertainty as a share of the number, the same in its unit.
const KEYS: &[(&str, f64, f64)] = &[
    ("offroad.mass_chassis", 0.01, 0.0),
    ("offroad.mass_swing_arm", 0.03, 0.0),
    ("offroad.mass_rear_wheel", 0.02, 0.0),
    ("offroad.mass_front_wheel", 0.02, 0.0),
    ("offroad.inertia_chassis", 0.05, 0.0),
    ("offroad.inertia_rear_wheel", 0.05, 0.0),
    ("offroad.inertia_front_wheel", 0.05, 0.0),
    ("offroad.swing_arm_cg", 0.0, 0.02),
    ("offroad.swing_arm_angle", 0.0, 0.01),
    ("offroad.chassis_cg_to_rear", 0.0, 0.005),
    ("offroad.chassis_cg_height", 0.0, 0.01),
];
/// The rider with his gear, kg; the shock's preload, N m at the pivot.
const RIDER: f64 = 3.0;
const PRELOAD: f64 = 15.0;
/// The rider's posture: weight that rests on the bar instead of the pegs, N, and share of the horizontal
/// force that feet take instead of arms (or the other way round).
const ON_THE_BAR: f64 = 60.0;
const FEET: f64 = 0.25;
/// Spring (with its stops) and damper forces, as shares.
const SPRING: f64 = 0.02;
const DAMPER: f64 = 0.04;

/// One standard deviation of everything, each as a change of every block.
pub(crate) fn columns(residuals: &Residuals, e: &Estimate, bike: &Bike) -> Vec<Vec<f64>> {
    let k = &e.kinematics;
    let step = residuals.step;
    let mut out = Vec::new();
    let forces = |i: usize| -> [f64; 5] {
        e.riders.first().map_or([0.0; 5], |r| r.tyres.columns().map(|f| f[i]))
    };
    let qdd = |i: usize| [k.xdd[i], k.zdd[i], k.mudd[i], k.zdd_f[i], k.add_r[i]];
    for &(key, share, plain) in KEYS {
        let Some(value) = bike.value(key) else { continue };
        let sigma = bike.uncertainty.get(key).copied().unwrap_or(share * value.abs() + plain);
        if sigma <= 0.0 {
            continue;
        }
        // a bike that cannot be is none that could have been ridden
        let Ok(other) = PlanarMotorcycle::new(&bike.with(key, value + sigma)) else { continue };
        out.push(residuals.response(|j, driving| {
            let i = j * step;
            let motion = k.motion(i);
            let (at, changed) = (e.machine.equations.at(&motion), other.equations.at(&motion));
            let (b, b_changed) =
                (at.known(&qdd(i), [0.0; 2], GRAVITY), changed.known(&qdd(i), [0.0; 2], GRAVITY));
            let f = forces(i);
            let mut db: [f64; 5] = std::array::from_fn(|row| {
                let tyres: f64 = (0..5).map(|c| (changed.at[row][c] - at.at[row][c]) * f[c]).sum();
                b_changed[row] - b[row] - tyres
            });
            if driving {
                let kappa = |m: &PlanarMotorcycle| {
                    m.chain.kappa(&m.equations, k.a_r[i]) * m.equations.p.r_r
                };
                db[4] -= (kappa(&other) - kappa(&e.machine)) * f[4];
            }
            finite(db)
        }));
    }
    let rider = bike.uncertainty.get("offroad.rider_mass").copied().unwrap_or(RIDER);
    out.push(residuals.response(|j, _| {
        let (down, forward) =
            (residuals.hold[j] * GRAVITY, -residuals.hold[j] * residuals.acceleration[0][j]);
        let moment = residuals.levers[j][1] * down + residuals.levers[j][2] * forward;
        [-rider * forward, -rider * down, -rider * moment, 0.0, 0.0]
    }));
    out.push(residuals.response(|j, _| {
        let levers = &residuals.levers[j];
        [0.0, 0.0, -(levers[3] - levers[1]) * ON_THE_BAR * residuals.hold[j], 0.0, 0.0]
    }));
    let mass = e.machine.rider.mass;
    out.push(residuals.response(|j, _| {
        let (levers, hold) = (&residuals.levers[j], residuals.hold[j]);
        let forward = -hold * mass * residuals.acceleration[0][j];
        [0.0, 0.0, -(levers[0] - levers[2]) * FEET * forward, 0.0, 0.0]
    }));
    let slope = |i: usize| e.machine.linkage.at(k.shock[i])[1];
    let fork_damper = |i: usize| e.machine.fork.damping(k.zd_f[i]);
    let shock_damper = |i: usize| e.machine.shock.damping(k.ad_r[i] / slope(i)) / slope(i);
    type Force<'a> = &'a dyn Fn(usize) -> f64;
    let forces: [(usize, f64, Force<'_>); 5] = [
        (4, PRELOAD, &|_| 1.0),
        (3, DAMPER, &fork_damper),
        (4, DAMPER, &shock_damper),
        (3, SPRING, &|i| k.f_sf[i] - fork_damper(i)),
        (4, SPRING, &|i| k.t_sr[i] - shock_damper(i)),
    ];
    for (row, share, force) in forces {
        out.push(residuals.response(|j, _| {
            let mut db = [0.0; 5];
            db[row] = share * force(j * step);
            finite(db)
        }));
    }
    out
}

fn finite(db: [f64; 5]) -> [f64; 5] {
    db.map(|v| if v.is_finite() { v } else { 0.0 })
}
