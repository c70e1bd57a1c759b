//! What a batch is asked to do, whatever its work is.

use std::path::PathBuf;
use std::time::SystemTime;

use crate::ingest::map::ChannelMap;
use crate::objects::Location;
use crate::pipeline::Pipeline;

/// What a batch is asked to do.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// Logs, folders and glob patterns.
    pub inputs: &'a [Location],
    /// Folder of bike files; where absent, the `bikes` beside the inputs' sessions.
    pub bikes: Option<&'a Location>,
    /// Output folder.
    pub out: &'a Location,
    /// The stages' settings.
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

/// What a TOML text says, without remarks, layout and the order of keys: what was made from it depends on nothing else.
pub fn content(text: &str) -> String {
    let table = text.parse::<toml::Table>().ok();
    table.and_then(|t| toml::to_string(&t).ok()).unwrap_or_else(|| text.to_owned())
}

/// Channel maps, with the text that they were read from: it is part of what the tables are
/// made from.
#[derive(Debug, Default)]
pub struct Maps {
    /// Their names and texts.
    texts: Vec<(String, String)>,
    list: Vec<ChannelMap>,
    /// The hashes of the files, one after the other.
    hashes: Vec<u8>,
}

impl Maps {
    /// The maps.
    pub fn list(&self) -> &[ChannelMap] {
        &self.list
    }

    /// Their names and texts, from which a worker makes them.
    pub fn given(&self) -> &[(String, String)] {
        &self.texts
    }

    /// BLAKE3 of all of them together.
    pub fn hash(&self) -> blake3::Hash {
        blake3::hash(&self.hashes)
    }

    /// Reads map files.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn read(paths: &[PathBuf]) -> Result<Self, String> {
        Self::parse(&Self::texts(paths)?)
    }

    /// The names and texts of map files.
    ///
    /// # Errors
    /// One cannot be read.
    pub fn texts(paths: &[PathBuf]) -> Result<Vec<(String, String)>, String> {
        let text = |path: &PathBuf| Ok((path.display().to_string(), ChannelMap::text_of(path)?));
        paths.iter().map(text).collect()
    }

    /// From names, for messages, and texts.
    ///
    /// # Errors
    /// A sentence that names the file and the key.
    pub fn parse(texts: &[(String, String)]) -> Result<Self, String> {
        let mut maps = Maps { texts: texts.to_vec(), ..Maps::default() };
        for (name, text) in texts {
            maps.list.push(ChannelMap::parse(text, name)?);
            maps.hashes.extend_from_slice(blake3::hash(content(text).as_bytes()).as_bytes());
        }
        Ok(maps)
    }
}
