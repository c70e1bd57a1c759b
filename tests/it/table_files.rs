//! The files of tables as readers meet them: plain texts, a file of every table, and the schema's types.

use std::path::{Path, PathBuf};

use arrow::datatypes::{DataType, SchemaRef};
use assert_cmd::Command;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::registry;
use roadbench::internals::store::tables::registry::{Command as Of, TableSpec};

fn schema(path: &Path) -> (SchemaRef, i64) {
    let file = std::fs::File::open(path).expect("open");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("parquet");
    let rows = reader.metadata().file_metadata().num_rows();
    (reader.schema().clone(), rows)
}

fn files(out: &Path, spec: &TableSpec) -> Vec<PathBuf> {
    read::files(out, spec).expect("listed")
}

/// Tables that `run` writes.
fn of_run() -> impl Iterator<Item = &'static TableSpec> {
    let fleet: Vec<&TableSpec> =
        if cfg!(feature = "fleet") { registry::of_fleet().collect() } else { Vec::new() };
    registry::of_session(Of::Run).chain([&registry::REJECTED]).chain(fleet)
}

#[test]
fn every_table_is_there_whatever_the_rides_gave() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let archive = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive");
    let ride = "sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet";
    std::fs::create_dir_all(at("logs")).expect("made");
    std::fs::write(at("logs/words.csv"), "no ride at all").expect("written");
    for (log, code, has_rows) in [(at("logs"), 1, false), (archive.join(ride), 0, true)] {
        let out = at(if has_rows { "one" } else { "none" });
        let run = || {
            let mut run = Command::cargo_bin("roadbench").expect("built");
            run.arg("run").arg(&log).arg("--bikes").arg(archive.join("bikes"));
            run.arg("--out").arg(&out).assert().code(code);
        };
        run();
        for spec in of_run() {
            let all = files(&out, spec);
            assert!(!all.is_empty(), "{}: no file", spec.name);
            for path in &all {
                assert_eq!(schema(path).0, spec.table().arrow(), "{}", path.display());
            }
            // `coefficients/*/*.parquet`, as queries have it
            let root = out.join(spec.name);
            let in_partition = |path: &PathBuf| path.parent().and_then(Path::parent) == Some(&root);
            let of_session = spec.scope == registry::Scope::Session;
            assert!(!of_session || all.iter().any(in_partition), "{}", spec.name);
        }
        let rows =
            |spec: &TableSpec| -> i64 { files(&out, spec).iter().map(|path| schema(path).1).sum() };
        assert_eq!(rows(&registry::SESSIONS) > 0, has_rows);
        assert_eq!(rows(&registry::REJECTED) > 0, !has_rows);
        // nothing is amiss, and what an output of an earlier version lacks the next run adds
        let mut verify = Command::cargo_bin("roadbench").expect("built");
        verify.arg("verify").arg(&out).assert().success();
        std::fs::remove_dir_all(out.join("laps")).expect("removed");
        run();
        assert!(!files(&out, &registry::LAPS).is_empty());
    }
}

#[test]
fn no_table_has_dictionaries_for_texts() {
    for spec in registry::ALL {
        for field in spec.table().arrow().fields() {
            let is_dictionary = matches!(field.data_type(), DataType::Dictionary(..));
            assert!(!is_dictionary, "{}.{}", spec.name, field.name());
        }
    }
}

#[test]
fn the_truth_of_the_bundled_archive_is_as_its_schema_says() {
    let truth = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive/truth");
    for (folder, spec) in
        [("coefficients", &registry::TRUTH), ("segments", &registry::TRUTH_SEGMENTS)]
    {
        let mut n = 0;
        for entry in walkdir::WalkDir::new(truth.join(folder)) {
            let entry = entry.expect("entry");
            if entry.file_type().is_file() {
                let (schema, rows) = schema(entry.path());
                assert_eq!(schema, spec.table().arrow(), "{}", entry.path().display());
                assert!(rows > 0);
                n += 1;
            }
        }
        assert_eq!(n, 12, "{folder}");
    }
}

/// A median over values that are not determined is no tyre's: each query of the book asks for the status.
#[test]
fn queries_of_the_book_take_determined_values_alone() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("book/src/output.md");
    let text = std::fs::read_to_string(page).expect("a page of the book");
    let medians: Vec<&str> = text.lines().filter(|line| line.contains("median(")).collect();
    assert!(medians.len() > 1, "{medians:?}");
    for line in medians {
        assert!(line.contains("status") && line.contains("ok"), "{line}");
    }
}
