//! `roadbench map`: which channel of a log is which column, by its motion; a channel map checked and mended.

use std::fmt::Write as _;
use std::io::{BufRead, IsTerminal, Write};
use std::path::PathBuf;

use clap::ValueHint;

use crate::cli::failure::Failure;
use crate::cli::inspect_source::print;
use crate::cli::location::location;
use crate::cli::log::{self, rejected};
use crate::cli::say::{note, tell};
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::contract::warning::Warning;
use crate::ingest;
use crate::ingest::checks::aids::Aids;
use crate::ingest::checks::judge::{by_motion_and_map, draft};
use crate::ingest::error::Error;
use crate::ingest::formats::listing::Listing;
use crate::ingest::formats::survey::survey;
use crate::ingest::map_for;
use crate::ingest::maps::ChannelMap;
use crate::ingest::maps::file::with_aids;
use crate::ingest::maps::propose::compare::{Comparison, Finding, compare, mend};
use crate::ingest::maps::propose::mend::{out_of_reach, taken_out};
use crate::ingest::maps::propose::physics::{Verdict, Verdicts};
use crate::store::objects::Location;
use crate::store::objects::files::read_text;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Draft or check a channel map from the motion in the log
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    log: Location,
    /// A channel map to check against the motion, instead of drafting one.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    /// Write that map with its wrong entries corrected.
    #[arg(long, requires = "map")]
    mend: bool,
    /// File for the map; without it the map goes to stdout. On a terminal every guess is asked about first.
    #[arg(short, long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    out: Option<PathBuf>,
    /// Bike file: its wheel radii stand in for those that wheel speeds in km/h were computed with.
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    bike: Option<PathBuf>,
    /// CAN database that the log's frames are read by; may be repeated.
    #[arg(long, value_name = "FILE")]
    dbc: Vec<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    log::require(&arguments.log)?;
    if let Some(out) = &arguments.out {
        let mut outputs = Outputs::default();
        outputs.file("--out", &out.into())?;
        outputs.apart_from([&arguments.log])?;
        outputs.apart_from_files(arguments.bike.iter().chain(&arguments.dbc))?;
        // a map may be mended in its place
        outputs.apart_from_files(arguments.map.iter().filter(|_| !arguments.mend))?;
    }
    let aids = Aids::read(&arguments.dbc).map_err(Failure::usage)?;
    let bike = arguments.bike.as_ref().map(|path| Bike::read(path)).transpose();
    let bike = bike.map_err(Failure::usage)?;
    let radii = bike.as_ref().map(|bike| Axle::BOTH.map(|axle| bike.wheel(axle).radius));
    let map = arguments.map.as_deref().map(ChannelMap::read).transpose().map_err(Failure::usage)?;
    let log = &arguments.log;
    let Some(survey) = survey(log, &aids).map_err(rejected)? else {
        // the channels of such a format have the names of `session.v1` already, or its reader knows them
        let what = "is of a format that is read without a channel map; `roadbench inspect` shows its channels";
        return Err(Failure::Usage(format!("{log} {what}")));
    };
    if let (Some(path), Some(map)) = (&arguments.map, map) {
        let maps = with_aids(vec![map], &aids);
        let Some(fitted) = map_for(log, &maps).map_err(rejected)? else {
            let message = format!("{log} is session.v1: it needs no channel map");
            return Err(Failure::Usage(message));
        };
        let judged = by_motion_and_map(log, &aids, &survey, radii, Some(&fitted));
        let found = compare(&fitted, &survey.listing, &judged.map_err(rejected)?);
        return check(&arguments, path, &maps, bike.as_ref(), (&survey.listing, &found));
    }
    let mut verdicts = by_motion_and_map(log, &aids, &survey, radii, None).map_err(rejected)?;
    let terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    if terminal && arguments.out.is_some() {
        let (input, output) = (std::io::stdin(), std::io::stdout());
        ask(&mut verdicts, &survey.listing, &mut input.lock(), &mut output.lock())
            .map_err(|e| Failure::Output(format!("cannot ask: {e}")))?;
    }
    for warning in &survey.listing.warnings {
        tell!("warning: {}: {}\n", warning.code, warning.message);
    }
    let text = draft(log, &survey, &verdicts);
    // by motion or by names: what is in the map counts
    let count = |start: &str| text.lines().filter(|l| l.starts_with(start)).count();
    let (sure, guesses) = (count("[channel."), count("# [channel."));
    if !survey.own_clock && !text.contains("\n[time]") {
        tell!(
            "warning: no_time: no column was recognised as the clock: name it in the map's [time] (`column` and `unit`), \
             or give the rows' `rate` there; without it the map cannot be read\n"
        );
    }
    // the smoother of an inertial unit makes its speed of the receiver's
    if !["velocity_x", "satellite_speed"].iter().any(|c| text.contains(&format!("\n[channel.{c}]")))
    {
        tell!(
            "warning: no_velocity: no channel is mapped to velocity_x: give the speed over ground in the map's \
             [channel.velocity_x] (`from` and `unit`); without it every run rejects the log\n"
        );
    }
    put_map(&arguments, &text, &format!("{sure} columns mapped, {guesses} guesses commented out"))
}

/// The map to its file, with a line on stdout, or to stdout.
fn put_map(arguments: &Arguments, text: &str, said: &str) -> Result<(), Failure> {
    let Some(path) = &arguments.out else { return print(text) };
    output::write(path, text.as_bytes()).map_err(|e| Failure::Output(e.to_string()))?;
    note!("{said}; written to {}", path.display());
    Ok(())
}

fn check(
    arguments: &Arguments,
    path: &std::path::Path,
    maps: &[ChannelMap],
    bike: Option<&Bike>,
    (listing, found): (&Listing, &Comparison),
) -> Result<(), Failure> {
    let text = read_text(path)
        .map_err(|e| Failure::Usage(format!("cannot read {}: {e}", path.display())))?;
    let far = out_of_reach(&text, &found.findings);
    let beyond = far.len();
    let mendable = found.findings.len() - beyond;
    if !arguments.mend {
        let known = |w: &Warning| found.findings.iter().any(|f| Some(f.channel) == w.channel);
        let read = as_read(&arguments.log, maps, bike);
        // what was found may be why a run rejects the log
        let is_explained = read.is_err() && mendable > 0;
        let (said, left) = by_run(read, |w| !known(w));
        let left = if is_explained { 0 } else { left };
        print(&(report(found) + &said))?;
        return refused(mendable, beyond + left);
    }
    tell!("{}", report(found));
    let mended = mend(&text, listing, &found.findings);
    // a map that cannot be read must not stand in for one that can
    let mut after =
        ChannelMap::parse(&mended, &path.display().to_string()).map_err(Failure::usage)?;
    let out = taken_out(&text, &found.findings);
    put_map(arguments, &mended, &done(&found.findings, &far, &out))?;
    after.aids = maps.first().map_or_else(Aids::default, |map| map.aids.clone());
    let (said, left) = by_run(as_read(&arguments.log, &[after], bike), |_| true);
    tell!("{said}");
    refused(0, beyond + left)
}

/// What a run's checks say, for people, and how much of it contradicts the map.
///
/// A log that a run rejects with this map is one thing that the map leaves wrong.
fn by_run(
    warnings: Result<Vec<Warning>, Error>,
    keep: impl Fn(&Warning) -> bool,
) -> (String, usize) {
    let mut said = String::new();
    let mut wrong = 0;
    let warnings = match warnings {
        Ok(warnings) => warnings,
        Err(e) => {
            return (
                format!("a run rejects the log with this map: {}: {}\n", e.code, e.message),
                1,
            );
        }
    };
    for warning in warnings.iter().filter(|w| keep(w)) {
        let channel = warning.channel.map_or("log", Channel::name);
        let _ = writeln!(said, "{channel}: {}: {}", warning.code, warning.message);
        wrong += usize::from(!UNDECIDED.contains(&warning.code));
    }
    (said, wrong)
}

/// What is wrong with a map: so many statements that `--mend` corrects, and so many that it leaves.
fn refused(mendable: usize, left: usize) -> Result<(), Failure> {
    let said = match (mendable, left) {
        (0, 0) => return Ok(()),
        (n, 0) => format!(
            "{n} of the map's statements contradict the log's motion; --mend corrects them or comments them out"
        ),
        (0, n) => format!(
            "{n} of the map's statements contradict the log, and --mend leaves them as they are: correct them by hand"
        ),
        (n, m) => format!(
            "{} of the map's statements contradict the log: --mend corrects {n} or comments them out, and leaves {m} to \
             be corrected by hand",
            n + m
        ),
    };
    Err(Failure::Rejected(said))
}

/// What a run's checks say without contradicting the map.
const UNDECIDED: [&str; 2] = ["standstill", "brakes_unclear"];

/// What the checks of a run say of the log as this map reads it.
///
/// # Errors
/// A run rejects the log with this map.
fn as_read(
    log: &Location,
    maps: &[ChannelMap],
    bike: Option<&Bike>,
) -> Result<Vec<Warning>, Error> {
    let config = ingest::Config::default();
    let (session, _) = ingest::read(log, maps).and_then(|raw| ingest::run(raw, &config))?;
    if !session.get(Channel::VelocityX).is_some_and(|v| v.iter().any(|v| v.is_finite())) {
        let message = "it gives no velocity_x, which every coefficient needs";
        return Err(Error { code: RejectionCode::MissingColumn, message: message.into() });
    }
    Ok(ingest::look(&session, bike, &config))
}

/// What `--mend` did: entries that it corrected, and those that it commented out.
fn done(findings: &[Finding], far: &[Channel], out: &[Channel]) -> String {
    let is_corrected = |c: &Channel| !far.contains(c) && !out.contains(c);
    let mut corrected: Vec<Channel> =
        findings.iter().map(|f| f.channel).filter(is_corrected).collect();
    corrected.dedup();
    let mut said = format!("{} entries corrected", corrected.len());
    if !out.is_empty() {
        let names: Vec<&str> = out.iter().map(|c| c.name()).collect();
        let _ = write!(said, ", {} commented out: {}", out.len(), names.join(", "));
    }
    said
}

/// What a comparison found, for people.
fn report(found: &Comparison) -> String {
    let mut text = String::new();
    for f in &found.findings {
        let _ = writeln!(text, "{}: {}: {}", f.channel, f.wrong.name(), f.message);
    }
    let names = |all: &[Channel]| all.iter().map(|c| c.name()).collect::<Vec<_>>().join(", ");
    for (what, all) in
        [("agree with the motion", &found.agree), ("no motion tells", &found.unchecked)]
    {
        if !all.is_empty() {
            let _ = writeln!(text, "{what}: {}", names(all));
        }
    }
    text
}

/// Asks about every column that has guesses only.
fn ask(
    verdicts: &mut Verdicts,
    listing: &Listing,
    input: &mut dyn BufRead,
    output: &mut dyn Write,
) -> std::io::Result<()> {
    let sure: Vec<Channel> =
        verdicts.entries.iter().filter(|e| e.doubt.is_none()).map(|e| e.channel).collect();
    let mut asked: Vec<Channel> = Vec::new();
    let mut chosen: Vec<Verdict> = Vec::new();
    for verdict in &mut verdicts.entries {
        let channel = verdict.channel;
        let Some(doubt) = verdict.doubt.clone() else { continue };
        if sure.contains(&channel) || asked.contains(&channel) {
            continue;
        }
        asked.push(channel);
        let name = listing.channels[verdict.source].full();
        writeln!(
            output,
            "\n{channel} from `{name}`? {}\n  not sure: {doubt}",
            verdict.why.join("; ")
        )?;
        loop {
            write!(output, "  [a]ccept, [l]eave out, or the name of another channel: ")?;
            output.flush()?;
            let mut line = String::new();
            if input.read_line(&mut line)? == 0 {
                return Ok(());
            }
            match line.trim() {
                "a" => verdict.doubt = None,
                "l" | "" => {}
                other => match listing
                    .channels
                    .iter()
                    .position(|c| c.full() == other || c.name == other)
                {
                    Some(place) => {
                        let unit = listing.channels[place].unit.clone();
                        let unit = unit.unwrap_or_else(|| verdict.unit.clone());
                        chosen.push(Verdict::new(channel, place, &unit).because("chosen by hand"));
                    }
                    None => {
                        writeln!(output, "  the log has no channel `{other}`")?;
                        continue;
                    }
                },
            }
            break;
        }
    }
    verdicts.entries.extend(chosen);
    verdicts.entries.sort_by_key(|e| (e.channel, e.doubt.is_some()));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::formats::listing::SourceChannel;

    /// What is promised of `--mend` is what it does.
    #[test]
    fn what_mend_leaves_is_said() {
        let said = |mendable, left| refused(mendable, left).expect_err("wrong").parts().1;
        assert!(refused(0, 0).is_ok());
        assert!(said(2, 0).contains("2 of the map's") && said(2, 0).contains("--mend corrects"));
        assert!(said(0, 2).contains("--mend leaves them") && said(0, 2).contains("by hand"));
        assert!(said(1, 2).starts_with("3 of") && said(1, 2).contains("leaves 2"));
    }

    #[test]
    fn guesses_are_asked_about_and_answers_obeyed() {
        let channel = |name: &str| SourceChannel { name: name.into(), ..SourceChannel::default() };
        let listing =
            Listing { channels: ["a", "b", "c"].map(channel).to_vec(), ..Listing::default() };
        let guess = |c: Channel, place: usize| Verdict::new(c, place, "deg").doubted("a guess");
        let mut verdicts = Verdicts {
            entries: vec![
                Verdict::new(Channel::VelocityX, 0, "m/s"),
                guess(Channel::Roll, 1),
                guess(Channel::Pitch, 1),
                guess(Channel::Yaw, 1),
            ],
            ..Verdicts::default()
        };
        let mut said = Vec::new();
        ask(&mut verdicts, &listing, &mut &b"a\nl\nnone\nc\n"[..], &mut said).expect("asked");
        let sure: Vec<(Channel, usize)> = verdicts
            .entries
            .iter()
            .filter(|e| e.doubt.is_none())
            .map(|e| (e.channel, e.source))
            .collect();
        assert_eq!(sure, [(Channel::VelocityX, 0), (Channel::Roll, 1), (Channel::Yaw, 2)]);
        let said = String::from_utf8(said).expect("text");
        assert!(said.contains("no channel `none`") && said.contains("not sure: a guess"), "{said}");
    }
}
