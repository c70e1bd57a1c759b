//! Tyre property files (`.tir`) and the published sets.
//!
//! ```text
//! $ a comment            ! a comment
//! [MODEL]
//! FITTYP = 52            $ 52 motorcycle Magic Formula 5.2, 62 MF 6.2, 1 linear
//! [UNITS]
//! LENGTH = 'meter'
//! ```

use std::path::{Path, PathBuf};

use super::keys::{Keys, Missing};
use super::linear::Linear;
use super::mf_62::Mf62;
use super::mf_mc::MfMc;
use super::published;
use super::tyre_model::TyreModel;
use crate::contract::key_error::KeyError;
use crate::contract::schema::{closest, meant};

/// Errors of a tyre file.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Neither a published set nor a file.
    #[error("no tyre `{name}`{meant}; give a .tir or .toml file, or one of {known}")]
    Unknown {
        name: String,
        /// Name that may have been meant, as a part of the sentence.
        meant: String,
        known: String,
    },
    /// The file cannot be read.
    #[error("cannot read tyre file {path}: {source}")]
    Read { path: PathBuf, source: std::io::Error },
    /// A line that is neither comment, section nor `KEY = value`.
    #[error("tyre file {path}, line {line}: {message}")]
    Syntax {
        path: PathBuf,
        /// From 1.
        line: usize,
        message: String,
    },
    /// A key is missing or cannot be.
    #[error("tyre file {path}: {message}")]
    Key { path: PathBuf, message: String },
}

/// A published set by name, or a `.tir` file.
///
/// # Errors
/// See [`Error`].
pub fn load(name_or_path: &str) -> Result<Box<dyn TyreModel>, Error> {
    if let Some(text) = published::text(name_or_path) {
        return parse(text, Path::new(name_or_path));
    }
    let path = Path::new(name_or_path);
    if !path.exists() && path.extension().is_none() {
        let known: Vec<&str> = published::SETS.iter().map(|(n, _)| *n).collect();
        return Err(Error::Unknown {
            name: name_or_path.into(),
            meant: meant(name_or_path, known.iter().copied()),
            known: known.join(", "),
        });
    }
    let bytes =
        std::fs::read(path).map_err(|source| Error::Read { path: path.to_owned(), source })?;
    parse(&String::from_utf8_lossy(&bytes), path)
}

/// The model of a property file's text; `path` is for messages.
///
/// # Errors
/// See [`Error`].
pub fn parse(text: &str, path: &Path) -> Result<Box<dyn TyreModel>, Error> {
    let keys = keys(text, path)?;
    let fail = |message: String| Error::Key { path: path.to_owned(), message };
    let model: Result<Box<dyn TyreModel>, Missing> = match keys.or("FITTYP", 0.0) as i64 {
        52 => MfMc::from_keys(&keys).map(|t| Box::new(t) as _),
        60..=62 => Mf62::from_keys(&keys).map(|t| Box::new(t) as _),
        1 => Linear::from_keys(&keys).map(|t| Box::new(t) as _),
        other => {
            return Err(fail(format!(
                "`FITTYP` = {other} is not known: 62 is Magic Formula 6.2, 52 the motorcycle \
                 Magic Formula 5.2, 1 the linear tyre"
            )));
        }
    };
    let model = model.map_err(|missing| {
        let near = closest(&missing.0, keys.numbers.keys().map(String::as_str));
        let hint = near.map(|n| format!("; is `{n}` meant?")).unwrap_or_default();
        fail(format!("{missing}{hint}"))
    })?;
    let carcass = model.carcass();
    for (name, x) in
        [("UNLOADED_RADIUS", carcass.radius), ("VERTICAL_STIFFNESS", carcass.stiffness)]
    {
        if x.is_nan() || x <= 0.0 {
            return Err(fail(format!("`{name}` = {x} must be positive")));
        }
    }
    if !(0.0..carcass.radius).contains(&carcass.crown) {
        return Err(fail(format!(
            "`CROWN_RADIUS` = {} m is not between 0 and the radius of {} m",
            carcass.crown, carcass.radius
        )));
    }
    Ok(model)
}

/// Reads the keys; a number in another unit than SI is converted by the file's `[UNITS]`.
///
/// # Errors
/// Names the line.
pub(crate) fn keys(text: &str, path: &Path) -> Result<Keys, Error> {
    let mut keys = Keys::default();
    let mut section = String::new();
    for (number, line) in text.lines().enumerate() {
        let fail =
            |message: String| Error::Syntax { path: path.to_owned(), line: number + 1, message };
        let line = bare(line);
        if line.is_empty() {
            continue;
        }
        if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']').trim().to_ascii_uppercase();
            continue;
        }
        let Some((key, value)) = line.split_once('=') else {
            // tables of other vendors ({ x y } blocks) are not keys
            if section.ends_with("TABLE") || section.contains("SHAPE") || line.starts_with('{') {
                continue;
            }
            return Err(fail(format!("`{line}` is not KEY = value")));
        };
        let (key, value) = (key.trim().to_ascii_uppercase(), value.trim());
        if let Some(text) = value.strip_prefix(['\'', '"']) {
            let text = text.trim_end_matches(['\'', '"']).trim();
            if section == "UNITS" {
                check_unit(&key, text).map_err(|e| fail(e.to_string()))?;
            }
            keys.texts.insert(key, text.to_owned());
            continue;
        }
        match value.parse::<f64>() {
            Ok(x) if x.is_finite() => {
                keys.numbers.insert(key, x);
            }
            // a word, or nothing, is no number that went wrong
            _ if !value.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c)) => {
                keys.texts.insert(key, value.to_owned());
            }
            _ => return Err(fail(format!("`{key}` = `{value}` is not a number"))),
        }
    }
    Ok(keys)
}

/// A line without its comment.
fn bare(line: &str) -> &str {
    let mut quoted = false;
    for (i, c) in line.char_indices() {
        match c {
            '\'' | '"' => quoted = !quoted,
            '$' | '!' if !quoted => return line[..i].trim(),
            _ => {}
        }
    }
    line.trim()
}

/// Property files of Magic Formula tyres are in SI units; anything else is refused.
fn check_unit(quantity: &str, unit: &str) -> Result<(), KeyError> {
    let si: &[&str] = match quantity {
        "LENGTH" => &["meter", "m", "metre"],
        "FORCE" => &["newton", "n"],
        "ANGLE" => &["radian", "radians", "rad"],
        "MASS" => &["kg", "kilogram"],
        "TIME" => &["second", "s", "sec"],
        "PRESSURE" => &["pascal", "pa"],
        _ => return Ok(()),
    };
    if si.iter().any(|s| s.eq_ignore_ascii_case(unit)) {
        return Ok(());
    }
    Err(KeyError::Values(format!(
        "{quantity} in `{unit}`: only {} is read; convert the file to SI units",
        si[0]
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_published_set_loads() {
        for (name, _) in published::SETS {
            load(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }

    #[test]
    fn a_missing_key_a_wrong_line_and_a_foreign_unit_are_named() {
        let text = published::text("sharp2004_front_120_70").expect("published");
        let message =
            |text: &str| parse(text, Path::new("x.tir")).expect_err("must fail").to_string();
        let without = text.replace("PKY6", "PKY66");
        assert!(message(&without).contains("missing key `PKY6`"), "{}", message(&without));
        let wrong = text.replace("PCX1 = 1.6064", "PCX1 = 1.6064x");
        assert!(message(&wrong).contains("line") && message(&wrong).contains("PCX1"));
        let unit = text.replace("'meter'", "'mm'");
        assert!(message(&unit).contains("LENGTH"), "{}", message(&unit));
        assert!(load("sharp2005").expect_err("unknown").to_string().contains("sharp2004_front"));
    }

    #[test]
    fn any_bytes_give_a_tyre_or_an_error() {
        let text = published::text("sharp2004_rear_180_55").expect("published");
        for cut in (0..text.len()).step_by(37) {
            if let Some(part) = text.get(..cut) {
                let _ = parse(part, Path::new("cut.tir"));
            }
        }
        let _ = parse("\u{0}\u{ff}==[[]'$!", Path::new("x"));
    }
}
