//! A session's manoeuvres at 10 Hz: smoothed signals and their derivatives, block by block.

use std::ops::Range;

use super::around::Around;
use super::dive::{NOISY, beyond, usual_pitch};
use super::replay::bridged;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::ride::{Brakes, acting_pressure, along_strip, brake_history};
use crate::statistics::smooth::{gradient, mean_twice, smooth};

/// Samples per second.
pub(crate) const RATE: f64 = 10.0;
/// Samples of a block: residuals are their means.
pub(crate) const BLOCK: usize = 3;
/// Left out at the start of every manoeuvre, s: what came before still acts.
const TRIM: f64 = 0.2;
/// Slip ratio from which a wheel is on its way to lock or spin.
const DEEP: f64 = 0.15;
/// What is left out around it, s.
const AROUND: f64 = 0.2;
/// Slower than this the slips say little, m/s.
const SLOWEST: f64 = 4.0;

/// What the residuals are made of, sample by sample, SI, ISO 8855; missing channels are NaN.
#[derive(Debug, Clone, Default)]
#[allow(missing_docs)] // a signal and, with `d`, its derivative by time
pub struct Samples {
    /// Samples of a block.
    pub block: usize,
    pub time: Vec<f64>,
    pub v: Vec<f64>,
    pub vd: Vec<f64>,
    /// With little of the sensor's noise, as `vdd`: what a delay is multiplied by. More noise in it than in the velocity
    /// would make every delay small.
    pub vd_quiet: Vec<f64>,
    pub vdd: Vec<f64>,
    pub vy: Vec<f64>,
    pub vyd: Vec<f64>,
    pub vyd_quiet: Vec<f64>,
    pub vydd: Vec<f64>,
    pub ax: Vec<f64>,
    pub ay: Vec<f64>,
    pub roll: Vec<f64>,
    pub rolld: Vec<f64>,
    pub rolldd: Vec<f64>,
    pub yaw_rate: Vec<f64>,
    pub yaw_rated: Vec<f64>,
    pub steer: Vec<f64>,
    pub omega: [Vec<f64>; 2],
    pub omegad: [Vec<f64>; 2],
    pub pressure: [Vec<f64>; 2],
    /// Where along the strip, for what depends on heading: cosine of the heading against the
    /// session's first straight, NaN without heading.
    pub along: Vec<f64>,
    /// Grade of the road, uphill positive; 0 where nothing shows it.
    pub grade: Vec<f64>,
    /// Pitch beyond the usual one, rad ([`dive`]).
    pub dive: Vec<f64>,
    pub dived: Vec<f64>,
    pub divedd: Vec<f64>,
    /// Heat in the brakes.
    pub brakes: Vec<Brakes>,
    /// One per manoeuvre: its kind and its samples, whole blocks.
    pub manoeuvres: Vec<(ManoeuvreKind, Range<usize>)>,
}

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
        self.len() / self.block
    }

    /// Time from a sample of a manoeuvre to the next, s.
    pub fn step(&self) -> f64 {
        (BLOCK / self.block) as f64 / RATE
    }

    /// The means of every block as a sample. Residuals of them are block means of residuals but for what bends within
    /// a block: near enough for slopes, at a third of the work.
    pub fn means(&self) -> Samples {
        let n = self.block as f64;
        let of = |x: &Vec<f64>| -> Vec<f64> {
            x.chunks_exact(self.block).map(|block| block.iter().sum::<f64>() / n).collect()
        };
        let both = |x: &[Vec<f64>; 2]| [of(&x[0]), of(&x[1])];
        let block = |i: usize| i / self.block;
        let ranges = self.manoeuvres.iter();
        Samples {
            block: 1,
            time: of(&self.time),
            v: of(&self.v),
            vd: of(&self.vd),
            vd_quiet: of(&self.vd_quiet),
            vdd: of(&self.vdd),
            vy: of(&self.vy),
            vyd: of(&self.vyd),
            vyd_quiet: of(&self.vyd_quiet),
            vydd: of(&self.vydd),
            ax: of(&self.ax),
            ay: of(&self.ay),
            roll: of(&self.roll),
            rolld: of(&self.rolld),
            rolldd: of(&self.rolldd),
            yaw_rate: of(&self.yaw_rate),
            yaw_rated: of(&self.yaw_rated),
            steer: of(&self.steer),
            omega: both(&self.omega),
            omegad: both(&self.omegad),
            pressure: both(&self.pressure),
            along: of(&self.along),
            grade: of(&self.grade),
            dive: of(&self.dive),
            dived: of(&self.dived),
            divedd: of(&self.divedd),
            // heat that begins anew within a block has no mean
            brakes: self.brakes.chunks_exact(self.block).map(|b| b[self.block / 2]).collect(),
            manoeuvres: ranges.map(|(kind, r)| (*kind, block(r.start)..block(r.end))).collect(),
        }
    }

    /// The samples of the used manoeuvres of an unfiltered session.
    pub fn gather(session: &Session, segments: &[Segment]) -> Self {
        Self::take(session, &picks(session, segments))
    }

    /// Picked samples of a session.
    pub fn take(session: &Session, picks: &[(ManoeuvreKind, Vec<usize>)]) -> Self {
        let rate = session.rate;
        let around = Around::of(session, picks);
        let near = &around.session;
        let n = near.len;
        let missing = || vec![f64::NAN; n];
        let smoothed = |c: Channel| near.get(c).map_or_else(missing, |x| smooth(x, rate));
        let column = |c: Channel| {
            let x = smoothed(c);
            let d = gradient(&x, rate);
            (x, d)
        };
        let (v, vd) = column(Channel::VelocityX);
        let (vy, vyd) = column(Channel::VelocityY);
        let (roll, rolld) = column(Channel::Roll);
        let rolldd = gradient(&smooth(&rolld, rate), rate);
        let quiet = |d: &[f64]| mean_twice(&bridged(d.to_vec()), rate, NOISY);
        let [vd_quiet, vyd_quiet] = [&vd, &vyd].map(|d| quiet(d));
        let [vdd, vydd] = [&vd_quiet, &vyd_quiet].map(|d| gradient(d, rate));
        let (yaw_rate, yaw_rated) = column(Channel::YawRate);
        let (omega_f, omegad_f) = column(Channel::WheelSpeedFront);
        let (omega_r, omegad_r) = column(Channel::WheelSpeedRear);
        let [ax, ay] = [Channel::AccelerationX, Channel::AccelerationY].map(smoothed);
        let steer = smoothed(Channel::SteerAngle);
        let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear]
            .map(|c| acting_pressure(&smoothed(c), rate));
        let grade = near.get(Channel::Grade);
        // what depends on the whole ride
        let brakes = around.only(brake_history(session), Brakes::default());
        let along = around.only(along_strip(session).into_iter(), f64::NAN);
        let usual = usual_pitch(session);
        let dive =
            usual.map_or_else(|| vec![0.0; n], |usual| beyond(&smoothed(Channel::Pitch), usual));
        let dived = gradient(&mean_twice(&dive, rate, NOISY), rate);
        let divedd = gradient(&dived, rate);
        let mut out = Samples { block: BLOCK, ..Samples::default() };
        for (kind, chosen) in picks {
            let start = out.len();
            for &picked in chosen {
                out.time.push(picked as f64 / rate);
                let i = around.position(picked);
                out.along.push(along[i]);
                out.grade.push(grade.map_or(0.0, |x| x[i]));
                out.dive.push(dive[i]);
                out.dived.push(dived[i]);
                out.divedd.push(divedd[i]);
                out.brakes.push(brakes[i]);
                for (to, x) in [
                    (&mut out.v, &v),
                    (&mut out.vd, &vd),
                    (&mut out.vd_quiet, &vd_quiet),
                    (&mut out.vdd, &vdd),
                    (&mut out.vy, &vy),
                    (&mut out.vyd, &vyd),
                    (&mut out.vyd_quiet, &vyd_quiet),
                    (&mut out.vydd, &vydd),
                    (&mut out.ax, &ax),
                    (&mut out.ay, &ay),
                    (&mut out.roll, &roll),
                    (&mut out.rolld, &rolld),
                    (&mut out.rolldd, &rolldd),
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
                    out.pressure[k].push(pressure[k][i]);
                }
            }
            out.manoeuvres.push((*kind, start..out.len()));
        }
        out
    }
}

/// Which samples of a session are looked at: per manoeuvre, whole blocks of them.
pub fn picks(session: &Session, segments: &[Segment]) -> Vec<(ManoeuvreKind, Vec<usize>)> {
    let rate = session.rate;
    let smoothed = |c: Channel| session.get(c).map(|x| smooth(x, rate));
    let (Some(v), Some(ax)) = (smoothed(Channel::VelocityX), smoothed(Channel::AccelerationX))
    else {
        return Vec::new();
    };
    let vd = gradient(&v, rate);
    let deep = deep(session, &v);
    let step = (rate / RATE).round().max(1.0) as usize;
    let usable = |i: &usize| v[*i] > SLOWEST && (ax[*i] + vd[*i]).is_finite() && !deep[*i];
    segments
        .iter()
        .filter(|s| s.used && s.kind.is_on_road())
        .map(|segment| {
            let from = segment.start + (TRIM * rate) as usize;
            let mut chosen: Vec<usize> =
                (from..segment.end.min(session.len)).step_by(step).filter(usable).collect();
            chosen.truncate(chosen.len() / BLOCK * BLOCK);
            (segment.kind, chosen)
        })
        .filter(|(_, chosen)| !chosen.is_empty())
        .collect()
}

/// Where a wheel is about to lock or to spin, and shortly before and after: slip changes within the
/// smoother's window, and no block mean is what it was.
fn deep(session: &Session, v: &[f64]) -> Vec<bool> {
    let mut deep = vec![false; session.len];
    let reach = (AROUND * session.rate) as usize;
    for channel in [Channel::WheelSpeedFront, Channel::WheelSpeedRear] {
        let Some(omega) = session.get(channel) else { continue };
        let ratio = |i: usize| omega[i] / v[i];
        let mut rolling: Vec<f64> = (0..session.len)
            .filter(|&i| v[i] > SLOWEST)
            .map(ratio)
            .filter(|r| r.is_finite())
            .collect();
        if rolling.is_empty() {
            continue;
        }
        let middle = rolling.len() / 2;
        let usual = *rolling.select_nth_unstable_by(middle, f64::total_cmp).1;
        for i in 0..session.len {
            if v[i] > SLOWEST && (ratio(i) / usual - 1.0).abs() > DEEP {
                deep[i.saturating_sub(reach)..(i + reach + 1).min(session.len)].fill(true);
            }
        }
    }
    deep
}
