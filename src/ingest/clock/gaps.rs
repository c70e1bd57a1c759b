//! Missing samples on the common clock: short ones bridged, long ones reported.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::ingest::clock::grid::{Interpolation, between};
use crate::ingest::warning::warning;

/// Fills runs of NaN between two samples that are at most `longest` samples apart.
pub(crate) fn bridge(values: &mut [f64], longest: usize, kind: Interpolation) {
    let Some(mut i) = values.iter().position(|v| v.is_nan()) else { return };
    while i < values.len() {
        if !values[i].is_nan() {
            i += 1;
            continue;
        }
        let end = i + values[i..].iter().take_while(|v| v.is_nan()).count();
        if i > 0 && end < values.len() && end - i < longest {
            fill(values, i, end, kind);
        }
        i = end;
    }
}

/// Fills `start..end`, whose neighbours on both sides are there.
fn fill(values: &mut [f64], start: usize, end: usize, kind: Interpolation) {
    // the sample before, the two at the borders, the sample after
    let places = [start.saturating_sub(2), start - 1, end, (end + 1).min(values.len() - 1)];
    let from = usize::from(start < 2 || values[places[0]].is_nan());
    let to = if end + 1 >= values.len() || values[places[3]].is_nan() { 3 } else { 4 };
    let times = places.map(|p| p as f64);
    let samples = places.map(|p| values[p]);
    for (i, value) in values.iter_mut().enumerate().take(end).skip(start) {
        let t = i as f64;
        *value = between(&times[from..to], &samples[from..to], 1 - from, t, f64::INFINITY, kind);
    }
}

/// Gaps of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Gaps {
    count: usize,
    samples: usize,
    first: usize,
    longest: usize,
}

/// Warns of what stayed missing, once where several channels miss the same.
pub(crate) fn report(session: &Session, limits: &[(Channel, f64)], warnings: &mut Vec<Warning>) {
    let mut groups: Vec<(Gaps, f64, Vec<Channel>)> = Vec::new();
    for &(channel, limit) in limits {
        let ends = limit * session.rate;
        let Some(gaps) = session.get(channel).and_then(|v| find(v, ends)) else { continue };
        match groups.iter_mut().find(|(g, l, _)| *g == gaps && *l == limit) {
            Some((_, _, channels)) => channels.push(channel),
            None => groups.push((gaps, limit, vec![channel])),
        }
    }
    for (gaps, limit, channels) in groups {
        let names: Vec<&str> = channels.iter().map(|c| c.name()).collect();
        let who = match channels.len() {
            n if n == limits.len() && n > 1 => "every channel".to_owned(),
            _ => names.join(", "),
        };
        let seconds = |samples: usize| samples as f64 / session.rate;
        let message = format!(
            "{who}: {} gap(s) beyond {limit:.3} s, {:.2} s in all, the longest {:.2} s; left \
             missing",
            gaps.count,
            seconds(gaps.samples),
            seconds(gaps.longest)
        );
        let only = if let [channel] = channels[..] { Some(channel) } else { None };
        warnings.push(warning("gap", only, gaps.count, Some(seconds(gaps.first)), message));
    }
}

/// Before the first and after the last sample less than `ends` samples are no gap: that a slower
/// channel begins and ends later and earlier than the others is its rate, not a loss.
fn find(values: &[f64], ends: f64) -> Option<Gaps> {
    let missing = |run: usize| if (run as f64) < ends { run } else { 0 };
    let before = missing(values.iter().take_while(|v| v.is_nan()).count());
    let after = missing(values.iter().rev().take_while(|v| v.is_nan()).count());
    let values = values.get(..values.len() - after)?;
    let first = before + values.get(before..)?.iter().position(|v| v.is_nan())?;
    let mut gaps = Gaps { count: 0, samples: 0, first, longest: 0 };
    let mut run = 0;
    for v in values[first..].iter().chain([&0.0]) {
        if v.is_nan() {
            run += 1;
        } else if run > 0 {
            gaps.count += 1;
            gaps.samples += run;
            gaps.longest = gaps.longest.max(run);
            run = 0;
        }
    }
    Some(gaps)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    const NAN: f64 = f64::NAN;

    #[test]
    fn short_runs_are_bridged_along_the_curve_long_ones_are_not() {
        let f = |i: usize| (i * i) as f64;
        let mut values: Vec<f64> = (0..20).map(f).collect();
        for i in [0, 3, 9, 10, 11, 12, 18] {
            values[i] = NAN;
        }
        bridge(&mut values, 4, Interpolation::Cubic);
        assert!(values[0].is_nan(), "nothing before the first sample");
        assert!((values[3] - 9.0).abs() < 1e-12, "{}", values[3]);
        assert!(values[9..13].iter().all(|v| v.is_nan()));
        assert!((values[18] - 324.0).abs() < 1.0);
    }

    #[test]
    fn a_slow_channel_ends_before_the_others_without_a_gap() {
        let values = [NAN, NAN, 1.0, NAN, NAN, NAN, 1.0, NAN, NAN, NAN];
        let gaps = find(&values, 3.0).expect("inside, and after");
        assert_eq!((gaps.count, gaps.samples, gaps.first), (2, 6, 3));
        assert_eq!(find(&values, 4.0).expect("inside").samples, 3);
        assert_eq!(find(&[NAN, 1.0, 1.0, NAN], 2.0), None);
        assert_eq!(find(&[NAN; 3], 10.0), None);
    }

    #[test]
    fn equal_gaps_are_told_once() {
        let mut session = Session::new(Meta::default(), 10.0, 8);
        session.set(Channel::Roll, vec![1.0, NAN, NAN, 1.0, 1.0, NAN, 1.0, 1.0]);
        session.set(Channel::Pitch, vec![1.0, NAN, NAN, 1.0, 1.0, NAN, 1.0, 1.0]);
        session.set(Channel::Yaw, vec![1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, NAN]);
        let mut warnings = Vec::new();
        let limits = [Channel::Roll, Channel::Pitch, Channel::Yaw].map(|c| (c, 0.1));
        report(&session, &limits, &mut warnings);
        assert_eq!(warnings.len(), 2);
        assert_eq!((warnings[0].count, warnings[0].time), (2, Some(0.1)));
        assert!(warnings[0].message.starts_with("roll, pitch: 2 gap(s)"));
        assert!(warnings[0].message.contains("0.30 s in all, the longest 0.20 s"));
        assert_eq!(warnings[1].channel, Some(Channel::Yaw));
    }
}
