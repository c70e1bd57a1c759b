//! Samples that no sensor can have meant: out of range, spikes, clipped, stuck.
//!
//! What is found becomes NaN, and a warning says so. All tests are conservative: a doubtful
//! sample stays, the robust fits behind can live with it.

use crate::channel::Channel;
use crate::ingest::clock::{Clocked, Timed, median};
use crate::ingest::{Config, warning};
use crate::schema::Table;
use crate::warning::Warning;

use Channel::*;

/// Share of samples out of range that is still taken for glitches, not for a wrong unit.
const RARE: f64 = 0.01;
/// Slower than this the bike is not moving, m/s.
const MOVING: f64 = 2.0;
/// Least samples of a run at the extreme, and least runs, to be called clipped.
const CLIPPED: (usize, usize) = (5, 3);
/// Least samples of a stuck run.
const STUCK: usize = 10;

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

/// Cleans every channel, and takes out those with nothing in them.
pub fn clean(log: &mut Clocked, config: &Config, warnings: &mut Vec<Warning>) {
    let table = Table::embedded("session");
    let moving = moving_times(log);
    let start = log.span().0;
    let Clocked { clocks, tracks } = log;
    tracks.retain_mut(|track| {
        let stamps = &clocks[track.clock].stamps;
        let mut job = Job { track, stamps, start, moving: moving.as_deref(), warnings };
        if job.track.channel == Yaw {
            unwrap(&mut job.track.values);
        }
        let Some(extent) = job.extent() else { return false };
        let range = table.column(job.track.channel.name()).and_then(|c| c.range);
        if let Some([low, high]) = range
            && (extent.low < low || extent.high > high)
        {
            job.out_of_range(low, high, extent.count);
        }
        if config.spike_threshold > 0.0 && job.track.channel != Gear {
            job.spikes(config.spike_threshold);
        }
        if CAN_CLIP.contains(&job.track.channel) {
            job.clipped();
        }
        if config.stuck_time > 0.0 && CAN_STICK.contains(&job.track.channel) {
            job.stuck(config.stuck_time);
        }
        job.track.values.iter().any(|v| v.is_finite()) || job.extent().is_some()
    });
}

/// One channel under examination.
struct Job<'a> {
    track: &'a mut Timed,
    stamps: &'a [f64],
    start: f64,
    moving: Option<&'a [(f64, f64)]>,
    warnings: &'a mut Vec<Warning>,
}

struct Extent {
    low: f64,
    high: f64,
    count: usize,
}

impl Job<'_> {
    fn warn(&mut self, code: &'static str, count: usize, at: usize, message: String) {
        let time = Some(self.stamps[at] - self.start);
        let channel = self.track.channel;
        let message = format!("{channel}: {message}");
        self.warnings.push(warning(code, Some(channel), count, time, message));
    }

    /// Smallest, largest and number of the finite samples; `None` and a warning if none is.
    fn extent(&mut self) -> Option<Extent> {
        let mut e = Extent { low: f64::INFINITY, high: f64::NEG_INFINITY, count: 0 };
        for &v in &self.track.values {
            e.low = e.low.min(v);
            e.high = e.high.max(v);
            e.count += usize::from(v.is_finite());
        }
        if e.count == 0 {
            let n = self.track.values.len();
            self.warn("empty_channel", n, 0, "has no sample at all, left out".into());
            return None;
        }
        Some(e)
    }

    fn out_of_range(&mut self, low: f64, high: f64, present: usize) {
        let outside = |v: f64| v < low || v > high;
        let found = self.track.values.iter().filter(|v| outside(**v)).count();
        let Some(first) = self.track.values.iter().position(|v| outside(*v)) else { return };
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
    }

    /// Single samples far off both neighbours, which agree with each other, where the signal
    /// is otherwise quiet.
    fn spikes(&mut self, threshold: f64) {
        let x = &mut self.track.values;
        let Some(least) = least_jump(x, threshold) else { return };
        let (mut count, mut first) = (0, 0);
        for i in 1..x.len().saturating_sub(1) {
            let (a, b) = (x[i] - x[i - 1], x[i] - x[i + 1]);
            if !(a.abs() > least && b.abs() > least && a * b > 0.0) {
                continue;
            }
            let jump = a.abs().min(b.abs());
            let around = x[i.saturating_sub(5)..i]
                .windows(2)
                .chain(x[i + 1..x.len().min(i + 6)].windows(2))
                .map(|w| (w[1] - w[0]).abs())
                .fold(0.0, f64::max);
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
    }

    /// Plateaus at the channel's own extreme where a peak ought to be.
    fn clipped(&mut self) {
        let Some(Extent { low, high, .. }) = self.extent() else { return };
        if !(high > low) {
            return;
        }
        let band = 0.05 * (high - low);
        let (mut count, mut first, mut limits) = (0, usize::MAX, Vec::new());
        for extreme in [low, high] {
            let x = &self.track.values;
            let at = x.iter().filter(|v| **v == extreme).count();
            // a peak spends more time near its top than on it; a plateau does not
            let near = x.iter().filter(|v| (**v - extreme).abs() < band).count() - at;
            if extreme == 0.0 || at < CLIPPED.0 * CLIPPED.1 || at <= near {
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
    }

    /// Runs without any change while the bike moves, in a channel that is noisy otherwise.
    fn stuck(&mut self, least: f64) {
        let x = &self.track.values;
        let runs: Vec<(usize, usize)> = equal_runs(x, STUCK)
            .into_iter()
            .filter(|&(a, b)| {
                self.stamps[b - 1] - self.stamps[a] >= least
                    && self.is_moving(self.stamps[(a + b) / 2])
            })
            .collect();
        let Some(&(first, end)) = runs.first() else { return };
        if end - first == x.len() {
            let message = "does not change during the whole log".into();
            return self.warn("stuck", x.len(), 0, message);
        }
        // a smooth source (a simulation, a filtered estimate) may rest on a value; a noisy
        // sensor that does so has stopped
        if !is_noisy(x) {
            return;
        }
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
    }

    fn is_moving(&self, time: f64) -> bool {
        self.moving.is_none_or(|spans| {
            let i = spans.partition_point(|s| s.1 < time);
            spans.get(i).is_some_and(|s| s.0 <= time)
        })
    }
}

/// What a jump must at least be to look at it: so many robust standard deviations of the
/// sample-to-sample change, and a fiftieth of the usual span.
fn least_jump(x: &[f64], threshold: f64) -> Option<f64> {
    let stride = (x.len() / 2048).max(1);
    let steps: Vec<f64> = (1..x.len())
        .step_by(stride)
        .map(|i| (x[i] - x[i - 1]).abs())
        .filter(|d| d.is_finite())
        .collect();
    let mut sample: Vec<f64> =
        x.iter().step_by(stride).copied().filter(|v| v.is_finite()).collect();
    let scale = 1.4826 * median(steps)?;
    sample.sort_unstable_by(f64::total_cmp);
    let cut = sample.len() / 100;
    let span = sample[sample.len() - 1 - cut] - sample[cut];
    let least = (threshold * scale).max(0.02 * span);
    (least > 0.0).then_some(least)
}

/// Runs `a..b` of at least `least` equal samples.
fn equal_runs(x: &[f64], least: usize) -> Vec<(usize, usize)> {
    let mut runs = Vec::new();
    let mut start = 0;
    for i in 1..=x.len() {
        if i == x.len() || x[i] != x[i - 1] {
            if i - start >= least && x[start].is_finite() {
                runs.push((start, i));
            }
            start = i;
        }
    }
    runs
}

/// Whether the changes from sample to sample keep changing sign, as noise does (two times in
/// three) and a smooth signal does not.
fn is_noisy(x: &[f64]) -> bool {
    let (mut turns, mut changes, mut last) = (0_usize, 0_usize, 0.0);
    for w in x.windows(2) {
        let step = w[1] - w[0];
        if step != 0.0 && step.is_finite() {
            turns += usize::from(step * last < 0.0);
            changes += 1;
            last = step;
        }
    }
    turns * 5 > changes
}

/// Yaw that runs on instead of wrapping at +-pi.
fn unwrap(yaw: &mut [f64]) {
    let (mut turns, mut last) = (0.0, f64::NAN);
    for y in yaw.iter_mut().filter(|y| y.is_finite()) {
        let step: f64 = *y - last;
        if step.abs() > std::f64::consts::PI {
            turns -= (step / std::f64::consts::TAU).round();
        }
        last = *y;
        *y += turns * std::f64::consts::TAU;
    }
}

/// When the bike moves; `None` when nothing tells its speed.
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
