//! Any inertial unit: the level frame from a bare inertial unit and a satellite receiver, against rides whose truth is known.

use std::path::Path;

use nalgebra::Rotation3;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::maps::file::with_aids;
use roadbench::internals::ingest::motion::navigation;
use roadbench::internals::ingest::motion::navigation::{Log, NAMES, Navigation, OUTPUTS};
use roadbench::internals::ingest::{self, Config};
use roadbench::internals::simulate::imu::Motion;
use roadbench::internals::simulate::loggers;
use roadbench::internals::simulate::prescribed::Prescribed;
use roadbench::internals::simulate::strapdown::{Receiver, Unit, crabbing, record, truth};
use roadbench::internals::simulate::track::{self, Track};
use roadbench::internals::statistics::random::Random;

use super::channels_by_physics::truth::judged;

const RATE: f64 = 100.0;
const VELOCITY_Y: usize = 1;
const ROLL: usize = 4;
const YAW_RATE: usize = 9;
const YAW: usize = 6;

fn degrees(x: f64) -> f64 {
    x.to_degrees()
}

fn run(log: &Log) -> Navigation {
    navigation::run(log).unwrap_or_else(|e| panic!("{e}"))
}

/// Errors of an output beyond its first and last two seconds; a whole turn of heading is none.
fn errors(found: &Navigation, motions: &[Motion], output: usize) -> Vec<f64> {
    let (values, true_ones) = (&found.level.values[output], &truth(motions)[output]);
    let whole = std::f64::consts::TAU;
    (200..motions.len() - 200)
        .map(|i| values[i] - true_ones[i])
        .map(|e| if output == YAW { e - (e / whole).round() * whole } else { e })
        .collect()
}

fn rms(x: &[f64]) -> f64 {
    let there: Vec<f64> = x.iter().copied().filter(|x| x.is_finite()).collect();
    (there.iter().map(|x| x * x).sum::<f64>() / there.len() as f64).sqrt()
}

/// Perfect sensors, whose receiver is 0.13 s late, mounted as they come: upside down, backwards, on their side, askew.
#[test]
fn without_noise_every_mounting_gives_the_truth() {
    let motions = Prescribed::road(6).motions(RATE);
    let quarter = std::f64::consts::FRAC_PI_2;
    let mountings = [
        [0.0, 0.0, 0.0],
        [2.0 * quarter, 0.0, 0.0],
        [0.0, 0.0, 2.0 * quarter],
        [quarter, 0.0, 0.3],
        [0.0, -quarter, 0.0],
        [2.4, 0.7, -1.9],
    ];
    for angles in mountings {
        let mounting = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let receiver = Receiver { delay: 0.13, ..Receiver::perfect(10.0) };
        let log =
            record(&motions, RATE, &Unit::perfect(mounting), &receiver, &mut Random::new(1, "n"));
        let found = run(&log);
        let off = |o: usize| rms(&errors(&found, &motions, o));
        assert!(degrees(off(ROLL)) < 0.03, "{angles:?}: roll {}", degrees(off(ROLL)));
        assert!(degrees(off(YAW)) < 0.03, "{angles:?}: heading {}", degrees(off(YAW)));
        assert!(off(VELOCITY_Y) < 0.01, "{angles:?}: {}", off(VELOCITY_Y));
        assert!(off(0) < 0.01 && off(2) < 0.01 && off(3) < 0.01, "{angles:?}");
        assert!((found.delay[0] - 0.13).abs() < 1e-3, "{angles:?}: {:?}", found.delay);
        // pitch is separated from roll by usual straight running, half a degree
        assert!(degrees(mounting.rotation_to(&found.mounting).angle()) < 0.3, "{angles:?}");
    }
}

#[test]
fn in_a_left_corner_every_sign_is_the_contracts() {
    let mut path = Prescribed::road(0);
    path.turns.push([24.0, 6.0, 3.0]);
    path.speeds.push([36.0, 1.0, -6.0]);
    path.length = 45.0;
    let motions = path.motions(RATE);
    let unit = Unit::perfect(Rotation3::from_euler_angles(3.0, 0.2, 1.0));
    let log = record(&motions, RATE, &unit, &Receiver::perfect(10.0), &mut Random::new(1, "n"));
    let level = run(&log).level;
    let at = |name: &str, i: usize| {
        level.values[NAMES.iter().position(|n| *n == name).expect("an output")][i]
    };
    let middle = 2400;
    assert!(at("roll", middle) < -0.3 && at("yaw_rate", middle) > 0.3);
    assert!(at("acceleration_y", middle) > 3.0 && at("velocity_y", middle) < -0.1);
    assert!(at("yaw", 3000) - at("yaw", 1800) > 2.0);
    assert!(at("roll_rate", 2250) < -0.01 && at("roll_rate", 2550) > 0.01);
    // braking at 36 s: speed falls, the nose dives
    assert!(at("acceleration_x", 3600) < -3.0 && at("pitch", 3600) > 0.0);
}

#[test]
fn the_delay_is_found_whatever_the_receiver() {
    let motions = Prescribed::road(6).motions(RATE);
    for (hertz, bar) in [(1.0, 7e-3), (5.0, 4e-3), (10.0, 3e-3), (25.0, 3e-3)] {
        for delay in [-0.2, 0.2] {
            let unit = Unit::usual(Rotation3::from_euler_angles(0.4, -1.0, 2.0));
            let receiver = Receiver { delay, ..Receiver::usual(hertz) };
            let log = record(&motions, RATE, &unit, &receiver, &mut Random::new(7, "delay"));
            let found = run(&log).delay[0];
            assert!((found - delay).abs() < bar, "{hertz} Hz, {delay} s: {found}");
        }
    }
}

/// A guess that is 0.2 s off: the alignment is made with it, the passes find the truth.
#[test]
fn a_wrong_guess_of_the_delay_does_no_harm() {
    let motions = Prescribed::road(6).motions(RATE);
    let unit = Unit::usual(Rotation3::identity());
    for guess in [-0.08, 0.32] {
        let mut log =
            record(&motions, RATE, &unit, &Receiver::usual(10.0), &mut Random::new(8, "delay"));
        log.delay = Some(guess);
        let found = run(&log).delay[0];
        assert!((found - 0.12).abs() < 3e-3, "from {guess}: {found}");
    }
}

/// Shares of errors within one and two standard deviations, over rides with drawn sensors.
#[test]
fn standard_deviations_are_those_of_the_errors() {
    let draws = 8;
    let mut within = [[0.0_f64; 3]; OUTPUTS];
    let mut outwards = Vec::new();
    for draw in 0..draws {
        let mut random = Random::new(draw, "coverage");
        let unit = Unit::usual(Rotation3::from_euler_angles(
            random.between(-3.0, 3.0),
            random.between(-1.5, 1.5),
            random.between(-3.0, 3.0),
        ));
        let motions = crabbing(&Prescribed::road(8).motions(RATE), unit.crab, &mut random);
        let found = run(&record(&motions, RATE, &unit, &Receiver::usual(10.0), &mut random));
        for (o, sums) in within.iter_mut().enumerate() {
            for (e, sd) in errors(&found, &motions, o).iter().zip(&found.level.sd[o][200..]) {
                let ratio = e.abs() / sd;
                sums[0] += 1.0;
                sums[1] += f64::from(ratio < 1.0);
                sums[2] += f64::from(ratio < 2.0);
            }
        }
        // turn sign times the error of v_y
        let turning: Vec<f64> = errors(&found, &motions, VELOCITY_Y)
            .iter()
            .zip(&truth(&motions)[9][200..])
            .filter(|(_, turn)| turn.abs() > 0.2)
            .map(|(e, turn)| e * turn.signum())
            .collect();
        outwards.push(turning.iter().sum::<f64>() / turning.len() as f64);
    }
    for (name, [n, one, two]) in NAMES.iter().zip(within) {
        let (one, two) = (100.0 * one / n, 100.0 * two / n);
        println!("{name}: {one:.1} {two:.1}");
        assert!((60.0..85.0).contains(&one), "{name}: {one:.1} % within one");
        assert!(two > 93.0, "{name}: {two:.1} % within two");
    }
    let mean = outwards.iter().sum::<f64>() / draws as f64;
    let spread = outwards.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (draws - 1) as f64;
    // true side slip here is 0.1 to 0.2 m/s: a filter that assumed none would be off by as much
    let error = (spread / draws as f64).sqrt();
    assert!(mean.abs() < 2.5 * error && error < 0.02, "{mean} +- {error}");
}

#[test]
fn outages_and_gaps_widen_and_do_no_more() {
    let motions = Prescribed::road(8).motions(RATE);
    let unit = Unit::usual(Rotation3::from_euler_angles(0.1, 3.0, 0.5));
    let receiver = Receiver { outliers: 0.02, ..Receiver::usual(10.0) };
    let mut log = record(&motions, RATE, &unit, &receiver, &mut Random::new(4, "gaps"));
    log.epochs.retain(|e| !(50.0..60.0).contains(&e.time));
    let blind = 7800..8300;
    for i in blind.clone() {
        log.rates.iter_mut().chain(&mut log.forces).for_each(|x| x[i] = f64::NAN);
    }
    let found = run(&log);
    for o in [0, 1, ROLL, YAW] {
        let e = errors(&found, &motions, o);
        let far =
            e.iter().zip(&found.level.sd[o][200..]).filter(|(e, sd)| e.abs() > 4.0 * **sd).count();
        assert!(far < e.len() / 50, "{}: {far} of {}", NAMES[o], e.len());
        assert!(
            blind
                .clone()
                .all(|i| found.level.values[o][i].is_nan() && found.level.sd[o][i].is_nan())
        );
        assert!(found.level.values[o][blind.end + 1].is_finite());
    }
    let sd = &found.level.sd[0];
    assert!(sd[5500] > 1.5 * sd[4500], "{} {}", sd[5500], sd[4500]);
    assert!(found.shares.iter().any(|s| s.source == "satellite velocity" && s.count[1] > 5));
}

#[test]
fn a_straight_road_says_little_of_side_slip() {
    let mut path = Prescribed::road(0);
    path.speeds.extend([[25.0, 2.0, 8.0], [35.0, 2.0, -8.0]]);
    path.length = 60.0;
    let motions = path.motions(RATE);
    let unit = Unit::usual(Rotation3::identity());
    let found = run(&record(
        &motions,
        RATE,
        &unit,
        &Receiver::usual(10.0),
        &mut Random::new(2, "straight"),
    ));
    let (v, sd) = (&found.level.values[0], &found.level.sd[VELOCITY_Y]);
    assert!(
        (1000..5000).all(|i| sd[i] > 0.99 * 0.2_f64.to_radians() * v[i]),
        "{:?}",
        &sd[3000..3003]
    );
}

#[test]
fn a_mirrored_ride_is_mirrored() {
    let path = Prescribed::road(5);
    let mut other = path.clone();
    other.turns.iter_mut().for_each(|t| t[2] = -t[2]);
    let [a, b] = [path, other].map(|p| {
        let motions = p.motions(RATE);
        let unit = Unit::perfect(Rotation3::identity());
        run(&record(&motions, RATE, &unit, &Receiver::perfect(10.0), &mut Random::new(1, "n")))
            .level
    });
    let signs = [1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0, -1.0, 1.0, -1.0];
    for (o, sign) in signs.into_iter().enumerate() {
        for i in (0..a.values[o].len()).step_by(50) {
            let off = a.values[o][i] - sign * b.values[o][i];
            assert!(off.abs() < 1e-6, "{} at {i}: {off}", NAMES[o]);
            assert!((a.sd[o][i] - b.sd[o][i]).abs() < 1e-6, "{} sd at {i}", NAMES[o]);
        }
    }
}

#[test]
fn forces_and_courses_of_the_other_sign_are_turned_round() {
    let motions = Prescribed::road(5).motions(RATE);
    let unit = Unit::usual(Rotation3::from_euler_angles(0.3, 0.2, 2.0));
    let mut log =
        record(&motions, RATE, &unit, &Receiver::usual(10.0), &mut Random::new(5, "signs"));
    log.forces.iter_mut().flatten().for_each(|f| *f = -*f);
    log.epochs.iter_mut().for_each(|e| e.course = -e.course);
    let found = run(&log);
    assert!(found.alignment.reversed && found.alignment.mirrored);
    assert!(degrees(rms(&errors(&found, &motions, ROLL))) < 0.5);
}

#[test]
fn what_a_ride_lacks_is_said() {
    let motions = Prescribed::road(5).motions(RATE);
    let unit = Unit::usual(Rotation3::identity());
    let log = record(&motions, RATE, &unit, &Receiver::usual(10.0), &mut Random::new(5, "lacks"));
    let refused = |log: &Log| navigation::run(log).expect_err("refused").to_string();
    assert!(refused(&Log { epochs: Vec::new(), ..log.clone() }).contains("satellite speed"));
    let mut slow = log.clone();
    slow.epochs.iter_mut().for_each(|e| e.speed = 2.0);
    assert!(refused(&slow).contains("straight running"), "{}", refused(&slow));
    let mut other = log.clone();
    other.forces.iter_mut().flatten().for_each(|f| *f *= 2.0);
    assert!(refused(&other).contains("m/s2"), "{}", refused(&other));
}

/// A box's CSV through its map: 25 Hz, speed without course, nothing known of the mounting; the map that `roadbench map` drafts gives
/// speeds, lean and turn as well as the one written for it; without a lever arm its accelerations are the unit's own.
#[test]
fn a_strapped_on_box_becomes_a_session_of_the_level_frame() {
    let track = Track::load("track").expect("built in").expect("a track");
    let ridden = track::ride(&Track { laps: 1, ..track }, 0).expect("comes round");
    let foreign = loggers::write(loggers::Profile::Phone, &ridden, 5);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(&foreign.file);
    std::fs::write(&path, &foreign.text).expect("written");
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers/phone.toml");
    let written = ChannelMap::read(&map).unwrap_or_else(|e| panic!("{e}"));
    let draft = judged(&path).draft;
    let drafted = ChannelMap::parse(&draft, "draft").unwrap_or_else(|e| panic!("{e}\n{draft}"));
    let motions: Vec<Motion> = ridden.ride.samples.iter().map(|s| s.motion).collect();
    // a raw unit at 25 Hz: its aliased vibration is in the accelerations, and their sd says so
    let common = [(0, 0.3), (1, 0.4), (ROLL, 0.03), (YAW_RATE, 0.05)];
    let accelerations = [(2, 0.6), (3, 1.3)];
    let unit_alone = accelerations.map(|(o, _)| (o, f64::INFINITY));
    for (map, accelerations) in [(written, accelerations), (drafted, unit_alone)] {
        let bars = [&common[..], &accelerations].concat();
        brought_level(&path, map, &bars, (ridden.ride.session.rate, &truth(&motions)));
    }
}

/// Reads a box's log by a map and holds the level frame against the truth.
fn brought_level(
    path: &Path,
    map: ChannelMap,
    bars: &[(usize, f64)],
    (rate, true_ones): (f64, &[Vec<f64>]),
) {
    let raw = ingest::read(path, &[map]).unwrap_or_else(|e| panic!("{e}"));
    let (session, warnings) =
        ingest::run(raw, &Config::default()).unwrap_or_else(|e| panic!("{e}"));
    let told = warnings.iter().find(|w| w.code == "level_frame").expect("told");
    println!("{}", told.message);
    let step = (rate / session.rate).round() as usize;
    for &(o, bar) in bars {
        let channel = Channel::from_name(NAMES[o]).expect("a channel");
        let sd = Channel::from_name(&format!("{}_sd", NAMES[o])).expect("a channel");
        let (x, sd) = (session.get(channel).expect("there"), session.get(sd).expect("there"));
        let e: Vec<f64> = (50..session.len - 50).map(|i| x[i] - true_ones[o][i * step]).collect();
        println!("{}: {:.4}, sd {:.4}", NAMES[o], rms(&e), rms(sd));
        assert!(rms(&e) < bar, "{}: {}", NAMES[o], rms(&e));
        // it says itself how far it is off
        assert!(rms(&e) < 1.5 * rms(sd), "{}: {}, sd {}", NAMES[o], rms(&e), rms(sd));
    }
    assert!(!session.has(Channel::ImuRateX) && !session.has(Channel::SatelliteSpeed));
}

/// A real unit in a car, whose x axis points up: level accelerations against the change of speed.
#[test]
fn a_real_unit_on_its_side_is_brought_level() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/canedge_gnss_imu");
    let log = data.join("3BA199E2_00000165_00000005-60FEBFEB.MF4");
    if !log.exists() {
        println!("no recording {}: nothing tested", log.display());
        return;
    }
    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats/canmod_gps.toml");
    let map = ChannelMap::read(&map).unwrap_or_else(|e| panic!("{e}"));
    let aids = Aids::read(&[data.join("canmod-gps.dbc")]).expect("a database");
    let maps = with_aids(vec![map], &aids);
    let raw = ingest::read(&log, &maps).unwrap_or_else(|e| panic!("{e}"));
    let speed =
        raw.tracks.iter().find(|t| t.channel == Channel::SatelliteSpeed).expect("read").clone();
    let (session, warnings) =
        ingest::run(raw, &Config::default()).unwrap_or_else(|e| panic!("{e}"));
    warnings
        .iter()
        .filter(|w| w.code.contains("level"))
        .for_each(|w| println!("{}: {}", w.code, w.message));
    assert!(warnings.iter().any(|w| w.code == "level_frame"), "{warnings:?}");
    let (v, a) = (
        session.get(Channel::VelocityX).expect("v"),
        session.get(Channel::AccelerationX).expect("a"),
    );
    // differences of the receiver's speed over 2 s against means of the level acceleration over the same
    let start = speed.time[0];
    let mean = |x: &[f64], from: f64, to: f64| {
        let part = &x[(from * session.rate) as usize..(to * session.rate) as usize];
        part.iter().sum::<f64>() / part.len() as f64
    };
    let (mut n, mut squares, mut all) = (0.0, 0.0, 0.0);
    for i in 5..speed.time.len() - 7 {
        let (from, to) = (speed.time[i] - start, speed.time[i + 2] - start);
        let change = (speed.values[i + 2] - speed.values[i]) / (to - from);
        let found = mean(a, from, to);
        if found.is_finite() && speed.values[i] > 5.0 {
            (n, squares, all) =
                (n + 1.0, squares + (found - change).powi(2), all + change * change);
        }
    }
    let (off, size) = (f64::sqrt(squares / n), f64::sqrt(all / n));
    println!(
        "acceleration_x: {off:.3} m/s2 of {size:.3} over {n} windows; speed {:.1}",
        mean(v, 100.0, 101.0)
    );
    // 0.29 was seen: the receiver is 0.23 s late, which these windows do not know
    assert!(n > 200.0 && off < 0.35 * size, "{off} of {size}");
    let up = session.get(Channel::Roll).expect("roll");
    assert!(rms(up).to_degrees() < 6.0, "a car hardly leans: {}", rms(up).to_degrees());
}
