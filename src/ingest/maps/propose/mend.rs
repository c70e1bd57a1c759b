//! A channel map's text with what contradicts the motion corrected: key by key, the rest as its owner wrote it.

use std::ops::Range;

use super::finding::{Finding, FindingKind, UNIT};
use super::physics::Verdict;
use super::{called, motion, quoted};
use crate::contract::channel::Channel;
use crate::ingest::formats::listing::Listing;
use crate::ingest::maps::units;

/// A map's text with the contradicted keys corrected, each under a comment that says why; what else is written in it
/// stays, and so do its line ends. What is of another channel, or of no unit that is known, is commented out and not lost.
pub fn mend(text: &str, listing: &Listing, findings: &[Finding]) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    for (k, finding) in findings.iter().enumerate() {
        if findings[..k].iter().any(|f| f.channel == finding.channel) {
            continue;
        }
        let Some(range) = table(&lines, finding.channel) else { continue };
        let all: Vec<&Finding> = findings.iter().filter(|f| f.channel == finding.channel).collect();
        let new = mended(&lines[range.clone()], &all, listing);
        lines.splice(range, new);
    }
    let end = if text.contains("\r\n") { "\r\n" } else { "\n" };
    lines.join(end) + end
}

/// The columns whose entries [`mend`] comments out instead of correcting them.
pub(crate) fn taken_out(text: &str, findings: &[Finding]) -> Vec<Channel> {
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let mut out: Vec<Channel> = Vec::new();
    for finding in findings {
        let is_in_reach = table(&lines, finding.channel).is_some();
        if is_in_reach && right(findings, finding.channel).is_none() {
            out.push(finding.channel);
        }
    }
    out.dedup();
    out
}

/// The entry that would be right of a column, where it is sure: the last finding's, as its delay is that of the map's
/// other channels.
fn right(findings: &[Finding], channel: Channel) -> Option<&Verdict> {
    let last = findings.iter().rfind(|f| f.channel == channel)?;
    last.mended.as_ref().filter(|v| v.doubt.is_none())
}

/// The columns with findings that a map has in no table of their own: they are out of the reach of [`mend`].
pub(crate) fn out_of_reach(text: &str, findings: &[Finding]) -> Vec<Channel> {
    let lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let far = findings.iter().map(|f| f.channel).filter(|c| table(&lines, *c).is_none());
    far.collect()
}

/// Lines of a column's table, without the comments in front of the next one.
fn table(lines: &[String], channel: Channel) -> Option<Range<usize>> {
    let head = format!("channel.{channel}");
    let start = lines.iter().position(|l| table_name(l).is_some_and(|name| name == head))?;
    let after = lines[start + 1..].iter().position(|l| l.trim_start().starts_with('['));
    let end = after.map_or(lines.len(), |n| start + 1 + n);
    let is_entry = |l: &String| !(l.trim().is_empty() || l.trim_start().starts_with('#'));
    let last = lines[start..end].iter().rposition(is_entry)?;
    Some(start..start + last + 1)
}

/// The name of the table that a line begins.
fn table_name(line: &str) -> Option<String> {
    let (name, _) = line.trim_start().strip_prefix('[')?.split_once(']')?;
    Some(name.replace(['"', '\'', ' '], ""))
}

/// A column's table corrected.
fn mended(old: &[String], findings: &[&Finding], listing: &Listing) -> Vec<String> {
    let said: Vec<String> =
        findings.iter().map(|f| format!("{}: {}", f.wrong.name(), f.message)).collect();
    let said = said.join("; ");
    // the last one's delay is that of the map's other channels
    let right = findings.last().and_then(|f| f.mended.as_ref());
    if let Some(verdict) = right.filter(|v| v.doubt.is_none()) {
        let mut table = Table(old.to_vec());
        correct(&mut table, verdict, findings, listing);
        table.0.splice(1..1, remark(&format!("mended, {said}")));
        return table.0;
    }
    let mut new = remark(&format!("taken out, {said}"));
    new.extend(old.iter().map(|l| format!("# {l}")));
    if let Some(guess) = right {
        new.extend(motion::entry(guess, listing).lines().map(str::to_owned));
    }
    new
}

fn remark(text: &str) -> Vec<String> {
    let mut out = String::new();
    // writing to a String cannot fail
    let _ = motion::comment(&mut out, text);
    out.lines().map(str::to_owned).collect()
}

/// Puts the contradicted keys right.
fn correct(table: &mut Table, verdict: &Verdict, findings: &[&Finding], listing: &Listing) {
    let is = |wrong: FindingKind| findings.iter().any(|f| f.wrong == wrong);
    let (other, unit) = (is(FindingKind::Channel), is(FindingKind::Unit));
    let channel = &listing.channels[verdict.source];
    if other {
        table.put("from", &quoted(&called(channel, listing)));
        // they were the other channel's
        ["or", "scale", "offset", "ratio"].iter().for_each(|key| table.out(key));
        if verdict.offset != 0.0 {
            table.put("offset", &format!("{:?}", verdict.offset));
        }
    }
    if other || unit {
        put_unit(table, verdict, channel.unit.as_deref().map(str::trim));
        for key in ["scale", "ratio"] {
            let large = table.number(key).is_some_and(|x| x.abs().ln().abs() > UNIT.ln());
            if large {
                table.out(key);
            }
        }
    }
    if other || unit || is(FindingKind::Sign) {
        let scale = table.number("scale").unwrap_or(1.0);
        table.number_is("sign", verdict.sign * scale.signum(), 1.0);
    }
    if other || is(FindingKind::Delay) {
        table.number_is("delay", (1000.0 * verdict.delay).round() / 1000.0, 0.0);
    }
}

/// The unit, the log's own where that is another, and the radius of a surface speed.
fn put_unit(table: &mut Table, verdict: &Verdict, own: Option<&str>) {
    let own = own.filter(|own| !own.is_empty());
    let same = table.text("unit").is_some_and(|u| units::same(&u, &verdict.unit) == Some(true));
    if !same && (verdict.unit != "1" || own.is_some()) {
        table.put("unit", &quoted(&verdict.unit));
    }
    match own.filter(|own| *own != verdict.unit) {
        Some(own) => table.put("file_unit", &quoted(own)),
        None => table.out("file_unit"),
    }
    match verdict.radius {
        Some(radius) if table.number("radius").is_none() => {
            table.put("radius", &radius.to_string());
            table.put("radius_sd", &motion::radius_sd(radius).to_string());
        }
        Some(_) => {}
        None => ["radius", "radius_sd"].iter().for_each(|key| table.out(key)),
    }
}

/// The lines of a table, its head first.
struct Table(Vec<String>);

impl Table {
    /// Lines of a key: more than one of a list that is written on several.
    fn find(&self, key: &str) -> Option<Range<usize>> {
        let value = |l: &String| {
            let rest = l.trim_start().strip_prefix(key)?.trim_start().strip_prefix('=')?;
            Some(apart(rest).0.to_owned())
        };
        let start = (1..self.0.len()).find(|i| value(&self.0[*i]).is_some())?;
        let open = value(&self.0[start]).is_some_and(|v| v.starts_with('[') && !v.ends_with(']'));
        let close = |i: &usize| apart(&self.0[*i]).0.ends_with(']');
        let last = if open { (start + 1..self.0.len()).find(close)? } else { start };
        Some(start..last + 1)
    }

    /// A value as TOML reads it.
    fn value(&self, key: &str) -> Option<toml::Value> {
        let text = self.0[self.find(key)?].join("\n");
        text.parse::<toml::Table>().ok()?.remove(key)
    }

    fn number(&self, key: &str) -> Option<f64> {
        let value = self.value(key)?;
        value.as_float().or_else(|| value.as_integer().map(|n| n as f64))
    }

    fn text(&self, key: &str) -> Option<String> {
        Some(self.value(key)?.as_str()?.to_owned())
    }

    /// Gives a key a value; the comment after it stays.
    fn put(&mut self, key: &str, value: &str) {
        let Some(lines) = self.find(key) else { return self.0.push(format!("{key} = {value}")) };
        let old = &self.0[lines.start];
        let after = old.split_once('=').map_or("", |(_, rest)| apart(rest).1);
        let after = if after.is_empty() { String::new() } else { format!(" {after}") };
        self.0.splice(lines, [format!("{key} = {value}{after}")]);
    }

    /// Gives a key a number, unless it is that, or would be without the key.
    fn number_is(&mut self, key: &str, value: f64, usual: f64) {
        if self.number(key).unwrap_or(usual) != value {
            self.put(key, &value.to_string());
        }
    }

    /// Comments a key out.
    fn out(&mut self, key: &str) {
        let Some(lines) = self.find(key) else { return };
        self.0[lines].iter_mut().for_each(|l| *l = format!("# {l}"));
    }
}

/// A value and the comment after it.
fn apart(text: &str) -> (&str, &str) {
    let mut quote: Option<char> = None;
    let mut escaped = false;
    for (i, c) in text.char_indices() {
        match quote {
            _ if escaped => escaped = false,
            Some('"') if c == '\\' => escaped = true,
            Some(q) if c == q => quote = None,
            Some(_) => {}
            None if c == '#' => return (text[..i].trim(), &text[i..]),
            None if matches!(c, '"' | '\'') => quote = Some(c),
            None => {}
        }
    }
    (text.trim(), "")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::formats::listing::SourceChannel;

    fn listing() -> Listing {
        let channel = |(name, unit): (&str, &str)| SourceChannel {
            name: name.into(),
            unit: (!unit.is_empty()).then(|| unit.to_owned()),
            ..SourceChannel::default()
        };
        let all = [("Roll", "deg"), ("Front", "bar"), ("Rear", "bar"), ("Speed", "")];
        Listing { channels: all.map(channel).to_vec(), ..Listing::default() }
    }

    fn finding(wrong: FindingKind, verdict: Verdict) -> Finding {
        let message = "seen".to_owned();
        Finding { channel: verdict.channel, wrong, message, mended: Some(verdict) }
    }

    fn verdict(channel: Channel, source: usize, unit: &str, sign: f64) -> Verdict {
        Verdict { sign, ..Verdict::new(channel, source, unit) }
    }

    const HAND: &str = "# mine\nname = \"m\"\n\n# on the tank, 2 deg off\n[channel.roll]\nfrom = \"Roll\"\n\
        unit = \"deg\"\noffset = 2.0 # deg, on the stand\nscale = 1.02\n\n# the brake\n[channel.brake_pressure_front]\n\
        from = \"Rear\" # ?\nunit = \"bar\"\noffset = 0.5\n";

    /// What a hand has written about a zero stays where only the sign was wrong.
    #[test]
    fn only_the_contradicted_key_changes() {
        let right = finding(FindingKind::Sign, verdict(Channel::Roll, 0, "deg", -1.0));
        let text = mend(HAND, &listing(), &[right]);
        let wanted = HAND
            .replace("[channel.roll]\n", "[channel.roll]\n# mended, wrong sign: seen\n")
            .replace("scale = 1.02\n", "scale = 1.02\nsign = -1\n");
        assert_eq!(text, wanted);
        // an editor of another system ends lines its way
        let right = finding(FindingKind::Sign, verdict(Channel::Roll, 0, "deg", -1.0));
        let text = mend(&HAND.replace('\n', "\r\n"), &listing(), &[right]);
        assert_eq!(text, wanted.replace('\n', "\r\n"));
        // a sign that stands there is turned, and its comment kept
        let turned = HAND.replace("scale = 1.02", "sign = -1 # upside down");
        let right = finding(FindingKind::Sign, verdict(Channel::Roll, 0, "deg", 1.0));
        let text = mend(&turned, &listing(), &[right]);
        assert!(
            text.contains("\nsign = 1 # upside down\n") && text.contains("offset = 2.0"),
            "{text}"
        );
    }

    #[test]
    fn numbers_of_another_channel_are_commented_out_not_lost() {
        let right = verdict(Channel::BrakePressureFront, 1, "bar", 1.0);
        let text = mend(HAND, &listing(), &[finding(FindingKind::Channel, right)]);
        assert!(
            text.contains("\nfrom = \"Front\" # ?\nunit = \"bar\"\n# offset = 0.5\n"),
            "{text}"
        );
        assert!(text.contains("offset = 2.0 # deg"), "{text}");
    }

    #[test]
    fn a_unit_takes_the_scale_along_that_stood_in_for_it() {
        let right =
            || finding(FindingKind::Unit, verdict(Channel::BrakePressureFront, 1, "psi", 1.0));
        let text = mend(HAND, &listing(), &[right()]);
        assert!(text.contains("\nunit = \"psi\"\noffset = 0.5\nfile_unit = \"bar\"\n"), "{text}");
        let scaled = HAND.replace("offset = 0.5", "scale = -14.5");
        let text = mend(&scaled, &listing(), &[right()]);
        assert!(text.contains("\n# scale = -14.5\n") && !text.contains("sign"), "{text}");
    }

    #[test]
    fn a_delay_alone_is_put_right() {
        let late = Verdict { delay: 0.1204, ..verdict(Channel::Roll, 0, "deg", -1.0) };
        let text = mend(HAND, &listing(), &[finding(FindingKind::Delay, late)]);
        assert!(text.contains("scale = 1.02\ndelay = 0.12\n") && !text.contains("sign"), "{text}");
    }

    #[test]
    fn what_is_wrong_altogether_is_commented_out_and_what_has_no_table_said() {
        let mut wrong = finding(FindingKind::Kind, verdict(Channel::Roll, 0, "deg", 1.0));
        wrong.mended = None;
        let text = mend(HAND, &listing(), std::slice::from_ref(&wrong));
        let out = "# taken out, no such quantity: seen\n# [channel.roll]\n# from = \"Roll\"\n";
        assert!(text.contains(out) && text.contains("# scale = 1.02\n\n# the brake\n"), "{text}");
        let inline = "channel.roll = { from = \"Roll\" }\n";
        assert!(out_of_reach(HAND, std::slice::from_ref(&wrong)).is_empty());
        assert_eq!(taken_out(HAND, std::slice::from_ref(&wrong)), [Channel::Roll]);
        let sure = finding(FindingKind::Sign, verdict(Channel::Roll, 0, "deg", -1.0));
        assert!(taken_out(HAND, &[sure]).is_empty());
        assert_eq!(out_of_reach(inline, std::slice::from_ref(&wrong)), [Channel::Roll]);
        assert_eq!(mend(inline, &listing(), &[wrong]), inline);
        assert_eq!(apart(" \"a # \\\" b\" # c"), ("\"a # \\\" b\"", "# c"));
    }
}
