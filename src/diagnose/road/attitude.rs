//! The part of the residuals that is trigonometry: how the bike lies and where its tyres point.
//!
//! It depends on few of the parameters: a linearisation in fifty makes it once and shares it among the
//! others. What it depends on is a [`Posture`]; attitudes see nothing else, so that parameters of equal
//! posture have equal attitudes.

use super::parameters::Parameters;
use super::samples::{RATE, Samples};
use crate::effects::ModelError;
use crate::model::formulation::Formulation::Corrected;
use crate::model::kinematics::{below_mass_centre, front_wheel, steering_rate};

/// Below this camber its tangent is itself, rad.
const SMALL: f64 = 1e-6;
/// Distance in relaxation lengths below which a lag forgets in proportion to it.
const SHORT: f64 = 1e-9;

/// How the bike lies at one sample. Pairs are front and rear.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)] // symbols of the residuals
pub struct Attitude {
    pub phi: f64,
    pub sin_phi: f64,
    pub cos_phi: f64,
    /// Roll against the road, its tangent.
    pub tan_road: f64,
    pub sin_d: f64,
    pub cos_d: f64,
    pub camber: [f64; 2],
    /// `1 - cos(camber)`.
    pub versine: [f64; 2],
    /// `tan(camber) / camber`.
    pub tangent: [f64; 2],
    pub r: f64,
    pub v: f64,
    pub vy: f64,
    /// Contact speeds along the wheels.
    pub rolling: [f64; 2],
    pub alpha: [f64; 2],
    /// `|tan(alpha)|`.
    pub drift: [f64; 2],
    /// How far the tyres' lag forgets until the next sample: `e^-x` and `(1 - e^-x)/x`.
    pub lag: [[f64; 2]; 2],
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
        Posture {
            mass: p.mass,
            cg_to_front: p.cg_to_front,
            wheelbase: p.wheelbase,
            cg_height: p.cg_height,
            caster: p.caster_angle.sin_cos(),
            yaw_rate_zero: p.yaw_rate_zero,
            vy_zero: p.vy_zero,
            velocity_height: p.velocity_height,
            sag: p.sag,
            normal_trail: p.normal_trail,
            crown: p.crown(),
            dive_arm: p.dive_arm,
            relaxation_length: p.relaxation_length,
            error: p.model_error.of_attitude(),
        }
    }
}

/// Sine and cosine of the front wheel's steering angle on the road, cambers, and their tangents and cosines.
struct Wheels {
    steer: (f64, f64),
    camber: [f64; 2],
    tan_camber: [f64; 2],
    cos_camber: [f64; 2],
}

impl Wheels {
    #[inline]
    fn of(s: &Samples, p: &Posture, i: usize, phi: f64, (sin_phi, cos_phi): (f64, f64)) -> Self {
        let wheel = front_wheel(p.error.steer(s.steer[i]), (sin_phi, cos_phi), p.caster, Corrected);
        let compliance = p.error.compliance(0.0);
        let to_rear = p.wheelbase - p.cg_to_front;
        let steer = match compliance == 0.0 {
            true => wheel.steer_sin_cos,
            false => {
                (wheel.steer - compliance * p.mass * s.ay[i] * to_rear / p.wheelbase).sin_cos()
            }
        };
        let level = [wheel.camber, phi];
        let known = [(wheel.camber_tan, wheel.camber_cos), (sin_phi / cos_phi, cos_phi)];
        let camber = level.map(|g| p.error.camber(g));
        let tan_cos = [0, 1].map(|k| match camber[k] == level[k] {
            true => known[k],
            false => (camber[k].tan(), camber[k].cos()),
        });
        let [tan_camber, cos_camber] = [tan_cos.map(|t| t.0), tan_cos.map(|t| t.1)];
        Wheels { steer, camber, tan_camber, cos_camber }
    }
}

impl Attitude {
    /// At sample `i`; straight runs need neither roll nor steering for their wheels' speeds.
    pub fn of(s: &Samples, p: &Posture, i: usize, cornering: bool) -> Self {
        let error = &p.error;
        let (h, lf, lr) = (p.cg_height, p.cg_to_front, p.wheelbase - p.cg_to_front);
        let v = error.velocity(s.v[i], s.vd_quiet[i]);
        let r = s.yaw_rate[i] - p.yaw_rate_zero;
        let phi = error.roll(s.roll[i]);
        let (sin_phi, cos_phi) = phi.sin_cos();
        let above = if cornering { p.velocity_height * cos_phi * s.rolld[i] } else { 0.0 };
        let vy = error.velocity_y(error.velocity(s.vy[i], s.vyd_quiet[i]) - p.vy_zero, r) + above;
        let Wheels { steer: (sin_d, cos_d), camber, tan_camber, cos_camber } =
            Wheels::of(s, p, i, phi, (sin_phi, cos_phi));
        let contact =
            [0, 1].map(|k| below_mass_centre(h, p.crown[k], p.sag[k], (sin_phi, cos_phi)));
        let falling = p.dive_arm.map(|arm| arm * s.dived[i]);
        let along = [0, 1].map(|k| v - falling[k] - r * contact[k][0]);
        let across = contact.map(|[_, per_rate]| vy + per_rate * s.rolld[i]);
        // a front wheel that is being steered goes aside behind its axis
        let rate = steering_rate(p.wheelbase, p.caster.1, cos_phi, s.rolld[i], v);
        let steered = if cornering { p.normal_trail * cos_phi * rate } else { 0.0 };
        let (across_f, across_r) = (across[0] + lf * r - steered, across[1] - lr * r);
        let ahead = along[0] * cos_d + across_f * sin_d;
        let aside = across_f * cos_d - along[0] * sin_d;
        let along = along[1];
        Attitude {
            phi,
            sin_phi,
            cos_phi,
            tan_road: tan_camber[1],
            sin_d,
            cos_d,
            camber,
            versine: cos_camber.map(|c| 1.0 - c),
            tangent: [0, 1].map(|k| {
                let small = camber[k].abs() < SMALL;
                if small { 1.0 } else { tan_camber[k] / camber[k] }
            }),
            r,
            v,
            vy,
            rolling: if cornering { [ahead, along] } else { falling.map(|f| v - f) },
            alpha: [aside.atan2(ahead), across_r.atan2(along)],
            drift: [(aside / ahead).abs(), (across_r / along).abs()],
            lag: p.relaxation_length.map(|length| {
                let x = s.v[i] / RATE / error.relaxation_length(length);
                let decay = (-x).exp();
                [decay, if x > SHORT { (1.0 - decay) / x } else { 1.0 }]
            }),
        }
    }
}
