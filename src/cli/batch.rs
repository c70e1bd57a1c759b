//! What `run` and `diagnose` have in common on the command line.

use std::io::Write;
use std::path::PathBuf;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::SystemTime;

use clap::ValueHint;
use jiff::Timestamp;
use jiff::civil::Date;
use jiff::tz::TimeZone;

use crate::batch::workers::fence::{LimitOptions, Sandboxed};
use crate::batch::workers::scheduler as engine;
use crate::batch::workers::scheduler::{Accounts, Intended};
use crate::batch::{self, Maps, Settings, State, Work};
use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::{log, say};
use crate::pipeline::Pipeline;
use crate::report::{self, terminal};
use crate::statistics::number_format;
use crate::store::objects::Location;
use crate::store::objects::counts;
use crate::store::objects::counts::Counts;
use crate::store::tables::output::Outputs;

/// Rejections that are listed on stderr; the rest is in `rejected/`.
const LISTED: usize = 20;

/// The variable that stands in for `--bikes`.
pub(crate) const BIKES: &str = "ROADBENCH_BIKES";

/// Options of a batch.
#[derive(Debug, clap::Args)]
pub(crate) struct Options {
    /// Logs, folders of logs or archives, glob patterns; here or in an object store (s3://, gs://, az://).
    #[arg(required = true, value_name = "INPUT")]
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    inputs: Vec<Location>,
    /// Folder of bike files, `<bike_id>.toml`; by default the `bikes` beside an archive's sessions.
    #[arg(long, value_name = "DIR", env = BIKES, hide_env_values = true)]
    #[arg(value_parser = location(), value_hint = ValueHint::DirPath)]
    bikes: Option<Location>,
    /// Folder or URL for the tables and the report; sessions that it holds already are kept.
    #[arg(short, long, value_name = "DIR")]
    #[arg(value_parser = location(), value_hint = ValueHint::DirPath)]
    out: Location,
    /// Settings of the stages; a file, or a built-in one: onroad (the default), offroad, paper.
    #[arg(long, value_name = "FILE")]
    pipeline: Option<PathBuf>,
    /// Channel map of logs that are not session.v1; may be repeated.
    ///
    /// Without it the shipped maps are tried.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// Progress bar on stderr; only ever shown on a terminal.
    #[arg(long, value_name = "WHEN", default_value = "auto")]
    progress: Show,
    /// Compute sessions again that are there already.
    #[arg(long)]
    force: bool,
    /// Only logs that were written since then, a date or a time: 2026-05-01, 2026-05-01T22:00:00Z.
    #[arg(long, value_name = "WHEN", value_parser = moment)]
    since: Option<SystemTime>,
    /// Memory that one log may take, GB.
    ///
    /// One that takes more is rejected (too_large). By default 1.5 GB and 40 times the log's size, and for all
    /// --jobs together no more than the machine has.
    #[arg(long, value_name = "GB", value_parser = above_zero)]
    memory_limit: Option<f64>,
    /// Processor time that one log may take, s.
    ///
    /// One that takes more is rejected (too_slow). By default a minute and 20 s per MB of the log, and more with
    /// every fault-free simulation of a diagnosis.
    #[arg(long, value_name = "SECONDS", value_parser = above_zero)]
    time_limit: Option<f64>,
    /// Read the logs in this process instead of in workers.
    ///
    /// There are no limits then, and a log that crashes the process ends the batch.
    #[arg(long)]
    in_process: bool,
    /// Only tell what would be done with each log, and why; nothing is written.
    #[arg(long)]
    pub dry_run: bool,
    /// Whether results are not printed: the demo has its own words for them.
    #[arg(skip)]
    quiet: bool,
}

/// When the progress bar is shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Show {
    /// On a terminal.
    Auto,
    /// Not at all.
    Never,
}

/// Options that were read: what [`Settings`] borrow from.
#[derive(Debug)]
pub(crate) struct Given {
    inputs: Vec<Location>,
    bikes: Option<Location>,
    out: Location,
    /// The stages' settings.
    pub pipeline: Pipeline,
    maps: Maps,
    force: bool,
    since: Option<SystemTime>,
    limits: LimitOptions,
}

impl Options {
    /// An archive into an output folder, without a word on stdout.
    pub(crate) fn quietly(archive: PathBuf, out: PathBuf) -> Self {
        Options {
            inputs: vec![archive.into()],
            bikes: None,
            out: out.into(),
            pipeline: None,
            map: Vec::new(),
            progress: Show::Never,
            force: false,
            since: None,
            memory_limit: None,
            time_limit: None,
            in_process: false,
            dry_run: false,
            quiet: true,
        }
    }

    /// Whether the progress bar may be shown.
    pub(crate) fn shows_progress(&self) -> bool {
        self.progress == Show::Auto && !say::is_quiet()
    }

    /// Whether results are not printed.
    pub(crate) fn is_quiet(&self) -> bool {
        self.quiet || say::is_quiet()
    }

    /// Where the batch writes.
    ///
    /// # Errors
    /// It cannot write there.
    pub(crate) fn outputs(&self) -> Result<Outputs, Failure> {
        let mut outputs = Outputs::default();
        outputs.folder("--out", &self.out)?;
        outputs.tables(&self.out);
        Ok(outputs)
    }

    /// Holds the files that are written against those that the batch reads, but for logs and bike files.
    ///
    /// # Errors
    /// One of them is an input.
    pub(crate) fn hold_against(&self, outputs: &Outputs) -> Result<(), Failure> {
        Ok(outputs.apart_from_files(self.pipeline.iter().chain(&self.map))?)
    }

    /// Reads what the options name.
    ///
    /// # Errors
    /// A file cannot be read, or is not what it should be.
    pub(crate) fn read(&self) -> Result<Given, Failure> {
        self.inputs.iter().try_for_each(log::refuse_own)?;
        let pipeline = match &self.pipeline {
            Some(path) => Pipeline::read(path).map_err(Failure::usage)?,
            None => Pipeline::onroad(),
        };
        Ok(Given {
            inputs: self.inputs.clone(),
            bikes: self.bikes.clone(),
            out: self.out.clone(),
            pipeline,
            maps: Maps::read(&self.map).map_err(Failure::usage)?,
            force: self.force,
            since: self.since,
            limits: LimitOptions {
                memory: self.memory_limit,
                time: self.time_limit,
                in_process: self.in_process,
            },
        })
    }
}

impl Given {
    /// A work whose logs are read by workers, if not asked otherwise.
    ///
    /// # Errors
    /// As [`Sandboxed::new`].
    pub(crate) fn fenced<W: Work>(&self, work: W) -> Result<Sandboxed<W>, Failure> {
        Ok(Sandboxed::new(work, &self.settings(), self.limits)?)
    }

    /// As the batch takes them.
    pub(crate) fn settings(&self) -> Settings<'_> {
        Settings {
            inputs: &self.inputs,
            bikes: self.bikes.as_ref(),
            out: &self.out,
            pipeline: &self.pipeline,
            maps: &self.maps,
            jobs: rayon::current_num_threads(),
            force: self.force,
            since: self.since,
        }
    }
}

/// A number for a limit.
fn above_zero(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(x) if x > 0.0 && x.is_finite() => Ok(x),
        _ => Err("it must be a number above zero".to_owned()),
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

/// Set by the first Ctrl-C (or SIGTERM), which lets the sessions under way finish; the second one ends
/// the program at once. Where nobody can listen for signals the first one does.
pub(crate) fn stop_on_signal() -> &'static AtomicBool {
    static STOP: AtomicBool = AtomicBool::new(false);
    static LISTENING: OnceLock<()> = OnceLock::new();
    let listen = || {
        let stop = || {
            if STOP.swap(true, Ordering::Relaxed) {
                std::process::exit(1); // whole files only, even so
            }
            tracing::warn!("stopping after the sessions under way; once more to stop at once");
        };
        if let Err(e) = ctrlc::set_handler(stop) {
            tracing::warn!("cannot listen for Ctrl-C, which ends the run at once: {e}");
        }
    };
    LISTENING.get_or_init(listen);
    &STOP
}

/// Prints what would be done: a line per log that would be computed or refused, and the counts.
///
/// # Errors
/// As of the batch, before it writes.
pub(crate) fn dry_run(given: &Given, work: &impl Work) -> Result<(), Failure> {
    let all: Vec<Intended> = engine::dry_run(&given.settings(), work)?;
    let count = |state: State| all.iter().filter(|i| i.state == state).count();
    let mut out = String::new();
    for i in all.iter().filter(|i| i.state != State::Unchanged) {
        let what = if i.state == State::Done { "compute" } else { "reject" };
        out.push_str(&format!("{what:8} {}: {}\n", i.log, i.why));
    }
    out.push_str(&format!(
        "{}: {} to compute, {} unchanged, {} to reject; nothing was written\n",
        number_format::count(all.len(), "log"),
        count(State::Done),
        count(State::Unchanged),
        count(State::Rejected)
    ));
    print(&out);
    Ok(())
}

/// An error where inputs were left because the batch was stopped.
///
/// # Errors
/// So it is.
pub(crate) fn stopped(accounts: &Accounts) -> Result<(), Failure> {
    if accounts.left == 0 {
        return Ok(());
    }
    Err(Failure::Rejected(format!(
        "stopped: {} of {} inputs are done, {} were not begun; run the same command again to go on",
        accounts.inputs - accounts.left,
        accounts.inputs,
        accounts.left
    )))
}

/// An error where the tables are not whole.
///
/// # Errors
/// So they are.
pub(crate) fn damaged(accounts: &Accounts) -> Result<(), Failure> {
    accounts.damage.clone().map_or(Ok(()), |message| Err(Failure::Output(message)))
}

/// An error that lists what was rejected, if anything was.
///
/// # Errors
/// So it was.
pub(crate) fn rejected(accounts: &Accounts) -> Result<(), Failure> {
    let rows = &accounts.rejected;
    if rows.is_empty() {
        return Ok(());
    }
    let list = terminal::rejections(rows, LISTED, say::width());
    Err(Failure::Rejected(format!("{} rejected:\n{}", rows.len(), list.trim_end())))
}

/// Says that nothing had to be done.
pub(crate) fn print_unchanged(accounts: &Accounts, out: &Location) {
    let logs = number_format::count(accounts.inputs, "log");
    print(&format!("{logs}, nothing has changed in {out}\n"));
    // who asks again wants the answer again
    if let Some(folder) = out.as_path().filter(|folder| folder.join("report/index.html").is_file())
    {
        let report = folder.join("report/index.html");
        let text = format!(
            "`roadbench show {}` prints what was found. Report: {}",
            folder.display(),
            report.display()
        );
        print(&terminal::wrapped(&text, say::line_width()));
    }
}

/// Logs what the batch did, and the requests to object stores, where there were any.
pub(crate) fn log_accounts(accounts: &Accounts, command: &str, seconds: f64) {
    let Accounts { inputs, done: computed, unchanged, left, bytes, .. } = *accounts;
    let rejected = accounts.rejected.len();
    tracing::info!(inputs, computed, unchanged, rejected, left, bytes, seconds, "{command}");
    let c = counts::so_far();
    if c.requests() == 0 {
        return;
    }
    let (requests, read, written) = (c.requests(), c.bytes_read, c.bytes_written);
    let Counts { get, head, list, put, delete, failed, .. } = c;
    tracing::info!(requests, get, head, list, put, delete, failed, read, written, "object stores");
}

/// Results go to stdout; a reader that has seen enough (`| head`) is no error.
pub(crate) fn print(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
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
