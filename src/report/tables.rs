//! The tables of a run, read back in the order of the report.

use std::path::Path;

use crate::report::as_read;
use crate::report::error::Error;
use crate::report::labels;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::read;
use crate::store::tables::rows::{
    Coefficient, ForceRow, Ident, LapCornerRow, LapPointRow, LapRow, LapTrendRow, Manoeuvre,
    PlotPoint, Rejected, SessionRow, TyreParameters, WarningRow,
};

/// Tables of which one at least makes a folder an output.
const OUTPUT_TABLES: [&str; 4] = ["sessions", "rejected", "causes", "discrepancies"];

/// Whether a folder is an output.
///
/// # Errors
/// [`Error::NotAnOutput`]: it holds none of the tables that a run or a diagnosis writes.
pub(crate) fn check(out: &Path) -> Result<(), Error> {
    match OUTPUT_TABLES.iter().any(|table| out.join(table).is_dir()) {
        true => Ok(()),
        false => Err(Error::NotAnOutput { path: out.to_owned() }),
    }
}

/// Every `sessions` row, by bike and session.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn sessions(out: &Path) -> Result<Vec<SessionRow>, Error> {
    let mut rows: Vec<SessionRow> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// Every `coefficients` row: by bike and session, then in the contract's order.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn coefficients(out: &Path) -> Result<Vec<Coefficient>, Error> {
    let mut rows: Vec<Coefficient> = read::rows(out)?;
    sort_coefficients(&mut rows);
    Ok(rows)
}

fn sort_coefficients(rows: &mut [Coefficient]) {
    rows.sort_by(|a, b| {
        let place = |c: &Coefficient| labels::order(&c.tyre, &c.coefficient);
        a.ident.key().cmp(&b.ident.key()).then_with(|| place(a).cmp(&place(b)))
    });
}

/// Every `forces` row, by bike, session and manoeuvre, then as the estimate wrote them; none where
/// nothing was ridden off-road.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn forces(out: &Path) -> Result<Vec<ForceRow>, Error> {
    let mut rows: Vec<ForceRow> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// Every `warnings` row, by bike and session, then as the stages wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn warnings(out: &Path) -> Result<Vec<WarningRow>, Error> {
    let mut rows: Vec<WarningRow> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

fn parameters(out: &Path) -> Result<Vec<TyreParameters>, Error> {
    let mut rows: Vec<TyreParameters> = read::rows(out)?;
    rows.sort_by(|a, b| a.ident.key().cmp(&b.ident.key()));
    Ok(rows)
}

/// Every `rejected` row, by path.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn rejected(out: &Path) -> Result<Vec<Rejected>, Error> {
    let mut rows: Vec<Rejected> = read::rows(out)?;
    rows.sort_by(|a, b| (&a.path, &a.code).cmp(&(&b.path, &b.code)));
    Ok(rows)
}

/// The tables that are read session by session; by default of no session.
#[derive(Debug, Default)]
pub(crate) struct SessionTables {
    manoeuvres: SessionFiles<Manoeuvre>,
    plots: SessionFiles<PlotPoint>,
    laps: SessionFiles<LapRow>,
    lap_corners: SessionFiles<LapCornerRow>,
    lap_points: SessionFiles<LapPointRow>,
    lap_trends: SessionFiles<LapTrendRow>,
}

impl SessionTables {
    /// Looks through the files of an output folder.
    ///
    /// # Errors
    /// A file cannot be read.
    pub(crate) fn read(out: &Path) -> Result<Self, Error> {
        Ok(SessionTables {
            manoeuvres: SessionFiles::read(out)?,
            plots: SessionFiles::read(out)?,
            laps: SessionFiles::read(out)?,
            lap_corners: SessionFiles::read(out)?,
            lap_points: SessionFiles::read(out)?,
            lap_trends: SessionFiles::read(out)?,
        })
    }

    /// As [`SessionTables::read`], for one session.
    ///
    /// # Errors
    /// A file cannot be read.
    pub(crate) fn read_one(out: &Path, session: &Ident) -> Result<Self, Error> {
        Ok(SessionTables {
            manoeuvres: SessionFiles::read_one(out, session)?,
            plots: SessionFiles::read_one(out, session)?,
            laps: SessionFiles::read_one(out, session)?,
            lap_corners: SessionFiles::read_one(out, session)?,
            lap_points: SessionFiles::read_one(out, session)?,
            lap_trends: SessionFiles::read_one(out, session)?,
        })
    }

    /// Number of rows of one session in each table. Their provenance is that of the session: only their absence is
    /// news, as of a table that was damaged when a page was made.
    pub(crate) fn counts(&self, session: &Ident) -> [usize; 6] {
        [
            self.manoeuvres.count(session),
            self.plots.count(session),
            self.laps.count(session),
            self.lap_corners.count(session),
            self.lap_points.count(session),
            self.lap_trends.count(session),
        ]
    }

    /// One session's manoeuvres, by number.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn manoeuvres(&self, session: &Ident) -> Result<Vec<Manoeuvre>, Error> {
        let mut rows = self.manoeuvres.rows(session)?;
        rows.sort_by_key(|m| m.manoeuvre_id);
        Ok(rows)
    }

    /// One session's points of plots, in file order.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn plots(&self, session: &Ident) -> Result<Vec<PlotPoint>, Error> {
        Ok(self.plots.rows(session)?)
    }

    /// One session's laps and their corners; none where it is not on a track.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn laps(&self, session: &Ident) -> Result<(Vec<LapRow>, Vec<LapCornerRow>), Error> {
        Ok((self.laps.rows(session)?, self.lap_corners.rows(session)?))
    }

    /// Trends of the tyres over the laps; none where there are too few.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn lap_trends(&self, session: &Ident) -> Result<Vec<LapTrendRow>, Error> {
        Ok(self.lap_trends.rows(session)?)
    }

    /// Every place of its laps.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn lap_points(&self, session: &Ident) -> Result<Vec<LapPointRow>, Error> {
        Ok(self.lap_points.rows(session)?)
    }
}

/// The tables that the pages of a run are made from.
#[derive(Debug)]
pub(crate) struct RunTables {
    /// By bike and session.
    pub sessions: Vec<SessionRow>,
    /// By bike and session, then in the contract's order.
    pub coefficients: Vec<Coefficient>,
    /// By bike and session.
    pub warnings: Vec<WarningRow>,
    /// By bike and session.
    pub parameters: Vec<TyreParameters>,
}

impl RunTables {
    /// Reads the tables of an output folder.
    ///
    /// # Errors
    /// The folder is no output, or a table cannot be read.
    pub(crate) fn read(out: &Path) -> Result<Self, Error> {
        check(out)?;
        Ok(RunTables {
            sessions: sessions(out)?,
            coefficients: as_read(coefficients(out)?),
            warnings: warnings(out)?,
            parameters: parameters(out)?,
        })
    }

    /// The rows of one session alone.
    ///
    /// # Errors
    /// A table cannot be read.
    pub(crate) fn read_one(out: &Path, session: &Ident) -> Result<Self, Error> {
        let mut coefficients =
            SessionFiles::<Coefficient>::read_one(out, session)?.rows(session)?;
        sort_coefficients(&mut coefficients);
        let coefficients = as_read(coefficients);
        Ok(RunTables {
            sessions: SessionFiles::<SessionRow>::read_one(out, session)?.rows(session)?,
            coefficients,
            warnings: SessionFiles::<WarningRow>::read_one(out, session)?.rows(session)?,
            parameters: SessionFiles::<TyreParameters>::read_one(out, session)?.rows(session)?,
        })
    }

    pub(crate) fn coefficients_of(&self, session: &Ident) -> &[Coefficient] {
        rows_of(&self.coefficients, session, |c| &c.ident)
    }

    /// One session's tyres as the model has them.
    pub(crate) fn parameters_of(&self, session: &Ident) -> &[TyreParameters] {
        rows_of(&self.parameters, session, |p| &p.ident)
    }

    pub(crate) fn warnings_of(&self, session: &Ident) -> &[WarningRow] {
        rows_of(&self.warnings, session, |w| &w.ident)
    }
}

/// Coefficients as pages have them.
fn as_read(mut rows: Vec<Coefficient>) -> Vec<Coefficient> {
    rows.iter_mut().for_each(as_read::coefficient);
    rows
}

/// One session's rows of those sorted by [`Ident::key`].
pub(super) fn rows_of<'a, R>(
    rows: &'a [R],
    session: &Ident,
    ident: impl Fn(&R) -> &Ident,
) -> &'a [R] {
    let start = rows.partition_point(|r| ident(r).key() < session.key());
    let length = rows[start..].partition_point(|r| ident(r).key() == session.key());
    &rows[start..start + length]
}
