//! Nothing is taken that was not the program's, and no session is lost: outputs by their mark, session ids that several
//! logs have, names that loggers use again, damaged files.

use std::collections::BTreeSet;
use std::path::Path;

use arrow::array::RecordBatch;
use arrow::compute::concat_batches;
use roadbench::internals::batch::Error;
use roadbench::internals::batch::jobs::run;
use roadbench::internals::batch::store::folder::Store;
use roadbench::internals::batch::store::forget::{Selection, forget};
use roadbench::internals::batch::store::reading::Reading;
use roadbench::internals::batch::store::verify::{FindingKind, mend, verify};
use roadbench::internals::batch::store::{kind, mark};
use roadbench::internals::report::Pages;
use roadbench::internals::store::tables::rows::{Coefficient, FleetRow, SessionRow};
use roadbench::internals::store::tables::{file, read};

use crate::script::{BIKE, Place, Script, adds_up, codes};

/// A run with what is made over all sessions.
fn night(place: &Place) -> roadbench::internals::batch::Accounts {
    let run = place.run();
    adds_up(&run);
    let store = Store::open(&kind::RUN, &place.path("out").into()).expect("opened");
    if store.is_behind() {
        run::finish(&store, Pages::Auto, |_| Ok(())).expect("fleet and report");
    }
    run
}

/// A folder is as it was, names and bytes.
fn contents(folder: &Path) -> BTreeSet<(String, Vec<u8>)> {
    let entries = walkdir::WalkDir::new(folder).into_iter().map(|e| e.expect("entry"));
    let files = entries.filter(|e| e.file_type().is_file());
    files
        .map(|e| (e.path().display().to_string(), std::fs::read(e.path()).expect("bytes")))
        .collect()
}

/// A folder of logs is no output, whatever its files are like: nothing in it is removed, made or locked.
#[test]
fn an_archive_of_logs_is_no_output() {
    let place = Place::new(&[]);
    place.put("archive/sessions/bike=b1/2026-05.parquet", "PAR1 a ride that was cut off");
    place.put("archive/sessions/bike=b1/.roadbench-x.tmp", "half a file of another program");
    place.put("archive/report/index.html", "<p>mine</p>");
    place.put("archive/coefficients/notes.parquet", "my own");
    let before = contents(&place.path("archive"));
    let archive = place.path("archive").into();
    let refused = |result: Result<(), Error>| match result {
        Err(Error::Usage(message)) => assert!(message.contains("archive"), "{message}"),
        other => panic!("{other:?}"),
    };
    refused(verify(&archive, true).map(drop));
    refused(mend(&archive, false).map(drop));
    refused(mend(&archive, true).map(drop));
    let all = Selection { missing: true, ..Selection::default() };
    refused(forget(&archive, &all, true).map(drop));
    drop(Reading::of(&place.path("archive")).expect("nothing to wait for"));
    // a run would write its tables between them
    place.put("logs/a.csv", "s-a|b1|ok");
    let run = place.run_with(&Script::default(), |s| s.out = place.path("archive"));
    refused(run.map(drop));
    assert_eq!(contents(&place.path("archive")), before);
}

/// In an output, too, files that roadbench did not write stay, and are listed.
#[test]
fn files_of_others_stay_in_an_output() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("b", "s-b|b2|reject")]);
    night(&place);
    let others = [
        "coefficients/notes.parquet",
        "coefficients/bike=b1/mine.parquet",
        "fleet/fleet_2025.parquet",
        "rejected/todo.parquet",
        "models/readme.txt",
    ];
    others.iter().for_each(|name| place.put(&format!("out/{name}"), "not roadbench's"));
    let out = place.path("out").into();
    let found = verify(&out, true).expect("verified");
    let foreign: Vec<&str> = found.findings.iter().map(|f| f.place.as_str()).collect();
    let mut expected = others.to_vec();
    expected.sort_unstable();
    assert_eq!(foreign, expected);
    assert!(found.findings.iter().all(|f| f.wrong == FindingKind::Foreign), "{:?}", found.findings);
    assert_eq!(mend(&out, true).expect("mended").removed, [""; 0]);
    std::fs::remove_file(place.path("logs/a.csv")).expect("removed");
    let which = Selection { bikes: vec!["b1".into(), "b2".into()], ..Selection::default() };
    let _ = forget(&out, &which, true); // b2 has rejections only
    night(&place);
    for name in others {
        let text = std::fs::read_to_string(place.path("out").join(name));
        assert_eq!(text.expect(name), "not roadbench's", "{name}");
    }
}

/// A log of which nothing can be used has no claim on a session's id, whichever comes first by name or by night.
#[test]
fn only_a_log_that_gives_rows_holds_an_id() {
    let (bad, good) = ("ride1|b1|reject", "ride1|b1|ok 0.3 2026-05-02T10:00:00Z");
    for (first, second) in [("x/ride1", "y/ride1"), ("y/ride1", "x/ride1")] {
        let scratch = Place::new(&[(first, bad), (second, good)]);
        night(&scratch);
        let nights = Place::new(&[(first, bad)]);
        night(&nights);
        nights.put(&format!("logs/{second}.csv"), good);
        let run = night(&nights);
        assert_eq!((run.done, codes(&run)), (1, vec!["duplicate_session_id"]), "{first}");
        let run = night(&nights);
        assert_eq!((run.unchanged, run.rejected.len()), (1, 1), "and stays");
        let other = Place::new(&[(second, good)]);
        night(&other);
        other.put(&format!("logs/{first}.csv"), bad);
        night(&other);
        for place in [&scratch, &nights, &other] {
            assert_eq!(place.sessions(), ["b1/ride1"]);
        }
        // rides without a start time: the first by name is tried first
        let place = Place::new(&[(first, "ride1|b1|reject"), (second, "ride1|b1|ok")]);
        night(&place);
        assert_eq!(place.sessions(), ["b1/ride1"]);
        let codes_now: Vec<String> = place.run().rejected.into_iter().map(|r| r.code).collect();
        let expected = if first < second { "too_short" } else { "duplicate_session_id" };
        assert_eq!(codes_now, [expected]);
    }
}

/// Of two whole rides with one id the one that began first has it, in whatever order they come; the other says so.
#[test]
fn neither_nights_nor_names_decide_whose_an_id_is() {
    let early = "ride1|b1|ok 0.31 2026-05-01T10:00:00Z";
    let late = "ride1|b1|ok 0.32 2026-05-02T10:00:00Z";
    for (a, b) in [(early, late), (late, early)] {
        for first in ["x", "y"] {
            let place = Place::new(&[]);
            let put = |name: &str| {
                place.put(&format!("logs/{name}/ride1.csv"), if name == "x" { a } else { b });
            };
            put(first);
            night(&place);
            put(if first == "x" { "y" } else { "x" });
            for _ in 0..2 {
                let run = night(&place);
                assert_eq!(codes(&run), ["duplicate_session_id"]);
            }
            let rows: Vec<Coefficient> = read::rows(&place.path("out")).expect("read");
            assert_eq!(rows.len(), 1);
            assert_eq!(rows[0].value, Some(0.31), "{a}, {first} first");
        }
    }
}

/// A logger that uses its file names again does not replace a ride whose log is gone: the new log is rejected with the way out.
#[test]
fn an_archived_ride_is_not_replaced_by_another_one_of_its_name() {
    let first = "*|b1|ok 0.31 2026-05-01T10:00:00Z";
    let second = "*|b1|ok 0.32 2026-05-02T10:00:00Z";
    let value = |place: &Place| {
        let rows: Vec<Coefficient> = read::rows(&place.path("out")).expect("read");
        rows.iter().map(|row| row.value.expect("a value")).collect::<Vec<_>>()
    };
    // under the same path, and under another one of the same name
    for other in ["LOG001", "tuesday/LOG001"] {
        for bad in [false, true] {
            let place = Place::new(&[("LOG001", first)]);
            night(&place);
            std::fs::remove_file(place.path("logs/LOG001.csv")).expect("removed");
            let text = if bad { second.replace("ok", "reject") } else { second.to_owned() };
            place.put(&format!("logs/{other}.csv"), &text);
            for _ in 0..2 {
                let run = night(&place);
                assert_eq!(codes(&run), ["duplicate_session_id"], "{other}");
                let why = &run.rejected[0].message;
                assert!(why.contains("2026-05-01T10:00:00Z") && why.contains("forget"), "{why}");
                assert_eq!(value(&place), [0.31]);
            }
            // the ways out: another name, or the other ride is given up
            std::fs::rename(
                place.path(&format!("logs/{other}.csv")),
                place.path("logs/LOG002.csv"),
            )
            .expect("renamed");
            place.put("logs/LOG002.csv", second);
            assert_eq!(night(&place).done, 1);
            assert_eq!(value(&place), [0.31, 0.32]);
        }
    }
    // one that was cut or exported again is the same ride
    let place = Place::new(&[("LOG001", first)]);
    night(&place);
    place.put("logs/LOG001.csv", "*|b1|ok 0.33 2026-05-01T10:00:20Z");
    assert_eq!(night(&place).done, 1);
    assert_eq!(value(&place), [0.33]);
    // a log that says another id is another session; the ride that had its name stays
    place.put("logs/LOG001.csv", "s-2|b1|ok 0.34 2026-05-03T10:00:00Z");
    assert_eq!(night(&place).done, 1);
    assert_eq!(value(&place), [0.33, 0.34]);
    let found = verify(&place.path("out").into(), true).expect("verified").findings;
    assert_eq!(found.iter().map(|f| f.wrong).collect::<Vec<_>>(), [FindingKind::LogMissing]);
    // names that are exchanged among logs that are there are no reason
    place.put("logs/x.csv", "s-x|b2|ok 0.35 2026-05-04T10:00:00Z");
    place.put("logs/y.csv", "s-y|b2|ok 0.36 2026-05-05T10:00:00Z");
    night(&place);
    place.put("logs/y.csv", "s-x|b2|ok 0.35 2026-05-04T10:00:00Z");
    place.put("logs/x.csv", "s-y|b2|ok 0.36 2026-05-05T10:00:00Z");
    assert_eq!(night(&place).rejected.len(), 0);
    assert_eq!(place.sessions(), ["b1/LOG001", "b1/s-2", "b2/s-x", "b2/s-y"]);
}

/// What is damaged or gone of tables, fleet, report and lists is as it was after a run, with or without `--mend` before.
#[test]
fn what_is_damaged_comes_back_as_it_was() {
    let logs = [
        ("a", "s-a|b1|ok 0.31 2026-05-01T10:00:00Z"),
        ("b", "s-b|b1|ok 0.32 2026-05-02T10:00:00Z"),
        ("c", "s-c|b2|ok 0.33 2026-06-01T10:00:00Z"),
        ("d", "s-d|b2|reject"),
    ];
    let place = Place::new(&logs);
    night(&place);
    let whole = place.files("out");
    let out = place.path("out").into();
    let files: Vec<&String> = whole.keys().filter(|n| !n.starts_with("rejected/")).collect();
    assert!(files.iter().any(|n| n.starts_with("report/")), "{files:?}");
    let mut n = 0;
    for file in files {
        for is_cut in [false, true] {
            for mends in [false, true] {
                let path = place.path("out").join(file);
                match is_cut {
                    true => {
                        let bytes = &whole[file];
                        std::fs::write(&path, &bytes[..bytes.len() / 2]).expect("cut");
                    }
                    false => std::fs::remove_file(&path).expect("removed"),
                }
                if mends {
                    mend(&out, false).expect("mended");
                }
                night(&place);
                let now = place.files("out");
                let other: Vec<&String> = whole
                    .keys()
                    .chain(now.keys())
                    .filter(|name| whole.get(*name) != now.get(*name))
                    .collect();
                assert!(other.is_empty(), "{file}, cut {is_cut}, mended {mends}: {other:?}");
                n += 1;
            }
        }
    }
    assert!(n > 80, "{n}");
}

/// One motorcycle's damaged table costs no other motorcycle its fleet tables or its page, and the message says what to do.
#[test]
fn a_damaged_table_stops_no_other_motorcycle() {
    let place = Place::new(&[
        ("a", "s-a|b1|ok 0.31 2026-05-01T10:00:00Z"),
        ("b", "s-b|b1|ok 0.32 2026-05-02T10:00:00Z"),
        ("c", "s-c|b2|ok 0.33 2026-06-01T10:00:00Z"),
    ]);
    night(&place);
    let table = "out/coefficients/bike=b1/2026-05.parquet";
    place.put(table, "PAR1 a bad disk PAR1");
    std::fs::remove_file(place.path("logs/a.csv")).expect("its log is gone: nobody can compute it");
    place.put("logs/d.csv", "s-d|b2|ok 0.34 2026-06-02T10:00:00Z");
    for _ in 0..2 {
        let run = night(&place);
        let why = run.damage.as_deref().expect("said every night");
        assert!(why.contains("coefficients/bike=b1/2026-05.parquet"), "{why}");
        assert!(why.contains("backup"), "{why}");
        let fleet: Vec<FleetRow> = read::rows(&place.path("out")).expect("read");
        assert_eq!(fleet.iter().map(|r| r.bike_id.as_str()).collect::<Vec<_>>(), ["b2"]);
        assert_eq!(fleet[0].n_sessions, 2, "s-d is in");
        let index = std::fs::read_to_string(place.path("out/report/index.html")).expect("a page");
        assert!(index.contains("s-d"));
        let found = verify(&place.path("out").into(), false).expect("verified");
        assert_eq!(found.unlisted, 0, "new tables have checksums");
        let damaged: Vec<_> = found.findings.iter().filter(|f| f.wrong.is_damage()).collect();
        assert_eq!(damaged.len(), 1, "{damaged:?}");
        assert_eq!(std::fs::read(place.path(table)).expect("stays"), b"PAR1 a bad disk PAR1");
    }
    let out = place.path("out").into();
    assert_eq!(mend(&out, false).expect("mended").removed, [""; 0], "s-a would be lost");
    assert_eq!(mend(&out, true).expect("mended").removed, [table.trim_start_matches("out/")]);
    let run = night(&place);
    assert_eq!(run.damage, None);
    let fleet: Vec<FleetRow> = read::rows(&place.path("out")).expect("read");
    assert_eq!(fleet.len(), 2, "s-b is back");
}

/// A bike file with a mistake in it, or that is gone, costs no session: the next night with a good one finds them as they were.
#[test]
fn a_bike_file_that_cannot_be_used_costs_no_session() {
    let place = Place::new(&[
        ("s-a", "s-a|b1|ok"),
        ("b", "s-b|b1|ok"),
        ("c", "s-c|b2|ok"),
        ("d", "s-d|b1|ok"),
    ]);
    night(&place);
    let whole = place.files("out");
    let good = std::fs::read_to_string(place.path("bikes/b1.toml")).expect("a bike file");
    let bad = [
        Some(good.replace("mass = 260.0", "mass = \"heavy\"")),
        Some(good.replace("mass", "masss")),
        Some(String::new()),
        None,
    ];
    for text in bad {
        match &text {
            Some(text) => place.put("bikes/b1.toml", text),
            None => std::fs::remove_file(place.path("bikes/b1.toml")).expect("removed"),
        }
        // a log that changed, and one that is new, wait for the bike file
        place.put("logs/d.csv", "s-d|b1|ok ");
        place.put("logs/e.csv", "s-e|b1|ok");
        let code = if text.is_some() { "bad_bike_file" } else { "no_bike_file" };
        for _ in 0..2 {
            let run = night(&place);
            assert_eq!((run.unchanged, codes(&run)), (1, vec![code; 4]), "{text:?}");
            let now = place.files("out");
            let is_table = |name: &&String| name.contains("/bike=");
            let other: Vec<&String> = whole
                .keys()
                .chain(now.keys())
                .filter(is_table)
                .filter(|name| whole.get(*name) != now.get(*name))
                .collect();
            assert!(other.is_empty(), "{other:?}");
        }
        place.put("bikes/b1.toml", &good);
        place.put("logs/d.csv", "s-d|b1|ok");
        std::fs::remove_file(place.path("logs/e.csv")).expect("removed");
        let run = night(&place);
        assert_eq!((run.done, run.unchanged, run.rejected.len()), (0, 4, 0), "{text:?}");
        assert!(place.files("out") == whole, "{text:?}");
    }
}

/// Nor does a channel map that is forgotten or fits no more: the log is what it was. One that has changed too is lost.
#[test]
fn a_channel_map_that_fits_no_more_costs_no_session() {
    use roadbench::internals::contract::rejection::RejectionCode as Code;
    for code in [Code::NoChannelMap, Code::MissingColumn, Code::NoBikeId] {
        let place = Place::new(&[("s-a", "s-a|b1|ok"), ("s-b", "s-b|b1|ok")]);
        night(&place);
        place.put("logs/s-b.csv", "s-b|b1|ok ");
        // the version and the maps are among the settings: no log is known without being opened
        place.put("bikes/b1.toml", &BIKE.replace("260.0", "261.0"));
        let without = Script { refuses: Some(code), ..Script::default() };
        let run = place.run_with(&without, |_| {}).expect("run");
        assert_eq!(codes(&run), [code.as_str(); 2]);
        assert_eq!(place.sessions(), ["b1/s-a"], "{code}");
        let run = night(&place);
        assert_eq!((run.done, run.rejected.len()), (2, 0));
    }
}

/// A table that comes back from a backup changes no session. Fleet and report, which were made without it, are made again.
#[test]
fn a_table_from_a_backup_comes_back_into_fleet_and_report() {
    let place = Place::new(&[
        ("a", "s-a|b1|ok 0.31 2026-05-01T10:00:00Z"),
        ("c", "s-c|b2|ok 0.33 2026-06-01T10:00:00Z"),
    ]);
    night(&place);
    std::fs::remove_file(place.path("logs/a.csv")).expect("its log is gone: nobody can compute it");
    night(&place);
    let whole = place.files("out");
    for file in ["coefficients/bike=b1/2026-05.parquet", "plots/bike=b1/2026-05.parquet"] {
        for is_cut in [false, true] {
            let path = place.path("out").join(file);
            match is_cut {
                true => std::fs::write(&path, &whole[file][..100]).expect("cut"),
                false => std::fs::remove_file(&path).expect("removed"),
            }
            assert!(night(&place).damage.is_some(), "{file}");
            let without = place.files("out");
            assert!(whole.iter().any(|(name, bytes)| {
                name.starts_with("report/") && without.get(name) != Some(bytes)
            }));
            std::fs::write(&path, &whole[file]).expect("from a backup");
            assert_eq!(night(&place).damage, None);
            let now = place.files("out");
            let other: Vec<&String> =
                whole.keys().filter(|name| whole.get(*name) != now.get(*name)).collect();
            assert!(other.is_empty(), "{file}, cut {is_cut}: {other:?}");
        }
    }
}

/// A table's file as another version of its schema has it, without some columns; the list of checksums agrees.
fn of_version(place: &Place, table: &str, version: &str, without: &[&str]) {
    let path = place.path(table);
    let rows: Vec<RecordBatch> =
        read::batches_of(std::fs::read(&path).expect("there").into()).expect("read");
    let schema = rows[0].schema();
    let kept: Vec<usize> = (0..schema.fields().len())
        .filter(|i| !without.contains(&schema.field(*i).name().as_str()))
        .collect();
    let mut metadata = schema.metadata().clone();
    metadata.insert("roadbench.schema".into(), version.into());
    let whole = concat_batches(&schema, &rows).expect("one batch").project(&kept).expect("fewer");
    let schema = whole.schema().as_ref().clone().with_metadata(metadata);
    let batch = whole.with_schema(schema.into()).expect("the same fields");
    file::write_batch(&path, &batch).expect("written");
    let mut list: std::collections::BTreeMap<String, String> = serde_json::from_slice(
        &std::fs::read(place.path("out/.roadbench/checksums.json")).expect("a list"),
    )
    .expect("a list");
    let sum = blake3::hash(&std::fs::read(&path).expect("there")).to_hex().to_string();
    list.insert(table.trim_start_matches("out/").into(), sum);
    place.put("out/.roadbench/checksums.json", &serde_json::to_string(&list).expect("text"));
}

/// A month that the earlier version of the tables wrote stays readable, and becomes one of today with the next session that comes.
#[test]
fn a_month_of_the_earlier_version_goes_on() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("c", "s-c|b2|ok")]);
    night(&place);
    let months = ["b1", "b2"].map(|bike| format!("out/coefficients/bike={bike}/2026-05.parquet"));
    for month in &months {
        of_version(&place, month, "coefficients.v1", &["term"]);
    }
    let rows = || -> Vec<Coefficient> { read::rows(&place.path("out")).expect("read") };
    let before = rows();
    assert!(!before.is_empty() && before.iter().all(|row| row.term.is_none()));
    assert_eq!(night(&place).unchanged, 2, "nothing is computed for a new column");
    place.put("logs/b.csv", "s-b|b1|ok");
    let run = night(&place);
    assert_eq!((run.done, run.unchanged, run.damage), (1, 2, None));
    // the other motorcycle's month, too: who reads all files at once finds one set of columns
    for month in &months {
        let file = std::fs::File::open(place.path(month)).expect("there");
        let reader = parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder::try_new(file);
        let schema = reader.expect("read").schema().clone();
        assert_eq!(schema.metadata()["roadbench.schema"], "coefficients.v2");
        assert!(schema.field_with_name("term").is_ok());
    }
    let same: Vec<Coefficient> =
        rows().into_iter().filter(|row| row.ident.session_id != "s-b").collect();
    assert_eq!(same.len(), before.len());
    assert!(same.iter().zip(&before).all(|(now, then)| now.value == then.value));
    assert!(verify(&place.path("out").into(), true).expect("verified").findings.is_empty());
}

/// What a newer version wrote is not replaced by what this one knows of it.
#[test]
fn tables_of_a_newer_version_are_left_alone() {
    let place = Place::new(&[("a", "s-a|b1|ok"), ("c", "s-c|b2|ok")]);
    night(&place);
    of_version(&place, "out/coefficients/bike=b1/2026-05.parquet", "coefficients.v3", &[]);
    let before = std::fs::read(place.path("out/coefficients/bike=b1/2026-05.parquet")).expect("it");
    place.put("logs/b.csv", "s-b|b1|ok");
    place.put("logs/d.csv", "s-d|b2|ok");
    let run = place.run();
    let why = run.damage.as_deref().expect("said");
    assert!(why.contains("newer roadbench (coefficients.v3)"), "{why}");
    let after = std::fs::read(place.path("out/coefficients/bike=b1/2026-05.parquet")).expect("it");
    assert!(before == after, "as it was");
    let rows: Vec<SessionRow> = read::rows(&place.path("out")).expect("read");
    let ids: Vec<&str> = rows.iter().map(|r| r.ident.session_id.as_str()).collect();
    assert_eq!(ids, ["s-a", "s-c", "s-d"], "the other motorcycle goes on");
    place.put("out/.roadbench/output.json", r#"{"program": "roadbench", "format": 99}"#);
    let refused = place.run_with(&Script::default(), |_| {});
    assert!(matches!(&refused, Err(Error::Usage(m)) if m.contains("newer")), "{refused:?}");
    assert!(mark::is_output(&place.path("out").into()).is_err());
}
