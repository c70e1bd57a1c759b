//! The part of the residuals that is trigonometry: how the bike lies and where its tyres point.
//!
//! It hangs on few numbers of a world; a linearisation in fifty makes it once and shares it among the
//! others.

use super::parameters::Parameters;
use super::samples::{RATE, Samples};
use crate::model::formulation::Formulation::Corrected;
use crate::model::kinematics::front_wheel;

/// How the bike lies at one sample. Pairs are front and rear.
#[derive(Debug, Clone, Copy)]
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

/// What attitudes hang on.
pub fn key(w: &Parameters) -> [f64; 11] {
    let d = &w.departure;
    [
        d.roll_zero,
        d.steer_zero,
        d.bank,
        d.compliance,
        d.latency,
        d.lever_arm,
        d.relaxation,
        w.yaw_rate_zero,
        w.vy_zero,
        w.relaxation_length[0],
        w.relaxation_length[1],
    ]
}

impl Attitude {
    /// At sample `i`, of the caster angle its sine and cosine; straight runs need neither roll nor
    /// steering for their wheels' speeds.
    pub fn of(s: &Samples, w: &Parameters, caster: (f64, f64), i: usize, cornering: bool) -> Self {
        let d = &w.departure;
        let (h, l) = (w.cg_height, w.wheelbase);
        let (lf, lr) = (w.cg_to_front, l - w.cg_to_front);
        let v = s.v[i] + d.latency * s.vd[i];
        let r = s.yaw_rate[i] - w.yaw_rate_zero;
        let vy = s.vy[i] + d.latency * s.vyd[i] - w.vy_zero - d.lever_arm * r;
        let phi = s.roll[i] + d.roll_zero;
        let (sin_phi, cos_phi) = phi.sin_cos();
        let steer = s.steer[i] + d.steer_zero;
        let wheel = front_wheel(steer, (sin_phi, cos_phi), caster, Corrected);
        let (sin_d, cos_d) = match d.compliance == 0.0 {
            true => wheel.steer_sin_cos,
            false => (wheel.steer - d.compliance * w.mass * s.ay[i] * lr / l).sin_cos(),
        };
        let camber = [wheel.camber, phi].map(|g| g - d.bank);
        let (tan_camber, cos_camber) = match d.bank == 0.0 {
            true => ([wheel.camber_tan, sin_phi / cos_phi], [wheel.camber_cos, cos_phi]),
            false => (camber.map(f64::tan), camber.map(f64::cos)),
        };
        let along = v - r * h * sin_phi;
        let across = vy + h * cos_phi * s.rolld[i];
        let (across_f, across_r) = (across + lf * r, across - lr * r);
        let (ahead, aside) = (along * cos_d + across_f * sin_d, across_f * cos_d - along * sin_d);
        let lag = [0, 1].map(|k| {
            let length = (w.relaxation_length[k] + d.relaxation).max(0.02);
            let x = s.v[i] / RATE / length;
            let decay = (-x).exp();
            [decay, if x > 1e-9 { (1.0 - decay) / x } else { 1.0 }]
        });
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
                let small = camber[k].abs() < 1e-6;
                if small { 1.0 } else { tan_camber[k] / camber[k] }
            }),
            r,
            v,
            vy,
            rolling: if cornering { [ahead, along] } else { [v, v] },
            alpha: [aside.atan2(ahead), across_r.atan2(along)],
            drift: [(aside / ahead).abs(), (across_r / along).abs()],
            lag,
        }
    }
}
