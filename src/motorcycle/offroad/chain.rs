//! The chain: what the drive force does to the rear suspension.
//!
//! The upper run pulls with the tension `T = (R_r D_r - I_1 W) / r_s` at a lever `d` about the
//! swing-arm pivot, `W` the wheel's absolute acceleration about +y. With `kappa = d / r_s` row 5
//! gains `kappa R_r` in the column of `D_r` and `kappa I_1 W` on the known side (book, Off the
//! road, section 5).

use super::equations::Equations;

/// Known properties of the chain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Chain {
    /// Nothing: `kappa` = 0, as in the paper.
    Ignored,
    /// Teeth of front over rear sprocket: exact for a front sprocket about the pivot.
    ToothRatio(f64),
    /// All of it: radii of front and rear sprocket, front sprocket's centre in the chassis frame
    /// (x, z down), m.
    Geometry {
        /// Front sprocket, m.
        r_p: f64,
        /// Rear sprocket, m.
        r_s: f64,
        /// Front sprocket's centre, m.
        centre: [f64; 2],
    },
}

/// Which run of the chain pulls.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Run {
    /// The upper: drive.
    Upper,
    /// The lower: engine braking.
    Lower,
}

impl Chain {
    /// `kappa` of the upper run at a swing-arm compression.
    #[inline]
    pub fn kappa(&self, equations: &Equations, a_r: f64) -> f64 {
        match *self {
            Chain::Ignored => 0.0,
            Chain::ToothRatio(ratio) => ratio,
            Chain::Geometry { r_p, r_s, centre } => {
                lever(equations, a_r, r_p, r_s, centre, Run::Upper) / r_s
            }
        }
    }
}

/// Lever of a run about the swing-arm pivot per unit tension, positive when it compresses, m.
pub fn lever(
    equations: &Equations,
    a_r: f64,
    r_p: f64,
    r_s: f64,
    centre: [f64; 2],
    run: Run,
) -> f64 {
    let [x_1, z_1] = equations.rear_axle(a_r);
    let [x_p, z_p] = equations.pivot();
    let (vx, vz) = (centre[0] - x_1, centre[1] - z_1);
    let length = vx.hypot(vz);
    let (ex, ez) = (vx / length, vz / length);
    let side = if run == Run::Upper { 1.0 } else { -1.0 };
    let cos = (r_s - r_p) / length;
    let sin = (1.0 - cos * cos).max(0.0).sqrt();
    let (nx, nz) = (cos * ex + side * sin * ez, cos * ez - side * sin * ex);
    side * (r_s + nx * (x_1 - x_p) + nz * (z_1 - z_p))
}
