//! `roadbench inspect` of a log as its logger wrote it, and the draft of a channel map for it.

use std::fmt::Write as _;
use std::io::Write as _;

use serde::Serialize;

use crate::cli::failure::Failure;
use crate::cli::log::rejected;
use crate::cli::number::number;
use crate::cli::say;
use crate::cli::say::tell;
use crate::ingest;
use crate::ingest::checks::aids::Aids;
use crate::ingest::checks::judge::{by_motion, draft};
use crate::ingest::formats::listing::SourceChannel;
use crate::ingest::formats::survey::{ChannelContents, Survey, survey};
use crate::store::objects::Location;

/// A log's own channels and the map that is proposed for them.
#[derive(Debug, Serialize)]
pub(crate) struct SourceInspection {
    format: &'static str,
    facts: Vec<(String, String)>,
    channels: Vec<SourceFacts>,
    warnings: Vec<(&'static str, String)>,
    /// TOML, ready to save.
    pub proposed_map: String,
}

#[derive(Debug, Serialize)]
struct SourceFacts {
    group: String,
    name: String,
    unit: Option<String>,
    /// Hz
    rate: Option<f64>,
    samples: usize,
    missing: usize,
    gaps: usize,
    /// s
    longest_gap: f64,
    min: Option<f64>,
    median: Option<f64>,
    max: Option<f64>,
}

/// What is printed of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    /// For people.
    Text,
    /// For programs.
    Json,
    /// The draft of a channel map alone.
    Draft,
}

/// The log as its logger wrote it; `why` is what keeps it from being read as a session.
///
/// # Errors
/// It cannot be read without a channel map, or stdout not be written.
pub(crate) fn show(
    log: &Location,
    aids: &Aids,
    form: Form,
    why: Option<ingest::Error>,
) -> Result<(), Failure> {
    let Some(survey) = survey(log, aids).map_err(rejected)? else {
        return Err(why.map_or_else(
            || {
                let what = "is of a format that can only be read through a channel map";
                Failure::Usage(format!("{log} {what}"))
            },
            rejected,
        ));
    };
    let verdicts = by_motion(log, aids, &survey, None).map_err(rejected)?;
    let found = SourceInspection::new(&survey, draft(log, &survey, &verdicts));
    match form {
        Form::Json => {
            let json = serde_json::to_string_pretty(&found);
            return print(&(json.map_err(|e| Failure::Output(e.to_string()))? + "\n"));
        }
        Form::Draft => return print(&found.proposed_map),
        Form::Text => print(&found.to_text(log))?,
    }
    if why.is_some() {
        tell!("none of the channel maps that come with roadbench fits this log\n");
    }
    Ok(())
}

/// Writes to stdout.
///
/// # Errors
/// It cannot be written.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    match std::io::stdout().write_all(text.as_bytes()) {
        // a pipe that was closed is no error
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Failure::Output(format!("cannot write to stdout: {e}")))
        }
        _ => Ok(()),
    }
}

impl SourceInspection {
    /// Of a log that was looked at, and the map that is proposed for it.
    fn new(survey: &Survey, proposed_map: String) -> Self {
        let Survey { format, listing, contents, .. } = survey;
        let meta = &listing.meta;
        let known = [
            ("session", Some(&meta.session_id).filter(|t| !t.is_empty())),
            ("bike", Some(&meta.bike_id).filter(|t| !t.is_empty())),
            ("started", meta.start_time.as_ref()),
            ("site", meta.site.as_ref()),
            ("rider", meta.rider_id.as_ref()),
        ];
        let known = known.into_iter().filter_map(|(k, v)| Some((k.to_owned(), v?.clone())));
        SourceInspection {
            format,
            facts: known.chain(listing.facts.iter().cloned()).collect(),
            channels: listing.channels.iter().zip(contents).map(|(c, s)| facts(c, s)).collect(),
            warnings: listing.warnings.iter().map(|w| (w.code, w.message.clone())).collect(),
            proposed_map,
        }
    }

    /// For people.
    pub(crate) fn to_text(&self, log: &Location) -> String {
        let mut out = String::new();
        // writing to a String cannot fail
        let _ = self.write(log, &mut out);
        out
    }

    fn write(&self, log: &Location, out: &mut String) -> std::fmt::Result {
        writeln!(out, "{log} ({}), {} channels", self.format, self.channels.len())?;
        for (name, value) in &self.facts {
            writeln!(out, "  {name}: {value}")?;
        }
        let longest = self.channels.iter().map(|c| c.full().chars().count()).max().unwrap_or(0);
        let width = longest.clamp(8, 44) + 2;
        if say::line_width() < width + FIGURES {
            self.write_narrow(longest.clamp(8, 30) + 2, out)?;
            return self.write_rest(out);
        }
        writeln!(
            out,
            "\n{:<width$}{:>8}{:>9}{:>9}{:>9}{:>6}{:>9}{:>11}{:>11}{:>11}",
            "channel",
            "unit",
            "rate Hz",
            "samples",
            "missing",
            "gaps",
            "longest",
            "min",
            "median",
            "max"
        )?;
        for c in &self.channels {
            let rate = c.rate.map(|r| format!("{r:.1}")).unwrap_or_default();
            let longest =
                if c.gaps > 0 { format!("{:.1} s", c.longest_gap) } else { String::new() };
            writeln!(
                out,
                "{:<width$}{:>8}{rate:>9}{:>9}{:>9}{:>6}{longest:>9}{:>11}{:>11}{:>11}",
                c.full(),
                c.unit.as_deref().unwrap_or("-"),
                c.samples,
                c.missing,
                c.gaps,
                number(c.min),
                number(c.median),
                number(c.max),
            )?;
        }
        self.write_rest(out)
    }

    /// Without rate, samples and gaps, in 80 columns.
    fn write_narrow(&self, width: usize, out: &mut String) -> std::fmt::Result {
        writeln!(
            out,
            "\n{:<width$}{:>7}{:>9}{:>10}{:>10}{:>10}",
            "channel", "unit", "missing", "min", "median", "max"
        )?;
        for c in &self.channels {
            let unit = c.unit.as_deref().unwrap_or("-");
            let [min, median, max] = [c.min, c.median, c.max].map(number);
            writeln!(
                out,
                "{:<width$}{unit:>7}{:>9}{min:>10}{median:>10}{max:>10}",
                c.full(),
                c.missing
            )?;
        }
        Ok(())
    }

    fn write_rest(&self, out: &mut String) -> std::fmt::Result {
        if !self.warnings.is_empty() {
            writeln!(out, "\nWarnings")?;
        }
        for (code, message) in &self.warnings {
            writeln!(out, "  {code}: {message}")?;
        }
        writeln!(
            out,
            "\nA channel map for it (`--propose` prints it alone; save it, check it, then \
             `roadbench convert LOG --map FILE`)\n\n{}",
            self.proposed_map
        )
    }
}

/// Width of all figures of a channel.
const FIGURES: usize = 84;

impl SourceFacts {
    fn full(&self) -> String {
        if self.group.is_empty() {
            self.name.clone()
        } else {
            format!("{}/{}", self.group, self.name)
        }
    }
}

fn facts(channel: &SourceChannel, contents: &ChannelContents) -> SourceFacts {
    let at = |i: usize| contents.extent.map(|e| e[i]);
    SourceFacts {
        group: channel.group.clone(),
        name: channel.name.clone(),
        unit: channel.unit.clone(),
        rate: contents.rate.or(channel.rate),
        samples: contents.samples,
        missing: contents.missing,
        gaps: contents.gaps,
        longest_gap: contents.longest_gap,
        min: at(0),
        median: at(1),
        max: at(2),
    }
}
