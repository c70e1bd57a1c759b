//! A session's manoeuvres at 10 Hz: smoothed signals and their derivatives, block by block.

use std::ops::Range;

use super::smooth::{gradient, smooth};
use crate::channel::Channel;
use crate::segment::{Kind, Segment};
use crate::session::Session;

/// Samples per second.
pub const RATE: f64 = 10.0;
/// Samples of a block: residuals are their means.
pub const BLOCK: usize = 3;
/// Left out at the start of every manoeuvre, s: what came before still acts.
const TRIM: f64 = 0.2;
/// Slower than this the slips say little, m/s.
const SLOWEST: f64 = 4.0;

/// What the residuals are made of, sample by sample, SI, ISO 8855; missing channels are NaN.
#[derive(Debug, Clone, Default)]
#[allow(missing_docs)] // a signal and, with `d`, its derivative by time
pub struct Samples {
    pub time: Vec<f64>,
    pub v: Vec<f64>,
    pub vd: Vec<f64>,
    pub vy: Vec<f64>,
    pub vyd: Vec<f64>,
    pub ax: Vec<f64>,
    pub ay: Vec<f64>,
    pub roll: Vec<f64>,
    pub rolld: Vec<f64>,
    pub yaw_rate: Vec<f64>,
    pub yaw_rated: Vec<f64>,
    pub steer: Vec<f64>,
    pub omega: [Vec<f64>; 2],
    pub omegad: [Vec<f64>; 2],
    pub pressure: [Vec<f64>; 2],
    /// Where along the strip, for what depends on heading: cosine of the heading against the
    /// session's first straight, NaN without heading.
    pub along: Vec<f64>,
    /// One per manoeuvre: its kind and its samples, whole blocks.
    pub manoeuvres: Vec<(Kind, Range<usize>)>,
}

/// Kinds that the base model describes.
const KINDS: [Kind; 6] = [
    Kind::Coasting,
    Kind::FrontBraking,
    Kind::RearBraking,
    Kind::CombinedBraking,
    Kind::Driving,
    Kind::Cornering,
];

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.time.is_empty()
    }

    /// Number of blocks.
    pub fn blocks(&self) -> usize {
        self.len() / BLOCK
    }

    /// The samples of the used manoeuvres of an unfiltered session.
    pub fn gather(session: &Session, segments: &[Segment]) -> Self {
        let rate = session.rate;
        let n = session.len;
        let missing = || vec![f64::NAN; n];
        let smoothed = |c: Channel| session.get(c).map_or_else(missing, |x| smooth(x, rate));
        let column = |c: Channel| {
            let x = smoothed(c);
            let d = gradient(&x, rate);
            (x, d)
        };
        let (v, vd) = column(Channel::VelocityX);
        let (vy, vyd) = column(Channel::VelocityY);
        let (roll, rolld) = column(Channel::Roll);
        let (yaw_rate, yaw_rated) = column(Channel::YawRate);
        let (omega_f, omegad_f) = column(Channel::WheelSpeedFront);
        let (omega_r, omegad_r) = column(Channel::WheelSpeedRear);
        let [ax, ay] = [Channel::AccelerationX, Channel::AccelerationY].map(smoothed);
        let steer = smoothed(Channel::SteerAngle);
        let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear].map(smoothed);
        let heading = session.get(Channel::Yaw);
        let mut out = Samples::default();
        let step = (rate / RATE).round().max(1.0) as usize;
        let mut axis: Option<f64> = None;
        for segment in segments.iter().filter(|s| s.used && KINDS.contains(&s.kind)) {
            let from = segment.start + (TRIM * rate) as usize;
            let usable = |i: &usize| v[*i] > SLOWEST && (ax[*i] + vd[*i]).is_finite();
            let chosen: Vec<usize> =
                (from..segment.end.min(n)).step_by(step).filter(usable).collect();
            let whole = chosen.len() / BLOCK * BLOCK;
            if whole == 0 {
                continue;
            }
            let start = out.len();
            for &i in &chosen[..whole] {
                let along = heading.map_or(f64::NAN, |yaw| {
                    let axis = *axis.get_or_insert(yaw[i]);
                    (yaw[i] - axis).cos()
                });
                out.time.push(i as f64 / rate);
                out.along.push(along);
                for (to, x) in [
                    (&mut out.v, &v),
                    (&mut out.vd, &vd),
                    (&mut out.vy, &vy),
                    (&mut out.vyd, &vyd),
                    (&mut out.ax, &ax),
                    (&mut out.ay, &ay),
                    (&mut out.roll, &roll),
                    (&mut out.rolld, &rolld),
                    (&mut out.yaw_rate, &yaw_rate),
                    (&mut out.yaw_rated, &yaw_rated),
                    (&mut out.steer, &steer),
                ] {
                    to.push(x[i]);
                }
                out.omega[0].push(omega_f[i]);
                out.omega[1].push(omega_r[i]);
                out.omegad[0].push(omegad_f[i]);
                out.omegad[1].push(omegad_r[i]);
                for k in 0..2 {
                    // sensors' noise below nothing is no braking
                    out.pressure[k].push(pressure[k][i].max(0.0));
                }
            }
            out.manoeuvres.push((segment.kind, start..out.len()));
        }
        out
    }
}
