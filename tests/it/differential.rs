//! `roadbench diagnose` on several rides of one motorcycle: each against its others.

use std::path::Path;
use std::process::Command;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::ingest::write_session;
use roadbench::internals::simulate::effects::{Effect, ModelError};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::multibody_ride::ridden;
use roadbench::internals::simulate::population::DrawnMachine;
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::ChangeRow;

use crate::shared::copy_folder;

/// A machine of the population, whose tyres and body are not those of our own simulator's scenarios.
const NUMBER: usize = 1;
const SEED: u64 = 21;

/// Writes the ride of a number into an archive.
fn ride(archive: &Path, ride: usize) {
    let (session, bike) = simulated(ride, None);
    put(archive, ride, &session, &bike);
}

fn put(archive: &Path, ride: usize, session: &Session, bike: &Bike) {
    for folder in ["sessions", "bikes"] {
        std::fs::create_dir_all(archive.join(folder)).expect("a folder");
    }
    write_session(archive.join(format!("sessions/ride_{ride}.parquet")), session, false)
        .expect("written");
    std::fs::write(archive.join("bikes/bike.toml"), bike.to_toml()).expect("written");
}

/// The ride of a number; an effect of a size may be in it.
fn simulated(ride: usize, hidden: Option<(&str, f64)>) -> (Session, Bike) {
    let plan = "naturalistic";
    let case = Case {
        seed: SEED,
        number: NUMBER,
        kind: Kind::Null,
        plan,
        hidden: vec![],
        foreign: None,
        odd: Vec::new(),
    };
    let (mut scenario, _) = case.machine().expect("a machine");
    scenario.seed = 7919 * (ride as u64 + 1) + 31 * SEED + NUMBER as u64;
    let mut error = ModelError::default();
    if let Some((name, size)) = hidden {
        (Effect::named(name).expect("an effect").set)(&mut error, size);
    }
    let machine = DrawnMachine::draw(SEED, NUMBER, 0).expect("a machine");
    let tour = machine.tour(&scenario, &error, BikeFile::Full).expect("a tour");
    let mut session = ridden(&tour, NUMBER).expect("a ride").session;
    session.meta.session_id = format!("ride_{ride}");
    session.meta.bike_id = "bike".to_owned();
    session.meta.start_time = Some(format!("2026-05-{:02}T10:00:00Z", ride + 1));
    (session, tour.bike)
}

fn diagnose(archive: &Path, out: &Path, nulls: &str) -> (String, Vec<ChangeRow>) {
    let done = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"))
        .arg("diagnose")
        .arg(archive)
        .arg("--out")
        .arg(out)
        .args(["--nulls", nulls])
        .output()
        .expect("roadbench starts");
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let rows = read::rows::<ChangeRow>(out).expect("changes");
    (String::from_utf8_lossy(&done.stdout).into_owned(), rows)
}

/// A steering zero of 5 mrad in the last of five rides; four alike say nothing. No fault-free simulation is needed for it.
#[test]
fn the_ride_that_differs_has_its_cause() {
    let folder = tempfile::tempdir().expect("a folder");
    let archive = folder.path().join("archive");
    let mut last = None;
    rayon::scope(|scope| {
        for k in 0..4 {
            let archive = &archive;
            scope.spawn(move |_| ride(archive, k));
        }
        scope.spawn(|_| last = Some(simulated(6, Some(("steer_zero", 0.005)))));
    });
    // what is diagnosed stays so (`diagnose_batch.rs`): only the last ride is left to do, twice
    let [out, json] = ["text", "json"].map(|name| folder.path().join(name));
    let (text, rows) = diagnose(&archive, &out, "0");
    assert!(text.starts_with("bike: 4 of 4 rides as before\nReport: "), "{text}");
    assert!(rows.iter().all(|r| r.verdict == "as_before"), "{rows:#?}");
    copy_folder(&out, &json);

    let (session, bike) = last.expect("ridden");
    put(&archive, 6, &session, &bike);
    let (text, rows) = diagnose(&archive, &out, "0");
    let changed: Vec<&ChangeRow> = rows.iter().filter(|r| r.verdict != "as_before").collect();
    let [row] = &changed[..] else { panic!("{text}{rows:#?}") };
    assert_eq!((row.ident.session_id.as_str(), row.verdict.as_str()), ("ride_6", "named"));
    assert_eq!(row.cause.as_deref(), Some("steer_zero"));
    let (low, high) = row.ci95_low.zip(row.ci95_high).expect("an interval");
    assert!(low < 0.005 && 0.005 < high && high - low < 0.006, "{low} to {high}");
    // what is new comes first; the rides of the nights before are not listed again
    let news = "1 ride diagnosed: 1 unlike the motorcycle's other rides\nNew since the last diagnosis:\n  bike, ride_6 \
                (2026-05-07): steer_zero";
    assert!(text.starts_with(news), "{text}");
    // one wording and one number in the terminal, the table and on the page
    let on_one_line = text.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(on_one_line.contains(&row.sentence), "{text}");
    news_outlasts_a_kill(&archive, [&json, &out]);
    let again = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"))
        .arg("diagnose")
        .arg(&archive)
        .arg("--out")
        .arg(&json)
        .args(["--nulls", "0", "--json"])
        .output()
        .expect("roadbench starts");
    let lines = String::from_utf8_lossy(&again.stdout);
    let lines = lines.lines().map(|l| serde_json::from_str(l).expect("JSON"));
    let lines: Vec<serde_json::Value> = lines.collect();
    assert_eq!(
        lines.last().map(|l| (&l["table"], &l["changes_new"])),
        Some((&"summary".into(), &1.into()))
    );
    let lines: Vec<_> = lines.into_iter().filter(|l| l["table"] == "changes").collect();
    let named: Vec<_> = lines.iter().filter(|l| l["cause"] == "steer_zero").collect();
    assert!(lines.len() >= 5 && named.len() == 1, "{lines:?}");
    assert_eq!((&named[0]["session_id"], &named[0]["new"]), (&"ride_6".into(), &true.into()));
    // a night without a new log says so, to programs too
    let [text, lines] = [&[][..], &["--json"][..]].map(|more| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"));
        command.arg("diagnose").arg(&archive).arg("--out").arg(&json).args(["--nulls", "0"]);
        let done = command.args(more).output().expect("roadbench starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8_lossy(&done.stdout).into_owned()
    });
    assert!(text.starts_with("5 logs, nothing has changed in "), "{text}");
    let rows = lines.lines().map(|l| serde_json::from_str(l).expect("JSON"));
    let rows: Vec<serde_json::Value> = rows.collect();
    let show = |more: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"));
        let done = command.arg("show").arg(&json).args(more).output().expect("roadbench starts");
        String::from_utf8_lossy(&done.stdout).into_owned()
    };
    assert!(
        show(&[]).starts_with("bike: 4 of 5 rides as before\n  ride_6 (2026-05-07): steer_zero")
    );
    assert!(show(&["--session", "ride_6"]).starts_with("ride_6  bike\nsteer_zero differs by"));
    let (last, rows) = rows.split_last().expect("a summary");
    let counts =
        ["diagnosed", "unchanged", "changes_new", "changes_standing"].map(|key| last[key].as_u64());
    assert_eq!(counts, [0, 5, 0, 1].map(Some), "{lines}");
    assert!(rows.len() == 5 && rows.iter().all(|r| r["new"] == false), "{lines}");
    let page = std::fs::read_to_string(out.join("report/index.html")).expect("a page");
    assert!(page.contains("4 of 5 rides as before"), "the page says nothing of the change");
}

/// A night that is killed between the tables of sessions and `changes`: `show` makes `changes` again, and the next diagnosis
/// reports what is new all the same. The outputs are those before and after a night with a new change, both printed.
fn news_outlasts_a_kill(archive: &Path, [before, after]: [&Path; 2]) {
    let killed = before.with_file_name("killed");
    copy_folder(after, &killed);
    let [kept, changes] = [".roadbench/changes.printed", "changes/changes.parquet"];
    assert!(!killed.join(kept).exists(), "the night was printed");
    std::fs::copy(before.join(changes), killed.join(changes)).expect("copied");
    for mark in [".roadbench/behind_diagnose", ".roadbench/switched_diagnose"] {
        std::fs::write(killed.join(mark), "").expect("marked");
    }
    let roadbench = |arguments: &[&str]| {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"));
        let done = command.args(arguments).output().expect("roadbench starts");
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        String::from_utf8_lossy(&done.stdout).into_owned()
    };
    let [input, output] = [archive, &killed].map(|path| path.to_str().expect("a path in UTF-8"));
    roadbench(&["show", output]);
    let rows = read::rows::<ChangeRow>(&killed).expect("changes");
    assert!(rows.iter().any(|row| row.cause.as_deref() == Some("steer_zero")), "made again");
    assert!(killed.join(kept).exists());
    roadbench(&["verify", output]);
    let arguments = ["diagnose", input, "--out", output, "--nulls", "0", "--json"];
    // once it is printed it stands; the summary is last beside a comparison, too
    for (more, expected) in [(&["--against", "..2026-05-04"][..], [1, 0]), (&[], [0, 1])] {
        let lines = roadbench(&[&arguments[..], more].concat());
        let last: serde_json::Value =
            lines.lines().last().and_then(|l| serde_json::from_str(l).ok()).expect("a summary");
        assert_eq!(last["table"], "summary", "{lines}");
        let counts = ["changes_new", "changes_standing"].map(|key| last[key].as_u64());
        assert_eq!(counts, expected.map(Some), "{lines}");
        assert!(!killed.join(kept).exists(), "kept no longer than needed");
    }
}

/// Three of seven fault-free rides of a simulator that is not ours never brake: what they do not determine is no difference.
#[test]
fn rides_without_braking_do_not_differ_in_friction() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    if !data.join("independent_plant").is_dir() {
        println!("not run: there are no recordings in ../shared/data");
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let archive = folder.path().join("archive");
    let rides = [("independent_plant", 1..=4), ("independent_plant_transients", 5..=7)];
    for (set, numbers) in rides {
        for number in numbers {
            let of_ride = data.join(set).join(format!("{number:02}"));
            for part in ["bikes", "sessions"] {
                let to = archive.join(part);
                std::fs::create_dir_all(&to).expect("a folder");
                for entry in std::fs::read_dir(of_ride.join(part)).expect("a folder") {
                    let entry = entry.expect("a file");
                    std::fs::copy(entry.path(), to.join(entry.file_name())).expect("copied");
                }
            }
        }
    }
    let (text, rows) = diagnose(&archive, &folder.path().join("out"), "0");
    let changed: Vec<&ChangeRow> = rows.iter().filter(|r| r.verdict != "as_before").collect();
    assert!(changed.is_empty() && text.contains("7 of 7 rides as before"), "{text}{changed:#?}");
}
