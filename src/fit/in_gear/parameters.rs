//! The parameters of the in-gear fit, each with what is known of it before the ride.

#![cfg_attr(not(feature = "internals"), allow(dead_code))] // tests name every parameter

use super::columns::Columns;
use super::config::Config;
use super::curve::Curve;
use crate::contract::bike::{Axle, Bike};

macro_rules! parameters {
    ($($name:ident: $words:literal;)*) => {
        #[allow(non_camel_case_types, clippy::upper_case_acronyms)]
        #[repr(usize)]
        enum Index { $($name),* }
        $(#[doc = $words] pub const $name: usize = Index::$name as usize;)*
        /// How many there are.
        pub const COUNT: usize = [$($words),*].len();
        pub const WORDS: [&str; COUNT] = [$($words),*];
    };
}

parameters! {
    R_F: "front rolling radius, m";
    R_R: "rear rolling radius, m";
    RHO_F: "front crown radius, m";
    RHO_R: "rear crown radius, m";
    K_F: "log of the front slip stiffness";
    K_R: "log of the rear slip stiffness, braking";
    K_D: "log of the rear slip stiffness, driving";
    D_F: "log of the front peak friction";
    D_R: "log of the rear peak friction";
    C_F: "log of the front shape";
    C_R: "log of the rear shape";
    E_F: "front curvature";
    E_R: "rear curvature";
    DRAG: "drag, kg/m";
    SIT_UP: "drag sitting up over tucked in";
    ROLLING: "rolling resistance";
    LOAD: "exponent of the load";
    LEAN_EXPONENT: "exponent of the stiffness under lean";
    LATERAL: "lateral limit";
    GROWTH_F: "front growth, 1e-6 s2/m2";
    GROWTH_R: "rear growth, 1e-6 s2/m2";
    SINK: "fall of the radius, mm/kN";
    ENGINE_0: "engine drag, N m";
    ENGINE_1: "engine drag with speed, N m per 1000/min";
    ENGINE_INERTIA: "engine inertia, kg m2";
    BRAKE_F: "log of the front brake gain, N m/bar";
    BRAKE_R: "log of the rear brake gain, N m/bar";
    LATENCY: "latency of the velocity, s";
    ANTENNA: "height of the velocity's reference upright, m";
    MASS: "mass, kg";
    HEIGHT: "height of the centre of mass, m";
    ARM: "centre of mass behind the front contact, m";
    LEAN_ZERO: "zero of the lean, rad";
    REAR_SHARE: "rear share of unmeasured braking";
    GAIN_F: "gain of the front slip stiffness with the load";
    GAIN_R: "gain of the rear slip stiffness with the load";
    TWIST: "twisting stiffness over the bike file's";
}

/// Vector of the fit's unknowns in their own scales (many are logarithms), by the indices above.
///
/// Apart from the other descriptions of a motorcycle: the solver moves, scales and varies it as a plain vector.
pub type Theta = [f64; COUNT];

/// Prior knowledge: independent normal distributions.
#[derive(Debug, Clone)]
pub struct Prior {
    pub mean: Theta,
    pub sd: Theta,
}

/// Pascal in a bar.
pub const BAR: f64 = 1e5;
/// A typical one-litre four's overall ratios; their common factor goes into the engine's drag.
const RATIOS: [f64; 6] = [10.9, 8.9, 7.5, 6.5, 5.8, 5.2];

/// Overall ratio of a gear; of no gear a middle one.
pub fn ratio(gear: Option<f64>) -> f64 {
    match gear {
        Some(gear) if gear < 0.5 => 0.0,
        Some(gear) => RATIOS[(gear.round() as usize).clamp(1, RATIOS.len()) - 1],
        None => 6.9,
    }
}

impl Prior {
    /// From the bike file and the pipeline's section.
    pub fn new(bike: &Bike, config: &Config, columns: &Columns) -> Self {
        let mut prior = Prior { mean: [0.0; COUNT], sd: [1.0; COUNT] };
        let mut set = |k: usize, mean: f64, sd: f64| {
            prior.mean[k] = mean;
            prior.sd[k] = sd;
        };
        let own = |key: &str, usual: f64| bike.uncertainty.get(key).copied().unwrap_or(usual);
        for (k, axle) in Axle::BOTH.into_iter().enumerate() {
            let wheel = bike.wheel(axle);
            let key = format!("{}.radius", axle.name());
            set(R_F + k, wheel.radius, own(&key, config.radius_uncertainty * wheel.radius));
            // a crown is about as round as the tyre is wide
            let sd = if k == 0 { 0.03 } else { 0.04 };
            set(RHO_F + k, 0.5 * wheel.width, sd);
            set(D_F + k, config.peak_friction.ln(), config.peak_friction_uncertainty);
            set(C_F + k, 1.55_f64.ln(), 0.08);
            set(E_F + k, 0.0, 0.35);
            set(GROWTH_F + k, [0.85, 1.2][k], 0.5);
            let key = format!("{}.slip_stiffness_load", axle.name());
            set(GAIN_F + k, bike.slip_stiffness_load(axle), bike.deviation(&key).max(0.02));
            let gain = [bike.brake_gain_front, bike.brake_gain_rear][k];
            match gain {
                Some(gain) => set(BRAKE_F + k, (gain * BAR).ln(), 0.1),
                None => set(BRAKE_F + k, [90.0_f64, 30.0][k].ln(), 1.5_f64.ln()),
            }
        }
        for k in [K_F, K_R, K_D] {
            set(k, config.slip_stiffness.ln(), config.slip_stiffness_factor.ln());
        }
        set(DRAG, bike.drag, bike.deviation("aerodynamics.drag").max(0.01));
        // from one who never tucks in to one who sits up at once
        set(SIT_UP, 1.15, 0.12);
        set(ROLLING, 0.015, 0.004);
        set(LOAD, 0.05, 0.04);
        set(LEAN_EXPONENT, 0.7, 0.25);
        set(LATERAL, 1.45, 0.1);
        set(SINK, 0.9, 0.5);
        // without a gear the ratio is a guess: 40 % of the drag, see `model`
        let widened = if columns.gear.is_some() { 1.0 } else { 1.5 };
        set(ENGINE_0, 6.0, 4.0 * widened);
        set(ENGINE_1, 1.7, 0.6 * widened);
        set(ENGINE_INERTIA, 0.02, 0.006);
        set(LATENCY, 0.18, 0.1);
        // on the tail or the dashboard
        set(ANTENNA, 0.9, 0.1);
        set(MASS, bike.mass, own("mass", 8.0));
        set(HEIGHT, bike.cg_height, own("cg_height", 0.03));
        set(ARM, bike.cg_to_front, own("cg_to_front", 0.015));
        set(LEAN_ZERO, 0.0, 0.02);
        set(REAR_SHARE, 0.08, 0.1);
        set(TWIST, 1.0, 0.4);
        prior
    }
}

/// The friction curve of a wheel; of the rear one under drive or not.
pub fn curve(theta: &Theta, wheel: usize, driven: bool) -> Curve {
    let stiffness = match (wheel, driven) {
        (0, _) => K_F,
        (_, false) => K_R,
        (_, true) => K_D,
    };
    Curve {
        stiffness: theta[stiffness].exp(),
        peak: theta[D_F + wheel].exp(),
        shape: theta[C_F + wheel].exp(),
        curvature: theta[E_F + wheel],
        exponent: theta[LEAN_EXPONENT],
        lateral: theta[LATERAL].max(0.9),
    }
}
