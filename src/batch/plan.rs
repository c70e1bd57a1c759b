//! The plan of a batch, before any samples are read: session and bike of each log, and the logs that are refused.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::discover::DiscoveredLog;
use super::error::Error;
use super::log_hash::hash_file;
use super::settings::{Maps, Settings};
use crate::batch::jobs::bikes::{BikeFile, BikeFiles, hash_settings};
use crate::batch::jobs::work::{Work, guarded};
use crate::batch::store::contents::Contents;
use crate::batch::store::marker::{Committed, Key};
use crate::contract::instant;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Meta;
use crate::ingest::Identified;
use crate::pipeline::{Pipeline, Rejection};
use crate::simulate::effects::SessionRef;
use crate::store::objects::plain::plain;
use crate::store::objects::{Location, source};
use crate::store::tables::names::is_plain;
use crate::store::tables::rows::Rejected;

/// One session to compute.
#[derive(Debug)]
pub struct Job {
    pub location: Location,
    /// Path or URL of the log, as in the tables.
    pub log: String,
    /// Size of the log, bytes.
    pub bytes: u64,
    /// Session, bike, rider, site and start, as far as known.
    pub meta: Meta,
    /// The file of its bike.
    pub bike: Arc<BikeFile>,
    /// Hash of everything that its tables depend on, except the log.
    pub pipeline_hash: String,
    /// Hash of the log's bytes, if the log was recognised by it.
    pub hash: Option<String>,
    /// Start, microseconds since 1970; `None` if it is known only once the log is read.
    pub start: Option<i64>,
    /// Other logs with the same session id, in the order in which they are tried: the first that gives rows is used.
    pub rivals: Vec<Job>,
}

impl Job {
    /// Bike and id of its session.
    pub fn key(&self) -> Key {
        Key::new(&self.meta.bike_id, &self.meta.session_id)
    }

    /// Commit entry of the session, if its tables are computed from a log with this hash.
    pub fn wanted(&self, input_hash: String) -> Committed {
        Committed {
            session_id: self.meta.session_id.clone(),
            bike_id: self.meta.bike_id.clone(),
            part: String::new(), // known once the log is read
            path: self.log.clone(),
            input_hash,
            pipeline_hash: self.pipeline_hash.clone(),
            version: crate::VERSION.to_owned(),
            start: self.start,
            is_old: false,
        }
    }
}

/// An input that is rejected before it is computed.
#[derive(Debug)]
pub(crate) struct Refused {
    /// Its row of `rejected`.
    pub row: Rejected,
    /// Size of the log, bytes.
    pub bytes: u64,
}

/// Logs to compute and logs that are refused.
#[derive(Debug, Default)]
pub(crate) struct Plan {
    /// Logs to compute, in order of path.
    pub jobs: Vec<Job>,
    /// Logs that are refused, in order of path.
    pub refused: Vec<Refused>,
}

impl Plan {
    /// Size of all logs, bytes.
    pub(crate) fn bytes(&self) -> u64 {
        let jobs = self.logs().map(|j| j.bytes);
        jobs.chain(self.refused.iter().map(|r| r.bytes)).sum()
    }
}

impl Plan {
    /// Every log to read, rivals included.
    pub(crate) fn logs(&self) -> impl Iterator<Item = &Job> {
        self.jobs.iter().flat_map(|job| std::iter::once(job).chain(&job.rivals))
    }
}

/// Identifies every input and finds its bike. A log that a session of the output (`before`) was computed from, with
/// unchanged bytes, is not opened: its session is known.
///
/// # Errors
/// The folder of bike files cannot be used.
pub(crate) fn plan(
    found: Vec<DiscoveredLog>,
    bikes: &Location,
    before: &Contents,
    settings: &Settings<'_>,
    work: &impl Work,
) -> Result<Plan, Error> {
    let hashes = hash_settings(settings.pipeline, &work.settings())?;
    let mut bikes = BikeFiles::new(bikes, hashes)?;
    let maps = settings.maps.hashes();
    let known = recognised_logs(&found, before, &mut bikes, settings.pipeline, &maps);
    let identified: Vec<Result<(Meta, String), Rejection>> = found
        .par_iter()
        .map(|f| match known.get(&f.location) {
            Some(known) => Ok((known.meta.clone(), known.map.clone())),
            None => identify(f, settings.maps, work)
                .map(|who| (who.meta, maps.get(&who.map).cloned().unwrap_or_default())),
        })
        .collect();
    let mut plan = Plan::default();
    for (found, meta) in found.into_iter().zip(identified) {
        let location = found.location;
        let log = log_name(&location);
        let bytes = match found.problem {
            None => source::stat(&location).map_or(0, |s| s.size),
            Some(_) => 0,
        };
        let refuse = |log, meta, why| {
            let hash = found.problem.is_none().then(|| hash_file(&location).ok()).flatten();
            let mut row = row(log, meta, why, hash);
            row.bike_id = row.bike_id.or_else(|| bike_of_folder(&location));
            Refused { row, bytes }
        };
        let (meta, map) = match meta {
            Ok(identified) => identified,
            Err(why) => {
                plan.refused.push(refuse(log, None, why));
                continue;
            }
        };
        match bikes.get(&meta.bike_id) {
            Ok(bike) => {
                let known = known.get(&location);
                let hash = known.map(|k| k.hash.clone());
                let own = || meta.start_time.as_deref().and_then(instant::microseconds);
                let start = known.map_or_else(own, |k| k.start);
                let pipeline_hash = bike.hash_of(settings.pipeline, &SessionRef::from(&meta), &map);
                let rivals = Vec::new();
                plan.jobs.push(Job {
                    location,
                    log,
                    bytes,
                    meta,
                    bike,
                    pipeline_hash,
                    hash,
                    start,
                    rivals,
                });
            }
            Err(why) => plan.refused.push(refuse(log, Some(meta), why)),
        }
    }
    refuse_copies(&mut plan, before);
    // logs that were recognised by their bytes are opened after all if others have the same session id
    group_rivals(&mut plan, |log| {
        let who = guarded(Stage::Ingest, || work.identify(log, settings.maps.list())).ok()?;
        instant::microseconds(who.meta.start_time.as_deref()?)
    });
    Ok(plan)
}

/// Of logs with the same bytes keeps one and refuses the others. It keeps the log whose session the output has, else the
/// first.
fn refuse_copies(plan: &mut Plan, before: &Contents) {
    let mut of_size: BTreeMap<u64, Vec<usize>> = BTreeMap::new();
    for (i, job) in plan.jobs.iter().enumerate() {
        of_size.entry(job.bytes).or_default().push(i);
    }
    let alike: Vec<usize> = of_size.into_values().filter(|jobs| jobs.len() > 1).flatten().collect();
    let hashed = alike.into_par_iter().filter_map(|i| {
        let job = &plan.jobs[i];
        let hash = job.hash.clone().map_or_else(|| hash_file(&job.location).ok(), Some)?;
        Some((hash, i))
    });
    let mut of_hash: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (hash, i) in hashed.collect::<Vec<_>>() {
        of_hash.entry(hash).or_default().push(i);
    }
    let mut refused: BTreeMap<usize, (String, Rejection)> = BTreeMap::new();
    for (hash, jobs) in of_hash {
        let is_there = |i: &&usize| {
            let job = &plan.jobs[**i];
            before.made_from(&job.log).contains(&job.key())
        };
        let Some(&kept) = jobs.iter().find(is_there).or(jobs.first()) else { continue };
        for &i in jobs.iter().filter(|i| **i != kept) {
            let (first, own) = (&plan.jobs[kept], &plan.jobs[i]);
            let why = match first.key() == own.key() {
                true => same_session(&own.key(), &first.log),
                false => duplicate(&first.log, &first.meta.session_id),
            };
            refused.insert(i, (hash.clone(), why));
        }
    }
    if refused.is_empty() {
        return;
    }
    for (i, job) in std::mem::take(&mut plan.jobs).into_iter().enumerate() {
        match refused.remove(&i) {
            None => plan.jobs.push(job),
            Some((hash, why)) => {
                let row = row(job.log, Some(job.meta), why, Some(hash));
                plan.refused.push(Refused { row, bytes: job.bytes });
            }
        }
    }
    plan.refused.sort_by(|a, b| a.row.path.cmp(&b.row.path));
}

/// Groups the logs with one session id into one job. The log with the earliest start is tried first, logs without a start
/// last, by path. So the id goes to the same ride in whatever order the logs arrive.
fn group_rivals(plan: &mut Plan, start: impl Fn(&Location) -> Option<i64>) {
    let mut groups: BTreeMap<Key, Vec<Job>> = BTreeMap::new();
    for job in std::mem::take(&mut plan.jobs) {
        groups.entry(job.key()).or_default().push(job);
    }
    for mut jobs in groups.into_values() {
        let is_alone = jobs.len() == 1;
        for job in jobs.iter_mut().filter(|job| !is_alone && job.hash.is_some()) {
            job.start = start(&job.location);
        }
        // stable: they are in order of path
        jobs.sort_by_key(|job| job.start.unwrap_or(i64::MAX));
        let mut jobs = jobs.into_iter();
        let Some(first) = jobs.next() else { continue };
        plan.jobs.push(Job { rivals: jobs.collect(), ..first });
    }
    plan.jobs.sort_by(|a, b| a.location.cmp(&b.location));
}

/// Rejection of a log with the same bytes as another.
pub(crate) fn duplicate(other: &str, session_id: &str) -> Rejection {
    Rejection {
        stage: Stage::Discover,
        code: RejectionCode::DuplicateLog,
        message: format!(
            "this log has the same bytes as {other} (session `{session_id}`), and a ride counts \
             once; remove one of the two"
        ),
        limits: None,
    }
}

/// Bike of the folder `bike=<id>` that a log lies in; known even if the log cannot be read.
fn bike_of_folder(log: &Location) -> Option<String> {
    let folders = log.folders();
    let mut ids = folders.iter().filter_map(|folder| folder.strip_prefix("bike="));
    ids.next_back().filter(|id| is_plain(id)).map(str::to_owned)
}

/// Path or URL of a log, as in the tables.
fn log_name(log: &Location) -> String {
    match log {
        Location::Local(path) => path.to_string_lossy().into_owned(),
        Location::Remote(url) => url.to_string(),
    }
}

/// A row of `rejected`.
pub(crate) fn row(
    log: String,
    meta: Option<Meta>,
    rejection: Rejection,
    input_hash: Option<String>,
) -> Rejected {
    let (session_id, bike_id) = match meta {
        Some(meta) => (Some(meta.session_id), Some(meta.bike_id).filter(|b| !b.is_empty())),
        None => (None, None),
    };
    Rejected {
        path: log,
        session_id,
        bike_id,
        stage: rejection.stage.as_str().to_owned(),
        code: rejection.code.as_str().to_owned(),
        message: plain(&rejection.message).into_owned(),
        limits: rejection.limits,
        input_hash,
        version: crate::VERSION.to_owned(),
    }
}

/// A log that sessions of the output were computed from.
struct KnownLog {
    meta: Meta,
    /// Hash of its channel map.
    map: String,
    /// Hash of its bytes.
    hash: String,
    /// Start, microseconds since 1970.
    start: Option<i64>,
}

/// Logs that an earlier batch read under the same path and settings and whose bytes are unchanged.
fn recognised_logs(
    found: &[DiscoveredLog],
    before: &Contents,
    bikes: &mut BikeFiles<'_>,
    pipeline: &Pipeline,
    maps: &BTreeMap<Option<String>, String>,
) -> BTreeMap<Location, KnownLog> {
    // a path that was used again has several sessions
    let mut by_path: BTreeMap<&str, Vec<&Committed>> = BTreeMap::new();
    before.sessions().for_each(|c| by_path.entry(&c.path).or_default().push(c));
    let made = found.iter().filter(|f| f.problem.is_none()).flat_map(|f| {
        let made = by_path.get(&*log_name(&f.location)).into_iter().flatten();
        made.map(move |there| (f, *there))
    });
    let mut candidates = Vec::new();
    for (found, there) in made {
        let (session_id, bike_id) = (&*there.session_id, &*there.bike_id);
        // site and start are not in the output: where the hash depends on them, the log is opened
        let who = SessionRef { session_id, bike_id, ..SessionRef::default() };
        let Ok(bike) = bikes.get(bike_id) else { continue };
        // the hash includes the channel map, which may set sessions and bikes
        let made_by = |map: &&String| bike.hash_of(pipeline, &who, map) == there.pipeline_hash;
        if let (true, Some(map)) = (there.version == crate::VERSION, maps.values().find(made_by)) {
            candidates.push((&found.location, there, map));
        }
    }
    let recognised = candidates.into_par_iter().filter_map(|(location, there, map)| {
        let hash = hash_file(location).ok().filter(|hash| *hash == there.input_hash)?;
        let meta = Meta {
            session_id: there.session_id.clone(),
            bike_id: there.bike_id.clone(),
            ..Meta::default()
        };
        Some((location.clone(), KnownLog { meta, map: map.clone(), hash, start: there.start }))
    });
    recognised.collect()
}

fn identify(found: &DiscoveredLog, maps: &Maps, work: &impl Work) -> Result<Identified, Rejection> {
    if let Some(problem) = &found.problem {
        return Err(problem.clone());
    }
    guarded(Stage::Ingest, || work.identify(&found.location, maps.list()))
}

/// Rejection of a log whose session another log gives.
pub(crate) fn same_session(key: &Key, holder: &str) -> Rejection {
    Rejection {
        stage: Stage::Discover,
        code: RejectionCode::DuplicateSessionId,
        message: format!(
            "session `{}` of {} is also in {holder}, which is used; give one of the two logs \
             another session_id, or remove one",
            key.session_id, key.bike_id
        ),
        limits: None,
    }
}

/// Rejection of a log whose session id the output has from another ride, the log of which is not among the inputs.
pub(crate) fn archived(there: &Committed, own: Option<i64>) -> Rejection {
    let when = |start: Option<i64>| start.and_then(instant::text).unwrap_or_default();
    let Committed { session_id, bike_id, path, .. } = there;
    Rejection {
        stage: Stage::Discover,
        code: RejectionCode::DuplicateSessionId,
        message: format!(
            "the output already has session `{session_id}` of {bike_id} from another ride ({path}, \
             began {}, this one {}), and that log is not among the inputs; give this log another \
             session_id or name, or remove the other session: roadbench forget OUT --session \
             {session_id}",
            when(there.start),
            when(own)
        ),
        limits: None,
    }
}
