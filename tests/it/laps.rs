//! Laps against the simulator's truth, of foreign logs as loggers write them; and none where nothing goes round.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use assert_cmd::Command;
use roadbench::contract::channel::Channel;
use roadbench::contract::session::Session;
use roadbench::ingest::{self, map::ChannelMap};
use roadbench::laps::find::Kind;
use roadbench::laps::{Config, detect};
use roadbench::simulate::loggers::{self, Profile};
use roadbench::simulate::track::{self, Track, TrackRide};
use roadbench::statistics::random::Random;
use roadbench::tables::read;
use roadbench::tables::rows::{LapCornerRow, LapPointRow, LapRow};

use crate::page;

/// The session of the bundled log: two laps.
fn ridden() -> &'static TrackRide {
    static RIDE: OnceLock<TrackRide> = OnceLock::new();
    RIDE.get_or_init(|| {
        let track = Track::load("track").expect("built in").expect("a track");
        track::ride(&Track { laps: 2, ..track }, 0).expect("comes round")
    })
}

/// Four laps, so that two at least lie between crossings of the start line itself.
fn long() -> &'static TrackRide {
    static RIDE: OnceLock<TrackRide> = OnceLock::new();
    RIDE.get_or_init(|| {
        let track = Track::load("track").expect("built in").expect("a track");
        track::ride(&track, 0).expect("comes round")
    })
}

const SUPERBIKE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 'Time (ms)'\nunit = 'ms'\n\
    [channel.velocity_x]\nfrom = 'GPS Speed (km/h)'\nunit = 'km/h'\n\
    [channel.latitude]\nfrom = 'Latitude (deg)'\nunit = 'deg'\n\
    [channel.longitude]\nfrom = 'Longitude (deg)'\nunit = 'deg'\n";
const LAP: &str = "[channel.lap]\nfrom = 'Lap'\nunit = '1'\n";
const PHONE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 'Time'\n\
    [channel.velocity_x]\nfrom = 'Speed'\nunit = 'km/h'\n\
    [channel.latitude]\nfrom = 'Latitude'\nunit = 'deg'\n\
    [channel.longitude]\nfrom = 'Longitude'\nunit = 'deg'\n";
const FACTORY: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 't'\nunit = 's'\n\
    [channel.velocity_x]\nfrom = 'v_gps'\nunit = 'km/h'\n\
    [channel.latitude]\nfrom = 'lat_gps'\nunit = 'deg'\n\
    [channel.longitude]\nfrom = 'lon_gps'\nunit = 'deg'\n";
const SATELLITE: &str = "name = 'm'\nformat = 'vbo'\n\
    [channel.velocity_x]\nfrom = 'velocity'\nunit = 'km/h'\n\
    [channel.latitude]\nfrom = 'lat'\nunit = 'deg'\n\
    [channel.longitude]\nfrom = 'long'\nunit = 'deg'\n";

fn session(path: &Path, map: &str) -> Session {
    let map = ChannelMap::parse(map, "m.toml").unwrap_or_else(|e| panic!("{e}"));
    let raw = ingest::read(path, &[map]).unwrap_or_else(|e| panic!("{e}"));
    ingest::run(raw, &ingest::Config::default()).unwrap_or_else(|e| panic!("{e}")).0
}

fn logged(ride: &TrackRide, profile: Profile, seed: u64, map: &str) -> Session {
    let foreign = loggers::write(profile, ride, seed);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(&foreign.file);
    fs::write(&path, &foreign.text).expect("written");
    session(&path, map)
}

/// When the motorcycle came past a place of the circuit (m from its start) in truth, s.
fn passages(ride: &TrackRide, place: f64) -> Vec<f64> {
    let (rate, length) = (ride.ride.session.rate, ride.entry.circuit.length);
    let laps = |along: f64| ((along - place) / length).floor();
    let pairs = ride.hands.windows(2).enumerate();
    pairs
        .filter(|(_, h)| laps(h[1].along) > laps(h[0].along))
        .map(|(i, h)| {
            let at = place + length * laps(h[1].along);
            (i as f64 + (at - h[0].along) / (h[1].along - h[0].along)) / rate
        })
        .collect()
}

/// Where on the circuit the motorcycle was at a true time, m.
fn along(ride: &TrackRide, time: f64) -> f64 {
    let at = ((time * ride.ride.session.rate) as usize).min(ride.hands.len() - 1);
    ride.hands[at].along.rem_euclid(ride.entry.circuit.length)
}

/// Errors of the timed laps (s) with the standard errors given for them; positions come `late` (s).
fn errors(ride: &TrackRide, session: &Session, config: &Config, late: f64) -> Vec<[f64; 2]> {
    let (_, found) = detect(session, config).expect("laps");
    let timed: Vec<_> = found.laps.iter().filter(|l| l.kind == Kind::Timed).collect();
    let truth = passages(ride, along(ride, timed[0].start - late));
    assert!(timed.len() + 1 >= truth.len(), "{} of {} laps", timed.len(), truth.len() - 1);
    let near = |t: f64| {
        truth.iter().copied().min_by(|a, b| (a - t).abs().total_cmp(&(b - t).abs())).expect("truth")
    };
    timed
        .iter()
        .map(|l| [l.duration() - (near(l.end - late) - near(l.start - late)), l.error])
        .collect()
}

/// The start line itself, 20 m to each side of the middle of the road.
fn start_line() -> Config {
    let [a, b] = [[0.0, -20.0], [0.0, 20.0]].map(track::position);
    Config { line: Some([a, b]), ..Config::default() }
}

#[test]
fn the_bundled_log_has_the_lap_time_of_its_truth() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers/superbike.csv");
    let session = session(&path, SUPERBIKE);
    let errors = errors(ridden(), &session, &Config::default(), 0.2);
    assert_eq!(errors.len(), 1);
    let [error, sd] = errors[0];
    println!("bundled: {error:+.3} s, standard error {sd:.3}");
    // a receiver that is 1.2 m off at each crossing, at 45 m/s
    assert!(error.abs() < 3.0 * sd && (0.02..0.1).contains(&sd), "{error} {sd}");
    // the counter of the log rises only once: the line is found
    let counted = self::session(&path, &format!("{SUPERBIKE}{LAP}"));
    assert!(detect(&counted, &Config::default()).is_some());
}

#[test]
fn every_logger_gives_the_lap_times_of_the_truth() {
    let mut scaled = Vec::new();
    for (name, profile, map, late) in [
        ("superbike, 10 Hz", Profile::Superbike, SUPERBIKE, 0.2),
        ("phone, 25 Hz", Profile::Phone, PHONE, 0.1),
        ("satellite, 10 Hz", Profile::Satellite, SATELLITE, 0.0),
        ("factory, 100 Hz", Profile::Factory, FACTORY, 0.12),
    ] {
        for (line, config) in [("found", Config::default()), ("given", start_line())] {
            let mut squares = Vec::new();
            for seed in 0..3 {
                let session = logged(long(), profile, seed, map);
                let errors = errors(long(), &session, &config, late);
                assert!(errors.len() >= 2, "{name} {line}: {errors:?}");
                scaled.extend(errors.iter().map(|[e, sd]| e / sd));
                squares.extend(errors.iter().map(|[e, _]| e * e));
            }
            let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            println!("{name}, line {line}: rms {rms:.3} s of {} laps", squares.len());
            assert!(rms < 0.08, "{name} {line}: {rms}");
        }
    }
    let inside = scaled.iter().filter(|z| z.abs() < 1.96).count();
    println!("{inside} of {} within the 95 % interval", scaled.len());
    assert!(inside * 10 >= scaled.len() * 9, "{scaled:?}");
}

/// A receiver of one sample a second, 2.5 m of white noise and holes of 3 s.
#[test]
fn a_rough_receiver_still_gives_laps() {
    let mut session = logged(long(), Profile::Phone, 4, PHONE);
    let mut random = Random::new(3, "rough");
    let rate = session.rate;
    for channel in [Channel::Latitude, Channel::Longitude] {
        let scale = if channel == Channel::Latitude { 111_195.0 } else { 79_500.0 };
        for (i, x) in session.get_mut(channel).expect("logged").iter_mut().enumerate() {
            *x += 2.5 / scale * random.normal();
            if (i as f64 / rate) % 61.0 < 3.0 {
                *x = f64::NAN;
            }
        }
    }
    let errors = errors(long(), &session, &Config::default(), 0.1);
    println!("rough: {errors:.3?}");
    assert!(errors.len() >= 2 && errors.iter().all(|[e, _]| e.abs() < 0.25), "{errors:?}");
}

/// The counter of the logger puts the line where the logger has it.
#[test]
fn a_mapped_lap_counter_gives_the_line() {
    let session = logged(long(), Profile::Superbike, 1, &format!("{SUPERBIKE}{LAP}"));
    let (ground, found) = detect(&session, &Config::default()).expect("laps");
    assert_eq!(found.line.source.name(), "logger");
    // the counter is not late, the position is: 0.2 s at the speed there
    let [north, east] = ground.place(found.line.middle);
    let off = (north - track::ORIGIN[0]) * 111_195.0;
    assert!(off.abs() < 8.0, "{off}");
    assert!(((east - track::ORIGIN[1]) * 79_500.0).abs() < 20.0);
    let timed = found.laps.iter().filter(|l| l.kind == Kind::Timed).count();
    assert!(timed >= 2, "{timed}");
}

/// Once round the block and home is no track; nor is the way there and back.
#[test]
fn a_ride_that_goes_round_once_has_no_laps() {
    let mut session = logged(long(), Profile::Superbike, 1, SUPERBIKE);
    let rate = session.rate;
    let kept = (155.0 * rate) as usize;
    for channel in [Channel::Latitude, Channel::Longitude] {
        session.get_mut(channel).expect("logged")[kept..].fill(f64::NAN);
    }
    let mut once = Session::new(session.meta.clone(), rate, kept);
    for channel in [Channel::VelocityX, Channel::Latitude, Channel::Longitude] {
        once.set(channel, session.get(channel).expect("logged")[..kept].to_vec());
    }
    assert!(detect(&once, &Config::default()).is_none());
    // there, and back the same way
    let half = (60.0 * rate) as usize;
    let mut out_and_home = Session::new(session.meta, rate, 2 * half);
    for channel in [Channel::VelocityX, Channel::Latitude, Channel::Longitude] {
        let x = once.get(channel).expect("set");
        let there = &x[..half];
        out_and_home.set(channel, there.iter().chain(there.iter().rev()).copied().collect());
    }
    assert!(detect(&out_and_home, &Config::default()).is_none());
}

/// The rides of the archive say nothing of their place; put where speed and yaw rate lead, half of them go to and
/// fro on a test strip, the others along a road.
#[test]
fn the_rides_of_the_archive_have_no_laps() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive/sessions");
    let files = walkdir::WalkDir::new(folder).into_iter().map(|e| e.expect("readable").into_path());
    let files: Vec<_> = files.filter(|p| p.extension().is_some_and(|e| e == "parquet")).collect();
    assert_eq!(files.len(), 12);
    for path in files {
        let raw = ingest::read(path.clone(), &[]).unwrap_or_else(|e| panic!("{e}"));
        let mut session = ingest::run(raw, &ingest::Config::default()).expect("clean").0;
        assert!(detect(&session, &Config::default()).is_none());
        let of = |c: Channel| session.get(c).expect("logged").to_vec();
        let (speed, turn) = (of(Channel::VelocityX), of(Channel::YawRate));
        let (mut yaw, mut x, mut y) = (0.0_f64, 0.0, 0.0);
        let (mut latitude, mut longitude) = (Vec::new(), Vec::new());
        for (v, w) in speed.iter().zip(&turn) {
            let (v, w) =
                (if v.is_finite() { *v } else { 0.0 }, if w.is_finite() { *w } else { 0.0 });
            yaw += w / session.rate;
            x += v * yaw.cos() / session.rate;
            y += v * yaw.sin() / session.rate;
            let [a, b] = track::position([x, y]);
            latitude.push(a);
            longitude.push(b);
        }
        session.set(Channel::Latitude, latitude);
        session.set(Channel::Longitude, longitude);
        let found = detect(&session, &Config::default());
        assert!(found.is_none(), "{}: {:?}", path.display(), found.map(|f| f.1));
    }
}

#[test]
fn the_page_of_a_track_session_has_laps_and_that_of_the_archive_none() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("rides/bikes")).expect("made");
    fs::copy(root.join("loggers/superbike.csv"), at("rides/superbike.csv")).expect("copied");
    fs::copy(root.join("loggers/bike.toml"), at("rides/bikes/superbike.toml")).expect("copied");
    let map = format!(
        "{SUPERBIKE}{LAP}[channel.roll]\nfrom = 'Lean (deg)'\nunit = 'deg'\n[meta]\nbike_id = 'superbike'\n"
    );
    fs::write(at("map.toml"), map).expect("written");
    let mut run = Command::cargo_bin("roadbench").expect("built");
    run.arg("run").arg(at("rides")).arg("--map").arg(at("map.toml"));
    let said = run.arg("--out").arg(at("out")).assert().success();
    let said = String::from_utf8_lossy(&said.get_output().stdout).into_owned();
    assert!(said.contains("\nLaps: 1 timed lap, best 1:5"), "{said}");
    let out = at("out");
    let laps: Vec<LapRow> = read::rows(&out).expect("a table");
    let corners: Vec<LapCornerRow> = read::rows(&out).expect("a table");
    let points: Vec<LapPointRow> = read::rows(&out).expect("a table");
    let kinds: Vec<&str> = laps.iter().map(|l| l.kind.as_str()).collect();
    assert_eq!(kinds, ["out", "timed", "in"]);
    let best = &laps[1];
    // nine corners, one of them a bend at little lean, whose times add up to the lap's; 3657 m
    assert!((8..=9).contains(&corners.len()), "{}", corners.len());
    let sum: f64 = corners.iter().map(|c| c.time).sum();
    assert!((sum - best.duration).abs() < 1e-6, "{sum}");
    let last = points.last().expect("points");
    assert!(
        (last.time - best.duration).abs() < 1e-6 && (last.station - 3657.0).abs() < 25.0,
        "{last:?}"
    );
    let lean = best.roll_left.expect("lean").max(best.roll_right.expect("lean")).to_degrees();
    assert!((45.0..60.0).contains(&lean), "{lean}");
    let used = best.friction_used_max.expect("used");
    assert!(
        (0.8..1.5).contains(&used) && best.friction_basis.as_deref() == Some("shown"),
        "{used}"
    );

    let html = fs::read_dir(out.join("report"))
        .expect("a report")
        .map(|e| e.expect("entry").path())
        .find(|p| p.file_name().is_some_and(|n| n != "index.html" && n != "fleet.html"))
        .map(|p| fs::read_to_string(p).expect("a page"))
        .expect("the session's page");
    assert!(html.contains("id=\"laps\"") && html.contains("data-lap=\"1\""));
    assert!(html.find("1 timed lap, best") < html.find("coefficients determined"));
    let drawn = &page::data(&html)["laps"];
    assert_eq!(drawn["corners"].as_array().map(Vec::len), Some(corners.len()));
    assert_eq!(drawn["laps"][0]["best"], true);
    let markdown = roadbench::report::summary::markdown(&out).expect("a summary");
    assert!(markdown.contains("\nLaps: 1 timed lap, best"), "{markdown}");

    // two rides of the archive, which do not go round
    let archive = root.join("archive");
    let mut run = Command::cargo_bin("roadbench").expect("built");
    run.arg("run").arg(&archive).arg("--out").arg(at("none")).assert().success();
    assert!(read::rows::<LapRow>(&at("none")).expect("none").is_empty());
    let pages =
        fs::read_dir(at("none/report")).expect("a report").map(|e| e.expect("entry").path());
    for path in pages.filter(|p| p.is_file()) {
        let html = fs::read_to_string(&path).expect("a page");
        assert!(!html.contains("id=\"laps\""), "{}", path.display());
    }
}
