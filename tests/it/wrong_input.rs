//! What a command says of a path or a name that is wrong, and its exit code: a table of command and mistake.

use std::path::Path;
use std::process::Output;

use assert_cmd::Command;

const ARCHIVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/archive");
const LOG: &str = concat!(
    env!("CARGO_MANIFEST_DIR"),
    "/fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet"
);

fn roadbench(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    command.current_dir(folder).args(arguments).output().expect("ran")
}

/// A folder with a file of each kind, a folder that is no output, and the output `out` of one log.
fn place() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    for (name, from) in [
        ("bike.toml", "fixtures/archive/bikes/archive_01.toml"),
        ("motorcycle.toml", "pipelines/motorcycles/sports_small.toml"),
        ("map.toml", "pipelines/maps/kiro.toml"),
        ("pipeline.toml", "pipelines/onroad.toml"),
        ("scenario.toml", "pipelines/scenarios/archive.toml"),
        ("ride.toml", "pipelines/scenarios/lane_change.toml"),
    ] {
        std::fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(from), at(name)).expect(from);
    }
    std::fs::write(at("ride.csv"), "time,velocity_x\n0,1\n0.01,1\n").expect("file");
    std::fs::create_dir(at("photos")).expect("folder");
    std::fs::write(at("photos/a.jpg"), "a picture").expect("file");
    let bikes = format!("{ARCHIVE}/bikes");
    let done = roadbench(folder.path(), &["run", LOG, "--bikes", &bikes, "--out", "out"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    folder
}

/// Words of a command line, exit code, and what its message says. `LOG` and `BIKES` stand for the archive's.
const CASES: &[(&str, u8, &str)] = &[
    // a log that is not there is wrong usage, whichever command
    ("run gone --bikes BIKES --out new", 2, "gone does not exist"),
    ("diagnose gone --bikes BIKES --out new", 2, "gone does not exist"),
    ("run *.gone --bikes BIKES --out new", 2, "nothing matches *.gone"),
    ("inspect gone", 2, "gone: file not found"),
    ("map gone", 2, "gone: file not found"),
    ("convert gone --out new", 2, "gone: file not found"),
    ("convert gone --dry-run", 2, "gone: file not found"),
    ("replay gone --motorcycle sports_touring --bikes BIKES", 2, "gone: file not found"),
    ("inspect photos", 2, "this is a folder, and one log is wanted"),
    // sets of sessions that are none
    ("compare gone a b", 2, "gone is not a folder"),
    ("compare photos a b", 2, "photos is not an output"),
    ("compare out s0001 others", 2, "A: no session `s0001`; did you mean `archive_s0001`?"),
    ("compare out archive_s0001 others", 2, "`archive_s0001` is every session"),
    ("compare out archive_s0001 archive_s0001", 2, "are the same sessions"),
    ("compare out archive_s0001", 2, "give a second output, or two sets of sessions"),
    ("compare out tire=x others", 2, "sessions cannot be chosen by `tire`"),
    ("compare out out", 2, "are the same sessions"),
    ("compare out a b --load 1", 2, "must be between 10 and 20000"),
    // other files that are not there
    ("inspect LOG --bikes gone", 2, "gone is not a folder: file not found"),
    ("inspect LOG --bikes bike.toml", 2, "bike.toml is a file; a folder is wanted"),
    ("inspect LOG --map gone", 2, "cannot read channel map gone: file not found"),
    ("inspect LOG --dbc gone", 2, "gone: file not found"),
    ("inspect LOG --pipeline gone", 2, "cannot read pipeline gone: file not found"),
    ("map LOG --bike gone", 2, "cannot read bike file gone: file not found"),
    ("map ride.csv --map gone", 2, "cannot read channel map gone: file not found"),
    ("run LOG --bikes gone --out new", 2, "--bikes gone: file not found"),
    ("run LOG --bikes bike.toml --out new", 2, "this is a file; give the folder"),
    ("run LOG --bikes BIKES --out new --model gone", 2, "--model gone: file not found"),
    ("run LOG --bikes BIKES --out new --map gone", 2, "channel map gone: file not found"),
    ("modes gone.toml", 2, "cannot read motorcycle file gone.toml: file not found"),
    ("tyre gone.tir", 2, "cannot read tyre file gone.tir: file not found"),
    ("tyre sharp1971_front --against gone.tdx", 2, "gone.tdx: file not found"),
    ("report out --bench gone.csv", 2, "gone.csv: file not found"),
    ("report out --bench front=gone.tdx", 2, "gone.tdx: file not found"),
    ("report gone", 2, "gone is not a folder"),
    ("verify gone", 2, "gone is not a folder"),
    ("forget gone --session s", 2, "gone is not a folder"),
    ("export gone --session s --format tir", 2, "gone is not a folder"),
    (
        "export out --session archive_s0001 --format tir --tyre front --bikes gone",
        2,
        "gone is not a folder",
    ),
    // a folder that is no output
    ("verify photos", 2, "photos is not an output of roadbench"),
    ("report photos", 2, "photos is not an output of roadbench"),
    ("forget photos --session s", 2, "photos is not an output of roadbench"),
    ("export photos --session s --format tir", 2, "photos is not an output of roadbench"),
    // names that are unknown
    ("report out --figures new --session gone", 2, "no session `gone`"),
    ("report out --open gone", 2, "no session `gone`"),
    ("export out --session gone --format tir", 2, "no session `gone`"),
    ("export out --session archive_s0001 --format gone", 2, "invalid value 'gone'"),
    ("export out --session archive_s0001 --format tir --tyre gone", 2, "invalid value 'gone'"),
    ("forget out --session gone", 2, "no session `gone`"),
    ("forget out --bike gone", 2, "no motorcycle `gone`"),
    ("modes gone", 2, "no motorcycle `gone`"),
    ("replay LOG --motorcycle gone --bikes BIKES", 2, "no motorcycle `gone`"),
    ("replay LOG --motorcycle sports_touring --bikes BIKES --front-tyre gone", 2, "no tyre `gone`"),
    ("tyre gone", 2, "no tyre `gone`"),
    ("simulate lane_change --front-tyre gone --out new", 2, "no tyre `gone`"),
    ("simulate gone --out new", 2, "no scenario `gone`"),
    ("simulate gone.toml --out new", 2, "no scenario `gone.toml`"),
    ("simulate lane_chang --out new", 2, "did you mean `lane_change`?"),
    ("plan gone", 2, "no scenario `gone`"),
    ("plan track", 2, "a plan is for rides of the reduced-order motorcycle"),
    ("schema gone", 2, "no schema `gone`"),
    ("bike new x --class gone --out new", 2, "no class `gone`"),
    ("bike new x --class naked --set gone=3 --out new", 2, "unknown key `gone`"),
    ("completions gone", 2, "invalid value 'gone'"),
    // one kind of file in the place of another
    ("modes bike.toml", 2, "this is a bike file, and a motorcycle file"),
    ("modes scenario.toml", 2, "this is a scenario, and a motorcycle file"),
    (
        "map LOG --bike motorcycle.toml",
        2,
        "this is a motorcycle file of the simulator, and a bike file is wanted",
    ),
    (
        "run LOG --bikes BIKES --out new --pipeline bike.toml",
        2,
        "this is a bike file, and a pipeline is wanted",
    ),
    (
        "diagnose LOG --bikes BIKES --out new --pipeline map.toml",
        2,
        "this is a channel map, and a pipeline",
    ),
    (
        "run LOG --bikes BIKES --out new --map pipeline.toml",
        2,
        "this is a pipeline, and a channel map is wanted",
    ),
    (
        "run LOG --bikes BIKES --out new --model motorcycle.toml",
        2,
        "and a model of `diagnose` is wanted",
    ),
    (
        "tyre motorcycle.toml",
        2,
        "this is a motorcycle file of the simulator, and a tyre file is wanted",
    ),
    ("simulate pipeline.toml --out new", 2, "this is a pipeline, and a scenario is wanted"),
    ("simulate motorcycle.toml --out new", 2, "and a scenario is wanted"),
    ("plan bike.toml", 2, "this is a bike file, and a scenario is wanted"),
    ("inspect bike.toml", 2, "this is a bike file, and a log is wanted"),
    ("convert ride.toml --out new", 2, "this is a scenario, and a log is wanted"),
    ("run motorcycle.toml --bikes BIKES --out new", 2, "and a log is wanted"),
    ("diagnose map.toml --bikes BIKES --out new", 2, "this is a channel map, and a log is wanted"),
    // what is there and cannot be used, or not be written
    ("inspect photos/a.jpg", 1, "a.jpg"),
    ("man bike.toml/new", 3, "a part of the path is a file"),
];

#[test]
fn every_command_says_what_is_wrong_and_ends_with_its_code() {
    let place = place();
    let bikes = format!("{ARCHIVE}/bikes");
    let mut wrong = Vec::new();
    for (line, code, wanted) in CASES {
        let words = line.split_whitespace().map(|w| match w {
            "LOG" => LOG,
            "BIKES" => &bikes,
            w => w,
        });
        let done = roadbench(place.path(), &words.collect::<Vec<_>>());
        let said = String::from_utf8_lossy(&done.stderr);
        // nothing is begun, so nothing is said but the message
        let before = said.lines().find(|l| *code == 2 && l.trim_start().starts_with("INFO"));
        if done.status.code() != Some(i32::from(*code)) {
            wrong.push(format!("{line}: exit code {:?}: {said}", done.status.code()));
        } else if !said.contains(wanted) || said.contains("os error") || before.is_some() {
            wrong.push(format!("{line}: {said}"));
        } else if !done.stdout.is_empty() || place.path().join("new").exists() {
            wrong.push(format!("{line}: something was printed or written"));
        }
    }
    assert!(wrong.is_empty(), "{} of {}:\n{}", wrong.len(), CASES.len(), wrong.join("\n"));
}

#[test]
fn the_version_has_no_riddles() {
    let done = roadbench(Path::new("."), &["--version"]);
    let said = String::from_utf8_lossy(&done.stdout);
    let commit = option_env!("ROADBENCH_COMMIT").unwrap_or("unknown");
    assert!(said.contains(&format!("commit    {commit}")), "{said}");
}

/// Every bundled file is known as what it is, and every scenario is in the help and in the book.
#[test]
fn bundled_files_and_scenarios_are_known() {
    use roadbench::internals::contract::file_kind::FileKind;
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut seen = 0;
    for (folder, kind) in [
        ("pipelines", FileKind::Pipeline),
        ("pipelines/motorcycles", FileKind::Motorcycle),
        ("pipelines/maps", FileKind::ChannelMap),
        ("pipelines/scenarios", FileKind::Scenario),
        ("fixtures/archive/bikes", FileKind::Bike),
        ("fixtures/bikes", FileKind::Bike),
    ] {
        for entry in std::fs::read_dir(root.join(folder)).expect(folder) {
            let path = entry.expect("entry").path();
            let is_toml = path.extension().is_some_and(|e| e == "toml");
            if !is_toml || path.ends_with("other_machines.toml") {
                continue;
            }
            let text = std::fs::read_to_string(&path).expect("text");
            assert_eq!(FileKind::of(&text), Some(kind), "{}", path.display());
            assert!(kind.expect(&text).is_ok());
            seen += 1;
        }
    }
    assert!(seen > 30, "{seen}");
    let names: Vec<&str> = roadbench::internals::simulate::builtin::names().collect();
    let files = std::fs::read_dir(root.join("pipelines/scenarios")).expect("scenarios").count();
    assert_eq!(names.len(), files, "{names:?}");
    let help = roadbench(root, &["simulate", "--help"]);
    let help = String::from_utf8_lossy(&help.stdout).into_owned();
    let page = std::fs::read_to_string(root.join("book/src/simulator.md")).expect("page");
    for name in names {
        assert!(help.contains(name), "{name}: {help}");
        assert!(page.contains(&format!("`{name}`")), "{name} is not in book/src/simulator.md");
    }
}
