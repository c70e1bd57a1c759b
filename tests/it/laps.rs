//! Laps against truth: the bundled log of a simulated track session, and rides round a curve whose times are known
//! exactly; and none where nothing goes round.

use std::f64::consts::TAU;
use std::fs;
use std::path::Path;

use assert_cmd::Command;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::geodesy::metres_per_degree;
use roadbench::internals::contract::session::{Markers, Meta, Session};
use roadbench::internals::ingest;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::segment::laps::find::{DetectedLaps, Kind};
use roadbench::internals::segment::laps::{Config, detect, look};
use roadbench::internals::simulate::track;
use roadbench::internals::statistics::random::{Coloured, Random};
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{LapCornerRow, LapPointRow, LapRow};

use crate::page;

const SUPERBIKE: &str = "name = 'm'\nformat = 'csv'\n[time]\ncolumn = 'Time (ms)'\nunit = 'ms'\n\
    [channel.velocity_x]\nfrom = 'GPS Speed (km/h)'\nunit = 'km/h'\n\
    [channel.latitude]\nfrom = 'Latitude (deg)'\nunit = 'deg'\n\
    [channel.longitude]\nfrom = 'Longitude (deg)'\nunit = 'deg'\n";
const LAP: &str = "[channel.lap_number]\nfrom = 'Lap'\nunit = '1'\n";

fn session(path: &Path, map: &str) -> Session {
    let map = ChannelMap::parse(map, "m.toml").unwrap_or_else(|e| panic!("{e}"));
    let raw = ingest::read(path, &[map]).unwrap_or_else(|e| panic!("{e}"));
    ingest::run(raw, &ingest::Config::default()).unwrap_or_else(|e| panic!("{e}")).0
}

fn timed(found: &DetectedLaps) -> Vec<[f64; 3]> {
    let timed = found.laps.iter().filter(|l| l.kind == Kind::Timed);
    timed.map(|l| [l.start, l.end, l.error]).collect()
}

/// The lap's time from the two places of the truth that are next to the line.
#[test]
fn the_bundled_log_has_the_lap_time_of_its_truth() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers");
    let ridden = session(&folder.join("superbike.csv"), SUPERBIKE);
    let (ground, found) = detect(&ridden, &Config::default()).expect("laps");
    let laps = timed(&found);
    assert_eq!(laps.len(), 1);
    let text = fs::read_to_string(folder.join("places_truth.toml")).expect("truth");
    let truth: toml::Table = text.parse().expect("TOML");
    let mut places: Vec<(f64, f64)> = truth["place"]
        .as_array()
        .expect("places")
        .iter()
        .map(|row| {
            let [lat, lon, first, second] =
                [0, 1, 2, 3].map(|k| row[k].as_float().expect("a number"));
            let [x, y] = ground.point([lat, lon]);
            let [east, north] = [x - found.line.middle[0], y - found.line.middle[1]];
            (east.hypot(north), second - first)
        })
        .collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(near, a), (far, b)] = [places[0], places[1]];
    assert!(near < 20.0 && far < 45.0, "{near} {far}");
    let expected = (a * far + b * near) / (near + far);
    let error = laps[0][1] - laps[0][0] - expected;
    println!("bundled: {error:+.3} s of {expected:.3}, standard error {:.3}", laps[0][2]);
    assert!(error.abs() < 0.08 && (0.02..0.1).contains(&laps[0][2]), "{error} {laps:?}");
    // the counter of the log rises only once: the line is found
    let counted = session(&folder.join("superbike.csv"), &format!("{SUPERBIKE}{LAP}"));
    assert_eq!(detect(&counted, &Config::default()).expect("laps").1.line.source.name(), "found");
}

/// A receiver.
#[derive(Clone, Copy)]
struct Receiver {
    /// Hz.
    rate: f64,
    /// How late, s.
    late: f64,
    /// Slow error of the place, m.
    slow: f64,
    /// White error of the place, m.
    white: f64,
    /// Of the first of these seconds of every 61 the place is missing.
    gap: f64,
}

const GOOD: Receiver = Receiver { rate: 10.0, late: 0.2, slow: 1.2, white: 0.01, gap: 0.0 };
/// Between two points of the truth, s.
const FINE: f64 = 0.002;

/// A ride round a closed curve of 2.7 km, each lap a little slower than the one before.
struct Round {
    /// Angle round the curve, 1 for a lap, by [`FINE`].
    along: Vec<f64>,
    speed: Vec<f64>,
}

fn place(along: f64) -> [f64; 2] {
    let (sin, cos) = (TAU * along).sin_cos();
    let radius = 400.0 + 120.0 * (2.0 * TAU * along).cos() + 40.0 * (3.0 * TAU * along).sin();
    [radius * cos, radius * sin]
}

impl Round {
    fn new(laps: f64) -> Self {
        let (mut along, mut speed) = (vec![0.3], Vec::new());
        loop {
            let now = along[along.len() - 1];
            let wave = (2.0 * TAU * now + 0.4).cos();
            let v = (36.0 + 17.0 * wave) * (1.0 - 0.01 * now.floor());
            speed.push(v);
            if now > 0.3 + laps {
                return Round { along, speed };
            }
            let ([a, b], [c, d]) = (place(now - 1e-6), place(now + 1e-6));
            along.push(now + v * FINE * 2e-6 / (c - a).hypot(d - b));
        }
    }

    /// Times at which the line's place was passed, s.
    fn passages(&self, middle: [f64; 2]) -> Vec<f64> {
        let far = |s: f64| (place(s)[0] - middle[0]).hypot(place(s)[1] - middle[1]);
        let around = (0..200_000).map(|k| f64::from(k) / 200_000.0);
        let at = around.min_by(|a, b| far(*a).total_cmp(&far(*b))).expect("a place");
        let pairs = self.along.windows(2).enumerate();
        pairs
            .filter(|(_, p)| (p[1] - at).floor() > (p[0] - at).floor())
            .map(|(i, p)| {
                let share = ((p[1] - at).floor() + at - p[0]) / (p[1] - p[0]);
                (i as f64 + share) * FINE
            })
            .collect()
    }

    /// As a logger has it; with a counter that goes up at angle 0, which is not late.
    fn logged(&self, receiver: Receiver, seed: u64) -> Session {
        let Receiver { rate, late, slow, white, gap } = receiver;
        let mut random = Random::new(seed, "receiver");
        let mut wander = [0; 2].map(|_| Coloured::new(slow, 60.0, 1.0 / rate, &mut random));
        let count = (self.along.len() as f64 * FINE * rate) as usize;
        let mut columns = [const { Vec::new() }; 4];
        for i in 0..count {
            let time = i as f64 / rate;
            let at = ((time - late).max(0.0) / FINE) as usize;
            let mut p = place(self.along[at]);
            for k in 0..2 {
                p[k] += wander[k].next(&mut random) + white * random.normal();
            }
            let [latitude, longitude] = match time % 61.0 < gap {
                true => [f64::NAN; 2],
                false => track::position(p),
            };
            let counter = self.along[(time / FINE) as usize].floor();
            let speed = self.speed[at] + 0.05 * random.normal();
            for (column, x) in columns.iter_mut().zip([latitude, longitude, speed, counter]) {
                column.push(x);
            }
        }
        let mut session = Session::new(Meta::default(), rate, count);
        let channels =
            [Channel::Latitude, Channel::Longitude, Channel::VelocityX, Channel::LapNumber];
        for (channel, column) in channels.into_iter().zip(columns) {
            session.set(channel, column);
        }
        session
    }
}

/// Errors of the timed laps with their standard errors, s.
fn errors(round: &Round, session: &Session, config: &Config, late: f64) -> Vec<[f64; 2]> {
    let (ground, found) = detect(session, config).expect("laps");
    let [latitude, longitude] = ground.place(found.line.middle);
    // back from where `track::position` puts a point
    let [north, east] = metres_per_degree(track::ORIGIN[0]);
    let middle = [(longitude - track::ORIGIN[1]) * east, (latitude - track::ORIGIN[0]) * north];
    let truth = round.passages(middle);
    let near = |t: f64| {
        truth.iter().copied().min_by(|a, b| (a - t).abs().total_cmp(&(b - t).abs())).expect("truth")
    };
    timed(&found)
        .into_iter()
        .map(|[start, end, sd]| [end - start - (near(end - late) - near(start - late)), sd])
        .collect()
}

#[test]
fn lap_times_are_those_of_the_truth_from_1_to_25_hz() {
    let round = Round::new(6.4);
    let mut scaled = Vec::new();
    for (name, receiver, bar) in [
        ("10 Hz", GOOD, 0.07),
        ("25 Hz", Receiver { rate: 25.0, late: 0.1, ..GOOD }, 0.07),
        ("1 Hz", Receiver { rate: 1.0, ..GOOD }, 0.1),
        ("25 Hz, 2.5 m white", Receiver { rate: 25.0, white: 2.5, ..GOOD }, 0.08),
        ("10 Hz, 2.5 m white, holes of 3 s", Receiver { white: 2.5, gap: 3.0, ..GOOD }, 0.1),
    ] {
        let mut squares = Vec::new();
        for seed in 0..6 {
            let mut session = round.logged(receiver, seed);
            session.remove(Channel::LapNumber);
            let errors = errors(&round, &session, &Config::default(), receiver.late);
            assert!(errors.len() >= 5, "{name}: {errors:?}");
            squares.extend(errors.iter().map(|[e, _]| e * e));
            scaled.extend(errors.iter().map(|[e, sd]| e / sd));
        }
        let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
        println!("{name}: rms {rms:.3} s of {} laps", squares.len());
        assert!(rms < bar, "{name}: {rms}");
    }
    let inside = scaled.iter().filter(|z| z.abs() < 1.96).count();
    println!("{inside} of {} within the 95 % interval", scaled.len());
    assert!(inside * 10 >= scaled.len() * 9, "{inside} of {}", scaled.len());
}

#[test]
fn a_counter_or_a_given_line_puts_the_line_where_it_is() {
    let round = Round::new(4.5);
    let session = round.logged(GOOD, 3);
    let (ground, found) = detect(&session, &Config::default()).expect("laps");
    assert_eq!((found.line.source.name(), timed(&found).len()), ("logger", 3));
    // the counter is not late, the place is
    let [x, y] = ground.point(track::position(place(0.0)));
    let off = (found.line.middle[0] - x).hypot(found.line.middle[1] - y);
    assert!(off < 0.2 * 55.0 + 6.0, "{off}");

    // across the road, 20 m to each side, from either end
    let [a, b] = [-20.0, 20.0].map(|d| track::position([place(0.0)[0] + d, place(0.0)[1]]));
    for line in [[a, b], [b, a]] {
        let config = Config { line: Some(line), ..Config::default() };
        let errors = errors(&round, &session, &config, GOOD.late);
        assert_eq!(errors.len(), 3);
        assert!(errors.iter().all(|[e, _]| e.abs() < 0.12), "{errors:?}");
    }
}

/// The place that the logger's markers are of.
const MARKED: f64 = 0.0;

/// When the curve's marked place was passed, to the millisecond, as a beacon beside the track tells it.
fn marked(round: &Round) -> Vec<f64> {
    let at = place(MARKED);
    round.passages(at).iter().map(|t| (t * 1e3).round() * 1e-3).collect()
}

fn codes(session: &Session) -> Vec<String> {
    let (_, warnings) = look(session, &Config::default());
    warnings.into_iter().map(|w| format!("{}: {}", w.code, w.message)).collect()
}

#[test]
fn the_loggers_markers_come_first_and_are_held_against_position() {
    let round = Round::new(8.4);
    let (mut squares, mut scaled) = (Vec::new(), Vec::new());
    for seed in 0..6 {
        let mut session = round.logged(GOOD, seed);
        session.markers.times = marked(&round);
        let (_, found) = detect(&session, &Config::default()).expect("laps");
        assert!(found.by_markers && found.line.source.name() == "markers");
        let truth = round.passages(place(MARKED));
        let laps: Vec<_> = found.laps.iter().filter(|l| l.kind == Kind::Timed).collect();
        assert_eq!(laps.len(), truth.len() - 1);
        for (lap, t) in laps.iter().zip(truth.windows(2)) {
            assert!((lap.duration() - (t[1] - t[0])).abs() < 2e-3, "{lap:?} {t:?}");
            let difference = lap.position_difference.expect("a position");
            squares.push(difference * difference);
            scaled.push(difference / lap.error);
        }
        assert!(codes(&session).is_empty(), "{:?}", codes(&session));
    }
    let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
    let inside = scaled.iter().filter(|z| z.abs() < 1.96).count();
    println!("markers against position: rms {rms:.3} s of {} laps, {inside} within", squares.len());
    assert!(rms < 0.07 && inside * 10 >= scaled.len() * 9, "{rms} {inside}");
}

#[test]
fn markers_that_cannot_be_right_are_said_and_left_out() {
    let round = Round::new(6.4);
    let mut session = round.logged(GOOD, 2);
    let right = marked(&round);
    session.markers.times = right.clone();
    let starts = |session: &Session| -> Vec<f64> {
        let found = detect(session, &Config::default()).expect("laps").1;
        timed(&found).iter().map(|l| l[0]).collect()
    };
    let all = starts(&session);
    assert_eq!(all.len(), 5);
    let half = 0.5 * (right[1] + right[2]);
    for (what, added) in [
        ("not within the ride", vec![-30.0, 1e5, f64::NAN]),
        ("repeat the one before", vec![right[2] + 0.3]),
        ("where most others are not", vec![half]),
        ("stand before an earlier one", vec![right[0]]),
    ] {
        let mut marked = right.clone();
        if what.starts_with("stand") {
            marked.remove(0);
        }
        marked.extend(&added);
        session.markers.times = marked;
        let said = codes(&session);
        assert!(said.iter().any(|s| s.contains(what)), "{what}: {said:?}");
        assert_eq!(starts(&session), all, "{what}");
    }
    // without positions only the distance tells
    let mut blind = session.clone();
    for channel in [Channel::Latitude, Channel::Longitude] {
        blind.remove(channel);
    }
    blind.markers.times = right.clone();
    blind.markers.times.push(right[2] + 3.0);
    let said = codes(&blind);
    assert!(said.iter().any(|s| s.contains("sooner after the one before")), "{said:?}");
    assert_eq!(starts(&blind), all);
    // a split in every lap: the line is where the first of two places is
    let mut splits: Vec<f64> = right.windows(2).map(|t| 0.6 * t[0] + 0.4 * t[1]).collect();
    splits.extend(&right);
    splits.sort_by(f64::total_cmp);
    session.markers.times = splits;
    assert_eq!(starts(&session), all);
    // nowhere twice, and of no use: position has the laps
    session.markers.times = vec![right[1] + 5.0, half, right[4] - 4.0];
    let (found, warnings) = look(&session, &Config::default());
    let found = found.expect("laps").1;
    assert!(!found.by_markers && timed(&found).len() >= 4 && warnings.len() == 1, "{warnings:?}");
    // who gives a line means it
    let ([x, y], [ahead_x, ahead_y]) = (place(0.6), place(0.601));
    let [dx, dy] = [ahead_x - x, ahead_y - y].map(|d| d / (ahead_x - x).hypot(ahead_y - y));
    let line = [-20.0, 20.0].map(|d| track::position([x - d * dy, y + d * dx]));
    session.markers.times = right;
    let config = Config { line: Some(line), ..Config::default() };
    let found = detect(&session, &config).expect("laps").1;
    assert!(!found.by_markers && found.line.source.name() == "given");
}

/// A logger without a receiver of satellites, but with a beacon; and a log that brings the line alone.
#[test]
fn markers_without_positions_give_laps_and_so_does_the_logs_own_line() {
    let round = Round::new(6.4);
    let mut session = round.logged(GOOD, 4);
    session.remove(Channel::LapNumber);
    let line = [-20.0, 20.0].map(|d| track::position([place(0.0)[0] + d, place(0.0)[1]]));
    session.markers.line = Some(line);
    let found = detect(&session, &Config::default()).expect("laps").1;
    assert_eq!((found.line.source.name(), found.by_markers), ("log", false));
    assert_eq!(timed(&found).len(), 5);
    session.markers = Markers { times: marked(&round), line: None };
    for channel in [Channel::Latitude, Channel::Longitude] {
        session.remove(channel);
    }
    // as it comes back from its file
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("round.parquet");
    session.meta.session_id = "round".into();
    session.meta.bike_id = "b".into();
    ingest::write_session(&path, &session, false).expect("written");
    let raw = ingest::read(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
    let back = ingest::run(raw, &ingest::Config::default()).unwrap_or_else(|e| panic!("{e}")).0;
    assert_eq!(back.markers, session.markers);
    let found = detect(&back, &Config::default()).expect("laps").1;
    let laps: Vec<_> = found.laps.iter().filter(|l| l.kind == Kind::Timed).collect();
    assert_eq!(laps.len(), 5);
    assert!(laps.iter().all(|l| l.position_difference.is_none()));
}

/// Once round the block and home is no track; nor is the way there and back.
#[test]
fn a_ride_that_goes_round_once_has_no_laps() {
    let once = Round::new(1.2).logged(GOOD, 1);
    assert!(detect(&once, &Config::default()).is_none());
    let half = once.len / 2;
    let mut back = Session::new(Meta::default(), once.rate, 6 * half);
    for channel in [Channel::VelocityX, Channel::Latitude, Channel::Longitude] {
        let there = &once.get(channel).expect("set")[..half];
        let way = there.iter().chain(there.iter().rev()).copied().collect::<Vec<f64>>();
        back.set(channel, way.repeat(3));
    }
    assert!(detect(&back, &Config::default()).is_none());
}

/// Manoeuvres on a strip, each from its beginning, in one log with gaps of some seconds: straight on, or into a bend.
/// The way from part to part is none that a motorcycle rides.
fn parts_of_a_strip(gap: f64) -> Session {
    const HZ: f64 = 10.0;
    const SPEED: f64 = 20.0;
    let mut columns = [const { Vec::new() }; 3];
    for part in 0..8 {
        let ([mut x, mut y], mut heading) = ([-150.0, 0.0], 0.0_f64);
        for i in 0..(20.0 * HZ) as usize {
            let [latitude, longitude] = track::position([x, y]);
            for (column, value) in columns.iter_mut().zip([latitude, longitude, SPEED]) {
                column.push(value);
            }
            if part % 2 == 1 && i as f64 * SPEED / HZ > 200.0 {
                heading += SPEED / HZ / 60.0;
            }
            (x, y) = (x + SPEED / HZ * heading.cos(), y + SPEED / HZ * heading.sin());
        }
        for column in &mut columns {
            column.resize(column.len() + (gap * HZ) as usize, f64::NAN);
        }
    }
    let mut session = Session::new(Meta::default(), HZ, columns[0].len());
    let channels = [Channel::Latitude, Channel::Longitude, Channel::VelocityX];
    for (channel, column) in channels.into_iter().zip(columns) {
        session.set(channel, column);
    }
    session
}

#[test]
fn parts_that_begin_at_one_place_are_no_laps() {
    for gap in [4.5, 6.0] {
        let session = parts_of_a_strip(gap);
        let found = detect(&session, &Config::default());
        assert!(found.is_none(), "{gap} s: {:?}", found.map(|f| f.1.laps));
    }
    // a lap that is ridden through such a gap stays one
    let round = Round::new(6.4);
    for gap in [3.0, 6.0] {
        let mut session = round.logged(Receiver { gap, ..GOOD }, 5);
        session.remove(Channel::LapNumber);
        let (ground, found) = detect(&session, &Config::default()).expect("laps");
        assert!(ground.jumps.is_empty(), "{gap} s: {:?}", ground.jumps);
        assert!(timed(&found).len() >= 4, "{gap} s: {:?}", found.laps);
    }
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
        .find(|p| {
            p.file_name()
                .is_some_and(|n| ["index.html", "fleet.html", "tyres.html"].iter().all(|o| n != *o))
        })
        .map(|p| fs::read_to_string(p).expect("a page"))
        .expect("the session's page");
    assert!(html.contains("id=\"laps\"") && html.contains("data-lap=\"1\""));
    assert!(html.find("1 timed lap, best") < html.find("coefficients determined"));
    let drawn = &page::data(&html)["laps"];
    assert_eq!(drawn["corners"].as_array().map(Vec::len), Some(corners.len()));
    assert_eq!(drawn["laps"][0]["best"], true);
    let markdown = roadbench::internals::report::summary::markdown(&out).expect("a summary");
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
