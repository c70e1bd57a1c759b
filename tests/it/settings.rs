//! Every key of a pipeline file changes some result: a key that changes nothing misleads its user.
//!
//! The keys are those of the files themselves and of the settings with every default, so a new one is tried without
//! being listed here.

use std::path::Path;

use arrow::array::RecordBatch;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest;
use roadbench::internals::ingest::Raw;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::{self, BUILTIN, Input, Pipeline};
use roadbench::internals::simulate::motocross::{self, scenario::Motocross};
use toml::Value;

use crate::superbike;

/// Keys that name the pipeline and set nothing.
const LABELS: [&str; 1] = ["name"];
/// What none of the rides here shows: they would take a rider off the line, a sensor stuck for just that long, whoops
/// of just that many bumps, unlike clocks, both brakes for a part of a stop.
const UNSEEN: [&str; 9] = [
    "segment.braking.least_share",
    "segment.braking.rear_share",
    "laps.half_width",
    "laps.least_on_track",
    "ingest.stuck_time",
    "offroad.max_lag",
    "segment.offroad.whoops_count",
    // no ride here has an altitude: `tests/it/hills.rs`
    "estimate.grade",
    // the only other value is that of the pipeline `onroad`
    "paper: estimate.formulation",
];
/// Texts and lists: another value of each.
const OTHERS: [(&str, &str); 4] = [
    ("estimate.formulation", "'paper'"),
    ("offroad.riders", "['none']"),
    ("offroad.chain", "'ignored'"),
    ("offroad.solve.weights", "'lengths'"),
];
/// What a number is multiplied by, until one changes a result or all are tried.
const FACTORS: [f64; 8] = [2.0, 0.5, 1.2, 0.8, 4.0, 0.25, 20.0, 0.05];

/// A ride as it was read, and its motorcycle.
struct Ride {
    raw: Raw,
    bike: Bike,
}

impl Ride {
    fn through(&self, pipeline: &Pipeline) -> Result<Vec<RecordBatch>, String> {
        let input = Input {
            log: Path::new("ride").into(),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: true,
        };
        let outcome = pipeline::run_raw(self.raw.clone(), &input, &self.bike, pipeline)
            .map_err(|e| e.to_string())?;
        Ok(outcome.tables().expect("tables").into_iter().map(|(_, batch)| batch).collect())
    }
}

/// The first seconds of a log.
fn cut(raw: &mut Raw, seconds: f64) {
    for track in &mut raw.tracks {
        let n = track.time.partition_point(|t| *t < track.time[0] + seconds);
        track.time = track.time[..n].to_vec().into();
        track.values.truncate(n);
    }
}

/// A ride of the bundled archive with a gap, a spike and a sensor that was stuck for a while.
fn road() -> Ride {
    let archive = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let log = "sessions/bike=archive_01/date=2026-05-01/archive_s0002.parquet";
    let mut raw = ingest::read(archive.join(log).as_path(), &[]).expect("read");
    cut(&mut raw, 300.0);
    for track in &mut raw.tracks {
        let values = &mut track.values;
        values[3000..3010].fill(f64::NAN); // 0.2 s
        values[4000..4018].fill(f64::NAN); // 0.36 s
        if track.channel == Channel::AccelerationX {
            values[5000] += 9.0;
        }
        if track.channel == Channel::YawRate {
            let stuck = values[6000];
            values[6000..6120].fill(stuck); // 2.4 s
        }
    }
    // nobody knows the tyres' side force ratio: changing lean gives it
    let text = std::fs::read_to_string(archive.join("bikes/archive_01.toml")).expect("bike");
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("archive_01.toml");
    let known: Vec<&str> = text.lines().filter(|l| !l.contains("side_force_ratio")).collect();
    std::fs::write(&path, known.join("\n")).expect("written");
    Ride { raw, bike: Bike::read(&path).expect("bike") }
}

/// The same ride without gear and brake pressures: what is found by the motion alone.
fn bare() -> Ride {
    let mut ride = road();
    let seen = [Channel::Gear, Channel::BrakePressureFront, Channel::BrakePressureRear];
    ride.raw.tracks.retain(|track| !seen.contains(&track.channel));
    ride
}

/// Laps of a track in gear.
fn track() -> Ride {
    let loggers = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers");
    let map = ChannelMap::parse(&superbike::drafted(), "drafted").expect("map");
    let raw = ingest::read(loggers.join("superbike.csv").as_path(), &[map]).expect("read");
    Ride { raw, bike: Bike::read(&loggers.join("bike.toml")).expect("bike") }
}

/// A stretch of motocross with two holes.
fn dirt() -> Ride {
    let (_, text) = motocross::scenario::BUILTIN
        .iter()
        .find(|(name, _)| *name == "motocross")
        .expect("built in");
    let text = text.replace("duration = 60.0", "duration = 14.0");
    let scenario = Motocross::parse(&text, Path::new("motocross.toml")).expect("scenario");
    let session = motocross::ride(&scenario, 0).session;
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path().join("ride.parquet");
    ingest::write_session(&path, &session, true).expect("written");
    let mut raw = ingest::read(path.as_path(), &[]).expect("read");
    for track in &mut raw.tracks {
        track.values[6400..6405].fill(f64::NAN); // 3 ms
        track.values[9600..9612].fill(f64::NAN); // 7 ms
    }
    Ride { raw, bike: scenario.bike }
}

/// Leaves by dotted path.
fn leaves(prefix: &str, table: &toml::Table, out: &mut Vec<(String, Value)>) {
    for (key, value) in table {
        let path = if prefix.is_empty() { key.clone() } else { format!("{prefix}.{key}") };
        match value {
            Value::Table(inner) => leaves(&path, inner, out),
            leaf => out.push((path, leaf.clone())),
        }
    }
}

/// A file's text with another value of a key.
fn with(table: &toml::Table, path: &str, value: &Value) -> String {
    let mut table = table.clone();
    let mut inner = &mut table;
    let (folders, leaf) = path.rsplit_once('.').unwrap_or(("", path));
    for key in folders.split('.').filter(|key| !key.is_empty()) {
        inner = inner.get_mut(key).and_then(Value::as_table_mut).expect("a table");
    }
    inner.insert(leaf.to_owned(), value.clone());
    table.to_string()
}

/// Other values of a key.
fn others(path: &str, value: &Value) -> Vec<Value> {
    match value {
        Value::Boolean(x) => vec![Value::Boolean(!x)],
        Value::Integer(n) => [n + 1, n * 2, (n - 1).max(1), n * 10].map(Value::Integer).into(),
        Value::Float(0.0) => [25.0, 1.0, 0.1].map(Value::Float).into(),
        Value::Float(x) => FACTORS.map(|factor| Value::Float(factor * x)).into(),
        _ => {
            let known = OTHERS.iter().find(|(key, _)| *key == path);
            let (_, other) = known.unwrap_or_else(|| panic!("`{path}`: give OTHERS another value"));
            let table: toml::Table = format!("x = {other}").parse().expect("TOML");
            vec![table["x"].clone()]
        }
    }
}

/// Keys of `table` that change no result of the rides.
fn idle(table: &toml::Table, keys: &[String], rides: &[&Ride]) -> Vec<(String, Value)> {
    let text = table.to_string();
    let pipeline = Pipeline::parse(&text, "as it is").expect("settings");
    let before: Vec<_> = rides.iter().map(|ride| ride.through(&pipeline)).collect();
    assert!(before.iter().all(Result::is_ok), "{:?}", before.iter().find(|b| b.is_err()));
    let mut all = Vec::new();
    leaves("", table, &mut all);
    let tried = all.into_iter().filter(|(path, _)| keys.contains(path));
    let tried: Vec<(String, Value)> = tried.collect();
    assert_eq!(tried.len(), keys.len(), "keys that the settings do not have");
    let changes = |(path, value): &(String, Value)| {
        others(path, value).iter().any(|other| {
            // a value that is refused is no change of a result
            let Ok(changed) = Pipeline::parse(&with(table, path, other), "changed") else {
                return false;
            };
            let mut pairs = rides.iter().zip(&before);
            pairs.any(|(ride, before)| ride.through(&changed) != *before)
        })
    };
    tried.into_par_iter().filter(|one| !changes(one)).collect()
}

/// The settings of a built-in pipeline, every default written out, and their keys.
fn resolved(name: &str) -> (toml::Table, Vec<String>) {
    let text = toml::to_string(&Pipeline::builtin(name)).expect("text");
    let table: toml::Table = text.parse().expect("TOML");
    let mut all = Vec::new();
    leaves("", &table, &mut all);
    (table, all.into_iter().map(|(path, _)| path).collect())
}

#[test]
fn every_key_of_a_pipeline_changes_some_result() {
    let (road, bare, track, dirt) = (road(), bare(), track(), dirt());
    let mut idle_keys = Vec::new();
    for (name, text) in BUILTIN {
        let (table, keys) = resolved(name);
        let mut own = Vec::new();
        leaves("", &text.parse().expect("TOML"), &mut own);
        let own: Vec<String> = own.into_iter().map(|(path, _)| path).collect();
        let is_dirt = table.contains_key("offroad");
        let of_dirt = |path: &str| path.starts_with("offroad.") || path.contains(".offroad.");
        let is_seen = |path: &str| {
            let key = format!("{name}: {path}");
            !LABELS.contains(&path) && !UNSEEN.iter().any(|unseen| key.contains(unseen))
        };
        // a file's own keys all; the defaults of stages that it runs
        let (of_track, rest): (Vec<String>, Vec<String>) = keys
            .into_iter()
            .filter(|path| is_seen(path))
            .filter(|path| match *name {
                "onroad" => own.contains(path) || !of_dirt(path),
                "offroad" => own.contains(path) || of_dirt(path),
                _ => own.contains(path),
            })
            .partition(|path| path.starts_with("in_gear.") || path.starts_with("laps."));
        let missing: Vec<&String> = own
            .iter()
            .filter(|path| is_seen(path))
            .filter(|path| !of_track.contains(path) && !rest.contains(path))
            .collect();
        assert!(missing.is_empty(), "{name}: not tried: {missing:?}");
        let (on_track, others): (Vec<&Ride>, Vec<&Ride>) = match is_dirt {
            true => (vec![], vec![&dirt]),
            false => (vec![&track], vec![&road, &bare, &track]),
        };
        // the fit of whole rides takes two thirds of a lap's time, and other keys show without it
        let without = with(&table, "in_gear.enabled", &Value::Boolean(false));
        let without: toml::Table = without.parse().expect("TOML");
        let (of_fit, of_laps): (Vec<String>, Vec<String>) =
            of_track.into_iter().partition(|path| path.starts_with("in_gear."));
        let mut found = idle(&table, &of_fit, &on_track);
        for (keys, rides) in [(of_laps, &on_track), (rest, &others)] {
            let unshown: Vec<String> =
                idle(&without, &keys, rides).into_iter().map(|(path, _)| path).collect();
            if !unshown.is_empty() {
                found.extend(idle(&table, &unshown, rides));
            }
        }
        idle_keys
            .extend(found.into_iter().map(|(path, value)| format!("{name}: {path} = {value}")));
    }
    assert!(idle_keys.is_empty(), "keys that change nothing:\n{}", idle_keys.join("\n"));
}

/// An old file may have keys that are gone: it is said which, and what to do.
#[test]
fn a_key_that_is_gone_is_told() {
    let old = "name = 'mine'\n[fit.friction]\nsearch_iterations = 120\n";
    let said = Pipeline::parse(old, "mine.toml").expect_err("an old file").to_string();
    for part in ["mine.toml", "`fit.friction.search_iterations`", "delete the line"] {
        assert!(said.contains(part), "{said}");
    }
    let archive = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let text = std::fs::read_to_string(archive.join("bikes/archive_01.toml")).expect("bike");
    let old = text.replace("[front]\n", "[front]\nslip_transition = 1.1\n");
    let bike = Bike::parse(&old, "archive_01", Path::new("archive_01.toml")).expect("passed by");
    let log = "sessions/bike=archive_01/date=2026-05-01/archive_s0002.parquet";
    let (_, warnings) =
        pipeline::prepare(archive.join(log).as_path(), &[], &bike, &Pipeline::onroad())
            .expect("prepared");
    let said = warnings.iter().find(|w| w.code == "removed_key").expect("said");
    for part in ["archive_01", "`front.slip_transition`", "delete the line"] {
        assert!(said.message.contains(part), "{}", said.message);
    }
}
