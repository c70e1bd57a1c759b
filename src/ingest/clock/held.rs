//! Numbers of a satellite receiver that a faster logger writes again in every row until the next fix.
//!
//! The repeats are no samples: taken as such they make stairs of a speed and of a path. A receiver computes all of its
//! numbers at once, so they change in the same rows, and at an even pace. That is what is asked here: a speed in coarse
//! steps changes at any time, a motorcycle that stands changes nothing at all, and a channel of another device changes
//! in other rows.

use std::sync::Arc;

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::raw::{Column, Track};
use crate::ingest::warning::warning;
use crate::statistics::order;

/// Channels that a satellite receiver may give.
pub(crate) const RECEIVER: [Channel; 8] = [
    Channel::Latitude,
    Channel::Longitude,
    Channel::VelocityX,
    Channel::SatelliteSpeed,
    Channel::Yaw,
    Channel::Course,
    Channel::Climb,
    Channel::Altitude,
];
/// Those of them that are speeds.
pub(crate) const SPEEDS: [Channel; 2] = [Channel::VelocityX, Channel::SatelliteSpeed];
/// Least changes of a channel that its pace can be seen in.
const LEAST_CHANGES: usize = 20;
/// Most of its changes that follow another one in the next row, as a share: fixes do not.
const NEXT_ROW: f64 = 0.05;
/// Changes of a channel that are in the rows of the others', as a share.
const TOGETHER: f64 = 0.8;
/// Rows of a change in which a second channel changes, too, as a share: a coarse one does not at every fix.
const SECOND: f64 = 0.5;
/// Rows between changes that are of an even pace, as a share ...
const EVEN: f64 = 0.9;
/// ... of all but those that are so many times as long: the bike stood, or fixes were lost.
const LONG: f64 = 1.7;
/// Most rows of one fix.
const MAX_ROWS_PER_FIX: usize = 500;

/// Where a receiver's numbers are new.
#[derive(Debug, PartialEq)]
struct Fixes {
    /// The rows, in order.
    rows: Vec<usize>,
    /// Places of the channels that are of this receiver.
    members: Vec<usize>,
    /// Rows per fix.
    pace: f64,
}

/// Thins the tracks of a receiver to its fixes, with a warning.
pub(crate) fn thin(tracks: &mut [Track], warnings: &mut Vec<Warning>) {
    let mut left: Vec<usize> =
        (0..tracks.len()).filter(|&i| RECEIVER.contains(&tracks[i].channel)).collect();
    while let Some(&first) = left.first() {
        let (group, others): (Vec<usize>, Vec<usize>) =
            left.iter().partition(|&&i| same_rows(&tracks[first].time, &tracks[i].time));
        left = others;
        let values: Vec<&[f64]> = group.iter().map(|&i| &tracks[i].values[..]).collect();
        let Some(fixes) = find(&values) else { continue };
        let members: Vec<usize> = fixes.members.iter().map(|&k| group[k]).collect();
        let names: Vec<&str> = members.iter().map(|&i| tracks[i].channel.name()).collect();
        let time = Arc::clone(&tracks[first].time);
        let lost = time.len() - fixes.rows.len();
        let message = said(&names, &time, &fixes);
        // clocks that were shared stay shared
        let mut made: Vec<[Arc<Vec<f64>>; 2]> = Vec::new();
        for i in members {
            let track = &mut tracks[i];
            let known = made.iter().find(|m| Arc::ptr_eq(&m[0], &track.time));
            let thinned = known
                .map_or_else(|| Arc::new(chosen(&track.time, &fixes.rows)), |m| Arc::clone(&m[1]));
            if known.is_none() {
                made.push([Arc::clone(&track.time), Arc::clone(&thinned)]);
            }
            track.values = chosen(&track.values, &fixes.rows);
            track.time = thinned;
        }
        warnings.push(warning("repeated_fixes", None, lost, None, message));
    }
}

/// The same of columns before any map; `wanted` are places of those that may be a receiver's. What was seen.
pub(crate) fn thin_columns(columns: &mut [Column], wanted: &[usize]) -> Vec<String> {
    let (mut left, mut seen) = (wanted.to_vec(), Vec::new());
    while let Some(&first) = left.first() {
        let (group, others): (Vec<usize>, Vec<usize>) =
            left.iter().partition(|&&i| Arc::ptr_eq(&columns[first].time, &columns[i].time));
        left = others;
        let values: Vec<&[f64]> = group.iter().map(|&i| &columns[i].values[..]).collect();
        let Some(fixes) = find(&values) else { continue };
        let time = Arc::clone(&columns[first].time);
        let thinned = Arc::new(chosen(&time, &fixes.rows));
        let members: Vec<usize> = fixes.members.iter().map(|&k| group[k]).collect();
        let names: Vec<String> =
            members.iter().map(|&i| format!("`{}`", columns[i].name)).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        seen.push(said(&names, &time, &fixes));
        for i in members {
            columns[i].values = chosen(&columns[i].values, &fixes.rows);
            columns[i].time = Arc::clone(&thinned);
        }
    }
    seen
}

fn chosen(from: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().filter_map(|&i| from.get(i).copied()).collect()
}

/// Whether two clocks are of the same rows: one may be shifted by a delay.
pub(crate) fn same_rows(a: &Arc<Vec<f64>>, b: &Arc<Vec<f64>>) -> bool {
    if Arc::ptr_eq(a, b) {
        return true;
    }
    let mut apart = a.iter().zip(b.iter()).map(|(a, b)| b - a).filter(|d| d.is_finite());
    let first = apart.next().unwrap_or(f64::NAN);
    a.len() == b.len() && apart.all(|d| (d - first).abs() < 1e-6)
}

/// Number of repeats, and their rate.
fn said(names: &[&str], time: &[f64], fixes: &Fixes) -> String {
    let mut steps: Vec<f64> = time.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    let rate = order::median(&mut steps).map_or(f64::NAN, |step| 1.0 / step);
    format!(
        "{}: {} of {} rows (at {rate:.3} Hz) only repeat the receiver's last fix (fixes at {:.3} \
         Hz); one row of each fix is kept",
        names.join(", "),
        time.len() - fixes.rows.len(),
        time.len(),
        rate / fixes.pace
    )
}

/// Rows in which a channel that rests in between is not as in the row before; none of a channel that does not rest.
fn changes(x: &[f64]) -> Vec<usize> {
    let differs = |i: &usize| {
        let (a, b) = (x[*i - 1], x[*i]);
        a != b && !(a.is_nan() && b.is_nan())
    };
    // counted first: of a channel without repeats the rows would be as many as its samples
    let (mut all, mut next, mut last) = (0, 0, 0);
    for i in (1..x.len()).filter(differs) {
        all += 1;
        next += usize::from(last + 1 == i && last > 0);
        last = i;
    }
    let rests = all >= LEAST_CHANGES && next as f64 <= NEXT_ROW * all as f64;
    if rests { (1..x.len()).filter(differs).collect() } else { Vec::new() }
}

/// How many of some rows are among others; both in order.
fn among(rows: &[usize], others: &[usize]) -> usize {
    rows.iter().filter(|row| others.binary_search(row).is_ok()).count()
}

/// The fixes of channels of the same rows; `None` where their numbers are not held.
fn find(channels: &[&[f64]]) -> Option<Fixes> {
    let len = channels.iter().map(|x| x.len()).min()?;
    let changed: Vec<Vec<usize>> = channels.iter().map(|x| changes(x)).collect();
    let resting: Vec<usize> = (0..channels.len()).filter(|&k| !changed[k].is_empty()).collect();
    let finest = *resting.iter().max_by_key(|&&k| changed[k].len())?;
    let with = |k: &usize| {
        among(&changed[*k], &changed[finest]) as f64 >= TOGETHER * changed[*k].len() as f64
    };
    let members: Vec<usize> = resting.into_iter().filter(with).collect();
    let mut rows: Vec<usize> = members.iter().flat_map(|&k| &changed[k]).copied().collect();
    rows.sort_unstable();
    rows.dedup();
    let both = |row: &&usize| {
        members.iter().filter(|&&k| changed[k].binary_search(row).is_ok()).count() >= 2
    };
    if (rows.iter().filter(both).count() as f64) < SECOND * rows.len() as f64 {
        return None;
    }
    let pace = pace(&rows)?;
    Some(Fixes { rows: with_rests(&rows, pace, len), members, pace })
}

/// Rows per fix, if new numbers come at an even pace.
fn pace(rows: &[usize]) -> Option<f64> {
    // how many steps are of so many rows
    let mut counts = vec![0_usize; 2 * MAX_ROWS_PER_FIX];
    for step in rows.windows(2).map(|w| w[1] - w[0]) {
        if let Some(count) = counts.get_mut(step) {
            *count += 1;
        }
    }
    // a fix may come a row sooner or later, more of a slow receiver
    let evenly = |k: usize| k..=k + 1 + k / 8;
    let even = |k: usize| counts[evenly(k)].iter().sum::<usize>();
    let k = (2..=MAX_ROWS_PER_FIX)
        .max_by_key(|&k| (even(k), MAX_ROWS_PER_FIX - k))
        .filter(|&k| even(k) >= LEAST_CHANGES - 1)?;
    let long = (LONG * (k + 1) as f64).ceil() as usize;
    let judged: usize = counts.iter().take(long).sum();
    let (usual, all) = (even(k) as f64, rows.len() as f64);
    let whole: usize = evenly(k).map(|step| step * counts[step]).sum();
    (usual >= EVEN * judged as f64 && usual >= SECOND * all).then(|| whole as f64 / usual)
}

/// The rows of the fixes, and those in between at the same pace where nothing changed: the bike stood.
fn with_rests(changed: &[usize], pace: f64, len: usize) -> Vec<usize> {
    let mut rows = Vec::with_capacity(changed.len() + 1);
    let mut rest = |from: usize, to: usize| {
        let count = ((to - from) as f64 / pace).round().max(1.0) as usize;
        rows.extend(
            (0..count).map(|j| from + (j as f64 * pace).round() as usize).filter(|r| *r < to),
        );
    };
    // what stands in the first rows may be any age, unless it is a whole fix
    let first = changed.first().copied().unwrap_or(len);
    if first as f64 > pace - 1.0 {
        let age = first as f64 % pace;
        let from = if age < 1.0 || pace - age < 1.0 { 0 } else { age.round() as usize };
        rest(from, first);
    }
    changed.windows(2).for_each(|w| rest(w[0], w[1]));
    if let Some(&last) = changed.last() {
        let whole = ((len - last) as f64 / pace).floor().max(1.0);
        rest(last, (last + (whole * pace).round() as usize).min(len));
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A ride of 100 s in rows at `rate`, new numbers at `fixes` Hz: latitude, longitude, speed, course.
    fn ridden(rate: f64, fixes: f64) -> (Vec<f64>, [Vec<f64>; 4]) {
        let time: Vec<f64> = (0..(100.0 * rate) as usize).map(|i| i as f64 / rate).collect();
        let at = |t: &f64| (t * fixes + 1e-9).floor() / fixes;
        let of = |f: &dyn Fn(f64) -> f64| time.iter().map(|t| f(at(t))).collect::<Vec<f64>>();
        let all = [
            of(&|t| 47.0 + 1e-4 * t + 2e-5 * (0.2 * t).sin()),
            of(&|t| 8.0 + 1e-4 * (0.3 * t).sin()),
            of(&|t| (1e2 * (15.0 + 4.0 * (0.4 * t).sin())).round() / 1e2),
            of(&|t| (40.0 * (0.3 * t).cos()).round()),
        ];
        (time, all)
    }

    fn found(channels: &[Vec<f64>]) -> Option<Fixes> {
        let all: Vec<&[f64]> = channels.iter().map(|x| &x[..]).collect();
        find(&all)
    }

    fn tracks(time: Vec<f64>, all: [Vec<f64>; 4]) -> Vec<Track> {
        let time = Arc::new(time);
        let channels = [Channel::Latitude, Channel::Longitude, Channel::VelocityX, Channel::Yaw];
        let track = |(channel, values)| Track { channel, time: Arc::clone(&time), values };
        channels.into_iter().zip(all).map(track).collect()
    }

    #[test]
    fn held_numbers_are_thinned_to_the_fixes() {
        for (rate, fixes, rows) in [
            (10.0, 1.0, 100),
            (10.0, 2.0, 200),
            (10.0, 5.0, 500),
            (10.0, 4.0, 400),
            (25.0, 10.0, 1000),
            (100.0, 5.0, 500),
        ] {
            let (time, all) = ridden(rate, fixes);
            let fine = time.iter().map(|t| t.sin()).collect();
            let mut tracks = tracks(time, all);
            let wheel =
                Track { channel: Channel::WheelSpeedFront, values: fine, ..tracks[0].clone() };
            tracks.push(wheel);
            let mut warnings = Vec::new();
            thin(&mut tracks, &mut warnings);
            let all_rows = (100.0 * rate) as usize;
            for track in &tracks[..4] {
                assert_eq!(track.time.len(), rows, "{fixes} Hz in {rate}: {}", track.channel);
                assert_eq!(track.values.len(), rows);
                assert!(Arc::ptr_eq(&track.time, &tracks[0].time));
                // each is of the first row of its fix
                let late = track.time.iter().map(|t| (t * fixes + 1e-6).fract() / fixes);
                assert!(late.fold(0.0, f64::max) < 1.0 / rate);
            }
            assert_eq!(tracks[4].values.len(), all_rows, "another sensor's");
            let [w] = &warnings[..] else { panic!("{warnings:?}") };
            assert_eq!((w.code, w.count), ("repeated_fixes", all_rows - rows));
            assert!(w.message.contains(&format!("(fixes at {fixes:.3} Hz)")), "{}", w.message);
        }
    }

    #[test]
    fn a_receiver_as_fast_as_the_rows_keeps_every_row() {
        let (_, all) = ridden(10.0, 10.0);
        assert_eq!(found(&all), None);
        // position and speed in coarse steps change at their own times
        let coarse = |x: &[f64], step: f64| x.iter().map(|v| (v / step).round() * step).collect();
        let steps = [coarse(&all[0], 1e-3), coarse(&all[1], 1e-4), coarse(&all[2], 1.0)];
        assert_eq!(found(&steps), None);
        assert_eq!(found(&[all[2].clone(), vec![3.0; all[2].len()]]), None);
        assert_eq!(found(&[vec![0.0; 500], vec![0.0; 500]]), None, "it never moved");
    }

    #[test]
    fn a_motorcycle_that_stands_loses_no_time() {
        let (time, mut all) = ridden(10.0, 1.0);
        for x in &mut all {
            let stands = x[300];
            x[300..600].fill(stands);
        }
        let mut tracks = tracks(time, all);
        thin(&mut tracks, &mut Vec::new());
        let steps = tracks[0].time.windows(2).map(|w| w[1] - w[0]);
        assert!(steps.fold(0.0, f64::max) < 1.3, "{:?}", tracks[0].time);
        assert_eq!(tracks[0].time.len(), 100);
        // all at 10 Hz but for the stop
        let (_, mut fast) = ridden(10.0, 10.0);
        for x in &mut fast {
            let stands = x[300];
            x[300..600].fill(stands);
        }
        assert_eq!(found(&fast), None);
    }

    #[test]
    fn what_changes_in_other_rows_is_of_another_device() {
        let (time, all) = ridden(10.0, 1.0);
        let speed: Vec<f64> = time.iter().map(|t| 15.0 + t.sin()).collect();
        let [lat, lon, _, course] = all;
        let mut tracks = tracks(time, [lat, lon, speed, course]);
        thin(&mut tracks, &mut Vec::new());
        let lengths: Vec<usize> = tracks.iter().map(|t| t.values.len()).collect();
        assert_eq!(lengths, [100, 100, 1000, 100]);
    }

    #[test]
    fn a_delay_of_some_channels_does_not_part_a_receiver() {
        let (time, all) = ridden(10.0, 2.0);
        let mut tracks = tracks(time, all);
        let earlier = Arc::new(tracks[2].time.iter().map(|t| t - 0.3).collect::<Vec<f64>>());
        tracks[2].time = earlier;
        let mut warnings = Vec::new();
        thin(&mut tracks, &mut warnings);
        assert_eq!(warnings.len(), 1);
        assert!(tracks.iter().all(|t| t.values.len() == 200 && t.time.len() == 200));
        assert!((tracks[2].time[0] - tracks[0].time[0] + 0.3).abs() < 1e-12);
    }

    #[test]
    fn fixes_that_come_a_row_late_are_of_an_even_pace() {
        let rows: Vec<usize> = (0..60).map(|i| 10 * i + [0, 1, 0, 1, 0][i % 5]).collect();
        assert!((pace(&rows).expect("even") - 10.0).abs() < 0.2);
        let uneven: Vec<usize> = (0..60).map(|i| 10 * i + (7 * i * i) % 9).collect();
        assert_eq!(pace(&uneven), None);
    }
}
