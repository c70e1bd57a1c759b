//! Reading a table session by session: the rows of every manoeuvre of a large archive would not fit
//! in memory.

use std::collections::BTreeMap;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;

use super::names::file_name;
use super::read::{self, Columns, Error};
use super::registry::Row;
use super::rows::Ident;

/// The columns that tell whose a row is.
const NAMES: [&str; 2] = ["session_id", "bike_id"];

/// Which files of the table of `R` hold which session.
#[derive(Debug)]
pub struct SessionFiles<R> {
    /// By bike and session.
    files: BTreeMap<(String, String), Vec<PathBuf>>,
    row: PhantomData<fn() -> R>,
}

impl<R> Default for SessionFiles<R> {
    fn default() -> Self {
        SessionFiles { files: BTreeMap::new(), row: PhantomData }
    }
}

impl<R: Row + DeserializeOwned> SessionFiles<R> {
    /// Looks through the table's files below an output folder; only the names of bikes and sessions
    /// are read.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub fn read(out: &Path) -> Result<Self, Error> {
        Self::of(read::files(out, R::spec())?)
    }

    /// As [`SessionFiles::read`], but where a batch wrote this one session by its own, only that file
    /// is looked at.
    ///
    /// # Errors
    /// As [`SessionFiles::read`].
    pub fn read_one(out: &Path, session: &Ident) -> Result<Self, Error> {
        let (bike, id) = session.key();
        let folder = out.join(R::spec().name).join(format!("bike={bike}"));
        let own = folder.join(format!("{}.parquet", file_name(id)));
        let found = if own.is_file() { Self::of(vec![own])? } else { Self::default() };
        match found.files.is_empty() {
            false => Ok(found),
            true => Self::read(out),
        }
    }

    fn of(paths: Vec<PathBuf>) -> Result<Self, Error> {
        let mut index: BTreeMap<(String, String), Vec<PathBuf>> = BTreeMap::new();
        for path in paths {
            for batch in read::batches(&path, Some(&NAMES))? {
                let columns = Columns::new(&path, R::spec(), &batch, &NAMES)?;
                let mut previous = None;
                for i in 0..batch.num_rows() {
                    let key = (columns.text("bike_id", i), columns.text("session_id", i));
                    // a session's rows follow one another: ask the map only when the name changes
                    if previous == Some(key) {
                        continue;
                    }
                    previous = Some(key);
                    let files = index.entry((key.0.to_owned(), key.1.to_owned())).or_default();
                    if files.last() != Some(&path) {
                        files.push(path.clone());
                    }
                }
            }
        }
        Ok(SessionFiles { files: index, row: PhantomData })
    }

    /// Bike and session of each, in their order.
    pub fn keys(&self) -> impl Iterator<Item = (&str, &str)> {
        self.files.keys().map(|(bike, session)| (bike.as_str(), session.as_str()))
    }

    /// One session's rows, in file order; none where no file holds the session.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub fn rows(&self, session: &Ident) -> Result<Vec<R>, Error> {
        let (bike, id) = session.key();
        let mut rows = Vec::new();
        for path in self.files.get(&(bike.to_owned(), id.to_owned())).into_iter().flatten() {
            rows.extend(read::rows_where(path, |columns, i| {
                columns.text("session_id", i) == id && columns.text("bike_id", i) == bike
            })?);
        }
        Ok(rows)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tables::file;
    use crate::tables::rows::Manoeuvre;

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
    }
}
