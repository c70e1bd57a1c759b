//! The command line's promises: exit codes, what goes to stdout and what to stderr.

use std::path::Path;

use assert_cmd::Command;
use roadbench::internals::cli;

use crate::commands::listed;

const BIKE: &str = "mass = 260.0\nwheelbase = 1.45\ncg_to_front = 0.72\ncg_height = 0.62\n\
    caster_angle = 0.43\n[front]\nradius = 0.3\nwidth = 0.12\n[rear]\nradius = 0.31\nwidth = 0.18\n";

struct Said {
    code: i32,
    out: String,
    err: String,
}

/// Runs the binary in a folder.
fn roadbench(folder: &Path, arguments: &[&str]) -> Said {
    roadbench_with(&[], folder, arguments)
}

/// Runs the binary in a folder, with variables of the environment.
fn roadbench_with(variables: &[(&str, &str)], folder: &Path, arguments: &[&str]) -> Said {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    for name in ["ROADBENCH_BIKES", "ROADBENCH_JOBS", "NO_COLOR", "CLICOLOR_FORCE"] {
        command.env_remove(name);
    }
    command.envs(variables.iter().copied());
    let output = command.current_dir(folder).args(arguments).output().expect("ran");
    Said {
        code: output.status.code().expect("not killed"),
        out: String::from_utf8(output.stdout).expect("utf-8"),
        err: String::from_utf8(output.stderr).expect("utf-8"),
    }
}

/// A folder with `n` logs that are none, and a bike.
fn rubbish(n: usize) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("folder");
    let put = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
        std::fs::write(path, text).expect("file");
    };
    put("bikes/b1.toml", BIKE);
    for i in 0..n {
        put(&format!("sessions/bike=b1/date=2026-05-01/s{i:03}.parquet"), "rubbish");
    }
    folder
}

#[test]
fn bad_usage_is_2_and_writes_nothing() {
    let place = rubbish(1);
    std::fs::write(place.path().join("bad.toml"), "name = \"x\"\n[filter]\nhigh_cutt = 3\n")
        .expect("file");
    for (arguments, named) in [
        (&["run", "sessions", "--out", "out"][..], "--bikes"),
        (&["run", "gone.parquet", "--bikes", "bikes", "--out", "out"], "gone.parquet"),
        (&["run", "sessions", "--bikes", "gone", "--out", "out"], "gone"),
        (&["run", "sessions", "--bikes", "bikes", "--out", "sessions"], "sessions"),
        (&["run", "sessions", "--bikes", "bikes", "--out", "sessions/x/out"], "sessions"),
        (&["run", ".", "--pipeline", "gone.toml", "--out", "out"], "gone.toml"),
        (&["run", ".", "--pipeline", "bad.toml", "--out", "out"], "high_cutt"),
        (&["run", ".", "--jobs", "many", "--out", "out"], "many"),
        (&["run", "."], "--out"),
        (&["report", "sessions", "--figures", "out", "--figure-format", "gif"], "both"),
        (&["report", "sessions", "--figure-format", "png"], "--figures"),
        (&["report", "sessions", "--bike", "b"], "--open"),
        (&["report", "sessions", "--open", "s", "--figures", "out"], "--figures"),
        (&["rum"], "rum"),
        (&["schema", "sesions"], "sesions"),
    ] {
        let said = roadbench(place.path(), arguments);
        assert_eq!(said.code, 2, "{arguments:?}: {}", said.err);
        assert!(said.err.contains(named), "{arguments:?}: {}", said.err);
        assert_eq!(said.out, "", "{arguments:?}");
        assert!(!place.path().join("out").exists(), "{arguments:?}");
    }
}

/// Files of the table of rejected logs, without the one that has no rows.
fn rejected(out: &Path) -> usize {
    let Ok(files) = std::fs::read_dir(out.join("rejected")) else { return 0 };
    files.flatten().filter(|f| f.file_name() != "empty.parquet").count()
}

#[test]
fn rejections_are_1_and_listed_up_to_a_point() {
    let place = rubbish(23);
    let said = roadbench(place.path(), &["run", ".", "--out", "out"]);
    assert_eq!(said.code, 1, "{}", said.err);
    assert!(said.err.contains("23 rejected:"), "{}", said.err);
    let listed = said.err.lines().filter(|l| l.starts_with("  ") && l.ends_with(".parquet"));
    assert_eq!(listed.count(), 20, "{}", said.err);
    assert!(said.err.contains("and 3 more, see rejected/"), "{}", said.err);
    assert!(!said.err.contains('\u{1b}'), "no control codes off a terminal");
    assert_eq!(rejected(&place.path().join("out")), 23);
}

#[test]
fn an_output_that_cannot_be_written_is_3() {
    let place = rubbish(1);
    std::fs::write(place.path().join("file"), "x").expect("file");
    let said = roadbench(place.path(), &["run", ".", "--out", "file/out"]);
    assert_eq!(said.code, 3, "{}", said.err);
    assert!(said.err.contains("file/out"), "{}", said.err);
    assert_eq!(said.err.lines().count(), 1, "one clear error: {}", said.err);
}

#[test]
fn json_logs_are_one_object_per_session() {
    let place = rubbish(3);
    let said = roadbench(place.path(), &["run", ".", "--out", "out", "--log-format", "json"]);
    let lines = said.err.lines().map(|l| serde_json::from_str(l).expect("nothing but json"));
    let events: Vec<serde_json::Value> =
        lines.filter(|event: &serde_json::Value| !event["status"].is_null()).collect();
    assert_eq!(events.len(), 3, "{}", said.err);
    for event in events {
        assert_eq!(event["status"], "rejected");
        assert!(event["log"].as_str().is_some_and(|l| l.ends_with(".parquet")));
        assert!(event["seconds"].is_number() && event["code"].is_string());
    }
}

#[test]
fn the_schemas_are_printed() {
    let said = roadbench(Path::new("."), &["schema", "coefficients"]);
    assert_eq!((said.code, said.err.as_str()), (0, ""));
    assert!(said.out.contains("name = \"std_error\""));
}

/// SIGINT in the middle: the run ends by itself with whole files, and the same command carries on.
#[cfg(unix)]
#[test]
fn a_signal_ends_the_run_and_the_same_command_carries_on() {
    use std::process::{Command, Stdio};
    const LOGS: usize = 600;
    let place = rubbish(LOGS);
    let rows = || rejected(&place.path().join("out"));
    let child = Command::new(assert_cmd::cargo::cargo_bin("roadbench"))
        .current_dir(place.path())
        .args(["run", ".", "--out", "out"])
        .stdout(Stdio::null())
        .stderr(Stdio::from(std::fs::File::create(place.path().join("err")).expect("file")))
        .spawn()
        .expect("child");
    while rows() < 20 {
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let signal = format!("kill -INT {}", child.id());
    assert!(Command::new("sh").args(["-c", &signal]).status().expect("sh").success());
    let status = child.wait_with_output().expect("ended").status;
    let err = std::fs::read_to_string(place.path().join("err")).expect("stderr");
    assert_eq!(status.code(), Some(1), "ended by itself: {err}");
    assert!(err.contains("run the same command again to go on"), "{err}");
    assert!(rows() < LOGS, "it was over before the signal came");
    let said = roadbench(place.path(), &["run", ".", "--out", "out"]);
    assert_eq!((said.code, rows()), (1, LOGS));
    assert!(said.err.contains(&format!("{LOGS} rejected")), "{}", said.err);
}

/// Simulate, run, look: what the README says of motocross, on a shorter ride.
#[test]
fn motocross_goes_from_scenario_to_report() {
    let place = tempfile::tempdir().expect("folder");
    let scenario = roadbench::internals::simulate::motocross::scenario::BUILTIN[0]
        .1
        .replace("duration = 60.0", "duration = 28.0");
    std::fs::write(place.path().join("short.toml"), scenario).expect("file");
    let said = roadbench(place.path(), &["simulate", "short.toml", "--out", "mx"]);
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("1 sessions of motocross"), "{}", said.out);
    let said = roadbench(
        place.path(),
        &["run", "mx", "--pipeline", "offroad", "--signals", "--out", "out"],
    );
    assert_eq!(said.code, 0, "{}", said.err);
    assert!(said.out.contains("Largest forces, rider C"), "{}", said.out);
    assert!(said.out.contains("flights of"), "{}", said.out);
    for table in ["forces", "signals", "manoeuvres", "coefficients"] {
        assert!(place.path().join("out").join(table).is_dir(), "{table}");
    }
    let page = std::fs::read_to_string(place.path().join("out/report/motocross_s0001.html"));
    let page = page.expect("page");
    assert!(page.contains("Riders side by side") && page.contains("Forces by segment and rider"));
    // a second run leaves it as it is, and the rows of a bike that lost its keys are refused by name
    let bike = place.path().join("mx/bikes/motocross.toml");
    let text = std::fs::read_to_string(&bike).expect("bike");
    std::fs::write(&bike, text.replace("linkage", "linkages")).expect("bike");
    let said = roadbench(place.path(), &["run", "mx", "--pipeline", "offroad", "--out", "out"]);
    assert_eq!(said.code, 1);
    assert!(said.err.contains("did you mean `offroad.linkage`"), "{}", said.err);
}

#[test]
fn broken_motocross_scenarios_name_the_key() {
    let place = tempfile::tempdir().expect("folder");
    let text = roadbench::internals::simulate::motocross::scenario::BUILTIN[0].1;
    for (from, to, named) in [
        ("rate = 1600.0", "rate = 20.0", "`rate`"),
        ("kind = \"whoops\"", "kind = \"woops\"", "woops"),
        ("peg_x = -0.19", "peg_q = -0.19", "peg_q"),
        ("offroad.inertia_chassis = 10.8", "offroad.inertia_chasis = 10.8", "inertia_chasis"),
        ("fork_travel = {", "fork_travle = {", "fork_travle"),
        ("unevenness = 0.008 ", "unevenness = 3.0 ", "`unevenness`"),
        ("frequency = [70.0, 140.0]", "frequency = [140.0, 70.0]", "[vibration]"),
        ("ramp = 9.0", "ramp = 0.1", "`ramp`"),
        ("friction = 0.85", "friction = 0.0", "[tyre_rear] `friction`"),
    ] {
        assert!(text.contains(from), "{from}");
        std::fs::write(place.path().join("bad.toml"), text.replace(from, to)).expect("file");
        let said = roadbench(place.path(), &["simulate", "bad.toml", "--out", "out"]);
        assert_eq!(said.code, 2, "{to}: {}", said.err);
        assert!(said.err.contains(named), "{to}: {}", said.err);
        assert!(!place.path().join("out").exists(), "{to}");
    }
    let said = roadbench(place.path(), &["simulate", "motocross", "--compare", "--out", "out"]);
    assert_eq!(said.code, 2);
}

/// Nobody reads the remarks any more: the disk behind stderr is full, or the pipe has ended. The tables come all the same.
#[test]
#[cfg(target_os = "linux")]
fn a_lost_stderr_stops_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let archive = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/archive");
    let log = format!("{archive}/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let lost = || std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
    let (reader, ended) = std::io::pipe().expect("pipe");
    drop(reader);
    use std::process::Stdio;
    for (name, stderr) in [("full", Stdio::from(lost())), ("ended", Stdio::from(ended))] {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_roadbench"));
        command.args(["--verbose", "run", &log, "--bikes"]).arg(format!("{archive}/bikes"));
        command.arg("--out").arg(folder.path().join(name)).stdout(Stdio::from(lost()));
        let status = command.stderr(stderr).status().expect("roadbench starts");
        assert_eq!(status.code(), Some(0), "{name}");
        assert!(folder.path().join(name).join("report/index.html").is_file(), "{name}");
    }
}

/// The help of a command, short and long, with what is shown at its end.
fn helps() -> Vec<(Vec<String>, String)> {
    fn collect(command: &clap::Command, path: &[String], found: &mut Vec<(Vec<String>, String)>) {
        let end = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        found.push((path.to_vec(), end));
        for below in command.get_subcommands() {
            collect(below, &[path, &[below.get_name().to_owned()]].concat(), found);
        }
    }
    let mut found = Vec::new();
    collect(&cli::command(), &[], &mut found);
    found
}

#[test]
fn every_command_is_in_one_group() {
    let said = roadbench(Path::new("."), &["--help"]);
    let mut shown = listed(&said.out);
    shown.sort_unstable();
    let program = cli::command();
    let mut all: Vec<&str> = program.get_subcommands().map(clap::Command::get_name).collect();
    all.sort_unstable();
    assert_eq!(shown, all, "a new command belongs into a group (src/cli/mod.rs)");
    for heading in ["Analyse:", "Prepare:", "Simulate:", "Maintain:", "Global options:"] {
        assert_eq!(said.out.lines().filter(|l| *l == heading).count(), 1, "{heading}");
    }
    let said = roadbench(Path::new("."), &["run", "--help"]);
    assert!(said.out.contains("\nOptions:\n") && said.out.contains("\nGlobal options:\n"));
}

/// On a wide terminal, too; examples stay on their lines.
#[test]
fn help_has_80_columns() {
    for (path, end) in helps() {
        for option in ["-h", "--help"] {
            let path: Vec<&str> = path.iter().map(String::as_str).chain([option]).collect();
            let said = roadbench_with(&[("COLUMNS", "200")], Path::new("."), &path);
            let wide: Vec<&str> = said.out.lines().filter(|l| l.chars().count() > 80).collect();
            assert!(wide.is_empty(), "{path:?}: {wide:#?}");
            let printed: Vec<&str> = said.out.lines().map(str::trim_end).collect();
            for line in end.lines().map(str::trim_end) {
                assert!(printed.contains(&line), "{path:?}: `{line}` is wrapped");
            }
        }
    }
}

#[test]
fn options_have_their_usual_letters() {
    let program = cli::command();
    let mut outs = 0;
    let usual = [("out", 'o'), ("jobs", 'j'), ("quiet", 'q'), ("verbose", 'v')];
    fn all<'a>(command: &'a clap::Command, found: &mut Vec<&'a clap::Command>) {
        found.push(command);
        command.get_subcommands().for_each(|below| all(below, found));
    }
    let mut commands = Vec::new();
    all(&program, &mut commands);
    for command in commands {
        for option in command.get_arguments() {
            let Some(long) = option.get_long() else { continue };
            let letter = usual.iter().find(|(name, _)| *name == long).map(|(_, letter)| *letter);
            assert_eq!(option.get_short(), letter, "{} --{long}", command.get_name());
            outs += usize::from(long == "out");
        }
    }
    assert_eq!(outs, 12);
    let place = rubbish(3);
    let said = roadbench(place.path(), &["run", ".", "-vj1", "-o", "out"]);
    assert_eq!((said.code, rejected(&place.path().join("out"))), (1, 3), "{}", said.err);
    assert!(said.err.contains("DEBUG") && said.err.contains("planned"), "{}", said.err);
    let said = roadbench(place.path(), &["-vv", "run", ".", "-o", "out"]);
    assert_eq!(said.code, 1, "{}", said.err);
    // what failed is still said
    let said = roadbench(place.path(), &["run", ".", "-qo", "quiet"]);
    assert_eq!((said.code, said.out.as_str()), (1, ""), "{}", said.err);
    assert!(!said.err.contains("INFO") && said.err.contains("3 rejected"), "{}", said.err);
    let said = roadbench(place.path(), &["schema", "-q", "-v"]);
    assert_eq!(said.code, 2);
}

/// Requested results are printed, remarks are not.
#[test]
fn quiet_leaves_out_notes() {
    let place = tempfile::tempdir().expect("folder");
    let loud = roadbench(place.path(), &["man", "loud"]);
    let quiet = roadbench(place.path(), &["man", "quiet", "--quiet"]);
    assert_eq!((loud.code, quiet.code, quiet.out.as_str()), (0, 0, ""), "{}", quiet.err);
    assert!(loud.out.contains("pages in loud") && place.path().join("quiet/roadbench.1").is_file());
    let said = roadbench(place.path(), &["schema", "coefficients", "-q"]);
    assert!(said.out.contains("name = \"std_error\""));
    let archive = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/archive");
    let log = format!("{archive}/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let bikes = format!("{archive}/bikes");
    let said = roadbench(place.path(), &["run", &log, "--bikes", &bikes, "-q", "-o", "out"]);
    assert_eq!((said.code, said.out.as_str()), (0, ""), "{}", said.err);
    assert!(!said.err.contains("INFO"), "{}", said.err);
    assert!(place.path().join("out/report/index.html").is_file());
}

/// An option that is given goes before the variable, and a variable that is empty is none.
#[test]
fn variables_stand_in_for_options() {
    let place = rubbish(1);
    let run = |bikes: &str, more: &[&str]| {
        let arguments = [&["run", "sessions", "--out", "out"][..], more].concat();
        roadbench_with(&[("ROADBENCH_BIKES", bikes)], place.path(), &arguments)
    };
    let said = run("gone", &[]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("gone"), "{}", said.err);
    let said = run("", &[]);
    assert_eq!(said.code, 2, "{}", said.err);
    assert!(said.err.contains("--bikes"), "{}", said.err);
    for (bikes, more) in [("bikes", &[][..]), ("gone", &["--bikes", "bikes"])] {
        let said = run(bikes, more);
        assert_eq!(said.code, 1, "{bikes}: {}", said.err);
        assert!(said.err.contains("1 rejected"), "{bikes}: {}", said.err);
    }
    // far too many are said to be
    let jobs = |jobs: &str, arguments: &[&str]| {
        roadbench_with(&[("ROADBENCH_JOBS", jobs)], place.path(), arguments)
    };
    assert!(jobs("1024", &["schema"]).err.contains("1024"));
    assert_eq!(jobs("1024", &["schema", "-j", "1"]).err, "");
    assert_eq!(jobs("1024", &["--jobs", "1", "schema"]).err, "");
    assert!(jobs("1", &["-j1024", "schema"]).err.contains("1024"));
    assert_eq!(jobs("", &["schema"]).err, "");
    let said = jobs("many", &["schema"]);
    assert_eq!(said.code, 2);
    assert!(said.err.contains("many"), "{}", said.err);
    for command in ["run", "diagnose", "inspect", "export", "replay"] {
        let said = roadbench(place.path(), &[command, "--help"]);
        for variable in ["[env: ROADBENCH_BIKES]", "[env: ROADBENCH_JOBS]"] {
            assert!(said.out.contains(variable), "{command}: {variable}");
        }
    }
}

/// `--color` goes before the environment, for messages, help and errors of usage.
#[test]
fn colours_are_as_asked() {
    for (variable, option, coloured) in [
        (("CLICOLOR_FORCE", "1"), "auto", true),
        (("CLICOLOR_FORCE", "1"), "never", false),
        (("NO_COLOR", "1"), "always", true),
        (("NO_COLOR", "1"), "auto", false),
    ] {
        for arguments in [&["schema", "nope"][..], &["schema", "--help"], &["schema", "--nope"]] {
            let arguments = [&["--color", option], arguments].concat();
            let said = roadbench_with(&[variable], Path::new("."), &arguments);
            let has = said.out.contains('\u{1b}') || said.err.contains('\u{1b}');
            assert_eq!(has, coloured, "{variable:?} {arguments:?}: {}{}", said.out, said.err);
        }
    }
}
