//! Every command of the README and of the book is run, in a copy of what the repository has.
//!
//! The fenced `sh` blocks of a page are run one after the other in one folder, as a reader would. The
//! archive in that folder has two rides instead of twelve, so that this takes a minute.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Commands that cannot be run here, by what is in them, and why.
const NOT_RUN: [(&str, &str); 12] = [
    (".ci/run", "runs these tests"),
    ("s3://", "needs an object store; tests/it/objects.rs has one"),
    ("pip install", "installs from the network; .ci/python does"),
    ("maturin ", "builds the wheel; .ci/python does"),
    ("spark-submit", "needs a Spark cluster; .ci/python starts one"),
    ("submit.py", "goes with spark-submit"),
    ("/archive --out /tables", "goes with spark-submit"),
    ("cargo install", "builds the program once more"),
    ("simulate characterise", "tests/it/lane_change.rs runs it"),
    ("run ride --out results", "tests/it/lane_change.rs runs it"),
    ("characterise_sports_small_s0001", "tests/it/lane_change.rs runs it"),
    ("simulate lane_change", "tests/it/lane_change.rs runs it"),
];

/// Not run where the real recordings are not beside the repository.
const REAL: &str = "kiro/";

/// What is another here: places of a server are folders of the copy, and a diagnosis simulates fewer rides without any
/// hidden effect (what it finds is tested elsewhere).
const OTHERWISE: [(&str, &str); 3] = [
    (" /archive/", " archive/"),
    (" /var/lib/node_exporter/", " "),
    ("roadbench diagnose ", "roadbench diagnose --nulls 8 "),
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The commands of a page's `sh` and `console` blocks, in order; what a line continues is one command, and so is a
/// loop.
fn commands(page: &str) -> Vec<String> {
    let (mut all, mut fence) = (Vec::new(), "");
    let mut open = String::new();
    for whole in page.lines() {
        let line = whole.trim();
        if line.starts_with("```") {
            fence = if fence.is_empty() { line } else { "" };
            continue;
        }
        // of a console block the output is looked at by `printed.rs`; what it makes later commands need
        let line = match fence {
            "```sh" => line,
            // what is indented is output
            "```console" if open.is_empty() => whole.strip_prefix("$ ").unwrap_or_default(),
            "```console" => line,
            _ => "",
        };
        if line.is_empty() || line.starts_with('#') {
            continue;
        }
        if !open.is_empty() {
            open.push('\n');
        }
        open += line;
        let more = line.ends_with('\\') || (open.starts_with("for ") && !open.ends_with("done"));
        if !more {
            all.push(std::mem::take(&mut open));
        }
    }
    assert!(open.is_empty(), "a command without an end: {open}");
    all
}

/// The commands that `roadbench --help` lists, of all groups.
pub fn listed(help: &str) -> Vec<&str> {
    let commands: Vec<&str> = help
        .lines()
        .skip_while(|l| !l.starts_with("Usage:"))
        .take_while(|l| !l.starts_with("Global options:"))
        .filter(|l| l.starts_with("  ") && !l.starts_with("   "))
        .filter_map(|l| l.split_whitespace().next())
        .collect();
    assert!(commands.len() >= 15, "{commands:?}");
    commands
}

/// A folder with what the commands name: two rides, the bikes, and the real recordings if there are any.
fn copy() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let to = folder.path();
    let put = |from: &Path, at: &str| {
        let at = to.join(at);
        std::fs::create_dir_all(at.parent().expect("a parent")).expect("folder");
        std::fs::copy(from, &at).unwrap_or_else(|e| panic!("{}: {e}", from.display()));
    };
    let archive = root().join("fixtures/archive");
    for name in [
        "bikes/archive_01.toml",
        "bikes/archive_02.toml",
        "sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet",
        "sessions/bike=archive_02/date=2026-05-04/archive_s0008.parquet",
    ] {
        put(&archive.join(name), &format!("fixtures/archive/{name}"));
        put(&archive.join(name), &format!("archive/{name}"));
    }
    for entry in std::fs::read_dir(root().join("fixtures/bikes")).expect("bikes").flatten() {
        put(&entry.path(), &format!("fixtures/bikes/{}", entry.file_name().to_string_lossy()));
    }
    let bundled =
        ["formats/ride.mf4", "loggers/superbike.csv", "loggers/bike.toml", "bench/rear_180_55.tdx"];
    for name in bundled.map(|name| format!("fixtures/{name}")) {
        put(&root().join(&name), &name);
    }
    if let Some(log) = recording() {
        put(&log, "kiro/KIRO_4.txt");
    }
    folder
}

fn recording() -> Option<PathBuf> {
    let log = root().join("../shared/data/emoto_kiro/KIRO_4.txt");
    log.is_file().then_some(log)
}

/// Runs a page's commands; gives back how many ran.
fn run(name: &str) -> usize {
    let page = std::fs::read_to_string(root().join(name)).expect(name);
    let folder = copy();
    let binary = assert_cmd::cargo::cargo_bin("roadbench");
    let here = binary.parent().expect("a folder").to_string_lossy().into_owned();
    let path = format!("{here}:{}", std::env::var("PATH").unwrap_or_default());
    let mut ran = 0;
    for command in commands(&page) {
        if let Some((_, why)) = NOT_RUN.iter().find(|(part, _)| command.contains(part)) {
            println!("{name}: not run ({why}): {command}");
            continue;
        }
        if command.contains(REAL) && recording().is_none() {
            println!("{name}: not run (there are no recordings in ../shared/data): {command}");
            continue;
        }
        // `cargo run` would build what is built already
        let mut here = command.replace("cargo run -- ", "roadbench ");
        for (said, tested) in OTHERWISE {
            here = here.replace(said, tested);
        }
        let begin = std::time::Instant::now();
        let output = Command::new("sh")
            .args(["-e", "-c", &here])
            .current_dir(folder.path())
            .env("PATH", &path)
            .output()
            .expect("a shell");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{name}: {command}\n{:?}\n{error}", output.status.code());
        println!("{name}: {:.1} s: {command}", begin.elapsed().as_secs_f64());
        ran += 1;
    }
    ran
}

#[test]
fn of_the_readme() {
    assert!(run("README.md") >= 2);
}

#[test]
fn the_readme_is_short_and_lists_every_command() {
    let page = std::fs::read_to_string(root().join("README.md")).expect("README");
    let words = page.split_whitespace().count();
    assert!(words <= 1200, "{words} words");
    let binary = assert_cmd::cargo::cargo_bin("roadbench");
    let help = Command::new(binary).arg("--help").output().expect("ran");
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    for name in listed(&help) {
        let row = [format!("| `roadbench {name} "), format!("| `roadbench {name}`")];
        assert!(row.iter().any(|start| page.contains(start)), "README.md has no row for {name}");
    }
}

#[test]
fn of_the_book() {
    let mut ran = 0;
    for page in walkdir::WalkDir::new(root().join("book/src")).sort_by_file_name() {
        let page = page.expect("page");
        if page.path().extension().is_some_and(|e| e == "md") {
            let name = page.path().strip_prefix(root()).expect("below");
            ran += run(&name.to_string_lossy());
        }
    }
    assert!(ran >= 25, "{ran}");
}

#[test]
fn commands_are_found_in_a_page() {
    let page = "x\n```sh\na b   # why\nfor x in 1 2; do c $x \\\n  d; done\n\n# a remark\n```\n```text\nno\n```\n```console\n$ e\nno\n```\n";
    assert_eq!(commands(page), ["a b   # why", "for x in 1 2; do c $x \\\nd; done", "e"]);
}
