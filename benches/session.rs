//! How long a session takes, against what no program can avoid: decoding its columns.
//!
//! ```text
//! cargo bench --no-default-features
//! ```
//! One simulated ride of 20 min x 100 Hz x 16 channels, written once as the archive has it
//! (float32 at sensor resolution) and once as float64. Everything is timed in this process, after
//! one run to warm up; every figure is the median of several runs. Nothing is compared with
//! earlier runs: what counts is the ratio, both sides of which are measured side by side.

use std::fs::File;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use parquet::arrow::arrow_reader::ParquetRecordBatchReaderBuilder;
use roadbench::Laps;
use roadbench::internals::batch::jobs::run::RunWork;
use roadbench::internals::batch::workers::scheduler as engine;
use roadbench::internals::batch::{Maps, Settings};
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::{self, road};
use roadbench::internals::estimate::zeros;
use roadbench::internals::fit::{Data, chain};
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::report::plots;
use roadbench::internals::simulate::scenario::Scenario;
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::{file, rows};
use roadbench::internals::tyre::formulation::Formulation;
use roadbench::internals::{filter, fit, ingest, segment, simulate};

/// Samples of the ride: 20 min at 100 Hz.
const SAMPLES: usize = 120_000;
/// Runs that a median is taken of.
const RUNS: usize = 15;
/// Diagnoses that a median is taken of.
const DIAGNOSES: usize = 3;
/// Sessions of a batch, and how often it is run with each number of jobs.
const SESSIONS: usize = 24;
const BATCHES: usize = 3;

type Failure = Box<dyn std::error::Error>;

/// First argument that makes the bench one batch alone, in the folder that follows, with so many jobs.
const ONE_BATCH: &str = "one-batch";

fn main() -> Result<(), Failure> {
    let arguments: Vec<String> = std::env::args().collect();
    if let [_, first, folder, jobs] = arguments.as_slice()
        && first == ONE_BATCH
    {
        return one_batch(Path::new(folder), jobs.parse()?);
    }
    let folder = tempfile::tempdir()?;
    let (ride, bike) = ride()?;
    println!(
        "one ride: {:.0} min x {} Hz x {} channels, {RUNS} runs each, median",
        ride.duration() / 60.0,
        ride.rate,
        ride.channels().count()
    );
    for (name, float32) in [("float32, the archive's form", true), ("float64", false)] {
        let path = folder.path().join(format!("{}.parquet", ride.meta.session_id));
        ingest::write_session(&path, &ride, float32)?;
        one_session(name, &path, &bike)?;
    }
    diagnosis(&ride, &bike)?;
    batches(folder.path(), &ride, &bike)
}

/// The diagnosis of the ride on one thread, against the estimate that it starts from.
fn diagnosis(ride: &Session, bike: &Bike) -> Result<(), Failure> {
    let pipeline = Pipeline::onroad();
    let settings = diagnose::Settings::default();
    let mut times = Stopwatch::default();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    for _ in 0..DIAGNOSES {
        let session = ride.clone();
        one.install(|| {
            times.plain("estimate", || {
                pipeline::characterise(session, bike, &pipeline, Formulation::Corrected)
            });
            times.plain("diagnose", || road::diagnose(ride, bike, &pipeline, &settings)).map(drop)
        })?;
    }
    let [estimate, diagnose] = ["estimate", "diagnose"].map(|name| times.median(name));
    println!("\ndiagnosis on one thread, median of {DIAGNOSES}: {diagnose:.2} s");
    println!("  over the estimate in memory: {:.0}", diagnose / estimate);
    Ok(())
}

/// The naturalistic scenario's first ride, longer: whole rounds until 20 min are full.
fn ride() -> Result<(Session, Bike), Failure> {
    let mut scenario = Scenario::builtin("naturalistic")?;
    let machine = scenario.machine(0);
    for plan in &mut scenario.plans {
        (plan.coasts, plan.brakings, plan.laps) = (24, 18, 40);
    }
    let simulated = simulate::session(&scenario, &machine, 0).session;
    if simulated.len < SAMPLES {
        return Err(format!("the ride is only {:.0} s long", simulated.duration()).into());
    }
    let mut ride = Session::new(simulated.meta.clone(), simulated.rate, SAMPLES);
    for channel in simulated.channels() {
        if let Some(x) = simulated.get(channel) {
            ride.set(channel, x[..SAMPLES].to_vec());
        }
    }
    Ok((ride, machine.bike))
}

/// Decoding, the whole pipeline, and every stage alone.
fn one_session(name: &str, path: &Path, bike: &Bike) -> Result<(), Failure> {
    let pipeline = Pipeline::onroad();
    let input = Input {
        log: path.into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    let mut stages = Stopwatch::default();
    for run in 0..=RUNS {
        if run == 1 {
            stages = Stopwatch::default(); // the first one warmed up
        }
        stages.time("decode", || decode(path))?;
        stages.time("pipeline", || pipeline::run(&input, bike, &pipeline))?;
        by_stage(&mut stages, &input, bike, &pipeline)?;
    }
    println!("\n{name}: {:.1} MB", std::fs::metadata(path)?.len() as f64 / 1e6);
    let (decode, pipeline) = (stages.median("decode"), stages.median("pipeline"));
    for (name, runs) in &stages.0 {
        let share = median(runs) / decode;
        let indent = if matches!(*name, "decode" | "pipeline") { "" } else { "  " };
        println!("  {:12} {:8.2} ms {share:6.2}", format!("{indent}{name}"), 1e3 * median(runs));
    }
    println!("  pipeline over decode: {:.2}", pipeline / decode);
    Ok(())
}

/// The yardstick: every column to Arrow arrays, each in one piece.
fn decode(path: &Path) -> Result<usize, Failure> {
    let builder = ParquetRecordBatchReaderBuilder::try_new(File::open(path)?)?;
    let all = usize::try_from(builder.metadata().file_metadata().num_rows())?;
    let mut rows = 0;
    for batch in builder.with_batch_size(all).build()? {
        rows += black_box(batch?).num_rows();
    }
    Ok(rows)
}

/// As `pipeline::run` does it, and then the tables as bytes.
fn by_stage(
    stages: &mut Stopwatch,
    input: &Input<'_>,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<(), Failure> {
    let raw = stages.time("read", || ingest::read(&input.log, input.maps))?;
    let (mut session, _) = stages.time("clean", || ingest::run(raw, &pipeline.ingest))?;
    stages.time("check", || ingest::check(&mut session, Some(bike), &pipeline.ingest))?;
    stages.plain("filter", || filter::run(&mut session, &pipeline.filter));
    let segments = stages.plain("segment", || segment::run(&session, bike, &pipeline.segment));
    let (zeros, _) = stages.plain("zeros", || zeros::run(&session, bike));
    let data = stages
        .plain("gather", || Data::gather(&session, &segments, bike, zeros, &pipeline.estimate));
    let formulation = pipeline.estimate.formulation;
    let solution = stages.plain("solve", || chain::solve(&data, bike, formulation, &pipeline.fit));
    let (ident, made) = (rows::Ident::from(&session.meta), rows::Provenance::default());
    let coefficients = stages.plain("rows", || {
        fit::coefficients::rows(&solution, bike, &pipeline.fit, &|_| None, &ident, &made)
    });
    let plots = stages.plain("plots", || {
        plots::road::rows(
            &session,
            &segments,
            &data,
            &solution,
            &coefficients,
            &Laps::default(),
            &[],
        )
    });
    stages.time("(encoding)", || {
        let coefficients = file::to_bytes(&coefficients)?;
        Ok::<_, file::Error>((coefficients, file::to_bytes(&plots)?))
    })?;
    Ok(())
}

/// Many sessions through the batch engine, with one and with two jobs.
fn batches(folder: &Path, ride: &Session, bike: &Bike) -> Result<(), Failure> {
    let (inputs, bikes) = (folder.join("sessions"), folder.join("bikes"));
    file::write_bytes(bikes.join(format!("{}.toml", bike.bike_id)), bike.to_toml().as_bytes())?;
    let mut copy = ride.clone();
    for number in 0..SESSIONS {
        copy.meta.session_id = format!("ride_{number:02}");
        ingest::write_session(inputs.join(format!("{number:02}.parquet")), &copy, true)?;
    }
    drop(copy);
    let mut times = Stopwatch::default();
    for round in 0..BATCHES {
        for (name, jobs) in [("1", 1), ("2", 2)] {
            let out = folder.join(format!("out_{round}_{jobs}"));
            times.time(name, || batch(std::slice::from_ref(&inputs), &bikes, &out, jobs))?;
        }
    }
    let rate = |name| SESSIONS as f64 / times.median(name);
    println!("\nbatch of {SESSIONS} such sessions (float32), tables written, median of {BATCHES}");
    println!("  1 job   {:6.2} sessions/s", rate("1"));
    println!("  2 jobs  {:6.2} sessions/s", rate("2"));
    println!("  parallel efficiency {:.2}", rate("2") / rate("1") / 2.0);
    println!("  peak memory of a process that does one batch, its program included:");
    for jobs in ["1", "2"] {
        let folder = folder.to_string_lossy();
        let alone =
            Command::new(std::env::current_exe()?).args([ONE_BATCH, &folder, jobs]).output()?;
        print!("    {jobs} jobs {}", String::from_utf8_lossy(&alone.stdout));
        if !alone.status.success() {
            return Err(String::from_utf8_lossy(&alone.stderr).into());
        }
    }
    Ok(())
}

/// One batch over the sessions that are in `folder`, and this process's largest resident size.
fn one_batch(folder: &Path, jobs: usize) -> Result<(), Failure> {
    let (inputs, bikes) = (folder.join("sessions"), folder.join("bikes"));
    let out = folder.join(format!("alone_{jobs}"));
    batch(std::slice::from_ref(&inputs), &bikes, &out, jobs)?;
    match peak_memory() {
        Some(bytes) => println!("{} MB", bytes / 1_000_000),
        None => println!("unknown: this system does not tell"),
    }
    Ok(())
}

fn batch(inputs: &[PathBuf], bikes: &Path, out: &Path, jobs: usize) -> Result<(), Failure> {
    let (pipeline, maps) = (Pipeline::onroad(), Maps::default());
    let settings = Settings {
        inputs: &inputs.iter().map(Location::from).collect::<Vec<_>>(),
        bikes: Some(&bikes.into()),
        out: &out.into(),
        pipeline: &pipeline,
        maps: &maps,
        jobs,
        force: false,
        since: None,
    };
    let (run, _) = engine::run(&settings, &RunWork::default(), &(), &AtomicBool::new(false))?;
    match run.done {
        SESSIONS => Ok(()),
        done => Err(format!("{done} of {SESSIONS} sessions done").into()),
    }
}

/// Times by name, in the order of their first appearance, s.
#[derive(Default)]
struct Stopwatch(Vec<(&'static str, Vec<f64>)>);

impl Stopwatch {
    fn plain<T>(&mut self, name: &'static str, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = black_box(work());
        let seconds = start.elapsed().as_secs_f64();
        match self.0.iter_mut().find(|(n, _)| *n == name) {
            Some((_, runs)) => runs.push(seconds),
            None => self.0.push((name, vec![seconds])),
        }
        result
    }

    fn time<T, E: Into<Failure>>(
        &mut self,
        name: &'static str,
        work: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, Failure> {
        self.plain(name, work).map_err(Into::into)
    }

    fn median(&self, name: &str) -> f64 {
        self.0.iter().find(|(n, _)| *n == name).map_or(f64::NAN, |(_, runs)| median(runs))
    }
}

fn median(runs: &[f64]) -> f64 {
    let mut runs = runs.to_vec();
    runs.sort_by(f64::total_cmp);
    runs[runs.len() / 2]
}

/// Largest resident size of this process so far, bytes.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    Some(1024 * line.split_whitespace().nth(1)?.parse::<u64>().ok()?)
}
