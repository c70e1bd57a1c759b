//! Logs that other software wrote, against the session that it was given (`fixtures/formats`).

mod devices;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use assert_cmd::Command;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Raw, Track};
use roadbench::internals::pipeline::Pipeline;

use Channel::*;

/// The first row of the session that is in the samples, as `ride.py` has it.
const FIRST: usize = 14_000;
/// Rows per second.
const RATE: f64 = 50.0;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// A sample, or one that was written anew: `.ci/formats` says where.
fn sample(name: &str) -> PathBuf {
    let folder = std::env::var_os("ROADBENCH_FORMATS").map(PathBuf::from);
    folder.unwrap_or_else(|| root().join("fixtures/formats")).join(name)
}

fn map(name: &str) -> Vec<ChannelMap> {
    vec![ChannelMap::read(&sample(name)).expect("bundled")]
}

/// The session that the samples were made from.
fn original() -> Raw {
    ingest::read(root().join("fixtures/formats/ride.parquet"), &[]).expect("bundled")
}

/// A channel of the original at the stamps of a track, which count from `zero`.
fn at_stamps(original: &Raw, track: &Track, zero: f64) -> Vec<f64> {
    let of = original.tracks.iter().find(|t| t.channel == track.channel).expect("original");
    let row = |t: &f64| of.values[FIRST + ((t - zero) * RATE).round() as usize];
    track.time.iter().map(row).collect()
}

/// Half a step of what the file can tell, in SI.
type Steps = fn(Channel) -> f64;

/// Single precision, and the pressures' own steps.
fn mdf(channel: Channel) -> f64 {
    match channel {
        BrakePressureFront | BrakePressureRear => 2500.0,
        _ => 0.0,
    }
}

fn can(channel: Channel) -> f64 {
    match channel {
        Roll | Pitch => 0.000_25,
        Yaw => 0.000_05,
        WheelSpeedFront => 0.0005,
        WheelSpeedRear => 0.005 * std::f64::consts::PI / 30.0,
        BrakePressureFront | BrakePressureRear => 2500.0,
        AccelerationX | AccelerationY => 0.0025,
        RollRate => 0.0025_f64.to_radians(),
        YawRate => 0.000_25,
        SteerAngle => 0.0002,
        Throttle => 0.0005,
        _ => 0.0,
    }
}

fn exact(_: Channel) -> f64 {
    0.0
}

/// Every sample of every channel is the original's; returns samples per channel.
fn compare(name: &str, raw: &Raw, step: Steps) -> Vec<(Channel, usize)> {
    let original = original();
    let mut counts = Vec::new();
    // python-can's MDF counts from when it was written, which is later than the frames
    let firsts = raw.tracks.iter().filter_map(|t| t.time.first().copied());
    let zero = firsts.fold(f64::INFINITY, f64::min);
    // and the first ROS message was logged after its own stamp
    let later = ["ride_bus.mf4", "ride_ros2.mcap"].contains(&name);
    assert!(zero == 0.0 || later, "{name} begins at {zero}");
    for track in &raw.tracks {
        let channel = track.channel;
        for t in track.time.iter() {
            // BLF and CDR have nanoseconds, ASC and candump microseconds
            let row = (t - zero) * RATE;
            let off = (row - row.round()).abs() / RATE;
            assert!(off < 2e-6, "{name}: {channel} at {t}");
        }
        let expected = at_stamps(&original, track, zero);
        let mut missing = 0;
        for ((t, got), wanted) in track.time.iter().zip(&track.values).zip(&expected) {
            if got.is_nan() {
                missing += 1;
                continue;
            }
            let near = step(channel) * 1.000_001 + 1e-6 * wanted.abs().max(1.0);
            assert!((got - wanted).abs() <= near, "{name}: {channel} at {t}: {got}, not {wanted}");
        }
        counts.push((channel, track.values.len() - missing));
    }
    // and the session that comes of it is that of the original at the same stamps
    let config = Pipeline::onroad().ingest;
    let tracks = raw.tracks.iter().map(|track| {
        let mut values = at_stamps(&original, track, zero);
        let lost = values.iter_mut().zip(&track.values).filter(|(_, got)| got.is_nan());
        lost.for_each(|(v, _)| *v = f64::NAN);
        Track { channel: track.channel, time: Arc::clone(&track.time), values }
    });
    let same = Raw { tracks: tracks.collect(), meta: raw.meta.clone(), ..Raw::default() };
    let (wanted, _) = ingest::run(same, &config).expect(name);
    let (got, _) = ingest::run(raw.clone(), &config).expect(name);
    assert_eq!((got.len, got.rate), (wanted.len, wanted.rate), "{name}");
    let mut apart = 0;
    for channel in wanted.channels() {
        let pairs = got.get(channel).expect(name).iter().zip(wanted.get(channel).expect(name));
        for (got, wanted) in pairs {
            // a cubic between quantised samples may go a little beyond them
            let near = 2.0 * step(channel) + 2e-6 * wanted.abs().max(1.0);
            apart += usize::from((got - wanted).abs() > near || got.is_nan() != wanted.is_nan());
        }
    }
    assert_eq!(apart, 0, "{name}: samples of the session that differ");
    counts
}

fn count(counts: &[(Channel, usize)], channel: Channel) -> usize {
    counts.iter().find(|(c, _)| *c == channel).map_or(0, |(_, n)| *n)
}

fn codes(raw: &Raw) -> Vec<&'static str> {
    raw.warnings.iter().map(|w| w.code).collect()
}

#[test]
fn mdf_of_asammdf_is_the_session_that_it_was_given() {
    for (name, rows, invalid) in [
        ("ride.mf4", 1000, 50),
        ("ride_420.mf4", 1000, 0),
        ("ride.mdf", 600, 0),
        ("ride_logger.mf4", 600, 50),
        ("ride_unfinalised.mf4", 600, 50),
    ] {
        let raw = ingest::read(sample(name), &[]).expect(name);
        let counts = compare(name, &raw, mdf);
        assert_eq!(counts.len(), 16, "{name}");
        assert_eq!(count(&counts, Roll), rows, "{name}");
        assert_eq!(count(&counts, VelocityX), rows / 5, "{name}: its own clock");
        assert_eq!(count(&counts, SteerAngle), rows / 2 - invalid, "{name}: invalidation bits");
        assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"), "{name}");
        let unfinalised = codes(&raw).contains(&"unfinalised");
        assert_eq!(unfinalised, name == "ride_unfinalised.mf4", "{:?}", raw.warnings);
    }
}

/// Two channels of one group that are called alike: a map says which.
#[test]
fn mdf_channels_of_one_name_are_read_by_their_number() {
    let folder = tempfile::tempdir().expect("a folder");
    for name in ["ride.mf4", "ride.mdf"] {
        let mut bytes = std::fs::read(sample(name)).expect("bundled");
        let places: Vec<usize> = bytes
            .windows(14)
            .enumerate()
            .filter(|(_, w)| *w == b"acceleration_y")
            .map(|w| w.0)
            .collect();
        assert!(!places.is_empty(), "{name}");
        places.iter().for_each(|at| bytes[at + 13] = b'x');
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        let read = |from: &str| {
            let text =
                format!("name = 'm'\nformat = 'mdf'\n[channel.acceleration_x]\nfrom = '{from}'\n");
            ingest::read(&path, &[ChannelMap::parse(&text, "m.toml").expect("a map")])
        };
        let error = read("acceleration_x").expect_err("which of them?");
        assert_eq!(error.code.as_str(), "ambiguous_column", "{name}: {error}");
        assert!(error.message.contains("#1") && error.message.contains("#2"), "{name}: {error}");
        let both: Vec<Vec<f64>> = ["acceleration_x #1", "acceleration_x #2"]
            .map(|from| read(from).expect(from).tracks[0].values.clone())
            .to_vec();
        let whole = ingest::read(sample(name), &[]).expect("bundled");
        for (values, channel) in both.iter().zip([AccelerationX, AccelerationY]) {
            let of = whole.tracks.iter().find(|t| t.channel == channel).expect("a track");
            assert_eq!(values, &of.values, "{name}: {channel}");
        }
    }
}

#[test]
fn mcap_of_its_own_package_is_the_session_that_it_was_given() {
    for (name, map_name, rows) in [
        ("ride_json.mcap", "ride_json.toml", 800),
        ("ride_json_lz4.mcap", "ride_json.toml", 400),
        ("ride_ros2.mcap", "ride_ros2.toml", 800),
    ] {
        let raw = ingest::read(sample(name), &map(map_name)).expect(name);
        let counts = compare(name, &raw, exact);
        assert_eq!(counts.len(), 10, "{name}");
        assert_eq!(count(&counts, YawRate), rows, "{name}");
        assert_eq!(count(&counts, BrakePressureRear), rows / 2, "{name}");
        let start = raw.meta.start_time.as_deref();
        assert!(start.is_some_and(|s| s.starts_with("2026-05-01T12:02:04")), "{name}: {start:?}");
        assert_eq!(raw.meta.rider_id.as_deref(), name.contains("json").then_some("r7"), "{name}");
    }
}

#[test]
fn can_logs_of_python_can_are_the_session_that_it_was_given() {
    for (name, rows) in [
        ("ride.blf", 1000),
        ("ride.asc", 400),
        ("ride_candump.log", 400),
        ("ride_bus.mf4", 400),
        ("ride.asc.gz", 400),
    ] {
        let map_name = if name == "ride_bus.mf4" { "ride_bus.toml" } else { "ride_can.toml" };
        let raw = ingest::read(sample(name), &map(map_name)).expect(name);
        let counts = compare(name, &raw, can);
        assert_eq!(counts.len(), 16, "{name}");
        for (channel, every) in [
            (Roll, 1),
            (WheelSpeedRear, 2),
            (BrakePressureFront, 4),
            (BrakePressureRear, 4),
            (VelocityY, 4),
            (Gear, 10),
        ] {
            assert_eq!(count(&counts, channel), rows / every, "{name}: {channel}");
        }
        assert!(raw.warnings.is_empty(), "{name}: {:?}", raw.warnings);
        let start = raw.meta.start_time.as_deref();
        let right = start.is_some_and(|s| s.starts_with("2026-05-01T12:02:04"));
        assert!(right || name == "ride_bus.mf4", "{name}: {start:?}");
    }
}

/// The channels of the map that are not in CAN FD frames, which python-can leaves out of a trace.
#[test]
fn a_peak_trace_of_python_can_is_the_session_that_it_was_given() {
    let text = ChannelMap::text_of(&sample("ride_can.toml")).expect("bundled");
    let (head, rest) = text.split_once("[detect]").expect("a map");
    let maps =
        [ChannelMap::parse(&format!("{head}optional = true\n[detect]{rest}"), "ride_can.toml")
            .expect("a map")];
    let raw = ingest::read(sample("ride.trc"), &maps).expect("read");
    let counts = compare("ride.trc", &raw, can);
    assert_eq!(counts.len(), 9, "{counts:?}");
    assert_eq!((count(&counts, Roll), count(&counts, BrakePressureRear)), (400, 100));
    assert!(raw.warnings.is_empty(), "{:?}", raw.warnings);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"));
}

/// As asammdf 8.8 has them: one group, two senders, each by itself.
#[test]
fn a_group_of_j1939_is_found_whoever_sent_it() {
    let of = |sender: u8| {
        let text = format!(
            "name = 'j'\nformat = 'can'\ndbc_text = [{}]\n[channel.velocity_x]\n\
             from = 'CCVS1 from {sender}/WheelBasedVehicleSpeed'\n",
            toml_text(&std::fs::read_to_string(sample("j1939.dbc")).expect("bundled"))
        );
        let maps = [ChannelMap::parse(&text, "j.toml").expect("a map")];
        ingest::read(sample("j1939.asc"), &maps).map(|raw| raw.tracks[0].clone())
    };
    for (sender, factor) in [(0, 1.0), (33, 2.0)] {
        let track = of(sender).expect("sent");
        assert_eq!(track.values.len(), 100);
        for (i, (time, v)) in track.time.iter().zip(&track.values).enumerate() {
            assert!((time - 0.02 * i as f64 - 1e-3 * f64::from(sender)).abs() < 2e-6, "{time}");
            assert!((v * 3.6 - factor * (20 + i / 10) as f64).abs() < 1e-9, "{i}: {v}");
        }
    }
    let error = of(34).expect_err("nobody");
    assert_eq!(error.code.as_str(), "missing_column");
}

fn toml_text(text: &str) -> String {
    format!("'''{text}'''")
}

#[test]
fn tracks_of_gpxpy_are_the_circle_that_it_was_given() {
    for (name, within) in
        [("circle_10.gpx", 1e-9), ("circle_11.gpx", 0.03), ("circle_garmin.gpx", 1e-9)]
    {
        let raw = ingest::read(sample(name), &[]).expect(name);
        let of =
            |c| raw.tracks.iter().find(|t| t.channel == c).unwrap_or_else(|| panic!("{name}: {c}"));
        let speed = of(VelocityX);
        assert_eq!(speed.values.len(), 250, "{name}");
        // positions are rounded to 1 cm: over half a second that is 0.02 m/s, and at the ends of a segment, where there
        // are neighbours to one side only, over a tenth 0.1 m/s
        let worst = |inner: bool| {
            let at_end = |i: usize| i < 3 || (97..103).contains(&i) || i >= 247;
            let of = speed.values.iter().enumerate().filter(|(i, _)| at_end(*i) != inner);
            of.map(|(_, v)| (v - 20.0).abs()).fold(0.0, f64::max)
        };
        println!("{name}: speed within {:.4} m/s, at ends {:.4}", worst(true), worst(false));
        assert!(worst(true) < within && worst(false) < 5.0 * within, "{name}: {}", worst(true));
        let step = speed.time[100] - speed.time[99];
        assert!((step - 5.1).abs() < 1e-6, "{name}: the pause is {step} s");
        assert_eq!(of(Latitude).values[0], 50.0, "{name}");
        assert!(raw.tracks.iter().all(|t| t.channel != Yaw), "{name}: a course is no heading");
        assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"), "{name}");
        let is_known = |code: &str| code == "unknown_column" && name == "circle_garmin.gpx";
        assert!(raw.warnings.iter().all(|w| is_known(w.code)), "{name}: {:?}", raw.warnings);
    }
    // a speed in km/h is recognised by its positions
    let text = std::fs::read_to_string(sample("circle_10.gpx")).expect("bundled");
    let text = text.replace("<speed>20.0</speed>", "<speed>72.0</speed>");
    let raw = read_bytes(text.as_bytes(), "kmh.gpx", &[]).expect("read");
    let speed = raw.tracks.iter().find(|t| t.channel == VelocityX).expect("mapped");
    assert!(speed.values.iter().all(|v| (v - 20.0).abs() < 1e-9));
    let plan = text.replace("time>", "when>");
    let error = read_bytes(plan.as_bytes(), "plan.gpx", &[]).expect_err("a planned route");
    assert!(error.message.contains("time"), "{error}");
}

/// A sample's first bytes, read through its map.
fn cut(name: &str, maps: &[ChannelMap], share: f64) -> Result<Raw, ingest::Error> {
    let mut bytes = std::fs::read(sample(name)).expect("bundled");
    bytes.truncate((bytes.len() as f64 * share) as usize);
    read_bytes(&bytes, name, maps)
}

fn read_bytes(bytes: &[u8], name: &str, maps: &[ChannelMap]) -> Result<Raw, ingest::Error> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    ingest::read(&path, maps)
}

#[test]
fn what_was_cut_off_is_read_up_to_there_and_said() {
    for (name, map_name, step, kept) in [
        ("ride_logger.mf4", "", mdf as Steps, None),
        ("ride_unfinalised.mf4", "", mdf, Some("unfinalised")),
        ("ride_json.mcap", "ride_json.toml", exact, Some("truncated")),
        ("ride_ros2.mcap", "ride_ros2.toml", exact, Some("truncated")),
        ("ride.blf", "ride_can.toml", can, Some("truncated")),
        ("ride.asc.gz", "ride_can.toml", can, Some("truncated")),
    ] {
        let maps = if map_name.is_empty() { Vec::new() } else { map(map_name) };
        let whole = ingest::read(sample(name), &maps).expect(name);
        let raw = cut(name, &maps, 0.8).expect(name);
        let counts = compare(name, &raw, step);
        let said = codes(&raw);
        assert!(said.contains(&kept.unwrap_or("truncated")), "{name}: {:?}", raw.warnings);
        let samples = |raw: &Raw| raw.tracks.iter().map(|t| t.values.len()).sum::<usize>();
        let share = samples(&raw) as f64 / samples(&whole) as f64;
        println!(
            "{name}: {:.0} % of the samples, {} channels, {said:?}",
            100.0 * share,
            counts.len()
        );
        assert!((0.5..1.0).contains(&share), "{name}: {share}");
    }
    // the description is at the end of what asammdf writes
    let error = cut("ride.mf4", &[], 0.8).expect_err("nothing is left");
    assert!(error.message.contains("description of its channels"), "{error}");
}

#[test]
fn one_broken_block_costs_itself() {
    // a byte in the middle of the samples of compressed formats
    for (name, map_name, step, code) in [
        ("ride_json.mcap", "ride_json.toml", exact as Steps, "damaged"),
        ("ride.blf", "ride_can.toml", can, "bad_frame"),
        ("ride.asc", "ride_can.toml", can, "bad_frame"),
    ] {
        let mut bytes = std::fs::read(sample(name)).expect("bundled");
        let mut middle = bytes.len() / 2;
        if name.contains("mcap") {
            // within the next packed block: there are indices between them that are not needed
            let zstd = b"\x28\xB5\x2F\xFD";
            middle += 200 + bytes[middle..].windows(4).position(|w| w == zstd).expect("a block");
        }
        bytes[middle..middle + 40].fill(b'~');
        let raw = read_bytes(&bytes, name, &map(map_name)).expect(name);
        assert!(codes(&raw).contains(&code), "{name}: {:?}", raw.warnings);
        let counts = compare(name, &raw, step);
        let channel = if name.contains("json") { YawRate } else { Roll };
        let whole = ingest::read(sample(name), &map(map_name)).expect(name);
        let all = whole.tracks.iter().find(|t| t.channel == channel).expect("mapped").values.len();
        let left = count(&counts, channel);
        println!("{name}: {left} of {all} samples left");
        assert!(left * 3 > all && left < all, "{name}: {left} of {all}");
    }
}

#[test]
fn no_cut_and_no_flipped_bit_stops_a_reader() {
    let can = map("ride_can.toml");
    let (json, ros2) = (map("ride_json.toml"), map("ride_ros2.toml"));
    let mut state = 1_u32;
    let mut random = |n: usize| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as usize % n
    };
    for (name, maps) in [
        ("ride.mf4", &[][..]),
        ("ride.mdf", &[]),
        ("ride_420.mf4", &[]),
        ("ride_logger.mf4", &[]),
        ("ride_unfinalised.mf4", &[]),
        ("ride_json_lz4.mcap", &json),
        ("ride_ros2.mcap", &ros2),
        ("ride.blf", &can),
        ("ride.asc", &can),
        ("ride_candump.log", &can),
        ("ride.trc", &can),
        ("ride.asc.gz", &can),
        ("circle_garmin.gpx", &[]),
    ] {
        let whole = std::fs::read(sample(name)).expect("bundled");
        let (mut read, mut refused) = (0, 0);
        for round in 0..30 {
            let mut bytes = whole.clone();
            match round % 3 {
                0 => bytes.truncate(random(whole.len())),
                1 => (0..3).for_each(|_| bytes[random(whole.len())] ^= 1 << random(8)),
                // where the lengths and links are
                _ => (0..3).for_each(|_| {
                    let near =
                        if round % 2 == 0 { random(2000) } else { whole.len() - 1 - random(2000) };
                    bytes[near] ^= 1 << random(8);
                }),
            }
            let began = Instant::now();
            match read_bytes(&bytes, name, maps) {
                Ok(_) => read += 1,
                Err(e) => {
                    assert!(!e.message.is_empty());
                    refused += 1;
                }
            }
            assert!(began.elapsed() < Duration::from_secs(5), "{name}, round {round}");
        }
        println!("{name}: {read} read, {refused} refused");
    }
}

fn roadbench(arguments: &[&str]) -> (bool, String, String) {
    let mut command = Command::cargo_bin("roadbench").expect("built");
    let output = command.current_dir(root()).args(arguments).output().expect("run");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.success(), text(&output.stdout), text(&output.stderr))
}

#[test]
fn inspect_shows_a_log_without_a_map_and_proposes_one() {
    let folder = tempfile::tempdir().expect("a folder");
    for (log, more, channels) in [
        (
            "fixtures/formats/ride_json.mcap",
            &[][..],
            &["/attitude/roll", "/wheels/speed.front"][..],
        ),
        ("fixtures/formats/ride_ros2.mcap", &[], &["/imu/angular_velocity.z"]),
        (
            "fixtures/formats/ride.blf",
            &["--source", "--dbc", "fixtures/formats/ride.dbc"],
            &["Attitude/roll"],
        ),
        ("fixtures/formats/ride.mf4", &["--source"], &["IMU/roll", "GPS/velocity_x"]),
    ] {
        let (done, out, err) = roadbench(&[&["inspect", log], more].concat());
        assert!(done, "{log}: {err}");
        for channel in channels {
            assert!(out.contains(channel), "{log}: {out}");
        }
        let wanted = [&["inspect", log, "--propose"], more].concat();
        let (done, draft, err) = roadbench(&wanted);
        assert!(done && out.contains(&draft), "{log}: {err}");
        let path = folder.path().join("draft.toml");
        let draft =
            draft.replace("fixtures/formats/ride.dbc", &sample("ride.dbc").display().to_string());
        std::fs::write(&path, &draft).expect("written");
        ChannelMap::read(&path).expect(&draft);
    }
    let (done, out, _) = roadbench(&["inspect", "fixtures/formats/ride.blf"]);
    assert!(done && out.contains("0x123 (1000 frames at 50.0 Hz, 8 bytes)"), "{out}");
}

#[test]
fn convert_shows_the_mapping_and_names_what_is_misspelt() {
    let log = "fixtures/formats/ride.blf";
    let (done, out, err) =
        roadbench(&["convert", log, "--map", "fixtures/formats/ride_can.toml", "--dry-run"]);
    assert!(done && out.contains("Attitude/roll") && out.contains("Wheels/rear"), "{out}{err}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("wrong.toml");
    let text = std::fs::read_to_string(sample("ride_can.toml")).expect("bundled");
    let text = text.replace("ride.dbc", &sample("ride.dbc").display().to_string());
    std::fs::write(&path, text.replace("Wheels.front\"\n", "Weels.front\"\n")).expect("written");
    let file = path.display().to_string();
    let (done, _, err) = roadbench(&["convert", log, "--map", &file, "--dry-run"]);
    assert!(!done && err.contains("did you mean `Wheels/front`"), "{err}");
    let unit = text.replace("from = \"roll\"", "from = \"roll\"\nunit = \"deg\"");
    std::fs::write(&path, unit).expect("written");
    let (done, _, err) = roadbench(&["convert", log, "--map", &file, "--dry-run"]);
    assert!(!done && err.contains("in rad") && err.contains("file_unit"), "{err}");
    std::fs::write(&path, text.replace("ride.dbc", "gone.dbc")).expect("written");
    let (done, _, err) = roadbench(&["convert", log, "--map", &file, "--dry-run"]);
    assert!(!done && err.contains("gone.dbc"), "{err}");
}

#[test]
fn a_map_takes_its_database_along() {
    let text = ChannelMap::text_of(&sample("ride_can.toml")).expect("bundled");
    let map = ChannelMap::parse(&text, "elsewhere").expect("it is all there");
    let raw = ingest::read(sample("ride.blf"), &[map]).expect("read");
    assert_eq!(raw.tracks.len(), 16);
    assert!(Path::new(&sample("ride.dbc")).exists());
}

/// A table of others may be packed in other ways than ours; one way that is not read says what to do.
#[test]
fn gzip_is_read_and_brotli_says_how_to_write_it_anew() {
    use parquet::arrow::ArrowWriter;
    use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
    use parquet::basic::{Compression, GzipLevel};
    use parquet::file::properties::WriterProperties;
    let own = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let folder = tempfile::tempdir().expect("folder");
    let log = folder.path().join("archive_s0001.parquet");
    let write = |compression: Compression| {
        let file = std::fs::File::open(&own).expect("there");
        let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("a table");
        let pairs = reader.metadata().file_metadata().key_value_metadata().cloned();
        let schema = Arc::clone(reader.schema());
        let properties = WriterProperties::builder()
            .set_compression(compression)
            .set_key_value_metadata(pairs)
            .build();
        let file = std::fs::File::create(&log).expect("file");
        let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).expect("writer");
        for batch in reader.build().expect("rows") {
            writer.write(&batch.expect("rows")).expect("written");
        }
        writer.close().expect("closed");
    };
    write(Compression::GZIP(GzipLevel::default()));
    let (there, packed) = (ingest::read(own.as_path(), &[]), ingest::read(log.as_path(), &[]));
    let (there, packed) = (there.expect("read"), packed.expect("read"));
    assert_eq!((there.meta, there.tracks.len()), (packed.meta, packed.tracks.len()));
    for (a, b) in there.tracks.iter().zip(&packed.tracks) {
        let bits = |values: &[f64]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(bits(&a.values) == bits(&b.values), "{}", a.channel.name());
    }

    // a column that says it is packed by brotli: thrift compact, field 4 behind the column's name
    write(Compression::SNAPPY);
    let mut bytes = std::fs::read(&log).expect("written");
    let name = b"velocity_x\x15\x02\x16";
    let at = bytes.windows(name.len()).rposition(|w| w == name).expect("its codec");
    bytes[at + name.len() - 2] = 8;
    std::fs::write(&log, bytes).expect("written");
    let why = ingest::read(log.as_path(), &[]).expect_err("not read");
    assert_eq!(why.code.as_str(), "unknown_compression", "{why}");
    for word in ["velocity_x", "BROTLI", "zstd", "archive_s0001.parquet"] {
        assert!(why.message.contains(word), "{word}: {why}");
    }
}
