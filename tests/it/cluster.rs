//! A batch over several processes, and a session in memory: both give what a run gives.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

use roadbench::internals::batch::jobs::bikes::{BikeFile, hash_settings};
use roadbench::internals::batch::jobs::distributed::{
    Answer, Driver, JobKind, Task, Terms, Worker,
};
use roadbench::internals::batch::jobs::in_memory;
use roadbench::internals::batch::jobs::run::RunWork;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Error, Maps, Settings, State};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::file;

fn fixtures() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/archive")
}

fn settings<'a>(
    inputs: &'a [Location],
    bikes: &'a Location,
    out: &'a Location,
    pipeline: &'a Pipeline,
    maps: &'a Maps,
) -> Settings<'a> {
    let bikes = Some(bikes);
    let (jobs, force, since) = (0, false, None);
    Settings { inputs, bikes, out, pipeline, maps, jobs, force, since }
}

/// The tables below a folder, but for those over the fleet.
fn files(out: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    glob::glob(&format!("{}/**/*.parquet", out.display()))
        .expect("a pattern")
        .map(|path| path.expect("listed"))
        .map(|path| (path.strip_prefix(out).expect("below").to_owned(), std::fs::read(&path)))
        .map(|(name, bytes)| (name, bytes.expect("read")))
        .collect()
}

/// A task's way to a worker and back, as it is sent.
fn send(terms: &Terms, task: &Task) -> Result<Answer, Error> {
    let terms = serde_json::to_string(terms).expect("json");
    let task = serde_json::to_string(task).expect("json");
    let worker = Worker::new(serde_json::from_str(&terms).expect("terms"))?;
    let answer = worker.run(serde_json::from_str(&task).expect("task"))?;
    let answer = serde_json::to_string(&answer).expect("json");
    Ok(serde_json::from_str(&answer).expect("answer"))
}

#[test]
fn workers_write_what_one_machine_writes() {
    let folder = tempfile::tempdir().expect("folder");
    let logs = folder.path().join("logs");
    std::fs::create_dir(&logs).expect("folder");
    for name in [
        "bike=archive_01/date=2026-05-01/archive_s0001",
        "bike=archive_02/date=2026-05-04/archive_s0007",
    ] {
        let log = fixtures().join(format!("sessions/{name}.parquet"));
        let to = logs.join(log.file_name().expect("name"));
        std::fs::copy(&log, to).expect("copied");
    }
    let whole = std::fs::read(logs.join("archive_s0001.parquet")).expect("read");
    std::fs::write(logs.join("cut.parquet"), &whole[..4000]).expect("written");
    // its footer is whole, so that it is found out by a worker only
    let mut damaged = std::fs::read(logs.join("archive_s0007.parquet")).expect("read");
    damaged[4..20_000].fill(0xA5);
    std::fs::write(logs.join("damaged.parquet"), with_id(&damaged)).expect("written");

    let (inputs, bikes) = ([Location::from(&logs)], fixtures().join("bikes").into());
    let (pipeline, maps) = (Pipeline::onroad(), Maps::default());
    let [one, many] = ["one", "many"].map(|name| folder.path().join(name));
    let stop = AtomicBool::new(false);
    let (run, _) = engine::run(
        &settings(&inputs, &bikes, &(&one).into(), &pipeline, &maps),
        &RunWork::default(),
        &(),
        &stop,
    )
    .expect("run");
    assert_eq!((run.done, run.rejected.len()), (2, 2), "{:?}", run.rejected);

    let out = Location::from(&many);
    let at = settings(&inputs, &bikes, &out, &pipeline, &maps);
    let driver = Driver::open(&at, Vec::new(), JobKind::Run { signals: false }).expect("open");
    let busy =
        Driver::open(&at, Vec::new(), JobKind::Run { signals: false }).expect_err("one at a time");
    assert!(matches!(busy, Error::Usage(_)), "{busy}");
    let tasks = driver.tasks();
    assert_eq!(tasks.len(), 3);
    assert!(tasks[0].bytes >= tasks[1].bytes, "the largest first");
    // a worker was killed while it wrote, another did the same twice
    std::fs::create_dir_all(many.join("plots/bike=archive_01")).expect("folder");
    let torn = many.join("plots/bike=archive_01/.roadbench-x.tmp");
    std::fs::write(&torn, "half").expect("written");
    send(driver.terms(), &tasks[0]).expect("done");
    let answers = tasks.iter().map(|task| send(driver.terms(), task).expect("done")).collect();
    let half = many.join(".roadbench/staged/run/.roadbench-y.tmp");
    std::fs::write(&half, "half").expect("written"); // of a third that was killed over it
    let (accounts, store) = driver.close(answers).expect("closed");
    drop(store);
    assert_eq!((accounts.inputs, accounts.done, accounts.rejected.len()), (4, 2, 2));
    assert!(!torn.exists() && !half.exists());
    assert_eq!(files(&one), files(&many));

    // nothing has changed
    let driver = Driver::open(&at, Vec::new(), JobKind::Run { signals: false }).expect("open");
    let answers: Vec<Answer> =
        driver.tasks().iter().map(|task| send(driver.terms(), task).expect("done")).collect();
    assert_eq!(answers.iter().filter(|a| a.state == State::Unchanged).count(), 2);
    assert_eq!(driver.close(answers).expect("closed").0.unchanged, 2);
}

/// The file under another session's name, of the same length.
fn with_id(bytes: &[u8]) -> Vec<u8> {
    let (from, to) = (b"archive_s0007", b"archive_sXXXX");
    let mut bytes = bytes.to_vec();
    for at in 0..bytes.len() - from.len() {
        if &bytes[at..at + from.len()] == from {
            bytes[at..at + from.len()].copy_from_slice(to);
        }
    }
    bytes
}

#[test]
fn an_answer_that_is_not_so_is_found_out() {
    let folder = tempfile::tempdir().expect("folder");
    let inputs = [fixtures().join("sessions/bike=archive_01/date=2026-05-01").into()];
    let (bikes, out) = (fixtures().join("bikes").into(), folder.path().join("out").into());
    let (pipeline, maps) = (Pipeline::onroad(), Maps::default());
    let at = settings(&inputs, &bikes, &out, &pipeline, &maps);
    let open = || Driver::open(&at, Vec::new(), JobKind::Run { signals: false }).expect("open");
    let lie = |task: &Task| Answer {
        log: task.log.clone(),
        state: State::Done,
        rejected: None,
        input_hash: Some("0".into()),
        samples: 1,
        seconds: 0.1,
    };
    let driver = open();
    let lies = driver.tasks().iter().map(lie).collect();
    let e = driver.close(lies).expect_err("nothing was written");
    assert!(e.to_string().contains("the same on every machine"), "{e}");
    let e = open().close(Vec::new()).expect_err("no answer");
    assert!(e.to_string().contains("no worker returned"), "{e}");
    let mut terms = open().terms().clone();
    terms.version = "0.0.0".into();
    let e = Worker::new(terms).expect_err("another version");
    assert!(e.to_string().contains("install the same wheel"), "{e}");
}

#[test]
fn a_session_in_memory_is_what_is_written() {
    let folder = tempfile::tempdir().expect("folder");
    let log = fixtures().join("sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet");
    let (bikes, out) = (fixtures().join("bikes"), folder.path().join("out"));
    let log = Location::from(log);
    let (inputs, pipeline, maps) = ([log.clone()], Pipeline::onroad(), Maps::default());
    let stop = AtomicBool::new(false);
    let (folder_of_bikes, output) = (Location::from(&bikes), Location::from(&out));
    let at = settings(&inputs, &folder_of_bikes, &output, &pipeline, &maps);
    engine::run(&at, &RunWork { signals: true }, &(), &stop).expect("run");

    let hashes = hash_settings(&pipeline, "").expect("hashes");
    let path = bikes.join("archive_01.toml");
    let text = std::fs::read_to_string(&path).expect("read");
    let bike = BikeFile::parse(text, "archive_01", &path, &hashes).expect("bike");
    let tables =
        in_memory::run(in_memory::Log::File(&log), &bike, &pipeline, &maps, true).expect("tables");
    let written = files(&out);
    assert_eq!(tables.len(), written.len());
    for (name, batch) in tables {
        let own = if name == "signals" { "archive_s0001" } else { "2026-05" };
        let file = PathBuf::from(name).join(format!("bike=archive_01/{own}.parquet"));
        let bytes = file::batch_to_bytes(name, &batch).expect("encoded");
        assert_eq!(written.get(&file), Some(&bytes), "{name}");
    }
}
