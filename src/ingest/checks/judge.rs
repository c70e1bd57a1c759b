//! A log's channels judged by their motion: decoded part by part, each only as long as it takes.

use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::detect::format_of;
use crate::ingest::formats::format::Decoder;
use crate::ingest::formats::listing::{Decoded, SourceChannel};
use crate::ingest::formats::survey::{Survey, parts};
use crate::ingest::maps::ChannelMap;
use crate::ingest::maps::propose;
use crate::ingest::maps::propose::compare::claims;
use crate::ingest::maps::propose::motion;
use crate::ingest::maps::propose::physics::{Clock, Log, Verdicts, judge};
use crate::store::objects::Location;

/// Channels of a surveyed log by the motion; `radii` are the bike file's, front and rear, m.
///
/// # Errors
/// The log cannot be read.
pub fn by_motion(
    log: &Location,
    aids: &Aids,
    survey: &Survey,
    radii: Option<[f64; 2]>,
) -> Result<Verdicts, Error> {
    by_motion_and_map(log, aids, survey, radii, None)
}

/// The same, with what a map that was fitted to the log makes of its channels: where a channel's name says nothing, the
/// map's word makes it a candidate, so that the motion is asked about it.
///
/// # Errors
/// As [`by_motion`].
pub(crate) fn by_motion_and_map(
    log: &Location,
    aids: &Aids,
    survey: &Survey,
    radii: Option<[f64; 2]>,
    map: Option<&ChannelMap>,
) -> Result<Verdicts, Error> {
    let Some(Decoder { decode, .. }) = format_of(log)?.decoder else {
        return Ok(Verdicts::default());
    };
    let spans = survey.contents.iter().filter_map(|c| c.span);
    let (start, end) =
        spans.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), s| (a.min(s.0), b.max(s.1)));
    if end.is_nan() || end <= start {
        return Ok(Verdicts::default());
    }
    let channels = &survey.listing.channels;
    let claims = map.map_or_else(Vec::new, |map| claims(map, &survey.listing));
    let mut judged = Log::new(channels, Clock::between(start, end)).claimed(&claims);
    let mut place = 0;
    for part in parts(channels) {
        let wanted: Vec<&SourceChannel> = part.iter().collect();
        let Decoded { columns, .. } = decode(log, aids, &wanted)?;
        judged.take(place, columns);
        place += part.len();
    }
    let mut verdicts = judge(&judged, radii);
    for (_, why) in verdicts.left.iter_mut().filter(|(place, _)| judged.is_claimed(*place)) {
        *why = why.replacen("named like", "mapped to", 1);
    }
    Ok(verdicts)
}

/// The draft of a channel map for a log: by its motion, or by names and units where nothing moves.
pub fn draft(log: &Location, survey: &Survey, verdicts: &Verdicts) -> String {
    let Survey { format, own_clock, listing, contents } = survey;
    let name = log.file_stem();
    let extents: Vec<Option<[f64; 3]>> = contents.iter().map(|c| c.extent).collect();
    match verdicts.entries.is_empty() {
        true => propose::propose(&name, format, *own_clock, listing, &extents),
        false => motion::draft(&name, format, *own_clock, listing, verdicts),
    }
}
