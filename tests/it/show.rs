//! `roadbench show`: what `run` printed of a session, read back, and the list of an output.

use std::path::{Path, PathBuf};
use std::process::Output;

use assert_cmd::Command;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Coefficient, SessionRow};

use crate::export::{BIKES, here};

const RIDES: &str = "fixtures/archive/sessions/bike=archive_01/date=2026-05-01";

/// Runs the binary in the repository as a terminal of 80 columns would show it.
fn roadbench(arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    command.current_dir(here("")).env("COLUMNS", "80").args(arguments);
    command.output().expect("the binary ran")
}

fn text(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("text")
}

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// An output of one log, and what the run printed.
fn ridden(out: &Path, logs: &[PathBuf]) -> Output {
    let logs: Vec<String> = logs.iter().map(|log| log.to_string_lossy().into_owned()).collect();
    let logs: Vec<&str> = logs.iter().map(String::as_str).collect();
    let out = out.to_string_lossy().into_owned();
    let options = ["--bikes", BIKES, "--out", &out, "--progress", "never"];
    roadbench(&[&["run"][..], &logs, &options].concat())
}

/// What the run says beyond the tables: what the bike file lacks, and where the report is.
fn without_what_no_table_has(printed: &str) -> String {
    let mut out = String::new();
    let mut is_cost = false;
    for line in printed.lines() {
        is_cost = match line {
            _ if line.starts_with("What the bike file lacks") => true,
            _ => is_cost && line.starts_with("  "),
        };
        if !is_cost && !line.starts_with("Report: ") && !line.starts_with("Page: ") {
            out += line;
            out += "\n";
        }
    }
    out.trim_end().replace("\n\n\n", "\n\n")
}

#[test]
fn a_session_is_shown_as_the_run_printed_it() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let ran = ridden(&out, &[here(RIDES).join("archive_s0001.parquet")]);
    assert!(ran.status.success(), "{}", said(&ran));
    let at = out.to_string_lossy().into_owned();
    let shown = roadbench(&["show", &at, "--session", "archive_s0001"]);
    assert!(shown.status.success(), "{}", said(&shown));
    let (ran, shown) = (text(&ran), text(&shown));
    assert!(ran.contains("Front tyre: peak friction "), "{ran}");
    assert_eq!(without_what_no_table_has(&shown), without_what_no_table_has(&ran));
    let page = out.join("report/archive_s0001.html");
    assert!(shown.ends_with(&format!("\nPage: {}\n", page.display())), "{shown}");
    let wide: Vec<&str> =
        shown.lines().filter(|l| l.chars().count() > 80 && !l.starts_with("Page: ")).collect();
    assert!(wide.is_empty(), "{wide:#?}");
    // rows are those of the tables, one object a line
    let json = text(&roadbench(&["show", &at, "--session", "archive_s0001", "--json"]));
    let of = |table: &str| -> Vec<serde_json::Value> {
        let lines = json.lines().map(serde_json::from_str::<serde_json::Value>);
        lines.map(|line| line.expect("JSON")).filter(|line| line["table"] == table).collect()
    };
    assert_eq!(of("sessions").len(), 1);
    let rows: Vec<Coefficient> = read::rows(&out).expect("coefficients");
    let lines = of("coefficients");
    assert_eq!(lines.len(), rows.len());
    for line in lines {
        let is_it =
            |row: &&Coefficient| line["tyre"] == row.tyre && line["coefficient"] == row.coefficient;
        let row = rows.iter().find(is_it).expect("the row of the table");
        // the reader of JSON is off in the last digit
        let near = |(x, y): (f64, f64)| (x - y).abs() <= 1e-14 * y.abs();
        let values = line["value"].as_f64().zip(row.value);
        assert!(values.map_or(line["value"].is_null() && row.value.is_none(), near), "{line}");
    }
    // a page that is not there has a command that writes it
    std::fs::remove_file(&page).expect("removed");
    let shown = text(&roadbench(&["show", &at, "--session", "archive_s0001"]));
    let one_line = shown.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(one_line.contains("--open=archive_s0001 --bike=archive_01` writes it"), "{shown}");
}

#[test]
fn an_output_is_listed_and_what_is_not_in_it_or_damaged_says_what_to_do() {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out");
    let bad = folder.path().join("broken_ride.csv");
    std::fs::write(&bad, "time;speed\n0;1\n").expect("written");
    let rides = here(RIDES);
    let logs = ["archive_s0001.parquet", "archive_s0002.parquet"].map(|name| rides.join(name));
    let ran = ridden(&out, &[logs[0].clone(), logs[1].clone(), bad]);
    assert_eq!(ran.status.code(), Some(1), "{}", said(&ran));
    let at = out.to_string_lossy().into_owned();
    let show = |more: &[&str]| roadbench(&[&["show", &at][..], more].concat());

    let listed = show(&[]);
    assert!(listed.status.success(), "{}", said(&listed));
    let listed = text(&listed);
    let rows: Vec<SessionRow> = read::rows(&out).expect("sessions");
    for row in &rows {
        let line = listed.lines().find(|l| l.starts_with(&row.ident.session_id));
        let line = line.unwrap_or_else(|| panic!("{listed}"));
        let cells: Vec<&str> = line.split_whitespace().collect();
        assert_eq!(cells[..3], [row.ident.session_id.as_str(), "archive_01", "2026-05-01"]);
        assert!(cells[3].starts_with("done"), "{line}");
        assert_eq!(cells.last().copied(), Some(row.n_coefficients_ok.to_string().as_str()));
    }
    assert!(listed.contains("\n1 rejected:\n") && listed.contains("broken_ride.csv"), "{listed}");
    assert!(listed.contains("--session archive_s0001"), "{listed}");
    let json = text(&show(&["--json"]));
    assert_eq!(json.lines().filter(|l| l.contains(r#""table":"sessions""#)).count(), 2, "{json}");
    assert_eq!(json.lines().filter(|l| l.contains(r#""table":"rejected""#)).count(), 1, "{json}");

    let refused = |more: &[&str], code: i32, words: &[&str]| {
        let output = show(more);
        let says = said(&output);
        assert_eq!(output.status.code(), Some(code), "{more:?}: {says}");
        for part in words {
            assert!(says.contains(part), "{more:?}: {says}");
        }
    };
    refused(
        &["--session", "archive_s001"],
        2,
        &["no session `archive_s001`", "`archive_s0001`", "or `archive_s0002`?"],
    );
    refused(&["--session", "entirely_else"], 2, &["`roadbench show OUT` lists them"]);
    refused(&["--session", "broken_ride"], 2, &["`broken_ride` was rejected", "broken_ride.csv"]);
    refused(
        &["--session", "archive_s0001", "--bike", "another"],
        2,
        &["bike `another` has no session `archive_s0001`; it is of archive_01"],
    );
    refused(&["--bike", "archive_1"], 2, &["no bike `archive_1`", "did you mean `archive_01`?"]);
    // a number of a file that is not as it was written is not shown
    let table = walkdir::WalkDir::new(out.join("coefficients")).into_iter();
    let table = table.map(|e| e.expect("entry").into_path());
    let table = table.into_iter().find(|p| p.extension().is_some_and(|e| e == "parquet"));
    let table = table.expect("a table");
    let mut bytes = std::fs::read(&table).expect("read");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    std::fs::write(&table, bytes).expect("written");
    refused(&["--session", "archive_s0001"], 3, &["coefficients/", "missing or damaged", "verify"]);
    assert!(show(&[]).status.success(), "the lists are as they were");
    let nowhere = roadbench(&["show", &folder.path().to_string_lossy()]);
    assert_eq!(nowhere.status.code(), Some(2), "{}", said(&nowhere));
    assert!(said(&nowhere).contains("is not an output of roadbench"), "{}", said(&nowhere));
}
