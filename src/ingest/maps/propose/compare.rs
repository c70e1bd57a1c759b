//! A channel map against what the motion says: wrong channels, signs, units and delays.

use super::finding::UNIT;
pub(crate) use super::finding::{Finding, FindingKind};
pub use super::mend::mend;
use super::motion;
use super::physics::{Verdict, Verdicts};
use crate::contract::channel::Channel;
use crate::ingest::formats::listing::Listing;
use crate::ingest::maps::units;
use crate::ingest::maps::{ChannelMap, Entry};
use crate::ingest::session_schema::si_unit;

/// Delays are compared with each other beyond this, s, ...
const LATE: f64 = 0.06;
/// ... and beyond so many standard errors.
const SURE: f64 = 3.0;

/// Result of a comparison.
#[derive(Debug, Clone, Default)]
pub struct Comparison {
    /// Findings; a column may have several.
    pub findings: Vec<Finding>,
    /// Columns that agree with the motion.
    pub agree: Vec<Channel>,
    /// Columns that no motion speaks for.
    pub unchecked: Vec<Channel>,
}

/// Holds a map that was fitted to the log against the verdicts.
pub fn compare(map: &ChannelMap, listing: &Listing, verdicts: &Verdicts) -> Comparison {
    let mut out = Comparison::default();
    let shift = common_shift(map, listing, verdicts);
    for entry in &map.entries {
        let before = out.findings.len();
        let checked = judge(entry, listing, verdicts, shift, &mut out.findings);
        let right = out.findings.len() == before;
        match (checked, right) {
            (true, true) => out.agree.push(entry.channel),
            (false, true) => out.unchecked.push(entry.channel),
            _ => {}
        }
    }
    out
}

/// Channels of a log by a map that fits it: their places, and the columns.
pub(crate) fn claims(map: &ChannelMap, listing: &Listing) -> Vec<(usize, Channel)> {
    map.entries.iter().filter_map(|e| Some((place(e, listing)?, quantity(e.channel)))).collect()
}

/// Whether an entry is sure but for its radius, or for which of two units it has.
fn sure(verdicts: &Verdicts, channel: Channel) -> Option<&Verdict> {
    let but = |e: &Verdict| e.doubt.is_none() || motion::lacks_radius(e) || e.of_two_units();
    let good = |e: &&Verdict| e.channel == channel && but(e);
    verdicts.entries.iter().find(good)
}

fn place(entry: &Entry, listing: &Listing) -> Option<usize> {
    let [from] = entry.from.as_slice() else { return None };
    listing.channels.iter().position(|c| c.full() == *from)
}

/// Whether the motion could be asked; what is wrong is added.
fn judge(
    entry: &Entry,
    listing: &Listing,
    verdicts: &Verdicts,
    shift: f64,
    findings: &mut Vec<Finding>,
) -> bool {
    let Some(source) = place(entry, listing) else { return false };
    let channel = entry.channel;
    let quantity = quantity(channel);
    let name = &entry.from[0];
    let mut find = |wrong: FindingKind, message: String, mended: Option<Verdict>| {
        findings.push(Finding { channel, wrong, message, mended });
    };
    let best = sure(verdicts, quantity);
    let own = verdicts.entries.iter().find(|e| e.channel == quantity && e.source == source);
    let other = best.filter(|b| b.source != source && b.confirmed);
    if let Some(best) = other {
        let is = verdicts.entries.iter().find(|e| e.source == source && e.channel != quantity);
        let is = match (is, verdicts.left_out(source)) {
            (Some(e), _) => format!("`{name}` is {}", e.channel),
            (None, Some(why)) => format!("`{name}`: {why}"),
            (None, None) => format!("`{name}` is not"),
        };
        let right = listing.channels[best.source].full();
        find(
            FindingKind::Channel,
            format!("{channel} is `{right}` ({}); {is}", best.why.join("; ")),
            Some(kept(best, entry)),
        );
        return true;
    }
    let Some(own) = own else {
        // what no motion knows stays as it is; an inertial unit's channels are no column's by themselves
        let imu = channel.name().starts_with("imu_");
        let still = verdicts.constant.contains(&source);
        if let Some(twin) = twin(quantity) {
            let is_twin = |e: &&Verdict| e.channel == twin && e.source == source && e.confirmed;
            if let Some(is) = verdicts.entries.iter().find(is_twin).filter(|e| e.doubt.is_none()) {
                let guess = verdicts.entries.iter().find(|e| e.channel == quantity).cloned();
                find(
                    FindingKind::Kind,
                    format!("`{name}` is {twin} ({})", is.why.join("; ")),
                    // a guess only: it is commented out
                    guess.map(|g| g.doubted("the motion does not show which channel it is")),
                );
                return true;
            }
        }
        let Some(why) = verdicts.left_out(source).filter(|_| !still && !imu) else { return false };
        find(FindingKind::Kind, format!("`{name}` is no {channel}: {why}"), None);
        return true;
    };
    let chosen = own.or_unit.as_deref().is_some_and(|unit| is_in(entry, unit));
    let only_part = own.or_unit.is_some()
        || motion::lacks_radius(own)
        || own.untimed()
        || own.of_two_units()
        || own.is_one_of_several();
    if let Some(doubt) = own.doubt.as_ref().filter(|_| own.confirmed && !only_part) {
        find(FindingKind::Kind, format!("`{name}`: {doubt}"), None);
        return true;
    }
    if !own.confirmed {
        return false;
    }
    let right = Some(kept(own, entry));
    let mut wrong = false;
    if let Some(ratio) = factor(entry, own).filter(|_| !chosen) {
        if ratio.abs().ln().abs() > UNIT.ln() {
            let message = format!(
                "its factor is {ratio:.4} times what the motion needs, as of {}: {}",
                own.unit,
                own.why.join("; ")
            );
            find(FindingKind::Unit, message, right.clone());
            wrong = true;
        }
        if ratio < 0.0 {
            find(FindingKind::Sign, format!("turned round: {}", own.why.join("; ")), right.clone());
            wrong = true;
        }
    }
    // the smoother finds the receiver's delay itself
    if let Some(error) = own.delay_error.filter(|_| quantity == channel) {
        let off = entry.delay - own.delay - shift;
        if !wrong && off.abs() > LATE.max(SURE * error) {
            let message = format!(
                "its delay of {:.3} s is off the other channels' by {off:+.3} s: measured {:.3} +- {error:.3} s",
                entry.delay, own.delay
            );
            let mended = right.map(|v| Verdict { delay: own.delay + shift, ..v });
            find(FindingKind::Delay, message, mended);
        }
    }
    true
}

/// The verdict with what only the map knows: its radius, and its delay where that fits.
fn kept(verdict: &Verdict, entry: &Entry) -> Verdict {
    let radius = entry.radius.or(verdict.radius);
    let doubt = verdict
        .doubt
        .clone()
        .filter(|_| !(motion::lacks_radius(verdict) && entry.radius.is_some()))
        .filter(|_| !(verdict.untimed() || verdict.of_two_units() || verdict.is_one_of_several()));
    Verdict { channel: entry.channel, radius: verdict.radius.and(radius), doubt, ..verdict.clone() }
}

/// The column that a column is taken for: the other wheel's, the other brake's, the other angle of a place.
fn twin(channel: Channel) -> Option<Channel> {
    use Channel::*;
    const PAIRS: [[Channel; 2]; 3] = [
        [WheelSpeedFront, WheelSpeedRear],
        [BrakePressureFront, BrakePressureRear],
        [Latitude, Longitude],
    ];
    let of = |[a, b]: [Channel; 2]| match channel {
        c if c == a => Some(b),
        c if c == b => Some(a),
        _ => None,
    };
    PAIRS.into_iter().find_map(of)
}

/// Whether an entry of a spin, without a radius, has about the factor of a unit.
fn is_in(entry: &Entry, unit: &str) -> bool {
    let right = units::conversion(unit, si_unit(entry.channel));
    let is = |factor: f64| {
        let ratio = entry.to_si.factor / factor;
        ratio > 0.0 && ratio.ln().abs() < UNIT.ln()
    };
    entry.radius.is_none() && right.is_ok_and(|c| is(c.factor))
}

/// Column as the verdicts have it: the smoother of an inertial unit takes speed and course under names of its own.
fn quantity(channel: Channel) -> Channel {
    match channel {
        Channel::SatelliteSpeed => Channel::VelocityX,
        Channel::Course => Channel::Yaw,
        other => other,
    }
}

/// The entry's factor over the right one; `None` where units do not tell.
fn factor(entry: &Entry, verdict: &Verdict) -> Option<f64> {
    let spin = verdict.radius.is_some();
    let target = if spin { "m/s" } else { si_unit(entry.channel) };
    let right = units::conversion(&verdict.unit, target).ok()?.factor * verdict.sign;
    // a radius of the map is no matter of units; without one the spin was taken for a surface speed
    let radius = if spin { entry.radius.or(verdict.radius)? } else { 1.0 };
    let radius = if !spin && entry.radius.is_some() { return Some(1.0) } else { radius };
    Some(entry.to_si.factor * radius / right)
}

/// The shift that the map's delays and the measured ones have in common: it moves the session, nothing else.
fn common_shift(map: &ChannelMap, listing: &Listing, verdicts: &Verdicts) -> f64 {
    let of = |entry: &Entry| {
        let source = place(entry, listing)?;
        let own =
            verdicts.entries.iter().find(|e| e.channel == entry.channel && e.source == source)?;
        own.delay_error.filter(|_| own.confirmed)?;
        Some(entry.delay - own.delay)
    };
    let mut all: Vec<f64> = map.entries.iter().filter_map(of).collect();
    all.sort_unstable_by(f64::total_cmp);
    // of two in the middle the smaller
    let middle = [all.len() / 2, all.len().saturating_sub(1) / 2]
        .iter()
        .filter_map(|i| all.get(*i).copied())
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))
        .unwrap_or(0.0);
    // errors of the measured delays are no shift
    if middle.abs() < LATE { 0.0 } else { middle }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::formats::listing::SourceChannel;

    fn wheels(map: &str, front: Verdict) -> Comparison {
        let channel = |name: &str| SourceChannel { name: name.into(), ..SourceChannel::default() };
        let listing = Listing { channels: ["a", "b"].map(channel).to_vec(), ..Listing::default() };
        let rear = Verdict {
            confirmed: true,
            ..Verdict::new(Channel::WheelSpeedRear, 1, "rad/s").because("r = 1")
        };
        let verdicts = Verdicts { entries: vec![front, rear], ..Verdicts::default() };
        let head = "name = \"m\"\nformat = \"csv\"\n[time]\ncolumn = \"t\"\nunit = \"s\"\n";
        let text = format!("{head}{map}");
        compare(&ChannelMap::parse(&text, "m").expect(&text), &listing, &verdicts)
    }

    /// Of a front wheel whose numbers are km/h or rad/s.
    fn front() -> Verdict {
        Verdict {
            confirmed: true,
            or_unit: Some("rad/s".into()),
            radius: Some(0.3),
            ..Verdict::new(Channel::WheelSpeedFront, 0, "km/h").doubted("km/h as well as rad/s")
        }
    }

    #[test]
    fn a_choice_between_two_units_is_the_maps() {
        let of = |unit: &str| {
            let map = format!("[channel.wheel_speed_front]\nfrom = \"a\"\nunit = \"{unit}\"\n");
            wheels(&map, front())
        };
        assert_eq!(of("rad/s").agree, [Channel::WheelSpeedFront]);
        let surface = "[channel.wheel_speed_front]\nfrom = \"a\"\nunit = \"km/h\"\nradius = 0.31\n";
        assert_eq!(wheels(surface, front()).agree, [Channel::WheelSpeedFront]);
        let none = of("rpm");
        let [finding] = none.findings.as_slice() else { panic!("{:?}", none.findings) };
        assert_eq!(finding.wrong, FindingKind::Unit, "no unit of the two");
        assert!(finding.mended.as_ref().is_some_and(|v| v.doubt.is_some()), "a guess only");
        // one of several of that name: the map chooses
        let several = Verdict {
            confirmed: true,
            ..Verdict::new(Channel::WheelSpeedFront, 0, "rad/s")
                .doubted("there is more than one such channel: `a`, `c`")
        };
        let map = "[channel.wheel_speed_front]\nfrom = \"a\"\nunit = \"rad/s\"\n";
        assert_eq!(wheels(map, several).agree, [Channel::WheelSpeedFront]);
    }

    /// A map that feeds the front wheel's column from what is surely the rear wheel.
    #[test]
    fn the_other_wheel_is_no_front_wheel_though_which_is_it_shows_not() {
        let map = "[channel.wheel_speed_front]\nfrom = \"b\"\nunit = \"rad/s\"\n";
        let found = wheels(map, front());
        let [finding] = found.findings.as_slice() else { panic!("{:?}", found.findings) };
        assert_eq!((finding.channel, finding.wrong), (Channel::WheelSpeedFront, FindingKind::Kind));
        assert!(finding.message.contains("`b` is wheel_speed_rear"), "{}", finding.message);
        assert!(finding.mended.as_ref().is_some_and(|v| v.doubt.is_some()), "a guess only");
    }
}
