//! Channels recognised by the motion, not by names alone: a small version of the study
//! `examples/channels`.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::map_for;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::maps::propose::compare::compare;

#[path = "../../examples/channels/truth.rs"]
pub mod truth;

use truth::{Planted, check, judged, map_text, planted, score};

const LOGS: [(&str, &str); 4] = [
    ("superbike", "superbike.csv"),
    ("factory", "factory.csv"),
    ("phone", "phone.csv"),
    ("satellite", "satellite.vbo"),
];

fn fixture(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers").join(file)
}

fn circumference(profile: &str) -> [f64; 2] {
    let text = std::fs::read_to_string(fixture(&format!("{profile}_truth.toml"))).expect("truth");
    let truth: toml::Table = text.parse().expect("TOML");
    [0, 1].map(|k| truth["circumference"][k].as_float().expect("a number"))
}

#[test]
fn every_channel_of_every_logger_is_mapped_rightly_and_nothing_else() {
    for (profile, file) in LOGS {
        let judged = judged(&fixture(file));
        let found = score(&judged, profile);
        assert_eq!(found.wrong, Vec::<String>::new(), "{profile}");
        // without wheels a throttle's delay may not show: then it is not in force, and says so
        let untimed = judged.verdicts.entries.iter().any(|e| e.untimed());
        assert!(!untimed || profile == "satellite", "{profile}");
        let missing: &[&str] = if untimed { &["throttle <- throttle"] } else { &[] };
        assert_eq!(found.missing, missing, "{profile}");
        assert_eq!(found.right + missing.len(), found.expected, "{profile}");
    }
}

#[test]
fn a_right_map_is_not_objected_to_and_planted_errors_are_named_and_mended() {
    for (profile, file) in LOGS {
        let (judged, circumference) = (judged(&fixture(file)), circumference(profile));
        let right = check(&judged, profile, circumference, None);
        assert_eq!(right.false_alarms, 0, "{profile}");
        for error in planted(profile) {
            let seen = check(&judged, profile, circumference, Some(error));
            assert!(
                seen.found && seen.named && seen.mended && seen.false_alarms == 0,
                "{profile}: {error:?}: {seen:?}"
            );
        }
    }
}

/// Of a box that is strapped on any way round the six channels go to the smoother, whatever its unit says.
#[test]
fn an_inertial_unit_that_is_not_level_is_drafted_for_the_smoother() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("box.csv");
    let text = std::fs::read_to_string(fixture("phone.csv")).expect("bundled");
    std::fs::write(&path, &text).expect("written");
    let found = judged(&path);
    let map = ChannelMap::parse(&found.draft, "draft").expect(&found.draft);
    let entry = |c: Channel| map.entries.iter().find(|e| e.channel == c);
    use Channel::*;
    let six = [ImuRateX, ImuRateY, ImuRateZ, ImuForceX, ImuForceY, ImuForceZ];
    assert!(six.iter().all(|c| entry(*c).is_some()), "{}", found.draft);
    assert!(entry(SatelliteSpeed).is_some() && entry(VelocityX).is_none(), "{}", found.draft);
    assert!(found.draft.contains("\n[imu]\n"), "{}", found.draft);
    // one axis less is no unit
    std::fs::write(&path, text.replacen("GyroZ", "Spare", 1)).expect("written");
    let found = judged(&path);
    assert!(!found.draft.contains("[imu]"), "{}", found.draft);
    assert!(found.draft.contains("\n[channel.velocity_x]"), "{}", found.draft);
}

/// Names that say nothing: the motion alone finds what it can.
#[test]
fn a_speed_is_found_whatever_it_is_called() {
    let text = std::fs::read_to_string(fixture("superbike.csv")).expect("bundled");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("unnamed.csv");
    std::fs::write(&path, text.replacen("GPS Speed (km/h)", "Kanal 7", 1)).expect("written");
    let judged = judged(&path);
    let speed = judged.verdicts.sure(Channel::VelocityX).expect("found");
    assert_eq!(judged.listing.channels[speed.source].name, "Kanal 7");
    assert_eq!(speed.unit, "km/h");
    // a log whose units lie: what is said to be m/s is km/h
    std::fs::write(&path, text.replacen("GPS Speed (km/h)", "GPS Speed (m/s)", 1))
        .expect("written");
    let judged = truth::judged(&path);
    let speed = judged.verdicts.sure(Channel::VelocityX).expect("found");
    assert_eq!(speed.unit, "km/h");
    assert!(speed.why.iter().any(|w| w.contains("the log says m/s")), "{:?}", speed.why);
}

/// A log with channels under other names, their numbers multiplied.
fn relabelled(text: &str, channels: &[(&str, String, f64)]) -> String {
    let mut lines = text.lines().map(|l| l.split(',').map(str::to_owned).collect::<Vec<_>>());
    let mut header = lines.next().expect("a header");
    let place = |name: &str| header.iter().position(|c| c == name).expect("a channel");
    let places: Vec<usize> = channels.iter().map(|c| place(c.0)).collect();
    for (place, (_, name, _)) in places.iter().zip(channels) {
        header[*place].clone_from(name);
    }
    let mut out = header.join(",") + "\n";
    for mut cells in lines {
        for (place, (_, _, factor)) in places.iter().zip(channels) {
            let x: f64 = cells[*place].parse().expect("a number");
            cells[*place] = format!("{:.3}", factor * x);
        }
        out += &(cells.join(",") + "\n");
    }
    out
}

fn superbike() -> String {
    std::fs::read_to_string(fixture("superbike.csv")).expect("bundled")
}

/// A radius that a wheel can have proves no unit: some number of teeth gives any of them.
#[test]
fn pulses_of_a_wheel_are_a_guess_until_their_number_is_known() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("pulses.csv");
    let [front, rear] = circumference("superbike");
    let pulses = |metres: f64| 54.0 / 3.6 / metres;
    for unit in [" (Hz)", ""] {
        let text = relabelled(
            &superbike(),
            &[
                ("Wheel Speed F (km/h)", format!("Wheel Speed F{unit}"), pulses(front)),
                ("Wheel Speed R (km/h)", format!("Wheel Speed R{unit}"), pulses(rear)),
            ],
        );
        std::fs::write(&path, text).expect("written");
        let judged = judged(&path);
        for wheel in [Channel::WheelSpeedFront, Channel::WheelSpeedRear] {
            assert!(judged.verdicts.sure(wheel).is_none(), "{unit}: {}", judged.draft);
            let all = &judged.verdicts.entries;
            let guess = all.iter().find(|e| e.channel == wheel).expect("a guess");
            let doubt = guess.doubt.clone().expect("a doubt");
            assert!(doubt.contains("as `ratio`") && doubt.contains("about 5"), "{doubt}");
        }
        // with the number of teeth it is right, and nobody objects
        let map = format!(
            "name = \"m\"\nformat = \"csv\"\n[time]\ncolumn = \"Time (ms)\"\nunit = \"ms\"\n[channel.wheel_speed_front]\n\
             from = \"Wheel Speed F{unit}\"\nunit = \"Hz\"\nratio = 54\n"
        );
        let map = ChannelMap::parse(&map, "m").expect(&map);
        let fitted = map_for(&judged.log, &[map]).expect("fits").expect("needs one");
        let found = compare(&fitted, &judged.listing, &judged.verdicts);
        assert!(found.findings.is_empty(), "{unit}: {:?}", found.findings);
    }
}

/// The path tells the delay of a yaw angle badly: it is not passed on to the gyroscope, nor is the receiver's to it.
#[test]
fn a_yaw_angle_makes_no_delay() {
    let text = superbike();
    let mut lines = text.lines();
    let header = lines.next().expect("a header");
    let place = header.split(',').position(|c| c == "Course (deg)").expect("a course");
    let rows: Vec<&str> = lines.collect();
    let mut course: Vec<f64> = Vec::new();
    for row in &rows {
        let x: f64 = row.split(',').nth(place).and_then(|c| c.parse().ok()).expect("a number");
        let last = course.last().copied().unwrap_or(x);
        course.push(last + (x - last + 180.0).rem_euclid(360.0) - 180.0);
    }
    // 0.1 s behind the wheels: half of the receiver's delay
    let at = |i: usize| course[i.min(course.len() - 1)];
    let mut out = header.replace("Course (deg)", "Course error (deg)")
        + ",Yaw angle (deg),Yaw Rate (deg/s)\n";
    for (i, row) in rows.iter().enumerate() {
        out += &format!("{row},{:.2},{:.3}\n", -at(i + 1), (at(i) - at(i + 2)) / 0.2);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("yaw.csv");
    std::fs::write(&path, out).expect("written");
    let judged = judged(&path);
    for channel in [Channel::Yaw, Channel::YawRate, Channel::Roll] {
        let entry = judged.verdicts.sure(channel).unwrap_or_else(|| panic!("{}", judged.draft));
        assert_eq!(entry.delay, 0.0, "{channel}: {}", judged.draft);
    }
}

/// A declared pressure that no brake of a motorcycle has is a guess; a map with it is mended and says so.
#[test]
fn a_pressure_in_another_unit_than_the_log_says_is_no_entry_in_force() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let psi = |text: &str| {
        text.replace("Brake F (bar)", "Brake F (psi)").replace("Brake R (bar)", "Brake R (psi)")
    };
    std::fs::write(at("psi.csv"), psi(&superbike())).expect("written");
    let judged = judged(Path::new(&at("psi.csv")));
    for brake in [Channel::BrakePressureFront, Channel::BrakePressureRear] {
        assert!(judged.verdicts.sure(brake).is_none(), "{}", judged.draft);
        let guess = judged.verdicts.entries.iter().find(|e| e.channel == brake).expect("a guess");
        assert_eq!(guess.unit, "bar", "{}", judged.draft);
    }
    let map = map_text("superbike", circumference("superbike"), None);
    let map = psi(&map).replace("unit = \"bar\"", "unit = \"psi\" # as its header says");
    std::fs::write(at("psi.toml"), map).expect("written");
    let run = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("roadbench").expect("built");
        let output = command.arg("map").arg(at("psi.csv")).args(arguments).output().expect("ran");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, out, err) = run(&["--map", &at("psi.toml")]);
    assert_eq!(code, Some(1), "{out}{err}");
    assert!(out.contains("brake_pressure_front: wrong unit"), "{out}");
    assert!(err.contains("--mend corrects"), "{err}");
    let (code, out, err) = run(&["--map", &at("psi.toml"), "--mend", "--out", &at("mended.toml")]);
    assert_eq!(code, Some(0), "{out}{err}");
    let mended = std::fs::read_to_string(at("mended.toml")).expect("written");
    assert!(mended.contains("unit = \"bar\" # as its header says"), "{mended}");
    assert!(mended.contains("file_unit = \"psi\""), "{mended}");
    let (code, out, err) = run(&["--map", &at("mended.toml")]);
    assert_eq!(code, Some(0), "{out}{err}");
}

/// Names that say nothing are no contradiction: the motion is asked about what the map makes of them.
#[test]
fn a_right_map_of_names_that_say_nothing_stays_as_it_is() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name).display().to_string();
    let names = [
        ("Wheel Speed F (km/h)", "qf (km/h)"),
        ("Wheel Speed R (km/h)", "qr (km/h)"),
        ("Brake F (bar)", "qa (bar)"),
        ("Brake R (bar)", "qb (bar)"),
    ];
    let new: Vec<(&str, String, f64)> = names.iter().map(|(a, b)| (*a, (*b).into(), 1.0)).collect();
    std::fs::write(at("q.csv"), relabelled(&superbike(), &new)).expect("written");
    let text = |planted: Option<Planted>| {
        let text = map_text("superbike", circumference("superbike"), planted);
        names.iter().fold(text, |t, (a, b)| t.replace(a, b))
    };
    let mend = |text: &str| {
        std::fs::write(at("q.toml"), text).expect("written");
        let mut command = Command::cargo_bin("roadbench").expect("built");
        command.args([
            "map",
            &at("q.csv"),
            "--map",
            &at("q.toml"),
            "--mend",
            "--out",
            &at("m.toml"),
        ]);
        let output = command.output().expect("ran");
        let said = String::from_utf8_lossy(&output.stderr).into_owned()
            + &String::from_utf8_lossy(&output.stdout);
        (output.status.code(), said, std::fs::read_to_string(at("m.toml")).expect("written"))
    };
    let right = text(None);
    let (code, said, mended) = mend(&right);
    assert_eq!(mended, right, "{said}");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("0 entries corrected"), "{said}");
    // the motion knows them all the same
    let swapped = Planted::Swapped(Channel::WheelSpeedFront, Channel::WheelSpeedRear);
    let (_, said, mended) = mend(&text(Some(swapped)));
    assert!(said.contains("2 entries corrected"), "{said}");
    assert!(mended.contains("from = \"qf (km/h)\""), "{mended}");
}

/// A map with which a run rejects the log does not agree with it.
#[test]
fn a_map_that_no_run_can_read_the_log_with_is_not_right() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ms.toml");
    let text = map_text("factory", circumference("factory"), None);
    std::fs::write(&path, text.replacen("unit = \"s\"", "unit = \"ms\"", 1)).expect("written");
    let mut command = Command::cargo_bin("roadbench").expect("built");
    let output = command.arg("map").arg(fixture("factory.csv")).arg("--map").arg(&path);
    let output = output.output().expect("ran");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("a run rejects the log with this map"), "{said}");
}

#[test]
fn the_command_drafts_checks_and_mends() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    let run = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("roadbench").expect("built");
        let log = fixture("superbike.csv");
        let output = command.arg("map").arg(log).args(arguments).output().expect("ran");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let bike = fixture("bike.toml").display().to_string();
    let (code, draft, err) = run(&["--bike", &bike]);
    assert_eq!(code, Some(0), "{err}");
    ChannelMap::parse(&draft, "draft").expect(&draft);
    for words in [
        "[channel.wheel_speed_front]",
        "sign = -1",
        "delay = ",
        "it is `Wheel Speed F (km/h)` again",
    ] {
        assert!(draft.contains(words), "{words} is not in\n{draft}");
    }
    let (_, without, _) = run(&[]);
    assert!(
        without.contains("# [channel.wheel_speed_front]") && without.contains("which radius"),
        "{without}"
    );

    let (wrong, mended) = (at("wrong.toml"), at("mended.toml"));
    let text =
        map_text("superbike", circumference("superbike"), Some(Planted::Sign(Channel::Roll)));
    std::fs::write(&wrong, &text).expect("written");
    let (wrong, mended) = (wrong.display().to_string(), mended.display().to_string());
    let (code, out, err) = run(&["--map", &wrong]);
    assert_eq!(code, Some(1), "{out}{err}");
    assert!(out.contains("roll: wrong sign") && err.contains("--mend"), "{out}{err}");
    let (code, _, err) = run(&["--map", &wrong, "--mend", "--out", &mended]);
    assert_eq!(code, Some(0), "{err}");
    let (code, out, err) = run(&["--map", &mended]);
    assert_eq!(code, Some(0), "{out}{err}");
}

/// Real recordings of other vehicles: nothing in force that is not so.
#[test]
fn real_recordings_give_no_wrong_map() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if !data.exists() {
        println!("no recordings in {}: nothing tested", data.display());
        return;
    }
    use Channel::*;
    for (file, right) in [
        (
            "racechrono_car/session_20251231_111318_tianma_lap9_v3.csv",
            &[
                (VelocityX, "gps/speed"),
                (AccelerationX, "calc/longitudinal_acc"),
                (AccelerationY, "calc/lateral_acc"),
                (Yaw, "gps/bearing"),
                (Latitude, "gps/latitude"),
                (Longitude, "gps/longitude"),
                (Altitude, "gps/altitude"),
                (LapNumber, "lap_number"),
            ][..],
        ),
        (
            "indy_av21_car/Putnam_park2023_run4_2.csv",
            &[(VelocityX, "vx(m/s)"), (Throttle, "throttle_ped_cmd(%)")],
        ),
    ] {
        let judged = judged(&data.join(file));
        for e in judged.verdicts.entries.iter().filter(|e| e.doubt.is_none()) {
            let from = judged.listing.channels[e.source].full();
            let known = right.iter().any(|(c, f)| *c == e.channel && *f == from);
            assert!(known, "{file}: {} <- {from}", e.channel);
        }
    }
}
