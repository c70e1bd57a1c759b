//! What `run --model` is given: the output of a diagnosis, its folder of models, or one of the files in it.

use std::io::ErrorKind;

use rayon::prelude::*;
use walkdir::WalkDir;

use crate::batch::error::Error;
use crate::batch::store::intact;
use crate::batch::store::manifest;
use crate::batch::store::reading::Reading;
use crate::contract::file_error::FileError;
use crate::simulate::effects::extended_model::ExtendedModel;
use crate::simulate::effects::models::Models;
use crate::simulate::effects::pooled_effects;
use crate::simulate::effects::pooled_effects::PooledEffects;
use crate::store::objects::Location;

/// Folder of the models below the output of a diagnosis.
const FOLDER: &str = "models";
/// Extension of a model.
const TOML: &str = ".toml";

/// Reads the models of many sessions and what those share from a folder, or one session's from a file.
///
/// # Errors
/// A sentence that names the file and the key, or says that there is no model.
pub fn read(at: &Location) -> Result<Models, Error> {
    let fail = |e: std::io::Error| Error::Usage(format!("--model {at}: {e}"));
    if at.file_name() == pooled_effects::FILE {
        let why = "is what sessions share, not a session's model; give the folder that it is in";
        return Err(Error::Usage(format!("--model {at}: this {why}")));
    }
    if at.is_folder().map_err(fail)? {
        return of_folder(at);
    }
    intact_file(at)?;
    let text = text(at).map_err(|e| Error::Usage(format!("--model {e}")))?;
    ExtendedModel::parse(&text, &at.to_string()).map(Models::of_one).map_err(usage)
}

/// Makes sure that a model of an output, `<out>/models/bike=<id>/<session>.toml`, is as it was written.
fn intact_file(at: &Location) -> Result<(), Error> {
    let at = at.absolute();
    let Some(root) = at.as_path().and_then(|path| path.ancestors().nth(3)) else { return Ok(()) };
    let root = Location::from(root);
    let own = manifest::below(&root, &at);
    intact::require(&root, |path| own.as_deref() == Some(path))
}

/// Of the output of a diagnosis or its folder of models.
fn of_folder(given: &Location) -> Result<Models, Error> {
    let fail = |e: std::io::Error| Error::Usage(format!("--model {given}: {e}"));
    let below = given.join(FOLDER);
    let out = given.as_path().map(|path| match path.file_name().is_some_and(|n| n == FOLDER) {
        true => path.parent().unwrap_or(path),
        false => path,
    });
    let _reading = out.map(Reading::of).transpose()?;
    let is_output = below.is_folder().map_err(fail)?;
    if let Some(root) = out.map(Location::from).or_else(|| is_output.then(|| given.clone())) {
        intact::require(&root, |path| manifest::is_below(path, FOLDER))?;
    }
    let folder = if is_output { below } else { given.clone() };
    let names = names(&folder).map_err(fail)?;
    let of_sessions: Vec<&String> = names.iter().filter(|name| is_model(name)).collect();
    let has_shared = names.iter().any(|name| name == pooled_effects::FILE);
    if of_sessions.is_empty() && !has_shared {
        let why = match given.file_name().starts_with("bike=") {
            true => "this is one motorcycle's; give the folder above it".to_owned(),
            false => "there is no model in this folder; `roadbench diagnose INPUT --out DIR` writes them to \
                      DIR, which is what to give"
                .to_owned(),
        };
        return Err(Error::Usage(format!("--model {given}: {why}")));
    }
    let models: Vec<ExtendedModel> = of_sessions
        .par_iter()
        .map(|name| {
            let at = folder.join(name);
            ExtendedModel::parse(&text(&at)?, &at.to_string()).map_err(usage)
        })
        .collect::<Result<_, Error>>()?;
    let shared = match has_shared {
        false => PooledEffects::default(),
        true => {
            let at = folder.join(pooled_effects::FILE);
            PooledEffects::parse(&text(&at)?, &at.to_string()).map_err(usage)?
        }
    };
    Models::of_many(models, &shared).map_err(|e| Error::Usage(format!("--model {folder}: {e}")))
}

/// The files of a folder and of the folders in it, in order. A local folder that is no diagnosis may be
/// large: nothing deeper is looked at.
fn names(folder: &Location) -> std::io::Result<Vec<String>> {
    let Some(path) = folder.as_path() else {
        return Ok(folder.list()?.into_iter().map(|entry| entry.key).collect());
    };
    let walk = WalkDir::new(path).min_depth(1).max_depth(2).sort_by_file_name();
    let mut names = Vec::new();
    for entry in walk {
        let entry = entry.map_err(std::io::Error::from)?;
        if let (false, Ok(below)) = (entry.path().is_dir(), entry.path().strip_prefix(path)) {
            let parts: Vec<_> = below.iter().map(|part| part.to_string_lossy()).collect();
            names.push(parts.join("/"));
        }
    }
    Ok(names)
}

/// Whether a file below the folder of models is a session's: `bike=<id>/<session>.toml`.
fn is_model(name: &str) -> bool {
    let parts = name.strip_prefix("bike=").and_then(|rest| rest.split_once('/'));
    parts.is_some_and(|(_, file)| file.ends_with(TOML) && !file.contains('/'))
}

fn text(at: &Location) -> Result<String, Error> {
    let bytes = at.read().map_err(|e| match e.kind() {
        ErrorKind::NotFound => Error::Usage(format!("{at}: file not found")),
        _ => Error::Usage(format!("{at}: {e}")),
    })?;
    String::from_utf8(bytes).map_err(|_| Error::Usage(format!("{at}: it is not UTF-8 text")))
}

fn usage(e: FileError) -> Error {
    Error::Usage(e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::store::manifest::{Manifest, checksum};

    #[test]
    fn a_model_that_is_not_as_it_was_written_is_refused_however_it_is_given() {
        let folder = tempfile::tempdir().expect("folder");
        let out = Location::from(folder.path());
        let file = "models/bike=b1/s.toml";
        out.join(file).write(b"friction_load = 0.19").expect("written");
        let mut list = Manifest::empty();
        list.put(file.to_owned(), checksum(b"friction_load = 0.12"));
        list.write(&out).expect("listed");
        for given in [out.clone(), out.join(FOLDER), out.join(file)] {
            let error = read(&given).map(drop).expect_err("damaged");
            assert!(matches!(error, Error::Output(_)), "{given}: {error}");
            assert!(error.to_string().contains(file), "{given}: {error}");
        }
    }
}
