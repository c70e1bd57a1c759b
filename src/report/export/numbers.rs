//! The numbers that make a tyre, in the order of the C structure that holds them.
//!
//! The C header ([`super::header`]) and the simulation unit ([`super::fmu`]) are made of this one list: fields, comments,
//! parameters and values cannot differ.

use super::ends::Ends;
use super::tyre::Characterised;

/// One number of a tyre.
pub(crate) struct Number {
    /// Its name in the file.
    pub name: &'static str,
    /// SI unit, or nothing.
    pub unit: &'static str,
    /// Meaning, as a comment.
    pub meaning: &'static str,
    pub value: fn(&Characterised, &Ends) -> f64,
}

macro_rules! numbers {
    ($($name:ident, $unit:literal, $meaning:literal, $value:expr;)*) => {
        &[$(Number { name: stringify!($name), unit: $unit, meaning: $meaning, value: $value }),*]
    };
}

pub(crate) const ALL: &[Number] = numbers! {
    mf_b, "", "stiffness factor of longitudinal friction, eq. 28", |c, _| c.tyre.tyre.friction.b;
    mf_c, "", "shape factor, eq. 28", |c, _| c.tyre.tyre.friction.c;
    mf_d, "", "peak friction coefficient, eq. 28", |c, _| c.tyre.tyre.friction.d;
    mf_e1, "", "curvature, eq. 28", |c, _| c.tyre.tyre.friction.e1;
    mf_e2, "", "curvature of driving over braking, eq. 28", |c, _| c.tyre.tyre.friction.e2;
    ct, "", "side force per load and tangent of camber, eq. 38", |c, _| c.tyre.tyre.stiffness.ct;
    c1, "", "slip angle per camber, eq. 37, adjusted to the stiffness of eq. 39", |c, _| c.tyre.tyre.stiffness.c1;
    c3, "1/rad2", "slip angle per camber cubed, eq. 37, adjusted likewise", |c, _| c.tyre.tyre.stiffness.c3;
    side_force_ratio, "", "camber over cornering stiffness, C of eq. 13", |c, _| c.tyre.tyre.side_force_ratio;
    twisting_stiffness, "m/rad", "twisting torque coefficient k_t, eq. 16", |c, _| c.tyre.tyre.twisting_stiffness;
    overturning_stiffness, "m", "crown radius k_x, eq. 18", |c, _| c.tyre.tyre.overturning_stiffness;
    rolling_radius, "m", "effective rolling radius under the nominal load", |c, _| c.tyre.tyre.rolling_radius;
    rolling_resistance, "", "c_rol, eq. 21", |c, _| c.tyre.tyre.rolling_resistance;
    relaxation_length, "m", "r_l, eq. 1", |c, _| c.tyre.tyre.relaxation_length;
    nominal_load, "N", "load at rest: what depends on load is relative to it", |c, _| c.tyre.nominal_load;
    slip_stiffness_load, "", "load sensitivity: gain of slip stiffness per load with the nominal load once more", |c, _| c.tyre.slip_stiffness_load;
    vertical_stiffness, "N/m", "K_z, eq. 12", |c, _| c.tyre.tyre.vertical_stiffness;
    camber_force_decay, "", "eq. 15", |c, _| c.tyre.tyre.camber_force_decay;
    camber_moment_decay, "", "eq. 17", |c, _| c.tyre.tyre.camber_moment_decay;
    reference_friction, "", "mu0: the road of the ride", |c, _| c.tyre.tyre.reference_friction;
    peak_slip, "", "sigma_max, eq. 3", |c, _| c.tyre.tyre.peak_slip;
    lateral_peak, "", "side force over load that was reached: no friction circle is smaller", |c, _| c.tyre.tyre.lateral_peak;
    deflection_share, "", "of the deflection, by which it rolls shorter", |c, _| c.tyre.deflection_share;
    width_over_front, "", "width over that of the front tyre, of which radius_camber is said", |c, _| c.crown;
    friction_load, "", "identified by a diagnosis: friction lost with the nominal load once more", |c, _| c.error.friction_load;
    stiffness_load, "", "named: side force per load gained with the nominal load once more", |c, _| c.error.stiffness_load;
    pneumatic_trail, "", "named: trail gained, over that under the nominal load", |c, _| c.error.pneumatic_trail;
    rolling_speed, "s/m", "named: rolling resistance gained per speed", |c, _| c.error.rolling_speed;
    radius_load, "1/kN", "named: rolling radius lost beyond deflection_share", |c, _| c.error.radius_load;
    radius_camber, "m", "named: crown beyond its own", |c, _| c.error.radius_camber;
    radius_speed, "", "named: rolling radius gained at 20 m/s, over itself", |c, _| c.error.radius_speed;
    slip_ratio_min, "", "least slip ratio that was ridden", |_, e| e.slip_ratio[0];
    slip_ratio_max, "", "largest slip ratio that was ridden", |_, e| e.slip_ratio[1];
    slip_angle_max, "rad", "largest slip angle that was ridden, of either sign", |_, e| e.slip_angle;
    camber_max, "rad", "largest camber that was ridden, of either sign", |_, e| e.camber;
    load_min, "N", "least load that was ridden", |_, e| e.load[0];
    load_max, "N", "largest load that was ridden", |_, e| e.load[1];
    side_friction_max, "", "largest side force over load that was ridden", |c, _| c.ridden_side();
};
