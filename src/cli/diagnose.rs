//! `roadbench diagnose`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::mpsc;

use rayon::prelude::*;

use crate::batch::discover::{bikes_beside, discover};
use crate::batch::plan::{self, Plan};
use crate::batch::store::{Contents, Store};
use crate::batch::{Maps, Stages, guarded};
use crate::cli::Failure;
use crate::cli::say::say;
use crate::diagnose::levels::{self, Evidence};
use crate::diagnose::{self, Diagnosis, Settings, summary};
use crate::objects::url::is_url;
use crate::pipeline::{Input, Pipeline, Rejection};
use crate::report::{self, terminal};
use crate::tables::file;
use crate::tables::names::file_name;

/// Rejections that are listed on stderr.
const LISTED: usize = 20;

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
    if is_url(&arguments.out) {
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
    let mut says: BTreeMap<&'static str, Vec<Evidence>> = BTreeMap::new();
    let one = |job: &plan::Job| {
        guarded("diagnose", || {
            let input = Input {
                path: &job.found.path,
                maps: maps.list(),
                input_hash: String::new(),
                pipeline_hash: String::new(),
                signals: false,
            };
            diagnose::run(&input, &job.bike.bike, &pipeline, &settings)
        })
    };
    let mut keep = |job: &plan::Job, result: Result<Diagnosis, Rejection>| {
        match result {
            Ok(found) => {
                let ident = &found.ident;
                let path = |name: &str| {
                    let part = format!("bike={}", ident.bike_id);
                    let file = format!("{}.parquet", file_name(&ident.session_id));
                    arguments.out.join(name).join(part).join(file)
                };
                file::write(&path("causes"), &found.causes).map_err(output)?;
                let rows = &found.discrepancies;
                file::write(&path("discrepancies"), rows).map_err(output)?;
                if let Some(model) = &found.model {
                    file::write(&path("replays"), &found.replays).map_err(output)?;
                    let path = path("models").with_extension("toml");
                    file::write_bytes(&path, model.to_toml().as_bytes()).map_err(output)?;
                }
                for (effect, evidence) in found.evidence() {
                    says.entry(effect).or_default().push(evidence);
                }
                store.forgive(&job.log).map_err(output)?;
                if arguments.quiet {
                    // the caller reads the tables
                } else if arguments.json {
                    for row in &found.causes {
                        let text = serde_json::to_string(row)
                            .map_err(|e| Failure::Output(e.to_string()))?;
                        say!("{text}");
                    }
                } else {
                    say!("{}", found.summary);
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
fn pooled(
    says: &BTreeMap<&'static str, Vec<Evidence>>,
    arguments: &Arguments,
) -> Result<(), Failure> {
    let rows = levels::pool(says);
    let path = arguments.out.join("causes/bike=_pooled/pooled.parquet");
    if rows.is_empty() && !path.exists() {
        return Ok(());
    }
    file::write(&path, &rows).map_err(|e| Failure::Output(e.to_string()))?;
    for row in rows.iter().filter(|_| !arguments.quiet) {
        if arguments.json {
            let text = serde_json::to_string(row).map_err(|e| Failure::Output(e.to_string()))?;
            say!("{text}");
            continue;
        }
        if let Some(text) = summary::pooled(row) {
            say!("{text}");
        }
    }
    Ok(())
}
