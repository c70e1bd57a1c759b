//! The part of the residuals that is trigonometry: how the bike lies and where its tyres point.
//!
//! It depends on few of the parameters: a linearisation in fifty makes it once and shares it among the
//! others. What it depends on is a [`Posture`]; attitudes see nothing else, so that parameters of equal
//! posture have equal attitudes.

use super::parameters::Parameters;
use super::samples::Samples;
use crate::simulate::effects::ModelError;
use crate::tyre::formulation::Formulation::Corrected;
use crate::tyre::kinematics::{below_mass_centre, front_wheel, steering_rate};
use crate::tyre::pair::both;

/// Below this camber its tangent is itself, rad.
const SMALL: f64 = 1e-6;
/// Below this turn its arc tangent is a short series, rad.
const SLIGHT: f64 = 0.01;
/// Distance in relaxation lengths below which a lag forgets in proportion to it.
const SHORT: f64 = 1e-9;

/// How the bike lies at one sample. Pairs are front and rear.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // symbols of the residuals
pub struct Attitude {
    pub lean: Lean,
    pub r: f64,
    pub v: f64,
    pub vy: f64,
    /// Contact speeds along the wheels.
    pub rolling: [f64; 2],
    pub alpha: [f64; 2],
    /// `tan(alpha)`.
    pub drift: [f64; 2],
    /// How far the tyres' lag forgets until the next sample: `e^-x` and `(1 - e^-x)/x`.
    pub lag: [[f64; 2]; 2],
}

/// Quantities that follow from the angles of roll and handlebar.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // as above
pub struct Lean {
    pub phi: f64,
    pub sin_phi: f64,
    pub cos_phi: f64,
    /// Roll against the road, its tangent.
    pub tan_road: f64,
    /// Handlebar angle and its sine.
    pub handlebar: f64,
    pub sin_handlebar: f64,
    pub sin_d: f64,
    pub cos_d: f64,
    /// Cambers against the horizontal.
    level: [f64; 2],
    pub camber: [f64; 2],
    /// `1 - cos(camber)`.
    pub versine: [f64; 2],
    /// `tan(camber) / camber`.
    pub tangent: [f64; 2],
}

/// The numbers that attitudes depend on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Posture {
    mass: f64,
    cg_to_front: f64,
    wheelbase: f64,
    cg_height: f64,
    /// Sine and cosine of the caster angle.
    caster: (f64, f64),
    yaw_rate_zero: f64,
    vy_zero: f64,
    velocity_height: f64,
    sag: [f64; 2],
    normal_trail: f64,
    crown: [f64; 2],
    dive_arm: [f64; 2],
    relaxation_length: [f64; 2],
    /// Nil for the effects that do not declare themselves here.
    error: ModelError,
}

impl Posture {
    /// That of some parameters.
    pub fn of(p: &Parameters) -> Self {
        let (vehicle, sensors) = (&p.vehicle, &p.sensors);
        Posture {
            mass: vehicle.mass,
            cg_to_front: vehicle.cg_to_front,
            wheelbase: vehicle.wheelbase,
            cg_height: vehicle.cg_height,
            caster: vehicle.caster_angle.sin_cos(),
            yaw_rate_zero: sensors.yaw_rate_zero,
            vy_zero: sensors.vy_zero,
            velocity_height: sensors.velocity_height,
            sag: vehicle.sag,
            normal_trail: vehicle.normal_trail,
            crown: p.crown(),
            dive_arm: vehicle.dive_arm,
            relaxation_length: p.relaxation_length,
            error: p.model_error.of_attitude(),
        }
    }
}

impl Lean {
    #[inline]
    fn of(s: &Samples, p: &Posture, i: usize, phi: f64, handlebar: f64) -> Self {
        let (sin_phi, cos_phi) = phi.sin_cos();
        let wheel = front_wheel(handlebar, (sin_phi, cos_phi), p.caster, Corrected);
        let compliance = p.error.compliance(0.0);
        let to_rear = p.wheelbase - p.cg_to_front;
        let (sin_d, cos_d) = match compliance == 0.0 {
            true => wheel.steer_sin_cos,
            false => {
                (wheel.steer() - compliance * p.mass * s.ay[i] * to_rear / p.wheelbase).sin_cos()
            }
        };
        let level = [wheel.camber, phi];
        let known = [(wheel.camber_tan, wheel.camber_cos), (sin_phi / cos_phi, cos_phi)];
        let camber = both(|k| p.error.camber(level[k]));
        let tan_cos = both(|k| match camber[k] == level[k] {
            true => known[k],
            false => (camber[k].tan(), camber[k].cos()),
        });
        Lean {
            phi,
            sin_phi,
            cos_phi,
            tan_road: tan_cos[1].0,
            handlebar,
            sin_handlebar: wheel.handlebar_sin,
            sin_d,
            cos_d,
            level,
            camber,
            versine: both(|k| 1.0 - tan_cos[k].1),
            tangent: both(|k| {
                let small = camber[k].abs() < SMALL;
                if small { 1.0 } else { tan_cos[k].0 / camber[k] }
            }),
        }
    }
}

/// Parts of an attitude that are known from other parameters.
#[derive(Debug, Clone, Copy)]
pub struct ReusableTerms<'a> {
    attitude: &'a Attitude,
    /// Whether angles that are the same point the wheels the same way.
    steered: bool,
    /// Whether the tyres lag as much.
    lagged: bool,
}

impl<'a> ReusableTerms<'a> {
    /// Of an attitude in one posture for another.
    pub fn of(
        own: &Posture,
        other: &Posture,
    ) -> impl Fn(&'a Attitude) -> ReusableTerms<'a> + use<'a> {
        let compliant = |p: &Posture| p.error.compliance(0.0);
        let geometry = |p: &Posture| (p.caster, p.mass, p.cg_to_front, p.wheelbase);
        let steered = compliant(own) == compliant(other) && geometry(own) == geometry(other);
        let lagged = own.lengths() == other.lengths();
        move |attitude| ReusableTerms { attitude, steered, lagged }
    }

    /// The lean of the same angles, if these are known to be the same.
    #[inline]
    fn lean(&self, p: &Posture, phi: f64, handlebar: f64) -> Option<Lean> {
        let lean = &self.attitude.lean;
        let same = |a: f64, b: f64| a == b || a.is_nan() && b.is_nan();
        let is_same = self.steered && same(phi, lean.phi) && same(handlebar, lean.handlebar);
        let is_level = |k: usize| same(p.error.camber(lean.level[k]), lean.camber[k]);
        (is_same && is_level(0) && is_level(1)).then_some(*lean)
    }
}

impl Posture {
    fn lengths(&self) -> [f64; 2] {
        both(|k| self.error.relaxation_length(self.relaxation_length[k]))
    }
}

impl Attitude {
    /// At sample `i`; straight runs need neither roll nor steering for their wheels' speeds.
    pub fn of(s: &Samples, p: &Posture, i: usize, cornering: bool) -> Self {
        Self::near(s, p, i, cornering, None)
    }

    /// The same where another attitude at the sample is known.
    #[inline]
    pub fn near(
        s: &Samples,
        p: &Posture,
        i: usize,
        cornering: bool,
        known: Option<ReusableTerms<'_>>,
    ) -> Self {
        let error = &p.error;
        let (h, lf, lr) = (p.cg_height, p.cg_to_front, p.wheelbase - p.cg_to_front);
        let v = error.velocity(s.v[i], s.vd_quiet[i]);
        let r = s.yaw_rate[i] - p.yaw_rate_zero;
        let (phi, handlebar) = (error.roll(s.roll[i]), error.steer(s.steer[i]));
        let lean = known.and_then(|known| known.lean(p, phi, handlebar));
        let lean = lean.unwrap_or_else(|| Lean::of(s, p, i, phi, handlebar));
        let Lean { sin_phi, cos_phi, sin_d, cos_d, .. } = lean;
        let above = if cornering { p.velocity_height * cos_phi * s.rolld[i] } else { 0.0 };
        let vy = error.velocity_y(error.velocity(s.vy[i], s.vyd_quiet[i]) - p.vy_zero, r) + above;
        let contact = both(|k| below_mass_centre(h, p.crown[k], p.sag[k], (sin_phi, cos_phi)));
        let falling = both(|k| p.dive_arm[k] * s.dived[i]);
        let along = both(|k| v - falling[k] - r * contact[k][0]);
        let across = both(|k| vy + contact[k][1] * s.rolld[i]);
        // a front wheel that is being steered goes aside behind its axis
        let rate = steering_rate(p.wheelbase, p.caster.1, cos_phi, s.rolld[i], v);
        let steered = if cornering { p.normal_trail * cos_phi * rate } else { 0.0 };
        let (across_f, across_r) = (across[0] + lf * r - steered, across[1] - lr * r);
        let ahead = along[0] * cos_d + across_f * sin_d;
        let aside = across_f * cos_d - along[0] * sin_d;
        let along = along[1];
        let drift = [aside / ahead, across_r / along];
        let arc = |k: usize, aside: f64, ahead: f64| {
            match known {
                Some(known) => turned(known.attitude, k, drift[k]),
                None => None,
            }
            .unwrap_or_else(|| aside.atan2(ahead))
        };
        Attitude {
            lean,
            r,
            v,
            vy,
            rolling: if cornering { [ahead, along] } else { both(|k| v - falling[k]) },
            alpha: [arc(0, aside, ahead), arc(1, across_r, along)],
            drift,
            lag: match known {
                Some(known) if known.lagged => known.attitude.lag,
                _ => {
                    let lengths = p.lengths();
                    both(|k| {
                        let x = s.v[i] * s.step() / lengths[k];
                        let decay = (-x).exp();
                        [decay, if x > SHORT { (1.0 - decay) / x } else { 1.0 }]
                    })
                }
            },
        }
    }
}

/// Slip angle of wheel `k` whose tangent has changed a little.
#[inline]
fn turned(known: &Attitude, k: usize, drift: f64) -> Option<f64> {
    let u = (drift - known.drift[k]) / (1.0 + drift * known.drift[k]);
    let square = u * u;
    let arc = u * (1.0 - square * (1.0 / 3.0 - square * (0.2 - square / 7.0)));
    (u.abs() < SLIGHT).then(|| known.alpha[k] + arc)
}
