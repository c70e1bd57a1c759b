//! Paths that commands write at the user's word: every option that names one, at everything that may be there
//! (`roadbench::internals::store::tables::output`). The tables that the tests print are those of what happens.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use roadbench::internals::cli;
use roadbench::internals::store::objects::Location;

use tried::{FILES, FOLDERS};

#[cfg(unix)]
mod planted;
mod tried;

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
    ("diagnose", "--against", Word),
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
    ("show", "OUT", Output),
    ("show", "--session", Word),
    ("show", "--bike", Word),
    ("compare", "OUT", Output),
    ("compare", "A", Word),
    ("compare", "B", Word),
    ("compare", "--out", File),
    ("compare", "--page", File),
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
        let second = "archive/sessions/bike=archive_01/date=2026-05-01/archive_s0002.parquet";
        for (from, to) in [
            (log, "log.parquet"),
            (second, "second.parquet"),
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
    let (code, said) = place.run("run log.parquet second.parquet --bikes bikes --out out", "");
    assert_eq!(code, 0, "{said}");
    place
}
