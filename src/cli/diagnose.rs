//! `roadbench diagnose`.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use clap::builder::NonEmptyStringValueParser;
use indicatif::ProgressBar;

use crate::batch::error::Error;
use crate::batch::jobs::diagnose::{DiagnoseWork, Verdict, against, finish};
use crate::batch::store::folder::Store;
use crate::batch::store::printed_changes;
use crate::batch::workers::in_order::InOrder;
use crate::batch::workers::scheduler as engine;
use crate::batch::workers::scheduler::Accounts;
use crate::batch::{Finished, Watch};
use crate::cli::batch::{
    Options, damaged, dry_run, log_accounts, print, print_unchanged, rejected, stop_on_signal,
    stopped,
};
use crate::cli::failure::Failure;
use crate::cli::json;
use crate::cli::progress::Progress;
use crate::cli::say;
use crate::diagnose::reference::news::News;
use crate::diagnose::reference::words as changes;
use crate::diagnose::{Settings, summary};
use crate::report::diagnosis::answer;
use crate::report::terminal;
use crate::statistics::number_format::count;
use crate::store::objects::Location;
use crate::store::tables::rows::{CauseRow, ChangeRow, Ident};

/// Find out why the model and a ride disagree
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    batch: Options,
    /// Fault-free simulations of each ride; the thresholds come from them. With 0 each ride is only compared with
    /// the motorcycle's other rides, which takes a tenth of the time.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
    /// Simulate additional riding for every cause that a ride cannot reveal.
    ///
    /// It says which would show it and how well, and takes half as long again. For causes that a ride cannot distinguish this is always done.
    #[arg(long)]
    advise: bool,
    /// Hold all other rides of a motorcycle, together, against these: before and after a part was changed.
    ///
    /// The rides are named as for `compare`: session ids, or days such as ..2026-05-03. Three at least of a motorcycle.
    #[arg(long, value_name = "SESSIONS", value_parser = NonEmptyStringValueParser::new())]
    against: Option<String>,
    /// Print the rows of the tables `causes` and `changes` as JSON, one object a line; its key `table` says of which.
    ///
    /// A row of `changes` has the key `new`: true where it was not there at the last diagnosis. The last line, `summary`, has
    /// the counts, also where nothing is new.
    #[arg(long)]
    json: bool,
}

impl Arguments {
    /// An archive into an output folder, without a word on stdout.
    pub(super) fn quietly(archive: PathBuf, out: PathBuf) -> Self {
        let batch = Options::quietly(archive, out);
        Arguments { batch, nulls: 24, advise: false, against: None, json: false }
    }
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments, bar: ProgressBar) -> Result<(), Failure> {
    let start = Instant::now();
    let settings =
        Settings { nulls: arguments.nulls, advise: arguments.advise, ..Settings::default() };
    let work = DiagnoseWork::new(settings).map_err(|e| Failure::Usage(format!("--nulls {e}")))?;
    let given = arguments.batch.read()?;
    if !arguments.batch.dry_run {
        arguments.batch.outputs()?;
    }
    let work = given.fenced(work)?;
    if arguments.batch.dry_run {
        return dry_run(&given, &work);
    }
    let format = match (arguments.json, arguments.batch.is_quiet()) {
        (true, _) => Format::Json,
        (false, true) => Format::None,
        (false, false) => Format::Words,
    };
    let progress = Progress::new(bar, arguments.batch.shows_progress());
    let order = InOrder::new(|text: String| progress.aside(|| print(&text)));
    // of many rides each in full is asked for
    let in_short = format == Format::Words && !say::is_verbose();
    let watch =
        Watcher { progress: &progress, order: &order, format, in_short, seen: Mutex::default() };
    let done = engine::run(&given.settings(), &work, &watch, stop_on_signal());
    order.flush();
    progress.clear();
    let (accounts, store) = done?;
    let out = store.root();
    let Seen { planned, causes: seen, rides } =
        watch.seen.into_inner().unwrap_or_else(PoisonError::into_inner);
    let log = || log_accounts(&accounts, "diagnose", start.elapsed().as_secs_f64());
    if accounts.left > 0 {
        log();
        return stopped(&accounts);
    }
    if !store.is_behind() {
        log();
        if format == Format::Words {
            print_unchanged(&accounts, out);
        }
        // what was new when an earlier command ended before it printed it
        let kept = printed_changes::kept(out);
        let rows = match format == Format::Json || kept.is_some() {
            true => printed_changes::standing(out),
            false => None,
        };
        let is_known = rows.is_some();
        let rows = rows.unwrap_or_default();
        if format == Format::Words && is_known {
            let earlier = kept.as_deref().filter(|rows| !rows.is_empty());
            print_news(&rows, earlier, &BTreeSet::new(), out);
        }
        let earlier = kept.as_deref().filter(|_| is_known).unwrap_or(&rows);
        let compared =
            print_last(&arguments, &store, format, &News::new(&rows, earlier), &accounts);
        if kept.is_some() && is_known {
            printed_changes::clear(out)?;
        }
        compared?;
        return damaged(&accounts).and_then(|()| rejected(&accounts));
    }
    let over_all = finish(&store)?;
    let in_short = in_short && planned > 1;
    if in_short && arguments.nulls > 0 {
        print(&answer::of_sessions(&seen, &over_all.causes, say::width()));
    } else {
        over_all.causes.iter().for_each(|row| print(&format.pooled(row)));
    }
    let (now, earlier) = (&over_all.changes, over_all.earlier.as_deref());
    if format == Format::Words {
        print_news(now, earlier, &rides.iter().map(Ident::key).collect(), out);
    }
    log();
    if format == Format::Words {
        print(&format!("Report: {}\n", out.join("report/index.html")));
    }
    let news = News::new(now, earlier.unwrap_or_default());
    let compared = print_last(&arguments, &store, format, &news, &accounts);
    printed_changes::clear(out)?;
    compared?;
    damaged(&accounts)?;
    rejected(&accounts)
}

/// What is new since the rows that were last printed; without any, or for `-v`, all current rows.
fn print_news(
    now: &[ChangeRow],
    earlier: Option<&[ChangeRow]>,
    diagnosed: &BTreeSet<(&str, &str)>,
    out: &Location,
) {
    let text = match earlier.filter(|_| !say::is_verbose()) {
        Some(earlier) => {
            let list = match out.as_path() {
                Some(folder) => format!("`roadbench show {}`", folder.display()),
                None => "the report".to_owned(),
            };
            News::new(now, earlier).text(diagnosed, &list)
        }
        // the first time all of it is new
        None => changes::of_motorcycles(now),
    };
    print(&terminal::wrapped(&text, say::line_width()));
}

/// The end of what is printed: the rows of `changes` as JSON, the comparison with chosen rides, and the summary, which is the
/// last line of JSON even if the comparison fails.
///
/// # Errors
/// Those of the comparison.
fn print_last(
    arguments: &Arguments,
    store: &Store,
    format: Format,
    news: &News<'_>,
    accounts: &Accounts,
) -> Result<(), Failure> {
    if format == Format::Json {
        for (row, is_new) in &news.rows {
            print(&json::line("changes", &NewsRow { new: *is_new, row }));
        }
    }
    let compared = match &arguments.against {
        Some(text) => print_against(store, text, format),
        None => Ok(()),
    };
    if format == Format::Json {
        print_summary(news, accounts);
    }
    compared
}

/// The counts as JSON.
fn print_summary(news: &News<'_>, accounts: &Accounts) {
    print(&json::line(
        "summary",
        &Summary {
            logs: accounts.inputs,
            diagnosed: accounts.done,
            unchanged: accounts.unchanged,
            rejected: accounts.rejected.len(),
            changes_new: news.new_changes().len(),
            changes_standing: news.standing().len(),
            changes_gone: news.gone.len(),
        },
    ));
}

/// A row of `changes` with whether it was not there at the last diagnosis.
#[derive(Debug, serde::Serialize)]
struct NewsRow<'a> {
    new: bool,
    #[serde(flatten)]
    row: &'a ChangeRow,
}

/// Counts of a diagnosis, of logs and of changes.
#[derive(Debug, serde::Serialize)]
struct Summary {
    logs: usize,
    diagnosed: usize,
    unchanged: usize,
    rejected: usize,
    changes_new: usize,
    changes_standing: usize,
    changes_gone: usize,
}

/// What the other rides of each motorcycle differ by from chosen ones.
fn print_against(store: &Store, text: &str, format: Format) -> Result<(), Failure> {
    if format == Format::None {
        return Ok(());
    }
    let found = against(store, text).map_err(|e| match e {
        Error::Usage(message) => Failure::Usage(message),
        other => Failure::Output(other.to_string()),
    })?;
    match format {
        Format::None => {}
        Format::Json => {
            let rows = found.iter().flat_map(|bike| &bike.changes);
            rows.for_each(|row| print(&json::line("against", row)));
        }
        Format::Words => {
            let mut said = String::new();
            for bike in &found {
                let [reference, others] = bike.rides;
                said += &format!(
                    "{}, {} together against {reference} of the reference ({text}):\n",
                    bike.bike_id,
                    count(others, "ride")
                );
                for row in &bike.changes {
                    let moved = row.moved.as_deref().unwrap_or_default();
                    said += &format!("  {}; moved: {moved}\n", row.sentence);
                }
                if bike.changes.is_empty() {
                    said += &format!("  {}\n", bike.largest);
                }
            }
            if found.is_empty() {
                said += &format!("--against {text}: no other rides of these motorcycles\n");
            }
            print(&terminal::wrapped(&said, say::line_width()));
        }
    }
    Ok(())
}

/// How results are printed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    None,
    Json,
    Words,
}

impl Format {
    fn session(self, verdict: &Verdict) -> String {
        match self {
            Format::None => String::new(),
            Format::Json => verdict.causes.iter().map(|row| json::line("causes", row)).collect(),
            // without fault-free simulations there is none
            Format::Words if verdict.summary.is_empty() => String::new(),
            Format::Words => {
                // what it means comes before how it was found
                let found = answer::causes_of_ride(&verdict.causes);
                let found: String = found.iter().map(|cause| format!("  {cause}\n")).collect();
                let summary = verdict.summary.as_str();
                let (ride, evidence) = summary.split_once('\n').unwrap_or((summary, ""));
                terminal::wrapped(&format!("{ride}\n{found}{evidence}"), say::line_width())
            }
        }
    }

    /// A row that several sessions share.
    fn pooled(self, row: &CauseRow) -> String {
        match self {
            Format::None => String::new(),
            Format::Json => json::line("causes", row),
            Format::Words => summary::pooled(row)
                .map(|text| terminal::wrapped(&text, say::line_width()))
                .unwrap_or_default(),
        }
    }
}

/// Progress, and each session's verdict in order of path.
struct Watcher<'a, F> {
    progress: &'a Progress,
    order: &'a InOrder<String, F>,
    format: Format,
    /// Whether of several rides only what they say together is printed.
    in_short: bool,
    seen: Mutex<Seen>,
}

#[derive(Debug, Default)]
struct Seen {
    /// How many logs there are.
    planned: usize,
    /// The rows of each ride that was computed.
    causes: Vec<Vec<CauseRow>>,
    /// The rides that were computed.
    rides: Vec<Ident>,
}

impl<F> Watcher<'_, F> {
    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<F: Fn(String) + Sync> Watch<Verdict> for Watcher<'_, F> {
    fn planned(&self, logs: &[String], bytes: u64) {
        self.order.expect(logs);
        self.seen().planned = logs.len();
        Watch::<Verdict>::planned(self.progress, logs, bytes);
    }

    fn finished(&self, finished: &Finished<'_>, result: Option<Verdict>) {
        self.progress.finished(finished, None::<Verdict>);
        let text = result.map(|verdict| {
            let mut seen = self.seen();
            let text = match self.in_short && seen.planned > 1 {
                true => String::new(),
                false => self.format.session(&verdict),
            };
            seen.causes.push(verdict.causes);
            seen.rides.push(verdict.ident);
            text
        });
        self.order.finished(finished.log, text);
    }
}
