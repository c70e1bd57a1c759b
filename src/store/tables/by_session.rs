//! Reading a table session by session: the rows of every manoeuvre of a large archive would not fit
//! in memory.

use std::collections::{BTreeMap, BTreeSet};
use std::marker::PhantomData;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::arrow::arrow_reader::{ArrowReaderMetadata, RowSelection};
use serde::de::DeserializeOwned;

use super::names::file_name;
use super::read::{self, Columns, Error};
use super::registry::Row;
use super::rows::Ident;
use crate::contract::instant;

/// The columns that tell whose a row is.
const NAMES: [&str; 2] = ["session_id", "bike_id"];

/// Which rows of the files of the table of `R` are of which session.
#[derive(Debug)]
pub(crate) struct SessionFiles<R> {
    /// By bike and session.
    places: BTreeMap<(String, String), Vec<Place>>,
    files: Vec<(PathBuf, ArrowReaderMetadata)>,
    row: PhantomData<fn() -> R>,
}

/// A place in [`SessionFiles::files`], and rows of it.
type Place = (usize, Range<usize>);

impl<R> Default for SessionFiles<R> {
    fn default() -> Self {
        SessionFiles { places: BTreeMap::new(), files: Vec::new(), row: PhantomData }
    }
}

impl<R: Row + DeserializeOwned> SessionFiles<R> {
    /// Looks through the table's files below an output folder; only the names of bikes and sessions
    /// are read.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn read(out: &Path) -> Result<Self, Error> {
        Self::of(read::files(out, R::spec())?)
    }

    /// As [`SessionFiles::read`], but only the files of the session's motorcycle are looked at.
    ///
    /// # Errors
    /// As [`SessionFiles::read`].
    pub(crate) fn read_one(out: &Path, session: &Ident) -> Result<Self, Error> {
        let folder = format!("bike={}", session.bike_id);
        let own = file_name(&session.session_id);
        let is_own = |path: &PathBuf| {
            let is_of_bike = path.parent().is_some_and(|p| p.ends_with(&folder));
            is_of_bike || path.file_stem().is_some_and(|stem| *stem == *own)
        };
        Self::of(read::files(out, R::spec())?.into_iter().filter(is_own).collect())
    }

    /// As [`SessionFiles::read`], but only the files of these sessions' motorcycles and months are looked at.
    ///
    /// # Errors
    /// As [`SessionFiles::read`].
    pub(crate) fn read_some(out: &Path, sessions: &[&Ident]) -> Result<Self, Error> {
        // a month of the motorcycle, `undated` there, or a file of the session's own
        let month = |s: &Ident| s.start_time.as_deref().and_then(instant::month);
        let wanted: BTreeSet<(String, String)> = sessions
            .iter()
            .flat_map(|s| {
                let month = month(s).unwrap_or_else(|| "undated".to_owned());
                [month, file_name(&s.session_id)].map(|stem| (format!("bike={}", s.bike_id), stem))
            })
            .collect();
        let is_own = |path: &PathBuf| {
            let folder = path.parent().and_then(Path::file_name);
            let names = folder.zip(path.file_stem());
            names.is_some_and(|(folder, stem)| {
                let names = [folder, stem].map(|n| n.to_string_lossy().into_owned());
                wanted.contains(&names.into())
            })
        };
        Self::of(read::files(out, R::spec())?.into_iter().filter(is_own).collect())
    }

    fn of(paths: Vec<PathBuf>) -> Result<Self, Error> {
        let mut found = Self::default();
        for path in paths {
            let about = read::about(&path)?;
            let mut at = 0;
            let mut previous: Option<(Arc<str>, Arc<str>)> = None;
            let mut from = 0;
            let place = found.files.len();
            for batch in read::selected(&path, &about, Some(&NAMES), None)? {
                let columns = Columns::new(&path, R::spec(), &batch, &NAMES)?;
                for i in 0..batch.num_rows() {
                    let key = (columns.text("bike_id", i), columns.text("session_id", i));
                    // a session's rows follow one another: the map is asked only when the name changes
                    if previous.as_ref().is_some_and(|(bike, id)| (&**bike, &**id) == key) {
                        continue;
                    }
                    found.add(previous.replace((key.0.into(), key.1.into())), place, from..at + i);
                    from = at + i;
                }
                at += batch.num_rows();
            }
            found.add(previous, place, from..at);
            found.files.push((path, about));
        }
        Ok(found)
    }

    fn add(&mut self, key: Option<(Arc<str>, Arc<str>)>, file: usize, rows: Range<usize>) {
        if let Some((bike, id)) = key {
            let key = (bike.to_string(), id.to_string());
            self.places.entry(key).or_default().push((file, rows));
        }
    }

    /// Bike and session of each, in their order.
    pub(crate) fn keys(&self) -> impl Iterator<Item = (&str, &str)> {
        self.places.keys().map(|(bike, session)| (bike.as_str(), session.as_str()))
    }

    /// Number of one session's rows.
    pub(crate) fn count(&self, session: &Ident) -> usize {
        let (bike, id) = session.key();
        let places = self.places.get(&(bike.to_owned(), id.to_owned()));
        places.into_iter().flatten().map(|(_, rows)| rows.len()).sum()
    }

    /// One session's rows, in file order; none where no file holds the session.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn rows(&self, session: &Ident) -> Result<Vec<R>, Error> {
        let (bike, id) = session.key();
        let mut rows = Vec::new();
        for (file, range) in
            self.places.get(&(bike.to_owned(), id.to_owned())).into_iter().flatten()
        {
            let (path, about) = &self.files[*file];
            let total = about.metadata().file_metadata().num_rows() as usize;
            let only = RowSelection::from_consecutive_ranges(std::iter::once(range.clone()), total);
            for batch in read::selected(path, about, None, Some(only))? {
                read::take(path, &batch, &|_, _| true, &mut rows)?;
            }
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::file;
    use crate::store::tables::rows::Manoeuvre;

    #[test]
    fn a_session_is_found_among_others() {
        let out = tempfile::tempdir().expect("folder");
        let ident = |session: &str| Ident {
            session_id: session.into(),
            bike_id: "b".into(),
            start_time: None,
        };
        let of = |session: &str, id| Manoeuvre {
            ident: ident(session),
            manoeuvre_id: id,
            ..Manoeuvre::default()
        };
        let put = |name: &str, rows: &[Manoeuvre]| {
            file::write(out.path().join("manoeuvres").join(name), rows).expect("written");
        };
        put("a.parquet", &[of("s", 1), of("t", 2), of("s", 3)]);
        put("b.parquet", &[of("t", 4)]);
        let files = SessionFiles::<Manoeuvre>::read(out.path()).expect("index");
        let ids = |session: &str| -> Vec<i64> {
            let rows = files.rows(&ident(session)).expect("rows");
            rows.iter().map(|m| m.manoeuvre_id).collect()
        };
        assert_eq!((ids("s"), ids("t"), ids("u")), (vec![1, 3], vec![2, 4], vec![]));
        assert_eq!(["s", "t", "u"].map(|session| files.count(&ident(session))), [2, 2, 0]);
    }
}
