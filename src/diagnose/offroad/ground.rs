//! Where the tyres push: the ground's slope under each wheel, and the columns of `A_t` that belong to
//! it.
//!
//! The estimate has every contact under the axle along the chassis. On the face of a jump the ground
//! is turned against the chassis by several degrees, and what a free front wheel then pushes back is
//! taken for something else. While a wheel is on the ground its axle goes along the ground, so the
//! axle's path tells the slope (the tyre's deflection is neglected).
//!
//! ```text
//! tan gamma = -z_axle' / x_axle'      phi = gamma - mu
//! normal: cos phi N + sin phi B, through the axle
//! along:  cos phi D + sin phi N, a radius below it
//! ```

use crate::estimate::offroad::kinematics::Kinematics;
use crate::motorcycle::offroad::equations::{Equations, Matrices};

/// Largest angle between ground and chassis that is believed, rad.
const STEEPEST: f64 = 0.7;

/// Columns `[N_f, N_r, T_f, T_r]` of a sample, ground axes: `T` forward along the ground. Rows as in
/// [`Equations`], the chain not in it.
pub(crate) fn columns(eq: &Equations, k: &Kinematics, at: &Matrices, i: usize) -> [[f64; 4]; 5] {
    let p = &eq.p;
    let (sin, cos) = at.pitch;
    let (sin_eps, cos_eps) = eq.caster();
    let (st, ct) = (p.a_r0 - k.a_r[i]).sin_cos();
    let relative = [
        [-k.zd_f[i] * sin_eps, -k.zd_f[i] * cos_eps],
        [-p.l_r * st * k.ad_r[i], -p.l_r * ct * k.ad_r[i]],
    ];
    let axles = [eq.front_axle(k.z_f[i]), eq.rear_axle(k.a_r[i])];
    let radii = [p.r_f, p.r_r];
    let mut out = [[0.0; 4]; 5];
    for wheel in 0..2 {
        let ([x, z], [vx, vz]) = (axles[wheel], relative[wheel]);
        let forward = k.xd[i] + k.mud[i] * (cos * z - sin * x) + cos * vx + sin * vz;
        let down = k.zd[i] - k.mud[i] * (cos * x + sin * z) + cos * vz - sin * vx;
        let slope = (-down).atan2(forward.max(1.0));
        let (s, c) = (slope - k.mu[i]).clamp(-STEEPEST, STEEPEST).sin_cos();
        let r = radii[wheel];
        for row in 0..5 {
            let normal = at.at[row][wheel];
            // B_f, B_r act a radius below the axle; here first through it
            let through = match (row, wheel) {
                (2, _) => at.at[2][2 + wheel] + r,
                (4, 1) => at.at[4][3] - r,
                _ => at.at[row][2 + wheel],
            };
            let lever = match (row, wheel) {
                (2, _) => r,
                (4, 1) => -r,
                _ => 0.0,
            };
            out[row][wheel] = c * normal + s * through;
            out[row][2 + wheel] = s * normal - c * through + lever;
        }
    }
    out
}
