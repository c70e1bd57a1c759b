//! The batch around stand-in stages ([`crate::script`]).

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, SystemTime};

use arrow::array::{AsArray, RecordBatch};
use arrow::datatypes::DataType;
use roadbench::internals::batch;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::kind;
use roadbench::internals::batch::store::marker::Key;
use roadbench::internals::batch::{Error, State};
use roadbench::internals::report::Pages;
use roadbench::internals::store::tables::{file, read, registry};

use crate::script::{BIKE, Place, Script, Setup, adds_up, codes};

#[test]
fn every_input_ends_as_a_session_or_a_rejection() {
    let place = Place::new(&[
        ("a", "s-a|b1|ok"),
        ("b", "s-b|b2|panic"),
        ("c", "s-c|b1|reject"),
        ("d", "s-a|b1|ok "),
        ("e", "s-e|b9|ok"),
        ("f", "s-f||ok"),
        ("g", "s-g|../b1|ok"),
        ("h", "rubbish"),
        ("i", "s-i|b1|overflow"),
        ("j", "s-j|bad|ok"),
        ("k", "s-k|bad|ok"),
        ("l", "s-l|b1|panic early"),
    ]);
    place.put("bikes/bad.toml", "masss = 1.0");
    let run = place.run();
    adds_up(&run);
    assert_eq!((run.inputs, run.done), (12, 1));
    assert_eq!(
        codes(&run),
        [
            "internal_error",
            "too_short",
            "duplicate_session_id",
            "no_bike_file",
            "no_bike_id",
            "bad_bike_id",
            "unknown_format",
            "internal_error",
            "bad_bike_file",
            "bad_bike_file",
            "internal_error",
        ]
    );
    let row = |code: &str| run.rejected.iter().find(|r| r.code == code).expect(code);
    assert!(row("no_bike_file").message.contains("b9.toml"), "{}", row("no_bike_file").message);
    assert!(row("duplicate_session_id").message.contains("a.csv"));
    assert!(row("bad_bike_file").message.contains("`masss`"));
    assert!(row("internal_error").message.contains("as the script says"));
    assert!(run.rejected.iter().all(|r| r.input_hash.is_some()));
    let names = place.names();
    assert_eq!(names.iter().filter(|n| n.starts_with("rejected/")).count(), 11);
    assert_eq!(
        names.iter().filter(|n| !n.starts_with("rejected/")).collect::<Vec<_>>(),
        [
            ".roadbench/checksums.json",
            "coefficients/bike=b1/2026-05.parquet",
            "evidence/bike=b1/2026-05.parquet",
            "manoeuvres/bike=b1/2026-05.parquet",
            "plots/bike=b1/2026-05.parquet",
            "sessions/bike=b1/2026-05.parquet",
            "warnings/bike=b1/2026-05.parquet",
        ]
    );
}

/// A log that cannot be read lies below its motorcycle's folder nevertheless: its rejection says whose it is.
#[test]
fn a_rejected_log_is_its_folders_motorcycle() {
    let place = Place::new(&[
        ("a", "s-a|b1|ok"),
        ("bike=b1/cut", "rubbish"),
        ("bike=../cut", "rubbish"),
        ("bike=b1/bike=b2/cut", "rubbish"),
    ]);
    let run = place.run();
    adds_up(&run);
    let bike_of = |folder: &str| {
        let end = format!("logs/{folder}cut.csv");
        run.rejected.iter().find(|row| row.path.ends_with(&end)).expect(folder).bike_id.clone()
    };
    assert_eq!(bike_of("bike=b1/").as_deref(), Some("b1"));
    assert_eq!(bike_of("bike=b1/bike=b2/").as_deref(), Some("b2"));
    assert_eq!(bike_of("bike=../"), None);
    assert_eq!(place.sessions(), ["b1/s-a"]);
}

#[test]
fn no_id_leads_out_of_the_output() {
    let long = "x".repeat(5000);
    let place = Place::new(&[
        ("a", "../../../escaped|b1|ok"),
        ("b", "/etc/escaped|b1|ok"),
        ("c", "..|b1|ok"),
        ("d", &format!("{long}|b1|ok")),
        ("e", "nul\0 and \u{1F3CD} \u{202E}|b1|ok"),
        ("f", ".roadbench-x.tmp|b1|ok"),
    ]);
    let before = place.names_outside();
    let run = place.run();
    adds_up(&run);
    assert_eq!(run.done, 6, "{:?}", codes(&run));
    assert_eq!(place.names_outside(), before);
    let names = place.names();
    assert_eq!(names.len(), 7, "six tables and the checksums");
    assert!(names.contains(&"sessions/bike=b1/2026-05.parquet".to_owned()));
    let warnings =
        read_column(&place.path("out/warnings/bike=b1/2026-05.parquet"), &["session_id", "code"]);
    assert!(warnings.contains(&vec!["../../../escaped".into(), "unsafe_session_id".into()]));
    let work = Script { signals: true, ..Script::default() };
    place.run_with(&work, |s| s.force = true).expect("run");
    assert_eq!(place.names_outside(), before);
    let escaped = "signals/bike=b1/%2E%2E%2F..%2F..%2Fescaped.parquet".to_owned();
    assert!(place.names().contains(&escaped), "what is asked for is a file per session");
    place.run_with(&Script::default(), |s| s.force = true).expect("run");
    assert_eq!(place.names(), names, "and goes where it is not asked for");
    let again = place.run();
    assert_eq!((again.done, again.unchanged), (0, 6), "found again under their own ids");
}

#[test]
fn the_same_bytes_whatever_the_number_of_workers() {
    let logs: Vec<(String, String)> = (0..24)
        .map(|i| {
            let what = if i % 7 == 3 { "reject" } else { "ok" };
            (format!("log{i}"), format!("s{i}{}|b{}|{what}", "y".repeat(i), i % 2 + 1))
        })
        .collect();
    let logs: Vec<(&str, &str)> = logs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let place = Place::new(&logs);
    for (out, jobs) in [("one", 1), ("two", 2)] {
        place
            .run_with(&Script::default(), |s| {
                s.out = place.path(out);
                s.jobs = jobs;
            })
            .expect("run");
    }
    let (one, two) = (place.tables("one"), place.tables("two"));
    assert_eq!(one.len(), 2 * 6 + 3 + 1, "two motorcycles, three rejections, the checksums");
    assert!(one == two, "bytes differ");
}

#[test]
fn what_is_there_is_not_computed_again() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b2|ok"), ("c", "s-c|b1|ok")]);
    place.run();
    let first = place.tables("out");

    let work = Script::default();
    let run = place.run_with(&work, |_| {}).expect("run");
    assert_eq!((run.unchanged, work.runs.load(Ordering::Relaxed)), (3, 0));
    assert!(place.tables("out") == first);

    let run = place.run_with(&Script::default(), |s| s.force = true).expect("run");
    assert_eq!(run.done, 3);
    assert!(place.tables("out") == first);

    place.put("bikes/b1.toml", &BIKE.replace("260", "250"));
    assert_eq!(place.run().done, 2, "the two sessions of the bike that changed");

    let map = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/maps/session_csv.toml");
    let run = place.run_with(&Script::default(), |s| s.maps = vec![map.clone()]).expect("run");
    assert_eq!((run.done, run.unchanged), (0, 3), "a map that no log is read by");
    let run = place
        .run_with(&Script { signals: true, ..Script::default() }, |s| s.maps = vec![map.clone()])
        .expect("run");
    assert_eq!(run.done, 3, "signals were not there");

    std::fs::remove_file(place.path("out/plots/bike=b2/2026-05.parquet")).expect("removed");
    let run = place.run_with(&Script::default(), |s| s.maps = vec![map.clone()]).expect("run");
    assert_eq!((run.done, run.unchanged), (1, 2), "a table was missing");
    let names = place.names();
    assert!(!names.contains(&"signals/bike=b2/s-b.parquet".to_owned()), "stale signals stay");
    assert!(names.contains(&"signals/bike=b1/s-a.parquet".to_owned()));
}

#[test]
fn a_session_is_either_in_the_tables_or_rejected() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("s-b", "s-b|b1|ok"), ("c", "s-c|b1|reject")]);
    place.run();
    place.put("logs/a.csv", "s-a|b1|reject");
    place.put("logs/s-b.csv", "rubbish");
    place.put("logs/c.csv", "s-c|b2|ok");
    place.put("logs/d.csv", "s-d|b2|ok");
    let run = place.run();
    assert_eq!((run.done, codes(&run)), (2, vec!["too_short", "unknown_format"]));
    let names = place.names();
    assert_eq!(names.iter().filter(|n| n.starts_with("rejected/")).count(), 2, "{names:?}");
    assert_eq!(place.sessions(), ["b2/s-c", "b2/s-d"]);
    assert!(!names.iter().any(|n| n.contains("bike=b1")), "{names:?}");
}

#[test]
fn a_session_moves_with_its_bike_and_others_stay() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b1|ok")]);
    place.run();
    place.put("logs/a.csv", "s-a|b2|ok");
    std::fs::remove_file(place.path("logs/b.csv")).expect("removed");
    place.put("logs/c.csv", "s-c|b2|ok");
    place.run();
    // s-b is no input any more: the archive keeps it
    assert_eq!(place.sessions(), ["b1/s-b", "b2/s-a", "b2/s-c"]);
    let rows = |table: &str, bike: &str| {
        let file = format!("out/{table}/bike={bike}/2026-05.parquet");
        read_column(&place.path(&file), &["session_id"]).concat()
    };
    for table in ["sessions", "coefficients"] {
        assert_eq!(
            (rows(table, "b1"), rows(table, "b2")),
            (vec!["s-b".into()], vec!["s-a".into(), "s-c".into()])
        );
    }
    assert_eq!(place.names().len(), 13, "and the checksums");
}

#[test]
fn bad_usage_writes_nothing() {
    let place = Place::new(&[("a", "s-a|b1|ok")]);
    place.put("empty/README.md", "x");
    let usage = |expected: &str, change: &dyn Fn(&mut Setup)| {
        match place.run_with(&Script::default(), |s| change(s)) {
            Err(Error::Usage(message)) => assert!(message.contains(expected), "{message}"),
            other => panic!("{expected}: {other:?}"),
        }
        assert!(!place.path("out").exists(), "{expected}");
    };
    let path = |name: &str| place.path(name);
    usage("--bikes", &|s| s.bikes = None);
    usage("nowhere", &|s| s.bikes = Some(path("nowhere")));
    usage("no bike file", &|s| s.bikes = Some(path("empty")));
    usage("nothing does not exist", &|s| s.inputs = vec![path("nothing")]);
    usage("holds no logs", &|s| s.inputs = vec![path("empty")]);
    usage("nothing matches", &|s| s.inputs = vec![path("logs/*.mcap")]);
}

#[test]
fn an_output_that_cannot_be_written_is_one_clear_error() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b1|ok")]);
    place.put("file", "not a folder");
    let result = place.run_with(&Script::default(), |s| s.out = place.path("file/out"));
    assert!(matches!(&result, Err(Error::Output(m)) if m.contains("file")), "{result:?}");

    // the disk fills up, so to say, in the middle: a file stands where a table's folder goes
    place.put("out/plots", "not a folder");
    let result = place.run_with(&Script::default(), |_| {});
    assert!(matches!(&result, Err(Error::Output(m)) if m.contains("plots")), "{result:?}");
    assert!(!place.names().iter().any(|n| n.starts_with("sessions/")), "nothing is committed");
}

#[test]
fn two_runs_do_not_share_an_output() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b1|ok")]);
    let held = Store::open(&kind::RUN, &place.path("out").into()).expect("first");
    let result = place.run_with(&Script::default(), |_| {});
    assert!(matches!(&result, Err(Error::Usage(m)) if m.contains("another roadbench")));
    drop(held);
    assert_eq!(place.run().done, 2);
}

#[test]
fn a_stopped_run_says_what_is_left_and_is_taken_up() {
    let logs: Vec<(String, String)> =
        (0..12).map(|i| (format!("l{i}"), format!("s{i}|b1|ok"))).collect();
    let logs: Vec<(&str, &str)> = logs.iter().map(|(a, b)| (a.as_str(), b.as_str())).collect();
    let place = Place::new(&logs);

    struct StopAfter<'a>(&'a AtomicBool, usize, AtomicUsize);
    impl<R> batch::Watch<R> for StopAfter<'_> {
        fn finished(&self, _: &batch::Finished<'_>, _: Option<R>) {
            if self.2.fetch_add(1, Ordering::Relaxed) + 1 == self.1 {
                self.0.store(true, Ordering::Relaxed);
            }
        }
    }
    let stop = AtomicBool::new(false);
    let watch = StopAfter(&stop, 3, AtomicUsize::new(0));
    let run = place.setup().run(&Script::default(), &watch, &stop).expect("run");
    adds_up(&run);
    assert!(run.left > 0 && run.done >= 3, "{run:?}");
    let rest = place.run();
    assert_eq!((rest.unchanged, rest.done), (run.done, run.left));
}

impl Place {
    fn names_outside(&self) -> Vec<PathBuf> {
        let out = self.path("out");
        let parent = self.root.path();
        walkdir::WalkDir::new(parent)
            .sort_by_file_name()
            .into_iter()
            .map(|e| e.expect("entry").into_path())
            .filter(|p| !p.starts_with(&out))
            .collect()
    }
}

/// Text columns of a table, row by row.
fn read_column(path: &Path, columns: &[&str]) -> Vec<Vec<String>> {
    let file = std::fs::File::open(path).expect("open");
    let reader = parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(file)
        .expect("parquet")
        .build()
        .expect("reader");
    let mut rows = Vec::new();
    for batch in reader {
        let batch = batch.expect("batch");
        for i in 0..batch.num_rows() {
            let cell = |name: &&str| {
                let column = batch.column_by_name(name).expect("column");
                let column = arrow::compute::cast(column, &arrow::datatypes::DataType::Utf8);
                column.expect("text").as_string::<i32>().value(i).to_owned()
            };
            rows.push(columns.iter().map(cell).collect());
        }
    }
    rows
}

/// One bike's five sessions by hand: 0.300 ... 0.303 and a far one, 1 mm standard error each.
#[cfg(feature = "fleet")]
#[test]
fn the_fleet_is_what_its_committed_sessions_say() {
    let place = Place::new(&[
        ("a", "s-1|b1|ok 0.300 2026-05-01T00:00:00Z"),
        ("b", "s 2|b1|ok 0.301 2026-05-02"),
        ("c", "s-3|b1|ok 0.302 2026-05-03T02:00:00+02:00"),
        ("d", "s-4|b1|ok 0.303 2026-05-04T00:00:00Z"),
        ("e", "s*%5|b1|ok 0.350 2026-05-05T00:00:00Z"),
        ("f", "s-6|b1|poor 9.0 2026-05-06T00:00:00Z"),
        ("g", "s-7|b1|ok 9.0 2026-05-07T00:00:00Z"),
        ("h", "s-8|b2|ok 0.29 2026-05-07T00:00:00Z"),
    ]);
    place.run();
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    store
        .remove(&Key::new("b1", "s-7"))
        .and_then(|()| store.remove(&Key::new("b1", "unknown")))
        .expect("marked");
    store.merge().expect("taken out");
    drop(store);
    let rows = batch::fleet::tables::write(&place.path("out")).expect("fleet");
    assert_eq!(rows.len(), 2);
    let close = |a: Option<f64>, b: f64| {
        let a = a.expect("a value");
        assert!((a - b).abs() < 1e-9, "{a} is not {b}");
    };
    let row = &rows[0];
    assert_eq!((row.bike_id.as_str(), row.tyre.as_str(), row.unit.as_str()), ("b1", "front", "m"));
    assert_eq!(row.n_sessions, 5);
    close(row.median, 0.302);
    close(row.quartile_1, 0.301);
    close(row.quartile_3, 0.303);
    close(row.robust_sd, 1.4826e-3);
    close(row.within_sd, 1e-3);
    close(row.between_sd, (4.717e-4_f64 - 1e-6).sqrt()); // equal errors: sample variance less theirs
    close(row.drift_per_day, 1e-3);
    assert_eq!((row.n_flagged, row.flagged_sessions.as_deref()), (1, Some("s*%5")));
    let alone = &rows[1];
    assert_eq!((alone.n_sessions, alone.robust_sd, alone.between_sd), (1, None, None));
    close(alone.median, 0.29);
    let bytes = place.files("out")["fleet/fleet.parquet"].clone();
    batch::fleet::tables::write(&place.path("out")).expect("fleet");
    assert!(place.files("out")["fleet/fleet.parquet"] == bytes);
}

#[cfg(feature = "fleet")]
#[test]
fn a_fleet_without_sessions_is_an_empty_table() {
    let place = Place::new(&[("a", "s-1|b1|reject")]);
    place.run();
    assert_eq!(batch::fleet::tables::write(&place.path("out")).expect("fleet").len(), 0);
}

/// An output of an earlier version had a file per session and table, ids and times as plain texts. What it holds moves
/// as it is, also that of a log that is gone; what a killed run of then has left half-written is computed again.
#[test]
fn an_output_of_before_moves_into_files_per_month() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s b|b1|ok"), ("c", "s-c|b2|ok")]);
    let work = Script { signals: true, ..Script::default() };
    place.run_with(&work, |_| {}).expect("run");
    let whole = place.tables("out");
    let names = [("s-a", "s-a"), ("s b", "s%20b"), ("s-c", "s-c")];
    for (name, bytes) in whole.iter().filter(|(name, _)| name.ends_with("2026-05.parquet")) {
        let table = registry::find(name.split('/').next().expect("folder")).expect("a table");
        let mut batches = read::batches_of(bytes.clone().into()).expect("read");
        if batches.is_empty() {
            batches.push(RecordBatch::new_empty(table.table().arrow()));
        }
        for batch in batches {
            let ids = arrow::compute::cast(&batch.columns()[0], &DataType::Utf8).expect("ids");
            let ids = ids.as_string::<i32>();
            for (id, file) in names {
                let own: Vec<bool> = ids.iter().map(|i| i == Some(id)).collect();
                let rows = arrow::compute::filter_record_batch(&batch, &own.into()).expect("rows");
                let fields: Vec<_> =
                    rows.schema().fields().iter().map(|f| f.name().clone()).collect();
                let columns = fields.iter().zip(rows.columns()).map(|(name, column)| {
                    let is_text = matches!(
                        column.data_type(),
                        DataType::Dictionary(..) | DataType::Timestamp(..)
                    );
                    // without arrow's list of time zones, which the program does not need,
                    // an instant is cast to text only once it has lost its zone
                    let local = match column.data_type() {
                        DataType::Timestamp(unit, _) => DataType::Timestamp(*unit, None),
                        other => other.clone(),
                    };
                    let local = arrow::compute::cast(column, &local).expect("without zone");
                    let text = is_text.then(|| arrow::compute::cast(&local, &DataType::Utf8));
                    let text = text.map(|t| t.expect("text"));
                    (name.as_str(), text.unwrap_or_else(|| Arc::clone(column)), true)
                });
                let old = RecordBatch::try_from_iter_with_nullable(columns).expect("old");
                let to = place.path("out").join(name.replace("2026-05", file));
                let is_of_bike = name.contains("bike=b2") == (id == "s-c");
                if is_of_bike {
                    file::write_batch(&to, &old).expect("written");
                }
            }
        }
        std::fs::remove_file(place.path("out").join(name)).expect("removed");
    }
    std::fs::remove_file(place.path("logs/b.csv")).expect("removed");
    place.put("out/.roadbench/writing/s-c", "b2");
    place.put("out/.roadbench/writing/s-torn", "b1");
    place.put("out/coefficients/bike=b1/s-torn.parquet", "half a session that no marker tells of");
    let run = place.run_with(&work, |_| {}).expect("run");
    assert_eq!((run.unchanged, run.done), (1, 1), "s-c was being written");
    assert_eq!(place.sessions(), ["b1/s b", "b1/s-a", "b2/s-c"]);
    assert!(place.tables("out") == whole, "{:?}", place.names());
}

/// A table of a month that cannot be read stops only what would go into it: the sessions wait, and the message says
/// what to do.
#[test]
fn a_damaged_table_is_named_and_loses_nothing() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("c", "s-c|b2|ok")]);
    place.run();
    let whole = place.tables("out");
    place.put("out/plots/bike=b1/2026-05.parquet", "PAR1 no table PAR1");
    place.put("logs/b.csv", "s-b|b1|ok");
    // the log of s-a is there: its rows are computed anew
    let run = place.run();
    assert_eq!((run.done, run.unchanged, &run.damage), (2, 1, &None));
    let with_b = place.tables("out");

    // it is not: s-b waits, and the message says for what
    std::fs::rename(place.path("logs/a.csv"), place.path("a.csv")).expect("away");
    place.put("out/plots/bike=b1/2026-05.parquet", "PAR1 no table PAR1");
    place.put("logs/b.csv", "s-b|b1|ok ");
    let run = place.run();
    let told = |m: &str| m.contains("plots/bike=b1/2026-05.parquet") && m.contains("backup");
    assert!(run.damage.as_deref().is_some_and(told), "{run:?}");
    assert_eq!(run.done, 1);
    let run = place.run();
    assert_eq!((run.done, run.unchanged), (0, 2), "s-b waits");
    assert!(run.damage.is_some(), "every night");
    std::fs::rename(place.path("a.csv"), place.path("logs/a.csv")).expect("back");
    place.put("logs/b.csv", "s-b|b1|ok");
    let run = place.run();
    assert_eq!((&run.damage, run.rejected.len()), (&None, 0));
    assert_eq!(place.sessions(), ["b1/s-a", "b1/s-b", "b2/s-c"]);
    assert!(place.tables("out") == with_b);
    std::fs::remove_file(place.path("logs/b.csv")).expect("removed");
    assert!(place.tables("out").len() == whole.len());
}

/// What waits may be damaged too, and a table may be removed while others' rows of it stay: both are computed again, and
/// nothing else is.
#[test]
fn what_is_lost_is_computed_again() {
    let logs = [("a", "s-a|b1|ok"), ("b", "s-b|b1|ok"), ("c", "s-c|b2|ok")];
    let place = Place::new(&logs);
    place.run();
    let whole = place.tables("out");

    // a session that waits is rubbish behind its footer
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    let there = store.found().of(&Key::new("b1", "s-b"))[0].clone();
    let rubbish = roadbench::internals::batch::jobs::work::SessionFile {
        folder: "coefficients",
        extension: "parquet",
        bytes: b"PAR1 rubbish".to_vec(),
    };
    store.commit(&there, &[rubbish]).expect("waits");
    drop(store);
    let run = place.run();
    assert_eq!((run.done, run.unchanged), (0, 3), "s-b stayed as it was");
    assert!(place.tables("out") == whole);

    // one log by itself after the month's table is gone: the other session is not taken for whole
    std::fs::remove_file(place.path("out/coefficients/bike=b1/2026-05.parquet")).expect("removed");
    let run = place.run_with(&Script::default(), |s| s.inputs = vec![place.path("logs/a.csv")]);
    assert_eq!(run.expect("run").done, 1);
    let run = place.run();
    assert_eq!((run.done, run.unchanged), (1, 2), "s-b has coefficients again");
    assert!(place.tables("out") == whole);

    // rows without a commit marker are nobody's
    let coefficients = place.path("out/coefficients/bike=b2/2026-05.parquet");
    std::fs::copy(place.path("out/coefficients/bike=b1/2026-05.parquet"), coefficients)
        .expect("ghosts");
    place.run_with(&Script::default(), |s| s.force = true).expect("run");
    assert!(place.tables("out") == whole);
}

/// A dry run says of every log what the run then does, and why; it writes nothing.
#[test]
fn a_dry_run_says_what_the_run_does() {
    let logs = [("a", "s-a|b1|ok"), ("b", "s-b|b2|ok"), ("c", "s-c|b1|ok"), ("d", "s-d|b1|ok")];
    let place = Place::new(&logs);
    let setup = place.setup();
    assert!(setup.intend().iter().all(|(_, state, why)| *state == State::Done && why == "new"));
    assert!(!place.path("out").exists());
    place.run();
    assert!(setup.intend().iter().all(|(_, state, _)| *state == State::Unchanged));

    place.put("bikes/b2.toml", &BIKE.replace("260.0", "261.0"));
    place.put("logs/a.csv", "s-a|b1|ok ");
    std::fs::rename(place.path("logs/c.csv"), place.path("logs/0.csv")).expect("renamed");
    place.put("logs/e.csv", "s-d|b1|ok");
    let before = place.tables("out");
    let told = setup.intend();
    assert_eq!(before, place.tables("out"));
    let of = |name: &str| {
        let (_, state, why) = told.iter().find(|(n, ..)| n == name).expect("told");
        (*state, why.as_str())
    };
    assert_eq!(of("0"), (State::Done, "the log was renamed or moved"));
    assert_eq!(of("a"), (State::Done, "the log has changed"));
    assert_eq!(of("b"), (State::Done, "the bike file or the settings have changed"));
    assert_eq!(of("d").0, State::Unchanged);
    assert_eq!(of("e").0, State::Rejected); // the same session as d
    let run = place.run();
    let count = |state: State| told.iter().filter(|t| t.1 == state).count();
    assert_eq!(run.done, count(State::Done));
    assert_eq!(run.unchanged, count(State::Unchanged));
    assert_eq!(run.rejected.len(), count(State::Rejected));
}

/// Only logs that were written since then are looked at; the others' tables stay.
#[test]
fn since_leaves_older_logs_alone() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b1|ok")]);
    place.run();
    let old = SystemTime::now() - Duration::from_secs(86_400);
    let log = std::fs::File::options().append(true).open(place.path("logs/a.csv")).expect("log");
    log.set_modified(old).expect("dated");
    place.put("bikes/b1.toml", &BIKE.replace("260.0", "261.0"));
    let since = Some(old + Duration::from_secs(60));
    let run = place.run_with(&Script::default(), |s| s.since = since).expect("run");
    assert_eq!((run.inputs, run.done), (1, 1));
    assert!(run.sessions.contains(&Key::new("b1", "s-b")));
    assert_eq!(place.sessions(), ["b1/s-a", "b1/s-b"]);
}

/// Fleet and report are made again after a change and only then: a killed run leaves them behind,
/// and a build without the fleet's tables leaves those behind for one that makes them.
#[test]
fn what_is_made_over_all_sessions_is_behind_after_a_change_only() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b1|reject")]);
    let open = || Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    let made = || {
        batch::jobs::run::finish(&open(), Pages::Auto, |_| Ok(())).expect("fleet and report");
    };
    let fleet = place.path("out/.roadbench/behind");
    assert!(open().is_behind(), "nothing is made yet");
    place.run();
    assert!(open().is_behind());
    made();
    assert!(!open().is_behind());
    place.run();
    assert!(!open().is_behind(), "the run changed nothing");
    assert_eq!(fleet.exists(), !cfg!(feature = "fleet"), "another build has the fleet to make");

    for (log, what) in [("c", "s-c|b1|ok"), ("b", "s-b|b1|ok"), ("a", "s-a|b1|reject")] {
        place.put(&format!("logs/{log}.csv"), what);
        place.run();
        assert!(open().is_behind(), "{log}: {what}");
        made();
        assert!(!open().is_behind());
    }
    // whatever of it is gone, or is not as it was written
    let derived = [
        "report/index.html",
        "fleet/fleet.parquet",
        "fleet_pooled/fleet_pooled.parquet",
        "fleet_events/fleet_events.parquet",
        "fleet_ratios/fleet_ratios.parquet",
        "tyres/tyres.parquet",
        "bikes/bikes.parquet",
        ".roadbench/checksums.json",
    ];
    let whole = place.files("out");
    for file in derived {
        std::fs::remove_file(place.path("out").join(file)).expect("removed");
        assert!(open().is_behind(), "{file} is gone");
        made();
        assert!(place.files("out") == whole, "{file}");
        let mut bytes = whole[file].clone();
        bytes.truncate(bytes.len() / 2);
        std::fs::write(place.path("out").join(file), bytes).expect("cut");
        assert!(open().is_behind(), "{file} is cut");
        made();
        assert!(place.files("out") == whole && !open().is_behind(), "{file}");
    }

    std::fs::write(&fleet, "fleet").expect("left by a build without fleet tables");
    assert_eq!(open().is_behind(), cfg!(feature = "fleet"));
    std::fs::write(&fleet, "").expect("left by a run that was killed");
    assert!(open().is_behind());
}

/// A log that the output was made from is recognised by its bytes, without opening it.
#[test]
fn a_log_that_is_known_is_not_opened() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b2|ok"), ("c", "s-c|b1|ok")]);
    let work = Script::default();
    let opened = |work: &Script| work.identified.swap(0, Ordering::Relaxed);
    place.run_with(&work, |_| {}).expect("run");
    assert_eq!(opened(&work), 3);
    place.run_with(&work, |_| {}).expect("run");
    assert_eq!(opened(&work), 0);

    place.put("bikes/b2.toml", &BIKE.replace("260.0", "261.0"));
    place.put("logs/a.csv", "s-a|b1|ok ");
    place.put("logs/0.csv", "s-0|b1|ok");
    let run = place.run_with(&work, |_| {}).expect("run");
    assert_eq!((run.done, run.unchanged), (3, 1));
    assert_eq!(opened(&work), 3, "a's bytes, b's bike, a late log that sorts first");
    place.put("logs/c.csv", "s-d|b1|ok");
    let run = place.run_with(&work, |_| {}).expect("run");
    assert!(
        run.sessions.contains(&Key::new("b1", "s-d")),
        "the bytes say who it is, not its old name"
    );
}
