//! The planar motorcycle of four bodies and five coordinates: its equations of motion.
//!
//! ```text
//! M q'' + m_v = A_w g + A_s f_s + A_r f_r + A_t f_t
//! q   = [x_s, z_s, mu, z_f, alpha_r]       f_t = [N_f, N_r, B_f, B_r, D_r]
//! f_s = [F_sf, T_sr]                       f_r = [L_x, L_z, A_x, A_z], on the bike
//! ```
//!
//! Bodies: 1 rear wheel, 2 swing arm, 3 chassis, 4 front wheel with the unsprung part of the fork.
//! Axes as in the paper: X forward, Z **down**, pitch `mu` positive nose **up**, `z_f` and
//! `alpha_r` positive in compression; a wheel that rolls forward turns about -y. SI units.
//!
//! Rows: 1 and 2 all forces along X and Z, N; 3 moments about the centre of mass of the chassis, N m; 4
//! the front wheel along the fork, N; 5 rear wheel and swing arm about their pivot, counted in
//! compression, N m.
//!
//! Source: Vasquez, Lot, Rustighi, Pegoraro (2019), appendix A, in the general form (swing arm
//! with mass) and with the errata of the book, Off the road, sections 3 to 5: the sign of `A_r`, the
//! `z_f'` of `m_v3`, the `m_4` of `m_v4`, the spin term of `m_v5`, the chain.

/// Masses, inertias and geometry of the four bodies, in the paper's axes (z down, from the centre of mass of the
/// chassis).
///
/// `b`, `h`, `w`, `a_r0` belong to the posture in which both travels are zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RigidBodies {
    /// Masses of bodies 1 to 4, kg.
    pub m: [f64; 4],
    /// Inertias of bodies 1 to 4 about their own centres of mass, kg m²; that of the swing arm may be
    /// negative when its mass is lumped into the others.
    pub i: [f64; 4],
    /// Swing arm, pivot to axle, m.
    pub l_r: f64,
    /// Swing arm, pivot to centre of mass along the same line, m.
    pub l_s: f64,
    /// Droop of the swing arm below the chassis' x axis at zero travel, rad.
    pub a_r0: f64,
    /// Caster angle, rad.
    pub eps: f64,
    /// Chassis' centre of mass ahead of the rear axle, m.
    pub b: f64,
    /// Chassis' centre of mass above the ground, m.
    pub h: f64,
    /// Wheelbase, m.
    pub w: f64,
    /// Front wheel's radius, m.
    pub r_f: f64,
    /// Rear wheel's radius, m.
    pub r_r: f64,
    /// Foot peg (x, z), m.
    pub peg: [f64; 2],
    /// Handlebar (x, z), m.
    pub bar: [f64; 2],
}

/// Variables of the matrices.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Motion {
    /// Pitch, nose up, rad.
    pub mu: f64,
    /// Fork compression, m.
    pub z_f: f64,
    /// Swing arm's compression, rad.
    pub a_r: f64,
    /// Pitch rate, rad/s.
    pub mud: f64,
    /// Rate of fork compression, m/s.
    pub zd_f: f64,
    /// Rate of swing-arm compression, rad/s.
    pub ad_r: f64,
    /// Rear wheel's acceleration relative to the swing arm, about +y, rad/s².
    pub mu1dd: f64,
    /// Front wheel's acceleration relative to the fork, about +y, rad/s².
    pub mu4dd: f64,
}

/// Terms that depend on the parameters only, computed once.
#[derive(Debug, Clone, Copy)]
pub struct Equations {
    pub p: RigidBodies,
    m_t: f64,
    m_12: f64,
    j_1: f64,
    j_2: f64,
    x_p: f64,
    z_p: f64,
    sin_eps: f64,
    cos_eps: f64,
    sin_a0: f64,
    cos_a0: f64,
}

/// The equations at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Matrices {
    /// Mass matrix, symmetric.
    pub m: [[f64; 5]; 5],
    /// Velocity terms and the spin of the wheels.
    pub mv: [f64; 5],
    /// Weights per g.
    pub aw: [f64; 5],
    /// Row 3 of `A_r`; rows 1 and 2 are plain sums, rows 4 and 5 zero.
    pub ar: [f64; 4],
    /// Tyre forces; the chain is not in it.
    pub at: [[f64; 5]; 5],
    /// Sine and cosine of the pitch.
    pub pitch: (f64, f64),
}

impl Equations {
    /// Precomputes what does not change.
    pub fn new(p: RigidBodies) -> Self {
        let (sin_a0, cos_a0) = p.a_r0.sin_cos();
        let (sin_eps, cos_eps) = p.eps.sin_cos();
        Equations {
            m_t: p.m.iter().sum(),
            m_12: p.m[0] + p.m[1],
            j_1: p.m[0] * p.l_r + p.m[1] * p.l_s,
            j_2: p.m[0] * p.l_r * p.l_r + p.m[1] * p.l_s * p.l_s,
            x_p: p.l_r * cos_a0 - p.b,
            z_p: p.h - p.r_r - p.l_r * sin_a0,
            sin_eps,
            cos_eps,
            sin_a0,
            cos_a0,
            p,
        }
    }

    /// Swing-arm pivot in the chassis frame, m.
    pub fn pivot(&self) -> [f64; 2] {
        [self.x_p, self.z_p]
    }

    /// Rear axle in the chassis frame, m.
    pub fn rear_axle(&self, a_r: f64) -> [f64; 2] {
        let (sin, cos) = (self.p.a_r0 - a_r).sin_cos();
        [self.x_p - self.p.l_r * cos, self.z_p + self.p.l_r * sin]
    }

    /// Front axle in the chassis frame, m.
    pub fn front_axle(&self, z_f: f64) -> [f64; 2] {
        let p = &self.p;
        [p.w - p.b - z_f * self.sin_eps, p.h - p.r_f - z_f * self.cos_eps]
    }

    /// Sine and cosine of the caster angle.
    pub fn caster(&self) -> (f64, f64) {
        (self.sin_eps, self.cos_eps)
    }

    /// Mass of the whole bike without rider, kg.
    pub fn mass(&self) -> f64 {
        self.m_t
    }

    /// The matrices of section 3.
    #[inline]
    pub fn at(&self, s: &Motion) -> Matrices {
        let p = &self.p;
        let [_, _, _, m_4] = p.m;
        let [i_1, i_2, i_3, i_4] = p.i;
        let (sm, cm) = s.mu.sin_cos();
        let (st, ct) = (p.a_r0 - s.a_r).sin_cos();
        let (se, ce) = (self.sin_eps, self.cos_eps);
        // of sums, from those of the parts
        let (sme, cme) = (sm * ce + cm * se, cm * ce - sm * se);
        let (smt, cmt) = (sm * ct + cm * st, cm * ct - sm * st);
        let (x_p, z_p, j_1, j_2) = (self.x_p, self.z_p, self.j_1, self.j_2);
        let (x_4, z_4) = (p.w - p.b - s.z_f * se, p.h - p.r_f - s.z_f * ce);
        let s_x = self.m_12 * x_p - j_1 * ct + m_4 * x_4;
        let s_z = self.m_12 * z_p + j_1 * st + m_4 * z_4;
        let (g_x, g_z) = (cm * s_x + sm * s_z, cm * s_z - sm * s_x);
        let k_r = j_1 * (st * x_p + ct * z_p);
        let k_f = m_4 * ((p.w - p.b) * se + (p.h - p.r_f) * ce - s.z_f);
        let k_a = s.ad_r * s.ad_r - 2.0 * s.mud * s.ad_r;
        let mud2 = s.mud * s.mud;

        let m13 = g_z;
        let m14 = -m_4 * sme;
        let m15 = -j_1 * smt;
        let m23 = -g_x;
        let m24 = -m_4 * cme;
        let m25 = -j_1 * cmt;
        let m33 = self.m_12 * (x_p * x_p + z_p * z_p)
            + j_2
            + 2.0 * j_1 * (z_p * st - x_p * ct)
            + m_4 * (x_4 * x_4 + z_4 * z_4)
            + i_1
            + i_2
            + i_3
            + i_4;
        let m34 = m_4 * ((p.w - p.b) * ce - (p.h - p.r_f) * se);
        let m35 = j_1 * (x_p * ct - z_p * st) - j_2 - i_1 - i_2;
        let m55 = j_2 + i_1 + i_2;
        let h_r = p.h + p.l_r * (st - self.sin_a0); // centre of mass above the rear contact
        let k = p.r_r + p.l_r * st; // pivot above the rear contact
        let [x_3p, z_3p] = p.peg;
        let [x_3h, z_3h] = p.bar;
        let spin = i_1 * s.mu1dd;
        Matrices {
            m: [
                [self.m_t, 0.0, m13, m14, m15],
                [0.0, self.m_t, m23, m24, m25],
                [m13, m23, m33, m34, m35],
                [m14, m24, m34, m_4, 0.0],
                [m15, m25, m35, 0.0, m55],
            ],
            mv: [
                -mud2 * g_x + j_1 * cmt * k_a - 2.0 * m_4 * cme * s.mud * s.zd_f,
                -mud2 * g_z - j_1 * smt * k_a + 2.0 * m_4 * sme * s.mud * s.zd_f,
                k_r * k_a - 2.0 * k_f * s.mud * s.zd_f + spin + i_4 * s.mu4dd,
                k_f * mud2,
                k_r * mud2 - spin,
            ],
            aw: [0.0, self.m_t, -g_x, -m_4 * cme, -j_1 * cmt],
            ar: [
                cm * z_3p - sm * x_3p,
                -cm * x_3p - sm * z_3p,
                cm * z_3h - sm * x_3h,
                -cm * x_3h - sm * z_3h,
            ],
            at: [
                [-sm, -sm, -cm, -cm, cm],
                [-cm, -cm, sm, sm, -sm],
                [
                    p.w - p.b - s.z_f * se,
                    p.l_r * (self.cos_a0 - ct) - p.b,
                    s.z_f * ce - p.h,
                    -h_r,
                    h_r,
                ],
                [ce, 0.0, se, 0.0, 0.0],
                [0.0, p.l_r * ct, 0.0, k, -k],
            ],
            pitch: (sm, cm),
        }
    }
}

impl Matrices {
    /// `M q'' + m_v - A_w g - A_s f_s`: the known side without the rider.
    #[inline]
    pub fn known(&self, qdd: &[f64; 5], fs: [f64; 2], g: f64) -> [f64; 5] {
        let mut b = [0.0; 5];
        for k in 0..5 {
            let row = &self.m[k];
            let inertia = row[0] * qdd[0]
                + row[1] * qdd[1]
                + row[2] * qdd[2]
                + row[3] * qdd[3]
                + row[4] * qdd[4];
            b[k] = inertia + self.mv[k] - self.aw[k] * g;
        }
        b[3] += fs[0];
        b[4] += fs[1];
        b
    }

    /// `b - A_r f_r`.
    #[inline]
    pub fn less_rider(&self, b: &[f64; 5], fr: &[f64; 4]) -> [f64; 5] {
        let [lx, lz, ax, az] = *fr;
        let moment = self.ar[0] * lx + self.ar[1] * lz + self.ar[2] * ax + self.ar[3] * az;
        [b[0] - lx - ax, b[1] - lz - az, b[2] - moment, b[3], b[4]]
    }

    /// `D_r - B_f - B_r` of a right-hand side: the sum along the chassis, no geometry in it.
    #[inline]
    pub fn along(&self, b: &[f64; 5]) -> f64 {
        self.pitch.1 * b[0] - self.pitch.0 * b[1]
    }
}
