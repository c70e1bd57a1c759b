//! The motorcycle Magic Formula: version 5.2 as refined by Sharp, Evangelou and Limebeer (2004),
//! after de Vries and Pacejka (1998).
//!
//! ```text
//! Fx = Gx Fx0(kappa)     Fy = Gy Fy0(beta, gamma)     Mz = -t Gy Fy0(beta, 0) + Mzr
//! Fy0 = Dy sin{Cy atan[By b - Ey(By b - atan By b)] + Cg atan[Bg g - Eg(Bg g - atan Bg g)]}
//! ```
//!
//! `b` is the slip angle, `g` the camber. The published sets' own sense has a force to the right
//! for both, so `Fy` and `Mz` turn their sign into ISO 8855. There is no overturning moment: it
//! comes from the contact point that moves round the crown.
//!
//! A property file of the format `PAC_MC` (MF-MCTyre) is in ISO 8855 already (`PKY1` is negative),
//! scales its moments by the unloaded radius, acts where the wheel plane meets the road and has an
//! overturning moment of its own (`QSX2`, `QSX3`) and an arm of the longitudinal force (`SSZ3`).
#![allow(non_snake_case)] // symbols keep the capitals of the source

use super::keys::{Keys, Missing};
use super::paper::{Input, Output};
use super::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// One tyre; names as in the source (lower case), SI.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // the source's names
pub(crate) struct MfMc {
    pub Fz0: f64,
    pub R0: f64,
    pub carcass: Carcass,
    pub pCx1: f64,
    pub pDx: [f64; 2],
    pub pEx: [f64; 4],
    pub pKx: [f64; 3],
    pub pCy: [f64; 2],
    pub pDy: [f64; 3],
    /// `pEy1, pEy2, pEy4, pEy5`.
    pub pEy: [f64; 4],
    pub pKy: [f64; 7],
    pub rBx: [f64; 2],
    pub rCx1: f64,
    pub rBy: [f64; 3],
    pub rCy1: f64,
    pub qCz1: f64,
    /// `qBz1, qBz2, qBz5, qBz6, qBz9, qBz10`.
    pub qBz: [f64; 6],
    /// `qDz1..4`.
    pub qDz: [f64; 4],
    /// `qDz8..11`.
    pub qDzr: [f64; 4],
    /// `qEz1, qEz2, qEz5`.
    pub qEz: [f64; 3],
    /// `qHz3, qHz4`.
    pub qHz: [f64; 2],
    /// Relaxation length over cornering stiffness: `c0 + c1 v + c2 v²`, m/N.
    pub lag: [f64; 3],
    /// Relaxation length of the slip ratio, m.
    pub lag_x: f64,
    /// `pTy1..3` of a file that has them and no lag: relaxation length over radius, its shape and load.
    pub relaxation: Option<[f64; 3]>,
    /// Rolling resistance coefficient.
    pub rolling: f64,
    /// Gain per speed, s/m: `qSy3 / LONGVL` of a property file.
    pub rolling_speed: f64,
    /// Factor on the camber stiffness.
    pub camber_scale: f64,
    /// `qSx2, qSx3, sSz3` of a file that has an overturning moment of its own, and the arm of `Fx` by
    /// camber; such a file is in ISO 8855.
    pub overturning: Option<[f64; 3]>,
}

/// `sign` that is zero at zero.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// The argument of the Magic Formula's sine.
fn bend(C: f64, E: f64, x: f64) -> f64 {
    C * (x - E * (x - x.atan())).atan()
}

impl MfMc {
    /// From a property file's keys.
    ///
    /// # Errors
    /// Names the first key that is missing.
    pub(crate) fn from_keys(keys: &Keys) -> Result<Self, Missing> {
        let k = |name: &str| keys.number(name);
        let list = |names: &str| names.split(' ').map(k).collect::<Result<Vec<f64>, _>>();
        fn fixed<const M: usize>(list: Vec<f64>) -> [f64; M] {
            std::array::from_fn(|i| list[i])
        }
        let own = keys.text("PROPERTY_FILE_FORMAT") == Some("PAC_MC");
        // such a file may say that it has one rolling radius at every load
        let constant = own && ["DREFF", "FREFF"].iter().all(|k| keys.number(k) == Ok(0.0));
        let crown = match own {
            true => keys.or("CROWN_RADIUS", 0.5 * keys.or("WIDTH", 0.0)),
            false => k("CROWN_RADIUS")?,
        };
        Ok(MfMc {
            Fz0: k("FNOMIN")?,
            R0: if own { k("UNLOADED_RADIUS")? } else { crown },
            carcass: Carcass {
                radius: k("UNLOADED_RADIUS")?,
                crown,
                stiffness: k("VERTICAL_STIFFNESS")?,
                damping: k("VERTICAL_DAMPING")?,
                deflection_share: keys
                    .or("EFFECTIVE_RADIUS_SHARE", if constant { 0.0 } else { 1.0 / 3.0 }),
            },
            pCx1: k("PCX1")?,
            pDx: fixed(list("PDX1 PDX2")?),
            pEx: fixed(list("PEX1 PEX2 PEX3 PEX4")?),
            pKx: fixed(list("PKX1 PKX2 PKX3")?),
            pCy: fixed(list("PCY1 PCY2")?),
            pDy: fixed(list("PDY1 PDY2 PDY3")?),
            pEy: fixed(list("PEY1 PEY2 PEY4 PEY5")?),
            pKy: fixed(list("PKY1 PKY2 PKY3 PKY4 PKY5 PKY6 PKY7")?),
            rBx: fixed(list("RBX1 RBX2")?),
            rCx1: k("RCX1")?,
            rBy: fixed(list("RBY1 RBY2 RBY3")?),
            rCy1: k("RCY1")?,
            qCz1: k("QCZ1")?,
            qBz: fixed(list("QBZ1 QBZ2 QBZ5 QBZ6 QBZ9 QBZ10")?),
            qDz: fixed(list("QDZ1 QDZ2 QDZ3 QDZ4")?),
            qDzr: fixed(list("QDZ8 QDZ9 QDZ10 QDZ11")?),
            qEz: fixed(list("QEZ1 QEZ2 QEZ5")?),
            qHz: fixed(list("QHZ3 QHZ4")?),
            lag: match own {
                true => [keys.or("LAG_C0", 0.0), keys.or("LAG_C1", 0.0), keys.or("LAG_C2", 0.0)],
                false => fixed(list("LAG_C0 LAG_C1 LAG_C2")?),
            },
            lag_x: if own { keys.or("LAG_X", 0.1) } else { k("LAG_X")? },
            relaxation: (own && keys.number("PTY1").is_ok()).then(|| {
                // without the third the second is the load, and the shape that of version 5.2
                match keys.number("PTY3") {
                    Ok(third) => [keys.or("PTY1", 0.0), keys.or("PTY2", 2.0), third],
                    Err(_) => [keys.or("PTY1", 0.0), 2.0, keys.or("PTY2", 1.0)],
                }
            }),
            rolling: keys.or("QSY1", 0.0),
            rolling_speed: keys.or("QSY3", 0.0) / keys.or("LONGVL", 16.7).max(0.1),
            camber_scale: keys.or("LKYC", 1.0),
            overturning: own.then(|| ["QSX2", "QSX3", "SSZ3"].map(|key| keys.or(key, 0.0))),
        })
    }

    /// Cornering stiffness, N/rad.
    pub(crate) fn Kya(&self, Fz: f64, g: f64) -> f64 {
        let [p1, p2, p3, p4, p5, ..] = self.pKy;
        p1 * self.Fz0 * (p2 * (Fz / ((p3 + p4 * g * g) * self.Fz0)).atan()).sin()
            / (1.0 + p5 * g * g)
    }

    /// Camber stiffness, N/rad.
    pub(crate) fn Kyg(&self, Fz: f64) -> f64 {
        self.camber_scale * (self.pKy[5] + self.pKy[6] * self.dfz(Fz)) * Fz
    }

    /// Slip stiffness, N.
    pub(crate) fn Kxk(&self, Fz: f64) -> f64 {
        let dfz = self.dfz(Fz);
        Fz * (self.pKx[0] + self.pKx[1] * dfz) * (self.pKx[2] * dfz).exp()
    }

    /// Longitudinal force alone, N: what `forces` gives.
    pub(crate) fn force_x(&self, input: &Input) -> f64 {
        let Input { slip_ratio, slip_angle, load, friction, .. } = *input;
        if load <= 0.0 { 0.0 } else { self.along(slip_ratio, slip_angle, load, friction) }
    }

    /// Side force alone, N: what `forces` gives.
    pub(crate) fn force_y(&self, input: &Input) -> f64 {
        let Input { slip_ratio, slip_angle, camber, load, friction } = *input;
        if load <= 0.0 {
            return 0.0;
        }
        let Side { Fy, .. } = self.side([slip_ratio, slip_angle, camber], load, friction);
        if self.overturning.is_some() { Fy } else { -Fy }
    }

    fn along(&self, k: f64, b: f64, Fz: f64, mu: f64) -> f64 {
        let k = k.clamp(-1.0, 1e3);
        let (dfz, mu) = (self.dfz(Fz), mu.max(LEAST));
        let Dx = (self.pDx[0] + self.pDx[1] * dfz) * Fz * mu;
        let Ex = ((self.pEx[0] + self.pEx[1] * dfz + self.pEx[2] * dfz * dfz)
            * (1.0 - self.pEx[3] * sign(k)))
        .min(1.0);
        let Bx = self.Kxk(Fz) / (self.pCx1 * Dx);
        let Fx0 = Dx * bend(self.pCx1, Ex, Bx * k).sin();
        let Bxa = self.rBx[0] * (self.rBx[1] * k).atan().cos();
        let Gx = (self.rCx1 * (Bxa * b).atan()).cos();
        Gx * Fx0
    }

    fn side(&self, [k, b, g]: [f64; 3], Fz: f64, mu: f64) -> Side {
        let k = k.clamp(-1.0, 1e3);
        let (dfz, mu) = (self.dfz(Fz), mu.max(LEAST));
        let Dy0 = Fz * self.pDy[0] * (self.pDy[1] * dfz).exp() * mu;
        let Dy = Dy0 / (1.0 + self.pDy[2] * g * g);
        let Ey = (self.pEy[0] + self.pEy[1] * g * g + self.pEy[2] * g * sign(b)).min(1.0);
        let By = self.Kya(Fz, g) / (self.pCy[0] * Dy);
        let Bg = self.Kyg(Fz) / (self.pCy[1] * Dy);
        let Fy0 =
            Dy * (bend(self.pCy[0], Ey, By * b) + bend(self.pCy[1], self.pEy[3], Bg * g)).sin();
        let Byk = self.rBy[0] * (self.rBy[1] * (b - self.rBy[2])).atan().cos();
        let Gy = (self.rCy1 * (Byk * k).atan()).cos();
        Side { Fy: Gy * Fy0, Gy, By, Dy0 }
    }

    fn dfz(&self, Fz: f64) -> f64 {
        // polynomials in load are no guide beyond four times the nominal one
        ((Fz - self.Fz0) / self.Fz0).min(3.0)
    }
}

/// Least friction: ice has some.
const LEAST: f64 = 1e-3;

/// Side force, and what the aligning moment needs of it: weight of the longitudinal slip, stiffness factor, peak of
/// the upright wheel.
struct Side {
    Fy: f64,
    Gy: f64,
    By: f64,
    Dy0: f64,
}

impl TyreModel for MfMc {
    fn forces(&self, input: &Input) -> Output {
        let Input { slip_ratio, slip_angle: b, camber: g, load: Fz, friction: mu } = *input;
        if Fz <= 0.0 {
            return Output::default(); // off the ground
        }
        let k = slip_ratio.clamp(-1.0, 1e3);
        let dfz = self.dfz(Fz);
        let Kxk = self.Kxk(Fz);
        let Fx = self.along(k, b, Fz, mu);
        let Side { Fy, Gy, By, Dy0 } = self.side([k, b, g], Fz, mu);

        // the trail works on the side force of the upright wheel
        let Kya0 = self.Kya(Fz, 0.0);
        let By0 = Kya0 / (self.pCy[0] * Dy0);
        let Fy00 = Dy0 * bend(self.pCy[0], self.pEy[0].min(1.0), By0 * b).sin();
        let with_slip = |b: f64| sign(b) * b.hypot(Kxk * k / Kya0);
        let Bt =
            (self.qBz[0] + self.qBz[1] * dfz) * (1.0 + self.qBz[2] * g.abs() + self.qBz[3] * g * g);
        // slip shortens the trail the more, the less the road grips
        let Bt = if self.overturning.is_some() { Bt / mu.max(LEAST) } else { Bt };
        let Dt = Fz
            * (self.R0 / self.Fz0)
            * (self.qDz[0] + self.qDz[1] * dfz)
            * (1.0 + self.qDz[2] * g.abs() + self.qDz[3] * g * g);
        let Et = ((self.qEz[0] + self.qEz[1] * dfz)
            * (1.0 + self.qEz[2] * g * std::f64::consts::FRAC_2_PI * (Bt * self.qCz1 * b).atan()))
        .min(1.0);
        let away = (1.0 + b * b).sqrt();
        let t = Dt * bend(self.qCz1, Et, Bt * with_slip(b)).cos() / away;
        let SHr = (self.qHz[0] + self.qHz[1] * dfz) * g;
        let Br = self.qBz[4] + self.qBz[5] * By * self.pCy[0];
        let Dr = Fz
            * self.R0
            * ((self.qDzr[0] + self.qDzr[1] * dfz) * g
                + (self.qDzr[2] + self.qDzr[3] * dfz) * g * g.abs())
            / away;
        let Mzr = Dr * (Br * with_slip(b + SHr)).atan().cos();
        let Mz = -t * Gy * Fy00 + Mzr;
        match self.overturning {
            None => Output { force_x: Fx, force_y: -Fy, moment_x: 0.0, moment_z: -Mz },
            Some([q2, q3, s3]) => {
                let Mx = self.R0 * Fz * (q3 * Fy / self.Fz0 - q2 * g);
                let Mz = Mz + self.R0 * s3 * g * Fx;
                Output { force_x: Fx, force_y: Fy, moment_x: Mx, moment_z: Mz }
            }
        }
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        let [c0, c1, c2] = self.lag;
        let per_stiffness = c0 + c1 * speed + c2 * speed * speed;
        let lateral = match (self.overturning.is_some() && self.lag == [0.0; 3], self.relaxation) {
            (true, Some([p1, p2, p3])) if p1 != 0.0 && p3 != 0.0 => {
                let share = load.max(0.0) / (p3 * self.Fz0);
                (p1 * (p2 * share.atan()).sin() * self.R0).max(0.0)
            }
            (true, _) => self.R0, // the file does not say: about a radius is usual
            (false, _) => self.Kya(load, 0.0).abs() * per_stiffness,
        };
        Relaxation { longitudinal: self.lag_x, lateral, camber: None }
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        let load = input.load.max(0.0);
        let coefficient = self.rolling + self.rolling_speed * speed.abs();
        coefficient * load * self.carcass.rolling_radius(load, 1.0 - input.camber.cos())
    }

    fn carcass(&self) -> Carcass {
        self.carcass
    }

    fn reference(&self) -> Reference {
        match self.overturning {
            None => Reference::Carcass,
            Some(_) => Reference::WheelPlane,
        }
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(*self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::tir;

    /// Load, slip ratio, slip angle, camber; forces and moment in ISO 8855: regenerated from the
    /// published equations by other code (shared/spec/simulation.md, section 4).
    const GOLDEN: [(&str, [f64; 4], [f64; 3]); 18] = [
        ("front", [1000.0, 0.0, 0.02, 0.0], [0.0, -340.351635848, 3.470885991]),
        ("front", [1000.0, 0.0, 0.0, -0.5], [0.0, 474.020861923, 14.771828323]),
        ("front", [1300.0, 0.0, 0.01, -0.5], [0.0, 399.87753729, 22.762282302]),
        ("front", [1300.0, 0.0, -0.02, -0.6], [0.0, 1175.284770736, 16.820233827]),
        ("front", [1300.0, -0.05, 0.0, 0.0], [-1358.164631921, f64::NAN, f64::NAN]),
        ("front", [1300.0, 0.05, 0.0, 0.0], [1371.839138717, f64::NAN, f64::NAN]),
        ("front", [1300.0, -0.08, 0.03, -0.3], [-1582.733843876, -253.667477804, 8.66264266]),
        ("front", [2500.0, 0.03, -0.04, 0.7], [1783.308131228, -687.50944692, -51.6537595]),
        ("front", [600.0, -0.2, 0.05, 0.2], [-764.44059284, -361.629402202, -0.611445273]),
        ("rear", [1000.0, 0.0, 0.02, 0.0], [0.0, -324.24063161, 4.43372922]),
        ("rear", [1000.0, 0.0, 0.0, -0.5], [0.0, 317.276107741, 15.51225369]),
        ("rear", [1300.0, 0.0, 0.01, -0.5], [0.0, 249.069393123, 24.601742889]),
        ("rear", [1300.0, 0.0, -0.02, -0.6], [0.0, 852.893352704, 18.723720165]),
        ("rear", [1300.0, -0.05, 0.0, 0.0], [-1320.135423875, f64::NAN, f64::NAN]),
        ("rear", [1300.0, -0.08, 0.03, -0.3], [-1567.170067878, -299.853347056, 10.409299115]),
        ("rear", [2500.0, 0.03, -0.04, 0.7], [1644.719743654, -498.538919728, -62.053563548]),
        ("rear", [600.0, -0.2, 0.05, 0.2], [-757.420303859, -343.715984921, -0.994453517]),
        ("rear", [1300.0, 0.0, 0.15, 0.0], [0.0, -1559.117005993, 6.799341467]),
    ];

    #[test]
    fn agrees_with_the_independent_values() {
        for (end, [load, slip_ratio, slip_angle, camber], expected) in GOLDEN {
            let name =
                if end == "front" { "sharp2004_front_120_70" } else { "sharp2004_rear_180_55" };
            let tyre = tir::load(name).expect("published");
            let out = tyre.forces(&Input { slip_ratio, slip_angle, camber, load, friction: 1.0 });
            for (found, expected) in
                [out.force_x, out.force_y, out.moment_z].into_iter().zip(expected)
            {
                let good = expected.is_nan() || (found - expected).abs() < 1e-8;
                assert!(good, "{end} {load} {slip_ratio} {slip_angle} {camber}: {out:?}");
            }
        }
    }

    #[test]
    fn nothing_is_not_a_number_and_nothing_pulls_in_the_air() {
        let tyre = tir::load("sharp2004_rear_180_55").expect("published");
        for load in [-100.0, 0.0, 1.0, 1500.0, 20_000.0] {
            for slip_ratio in [-5.0, -1.0, 0.0, 0.3, 50.0, f64::INFINITY] {
                for slip_angle in [-1.5, -0.2, 0.0, 1.5] {
                    for camber in [-1.3, 0.0, 1.05] {
                        let input = Input { slip_ratio, slip_angle, camber, load, friction: 0.0 };
                        let o = tyre.forces(&input);
                        let all = [o.force_x, o.force_y, o.moment_x, o.moment_z];
                        assert!(all.iter().all(|x| x.is_finite()), "{input:?} {o:?}");
                        assert!(load > 0.0 || all == [0.0; 4], "{input:?} {o:?}");
                    }
                }
            }
        }
    }
}
