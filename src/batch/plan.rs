//! Before any samples are read: which session each log is, on which bike, and what is refused.

use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::prelude::*;

use super::discover::Found;
use super::store::{Committed, Contents};
use super::{Error, Maps, Work, guarded};
use crate::contract::bike::Bike;
use crate::contract::session::Meta;
use crate::ingest::UNREACHABLE;
use crate::objects::{files, source, url};
use crate::pipeline::{Pipeline, Rejection};
use crate::tables::names::is_plain;
use crate::tables::rows::Rejected;

/// Longest bike id: it becomes a folder name.
const LONGEST_BIKE_ID: usize = 100;

/// One session to compute.
#[derive(Debug)]
pub struct Job {
    /// The log.
    pub found: Found,
    /// The log as it is named in the tables.
    pub log: String,
    /// Size of the log, bytes.
    pub bytes: u64,
    /// Who and when.
    pub meta: Meta,
    /// The bike it was ridden on.
    pub bike: Arc<BikeFile>,
    /// The hash of its bytes, where it was recognised by it.
    pub hash: Option<String>,
}

/// A bike and the hash of all that goes into its sessions besides the logs.
#[derive(Debug)]
pub struct BikeFile {
    /// The bike.
    pub bike: Bike,
    /// What its file says.
    pub text: String,
    /// BLAKE3 of the resolved pipeline, the bike file and the channel maps.
    pub pipeline_hash: String,
}

/// An input that is rejected before it is computed.
#[derive(Debug)]
pub struct Refused {
    /// Its row.
    pub row: Rejected,
    /// Size of the log, bytes.
    pub bytes: u64,
}

/// What a run will do.
#[derive(Debug, Default)]
pub struct Plan {
    /// To compute, in order of path.
    pub jobs: Vec<Job>,
    /// Rejected already, in order of path.
    pub refused: Vec<Refused>,
}

/// Identifies every input and finds its bike. A log that the output's sessions (`before`) were made
/// from, just as it is, need not be opened: they tell who it is.
///
/// # Errors
/// The folder of bike files cannot be used.
pub fn plan(
    found: Vec<Found>,
    bikes: &Path,
    before: &Contents,
    pipeline: &Pipeline,
    maps: &Maps,
    work: &impl Work,
) -> Result<Plan, Error> {
    check_bikes(bikes)?;
    let salt = salt(pipeline, maps)?;
    let mut garage = BTreeMap::new();
    let known = known(&found, before, |bike_id| lookup(&mut garage, bikes, bike_id, &salt));
    let identified: Vec<Result<Meta, Rejection>> = found
        .par_iter()
        .map(|f| match known.get(&f.path) {
            Some(known) => Ok(known.meta.clone()),
            None => identify(f, maps, work),
        })
        .collect();
    let mut first: BTreeMap<String, String> = BTreeMap::new();
    let mut plan = Plan::default();
    for (found, meta) in found.into_iter().zip(identified) {
        let log = found.path.to_string_lossy().into_owned();
        let bytes = match found.problem {
            None => source::stat(&found.path).map_or(0, |s| s.size),
            Some(_) => 0,
        };
        let refuse = |log, meta, why| {
            let hash = found.problem.is_none().then(|| hash_file(&found.path).ok()).flatten();
            Refused { row: row(log, meta, why, hash), bytes }
        };
        let meta = match meta {
            Ok(meta) => meta,
            Err(why) => {
                plan.refused.push(refuse(log, None, why));
                continue;
            }
        };
        let bike = claim(&mut first, &meta, &log)
            .and_then(|()| lookup(&mut garage, bikes, &meta.bike_id, &salt));
        match bike {
            Ok(bike) => {
                let hash = known.get(&found.path).map(|k| k.hash.clone());
                plan.jobs.push(Job { found, log, bytes, meta, bike, hash });
            }
            Err(why) => plan.refused.push(refuse(log, Some(meta), why)),
        }
    }
    Ok(plan)
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
        input_hash,
        version: crate::VERSION.to_owned(),
    }
}

/// BLAKE3 of a file's bytes, as hexadecimal digits; of a log in an object store the store's own
/// name for its bytes ([`source::identity`]).
///
/// # Errors
/// It cannot be read.
pub fn hash_file(path: &Path) -> std::io::Result<String> {
    if let Some(url) = url::parse(path)? {
        return source::identity(&url);
    }
    if !path.is_file() {
        return Err(std::io::ErrorKind::InvalidInput.into()); // a pipe would never end
    }
    let mut hasher = blake3::Hasher::new();
    hasher.update_reader(File::open(path)?)?;
    Ok(hasher.finalize().to_hex().to_string())
}

/// A log that the output was made from.
struct Known {
    meta: Meta,
    hash: String,
}

/// Who the logs are that were read before under the same name and settings, and have the same bytes.
fn known(
    found: &[Found],
    before: &Contents,
    mut bike: impl FnMut(&str) -> Result<Arc<BikeFile>, Rejection>,
) -> BTreeMap<PathBuf, Known> {
    let by_path: BTreeMap<&str, &Committed> =
        before.sessions().map(|c| (c.path.as_str(), c)).collect();
    let there = |found: &Found| by_path.get(found.path.to_str()?).copied();
    let mut candidates = Vec::new();
    for found in found.iter().filter(|f| f.problem.is_none()) {
        let Some(there) = there(found) else { continue };
        let same = there.version == crate::VERSION
            // it has the channel maps in it, which may name sessions and bikes
            && bike(&there.bike_id).is_ok_and(|b| b.pipeline_hash == there.pipeline_hash);
        if same {
            candidates.push((&found.path, there));
        }
    }
    let recognised = candidates.into_par_iter().filter_map(|(path, there)| {
        let hash = hash_file(path).ok().filter(|hash| *hash == there.input_hash)?;
        let meta = Meta {
            session_id: there.session_id.clone(),
            bike_id: there.bike_id.clone(),
            ..Meta::default()
        };
        Some((path.clone(), Known { meta, hash }))
    });
    recognised.collect()
}

fn identify(found: &Found, maps: &Maps, work: &impl Work) -> Result<Meta, Rejection> {
    if let Some(problem) = &found.problem {
        return Err(problem.clone());
    }
    guarded("ingest", || {
        work.identify(&found.path, &maps.list).map_err(|e| Rejection {
            stage: "ingest",
            code: e.code,
            message: e.message,
        })
    })
}

/// The first log of a session has its name; a second one is refused.
fn claim(first: &mut BTreeMap<String, String>, meta: &Meta, log: &str) -> Result<(), Rejection> {
    if let Some(holder) = first.get(&meta.session_id) {
        return Err(Rejection {
            stage: "discover",
            code: "duplicate_session_id",
            message: format!(
                "session `{}` is also in {holder}, which comes first; give one of them another \
                 session_id, or leave one out",
                meta.session_id
            ),
        });
    }
    first.insert(meta.session_id.clone(), log.to_owned());
    Ok(())
}

type Garage = BTreeMap<String, Result<Arc<BikeFile>, Rejection>>;

/// The bike of that id; its file is read once.
fn lookup(
    garage: &mut Garage,
    bikes: &Path,
    bike_id: &str,
    salt: &[u8],
) -> Result<Arc<BikeFile>, Rejection> {
    if let Some(known) = garage.get(bike_id) {
        return known.clone();
    }
    let read = read_bike(bikes, bike_id, salt);
    garage.insert(bike_id.to_owned(), read.clone());
    read
}

fn read_bike(bikes: &Path, bike_id: &str, salt: &[u8]) -> Result<Arc<BikeFile>, Rejection> {
    let refuse = |code, message| Rejection { stage: "discover", code, message };
    if bike_id.is_empty() {
        return Err(refuse(
            "no_bike_id",
            "the log does not say which bike it was ridden on; put it in a folder bike=<id>/, \
             in the file's metadata (bike_id) or under [meta] in its channel map"
                .to_owned(),
        ));
    }
    if !is_plain(bike_id) || bike_id.len() > LONGEST_BIKE_ID {
        return Err(refuse(
            "bad_bike_id",
            format!(
                "bike id `{}` cannot be a file name: use letters, digits, `.`, `_` and `-`, at \
                 most {LONGEST_BIKE_ID}",
                bike_id.escape_debug()
            ),
        ));
    }
    let path = bikes.join(format!("{bike_id}.toml"));
    let text = files::read(&path).and_then(|bytes| {
        String::from_utf8(bytes).map_err(|_| std::io::Error::other("it is not UTF-8 text"))
    });
    let text = match text {
        Ok(text) => text,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => {
            let message = format!(
                "there is no bike file {}: write one (`roadbench schema bike` lists its keys), \
                 or correct the log's bike_id",
                path.display()
            );
            return Err(refuse("no_bike_file", message));
        }
        Err(e) if url::is_url_path(&path) => {
            return Err(refuse(UNREACHABLE, format!("cannot read the bike file: {e}")));
        }
        Err(e) => {
            return Err(refuse("bad_bike_file", format!("cannot read {}: {e}", path.display())));
        }
    };
    let bike = BikeFile::parse(text, bike_id, &path, salt)
        .map_err(|e| refuse("bad_bike_file", e.to_string()))?;
    Ok(Arc::new(bike))
}

impl BikeFile {
    /// From a bike file's text; `path` is for messages, `salt` is [`salt`]'s.
    ///
    /// # Errors
    /// As [`Bike::parse`].
    pub fn parse(
        text: String,
        bike_id: &str,
        path: &Path,
        salt: &[u8],
    ) -> Result<Self, crate::contract::bike::Error> {
        let bike = Bike::parse(&text, bike_id, path)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(salt);
        hasher.update(text.as_bytes());
        let pipeline_hash = hasher.finalize().to_hex().to_string();
        Ok(BikeFile { bike, text, pipeline_hash })
    }
}

fn check_bikes(bikes: &Path) -> Result<(), Error> {
    let fail = |why: String| Error::Usage(format!("--bikes {}: {why}", bikes.display()));
    let names: Vec<PathBuf> = if url::is_url_path(bikes) {
        let there = files::list(bikes).map_err(|e| fail(e.to_string()))?;
        there.into_iter().map(|e| e.key.into()).collect()
    } else {
        let there = std::fs::read_dir(bikes).map_err(|e| fail(e.to_string()))?;
        there.filter_map(|e| Some(e.ok()?.file_name().into())).collect()
    };
    if names.iter().any(|n| n.extension().is_some_and(|x| x == "toml")) {
        return Ok(());
    }
    Err(fail("there is no bike file (<bike_id>.toml) in it".to_owned()))
}

/// What every session's pipeline hash starts from; each part is hashed so that none can run into the next.
///
/// # Errors
/// The pipeline cannot be written as text: our own mistake.
pub fn salt(pipeline: &Pipeline, maps: &Maps) -> Result<Vec<u8>, Error> {
    let text = toml::to_string(pipeline)
        .map_err(|e| Error::Usage(format!("pipeline {}: {e}", pipeline.name)))?;
    let mut salt = blake3::hash(text.as_bytes()).as_bytes().to_vec();
    salt.extend_from_slice(blake3::hash(&maps.text).as_bytes());
    Ok(salt)
}
