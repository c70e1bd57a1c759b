//! Real recordings, end to end: what their channels allow comes out plausible, what they do not
//! allow is said, and nothing that calls itself `ok` is out of what such a vehicle can have.
//!
//! The recordings are not part of the repository; without them the test says so and passes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use assert_cmd::Command;
use roadbench::internals::batch::jobs::run::RunWork;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Maps, Settings};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::report::tables;
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::rows::{Coefficient, Status};

const LOGS: [&str; 7] = [
    "emoto_kiro/KIRO_4.txt",
    "emoto_kiro/Primeira_Saida.txt",
    "indy_av21_car/LVMS_23_01_04_B.csv",
    "indy_av21_car/Putnam_park2023_run4_2.csv",
    "tudelft_sbw_bicycle/eigen_normal_sil6.5n2_5.4kph.log",
    "tudelft_sbw_bicycle/sil_avg_5.log",
    "tudelft_sbw_bicycle/simple_test_model_matching_off.log",
];

/// The recordings, or nothing and a note.
fn logs() -> Option<Vec<PathBuf>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    let logs: Vec<PathBuf> = LOGS.iter().map(|l| data.join(l)).collect();
    if logs.iter().all(|l| l.exists()) {
        return Some(logs);
    }
    println!("no recordings in {}: nothing tested", data.display());
    None
}

fn bikes() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/bikes")
}

/// Runs logs; session, tyre, coefficient to row.
fn run(logs: &[PathBuf], out: &Path) -> BTreeMap<(String, String, String), Coefficient> {
    let inputs: Vec<Location> = logs.iter().map(Location::from).collect();
    let settings = Settings {
        inputs: &inputs,
        bikes: Some(&bikes().into()),
        out: &out.into(),
        pipeline: &Pipeline::onroad(),
        maps: &Maps::default(),
        jobs: 2,
        force: false,
        since: None,
    };
    let stop = AtomicBool::new(false);
    let (run, store) = engine::run(&settings, &RunWork::default(), &(), &stop).expect("run");
    drop(store);
    assert!(run.rejected.is_empty(), "{:?}", run.rejected);
    assert_eq!(run.sessions.len(), logs.len());
    roadbench::internals::report::write(out).expect("report");
    let rows = tables::coefficients(out).expect("coefficients").into_iter();
    rows.map(|c| ((c.ident.session_id.clone(), c.tyre.clone(), c.coefficient.clone()), c)).collect()
}

/// What no tyre or vehicle of these has: a wide range of the literature's for rubber on asphalt.
fn physical(coefficient: &str) -> Option<[f64; 2]> {
    Some(match coefficient {
        "effective_rolling_radius" => [0.25, 0.36],
        "mf_d" => [0.6, 2.0],
        "peak_slip" => [0.03, 0.4],
        "drag" => [0.05, 1.5],
        "rolling_resistance" => [0.002, 0.05],
        _ => return None,
    })
}

#[test]
fn recordings_give_what_their_channels_allow() {
    let Some(logs) = logs() else { return };
    let folder = tempfile::tempdir().expect("folder");
    let rows = run(&logs, &folder.path().join("out"));
    let row = |session: &str, tyre: &str, name: &str| {
        &rows[&(session.to_owned(), tyre.to_owned(), name.to_owned())]
    };

    for c in rows.values().filter(|c| c.status == Status::Ok) {
        let value = c.value.expect("an ok coefficient has a value");
        let within =
            physical(&c.coefficient).is_none_or(|[low, high]| (low..high).contains(&value));
        assert!(within, "{} {} {} = {value}", c.ident.session_id, c.tyre, c.coefficient);
    }

    // tyre radius over gear ratio, GPS against motor speed over the whole ride: 0.0537 m, its
    // median absolute deviation 4.3 % (SOURCE.txt of the recording); the map's ratio is 5.4
    let kiro = row("Primeira_Saida", "rear", "effective_rolling_radius");
    if let Some(value) = kiro.value {
        let radius = value / 5.4;
        assert!((radius / 0.0537 - 1.0).abs() < 0.043, "{radius} m per turn of the motor");
    }

    // the ECU's wheel speed over the velocity has medians of 1.000 to 1.013 (LVMS) and 1.010 to
    // 1.015 (Putnam) in SOURCE.txt, taken with 0.30 m. The undriven front wheels show it under
    // gentle power; the driven rear ones have no coasting in neutral, and what a ride in gear tells
    // is enough at Putnam only
    for (session, low, high) in
        [("LVMS_23_01_04_B", 1.000, 1.013), ("Putnam_park2023_run4_2", 1.010, 1.016)]
    {
        let front = row(session, "front", "effective_rolling_radius");
        assert_eq!(front.status, Status::Ok, "{session}");
        let radius = front.value.expect("a value");
        assert!((0.30 / high..0.30 / low).contains(&radius), "{session}: {radius} m");
        let rear = row(session, "rear", "effective_rolling_radius");
        assert_eq!(rear.status == Status::Ok, session.starts_with("Putnam"), "{session}");
        if let (Status::Ok, Some(radius)) = (rear.status, rear.value) {
            assert!((0.30 / high..0.30 / low).contains(&radius), "{session}: rear {radius} m");
        }
    }

    for (session, tyre, name, channel) in [
        ("KIRO_4", "front", "effective_rolling_radius", "wheel_speed_front"),
        ("KIRO_4", "rear", "cornering_stiffness_0", "roll"),
        ("Putnam_park2023_run4_2", "front", "slip_camber_c1", "roll"),
        ("Putnam_park2023_run4_2", "vehicle", "overturning_stiffness", "roll"),
        ("sil_avg_5", "rear", "mf_d", "wheel_speed_rear"),
        ("sil_avg_5", "front", "slip_camber_c1", "yaw_rate"),
    ] {
        let c = row(session, tyre, name);
        assert_eq!((c.status, c.value), (Status::NotAvailable, None), "{session} {tyre} {name}");
        let reason = c.reason.as_deref().unwrap_or_default();
        assert!(reason.contains(channel), "{session} {tyre} {name}: {reason}");
    }
    // a treadmill and one wheel speed: nothing of a tyre is in it
    let bicycle = rows.values().filter(|c| c.ident.bike_id == "tudelft_sbw");
    assert_eq!(bicycle.filter(|c| c.status == Status::Ok).count(), 0);
}

#[test]
fn a_converted_recording_gives_the_same_numbers() {
    let Some(logs) = logs() else { return };
    let folder = tempfile::tempdir().expect("folder");
    let path = |name: &str| folder.path().join(name);
    let log = &logs[1];
    let converted = path("Primeira_Saida.parquet");
    let roadbench = |arguments: &[&Path]| {
        Command::cargo_bin("roadbench").expect("binary").args(arguments).assert().success()
    };
    roadbench(&["convert".as_ref(), log, "--out".as_ref(), &converted]);
    let said = roadbench(&["inspect".as_ref(), log, "--bikes".as_ref(), &bikes()]);
    let text = String::from_utf8(said.get_output().stdout.clone()).expect("text");
    assert!(text.contains("missing: wheel_speed_front"), "{text}");
    let a = run(std::slice::from_ref(log), &path("a"));
    let b = run(std::slice::from_ref(&converted), &path("b"));
    assert_eq!(a.len(), b.len());
    for (key, a) in &a {
        let b = &b[key];
        assert_eq!((a.status, a.value, a.std_error), (b.status, b.value, b.std_error), "{key:?}");
    }
}

/// The suspension log: samples, rate and extent as unpacked apart, by Python's `struct`.
#[test]
fn a_suspension_log_is_listed_as_it_was_recorded() {
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/suspension_sst/00647.SST");
    if !log.exists() {
        println!("no {}: nothing tested", log.display());
        return;
    }
    let seen = roadbench::internals::ingest::formats::survey::survey(&log, &Default::default())
        .expect("read")
        .expect("listed");
    let names: Vec<&str> = seen.listing.channels.iter().map(|c| c.name.as_str()).collect();
    assert_eq!((seen.format, &names[..]), ("sst", &["fork", "shock"][..]));
    assert_eq!(seen.listing.meta.start_time.as_deref(), Some("2023-07-07T17:11:40Z"));
    for (contents, range) in seen.contents.iter().zip([(1.0, 417.0), (0.0, 366.0)]) {
        assert_eq!(contents.samples, 54_035);
        assert!((contents.rate.expect("a rate") - 1000.0).abs() < 1e-6);
        let [least, _, largest] = contents.extent.expect("numbers");
        assert_eq!((least, largest), range);
    }
}
