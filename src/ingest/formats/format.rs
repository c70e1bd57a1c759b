//! What a log format is: one declaration per format, and what formats with channels of their own have
//! in common.
//!
//! A format is one file with a [`Format`]: [`list`](Format::list) gives the channels of a log,
//! [`decode`](Format::decode) the wanted ones, in the log's own units and on its own clocks. All else
//! is here, once: which channel map fits, which channel a name means, whether the map's units are the
//! log's.
//!
//! ```text
//! list -> choose a map -> fit it to the log (names, units) -> decode -> ChannelMap::apply -> Raw
//! ```
//!
//! A text, whose map also says how it is laid out, makes its [`LogFormat`] itself and takes from here
//! what it can: `ingest::fit` checks a map's names and units against a [`Listing`] made from its
//! header and its row of units, and a [`Decoder`] lets `inspect` show it and propose a map.

use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::contract::warning::Warning;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::ident;
use crate::ingest::maps::bind::{fit, is_for};
use crate::ingest::maps::propose::columns_called;
use crate::ingest::maps::{ChannelMap, Maps, ShippedMap};
use crate::ingest::raw::{Identified, Raw};
use crate::ingest::warning::warning;
use crate::store::objects::Location;

/// A log format: everything that the rest of the program has to know of it.
#[derive(Debug)]
pub struct LogFormat {
    /// Its name, as in `format` of a channel map.
    pub name: &'static str,
    /// Description, in a line for people.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub description: &'static str,
    /// Names of its channels in a channel map.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub channel_names: &'static str,
    /// Extensions of file names by which its logs are found in a folder, in lower case.
    pub extensions: &'static [&'static str],
    /// The channel maps of this format that come with the program; the first that fits is taken.
    pub maps: &'static [ShippedMap],
    /// Whether its logs bring their own clocks, so that its maps need no `[time]`.
    pub own_clock: bool,
    /// Whether a file is of this format, from its name and first bytes.
    pub sniff: fn(&Head<'_>) -> bool,
    /// Session, bike and start time, without decoding samples.
    pub identify: fn(&Location, Maps<'_>) -> Result<Identified, Error>,
    pub read: fn(&Location, Maps<'_>) -> Result<Raw, Error>,
    /// The channel map that `read` goes through, if it needs one.
    pub map: fn(&Location, Maps<'_>) -> Result<Option<ChannelMap>, Error>,
    /// Access to its channels without a channel map, if that is possible.
    pub decoder: Option<Decoder>,
}

/// A format whose logs bring channels and clocks of their own.
pub(crate) trait Format {
    /// As [`LogFormat::name`].
    const NAME: &'static str;
    /// As [`LogFormat::description`].
    const DESCRIPTION: &'static str;
    /// As [`LogFormat::channel_names`].
    const CHANNEL_NAMES: &'static str = "channel";
    /// As [`LogFormat::extensions`].
    const EXTENSIONS: &'static [&'static str];
    /// As [`LogFormat::maps`].
    const MAPS: &'static [ShippedMap] = &[];

    /// Whether a file is of this format.
    fn sniff(head: &Head<'_>) -> bool;

    /// Contents of a log, without decoding samples where the format allows that.
    ///
    /// # Errors
    /// The log cannot be read at all; what is damaged in part is a warning.
    fn list(log: &Location, aids: &Aids) -> Result<Listing, Error>;

    /// The wanted channels, in the order asked for, each with the name [`SourceChannel::full`].
    ///
    /// # Errors
    /// As [`list`](Format::list).
    fn decode(log: &Location, aids: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error>;
}

/// Access to a log's channels without a channel map.
#[derive(Debug, Clone, Copy)]
pub struct Decoder {
    /// As [`Format::list`].
    pub list: fn(&Location, &Aids) -> Result<Listing, Error>,
    /// As [`Format::decode`].
    pub decode: fn(&Location, &Aids, &[&SourceChannel]) -> Result<Decoded, Error>,
}

/// Name and first bytes of a log.
#[derive(Debug)]
pub struct Head<'a> {
    pub log: &'a Location,
    /// Its first bytes, at most [`HEAD_LEN`].
    pub bytes: &'a [u8],
}

impl Head<'_> {
    /// Whether the file's name has this extension, in whatever case.
    pub fn has_extension(&self, extension: &str) -> bool {
        self.log.has_extension(extension)
    }
}

/// How much of a file is looked at to recognise its format, bytes.
pub(crate) const HEAD_LEN: u64 = 64 * 1024;

/// The declaration of a format.
pub(crate) const fn format<F: Format>() -> LogFormat {
    LogFormat {
        name: F::NAME,
        description: F::DESCRIPTION,
        channel_names: F::CHANNEL_NAMES,
        extensions: F::EXTENSIONS,
        maps: F::MAPS,
        own_clock: true,
        sniff: F::sniff,
        identify: identify::<F>,
        read: read::<F>,
        map: map::<F>,
        decoder: Some(Decoder { list: F::list, decode: F::decode }),
    }
}

/// The map that is taken for a log, fitted to it, and the log's listing.
fn choose<F: Format>(log: &Location, maps: Maps<'_>) -> Result<(ChannelMap, Listing), Error> {
    let candidates = maps.of_format(F::NAME);
    let mut listed: Option<(&Aids, Listing)> = None;
    for &map in &candidates {
        let listing = match listed.take() {
            Some((aids, listing)) if *aids == map.aids => listing,
            _ => F::list(log, &map.aids)?,
        };
        // a single map that was asked for is used even if it does not claim the log
        let asked = candidates.len() == 1 && maps.given;
        if asked || is_for(map, &listing) {
            return Ok((fit(map, &listing)?, listing));
        }
        listed = Some((&map.aids, listing));
    }
    let listing = match listed {
        Some((_, listing)) => listing,
        None => F::list(log, &Aids::default())?,
    };
    if listing.channels.is_empty() {
        let facts: Vec<String> =
            listing.facts.iter().map(|(name, value)| format!("{name}: {value}")).collect();
        let message = format!(
            "no channel can be read from {} ({}){}",
            log,
            F::NAME,
            if facts.is_empty() { String::new() } else { format!("; {}", facts.join("; ")) }
        );
        return Err(Error::new(
            RejectionCode::NoChannelMap,
            message.chars().take(600).collect::<String>(),
        ));
    }
    let tried: Vec<&str> = candidates.iter().map(|m| m.name.as_str()).collect();
    let tried = if tried.is_empty() { "none" } else { &tried.join(", ") };
    Err(Error::new(
        RejectionCode::NoChannelMap,
        format!(
            "no channel map of format {} fits {} (tried {tried}); its channels are {}; \
             `roadbench inspect` proposes a map for it",
            F::NAME,
            log,
            listing.names()
        ),
    ))
}

fn identify<F: Format>(log: &Location, maps: Maps<'_>) -> Result<Identified, Error> {
    let (map, listing) = choose::<F>(log, maps)?;
    Ok(Identified { meta: who(log, &listing, &map), map: Some(map.name) })
}

/// The log's word first, then its path's, then the map's.
fn who(log: &Location, listing: &Listing, map: &ChannelMap) -> Meta {
    ident::or(listing.meta.clone(), ident::or(ident::from_path(log), map.meta.clone()))
}

fn map<F: Format>(log: &Location, maps: Maps<'_>) -> Result<Option<ChannelMap>, Error> {
    choose::<F>(log, maps).map(|(map, _)| Some(map))
}

fn read<F: Format>(log: &Location, maps: Maps<'_>) -> Result<Raw, Error> {
    let (map, listing) = choose::<F>(log, maps)?;
    let wanted: Vec<&SourceChannel> =
        map.needed().into_iter().map(|name| listing.find(name)).collect::<Result<_, Error>>()?;
    let Decoded { columns, warnings, markers } = F::decode(log, &map.aids, &wanted)?;
    let meta = who(log, &listing, &map);
    let left = left_out(&listing, &wanted, &map).filter(|_| !maps.given);
    let mut all = listing.warnings;
    all.extend(warnings);
    all.extend(left);
    Ok(Raw {
        meta,
        tracks: map.apply(columns)?,
        warnings: all,
        euler_yaw: map.euler_yaw,
        wheel_scale_sd: map.wheel_scale_sd(),
        imu: map.imu,
        markers,
        map: Some(map.name),
        ..Raw::default()
    })
}

/// Names that a warning lists, at most.
const LISTED: usize = 40;

/// Channels that a map of the program leaves out although it has nothing else for the columns that they are named like:
/// a user who did not write the map does not know this. A course adds nothing to the positions that it is of.
fn left_out(listing: &Listing, wanted: &[&SourceChannel], map: &ChannelMap) -> Option<Warning> {
    let has = |column: Channel| map.entries.iter().any(|e| e.channel == column);
    let fed =
        |column: &Channel| has(*column) || (*column == Channel::Yaw && has(Channel::Latitude));
    let unread = listing.channels.iter().filter(|c| !wanted.contains(c));
    let lost = unread.filter(|c| columns_called(&c.name).iter().any(|column| !fed(column)));
    let names: Vec<String> = lost.map(SourceChannel::full).collect();
    if names.is_empty() {
        return None;
    }
    let more = match names.len().checked_sub(LISTED) {
        None | Some(0) => String::new(),
        Some(more) => format!(" and {more} more"),
    };
    let message = format!(
        "not read by channel map {}: {}{more}; `roadbench map LOG` drafts a map that reads what it knows of them",
        map.name,
        names[..names.len().min(LISTED)].join(", ")
    );
    Some(warning("unknown_column", None, names.len(), None, message))
}

/// A library that reads damaged bytes may panic; that is an unreadable log, not our end.
pub(crate) fn guarded<T>(
    log: &Location,
    work: impl FnOnce() -> Result<T, String>,
) -> Result<T, Error> {
    let damaged =
        |what: &str| Error::new(RejectionCode::Damaged, format!("{log} is damaged: {what}"));
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|message| damaged(&message)),
        Err(_) => Err(damaged("its parts contradict each other")),
    }
}
