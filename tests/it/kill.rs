//! Runs that are killed, and readers that read along.

use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;

use roadbench::internals::batch::store::contents::Contents;
use roadbench::internals::batch::store::kind;

use crate::script::{BIKE, Place, Script, Setup, adds_up, killed_after};

/// Not a test of its own: the process that the next test kills.
#[test]
#[ignore = "run by a_killed_run_leaves_whole_files_and_is_taken_up"]
fn victim() {
    let Some(root) = std::env::var_os("ROADBENCH_TEST_VICTIM").map(PathBuf::from) else { return };
    let setup = Setup {
        inputs: vec![root.join("logs")],
        bikes: Some(root.join("bikes")),
        out: root.join("out"),
        maps: Vec::new(),
        jobs: 2,
        force: false,
        since: None,
    };
    let work = Script { pause: Duration::from_millis(2), ..Script::default() };
    let _ = setup.run(&work, &(), &AtomicBool::new(false));
}

#[test]
fn a_killed_run_leaves_whole_files_and_is_taken_up() {
    let logs: Vec<(String, String)> =
        (0..60).map(|i| (format!("l{i:02}"), format!("s{i:02}|b1|ok"))).collect();
    let logs: Vec<(&str, &str)> = logs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let place = Place::new(&logs);
    let (mut partial, mut rounds) = (0, 0);
    for wanted in [2, 9, 17, 31] {
        let mut child = std::process::Command::new(std::env::current_exe().expect("test binary"))
            .args(["--exact", "kill::victim", "--ignored"])
            .env("ROADBENCH_TEST_VICTIM", place.root.path())
            .stdout(std::process::Stdio::null())
            .stderr(std::process::Stdio::null())
            .spawn()
            .expect("child");
        let folder = place.path("out/.roadbench/staged/run");
        for _ in 0..10_000 {
            let there = std::fs::read_dir(&folder).map_or(0, Iterator::count);
            if there >= wanted || child.try_wait().expect("child").is_some() {
                break;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
        child.kill().expect("SIGKILL");
        child.wait().expect("gone");
        let names = place.names();
        let sessions = names.iter().filter(|n| n.ends_with(".session")).count();
        partial += usize::from(sessions > 0 && sessions < 60);
        rounds += 1;
        for name in names.iter().filter(|n| n.ends_with(".parquet") || n.ends_with(".session")) {
            let bytes = std::fs::read(place.path("out").join(name)).expect("bytes");
            assert!(bytes.len() > 8 && bytes.ends_with(b"PAR1"), "{name} is not whole");
        }
    }
    assert!(partial > 0, "none of {rounds} runs was killed in the middle");
    place.put("out/plots/bike=b1/.roadbench-left.tmp", "half a file");
    place.put("out/.roadbench/.roadbench-left.tmp", "half a mark");
    let rest = place.run();
    adds_up(&rest);
    assert!(rest.unchanged > 0, "the killed runs' sessions are kept");
    place.run_with(&Script::default(), |s| s.out = place.path("fresh")).expect("run");
    assert!(place.tables("out") == place.tables("fresh"), "not what an undisturbed run writes");
}

/// The victim process on a place.
pub fn victim_of(place: &Place) -> Child {
    Command::new(std::env::current_exe().expect("test binary"))
        .args(["--exact", "kill::victim", "--ignored"])
        .env("ROADBENCH_TEST_VICTIM", place.root.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("child")
}

/// Reads every table that it finds again and again until stopped; how many it has read.
///
/// With `kept`, a session that was there at the start is there at every look.
fn read_along(place: &Place, stop: &AtomicBool, kept: &AtomicBool, read: &AtomicUsize) {
    let out = place.path("out");
    let markers = || {
        let there = Contents::read(&kind::RUN, &out.clone().into()).expect("read");
        there.taken_in().count()
    };
    while !stop.load(Ordering::Relaxed) {
        for entry in walkdir::WalkDir::new(&out).into_iter().filter_map(Result::ok) {
            let name = entry.file_name().to_string_lossy();
            if name.starts_with('.') || !name.ends_with(".parquet") {
                continue;
            }
            // gone since it was listed: that is no torn file
            let Ok(file) = std::fs::File::open(entry.path()) else { continue };
            let rows = ParquetRecordBatchReaderBuilder::try_new(file)
                .and_then(ParquetRecordBatchReaderBuilder::build)
                .map(|reader| reader.map(|batch| batch.expect("rows").num_rows()).sum::<usize>());
            assert!(rows.is_ok(), "{}: {rows:?}", entry.path().display());
            read.fetch_add(1, Ordering::Relaxed);
        }
        if kept.load(Ordering::Acquire) {
            let there = markers();
            // the rounds without earlier tables may have begun meanwhile
            assert!(!kept.load(Ordering::Acquire) || there == place_size(place), "{there} left");
        }
    }
}

fn place_size(place: &Place) -> usize {
    std::fs::read_dir(place.path("logs")).expect("logs").count()
}

/// Says stop when it goes, by a panic too.
struct Stops<'a>(&'a AtomicBool);

impl Drop for Stops<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// Kills a run of some sessions at instants spread over all its duration, half of them in an empty
/// folder and half over the tables of an older bike file, and lets each be taken up.
fn kills(sessions: usize, rounds: usize) {
    let logs: Vec<(String, String)> =
        (0..sessions).map(|i| (format!("l{i:03}"), format!("s{i:03}|b1|ok"))).collect();
    let logs: Vec<(&str, &str)> = logs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let place = Place::new(&logs);
    let other = BIKE.replace("mass = 260.0", "mass = 270.0");
    assert_ne!(other, BIKE);
    // what undisturbed runs write, and how long one takes
    let mut undisturbed = Vec::new();
    let mut longest = Duration::ZERO;
    for bike in [BIKE, &other] {
        place.put("bikes/b1.toml", bike);
        let begun = Instant::now();
        victim_of(&place).wait().expect("undisturbed");
        longest = longest.max(begun.elapsed());
        undisturbed.push(place.tables("out"));
    }
    let (stop, kept, read) = (AtomicBool::new(false), AtomicBool::new(false), AtomicUsize::new(0));
    let (mut early, mut torn) = (0, 0);
    std::thread::scope(|scope| {
        // a round that fails must not leave the reader reading for ever
        let _stops = Stops(&stop);
        let reader = scope.spawn(|| read_along(&place, &stop, &kept, &read));
        for round in 0..3 * rounds {
            if early == rounds {
                break;
            }
            let over = round % 4 < 2;
            kept.store(false, Ordering::Release);
            if !over {
                let _ = std::fs::remove_dir_all(place.path("out"));
            }
            place.put("bikes/b1.toml", [BIKE, &other][round % 2]);
            kept.store(over, Ordering::Release);
            // evenly spread, never twice the same
            let share = (round as f64 * 0.618_033_988_75).fract();
            let ended = killed_after(victim_of(&place), longest.mul_f64(share));
            early += usize::from(ended.is_none());
            // the machine was busier when it was timed: the next ones are killed sooner
            longest = ended.map_or(longest, |lived| longest.min(lived));
            torn += usize::from(
                std::fs::read_dir(place.path("out/.roadbench/staged/run"))
                    .is_ok_and(|mut left| left.next().is_some()),
            );
            adds_up(&place.run());
            let (now, wanted) = (place.tables("out"), &undisturbed[round % 2]);
            let differs = wanted.keys().chain(now.keys()).find(|k| now.get(*k) != wanted.get(*k));
            assert!(differs.is_none(), "round {round}: {differs:?} is not as undisturbed");
            if reader.is_finished() {
                break; // it has something to say
            }
        }
    });
    let read = read.into_inner();
    println!(
        "{sessions} sessions: {early} of {rounds} killed before the end, {torn} of them with \
         sessions that waited; {read} tables read along"
    );
    assert_eq!(early, rounds, "runs that were killed before their end");
    assert!(read > sessions, "the reader has read only {read} tables");
}

#[test]
fn a_run_killed_at_any_instant_leaves_tables_and_is_taken_up() {
    kills(60, 12);
}

#[test]
#[ignore = "ten minutes; the same on a large scale: cargo nextest run --run-ignored all two_hundred_kills"]
fn two_hundred_kills() {
    kills(300, 200);
}
