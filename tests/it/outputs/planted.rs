//! Every option that writes, at everything that may be there.

use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};

use rayon::prelude::*;

use super::tried::{OfFile, OfFolder};
use super::*;

/// What was there before.
const OLD: &[u8] = b"somebody's";

/// `None` where only root may make such a thing.
fn make(command: &str, path: &Path, rest: &[&str]) -> Option<()> {
    let made = Command::new(command).arg(path).args(rest).stderr(Stdio::null()).status();
    made.is_ok_and(|status| status.success()).then_some(())
}

fn is_whole(bytes: &[u8], holds: &str) -> bool {
    bytes.windows(holds.len()).any(|part| part == holds.as_bytes())
}

fn mode(path: &Path) -> u32 {
    std::fs::metadata(path).expect("there").mode() & 0o7777
}

const FILE_COLUMNS: [&str; 13] = [
    "nothing",
    "file",
    "link to file",
    "dangling link",
    "circle of links",
    "device",
    "full device",
    "pipe",
    "folder",
    "its input",
    "link to input",
    "below a file",
    "of an output",
];

/// Tries one option at one thing; what happens, in words.
fn try_file(row: &OfFile, column: &str, place: &Place) -> Option<String> {
    let at = place.path(row.at);
    std::fs::create_dir_all(at.parent().expect("a folder")).expect("folder");
    let why = format!("{} at {column}", row.option);
    let run = |tried: &str, code: i32| {
        let (found, said) = place.run(row.line, tried);
        assert_eq!(found, code, "{why}: {said}");
        assert!(code == 0 || said.contains(tried) || said.contains(row.at), "{why}: {said}");
    };
    let written = |name: &str| assert!(is_whole(&place.read(name), row.holds), "{why}: {name}");
    // a name in a folder is tried by the folder's options
    let is_named = row.line.contains("AT");
    let said = match column {
        "nothing" => {
            run(row.at, 0);
            written(row.at);
            "made"
        }
        "file" => {
            place.put(row.at, OLD);
            std::fs::set_permissions(&at, PermissionsExt::from_mode(0o640)).expect("mode");
            run(row.at, 0);
            written(row.at);
            assert_eq!(mode(&at), 0o640, "{why}");
            "replaced, rights kept"
        }
        "link to file" => {
            place.put("elsewhere/old", OLD);
            std::fs::set_permissions(place.path("elsewhere/old"), PermissionsExt::from_mode(0o600))
                .expect("mode");
            symlink(place.path("elsewhere/old"), &at).expect("link");
            run(row.at, 0);
            written("elsewhere/old");
            assert!(at.is_symlink() && mode(&at) == 0o600, "{why}");
            "its file replaced, link stays"
        }
        "dangling link" => {
            symlink(place.path("elsewhere/new"), &at).expect("link");
            run(row.at, 0);
            written("elsewhere/new");
            assert!(at.is_symlink(), "{why}");
            "its file made, link stays"
        }
        "circle of links" => {
            symlink(&at, place.path("circle")).expect("link");
            symlink(place.path("circle"), &at).expect("link");
            run(row.at, 3);
            assert!(at.is_symlink(), "{why}");
            "error 3"
        }
        "device" | "full device" => {
            let minor = if column == "device" { "3" } else { "7" };
            make("mknod", &at, &["c", "1", minor])?;
            run(row.at, if column == "device" { 0 } else { 3 });
            let kind = std::fs::metadata(&at).expect("there").file_type();
            assert!(kind.is_char_device(), "{why}");
            if column == "device" { "written to" } else { "error 3" }
        }
        "pipe" => {
            make("mkfifo", &at, &[])?;
            let from = at.clone();
            // who reads comes a little later
            let reader = std::thread::spawn(move || {
                std::thread::sleep(std::time::Duration::from_millis(400));
                std::fs::read(from).expect("read")
            });
            run(row.at, 0);
            let read = reader.join().expect("no panic");
            assert!(is_whole(&read, row.holds), "{why}");
            assert!(std::fs::metadata(&at).expect("there").file_type().is_fifo(), "{why}");
            "written to"
        }
        "folder" => {
            std::fs::create_dir(&at).expect("folder");
            run(row.at, 2);
            assert!(at.is_dir(), "{why}");
            "refused (2)"
        }
        "its input" | "link to input" => {
            let input = row.input?;
            let before = place.read(input);
            let (input, tried) = (place.path(input), at.clone());
            match column {
                "its input" => std::fs::hard_link(&input, &tried).expect("link"),
                _ => symlink(&input, &tried).expect("link"),
            }
            run(row.at, 2);
            assert!(std::fs::read(&input).expect("there") == before, "{why}");
            if is_named {
                run(row.input?, 2);
                assert!(std::fs::read(&input).expect("there") == before, "{why}");
            }
            assert!(!place.path("new").exists(), "{why}: before anything is computed");
            "refused (2)"
        }
        "below a file" if is_named => {
            place.put("afile", OLD);
            run("afile/x", 3);
            run("/proc/roadbench-test", 3);
            assert_eq!(place.read("afile"), OLD, "{why}");
            assert!(!place.path("new").exists(), "{why}: before anything is computed");
            "error 3"
        }
        "of an output" if is_named => {
            for own in ["out/coefficients/bike=archive_01/2026-05.parquet", "out/.roadbench.lock"] {
                let before = place.read(own);
                run(own, 2);
                assert!(place.read(own) == before, "{why}");
            }
            "refused (2)"
        }
        _ => return Some("-".to_owned()),
    };
    // no temporary stays, whatever happened
    for entry in std::fs::read_dir(at.parent().expect("a folder")).expect("list").flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        assert!(!name.ends_with(".tmp"), "{why}: {name}");
    }
    Some(said.to_owned())
}

fn table<T: Sync>(
    rows: &[T],
    columns: &[&str],
    name: impl Fn(&T) -> &str + Sync,
    cell: impl Fn(&T, &str) -> String + Sync,
) {
    let lines: Vec<String> = rows
        .par_iter()
        .map(|row| {
            let cells: Vec<String> = columns.iter().map(|column| cell(row, column)).collect();
            format!("| `{}` | {} |", name(row), cells.join(" | "))
        })
        .collect();
    println!("| option | {} |\n|---{}|", columns.join(" | "), "|---".repeat(columns.len()));
    lines.iter().for_each(|line| println!("{line}"));
}

#[test]
fn files_are_written_by_one_rule() {
    let output = with_output();
    table(
        FILES,
        &FILE_COLUMNS,
        |row| row.option,
        |row, column| {
            let place = Place::new(Some(&output));
            try_file(row, column, &place).unwrap_or_else(|| "-".to_owned())
        },
    );
}

const FOLDER_COLUMNS: [&str; 9] = [
    "nothing",
    "link to folder",
    "dangling link",
    "file",
    "device",
    "pipe",
    "below a file",
    "of an output",
    "somebody's sessions",
];

fn try_folder(row: &OfFolder, column: &str, place: &Place) -> Option<String> {
    let at = place.path("at");
    let why = format!("{} at {column}", row.option);
    let run = |tried: &str, code: i32| {
        let (found, said) = place.run(row.line, tried);
        assert_eq!(found, code, "{why}: {said}");
        assert!(code == 0 || said.contains(tried), "{why}: {said}");
        let lines = said.lines().filter(|line| line.contains("roadbench:")).count();
        assert_eq!(lines, usize::from(code != 0), "{why}: one clear error: {said}");
    };
    let needs = |tried: &str| {
        let before = std::fs::symlink_metadata(place.path(tried)).expect("there");
        run(tried, 2);
        let now = std::fs::symlink_metadata(place.path(tried)).expect("there");
        assert!(before.ino() == now.ino() && before.mode() == now.mode(), "{why}");
        "refused (2)"
    };
    let said = match column {
        "nothing" => {
            let holds = row.holds?;
            run("at", 0);
            assert!(at.join(holds).exists(), "{why}");
            "made"
        }
        "link to folder" => {
            let holds = row.holds?;
            std::fs::create_dir(place.path("elsewhere")).expect("folder");
            symlink("elsewhere", &at).expect("link");
            run("at", 0);
            assert!(place.path("elsewhere").join(holds).exists() && at.is_symlink(), "{why}");
            "followed"
        }
        "dangling link" => {
            symlink("nowhere", &at).expect("link");
            needs("at")
        }
        "file" => {
            place.put("at", OLD);
            let said = needs("at");
            assert_eq!(place.read("at"), OLD, "{why}");
            said
        }
        "device" => {
            make("mknod", &at, &["c", "1", "3"])?;
            needs("at")
        }
        "pipe" => {
            make("mkfifo", &at, &[])?;
            needs("at")
        }
        "below a file" => {
            place.put("at", OLD);
            run("at/x", 3);
            run("/proc/roadbench-test", 3);
            "error 3"
        }
        "of an output" => {
            run("out/coefficients", 2);
            "refused (2)"
        }
        "somebody's sessions" => {
            let log = format!("at/{}/bike=archive_01/own.parquet", row.sessions?);
            place.put(&log, OLD);
            run("at", 2);
            let there = Location::from(at).list().expect("list");
            assert!(there.len() == 1 && place.read(&log) == OLD, "{why}: {there:?}");
            "refused (2)"
        }
        _ => unreachable!("{column}"),
    };
    let is_run = ["nothing", "link to folder"].contains(&column);
    assert!(is_run || !place.path("new").exists(), "{why}: before anything is computed");
    Some(said.to_owned())
}

#[test]
fn folders_are_written_by_one_rule() {
    let output = with_output();
    table(
        FOLDERS,
        &FOLDER_COLUMNS,
        |row| row.option,
        |row, column| {
            let place = Place::new(Some(&output));
            try_folder(row, column, &place).unwrap_or_else(|| "-".to_owned())
        },
    );
}

/// An output that is there already must be a folder, and what looks into it waits for nobody.
#[test]
fn what_is_no_folder_is_no_output() {
    let place = Place::new(None);
    place.put("file", OLD);
    let _ = make("mkfifo", &place.path("pipe"), &[]).and(make(
        "mknod",
        &place.path("nul"),
        &["c", "1", "3"],
    ));
    for line in
        ["report AT", "forget AT --missing", "verify AT", "export AT --session s --format toml"]
    {
        for name in ["file", "pipe", "nul"].into_iter().filter(|name| place.path(name).exists()) {
            let (code, said) = place.run(line, name);
            assert!(code == 2 && said.contains(name), "{line} {name}: {code} {said}");
        }
    }
    assert_eq!(place.read("file"), OLD);
}

#[test]
fn a_pipe_without_a_reader_is_an_error_and_what_is_printed_may_be_named() {
    let place = with_output();
    if make("mkfifo", &place.path("pipe"), &[]).is_some() {
        let (code, said) = place.run("convert log.parquet --out AT", "pipe");
        assert!(code == 3 && said.contains("no program reads this pipe"), "{code} {said}");
        let there = std::fs::metadata(place.path("pipe")).expect("there");
        assert!(there.file_type().is_fifo());
    }
    // as a shell opens it for stdout: what was printed before stays
    let line = "{0} report out --markdown /dev/stdout > all.txt; {0} report out --markdown all.md";
    let line = line.replace("{0}", env!("CARGO_BIN_EXE_roadbench"));
    let status = Command::new("sh").args(["-c", &line]).current_dir(place.path("")).status();
    assert!(status.expect("sh").success());
    let (all, summary) = (place.read("all.txt"), place.read("all.md"));
    let all = String::from_utf8(all).expect("text");
    assert!(all.starts_with(&*String::from_utf8_lossy(&summary)), "{all}");
    assert!(all.ends_with("out/report/index.html\n"), "{all}");
}

/// The largest file that a user may write: an error as of a full disk, and nothing half-written.
#[test]
fn a_file_that_may_not_grow_is_one_clear_error() {
    let place = Place::new(None);
    for (line, name) in [
        ("convert log.parquet --out it.parquet", "it.parquet"),
        ("run log.parquet --bikes bikes --out new", "new/"),
    ] {
        let line = format!("ulimit -f 8; exec {} {line}", env!("CARGO_BIN_EXE_roadbench"));
        let output = Command::new("sh").args(["-c", &line]).current_dir(place.path("")).output();
        let output = output.expect("sh");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(3), "{line}: {said}");
        assert!(said.contains("File too large") && said.contains(name), "{line}: {said}");
    }
    let left = Location::from(place.path("")).list().expect("list");
    assert!(!left.iter().any(|e| e.key.ends_with(".tmp") || e.key == "it.parquet"), "{left:?}");
}

/// Names of our own in an output, with links at them: none is written through.
#[test]
fn a_link_at_a_name_of_ours_harms_nobody() {
    let output = with_output();
    let lists = |place: &Place| {
        place.run("report out --figures figures", "");
        let list = std::fs::read_dir(place.path("figures")).expect("figures").flatten();
        let mut names = list.map(|e| e.file_name().to_string_lossy().into_owned());
        names.find(|name| name.starts_with(".roadbench-figures-")).expect("a list")
    };
    let line = "run log.parquet --bikes bikes --out out --figures figures";
    for (name, code) in [
        ("out/.roadbench.lock".to_owned(), 3),
        ("out/.roadbench/tables.lock".to_owned(), 3),
        ("out/.roadbench-run.json.tmp".to_owned(), 0),
        ("out/run.json".to_owned(), 0),
        ("out/fleet/fleet.parquet".to_owned(), 0),
        ("out/.roadbench/checksums.json".to_owned(), 0),
        (String::new(), 3),
    ] {
        let place = Place::new(Some(&output));
        let name = if name.is_empty() { format!("figures/{}", lists(&place)) } else { name };
        place.put("kept", OLD);
        let _ = std::fs::remove_file(place.path(&name));
        symlink(place.path("kept"), place.path(&name)).expect("link");
        let (found, said) = place.run(line, "");
        assert_eq!(place.read("kept"), OLD, "{name}: {said}");
        assert_eq!(found, code, "{name}: {said}");
        let last = name.rsplit('/').next().unwrap_or_default();
        assert!(code == 0 || (said.contains(last) && said.contains("remove it")), "{said}");
    }
}
