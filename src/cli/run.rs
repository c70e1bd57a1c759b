//! `roadbench run`.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Instant, SystemTime};

use indicatif::ProgressBar;
use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;

use crate::batch::desk::Desk;
use crate::batch::progress::Progress;
use crate::batch::summary::Summary;
use crate::batch::{self, Intended, Maps, Run, Settings, Stages, State};
use crate::cli::Failure;
use crate::cli::report::{Copies, Pages};
use crate::effects::extended_model::Model;
use crate::objects::counts::Counts;
use crate::objects::url::plain;
use crate::pipeline::Pipeline;
use crate::report::{self, terminal};
use crate::tables::rows;

/// Rejections that are listed on stderr; the rest is in `rejected/`.
const LISTED: usize = 20;

/// Turn riding logs into tyre coefficients
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Logs, folders of logs or archives, glob patterns; here or in an object store (s3://, gs://, az://).
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Folder of bike files, `<bike_id>.toml`; by default the `bikes` beside an archive's sessions.
    #[arg(long, value_name = "DIR")]
    bikes: Option<PathBuf>,
    /// Folder or URL for the tables and the report; sessions that it holds already are kept.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Settings of the stages; by default the built-in pipelines/onroad.toml.
    #[arg(long, value_name = "FILE")]
    pipeline: Option<PathBuf>,
    /// Extended model that `diagnose` wrote: what it found is taken out of that motorcycle's sessions.
    #[arg(long, value_name = "FILE")]
    model: Option<PathBuf>,
    /// Channel map of logs that are not session.v1; may be repeated. Without it the shipped maps
    /// are tried.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// Sessions that are worked on at the same time; 0 takes one per core.
    #[arg(long, value_name = "N", default_value_t = 0)]
    jobs: usize,
    /// Progress bar on stderr; only ever shown on a terminal.
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    progress: Show,
    /// Also write the estimated time series.
    #[arg(long)]
    signals: bool,
    /// Compute sessions again that are there already.
    #[arg(long)]
    force: bool,
    /// Only logs that were written since then, a date or a time: 2026-05-01, 2026-05-01T22:00:00Z.
    #[arg(long, value_name = "WHEN", value_parser = moment)]
    since: Option<SystemTime>,
    /// Also write what the run did as Prometheus text, for its text-file collector.
    #[arg(long, value_name = "FILE")]
    metrics: Option<PathBuf>,
    #[command(flatten)]
    pages: Pages,
    #[command(flatten)]
    copies: Copies,
    /// Only tell what would be done with each log, and why; nothing is written.
    #[arg(long)]
    dry_run: bool,
    /// Whether the results are not to be printed: the demo tells them.
    #[arg(skip)]
    quiet: bool,
}

impl Arguments {
    /// An archive into an output folder, without a word on stdout.
    pub(super) fn quietly(archive: PathBuf, out: PathBuf) -> Self {
        Arguments {
            inputs: vec![archive],
            bikes: None,
            out,
            pipeline: None,
            model: None,
            map: Vec::new(),
            jobs: 0,
            progress: Show::Never,
            signals: false,
            force: false,
            since: None,
            metrics: None,
            pages: Pages::default(),
            copies: Copies::default(),
            dry_run: false,
            quiet: true,
        }
    }
}

/// A date is its first moment, UTC.
fn moment(text: &str) -> Result<SystemTime, String> {
    let day = || text.parse::<Date>().ok()?.to_zoned(TimeZone::UTC).ok().map(|z| z.timestamp());
    let at: Timestamp = match text.parse() {
        Ok(at) => at,
        Err(e) => day().ok_or_else(|| {
            format!("neither a date (2026-05-01) nor a time (2026-05-01T22:00:00Z): {e}")
        })?,
    };
    Ok(SystemTime::from(at))
}

/// When the progress bar is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Show {
    /// On a terminal.
    Auto,
    /// Not at all.
    Never,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let (start, started) = (Instant::now(), Timestamp::now());
    let mut pipeline = match &arguments.pipeline {
        Some(path) => Pipeline::read(path).map_err(Failure::Usage)?,
        None => Pipeline::onroad(),
    };
    if let Some(path) = &arguments.model {
        if pipeline.offroad.is_some() {
            let message = "--model is for road sessions; take a pipeline without [offroad]";
            return Err(Failure::Usage(message.to_owned()));
        }
        pipeline.model = Some(Model::read(path).map_err(Failure::Usage)?);
    }
    let maps = Maps::read(&arguments.map).map_err(Failure::Usage)?;
    let stop = stop_on_signal()?;
    let inputs: Vec<PathBuf> = arguments.inputs.iter().map(|i| plain(i)).collect();
    let bikes = arguments.bikes.as_deref().map(plain);
    let out = plain(&arguments.out);
    let settings = Settings {
        inputs: &inputs,
        bikes: bikes.as_deref(),
        out: &out,
        pipeline: &pipeline,
        maps: &maps,
        jobs: arguments.jobs,
        force: arguments.force,
        since: arguments.since,
        signals: arguments.signals,
    };
    if arguments.dry_run {
        print(&intentions(&batch::intend(&settings, &Stages)?));
        return Ok(());
    }
    let progress = Progress::new(bar, arguments.progress == Show::Auto);
    let run = batch::run(&settings, &Stages, &progress, &stop);
    progress.clear();
    let (run, store) = run?;
    let out = store.root();
    let told = |seconds: f64| -> Result<(), Failure> {
        let summary = Summary::of(&run, &pipeline, started, seconds);
        summary.write(out)?;
        if let Some(path) = &arguments.metrics {
            summary.write_metrics(path)?;
        }
        let Summary { inputs, computed, unchanged, rejected, left, bytes, requests, .. } = summary;
        tracing::info!(inputs, computed, unchanged, rejected, left, bytes, seconds, "run");
        if let Some(c) = requests {
            let (requests, failed, read, written) =
                (c.requests(), c.failed, c.bytes_read, c.bytes_written);
            let Counts { get, head, list, put, delete, .. } = c;
            tracing::info!(
                requests,
                get,
                head,
                list,
                put,
                delete,
                failed,
                read,
                written,
                "object stores"
            );
        }
        Ok(())
    };
    if run.left > 0 {
        told(start.elapsed().as_secs_f64())?;
        return Err(Failure::Rejected(format!(
            "stopped: {} of {} inputs are done, {} were not begun; the same command carries on",
            run.inputs - run.left,
            run.inputs,
            run.left
        )));
    }
    if !store.is_behind() {
        if arguments.copies.asked() {
            arguments.copies.write(Desk::of(out)?.folder(), None)?;
        }
        told(start.elapsed().as_secs_f64())?;
        if !arguments.quiet {
            print(&format!("{} sessions, nothing has changed in {}\n", run.inputs, out.display()));
        }
        return listed(&run);
    }
    let desk = Desk::of(out)?;
    aggregate(desk.folder())?;
    report::build(desk.folder(), arguments.pages.kind, false)?;
    arguments.copies.write(desk.folder(), None)?;
    desk.publish()?;
    store.caught_up()?;
    told(start.elapsed().as_secs_f64())?;
    match &run.only {
        _ if arguments.quiet => {}
        Some(only) => {
            print(&terminal::summary(&only.session, &only.coefficients));
            print(&report::session::forces::terminal(&only.forces, &only.manoeuvres));
        }
        None => print(&overview(&run, desk.folder(), start.elapsed().as_secs_f64())?),
    }
    tracing::info!("report: {}", out.join("report/index.html").display());
    listed(&run)
}

fn listed(run: &Run) -> Result<(), Failure> {
    if run.rejected.is_empty() {
        return Ok(());
    }
    let list = terminal::rejections(&run.rejected, LISTED);
    Err(Failure::Rejected(format!("{} rejected:\n{}", run.rejected.len(), list.trim_end())))
}

impl From<batch::Error> for Failure {
    fn from(e: batch::Error) -> Self {
        match e {
            batch::Error::Usage(message) => Failure::Usage(message),
            batch::Error::Output(message) | batch::Error::Internal(message) => {
                Failure::Output(message)
            }
        }
    }
}

impl From<report::Error> for Failure {
    fn from(e: report::Error) -> Self {
        Failure::Output(e.to_string())
    }
}

/// The first Ctrl-C (or SIGTERM) lets the sessions under way finish, the second one ends at once.
fn stop_on_signal() -> Result<Arc<AtomicBool>, Failure> {
    let stop = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&stop);
    ctrlc::set_handler(move || {
        if flag.swap(true, Ordering::Relaxed) {
            std::process::exit(1); // whole files only, even so
        }
        tracing::warn!("stopping after the sessions under way; once more to stop at once");
    })
    .map_err(|e| Failure::Usage(format!("cannot listen for Ctrl-C: {e}")))?;
    Ok(stop)
}

/// The tables over all sessions of the output, of this run and of earlier ones.
#[cfg(feature = "fleet")]
fn aggregate(out: &Path) -> Result<(), Failure> {
    let rows = batch::fleet::write(out)?;
    tracing::debug!(rows = rows.len(), "fleet");
    Ok(())
}

/// Built without the feature `fleet`: there is no such table.
#[cfg(not(feature = "fleet"))]
fn aggregate(_out: &Path) -> Result<(), Failure> {
    tracing::debug!("built without the feature `fleet`: no fleet table");
    Ok(())
}

/// What the run's sessions gave, read back from the tables: those that were there already count too.
fn overview(run: &Run, out: &Path, seconds: f64) -> Result<String, Failure> {
    let ours = |ident: &rows::Ident| run.sessions.contains(&ident.session_id);
    let mut sessions = report::tables::sessions(out)?;
    sessions.retain(|s| ours(&s.ident));
    let mut coefficients = report::tables::coefficients(out)?;
    coefficients.retain(|c| ours(&c.ident));
    Ok(terminal::batch_summary(&sessions, &coefficients, &run.rejected, seconds))
}

/// A line per log that would be computed or refused, and the counts.
fn intentions(all: &[Intended]) -> String {
    let count = |state: State| all.iter().filter(|i| i.state == state).count();
    let mut out = String::new();
    for i in all.iter().filter(|i| i.state != State::Unchanged) {
        let what = if i.state == State::Done { "compute" } else { "reject" };
        out.push_str(&format!("{what:8} {}: {}\n", i.log, i.why));
    }
    out.push_str(&format!(
        "{} logs: {} to compute, {} unchanged, {} to reject; nothing was written\n",
        all.len(),
        count(State::Done),
        count(State::Unchanged),
        count(State::Rejected)
    ));
    out
}

/// Results go to stdout; a reader that has seen enough (`| head`) is no error.
fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}
