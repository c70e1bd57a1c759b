//! What a machine of the population is built of beyond its plant: bodies, springs, frame and inertial unit.

use std::collections::BTreeMap;

use super::draw::{spread, within};
use crate::simulate::effects::ModelError;
use crate::simulate::imu::{Attitude, Imu, Satellite, Triad};
use crate::simulate::motorcycle::Plant;
use crate::simulate::multibody_ride::Build;
use crate::statistics::random::Random;

/// How a machine is sprung.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Springs {
    /// Wheels fixed in the frame.
    None,
    /// Touring.
    Soft,
    /// Road.
    Usual,
    /// Racing.
    Stiff,
}

/// Imperfections of every motorcycle and road, well below what a ride shows: three in a hundred of the usual sizes.
pub(super) fn usual_imperfections(random: &mut Random) -> ModelError {
    let mut error = ModelError::default();
    let mut usual = |typical: f64| 0.03 * typical * random.normal().clamp(-2.0, 2.0);
    error.road_grade = usual(0.003);
    error.wind = usual(1.0);
    error.pad_heat = usual(0.01);
    error.brake_fade = usual(0.06);
    error
}

/// Bodies, springs and frame; a shaft drives the wheel.
pub(super) fn build(plant: &Plant, r: &mut Random) -> (Springs, Build) {
    let vehicle = &plant.vehicle;
    let bodies = ["sports_small", "sports_touring"][usize::from(vehicle.mass > 280.0)];
    let springs = match r.between(0.0, 6.0) as usize {
        0 => Springs::None,
        1 => Springs::Soft,
        2 | 3 => Springs::Usual,
        _ => Springs::Stiff,
    };
    let mut keys: BTreeMap<String, Option<f64>> = BTreeMap::new();
    let mut put = |key: &str, value: Option<f64>| {
        keys.insert(key.to_owned(), value);
    };
    // wheels with tyre and discs 9 to 13 kg in front, 11 to 16 kg behind (Sharp et al. 2004: 11.9, 14.7)
    put("front.wheel.mass", Some(r.between(9.0, 13.0)));
    put("rear.wheel.mass", Some(r.between(11.0, 16.0)));
    for (end, spin) in ["front", "rear"].into_iter().zip(vehicle.wheel_inertia) {
        // a disc has half its spin inertia across, a ring with a hub a little more
        put(&format!("{end}.wheel.diametral_inertia"), Some(r.between(0.55, 0.62) * spin));
    }
    put("fork.mass", Some(r.between(5.5, 9.0)));
    // longer relaxation lengths than 0.2 m need more, or the steering wobbles at 5 to 6 Hz in corners until it throws the
    // rider
    let lag = (plant.tyres[0].relaxation_length / 0.2).max(1.0);
    put("steering.damping", Some(lag * lag * r.between(4.0, 10.0)));
    put("engine.inertia", Some(r.between(0.0, 0.02)));
    // stiffness at the wheel over the lender's 17 kN/m each: 10 (touring) to 30 kN/m (racing)
    let stiffer = match springs {
        Springs::None => None,
        Springs::Soft => Some(r.between(0.6, 0.85)),
        Springs::Usual => Some(r.between(0.85, 1.2)),
        Springs::Stiff => Some(r.between(1.2, 1.8)),
    };
    // the damping ratio stays within a third
    for (name, stiffness, compression, rebound) in
        [("fork", 17e3, 700.0, 1300.0), ("swing_arm", 5142.5, 272.25, 393.25)]
    {
        let damped = stiffer.map(|s: f64| s.sqrt() * r.between(0.75, 1.33));
        put(&format!("{name}.stiffness"), stiffer.map(|s| s * stiffness));
        put(&format!("{name}.compression"), Some(damped.map_or(0.0, |d| d * compression)));
        put(&format!("{name}.rebound"), Some(damped.map_or(0.0, |d| d * rebound)));
    }
    put("swing_arm.pivot_x", Some(r.between(0.5, 0.6)));
    put("swing_arm.pivot_z", Some(r.between(0.36, 0.42)));
    if r.between(0.0, 1.0) < 0.5 {
        // 34 kN m/rad (Sharp and Alstead 1980) to 150 kN m/rad (Sharp et al. 2004: 100)
        put("frame_twist.stiffness", Some(spread(r, 34e3, 150e3)));
        put("frame_twist.damping", Some(100.0));
        put("frame_twist.x", Some(vehicle.wheelbase - 0.25));
        put("frame_twist.z", Some(0.8));
    }
    let lender = if bodies == "sports_small" { 260.0 } else { 308.0 };
    let trail = Some(r.between(0.085, 0.12)); // data sheets (schemas/bike.v1.toml)
    // the lender's radii of gyration, within a twelfth
    let frame_inertia = vehicle.mass / lender * r.between(0.85, 1.18);
    (springs, Build { bodies, frame_inertia, trail, keys })
}

/// A fused inertial and satellite unit with an aided filter, its noise over the usual; as in
/// `pipelines/scenarios/characterise.toml`, with a gyroscope whose zero is tracked.
pub(super) fn imu(noise: f64, r: &mut Random) -> Imu {
    let mounting = [0; 3].map(|_| 0.001 * r.normal());
    Imu {
        // units give the accelerations of the centre of mass: the rest of a lever arm that was measured
        position: [0; 3].map(|_| within(r, 0.0, 0.02, 2.0)),
        mounting,
        // zeros are effects: these tilt the attitude by a third of what shows
        accelerometer: Triad { white: 0.06 * noise, bias: 0.005, scale: 0.0 },
        gyro: Triad { white: 0.004 * noise, bias: 5e-5, scale: 0.0 },
        attitude: Attitude::Filter { time_constant: r.between(8.0, 20.0), speed_aided: true },
        antenna: [0.0; 3],
        satellite: Satellite { white: 0.01 * noise, slow: 0.02 * noise, slow_time: 2.0 },
    }
}
