//! The fleet's table: how each coefficient of a bike spreads over its sessions.
//!
//! Assumes the sessions' tables of one output folder, of this run and of earlier ones. Only
//! committed sessions take part, and of them the rows with status `ok`; the poorly determined are
//! pooled but help no other. The tables are read as all others are; polars sorts, filters and groups the
//! coefficients and takes their quantiles (its eager core alone: the lazy engine with its own Parquet reader is
//! 53 crates more). What it has no word for is in [`dispersion`] and [`crate::fleet`].
//!
//! The rows are sorted before anything is computed, so the same sessions give the same bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use polars::prelude::*;
use rayon::prelude::*;

use super::dispersion;
use super::rows::{Own, Owns, Units, complete, event_rows, pooled_rows, ratio_rows};
use super::tyres;
use crate::batch::error::Error;
use crate::batch::store::contents::Contents;
use crate::batch::store::kind;
use crate::contract::status::Status;
use crate::fleet::{Observation, common, drift};
use crate::store::tables::file;
use crate::store::tables::read;
use crate::store::tables::read::Columns;
use crate::store::tables::registry::Row;
use crate::store::tables::rows::{Coefficient, FleetRow, SessionRow};

/// From so many sessions on, one that is far from the others is flagged.
const FLAG_FROM: usize = 5;

/// Farther from the median than so many robust standard deviations is far.
const FAR: f64 = 4.0;

/// A session within so many of its own standard errors is never far.
const OWN: f64 = 2.0;

/// Writes the tables `fleet`, `fleet_pooled`, `fleet_events`, `fleet_ratios`, `tyres` and `bikes` from the coefficients and the
/// evidence in `out`; gives back the rows of the first.
///
/// # Errors
/// A coefficients table cannot be read, or the fleet's not be written.
pub fn write(out: &Path) -> Result<Vec<FleetRow>, Error> {
    let there = Contents::read(&kind::RUN, &out.into())?;
    let paths = paths(out, &there);
    let mut rows = Vec::new();
    let (mut pooled, mut events, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut of_tyres, mut of_bikes) = (Vec::new(), Vec::new());
    if !paths.is_empty() {
        let frame = estimated(&paths)?;
        rows = aggregate(&frame).map_err(fail)?;
        let (mut observations, units) = observations(&frame).map_err(fail)?;
        let own = owns(&frame).map_err(fail)?;
        place(out, &mut observations);
        let bikes = crate::fleet::analyse(&observations);
        complete(&mut rows, &bikes);
        pooled = bikes.iter().flat_map(|bike| pooled_rows(bike, &units, &own)).collect();
        events = bikes.iter().flat_map(event_rows).collect();
        ratios = bikes.iter().flat_map(ratio_rows).collect();
        (of_tyres, of_bikes) = tyres::rows(out, &there, &bikes, &own)?;
    }
    save(out, &rows)?;
    save(out, &pooled)?;
    save(out, &events)?;
    save(out, &ratios)?;
    save(out, &of_tyres)?;
    save(out, &of_bikes)?;
    Ok(rows)
}

fn save<R: Row>(out: &Path, rows: &[R]) -> Result<(), Error> {
    let name = R::spec().name;
    let path = out.join(name).join(format!("{name}.parquet"));
    let newer = std::fs::File::open(&path).ok().and_then(|f| read::newer_schema(R::spec(), f));
    if let Some(schema) = newer {
        return Err(Error::Output(format!(
            "{} was written by a newer roadbench ({schema}); use that one, or choose another --out",
            path.display()
        )));
    }
    Ok(file::write(&path, rows)?)
}

/// The coefficient tables of the committed sessions.
fn paths(out: &Path, there: &Contents) -> BTreeSet<PathBuf> {
    let paths = there.sessions().map(|session| {
        let folder = out.join("coefficients").join(format!("bike={}", session.bike_id));
        folder.join(format!("{}.parquet", session.part))
    });
    paths.filter(|path| path.is_file()).collect()
}

/// The columns that the fleet needs of a coefficient.
const TEXTS: [&str; 6] = ["bike_id", "tyre", "coefficient", "unit", "session_id", "status"];
const NUMBERS: [&str; 3] = ["start_time", "value", "std_error"];
/// The ends of its interval, which tables need not have.
const ENDS: [&str; 2] = ["ci95_low", "ci95_high"];

/// Columns by which sessions are grouped.
const KEYS: [&str; 4] = [TEXTS[0], TEXTS[1], TEXTS[2], TEXTS[3]];

const MICROSECONDS_PER_DAY: f64 = 86_400e6;

/// Every row with a finite value that is estimated, in order of key and session.
fn estimated(paths: &BTreeSet<PathBuf>) -> Result<DataFrame, Error> {
    let paths: Vec<&PathBuf> = paths.iter().collect();
    let parts: Result<Vec<Estimated>, Error> =
        paths.par_iter().map(|path| Estimated::read(path)).collect();
    let mut all = Estimated::default();
    parts?.into_iter().for_each(|part| all.append(part));
    let sorted = all.frame().and_then(|frame| {
        frame.sort(KEYS.iter().chain(&["session_id"]), SortMultipleOptions::default())
    });
    sorted.map_err(fail)
}

fn fail(e: PolarsError) -> Error {
    Error::Output(format!("cannot aggregate the fleet: {e}"))
}

/// Columns of the estimated coefficients.
#[derive(Default)]
struct Estimated {
    /// In the order of [`TEXTS`].
    texts: [Vec<String>; 6],
    /// Days since 1970.
    start_time: Vec<Option<f64>>,
    value: Vec<f64>,
    /// NaN where there is none that is finite.
    std_error: Vec<f64>,
    /// In the order of [`ENDS`]; NaN where there is none.
    ends: [Vec<f64>; 2],
}

impl Estimated {
    /// The schema lets some of these columns be missing; a fleet without one of them would be another fleet.
    fn read(path: &Path) -> Result<Self, Error> {
        let mut all = Self::default();
        let wanted = [&TEXTS[..], &NUMBERS].concat();
        let with_ends = [&wanted[..], &ENDS].concat();
        for batch in read::batches(path, Some(&with_ends))? {
            if let Some(name) = wanted.iter().find(|name| batch.column_by_name(name).is_none()) {
                let message = format!("it has no column `{name}`");
                return Err(read::Error { path: path.to_owned(), message }.into());
            }
            let columns = Columns::new(path, Coefficient::spec(), &batch, &with_ends)?;
            (0..batch.num_rows()).for_each(|i| all.push(&columns, i));
        }
        Ok(all)
    }

    fn push(&mut self, columns: &Columns, i: usize) {
        let value = columns.number("value", i);
        let status = columns.text("status", i);
        let is_estimated =
            [Status::Ok, Status::PoorlyDetermined].iter().any(|s| s.name() == status);
        if !is_estimated || !value.is_finite() {
            return;
        }
        for (column, name) in self.texts.iter_mut().zip(TEXTS) {
            column.push(columns.text(name, i).to_owned());
        }
        let start = columns.instant("start_time", i);
        self.start_time.push(start.map(|micros| micros as f64 / MICROSECONDS_PER_DAY));
        self.value.push(value);
        self.std_error.push(columns.number("std_error", i));
        for (column, name) in self.ends.iter_mut().zip(ENDS) {
            column.push(columns.number(name, i));
        }
    }

    fn append(&mut self, mut other: Self) {
        for (column, more) in self.texts.iter_mut().zip(&mut other.texts) {
            column.append(more);
        }
        self.start_time.append(&mut other.start_time);
        self.value.append(&mut other.value);
        self.std_error.append(&mut other.std_error);
        for (column, more) in self.ends.iter_mut().zip(&mut other.ends) {
            column.append(more);
        }
    }

    fn frame(self) -> PolarsResult<DataFrame> {
        let height = self.value.len();
        let texts = TEXTS.into_iter().zip(self.texts);
        let mut columns: Vec<Column> =
            texts.map(|(name, texts)| Column::new(name.into(), texts)).collect();
        columns.push(Column::new("start_time".into(), self.start_time));
        columns.push(Column::new("value".into(), self.value));
        columns.push(Column::new("std_error".into(), self.std_error));
        let ends = ENDS.into_iter().zip(self.ends);
        columns.extend(ends.map(|(name, ends)| Column::new(name.into(), ends)));
        DataFrame::new(height, columns)
    }
}

/// One row per bike, tyre, coefficient and unit: quantiles, and what the sessions' figures say.
fn aggregate(frame: &DataFrame) -> PolarsResult<Vec<FleetRow>> {
    let determined = frame.column("status")?.str()?.equal(Status::Ok.name());
    let groups = frame.filter(&determined)?.partition_by_stable(KEYS, true)?;
    groups.iter().map(fleet_row).collect()
}

/// The sessions of one motorcycle, tyre and coefficient.
fn fleet_row(group: &DataFrame) -> PolarsResult<FleetRow> {
    let first = |name: &str| -> PolarsResult<String> {
        Ok(group.column(name)?.str()?.get(0).unwrap_or_default().to_owned())
    };
    let numbers = |name: &str| group.column(name)?.f64();
    let value = numbers("value")?;
    let quantile = |q: f64| value.quantile(q, QuantileMethod::Linear);
    let sessions = Sessions {
        ids: group.column("session_id")?.str()?.iter().map(Option::unwrap_or_default).collect(),
        days: numbers("start_time")?.iter().collect(),
        values: value.iter().map(|x| x.unwrap_or(f64::NAN)).collect(),
        errors: numbers("std_error")?.iter().map(|x| x.unwrap_or(f64::NAN)).collect(),
    };
    let median = value.median();
    Ok(FleetRow {
        bike_id: first("bike_id")?,
        tyre: first("tyre")?,
        coefficient: first("coefficient")?,
        unit: first("unit")?,
        median,
        quartile_1: quantile(0.25)?,
        quartile_3: quantile(0.75)?,
        ..sessions.row(median)
    })
}

/// The rows as [`crate::fleet`] takes them, and the units.
fn observations(frame: &DataFrame) -> PolarsResult<(Vec<Observation>, Units)> {
    let texts = |name: &str| frame.column(name)?.str();
    let (bike, tyre, coefficient) = (texts("bike_id")?, texts("tyre")?, texts("coefficient")?);
    let (unit, session) = (texts("unit")?, texts("session_id")?);
    let (start, status) = (frame.column("start_time")?.f64()?, texts("status")?);
    let (value, error) = (frame.column("value")?.f64()?, frame.column("std_error")?.f64()?);
    let mut units = Units::new();
    let mut rows = Vec::with_capacity(frame.height());
    for i in 0..frame.height() {
        let text = |column: &StringChunked| column.get(i).unwrap_or_default().to_owned();
        units.entry((text(tyre), text(coefficient))).or_insert_with(|| text(unit));
        rows.push(Observation {
            bike: text(bike),
            tyre: text(tyre),
            coefficient: text(coefficient),
            session: text(session),
            day: start.get(i),
            value: value.get(i).unwrap_or(f64::NAN),
            error: error.get(i).unwrap_or(f64::NAN),
            determined: status.get(i) == Some(Status::Ok.name()),
            ..Observation::default()
        });
    }
    Ok((rows, units))
}

/// Each session's own value and interval.
fn owns(frame: &DataFrame) -> PolarsResult<Owns> {
    let texts = |name: &str| frame.column(name)?.str();
    let [bike, session] = [texts("bike_id")?, texts("session_id")?];
    let [tyre, coefficient] = [texts("tyre")?, texts("coefficient")?];
    let numbers = |name: &str| frame.column(name)?.f64();
    let [value, error] = [numbers("value")?, numbers("std_error")?];
    let [low, high] = [numbers(ENDS[0])?, numbers(ENDS[1])?];
    let known = |column: &Float64Chunked, i: usize| column.get(i).filter(|x| x.is_finite());
    let of = |i: usize| {
        let text = |column: &StringChunked| column.get(i).unwrap_or_default().to_owned();
        let own = Own {
            value: known(value, i)?,
            std_error: known(error, i)?,
            interval: [known(low, i)?, known(high, i)?],
        };
        Some(([text(bike), text(session), text(tyre), text(coefficient)], own))
    };
    Ok((0..frame.height()).filter_map(of).collect())
}

/// Puts in where each session was ridden, where there are motorcycles enough to have a site in common.
fn place(out: &Path, observations: &mut [Observation]) {
    let bikes: BTreeSet<&str> = observations.iter().map(|o| o.bike.as_str()).collect();
    if bikes.len() < common::BIKES {
        return;
    }
    // tables of an older version may lack the column: then no site is taken out
    let sessions: Vec<SessionRow> = read::rows(out).unwrap_or_default();
    let sites: BTreeMap<(&str, &str), &str> =
        sessions.iter().filter_map(|s| Some((s.ident.key(), s.site.as_deref()?))).collect();
    for o in observations {
        o.site = sites.get(&(o.bike.as_str(), o.session.as_str())).map(|s| (*s).to_owned());
    }
}

/// One coefficient's figures, session by session, in order of session id.
struct Sessions<'a> {
    ids: Vec<&'a str>,
    /// Start, days since 1970.
    days: Vec<Option<f64>>,
    values: Vec<f64>,
    /// Standard error, NaN where there is none.
    errors: Vec<f64>,
}

impl Sessions<'_> {
    /// Everything of a row that is not a key or a quantile.
    fn row(&self, median: Option<f64>) -> FleetRow {
        let robust_sd = median.and_then(|m| dispersion::robust_sd(&self.values, m));
        let (known_values, known_errors): (Vec<f64>, Vec<f64>) = self
            .values
            .iter()
            .zip(&self.errors)
            .filter(|(_, e)| e.is_finite() && **e > 0.0)
            .unzip();
        let (when, what): (Vec<f64>, Vec<f64>) =
            self.days.iter().zip(&self.values).filter_map(|(d, v)| d.map(|d| (d, *v))).unzip();
        let flagged: Vec<&str> = match (median, robust_sd) {
            (Some(median), Some(sd)) if self.values.len() >= FLAG_FROM && sd > 0.0 => {
                let off = self.values.iter().map(|v| (v - median).abs());
                let far = off.zip(&self.errors).map(|(off, error)| {
                    // METHOD: what its own standard error explains is no reason to look at a ride
                    off > FAR * sd && (error.is_nan() || off > OWN * error)
                });
                self.ids.iter().zip(far).filter(|(_, far)| *far).map(|(id, _)| *id).collect()
            }
            _ => Vec::new(),
        };
        FleetRow {
            n_sessions: self.values.len() as i64,
            robust_sd,
            within_sd: dispersion::root_mean_square(&known_errors),
            between_sd: dispersion::between_sd(&known_values, &known_errors),
            drift_per_day: dispersion::theil_sen(&when, &what)
                .filter(|_| drift::spans_enough(when.iter().copied())),
            n_flagged: flagged.len() as i64,
            flagged_sessions: (!flagged.is_empty()).then(|| flagged.join(", ")),
            ..FleetRow::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    use arrow::array::{
        ArrayRef, Float64Array, RecordBatch, StringArray, TimestampMillisecondArray,
    };

    /// A table of one motorcycle's rear slip stiffness, a session per value.
    fn table(folder: &Path, status: &str, start: ArrayRef, values: &[f64]) -> BTreeSet<PathBuf> {
        let n = values.len();
        let texts = |text: &str| -> ArrayRef { Arc::new(StringArray::from(vec![text; n])) };
        let ids: Vec<String> = (0..n).map(|i| format!("s{i}")).collect();
        let columns: [(&str, ArrayRef); 9] = [
            ("bike_id", texts("b1")),
            ("tyre", texts("rear")),
            ("coefficient", texts("slip_stiffness")),
            ("unit", texts("1")),
            ("session_id", Arc::new(StringArray::from(ids))),
            ("status", texts(status)),
            ("start_time", start),
            ("value", Arc::new(Float64Array::from(values.to_vec()))),
            ("std_error", Arc::new(Float64Array::from(vec![0.1; n]))),
        ];
        let batch = RecordBatch::try_from_iter(columns).expect("batch");
        let path = folder.join("2026-05.parquet");
        file::write_batch(path.as_path(), &batch).expect("written");
        BTreeSet::from([path])
    }

    #[test]
    fn start_times_of_any_type_give_their_days() {
        let folder = tempfile::tempdir().expect("folder");
        let milliseconds = TimestampMillisecondArray::from(vec![86_400_000, 129_600_000]);
        let texts = || vec![Some("1970-01-02T00:00:00Z"), Some("1970-01-02T14:00:00+02:00")];
        let kinds: [(ArrayRef, [Option<f64>; 2]); 4] = [
            (Arc::new(StringArray::from(texts())), [Some(1.0), Some(1.5)]),
            (Arc::new(milliseconds.clone()), [Some(1.0), Some(1.5)]),
            (Arc::new(milliseconds.with_timezone("Europe/Rome")), [Some(1.0), Some(1.5)]),
            (Arc::new(StringArray::from(vec![Some("yesterday"), None])), [None, None]),
        ];
        for (start, days) in kinds {
            let kind = start.data_type().clone();
            let paths = table(folder.path(), "ok", start, &[1.0, 3.0]);
            let frame = estimated(&paths).expect("read");
            let (observations, _) = observations(&frame).expect("observations");
            let found: Vec<Option<f64>> = observations.iter().map(|o| o.day).collect();
            assert_eq!(found, days, "{kind}");
            let rows = aggregate(&frame).expect("rows");
            assert_eq!((rows.len(), rows[0].median, rows[0].n_sessions), (1, Some(2.0), 2));
        }
    }

    #[test]
    fn sessions_without_a_determined_coefficient_give_no_rows() {
        let folder = tempfile::tempdir().expect("folder");
        for (status, estimates) in [("poorly_determined", 2), ("not_available", 0)] {
            let start: ArrayRef = Arc::new(StringArray::from(vec![None::<&str>; 2]));
            let frame = estimated(&table(folder.path(), status, start, &[1.0, 2.0])).expect("read");
            assert_eq!(frame.height(), estimates, "{status}");
            assert!(aggregate(&frame).expect("rows").is_empty());
            assert_eq!(observations(&frame).expect("observations").0.len(), estimates);
        }
    }

    #[test]
    fn a_table_without_values_is_named() {
        let folder = tempfile::tempdir().expect("folder");
        let path = folder.path().join("2026-05.parquet");
        let ids: ArrayRef = Arc::new(StringArray::from(vec!["b1"]));
        let batch = RecordBatch::try_from_iter(TEXTS.map(|name| (name, Arc::clone(&ids))));
        file::write_batch(path.as_path(), &batch.expect("batch")).expect("written");
        let words = estimated(&BTreeSet::from([path])).expect_err("no values").to_string();
        assert!(words.contains("2026-05.parquet") && words.contains("start_time"), "{words}");
    }

    #[test]
    fn a_session_is_flagged_when_it_is_far_and_sure_of_it() {
        let flagged = |error: f64, n: usize| {
            let sessions = Sessions {
                ids: ["a", "b", "c", "d", "e", "f"][..n].to_vec(),
                days: vec![None; n],
                values: [1.0, 1.1, 0.9, 2.0, 1.05, 0.95][..n].to_vec(),
                errors: [0.1, 0.1, 0.1, error, 0.1, 0.1][..n].to_vec(),
            };
            sessions.row(Some(1.0)).flagged_sessions
        };
        assert_eq!(flagged(0.1, 6).as_deref(), Some("d"));
        assert_eq!(flagged(f64::NAN, 6).as_deref(), Some("d"), "no error is no excuse");
        assert_eq!(flagged(0.6, 6), None, "its own error explains it");
        assert_eq!(flagged(0.1, 4), None, "too few to tell");
    }
}
