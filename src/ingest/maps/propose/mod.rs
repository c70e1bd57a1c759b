//! A draft of a channel map for a log that none fits.
//!
//! Channels are recognised by the words of their names, by what their units measure, and, where the log has a
//! speed or a position, by its motion ([`physics`]). What is sure enough is an entry; what could be meant is one
//! too, commented out, with the reason. [`compare`] holds a map that there is against the motion.

use std::fmt::Write as _;

use crate::contract::channel::Channel;
use crate::ingest::clock::stamps::names;
use crate::ingest::formats::listing::{ListedClock, Listing, SourceChannel};
use crate::ingest::maps::units;

pub(crate) mod compare;
pub(crate) mod finding;
mod languages;
#[cfg(test)]
mod loggers;
pub(crate) mod mend;
pub(crate) mod motion;
pub(crate) mod physics;
mod words;

use words::{RULES, Rule, words};

/// Most channels of the log that are offered for one column.
const MAX_OFFERED: usize = 4;

/// Least, middle and largest number of a channel.
type Extent = [f64; 3];

/// How well a channel of the log suits a column.
struct Candidate<'a> {
    channel: &'a SourceChannel,
    score: usize,
    /// Why it is only a guess.
    doubt: Option<String>,
}

/// The text of a channel map for such a log: ready to save, and to be checked by its owner.
///
/// `name` becomes the map's; `extents` are the least, middle and largest number of each channel, in the same order, or
/// empty where they are not known.
pub(crate) fn propose(
    name: &str,
    format: &str,
    own_clock: bool,
    listing: &Listing,
    extents: &[Option<Extent>],
) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write_map(&mut out, name, format, own_clock, (listing, extents));
    out
}

fn write_map(
    out: &mut String,
    name: &str,
    format: &str,
    own_clock: bool,
    (listing, extents): (&Listing, &[Option<Extent>]),
) -> std::fmt::Result {
    let found: Vec<(&Rule, Vec<Candidate<'_>>)> =
        RULES.iter().map(|rule| (rule, candidates(rule, format, listing, extents))).collect();
    let sure: Vec<&SourceChannel> = found
        .iter()
        .filter_map(|(_, c)| c.first().filter(|c| c.doubt.is_none()).map(|c| c.channel))
        .collect();
    writeln!(
        out,
        "# A draft: names and units were recognised, nothing else is known. Check each entry, its\n\
         # sign above all: x is forward, y left, z up; in a left-hand corner roll is negative and\n\
         # yaw rate positive (`sign = -1` turns a channel round). `roadbench schema channel_map`\n\
         # lists every key.\n\
         name = {}\nformat = {}",
        quoted(name),
        quoted(format)
    )?;
    if !listing.layout.is_empty() {
        writeln!(out, "\n{}", listing.layout.trim_end())?;
    }
    writeln!(out, "\n# a log with these channels is taken for one of this source\n[detect]")?;
    let mut named: Vec<String> = sure.iter().map(|c| quoted(&called(c, listing))).collect();
    named.dedup();
    named.truncate(6);
    writeln!(out, "columns = [{}]", named.join(", "))?;
    writeln!(out, "\n[meta]\n# bike_id = \"...\" # its bike file is bikes/<bike_id>.toml")?;
    if !own_clock {
        write_time(out, listing)?;
    }
    if sure.is_empty() {
        writeln!(out, "\n[channel]")?;
    }
    for (rule, candidates) in &found {
        for candidate in candidates.iter().take(MAX_OFFERED) {
            write_entry(out, rule, candidate, listing)?;
        }
    }
    let missing: Vec<&str> =
        found.iter().filter(|(_, c)| c.is_empty()).map(|(r, _)| r.channel.name()).collect();
    if !missing.is_empty() {
        writeln!(out, "\n# nothing was recognised as {}", missing.join(", "))?;
    }
    Ok(())
}

/// Whether a channel may hold the stamps of the others by its name and unit, how well its name suits, the smaller the
/// better, and its unit if anything says it.
pub(crate) fn clock(channel: &SourceChannel) -> Option<(usize, Option<&str>)> {
    let (rank, by_name) = names::clock(&channel.name).or_else(|| short_clock(&channel.name))?;
    let own = channel.unit.as_deref().map(str::trim).filter(|u| !u.is_empty());
    let known = own.and_then(units::dimension);
    known.is_none_or(|d| d == "time").then_some((rank, own.filter(|_| known.is_some()).or(by_name)))
}

/// `t_s` and its like: after every other name of a clock.
fn short_clock(name: &str) -> Option<(usize, Option<&'static str>)> {
    let name = names::folded(name);
    let unit =
        ["s", "ms", "us", "ns"].into_iter().find(|unit| name.strip_prefix("t ") == Some(unit))?;
    Some((usize::MAX, Some(unit)))
}

/// Whether a word of another language is one of those that names are made of, or the name of a clock.
pub(crate) fn is_known_word(word: &str) -> bool {
    let plain = names::folded(word);
    languages::english(&plain).is_some() || names::clock(word).is_some()
}

/// The columns that a name may mean.
pub(crate) fn columns_called(name: &str) -> Vec<Channel> {
    let words = words(units::of_name(name).0);
    let is = |rule: &&Rule| name == rule.channel.name() || rule.score(&words).is_some();
    RULES.iter().filter(is).map(|rule| rule.channel).collect()
}

/// Whether a name may mean a column.
pub(crate) fn is_called(name: &str, column: Channel) -> bool {
    columns_called(name).contains(&column)
}

/// The channel whose name is best for a column; of equal ones the first.
pub(crate) fn best_named(channels: &[SourceChannel], column: Channel) -> Option<usize> {
    let rule = RULES.iter().find(|r| r.channel == column)?;
    let score = |c: &SourceChannel| candidate(rule, c).map(|c| c.score);
    let scored = channels.iter().enumerate().filter_map(|(i, c)| Some((score(c)?, i)));
    scored.max_by_key(|(score, i)| (*score, usize::MAX - i)).map(|s| s.1)
}

/// The clock of a log, by its stamps or, where nobody could judge them, by its name.
fn found_clock(listing: &Listing) -> Option<ListedClock> {
    let by_name = || {
        let ranked = listing.channels.iter().enumerate();
        let ranked = ranked.filter_map(|(i, c)| Some((clock(c)?, i)));
        let ((_, unit), channel) = ranked.min_by_key(|((rank, _), i)| (*rank, *i))?;
        Some(ListedClock { channel, unit: unit.map(str::to_owned), ..ListedClock::default() })
    };
    let judged = !listing.layout.is_empty() || listing.clock.is_some();
    listing.clock.clone().or_else(|| by_name().filter(|_| !judged))
}

fn write_time(out: &mut String, listing: &Listing) -> std::fmt::Result {
    let Some(clock) = found_clock(listing) else {
        return writeln!(out, "\n# [time]\n# column = \"...\"\n# unit = \"s\" # or rate = 100");
    };
    writeln!(out)?;
    if let Some(why) = &clock.why {
        writeln!(out, "# {why}")?;
    }
    let name = called(&listing.channels[clock.channel], listing);
    writeln!(out, "[time]\ncolumn = {}", quoted(&name))?;
    match &clock.unit {
        Some(unit) => writeln!(out, "unit = {}", quoted(unit))?,
        None => writeln!(out, "# unit = \"s\"")?,
    }
    match clock.epoch {
        true => {
            writeln!(out, "epoch = true # it tells the day, by UTC where it says no other zone")
        }
        false => Ok(()),
    }
}

fn write_entry(
    out: &mut String,
    rule: &Rule,
    candidate: &Candidate<'_>,
    listing: &Listing,
) -> std::fmt::Result {
    let Candidate { channel, doubt, .. } = candidate;
    let mark = if doubt.is_some() { "# " } else { "" };
    writeln!(out)?;
    if let Some(doubt) = doubt {
        writeln!(out, "# not sure: {doubt}")?;
    }
    if let Some(hint) = rule.hint {
        writeln!(out, "# {hint}")?;
    }
    writeln!(out, "{mark}[channel.{}]", rule.channel)?;
    writeln!(out, "{mark}from = {}", quoted(&called(channel, listing)))?;
    match &channel.unit {
        Some(unit) => writeln!(out, "{mark}unit = {}", quoted(unit))?,
        None if rule.dimension == "ratio" => {}
        None => writeln!(out, "{mark}unit = \"?\"")?,
    }
    if needs_radius(rule, channel) {
        writeln!(out, "{mark}radius = 0.3 # m, that the source computed it with")?;
    }
    if rule.channel == Channel::Yaw && is_compass(channel) {
        writeln!(out, "{mark}sign = -1 # a compass course is positive to the right")?;
    }
    Ok(())
}

/// A direction counted clockwise from north.
fn is_compass(channel: &SourceChannel) -> bool {
    let words = words(units::of_name(&channel.name).0);
    words.iter().any(|w| matches!(w.as_str(), "course" | "bearing" | "heading" | "compass"))
}

/// A channel that says that it is calculated from others.
fn is_calculated(channel: &SourceChannel) -> bool {
    let words = words(units::of_name(&channel.name).0);
    words.iter().any(|w| matches!(w.as_str(), "calc" | "calculated" | "computed"))
}

/// A surface speed where a spin is wanted.
fn needs_radius(rule: &Rule, channel: &SourceChannel) -> bool {
    rule.dimension == "angular rate"
        && channel.unit.as_deref().and_then(units::dimension) == Some("speed")
}

/// The channels that could feed a column, the best first; only the first can be without doubt.
fn candidates<'a>(
    rule: &Rule,
    format: &str,
    listing: &'a Listing,
    extents: &[Option<Extent>],
) -> Vec<Candidate<'a>> {
    // a switch that was never pressed, a sensor that was never connected
    let at_rest = |place: usize| {
        let extent = extents.get(place).copied().flatten();
        rule.is_controlled() && extent.is_some_and(|[least, _, most]| least == most)
    };
    let channels = listing.channels.iter().enumerate().filter(|(place, _)| !at_rest(*place));
    let mut found: Vec<Candidate<'a>> = channels.filter_map(|(_, c)| candidate(rule, c)).collect();
    if rule.channel == Channel::Roll && format == "racechrono" {
        let doubt = "RaceChrono calculates it from the lateral acceleration: it is no measurement";
        found.iter_mut().for_each(|c| c.doubt = Some(doubt.to_owned()));
    }
    for c in found.iter_mut().filter(|c| rule.channel == Channel::Roll && is_calculated(c.channel))
    {
        c.doubt = Some("by its name it is calculated: it is no measurement".to_owned());
    }
    if format == "racechrono" {
        let of_phone = |c: &&mut Candidate<'_>| {
            ["x_", "y_", "z_"].iter().any(|axis| c.channel.name.starts_with(axis))
        };
        for c in found.iter_mut().filter(of_phone) {
            c.doubt = Some("a phone's axes point wherever the phone does".to_owned());
        }
    }
    let of_grip = |c: &Candidate<'_>| rule.is_grip(&words(units::of_name(&c.channel.name).0));
    if found.iter().any(of_grip) && !found.iter().all(of_grip) {
        let doubt = "the log has the rider's grip and the engine's valve: which do you want?";
        found.iter_mut().for_each(|c| c.doubt = Some(doubt.to_owned()));
    }
    found.sort_by_key(|c| std::cmp::Reverse((c.doubt.is_none(), c.score)));
    let best = found.first().map(|c| (c.doubt.is_none(), c.score));
    let equals = found.iter().filter(|c| Some((c.doubt.is_none(), c.score)) == best).count();
    for (i, candidate) in found.iter_mut().enumerate() {
        if candidate.doubt.is_none() && (i > 0 || equals > 1) {
            candidate.doubt = Some("there is more than one such channel".to_owned());
        }
    }
    found
}

fn candidate<'a>(rule: &Rule, channel: &'a SourceChannel) -> Option<Candidate<'a>> {
    let exact = channel.name == rule.channel.name();
    let score = if exact { 100 } else { rule.score(&words(units::of_name(&channel.name).0))? };
    let dimension = channel.unit.as_deref().map(units::dimension);
    let doubt = match dimension {
        Some(Some(d)) if d == rule.dimension => None,
        Some(Some("speed")) if rule.dimension == "angular rate" && rule.is_wheel() => {
            Some("it is a speed: with which radius was it computed?".to_owned())
        }
        // a count or a share without unit
        Some(Some(_)) => return None,
        Some(None) => Some("its unit is not known to roadbench".to_owned()),
        None if rule.dimension == "ratio" => None,
        None => Some("the log does not say its unit".to_owned()),
    };
    Some(Candidate { channel, score, doubt })
}

/// How a map calls a channel: by its name, and its group where that is needed.
fn called(channel: &SourceChannel, listing: &Listing) -> String {
    let alone = listing.channels.iter().filter(|c| c.name == channel.name).count() == 1;
    if alone { channel.name.clone() } else { channel.full() }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::maps::ChannelMap;
    use crate::ingest::maps::bind::fit;

    fn listing(channels: &[(&str, &str, &str)]) -> Listing {
        let channel = |&(group, name, unit): &(&str, &str, &str)| SourceChannel {
            group: group.into(),
            name: name.into(),
            unit: (!unit.is_empty()).then(|| unit.to_owned()),
            ..SourceChannel::default()
        };
        Listing { channels: channels.iter().map(channel).collect(), ..Listing::default() }
    }

    #[test]
    fn a_short_name_with_a_unit_of_time_is_a_clock() {
        let of = |name: &str| {
            let channel = SourceChannel { name: name.into(), ..SourceChannel::default() };
            clock(&channel).map(|c| c.1.map(str::to_owned))
        };
        assert_eq!(of("t_s"), Some(Some("s".to_owned())));
        assert_eq!(of("t ms"), Some(Some("ms".to_owned())));
        assert_eq!(of("t_air"), None);
        assert_eq!(of("ax_s"), None);
    }

    #[test]
    fn a_draft_is_a_map_that_fits() {
        let log = listing(&[
            ("GPS", "GPS Speed", "km/h"),
            ("GPS", "Speed Accuracy", "km/h"),
            ("ABS", "WheelSpeed_Front", "km/h"),
            ("ABS", "WheelSpeed_Rear", "rpm"),
            ("IMU", "LeanAngle", "deg"),
            ("IMU", "YawRate", "deg/s"),
            ("ECU", "Gear", ""),
            ("ECU", "TPS", "%"),
            ("ECU", "BrakePressF", "bar"),
            ("ECU", "EngineSpeed", "rpm"),
            ("ECU", "Steering \"angle\"", ""),
        ]);
        let text = propose("my \"logger\"", "kiro", true, &log, &[]);
        let map = ChannelMap::parse(&text, "draft").expect(&text);
        let fitted = fit(&map, &log).expect(&text);
        let taken =
            |c: Channel| fitted.entries.iter().find(|e| e.channel == c).map(|e| e.from[0].as_str());
        assert_eq!(taken(Channel::VelocityX), Some("GPS/GPS Speed"));
        assert_eq!(taken(Channel::WheelSpeedFront), None, "a radius is needed:\n{text}");
        assert!(text.contains("# from = \"WheelSpeed_Front\""), "{text}");
        assert_eq!(taken(Channel::WheelSpeedRear), Some("ABS/WheelSpeed_Rear"));
        assert_eq!(taken(Channel::Roll), Some("IMU/LeanAngle"));
        assert_eq!(taken(Channel::YawRate), Some("IMU/YawRate"));
        assert_eq!(taken(Channel::Gear), Some("ECU/Gear"));
        assert_eq!(taken(Channel::Throttle), Some("ECU/TPS"));
        assert_eq!(taken(Channel::BrakePressureFront), Some("ECU/BrakePressF"));
        assert_eq!(taken(Channel::SteerAngle), None);
        assert!(text.contains("# unit = \"?\""), "{text}");
    }

    #[test]
    fn a_compass_course_is_turned_round_and_a_calculated_lean_is_none() {
        let log = listing(&[("gps", "bearing", "deg"), ("calc", "lean_angle", "deg")]);
        let text = propose("x", "racechrono", true, &log, &[]);
        let map = ChannelMap::parse(&text, "draft").expect(&text);
        let entries: Vec<(Channel, f64)> =
            map.entries.iter().map(|e| (e.channel, e.sign)).collect();
        assert_eq!(entries, [(Channel::Yaw, -1.0)], "{text}");
        assert!(text.contains("calculates it from the lateral acceleration"), "{text}");
        let other = propose("x", "kiro", true, &log, &[]);
        assert!(other.contains("\n[channel.roll]"), "{other}");
        let called = propose("x", "vbo", true, &listing(&[("", "lean_calc", "deg")]), &[]);
        assert!(
            !called.contains("\n[channel.roll]") && called.contains("it is calculated"),
            "{called}"
        );
        let yaw = propose("x", "kiro", true, &listing(&[("", "Yaw", "deg")]), &[]);
        assert!(yaw.contains("[channel.yaw]") && !yaw.contains("\nsign"), "{yaw}");
    }

    #[test]
    fn what_never_moved_is_neither_throttle_nor_brake() {
        let log = listing(&[
            ("", "TPS 1", "%"),
            ("", "TPS 2", "%"),
            ("", "Brake Press F", "bar"),
            ("", "Lean Angle", "deg"),
        ]);
        let still = |x: f64| Some([x; 3]);
        let moved = Some([0.0, 10.0, 80.0]);
        let text = propose("x", "kiro", true, &log, &[still(0.0), moved, still(1.0), still(0.0)]);
        let map = ChannelMap::parse(&text, "draft").expect(&text);
        let taken: Vec<(Channel, &str)> =
            map.entries.iter().map(|e| (e.channel, e.from[0].as_str())).collect();
        assert_eq!(taken, [(Channel::Roll, "Lean Angle"), (Channel::Throttle, "TPS 2")], "{text}");
        assert!(!text.contains("Brake Press F"), "{text}");
    }

    #[test]
    fn doubles_are_guesses_and_text_logs_get_a_clock() {
        let log = listing(&[
            ("", "Time", "s"),
            ("A", "roll", "deg"),
            ("B", "roll", "deg"),
            ("", "pitch", "parsec"),
        ]);
        let text = propose("x", "csv", false, &log, &[]);
        assert!(text.contains("[time]\ncolumn = \"Time\"\nunit = \"s\""), "{text}");
        assert!(text.contains("# [channel.roll]\n# from = \"A/roll\""), "{text}");
        assert!(text.contains("# unit = \"parsec\""), "{text}");
        ChannelMap::parse(&text, "draft").expect(&text);
    }
}
