//! Repair of recorded stamps.
//!
//! A logger's stamps may repeat, jump back, be missing or jitter around the instants at which
//! the samples were really taken. Afterwards they strictly increase, and where the source is
//! evidently periodic they lie on straight lines over the row number, so that the phase of the
//! signals is that of the sampling and not of the stamping.

use std::sync::Arc;

pub(crate) mod extent;
pub(crate) mod gaps;
pub(crate) mod grid;
pub(crate) mod held;
pub(crate) mod resample;
mod single;
pub(crate) mod stamps;
mod together;
pub(crate) mod wraps;

use single::Repaired;
pub(crate) use single::{Clock, longest, spread};

use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest::error::Error;
use crate::ingest::raw::Track;

/// A channel on a repaired clock.
#[derive(Debug, Clone)]
pub(crate) struct Timed {
    pub channel: Channel,
    /// Index of its clock.
    pub clock: usize,
    /// SI values, NaN where there is none; as many as the clock's stamps.
    pub values: Vec<f64>,
}

/// A log with repaired clocks.
#[derive(Debug, Clone)]
pub(crate) struct Clocked {
    /// The clocks, each shared by the channels that were logged together.
    pub clocks: Vec<Clock>,
    pub tracks: Vec<Timed>,
}

/// A recorded clock, who uses it and what became of it.
struct Source {
    time: Arc<Vec<f64>>,
    channels: Vec<Channel>,
    repaired: Option<Repaired>,
}

/// Repairs every clock; channels that share one keep sharing it, and the clocks of one logger stay together
/// ([`together`]).
///
/// # Errors
/// `no_time` when no channel has two usable stamps, `too_short` under 1 s.
pub(crate) fn repair(tracks: Vec<Track>, warnings: &mut Vec<Warning>) -> Result<Clocked, Error> {
    let mut sources: Vec<Source> = Vec::new();
    let mut source_of = Vec::with_capacity(tracks.len());
    let mut rows = 0;
    for track in &tracks {
        rows = rows.max(track.time.len());
        let known = sources.iter().position(|s| Arc::ptr_eq(&s.time, &track.time));
        let at = known.unwrap_or_else(|| {
            let time = Arc::clone(&track.time);
            sources.push(Source { time, channels: Vec::new(), repaired: None });
            sources.len() - 1
        });
        sources[at].channels.push(track.channel);
        source_of.push(at);
    }
    let times: Vec<Arc<Vec<f64>>> = sources.iter().map(|s| Arc::clone(&s.time)).collect();
    for (source, repaired) in sources.iter_mut().zip(together::repair(&times)) {
        source.repaired = repaired;
    }
    let mut out = Clocked { clocks: Vec::new(), tracks: Vec::with_capacity(tracks.len()) };
    let several = sources.len() > 1;
    let mut clock_of = Vec::with_capacity(sources.len());
    for Source { channels, repaired, .. } in &sources {
        clock_of.push(out.clocks.len());
        if let Some(repaired) = repaired {
            repaired.report(if several { channels } else { &[] }, warnings);
            out.clocks.push(repaired.clock.clone());
        }
    }
    for (track, at) in tracks.into_iter().zip(source_of) {
        let Some(repaired) = &sources[at].repaired else { continue };
        let values = match &repaired.kept {
            None => track.values,
            Some(kept) => kept.iter().map(|&i| track.values[i]).collect(),
        };
        out.tracks.push(Timed { channel: track.channel, clock: clock_of[at], values });
    }
    let (start, end) = out.span();
    if out.tracks.is_empty() {
        let code = if rows < 2 { RejectionCode::TooShort } else { RejectionCode::NoTime };
        let message = format!("no channel has two usable time stamps ({rows} rows)");
        return Err(Error::new(code, message));
    }
    if end - start < 1.0 {
        let message =
            format!("only {:.3} s of usable time in {rows} rows; 1 s is the least", end - start);
        return Err(Error::new(RejectionCode::TooShort, message));
    }
    Ok(out)
}

impl Clocked {
    /// First and last stamp of all, s.
    pub(crate) fn span(&self) -> (f64, f64) {
        self.clocks.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(start, end), clock| {
            let first = clock.stamps.first().copied().unwrap_or(start);
            let last = clock.stamps.last().copied().unwrap_or(end);
            (start.min(first), end.max(last))
        })
    }
}
