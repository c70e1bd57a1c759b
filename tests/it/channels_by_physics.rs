//! Channels told by what motion demands of them, not by names alone: a small version of the study
//! `examples/channels`.

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::maps::ChannelMap;

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
