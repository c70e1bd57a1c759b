//! Every channel onto one uniform clock.
//!
//! A channel that is on the clock already is moved, one that only has holes is spread out;
//! the others are interpolated by a cubic through the neighbouring samples, which delays
//! nothing. A channel faster than the clock goes through a zero-phase low-pass first.

use rayon::prelude::*;

use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::session::{Meta, Session};
use crate::contract::warning::Warning;
use crate::ingest::clock::gaps;
use crate::ingest::clock::grid::{Grid, Interpolation, ON_CLOCK, between};
use crate::ingest::clock::{Clock, Clocked, Timed};
use crate::ingest::config::Config;
use crate::ingest::error::Error;
use crate::ingest::motion::low_pass::{CUT_OFF, low_passed};
use crate::ingest::warning::warning;
use crate::statistics::order::upper_median;

/// Fastest clock, Hz.
const MAX_RATE: f64 = 2000.0;
/// A rate so near to a whole number is that number.
const SNAP: f64 = 0.01;
/// Channels this much faster than the clock are low-passed.
const FASTER: f64 = 1.5;
/// Most samples of a session: as many as are read from one file.
const MAX_SAMPLES: f64 = 2e7;

/// Brings all channels onto the pipeline's rate, or the fastest channel's own.
///
/// # Errors
/// `too_short` when no channel has a sample left, `file_too_large` when the stamps span more
/// time than a ride can last.
pub(crate) fn onto_one_clock(
    meta: Meta,
    log: Clocked,
    config: &Config,
    warnings: &mut Vec<Warning>,
) -> Result<Session, Error> {
    if log.tracks.is_empty() {
        return Err(Error::new(RejectionCode::TooShort, "no channel has any sample"));
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
        return Err(Error::new(RejectionCode::FileTooLarge, message));
    }
    // a last stamp just short of a grid point still is that point
    let len = ((end - start) * rate + ON_CLOCK).floor() as usize + 1;
    let grid = Grid { start, rate, len };
    let mut session = Session::new(meta, rate, len);
    session.velocity_spacing = velocity_spacing(&log);
    let limit = |clock: &Clock| config.max_gap.max(1.5 * clock.period);
    let limits: Vec<(Channel, f64)> =
        log.tracks.iter().map(|t| (t.channel, limit(&log.clocks[t.clock]))).collect();
    let is_faster = |track: &Timed| {
        log.clocks[track.clock].period * rate * FASTER < 1.0
            && !matches!(track.channel, Channel::Gear | Channel::LapNumber)
    };
    let filtered: Vec<Channel> =
        log.tracks.iter().filter(|t| is_faster(t)).map(|t| t.channel).collect();
    let (faster, others): (Vec<Timed>, Vec<Timed>) = log.tracks.into_iter().partition(is_faster);
    for (i, clock) in log.clocks.iter().enumerate() {
        let own: Vec<&Timed> = faster.iter().filter(|t| t.clock == i).collect();
        let samples: Vec<&[f64]> = own.iter().map(|t| &t.values[..]).collect();
        let placed = low_passed(&clock.stamps, &samples, grid, limit(clock));
        own.iter().zip(placed).for_each(|(track, values)| session.set(track.channel, values));
    }
    drop(faster);
    let place = |track: Timed| {
        let clock = &log.clocks[track.clock];
        (track.channel, place(track, clock, grid, limit(clock)))
    };
    let placed: Vec<(Channel, Vec<f64>)> = others.into_par_iter().map(place).collect();
    placed.into_iter().for_each(|(channel, values)| session.set(channel, values));
    if !filtered.is_empty() {
        let names: Vec<&str> = filtered.iter().map(|c| c.name()).collect();
        let message = format!(
            "brought down to {rate} Hz after a low-pass at {:.1} Hz: {}",
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

/// Time between two samples of the forward velocity, s: the median; 0 without them.
fn velocity_spacing(log: &Clocked) -> f64 {
    let Some(track) = log.tracks.iter().find(|t| t.channel == Channel::VelocityX) else {
        return 0.0;
    };
    let stamps = log.clocks[track.clock].stamps.iter().zip(&track.values);
    let measured: Vec<f64> = stamps.filter(|(_, v)| v.is_finite()).map(|(t, _)| *t).collect();
    let mut steps: Vec<f64> = measured.windows(2).map(|w| w[1] - w[0]).collect();
    upper_median(&mut steps).unwrap_or(0.0)
}

/// One channel that is not faster than the grid on it; gaps up to `limit` (s, between samples) are bridged.
fn place(track: Timed, clock: &Clock, grid: Grid, limit: f64) -> Vec<f64> {
    let Timed { channel, mut values, .. } = track;
    let longest = (limit * grid.rate + 1e-6).floor() as usize;
    if on_clock(clock, grid) {
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
        gaps::bridge(&mut values, longest, Interpolation::of(channel));
        return values;
    }
    let (times, samples): (Vec<f64>, Vec<f64>) = clock
        .stamps
        .iter()
        .zip(&values)
        .filter(|(_, v)| v.is_finite())
        .map(|(t, v)| (*t, *v))
        .unzip();
    interpolated(&times, &samples, grid, limit, Interpolation::of(channel))
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
fn interpolated(
    times: &[f64],
    samples: &[f64],
    grid: Grid,
    limit: f64,
    kind: Interpolation,
) -> Vec<f64> {
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
        let out = interpolated(&times, &samples, grid(100.0, 51), 1.0, Interpolation::Cubic);
        for (j, y) in out.iter().enumerate().take(42).skip(10) {
            let t = j as f64 / 100.0;
            assert!((y - f(t)).abs() < 1e-12, "{t}: {y} not {}", f(t));
        }
    }

    #[test]
    fn gaps_beyond_the_limit_stay() {
        let times = [0.0, 0.1, 0.2, 0.8, 0.9, 1.0];
        let out = interpolated(&times, &[1.0; 6], grid(20.0, 21), 0.25, Interpolation::Cubic);
        let missing: Vec<usize> = (0..21).filter(|&j| out[j].is_nan()).collect();
        assert_eq!(missing, (5..16).collect::<Vec<_>>());
    }

    #[test]
    fn gear_stays_whole() {
        let out = interpolated(
            &[0.0, 0.13, 0.26],
            &[1.0, 2.0, 3.0],
            grid(50.0, 14),
            0.3,
            Interpolation::Nearest,
        );
        assert!(out.iter().all(|g| g.fract() == 0.0), "{out:?}");
    }
}
