//! A log without a channel map: what its channels hold.
//!
//! Every channel is decoded once and described; of the samples only so many are in memory at a
//! time (32 million), however many channels the log has.

use std::sync::Arc;

use rayon::prelude::*;

use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::extent::extent;
use crate::ingest::error::Error;
use crate::ingest::formats::detect::format_of;
use crate::ingest::formats::format::Decoder;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::raw::Column;
use crate::statistics::order::upper_median_of;
use crate::store::objects::Location;

/// Samples that are decoded at a time, about.
const BUDGET: u64 = 32 << 20;

/// Samples assumed of a channel whose number of samples is not known.
const ASSUMED_SAMPLES: u64 = 1 << 20;

/// A step between samples is a gap when it is as long as so many usual ones, and ...
const GAP_STEPS: f64 = 2.5;

/// ... at least as long as this, s.
const GAP: f64 = 0.25;

/// A log's channels, described.
#[derive(Debug)]
pub struct Survey {
    /// Name of the format.
    pub format: &'static str,
    /// Whether its logs bring their own clocks.
    pub own_clock: bool,
    /// The channels, as the log lists them.
    pub listing: Listing,
    pub contents: Vec<ChannelContents>,
}

#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelContents {
    /// Samples with a number.
    pub samples: usize,
    /// Samples without one.
    pub missing: usize,
    /// From the usual step, Hz.
    pub rate: Option<f64>,
    /// Steps much longer than the usual one.
    pub gaps: usize,
    /// Longest gap, s.
    pub longest_gap: f64,
    /// First and last stamp, s.
    pub span: Option<(f64, f64)>,
    /// Least, middle and largest number, in the log's own unit.
    pub extent: Option<[f64; 3]>,
}

/// Looks at every channel of a log; `None` for formats that cannot be read without a map.
///
/// # Errors
/// The log cannot be read.
pub fn survey(log: impl Into<Location>, aids: &Aids) -> Result<Option<Survey>, Error> {
    let log = &log.into();
    let format = format_of(log)?;
    let Some(Decoder { list, decode }) = format.decoder else { return Ok(None) };
    let mut listing = list(log, aids)?;
    let mut contents = Vec::with_capacity(listing.channels.len());
    let mut warnings = Vec::new();
    for part in parts(&listing.channels) {
        let wanted: Vec<&SourceChannel> = part.iter().collect();
        let Decoded { columns, warnings: more, .. } = decode(log, aids, &wanted)?;
        contents.extend(look(&columns));
        for warning in more {
            if !warnings.contains(&warning) {
                warnings.push(warning);
            }
        }
    }
    contents.resize(listing.channels.len(), ChannelContents::default());
    listing.warnings.extend(warnings);
    Ok(Some(Survey { format: format.name, own_clock: format.own_clock, listing, contents }))
}

/// Channels in parts that fit the budget, each of neighbours; a group is only split if it
/// is larger than the budget, since its channels are interleaved in the file.
pub(crate) fn parts(channels: &[SourceChannel]) -> Vec<&[SourceChannel]> {
    let size = |channel: &SourceChannel| channel.samples.unwrap_or(ASSUMED_SAMPLES);
    let mut parts = Vec::new();
    let (mut start, mut end, mut sum) = (0, 0, 0_u64);
    for group in channels.chunk_by(|a, b| a.group == b.group) {
        let whole = group.iter().map(size).fold(0, u64::saturating_add);
        if end > start && sum.saturating_add(whole) > BUDGET {
            parts.push(&channels[start..end]);
            (start, sum) = (end, 0);
        }
        for channel in group {
            if end > start && sum.saturating_add(size(channel)) > BUDGET {
                parts.push(&channels[start..end]);
                (start, sum) = (end, 0);
            }
            sum = sum.saturating_add(size(channel));
            end += 1;
        }
    }
    if start < end {
        parts.push(&channels[start..]);
    }
    parts
}

/// Contents of channels. Those of one clock share the results that depend on the clock only.
fn look(columns: &[Column]) -> Vec<ChannelContents> {
    let mut clocks: Vec<&Arc<Vec<f64>>> = Vec::new();
    for column in columns {
        if !clocks.iter().any(|c| Arc::ptr_eq(c, &column.time)) {
            clocks.push(&column.time);
        }
    }
    let told: Vec<Option<ChannelContents>> = clocks.par_iter().map(|c| whole_clock(c)).collect();
    let describe = |column: &Column| {
        let clock = clocks.iter().position(|c| Arc::ptr_eq(c, &column.time));
        let found = extent(&column.values);
        let count = found.map_or(0, |f| f.1);
        let missing = column.values.len() - count;
        match clock.and_then(|i| told[i].as_ref()).filter(|_| missing == 0) {
            Some(clock) => {
                ChannelContents { samples: count, extent: found.map(|f| f.0), ..clock.clone() }
            }
            None => look_closely(column),
        }
    };
    columns.par_iter().map(describe).collect()
}

/// Contents of a clock whose channels miss no sample; `None` if stamps of its own are
/// missing.
fn whole_clock(time: &[f64]) -> Option<ChannelContents> {
    time.iter().all(|t| t.is_finite()).then(|| of_stamps(time))
}

fn look_closely(column: &Column) -> ChannelContents {
    let there = column.time.iter().zip(&column.values);
    let there = there.filter(|(t, v)| t.is_finite() && v.is_finite());
    let (stamps, values): (Vec<f64>, Vec<f64>) = there.map(|(t, v)| (*t, *v)).unzip();
    ChannelContents {
        samples: values.len(),
        missing: column.values.len() - values.len(),
        extent: extent(&values).map(|f| f.0),
        ..of_stamps(&stamps)
    }
}

/// Rate, gaps and span.
fn of_stamps(stamps: &[f64]) -> ChannelContents {
    let mut steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).collect();
    steps.retain(|d| *d > 0.0);
    let period = upper_median_of(&steps);
    let least = period.map_or(f64::INFINITY, |p| GAP.max(GAP_STEPS * p));
    let gaps = steps.iter().filter(|d| **d > least);
    ChannelContents {
        rate: period.map(|p| 1.0 / p),
        gaps: gaps.clone().count(),
        longest_gap: gaps.copied().fold(0.0, f64::max),
        span: stamps.first().copied().zip(stamps.last().copied()),
        ..ChannelContents::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_is_described_by_what_it_holds() {
        let mut time: Vec<f64> = (0..1000).map(|i| f64::from(i) * 0.01).collect();
        time[500..].iter_mut().for_each(|t| *t += 2.0);
        let mut values: Vec<f64> = time.clone();
        values[3] = f64::NAN;
        let time = Arc::new(time);
        let column = |values| Column { name: "x".into(), time: Arc::clone(&time), values };
        let found = look(&[column(time.to_vec()), column(values)]);
        let (whole, seen) = (&found[0], &found[1]);
        assert_eq!((whole.samples, whole.missing, whole.gaps), (1000, 0, 1));
        assert_eq!((whole.rate, whole.longest_gap, whole.span), (seen.rate, 2.01, seen.span));
        assert_eq!((seen.samples, seen.missing, seen.gaps), (999, 1, 1));
        assert!((seen.longest_gap - 2.01).abs() < 1e-9);
        assert!((seen.rate.expect("a rate") - 100.0).abs() < 1e-6);
        assert_eq!(seen.extent.expect("numbers")[0], 0.0);
        let empty = Column { name: "x".into(), time: Arc::default(), values: Vec::new() };
        assert_eq!(look(&[empty]), [ChannelContents::default()]);
    }

    #[test]
    fn parts_hold_every_channel_once() {
        let channel = |samples| SourceChannel { samples, ..SourceChannel::default() };
        let big = Some(BUDGET - 10);
        let channels: Vec<SourceChannel> =
            [big, Some(5), None, Some(3), big, big].into_iter().map(channel).collect();
        let lengths: Vec<usize> = parts(&channels).iter().map(|p| p.len()).collect();
        assert_eq!(lengths, [2, 2, 1, 1]);
        assert!(parts(&[]).is_empty());
        let grouped = |(group, samples): (&str, u64)| SourceChannel {
            group: group.into(),
            samples: Some(samples),
            ..SourceChannel::default()
        };
        let third = BUDGET / 3;
        let channels =
            [("a", third), ("a", third), ("b", third), ("b", third), ("c", BUDGET), ("c", 1)];
        let channels = channels.map(grouped);
        let groups: Vec<&str> = parts(&channels).iter().map(|p| &*p[0].group).collect();
        assert_eq!(groups, ["a", "b", "c", "c"]);
    }
}
