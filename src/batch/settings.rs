//! What a batch is asked to do, whatever its work is.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::SystemTime;

use crate::contract::file_error::FileError;
use crate::ingest::maps::ChannelMap;
use crate::ingest::maps::file::or_shipped;
use crate::pipeline::Pipeline;
use crate::store::objects::Location;

/// Inputs and options of a batch.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// Logs, folders and glob patterns.
    pub inputs: &'a [Location],
    /// Folder of bike files; where absent, the `bikes` beside the inputs' sessions.
    pub bikes: Option<&'a Location>,
    /// Output folder or URL.
    pub out: &'a Location,
    /// Settings of all stages.
    pub pipeline: &'a Pipeline,
    /// The channel maps to choose from; none means those that come with the program.
    pub maps: &'a Maps,
    /// Workers; 0 takes one per core.
    pub jobs: usize,
    /// Compute again what is there already.
    pub force: bool,
    /// Only logs that were written since then.
    pub since: Option<SystemTime>,
}

/// Content of a TOML text without comments, layout and order of keys: results depend on nothing else.
pub(crate) fn content(text: &str) -> String {
    let table = text.parse::<toml::Table>().ok();
    table.and_then(|t| toml::to_string(&t).ok()).unwrap_or_else(|| text.to_owned())
}

/// Channel maps, with the text that they were read from.
#[derive(Debug, Default)]
pub struct Maps {
    /// Their names and texts.
    texts: Vec<(String, String)>,
    list: Vec<ChannelMap>,
}

impl Maps {
    /// All channel maps, those of the user first.
    pub fn list(&self) -> &[ChannelMap] {
        &self.list
    }

    /// Their names and texts, from which a worker makes them.
    pub fn given(&self) -> &[(String, String)] {
        &self.texts
    }

    /// Hash of the maps that decide how a log is read: the content of the map with this name, and the recognition rules
    /// of the maps before it, which might take the log instead. Empty if no map is needed.
    pub fn hash_of(&self, taken: Option<&str>) -> String {
        let list = or_shipped(&self.list).list;
        // of several with one name, all
        let Some(place) = taken.and_then(|name| list.iter().rposition(|m| m.name == name)) else {
            return String::new();
        };
        let map = &list[place];
        let mut hasher = blake3::Hasher::new();
        for before in list[..=place].iter().filter(|m| m.format == map.format) {
            let what = match before.name == map.name {
                true => content(&before.text),
                false => format!("{:?} {:?}", before.detect, before.csv),
            };
            hasher.update(blake3::hash(what.as_bytes()).as_bytes());
        }
        hasher.finalize().to_hex().to_string()
    }

    /// [`Maps::hash_of`] of everything that may be taken, and of nothing.
    pub fn hashes(&self) -> BTreeMap<Option<String>, String> {
        let names = or_shipped(&self.list).list.iter().map(|m| Some(m.name.clone()));
        let all = std::iter::once(None).chain(names);
        all.map(|taken| (taken.clone(), self.hash_of(taken.as_deref()))).collect()
    }

    /// Reads map files.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn read(paths: &[PathBuf]) -> Result<Self, FileError> {
        Self::parse(&Self::texts(paths)?)
    }

    /// The names and texts of map files.
    ///
    /// # Errors
    /// One cannot be read.
    pub fn texts(paths: &[PathBuf]) -> Result<Vec<(String, String)>, FileError> {
        let text = |path: &PathBuf| Ok((path.display().to_string(), ChannelMap::text_of(path)?));
        paths.iter().map(text).collect()
    }

    /// From names, for messages, and texts.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn parse(texts: &[(String, String)]) -> Result<Self, FileError> {
        let mut maps = Maps { texts: texts.to_vec(), ..Maps::default() };
        for (name, text) in texts {
            maps.list.push(ChannelMap::parse(text, name)?);
        }
        Ok(maps)
    }
}
