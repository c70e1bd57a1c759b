//! Logs of other sources: what all formats with channels of their own have in common.
//!
//! A format is one file with a [`Format`]: [`list`](Format::list) says which channels a log has,
//! [`decode`](Format::decode) gives the wanted ones, in the log's own units and on its own
//! clocks. All else is here, once: which channel map fits, which channel a name means, whether
//! the map's units are the log's.
//!
//! ```text
//! list -> choose a map -> fit it to the log (names, units) -> decode -> ChannelMap::apply -> Raw
//! ```
//!
//! A text, whose map also says how it is laid out, has a `Reader` of its own and takes from here
//! what it can: [`fit`] checks a map's names and units against a [`Listing`] made from its header
//! and its row of units, and a [`Look`] lets `inspect` show it and propose a map.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;

use crate::contract::schema;
use crate::contract::session::Meta;
use crate::contract::warning::Warning;
use crate::ingest::map::{self, ChannelMap, Column, Entry, of_format};
use crate::ingest::{Error, Head, Raw, Reader, ident, units};
use crate::objects::Location;

/// A format whose logs bring channels and clocks of their own.
pub trait Format {
    /// Its name, as in `format` of a channel map.
    const NAME: &'static str;

    /// Whether a file is of this format.
    fn sniff(head: &Head<'_>) -> bool;

    /// What is in a log, without decoding samples where the format allows that.
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

/// What a log cannot be understood without and does not hold itself; a channel map brings it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Aids {
    /// Texts of CAN databases (DBC).
    pub dbc: Vec<String>,
    /// Their names, for people.
    pub names: Vec<String>,
}

impl Aids {
    /// Reads the files.
    ///
    /// # Errors
    /// A sentence that names the file.
    pub fn read(dbc: &[PathBuf]) -> Result<Self, String> {
        let names = dbc.iter().map(|path| path.display().to_string()).collect();
        let dbc = dbc.iter().map(|path| map::read_dbc(path)).collect::<Result<_, String>>()?;
        Ok(Aids { dbc, names })
    }
}

/// What is in a log.
#[derive(Debug, Clone, Default)]
pub struct Listing {
    /// Its channels, those of one group one after the other.
    pub channels: Vec<SourceChannel>,
    /// Who and when, as far as the log says it in these words.
    pub meta: Meta,
    /// What else it says of itself (vehicle, logger, comment, ...), for people.
    pub facts: Vec<(String, String)>,
    /// What was noticed.
    pub warnings: Vec<Warning>,
    /// TOML that a channel map for such a log needs besides its channels: the layout of a text,
    /// say. Empty for most formats.
    pub layout: String,
}

/// A channel as the log tells it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SourceChannel {
    /// What it was logged with (a group, topic or message); empty if the format knows none.
    pub group: String,
    /// Its name.
    pub name: String,
    /// Its unit, as it is written there; `None` where the log gives none.
    pub unit: Option<String>,
    /// Samples, where that is known without decoding.
    pub samples: Option<u64>,
    /// Rate, Hz, where the log gives it.
    pub rate: Option<f64>,
    /// Where the format finds it again: its own business.
    pub place: [usize; 3],
}

/// Decoded channels.
#[derive(Debug, Default)]
pub struct Decoded {
    /// As asked for. Channels that were logged together share their clock.
    pub columns: Vec<Column>,
    /// What was noticed beyond what [`Listing::warnings`] says.
    pub warnings: Vec<Warning>,
}

/// Looking at a log without a channel map.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    /// As [`Format::list`].
    pub list: fn(&Location, &Aids) -> Result<Listing, Error>,
    /// As [`Format::decode`].
    pub decode: fn(&Location, &Aids, &[&SourceChannel]) -> Result<Decoded, Error>,
}

/// The reader of a format.
pub const fn reader<F: Format>() -> Reader {
    Reader {
        name: F::NAME,
        sniff: F::sniff,
        own_clock: true,
        identify: identify::<F>,
        read: read::<F>,
        map: map::<F>,
        look: Some(Look { list: F::list, decode: F::decode }),
    }
}

impl SourceChannel {
    /// Group and name.
    pub fn full(&self) -> String {
        if self.group.is_empty() {
            self.name.clone()
        } else {
            format!("{}/{}", self.group, self.name)
        }
    }

    /// Whether a map means this channel by `text`: its name, or group and name with `/` or `.`
    /// between.
    fn is_called(&self, text: &str) -> bool {
        let with_group = || {
            let rest = text.strip_prefix(self.group.as_str())?.strip_prefix(['/', '.'])?;
            Some(rest == self.name)
        };
        text == self.name || (!self.group.is_empty() && with_group() == Some(true))
    }
}

impl Listing {
    /// The one channel that is called so.
    ///
    /// # Errors
    /// `missing_column`, `ambiguous_column`: a sentence about the name.
    pub fn find(&self, name: &str) -> Result<&SourceChannel, Error> {
        if let Some(exact) = self.channels.iter().find(|c| c.full() == name) {
            return Ok(exact);
        }
        let mut called = self.channels.iter().filter(|c| c.is_called(name));
        let Some(first) = called.next() else {
            return Err(Error::new("missing_column", self.unknown(name)));
        };
        let others: Vec<String> = called.map(SourceChannel::full).collect();
        if others.is_empty() {
            return Ok(first);
        }
        let message = format!(
            "`{name}` is in the log several times: {}, {}; say which",
            first.full(),
            others.join(", ")
        );
        Err(Error::new("ambiguous_column", message))
    }

    fn unknown(&self, name: &str) -> String {
        let full: Vec<String> = self.channels.iter().map(SourceChannel::full).collect();
        let names = self.channels.iter().map(|c| c.name.as_str());
        let near = schema::nearest(name, names.chain(full.iter().map(String::as_str)));
        let near = near.map(|near| format!("; did you mean `{near}`?")).unwrap_or_default();
        format!("`{name}` is not in the log{near}")
    }

    /// Whether a map was written for logs like this one.
    fn is_for(&self, map: &ChannelMap) -> bool {
        // `*` is every log of the format
        let there = |name: &String| name == "*" || self.channels.iter().any(|c| c.is_called(name));
        !map.detect.is_empty() && map.detect.iter().all(there)
    }

    /// The channels' names, for messages.
    fn names(&self) -> String {
        let names: Vec<String> = self.channels.iter().map(SourceChannel::full).collect();
        names.join(", ").chars().take(300).collect()
    }
}

/// A channel map as it is for one log: every `from` is a channel's full name, every unit agreed
/// with the log's own, and the entries of an `optional` map that the log has nothing for are
/// gone.
///
/// # Errors
/// A name or a unit that does not fit, in a sentence that names the map and the entry.
pub fn fit(map: &ChannelMap, listing: &Listing) -> Result<ChannelMap, Error> {
    let mut fitted = map.clone();
    fitted.entries.clear();
    for entry in &map.entries {
        let fail = |e: Error| {
            let place = format!("channel map {}, [channel.{}]", map.name, entry.channel);
            Error::new(e.code, format!("{place}: {}", e.message))
        };
        let found = match first_of(entry, listing) {
            Ok(found) => found,
            Err(e) if map.optional && e.code == "missing_column" => continue,
            Err(e) => return Err(fail(e)),
        };
        fitted.entries.push(entry_for(entry, &found).map_err(fail)?);
    }
    if fitted.entries.is_empty() {
        let message = format!("channel map {} takes nothing from this log", map.name);
        return Err(Error::new("no_channel_map", message));
    }
    Ok(fitted)
}

/// What an entry is `from`, or the first of `or` that the log has.
fn first_of<'a>(entry: &Entry, listing: &'a Listing) -> Result<Vec<&'a SourceChannel>, Error> {
    let all = |names: &[String]| -> Result<Vec<&'a SourceChannel>, Error> {
        names.iter().map(|name| listing.find(name)).collect()
    };
    let missing = |found: &Result<_, Error>| {
        found.as_ref().is_err_and(|e: &Error| e.code == "missing_column")
    };
    let from = all(&entry.from);
    if !missing(&from) {
        return from;
    }
    let others = entry.or.iter().map(|name| all(std::slice::from_ref(name)));
    others.into_iter().find(|found| !missing(found)).unwrap_or(from)
}

fn entry_for(entry: &Entry, found: &[&SourceChannel]) -> Result<Entry, Error> {
    let mut agreed = entry.clone();
    agreed.from = found.iter().map(|c| c.full()).collect();
    for channel in found {
        let unit = agreed_unit(entry, channel)?;
        let several = found.len() > 1 && channel != &found[0];
        if several && units::same(&unit, &agreed.unit) != Some(true) {
            let message = format!(
                "`{}` is in {}, `{}` in {unit}: no mean of different units",
                found[0].full(),
                agreed.unit,
                channel.full()
            );
            return Err(Error::new("unit_mismatch", message));
        }
        agreed.unit = unit;
    }
    agreed.convert().map_err(|e| Error::new("unknown_unit", e))?;
    Ok(agreed)
}

/// The unit of a channel, by the map and the log: where both say one they must not contradict.
fn agreed_unit(entry: &Entry, channel: &SourceChannel) -> Result<String, Error> {
    let own = channel.unit.as_deref().map(str::trim).filter(|u| !u.is_empty());
    let name = channel.full();
    match (entry.unit_given, own) {
        (true, None) => Ok(entry.unit.clone()),
        (true, Some(own)) => {
            // with a scale it is another number that the unit is of
            let free = entry.scale != 1.0 || entry.file_unit.as_deref() == Some(own);
            if free || units::same(&entry.unit, own) != Some(false) {
                return Ok(entry.unit.clone());
            }
            let message = format!(
                "the log says that `{name}` is in {own}, the map says {}; take `unit` out, or if \
                 the log is wrong add `file_unit = \"{own}\"`",
                entry.unit
            );
            Err(Error::new("unit_mismatch", message))
        }
        (false, Some(own)) => match entry.converted(own) {
            Ok(_) => Ok(own.to_owned()),
            Err(e) => {
                let message = format!("`{name}`: the log gives the {e}; say it with `unit`");
                Err(Error::new("unknown_unit", message))
            }
        },
        (false, None) if entry.unit == "1" => Ok(entry.unit.clone()),
        (false, None) => {
            let message = format!(
                "the log gives no unit for `{name}`; say it in the map, e.g. `unit = \"{}\"`",
                entry.unit
            );
            Err(Error::new("unknown_unit", message))
        }
    }
}

/// The map that is taken for a log, fitted to it, and the log's listing.
fn choose<F: Format>(log: &Location, maps: &[ChannelMap]) -> Result<(ChannelMap, Listing), Error> {
    let candidates = of_format(maps, F::NAME);
    let mut listed: Option<(&Aids, Listing)> = None;
    for &map in &candidates {
        let listing = match listed.take() {
            Some((aids, listing)) if *aids == map.aids => listing,
            _ => F::list(log, &map.aids)?,
        };
        // a single map that was asked for is used even if it does not claim the log
        let asked = candidates.len() == 1 && !maps.is_empty();
        if asked || listing.is_for(map) {
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
        return Err(Error::new("no_channel_map", message.chars().take(600).collect::<String>()));
    }
    let tried: Vec<&str> = candidates.iter().map(|m| m.name.as_str()).collect();
    let tried = if tried.is_empty() { "none" } else { &tried.join(", ") };
    Err(Error::new(
        "no_channel_map",
        format!(
            "no channel map of format {} fits {} (tried {tried}); its channels are {}; \
             `roadbench inspect` proposes a map for it",
            F::NAME,
            log,
            listing.names()
        ),
    ))
}

fn identify<F: Format>(log: &Location, maps: &[ChannelMap]) -> Result<Meta, Error> {
    let (map, listing) = choose::<F>(log, maps)?;
    Ok(who(log, &listing, &map))
}

/// The log's word first, then its path's, then the map's.
fn who(log: &Location, listing: &Listing, map: &ChannelMap) -> Meta {
    ident::or(listing.meta.clone(), ident::or(ident::from_path(log), map.meta.clone()))
}

fn map<F: Format>(log: &Location, maps: &[ChannelMap]) -> Result<Option<ChannelMap>, Error> {
    choose::<F>(log, maps).map(|(map, _)| Some(map))
}

fn read<F: Format>(log: &Location, maps: &[ChannelMap]) -> Result<Raw, Error> {
    let (map, listing) = choose::<F>(log, maps)?;
    let wanted: Vec<&SourceChannel> =
        map.needed().into_iter().map(|name| listing.find(name)).collect::<Result<_, Error>>()?;
    let Decoded { columns, warnings } = F::decode(log, &map.aids, &wanted)?;
    let meta = who(log, &listing, &map);
    let mut all = listing.warnings;
    all.extend(warnings);
    Ok(Raw { meta, tracks: map.apply(columns)?, warnings: all, euler_yaw: map.euler_yaw })
}

/// A library that reads damaged bytes may panic; that is an unreadable log, not our end.
pub(super) fn guarded<T>(
    log: &Location,
    work: impl FnOnce() -> Result<T, String>,
) -> Result<T, Error> {
    let damaged = |what: &str| Error::new("unreadable", format!("{log} is damaged: {what}"));
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(done) => done.map_err(|message| damaged(&message)),
        Err(_) => Err(damaged("its parts make no sense")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::channel::Channel;

    fn listing(channels: &[(&str, &str, Option<&str>)]) -> Listing {
        let channel = |&(group, name, unit): &(&str, &str, Option<&str>)| SourceChannel {
            group: group.into(),
            name: name.into(),
            unit: unit.map(str::to_owned),
            ..SourceChannel::default()
        };
        Listing { channels: channels.iter().map(channel).collect(), ..Listing::default() }
    }

    fn map(more: &str) -> ChannelMap {
        ChannelMap::parse(&format!("name = 'm'\nformat = 'kiro'\n{more}"), "m.toml").expect("a map")
    }

    #[test]
    fn names_are_found_with_and_without_their_group() {
        let log = listing(&[("IMU", "roll", None), ("GPS", "v", None), ("ECU", "v", None)]);
        assert_eq!(log.find("roll").expect("unique").group, "IMU");
        assert_eq!(log.find("ECU.v").expect("named").group, "ECU");
        assert_eq!(log.find("GPS/v").expect("named").group, "GPS");
        let error = log.find("v").expect_err("twice");
        assert_eq!(error.code, "ambiguous_column");
        assert!(error.message.contains("GPS/v, ECU/v"), "{error}");
        let error = log.find("Rol").expect_err("misspelt");
        assert!(error.message.contains("did you mean `roll`"), "{error}");
    }

    #[test]
    fn units_of_map_and_log_must_agree() {
        let log = listing(&[
            ("", "v", Some("km/h")),
            ("", "lean", Some("Grad")),
            ("", "steer", None),
            ("", "gear", None),
        ]);
        let roll = "[channel.roll]\nfrom = 'lean'\n";
        let cases = [
            ("[channel.velocity_x]\nfrom = 'v'\nunit = 'm/s'\n", "unit_mismatch", "file_unit"),
            (roll, "unknown_unit", "`Grad`"),
            ("[channel.steer_angle]\nfrom = 'steer'\n", "unknown_unit", "no unit for `steer`"),
            ("[channel.velocity_x]\nfrom = 'lean'\n", "unknown_unit", "Grad"),
        ];
        for (text, code, words) in cases {
            let error = fit(&map(text), &log).expect_err(text);
            assert_eq!(error.code, code, "{error}");
            assert!(
                error.message.contains(words) && error.message.contains("[channel."),
                "{error}"
            );
        }
        let factor = |text: &str| fit(&map(text), &log).expect(text).entries[0].to_si.factor;
        let v = |more: &str| factor(&format!("[channel.velocity_x]\nfrom = 'v'\n{more}"));
        assert!((v("") - 1.0 / 3.6).abs() < 1e-12);
        assert!((v("unit = 'kph'") - 1.0 / 3.6).abs() < 1e-12);
        assert_eq!(v("unit = 'm/s'\nfile_unit = 'km/h'"), 1.0);
        assert_eq!(v("unit = 'm/s'\nscale = 0.5"), 0.5);
        assert!((factor(&format!("{roll}unit = 'deg'")) - 1_f64.to_radians()).abs() < 1e-12);
        assert_eq!(factor("[channel.gear]\nfrom = 'gear'\n"), 1.0);
    }

    #[test]
    fn optional_maps_lose_what_is_not_there() {
        let log = listing(&[("", "v", Some("m/s"))]);
        let text = "[channel.velocity_x]\nfrom = 'v'\n[channel.roll]\nfrom = 'x'\n";
        let error = fit(&map(text), &log).expect_err("x is missing");
        assert!(error.message.contains("[channel.roll]"), "{error}");
        let fitted = fit(&map(&format!("optional = true\n{text}")), &log).expect("v is there");
        assert_eq!(fitted.entries.len(), 1);
        assert_eq!(fitted.entries[0].channel, Channel::VelocityX);
        let none = fit(&map("optional = true\n[channel.roll]\nfrom = 'x'\n"), &log);
        assert_eq!(none.expect_err("nothing").code, "no_channel_map");
    }
}
