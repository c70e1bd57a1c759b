//! The rule for every path that a command writes at the user's word (`--out FILE`, `--markdown`, `--figures`, ...).
//!
//! ```text
//! nothing there, a file     made or replaced whole; it keeps its rights
//! a link to a file          the file that it leads to is replaced, or made; the link stays
//! a device, a pipe          written into; a pipe that nobody reads is waited for, for five seconds
//! stdout, stderr            as `/dev/stdout` or by another name: written to as what is printed
//! a folder, a socket        refused
//! an input of the command   refused, however it is spelled, hard links too
//! an output's own file      refused: its tables, its report, what it keeps for itself
//! ```
//!
//! Where a folder is wanted, a link to one is followed; anything else that is there is refused. All that is refused is refused
//! before the work begins ([`Outputs`]); [`write()`] then looks again. It stands among the tables because it is they that a path
//! may not be one of ([`registry::folders`]).
//!
//! What the program writes at names of its own, below an output, does not come here: there a link is replaced and never
//! followed ([`Location::write`]).

use std::fs::Metadata;
use std::io::{Error, ErrorKind, Result};
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use self::target::{Target, target, what_is};
pub(crate) use self::target::{write, write_rows};
use super::registry;
use crate::store::objects::Location;
use crate::store::objects::replace::{folder_of, same_file};

mod target;

/// How deep a folder of inputs is searched: a diagnosis has its models in a folder per motorcycle.
const DEPTH: usize = 3;

/// Why a path is not written.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// The path is the wrong one; the sentence says which option and what to do.
    #[error("{0}")]
    Wrong(String),
    /// Nothing can be written there.
    #[error("{0}")]
    Cannot(String),
}

/// The paths of one command that it writes at the user's word.
#[derive(Debug, Default)]
pub(crate) struct Outputs {
    /// Folders of tables, the command's own: what they hold may not be there yet.
    tables: Vec<PathBuf>,
    files: Vec<Given>,
}

/// A file that an option names.
#[derive(Debug)]
struct Given {
    /// The option with its value, for messages.
    named: String,
    option: String,
    /// Links followed; none of what is no file.
    place: Option<Location>,
    there: Option<Metadata>,
}

impl Outputs {
    /// A folder with tables of the command: no other path may lie among them.
    pub(crate) fn tables(&mut self, out: &Location) {
        self.tables.extend(out.absolute().as_path().map(Path::to_owned));
    }

    /// A folder that `option` names; made later, where it is missing.
    ///
    /// # Errors
    /// There is something else, it cannot be made or not be written to, or it lies among tables.
    pub(crate) fn folder(
        &mut self,
        option: &str,
        at: &Location,
    ) -> std::result::Result<(), Refusal> {
        let Some(path) = at.as_path() else { return Ok(()) };
        let named = format!("{option} {at}");
        let wrong = |what: &str| Refusal::Wrong(format!("{named} {what}; a folder is needed"));
        match std::fs::metadata(path) {
            Ok(there) if there.is_dir() => {}
            Ok(there) => return Err(wrong(&format!("is {}", what_is(&there)))),
            Err(e) if e.kind() == ErrorKind::NotFound => {
                if let Ok(to) = std::fs::read_link(path) {
                    return Err(wrong(&format!(
                        "is a link to {}, which is not there",
                        to.display()
                    )));
                }
            }
            Err(e) => return Err(cannot(&named, &e)),
        }
        self.refuse_own(&named, path)?;
        try_folder(path).map_err(|e| cannot(&named, &e))
    }

    /// A file that `option` names.
    ///
    /// # Errors
    /// It cannot be written, is what no file can be, lies among tables, or is that of another option.
    pub(crate) fn file(&mut self, option: &str, at: &Location) -> std::result::Result<(), Refusal> {
        let named = format!("{option} {at}");
        let (place, there) = match at.as_path() {
            None => (Some(at.clone()), None),
            Some(path) => match target(path) {
                Ok(Target::File(place, there)) => {
                    self.refuse_own(&named, &place)?;
                    let tried = match there {
                        // one that is write-protected is meant to stay
                        Some(_) => std::fs::File::options().write(true).open(&place).map(drop),
                        None => Ok(()),
                    };
                    tried
                        .and_then(|()| try_folder(folder_of(&place)))
                        .map_err(|e| cannot(&named, &e))?;
                    (Some(Location::Local(place).absolute()), there)
                }
                Ok(Target::Stream | Target::Printed(_)) => (None, None),
                Err(e) if e.kind() == ErrorKind::InvalidInput => {
                    return Err(Refusal::Wrong(format!("{named} {e}")));
                }
                Err(e) => return Err(cannot(&named, &e)),
            },
        };
        let given = Given { named, option: option.to_owned(), place, there };
        if let Some(other) = self.files.iter().find(|other| other.is_same(&given)) {
            let both = format!("{} and {} are one file", other.named, given.named);
            return Err(Refusal::Wrong(format!("{both}; give each its own")));
        }
        self.files.push(given);
        Ok(())
    }

    /// Holds the files against what the command reads; of a folder, against the TOML files in it.
    ///
    /// # Errors
    /// One of them is an input.
    pub(crate) fn apart_from<'a>(
        &self,
        inputs: impl IntoIterator<Item = &'a Location>,
    ) -> std::result::Result<(), Refusal> {
        // most nights there is nothing to hold against anything
        let local = self.files.iter().any(|f| f.there.is_some());
        let remote: Vec<&Given> = self
            .files
            .iter()
            .filter(|f| f.place.as_ref().is_some_and(Location::is_remote))
            .collect();
        for input in inputs {
            match input.as_path() {
                None => {
                    if let Some(given) = remote.iter().find(|f| f.place.as_ref() == Some(input)) {
                        return Err(given.is_input(input));
                    }
                }
                Some(path) if local => self.apart_from_path(path)?,
                Some(_) => {}
            }
        }
        Ok(())
    }

    /// [`Outputs::apart_from`] of local paths; names that are no paths, as of what is built in, are none of a file.
    ///
    /// # Errors
    /// One of them is an input.
    pub(crate) fn apart_from_files(
        &self,
        inputs: impl IntoIterator<Item = impl AsRef<Path>>,
    ) -> std::result::Result<(), Refusal> {
        if !self.files.iter().any(|f| f.there.is_some()) {
            return Ok(());
        }
        inputs.into_iter().try_for_each(|input| self.apart_from_path(input.as_ref()))
    }

    fn apart_from_path(&self, input: &Path) -> std::result::Result<(), Refusal> {
        let Ok(meta) = std::fs::metadata(input) else { return Ok(()) };
        if !meta.is_dir() {
            return self.apart_from_file(input, &meta);
        }
        let walk = WalkDir::new(input).max_depth(DEPTH).follow_links(true).into_iter();
        let toml = |e: &walkdir::DirEntry| e.path().extension().is_some_and(|e| e == "toml");
        for entry in walk.filter_map(std::result::Result::ok).filter(toml) {
            if let Ok(meta) = std::fs::metadata(entry.path()) {
                self.apart_from_file(entry.path(), &meta)?;
            }
        }
        Ok(())
    }

    fn apart_from_file(&self, input: &Path, meta: &Metadata) -> std::result::Result<(), Refusal> {
        let is_it = |f: &&Given| f.is_there(input, meta);
        self.files.iter().find(is_it).map_or(Ok(()), |f| Err(f.is_input(&input.into())))
    }

    /// Refuses what lies where an output has its own files.
    fn refuse_own(&self, named: &str, path: &Path) -> std::result::Result<(), Refusal> {
        let place = Location::from(path).absolute();
        let Some(place) = place.as_path() else { return Ok(()) };
        for out in place.ancestors().skip(1) {
            if !self.tables.iter().any(|own| own == out) && !is_output(out) {
                continue;
            }
            let first = place.strip_prefix(out).ok().and_then(|below| below.iter().next());
            let first = first.unwrap_or_default().to_string_lossy();
            // bike files may stand beside the table of motorcycles
            let may_be = first == registry::BIKES.name
                && place.extension().is_none_or(|ending| ending != "parquet");
            let is_own = registry::folders().chain([registry::OWN]).any(|own| own == first)
                || registry::OTHER_FILES.contains(&first.as_ref());
            if is_own && !may_be {
                let out = out.display();
                return Err(Refusal::Wrong(format!(
                    "{named} lies where the output {out} has its own files ({first}); choose another place"
                )));
            }
        }
        Ok(())
    }
}

impl Given {
    fn is_input(&self, input: &Location) -> Refusal {
        let is = format!("{} is an input of this command ({input})", self.named);
        Refusal::Wrong(format!("{is} and would be overwritten; choose another {}", self.option))
    }

    fn is_same(&self, other: &Given) -> bool {
        let place = self.place.as_ref().filter(|place| other.place.as_ref() == Some(*place));
        let one = |a: &Option<Metadata>, b: &Option<Metadata>| match (a, b) {
            (Some(a), Some(b)) => cfg!(unix) && same_file(a, b),
            _ => false,
        };
        place.is_some() || one(&self.there, &other.there)
    }

    /// Whether it is that file.
    fn is_there(&self, input: &Path, meta: &Metadata) -> bool {
        let Some(there) = &self.there else { return false };
        match cfg!(unix) {
            true => same_file(there, meta),
            false => {
                let own = self.place.as_ref().and_then(Location::as_path);
                own.and_then(|own| own.canonicalize().ok()) == input.canonicalize().ok()
            }
        }
    }
}

/// Whether a folder is what `run` or `diagnose` wrote.
pub(crate) fn is_output(folder: &Path) -> bool {
    [registry::LOCK, registry::OWN].iter().any(|mark| folder.join(mark).exists())
}

fn cannot(named: &str, e: &Error) -> Refusal {
    Refusal::Cannot(format!("cannot write to {named}: {e}"))
}

/// Whether files can be made in a folder, or in the one that is there of those above it; nothing stays.
fn try_folder(folder: &Path) -> Result<()> {
    let there = folder.ancestors().find(|f| f.symlink_metadata().is_ok());
    // of a relative path the last ancestor is empty: the folder that one is in
    let there = there.filter(|f| *f != Path::new("")).unwrap_or(Path::new("."));
    if !std::fs::metadata(there)?.is_dir() {
        let what = format!("{} is no folder", there.display());
        return Err(Error::new(ErrorKind::NotADirectory, what));
    }
    tempfile::tempfile_in(there).map(drop)
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;

    fn at(folder: &tempfile::TempDir, name: &str) -> Location {
        folder.path().join(name).into()
    }

    fn put(folder: &tempfile::TempDir, name: &str) {
        at(folder, name).write(b"x").expect(name);
    }

    #[test]
    fn an_output_keeps_its_own_places_and_no_others() {
        let folder = tempfile::tempdir().expect("folder");
        put(&folder, "out/.roadbench.lock");
        put(&folder, "no output/sessions/a");
        let mut outputs = Outputs::default();
        outputs.tables(&at(&folder, "new"));
        symlink(folder.path().join("out"), folder.path().join("link")).expect("link");
        symlink(folder.path().join("out/run.json"), folder.path().join("to run")).expect("link");
        for own in [
            "out/sessions/x",
            "out/report/index.html",
            "out/.roadbench/x",
            "out/run.json",
            "link/bench.csv",
            "to run",
            "out/bikes/bikes.parquet",
            "new/coefficients/bike=a/x.parquet",
            "new/.roadbench.lock",
        ] {
            let wrong = outputs.file("--o", &at(&folder, own)).expect_err(own).to_string();
            assert!(wrong.contains("own files"), "{own}: {wrong}");
        }
        outputs.folder("--o", &at(&folder, "out/sessions")).expect_err("a folder of tables");
        for other in
            ["out/x.md", "out/bikes/b.toml", "no output/sessions/a", "new/x", "out/other/x"]
        {
            outputs.file("--o", &at(&folder, other)).expect(other);
        }
        for other in ["out", "out/figures", "out/bikes"] {
            outputs.folder("--o", &at(&folder, other)).expect(other);
        }
    }

    #[test]
    fn an_input_is_one_by_any_name() {
        let folder = tempfile::tempdir().expect("folder");
        put(&folder, "bikes/b.toml");
        put(&folder, "bikes/notes.md");
        std::fs::hard_link(folder.path().join("bikes/b.toml"), folder.path().join("hard"))
            .expect("link");
        symlink("bikes/b.toml", folder.path().join("soft")).expect("link");
        for (name, is_input) in [
            ("bikes/b.toml", true),
            ("bikes/../bikes/b.toml", true),
            ("hard", true),
            ("soft", true),
            ("bikes/notes.md", false),
            ("bikes/new.toml", false),
        ] {
            let mut outputs = Outputs::default();
            outputs.file("--o", &at(&folder, name)).expect(name);
            let folder_of_bikes = outputs.apart_from([&at(&folder, "bikes")]);
            let file = outputs.apart_from([&at(&folder, "bikes/b.toml")]);
            assert_eq!((folder_of_bikes.is_err(), file.is_err()), (is_input, is_input), "{name}");
        }
        let remote = |text: &str| Location::parse(text).expect(text);
        let mut outputs = Outputs::default();
        outputs.file("--out", &remote("s3://b/ride.csv")).expect("an object");
        outputs.apart_from([&remote("s3://b/ride.csv")]).expect_err("its own log");
        outputs.apart_from([&remote("s3://b/other.csv")]).expect("another");
    }

    #[test]
    fn two_options_have_a_file_each() {
        let folder = tempfile::tempdir().expect("folder");
        put(&folder, "there");
        std::fs::hard_link(folder.path().join("there"), folder.path().join("hard")).expect("link");
        for (a, b) in [("new", "./new"), ("there", "hard")] {
            let mut outputs = Outputs::default();
            outputs.file("--a", &at(&folder, a)).expect(a);
            let wrong = outputs.file("--b", &at(&folder, b)).expect_err(b).to_string();
            assert!(wrong.contains("--a") && wrong.contains("--b"), "{wrong}");
        }
        let mut outputs = Outputs::default();
        for option in ["--a", "--b"] {
            outputs
                .file(option, &Location::from(Path::new("/dev/null")))
                .expect("a device takes all");
        }
    }
}
