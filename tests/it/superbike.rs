//! A superbike's bus log, as its owner has it: from the foreign file to coefficients.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Coefficient, Rejected, Status};

/// The fixture's folder.
fn fixture() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/loggers")
}

fn truth(file: &str) -> toml::Table {
    fs::read_to_string(fixture().join(file)).expect("truth").parse().expect("TOML")
}

fn pair(truth: &toml::Table, key: &str) -> [f64; 2] {
    [0, 1].map(|k| truth[key][k].as_float().expect("a number"))
}

/// The drafted map; only what no log says is filled in: with which radius wheel speeds in km/h were computed.
pub fn drafted() -> String {
    let log = fixture().join("superbike.csv");
    let output = Command::cargo_bin("roadbench")
        .expect("built")
        .args(["inspect", "--propose"])
        .arg(log)
        .output()
        .expect("ran");
    let mut draft = String::from_utf8(output.stdout).expect("text");
    let circumference = pair(&truth("superbike_truth.toml"), "circumference");
    for (wheel, circumference) in ["front", "rear"].into_iter().zip(circumference) {
        let begin = draft.find(&format!("# [channel.wheel_speed_{wheel}]")).expect("drafted");
        let end = begin + draft[begin..].find("\n\n").expect("an entry ends");
        let entry = draft[begin..end].replace("\n# ", "\n").replacen("# ", "", 1);
        let radius = format!("radius = {:.4}", circumference / std::f64::consts::TAU);
        // this logger's radius is known exactly
        let lines = entry.lines().filter(|l| !l.starts_with("radius_sd"));
        let entry = lines.map(|l| if l.starts_with("radius") { &radius } else { l });
        let entry: Vec<&str> = entry.collect();
        draft.replace_range(begin..end, &entry.join("\n"));
    }
    draft
}

#[test]
fn its_log_gives_radii_slip_stiffnesses_and_crowns() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    fs::create_dir_all(at("rides/sessions")).expect("made");
    fs::create_dir_all(at("rides/bikes")).expect("made");
    fs::copy(fixture().join("superbike.csv"), at("rides/sessions/superbike.csv")).expect("copied");
    fs::copy(fixture().join("bike.toml"), at("rides/bikes/superbike.toml")).expect("copied");
    let draft = drafted().replace("[meta]", "[meta]\nbike_id = \"superbike\"");
    fs::write(at("map.toml"), draft).expect("written");
    let mut run = Command::cargo_bin("roadbench").expect("built");
    run.arg("run").arg(at("rides")).arg("--map").arg(at("map.toml"));
    run.arg("--out").arg(at("out")).assert().success();
    let out = at("out");
    let rejected: Vec<Rejected> = read::rows(&out).expect("a table");
    assert!(rejected.is_empty(), "{}", rejected[0].message);
    let rows: Vec<Coefficient> = read::rows(&out).expect("a table");
    let row = |tyre: &str, name: &str| -> &Coefficient {
        let own = |c: &&Coefficient| c.tyre == tyre && c.coefficient == name;
        rows.iter().find(own).unwrap_or_else(|| panic!("{tyre} {name}"))
    };
    let ride = truth("ride_truth.toml");
    for (name, truth) in [
        ("slip_stiffness", pair(&ride, "slip_stiffness")),
        ("overturning_stiffness", pair(&ride, "crown_radius")),
    ] {
        for (tyre, truth) in ["front", "rear"].into_iter().zip(truth) {
            let c = row(tyre, name);
            assert_eq!(c.status, Status::Ok, "{tyre} {name}: {:?}", c.reason);
            let [low, high] = [c.ci95_low, c.ci95_high].map(|x| x.expect("an interval"));
            assert!((low..=high).contains(&truth), "{tyre} {name}: {truth} in {low} to {high}");
        }
    }
    for tyre in ["front", "rear"] {
        assert_eq!(row(tyre, "effective_rolling_radius").status, Status::Ok);
        // never at its limit: a bound, and no value
        let peak = row(tyre, "mf_d");
        assert_eq!((peak.status, peak.value), (Status::LowerBound, None), "{tyre}: {peak:?}");
        assert!(peak.ci95_low.is_some_and(|low| (0.4..1.2).contains(&low)), "{:?}", peak.ci95_low);
    }
    // lean, speed and course alone
    for tyre in ["front", "rear"] {
        let c = row(tyre, "lateral_friction_ct");
        assert_eq!(c.status, Status::Ok, "{tyre}: {:?}", c.reason);
        assert!(c.value.is_some_and(|ct| (-1.0..-0.7).contains(&ct)), "{tyre}: {:?}", c.value);
        // what it cannot carry
        let reason = row(tyre, "cornering_stiffness_0").reason.clone().unwrap_or_default();
        assert!(reason.contains("no channels velocity_y, yaw_rate, steer_angle"), "{reason}");
    }
}
