//! Outputs that are not as they were written ([`roadbench::internals::batch::store::verify`]).

use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::kind;
use roadbench::internals::batch::store::verify::{FindingKind, mend, verify};
use roadbench::internals::report::Pages;

use crate::script::Place;

fn whole_run(place: &Place) {
    place.run();
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    run::finish(&store, Pages::Auto, |_| Ok(())).expect("fleet and report");
}

fn found(place: &Place) -> Vec<(FindingKind, String)> {
    let done = verify(&place.path("out").into(), true).expect("verified");
    assert_eq!(done.unlisted, 0);
    done.findings.into_iter().map(|f| (f.wrong, f.place)).collect()
}

fn flip(place: &Place, file: &str) {
    let path = place.path(file);
    let mut bytes = std::fs::read(&path).expect("there");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&path, bytes).expect("written");
}

const LOGS: [(&str, &str); 4] =
    [("a", "s-a|b1|ok"), ("b", "s-b|b1|ok"), ("c", "s-c|b2|ok"), ("d", "s-d|b2|reject")];

#[test]
fn an_output_is_as_it_was_written_or_it_is_told_what_is_not() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    assert_eq!(found(&place), []);
    let whole = place.files("out");

    // one bit of every file in turn: reported for this file, and for no other
    let files: Vec<String> =
        place.names().into_iter().filter(|n| n.ends_with(".parquet")).collect();
    assert!(files.len() > 12, "{files:?}");
    for file in files.iter().filter(|f| !f.starts_with("rejected/")) {
        flip(&place, &format!("out/{file}"));
        let told = found(&place);
        assert!(told.contains(&(FindingKind::Changed, file.clone())), "{file}: {told:?}");
        assert!(
            told.iter().all(|(wrong, at)| at == file || *wrong != FindingKind::Changed),
            "{file}: {told:?}"
        );
        flip(&place, &format!("out/{file}"));
    }
    assert_eq!(found(&place), []);

    // a table that is damaged is removed, and its sessions are computed again
    flip(&place, "out/coefficients/bike=b1/2026-05.parquet");
    flip(&place, "out/fleet/fleet.parquet");
    let out = place.path("out").into();
    let mended = mend(&out, false).expect("mended");
    assert_eq!(mended.removed, ["coefficients/bike=b1/2026-05.parquet", "fleet/fleet.parquet"]);
    let again = place.run();
    assert_eq!((again.done, again.unchanged), (2, 1));
    whole_run(&place);
    assert_eq!(found(&place), []);
    assert!(place.files("out") == whole, "not as it was");

    // so is a month's commit markers
    flip(&place, "out/sessions/bike=b1/2026-05.parquet");
    mend(&out, false).expect("mended");
    whole_run(&place);
    assert!(place.files("out") == whole, "not as it was");
}

#[test]
fn what_is_gone_left_over_or_nobodys_is_told() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    std::fs::remove_file(place.path("out/evidence/bike=b1/2026-05.parquet")).expect("removed");
    std::fs::copy(
        place.path("out/plots/bike=b2/2026-05.parquet"),
        place.path("out/plots/bike=b2/2031-01.parquet"),
    )
    .expect("copied");
    place.put("out/coefficients/.roadbench-x.tmp", "half a file");
    std::fs::remove_file(place.path("logs/a.csv")).expect("removed");
    place.put("logs/c.csv", "s-c|b2|ok ");
    let done = verify(&place.path("out").into(), true).expect("verified");
    assert_eq!(done.unlisted, 1, "the copy");
    let mut told: Vec<(FindingKind, String)> =
        done.findings.into_iter().map(|f| (f.wrong, f.place)).collect();
    let log = |name: &str| place.path(name).to_string_lossy().into_owned();
    let mut expected = vec![
        (FindingKind::Missing, "evidence/bike=b1/2026-05.parquet".to_owned()),
        (FindingKind::Orphan, "plots/bike=b2/2031-01.parquet".to_owned()),
        (FindingKind::LeftOver, "coefficients/.roadbench-x.tmp".to_owned()),
        (FindingKind::LogMissing, log("logs/a.csv")),
        (FindingKind::LogChanged, log("logs/c.csv")),
    ];
    told.sort();
    expected.sort();
    assert_eq!(told, expected);
    let alone = verify(&place.path("out").into(), false).expect("verified");
    assert_eq!((alone.logs, alone.findings.len()), (0, 3));
}

/// A damaged table is not given up for nothing: sessions whose logs are gone cannot be computed again.
#[test]
fn mending_keeps_what_no_log_can_give_again() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    let [kept, gone] =
        ["coefficients/bike=b1/2026-05.parquet", "coefficients/bike=b2/2026-05.parquet"];
    flip(&place, &format!("out/{kept}"));
    flip(&place, &format!("out/{gone}"));
    std::fs::remove_file(place.path("logs/a.csv")).expect("removed");
    let out = place.path("out").into();
    let mended = mend(&out, false).expect("mended");
    assert_eq!(mended.removed, [gone]);
    let sessions = mended.kept.get(kept).map(|s| s.iter().map(String::as_str).collect::<Vec<_>>());
    assert_eq!(sessions, Some(vec!["s-a"]), "{:?}", mended.kept);
    // no run has made the other one again
    assert_eq!(mend(&out, true).expect("mended").removed, [kept]);
    let run = place.run();
    assert!(run.done >= 1, "{}", run.done);
    assert!(mend(&out, false).expect("mended").kept.is_empty());
    assert!(
        found(&place).iter().all(|(wrong, _)| *wrong == FindingKind::LogMissing),
        "{:?}",
        found(&place)
    );
}

/// A run does not spread what a bad disk made of a table.
#[test]
fn a_run_notices_a_table_that_is_not_as_it_was_written() {
    let place = Place::new(&LOGS);
    whole_run(&place);
    // bytes that still are a table: an older one of the same month
    let table = "out/coefficients/bike=b1/2026-05.parquet";
    let old = std::fs::read(place.path(table)).expect("there");
    place.put("logs/e.csv", "s-e|b1|ok");
    place.run();
    std::fs::write(place.path(table), old).expect("written");
    place.put("logs/f.csv", "s-f|b1|ok");
    let run = place.run();
    assert_eq!((run.done, run.rejected.len(), &run.damage), (4, 1, &None), "the month anew");
    assert_eq!(place.sessions(), ["b1/s-a", "b1/s-b", "b1/s-e", "b1/s-f", "b2/s-c"]);
    assert_eq!(place.run().unchanged, 5);
    whole_run(&place);
    assert_eq!(found(&place), []);
}

/// Two rides of a motorcycle, as the program writes them; again into the same folder.
fn two_rides(folder: &Path) -> PathBuf {
    let out = folder.join("out");
    let day = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let logs = day.join("sessions/bike=archive_01/date=2026-05-01");
    let mut command = Command::cargo_bin("roadbench").expect("built");
    command.arg("run").arg(logs).arg("--bikes").arg(day.join("bikes"));
    command.arg("--out").arg(&out).args(["--progress", "never"]).assert().success();
    out
}

/// What a command says, and its exit code.
fn said(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::cargo_bin("roadbench").expect("built");
    let output = command.args(arguments).output().expect("ran");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// No number of a damaged table goes to a person or a file: who reads it refuses, with the file and what to do, and the
/// report, which is made of the rest, says so by its exit code.
#[test]
fn no_command_gives_numbers_of_a_damaged_table() {
    let folder = tempfile::tempdir().expect("folder");
    let out = two_rides(folder.path());
    let text = out.to_string_lossy().into_owned();
    let id = "archive_s0001";
    let export = ["export", &text, "--session", id, "--format", "toml"];
    let compare = ["compare", &text, id, "archive_s0002"];
    let open = ["report", &text, "--open", id, "--no-browser"];
    let report = ["report", &text];
    let readers: [(&[&str], &[&str]); 4] = [
        (&export, &["sessions", "coefficients", "manoeuvres", "plots"]),
        (&compare, &["sessions", "coefficients", "evidence", "plots"]),
        (&open, &["sessions", "coefficients", "tyre_parameters", "plots"]),
        (&report, &["sessions", "coefficients", "tyre_parameters", "plots"]),
    ];
    for (command, tables) in readers {
        assert_eq!(said(command).0, Some(0), "{command:?}");
        for table in tables {
            let file = format!("{table}/bike=archive_01/2026-05.parquet");
            let whole = std::fs::read(out.join(&file)).expect(&file);
            let mut damaged = whole.clone();
            damaged[whole.len() / 2] ^= 1;
            std::fs::write(out.join(&file), damaged).expect("written");
            let (code, says) = said(command);
            assert_eq!(code, Some(3), "{command:?} {file}: {says}");
            assert!(says.contains(&file) && says.contains("roadbench verify"), "{says}");
            std::fs::remove_file(out.join(&file)).expect("removed");
            assert_eq!(said(command).0, Some(3), "{command:?} without {file}");
            std::fs::write(out.join(&file), whole).expect("written");
        }
        assert_eq!(said(command).0, Some(0), "{command:?}");
    }
    // the tables over all sessions are the report's alone
    let fleet = out.join("fleet/fleet.parquet");
    let mut bytes = std::fs::read(&fleet).expect("a table");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&fleet, bytes).expect("written");
    assert_eq!([&export[..], &compare].map(|command| said(command).0), [Some(0); 2]);
    let (code, says) = said(&report);
    assert!(code == Some(3) && says.contains("fleet/fleet.parquet"), "{says}");
}

/// A report that was made while a table was damaged does not outlive the damage, however the table is repaired: a run
/// that computes its sessions again, or a backup.
#[test]
fn a_report_of_damaged_tables_is_made_again_once_they_are_repaired() {
    let folder = tempfile::tempdir().expect("folder");
    let out = two_rides(folder.path());
    let pages = || -> Vec<String> {
        let page = |id| out.join(format!("report/{id}.html"));
        let read = |id| std::fs::read_to_string(page(id)).expect("a page");
        ["archive_s0001", "archive_s0002"].map(read).into()
    };
    let whole = pages();
    let file = out.join("coefficients/bike=archive_01/2026-05.parquet");
    let bytes = std::fs::read(&file).expect("a table");
    for from_backup in [false, true] {
        let mut damaged = bytes.clone();
        damaged[bytes.len() / 2] ^= 1;
        std::fs::write(&file, damaged).expect("written");
        assert_eq!(said(&["report", &out.to_string_lossy()]).0, Some(3));
        assert!(pages()[0].contains("0 of 0 coefficients determined"), "made without the table");
        if from_backup {
            std::fs::write(&file, &bytes).expect("written");
        }
        two_rides(folder.path());
        assert!(pages() == whole, "from a backup: {from_backup}");
    }
}
