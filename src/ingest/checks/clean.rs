//! Samples that no sensor can have meant: out of range, spikes, clipped, stuck.
//!
//! What is found becomes NaN, and a warning says so. All tests are conservative: a doubtful
//! sample stays, the robust fits tolerate it.

use super::{frozen, zero_speed};
use crate::contract::schema;
use rayon::prelude::*;

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::clock::{Clock, Clocked, Timed};
use crate::ingest::config::Config;
use crate::ingest::warning::warning;
use crate::statistics::order::{SD_PER_MAD, upper_median};

use crate::statistics::angles::unwrap;
use Channel::*;

/// Share of samples out of range that is still taken for glitches, not for a wrong unit.
const RARE: f64 = 0.01;
/// Slower than this the bike is not moving, m/s.
const MOVING: f64 = 2.0;
/// Least samples of a run at the extreme, and least runs, to be called clipped.
const CLIPPED: (usize, usize) = (5, 3);
/// Least samples of a stuck run.
const STUCK: usize = 10;
/// A stuck run ends with a jump of so many usual changes.
const STUCK_JUMP: f64 = 5.0;

/// Inertial channels: they have limits of their own that a ride can exceed.
const CAN_CLIP: &[Channel] = &[
    AccelerationX,
    AccelerationY,
    RollRate,
    PitchRate,
    YawRate,
    ChassisAccelerationZ,
    HeadAccelerationZ,
    TailAccelerationZ,
    ForkTopAcceleration,
    ForkBottomAcceleration,
    ShockTopAcceleration,
    ShockBottomAcceleration,
];

/// Channels that change all the time while the bike moves.
const CAN_STICK: &[Channel] = &[
    VelocityX,
    VelocityY,
    AccelerationX,
    AccelerationY,
    Roll,
    Pitch,
    Yaw,
    RollRate,
    PitchRate,
    YawRate,
    SteerAngle,
    WheelSpeedFront,
    WheelSpeedRear,
    ChassisAccelerationZ,
    HeadAccelerationZ,
    TailAccelerationZ,
    ForkTravel,
    ShockTravel,
    ForkTopAcceleration,
    ForkBottomAcceleration,
    ShockTopAcceleration,
    ShockBottomAcceleration,
];

/// Channels of hands, feet and bumps, which may come and go within [`SHORTEST`].
const QUICK: &[Channel] = &[
    Throttle,
    BrakePressureFront,
    BrakePressureRear,
    AccelerationX,
    AccelerationY,
    PitchRate,
    SteerAngle,
    ChassisAccelerationZ,
    HeadAccelerationZ,
    TailAccelerationZ,
    ForkTravel,
    ShockTravel,
    ForkTopAcceleration,
    ForkBottomAcceleration,
    ShockTopAcceleration,
    ShockBottomAcceleration,
];
/// Shortest that such a channel does something, s: a dab of a brake, a bump. A single sample that stands out is a
/// fault only where it would be shorter than that, from one neighbour to the other.
const SHORTEST: f64 = 0.1;

/// Cleans every channel, and takes out those with nothing in them.
pub(crate) fn clean(log: &mut Clocked, config: &Config, warnings: &mut Vec<Warning>) {
    let table = schema::session();
    let moving = moving_times(log);
    let start = log.span().0;
    let Clocked { clocks, tracks } = log;
    let look = |track: &mut Timed| {
        let range = table.column(track.channel.name()).and_then(|c| c.range);
        let Clock { stamps, period, .. } = &clocks[track.clock];
        let (period, warnings) = (*period, Vec::new());
        let mut job = Job { track, stamps, period, start, moving: moving.as_deref(), warnings };
        let anything = job.run(range, config);
        (anything, job.warnings)
    };
    let found: Vec<(bool, Vec<Warning>)> = tracks.par_iter_mut().map(look).collect();
    let (keep, said): (Vec<bool>, Vec<Vec<Warning>>) = found.into_iter().unzip();
    warnings.extend(said.into_iter().flatten());
    let mut keep = keep.into_iter();
    tracks.retain(|_| keep.next() == Some(true));
    zero_speed::take_out(log, warnings);
    if config.stuck_time > 0.0 {
        frozen::take_out(log, config.stuck_time, warnings);
    }
}

/// One channel under examination.
struct Job<'a> {
    track: &'a mut Timed,
    stamps: &'a [f64],
    /// Usual distance between its samples, s.
    period: f64,
    start: f64,
    moving: Option<&'a [(f64, f64)]>,
    warnings: Vec<Warning>,
}

#[derive(Clone, Copy)]
struct Extent {
    low: f64,
    high: f64,
    count: usize,
}

impl Extent {
    /// In lanes, which the compiler can do side by side: this pass is over every sample.
    fn of(values: &[f64]) -> Self {
        const LANES: usize = 8;
        let (mut low, mut high) = ([f64::INFINITY; LANES], [f64::NEG_INFINITY; LANES]);
        let mut missing = [0_u64; LANES];
        let (chunks, rest) = values.as_chunks::<LANES>();
        let mut lane = |k: usize, v: f64| {
            low[k] = if v < low[k] { v } else { low[k] };
            high[k] = if v > high[k] { v } else { high[k] };
            missing[k] += u64::from(v.is_nan());
        };
        for chunk in chunks {
            for (k, &v) in chunk.iter().enumerate() {
                lane(k, v);
            }
        }
        rest.iter().for_each(|&v| lane(0, v));
        Extent {
            low: low.into_iter().fold(f64::INFINITY, f64::min),
            high: high.into_iter().fold(f64::NEG_INFINITY, f64::max),
            count: values.len() - missing.iter().sum::<u64>() as usize,
        }
    }
}

impl Job<'_> {
    /// All tests; whether anything is left.
    fn run(&mut self, range: Option<[f64; 2]>, config: &Config) -> bool {
        if self.track.channel == Yaw {
            unwrap(&mut self.track.values);
        }
        let Some(mut extent) = self.extent() else { return false };
        let mut changed = false;
        if let Some([low, high]) = range
            && (extent.low < low || extent.high > high)
        {
            changed |= self.out_of_range(low, high, extent.count);
        }
        if config.spike_threshold > 0.0
            && !matches!(self.track.channel, Gear | LapNumber)
            && !self.may_dab()
        {
            changed |= self.spikes(config.spike_threshold);
        }
        if CAN_CLIP.contains(&self.track.channel) {
            if changed {
                let Some(left) = self.extent() else { return false };
                extent = left;
            }
            changed |= self.clipped(extent);
        }
        if config.stuck_time > 0.0 && CAN_STICK.contains(&self.track.channel) {
            changed |= self.stuck(config.stuck_time);
        }
        !changed || self.track.values.iter().any(|v| v.is_finite()) || self.extent().is_some()
    }

    /// Whether a single sample that stands out may be real.
    fn may_dab(&self) -> bool {
        QUICK.contains(&self.track.channel) && 2.0 * self.period >= SHORTEST
    }

    fn warn(&mut self, code: &'static str, count: usize, at: usize, message: String) {
        let time = Some(self.stamps[at] - self.start);
        let channel = self.track.channel;
        let message = format!("{channel}: {message}");
        self.warnings.push(warning(code, Some(channel), count, time, message));
    }

    /// Smallest, largest and number of the finite samples; `None` and a warning if none is.
    fn extent(&mut self) -> Option<Extent> {
        let e = Extent::of(&self.track.values);
        if e.count == 0 {
            let n = self.track.values.len();
            self.warn("empty_channel", n, 0, "has no sample at all, left out".into());
            return None;
        }
        Some(e)
    }

    fn out_of_range(&mut self, low: f64, high: f64, present: usize) -> bool {
        let outside = |v: f64| v < low || v > high;
        let found = self.track.values.iter().filter(|v| outside(**v)).count();
        let Some(first) = self.track.values.iter().position(|v| outside(*v)) else {
            return false;
        };
        let value = self.track.values[first];
        let much = found as f64 > RARE * present as f64;
        let message = format!(
            "{found} of {present} samples are out of the physical range {low} to {high}, the \
             first is {value:.4}; {}",
            if much { "too many for glitches: is the unit right?" } else { "taken as missing" }
        );
        self.warn("out_of_range", found, first, message);
        if !much {
            for v in self.track.values.iter_mut().filter(|v| outside(**v)) {
                *v = f64::NAN;
            }
        }
        !much
    }

    /// Single samples far off both neighbours, which agree with each other, where the signal
    /// is otherwise quiet.
    fn spikes(&mut self, threshold: f64) -> bool {
        let x = &mut self.track.values;
        let Some(least) = least_jump(x, threshold) else { return false };
        let (mut count, mut first) = (0, 0);
        let suspects = peaks(x, least);
        for i in suspects {
            let (a, b) = (x[i] - x[i - 1], x[i] - x[i + 1]);
            let jump = a.abs().min(b.abs());
            let Some(around) = change_around(x, i) else { continue };
            if jump > 0.5 * threshold * around && (x[i + 1] - x[i - 1]).abs() < 0.3 * jump {
                if count == 0 {
                    first = i;
                }
                count += 1;
                x[i] = f64::NAN;
            }
        }
        if count > 0 {
            let message = format!("{count} single samples stand out as spikes, taken as missing");
            self.warn("spike", count, first, message);
        }
        count > 0
    }

    /// Plateaus at the channel's own extreme where a peak ought to be.
    fn clipped(&mut self, Extent { low, high, .. }: Extent) -> bool {
        if high <= low {
            return false;
        }
        let band = 0.05 * (high - low);
        let (mut count, mut first, mut limits) = (0, usize::MAX, Vec::new());
        for extreme in [low, high] {
            let x = &self.track.values;
            let at = x.iter().filter(|v| **v == extreme).count();
            if extreme == 0.0 || at < CLIPPED.0 * CLIPPED.1 {
                continue;
            }
            // a peak spends more time near its top than on it; a plateau does not
            let near = x.iter().filter(|v| (**v - extreme).abs() < band).count() - at;
            if at <= near {
                continue;
            }
            let runs: Vec<(usize, usize)> = equal_runs(x, CLIPPED.0)
                .into_iter()
                .filter(|&(a, b)| x[a] == extreme && self.is_moving(self.stamps[(a + b) / 2]))
                .collect();
            if runs.len() < CLIPPED.1 {
                continue;
            }
            for (a, b) in runs {
                self.track.values[a..b].fill(f64::NAN);
                count += b - a;
                first = first.min(a);
            }
            limits.push(format!("{extreme:.4}"));
        }
        if count > 0 {
            let message = format!(
                "{count} samples sit at the sensor's limit {}, taken as missing",
                limits.join(" and ")
            );
            self.warn("clipped", count, first, message);
        }
        count > 0
    }

    /// Runs without any change while the bike moves, in a channel that is noisy otherwise.
    fn stuck(&mut self, least: f64) -> bool {
        let x = &self.track.values;
        let runs: Vec<(usize, usize)> = equal_runs(x, STUCK)
            .into_iter()
            .filter(|&(a, b)| {
                self.stamps[b - 1] - self.stamps[a] >= least
                    && self.is_moving(self.stamps[(a + b) / 2])
            })
            .collect();
        let Some(&(first, end)) = runs.first() else { return false };
        if end - first == x.len() {
            let message = "does not change during the whole log".into();
            self.warn("stuck", x.len(), 0, message);
            return false;
        }
        // A smooth source (a simulation, a filtered estimate) may rest on a value, and so may a
        // coarse one; a noisy sensor that does so and then jumps had stopped.
        let jump = STUCK_JUMP * usual_change(x);
        let mut runs = runs;
        runs.retain(|&(_, b)| b == x.len() || (x[b] - x[b - 1]).abs() > jump);
        let Some(&(first, _)) = runs.first().filter(|_| is_noisy(x)) else { return false };
        let mut count = 0;
        for &(a, b) in &runs {
            self.track.values[a + 1..b].fill(f64::NAN);
            count += b - a - 1;
        }
        let message = format!(
            "does not change at all {} time(s) for {least} s and more while the bike moves, \
             taken as missing",
            runs.len()
        );
        self.warn("stuck", count, first, message);
        true
    }

    fn is_moving(&self, time: f64) -> bool {
        self.moving.is_none_or(|spans| {
            let i = spans.partition_point(|s| s.1 < time);
            spans.get(i).is_some_and(|s| s.0 <= time)
        })
    }
}

/// Samples that are on one side of both neighbours by more than `least`.
fn peaks(x: &[f64], least: f64) -> Vec<usize> {
    /// Samples that are looked at together: almost never is there one among them.
    const SPAN: usize = 256;
    let stands_out = |before: f64, at: f64, after: f64| {
        let (a, b) = (at - before, at - after);
        // not `&&`: without ways out it is done for several at once
        (a.abs() > least) & (b.abs() > least) & (a * b > 0.0)
    };
    let mut found = Vec::new();
    let mut start = 1;
    while start + 1 < x.len() {
        let end = (start + SPAN).min(x.len() - 1);
        let (before, at, after) = (&x[start - 1..end - 1], &x[start..end], &x[start + 1..=end]);
        let triples = || before.iter().zip(at).zip(after).map(|((a, b), c)| stands_out(*a, *b, *c));
        if triples().map(u64::from).sum::<u64>() > 0 {
            let here = triples().enumerate().filter(|(_, out)| *out);
            found.extend(here.map(|(i, _)| start + i));
        }
        start = end;
    }
    found
}

/// Least jump that is examined: so many robust standard deviations of the
/// sample-to-sample change, and a fiftieth of the usual span.
fn least_jump(x: &[f64], threshold: f64) -> Option<f64> {
    let stride = (x.len() / 2048).max(1);
    let mut steps: Vec<f64> = (1..x.len())
        .step_by(stride)
        .map(|i| (x[i] - x[i - 1]).abs())
        .filter(|d| d.is_finite())
        .collect();
    let mut sample: Vec<f64> =
        x.iter().step_by(stride).copied().filter(|v| v.is_finite()).collect();
    let scale = SD_PER_MAD * upper_median(&mut steps)?;
    sample.sort_unstable_by(f64::total_cmp);
    let cut = sample.len() / 100;
    let span = sample[sample.len() - 1 - cut] - sample[cut];
    let least = (threshold * scale).max(0.02 * span);
    (least > 0.0).then_some(least)
}

/// Largest change between neighbours near `i` that does not involve `i`; `None` where too few
/// samples are around it.
fn change_around(x: &[f64], i: usize) -> Option<f64> {
    let before = x[i.saturating_sub(5)..i].windows(2);
    let after = x[i + 1..x.len().min(i + 6)].windows(2);
    let (mut largest, mut count) = (0.0_f64, 0);
    for step in before.chain(after).map(|w| (w[1] - w[0]).abs()).filter(|s| s.is_finite()) {
        largest = largest.max(step);
        count += 1;
    }
    (count >= 4).then_some(largest)
}

/// Runs `a..b` of at least `least` equal samples.
fn equal_runs(x: &[f64], least: usize) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    // a run that long has two equal samples at this distance, wherever it begins
    let stride = (least / 2).max(1);
    let mut i = 0;
    while i + stride < x.len() {
        if x[i] != x[i + stride] {
            i += stride;
            continue;
        }
        let value = x[i];
        let start = i - x[..i].iter().rev().take_while(|v| **v == value).count();
        let end = i + x[i..].iter().take_while(|v| **v == value).count();
        if end - start >= least {
            runs.push((start, end));
        }
        i = end.max(i + stride);
    }
    runs
}

/// Whether the signal bends back and forth from sample to sample, as noise does (three times in
/// four) and a smooth signal does not.
fn is_noisy(x: &[f64]) -> bool {
    let span = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
    let (mut turns, mut bends, mut last) = (0_usize, 0_usize, 0.0);
    for w in x.windows(3) {
        let bend = w[0] - 2.0 * w[1] + w[2];
        // rounding of a computed signal is no noise
        if bend.abs() > 1e-6 * span {
            turns += usize::from(bend * last < 0.0);
            bends += 1;
            last = bend;
        }
    }
    turns * 2 > bends
}

/// The usual size of a change, among the samples that change.
fn usual_change(x: &[f64]) -> f64 {
    let stride = (x.len() / 2048).max(1);
    let mut changes: Vec<f64> = (1..x.len())
        .step_by(stride)
        .map(|i| (x[i] - x[i - 1]).abs())
        .filter(|d| *d > 0.0)
        .collect();
    upper_median(&mut changes).unwrap_or(f64::INFINITY)
}

/// Spans in which the bike moves, s; `None` without any channel of its speed.
fn moving_times(log: &Clocked) -> Option<Vec<(f64, f64)>> {
    // a wheel of any size: a rough speed is enough to know whether it turns
    let gauges = [(VelocityX, 1.0), (WheelSpeedRear, 0.3), (WheelSpeedFront, 0.3)];
    let (track, factor) = gauges
        .iter()
        .find_map(|(c, f)| log.tracks.iter().find(|t| t.channel == *c).map(|t| (t, f)))?;
    let stamps = &log.clocks[track.clock].stamps;
    let mut spans: Vec<(f64, f64)> = Vec::new();
    let mut open = None;
    for (&t, &v) in stamps.iter().zip(&track.values) {
        if v.abs() * factor > MOVING {
            open.get_or_insert((t, t)).1 = t;
        } else if !v.is_nan()
            && let Some(span) = open.take()
        {
            spans.push(span);
        }
    }
    spans.extend(open);
    Some(spans)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_found_wherever_they_begin() {
        for start in 0..40 {
            for len in [9, 10, 11, 23] {
                let mut x: Vec<f64> = (0..80).map(f64::from).collect();
                x[start..start + len].fill(-1.0);
                let found = if len < 10 { vec![] } else { vec![(start, start + len)] };
                assert_eq!(equal_runs(&x, 10), found, "{len} from {start}");
            }
        }
    }

    #[test]
    fn extent_passes_over_nan() {
        let mut x: Vec<f64> = (0..21).map(f64::from).collect();
        x[0] = f64::NAN;
        x[20] = f64::NAN;
        let e = Extent::of(&x);
        assert_eq!((e.low, e.high, e.count), (1.0, 19.0, 19));
        assert_eq!(Extent::of(&[f64::NAN; 3]).count, 0);
    }

    #[test]
    fn yaw_runs_on() {
        let mut yaw: Vec<f64> = (0..100).map(|i| 0.2 * f64::from(i)).collect();
        let truth = yaw.clone();
        yaw.iter_mut().for_each(|y| *y = y.sin().atan2(y.cos()));
        unwrap(&mut yaw);
        assert!(yaw.iter().zip(&truth).all(|(a, b)| (a - b).abs() < 1e-9));
    }
}
