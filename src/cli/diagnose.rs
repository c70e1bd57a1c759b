//! `roadbench diagnose`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc;

use rayon::prelude::*;

use crate::batch::discover::{bikes_beside, discover};
use crate::batch::plan::{self, Plan};
use crate::batch::store::{Contents, Store};
use crate::batch::{Maps, Stages, guarded};
use crate::cli::failure::Failure;
use crate::cli::say::say;
use crate::contract::schema::Table;
use crate::diagnose::levels::{self, Say};
use crate::diagnose::name::{ALARM, Cause, Verdict};
use crate::diagnose::offroad;
use crate::diagnose::ride::{self, Diagnosis, Settings};
use crate::effects::Effect;
use crate::objects::url::is_url_path;
use crate::pipeline::{Pipeline, Rejection};
use crate::report::{self, terminal};
use crate::tables::file;
use crate::tables::names::file_name;
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident};

/// Rejections that are listed on stderr.
const LISTED: usize = 20;
/// Most parts of the misfit that are told.
const TOLD: usize = 5;

/// Find what the model of a ride gets wrong, and why
#[derive(Debug, clap::Args)]
pub struct Arguments {
    /// Logs, folders of logs or archives, glob patterns.
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,
    /// Folder of bike files; by default the `bikes` beside an archive's sessions.
    #[arg(long, value_name = "DIR")]
    bikes: Option<PathBuf>,
    /// Folder for the tables `causes` and `discrepancies`.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Settings of the stages; a file, onroad (the default) or offroad.
    #[arg(long, value_name = "FILE")]
    pipeline: Option<PathBuf>,
    /// Channel map of logs that are not session.v1; may be repeated.
    #[arg(long, value_name = "FILE")]
    map: Vec<PathBuf>,
    /// Simulated nulls of each ride, from which the thresholds come.
    #[arg(long, default_value_t = 24)]
    nulls: usize,
    /// Simulate more riding for every cause that a ride says nothing of, and say which would show it and
    /// how well; half as long again. For causes that it cannot tell apart that is always done.
    #[arg(long)]
    advise: bool,
    /// Print the rows of `causes` as JSON, one object a line, instead of words.
    #[arg(long)]
    json: bool,
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
            map: Vec::new(),
            nulls: 24,
            advise: false,
            json: false,
            quiet: true,
        }
    }
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub fn run(arguments: Arguments) -> Result<(), Failure> {
    if !(8..=1000).contains(&arguments.nulls) {
        return Err(Failure::Usage(format!(
            "--nulls {}: fewer than 8 say nothing, more than 1000 nothing new",
            arguments.nulls
        )));
    }
    let pipeline = match &arguments.pipeline {
        Some(path) => Pipeline::read(path).map_err(Failure::Usage)?,
        None => Pipeline::onroad(),
    };
    let maps = Maps::read(&arguments.map).map_err(Failure::Usage)?;
    if is_url_path(&arguments.out) {
        let out = arguments.out.display();
        let message = format!("--out {out}: diagnose writes to a folder; copy it from there");
        return Err(Failure::Usage(message));
    }
    let found = discover(&arguments.inputs, &arguments.out)?;
    let beside = bikes_beside(&arguments.inputs)?;
    let bikes = arguments.bikes.as_deref().or(beside.as_deref()).ok_or_else(|| {
        Failure::Usage("which bikes? Give the folder of bike files with --bikes DIR".to_owned())
    })?;
    let Plan { jobs, refused } =
        plan::plan(found, bikes, &Contents::default(), &pipeline, &maps, &Stages)?;
    let store = Store::open(&arguments.out)?;
    let output = |e: file::Error| Failure::Output(e.to_string());
    let mut rejected: Vec<_> = refused.into_iter().map(|r| r.row).collect();
    let count = jobs.len() + rejected.len();
    let settings =
        Settings { nulls: arguments.nulls, advise: arguments.advise, ..Settings::default() };
    let mut says: BTreeMap<&'static str, Vec<Say>> = BTreeMap::new();
    let one = |job: &plan::Job| {
        guarded("diagnose", || {
            let (log, maps, bike) = (&job.found.path, maps.list(), &job.bike.bike);
            match pipeline.offroad {
                None => ride::log(log, maps, bike, &pipeline, &settings)
                    .map(|d| Found::Road(Box::new(d))),
                Some(_) => offroad::log(log, maps, bike, &pipeline, arguments.nulls)
                    .map(|d| Found::Offroad(Box::new(d))),
            }
        })
    };
    let mut keep = |job: &plan::Job, result: Result<Found, Rejection>| {
        match result {
            Ok(found) => {
                let (ident, causes, rows) = found.tables();
                let path = |name: &str| {
                    let part = format!("bike={}", ident.bike_id);
                    let file = format!("{}.parquet", file_name(&ident.session_id));
                    arguments.out.join(name).join(part).join(file)
                };
                file::write(&path("causes"), &Table::embedded("causes"), causes).map_err(output)?;
                file::write(&path("discrepancies"), &Table::embedded("discrepancies"), rows)
                    .map_err(output)?;
                if let Found::Road(d) = &found {
                    file::write(&path("replays"), &Table::embedded("replays"), &d.replays)
                        .map_err(output)?;
                    let model = path("models").with_extension("toml");
                    file::write_bytes(&model, d.model.to_toml().as_bytes()).map_err(output)?;
                    // sizes under a model that is known to be wrong are no sizes
                    let sound = d.naming.named() || d.naming.alarm <= ALARM;
                    for row in d.causes.iter().filter(|_| sound && !d.naming.unexplained) {
                        if let Ok(effect) = Effect::named(&row.effect)
                            && let Some(say) = Say::of(row, d.site.as_deref())
                        {
                            says.entry(effect.name).or_default().push(say);
                        }
                    }
                }
                store.forgive(&job.log).map_err(output)?;
                if arguments.quiet {
                    // the caller reads the tables
                } else if arguments.json {
                    for row in causes {
                        let text = serde_json::to_string(row)
                            .map_err(|e| Failure::Output(e.to_string()))?;
                        say!("{text}");
                    }
                } else {
                    match &found {
                        Found::Road(d) => tell(d),
                        Found::Offroad(d) => say!("{}", d.words().trim_end()),
                    }
                }
            }
            Err(why) => {
                rejected.push(plan::row(job.log.clone(), Some(job.meta.clone()), why, None))
            }
        }
        Ok::<(), Failure>(())
    };
    // told in their order as they are done; a few are held for those before them
    let (send, receive) = mpsc::sync_channel(rayon::current_num_threads());
    std::thread::scope(|scope| {
        let (jobs, one) = (&jobs, &one);
        scope.spawn(move || {
            let jobs = jobs.iter().enumerate().par_bridge();
            // whoever hears no more wants no more
            jobs.try_for_each(|(k, job)| send.send((k, one(job))))
        });
        let (mut waiting, mut next) = (BTreeMap::new(), 0);
        for (k, result) in receive {
            waiting.insert(k, result);
            while let Some(result) = waiting.remove(&next) {
                keep(&jobs[next], result)?;
                next += 1;
            }
        }
        Ok::<(), Failure>(())
    })?;
    pooled(&says, &arguments)?;
    for row in &rejected {
        store.reject(row).map_err(output)?;
    }
    tracing::info!(sessions = count - rejected.len(), "tables: {}", arguments.out.display());
    report::write(&arguments.out)?;
    tracing::info!("report: {}", arguments.out.join("report/index.html").display());
    if rejected.is_empty() {
        return Ok(());
    }
    let list = terminal::rejections(&rejected, LISTED);
    Err(Failure::Rejected(format!("{} rejected:\n{}", rejected.len(), list.trim_end())))
}

/// Writes and tells what sessions share.
fn pooled(says: &BTreeMap<&'static str, Vec<Say>>, arguments: &Arguments) -> Result<(), Failure> {
    let rows = levels::pool(says);
    let path = arguments.out.join("causes/bike=_pooled/pooled.parquet");
    if rows.is_empty() && !path.exists() {
        return Ok(());
    }
    file::write(&path, &Table::embedded("causes"), &rows)
        .map_err(|e| Failure::Output(e.to_string()))?;
    for row in rows.iter().filter(|_| !arguments.quiet) {
        if arguments.json {
            let text = serde_json::to_string(row).map_err(|e| Failure::Output(e.to_string()))?;
            say!("{text}");
            continue;
        }
        let (Some(value), Some(low), Some(high)) = (row.value, row.ci95_low, row.ci95_high) else {
            continue;
        };
        say!(
            "{} {}: {}\n      {value:.4} {}, 95 % interval {low:.4} to {high:.4}; {}",
            row.level,
            row.pooled_over.as_deref().unwrap_or(""),
            row.effect,
            row.unit,
            row.reason
        );
    }
    Ok(())
}

/// What a session says, on the road or off it.
enum Found {
    Road(Box<Diagnosis>),
    Offroad(Box<offroad::Diagnosis>),
}

impl Found {
    fn tables(&self) -> (&Ident, &[CauseRow], &[DiscrepancyRow]) {
        match self {
            Found::Road(d) => (&d.ident, &d.causes, &d.discrepancies),
            Found::Offroad(d) => (&d.ident, &d.causes, &d.discrepancies),
        }
    }
}

/// The verdict in words.
fn tell(d: &Diagnosis) {
    let naming = &d.naming;
    say!("{}  {}", d.ident.session_id, d.ident.bike_id);
    let named: Vec<&Cause> = naming
        .causes
        .iter()
        .filter(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
        .collect();
    match (named.is_empty(), naming.unexplained) {
        (true, true) => say!(
            "  Something is wrong that no candidate explains{} (largest score of a candidate {:.1}; 19 of \
             20 nulls stay below 1).",
            naming.left.map_or(String::new(), |(term, _)| format!(": {}", term.describe())),
            naming.alarm
        ),
        (true, false) if naming.alarm > ALARM => say!(
            "  Nothing is named. A candidate scores {:.1} (19 of 20 nulls stay below 1), but none has a size \
             that can be and gains enough.",
            naming.alarm
        ),
        (true, false) if naming.causes.iter().all(|c| c.verdict == Verdict::NotIdentifiable) => {
            say!(
                "  This ride can show none of the {} candidates: nothing can be said of what is wrong.",
                naming.causes.len()
            )
        }
        (true, false) => say!(
            "  Nothing is wrong that this ride could show: the largest score is {:.1} (19 of 20 nulls stay \
             below 1).",
            naming.alarm
        ),
        (false, true) => say!(
            "  Something more is wrong than is named{}.",
            naming.left.map_or(String::new(), |(term, _)| format!(": {}", term.describe()))
        ),
        (false, false) => {}
    }
    for cause in &named {
        let half = 1.96 * cause.std_error;
        say!(
            "  {}: {}\n      {:.4} {}, 95 % interval {:.4} to {:.4}; score {:.1}, gain {:.0}",
            cause.effect.name,
            cause.effect.sentence,
            cause.value,
            cause.effect.unit,
            cause.value - half,
            cause.value + half,
            cause.score,
            cause.gain
        );
        if cause.verdict == Verdict::Ambiguous {
            let row = d.causes.iter().find(|r| r.effect == cause.effect.name);
            say!(
                "      or {}: this ride cannot tell; what would: {}",
                cause.equivalent.join(" or "),
                row.and_then(|r| r.separate_by.as_deref()).unwrap_or(cause.effect.separate_by)
            );
        }
    }
    if let Some(row) = d.causes.iter().find(|r| r.gain_heldout.is_some())
        && let (Some(gain), Some(bound)) = (row.gain_heldout, row.gain_upper_bound)
    {
        say!("  On manoeuvres left out it gains {gain:.0}; with every candidate free {bound:.0}.");
    }
    let mut wrong: Vec<_> = d.discrepancies.iter().filter(|r| r.structured).collect();
    wrong.sort_by(|a, b| (b.rmse_base / b.null_largest).total_cmp(&(a.rmse_base / a.null_largest)));
    for row in wrong.into_iter().take(TOLD) {
        let after =
            row.rmse_extended.map_or(String::new(), |r| format!(", {r:.4} with the causes"));
        let with = row.covariate.as_deref().map_or(String::new(), |c| {
            format!(", goes with {c} ({:+.2})", row.correlation.unwrap_or(0.0))
        });
        say!(
            "  misfit of {} while {}: {:.4}{} against {:.4} in nulls{after}{with}",
            row.channel,
            row.kind.replace('_', " "),
            row.rmse_base,
            if row.unit == "1" { " sd".to_owned() } else { format!(" {}", row.unit) },
            row.noise_floor
        );
    }
}
