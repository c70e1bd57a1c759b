//! Drifts of the sensors, from what the residuals of the ride itself do over seconds.
//!
//! A fused velocity drifts by centimetres per second, an attitude by tenths of a degree. Such an
//! error is in every channel that uses the signal, and it bends estimates as no noise on the
//! residuals would (an error in a regressor); fault-free simulations must have it where it arises.
//!
//! ```text
//! kinematic_x = v' - ax - r vy     its integral over T is the drift of v:  D(T) = 2 sd² (1 - e^(-T/tau))
//! kinematic_y = ay - vy' - v r     the same of vy
//! roll        = ay - balance       g / cos²(phi) times that of roll
//! ```

use super::parameters::Parameters;
use super::residuals::Blocks;
use super::samples::{BLOCK, RATE, Samples};
use super::white_noise::white_noise;
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::residual_channel::ResidualChannel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::order::{SD_PER_MAD, upper_median};
use crate::statistics::random::{Coloured, Random};

/// Spans over which drift is looked at, s; the first is for the white noise.
const SPANS: [f64; 3] = [0.1, 0.8, 3.0];
/// Bounds of the correlation time, s.
const TIMES: [f64; 2] = [0.4, 8.0];

/// First-order drift of a signal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Drift {
    pub channel: Channel,
    /// Standard deviation, in the channel's unit.
    pub sd: f64,
    /// Correlation time, s.
    pub time: f64,
}

/// The drift of velocities and roll in the used manoeuvres; a signal of which nothing is known has
/// none.
pub(crate) fn drifts(
    session: &Session,
    segments: &[Segment],
    samples: &Samples,
    found: &Blocks,
    values: &Parameters,
) -> Vec<Drift> {
    let mut out = Vec::new();
    let get = |c: Channel| session.get(c);
    let dt = 1.0 / session.rate;
    let yaw_rate = get(Channel::YawRate);
    let turning = |i: usize| yaw_rate.map_or(0.0, |r| r[i] - values.sensors.yaw_rate_zero);
    if let (Some(v), Some(ax)) = (get(Channel::VelocityX), get(Channel::AccelerationX)) {
        let vy = get(Channel::VelocityY);
        let rate =
            |i: usize| ax[i] - values.sensors.ax_zero + turning(i) * vy.map_or(0.0, |y| y[i]);
        let walk = white_noise(ax).powi(2) * dt;
        out.extend(of_signal(v, rate, walk, session.rate, segments, Channel::VelocityX));
        if let (Some(vy), Some(ay)) = (vy, get(Channel::AccelerationY)) {
            let rate = |i: usize| ay[i] - values.sensors.ay_zero - turning(i) * v[i];
            let fast = 15.0; // m/s, a usual speed
            let turns = yaw_rate.map_or(0.0, white_noise) * fast;
            let walk = (white_noise(ay).powi(2) + turns * turns) * dt;
            out.extend(of_signal(vy, rate, walk, session.rate, segments, Channel::VelocityY));
        }
    }
    if let Some((sd, time)) = correlated(samples, &found[ResidualChannel::Roll as usize]) {
        out.push(Drift { channel: Channel::Roll, sd, time });
    }
    out
}

/// Adds drift to a session.
pub(crate) fn add(session: &mut Session, drifts: &[Drift], random: &mut Random) {
    let dt = 1.0 / session.rate;
    for error in drifts {
        let mut noise = Coloured::new(error.sd, error.time, dt, random);
        if let Some(x) = session.get_mut(error.channel) {
            x.iter_mut().for_each(|x| *x += noise.next(random));
        }
    }
}

/// How a signal drifts from the integral of its rate, whose own noise walks by `walk` per second.
fn of_signal(
    x: &[f64],
    rate: impl Fn(usize) -> f64,
    walk: f64,
    sampling: f64,
    segments: &[Segment],
    channel: Channel,
) -> Option<Drift> {
    let mut changes: [Vec<f64>; 3] = Default::default();
    let spans = SPANS.map(|s| (s * sampling) as usize);
    // in a corner each velocity's drift turns into the other's
    for segment in segments.iter().filter(|s| s.used && s.kind != ManoeuvreKind::Cornering) {
        let end = segment.end.min(x.len());
        let mut sum = 0.0;
        let off: Vec<f64> = (segment.start..end)
            .map(|i| {
                let off = x[i] - sum;
                sum += rate(i) / sampling;
                off
            })
            .collect();
        for (changes, span) in changes.iter_mut().zip(spans) {
            let step = (span / 4).max(1);
            let ahead = off.get(span..).unwrap_or_default().iter().zip(&off).step_by(step);
            changes.extend(ahead.map(|(b, a)| b - a).filter(|d| d.is_finite()));
        }
    }
    // a zero that is a little off drifts; only what differs from it is drift
    let [white, short, long] = changes.map(|changes| {
        let drift = median_of_ten(changes.clone())?;
        let squares = changes.iter().map(|d| (d - drift) * (d - drift)).collect();
        median_of_ten(squares).map(|m| m / MEDIAN_OF_SQUARE)
    });
    let beyond = |d: f64, span: f64| d - white.unwrap_or(0.0) - walk * (span - SPANS[0]);
    let (short, long) = (beyond(short?, SPANS[1]), beyond(long?, SPANS[2]));
    if short <= 0.0 || long <= 0.0 {
        return None;
    }
    // from 1 where all is forgotten at once to T2/T1 where nothing is
    let forgotten = |tau: f64, span: f64| (-SPANS[0] / tau).exp() - (-span / tau).exp();
    let time = solve(|tau| forgotten(tau, SPANS[2]) / forgotten(tau, SPANS[1]) - long / short);
    let sd = (0.5 * short / forgotten(time, SPANS[1])).sqrt();
    Some(Drift { channel, sd, time })
}

/// Spread and correlation time of the part of the roll residual that lasts, as roll.
fn correlated(samples: &Samples, residual: &[f64]) -> Option<(f64, f64)> {
    let in_roll = |b: usize| {
        let phi = samples.roll[b * BLOCK + BLOCK / 2];
        residual[b] * phi.cos().powi(2) / GRAVITY
    };
    let mut all: Vec<f64> = Vec::new();
    for (_, range) in &samples.manoeuvres {
        all.extend((range.start / BLOCK..range.end / BLOCK).map(in_roll));
    }
    all.retain(|r| r.is_finite());
    let middle = median_of_ten(all.clone())?;
    let limit = 4.0 * SD_PER_MAD * median_of_ten(all.iter().map(|r| (r - middle).abs()).collect())?;
    let clipped = |b: usize| in_roll(b).clamp(-limit, limit);
    let covariance = |lag: usize| {
        let (mut sum, mut n) = (0.0, 0);
        for (_, range) in &samples.manoeuvres {
            for b in range.start / BLOCK + lag..range.end / BLOCK {
                let product = clipped(b) * clipped(b - lag);
                if product.is_finite() {
                    sum += product;
                    n += 1;
                }
            }
        }
        (n > 20).then(|| sum / f64::from(n))
    };
    let (one, four) = (covariance(1)?, covariance(4)?);
    if one <= 0.0 {
        return None;
    }
    let step = BLOCK as f64 / RATE;
    let time = (3.0 * step / (one / four.max(0.05 * one)).ln().max(1e-3)).clamp(TIMES[0], TIMES[1]);
    Some(((one * (step / time).exp()).sqrt(), time))
}

/// Median of a squared standard normal.
const MEDIAN_OF_SQUARE: f64 = 0.4549;

/// The median, where there are enough values.
fn median_of_ten(mut x: Vec<f64>) -> Option<f64> {
    if x.len() < 10 {
        return None;
    }
    upper_median(&mut x)
}

/// The believed time at which a rising function of it is nil, by halving.
fn solve(f: impl Fn(f64) -> f64) -> f64 {
    let [mut low, mut high] = TIMES;
    for _ in 0..40 {
        let mid = 0.5 * (low + high);
        if f(mid) < 0.0 { low = mid } else { high = mid }
    }
    0.5 * (low + high)
}
