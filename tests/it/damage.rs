//! Logs that were damaged at random, of every format: none stops the batch, none hangs, none is lost.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use roadbench::internals::batch::jobs::run::RunWork;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Finished, Maps, Settings, Watch};
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::formats::survey::survey;
use roadbench::internals::ingest::{self, write_session};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::store::objects::Location;

use crate::racing_files;

/// Damaged files of each format.
const EACH: usize = 80;
/// Logs of racing loggers, and damaged files of each.
pub const RACING: [&str; 6] = ["ld", "CTRK", "motec", "aim", "racechrono", "xsens"];
const OF_RACING: usize = 20;
/// The same of those that other software wrote: samples of fixtures/formats.
pub const FOREIGN: [(&str, &str); 13] = [
    ("mf4", "ride_logger.mf4"),
    ("mdf", "ride.mdf"),
    ("mcap", "ride_json.mcap"),
    ("blf", "ride.blf"),
    ("asc", "ride.asc"),
    ("trc", "ride.trc"),
    ("asc.gz", "ride.asc.gz"),
    ("gpx", "circle_garmin.gpx"),
    ("csv", "racing/racebox.csv"),
    ("fit", "circle.fit"),
    ("nmea", "circle.nmea"),
    ("ubx", "circle.ubx"),
    ("zip", "sensors/sensor_logger.zip"),
];
const EACH_FOREIGN: usize = 40;
/// Longest that a file may take, s; they are of 20 s of riding.
const LONGEST: f64 = 10.0;

/// 20 s of a bundled ride.
pub fn ride() -> Session {
    let log = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let raw = ingest::read(&log, &[]).expect("bundled");
    let whole = ingest::run(raw, &Pipeline::onroad().ingest).expect("bundled").0;
    let n = (20.0 * whole.rate) as usize;
    let mut ride = Session::new(Meta::default(), whole.rate, n);
    for channel in whole.channels() {
        ride.set(channel, whole.get(channel).expect("its own")[2000..2000 + n].to_vec());
    }
    ride
}

/// A whole file of each format, by its extension.
pub fn whole(ride: &Session, folder: &Path, name: &str, format: &str) -> Vec<u8> {
    let id = Meta { session_id: name.to_owned(), bike_id: "b1".into(), ..Meta::default() };
    match format {
        "parquet" => {
            let path = folder.join("whole.parquet");
            let mut ride = ride.clone();
            ride.meta = id;
            write_session(&path, &ride, false).expect("written");
            std::fs::read(path).expect("just written")
        }
        "csv" => {
            let channels: Vec<Channel> = ride.channels().collect();
            let names: Vec<&str> = channels.iter().map(|c| c.name()).collect();
            let mut text = format!("time,{}\n", names.join(","));
            for i in 0..ride.len {
                let values = channels.iter().map(|c| ride.get(*c).expect("its own")[i].to_string());
                let row: Vec<String> =
                    std::iter::once(ride.time(i).to_string()).chain(values).collect();
                text += &row.join(",");
                text.push('\n');
            }
            text.into_bytes()
        }
        "ld" => racing_files::motec_ld(ride),
        "CTRK" => racing_files::ctrk(ride),
        "motec" => racing_files::motec_csv(ride).into_bytes(),
        "aim" => racing_files::aim_csv(ride).into_bytes(),
        "racechrono" => racing_files::racechrono_v3(ride).into_bytes(),
        "xsens" => racing_files::xsens(ride).into_bytes(),
        _ => {
            // a logger of lines of several kinds
            let mut text = String::new();
            for ms in (0..20_000).step_by(100) {
                let speed = 40.0 + f64::from(ms) * 1e-3;
                text += &format!("susp {},{},{ms}\n", 500 + ms % 70, 480 - ms % 50);
                if ms % 200 == 0 {
                    // what the map takes for the wheel: 0.0537 m of road per radian of the motor
                    let motor = speed / 3.6 / 0.0537 * 60.0 / std::f64::consts::TAU;
                    text += &format!("15,{motor:.0},0,0,0,{ms}\n");
                }
                if ms % 1000 == 0 {
                    let at = 12_0000.0 + f64::from(ms) * 1e-3;
                    text += &format!(
                        "$GPGGA,{at:.3},4044.{:04},N,00150.2000,W,$GPVTG,12.5,T,,M,{:.2},N,\
                         {speed:.2},K,{ms}\n",
                        ms / 10,
                        speed / 1.852
                    );
                }
            }
            text.into_bytes()
        }
    }
}

/// One kind of damage, in turn.
pub fn damage(bytes: &mut Vec<u8>, kind: usize, random: &mut Pcg64) {
    let n = bytes.len();
    match kind % 10 {
        // bits
        0 => flip(bytes, 1, 0..n, random),
        1 => flip(bytes, 30, 0..n, random),
        2 => flip(bytes, 2000, 0..n, random),
        // the lies of a header and of a footer
        3 => flip(bytes, 3, 0..n.min(200), random),
        4 => flip(bytes, 6, n - n.min(600)..n, random),
        5 => bytes.truncate(random.random_range(0..n)),
        // a block that was never written
        6 => {
            let from = random.random_range(0..n);
            bytes[from..(from + 512).min(n)].fill(0);
        }
        // blocks in another order
        7 => {
            let half = n / 2;
            let by = random.random_range(1..half);
            bytes.rotate_left(by);
        }
        8 => {
            let from = random.random_range(0..n);
            let block = bytes[from..(from + 700).min(n)].to_vec();
            let at = random.random_range(0..n);
            bytes.splice(at..at, block);
        }
        _ => {
            let odd: [&[u8]; 8] = [
                b"\xff\xfe\x00\x00",
                b"\"",
                b"1e999999",
                b"\r",
                b"-9223372036854775808",
                b",,,,,,,,,,,,,,,,",
                b"PAR1",
                b"\xf0\x9f\x8f\x8d nan\n",
            ];
            for _ in 0..5 {
                let at = random.random_range(0..n.min(3000));
                let odd = odd[random.random_range(0..odd.len())];
                bytes.splice(at..at, odd.iter().copied());
            }
        }
    }
}

fn flip(bytes: &mut [u8], times: usize, within: std::ops::Range<usize>, random: &mut Pcg64) {
    for _ in 0..times {
        let at = random.random_range(within.clone());
        bytes[at] ^= 1 << random.random_range(0..8);
    }
}

/// Longest time and who took it.
#[derive(Default)]
struct Slowest(Mutex<(f64, String)>);

impl<R> Watch<R> for Slowest {
    fn finished(&self, finished: &Finished<'_>, _: Option<R>) {
        let mut slowest = self.0.lock().expect("no panic holds it");
        if finished.seconds > slowest.0 {
            *slowest = (finished.seconds, finished.log.to_owned());
        }
    }
}

/// The maps that come with roadbench and those of the samples.
fn maps() -> Maps {
    Maps::read(&map_files()).expect("ours")
}

pub fn map_files() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut paths: Vec<PathBuf> = ["pipelines/maps", "fixtures/formats"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).expect("ours"))
        .map(|entry| entry.expect("ours").path())
        .filter(|path| path.extension().is_some_and(|e| e == "toml"))
        .collect();
    paths.sort();
    paths
}

#[test]
fn damaged_logs_are_each_accounted_for() {
    let folder = tempfile::tempdir().expect("folder");
    let root = folder.path();
    let ride = ride();
    let mut random = Pcg64::seed_from_u64(6);
    let logs = root.join("logs/bike=b1");
    std::fs::create_dir_all(&logs).expect("folder");
    let formats = ["parquet", "csv", "txt"].map(|f| (f, EACH)).into_iter();
    for (format, each) in formats.chain(RACING.map(|f| (f, OF_RACING))) {
        for number in 0..each {
            let name = format!("{format}_{number:02}");
            let mut bytes = whole(&ride, root, &name, format);
            damage(&mut bytes, number, &mut random);
            let extension = match format {
                "motec" | "aim" | "racechrono" => "csv",
                "xsens" => "txt",
                other => other,
            };
            std::fs::write(logs.join(format!("{name}.{extension}")), bytes).expect("log");
        }
    }
    for (format, sample) in FOREIGN {
        let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats").join(sample);
        for number in 0..EACH_FOREIGN {
            let mut bytes = std::fs::read(&sample).expect("bundled");
            damage(&mut bytes, number, &mut random);
            std::fs::write(logs.join(format!("other_{format}_{number:02}.{format}")), bytes)
                .expect("log");
        }
    }
    let bikes = root.join("bikes");
    std::fs::create_dir_all(&bikes).expect("folder");
    let bike = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive/bikes/archive_01.toml");
    std::fs::copy(bike, bikes.join("b1.toml")).expect("bike");
    let inputs = [Location::from(root.join("logs"))];
    let settings = Settings {
        inputs: &inputs,
        bikes: Some(&bikes.into()),
        out: &root.join("out").into(),
        pipeline: &Pipeline::onroad(),
        maps: &maps(),
        jobs: 2,
        force: false,
        since: None,
    };
    let slowest = Slowest::default();
    let (run, _) = engine::run(&settings, &RunWork::default(), &slowest, &AtomicBool::new(false))
        .expect("run");
    let foreign = FOREIGN.len() * EACH_FOREIGN;
    assert_eq!(run.inputs, 3 * EACH + RACING.len() * OF_RACING + foreign);
    assert_eq!(run.done + run.rejected.len(), run.inputs);
    let mut codes = std::collections::BTreeMap::new();
    for row in &run.rejected {
        *codes.entry(row.code.as_str()).or_insert(0) += 1;
        assert_ne!(row.code, "internal_error", "{}: {}", row.path, row.message);
        assert!(!row.message.is_empty(), "{row:?}");
    }
    let (seconds, who) = slowest.0.into_inner().expect("no panic holds it");
    println!("{} through, rejected {codes:?}; the longest took {seconds:.2} s: {who}", run.done);
    assert!(seconds < LONGEST, "{who} took {seconds} s");
    // the corpus is neither harmless nor hopeless
    assert!(run.done > 30 && run.rejected.len() > 60, "{} through", run.done);
    assert!(codes.len() >= 5, "{codes:?}");
}

/// A number of four or eight bytes written over every block of that kind in an MDF 4 sample.
fn patched(kind: &[u8; 4], at: impl Fn(&[u8]) -> usize, number: &[u8]) -> Vec<u8> {
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats/ride_logger.mf4");
    let mut bytes = std::fs::read(sample).expect("bundled");
    let blocks: Vec<usize> =
        (0..bytes.len()).step_by(8).filter(|i| bytes[*i..].starts_with(kind)).collect();
    assert!(blocks.len() >= 4);
    for block in blocks {
        let place = block + at(&bytes[block..]);
        bytes[place..place + number.len()].copy_from_slice(number);
    }
    bytes
}

/// Small files that claim much: read without end, or into more memory than there is, were it believed.
#[test]
fn files_that_claim_without_bounds_end() {
    let twins =
        format!("Format,MoTeC CSV File\nTime{}\n0{}\n", ",a".repeat(4000), ",1".repeat(4000));
    let mut cases = vec![("twins.csv".to_owned(), twins.into_bytes())];
    for length in [1_u64 << 33, 1 << 62, u64::MAX - 30, u64::MAX] {
        let bytes = patched(b"##DT", |_| 8, &length.to_le_bytes());
        cases.push((format!("length_{length}.mf4"), bytes));
    }
    for count in [0_u32, 65, 1 << 20, u32::MAX] {
        let bytes = patched(b"##CN", |b| 24 + 8 * usize::from(b[16]) + 8, &count.to_le_bytes());
        cases.push((format!("bits_{count}.mf4"), bytes));
    }
    let folder = tempfile::tempdir().expect("folder");
    let maps = maps();
    for (name, bytes) in cases {
        let path = folder.path().join(&name);
        std::fs::write(&path, bytes).expect("log");
        let began = Instant::now();
        let read = ingest::read(&path, maps.list()).map(|raw| raw.tracks.len());
        let seen = survey(&path, &Aids::default()).map(|s| s.map_or(0, |s| s.contents.len()));
        let seconds = began.elapsed().as_secs_f64();
        println!("{name}: {read:?}, {seen:?} in {seconds:.2} s");
        assert!(seconds < LONGEST, "{name} took {seconds} s");
    }
}

/// A place that is not on Earth, in a track that goes round: found by mutants (a lap's crossing before all time).
#[test]
fn a_place_off_the_earth_is_no_place() {
    let folder = tempfile::tempdir().expect("folder");
    let sample = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats/circle_garmin.gpx");
    let text = std::fs::read_to_string(sample).expect("bundled");
    let bike = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive/bikes/archive_01.toml");
    let logs = folder.path().join("logs/bike=b1");
    std::fs::create_dir_all(&logs).expect("folder");
    std::fs::create_dir_all(folder.path().join("bikes")).expect("folder");
    std::fs::copy(bike, folder.path().join("bikes/b1.toml")).expect("bike");
    // one far beyond, and soon after one on another continent
    let damaged = text
        .replace("lat=\"49.9996975\"", "lat=\"999999999999999999999.9996975\"")
        .replace("lat=\"49.9997145\"", "lat=\"9.9997145\"");
    assert_ne!(damaged, text);
    std::fs::write(logs.join("round.gpx"), damaged).expect("log");
    let settings = Settings {
        inputs: &[Location::from(folder.path().join("logs"))],
        bikes: Some(&folder.path().join("bikes").into()),
        out: &folder.path().join("out").into(),
        pipeline: &Pipeline::onroad(),
        maps: &maps(),
        jobs: 2,
        force: false,
        since: None,
    };
    let (run, _) =
        engine::run(&settings, &RunWork::default(), &(), &AtomicBool::new(false)).expect("run");
    assert_eq!(run.done, 1, "{:?}", run.rejected);
}
