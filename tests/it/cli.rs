//! The command line's promises: exit codes, what goes to stdout and what to stderr.

use std::path::Path;

use assert_cmd::Command;

const BIKE: &str = "mass = 260.0\nwheelbase = 1.45\ncg_to_front = 0.72\ncg_height = 0.62\n\
    caster_angle = 0.43\n[front]\nradius = 0.3\nwidth = 0.12\n[rear]\nradius = 0.31\nwidth = 0.18\n";

struct Said {
    code: i32,
    out: String,
    err: String,
}

/// Runs the binary in a folder.
fn roadbench(folder: &Path, arguments: &[&str]) -> Said {
    let output = Command::cargo_bin("roadbench")
        .expect("binary")
        .current_dir(folder)
        .args(arguments)
        .output()
        .expect("ran");
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
    assert!(err.contains("the same command carries on"), "{err}");
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
