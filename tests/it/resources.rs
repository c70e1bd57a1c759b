//! What fails for want of the machine's resources is not the logs' fault: rows of an earlier night stay.

use std::collections::BTreeMap;
use std::fs::Permissions;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use roadbench::internals::batch::jobs::bikes::BikeFile;
use roadbench::internals::batch::jobs::work::Output as WorkOutput;
use roadbench::internals::batch::store::kind::Kind;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Accounts, Error, Work};
use roadbench::internals::ingest::Identified;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::{Input, Outcome, Pipeline, Rejection};
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::registry;

use crate::disk::Small;
use crate::fence::{Archive, busy_worker, constant_rows_of, signal, whole};
use crate::script::{Place, Script, adds_up, codes};

/// The rows of sessions in an output: no table over all of them, mark or rejection.
fn rows(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let folder = |path: &Path| path.iter().next().map(|f| f.to_string_lossy().into_owned());
    let is_row = |path: &Path| {
        let folder = folder(path).unwrap_or_default();
        let other = ["report", "rejected", ".roadbench", ".roadbench.lock"];
        !other.contains(&&*folder) && registry::of_fleet().all(|spec| spec.name != folder)
    };
    whole(out).into_iter().filter(|(path, _)| is_row(path)).collect()
}

fn said(done: &Output) -> String {
    String::from_utf8_lossy(&done.stderr).into_owned()
}

/// The system's killer takes the worker twice: the log's earlier rows stay, and it is tried again.
#[test]
fn a_worker_that_is_killed_from_outside_costs_no_rows() {
    let archive = Archive::new();
    assert!(archive.run("out", &[]).status.success());
    let (good, good_rows) = (whole(&archive.path("out")), rows(&archive.path("out")));
    let log = archive.log("date=2026-05-01/archive_s0001.parquet");
    let bytes = std::fs::read(&log).expect("a log");
    // the same session, and slow to read
    let who = [("session_id", "archive_s0001"), ("bike_id", "archive_01")];
    constant_rows_of(&log, 6_000_000, &who);
    for night in ["the second", "the third"] {
        let slow = ["--jobs", "1", "--memory-limit", "8"];
        let mut batch = archive.command("out", &slow).spawn().expect("started");
        let first = busy_worker(&batch);
        signal("KILL", first);
        let second = loop {
            let worker = busy_worker(&batch);
            if worker != first {
                break worker;
            }
        };
        signal("KILL", second);
        assert_eq!(batch.wait().expect("ended").code(), Some(1), "{night}");
        let [row] = &archive.rejected("out")[..] else { panic!("one is rejected") };
        assert_eq!((row.code.as_str(), row.limits.as_deref()), ("killed", None), "{night}");
        assert!(row.message.contains("SIGKILL"), "{}", row.message);
        assert!(row.message.contains("next run") && !row.message.contains("report"));
        assert!(rows(&archive.path("out")) == good_rows, "{night}: rows went");
        assert_eq!(archive.sessions("out"), 12, "{night}");
    }
    std::fs::write(&log, bytes).expect("as it was");
    assert!(archive.run("out", &[]).status.success());
    assert!(whole(&archive.path("out")) == good, "not what the first night wrote");
}

/// Somebody who may not do everything, and of whom nothing else runs.
struct Somebody {
    /// None where this process is nobody special itself.
    user: Option<u32>,
    program: PathBuf,
    _folder: tempfile::TempDir,
}

impl Somebody {
    /// None where the system has not what it takes.
    fn new(archive: &Archive) -> Option<Self> {
        let folder = tempfile::tempdir().expect("folder");
        let program = folder.path().join("roadbench");
        let built = Path::new(env!("CARGO_BIN_EXE_roadbench"));
        if std::fs::hard_link(built, &program).is_err() {
            std::fs::copy(built, &program).expect("copied");
        }
        let is_root = std::fs::metadata(folder.path()).expect("there").uid() == 0;
        let user = is_root.then(|| 400_000_000 + std::process::id());
        let somebody = Somebody { user, program, _folder: folder };
        if let Some(user) = user {
            for place in [somebody._folder.path(), &archive.path(".")] {
                std::fs::set_permissions(place, Permissions::from_mode(0o755)).expect("opened");
            }
            for entry in walkdir::WalkDir::new(archive.path(".")) {
                let entry = entry.expect("entry");
                std::os::unix::fs::chown(entry.path(), Some(user), Some(user)).expect("given");
            }
        }
        let can = somebody.command(&["--nofile=100"]).arg("--version").output();
        if can.as_ref().is_ok_and(|done| done.status.success()) {
            return Some(somebody);
        }
        println!("skipped: no setpriv and prlimit here, or not for us ({can:?})");
        None
    }

    fn command(&self, limits: &[&str]) -> Command {
        let mut command = Command::new("prlimit");
        if let Some(user) = self.user {
            command = Command::new("setpriv");
            command.arg(format!("--reuid={user}")).arg(format!("--regid={user}"));
            command.args(["--clear-groups", "prlimit"]);
        }
        command.args(limits).arg(&self.program).current_dir("/");
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    fn run(&self, limits: &[&str], archive: &Archive, more: &[&str]) -> Output {
        let mut command = self.command(limits);
        command.arg("run").arg(archive.path("logs")).arg("--out").arg(archive.path("out"));
        command.args(more).output().expect("started")
    }
}

/// Whatever is missing, a run does what it can and says the rest in a sentence; no row is lost, not even with --force.
#[test]
fn a_run_without_processes_files_stack_or_memory_costs_no_rows() {
    // of short rides two are open at once so often that nine files are too few
    let archive = Archive::complete();
    let Some(somebody) = Somebody::new(&archive) else { return };
    assert!(somebody.run(&["--nofile=1000"], &archive, &[]).status.success());
    let good = rows(&archive.path("out"));
    assert_eq!(archive.sessions("out"), 12);
    let is_counted = somebody.user.is_some(); // else others' processes are counted, too
    for (limit, jobs, wanted, word) in [
        ("--nproc=60:60", "999", &[0][..], "--jobs 999"),
        ("--nproc=24:24", "16", &[0], "can be started"),
        ("--nproc=6:6", "0", &[0, 3], "no worker process can be started"),
        ("--nproc=1:1", "0", &[0, 3], "no thread can be started"),
        ("--nofile=30:30", "16", &[0], ""),
        ("--nofile=9:9", "0", &[0], ""),
        ("--nofile=4:4", "0", &[3], "Too many open files"),
        ("--stack=131072:131072", "0", &[0], ""),
        ("--as=300000000:300000000", "0", &[3], "ulimit -v"),
        ("--data=100000000:100000000", "0", &[3], "ulimit -d"),
    ] {
        if limit.starts_with("--nproc") && !is_counted {
            println!("skipped: {limit}, which counts all that this user runs");
            continue;
        }
        let done = somebody.run(&[limit], &archive, &["--force", "--jobs", jobs]);
        let (code, said) = (done.status.code(), said(&done));
        assert!(wanted.iter().any(|w| code == Some(*w)), "{limit}: {code:?}\n{said}");
        assert!(said.contains(word), "{limit}: {said}");
        assert!(!said.contains("backtrace"), "{limit}: {said}");
        if code == Some(3) {
            let own = said.lines().filter(|l| l.starts_with("roadbench: ")).count();
            assert_eq!(own, 1, "{limit}: one sentence\n{said}");
        }
        assert_eq!(archive.rejected("out").len(), 0, "{limit}: {said}");
        assert!(rows(&archive.path("out")) == good, "{limit}: not the rows of the good night");
    }
}

/// The output's tables are copied here to be worked on: where there is no room for them, that is no fault of the objects.
#[test]
#[cfg(feature = "cloud")]
fn a_full_temporary_folder_is_told_from_the_store() {
    let server = crate::s3_server::Server::start();
    let (place, archive) = (Place::new(&[]), Archive::new());
    let Some(small) = Small::new(&place, "64k") else {
        println!("skipped: no file system may be mounted here");
        return;
    };
    let run = |temporary: &Path| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_roadbench"));
        command.arg("run").arg(archive.path("logs")).args(["--out", "s3://fleet/out"]);
        command.envs(server.environment()).env("TMPDIR", temporary).output().expect("started")
    };
    for (temporary, why) in
        [(small.0.as_path(), "No space left"), (&place.path("none"), "file not found")]
    {
        let done = run(temporary);
        let said = said(&done);
        assert_eq!(done.status.code(), Some(3), "{said}");
        let last = said.lines().find(|l| l.starts_with("roadbench: ")).expect("a sentence");
        let folder = temporary.display().to_string();
        for word in [why, "set TMPDIR", folder.as_str()] {
            assert!(last.contains(word), "{word}: {last}");
        }
        assert!(!last.contains("s3://"), "{last}");
    }
    let done = run(&place.path("."));
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
}

/// A log that may not be read tonight, and a folder that may not be searched.
#[test]
fn an_unreadable_log_keeps_its_rows_until_it_is_readable() {
    let archive = Archive::new();
    let bad = archive.log("date=2026-05-02/bad.parquet");
    std::fs::write(&bad, "no table").expect("written");
    let Some(somebody) = Somebody::new(&archive) else { return };
    let night = || somebody.run(&["--nofile=1000"], &archive, &[]);
    let other = |command: &[&str]| {
        let mut own = somebody.command(&["--nofile=1000"]);
        own.arg(command[0]).arg(archive.path("out")).args(&command[1..]).output().expect("started")
    };
    assert_eq!(night().status.code(), Some(1), "a bad log is rejected");
    let good = whole(&archive.path("out"));
    let good_rows = rows(&archive.path("out"));
    let codes = || {
        let all = archive.rejected("out");
        let name = |path: &str| path.rsplit('/').next().expect("a name").to_owned();
        all.iter().map(|r| (name(&r.path), r.code.clone())).collect::<BTreeMap<_, _>>()
    };
    let log = archive.log("date=2026-05-01/archive_s0001.parquet");
    let folder = archive.log("date=2026-05-02");
    let may = |at: &Path, mode| {
        std::fs::set_permissions(at, Permissions::from_mode(mode)).expect("changed");
    };
    // a folder that may not be listed, and one that nothing may be reached in either
    for closed in [0o311, 0o000] {
        may(&log, 0o000);
        may(&folder, closed);
        let done = night();
        assert_eq!(done.status.code(), Some(1), "{}", said(&done));
        let now = codes();
        assert_eq!(now["archive_s0001.parquet"], "unreadable", "{now:?}");
        assert_eq!(now["date=2026-05-02"], "unreadable", "{now:?}");
        assert_eq!(now["bad.parquet"], "not_parquet", "what cannot be seen is not gone: {now:?}");
        assert!(rows(&archive.path("out")) == good_rows, "rows went");
        if closed == 0 {
            let done = other(&["forget", "--missing"]);
            assert_eq!(done.status.code(), Some(3), "{}", said(&done));
            assert!(said(&done).contains("cannot tell whether"), "{}", said(&done));
        }
        let done = other(&["verify"]);
        let found = String::from_utf8_lossy(&done.stdout);
        assert!(found.contains("log_unreadable") && !found.contains("log_missing"), "{found}");
        assert!(rows(&archive.path("out")) == good_rows, "rows went");
    }
    may(&log, 0o644);
    may(&folder, 0o755);
    assert_eq!(night().status.code(), Some(1));
    assert!(whole(&archive.path("out")) == good, "not what the first night wrote");
}

#[test]
fn a_name_that_is_no_text_is_a_log_to_a_pattern() {
    let archive = Archive::new();
    let log = archive.log("date=2026-05-01/archive_s0001.parquet");
    std::fs::rename(&log, log.with_file_name(std::ffi::OsStr::from_bytes(b"f\xfcr.parquet")))
        .expect("renamed");
    let done = Command::new(env!("CARGO_BIN_EXE_roadbench"))
        .arg("run")
        .arg(archive.log("date=*/*.parquet"))
        .args(["--bikes".as_ref(), archive.path("logs/bikes").as_os_str()])
        .args(["--out".as_ref(), archive.path("out").as_os_str()])
        .output()
        .expect("started");
    assert_eq!(done.status.code(), Some(0), "{}", said(&done));
    assert_eq!(archive.sessions("out"), 6);
}

/// Replaces a log by another text: between plan and work, or while it is read.
struct Replaces {
    script: Script,
    log: PathBuf,
    by: &'static str,
    is_early: bool,
    done: Mutex<bool>,
}

impl Replaces {
    fn replace(&self, is_now: bool) {
        let mut done = self.done.lock().expect("no panic");
        if is_now && !*done {
            std::fs::write(&self.log, self.by).expect("written");
            *done = true;
        }
    }
}

impl Work for Replaces {
    type Result = Outcome;

    fn kind(&self) -> &'static Kind {
        self.script.kind()
    }

    fn planned(&self, _: usize) {
        self.replace(self.is_early);
    }

    fn identify(&self, log: &Location, maps: &[ChannelMap]) -> Result<Identified, Rejection> {
        self.script.identify(log, maps)
    }

    fn run(
        &self,
        input: &Input<'_>,
        bike: &BikeFile,
        pipeline: &Pipeline,
    ) -> Result<WorkOutput<Outcome>, Rejection> {
        let read = self.script.run(input, bike, pipeline);
        self.replace(input.log == Location::from(&self.log));
        read
    }
}

#[test]
fn a_log_that_changes_while_it_is_read_is_read_again_by_the_next_run() {
    let place = Place::new(&[("a", "s-a|b1|ok 0.30 2026-05-01T10:00:00Z"), ("b", "s-b|b1|ok")]);
    adds_up(&place.run());
    let good = rows(&place.path("out"));
    for (is_early, by) in [
        (true, "s-other|b1|ok"),
        (false, "s-other|b1|ok"),
        (false, "s-a|b1|ok 0.32 2026-05-01T10:00:00Z"),
        // what is there in the end makes no sense, and was never read
        (false, "half"),
    ] {
        place.put("logs/a.csv", "s-a|b1|ok 0.31 2026-05-01T10:00:00Z");
        let work = Replaces {
            script: Script::default(),
            log: place.path("logs/a.csv"),
            by,
            is_early,
            done: Mutex::new(false),
        };
        let done: Result<Accounts, Error> = place.setup().with(|settings| {
            engine::run(settings, &work, &(), &AtomicBool::new(false)).map(|(done, _)| done)
        });
        let done = done.expect("run");
        assert!(*work.done.lock().expect("no panic"), "{by}");
        adds_up(&done);
        assert_eq!(codes(&done), ["changed"], "{by}");
        let message = &done.rejected[0].message;
        assert!(message.contains("changed while it was read"), "{message}");
        assert!(message.contains("next run") && !message.contains("mistake"), "{message}");
        assert!(rows(&place.path("out")) == good, "{by}: rows went");
    }
    place.put("logs/a.csv", "s-a|b1|ok 0.30 2026-05-01T10:00:00Z");
    adds_up(&place.run());
    assert!(rows(&place.path("out")) == good);

    // touched, and the same: that is no change
    let work = Replaces {
        script: Script::default(),
        log: place.path("logs/a.csv"),
        by: "s-a|b1|ok 0.31 2026-05-01T10:00:00Z",
        is_early: false,
        done: Mutex::new(false),
    };
    place.put("logs/a.csv", work.by);
    let done = place.setup().with(|settings| {
        engine::run(settings, &work, &(), &AtomicBool::new(false)).map(|(done, _)| done)
    });
    let done = done.expect("run");
    assert_eq!((codes(&done), done.done), (vec![], 1));
    assert_eq!(work.script.runs.load(Ordering::Relaxed), 1);
}

/// A log that is named and not there, and a folder in place of a log: what was read of it before stays.
#[test]
fn an_absent_log_keeps_its_rows() {
    let place = Place::new(&[("a", "*|b1|ok"), ("b", "*|b1|ok")]);
    adds_up(&place.run());
    let good = rows(&place.path("out"));
    let named = || {
        let logs = ["a", "b"].map(|log| place.path(&format!("logs/{log}.csv")));
        let done = place.run_with(&Script::default(), |setup| setup.inputs = logs.to_vec());
        done.expect("run")
    };
    std::fs::remove_file(place.path("logs/b.csv")).expect("removed");
    assert_eq!(codes(&named()), ["not_found"]);
    assert!(rows(&place.path("out")) == good, "rows went");
    std::fs::create_dir(place.path("logs/b.csv")).expect("a folder");
    assert_eq!(codes(&named()), ["no_logs"]);
    assert!(rows(&place.path("out")) == good, "rows went");
    // a log that is bad has no session any more
    std::fs::remove_dir(place.path("logs/b.csv")).expect("removed");
    place.put("logs/b.csv", "no script");
    assert_eq!(codes(&named()), ["unknown_format"]);
    assert_eq!(place.sessions(), ["b1/a"]);
}
