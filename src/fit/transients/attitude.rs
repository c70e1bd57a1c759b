//! Slow errors of an inertial unit's attitude, as accelerations and velocities of the same ride show them.
//!
//! A unit turns its accelerations level by its own attitude. Where that drifts by milliradians, as the zeros of its gyros make
//! it, the accelerations carry a share of gravity that the velocities do not have:
//!
//! ```text
//! pitch_error =  mean(a_x - (v_x' - v_y psi')) / g        roll_error = -mean(a_y - (v_y' + v_x psi')) / g
//! ```
//!
//! with means over some seconds, over their mean of the whole ride: that is the sensors' zeros, which others know. What
//! turns in circles turns such an error with it, so it comes and goes with the lean and looks like slip: zeros of 0.5 mrad/s in a
//! filter of 20 s moved cornering stiffnesses by up to four standard deviations.

use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::estimate::samples::between;
use crate::estimate::zeros::Zeros;

/// Standard deviation of the Gaussian mean, s: satellite velocities are noisier over less, and errors turn within more.
const OVER: f64 = 1.5;
/// Rate at which the mean is taken, Hz.
const COARSE: f64 = 10.0;
/// Slowest samples that count, m/s.
const MOVING: f64 = 3.0;
/// Errors larger than this are no drift of an attitude, rad, root mean square.
const LARGEST: f64 = 0.03;
/// Velocities that come less often tell nothing within a second, s.
const SPARSE: f64 = 0.5;

/// The session with slow errors of pitch and roll taken off its attitude and its accelerations; `None` where nothing shows
/// them: without accelerations of a known zero and measured velocities.
pub(crate) fn corrected(session: &Session, zeros: &Zeros) -> Option<Session> {
    if !zeros.acceleration_known || session.velocity_spacing > SPARSE {
        return None;
    }
    let late = zeros.latency * session.rate;
    let velocity = session.get(Channel::VelocityX)?;
    // one that was estimated has these accelerations in it
    let drift = session.get(Channel::VelocityY).filter(|_| !session.has(Channel::VelocityYSd));
    let turn = session.get(Channel::YawRate)?;
    let rate = |x: &[f64], i: usize| {
        let at = i as f64 + late;
        0.5 * session.rate * (between(x, at + 1.0) - between(x, at - 1.0))
    };
    let moves = |i: usize| velocity[i] > MOVING;
    let mut out = session.clone();
    let mut is_corrected = false;
    let x = session.get(Channel::AccelerationX).filter(|_| session.has(Channel::Pitch));
    if let Some(x) = x {
        let aside = |i: usize| drift.map_or(0.0, |v| between(v, i as f64 + late) * turn[i]);
        let over = |i: usize| x[i] - rate(velocity, i) + aside(i);
        if let Some(error) = slow(session, |i| if moves(i) { over(i) } else { f64::NAN }) {
            add(&mut out, Channel::AccelerationX, -1.0, &error);
            add(&mut out, Channel::Pitch, -1.0 / GRAVITY, &error);
            is_corrected = true;
        }
    }
    if let (Some(y), Some(drift)) = (session.get(Channel::AccelerationY), drift) {
        let over = |i: usize| y[i] - rate(drift, i) - between(velocity, i as f64 + late) * turn[i];
        if let Some(error) = slow(session, |i| if moves(i) { over(i) } else { f64::NAN }) {
            add(&mut out, Channel::AccelerationY, -1.0, &error);
            add(&mut out, Channel::Roll, 1.0 / GRAVITY, &error);
            is_corrected = true;
        }
    }
    is_corrected.then_some(out)
}

/// Adds `scale` times a signal to a channel.
fn add(session: &mut Session, channel: Channel, scale: f64, signal: &[f64]) {
    if let Some(column) = session.get_mut(channel) {
        column.iter_mut().zip(signal).for_each(|(x, s)| *x += scale * s);
    }
}

/// Gaussian mean of a signal (m/s²) over its mean of the ride, sample by sample; what is NaN has no weight, and far from
/// everything else the mean is zero. `None` where it is too large.
fn slow(session: &Session, signal: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
    let step = ((session.rate / COARSE).round() as usize).max(1);
    let blocks = session.len.div_ceil(step);
    let mut sums = vec![[0.0; 2]; blocks];
    for i in 0..session.len {
        let value = signal(i);
        if value.is_finite() {
            sums[i / step][0] += value;
            sums[i / step][1] += 1.0;
        }
    }
    let total = sums.iter().fold([0.0; 2], |a, b| [a[0] + b[0], a[1] + b[1]]);
    if total[1] < 1.0 {
        return None;
    }
    let mean = total[0] / total[1];
    let over = OVER * session.rate / step as f64;
    let reach = (4.0 * over).ceil() as usize;
    let weights: Vec<f64> = (0..=reach).map(|k| (-0.5 * (k as f64 / over).powi(2)).exp()).collect();
    // a mean of next to nothing is noise
    let least = weights[0] * step as f64;
    let coarse: Vec<f64> = (0..blocks)
        .map(|i| {
            let mut sum = [0.0; 2];
            for j in i.saturating_sub(reach)..(i + reach + 1).min(blocks) {
                let weight = weights[i.abs_diff(j)];
                (0..2).for_each(|m| sum[m] += weight * sums[j][m]);
            }
            if sum[1] > least { sum[0] / sum[1] - mean } else { 0.0 }
        })
        .collect();
    let square: f64 = coarse.iter().map(|x| x * x).sum::<f64>() / blocks as f64;
    if square.sqrt() > LARGEST * GRAVITY {
        return None;
    }
    let centre = 0.5 * (step as f64 - 1.0);
    let at = |i: usize| {
        let place = ((i as f64 - centre) / step as f64).clamp(0.0, (blocks - 1) as f64);
        let left = place as usize;
        let right = (left + 1).min(blocks - 1);
        coarse[left] + (place - left as f64) * (coarse[right] - coarse[left])
    };
    Some((0..session.len).map(at).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    const RATE: f64 = 100.0;

    /// A ride in curves whose unit's pitch and roll are off by slow waves of 8 and 5 mrad.
    fn ride() -> (Session, Vec<f64>, Vec<f64>) {
        let n = 12_000;
        let t = |i: usize| i as f64 / RATE;
        let wave = |i: usize| [8e-3 * (t(i) / 3.0).sin(), 5e-3 * (t(i) / 2.5).cos()];
        let speed = |t: f64| 15.0 + 3.0 * (0.3 * t).sin();
        let aside = |t: f64| 0.3 * (0.8 * t).sin();
        let turn = |t: f64| 0.4 * (0.8 * t).sin();
        let mut session = Session::new(Meta::default(), RATE, n);
        let column = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
        let rate = |f: &dyn Fn(f64) -> f64, t: f64| (f(t + 1e-3) - f(t - 1e-3)) / 2e-3;
        let x = |i| rate(&speed, t(i)) - aside(t(i)) * turn(t(i)) + GRAVITY * wave(i)[0] + 0.05;
        let y = |i| rate(&aside, t(i)) + speed(t(i)) * turn(t(i)) - GRAVITY * wave(i)[1] - 0.03;
        session.set(Channel::VelocityX, column(&|i| speed(t(i))));
        session.set(Channel::VelocityY, column(&|i| aside(t(i))));
        session.set(Channel::YawRate, column(&|i| turn(t(i))));
        session.set(Channel::AccelerationX, column(&x));
        session.set(Channel::AccelerationY, column(&y));
        session.set(Channel::Pitch, column(&|i| 0.01 + wave(i)[0]));
        session.set(Channel::Roll, column(&|i| -0.3 * turn(t(i)) + wave(i)[1]));
        let pitch = column(&|_| 0.01);
        let roll = column(&|i| -0.3 * turn(t(i)));
        (session, pitch, roll)
    }

    fn zeros() -> Zeros {
        Zeros { acceleration_known: true, ..Zeros::default() }
    }

    fn spread(session: &Session, channel: Channel, truth: &[f64]) -> f64 {
        let x = session.get(channel).expect("there");
        let off: Vec<f64> = x.iter().zip(truth).map(|(a, b)| a - b).collect();
        let mean = off.iter().sum::<f64>() / off.len() as f64;
        (off.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / off.len() as f64).sqrt()
    }

    #[test]
    fn waves_of_the_attitude_are_taken_off() {
        let (session, pitch, roll) = ride();
        let out = corrected(&session, &zeros()).expect("all channels");
        for (channel, truth) in [(Channel::Pitch, &pitch), (Channel::Roll, &roll)] {
            let [before, after] = [&session, &out].map(|s| spread(s, channel, truth));
            assert!(before > 3e-3 && after < 0.2 * before, "{channel}: {before} {after}");
        }
    }

    #[test]
    fn what_does_not_show_it_leaves_the_session() {
        let (mut session, ..) = ride();
        assert!(corrected(&session, &Zeros::default()).is_none(), "no zero");
        let mut sparse = session.clone();
        sparse.velocity_spacing = 1.0;
        assert!(corrected(&sparse, &zeros()).is_none(), "once a second");
        // a lateral velocity that was made of these accelerations says nothing of them
        session.set(Channel::VelocityYSd, vec![0.05; session.len]);
        let out = corrected(&session, &zeros()).expect("pitch");
        assert_eq!(out.get(Channel::Roll), session.get(Channel::Roll));
        // a tenth of gravity is no drift
        let x = session.get_mut(Channel::AccelerationX).expect("there");
        x.iter_mut().enumerate().for_each(|(i, x)| *x += if i < 6000 { 2.0 } else { 0.0 });
        assert!(corrected(&session, &zeros()).is_none(), "too large");
    }
}
