//! The draft of a channel map by the motion: every entry with the figure that decided.

use std::fmt::Write as _;

use super::physics::{RADIUS, Verdict, Verdicts};
use super::words::RULES;
use super::{MAX_OFFERED, called, found_clock, quoted, write_time};
use crate::contract::channel::Channel;
use crate::ingest::formats::listing::Listing;

/// How far the circumference that a logger computes with is from the bike file's rolling one, one standard deviation: it
/// may be the unloaded tyre's, 1 to 3 % more, and tyres of a size differ by 1.5 to 2.5 % (ETRTO's tolerance).
const NOMINAL: f64 = 0.02;
/// Widest comment line.
const WIDTH: usize = 110;

/// The text of a channel map of verdicts: what is sure is in force, the rest commented out.
pub(crate) fn draft(
    name: &str,
    format: &str,
    own_clock: bool,
    listing: &Listing,
    verdicts: &Verdicts,
) -> String {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = write(&mut out, name, format, own_clock, listing, verdicts);
    out
}

fn write(
    out: &mut String,
    name: &str,
    format: &str,
    own_clock: bool,
    listing: &Listing,
    verdicts: &Verdicts,
) -> std::fmt::Result {
    comment(
        out,
        "A draft: names, units and the motion in the log itself decided; above each entry is the figure that \
         did. What is commented out is a guess. x is forward, y left, z up; in a left-hand corner roll is negative \
         and yaw rate positive. `roadbench schema channel_map` lists every key.",
    )?;
    for remark in &verdicts.remarks {
        comment(out, remark)?;
    }
    if !own_clock && found_clock(listing).is_none() {
        comment(
            out,
            "No clock was found: how fast anything changes is by an assumed rate. Accelerations, rates and delays below \
             say nothing until [time] is given.",
        )?;
    }
    writeln!(out, "name = {}\nformat = {}", quoted(name), quoted(format))?;
    if !listing.layout.is_empty() {
        writeln!(out, "\n{}", listing.layout.trim_end())?;
    }
    writeln!(out, "\n# a log with these channels is taken for one of this source\n[detect]")?;
    let sure = verdicts.entries.iter().filter(|e| e.doubt.is_none());
    let mut named: Vec<String> =
        sure.map(|e| quoted(&called(&listing.channels[e.source], listing))).collect();
    named.truncate(6);
    writeln!(out, "columns = [{}]", named.join(", "))?;
    writeln!(out, "\n[meta]\n# bike_id = \"...\" # its bike file is bikes/<bike_id>.toml")?;
    if !own_clock {
        write_time(out, listing)?;
    }
    if named.is_empty() {
        writeln!(out, "\n[channel]")?;
    }
    let imu = inertial_unit(verdicts);
    if !imu.is_empty() {
        writeln!(out, "\n[imu]")?;
        comment(
            out,
            "from the unit to the centre of mass of motorcycle and rider, forward, left, up, m: \
             measure it: without it velocities and accelerations are those of the unit, with an \
             assumed uncertainty of 0.3 m",
        )?;
        writeln!(out, "# arm = [0.0, 0.0, 0.0]")?;
    }
    let of_imu = |e: &&Verdict| e.doubt.is_some() && imu.contains(&e.source);
    let mut said: Option<&[String]> = None;
    for channel in columns(verdicts) {
        let entries = verdicts.entries.iter().filter(|e| e.channel == channel && !of_imu(e));
        for verdict in entries.take(MAX_OFFERED) {
            let mut shown = if imu.is_empty() { verdict.clone() } else { for_smoother(verdict) };
            // what is as the one before is said once
            if said == Some(&verdict.why) {
                shown.why.clear();
            }
            said = Some(&verdict.why);
            writeln!(out, "\n{}", entry(&shown, listing).trim_end())?;
        }
    }
    left_over(out, listing, verdicts)?;
    let found = |c: Channel| verdicts.entries.iter().any(|e| e.channel == c);
    let missing: Vec<&str> =
        RULES.iter().map(|r| r.channel).filter(|c| !found(*c)).map(Channel::name).collect();
    if !missing.is_empty() {
        writeln!(out)?;
        comment(out, &format!("nothing was recognised as {}", missing.join(", ")))?;
    }
    Ok(())
}

/// Places of the channels of a drafted inertial unit.
fn inertial_unit(verdicts: &Verdicts) -> Vec<usize> {
    use Channel::*;
    let own = [ImuRateX, ImuRateY, ImuRateZ, ImuForceX, ImuForceY, ImuForceZ];
    verdicts.entries.iter().filter(|e| own.contains(&e.channel)).map(|e| e.source).collect()
}

/// The receiver's speed and course as the smoother of an inertial unit takes them: it finds their delay itself.
fn for_smoother(verdict: &Verdict) -> Verdict {
    let channel = match verdict.channel {
        Channel::VelocityX => Channel::SatelliteSpeed,
        Channel::Yaw => Channel::Course,
        other => other,
    };
    Verdict { channel, ..verdict.clone() }
}

fn columns(verdicts: &Verdicts) -> Vec<Channel> {
    let mut all: Vec<Channel> = verdicts.entries.iter().map(|e| e.channel).collect();
    all.dedup();
    all
}

/// The table of one entry with its comments, as it stands in a map.
pub(crate) fn entry(verdict: &Verdict, listing: &Listing) -> String {
    let mut out = String::new();
    let _ = write_entry(&mut out, verdict, listing);
    out
}

/// How far a radius may be off that stands in for the logger's own, one standard deviation, m.
pub(super) fn radius_sd(radius: f64) -> f64 {
    (1e4 * NOMINAL * radius).round() / 1e4
}

fn write_entry(out: &mut String, verdict: &Verdict, listing: &Listing) -> std::fmt::Result {
    let channel = &listing.channels[verdict.source];
    let mark = if verdict.doubt.is_some() { "# " } else { "" };
    let mut why = verdict.why.join("; ");
    if verdict.delay > 0.0 {
        let error = verdict.delay_error.map_or(String::new(), |e| format!(" +- {e:.3}"));
        why += &format!("; {:.3}{error} s late", verdict.delay);
    }
    if !why.is_empty() {
        comment(out, why.trim_start_matches("; "))?;
    }
    if let Some(doubt) = &verdict.doubt {
        comment(out, &format!("not sure: {doubt}"))?;
    }
    writeln!(out, "{mark}[channel.{}]", verdict.channel)?;
    writeln!(out, "{mark}from = {}", quoted(&called(channel, listing)))?;
    let own = channel.unit.as_deref().map(str::trim).filter(|u| !u.is_empty());
    if verdict.unit != "1" || own.is_some() {
        writeln!(out, "{mark}unit = {}", quoted(&verdict.unit))?;
    }
    if let Some(own) = own.filter(|own| *own != verdict.unit && verdict.unit != "?") {
        writeln!(out, "{mark}file_unit = {}", quoted(own))?;
    }
    if verdict.offset != 0.0 {
        writeln!(out, "{mark}offset = {:?}", verdict.offset)?;
    }
    if verdict.sign < 0.0 {
        writeln!(out, "{mark}sign = -1")?;
    }
    if let Some(radius) = verdict.radius {
        writeln!(out, "{mark}radius = {radius} # m, that the source computed it with")?;
        writeln!(
            out,
            "{mark}radius_sd = {} # m; take it out where the logger's own radius is known",
            radius_sd(radius)
        )?;
    }
    if verdict.delay > 0.0 {
        writeln!(out, "{mark}delay = {} # s", verdict.delay)?;
    }
    Ok(())
}

fn left_over(out: &mut String, listing: &Listing, verdicts: &Verdicts) -> std::fmt::Result {
    let imu = inertial_unit(verdicts);
    let left: Vec<&(usize, String)> =
        verdicts.left.iter().filter(|l| !imu.contains(&l.0)).collect();
    if left.is_empty() {
        return Ok(());
    }
    writeln!(out, "\n# Left over:")?;
    for (place, why) in left {
        comment(out, &format!("{}: {why}", listing.channels[*place].full()))?;
    }
    Ok(())
}

/// A text as comment lines.
pub(super) fn comment(out: &mut String, text: &str) -> std::fmt::Result {
    let mut line = String::new();
    for word in text.split_whitespace() {
        if !line.is_empty() && line.len() + word.len() + 3 > WIDTH {
            writeln!(out, "# {line}")?;
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += word;
    }
    writeln!(out, "# {line}")
}

/// Whether an entry only lacks the radius that its surface speed was computed with.
pub(crate) fn lacks_radius(verdict: &Verdict) -> bool {
    verdict.doubt.as_deref() == Some(RADIUS)
}
