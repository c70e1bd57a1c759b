//! Logs whose channels contradict each other: said by every command, and nothing that depends on them is `ok`; and
//! drafts that neither throw a measured lean out nor invent a delay.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Config};

use crate::channels_by_physics::truth::judged;

const GRAVITY: f64 = 9.806_65;

/// What a logger makes of the ride.
struct Logger {
    /// What its speeds and the wheels' are multiplied by.
    speed: f64,
    /// Sign of the lean.
    side: f64,
    /// How late the receiver is, s.
    late: f64,
    /// A second lean, rounded and held at zero when it is small, in front of the other.
    rounded: bool,
    position: bool,
}

const RIGHT: Logger = Logger { speed: 1.0, side: 1.0, late: 0.0, rounded: false, position: true };

/// Four minutes at 10 Hz: drive, brakes and bends at once, as on a track. The wheels run faster in bends, the lean is
/// 1.05 times the ideal one, both with a little noise.
fn log(of: &Logger) -> String {
    let speed = |t: f64| 26.0 + 8.0 * (0.21 * t).sin() + 3.0 * (0.53 * t + 0.4).sin();
    let pull = |t: f64| 8.0 * 0.21 * (0.21 * t).cos() + 3.0 * 0.53 * (0.53 * t + 0.4).cos();
    let turn = |t: f64| 0.25 * (0.33 * t + 1.0).sin() + 0.1 * (0.71 * t).sin();
    let noise = |k: usize| ((k * 7919 + 13) % 1000) as f64 / 1000.0 - 0.5;
    let mut text = String::from("Time (s),GPS Speed (km/h),");
    if of.position {
        text += "Latitude (deg),Longitude (deg),";
    }
    if of.rounded {
        text += "Lean Angle (deg),";
    }
    text += "Lean (deg),Wheel Speed F (km/h),Wheel Speed R (km/h),Brake F (bar),Brake R (bar),TPS (%)\n";
    let (mut east, mut north, mut heading, step) = (0.0, 0.0, 0.0_f64, 0.01);
    let mut path = Vec::new();
    for i in 0..24_000 {
        let t = f64::from(i) * step;
        path.push((east, north));
        east += speed(t) * heading.cos() * step;
        north += speed(t) * heading.sin() * step;
        heading += turn(t) * step;
    }
    let metres = 6.371e6_f64.to_radians();
    for i in 0..2400_usize {
        let t = i as f64 * 0.1;
        let seen = (t - of.late).max(0.0);
        let kmh = |v: f64, k: usize| (3.6 * v * of.speed + 0.1 * noise(k)).max(0.0);
        let ideal = (speed(t) * turn(t) / GRAVITY).atan();
        let faster = 1.0 + 0.18 * (1.0 - ideal.cos());
        let braking = (-pull(t) - 0.6).max(0.0);
        let front = speed(t) * faster * (1.0 - 0.004 * braking);
        let rear = speed(t) * faster * (1.0 + 0.004 * pull(t).max(0.0));
        let lean = -(1.05 * ideal.to_degrees()) * of.side + 0.4 * noise(3 * i);
        let _ = write!(text, "{t:.2},{:.2},", kmh(speed(seen), i));
        if of.position {
            let (x, y) = path[(seen / step).round() as usize];
            let (north, east) = (47.0 + y / metres, 8.0 + x / metres / 47.0_f64.to_radians().cos());
            let _ = write!(text, "{north:.7},{east:.7},");
        }
        if of.rounded {
            let _ = write!(text, "{:.0},", if lean.abs() < 3.0 { 0.0 } else { lean });
        }
        let _ = writeln!(
            text,
            "{lean:.2},{:.2},{:.2},{:.2},{:.2},{:.1}",
            kmh(front, 5 * i),
            kmh(rear, 7 * i),
            (1.2 * braking).max(0.0),
            0.2 * braking,
            100.0 * (pull(t) / 4.0).clamp(0.0, 1.0)
        );
    }
    text
}

fn written(folder: &Path, text: &str) -> PathBuf {
    let path = folder.join("ride.csv");
    std::fs::write(&path, text).expect("written");
    path
}

const MAP: &str = "name = \"own\"\nformat = \"csv\"\n[detect]\ncolumns = [\"Lean (deg)\"]\n[time]\ncolumn = \"Time (s)\"\n\
    unit = \"s\"\n[channel.velocity_x]\nfrom = \"GPS Speed (km/h)\"\nunit = \"km/h\"\n[channel.roll]\nfrom = \"Lean (deg)\"\n\
    unit = \"deg\"\n[channel.wheel_speed_front]\nfrom = \"Wheel Speed F (km/h)\"\nunit = \"km/h\"\nradius = 0.30\n\
    [channel.wheel_speed_rear]\nfrom = \"Wheel Speed R (km/h)\"\nunit = \"km/h\"\nradius = 0.31\n[channel.throttle]\n\
    from = \"TPS (%)\"\nunit = \"%\"\n[channel.latitude]\nfrom = \"Latitude (deg)\"\nunit = \"deg\"\n\
    [channel.longitude]\nfrom = \"Longitude (deg)\"\nunit = \"deg\"\n";

struct Said {
    code: Option<i32>,
    out: String,
    err: String,
}

fn roadbench(folder: &Path, arguments: &[&str]) -> Said {
    let mut command = Command::cargo_bin("roadbench").expect("built");
    let output = command.current_dir(folder).args(arguments).output().expect("ran");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    Said { code: output.status.code(), out: text(&output.stdout), err: text(&output.stderr) }
}

/// A folder with the log, its map and a bike file.
fn prepared(of: &Logger) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    written(folder.path(), &log(of));
    std::fs::write(folder.path().join("m.toml"), MAP).expect("written");
    let new = "bike new mine --class naked --front 120/70ZR17 --rear 180/55ZR17 --weight 270";
    let made = roadbench(folder.path(), &new.split(' ').collect::<Vec<&str>>());
    assert_eq!(made.code, Some(0), "{}", made.err);
    folder
}

const CONVERT: [&str; 8] =
    ["convert", "ride.csv", "--map", "m.toml", "--bike", "mine", "--out", "ride.parquet"];
const RUN: [&str; 6] = ["run", "ride.parquet", "--bikes", "bikes", "--out", "out"];

#[test]
fn speeds_in_mph_read_as_kmh_are_said_by_every_command() {
    let folder = prepared(&Logger { speed: 0.621_371, ..RIGHT });
    let at = folder.path();
    let convert = roadbench(at, &CONVERT);
    assert!(convert.err.contains("unit_velocity") && convert.err.contains("mph read as km/h"));
    let inspect = roadbench(at, &["inspect", "ride.parquet", "--bikes", "bikes"]);
    assert!(inspect.out.contains("mph read as km/h"), "{}", inspect.out);
    let bare = roadbench(at, &["inspect", "ride.parquet"]);
    assert!(bare.out.contains("mph read as km/h"), "{}{}", bare.out, bare.err);
    let run = roadbench(at, &RUN);
    assert_ne!(run.code, Some(0), "{}", run.out);
    assert!(run.err.contains("mph read as km/h"), "{}", run.err);
    let map = roadbench(at, &["map", "ride.csv", "--map", "m.toml"]);
    assert_eq!(map.code, Some(1), "{}", map.out);
    assert!(map.out.contains("velocity_x"), "{}", map.out);
}

#[test]
fn a_lean_to_the_left_gives_no_lateral_friction_and_its_sign_is_named() {
    let folder = prepared(&Logger { side: -1.0, ..RIGHT });
    let at = folder.path();
    let convert = roadbench(at, &CONVERT);
    assert!(convert.err.contains("sign_lateral"), "{}", convert.err);
    let said = roadbench(at, &RUN);
    assert!(said.out.contains("lateral_friction_ct"), "{}{}", said.out, said.err);
    let ok = |line: &&str| line.contains("lateral_friction_ct") && line.trim_end().ends_with(" ok");
    assert!(!said.out.lines().any(|l| ok(&l)), "{}", said.out);
    let map = roadbench(at, &["map", "ride.csv", "--map", "m.toml"]);
    assert!(map.out.contains("roll: wrong sign"), "{}", map.out);
}

#[test]
fn a_right_log_is_not_objected_to() {
    let folder = prepared(&RIGHT);
    let at = folder.path();
    let convert = roadbench(at, &CONVERT);
    assert!(!convert.err.contains("sign_") && !convert.err.contains("scale_"), "{}", convert.err);
    let inspect = roadbench(at, &["inspect", "ride.parquet", "--bikes", "bikes"]);
    assert_eq!(inspect.code, Some(0), "{}", inspect.err);
    assert!(!inspect.out.contains("scale_") && !inspect.out.contains("unit_"), "{}", inspect.out);
    let map = roadbench(at, &["map", "ride.csv", "--map", "m.toml", "--bike", "bikes/mine.toml"]);
    assert_eq!(map.code, Some(0), "{}{}", map.out, map.err);
}

/// The wheels run ahead in bends by as much as the lean is larger than the ideal one.
#[test]
fn a_measured_lean_beside_wheel_speeds_is_drafted() {
    let folder = tempfile::tempdir().expect("a folder");
    for rounded in [false, true] {
        let found = judged(&written(folder.path(), &log(&Logger { rounded, ..RIGHT })));
        let lean = found.verdicts.sure(Channel::Roll).expect("drafted");
        assert_eq!(found.listing.channels[lean.source].name, "Lean (deg)");
        assert_eq!(lean.sign, 1.0);
    }
}

#[test]
fn channels_of_one_clock_get_no_delay_of_their_own() {
    let folder = tempfile::tempdir().expect("a folder");
    for (late, position) in [(0.0, true), (0.0, false), (0.25, true)] {
        let path = written(folder.path(), &log(&Logger { late, position, ..RIGHT }));
        let found = judged(&path);
        let map = ChannelMap::parse(&found.draft, "draft").expect(&found.draft);
        let receiver = [Channel::VelocityX, Channel::Latitude, Channel::Longitude];
        for entry in &map.entries {
            let of_receiver = receiver.contains(&entry.channel);
            let truth = if of_receiver { late } else { 0.0 };
            let off = (entry.delay - truth).abs();
            // without bends a receiver's delay does not show well
            assert!(off < 0.06, "{} of {late}, {position}: {}", entry.channel, entry.delay);
        }
        let spread = found.verdicts.sure(Channel::VelocityX).and_then(|v| v.delay_error);
        assert!(spread.is_some_and(|s| s >= 0.02), "{spread:?}");
    }
}

/// Cases of other people's logs; they are not part of the repository.
#[test]
fn cases_of_foreign_logs() {
    let cases = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/cases/logs");
    let case = |name: &str| Some(cases.join(name).join("ride.csv.gz")).filter(|p| p.exists());
    if let Some(log) = case("lean_larger_than_ideal") {
        assert!(judged(&log).verdicts.sure(Channel::Roll).is_some());
    }
    if let Some(log) = case("no_position_delay") {
        let map = ChannelMap::parse(&judged(&log).draft, "draft").expect("a draft");
        assert!(map.entries.iter().all(|e| e.delay < 0.05));
    }
    let Some(log) = case("lean_left_positive") else {
        println!("not run: there are no cases in ../shared/cases");
        return;
    };
    let map = ChannelMap::read(&cases.join("lean_left_positive/map.toml")).expect("a map");
    let raw = ingest::read(log.as_path(), &[map]).expect("read");
    let (mut session, _) = ingest::run(raw, &Config::default()).expect("a session");
    let warnings = ingest::check(&mut session, None, &Config::default()).expect("checked");
    assert!(warnings.iter().any(|w| w.code == "sign_lateral"), "{warnings:?}");
    assert!(session.contradicted.iter().any(|c| c.0 == Channel::Roll));
}
