//! Every channel onto one uniform clock.
//!
//! A channel that is on the clock already is moved, one that only has holes is spread out;
//! the others are interpolated by a cubic through the neighbouring samples, which delays
//! nothing. A channel faster than the clock goes through a zero-phase low-pass first.

use crate::channel::Channel;
use crate::ingest::clock::{Clock, Clocked, Timed};
use crate::ingest::{Config, Error, gaps, warning};
use crate::session::{Meta, Session};
use crate::warning::Warning;

/// Fastest clock, Hz.
const MAX_RATE: f64 = 2000.0;
/// A rate so near to a whole number is that number.
const SNAP: f64 = 0.01;
/// Largest distance from the clock that needs no interpolation, as a share of its period.
const ON_CLOCK: f64 = 0.02;
/// Channels this much faster than the clock are low-passed.
const FASTER: f64 = 1.5;
/// Half length of the low-pass, in periods of the clock.
const HALF_LENGTH: f64 = 4.0;
/// Its cut-off, as a share of the clock's rate.
const CUT_OFF: f64 = 0.45;
/// Most samples of a session: as many as are read from one file.
const MAX_SAMPLES: f64 = 2e7;

/// The common clock.
#[derive(Debug, Clone, Copy)]
struct Grid {
    start: f64,
    rate: f64,
    len: usize,
}

/// Brings all channels onto the pipeline's rate, or the fastest channel's own.
///
/// # Errors
/// `too_short` when no channel has a sample left, `file_too_large` when the stamps span more
/// time than a ride can last.
pub fn onto_one_clock(
    meta: Meta,
    log: Clocked,
    config: &Config,
    warnings: &mut Vec<Warning>,
) -> Result<Session, Error> {
    if log.tracks.is_empty() {
        return Err(Error::new("too_short", "no channel has any sample"));
    }
    let rate = if config.rate > 0.0 { config.rate } else { own_rate(&log) }.min(MAX_RATE);
    let (start, end) = log.span();
    let samples = ((end - start) * rate).round();
    if samples > MAX_SAMPLES {
        let message = format!(
            "the stamps span {:.0} s, {samples:.0} samples at {rate} Hz; is the unit of time \
             right?",
            end - start
        );
        return Err(Error::new("file_too_large", message));
    }
    // a last stamp just short of a grid point still is that point
    let len = ((end - start) * rate + ON_CLOCK).floor() as usize + 1;
    let grid = Grid { start, rate, len };
    let mut session = Session::new(meta, rate, len);
    let mut filtered = Vec::new();
    let mut limits = Vec::new();
    for track in log.tracks {
        let clock = &log.clocks[track.clock];
        let channel = track.channel;
        let limit = config.max_gap.max(1.5 * clock.period);
        if clock.period * rate * FASTER < 1.0 && channel != Channel::Gear {
            filtered.push(channel);
        }
        session.set(channel, place(track, clock, grid, limit));
        limits.push((channel, limit));
    }
    if !filtered.is_empty() {
        let names: Vec<&str> = filtered.iter().map(|c| c.name()).collect();
        let message = format!(
            "brought down to {rate} Hz behind a low-pass at {:.1} Hz: {}",
            CUT_OFF * rate,
            names.join(", ")
        );
        warnings.push(warning("down_sampled", None, filtered.len(), None, message));
    }
    gaps::report(&session, &limits, warnings);
    Ok(session)
}

/// Rate of the fastest clock that is not faster than the fastest of ours, a whole number if it
/// is near one, Hz.
fn own_rate(log: &Clocked) -> f64 {
    let periods = log.tracks.iter().map(|t| log.clocks[t.clock].period);
    let rate = (1.0 / periods.fold(f64::INFINITY, f64::min)).min(MAX_RATE);
    let whole = rate.round();
    if whole >= 1.0 && (rate - whole).abs() <= SNAP * rate { whole } else { rate }
}

/// One channel on the grid; gaps up to `limit` (s, between samples) are bridged.
fn place(track: Timed, clock: &Clock, grid: Grid, limit: f64) -> Vec<f64> {
    let Timed { channel, mut values, .. } = track;
    let faster = clock.period * grid.rate * FASTER < 1.0 && channel != Channel::Gear;
    let longest = (limit * grid.rate + 1e-6).floor() as usize;
    if !faster && on_clock(clock, grid) {
        let first = ((clock.stamps[0] - grid.start) * grid.rate).round() as usize;
        if !(clock.uniform && first == 0 && values.len() == grid.len) {
            let mut spread = vec![f64::NAN; grid.len];
            for (t, v) in clock.stamps.iter().zip(&values) {
                let at = ((t - grid.start) * grid.rate).round() as usize;
                if let Some(slot) = spread.get_mut(at) {
                    *slot = *v;
                }
            }
            values = spread;
        }
        gaps::bridge(&mut values, longest, kind(channel));
        return values;
    }
    let (times, samples): (Vec<f64>, Vec<f64>) = clock
        .stamps
        .iter()
        .zip(&values)
        .filter(|(_, v)| v.is_finite())
        .map(|(t, v)| (*t, *v))
        .unzip();
    if faster {
        low_passed(&times, &samples, grid, limit)
    } else {
        interpolated(&times, &samples, grid, limit, kind(channel))
    }
}

/// How a channel is read between its samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Kind {
    /// The nearest sample's: whole numbers.
    Nearest,
    /// A straight line: bounded quantities that step, where a cubic would overshoot.
    Linear,
    /// A cubic.
    Cubic,
}

fn kind(channel: Channel) -> Kind {
    match channel {
        Channel::Gear => Kind::Nearest,
        Channel::Throttle | Channel::BrakePressureFront | Channel::BrakePressureRear => {
            Kind::Linear
        }
        _ => Kind::Cubic,
    }
}

/// Whether every stamp is a point of the grid.
fn on_clock(clock: &Clock, grid: Grid) -> bool {
    let off = |t: f64| {
        let at = (t - grid.start) * grid.rate;
        (at - at.round()).abs()
    };
    if clock.uniform {
        let count = clock.stamps.len();
        let first = clock.stamps[0];
        // a slow drift does not show in a single step but at the end
        let same_pace = ((clock.period * grid.rate - 1.0) * count as f64).abs() <= ON_CLOCK;
        return same_pace && off(first) <= ON_CLOCK;
    }
    // two samples must not share a point
    let apart = clock.stamps.windows(2).all(|w| (w[1] - w[0]) * grid.rate > 0.5);
    apart && clock.stamps.iter().all(|t| off(*t) <= ON_CLOCK)
}

/// Interpolation between samples at most `limit` apart, NaN elsewhere.
fn interpolated(times: &[f64], samples: &[f64], grid: Grid, limit: f64, kind: Kind) -> Vec<f64> {
    let slack = ON_CLOCK / grid.rate;
    let mut out = vec![f64::NAN; grid.len];
    let mut right = 1;
    for (j, slot) in out.iter_mut().enumerate() {
        let t = grid.start + j as f64 / grid.rate;
        while right < times.len() && times[right] < t {
            right += 1;
        }
        if right >= times.len() {
            if let (Some(last), Some(v)) = (times.last(), samples.last())
                && (t - last).abs() <= slack
            {
                *slot = *v;
            }
            continue;
        }
        let left = right - 1;
        if (t - times[left]).abs() <= slack {
            *slot = samples[left];
        } else if (t - times[right]).abs() <= slack {
            *slot = samples[right];
        } else if t > times[left] && times[right] - times[left] <= limit {
            *slot = between(times, samples, left, t, limit, kind);
        }
    }
    out
}

/// Value at `t` between samples `left` and `left + 1`.
pub fn between(times: &[f64], samples: &[f64], left: usize, t: f64, limit: f64, kind: Kind) -> f64 {
    let (t0, t1) = (times[left], times[left + 1]);
    let (y0, y1) = (samples[left], samples[left + 1]);
    let step = t1 - t0;
    let u = (t - t0) / step;
    match kind {
        Kind::Nearest => return if u < 0.5 { y0 } else { y1 },
        Kind::Linear => return y0 + u * (y1 - y0),
        Kind::Cubic => {}
    }
    let secant = (y1 - y0) / step;
    // slope of the parabola through three samples; across a gap, of the straight line
    let slope = |near: usize, far: Option<usize>| {
        let Some(far) = far.filter(|&f| f < times.len()) else { return secant };
        let other = times[near] - times[far];
        if other.abs() > limit || !samples[far].is_finite() {
            return secant;
        }
        let outer = (samples[near] - samples[far]) / other;
        let other = other.abs();
        (secant * other + outer * step) / (step + other)
    };
    let m0 = slope(left, left.checked_sub(1)) * step;
    let m1 = slope(left + 1, Some(left + 2)) * step;
    let (u2, u3) = (u * u, u * u * u);
    (2.0 * u3 - 3.0 * u2 + 1.0) * y0
        + (u3 - 2.0 * u2 + u) * m0
        + (3.0 * u2 - 2.0 * u3) * y1
        + (u3 - u2) * m1
}

/// Weighted mean of the samples around each grid point: a windowed sinc, symmetric and so
/// without delay. NaN within a gap, and beyond the first and the last sample.
fn low_passed(times: &[f64], samples: &[f64], grid: Grid, limit: f64) -> Vec<f64> {
    let half = HALF_LENGTH / grid.rate;
    let slack = ON_CLOCK / grid.rate;
    let weight = |dt: f64| {
        let x = std::f64::consts::TAU * CUT_OFF * grid.rate * dt;
        let sinc = if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
        let window = (0.5 * std::f64::consts::PI * dt / half).cos();
        sinc * window * window
    };
    let mut out = vec![f64::NAN; grid.len];
    let (mut low, mut right) = (0, 0);
    for (j, slot) in out.iter_mut().enumerate() {
        let t = grid.start + j as f64 / grid.rate;
        while right < times.len() && times[right] < t - slack {
            right += 1;
        }
        while low < times.len() && times[low] <= t - half {
            low += 1;
        }
        let inside = right < times.len()
            && if right == 0 {
                times[0] <= t + slack
            } else {
                times[right] - times[right - 1] <= limit
            };
        if !inside {
            continue;
        }
        // on one side of a gap only
        let same_side = |a: usize, b: usize| times[b] - times[a] <= limit;
        let mut from = right;
        while from > low && same_side(from - 1, from) {
            from -= 1;
        }
        let (mut sum, mut weights) = (0.0, 0.0);
        for k in from..times.len() {
            if times[k] >= t + half || (k > from && !same_side(k - 1, k)) {
                break;
            }
            let w = weight(times[k] - t);
            sum += w * samples[k];
            weights += w;
        }
        *slot = sum / weights;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rate: f64, len: usize) -> Grid {
        Grid { start: 0.0, rate, len }
    }

    #[test]
    fn a_cubic_goes_through_a_parabola() {
        let times = [0.0, 0.1, 0.25, 0.3, 0.42, 0.5];
        let f = |t: f64| 3.0 - 2.0 * t + 5.0 * t * t;
        let samples = times.map(f);
        let out = interpolated(&times, &samples, grid(100.0, 51), 1.0, Kind::Cubic);
        for (j, y) in out.iter().enumerate().take(42).skip(10) {
            let t = j as f64 / 100.0;
            assert!((y - f(t)).abs() < 1e-12, "{t}: {y} not {}", f(t));
        }
    }

    #[test]
    fn gaps_beyond_the_limit_stay() {
        let times = [0.0, 0.1, 0.2, 0.8, 0.9, 1.0];
        let out = interpolated(&times, &[1.0; 6], grid(20.0, 21), 0.25, Kind::Cubic);
        let missing: Vec<usize> = (0..21).filter(|&j| out[j].is_nan()).collect();
        assert_eq!(missing, (5..16).collect::<Vec<_>>());
    }

    #[test]
    fn going_down_keeps_the_band_and_its_phase_and_stops_what_would_fold() {
        let fine: Vec<f64> = (0..4000).map(|i| f64::from(i) / 1000.0).collect();
        let wave = |f: f64| {
            let samples: Vec<f64> =
                fine.iter().map(|t| (std::f64::consts::TAU * f * t).sin()).collect();
            low_passed(&fine, &samples, grid(100.0, 400), 0.25)
        };
        let kept = wave(20.0);
        for (j, y) in kept.iter().enumerate().take(390).skip(10) {
            let truth = (std::f64::consts::TAU * 20.0 * j as f64 / 100.0).sin();
            assert!((y - truth).abs() < 0.02, "{j}: {y} not {truth}");
        }
        let stopped = wave(90.0);
        assert!(stopped[10..390].iter().all(|y| y.abs() < 0.03));
    }

    #[test]
    fn gear_stays_whole() {
        let out =
            interpolated(&[0.0, 0.13, 0.26], &[1.0, 2.0, 3.0], grid(50.0, 14), 0.3, Kind::Nearest);
        assert!(out.iter().all(|g| g.fract() == 0.0), "{out:?}");
    }
}
