//! Magic Formula 6.2, as property files for cars and motorcycles hold it.
//!
//! Pacejka (2012), *Tire and Vehicle Dynamics*, 3rd ed., chapter 4.3.2, without turn slip (all
//! zetas one). Its axes are TYDEX W: a positive slip angle or camber pulls to the right, as in
//! ISO 8855, so that nothing turns its sign. Forces act where the wheel plane meets the road; the
//! overturning moment is the formula's own.
//!
//! ```text
//! Fx = Gxa Fx0      Fy = Gyk Fy0 + SVyk      Mz = -t F'y + Mzr + s Fx
//! ```
#![allow(non_snake_case)] // symbols keep the capitals of the source

use super::keys::{Keys, Missing};
use super::mf_62_scale::Scale;
use super::paper::{Input, Output};
use super::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// Coefficients of one letter and direction; index 0 is the source's 1. Absent ones are zero.
pub(crate) type List<const M: usize> = [f64; M];

/// One tyre at one inflation pressure.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)] // the source's names
pub(crate) struct Mf62 {
    pub Fz0: f64,
    pub R0: f64,
    pub V0: f64,
    /// Pressure over nominal, less one; and their ratio.
    pub dpi: f64,
    pub pressure: f64,
    pub carcass: Carcass,
    pub stiffness: [f64; 2],
    pub pcfx: List<3>,
    pub pcfy: List<3>,
    pub pCx: List<1>,
    pub pDx: List<3>,
    pub pEx: List<4>,
    pub pKx: List<3>,
    pub pHx: List<2>,
    pub pVx: List<2>,
    pub ppx: List<4>,
    pub rBx: List<3>,
    pub rCx: List<1>,
    pub rEx: List<2>,
    pub rHx: List<1>,
    pub pCy: List<1>,
    pub pDy: List<3>,
    pub pEy: List<5>,
    pub pKy: List<7>,
    pub pHy: List<2>,
    pub pVy: List<4>,
    pub ppy: List<5>,
    pub rBy: List<4>,
    pub rCy: List<1>,
    pub rEy: List<2>,
    pub rHy: List<2>,
    pub rVy: List<6>,
    pub qBz: List<10>,
    pub qCz: List<1>,
    pub qDz: List<11>,
    pub qEz: List<5>,
    pub qHz: List<4>,
    pub ppz: List<2>,
    pub ssz: List<4>,
    pub qsx: List<14>,
    pub ppMx: List<1>,
    pub qsy: List<8>,
    scale: Scale,
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// `x - E (x - atan x)`, the bent argument.
fn bent(E: f64, x: f64) -> f64 {
    x - E * (x - x.atan())
}

/// Result of pure lateral slip at one camber.
struct Lateral {
    Fy0: f64,
    mu: f64,
    Kya: f64,
    ByCy: f64,
    /// `SHy + SVy / Kya`.
    SHf: f64,
}

/// Load and slips of a contact, as the formulas want them.
struct Slips {
    Fz: f64,
    /// Relative load beyond the nominal one.
    dfz: f64,
    k: f64,
    /// Tangent of the slip angle.
    a: f64,
    /// Sine of the camber angle.
    g: f64,
    /// Friction of the road, relative.
    mu: f64,
}

impl Mf62 {
    /// From a property file's keys.
    ///
    /// # Errors
    /// Names the first key that is missing; shape coefficients that are absent are zero.
    pub(crate) fn from_keys(keys: &Keys) -> Result<Self, Missing> {
        fn list<const M: usize>(keys: &Keys, stem: &str) -> List<M> {
            std::array::from_fn(|i| keys.or(&format!("{stem}{}", i + 1), 0.0))
        }
        for needed in ["PCX1", "PDX1", "PKX1", "PCY1", "PDY1", "PKY1", "PKY2", "PKY6"] {
            keys.number(needed)?;
        }
        // a file that says so has one rolling radius at every load
        let constant = ["DREFF", "FREFF"].iter().all(|k| keys.number(k) == Ok(0.0));
        let share = if constant { 0.0 } else { 1.0 / 3.0 };
        let nominal = keys.or("NOMPRES", 0.0);
        let pressure = if nominal > 0.0 { keys.or("INFLPRES", nominal) / nominal } else { 1.0 };
        // files from before 6.1 have the load factor in place of the fixed 2
        let mut pKy: List<7> = list(keys, "PKY");
        if keys.number("PKY4").is_err() {
            pKy[3] = 2.0;
        }
        let mut qsy: List<8> = list(keys, "QSY");
        // a file without the exponent means a resistance in proportion to load
        if keys.number("QSY7").is_err() {
            qsy[6] = 1.0;
        }
        Ok(Mf62 {
            Fz0: keys.number("FNOMIN")? * keys.or("LFZO", 1.0),
            R0: keys.number("UNLOADED_RADIUS")?,
            V0: keys.or("LONGVL", 16.7),
            dpi: pressure - 1.0,
            pressure,
            carcass: Carcass {
                radius: keys.number("UNLOADED_RADIUS")?,
                // how the contour keys are meant is not public: half the width is usual
                crown: keys.or("CROWN_RADIUS", 0.5 * keys.or("WIDTH", 0.0)),
                stiffness: keys.number("VERTICAL_STIFFNESS")?,
                damping: keys.or("VERTICAL_DAMPING", 200.0),
                deflection_share: keys.or("EFFECTIVE_RADIUS_SHARE", share),
            },
            stiffness: [
                keys.or("LONGITUDINAL_STIFFNESS", 3e5),
                keys.or("LATERAL_STIFFNESS", 1.2e5),
            ],
            pcfx: list(keys, "PCFX"),
            pcfy: list(keys, "PCFY"),
            pCx: list(keys, "PCX"),
            pDx: list(keys, "PDX"),
            pEx: list(keys, "PEX"),
            pKx: list(keys, "PKX"),
            pHx: list(keys, "PHX"),
            pVx: list(keys, "PVX"),
            ppx: list(keys, "PPX"),
            rBx: list(keys, "RBX"),
            rCx: list(keys, "RCX"),
            rEx: list(keys, "REX"),
            rHx: list(keys, "RHX"),
            pCy: list(keys, "PCY"),
            pDy: list(keys, "PDY"),
            pEy: list(keys, "PEY"),
            pKy,
            pHy: list(keys, "PHY"),
            pVy: list(keys, "PVY"),
            ppy: list(keys, "PPY"),
            rBy: list(keys, "RBY"),
            rCy: list(keys, "RCY"),
            rEy: list(keys, "REY"),
            rHy: list(keys, "RHY"),
            rVy: list(keys, "RVY"),
            qBz: list(keys, "QBZ"),
            qCz: list(keys, "QCZ"),
            qDz: list(keys, "QDZ"),
            qEz: list(keys, "QEZ"),
            qHz: list(keys, "QHZ"),
            ppz: list(keys, "PPZ"),
            ssz: list(keys, "SSZ"),
            qsx: list(keys, "QSX"),
            ppMx: list(keys, "PPMX"),
            qsy,
            scale: Scale::from_keys(keys),
        })
    }

    /// Longitudinal force alone, N: what `forces` gives.
    pub(crate) fn force_x(&self, input: &Input) -> f64 {
        match self.slips(input) {
            Some(at) => self.longitudinal(&at, self.Kxk(at.Fz)),
            None => 0.0,
        }
    }

    /// Side force alone, N: what `forces` gives.
    pub(crate) fn force_y(&self, input: &Input) -> f64 {
        self.slips(input).map_or(0.0, |at| self.side(&at).0)
    }

    /// Inputs of the formulas; nothing off the ground.
    fn slips(&self, input: &Input) -> Option<Slips> {
        let Input { slip_ratio, slip_angle, camber, load: Fz, friction } = *input;
        if Fz <= 0.0 {
            return None;
        }
        Some(Slips {
            Fz,
            dfz: self.dfz(Fz),
            k: slip_ratio.clamp(-1.0, 1e3),
            a: slip_angle.clamp(-1.5, 1.5).tan(),
            g: camber.sin(),
            mu: friction.max(1e-3), // ice has some
        })
    }

    /// Side force under combined slip, N, and what pure slip gives (4.E58 to 4.E67).
    fn side(&self, at: &Slips) -> (f64, Lateral) {
        let &Slips { Fz, dfz, k, a, g, mu } = at;
        let y = self.lateral(Fz, a, g, mu);
        let DVyk = y.mu
            * Fz
            * (self.rVy[0] + self.rVy[1] * dfz + self.rVy[2] * g)
            * (self.rVy[3] * a).atan().cos();
        let SVyk = DVyk * (self.rVy[4] * (self.rVy[5] * k).atan()).sin() * self.scale.vyka;
        (self.weight_y(dfz, a, g, k) * y.Fy0 + SVyk, y)
    }

    /// Longitudinal force under combined slip, N (4.E9 to 4.E18, 4.E50 to 4.E57).
    fn longitudinal(&self, at: &Slips, Kxk: f64) -> f64 {
        let &Slips { Fz, dfz, k, a, g, mu } = at;
        let (s, dpi) = (&self.scale, self.dpi);
        let Cx = self.pCx[0] * s.cx;
        let mux = (self.pDx[0] + self.pDx[1] * dfz)
            * (1.0 + self.ppx[2] * dpi + self.ppx[3] * dpi * dpi)
            * (1.0 - self.pDx[2] * g * g)
            * s.mux
            * mu;
        let Dx = mux * Fz;
        let kx = k + (self.pHx[0] + self.pHx[1] * dfz) * s.hx;
        let Ex = ((self.pEx[0] + self.pEx[1] * dfz + self.pEx[2] * dfz * dfz)
            * (1.0 - self.pEx[3] * sign(kx))
            * s.ex)
            .min(1.0);
        let Bx = Kxk / (Cx * Dx);
        let SVx = Fz * (self.pVx[0] + self.pVx[1] * dfz) * s.vx * s.mux * mu;
        let Fx0 = Dx * (Cx * bent(Ex, Bx * kx).atan()).sin() + SVx;
        let Bxa = (self.rBx[0] + self.rBx[2] * g * g) * (self.rBx[1] * k).atan().cos() * s.xal;
        let Exa = (self.rEx[0] + self.rEx[1] * dfz).min(1.0);
        let Gxa = |a: f64| (self.rCx[0] * bent(Exa, Bxa * a).atan()).cos();
        Fx0 * Gxa(a + self.rHx[0]) / Gxa(self.rHx[0])
    }

    /// Aligning moment under combined slip, N m (4.E31 to 4.E49, 4.E71 to 4.E78).
    fn aligning(&self, at: &Slips, Kxk: f64, y: &Lateral, [Fx, Fy]: [f64; 2]) -> f64 {
        let &Slips { Fz, dfz, k, a, g, mu } = at;
        let (s, dpi) = (&self.scale, self.dpi);
        // the trail works on the side force of the upright wheel (4.E71-4.E78)
        let upright = self.lateral(Fz, a, 0.0, mu);
        let Fy_upright = self.weight_y(dfz, a, 0.0, k) * upright.Fy0;
        let cos_a = 1.0 / (1.0 + a * a).sqrt();
        let with_slip = |x: f64| sign(x) * x.hypot(Kxk / y.Kya * k);
        let SHt = self.qHz[0] + self.qHz[1] * dfz + (self.qHz[2] + self.qHz[3] * dfz) * g;
        let at = with_slip(a + SHt);
        let Bt = (self.qBz[0] + self.qBz[1] * dfz + self.qBz[2] * dfz * dfz)
            * (1.0 + self.qBz[3] * g + self.qBz[4] * g.abs() + self.qBz[5] * g * g)
            * s.ky
            / (s.muy * mu);
        let Ct = self.qCz[0];
        let Dt = Fz
            * (self.R0 / self.Fz0)
            * (self.qDz[0] + self.qDz[1] * dfz)
            * (1.0 - self.ppz[0] * dpi)
            * (1.0 + self.qDz[2] * g.abs() + self.qDz[3] * g * g)
            * s.tr;
        let Et = ((self.qEz[0] + self.qEz[1] * dfz + self.qEz[2] * dfz * dfz)
            * (1.0
                + (self.qEz[3] + self.qEz[4] * g)
                    * std::f64::consts::FRAC_2_PI
                    * (Bt * Ct * (a + SHt)).atan()))
        .min(1.0);
        let t = Dt * (Ct * bent(Et, Bt * at).atan()).cos() * cos_a;
        let Br = self.qBz[8] * s.ky / (s.muy * mu) + self.qBz[9] * y.ByCy;
        let Dr = Fz
            * self.R0
            * ((self.qDz[5] + self.qDz[6] * dfz) * s.res
                + ((self.qDz[7] + self.qDz[8] * dfz) * (1.0 + self.ppz[1] * dpi)
                    + (self.qDz[9] + self.qDz[10] * dfz) * g.abs())
                    * g
                    * s.kzc)
            * s.muy
            * mu
            * cos_a;
        let Mzr = Dr * (Br * with_slip(a + y.SHf)).atan().cos();
        let arm = self.R0
            * (self.ssz[0] + self.ssz[1] * Fy / self.Fz0 + (self.ssz[2] + self.ssz[3] * dfz) * g)
            * s.s;
        -t * Fy_upright + Mzr + arm * Fx
    }

    /// Overturning moment, N m (4.E69).
    fn overturning(&self, Fz: f64, Fy: f64, camber: f64) -> f64 {
        let (s, dpi) = (&self.scale, self.dpi);
        let q = &self.qsx;
        let (f, side) = (Fz / self.Fz0, Fy / self.Fz0);
        self.R0
            * Fz
            * s.mx
            * (q[0] * s.vmx - q[1] * camber * (1.0 + self.ppMx[0] * dpi)
                + q[2] * side
                + q[3]
                    * (q[4] * (q[5] * f).powi(2).atan()).cos()
                    * (q[6] * camber + q[7] * (q[8] * side).atan()).sin()
                + q[9] * (q[10] * f).atan() * camber
                - q[11] * camber * camber.abs())
            + self.R0 * Fy * s.mx * (q[12] + q[13] * camber.abs()) // (4.E69)
    }

    fn dfz(&self, Fz: f64) -> f64 {
        // polynomials in load are no guide beyond four times the nominal one
        ((Fz - self.Fz0) / self.Fz0).min(3.0)
    }

    /// Slip stiffness, N (4.E15).
    pub(crate) fn Kxk(&self, Fz: f64) -> f64 {
        let dfz = self.dfz(Fz);
        Fz * (self.pKx[0] + self.pKx[1] * dfz)
            * (self.pKx[2] * dfz).exp()
            * (1.0 + self.ppx[0] * self.dpi + self.ppx[1] * self.dpi * self.dpi)
            * self.scale.kx
    }

    /// Cornering stiffness, N/rad, negative (4.E25); `g` is the sine of the camber.
    pub(crate) fn Kya(&self, Fz: f64, g: f64) -> f64 {
        let k = &self.pKy;
        let load = Fz / self.Fz0 / ((k[1] + k[4] * g * g) * (1.0 + self.ppy[1] * self.dpi));
        k[0] * self.Fz0
            * (1.0 + self.ppy[0] * self.dpi)
            * (1.0 - k[2] * g.abs())
            * (k[3] * load.atan()).sin()
            * self.scale.ky
    }

    /// Camber stiffness, N/rad, negative (4.E30).
    pub(crate) fn Kyg(&self, Fz: f64) -> f64 {
        Fz * (self.pKy[5] + self.pKy[6] * self.dfz(Fz))
            * (1.0 + self.ppy[4] * self.dpi)
            * self.scale.kyc
    }

    /// Pure lateral slip (4.E19-4.E30).
    fn lateral(&self, Fz: f64, a: f64, g: f64, mu: f64) -> Lateral {
        let (dfz, dpi, s) = (self.dfz(Fz), self.dpi, &self.scale);
        let Kya = self.Kya(Fz, g);
        let Cy = self.pCy[0] * s.cy;
        let muy = (self.pDy[0] + self.pDy[1] * dfz)
            * (1.0 + self.ppy[2] * dpi + self.ppy[3] * dpi * dpi)
            * (1.0 - self.pDy[2] * g * g)
            * s.muy
            * mu;
        let Dy = muy * Fz;
        let SVyg = Fz * (self.pVy[2] + self.pVy[3] * dfz) * g * s.kyc * s.muy * mu;
        let SVy = Fz * (self.pVy[0] + self.pVy[1] * dfz) * s.vy * s.muy * mu + SVyg;
        // the stiffness keeps its sign and never vanishes
        let safe = if Kya.abs() < 1e-3 { -1e-3 } else { Kya };
        let SHy = (self.pHy[0] + self.pHy[1] * dfz) * s.hy + (self.Kyg(Fz) * g - SVyg) / safe;
        let ay = a + SHy;
        let Ey = ((self.pEy[0] + self.pEy[1] * dfz)
            * (1.0 + self.pEy[4] * g * g - (self.pEy[2] + self.pEy[3] * g) * sign(ay))
            * s.ey)
            .min(1.0);
        let By = safe / (Cy * Dy);
        let Fy0 = Dy * (Cy * bent(Ey, By * ay).atan()).sin() + SVy;
        Lateral { Fy0, mu: muy, Kya: safe, ByCy: By * Cy, SHf: SHy + SVy / safe }
    }

    /// Weighting of the lateral force by longitudinal slip (4.E59-4.E64).
    fn weight_y(&self, dfz: f64, a: f64, g: f64, k: f64) -> f64 {
        let B = (self.rBy[0] + self.rBy[3] * g * g)
            * (self.rBy[1] * (a - self.rBy[2])).atan().cos()
            * self.scale.yka;
        let E = (self.rEy[0] + self.rEy[1] * dfz).min(1.0);
        let SH = self.rHy[0] + self.rHy[1] * dfz;
        let G = |k: f64| (self.rCy[0] * bent(E, B * k).atan()).cos();
        G(k + SH) / G(SH)
    }
}

impl TyreModel for Mf62 {
    fn forces(&self, input: &Input) -> Output {
        let Some(at) = self.slips(input) else {
            return Output::default(); // off the ground
        };
        let Kxk = self.Kxk(at.Fz);
        let Fx = self.longitudinal(&at, Kxk);
        let (Fy, y) = self.side(&at);
        let Mz = self.aligning(&at, Kxk, &y, [Fx, Fy]);
        let Mx = self.overturning(at.Fz, Fy, input.camber);
        Output { force_x: Fx, force_y: Fy, moment_x: Mx, moment_z: Mz }
    }

    fn relaxation(&self, load: f64, _speed: f64) -> Relaxation {
        let dfz = self.dfz(load);
        // the carcass stiffens or softens with load and pressure, by no more than a factor of ten
        let carcass = |k: usize, p: &List<3>| {
            let share = (1.0 + p[0] * dfz + p[1] * dfz * dfz) * (1.0 + p[2] * self.dpi);
            self.stiffness[k] * share.clamp(0.1, 10.0)
        };
        Relaxation {
            longitudinal: (self.Kxk(load) / carcass(0, &self.pcfx)).max(0.0),
            lateral: (-self.Kya(load, 0.0) / carcass(1, &self.pcfy)).max(0.0),
            camber: None,
        }
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        let Fz = input.load.max(0.0);
        let (q, v, f) = (&self.qsy, (speed / self.V0).abs(), Fz / self.Fz0);
        let g = input.camber;
        // the longitudinal force's own share needs the force: left out, it is small
        let whole = (q[0] + q[2] * v + q[3] * v.powi(4) + (q[4] + q[5] * f) * g * g)
            * f.powf(q[6])
            * self.pressure.powf(q[7])
            * self.scale.my;
        (self.Fz0 * self.R0 * whole).max(0.0) // (4.E70) with the nominal load, as its exponent needs
    }

    fn carcass(&self) -> Carcass {
        self.carcass
    }

    fn reference(&self) -> Reference {
        Reference::WheelPlane
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::tir;

    fn set(name: &str) -> Mf62 {
        let text = crate::tyre::published::text(name).expect("published");
        Mf62::from_keys(&tir::keys(text, name.as_ref()).expect("keys")).expect("complete")
    }

    #[test]
    fn stiffnesses_are_the_published_cross_check() {
        // motorcycle-tyre-parameters, section 0: per load at two loads, to the digits given
        for (name, load, cornering, camber) in [
            ("mf62_front_120_70", 1100.0, 15166.0, 891.0),
            ("mf62_front_120_70", 2000.0, 17937.0, 1761.0),
            ("mf62_rear_190_55", 1600.0, 25077.0, 1202.0),
            ("mf62_rear_190_55", 2000.0, 27809.0, 1623.0),
        ] {
            let t = set(name);
            assert!((-t.Kya(load, 0.0) - cornering).abs() < 1.0, "{name} {}", t.Kya(load, 0.0));
            assert!((-t.Kyg(load) - camber).abs() < 1.0, "{name} {}", t.Kyg(load));
            // the force's own slope is that stiffness
            let force = |slip_angle: f64, camber: f64| {
                let input = Input { slip_ratio: 0.0, slip_angle, camber, load, friction: 1.0 };
                t.forces(&input).force_y
            };
            let h = 1e-6;
            let slope = (force(h, 0.0) - force(-h, 0.0)) / (2.0 * h);
            // the curve's own shifts take it a little off its steepest point
            assert!((slope / -cornering - 1.0).abs() < 0.05, "{name} {slope}");
        }
        for (name, per_load, peak) in
            [("mf62_front_120_70", 38.6, 1.27), ("mf62_rear_190_55", 34.0, 1.41)]
        {
            let t = set(name);
            assert!((t.Kxk(2000.0) / 2000.0 - per_load).abs() < 0.4, "{}", t.Kxk(2000.0) / 2000.0);
            let friction = (1..800)
                .map(|i| {
                    let slip_ratio = f64::from(i) * 1e-3;
                    let input = Input {
                        slip_ratio,
                        slip_angle: 0.0,
                        camber: 0.0,
                        load: 2000.0,
                        friction: 1.0,
                    };
                    t.forces(&input).force_x / 2000.0
                })
                .fold(0.0, f64::max);
            // the vertical shift of the set comes on top of the peak factor
            assert!((friction - peak).abs() < 0.04, "{name} {friction}");
        }
    }

    #[test]
    fn leaning_left_pulls_left_and_rights_the_wheel() {
        for name in ["mf62_front_120_70", "mf62_rear_190_55"] {
            let t = set(name);
            let input = Input {
                slip_ratio: 0.0,
                slip_angle: 0.0,
                camber: -0.6,
                load: 1500.0,
                friction: 1.0,
            };
            let o = t.forces(&input);
            assert!(o.force_y > 0.4 * 1500.0 && o.moment_x > 0.0 && o.moment_z > 0.0, "{o:?}");
        }
    }

    #[test]
    fn nothing_is_not_a_number() {
        let t = set("mf62_rear_190_55");
        for load in [0.0, 1.0, 1500.0, 10_000.0] {
            for slip_ratio in [-3.0, -1.0, 0.0, 0.2, f64::INFINITY] {
                for slip_angle in [-3.0, -0.2, 0.0, 1.6] {
                    for camber in [-1.3, 0.0, 1.0] {
                        let input = Input { slip_ratio, slip_angle, camber, load, friction: 0.0 };
                        let o = t.forces(&input);
                        let all = [o.force_x, o.force_y, o.moment_x, o.moment_z];
                        assert!(all.iter().all(|x| x.is_finite()), "{input:?} {o:?}");
                    }
                }
            }
        }
    }
}
