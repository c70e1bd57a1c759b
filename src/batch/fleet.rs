//! The fleet's table: how each coefficient of a bike spreads over its sessions.
//!
//! Assumes the sessions' tables of one output folder, of this run and of earlier ones. Only
//! committed sessions take part, and of them the rows with status `ok`; the poorly determined are
//! pooled but help no other. Polars scans, filters and groups the coefficients and takes their
//! quantiles; what it has no word for is in [`dispersion`] and [`crate::fleet`].
//!
//! The rows are sorted before anything is computed, so the same sessions give the same bytes.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use polars::prelude::*;

use super::contents::Contents;
use super::dispersion;
use super::error::Error;
use super::fleet_rows::{Units, complete, event_rows, pooled_rows, ratio_rows};
use super::{kind, tyres};
use crate::contract::status::Status;
use crate::fleet::{Observation, common};
use crate::tables::registry::Row;
use crate::tables::rows::{FleetRow, SessionRow};
use crate::tables::{file, read};

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
    let fail = |e: PolarsError| Error::Output(format!("cannot aggregate the fleet: {e}"));
    let there = Contents::read(&kind::RUN, &out.into())?;
    let paths = paths(out, &there).map_err(fail)?;
    let mut rows = Vec::new();
    let (mut pooled, mut events, mut ratios) = (Vec::new(), Vec::new(), Vec::new());
    let (mut of_tyres, mut of_bikes) = (Vec::new(), Vec::new());
    if !paths.is_empty() {
        let frame = scan(paths).map_err(fail)?;
        rows = aggregate(&frame).and_then(|frame| unpack(&frame)).map_err(fail)?;
        let (mut observations, units) = observations(&frame).map_err(fail)?;
        place(out, &mut observations);
        let bikes = crate::fleet::analyse(&observations);
        complete(&mut rows, &bikes);
        pooled = bikes.iter().flat_map(|bike| pooled_rows(bike, &units)).collect();
        events = bikes.iter().flat_map(event_rows).collect();
        ratios = bikes.iter().flat_map(ratio_rows).collect();
        (of_tyres, of_bikes) = tyres::rows(out, &there, &bikes)?;
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
    Ok(file::write(&path, rows)?)
}

/// The coefficient tables of the committed sessions.
fn paths(out: &Path, there: &Contents) -> PolarsResult<Vec<PlRefPath>> {
    let files: BTreeSet<PathBuf> = there
        .sessions()
        .map(|session| {
            let folder = out.join("coefficients").join(format!("bike={}", session.bike_id));
            folder.join(format!("{}.parquet", session.part))
        })
        .collect();
    let files = files.iter().filter(|path| path.is_file());
    files.map(|path| PlRefPath::try_from_path(path)).collect()
}

const KEYS: [&str; 4] = ["bike_id", "tyre", "coefficient", "unit"];

/// Every row with a finite value that is estimated, in order of key and session.
fn scan(paths: Vec<PlRefPath>) -> PolarsResult<DataFrame> {
    let arguments = ScanArgsParquet {
        glob: false, // the names are files, whatever characters they hold
        hive_options: polars::io::HiveOptions::new_disabled(),
        ..ScanArgsParquet::default()
    };
    let is = |status: Status| col("status").eq(lit(status.name()));
    let estimated = is(Status::Ok).or(is(Status::PoorlyDetermined));
    let columns = KEYS.iter().chain(&["session_id", "start_time", "value", "std_error", "status"]);
    let text = |name: &str| col(name).cast(DataType::String);
    // days since 1970, as a number
    let day = col("start_time").cast(DataType::Int64).cast(DataType::Float64) / lit(86_400e6);
    LazyFrame::scan_parquet_sources(ScanSources::Paths(paths.into_iter().collect()), arguments)?
        .with_columns([text("session_id"), text("bike_id"), day.alias("start_time")])
        .filter(estimated.and(col("value").is_finite()))
        .select(columns.map(|name| col(*name)).collect::<Vec<_>>())
        .sort(KEYS.iter().chain(&["session_id"]).copied().collect::<Vec<_>>(), Default::default())
        .collect()
}

/// One row per bike, tyre and coefficient: quantiles, and the sessions' figures as lists.
fn aggregate(frame: &DataFrame) -> PolarsResult<DataFrame> {
    let value = || col("value");
    frame
        .clone()
        .lazy()
        .filter(col("status").eq(lit(Status::Ok.name())))
        .group_by_stable(KEYS.map(col))
        .agg([
            value().median().alias("median"),
            value().quantile(lit(0.25), QuantileMethod::Linear).alias("quartile_1"),
            value().quantile(lit(0.75), QuantileMethod::Linear).alias("quartile_3"),
            col("session_id"),
            col("start_time"),
            value(),
            col("std_error"),
        ])
        .collect()
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

fn unpack(frame: &DataFrame) -> PolarsResult<Vec<FleetRow>> {
    let texts = |name: &str| frame.column(name)?.str();
    let numbers = |name: &str| frame.column(name)?.f64();
    let lists = |name: &str| frame.column(name)?.list();
    let (bike_id, tyre) = (texts("bike_id")?, texts("tyre")?);
    let (coefficient, unit) = (texts("coefficient")?, texts("unit")?);
    let (median, q1, q3) = (numbers("median")?, numbers("quartile_1")?, numbers("quartile_3")?);
    let (ids, starts) = (lists("session_id")?, lists("start_time")?);
    let (values, errors) = (lists("value")?, lists("std_error")?);
    let mut rows = Vec::with_capacity(frame.height());
    for i in 0..frame.height() {
        let text = |column: &StringChunked| column.get(i).unwrap_or_default().to_owned();
        let group = |column: &ListChunked| {
            column.get_as_series(i).ok_or_else(|| polars_err!(ComputeError: "empty group"))
        };
        let (ids, starts) = (group(ids)?, group(starts)?);
        let (values, errors) = (group(values)?, group(errors)?);
        let sessions = Sessions {
            ids: ids.str()?.iter().map(Option::unwrap_or_default).collect(),
            days: starts.f64()?.iter().collect(),
            values: values.f64()?.iter().map(|x| x.unwrap_or(f64::NAN)).collect(),
            errors: errors.f64()?.iter().map(|x| x.unwrap_or(f64::NAN)).collect(),
        };
        rows.push(FleetRow {
            bike_id: text(bike_id),
            tyre: text(tyre),
            coefficient: text(coefficient),
            unit: text(unit),
            median: median.get(i),
            quartile_1: q1.get(i),
            quartile_3: q3.get(i),
            ..sessions.row(median.get(i))
        });
    }
    Ok(rows)
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
            drift_per_day: dispersion::theil_sen(&when, &what),
            n_flagged: flagged.len() as i64,
            flagged_sessions: (!flagged.is_empty()).then(|| flagged.join(", ")),
            ..FleetRow::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
