//! The bike files of a batch, each read once, with the hash of all that goes into a bike's sessions
//! besides the logs.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;
use std::sync::Arc;

use crate::batch::error::Error;
use crate::batch::settings::content;
use crate::contract::bike::{self, Bike, DEFAULT, STANDS_IN_FOR};
use crate::contract::rejection::{RejectionCode, Stage};

use crate::pipeline::{Pipeline, Rejection};
use crate::simulate::effects::SessionRef;
use crate::store::objects::Location;
use crate::store::objects::plain::plain;
use crate::store::tables::names::is_plain;

/// Longest bike id: it becomes a folder name.
const LONGEST_BIKE_ID: usize = 100;

/// A bike and the hash of all that goes into its sessions besides the logs.
#[derive(Debug)]
pub struct BikeFile {
    /// Geometry, masses and sensors, with defaults filled in.
    pub bike: Bike,
    /// Text of its file.
    pub text: String,
    /// BLAKE3 of the resolved pipeline, the channel maps, the command's own settings and the bike file.
    /// [`BikeFile::hash_of`] adds the inputs of one session.
    pub pipeline_hash: String,
}

impl BikeFile {
    /// From a bike file's text; `path` is for messages, `settings` are of [`hash_settings`].
    ///
    /// # Errors
    /// As [`Bike::parse`].
    pub fn parse(
        text: String,
        bike_id: &str,
        path: &Path,
        settings: &[u8],
    ) -> Result<Self, bike::Error> {
        let bike = Bike::parse(&text, bike_id, path)?;
        let mut hasher = blake3::Hasher::new();
        hasher.update(settings);
        hasher.update(content(&text).as_bytes());
        let pipeline_hash = hasher.finalize().to_hex().to_string();
        Ok(BikeFile { bike, text, pipeline_hash })
    }

    /// The hash of all that goes into one of the bike's sessions besides the log: that of every session,
    /// with the channel map ([`Maps::hash_of`](crate::batch::Maps::hash_of)) and what the models take out of this one. A session
    /// that they leave alone keeps the hash.
    pub fn hash_of(&self, pipeline: &Pipeline, who: &SessionRef<'_>, map: &str) -> String {
        let own = pipeline.models.as_ref().map(|models| models.text_of(who)).unwrap_or_default();
        if own.is_empty() && map.is_empty() {
            return self.pipeline_hash.clone();
        }
        let mut hasher = blake3::Hasher::new();
        // of one length: neither can run into what follows
        hasher.update(self.pipeline_hash.as_bytes());
        hasher.update(map.as_bytes());
        hasher.update(own.as_bytes());
        hasher.finalize().to_hex().to_string()
    }
}

/// Start of every session's pipeline hash: the hashes of the pipeline and, where there are any, of the
/// command's own settings. Each part is hashed by itself so that none can run into the next. Channel maps and models
/// are no part of it: they differ by session ([`BikeFile::hash_of`]).
///
/// # Errors
/// The pipeline cannot be written as text: our own mistake.
pub fn hash_settings(pipeline: &Pipeline, own: &str) -> Result<Vec<u8>, Error> {
    let text = toml::to_string(&Pipeline { models: None, ..pipeline.clone() })
        .map_err(|e| Error::Usage(format!("pipeline {}: {e}", pipeline.name)))?;
    let mut hashes = blake3::hash(text.as_bytes()).as_bytes().to_vec();
    if !own.is_empty() {
        hashes.extend_from_slice(blake3::hash(own.as_bytes()).as_bytes());
    }
    Ok(hashes)
}

/// A folder of bike files.
#[derive(Debug)]
pub(crate) struct BikeFiles<'a> {
    folder: &'a Location,
    settings: Vec<u8>,
    /// By bike id.
    read: BTreeMap<String, Result<Arc<BikeFile>, Rejection>>,
}

impl<'a> BikeFiles<'a> {
    /// Of a folder; `settings` are of [`hash_settings`].
    ///
    /// # Errors
    /// The folder cannot be read or holds no bike file.
    pub(crate) fn new(folder: &'a Location, settings: Vec<u8>) -> Result<Self, Error> {
        let fail = |why: String| Error::Usage(format!("--bikes {folder}: {why}"));
        let names: Vec<String> = match folder.as_path() {
            None => {
                let there = folder.list().map_err(|e| fail(e.to_string()))?;
                there.into_iter().map(|e| e.key).collect()
            }
            Some(path) => {
                let there = std::fs::read_dir(path).map_err(|e| match e.kind() {
                    ErrorKind::NotFound => {
                        fail("file not found; give a folder of bike files".into())
                    }
                    ErrorKind::NotADirectory => {
                        fail("this is a file; give the folder that it is in".into())
                    }
                    _ => fail(plain(&e.to_string()).into_owned()),
                })?;
                let name = |e: std::fs::DirEntry| e.file_name().to_string_lossy().into_owned();
                there.filter_map(|e| e.ok().map(name)).collect()
            }
        };
        let is_toml = |name: &String| Path::new(name).extension().is_some_and(|x| x == "toml");
        if names.iter().any(is_toml) {
            return Ok(BikeFiles { folder, settings, read: BTreeMap::new() });
        }
        Err(fail(
            "there is no bike file (<bike_id>.toml) in it; `roadbench bike new NAME` writes one"
                .to_owned(),
        ))
    }

    /// The bike of that id; its file is read once.
    ///
    /// # Errors
    /// There is no such file, or it is not what it should be.
    pub(crate) fn get(&mut self, bike_id: &str) -> Result<Arc<BikeFile>, Rejection> {
        if let Some(known) = self.read.get(bike_id) {
            return known.clone();
        }
        let read = self.read_bike(bike_id);
        self.read.insert(bike_id.to_owned(), read.clone());
        read
    }

    fn read_bike(&self, bike_id: &str) -> Result<Arc<BikeFile>, Rejection> {
        let refuse =
            |code, message| Rejection { stage: Stage::Discover, code, message, limits: None };
        if bike_id.is_empty() {
            return Err(refuse(
                RejectionCode::NoBikeId,
                "the log does not say which bike it was ridden on; put it in a folder bike=<id>/, \
                 in the file's metadata (bike_id), under [meta] in its channel map, or have it written: \
                 `roadbench convert LOG --bike NAME --out FILE`"
                    .to_owned(),
            ));
        }
        if !is_plain(bike_id) || bike_id.len() > LONGEST_BIKE_ID {
            return Err(refuse(
                RejectionCode::BadBikeId,
                format!(
                    "bike id `{}` cannot be a file name: use letters, digits, `.`, `_` and `-`, at \
                     most {LONGEST_BIKE_ID}",
                    bike_id.escape_debug()
                ),
            ));
        }
        let mut at = self.folder.join(format!("{bike_id}.toml"));
        let mut text = read_text(&at);
        if text.as_ref().is_err_and(|e| e.kind() == ErrorKind::NotFound) {
            let default = self.folder.join(format!("{DEFAULT}.toml"));
            // with the bike's name in it the text is no other bike's, and says that it is none of its own
            let found =
                read_text(&default).map(|t| format!("{STANDS_IN_FOR} = \"{bike_id}\"\n{t}"));
            if found.as_ref().map_or_else(|e| e.kind() != ErrorKind::NotFound, |_| true) {
                (at, text) = (default, found);
            }
        }
        let text = text.map_err(|e| match e.kind() {
            ErrorKind::NotFound => {
                refuse(RejectionCode::NoBikeFile, no_file(bike_id, &at, self.folder))
            }
            _ if at.is_remote() => {
                refuse(RejectionCode::Unreachable, format!("cannot read the bike file: {e}"))
            }
            ErrorKind::InvalidData => {
                refuse(RejectionCode::BadBikeFile, format!("cannot read {at}: {e}"))
            }
            _ => refuse(RejectionCode::Unreadable, format!("cannot read the bike file {at}: {e}")),
        })?;
        let path = at.to_string(); // for messages
        let bike = BikeFile::parse(text, bike_id, Path::new(&path), &self.settings)
            .map_err(|e| refuse(RejectionCode::BadBikeFile, e.to_string()))?;
        Ok(Arc::new(bike))
    }
}

fn read_text(at: &Location) -> std::io::Result<String> {
    let bytes = at.read()?;
    String::from_utf8(bytes)
        .map_err(|_| std::io::Error::new(ErrorKind::InvalidData, "it is not UTF-8 text"))
}

/// Commands that write a missing bike file.
fn no_file(bike_id: &str, at: &Location, folder: &Location) -> String {
    let folder = folder.to_string();
    let out = if folder == "bikes" { String::new() } else { format!(" --out {folder}") };
    format!(
        "there is no bike file {at}: `roadbench bike new {bike_id} --class CLASS --front SIZE --rear SIZE --weight \
         KG{out}` writes it from class, tyre sizes and weight with rider; `roadbench bike new {DEFAULT} --class \
         CLASS{out}` writes one for every bike without; or correct the log's bike_id"
    )
}
