//! What riders' own devices write - watches, cameras, receivers, phones - against the ride that their files were made from
//! (`fixtures/formats/write_devices.py`, `fixtures/formats/sensors`).

use std::f64::consts::PI;

use roadbench::internals::contract::channel::Channel::{self, *};
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::checks::judge::{by_motion, draft};
use roadbench::internals::ingest::formats::survey::survey;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Raw, Track};
use roadbench::internals::store::objects::Location;

use super::{codes, read_bytes, root, sample};

/// The circle of `write_devices.py`: degrees north and east `t` seconds after the start.
fn place(t: f64) -> [f64; 2] {
    let angle = 0.2 * t;
    [50.0 + 100.0 * angle.sin() / 111_229.0, 13.0 + 100.0 * angle.cos() / 71_695.7]
}

fn of(raw: &Raw, channel: Channel) -> &Track {
    raw.tracks.iter().find(|t| t.channel == channel).unwrap_or_else(|| panic!("{channel}"))
}

/// Holds a log against the circle: how far its positions are off at most, degrees; rows with a position.
fn hold_against_the_circle(name: &str, raw: &Raw, zero: f64) -> (f64, usize) {
    let (north, east, speed) = (of(raw, Latitude), of(raw, Longitude), of(raw, VelocityX));
    let (mut worst, mut fixes) = (0.0_f64, 0);
    for (i, t) in north.time.iter().enumerate() {
        let wanted = place(t - zero);
        if north.values[i].is_finite() {
            fixes += 1;
            worst = worst.max((north.values[i] - wanted[0]).abs());
            worst = worst.max((east.values[i] - wanted[1]).abs());
        }
    }
    assert!(
        speed.values.iter().all(|v| (v - 20.0).abs() < 1e-3),
        "{name}: {:?}",
        &speed.values[..3]
    );
    assert!(
        of(raw, Altitude).values.iter().all(|z| (z - 300.0).abs() < 1e-9 || z.is_nan()),
        "{name}"
    );
    println!("{name}: {fixes} positions within {worst:.1e} degrees, {:?}", codes(raw));
    (worst, fixes)
}

/// 2026-05-01T12:02:04Z, s since 1970.
const START: f64 = 1_777_636_924.0;

#[test]
fn devices_recorded_the_circle() {
    for (name, rows, fixes, within, warned, start) in [
        // the map of FIT has no lean: said
        ("circle.fit", 91, 88, 1e-7, &["unknown_column"][..], "2026-05-01T12:02:04Z"),
        ("circle_camera.fit", 300, 300, 1e-7, &[], "2026-05-01T12:02:04Z"),
        ("circle.nmea", 150, 150, 1e-7, &["no_fix"], "2026-05-01T23:59:45Z"),
        ("circle.ubx", 295, 295, 1e-7, &["no_fix"], "2026-05-01T12:02:04.5Z"),
        ("circle.tcx", 91, 88, 1e-7, &[], "2026-05-01T12:02:04Z"),
    ] {
        let raw = ingest::read(sample(name), &[]).expect(name);
        let zero = if name == "circle.nmea" { START + 43_061.0 } else { START };
        let (worst, found) = hold_against_the_circle(name, &raw, zero);
        assert!(worst < within && found == fixes, "{name}: {worst}, {found}");
        let speed = of(&raw, VelocityX);
        assert_eq!(speed.time.len(), rows, "{name}");
        let step = (speed.time[rows - 1] - speed.time[0]) / (rows - 1) as f64;
        let wanted = match name {
            "circle.fit" | "circle.tcx" => 1.0,
            "circle.nmea" => 0.2,
            _ => 0.1,
        };
        assert!((step - wanted).abs() < 1e-9, "{name}: every {step} s");
        assert_eq!(codes(&raw), warned, "{name}: {:?}", raw.warnings);
        assert_eq!(raw.meta.start_time.as_deref(), Some(start), "{name}");
        let (session, _) = ingest::run(raw, &ingest::Config::default()).expect(name);
        let v = session.get(VelocityX).expect(name);
        assert!(v.iter().filter(|v| v.is_finite()).all(|v| (v - 20.0).abs() < 1e-3), "{name}");
    }
}

#[test]
fn a_watch_keeps_fields_of_apps_and_laps() {
    let log = Location::from(sample("circle.fit"));
    let seen = survey(&log, &Aids::default()).expect("read").expect("listed");
    let channel = |name: &str| {
        let at = seen.listing.channels.iter().position(|c| c.full() == name).expect(name);
        (seen.listing.channels[at].unit.clone(), seen.contents[at].clone())
    };
    let (unit, lean) = channel("record/lean");
    assert_eq!((unit.as_deref(), lean.samples), (Some("deg"), 91));
    assert_eq!(lean.extent.map(|e| [e[0], e[2]]), Some([-22.75, -22.0]));
    let (_, lap) = channel("record/lap");
    assert_eq!(lap.extent.map(|e| [e[0], e[2]]), Some([1.0, 3.0]));
    let (_, heart) = channel("record/heart_rate");
    assert_eq!((heart.samples, heart.missing), (19, 0), "on a clock of its own");
}

/// Number of rows and messages of a file, by how much of it is cut off.
#[test]
fn files_of_devices_that_break_off_are_read_up_to_there() {
    for (name, code) in [
        ("circle.fit", "truncated"),
        ("circle.nmea", "bad_line"),
        ("circle.ubx", "truncated"),
        ("circle.tcx", "truncated"),
    ] {
        let mut bytes = std::fs::read(sample(name)).expect("bundled");
        let whole = of(&ingest::read(sample(name), &[]).expect(name), VelocityX).values.len();
        // within a row, whatever the format
        bytes.truncate(bytes.len() * 7 / 10 - 7);
        let raw = read_bytes(&bytes, name, &[]).expect(name);
        let share = of(&raw, VelocityX).values.len() as f64 / whole as f64;
        println!("{name}: {:.0} % of the rows, {:?}", 100.0 * share, codes(&raw));
        assert!((0.6..0.85).contains(&share), "{name}: {share}");
        assert!(codes(&raw).contains(&code), "{name}: {:?}", raw.warnings);
    }
    // a watch whose battery went flat never wrote how much there is
    let mut bytes = std::fs::read(sample("circle.fit")).expect("bundled");
    bytes[4..8].fill(0);
    let raw = read_bytes(&bytes, "flat.fit", &[]).expect("read");
    assert!(codes(&raw).contains(&"unfinalised"), "{:?}", raw.warnings);
    assert_eq!(of(&raw, VelocityX).values.len(), 91);
    // a wrong byte in the middle is said by the checksum
    let mut bytes = std::fs::read(sample("circle.fit")).expect("bundled");
    let at = bytes.len() - 600;
    bytes[at] ^= 1;
    let raw = read_bytes(&bytes, "damaged.fit", &[]).expect("read");
    assert!(codes(&raw).contains(&"damaged"), "{:?}", raw.warnings);
}

/// By Python's own reading of the same texts.
#[test]
fn gopro_telemetry_is_what_its_own_extractor_wrote() {
    let raw = ingest::read(sample("sensors/hero7-GPS5.csv"), &[]).expect("read");
    let mean = |channel| of(&raw, channel).values.iter().sum::<f64>() / 308.0;
    for (channel, wanted, within) in [
        (Latitude, 42.342_518_011_688_33, 1e-9),
        (Longitude, -8.752_638_846_753_248, 1e-9),
        (Altitude, 57.532_321_428_571_44, 1e-9),
        (VelocityX, 1.927_724_025_974_025_8, 1e-9),
    ] {
        assert_eq!(of(&raw, channel).values.len(), 308);
        assert!((mean(channel) - wanted).abs() < within, "{channel}: {}", mean(channel));
    }
    assert_eq!(raw.meta.start_time.as_deref(), Some("2019-01-03T16:33:34.094Z"));
    let time = &of(&raw, VelocityX).time;
    assert!((time[307] - 16.905_777_777_777_763).abs() < 1e-9, "{}", time[307]);
    let log = Location::from(sample("sensors/gopro_hero5.zip"));
    let seen = survey(&log, &Aids::default()).expect("read").expect("listed");
    for (name, unit, samples, rate) in [
        ("ACCL/Accelerometer (up/down)", "m/s²", 199, 198.8),
        ("GYRO/Gyroscope (z)", "rad/s", 399, 398.6),
        ("GPS5/GPS (2D speed)", "m/s", 18, 18.0),
    ] {
        let at = seen.listing.channels.iter().position(|c| c.full() == name).expect(name);
        assert_eq!(seen.listing.channels[at].unit.as_deref(), Some(unit), "{name}");
        let found = &seen.contents[at];
        assert_eq!(found.samples, samples, "{name}");
        assert!(
            found.rate.is_some_and(|r| (r / rate - 1.0).abs() < 0.01),
            "{name}: {:?}",
            found.rate
        );
    }
}

/// The archives of the two apps were written from a CSV that another reader reads.
#[test]
fn phones_wrote_the_lap_that_they_were_given() {
    let original =
        std::fs::read_to_string(root().join("fixtures/loggers/phone.csv")).expect("bundled");
    let rows: Vec<Vec<f64>> = original
        .lines()
        .skip(1)
        .take(750)
        .map(|l| l.split(',').map(|c| c.parse().unwrap_or(f64::NAN)).collect())
        .collect();
    let map = |sensor: &str, force: &str, axes: [&str; 3]| {
        let mut text = "name = 'p'\nformat = 'sensors'\n".to_owned();
        for (axis, name) in ["x", "y", "z"].iter().zip(axes) {
            text += &format!(
                "[channel.imu_rate_{axis}]\nfrom = '{sensor}/{name}'\n[channel.imu_force_{axis}]\nfrom = '{force}/{name}'\n"
            );
        }
        [ChannelMap::parse(&text, "p.toml").expect("a map")]
    };
    for (name, force, axes, sign, late) in [
        ("sensors/sensor_logger.zip", "TotalAcceleration", ["x", "y", "z"], -1.0, 0.004),
        ("sensors/phyphox.zip", "Accelerometer", ["X", "Y", "Z"], 1.0, 0.003),
    ] {
        let raw = ingest::read(sample(name), &map("Gyroscope", force, axes)).expect(name);
        let first = of(&raw, ImuForceX).time[0];
        let mut worst = [0.0_f64; 2];
        for (axis, (rate, force)) in
            [(ImuRateX, ImuForceX), (ImuRateY, ImuForceY), (ImuRateZ, ImuForceZ)]
                .into_iter()
                .enumerate()
        {
            for (track, later, place, factor, at) in [
                (of(&raw, rate), late, 10 + axis, PI / 180.0, 0),
                (of(&raw, force), 0.0, 6 + axis, sign * 9.806_65, 1),
            ] {
                for (t, x) in track.time.iter().zip(&track.values) {
                    let row = (t - first - later) / 0.04;
                    assert!((row - row.round()).abs() < 1e-3, "{name}: {row}");
                    let wanted = factor * rows[row.round() as usize][place];
                    worst[at] = worst[at].max((x - wanted).abs());
                }
            }
        }
        println!(
            "{name}: rates within {:.0e} rad/s, forces within {:.0e} m/s2",
            worst[0], worst[1]
        );
        assert!(worst[0] < 1e-6 && worst[1] < 3e-6, "{name}: {worst:?}");
        // and what is taken without a map
        let raw = ingest::read(sample(name), &[]).expect(name);
        let speed = of(&raw, VelocityX);
        let wanted = if name.contains("phyphox") { 750 - 188 } else { 30 };
        assert!(speed.values.len().abs_diff(wanted) < 2, "{name}: {}", speed.values.len());
        for (t, v) in speed.time.iter().zip(&speed.values).filter(|(_, v)| v.is_finite()) {
            let row = rows[((t - speed.time[0]) / 0.04).round() as usize][5];
            assert!((v - row / 3.6).abs() < 1e-3, "{name}: {v} at {t}");
        }
        assert!(
            raw.tracks
                .iter()
                .all(|t| [VelocityX, Latitude, Longitude, Altitude].contains(&t.channel))
        );
        assert_eq!(raw.meta.start_time.as_deref(), Some("2026-07-01T10:00:00Z"), "{name}");
    }
}

/// A phone that is fixed to the frame: the whole lap as Sensor Logger writes it, through the draft that the motion gives.
#[test]
fn a_phone_on_the_frame_is_drafted_as_an_inertial_unit() {
    let original =
        std::fs::read_to_string(root().join("fixtures/loggers/phone.csv")).expect("bundled");
    let (mut force, mut rate, mut place) = (String::new(), String::new(), String::new());
    for (i, line) in original.lines().skip(1).enumerate() {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells[k].parse::<f64>().expect("a number");
        let stamp = |late: u64| {
            format!(
                "{},{}",
                1_782_900_000_000_000_000 + 40_000_000 * i as u64 + late,
                0.04 * i as f64
            )
        };
        let three = |k: usize, factor: f64| {
            format!(
                "{:.6},{:.6},{:.6}",
                factor * number(k + 2),
                factor * number(k + 1),
                factor * number(k)
            )
        };
        force += &format!("{},{}\n", stamp(0), three(6, 9.806_65));
        rate += &format!("{},{}\n", stamp(4_000_000), three(10, PI / 180.0));
        place += &format!(
            "{},{:.4},{},{},{}\n",
            stamp(0),
            number(5) / 3.6,
            cells[4],
            cells[3],
            cells[2]
        );
    }
    let own = "time,seconds_elapsed,z,y,x\n";
    let bytes = packed(&[
        ("TotalAcceleration.csv", own.to_owned() + &force),
        ("Gyroscope.csv", own.to_owned() + &rate),
        (
            "Location.csv",
            format!("time,seconds_elapsed,speed,altitude,longitude,latitude\n{place}"),
        ),
    ]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("lap.zip");
    std::fs::write(&path, bytes).expect("written");
    let log = Location::from(path.clone());
    let aids = Aids::default();
    let seen = survey(&log, &aids).expect("read").expect("listed");
    let verdicts = by_motion(&log, &aids, &seen, None).expect("moves");
    let text = draft(&log, &seen, &verdicts);
    for entry in ["[channel.imu_rate_x]", "[channel.imu_force_z]", "[channel.satellite_speed]"] {
        assert!(text.contains(entry), "{text}");
    }
    let map = ChannelMap::parse(&text, "draft.toml").expect(&text);
    let levelled = |raw: Raw| ingest::run(raw, &ingest::Config::default()).expect("a session");
    let (phone, said) = levelled(ingest::read(&path, &[map]).expect("read"));
    assert!(said.iter().any(|w| w.code == "level_frame"), "{said:?}");
    // as the same lap is from the CSV of the box, whose map knows the lever arm and whose gyroscopes are in time
    let maps = [ChannelMap::read(&root().join("fixtures/loggers/phone.toml")).expect("bundled")];
    let (boxed, _) =
        levelled(ingest::read(root().join("fixtures/loggers/phone.csv"), &maps).expect("read"));
    for (channel, within) in [(Roll, 0.5_f64.to_radians()), (VelocityX, 0.2), (YawRate, 0.03)] {
        let (a, b) = (phone.get(channel).expect("levelled"), boxed.get(channel).expect("levelled"));
        let n = a.len().min(b.len());
        let squares: f64 =
            (25..n - 25).map(|i| (a[i] - b[i]).powi(2)).filter(|x| x.is_finite()).sum();
        let rms = (squares / n as f64).sqrt();
        println!("{channel}: rms {rms:.4}");
        assert!(rms < within, "{channel}: {rms}");
    }
}

fn packed(files: &[(&str, String)]) -> Vec<u8> {
    use std::io::Write as _;
    let mut out = Vec::new();
    let mut archive = rawzip::ZipArchiveWriter::new(&mut out);
    for (name, text) in files {
        let builder = archive.new_file(name).compression_method(rawzip::CompressionMethod::DEFLATE);
        let (mut entry, config) = builder.start().expect("in memory");
        let packing = flate2::write::DeflateEncoder::new(&mut entry, flate2::Compression::fast());
        let mut writer = config.wrap(packing);
        writer.write_all(text.as_bytes()).expect("in memory");
        let (packing, descriptor) = writer.finish().expect("in memory");
        packing.finish().expect("in memory");
        entry.finish(descriptor).expect("in memory");
    }
    archive.finish().expect("in memory");
    out
}
