//! Logs that end the process which reads them: one worker and one row of `rejected`, and the batch goes on.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use arrow::array::{ArrayRef, Float64Array, RecordBatch};
use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use parquet::arrow::{ARROW_SCHEMA_META_KEY, ArrowWriter};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{Rejected, SessionRow};

const ARCHIVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/fixtures/archive");

/// The bundled archive, to which logs may be added.
pub struct Archive(tempfile::TempDir);

/// Samples of a ride that [`Archive::new`] keeps: 40 s.
const SHORT: usize = 2000;

impl Archive {
    /// The begin of each ride: what is in the tables is no matter, and a run takes a quarter of the time.
    pub fn new() -> Self {
        Archive::with(begin_of)
    }

    /// The rides as they are.
    pub fn complete() -> Self {
        Archive::with(|from, to| _ = std::fs::copy(from, to).expect("copied"))
    }

    /// The archive, each log written by `log` from one place to another.
    fn with(log: fn(&Path, &Path)) -> Self {
        let folder = tempfile::tempdir().expect("folder");
        for entry in walkdir::WalkDir::new(ARCHIVE).into_iter().filter_map(Result::ok) {
            let below = entry.path().strip_prefix(ARCHIVE).expect("below");
            let to = folder.path().join("logs").join(below);
            match entry.file_type().is_dir() {
                true => std::fs::create_dir_all(&to).expect("folder"),
                false if below.starts_with("sessions") => log(entry.path(), &to),
                false => _ = std::fs::copy(entry.path(), &to).expect("copied"),
            }
        }
        Archive(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn log(&self, name: &str) -> PathBuf {
        self.path("logs/sessions/bike=archive_01").join(name)
    }

    pub fn command(&self, out: &str, more: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_roadbench"));
        command.arg("run").arg(self.path("logs")).arg("--out").arg(self.path(out)).args(more);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        command
    }

    pub fn run(&self, out: &str, more: &[&str]) -> Output {
        self.command(out, more).output().expect("started")
    }

    pub fn sessions(&self, out: &str) -> usize {
        read::rows::<SessionRow>(&self.path(out)).expect("sessions").len()
    }

    pub fn rejected(&self, out: &str) -> Vec<Rejected> {
        read::rows(&self.path(out)).expect("rejected")
    }
}

/// Writes the first samples of a log as another.
fn begin_of(log: &Path, to: &Path) {
    let file = std::fs::File::open(log).expect("a log");
    let reader = ParquetRecordBatchReaderBuilder::try_new(file).expect("a table");
    let pairs = reader.metadata().file_metadata().key_value_metadata().cloned().unwrap_or_default();
    let own = pairs.into_iter().filter(|pair| pair.key != ARROW_SCHEMA_META_KEY).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(own)).build();
    let schema = reader.schema().clone();
    let file = std::fs::File::create(to).expect("file");
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).expect("writer");
    for batch in reader.with_limit(SHORT).build().expect("a reader") {
        writer.write(&batch.expect("rows")).expect("rows");
    }
    writer.close().expect("closed");
}

/// So many rows that say the same, in a few bytes each column.
pub fn constant_rows(to: &Path, rows: usize) {
    constant_rows_of(to, rows, &[]);
}

/// The same, and says whose it is.
pub fn constant_rows_of(to: &Path, rows: usize, who: &[(&str, &str)]) {
    let file = std::fs::File::create(to).expect("file");
    let names =
        ["velocity_x", "roll", "yaw_rate", "wheel_speed_front", "wheel_speed_rear", "throttle"];
    let batch = |start: usize, n: usize| {
        let time = Float64Array::from_iter_values((start..start + n).map(|i| i as f64 * 0.01));
        let one: ArrayRef = Arc::new(Float64Array::from_value(1.0, n));
        let columns = names.iter().map(|name| (*name, Arc::clone(&one)));
        let time: (&str, ArrayRef) = ("time", Arc::new(time));
        RecordBatch::try_from_iter([time].into_iter().chain(columns)).expect("columns")
    };
    let pairs = who.iter().map(|(k, v)| KeyValue::new((*k).to_owned(), (*v).to_owned())).collect();
    let properties = WriterProperties::builder().set_key_value_metadata(Some(pairs)).build();
    let schema = batch(0, 1).schema();
    let mut writer = ArrowWriter::try_new(file, schema, Some(properties)).expect("writer");
    for start in (0..rows).step_by(100_000) {
        writer.write(&batch(start, 100_000)).expect("rows");
    }
    writer.close().expect("closed");
}

pub fn whole(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let files =
        walkdir::WalkDir::new(folder).sort_by_file_name().into_iter().filter_map(Result::ok);
    let files = files.filter(|e| e.file_type().is_file() && e.file_name() != "run.json");
    files
        .map(|e| {
            let bytes = std::fs::read(e.path()).expect("there");
            (e.path().strip_prefix(folder).expect("below").to_owned(), bytes)
        })
        .collect()
}

#[test]
fn workers_write_what_the_process_itself_does() {
    let archive = Archive::complete();
    let (fenced, own) = (archive.run("fenced", &[]), archive.run("own", &["--in-process"]));
    assert!(fenced.status.success() && own.status.success());
    let (fenced, own) = (whole(&archive.path("fenced")), whole(&archive.path("own")));
    assert_eq!(fenced.len(), own.len());
    for (a, b) in fenced.iter().zip(&own) {
        assert!(a == b, "{} and {} differ", a.0.display(), b.0.display());
    }
}

/// A log beyond its limits is rejected by name, the others are done, and it is not tried again before something changes.
#[cfg(target_os = "linux")]
#[test]
fn a_log_beyond_its_limits_costs_itself_only() {
    let archive = Archive::new();
    constant_rows(&archive.log("rows.parquet"), 6_000_000);
    let tight = ["--memory-limit", "0.4"];
    let done = archive.run("out", &tight);
    assert_eq!(done.status.code(), Some(1), "{}", String::from_utf8_lossy(&done.stderr));
    assert_eq!(archive.sessions("out"), 12);
    let [row] = &archive.rejected("out")[..] else { panic!("one is rejected") };
    assert_eq!((row.code.as_str(), row.session_id.as_deref()), ("too_large", Some("rows")));
    assert!(
        row.message.contains("0.40 GB") && row.message.contains("--memory-limit"),
        "{}",
        row.message
    );

    // the second night: the same row, and no worker is ended for it
    let (before, start) = (whole(&archive.path("out")), Instant::now());
    assert_eq!(archive.run("out", &tight).status.code(), Some(1));
    let again = start.elapsed();
    assert!(whole(&archive.path("out")) == before);

    // with more it is tried again, and ended for another reason
    let start = Instant::now();
    let done = archive.run("out", &["--memory-limit", "8", "--time-limit", "1"]);
    let tried = start.elapsed();
    assert_eq!(done.status.code(), Some(1));
    let [row] = &archive.rejected("out")[..] else { panic!("one is rejected") };
    assert_eq!(row.code, "too_slow", "{}", row.message);
    assert!(again < tried, "{again:?} without it, {tried:?} with it");
    assert_eq!(archive.sessions("out"), 12);
}

/// The workers of a batch.
pub fn workers_of(batch: &Child) -> Vec<u32> {
    let entries = std::fs::read_dir("/proc").expect("Linux").filter_map(Result::ok);
    let pids = entries.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok());
    let parent = |pid: u32| {
        let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse::<u32>().ok()
    };
    pids.filter(|pid| parent(*pid) == Some(batch.id())).collect()
}

pub fn signal(name: &str, pid: u32) {
    let sent = Command::new("kill").arg(format!("-{name}")).arg(pid.to_string()).status();
    assert!(sent.expect("kill").success());
}

/// Waits until the one worker of a batch has been busy for 0.3 s.
pub fn busy_worker(batch: &Child) -> u32 {
    let start = Instant::now();
    loop {
        assert!(start.elapsed() < Duration::from_secs(60), "no worker is busy");
        std::thread::sleep(Duration::from_millis(20));
        let stat = |pid: u32| {
            let text = std::fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
            let ticks = text.rsplit_once(')')?.1.split_whitespace().nth(11)?.parse::<u32>().ok()?;
            Some((ticks, pid))
        };
        let busiest = workers_of(batch).into_iter().filter_map(stat).max();
        if let Some((30.., pid)) = busiest {
            return pid;
        }
    }
}

/// A crash is the log's, whose row says so; workers end with the batch, even with one that was killed.
#[cfg(target_os = "linux")]
#[test]
fn a_worker_that_crashes_is_replaced_and_none_outlives_its_batch() {
    let archive = Archive::new();
    constant_rows(&archive.log("rows.parquet"), 6_000_000);
    let mut batch =
        archive.command("out", &["--jobs", "1", "--memory-limit", "8"]).spawn().expect("started");
    // the largest log comes first; a worker that had another log before is not believed at once
    let first = busy_worker(&batch);
    signal("ABRT", first);
    let second = Instant::now();
    while workers_of(&batch).iter().all(|pid| *pid == first) {
        assert!(second.elapsed() < Duration::from_secs(30), "no other worker");
        std::thread::sleep(Duration::from_millis(20));
    }
    signal("ABRT", busy_worker(&batch));
    assert_eq!(batch.wait().expect("ended").code(), Some(1));
    assert_eq!(archive.sessions("out"), 12);
    let [row] = &archive.rejected("out")[..] else { panic!("one is rejected") };
    assert_eq!(row.code, "crashed");
    assert!(row.message.contains("SIGABRT") && row.message.contains("report"), "{}", row.message);

    let mut batch =
        archive.command("other", &["--jobs", "1", "--memory-limit", "8"]).spawn().expect("started");
    let worker = busy_worker(&batch);
    batch.kill().expect("SIGKILL");
    batch.wait().expect("gone");
    let start = Instant::now();
    while Path::new(&format!("/proc/{worker}")).exists() {
        assert!(start.elapsed() < Duration::from_secs(10), "the worker goes on for nobody");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What a worker gives up, tried in one.
#[cfg(target_os = "linux")]
#[test]
fn a_worker_may_neither_write_nor_reach_the_network() {
    let archive = Archive::new();
    let done = archive.run("out", &["--verbose"]);
    let said = String::from_utf8_lossy(&done.stderr);
    let line = said.lines().find(|l| l.contains("workers may, beyond reading")).expect("said");
    assert!(!line.contains("network"), "{line}"); // seccomp: every Linux
    if Path::new("/sys/kernel/security/landlock").exists() {
        assert!(!line.contains("write"), "{line}");
    }
}
