//! Rider A: a mass on the springs and dampers of arms and legs, integrated (Vasquez et al. 2019,
//! eqs. 7 and 8; the equations behind the words as in the book, Off the road, section 9).
//!
//! The state is taken relative to the chassis, `[x', z', x, z]` of the rider's centre of mass less
//! that of the chassis: its accelerations alone drive it, nothing drifts. Runge-Kutta of fourth
//! order with the motion between two samples by cubics.
//!
//! A passive rider can topple over, where a real one would hold on: the model is set upright again,
//! and that is counted.
//!
//! The torque at the hip that keeps the torso upright is not passed to the bike, as in the paper.

use nalgebra::{Matrix2, Vector2};

use super::types::{Base, Forces};
use crate::GRAVITY;
use crate::contract::key_error::KeyError;
use crate::motorcycle::offroad::body::Body;

/// A limb in the posture of rest: natural length, m, and force, N, positive in compression.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limb {
    /// Length without force, m.
    pub natural: f64,
    /// Force at rest, N.
    pub force: f64,
    /// Length at rest, m.
    pub length: f64,
}

/// The rider, standing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Standing {
    body: Body,
    peg: [f64; 2],
    bar: [f64; 2],
    /// Limb between pegs and hip.
    pub leg: Limb,
    /// Limb between handlebar and shoulder.
    pub arm: Limb,
}

/// The chassis at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct Instant {
    /// Pitch, nose up, rad.
    pub mu: f64,
    /// Pitch rate, rad/s.
    pub mud: f64,
    /// Forward acceleration, m/s².
    pub xdd: f64,
    /// Downward acceleration, m/s².
    pub zdd: f64,
}

/// Forces of the limbs at one instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimbForces {
    /// Legs' compression force, N.
    pub leg: f64,
    /// Arms' compression force, N.
    pub arm: f64,
    /// Torque on the torso that keeps its attitude, N m.
    pub hip_torque: f64,
    /// On the bike, `[L_x, L_z, A_x, A_z]`, N.
    pub on_bike: [f64; 4],
}

/// Least stiffness of the standing posture that is accepted, 1/s²: 0.1 Hz.
const LEAST_STIFFNESS: f64 = 0.4;

/// Tangent of the lean of the legs at which the rider is off his feet: 45 degrees.
const TOPPLED: f64 = 1.0;

impl Standing {
    /// The natural lengths that hold the nominal posture, and whether it is stable.
    ///
    /// # Errors
    /// The limbs cannot carry the weight, or the preloaded leg topples over; the sentence names
    /// the keys.
    pub fn new(body: &Body, peg: [f64; 2], bar: [f64; 2]) -> Result<Self, KeyError> {
        for (key, value) in
            [("rider_mass", body.mass), ("leg_stiffness", body.k_l), ("arm_stiffness", body.k_a)]
        {
            if value.is_nan() || value <= 0.0 {
                return Err(KeyError::Values(format!(
                    "rider A needs `offroad.{key}` above zero, it is {value}"
                )));
            }
        }
        let standing = Self::at_rest(body, peg, bar)?;
        let least = standing.least_stiffness();
        if !least.is_finite() || least < LEAST_STIFFNESS {
            return Err(KeyError::Values(format!(
                "rider A cannot stand so: the least stiffness of the posture is {least:.1} 1/s2, \
                 the arms are too near to vertical to hold the legs; move `offroad.shoulder_x`, \
                 `offroad.rider_cg_x` or take rider b or c"
            )));
        }
        Ok(standing)
    }

    /// As [`Standing::new`] without the test of stability.
    ///
    /// # Errors
    /// The limbs cannot carry the weight.
    pub fn at_rest(body: &Body, peg: [f64; 2], bar: [f64; 2]) -> Result<Self, KeyError> {
        let from = |p: [f64; 2], joint: [f64; 2]| {
            Vector2::new(body.cg[0] + joint[0] - p[0], body.cg[1] + joint[1] - p[1])
        };
        let (leg, arm) = (from(peg, body.hip), from(bar, body.shoulder));
        let limbs = Matrix2::from_columns(&[leg.normalize(), arm.normalize()]);
        let forces = limbs
            .try_inverse()
            .filter(|i| i.iter().all(|v| v.is_finite() && v.abs() < 1e6))
            .map(|i| i * Vector2::new(0.0, -body.mass * GRAVITY))
            .ok_or(
                "rider A: arms and legs are parallel and cannot carry the weight; move \
                 `offroad.shoulder_x` or `offroad.rider_cg_x`",
            )?;
        let limb = |v: Vector2<f64>, force: f64, stiffness: f64| Limb {
            natural: v.norm() + force / stiffness,
            force,
            length: v.norm(),
        };
        Ok(Standing {
            body: *body,
            peg,
            bar,
            leg: limb(leg, forces[0], body.k_l),
            arm: limb(arm, forces[1], body.k_a),
        })
    }

    /// Smallest eigenvalue of the posture's stiffness per mass, 1/s².
    pub fn least_stiffness(&self) -> f64 {
        let stiffness = self.stiffness(0.0, [self.body.cg[0], self.body.cg[1]]);
        stiffness.symmetric_eigenvalues().min() / self.body.mass
    }

    /// Stiffness of both limbs against motion of the centre of mass, N/m.
    fn stiffness(&self, mu: f64, place: [f64; 2]) -> Matrix2<f64> {
        let limb = |point: [f64; 2], joint: [f64; 2], k: f64, natural: f64| {
            let p = turned(point, mu.sin_cos());
            let v = Vector2::new(place[0] + joint[0] - p[0], place[1] + joint[1] - p[1]);
            let (length, e) = (v.norm(), v.normalize());
            let along = e * e.transpose();
            along * k - (Matrix2::identity() - along) * (k * (natural - length) / length)
        };
        let b = &self.body;
        limb(self.peg, b.hip, b.k_l, self.leg.natural)
            + limb(self.bar, b.shoulder, b.k_a, self.arm.natural)
    }

    /// The state at rest on a chassis that pitches by `mu`: Newton on the two force balances.
    pub fn rest(&self, mu: f64) -> [f64; 4] {
        let p = turned(self.body.cg, mu.sin_cos());
        let mut place = [p[0], p[1]];
        for _ in 0..30 {
            let instant = Instant { mu, ..Instant::default() };
            let rate = self.rate(&[0.0, 0.0, place[0], place[1]], &instant, mu.sin_cos());
            let off = Vector2::new(rate[0], rate[1]) * self.body.mass;
            let Some(inverse) = self.stiffness(mu, place).try_inverse() else { break };
            let step = inverse * off;
            let short = 0.1 / step.norm().max(0.1);
            place[0] += short * step[0];
            place[1] += short * step[1];
            if step.norm() < 1e-13 {
                break;
            }
        }
        [0.0, 0.0, place[0], place[1]]
    }

    /// Limb forces from the relative state.
    #[inline]
    pub fn limb_forces(&self, y: &[f64; 4], mud: f64, (sin, cos): (f64, f64)) -> LimbForces {
        let b = &self.body;
        let limb = |point: [f64; 2], joint: [f64; 2], natural: f64, k: f64, c: f64| {
            let p = turned(point, (sin, cos));
            let (dx, dz) = (y[2] + joint[0] - p[0], y[3] + joint[1] - p[1]);
            let length = (dx * dx + dz * dz).sqrt();
            let (ex, ez) = (dx / length, dz / length);
            let rate = ex * (y[0] - mud * p[1]) + ez * (y[1] + mud * p[0]);
            let force = k * (natural - length) - c * rate;
            (force, force * ex, force * ez)
        };
        let (leg, lx, lz) = limb(self.peg, b.hip, self.leg.natural, b.k_l, b.c_l);
        let (arm, ax, az) = limb(self.bar, b.shoulder, self.arm.natural, b.k_a, b.c_a);
        let hip_torque = -(b.hip[1] * lx - b.hip[0] * lz + b.shoulder[1] * ax - b.shoulder[0] * az);
        LimbForces { leg, arm, hip_torque, on_bike: [-lx, -lz, -ax, -az] }
    }

    /// Rate of the relative state.
    #[inline]
    pub fn rate(&self, y: &[f64; 4], base: &Instant, pitch: (f64, f64)) -> [f64; 4] {
        let [lx, lz, ax, az] = self.limb_forces(y, base.mud, pitch).on_bike;
        let per_mass = -1.0 / self.body.mass;
        [per_mass * (lx + ax) - base.xdd, GRAVITY + per_mass * (lz + az) - base.zdd, y[0], y[1]]
    }

    /// Whether no rider could stand so: legs leaning by more than `TOPPLED` or folded to half. A
    /// passive limb goes on through that to postures on the other side of the bar.
    #[inline]
    pub fn toppled(&self, y: &[f64; 4], pitch: (f64, f64)) -> bool {
        let p = turned(self.peg, pitch);
        let (dx, dz) = (y[2] + self.body.hip[0] - p[0], y[3] + self.body.hip[1] - p[1]);
        // z is down: upright legs have dz < 0
        let upright = -dz > 0.5 * self.leg.natural && dx.abs() < TOPPLED * -dz;
        !upright
    }

    /// One step of Runge-Kutta from `from` over `mid` to `to`.
    #[inline]
    pub fn step(
        &self,
        y: &[f64; 4],
        dt: f64,
        from: Attitude,
        mid: Attitude,
        to: Attitude,
    ) -> [f64; 4] {
        let add = |k: &[f64; 4], h: f64| -> [f64; 4] { std::array::from_fn(|i| y[i] + h * k[i]) };
        let k1 = self.rate(y, &from.0, from.1);
        let k2 = self.rate(&add(&k1, 0.5 * dt), &mid.0, mid.1);
        let k3 = self.rate(&add(&k2, 0.5 * dt), &mid.0, mid.1);
        let k4 = self.rate(&add(&k3, dt), &to.0, to.1);
        std::array::from_fn(|i| y[i] + dt / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
    }
}

/// The chassis at an instant, with sine and cosine of its pitch.
pub(crate) type Attitude = (Instant, (f64, f64));

#[inline]
fn turned(p: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    [cos * p[0] + sin * p[1], cos * p[1] - sin * p[0]]
}

/// The forces over a session; each stretch of known motion starts at rest.
///
/// # Errors
/// As [`Standing::new`].
pub(crate) fn forces(
    body: &Body,
    peg: [f64; 2],
    bar: [f64; 2],
    base: &Base<'_>,
) -> Result<Forces, KeyError> {
    let standing = Standing::new(body, peg, bar)?;
    let n = base.mu.len();
    let mut out = Forces::zeros(n);
    let dt = 1.0 / base.rate;
    let motion = |i: usize| -> Instant {
        Instant { mu: base.mu[i], mud: base.mud[i], xdd: base.xdd[i], zdd: base.zdd[i] }
    };
    let known = |x: &Instant| (x.mu + x.mud + x.xdd + x.zdd).is_finite();
    let with = |x: Instant| (x, x.mu.sin_cos());
    let mut state: Option<[f64; 4]> = None;
    let mut from = (Instant::default(), (0.0, 1.0));
    for i in 0..n {
        let now = motion(i);
        if !known(&now) {
            state = None;
            for x in [&mut out.lx, &mut out.lz, &mut out.ax, &mut out.az] {
                x[i] = f64::NAN;
            }
            continue;
        }
        let to = with(now);
        let y = match state {
            None => standing.rest(now.mu),
            Some(y) => {
                let mid = with(between(&motion, i, n, &from.0, &now));
                let y = standing.step(&y, dt, from, mid, to);
                if standing.toppled(&y, to.1) {
                    out.toppled.push(i);
                    standing.rest(now.mu)
                } else {
                    y
                }
            }
        };
        let [lx, lz, ax, az] = standing.limb_forces(&y, now.mud, to.1).on_bike;
        (out.lx[i], out.lz[i], out.ax[i], out.az[i]) = (lx, lz, ax, az);
        state = Some(y);
        from = to;
    }
    Ok(out)
}

/// Half way between samples `i - 1` and `i`, by the cubic through four; by a line at the ends.
#[inline]
fn between(
    motion: &impl Fn(usize) -> Instant,
    i: usize,
    n: usize,
    a: &Instant,
    b: &Instant,
) -> Instant {
    let line = Instant {
        mu: 0.5 * (a.mu + b.mu),
        mud: 0.5 * (a.mud + b.mud),
        xdd: 0.5 * (a.xdd + b.xdd),
        zdd: 0.5 * (a.zdd + b.zdd),
    };
    if i < 2 || i + 1 >= n {
        return line;
    }
    let (before, after) = (motion(i - 2), motion(i + 1));
    let cubic = |m: f64, p: f64, q: f64| m + (2.0 * m - p - q) / 16.0;
    let out = Instant {
        mu: cubic(line.mu, before.mu, after.mu),
        mud: cubic(line.mud, before.mud, after.mud),
        xdd: cubic(line.xdd, before.xdd, after.xdd),
        zdd: cubic(line.zdd, before.zdd, after.zdd),
    };
    if (out.mu + out.mud + out.xdd + out.zdd).is_finite() { out } else { line }
}
