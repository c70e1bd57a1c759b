//! `roadbench diagnose` on an archive: again, after a change, killed, in an object store.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use roadbench::internals::batch::store::contents::Contents;
use roadbench::internals::batch::store::kind;

use crate::script::killed_after;

/// Short rides with a steering sensor that is off and velocities that come late.
struct Archive {
    folder: tempfile::TempDir,
}

type Files = BTreeMap<String, Vec<u8>>;

impl Archive {
    /// Sessions whose diagnosis is there.
    fn diagnosed(&self, out: &str) -> usize {
        let there = Contents::read(&kind::DIAGNOSE, &self.path(out).into()).expect("read");
        there.sessions().count()
    }

    fn new(sessions: usize) -> Self {
        let archive = Archive { folder: tempfile::tempdir().expect("folder") };
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/scenarios/demo.toml");
        let text = std::fs::read_to_string(path).expect("the demo's scenario");
        let short = text
            .replace("coasts = 8, brakings = 5, laps = 9", "coasts = 1, brakings = 1, laps = 1")
            .replace("sessions_per_bike = 2", &format!("sessions_per_bike = {sessions}"))
            .replace("seed = 3", "seed = 2"); // three of its rides show a steering zero that they share
        assert!(short.contains("laps = 1"), "the demo has another plan");
        std::fs::write(archive.path("short.toml"), short).expect("written");
        archive.succeed(&["simulate", "short.toml", "--out", "in"]);
        archive
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"));
        command.args(arguments).current_dir(self.folder.path());
        command
    }

    fn succeed(&self, arguments: &[&str]) -> String {
        let Output { status, stdout, stderr } =
            self.command(arguments).output().expect("roadbench starts");
        assert!(status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&stderr));
        String::from_utf8_lossy(&stdout).into_owned()
    }

    /// Diagnoses what `input` names, with few nulls and more options.
    fn diagnose(&self, input: &str, out: &str, more: &[&str]) -> String {
        self.succeed(&[&["diagnose", input, "--out", out, "--nulls", "8"], more].concat())
    }

    /// Every file of an output but for the lock.
    fn files(&self, out: &str) -> Files {
        let root = self.path(out);
        let files = walkdir::WalkDir::new(&root).into_iter().map(|e| e.expect("entry"));
        files
            .filter(|e| {
                e.file_type().is_file() && !e.file_name().to_string_lossy().ends_with(".lock")
            })
            .map(|e| {
                let name = e.path().strip_prefix(&root).expect("below").to_string_lossy();
                (name.replace('\\', "/"), std::fs::read(e.path()).expect("bytes"))
            })
            .collect()
    }

    fn logs(&self) -> Vec<PathBuf> {
        let mut logs: Vec<PathBuf> = walkdir::WalkDir::new(self.path("in/sessions"))
            .into_iter()
            .map(|e| e.expect("entry").into_path())
            .filter(|p| p.extension().is_some_and(|e| e == "parquet"))
            .collect();
        logs.sort();
        logs
    }
}

fn assert_same(a: &Files, b: &Files) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(a), names(b));
    let differs = a.iter().find(|(name, bytes)| b[*name] != **bytes);
    assert!(differs.is_none(), "{:?} differs", differs.map(|(name, _)| name));
}

#[test]
fn what_is_diagnosed_is_kept_and_what_has_changed_is_done_again() {
    let archive = Archive::new(3);
    let first = archive.diagnose("in", "out", &[]);
    // what they share first; each ride in full is asked for
    assert!(
        first.starts_with("3 rides: ") && first.contains("\nAll rides of demo_01: "),
        "{first}"
    );
    assert!(first.ends_with("Report: out/report/index.html\n"), "{first}");
    let in_full = archive.diagnose("in", "again", &["-v"]);
    assert!(in_full.contains("\ndemo_s0003  demo_01\n"), "{in_full}");
    let whole = archive.files("out");
    for table in ["causes", "discrepancies", "replays", "diagnoses", "models"] {
        let own = |name: &&String| name.starts_with(&format!("{table}/bike=demo_01/"));
        let n = if table == "models" { 3 } else { 1 }; // a table's rows of a month are one file
        assert_eq!(whole.keys().filter(own).count(), n, "{table}");
    }
    let shared = String::from_utf8(whole["models/pooled.toml"].clone()).expect("text");
    assert!(shared.contains("effect = \"steer_zero\"\nlevel = \"bike\""), "{shared}");
    let start = Instant::now();
    let again = archive.diagnose("in", "out", &[]);
    println!("a second run on 3 rides: {:?}", start.elapsed());
    assert!(again.starts_with("3 logs, nothing has changed in out\n"), "{again}");
    assert!(again.contains("Report: out/report/index.html"), "{again}");
    // the answer is read back: of all rides, and of one
    let shown = archive.succeed(&["show", "out"]);
    assert!(shown.starts_with("3 rides: "), "{shown}");
    let one = archive.succeed(&["show", "out", "--session", "demo_s0003"]);
    assert!(one.starts_with("demo_s0003  demo_01\n"), "{one}");
    assert!(one.contains("Report: out/report/index.html"), "{one}");
    let rows = archive.succeed(&["show", "out", "--session", "demo_s0003", "--json"]);
    // its causes, and how it compares with the others
    let of = |table: &str| {
        rows.lines().filter(|l| l.contains(&format!("\"table\":\"{table}\""))).count()
    };
    assert!(
        of("causes") > 0 && of("changes") == 1 && rows.lines().count() == of("causes") + 1,
        "{rows}"
    );
    assert_same(&archive.files("out"), &whole);

    // what would be done, and why
    let dry = |more: &[&str]| archive.diagnose("in", "out", &[more, &["--dry-run"]].concat());
    let settings = "the bike file or the settings have changed";
    assert!(dry(&[]).contains("0 to compute, 3 unchanged"));
    assert_eq!(dry(&["--advise"]).matches(settings).count(), 3);
    assert_eq!(dry(&["--force"]).matches("compute ").count(), 3);
    let nulls = ["diagnose", "in", "--out", "out", "--nulls", "9", "--dry-run"];
    assert_eq!(archive.succeed(&nulls).matches(settings).count(), 3);
    let bike = archive.path("in/bikes/demo_01.toml");
    let text = std::fs::read_to_string(&bike).expect("bike");
    std::fs::write(&bike, {
        let mass = text.lines().find(|l| l.starts_with("mass")).expect("mass");
        text.replace(mass, "mass = 251.0")
    })
    .expect("written");
    assert_eq!(dry(&[]).matches(settings).count(), 3);
    std::fs::write(&bike, text).expect("written");
    let [one, two, _] = &archive.logs()[..] else { panic!("three logs") };
    let kept = std::fs::read(one).expect("log");
    let mut changed = kept.clone();
    changed[1000] ^= 1; // a sample: the footer, which says who it is, stays
    std::fs::write(one, changed).expect("written");
    assert!(dry(&[]).contains("the log has changed"));
    std::fs::write(one, kept).expect("written");
    assert_same(&archive.files("out"), &whole);

    // a lost table is made again
    let causes =
        whole.keys().find(|name| name.starts_with("causes/bike=demo_01/")).expect("causes");
    std::fs::remove_file(archive.path("out").join(causes)).expect("lost");
    let mended = archive.diagnose("in", "out", &["--json"]);
    assert!(mended.contains("demo_s0002") && mended.contains("\"demo_s0001\""), "{mended}");
    assert_same(&archive.files("out"), &whole);

    // session by session gives what all at once give, what they share included
    let log = |path: &Path| path.strip_prefix(archive.folder.path()).expect("below").to_owned();
    let stale = archive.path("grown/models/pooled.toml");
    std::fs::create_dir_all(stale.parent().expect("folder")).expect("folder");
    std::fs::write(&stale, &shared).expect("written");
    std::fs::create_dir_all(archive.path("grown/.roadbench")).expect("folder");
    std::fs::write(archive.path("grown/.roadbench/checksums.json"), "{}").expect("an output");
    archive.diagnose(&log(one).to_string_lossy(), "grown", &["--bikes", "in/bikes"]);
    assert!(!stale.exists(), "one session shares nothing");
    archive.diagnose(&log(two).to_string_lossy(), "grown", &["--bikes", "in/bikes"]);
    archive.diagnose("in", "grown", &[]);
    assert_same(&archive.files("grown"), &whole);
}

#[test]
fn a_diagnosis_and_a_run_may_share_an_output() {
    let archive = Archive::new(2);
    archive.succeed(&["run", "in", "--out", "out"]);
    archive.diagnose("in", "out", &[]);
    // and a run may be freed of what the same output says
    let with = ["run", "in", "--out", "freed", "--model", "out"];
    archive.succeed(&with);
    assert!(archive.succeed(&with).contains("nothing has changed"));
    let dry = ["run", "in", "--out", "out", "--dry-run"];
    assert!(archive.succeed(&dry).contains("0 to compute, 2 unchanged"));
    assert!(archive.diagnose("in", "out", &["--dry-run"]).contains("0 to compute, 2 unchanged"));
    assert!(archive.succeed(&["run", "in", "--out", "out"]).contains("nothing has changed"));
    // what is too short for one of the two is rejected for that one, whichever runs last
    std::fs::copy(archive.path("short.toml"), archive.path("shorter.toml")).expect("copied");
    let text = std::fs::read_to_string(archive.path("shorter.toml")).expect("scenario");
    let shorter = text
        .replace("coasts = 1, brakings = 1, laps = 1", "coasts = 1, brakings = 0, laps = 0")
        .replace("name = \"demo\"", "name = \"short\"");
    std::fs::write(archive.path("shorter.toml"), shorter).expect("written");
    archive.succeed(&["simulate", "shorter.toml", "--out", "brief"]);
    archive.succeed(&["run", "brief", "--out", "out"]);
    let arguments = ["diagnose", "brief", "--out", "out", "--nulls", "8"];
    let refused = archive.command(&arguments).output().expect("roadbench starts");
    assert_eq!(refused.status.code(), Some(1));
    let rejected = |files: &Files| files.keys().filter(|n| n.starts_with("rejected/")).count();
    let there = rejected(&archive.files("out"));
    assert!(there > 0, "{}", String::from_utf8_lossy(&refused.stderr));
    archive.succeed(&["run", "brief", "--out", "out", "--force"]);
    assert_eq!(rejected(&archive.files("out")), there);
}

/// Kills a diagnosis at instants spread over its duration and lets each be taken up.
fn kills(sessions: usize, rounds: usize) {
    let archive = Archive::new(sessions);
    let start = Instant::now();
    archive.diagnose("in", "whole", &[]);
    let mut duration = start.elapsed();
    let whole = archive.files("whole");
    let (mut early, mut between, mut tries) = (0, 0, 0);
    while early < rounds && tries < 3 * rounds {
        tries += 1;
        let _ = std::fs::remove_dir_all(archive.path("out"));
        let child = archive
            .command(&["diagnose", "in", "--out", "out", "--nulls", "8"])
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("roadbench starts");
        let ended = killed_after(child, duration.mul_f64((early as f64 + 0.7) / rounds as f64));
        early += usize::from(ended.is_none());
        // the machine was busier when it was timed: the next ones are killed sooner
        duration = ended.map_or(duration, |lived| duration.min(lived));
        let left = archive.files("out");
        for (name, bytes) in left.iter().filter(|(name, _)| name.ends_with(".parquet")) {
            assert!(bytes.len() > 8 && bytes.ends_with(b"PAR1"), "{name} is not whole");
        }
        let done = left.keys().filter(|n| n.starts_with("diagnoses/")).count();
        between += usize::from(done > 0 && done < sessions);
        archive.diagnose("in", "out", &[]);
        assert_same(&archive.files("out"), &whole);
    }
    println!(
        "{sessions} rides ({duration:?} undisturbed): {early} of {rounds} killed before the end, \
         {between} of them with some sessions done"
    );
    assert_eq!(early, rounds, "diagnoses that were killed before their end");
}

#[test]
fn a_diagnosis_killed_at_any_instant_is_taken_up() {
    kills(3, 6);
}

#[test]
#[ignore = "minutes; the same at twenty instants: cargo nextest run --run-ignored all twenty_kills"]
fn twenty_kills() {
    kills(4, 20);
}

/// Ctrl-C lets the sessions under way finish; the same command goes on.
#[cfg(unix)]
#[test]
fn a_stopped_diagnosis_finishes_what_is_under_way() {
    let archive = Archive::new(3);
    let child = archive
        .command(&["diagnose", "in", "--out", "out", "--nulls", "8", "--jobs", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("roadbench starts");
    let under_way = || archive.path("out/.roadbench.lock").exists();
    for _ in 0..600 {
        if under_way() {
            break;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    std::thread::sleep(Duration::from_millis(300));
    let id = child.id().to_string();
    let killed = Command::new("kill").args(["-TERM", &id]).status().expect("kill");
    assert!(killed.success());
    let output = child.wait_with_output().expect("ended");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("run the same command again to go on"), "{said}");
    let done = archive.files("out").keys().filter(|n| n.starts_with("diagnoses/")).count();
    assert!((1..3).contains(&done), "{done} done\n{said}");
    archive.diagnose("in", "out", &[]);
    archive.diagnose("in", "whole", &[]);
    assert_same(&archive.files("out"), &archive.files("whole"));
}

#[cfg(feature = "cloud")]
mod store {
    use super::*;
    use crate::objects::run;
    use crate::s3_server::Server;

    const THERE: [&str; 6] =
        ["diagnose", "s3://fleet/in", "--out", "s3://fleet/out", "--nulls", "8"];

    /// Tables and pages; `diagnoses` names the logs and their hashes, which differ in a store.
    fn comparable(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Files {
        let other = |name: &str| name.starts_with('.') || name.starts_with("diagnoses/");
        files.into_iter().filter(|(name, _)| !other(name)).collect()
    }

    #[test]
    fn a_diagnosis_in_a_failing_store_is_that_on_disk() {
        let archive = Archive::new(2);
        archive.diagnose("in", "out", &[]);
        let server = Server::start();
        for (name, bytes) in archive.files("in") {
            server.put(&format!("in/{name}"), bytes);
        }
        server.faults(11, 0.1, 25);
        let (code, said) = run(&server, &THERE);
        assert_eq!(code, 0, "{said}");
        server.faults(0, 0.0, 0);
        let below = || server.below("out/").into_iter().map(|(n, b)| (n, b.to_vec()));
        assert_same(&comparable(below()), &comparable(archive.files("out")));
        assert_eq!(archive.diagnosed("out"), 2);

        let freed =
            ["run", "s3://fleet/in", "--out", "s3://fleet/freed", "--model", "s3://fleet/out"];
        let (code, said) = run(&server, &freed);
        assert_eq!(code, 0, "{said}");
        archive.succeed(&["run", "in", "--out", "freed", "--model", "out"]);
        let warnings = |files: Files| -> Files {
            files.into_iter().filter(|(name, _)| name.starts_with("warnings/")).collect()
        };
        let there = server.below("freed/").into_iter().map(|(n, b)| (n, b.to_vec())).collect();
        assert_same(&warnings(there), &warnings(archive.files("freed")));

        std::thread::sleep(Duration::from_secs(3)); // what the client gave up may still be done
        let _ = server.seen();
        let (code, said) = run(&server, &THERE);
        assert_eq!(code, 0, "{said}");
        assert!(said.contains("nothing has changed") || said.contains("killed"), "{said}");
        if said.contains("nothing has changed") {
            let seen = server.seen();
            let logs = seen.iter().filter(|s| s.method == "GET" && s.key.contains("in/sessions"));
            assert_eq!(logs.count(), 0, "logs that are known are not fetched");
        }
        assert_same(&comparable(below()), &comparable(archive.files("out")));
    }
}

/// The event of a session says how many samples it has, as that of `run` does.
#[test]
fn events_have_the_samples_of_the_session() {
    let archive = Archive::new(1);
    let samples = |command: &[&str]| {
        let all = [command, &["--log-format", "json"]].concat();
        let output = archive.command(&all).output().expect("roadbench starts");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        let events = said.lines().filter_map(|l| serde_json::from_str(l).ok());
        let samples: Vec<i64> =
            events.filter_map(|e: serde_json::Value| e["samples"].as_i64()).collect();
        assert_eq!(samples.len(), 1, "{said}");
        samples[0]
    };
    let run = samples(&["run", "in", "--out", "run"]);
    assert!(run > 1000, "{run}");
    assert_eq!(samples(&["diagnose", "in", "--out", "out", "--nulls", "8"]), run);
}
