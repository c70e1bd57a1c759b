//! `roadbench run`.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use clap::ValueHint;
use indicatif::ProgressBar;
use jiff::Timestamp;

use crate::batch::discover::DiscoveredLog;
use crate::batch::jobs::models;
use crate::batch::jobs::run::{RunWork, finish};
use crate::batch::store::local_copy::LocalCopy;
use crate::batch::store::marker::Key;
use crate::batch::summary::Summary;
use crate::batch::workers::scheduler as engine;
use crate::batch::workers::scheduler::Accounts;
use crate::batch::{Finished, Watch};
use crate::cli::batch::{
    Given, Options, damaged, dry_run, log_accounts, print, print_unchanged, rejected,
    stop_on_signal, stopped,
};
use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::progress::Progress;
use crate::cli::report::{Copies, Pages};
use crate::cli::say;
use crate::pipeline::{Outcome, Pipeline};
use crate::report::session::printed::Printed;
use crate::report::{self, terminal};
use crate::store::objects::Location;
use crate::store::tables::output::Outputs;
use crate::store::tables::rows;

/// Turn riding logs into tyre coefficients
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    batch: Options,
    /// Remove from the recordings what `diagnose` identified.
    ///
    /// PATH is its output, here or in an object store. Each session is corrected for its own causes and for those
    /// that it shares with others. PATH may be one session's model file, too: causes that usually are the
    /// motorcycle's then go to all of its sessions, the others to that session only.
    #[arg(long, value_name = "PATH")]
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    model: Option<Location>,
    /// Also write the estimated time series.
    #[arg(long)]
    signals: bool,
    /// Also write what the run did as Prometheus text, for its text-file collector.
    #[arg(long, value_name = "FILE")]
    metrics: Option<PathBuf>,
    #[command(flatten)]
    pages: Pages,
    #[command(flatten)]
    copies: Copies,
}

impl Arguments {
    /// An archive into an output folder, without a word on stdout.
    pub(super) fn quietly(archive: PathBuf, out: PathBuf) -> Self {
        Arguments {
            batch: Options::quietly(archive, out),
            model: None,
            signals: false,
            metrics: None,
            pages: Pages::default(),
            copies: Copies::default(),
        }
    }

    /// Place where the command writes, checked against what it reads but for the logs.
    fn outputs(&self) -> Result<Outputs, Failure> {
        let mut outputs = self.batch.outputs()?;
        if let Some(metrics) = &self.metrics {
            outputs.file("--metrics", &metrics.into())?;
        }
        self.copies.declare(&mut outputs)?;
        self.batch.hold_against(&outputs)?;
        outputs.apart_from(&self.model)?;
        Ok(outputs)
    }

    fn read(&self) -> Result<Given, Failure> {
        let mut given = self.batch.read()?;
        if let Some(at) = &self.model {
            if given.pipeline.offroad.is_some() {
                let message = "--model is for road sessions; take a pipeline without [offroad]";
                return Err(Failure::Usage(message.to_owned()));
            }
            given.pipeline.models = Some(models::read(at)?);
        }
        Ok(given)
    }
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let (start, started) = (Instant::now(), Timestamp::now());
    let given = arguments.read()?;
    let outputs = match arguments.batch.dry_run {
        true => Outputs::default(),
        false => arguments.outputs()?,
    };
    let work = given.fenced(RunWork { signals: arguments.signals })?;
    if arguments.batch.dry_run {
        return dry_run(&given, &work);
    }
    let watch = Watcher {
        progress: Progress::new(bar, arguments.batch.shows_progress()),
        only: Mutex::default(),
    };
    let check = |logs: &[DiscoveredLog], bikes: &Location| {
        let logs = logs.iter().map(|found| &found.location);
        Ok(outputs.apart_from(logs.chain([bikes]))?)
    };
    let done = engine::run_if(&given.settings(), &work, &watch, stop_on_signal(), check);
    Watcher::clear(&watch);
    let (accounts, store) = done?;
    let out = store.root();
    let summarise = || {
        let seconds = start.elapsed().as_secs_f64();
        summarise(&accounts, &given.pipeline, started, seconds, out, arguments.metrics.as_deref())
    };
    if accounts.left > 0 {
        summarise()?;
        return stopped(&accounts);
    }
    if !store.is_behind() {
        if arguments.copies.asked() {
            arguments.copies.write(LocalCopy::of(out)?.folder(), None)?;
        }
        summarise()?;
        if !arguments.batch.is_quiet() {
            print_unchanged(&accounts, out);
        }
        return damaged(&accounts).and_then(|()| rejected(&accounts));
    }
    let copy = finish(&store, arguments.pages.kind.into(), |copy| {
        arguments.copies.write(copy.folder(), None)
    })?;
    summarise()?;
    if !arguments.batch.is_quiet() {
        match watch.only() {
            Some(only) => {
                let printed = Printed {
                    session: &only.session,
                    coefficients: &only.coefficients,
                    warnings: &only.warnings,
                    laps: &only.laps.laps,
                    trends: &only.laps.trends,
                    costs: &only.costs,
                    forces: &only.forces,
                    manoeuvres: &only.manoeuvres,
                };
                print(&printed.text(say::width()));
            }
            None => {
                print(&overview(&accounts, copy.folder(), start.elapsed().as_secs_f64())?);
            }
        }
    }
    if !arguments.batch.is_quiet() {
        print(&format!("\nReport: {}\n", out.join("report/index.html")));
    }
    damaged(&accounts)?;
    rejected(&accounts)
}

/// Progress, and what a single log gave.
struct Watcher {
    progress: Progress,
    /// How many logs there are, and the outcome of the last one that was computed.
    only: Mutex<(usize, Option<Outcome>)>,
}

impl Watcher {
    fn clear(&self) {
        self.progress.clear();
    }

    /// The outcome, where there was one log only.
    fn only(self) -> Option<Outcome> {
        self.only.into_inner().unwrap_or_else(PoisonError::into_inner).1
    }
}

impl Watch<Outcome> for Watcher {
    fn planned(&self, logs: &[String], bytes: u64) {
        self.only.lock().unwrap_or_else(PoisonError::into_inner).0 = logs.len();
        Watch::<Outcome>::planned(&self.progress, logs, bytes);
    }

    fn finished(&self, finished: &Finished<'_>, result: Option<Outcome>) {
        let mut only = self.only.lock().unwrap_or_else(PoisonError::into_inner);
        if only.0 == 1 {
            only.1 = result;
        }
        drop(only);
        self.progress.finished(finished, None::<Outcome>);
    }
}

/// Tells machines what the run did: `run.json`, metrics, the log.
fn summarise(
    accounts: &Accounts,
    pipeline: &Pipeline,
    started: Timestamp,
    seconds: f64,
    out: &Location,
    metrics: Option<&Path>,
) -> Result<(), Failure> {
    let summary = Summary::of(accounts, pipeline, started, seconds);
    summary.write(out)?;
    if let Some(path) = metrics {
        summary.write_metrics(path)?;
    }
    log_accounts(accounts, "run", seconds);
    Ok(())
}

/// What the run's sessions gave, read back from the tables: those that were there already count too.
fn overview(accounts: &Accounts, out: &Path, seconds: f64) -> Result<String, Failure> {
    let ours = |ident: &rows::Ident| {
        accounts.sessions.contains(&Key::new(&ident.bike_id, &ident.session_id))
    };
    let mut sessions = report::tables::sessions(out)?;
    let all = sessions.len();
    sessions.retain(|s| ours(&s.ident));
    let elsewhere = all - sessions.len();
    let mut coefficients = report::tables::coefficients(out)?;
    coefficients.retain(|c| ours(&c.ident));
    let mut warnings = report::tables::warnings(out)?;
    warnings.retain(|w| ours(&w.ident));
    let (rejected, layout) = (&accounts.rejected, (seconds, say::width()));
    Ok(terminal::batch_summary(&sessions, &coefficients, rejected, &warnings, elsewhere, layout))
}
