//! Logs of racing loggers: small ones checked by hand, whole rides written and read back, damage.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Config, Raw};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::segment::laps::{self, look};

use crate::racing_files::{self as files, DIGITS};

const G: f64 = 9.80665;

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/formats/racing").join(name)
}

fn read(name: &str) -> Raw {
    ingest::read(fixture(name), &[]).unwrap_or_else(|e| panic!("{name}: {} {e}", e.code))
}

/// First sample, and rate in Hz, of a channel.
fn first(raw: &Raw, channel: Channel) -> (f64, f64) {
    let track =
        raw.tracks.iter().find(|t| t.channel == channel).unwrap_or_else(|| panic!("{channel}"));
    let (n, time) = (track.time.len(), &track.time);
    (track.values[0], (n - 1) as f64 / (time[n - 1] - time[0]))
}

fn near(got: (f64, f64), value: f64, rate: f64) {
    assert!((got.0 - value).abs() < 1e-6 * value.abs().max(1.0), "{} not {value}", got.0);
    assert!((got.1 - rate).abs() < 1e-3 * rate, "{} Hz, not {rate}", got.1);
}

fn codes(raw: &Raw) -> Vec<&str> {
    raw.warnings.iter().map(|w| w.code).collect()
}

#[test]
fn motec_i2_by_hand() {
    let raw = read("motec_i2.csv");
    use Channel::*;
    near(first(&raw, VelocityX), 25.0, 20.0);
    near(first(&raw, AccelerationX), 0.25 * G, 20.0);
    near(first(&raw, WheelSpeedFront), 25.0 / 0.30, 20.0);
    near(first(&raw, BrakePressureFront), 0.0, 20.0);
    near(first(&raw, Throttle), 0.5, 20.0);
    near(first(&raw, SteerAngle), 2_f64.to_radians(), 20.0);
    near(first(&raw, AirTemperature), 20.5, 20.0);
    assert!(raw.tracks.iter().all(|t| t.channel != AccelerationY), "it leans with the frame");
    let Meta { session_id, bike_id, start_time, site, rider_id, .. } = raw.meta.clone();
    assert_eq!((session_id.as_str(), bike_id.as_str()), ("motec_i2", "R6_11"));
    assert_eq!(start_time.as_deref(), Some("2005-11-23T09:53:00Z"));
    assert_eq!((site.as_deref(), rider_id.as_deref()), (Some("Calder"), Some("A. Rider")));
    assert_eq!(codes(&raw), ["local_time", "unknown_column"], "no time zone is told");
}

#[test]
fn aim_race_studio_by_hand() {
    let raw = read("aim_rs3.csv");
    use Channel::*;
    near(first(&raw, VelocityX), 20.0, 10.0);
    near(first(&raw, AccelerationY), 0.5 * G, 10.0);
    near(first(&raw, YawRate), 14.3_f64.to_radians(), 10.0);
    near(first(&raw, Gear), 4.0, 10.0);
    near(first(&raw, Latitude), 42.15, 10.0);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2022-06-19T15:42:00Z"));
    assert_eq!(raw.meta.bike_id, "S1000RR");
    // another country and another version: semicolons, decimal commas, Latin-1, underscores
    let raw = read("aim_rs2_eu.csv");
    near(first(&raw, VelocityX), 30.0, 20.0);
    near(first(&raw, AccelerationY), -0.5 * G, 20.0);
    near(first(&raw, WheelSpeedRear), 100.0, 20.0);
    near(first(&raw, AirTemperature), 20.5, 20.0);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2022-06-19T15:42:10Z"));
    assert_eq!(raw.meta.rider_id.as_deref(), Some("C"));
}

#[test]
fn racechrono_by_hand() {
    let raw = read("racechrono_v3.csv");
    use Channel::*;
    near(first(&raw, VelocityX), 15.0, 10.0);
    near(first(&raw, AccelerationY), 0.92 * G, 10.0);
    near(first(&raw, Throttle), 0.105, 5.0);
    near(first(&raw, BrakePressureFront), 0.05e5, 5.0);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2026-02-22T09:40:00Z"));
    assert_eq!(raw.meta.rider_id.as_deref(), Some("D. Rider"));
    // slow channels are no gaps
    let (session, warnings) = ingest::run(raw, &Config::default()).expect("usable");
    assert!(warnings.iter().all(|w| w.code != "gap"), "{warnings:?}");
    assert_eq!(session.rate, 10.0);
    let raw = read("racechrono_v2.csv");
    near(first(&raw, VelocityX), 20.0, 10.0);
    near(first(&raw, AccelerationY), -0.5 * G, 10.0);
    near(first(&raw, Throttle), 0.25, 2.0);
}

#[test]
fn vbox_by_hand() {
    let raw = read("vbox.vbo");
    use Channel::*;
    near(first(&raw, VelocityX), 25.0, 10.0);
    near(first(&raw, AccelerationX), 0.05 * G, 10.0);
    near(first(&raw, AccelerationY), 0.40 * G, 10.0);
    near(first(&raw, Latitude), 3170.0 / 60.0, 10.0);
    near(first(&raw, Longitude), -1.35, 10.0);
    near(first(&raw, Altitude), 102.5, 10.0);
    assert!(raw.tracks.iter().all(|t| t.channel != Yaw), "a course is no heading");
    assert_eq!(raw.meta.start_time.as_deref(), Some("2025-06-14T09:59:58.9Z"));
    assert_eq!(codes(&raw), ["bad_line", "unknown_column"], "a row is cut off");
    let (session, _) = ingest::run(raw, &Config::default()).expect("usable");
    assert_eq!(session.rate, 10.0);
}

#[test]
fn racebox_by_hand() {
    let raw = read("racebox.csv");
    use Channel::*;
    // a circle of 100 m at 72 km/h, to the left: that it is km/h is in its positions only
    near(first(&raw, VelocityX), 20.0, 5.0);
    near(first(&raw, AccelerationX), 0.01 * G, 5.0);
    near(first(&raw, Latitude), 50.0, 5.0);
    assert!(raw.tracks.iter().all(|t| !matches!(t.channel, AccelerationY | YawRate | Altitude)));
    let speed = raw.tracks.iter().find(|t| t.channel == VelocityX).expect("mapped");
    assert_eq!(speed.values.iter().filter(|v| v.is_nan()).count(), 3, "no fix is no standstill");
    assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"));
    assert_eq!(raw.meta.site.as_deref(), Some("Test"));
    assert_eq!(codes(&raw), ["no_fix", "unknown_column"]);
    // no block, units behind the names
    let raw = read("racebox_units.csv");
    near(first(&raw, VelocityX), 7.17, 25.0);
    near(first(&raw, Altitude), 300.0, 25.0);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"));
    // a unit that nothing tells is asked for, not guessed
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("r.csv");
    let text = std::fs::read_to_string(fixture("racebox.csv")).expect("bundled");
    let short: Vec<&str> = text.lines().take(40).collect();
    std::fs::write(&path, short.join("\n")).expect("written");
    let e = ingest::read(&path, &[]).expect_err("5 s of riding");
    assert!(e.code.as_str() == "unknown_unit" && e.message.contains("`Speed`"), "{e}");
    let text =
        "name = 'm'\nformat = 'racebox'\n[channel.velocity_x]\nfrom = 'Speed'\nunit = 'km/h'\n";
    let map = [ChannelMap::parse(text, "m.toml").expect("a map")];
    near(first(&ingest::read(&path, &map).expect("told"), VelocityX), 20.0, 5.0);
}

#[test]
fn a_suspension_log_by_hand() {
    let mut bytes = b"SST\x03\xe8\x03\x01\x10".to_vec();
    bytes.extend(1_777_636_924_i64.to_le_bytes());
    for i in 0..2000_u16 {
        bytes.extend((100 + i / 10).to_le_bytes());
        bytes.extend((50 + i / 20).to_le_bytes());
    }
    bytes.extend([1, 0]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("00001.SST");
    std::fs::write(&path, &bytes).expect("written");
    let text = "name = 'm'\nformat = 'sst'\n[channel.fork_travel]\nfrom = 'fork'\nunit = 'mm'\nscale = 0.5\n\
        offset = -50\n[channel.shock_travel]\nfrom = 'shock'\nunit = 'mm'\n";
    let map = [ChannelMap::parse(text, "m.toml").expect("a map")];
    let raw = ingest::read(&path, &map).expect("read");
    near(first(&raw, Channel::ForkTravel), 0.0, 1000.0);
    near(first(&raw, Channel::ShockTravel), 0.05, 1000.0);
    let fork = &raw.tracks[0].values;
    assert!((fork[1999] - 0.0995).abs() < 1e-12 && fork.len() == 2000, "{}", fork[1999]);
    assert_eq!(raw.meta.start_time.as_deref(), Some("2026-05-01T12:02:04Z"));
    assert_eq!(codes(&raw), ["truncated"]);
    bytes[3] = 4;
    std::fs::write(&path, &bytes).expect("written");
    let e = ingest::read(&path, &map).expect_err("another version");
    assert!(e.code.as_str() == "unknown_version" && e.message.contains("version 4"), "{e}");
}

#[test]
fn xsens_by_hand() {
    let raw = read("xsens_mti.txt");
    use Channel::*;
    // a left-hand corner: 20 m/s, 0.5 rad/s, 30 degrees of lean; north-east at the start
    near(first(&raw, VelocityX), 20.0, 100.0);
    near(first(&raw, VelocityY), 0.0, 100.0);
    near(first(&raw, AccelerationX), 0.0, 100.0);
    near(first(&raw, AccelerationY), 10.0, 100.0);
    near(first(&raw, Roll), -30_f64.to_radians(), 100.0);
    near(first(&raw, RollRate), 0.0, 100.0);
    near(first(&raw, PitchRate), 0.0, 100.0);
    near(first(&raw, YawRate), 0.5, 100.0);
    near(first(&raw, Yaw), 45_f64.to_radians(), 100.0);
    near(first(&raw, Latitude), 45.6, 4.0);
    // the first stamp is half a second late; the ticks begin anew at the 100th row
    assert_eq!(raw.meta.start_time.as_deref(), Some("2024-05-01T10:20:29.5Z"));
    assert!(raw.euler_yaw);
    let (session, warnings) = ingest::run(raw, &Config::default()).expect("usable");
    assert!((session.len, session.rate) == (159, 100.0), "{} at {}", session.len, session.rate);
    assert!(warnings.iter().all(|w| !w.code.starts_with("time")), "{warnings:?}");
    // no stamps: packets at the header's rate, one of them lost
    let raw = read("xsens_mtw.txt");
    near(first(&raw, YawRate), 0.1, 40.0 * 78.0 / 79.0);
    assert_eq!(raw.tracks[0].time.len(), 79);
    let (session, _) = ingest::run(raw, &Config::default()).expect("usable");
    assert_eq!((session.len, session.rate), (80, 40.0));
}

#[test]
fn units_are_the_files_or_the_maps_but_not_two() {
    let map = |channel: &str| {
        let text = format!("name = 'm'\nformat = 'motec_csv'\n[channel.{channel}");
        [ChannelMap::parse(&text, "m.toml").unwrap_or_else(|e| panic!("{e}"))]
    };
    let fail =
        |channel: &str| ingest::read(fixture("motec_i2.csv"), &map(channel)).expect_err(channel);
    let e = fail("velocity_x]\nfrom = 'Ground Speed'\nunit = 'mph'\n");
    assert_eq!(e.code.as_str(), "unit_mismatch");
    assert!(e.message.contains("km/h") && e.message.contains("mph"), "{e}");
    let e = fail("wheel_speed_rear]\nfrom = 'Ground Speed'\n");
    assert_eq!(e.code.as_str(), "unknown_unit", "no radius: {e}");
    let e = fail("velocity_x]\nfrom = 'Ground Sped'\n");
    assert!(e.message.contains("did you mean `Ground Speed`"), "{e}");
    // a plain CSV whose map says where its units stand
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("r.csv");
    std::fs::write(&path, "t;v\ns;furlong\n0;1\n1;2\n2;3\n").expect("written");
    let text = "name = 'm'\nformat = 'csv'\n[csv]\ndelimiter = ';'\nrows_after_header = 1\n\
        units_row = 1\n[time]\ncolumn = 't'\n[channel.velocity_x]\nfrom = 'v'\n";
    let plain = [ChannelMap::parse(text, "m.toml").expect("a map")];
    let e = ingest::read(&path, &plain).expect_err("furlong");
    assert!(e.code.as_str() == "unknown_unit" && e.message.contains("`v`"), "{e}");
    std::fs::write(&path, "t;v\ns;km/h\n0;36\n1;36\n2;36\n").expect("written");
    assert_eq!(ingest::read(&path, &plain).expect("read").tracks[0].values, [10.0; 3]);
}

#[test]
fn what_is_cut_off_is_read_up_to_there() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = std::fs::read_to_string(fixture("aim_rs2_eu.csv").with_file_name("motec_i2.csv"));
    let text = text.expect("there");
    let path = folder.path().join("cut.csv");
    std::fs::write(&path, &text[..text.len() - 30]).expect("written");
    let raw = ingest::read(&path, &[]).expect("most of it is there");
    assert!(codes(&raw).contains(&"cut_off"), "{:?}", raw.warnings);
    assert_eq!(raw.tracks[0].values.len(), 59);
    // UTF-16, as some Windows programs save it
    let mut bytes = vec![0xff, 0xfe];
    text.encode_utf16().for_each(|u| bytes.extend(u.to_le_bytes()));
    std::fs::write(&path, bytes).expect("written");
    let raw = ingest::read(&path, &[]).expect("the same text");
    assert_eq!(raw.tracks[0].values.len(), 60);
}

#[test]
fn markers_of_laps_are_read() {
    for (name, times) in [
        ("motec_i2.csv", &[1.5][..]),
        ("aim_rs3.csv", &[2.0, 4.0]),
        ("racechrono_v3.csv", &[]),
        ("racechrono_v2.csv", &[]),
    ] {
        assert_eq!(read(name).markers.times, times, "{name}");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("r.csv");
    // RaceChrono puts a row in where the line was passed
    let text = std::fs::read_to_string(fixture("racechrono_v3.csv")).expect("bundled");
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    let first = lines.iter().position(|l| l.starts_with("unix time")).expect("units") + 2;
    for (k, line) in lines[first..].iter_mut().enumerate() {
        let mut cells: Vec<&str> = line.split(',').collect();
        cells[2] = if k < 3 {
            ""
        } else if k < 8 {
            "1"
        } else {
            "2"
        };
        *line = cells.join(",");
    }
    let stamp = |k: usize| -> f64 {
        lines[first + k].split(',').next().and_then(|t| t.parse().ok()).expect("a stamp")
    };
    std::fs::write(&path, lines.join("\n")).expect("written");
    let raw = ingest::read(&path, &[]).expect("read");
    assert_eq!(raw.markers.times, [stamp(3), stamp(8)]);
    let start = raw.tracks.iter().map(|t| t.time[0]).fold(f64::INFINITY, f64::min);
    let (session, _) = ingest::run(raw, &Config::default()).expect("usable");
    assert!((session.markers.times[1] - (stamp(8) - start)).abs() < 1e-6, "s since the start");
    // a record of the kind 5 after the first 10 s of a Y-Trac
    let bytes = files::ctrk(&ride(30.0));
    let mut at = 0x34 + 0x1f;
    let word = |at: usize| u16::from_le_bytes([bytes[at], bytes[at + 1]]);
    while bytes[at + 6] < 10 {
        at += usize::from(word(at + 2));
    }
    let mut lap = vec![5, 0, 22, 0, 123, 0];
    lap.extend(&bytes[at + 6..at + 14]);
    lap.extend([0; 8]);
    let marked = [&bytes[..at], &lap, &bytes[at..]].concat();
    let path = folder.path().join("y.CTRK");
    std::fs::write(&path, marked).expect("written");
    assert_eq!(ingest::read(&path, &[]).expect("read").markers.times, [10.123]);
}

/// A car's laps on a circuit, timed by RaceChrono: its markers against the positions of the same receiver.
#[test]
fn real_markers_agree_with_position() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/racechrono_car");
    for (name, expected) in [
        ("session_20251231_111318_tianma_lap9_v3.csv", 76.329),
        ("session_20251231_111959_tianma_lap13_v3.csv", 75.934),
    ] {
        let path = data.join(name);
        if !path.exists() {
            println!("{} is not there: nothing tested", path.display());
            return;
        }
        let raw = ingest::read(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
        let (session, _) = ingest::run(raw, &Config::default()).expect("usable");
        let (found, warnings) = look(&session, &laps::Config::default());
        let found = found.expect("a lap").1;
        let best = &found.laps[found.best];
        let difference = best.position_difference.expect("positions");
        println!("{name}: {:.3} s by markers, by position {difference:+.4} s", best.duration());
        assert!(found.by_markers && (best.duration() - expected).abs() < 2e-3, "{best:?}");
        assert!(difference.abs() < 0.02 && warnings.is_empty(), "{difference} {warnings:?}");
    }
}

/// The first seconds of a bundled ride.
fn ride(seconds: f64) -> Session {
    let log = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let raw = ingest::read(&log, &[]).expect("bundled");
    let whole = ingest::run(raw, &Pipeline::onroad().ingest).expect("bundled").0;
    let n = (seconds * whole.rate) as usize;
    let mut ride = Session::new(Meta::default(), whole.rate, n);
    for channel in whole.channels() {
        ride.set(channel, whole.get(channel).expect("its own")[1000..1000 + n].to_vec());
    }
    ride
}

/// Reads a log and compares it with what was written; `step` says every how many samples a channel
/// was written, `within` how exactly (SI).
fn same(
    ride: &Session,
    name: &str,
    bytes: &[u8],
    step: impl Fn(Channel) -> usize,
    within: impl Fn(Channel, f64) -> f64,
) -> usize {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("written");
    let raw = ingest::read(&path, &[]).unwrap_or_else(|e| panic!("{name}: {} {e}", e.code));
    assert!(raw.meta.rider_id.as_deref().is_none_or(|r| r == "Somebody"));
    let (back, warnings) = ingest::run(raw, &Pipeline::onroad().ingest).expect(name);
    assert!(warnings.iter().all(|w| w.code != "gap"), "{name}: {warnings:?}");
    assert_eq!((back.len, back.rate), (ride.len, ride.rate), "{name}");
    for channel in back.channels() {
        let (a, b) = (ride.get(channel).expect("written"), back.get(channel).expect("its own"));
        let mut compared = 0;
        for i in (0..ride.len).step_by(step(channel)) {
            if a[i].is_finite() && b[i].is_finite() {
                compared += 1;
                let most = within(channel, a[i]);
                let off = (a[i] - b[i]).abs();
                assert!(off <= most, "{name}: {channel} sample {i}: {} not {}", b[i], a[i]);
            }
        }
        let asked = ride.len / step(channel);
        // the first one of a late channel is before the log
        assert!((compared + 1) * 1000 >= asked * 995, "{name}: {channel}: {compared} of {asked}");
    }
    back.channels().count()
}

#[test]
fn a_ride_comes_back_from_every_text() {
    let ride = ride(30.0);
    let resolution = 0.501 * 10_f64.powi(-(DIGITS as i32));
    let exact = |map: &'static str| {
        let logged = files::logged(files::shipped(map), &ride);
        let factors: Vec<(Channel, f64)> = logged.iter().map(|c| (c.channel, c.factor)).collect();
        move |channel: Channel, value: f64| {
            let factor = factors.iter().find(|f| f.0 == channel).expect("written").1;
            resolution * factor + 1e-9 * value.abs()
        }
    };
    let every = |_: Channel| 1;
    let text = files::motec_csv(&ride);
    assert!(same(&ride, "m.csv", text.as_bytes(), every, exact("motec_csv")) >= 9);
    let text = files::aim_csv(&ride);
    assert!(same(&ride, "a.csv", text.as_bytes(), every, exact("aim_csv")) >= 9);
    let gps = |c: Channel| {
        use Channel::*;
        if matches!(c, VelocityX | AccelerationX | AccelerationY | Latitude | Longitude) {
            10
        } else {
            1
        }
    };
    let text = files::racechrono_v3(&ride);
    assert!(same(&ride, "r.csv", text.as_bytes(), gps, exact("racechrono_v3")) >= 7);
    // seven digits, and what a speed of 40 m/s and gravity make of an angle's last one
    let mut level = ride.clone();
    level.set(Channel::PitchRate, vec![0.0; ride.len]);
    let text = files::xsens(&level);
    assert!(same(&level, "x.txt", text.as_bytes(), every, |_, _| 2e-6) >= 10);
}

#[test]
fn a_ride_comes_back_from_the_binary_logs() {
    let ride = ride(30.0);
    let logged = files::logged(files::shipped("motec_ld"), &ride);
    let ld = |channel: Channel, value: f64| {
        let (k, c) = logged.iter().enumerate().find(|c| c.1.channel == channel).expect("written");
        let whole = 0.501 * 10_f64.powi(-(DIGITS as i32)) * c.factor;
        if k < 4 { whole } else { 6.1e-8 * value.abs() + 1e-12 }
    };
    let bytes = files::motec_ld(&ride);
    assert!(same(&ride, "m.ld", &bytes, |_| 1, ld) >= 9);
    let steps = |c: Channel| match c {
        Channel::VelocityX | Channel::Latitude | Channel::Longitude => ride.rate as usize,
        Channel::BrakePressureFront | Channel::BrakePressureRear | Channel::Gear => 2,
        _ => 1,
    };
    // the loggers' own steps: 1/64 m/s, 1/32 bar, 1/1000 g, 1/696
    let coarse = |c: Channel, _: f64| {
        use Channel::*;
        0.501
            * match c {
                WheelSpeedFront | WheelSpeedRear => 1.0 / 64.0 / 0.30,
                BrakePressureFront | BrakePressureRear => 1e5 / 32.0,
                AccelerationX => 1e-3 * G,
                Throttle => 1.0 / 696.0,
                VelocityX => 1e-3 * 1852.0 / 3600.0,
                // a constant position
                Latitude | Longitude => f64::INFINITY,
                _ => 1e-9,
            }
    };
    let mut there = ride.clone();
    there.set(Channel::Gear, vec![3.0; ride.len]);
    there.set(Channel::Latitude, vec![47.95; ride.len]);
    there.set(Channel::Longitude, vec![0.2; ride.len]);
    let positive = |v: &mut f64| *v = v.max(0.0);
    use Channel::{
        BrakePressureFront, BrakePressureRear, Throttle, WheelSpeedFront, WheelSpeedRear,
    };
    for c in [BrakePressureFront, BrakePressureRear, Throttle, WheelSpeedFront, WheelSpeedRear] {
        there.get_mut(c).expect("there").iter_mut().for_each(positive);
    }
    let bytes = files::ctrk(&there);
    assert!(same(&there, "y.CTRK", &bytes, steps, coarse) >= 9);
}

/// MoTeC's own sample, which comes with the crate motec-i2, read by that crate and by us.
#[test]
fn motecs_sample_log_as_another_reads_it() {
    let home = std::env::var("CARGO_HOME").map(PathBuf::from);
    let home = home.or_else(|_| std::env::var("HOME").map(|h| Path::new(&h).join(".cargo")));
    let sources = home.expect("a home").join("registry/src");
    let sample = std::fs::read_dir(sources)
        .into_iter()
        .flatten()
        .flatten()
        .map(|index| index.path().join("motec-i2-0.2.0/samples/Sample1.ld"));
    let Some(sample) = sample.into_iter().find(|p| p.exists()) else {
        println!("motec-i2's sample is not where cargo unpacks crates: nothing tested");
        return;
    };
    let text = ["name = 's'\nformat = 'motec_ld'\n[channel.velocity_x]\nfrom = 'Ground Speed'\n"];
    let maps = text.map(|t| ChannelMap::parse(t, "s.toml").expect("a map"));
    let raw = ingest::read(&sample, &maps).expect("a log");
    assert_eq!(raw.meta.start_time.as_deref(), Some("2005-11-23T09:53:00Z"));
    assert_eq!((raw.meta.bike_id.as_str(), raw.meta.site.as_deref()), ("11A", Some("Calder")));
    let look = ingest::format_of(&sample).expect("known").decoder.expect("without a map");
    let aids = ingest::checks::aids::Aids::default();
    let listing = (look.list)(&(&sample).into(), &aids).expect("listed");
    let wanted: Vec<_> = listing.channels.iter().collect();
    let ours = (look.decode)(&(&sample).into(), &aids, &wanted).expect("decoded").columns;
    let mut file = std::fs::File::open(&sample).expect("there");
    let mut theirs = motec_i2::LDReader::new(&mut file);
    let channels = theirs.read_channels().expect("read");
    assert_eq!((channels.len(), ours.len()), (78, 78));
    let mut samples = 0;
    for ((channel, source), column) in channels.iter().zip(&wanted).zip(&ours) {
        assert_eq!(channel.name, source.name);
        assert_eq!(channel.unit, source.unit.clone().unwrap_or_default());
        assert_eq!(Some(f64::from(channel.sample_rate)), source.rate);
        let data = theirs.channel_data(channel).expect("read");
        assert_eq!(data.len(), column.values.len());
        for (a, b) in data.iter().zip(&column.values) {
            let a = a.decode_f64(channel);
            assert!((a - b).abs() <= 1e-12 * a.abs().max(1.0), "{}: {b} not {a}", channel.name);
        }
        samples += data.len();
    }
    assert!(samples > 500_000, "{samples}");
}

#[test]
fn damage_is_an_error_or_a_warning() {
    let ride = ride(8.0);
    let logs: [(&str, Vec<u8>); 6] = [
        ("m.ld", files::motec_ld(&ride)),
        ("y.CTRK", files::ctrk(&ride)),
        ("m.csv", files::motec_csv(&ride).into_bytes()),
        ("a.csv", files::aim_csv(&ride).into_bytes()),
        ("r.csv", files::racechrono_v3(&ride).into_bytes()),
        ("x.txt", files::xsens(&ride).into_bytes()),
    ];
    let folder = tempfile::tempdir().expect("a folder");
    let mut random = Pcg64::seed_from_u64(7);
    let (mut through, mut refused) = (0, 0);
    for (name, whole) in &logs {
        let path = folder.path().join(name);
        for k in 0..40 {
            let mut bytes = whole.clone();
            let n = bytes.len();
            match k % 4 {
                0 => bytes.truncate(random.random_range(0..n)),
                1 => {
                    // the head, where the lies are
                    for _ in 0..8 {
                        let at = random.random_range(0..n.min(1500));
                        bytes[at] = random.random_range(0..=255);
                    }
                }
                2 => {
                    for _ in 0..200 {
                        let at = random.random_range(0..n);
                        bytes[at] ^= 1 << random.random_range(0..8);
                    }
                }
                _ => {
                    let by = random.random_range(1..n);
                    bytes[n.min(100)..].rotate_left(by % (n - n.min(100)).max(1));
                }
            }
            std::fs::write(&path, &bytes).expect("written");
            let _ = ingest::identify(&path, &[]);
            match ingest::read(&path, &[]).and_then(|raw| ingest::run(raw, &Config::default())) {
                Ok(_) => through += 1,
                Err(e) => {
                    refused += 1;
                    assert!(!e.message.is_empty());
                }
            }
            if let Ok(Some(look)) = ingest::format_of(&path).map(|r| r.decoder)
                && let Ok(listing) = (look.list)(&(&path).into(), &Default::default())
            {
                let wanted: Vec<_> = listing.channels.iter().collect();
                let _ = (look.decode)(&(&path).into(), &Default::default(), &wanted);
            }
        }
    }
    println!("{through} read, {refused} refused");
    assert!(through > 60 && refused > 20, "{through} read, {refused} refused");
}

#[test]
fn inspect_shows_the_log_and_drafts_a_map() {
    let roadbench = |args: &[&str], log: &str| {
        let mut command = Command::cargo_bin("roadbench").expect("built");
        let out = command.args(args).arg(fixture(log)).output().expect("run");
        assert!(out.status.success(), "{log}: {}", String::from_utf8_lossy(&out.stderr));
        String::from_utf8(out.stdout).expect("text")
    };
    let text = roadbench(&["inspect"], "motec_i2.csv");
    assert!(text.contains("velocity_x") && text.contains("2005-11-23T09:53:00Z"), "{text}");
    let text = roadbench(&["inspect", "--source"], "racechrono_v3.csv");
    for words in ["gps", "throttle_pos", "bar"] {
        assert!(text.contains(words), "{words} in\n{text}");
    }
    let draft = roadbench(&["inspect", "--propose"], "aim_rs3.csv");
    let map = ChannelMap::parse(&draft, "draft").expect(&draft);
    let raw = ingest::read(fixture("aim_rs3.csv"), &[map]).expect(&draft);
    assert!(raw.tracks.iter().any(|t| t.channel == Channel::VelocityX), "{draft}");
    let text = roadbench(&["convert", "--dry-run"], "motec_i2.csv");
    assert!(text.contains("Brake Pres Front") && text.contains("kPa"), "{text}");
}
