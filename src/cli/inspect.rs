//! `roadbench inspect`: channels, rates and gaps of a log, and what can be estimated from it.

use crate::contract::schema;
use std::path::{Path, PathBuf};

use clap::ValueHint;

use crate::cli::batch::BIKES;
use crate::cli::failure::Failure;
use crate::cli::inspect_source::{Form, print, show};
use crate::cli::location::{location, require_folder};
use crate::cli::log::{self, rejected};
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::coefficient::{Coefficient, Requirement, Source};
use crate::contract::rejection::RejectionCode;
use crate::contract::session::{Meta, Session};
use crate::contract::warning::Warning;
use crate::fit::missing;
use crate::ingest::checks::aids::Aids;
use crate::ingest::maps::ChannelMap;
use crate::ingest::maps::file::with_aids;
use crate::ingest::{self, Raw, Track};
use crate::pipeline::{Pipeline, characterise};
use crate::statistics::order::upper_median_of;
use crate::store::objects::Location;

mod facts;
pub(super) mod text;

use facts::{ChannelFacts, Estimate, Facts, Inspection, Noticed, Reason};

/// Show a log's channels, rates, gaps and what it can estimate
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The log.
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    log: Location,
    /// Folder of bike files; with it units and signs are checked against the bike.
    #[arg(long, value_name = "DIR", env = BIKES, hide_env_values = true)]
    bikes: Option<PathBuf>,
    /// Channel map to use; may be repeated. Without it the shipped maps are tried.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// CAN database that the log's frames are read by; may be repeated.
    #[arg(long, value_name = "FILE")]
    dbc: Vec<PathBuf>,
    /// Show the log's own channels, even where a channel map fits it.
    #[arg(long)]
    source: bool,
    /// Print a draft of a channel map for the log and nothing else.
    #[arg(long, conflicts_with = "json")]
    propose: bool,
    /// Pipeline file; without it the built-in one.
    #[arg(long, value_name = "FILE")]
    pipeline: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    log::require(&arguments.log)?;
    if let Some(folder) = &arguments.bikes {
        require_folder(folder)?;
    }
    let aids = Aids::read(&arguments.dbc).map_err(Failure::usage)?;
    let maps = ChannelMap::read_all(&arguments.map).map_err(Failure::usage)?;
    let maps = with_aids(maps, &aids);
    let pipeline = match &arguments.pipeline {
        Some(path) => Pipeline::read(path).map_err(Failure::usage)?,
        None => Pipeline::onroad(),
    };
    let form = match (arguments.propose, arguments.json) {
        (true, _) => Form::Draft,
        (_, true) => Form::Json,
        _ => Form::Text,
    };
    if arguments.source || arguments.propose {
        return show(&arguments.log, &aids, form, None);
    }
    let raw = match ingest::read(&arguments.log, &maps) {
        Ok(raw) => raw,
        Err(e) if e.code == RejectionCode::NoChannelMap && arguments.map.is_empty() => {
            return show(&arguments.log, &aids, form, Some(e));
        }
        Err(e) => return Err(rejected(e)),
    };
    let nameless = raw.meta.bike_id.is_empty();
    let bike = match &arguments.bikes {
        Some(folder) if !nameless => Some(read_bike(folder, &raw.meta)?),
        _ => None,
    };
    let mut inspection = inspect(raw, bike.as_ref(), &pipeline).map_err(rejected)?;
    if let Some(folder) = arguments.bikes.as_ref().filter(|_| nameless) {
        inspection.warnings.push(without_bike(folder));
    }
    let text = if arguments.json {
        let json = serde_json::to_string_pretty(&inspection);
        json.map_err(|e| Failure::Output(e.to_string()))? + "\n"
    } else {
        inspection.to_text()
    };
    print(&text)?;
    match inspection.rejected {
        Some(reason) => Err(Failure::Rejected(format!("{} ({})", reason.message, reason.code))),
        None => Ok(()),
    }
}

/// What is said where bike files are given and the log does not say of which bike it is.
fn without_bike(folder: &Path) -> Noticed {
    let message = format!(
        "the log names no bike, so nothing was checked against the bike files in {}: name it with \
         `convert LOG --bike ID --out FILE`, with `bike_id` in the [meta] of its channel map, or put the log into a \
         folder `bike_id=ID`",
        folder.display()
    );
    Noticed { code: "no_bike_id", channel: None, count: 1, time: None, message }
}

fn read_bike(folder: &Path, meta: &Meta) -> Result<(PathBuf, Bike), Failure> {
    let path = folder.join(format!("{}.toml", meta.bike_id));
    let bike = Bike::read(&path).map_err(Failure::usage)?;
    Ok((path, bike))
}

/// Looks at a log as the pipeline would, without stopping at what it would reject.
fn inspect(
    raw: Raw,
    bike: Option<&(PathBuf, Bike)>,
    pipeline: &Pipeline,
) -> Result<Inspection, ingest::Error> {
    let config = &pipeline.ingest;
    let source: Vec<(Channel, usize, Option<f64>)> =
        raw.tracks.iter().map(|t| (t.channel, recorded(t), source_rate(t))).collect();
    let (mut session, mut warnings) = ingest::run(raw, config)?;
    let table = schema::session();
    let mut channels: Vec<ChannelFacts> = session
        .channels()
        .filter_map(|c| {
            let from = source.iter().find(|s| s.0 == c);
            let (samples, rate) = from.map_or((0, None), |s| (s.1, s.2));
            // what may be missing before its first and after its last sample: a slow channel's own
            // period is no gap
            let ends = config.max_gap.max(rate.map_or(0.0, |r| 1.5 / r));
            let source = OfSource { samples, rate, ends };
            Some(channel_facts(&session, c, table.column(c.name())?, source))
        })
        .collect();
    let facts = facts(&session, bike.map(|b| b.0.clone()));
    let mut rejected = None;
    // as a run does; off-road a session without velocity has nothing that could be checked
    let known = bike.map(|b| &b.1);
    if known.is_some() && pipeline.offroad.is_none() || session.has(Channel::VelocityX) {
        match ingest::check(&mut session, known, config) {
            Ok(more) => warnings.extend(more),
            Err(e) => rejected = Some(Reason { code: e.code.as_str(), message: e.message }),
        }
    }
    for c in &mut channels {
        let codes: Vec<&str> = warnings
            .iter()
            .filter(|w| w.channel.is_some_and(|x| x.name() == c.channel))
            .map(|w| w.code)
            .collect();
        if !codes.is_empty() {
            c.verdict = codes.join(", ");
        }
    }
    let estimates = estimates(&session);
    let costs = match bike {
        Some((_, bike)) if rejected.is_none() => costs(session, bike, pipeline),
        _ => Vec::new(),
    };
    let warnings = warnings.into_iter().map(noticed).collect();
    Ok(Inspection { session: facts, channels, warnings, rejected, estimates, costs })
}

/// What the numbers cost that the bike file does not have: known once the tyres are estimated.
fn costs(session: Session, bike: &Bike, pipeline: &Pipeline) -> Vec<String> {
    if pipeline.offroad.is_some() {
        return Vec::new();
    }
    let ridden = characterise(session, bike, pipeline, pipeline.estimate.formulation);
    missing::costs(&ridden.solution).iter().map(ToString::to_string).collect()
}

fn noticed(w: Warning) -> Noticed {
    Noticed {
        code: w.code,
        channel: w.channel.map(Channel::name),
        count: w.count,
        time: w.time,
        message: w.message,
    }
}

fn facts(session: &Session, bike_file: Option<PathBuf>) -> Facts {
    let Meta { session_id, bike_id, start_time, tyre_front, tyre_rear, site, rider_id } =
        session.meta.clone();
    let distance = session
        .get(Channel::VelocityX)
        .map(|v| v.iter().filter(|v| v.is_finite()).map(|v| v.abs()).sum::<f64>() / session.rate);
    Facts {
        session_id,
        bike_id,
        start_time,
        tyre_front,
        tyre_rear,
        site,
        rider_id,
        duration: session.duration(),
        rate: session.rate,
        samples: session.len,
        distance,
        bike_file,
    }
}

fn recorded(track: &Track) -> usize {
    track.values.iter().filter(|v| v.is_finite()).count()
}

/// The usual distance of a source's samples as a rate, Hz.
fn source_rate(track: &Track) -> Option<f64> {
    let stamps = track.time.iter().zip(&track.values).filter(|(_, v)| v.is_finite());
    let stamps: Vec<f64> = stamps.map(|(t, _)| *t).collect();
    let steps: Vec<f64> = stamps.windows(2).map(|w| w[1] - w[0]).filter(|d| *d > 0.0).collect();
    Some(1.0 / upper_median_of(&steps)?)
}

/// A channel in the log itself.
struct OfSource {
    samples: usize,
    /// Hz
    rate: Option<f64>,
    /// What its first and last sample may be off the session's, s.
    ends: f64,
}

/// Number of gaps on the common clock, and samples in the longest. Before the first and after the
/// last sample less than `ends` samples are none.
fn gaps(x: &[f64], ends: f64) -> (usize, usize) {
    let there = |v: &f64| v.is_finite();
    let (mut gaps, mut longest, mut at) = (0, 0, 0);
    for run in x.chunk_by(|a, b| there(a) == there(b)) {
        let outside = at == 0 || at + run.len() == x.len();
        at += run.len();
        if there(&run[0]) || (outside && (run.len() as f64) < ends && run.len() < x.len()) {
            continue;
        }
        gaps += 1;
        longest = longest.max(run.len());
    }
    (gaps, longest)
}

fn channel_facts(
    session: &Session,
    channel: Channel,
    column: &crate::contract::schema::Column,
    source: OfSource,
) -> ChannelFacts {
    let OfSource { samples, rate, ends } = source;
    let x = session.get(channel).unwrap_or_default();
    let there: Vec<f64> = x.iter().copied().filter(|v| v.is_finite()).collect();
    let (gaps, longest) = gaps(x, ends * session.rate);
    let outside = column
        .range
        .map_or(0, |[low, high]| there.iter().filter(|v| !(low..=high).contains(*v)).count());
    let verdict = match (there.len(), outside) {
        (0, _) => "empty".to_owned(),
        (_, 0) => "plausible".to_owned(),
        (n, k) => format!("{:.1} % out of range", 100.0 * k as f64 / n as f64),
    };
    ChannelFacts {
        channel: channel.name(),
        unit: column.unit.clone().unwrap_or_default(),
        rate,
        samples,
        missing: 100.0 * (x.len() - there.len()) as f64 / x.len().max(1) as f64,
        gaps,
        longest_gap: longest as f64 / session.rate,
        min: there.iter().copied().reduce(f64::min),
        max: there.iter().copied().reduce(f64::max),
        median: upper_median_of(&there),
        verdict,
    }
}

/// What a log with suspension travel gives besides, with the pipeline for it.
const OFFROAD: &str = "standing, with --pipeline offroad: also every tyre force over time";

/// What the channels allow, coefficients side by side that need the same.
fn estimates(session: &Session) -> Vec<Estimate> {
    let suspended = session.has(Channel::ForkTravel) || session.has(Channel::ShockTravel);
    let alike = |a: &Coefficient, b: &Coefficient| {
        let kind = |c: &Coefficient| std::mem::discriminant(&c.spec().source);
        kind(a) == kind(b) && estimated_alike(a.spec().requirements, b.spec().requirements)
    };
    Coefficient::ALL
        .chunk_by(alike)
        .filter(|group| {
            let offroad = group[0].spec().source == Source::OffRoad;
            group[0].is_onroad() || (suspended && offroad)
        })
        .flat_map(|group| {
            let requirements = group[0].spec().requirements.iter();
            requirements.map(|r| estimate(session, group, r))
        })
        .collect()
}

/// Whether two coefficients need the same channels and riding for the same parts.
fn estimated_alike(a: &[Requirement], b: &[Requirement]) -> bool {
    let same = |(x, y): (&Requirement, &Requirement)| {
        (x.part, x.channels, x.riding.manoeuvres) == (y.part, y.channels, y.riding.manoeuvres)
    };
    a.len() == b.len() && a.iter().zip(b).all(same)
}

fn estimate(session: &Session, group: &[Coefficient], requirement: &Requirement) -> Estimate {
    let source = group[0].spec().source;
    let missing = requirement.missing(session);
    let status = match source {
        Source::BikeFile(_) => "assumed",
        _ if missing.is_empty() => "possible",
        Source::ChangingLean(_) => "assumed",
        _ => "not_available",
    };
    let mut riding = requirement.riding.manoeuvres.to_owned();
    if source == Source::OffRoad {
        riding = format!("{riding}, {OFFROAD}");
    }
    Estimate {
        tyre: requirement.part.name(),
        coefficients: group.iter().map(|c| c.name()).collect(),
        status,
        missing_channels: missing.into_iter().map(Channel::name).collect(),
        riding,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn track(channel: Channel, time: &Arc<Vec<f64>>, f: impl Fn(f64) -> f64) -> Track {
        Track { channel, time: Arc::clone(time), values: time.iter().map(|t| f(*t)).collect() }
    }

    #[test]
    fn a_log_of_two_channels_is_described() {
        let time = Arc::new((0..3000).map(|i| f64::from(i) / 50.0).collect::<Vec<f64>>());
        let v = |t: f64| if (20.0..25.0).contains(&t) { f64::NAN } else { 10.0 + t / 6.0 };
        let raw = Raw {
            tracks: vec![
                track(Channel::VelocityX, &time, v),
                track(Channel::WheelSpeedFront, &time, |t| (10.0 + t / 6.0) / 0.3),
            ],
            ..Raw::default()
        };
        let got = inspect(raw, None, &Pipeline::onroad()).expect("readable");
        let velocity = &got.channels[0];
        assert_eq!((velocity.channel, velocity.samples, velocity.gaps), ("velocity_x", 2750, 1));
        assert!((velocity.rate.expect("rate") - 50.0).abs() < 1e-6);
        assert!((velocity.missing - 100.0 / 12.0).abs() < 0.1, "{}", velocity.missing);
        assert!((velocity.longest_gap - 5.0).abs() < 0.1, "{}", velocity.longest_gap);
        assert_eq!(velocity.min, Some(10.0));
        let possible: Vec<&str> =
            got.estimates.iter().filter(|e| e.status == "possible").map(|e| e.tyre).collect();
        // drag takes something that shows coasting
        assert_eq!(possible, ["front", "front"]);
        let text = got.to_text();
        assert!(text.contains("missing: wheel_speed_rear; then from straight coasting"), "{text}");
        assert!(text.contains("give --bikes"), "{text}");
        assert!(serde_json::to_string(&got).is_ok());
    }

    #[test]
    fn a_slow_channel_ends_before_the_others_without_a_gap() {
        let clock = |rate: f64, n: i32| -> Arc<Vec<f64>> {
            Arc::new((0..n).map(|i| f64::from(i) / rate).collect())
        };
        // the last second is missing of one that has 100 samples a second, not of one that has one
        let (fast, slow, short) = (clock(100.0, 2099), clock(1.0, 21), clock(100.0, 2000));
        let ingest = ingest::Config { stuck_time: 0.0, ..ingest::Config::default() };
        let pipeline = Pipeline { ingest, ..Pipeline::onroad() };
        let raw = Raw {
            tracks: vec![
                track(Channel::RollRate, &fast, |t| (7.0 * t).sin()),
                track(Channel::VelocityX, &slow, |t| 10.0 + t.sin()),
                track(Channel::YawRate, &short, |t| (5.0 * t).cos()),
            ],
            ..Raw::default()
        };
        let got = inspect(raw, None, &pipeline).expect("readable");
        let gaps = |c: Channel| {
            let facts = got.channels.iter().find(|f| f.channel == c.name()).expect("there");
            (facts.gaps, (100.0 * facts.longest_gap).round())
        };
        assert_eq!(gaps(Channel::RollRate), (0, 0.0));
        assert_eq!(gaps(Channel::VelocityX), (0, 0.0));
        assert_eq!(gaps(Channel::YawRate), (1, 99.0));
        let nan = f64::NAN;
        let x = [nan, nan, 1.0, nan, 1.0, nan, nan];
        assert_eq!((super::gaps(&x, 3.0), super::gaps(&x, 2.0)), ((1, 1), (3, 2)));
        assert_eq!(super::gaps(&[nan; 3], 9.0), (1, 3));
    }
}
