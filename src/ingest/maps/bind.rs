//! A channel map fitted to a log: names and units of the map against those of the log's channels.

use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::ingest::formats::listing::{Listing, SourceChannel};
use crate::ingest::maps::units;
use crate::ingest::maps::{ChannelMap, Entry};

/// Whether a map was written for logs like this one.
pub(crate) fn is_for(map: &ChannelMap, listing: &Listing) -> bool {
    // `*` is every log of the format
    let there = |name: &String| name == "*" || listing.channels.iter().any(|c| c.is_called(name));
    !map.detect.is_empty() && map.detect.iter().all(there)
}

/// A channel map as it is for one log: every `from` is a channel's full name, every unit agreed
/// with the log's own, and the entries of an `optional` map that the log has nothing for are
/// gone.
///
/// # Errors
/// A name or a unit that does not fit, in a sentence that names the map and the entry.
pub(crate) fn fit(map: &ChannelMap, listing: &Listing) -> Result<ChannelMap, Error> {
    let mut fitted = map.clone();
    fitted.entries.clear();
    for entry in &map.entries {
        let fail = |e: Error| {
            let place = format!("channel map {}, [channel.{}]", map.name, entry.channel);
            Error::new(e.code, format!("{place}: {}", e.message))
        };
        let found = match first_of(entry, listing) {
            Ok(found) => found,
            Err(e) if map.optional && e.code == RejectionCode::MissingColumn => continue,
            Err(e) => return Err(fail(e)),
        };
        fitted.entries.push(entry_for(entry, &found).map_err(fail)?);
    }
    if fitted.entries.is_empty() {
        let message = format!("channel map {} takes nothing from this log", map.name);
        return Err(Error::new(RejectionCode::NoChannelMap, message));
    }
    Ok(fitted)
}

/// Channel of an entry: `from`, or the first of `or` that the log has.
fn first_of<'a>(entry: &Entry, listing: &'a Listing) -> Result<Vec<&'a SourceChannel>, Error> {
    let all = |names: &[String]| -> Result<Vec<&'a SourceChannel>, Error> {
        names.iter().map(|name| listing.find(name)).collect()
    };
    let missing = |found: &Result<_, Error>| {
        found.as_ref().is_err_and(|e: &Error| e.code == RejectionCode::MissingColumn)
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
            return Err(Error::new(RejectionCode::UnitMismatch, message));
        }
        agreed.unit = unit;
    }
    agreed.convert().map_err(|e| Error::new(RejectionCode::UnknownUnit, e))?;
    Ok(agreed)
}

/// The unit of a channel, by the map and the log: where both give one they must agree.
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
                "the log says that `{name}` is in {own}, the map says {}; remove `unit`, or if the \
                 log is wrong add `file_unit = \"{own}\"`",
                entry.unit
            );
            Err(Error::new(RejectionCode::UnitMismatch, message))
        }
        (false, Some(own)) => match entry.converted(own) {
            Ok(_) => Ok(own.to_owned()),
            Err(e) => {
                let message = format!("`{name}`: the log gives the {e}; give it with `unit`");
                Err(Error::new(RejectionCode::UnknownUnit, message))
            }
        },
        (false, None) if entry.unit == "1" => Ok(entry.unit.clone()),
        (false, None) => {
            let message = format!(
                "the log gives no unit for `{name}`; give it in the map, e.g. `unit = \"{}\"`",
                entry.unit
            );
            Err(Error::new(RejectionCode::UnknownUnit, message))
        }
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
        assert_eq!(error.code.as_str(), "ambiguous_column");
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
            assert_eq!(error.code.as_str(), code, "{error}");
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
        assert_eq!(none.expect_err("nothing").code.as_str(), "no_channel_map");
    }
}
