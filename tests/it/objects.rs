//! Batches from and to an object store, through the real binary, against a server that fails now
//! and then.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use arrow::array::{ArrayRef, Float64Array, RecordBatch};
use arrow::datatypes::{DataType, Field, Schema};
use parquet::arrow::ArrowWriter;
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

use crate::s3_server::{Seen, Server, kinds};

const BIKE: &str = "mass = 260.0\nwheelbase = 1.45\ncg_to_front = 0.72\ncg_height = 0.62\n\
    caster_angle = 0.43\n[front]\nradius = 0.3\nwidth = 0.12\n[rear]\nradius = 0.31\nwidth = 0.18\n";

/// Sessions of the archive: so many as Parquet, so many as CSV.
const PARQUET: usize = 24;
const CSV: usize = 8;

/// Columns of a Parquet log that no stage wants.
const UNWANTED: usize = 24;

/// Tables whose bytes do not know where the log came from.
const SAME: [&str; 3] = ["manoeuvres", "warnings", "plots"];

/// A slow ride of some seconds, twenty samples each.
fn ride(number: usize, n: usize) -> Vec<(&'static str, Vec<f64>)> {
    let mut random = Pcg64::seed_from_u64(number as u64);
    let time: Vec<f64> = (0..n).map(|i| i as f64 / 20.0).collect();
    let speed: Vec<f64> =
        time.iter().map(|t| 15.0 + (0.4 * t).sin() + 0.01 * random.random::<f64>()).collect();
    let over = |by: f64| speed.iter().map(|v| v / by).collect::<Vec<f64>>();
    let roll = time.iter().map(|t| 0.2 * (0.3 * t).sin()).collect();
    let (front, rear) = (over(0.3), over(0.31));
    let acceleration = time.iter().map(|t| 0.4 * (0.4 * t).cos()).collect();
    vec![
        ("time", time),
        ("velocity_x", speed),
        ("acceleration_x", acceleration),
        ("roll", roll),
        ("wheel_speed_front", front),
        ("wheel_speed_rear", rear),
    ]
}

fn parquet(number: usize, n: usize) -> Vec<u8> {
    let mut columns = ride(number, n);
    let rows = columns[0].1.len();
    let mut random = Pcg64::seed_from_u64(1000 + number as u64);
    // what is not wanted is most of the file, and between what is and the footer
    let names: Vec<String> = (0..UNWANTED).map(|i| format!("camera_{i:02}")).collect();
    for name in &names {
        columns.push((name, (0..rows).map(|_| random.random()).collect()));
    }
    let fields: Vec<Field> =
        columns.iter().map(|(name, _)| Field::new(*name, DataType::Float64, true)).collect();
    let arrays = columns.iter().map(|(_, x)| Arc::new(Float64Array::from(x.clone())) as ArrayRef);
    let batch = RecordBatch::try_new(Arc::new(Schema::new(fields)), arrays.collect());
    let mut bytes = Vec::new();
    let pairs = vec![KeyValue::new("site".to_owned(), "ring".to_owned())];
    let properties = WriterProperties::builder()
        .set_key_value_metadata(Some(pairs))
        .set_dictionary_enabled(false)
        .build();
    let batch = batch.expect("batch");
    let mut writer =
        ArrowWriter::try_new(&mut bytes, batch.schema(), Some(properties)).expect("writer");
    writer.write(&batch).expect("rows");
    writer.close().expect("footer");
    bytes
}

fn csv(number: usize) -> Vec<u8> {
    let columns = ride(number, 300);
    let names: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
    let mut text = names.join(",") + "\n";
    for row in 0..columns[0].1.len() {
        let cells: Vec<String> = columns.iter().map(|(_, x)| format!("{:.6}", x[row])).collect();
        text.push_str(&(cells.join(",") + "\n"));
    }
    text.into_bytes()
}

/// The archive's files.
fn archive() -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    for bike in ["b1", "b2"] {
        files.insert(format!("bikes/{bike}.toml"), BIKE.as_bytes().to_vec());
    }
    for i in 0..PARQUET + CSV {
        let folder = format!("sessions/bike=b{}/date=2026-05-{:02}", 1 + i % 2, 1 + i % 28);
        let (bytes, extension) =
            if i < PARQUET { (parquet(i, 240 + 20 * (i % 5)), "parquet") } else { (csv(i), "csv") };
        files.insert(format!("{folder}/s{i:03}.{extension}"), bytes);
    }
    files.insert("sessions/bike=b1/broken.parquet".to_owned(), b"PAR1 and then nothing".to_vec());
    files.insert("README.md".to_owned(), b"no log".to_vec());
    files
}

fn served() -> Server {
    let server = Server::start();
    for (name, bytes) in archive() {
        server.put(&format!("in/{name}"), bytes);
    }
    server
}

fn command(server: &Server, arguments: &[&str]) -> Command {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin!("roadbench"));
    command.args(arguments).envs(server.environment());
    for (name, _) in std::env::vars().filter(|(name, _)| name.starts_with("AWS_")) {
        if server.environment().iter().all(|(ours, _)| *ours != name) {
            command.env_remove(name);
        }
    }
    command
}

pub fn run(server: &Server, arguments: &[&str]) -> (i32, String) {
    let Output { status, stdout, stderr } =
        command(server, arguments).output().expect("roadbench starts");
    let text = String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr);
    (status.code().unwrap_or(-1), text)
}

type Files = BTreeMap<String, Vec<u8>>;

/// Every table and page, without what tells of the run itself.
fn tables(files: impl IntoIterator<Item = (String, Vec<u8>)>) -> Files {
    files.into_iter().filter(|(name, _)| name != "run.json" && !name.starts_with('.')).collect()
}

fn there(server: &Server, prefix: &str) -> Files {
    tables(server.below(prefix).into_iter().map(|(name, bytes)| (name, bytes.to_vec())))
}

fn here(folder: &Path) -> Files {
    let files = walkdir::WalkDir::new(folder).into_iter().filter_map(Result::ok);
    tables(files.filter(|e| e.file_type().is_file()).map(|e| {
        let name = e.path().strip_prefix(folder).expect("below").to_string_lossy().into_owned();
        (name, std::fs::read(e.path()).expect("read"))
    }))
}

fn assert_same(a: &Files, b: &Files) {
    let names = |files: &Files| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(a), names(b));
    for (name, bytes) in a {
        assert!(b[name] == *bytes, "{name} differs");
    }
    let sessions = a.iter().filter(|(name, _)| name.starts_with("sessions/"));
    let n: usize = sessions.flat_map(|(_, bytes)| rows(bytes)).map(|b| b.num_rows()).sum();
    assert_eq!(n, PARQUET + CSV);
}

/// A table's rows without what names the log.
fn rows(bytes: &[u8]) -> Vec<RecordBatch> {
    let bytes = bytes::Bytes::copy_from_slice(bytes);
    let reader = ParquetRecordBatchReaderBuilder::try_new(bytes).expect("parquet");
    let batches = reader.build().expect("reader").map(|batch| {
        let batch = batch.expect("rows");
        let fields = batch.schema();
        let kept = fields.fields().iter().enumerate();
        let kept = kept.filter(|(_, f)| !["path", "input_hash"].contains(&f.name().as_str()));
        batch.project(&kept.map(|(i, _)| i).collect::<Vec<_>>()).expect("columns")
    });
    batches.collect()
}

fn count(seen: &[Seen], method: &str, part: &str) -> usize {
    seen.iter().filter(|s| s.method == method && s.key.contains(part)).count()
}

fn downloads(seen: &[Seen]) -> usize {
    count(seen, "GET", "in/sessions")
}

const THERE: [&str; 4] = ["run", "s3://fleet/in", "--out", "s3://fleet/out"];

#[test]
fn a_batch_on_a_failing_store_ends_like_one_on_disk() {
    let server = served();
    let folder = tempfile::tempdir().expect("folder");
    for (name, bytes) in archive() {
        let path = folder.path().join("in").join(name);
        std::fs::create_dir_all(path.parent().expect("parent")).expect("folder");
        std::fs::write(path, bytes).expect("file");
    }
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();

    // as it should be: all on disk, and from the store to disk
    let (code, said) = run(&server, &["run", &at("in"), "--out", &at("disk")]);
    assert_eq!(code, 1, "{said}");
    assert_eq!(server.seen().len(), 0, "no request for local files");
    let (code, said) = run(&server, &["run", "s3://fleet/in", "--out", &at("fetched")]);
    assert_eq!(code, 1, "{said}");
    let seen = server.seen();
    assert_eq!(count(&seen, "PUT", ""), 0);
    println!("from the store, {} logs: {} requests for logs", PARQUET + CSV, downloads(&seen));
    let fetched = here(&folder.path().join("fetched"));
    let disk = here(&folder.path().join("disk"));
    for (name, bytes) in &disk {
        let table = name.split('/').next().unwrap_or("");
        if SAME.contains(&table) {
            assert!(fetched[name] == *bytes, "{name} differs");
        }
        if ["sessions", "coefficients"].contains(&table) {
            assert_eq!(rows(&fetched[name]), rows(bytes), "{name}");
        }
    }

    // with faults, two at a time, everything in the store
    server.faults(7, 0.12, 60);
    let start = Instant::now();
    let (code, said) = run(&server, &[&THERE[..], &["--jobs", "2"]].concat());
    assert_eq!(code, 1, "{said}");
    let seen = server.seen();
    let failed = seen.iter().filter(|s| s.fault.is_some()).count();
    println!(
        "{} requests, {failed} with faults {:?}, {:?}",
        seen.len(),
        kinds(&seen),
        start.elapsed()
    );
    assert!(failed >= 30 && kinds(&seen).len() >= 6, "{failed} {:?}", kinds(&seen));
    server.faults(0, 0.0, 0);
    assert_same(&there(&server, "out/"), &fetched);
    let told = server.below("out/run.json");
    let told: serde_json::Value = serde_json::from_slice(&told[""]).expect("json");
    assert!(told["requests"]["failed"].as_u64() > Some(10), "{told}");
    println!("run.json: {}", told["requests"]);

    // A request that the client has given up may still be done, even after the next one: a session that
    // was taken in can wait once more. The next run takes it in again.
    std::thread::sleep(Duration::from_secs(3));
    println!("left behind: {:?}", waiting(&server));
    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 1, "{said}");
    assert_eq!(waiting(&server), [""; 0]);
    assert_same(&there(&server, "out/"), &fetched);
}

/// What is below `.roadbench` but for checksums and mark.
fn waiting(server: &Server) -> Vec<String> {
    let own = ["checksums.json", "output.json"];
    let all = server.below("out/.roadbench/").into_keys();
    all.filter(|key| !own.contains(&key.as_str())).collect()
}

/// Bits that are turned on the way, in logs and in tables, are noticed and asked for or sent again; what is turned in the
/// store itself is reported, and computed again.
#[test]
fn turned_bits_are_noticed() {
    let server = served();
    let folder = tempfile::tempdir().expect("folder");
    // the inputs under names that are checksums
    server.flips(0);
    for (key, bytes) in server.below("in/") {
        server.put(&format!("in/{key}"), bytes.to_vec());
    }
    let whole = folder.path().join("whole").to_string_lossy().into_owned();
    let (code, said) = run(&server, &["run", "s3://fleet/in", "--out", &whole]);
    assert_eq!(code, 1, "{said}");
    let whole = here(&folder.path().join("whole"));

    server.flips(5);
    let (code, said) = run(&server, &THERE);
    let turned = server.flips(0);
    assert_eq!(code, 1, "{said}");
    assert!(turned > 20, "{turned}");
    assert_same(&there(&server, "out/"), &whole);

    // the same without the fifth bit finds nothing to do, and nothing wrong
    let (_, said) = run(&server, &THERE);
    assert!(said.contains("computed=0"), "{said}");
    let (code, said) = run(&server, &["verify", "s3://fleet/out"]);
    assert_eq!(code, 0, "{said}");

    // a disk of the store turns one
    let table = "out/coefficients/bike=b1/";
    let (key, bytes) = server.below(table).into_iter().next().expect("a table");
    let mut bytes = bytes.to_vec();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 4;
    server.put(&format!("{table}{key}"), bytes);
    let (code, said) = run(&server, &["verify", "s3://fleet/out", "--no-logs"]);
    assert_eq!(code, 1, "{said}");
    assert!(said.contains("changed") && said.contains(&key), "{said}");
    let (code, said) = run(&server, &["verify", "s3://fleet/out", "--no-logs", "--mend"]);
    assert_eq!(code, 0, "{said}");
    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 1, "{said}");
    assert_same(&there(&server, "out/"), &whole);
}

#[test]
fn what_has_not_changed_is_not_downloaded_and_only_wanted_columns_are() {
    let server = served();
    server.remove("in/sessions/bike=b1/broken.parquet");
    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 0, "{said}");
    let seen = server.seen();
    let per_session = |n: usize| n as f64 / (PARQUET + CSV) as f64;
    let own = ["sessions", "coefficients", "manoeuvres", "warnings", "plots", "staged"];
    let puts = seen.iter().filter(|s| s.method == "PUT" && own.iter().any(|o| s.key.contains(o)));
    println!(
        "{} requests in all; a session: {:.2} to read its log, {:.2} to write its tables",
        seen.len(),
        per_session(downloads(&seen)),
        per_session(puts.count() + count(&seen, "POST", ""))
    );
    assert!(downloads(&seen) <= 5 * PARQUET + CSV + 10, "{}", downloads(&seen));

    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 0, "{said}");
    let seen = server.seen();
    assert_eq!(downloads(&seen), 0, "{said}");
    println!("nothing changed: {} requests", seen.len());
    assert!(said.contains(&format!("unchanged={}", PARQUET + CSV)), "{said}");

    // one log is others' bytes now, a large one comes, earlier in order
    let old = "in/sessions/bike=b1/date=2026-05-03/s002.parquet";
    let large = parquet(78, 6000);
    let size = large.len() as u64;
    server.put(old, parquet(77, 300));
    server.put("in/sessions/bike=b1/a000.parquet", large);
    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("computed=2"), "{said}");
    let seen = server.seen();
    let logs = seen.iter().filter(|s| s.method == "GET" && s.key.starts_with("in/sessions"));
    let (old, new): (Vec<&Seen>, Vec<&Seen>) = logs.partition(|s| s.key == old);
    assert!(!old.is_empty() && new.iter().all(|s| s.key.ends_with("a000.parquet")), "{new:?}");
    let read: u64 = new.iter().map(|s| s.length()).sum();
    println!("a log of {size} bytes: {read} read in {} requests", new.len());
    assert!(read < size / 2, "{new:?}");
}

#[test]
fn a_killed_run_leaves_a_lock_that_ends_and_tables_that_are_mended() {
    let server = served();
    server.remove("in/sessions/bike=b1/broken.parquet");
    let (code, said) = run(&server, &THERE);
    assert_eq!(code, 0, "{said}");
    let whole = there(&server, "out/");
    server.seen();

    // each on a server of its own and at once: they wait most of the time
    std::thread::scope(|scope| {
        for kill_after in [3, 25, 60] {
            let (twin, whole) = (server.twin(), &whole);
            scope.spawn(move || is_mended(&twin, whole, kill_after));
        }
    });
}

/// Computes again what is there, is killed after so many writes, and ends like `whole`.
fn is_mended(server: &Server, whole: &Files, kill_after: usize) {
    // computed again, slowly, and killed between two requests that write
    server.faults(1, 0.1, usize::MAX);
    let mut child: Child = command(server, &[&THERE[..], &["--force"]].concat())
        .env("ROADBENCH_LOCK_SECONDS", "8")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("roadbench starts");
    let mut puts = 0;
    let start = Instant::now();
    while puts < kill_after && start.elapsed() < Duration::from_secs(60) {
        puts += count(&server.seen(), "PUT", "out/");
        std::thread::sleep(Duration::from_millis(5));
    }
    child.kill().expect("killed");
    child.wait().expect("gone");
    server.faults(0, 0.0, 0);
    assert!(server.below("out/.roadbench/").contains_key("lock"));
    // a reader sees whole tables
    for (name, bytes) in there(server, "out/") {
        if name.ends_with(".parquet") {
            rows(&bytes); // or it panics
        }
    }
    let (code, said) = run(server, &THERE);
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("another roadbench") && said.contains("its lock ends at"), "{said}");
    // the lock ends, and so do requests that the server was slow to do
    std::thread::sleep(Duration::from_secs(3));
    let until = Instant::now() + Duration::from_secs(20);
    let (code, said) = loop {
        let ended = run(server, &THERE);
        if ended.0 != 2 || Instant::now() > until {
            break ended;
        }
        std::thread::sleep(Duration::from_millis(500));
    };
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("taking over the lock"), "{said}");
    assert_same(&there(server, "out/"), whole);
    assert_eq!(waiting(server), [""; 0]);
    println!("killed after {puts} writes: mended");
}

#[test]
fn refusals_say_what_to_set() {
    let server = served();
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let bikes = ["--bikes", "s3://fleet/in/bikes"];
    let s3 = "s3://fleet/in";
    for (arguments, code, words) in [
        (vec!["run", "s3:///in", "--out", &out], 2, "bucket is missing"),
        (vec!["run", "ftp://fleet/in", "--out", &out], 2, "`ftp`"),
        (vec!["run", "s3://gone/in", "--out", &out], 2, "no bucket s3://gone"),
        (vec!["run", "s3://fleet/gone", "--out", &out], 2, "s3://fleet/gone does not exist"),
        (vec!["run", "s3://fleet/in/*/x*.csv", "--out", &out], 2, "nothing matches"),
        (vec!["run", s3, "--out", "s3://gone/out"], 3, "no bucket s3://gone"),
        (vec!["run", s3, "--out", "s3://fleet/in/sessions"], 2, "choose another"),
        (vec!["run", s3, "--bikes", "s3://fleet/none", "--out", &out], 2, "no bike file"),
    ] {
        let (got, said) = run(&server, &arguments);
        assert_eq!(got, code, "{arguments:?}: {said}");
        assert!(said.contains(words), "{arguments:?}: {said}");
    }
    let one = ["run", "s3://fleet/in/sessions/*/*/s00[0-3].parquet"];
    let (code, said) = run(&server, &[&one[..], &bikes, &["--out", &out, "--dry-run"]].concat());
    assert!(code == 0 && said.contains("4 logs: 4 to compute"), "{said}");

    let with = |change: &dyn Fn(&mut Command)| {
        let mut command = command(&server, &["run", s3, "--out", &out]);
        change(&mut command);
        let Output { status, stderr, .. } = command.output().expect("roadbench starts");
        (status.code(), String::from_utf8_lossy(&stderr).into_owned())
    };
    let (code, said) = with(&|c| _ = c.env("AWS_ACCESS_KEY_ID", "stranger"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("permission denied (403)") && said.contains("AWS_SECRET_ACCESS_KEY"));
    let (code, said) = with(&|c| {
        c.env_remove("AWS_ACCESS_KEY_ID").env_remove("AWS_SECRET_ACCESS_KEY");
        c.env("AWS_EC2_METADATA_DISABLED", "true");
    });
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("no credentials for s3://"), "{said}");
    let (code, said) = with(&|c| _ = c.env("AWS_ALLOW_HTTP", "false"));
    assert_eq!(code, Some(2), "{said}");
    assert!(said.contains("AWS_ALLOW_HTTP=true"), "{said}");
    assert!(!folder.path().join("out").exists());
}
