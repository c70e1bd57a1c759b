//! Before any samples are read: which session each log is, on which bike, and what is refused.

use std::collections::BTreeMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::bikes::{BikeFile, BikeFiles, hash_settings};
use super::blame::DUPLICATE_ID;
use super::contents::Contents;
use super::discover::Found;
use super::error::Error;
use super::log_hash::hash_file;
use super::marker::{Committed, Key};
use super::settings::{Maps, Settings};
use super::work::{Work, guarded};
use crate::contract::session::Meta;
use crate::effects::Who;
use crate::ingest::Identified;
use crate::objects::{Location, source};
use crate::pipeline::{Pipeline, Rejection};
use crate::tables::rows::Rejected;

/// One session to compute.
#[derive(Debug)]
pub struct Job {
    /// The log.
    pub location: Location,
    /// The log as it is named in the tables.
    pub log: String,
    /// Size of the log, bytes.
    pub bytes: u64,
    /// Who and when.
    pub meta: Meta,
    /// The bike it was ridden on.
    pub bike: Arc<BikeFile>,
    /// Hash of all that its tables are made from besides the log.
    pub pipeline_hash: String,
    /// The hash of its bytes, where it was recognised by it.
    pub hash: Option<String>,
}

impl Job {
    /// Who its session is.
    pub fn key(&self) -> Key {
        Key::new(&self.meta.bike_id, &self.meta.session_id)
    }

    /// What the session's tables would be made from.
    pub fn wanted(&self, input_hash: String) -> Committed {
        Committed {
            session_id: self.meta.session_id.clone(),
            bike_id: self.meta.bike_id.clone(),
            part: String::new(), // known once the log is read
            path: self.log.clone(),
            input_hash,
            pipeline_hash: self.pipeline_hash.clone(),
            version: crate::VERSION.to_owned(),
            is_old: false,
        }
    }
}

/// An input that is rejected before it is computed.
#[derive(Debug)]
pub struct Refused {
    /// Its row.
    pub row: Rejected,
    /// Size of the log, bytes.
    pub bytes: u64,
}

/// What a batch will do.
#[derive(Debug, Default)]
pub struct Plan {
    /// To compute, in order of path.
    pub jobs: Vec<Job>,
    /// Rejected already, in order of path.
    pub refused: Vec<Refused>,
}

impl Plan {
    /// Size of all logs, bytes.
    pub fn bytes(&self) -> u64 {
        let jobs = self.jobs.iter().map(|j| j.bytes);
        jobs.chain(self.refused.iter().map(|r| r.bytes)).sum()
    }
}

/// Identifies every input and finds its bike. A log that the output's sessions (`before`) were made
/// from, just as it is, need not be opened: they tell who it is.
///
/// # Errors
/// The folder of bike files cannot be used.
pub fn plan(
    found: Vec<Found>,
    bikes: &Location,
    before: &Contents,
    settings: &Settings<'_>,
    work: &impl Work,
) -> Result<Plan, Error> {
    let hashes = hash_settings(settings.pipeline, &work.settings())?;
    let mut bikes = BikeFiles::new(bikes, hashes)?;
    let maps = settings.maps.hashes();
    let known = known(&found, before, &mut bikes, settings.pipeline, &maps);
    let identified: Vec<Result<(Meta, String), Rejection>> = found
        .par_iter()
        .map(|f| match known.get(&f.location) {
            Some(known) => Ok((known.meta.clone(), known.map.clone())),
            None => identify(f, settings.maps, work)
                .map(|who| (who.meta, maps.get(&who.map).cloned().unwrap_or_default())),
        })
        .collect();
    // a session that is there stays with its log, whatever else says to be it
    let mut first: BTreeMap<Key, String> = BTreeMap::new();
    for (found, meta) in found.iter().zip(&identified) {
        let (log, Ok((meta, _))) = (name(&found.location), meta) else { continue };
        let key = Key::new(&meta.bike_id, &meta.session_id);
        if before.made_from(&log).contains(&key) {
            first.entry(key).or_insert(log);
        }
    }
    let mut plan = Plan::default();
    for (found, meta) in found.into_iter().zip(identified) {
        let location = found.location;
        let log = name(&location);
        let bytes = match found.problem {
            None => source::stat(&location).map_or(0, |s| s.size),
            Some(_) => 0,
        };
        let refuse = |log, meta, why| {
            let hash = found.problem.is_none().then(|| hash_file(&location).ok()).flatten();
            Refused { row: row(log, meta, why, hash), bytes }
        };
        let (meta, map) = match meta {
            Ok(identified) => identified,
            Err(why) => {
                plan.refused.push(refuse(log, None, why));
                continue;
            }
        };
        match claim(&mut first, &meta, &log).and_then(|()| bikes.get(&meta.bike_id)) {
            Ok(bike) => {
                let hash = known.get(&location).map(|k| k.hash.clone());
                let pipeline_hash = bike.hash_of(settings.pipeline, &Who::from(&meta), &map);
                plan.jobs.push(Job { location, log, bytes, meta, bike, pipeline_hash, hash });
            }
            Err(why) => plan.refused.push(refuse(log, Some(meta), why)),
        }
    }
    refuse_copies(&mut plan, before);
    Ok(plan)
}

/// Refuses every log but one of those that have the same bytes: the one whose session is there, else the first.
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
            let first = &plan.jobs[kept];
            refused.insert(i, (hash.clone(), duplicate(&first.log, &first.meta.session_id)));
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

/// Why a log is not used whose bytes another one has.
pub fn duplicate(other: &str, session_id: &str) -> Rejection {
    Rejection {
        stage: "discover",
        code: "duplicate_log",
        message: format!(
            "it has the same bytes as {other} (session `{session_id}`), and a ride counts once; leave one of them out"
        ),
        limits: None,
    }
}

/// A log as the tables name it.
fn name(log: &Location) -> String {
    match log {
        Location::Local(path) => path.to_string_lossy().into_owned(),
        Location::Remote(url) => url.to_string(),
    }
}

/// A row of `rejected`.
pub fn row(
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
        stage: rejection.stage.to_owned(),
        code: rejection.code.to_owned(),
        message: rejection.message,
        limits: rejection.limits,
        input_hash,
        version: crate::VERSION.to_owned(),
    }
}

/// A log that the output was made from.
struct Known {
    meta: Meta,
    /// The hash of its channel map.
    map: String,
    hash: String,
}

/// Who the logs are that were read before under the same name and settings, and have the same bytes.
fn known(
    found: &[Found],
    before: &Contents,
    bikes: &mut BikeFiles<'_>,
    pipeline: &Pipeline,
    maps: &BTreeMap<Option<String>, String>,
) -> BTreeMap<Location, Known> {
    let by_path: BTreeMap<&str, &Committed> =
        before.sessions().map(|c| (c.path.as_str(), c)).collect();
    let mut candidates = Vec::new();
    for found in found.iter().filter(|f| f.problem.is_none()) {
        let Some(&there) = by_path.get(&*name(&found.location)) else { continue };
        let (session_id, bike_id) = (&*there.session_id, &*there.bike_id);
        // the output does not say where and when; where that matters the log is opened
        let who = Who { session_id, bike_id, ..Who::default() };
        let Ok(bike) = bikes.get(bike_id) else { continue };
        // the hash has the channel map in it, which may name sessions and bikes
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
        Some((location.clone(), Known { meta, map: map.clone(), hash }))
    });
    recognised.collect()
}

fn identify(found: &Found, maps: &Maps, work: &impl Work) -> Result<Identified, Rejection> {
    if let Some(problem) = &found.problem {
        return Err(problem.clone());
    }
    guarded("ingest", || work.identify(&found.location, maps.list()))
}

/// The log that a session was made from has its name, or else the first one; any other is refused.
fn claim(first: &mut BTreeMap<Key, String>, meta: &Meta, log: &str) -> Result<(), Rejection> {
    let key = Key::new(&meta.bike_id, &meta.session_id);
    if let Some(holder) = first.get(&key).filter(|holder| *holder != log) {
        return Err(Rejection {
            stage: "discover",
            code: DUPLICATE_ID,
            message: format!(
                "session `{}` of {} is also in {holder}, which has it; give one of them another \
                 session_id, or leave one out",
                meta.session_id, meta.bike_id
            ),
            limits: None,
        });
    }
    first.insert(key, log.to_owned());
    Ok(())
}
