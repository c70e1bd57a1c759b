//! Paths that commands write at the user's word: every option that names one, at everything that may be there
//! (`roadbench::tables::output`). The tables that the tests print are those of what happens.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use roadbench::cli;
use roadbench::objects::Location;

/// What an option's value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Class {
    /// No path.
    Word,
    /// A file or folder that is read, or the name of something built in.
    Read,
    /// An output that is there already.
    Output,
    /// A file that is written.
    File,
    /// A folder that is written to.
    Folder,
}
use Class::{File, Folder, Output, Read, Word};

/// Every option and argument whose value is a path or a text, by command. One that is missing here fails the test below.
const CLASSES: &[(&str, &str, Class)] = &[
    ("run", "INPUT", Read),
    ("run", "--bikes", Read),
    ("run", "--out", Folder),
    ("run", "--pipeline", Read),
    ("run", "--map", Read),
    ("run", "--model", Read),
    ("run", "--metrics", File),
    ("run", "--figures", Folder),
    ("run", "--markdown", File),
    ("diagnose", "INPUT", Read),
    ("diagnose", "--bikes", Read),
    ("diagnose", "--out", Folder),
    ("diagnose", "--pipeline", Read),
    ("diagnose", "--map", Read),
    ("plan", "SCENARIO", Read),
    ("plan", "--pipeline", Read),
    ("simulate", "SCENARIO", Read),
    ("simulate", "--out", Folder),
    ("simulate", "--front-tyre", Read),
    ("simulate", "--rear-tyre", Read),
    ("modes", "MOTORCYCLE", Read),
    ("modes", "--out", Folder),
    ("replay", "LOG", Read),
    ("replay", "--motorcycle", Read),
    ("replay", "--front-tyre", Read),
    ("replay", "--rear-tyre", Read),
    ("replay", "--bikes", Read),
    ("replay", "--map", Read),
    ("replay", "--out", Folder),
    ("tyre", "TYRE", Read),
    ("tyre", "--against", Read),
    ("tyre", "--out", Folder),
    ("inspect", "LOG", Read),
    ("inspect", "--bikes", Read),
    ("inspect", "--map", Read),
    ("inspect", "--dbc", Read),
    ("inspect", "--pipeline", Read),
    ("bike new", "NAME", Word),
    ("bike new", "--class", Word),
    ("bike new", "--model", Word),
    ("bike new", "--front", Word),
    ("bike new", "--rear", Word),
    ("bike new", "--set", Word),
    ("bike new", "--out", Folder),
    ("map", "LOG", Read),
    ("map", "--map", Read),
    ("map", "--out", File),
    ("map", "--bike", Read),
    ("map", "--dbc", Read),
    ("convert", "LOG", Read),
    ("convert", "--map", Read),
    ("convert", "--dbc", Read),
    ("convert", "--bike", Word),
    ("convert", "--out", File),
    ("report", "OUT", Output),
    ("report", "--bench", Read),
    ("report", "--figures", Folder),
    ("report", "--markdown", File),
    ("report", "--session", Word),
    ("report", "--open", Word),
    ("report", "--bike", Word),
    ("forget", "OUT", Output),
    ("forget", "--session", Word),
    ("forget", "--bike", Word),
    ("verify", "OUT", Output),
    ("export", "OUT", Output),
    ("export", "--session", Word),
    ("export", "--bike", Word),
    ("export", "--bikes", Read),
    ("export", "--model", Read),
    ("export", "--out", File),
    ("schema", "NAME", Word),
    ("demo", "--out", Folder),
    ("man", "DIR", Folder),
];

/// A file that an option names, or that a command puts into a folder by a name of its own.
struct OfFile {
    option: &'static str,
    /// The command; `AT` is the path that is tried.
    line: &'static str,
    /// Where that path is, in the folder of the case.
    at: &'static str,
    /// One of the files that the command reads, and how it is said otherwise.
    input: Option<&'static str>,
    /// What is written has this in it.
    holds: &'static str,
}

const FILES: &[OfFile] = &[
    OfFile {
        option: "run --metrics",
        line: "run log.parquet --bikes bikes --out new --metrics AT",
        at: "it.prom",
        input: Some("log.parquet"),
        holds: "roadbench_sessions",
    },
    OfFile {
        option: "run --markdown",
        line: "run log.parquet --bikes bikes --out new --markdown AT",
        at: "it.md",
        input: Some("bikes/archive_01.toml"),
        holds: "# Tyre coefficients",
    },
    OfFile {
        option: "report --markdown",
        line: "report out --bench bench.csv --markdown AT",
        at: "it.md",
        input: Some("bench.csv"),
        holds: "# Tyre coefficients",
    },
    OfFile {
        option: "convert --out",
        line: "convert log.parquet --out AT",
        at: "it.parquet",
        input: Some("log.parquet"),
        holds: "PAR1",
    },
    OfFile {
        option: "export --out",
        line: "export out --session archive_s0001 --format toml --bikes bikes --out AT",
        at: "it.toml",
        input: Some("bikes/archive_01.toml"),
        holds: "archive_s0001",
    },
    OfFile {
        option: "map --out",
        line: "map superbike.csv --out AT",
        at: "it.toml",
        input: Some("superbike.csv"),
        holds: "name =",
    },
    OfFile {
        option: "bike new --out",
        line: "bike new mine --class naked --weight 250 --force --out garage",
        at: "garage/mine.toml",
        input: None,
        holds: "wheelbase",
    },
    OfFile {
        option: "man DIR",
        line: "man pages",
        at: "pages/roadbench-run.1",
        input: None,
        holds: ".TH",
    },
    OfFile {
        option: "modes --out",
        line: "modes sports_small --out drawn",
        at: "drawn/modes.svg",
        input: None,
        holds: "<svg",
    },
    OfFile {
        option: "tyre --out",
        line: "tyre sharp2004_front_120_70 --out drawn",
        at: "drawn/bench.parquet",
        input: None,
        holds: "PAR1",
    },
    OfFile {
        option: "replay --out",
        line: "replay log.parquet --motorcycle sports_touring --bikes bikes --out drawn",
        at: "drawn/replay.parquet",
        input: Some("log.parquet"),
        holds: "PAR1",
    },
];

/// A folder that an option names.
struct OfFolder {
    option: &'static str,
    line: &'static str,
    /// What is in it then; none where the command takes too long for a test of it.
    holds: Option<&'static str>,
    /// Where somebody keeps sessions in the folder, if that matters.
    sessions: Option<&'static str>,
}

const FOLDERS: &[OfFolder] = &[
    OfFolder {
        option: "run --out",
        line: "run log.parquet --bikes bikes --out AT",
        holds: Some("report/index.html"),
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "run --figures",
        line: "run log.parquet --bikes bikes --out new --figures AT",
        holds: Some("archive_s0001/timeline.svg"),
        sessions: None,
    },
    OfFolder {
        option: "diagnose --out",
        line: "diagnose log.parquet --bikes bikes --out AT",
        holds: None,
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "simulate --out",
        line: "simulate short.toml --out AT",
        holds: Some("truth"),
        sessions: Some("sessions"),
    },
    OfFolder {
        option: "demo --out",
        line: "demo --no-open --out AT",
        holds: None,
        sessions: Some("archive/sessions"),
    },
    OfFolder {
        option: "report --figures",
        line: "report out --figures AT",
        holds: Some("archive_s0001/timeline.svg"),
        sessions: None,
    },
    OfFolder { option: "man DIR", line: "man AT", holds: Some("roadbench.1"), sessions: None },
    OfFolder {
        option: "bike new --out",
        line: "bike new mine --class naked --weight 250 --out AT",
        holds: Some("mine.toml"),
        sessions: None,
    },
    OfFolder {
        option: "modes --out",
        line: "modes sports_small --out AT",
        holds: Some("modes.parquet"),
        sessions: None,
    },
    OfFolder {
        option: "tyre --out",
        line: "tyre sharp2004_front_120_70 --out AT",
        holds: Some("bench.svg"),
        sessions: None,
    },
    OfFolder {
        option: "replay --out",
        line: "replay log.parquet --motorcycle sports_touring --bikes bikes --out AT",
        holds: Some("replay.parquet"),
        sessions: None,
    },
];

/// An argument as it is written.
fn name_of(argument: &clap::Arg) -> String {
    let position = || {
        let names = argument.get_value_names().and_then(|names| names.first());
        names.map_or_else(|| argument.get_id().to_string().to_uppercase(), ToString::to_string)
    };
    argument.get_long().map_or_else(position, |long| format!("--{long}"))
}

/// The arguments of every command whose values are paths or texts.
fn arguments() -> Vec<(String, String)> {
    fn below(command: &clap::Command, names: &[String], found: &mut Vec<(String, String)>) {
        use std::any::TypeId;
        let texts = [
            TypeId::of::<PathBuf>(),
            TypeId::of::<Location>(),
            TypeId::of::<String>(),
            TypeId::of::<std::ffi::OsString>(),
        ];
        for argument in command.get_arguments().filter(|a| a.get_action().takes_values()) {
            let kind = argument.get_value_parser().type_id();
            if texts.iter().any(|text| kind == *text) {
                found.push((names.join(" "), name_of(argument)));
            }
        }
        for sub in command.get_subcommands().filter(|c| c.get_name() != "help") {
            below(sub, &[names, &[sub.get_name().to_owned()]].concat(), found);
        }
    }
    let mut command = cli::command();
    command.build();
    let mut found = Vec::new();
    below(&command, &[], &mut found);
    found
}

fn class_of(command: &str, argument: &str) -> Option<Class> {
    CLASSES.iter().find(|(c, a, _)| (*c, *a) == (command, argument)).map(|(_, _, class)| *class)
}

#[test]
fn every_option_that_may_be_a_path_is_classified_and_every_written_one_is_tried() {
    let all = arguments();
    let is_tried = |command: &str, argument: &str, files: bool| {
        let option = format!("{command} {argument}");
        match files {
            true => FILES.iter().any(|row| row.option == option),
            false => FOLDERS.iter().any(|row| row.option == option),
        }
    };
    for (command, argument) in &all {
        let Some(class) = class_of(command, argument) else {
            panic!("`{command} {argument}`: is it a path, and is it written? See CLASSES");
        };
        if matches!(class, File | Folder) {
            assert!(
                is_tried(command, argument, class == File),
                "`{command} {argument}` is not tried"
            );
        }
    }
    let there =
        |(c, a): (&str, &str)| all.iter().any(|(command, name)| (&**command, &**name) == (c, a));
    let gone: Vec<_> = CLASSES.iter().filter(|(c, a, _)| !there((c, a))).collect();
    assert!(gone.is_empty(), "no such options: {gone:?}");
}

#[test]
fn an_empty_path_is_bad_usage_that_says_which() {
    for (command, argument, class) in CLASSES.iter().filter(|(_, _, class)| *class != Word) {
        let mut line: Vec<&str> = std::iter::once("roadbench").chain(command.split(' ')).collect();
        line.extend(argument.starts_with("--").then_some(*argument));
        line.push("");
        let e = cli::command().try_get_matches_from(&line).expect_err("an empty path");
        let says = e.to_string();
        let first = says.lines().next().unwrap_or_default();
        assert_eq!(e.exit_code(), 2, "{line:?}");
        assert!(first.contains(argument), "{line:?} ({class:?}): {says}");
    }
}

/// A folder with all that the commands read.
struct Place(tempfile::TempDir);

impl Place {
    fn new(out: Option<&Place>) -> Self {
        let place = Place(tempfile::tempdir().expect("folder"));
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures");
        let log = "archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet";
        for (from, to) in [
            (log, "log.parquet"),
            ("archive/bikes/archive_01.toml", "bikes/archive_01.toml"),
            ("loggers/superbike.csv", "superbike.csv"),
        ] {
            place.put(to, &std::fs::read(root.join(from)).expect(from));
        }
        let bench = "tyre,coefficient,value\nfront,cornering_stiffness_0,12.5\n";
        place.put("bench.csv", bench.as_bytes());
        let scenario =
            std::fs::read_to_string(root.join("archive/scenario.toml")).expect("scenario");
        let short = scenario.replace("sessions_per_bike = 6", "sessions_per_bike = 1");
        place.put("short.toml", short.replace("bikes = 2", "bikes = 1").as_bytes());
        if let Some(from) = out {
            for entry in Location::from(from.path("out")).list().expect("an output") {
                let bytes = std::fs::read(from.path("out").join(&entry.key)).expect("a file of it");
                place.put(&format!("out/{}", entry.key), &bytes);
            }
        }
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn put(&self, name: &str, bytes: &[u8]) {
        let path = self.path(name);
        std::fs::create_dir_all(path.parent().expect("a folder")).expect("folder");
        std::fs::write(path, bytes).expect(name);
    }

    fn read(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap_or_default()
    }

    /// Exit code and what is on stderr.
    fn run(&self, line: &str, at: &str) -> (i32, String) {
        let words = line.split(' ').map(|word| if word == "AT" { at } else { word });
        let output = Command::new(env!("CARGO_BIN_EXE_roadbench"))
            .args(words)
            .current_dir(self.0.path())
            .stdin(Stdio::null())
            .output()
            .expect("roadbench starts");
        let code = output.status.code().unwrap_or_else(|| panic!("{line} {at}: it was killed"));
        (code, String::from_utf8_lossy(&output.stderr).into_owned())
    }
}

/// A place with an output in it.
fn with_output() -> Place {
    let place = Place::new(None);
    let (code, said) = place.run("run log.parquet --bikes bikes --out out", "");
    assert_eq!(code, 0, "{said}");
    place
}

#[cfg(unix)]
mod planted {
    use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};

    use rayon::prelude::*;

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
                std::fs::set_permissions(
                    place.path("elsewhere/old"),
                    PermissionsExt::from_mode(0o600),
                )
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
                for own in
                    ["out/coefficients/bike=archive_01/2026-05.parquet", "out/.roadbench.lock"]
                {
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
            for name in ["file", "pipe", "nul"].into_iter().filter(|name| place.path(name).exists())
            {
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
            assert!(code == 3 && said.contains("nobody reads this pipe"), "{code} {said}");
            let there = std::fs::metadata(place.path("pipe")).expect("there");
            assert!(there.file_type().is_fifo());
        }
        // as a shell opens it for stdout: what was printed before stays
        let line =
            "{0} report out --markdown /dev/stdout > all.txt; {0} report out --markdown all.md";
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
            let output =
                Command::new("sh").args(["-c", &line]).current_dir(place.path("")).output();
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
}
