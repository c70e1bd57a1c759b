//! Any log to one [`Session`] on one clean clock.
//!
//! ```text
//! file -> format (FORMATS) -> Raw: SI tracks, each on its source's own clock
//!      -> run: clocks repaired, faults taken out, one common clock -> Session
//!      -> check: channels against physics, given the bike
//! ```
//!
//! A new format is one file in [`formats`] (mostly a [`formats::format::Format`]: what is in the log, and the
//! wanted channels of it) and one line in [`formats::FORMATS`]. A new source of a known format is one
//! channel map ([`maps`]), no code; [`maps::propose`] drafts one.

use std::sync::Arc;

use crate::contract::channel::Channel;
use crate::contract::instant;
use crate::contract::session::{Meta, Session};
use crate::contract::warning::Warning;
use crate::store::objects::{Location, source};

pub(crate) mod checks;
pub(crate) mod clock;
pub(crate) mod config;
pub(crate) mod error;
pub(crate) mod formats;
mod ident;
pub(crate) mod maps;
pub(crate) mod motion;
pub(crate) mod raw;
mod session_schema;
mod warning;
pub(crate) mod write;

pub(crate) use checks::{check, look};
pub(crate) use clock::extent::extent;
pub(crate) use config::Config;
pub(crate) use error::Error;
pub(crate) use formats::detect::format_of;
pub(crate) use raw::{Identified, Raw, Track};
pub(crate) use write::{session_bytes, write_session};

use checks::clean;
use clock::held::{RECEIVER, SPEEDS, same_rows};
use clock::{resample, stamps};
use maps::ChannelMap;
use maps::file::or_shipped;
use motion::{inertial, receiver, yaw};

/// Session, bike, start time and channel map, without reading the samples.
///
/// `maps` are the channel maps to choose from; an empty slice means [`maps::file::shipped`].
///
/// # Errors
/// The file cannot be read or is of no known kind, or it names itself in a way that cannot be
/// a file name (`bad_bike_id`, `bad_session_id`).
pub fn identify(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Identified, Error> {
    let log = &log.into();
    let identified = whole(log, || (format_of(log)?.identify)(log, or_shipped(maps)));
    let Identified { meta, map } = identified?;
    Ok(Identified { meta: ident::checked(meta)?, map })
}

/// Reads a log of any known format.
///
/// `maps` as in [`identify`].
///
/// # Errors
/// The file cannot be read, or lacks what every session needs.
pub fn read(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Raw, Error> {
    let log = &log.into();
    let mut raw = whole(log, || (format_of(log)?.read)(log, or_shipped(maps)))?;
    if let Some(why) = source::broken(log) {
        let message =
            format!("the packed log is damaged or cut off ({why}); read as far as it was unpacked");
        raw.warnings.push(warning::warning("truncated", None, 1, None, message));
    }
    no_fix(&mut raw);
    stamps::check::by_motion(&raw.tracks)?;
    let start = raw.meta.start_time.clone();
    raw.meta = ident::checked(raw.meta)?;
    if let (Some(start), None) = (start, &raw.meta.start_time) {
        let years = instant::YEARS;
        let message = format!(
            "the log says that it began at `{start}`, which is no time of the years {} to {}; the session has no start time",
            years.start,
            years.end - 1
        );
        raw.warnings.push(warning::warning("implausible_start_time", None, 1, None, message));
    }
    Ok(raw)
}

/// Takes out positions that no receiver gave, and what it wrote for its other channels there, with a warning.
fn no_fix(raw: &mut Raw) {
    let place = |raw: &Raw, channel| raw.tracks.iter().position(|t| t.channel == channel);
    let (Some(north), Some(east)) = (place(raw, Channel::Latitude), place(raw, Channel::Longitude))
    else {
        return;
    };
    if raw.tracks[north].values.len() != raw.tracks[east].values.len() {
        return;
    }
    let mut longitude = std::mem::take(&mut raw.tracks[east].values);
    let lost = receiver::positions(&mut raw.tracks[north].values, &mut longitude);
    raw.tracks[east].values = longitude;
    let time = Arc::clone(&raw.tracks[north].time);
    let mut others = Vec::new();
    for track in raw.tracks.iter_mut().filter(|t| RECEIVER.contains(&t.channel)) {
        let is_place = [Channel::Latitude, Channel::Longitude].contains(&track.channel);
        if is_place || !same_rows(&time, &track.time) {
            continue;
        }
        let is_speed = SPEEDS.contains(&track.channel);
        if receiver::take_out(&mut track.values, &lost, is_speed) > 0 {
            others.push(track.channel.name());
        }
    }
    let also = match others.is_empty() {
        true => String::new(),
        false => format!(", and so are {} of these rows", others.join(", ")),
    };
    let rows: usize = lost.runs.iter().map(|r| r.0.len()).sum();
    let message = match lost.count {
        0 if also.is_empty() => return,
        0 => {
            format!("{rows} rows have no position: the receiver had no fix; that is missing{also}")
        }
        count => format!(
            "{count} samples have no position (0, 0, or none on a globe): the receiver had no fix; taken as missing{also}"
        ),
    };
    let count = if lost.count > 0 { lost.count } else { rows };
    raw.warnings.push(warning::warning("no_fix", None, count, None, message));
}

/// Reads of a log. Where the system, or a store, did not give it all of the bytes, that is the error, whatever the reader made
/// of the others: a log that ends there looks like one that was cut off.
fn whole<T>(log: &Location, read: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    source::take_fault(log); // of an earlier try
    let read = read();
    match source::take_fault(log) {
        Some(fault) => Err(Error::unreadable(log, &fault)),
        None => read,
    }
}

/// The channel map that [`read`] takes for a log; `None` if it is `session.v1` already.
///
/// # Errors
/// As [`identify`].
pub fn map_for(log: impl Into<Location>, maps: &[ChannelMap]) -> Result<Option<ChannelMap>, Error> {
    let log = &log.into();
    (format_of(log)?.map)(log, or_shipped(maps))
}

/// Repairs the clocks, takes out what no sensor can have meant, and brings every channel onto
/// one clock.
///
/// In this order, each with its warning: rows that repeat a receiver's fix (`repeated_fixes`), stamps (`time_missing`,
/// `time_duplicated`,
/// `time_backwards`, `time_jitter`), values out of the schema's range (`out_of_range`),
/// `spike`, `clipped`, `stuck`, `gap`, `empty_channel`, `down_sampled`; then an inertial unit that is fixed to the
/// frame is brought into the level frame (`level_frame`, `level_frame_doubt`, `no_level_frame`).
///
/// # Errors
/// Nothing usable is left: `no_time`, `too_short`.
pub fn run(raw: Raw, config: &Config) -> Result<(Session, Vec<Warning>), Error> {
    let Raw {
        meta,
        mut tracks,
        mut warnings,
        euler_yaw,
        imu,
        wheel_scale_sd,
        velocity_spacing,
        mut markers,
        zero,
        ..
    } = raw;
    let zero = zero.or_else(|| unix_zero(&meta, &tracks));
    clock::held::thin(&mut tracks, &mut warnings);
    let mut tracks = clock::repair(tracks, &mut warnings)?;
    // before faults are looked for: a course jumps by a whole turn
    let receiver = inertial::take_receiver(&mut tracks);
    clean::clean(&mut tracks, config, &mut warnings);
    let (start, _) = tracks.span();
    let meta = begun(meta, zero, start);
    markers.times.iter_mut().for_each(|t| *t -= start);
    let mut session = resample::onto_one_clock(meta, tracks, config, &mut warnings)?;
    session.wheel_scale_sd = wheel_scale_sd;
    session.velocity_spacing = session.velocity_spacing.max(velocity_spacing);
    session.markers = markers;
    let levelled = inertial::level(&mut session, receiver, imu, &mut warnings);
    if euler_yaw && !levelled {
        yaw::to_trace(&mut session, &mut warnings);
    }
    Ok((session, warnings))
}

/// The stamp at which the start time holds, where the stamps count from 1970 and it is one of them.
fn unix_zero(meta: &Meta, tracks: &[Track]) -> Option<f64> {
    let unix = instant::microseconds(meta.start_time.as_deref()?)? as f64 * 1e-6;
    let first = |t: &Track| t.time.iter().copied().find(|t| t.is_finite());
    tracks.iter().filter_map(first).any(|t| (t - unix).abs() < ROUNDED_UP).then_some(unix)
}

/// Steps of the start time that are not worth a word: it is rounded, s.
const ROUNDED: f64 = 0.5;
/// A start time is of the first stamp where it is no further from it, s.
const ROUNDED_UP: f64 = 2.0;

/// The start of the part of a log that is used.
fn begun(mut meta: Meta, zero: Option<f64>, start: f64) -> Meta {
    let time = meta.start_time.as_deref().and_then(instant::microseconds);
    if let (Some(time), Some(zero)) = (time, zero) {
        let later = start - zero;
        if later.is_finite() && later.abs() > ROUNDED {
            let ms = (time as f64 * 1e-3 + later * 1e3).round();
            meta.start_time = instant::text(ms as i64 * 1000).or(meta.start_time);
        }
    }
    meta
}

#[cfg(test)]
mod tests {
    use std::io::ErrorKind;

    use super::*;
    use crate::contract::rejection::RejectionCode;
    use crate::store::objects::faults;

    #[test]
    fn half_a_log_is_unreadable_whatever_its_reader_made_of_it() {
        let log = Location::from(std::path::Path::new("half.csv"));
        let read = |made: Result<u8, Error>, kind: Option<ErrorKind>| {
            let reader = || {
                kind.into_iter().for_each(|kind| faults::note(&log, &kind.into()));
                made
            };
            whole(&log, reader).map_err(|e| e.code)
        };
        let damaged = || Err(Error::new(RejectionCode::Damaged, "cut off"));
        assert_eq!(read(Ok(7), None), Ok(7));
        assert_eq!(read(damaged(), None), Err(RejectionCode::Damaged));
        for made in [Ok(7), damaged()] {
            assert_eq!(
                read(made, Some(ErrorKind::PermissionDenied)),
                Err(RejectionCode::Unreadable)
            );
        }
        // its end is what every reader comes to
        assert_eq!(read(Ok(7), Some(ErrorKind::UnexpectedEof)), Ok(7));
        assert_eq!(read(Ok(7), None), Ok(7), "what was noted is of one try");
    }

    #[test]
    fn who_does_not_give_a_log_says_whether_it_is_bad() {
        let code = |kind: ErrorKind, log: &str| {
            let log = Location::parse(log).expect("a location");
            Error::unreadable(&log, &kind.into()).code
        };
        for (kind, here, in_a_store) in [
            (ErrorKind::PermissionDenied, RejectionCode::Unreadable, RejectionCode::Unreachable),
            (ErrorKind::NotFound, RejectionCode::Unreadable, RejectionCode::Unreachable),
            (ErrorKind::Other, RejectionCode::Unreadable, RejectionCode::Unreachable),
            (ErrorKind::InvalidData, RejectionCode::Damaged, RejectionCode::Damaged),
            (ErrorKind::UnexpectedEof, RejectionCode::Damaged, RejectionCode::Damaged),
            (ErrorKind::AlreadyExists, RejectionCode::Unreadable, RejectionCode::Changed),
        ] {
            assert_eq!((code(kind, "a.csv"), code(kind, "s3://b/a.csv")), (here, in_a_store));
        }
    }
}
