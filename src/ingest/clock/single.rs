//! One clock repaired: stamps that strictly increase, on straight lines over the row number where they are periodic.

use std::sync::Arc;

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::warning::warning;
use crate::statistics::order::upper_median;

/// Stamps that strictly increase.
#[derive(Debug, Clone)]
pub(crate) struct Clock {
    /// Stamps, s.
    pub stamps: Arc<Vec<f64>>,
    /// Usual distance between stamps, s.
    pub period: f64,
    /// Whether every stamp is where `period` puts it, counted from the first.
    pub uniform: bool,
}

/// Largest deviation from a uniform clock that is none, as a share of the period.
const UNIFORM: f64 = 1e-3;
/// A descent of more than this is a restarted clock, not a late stamp, s.
const RESTART: f64 = 1.0;
/// A step ahead of more than this is a clock that was set, not a pause in a ride, s.
const SET_AHEAD: f64 = 3600.0;
/// Runs shorter than this are not fitted: too few stamps to tell jitter from pace.
const SHORTEST_RUN: usize = 16;
/// A step of more periods than this is a gap between runs.
const RUN_GAP: f64 = 2.5;
/// Share of repeated stamps from which the clock is taken to be coarse rather than stuttering.
const COARSE: f64 = 0.2;

/// A repaired clock and what was done to it.
#[derive(Debug, Clone)]
pub(crate) struct Repaired {
    pub(crate) clock: Clock,
    /// Rows that are left, where not all are.
    pub(crate) kept: Option<Vec<usize>>,
    /// Their stamps as recorded, where the repair moved them.
    pub(crate) raw: Option<Vec<f64>>,
    /// Whether the stamps are coarser than the sampling.
    pub(crate) coarse: bool,
    /// Whether its jitter is not that of the logger's other clocks, so that it stays.
    pub(crate) own_jitter: bool,
    pub(crate) missing: Fault,
    pub(crate) duplicated: Fault,
    pub(crate) backwards: Fault,
    /// Samples lost to a restarted clock.
    lost: usize,
    /// Rows whose stamps were moved, and their RMS move in s.
    pub(crate) jitter: (usize, f64),
}

/// How often, and when first, s after the first stamp.
#[derive(Debug, Default, Clone, Copy)]
pub(crate) struct Fault {
    count: usize,
    first: Option<f64>,
}

impl Fault {
    fn note(&mut self, time: f64) {
        self.count += 1;
        self.first.get_or_insert(time);
    }
}

impl Repaired {
    /// `channels` are those of the clock, where the log has several.
    pub(crate) fn report(&self, channels: &[Channel], warnings: &mut Vec<Warning>) {
        let names: Vec<&str> = channels.iter().map(|c| c.name()).collect();
        let of = if names.is_empty() { String::new() } else { format!("{}: ", names.join(", ")) };
        let channel = channels.first().copied().filter(|_| channels.len() == 1);
        let mut put = |code, count, time, message: String| {
            warnings.push(warning(code, channel, count, time, format!("{of}{message}")));
        };
        if self.missing.count > 0 {
            let n = self.missing.count;
            put("time_missing", n, None, format!("{n} rows without a time stamp, left out"));
        }
        if self.duplicated.count > 0 {
            let n = self.duplicated.count;
            let message = format!("{n} rows repeat the stamp before them, left out");
            put("time_duplicated", n, self.duplicated.first, message);
        }
        if self.backwards.count > 0 {
            let n = self.backwards.count;
            let message = match self.lost {
                0 => format!("{n} rows out of time order, left out"),
                lost => format!(
                    "the clock jumps back or far ahead; the longest part between jumps is used, {lost} of \
                     {} rows are left out: split the log to use the others",
                    lost + self.clock.stamps.len()
                ),
            };
            put("time_backwards", n, self.backwards.first, message);
        }
        let (n, rms) = self.jitter;
        if n > 0 {
            let done = if self.own_jitter {
                "the logger's other clocks do not, so the samples keep their stamps"
            } else {
                "the samples get the stamps of the regular clock"
            };
            let message = format!(
                "stamps jitter by {:.2} ms RMS around a regular {:.4} Hz; {done}",
                rms * 1e3,
                1.0 / self.clock.period
            );
            put("time_jitter", n, None, message);
        }
    }
}

/// `None` when there are no two usable stamps.
pub(crate) fn repair_one(stamps: &Arc<Vec<f64>>) -> Option<Repaired> {
    let as_is = |period| Repaired {
        clock: Clock { stamps: Arc::clone(stamps), period, uniform: true },
        kept: None,
        raw: None,
        coarse: false,
        own_jitter: false,
        missing: Fault::default(),
        duplicated: Fault::default(),
        backwards: Fault::default(),
        lost: 0,
        jitter: (0, 0.0),
    };
    if let Some(period) = uniform_period(stamps) {
        return Some(as_is(period));
    }
    let mut out = as_is(0.0);
    let start = stamps.iter().copied().find(|t| t.is_finite())?;
    let mut kept: Vec<usize> = (0..stamps.len()).filter(|&i| stamps[i].is_finite()).collect();
    out.missing.count = stamps.len() - kept.len();
    drop_outliers(stamps, &mut kept, &mut out.backwards, start);
    let (part, descents) = longest_part(stamps, &kept);
    out.lost = kept.len() - part.len();
    descents.into_iter().for_each(|t| out.backwards.note((t - start).max(0.0)));
    kept = part;
    let coarse = coarse_clock(stamps, &kept);
    if coarse.is_none() {
        strictly_increasing(stamps, &mut kept, &mut out, start);
    }
    let raw: Vec<f64> = kept.iter().map(|&i| stamps[i]).collect();
    if raw.len() < 2 {
        return None;
    }
    out.coarse = coarse.is_some();
    let fitted = match coarse {
        Some(fitted) => fitted,
        None => without_jitter(&raw),
    };
    out.jitter = jitter(&fitted, &raw);
    out.clock = clock_of(fitted);
    out.raw = Some(raw);
    out.kept = (kept.len() < stamps.len()).then_some(kept);
    Some(out)
}

/// Rows whose stamps were moved and their RMS move; none where it is nothing to speak of.
pub(crate) fn jitter(fitted: &[f64], raw: &[f64]) -> (usize, f64) {
    let moved: Vec<f64> = fitted.iter().zip(raw).map(|(a, b)| a - b).collect();
    let rms = (moved.iter().map(|d| d * d).sum::<f64>() / moved.len() as f64).sqrt();
    if rms > 0.02 * usual_step(fitted) {
        (moved.iter().filter(|d| **d != 0.0).count(), rms)
    } else {
        (0, 0.0)
    }
}

/// A clock of these stamps.
pub(crate) fn clock_of(stamps: Vec<f64>) -> Clock {
    let uniform = uniform_period(&stamps);
    let period = uniform.unwrap_or_else(|| usual_step(&stamps));
    Clock { period, uniform: uniform.is_some(), stamps: Arc::new(stamps) }
}

/// The period, if every stamp is where it puts it.
fn uniform_period(stamps: &[f64]) -> Option<f64> {
    let (&first, &last) = (stamps.first()?, stamps.last()?);
    if stamps.len() < 2 {
        return None;
    }
    let period = (last - first) / (stamps.len() - 1) as f64;
    if !(period > 0.0 && period.is_finite()) {
        return None;
    }
    let worst = UNIFORM * period;
    let all =
        stamps.iter().enumerate().all(|(i, t)| (t - first - i as f64 * period).abs() <= worst);
    all.then_some(period)
}

/// Takes out single stamps that lie outside their two neighbours, which are in order.
fn drop_outliers(stamps: &[f64], kept: &mut Vec<usize>, fault: &mut Fault, start: f64) {
    let mut bad = Vec::new();
    for w in kept.windows(3) {
        let (before, at, after) = (stamps[w[0]], stamps[w[1]], stamps[w[2]]);
        let step = after - before;
        // a neighbour far away is the other side of a gap, and says nothing
        let outside = at < before || (at > after && at - after > RESTART.min(10.0 * step));
        if step > 0.0 && outside && bad.last() != Some(&w[0]) {
            fault.note((before - start).max(0.0));
            bad.push(w[1]);
        }
    }
    if !bad.is_empty() {
        kept.retain(|i| bad.binary_search(i).is_err());
    }
}

/// The longest part between restarts of the clock (back, or far ahead), and the stamps before
/// them.
fn longest_part(stamps: &[f64], kept: &[usize]) -> (Vec<usize>, Vec<f64>) {
    let mut borders = vec![0];
    let mut descents = Vec::new();
    let mut latest = f64::NEG_INFINITY;
    for (k, &i) in kept.iter().enumerate() {
        if stamps[i] < latest - RESTART || (k > 0 && stamps[i] > latest + SET_AHEAD) {
            borders.push(k);
            descents.push(latest);
            latest = stamps[i];
        }
        latest = latest.max(stamps[i]);
    }
    borders.push(kept.len());
    let mut longest = 0..0;
    for pair in borders.windows(2) {
        if pair[1] - pair[0] > longest.len() {
            longest = pair[0]..pair[1];
        }
    }
    (kept[longest].to_vec(), descents)
}

/// The rows of the part that [`repair_one`] keeps of a clock that jumps back or far ahead; `None` where it does not jump.
pub(crate) fn longest(stamps: &[f64]) -> Option<Vec<usize>> {
    let mut kept: Vec<usize> = (0..stamps.len()).filter(|&i| stamps[i].is_finite()).collect();
    drop_outliers(stamps, &mut kept, &mut Fault::default(), 0.0);
    let (part, descents) = longest_part(stamps, &kept);
    (!descents.is_empty()).then_some(part)
}

/// Leaves out rows whose stamp is not later than every one before.
fn strictly_increasing(stamps: &[f64], kept: &mut Vec<usize>, out: &mut Repaired, start: f64) {
    let mut latest = f64::NEG_INFINITY;
    kept.retain(|&i| {
        let t = stamps[i];
        let ok = t > latest;
        if ok {
            latest = t;
        } else if t == latest {
            out.duplicated.note(t - start);
        } else {
            out.backwards.note((latest - start).max(0.0));
        }
        ok
    });
}

/// A clock coarser than the sampling (whole seconds at 10 Hz, say), spread over the rows; `None`
/// if it is not that.
fn coarse_clock(stamps: &[f64], kept: &[usize]) -> Option<Vec<f64>> {
    let raw: Vec<f64> = kept.iter().map(|&i| stamps[i]).collect();
    let repeats = raw.windows(2).filter(|w| w[0] == w[1]).count();
    let ordered = raw.windows(2).all(|w| w[0] <= w[1]);
    if !ordered || raw.len() < SHORTEST_RUN || (repeats as f64) < COARSE * raw.len() as f64 {
        return None;
    }
    let mut steps: Vec<f64> = raw.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    let tick = upper_median(&mut steps)?;
    let (fit, residual) = fit_line(&raw, None)?;
    // a coarse clock's residual is at most its tick; one that stutters drifts away
    if residual < 0.5 * tick { Some(fit) } else { within_ticks(&raw, tick) }
}

/// Stamps that are coarser than the rows, spread over them; `None` of stamps that are not.
pub(crate) fn spread(stamps: &[f64]) -> Option<Vec<f64>> {
    let kept: Vec<usize> = (0..stamps.len()).filter(|&i| stamps[i].is_finite()).collect();
    let fitted = coarse_clock(stamps, &kept)?;
    let mut out = vec![f64::NAN; stamps.len()];
    kept.into_iter().zip(fitted).for_each(|(i, t)| out[i] = t);
    Some(out)
}

/// Coarse stamps whose rows do not come at one pace (a pause, lost rows): each tick's rows are spread over the tick.
/// `None` where ticks have too few rows to be what the clock is coarse by.
fn within_ticks(raw: &[f64], tick: f64) -> Option<Vec<f64>> {
    let groups: Vec<&[f64]> = raw.chunk_by(|a, b| a == b).collect();
    let mut counts: Vec<f64> = groups.iter().map(|g| g.len() as f64).collect();
    let usual = upper_median(&mut counts)?;
    // a stutter repeats single stamps, and most ticks are alike
    let alike = groups.iter().filter(|g| (g.len() as f64 - usual).abs() <= 0.3 * usual).count();
    if usual < 3.0 || 10 * alike < 7 * groups.len() {
        return None;
    }
    let mut out = Vec::with_capacity(raw.len());
    for (k, group) in groups.iter().enumerate() {
        let n = group.len() as f64;
        let full = groups.get(k + 1).is_some_and(|next| next[0] - group[0] < 1.5 * tick);
        let rows = if full { n.max(usual * f64::from(u8::from(k == 0))) } else { n.max(usual) };
        // the first tick may have begun before the log
        let skipped = if k == 0 && full { rows - n } else { 0.0 };
        out.extend((0..group.len()).map(|i| group[0] + tick * (skipped + i as f64) / rows));
    }
    Some(out)
}

/// Stamps on straight lines over the row number, run by run, where the source is periodic.
fn without_jitter(raw: &[f64]) -> Vec<f64> {
    let mut out = raw.to_vec();
    let period = usual_step(raw);
    let mut start = 0;
    for end in 1..=raw.len() {
        if end < raw.len() && raw[end] - raw[end - 1] <= RUN_GAP * period {
            continue;
        }
        let run = &raw[start..end];
        if run.len() >= SHORTEST_RUN
            && let Some(fit) = periodic(run, period)
            && (start == 0 || out[start - 1] < fit[0])
        {
            out[start..end].copy_from_slice(&fit);
        }
        start = end;
    }
    // a fitted run may run into one that is not
    if out.windows(2).all(|w| w[0] < w[1]) { out } else { raw.to_vec() }
}

/// The regular stamps of one run, if it is periodic, possibly with lost rows.
fn periodic(run: &[f64], period: f64) -> Option<Vec<f64>> {
    let mut index = Vec::with_capacity(run.len());
    let mut at = 0.0;
    index.push(at);
    for w in run.windows(2) {
        at += ((w[1] - w[0]) / period).round().max(1.0);
        index.push(at);
    }
    let by_row = fit_line(run, None)?;
    let by_step = fit_line(run, Some(&index))?;
    let (fit, residual) = if by_step.1 < by_row.1 { by_step } else { by_row };
    // uniform jitter over a whole period has 0.29; more than 0.5 is not a periodic source
    (residual < 0.5 * period).then_some(fit)
}

/// Least-squares line through stamps over their index (the row where none is given): the
/// stamps on the line and the standard deviation from it.
fn fit_line(stamps: &[f64], index: Option<&[f64]>) -> Option<(Vec<f64>, f64)> {
    let n = stamps.len() as f64;
    let k = |i: usize| index.map_or(i as f64, |index| index[i]);
    let first = *stamps.first()?;
    let (mut mean_k, mut mean_t) = (0.0, 0.0);
    for (i, t) in stamps.iter().enumerate() {
        mean_k += k(i) / n;
        mean_t += (t - first) / n;
    }
    let (mut kk, mut kt) = (0.0, 0.0);
    for (i, t) in stamps.iter().enumerate() {
        let dk = k(i) - mean_k;
        kk += dk * dk;
        kt += dk * (t - first - mean_t);
    }
    let slope = kt / kk;
    if !(slope > 0.0 && slope.is_finite()) {
        return None;
    }
    let fit: Vec<f64> =
        (0..stamps.len()).map(|i| first + mean_t + slope * (k(i) - mean_k)).collect();
    let square: f64 = fit.iter().zip(stamps).map(|(a, b)| (a - b) * (a - b)).sum();
    Some((fit, (square / n).sqrt()))
}

/// Mean of the steps near the median one: the median alone is wrong for stamps that alternate
/// or are rounded.
fn usual_step(stamps: &[f64]) -> f64 {
    let steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    let near = |middle: f64| {
        let (mut sum, mut count) = (0.0, 0.0);
        for step in steps.iter().filter(|s| (0.5..1.5).contains(&(*s / middle))) {
            sum += step;
            count += 1.0;
        }
        sum / count
    };
    upper_median(&mut steps.clone()).map_or(0.0, near)
}
