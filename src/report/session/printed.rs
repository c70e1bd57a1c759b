//! One session as the terminal says it: the same after a run over a single log and when `roadbench show` reads it back.

use std::path::Path;

use super::{forces, lap_trends, laps};
use crate::report::error::Error;
use crate::report::terminal;
use crate::store::tables::by_session::SessionFiles;
use crate::store::tables::rows::{
    Coefficient, ForceRow, Ident, LapRow, LapTrendRow, Manoeuvre, SessionRow, WarningRow,
};

/// The tables that it is read from.
pub(crate) const TABLES: &[&str] =
    &["sessions", "coefficients", "warnings", "laps", "lap_trends", "forces", "manoeuvres"];

/// Text about a session, as the tables have it.
#[derive(Debug)]
pub(crate) struct Printed<'a> {
    pub session: &'a SessionRow,
    pub coefficients: &'a [Coefficient],
    pub warnings: &'a [WarningRow],
    /// Its laps; none off a track.
    pub laps: &'a [LapRow],
    /// Trends of the tyres over the laps.
    pub trends: &'a [LapTrendRow],
    /// Missing keys of the bike file, as sentences; no table has them.
    pub costs: &'a [String],
    /// Its forces off the road.
    pub forces: &'a [ForceRow],
    pub manoeuvres: &'a [Manoeuvre],
}

impl Printed<'_> {
    /// The text, in lines of at most `width` characters, 80 or more.
    pub(crate) fn text(&self, width: usize) -> String {
        let mut out = terminal::summary(self.session, self.coefficients, self.warnings, width);
        let laps = laps::terminal(self.laps) + &lap_trends::terminal(self.trends);
        out += &terminal::wrapped(&laps, width);
        out += &terminal::costs(self.costs, width);
        out += &forces::terminal(self.forces, self.manoeuvres);
        out
    }
}

/// The rows of one session, read back.
#[derive(Debug)]
pub(crate) struct Stored {
    pub session: SessionRow,
    pub coefficients: Vec<Coefficient>,
    pub warnings: Vec<WarningRow>,
    laps: Vec<LapRow>,
    trends: Vec<LapTrendRow>,
    forces: Vec<ForceRow>,
    manoeuvres: Vec<Manoeuvre>,
}

impl Stored {
    /// Reads a session of an output.
    ///
    /// # Errors
    /// A table cannot be read or lacks a column, or the table `sessions` has no row of it.
    pub(crate) fn read(out: &Path, ident: &Ident) -> Result<Self, Error> {
        let missing = || Error::NoSession(format!("no session `{}`", ident.session_id));
        let sessions = SessionFiles::<SessionRow>::read_one(out, ident)?.rows(ident)?;
        Ok(Stored {
            session: sessions.into_iter().next().ok_or_else(missing)?,
            coefficients: SessionFiles::read_one(out, ident)?.rows(ident)?,
            warnings: SessionFiles::read_one(out, ident)?.rows(ident)?,
            laps: SessionFiles::read_one(out, ident)?.rows(ident)?,
            trends: SessionFiles::read_one(out, ident)?.rows(ident)?,
            forces: SessionFiles::read_one(out, ident)?.rows(ident)?,
            manoeuvres: SessionFiles::read_one(out, ident)?.rows(ident)?,
        })
    }

    pub(crate) fn printed(&self) -> Printed<'_> {
        Printed {
            session: &self.session,
            coefficients: &self.coefficients,
            warnings: &self.warnings,
            laps: &self.laps,
            trends: &self.trends,
            costs: &[],
            forces: &self.forces,
            manoeuvres: &self.manoeuvres,
        }
    }
}
