//! Each ride's numbers: of the table `estimates`, and of the coefficients over all sessions.

use std::collections::BTreeMap;
use std::path::Path;

use crate::report::error::Error;
use crate::report::fleet::tables::SessionEstimate;
use crate::report::fleet::what_changed::evidence::{Quantity, words};
use crate::report::fleet::what_changed::rides::Rides;
use crate::report::{labels, parameter_words, readable};
use crate::store::tables::read;
use crate::store::tables::registry::Row;
use crate::store::tables::rows::{EstimateRow, SessionRow};

/// Half of a 95 % interval in standard errors.
const WIDE: f64 = 1.96;

/// One ride's number. In single precision: a fleet has millions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Estimate {
    /// The ride's place among the motorcycle's rides.
    ride: u32,
    value: f32,
    error: f32,
}

/// The numbers of one name of a motorcycle's rides.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Numbers {
    unit: String,
    is_effect: bool,
    estimates: Vec<Estimate>,
}

/// By motorcycle and name.
pub(crate) type Estimates = BTreeMap<String, BTreeMap<String, Numbers>>;

/// One ride's value with its interval, as people read it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// The ride's place among the motorcycle's rides.
    pub ride: usize,
    pub value: f64,
    /// Ends of its 95 % interval.
    pub ends: [f64; 2],
    /// Whether the ride determines it.
    pub is_determined: bool,
}

/// A number over the rides.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Series {
    /// Description, in words.
    pub title: String,
    /// Key in the tables.
    pub key: String,
    /// Unit, as people read it; empty for a pure number.
    pub unit: String,
    /// Where it is from.
    pub source: &'static str,
    /// The rides that know it, in order of time.
    pub points: Vec<Point>,
}

/// The table `estimates` of motorcycles whose rides are known.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn estimates(out: &Path, bikes: &BTreeMap<String, Rides>) -> Result<Estimates, Error> {
    let mut places: BTreeMap<(&str, &str), u32> = BTreeMap::new();
    for (bike, rides) in bikes {
        for (i, ride) in rides.rides.iter().enumerate() {
            places.insert((bike, &ride.ident.session_id), i as u32);
        }
    }
    let mut all = Estimates::new();
    for path in read::files(out, EstimateRow::spec())? {
        // one file is held at a time
        for row in read::file_rows::<EstimateRow>(&path)? {
            let Some(ride) = places.get(&row.ident.key()).copied() else { continue };
            if !(row.value.is_finite() && row.std_error > 0.0 && row.std_error.is_finite()) {
                continue;
            }
            let estimate = Estimate { ride, value: row.value as f32, error: row.std_error as f32 };
            let numbers =
                all.entry(row.ident.bike_id).or_default().entry(row.parameter).or_insert(Numbers {
                    unit: row.unit,
                    is_effect: row.part == "effect",
                    estimates: Vec::new(),
                });
            numbers.estimates.push(estimate);
        }
    }
    for numbers in all.values_mut().flat_map(BTreeMap::values_mut) {
        numbers.estimates.sort_by_key(|e| e.ride);
    }
    Ok(all)
}

/// A number of the table `estimates` over the rides.
pub(crate) fn of_estimates(name: &str, numbers: &Numbers) -> Series {
    let (unit, factor) = match numbers.is_effect {
        true => readable::unit(name, &numbers.unit),
        false => readable::unit("", &numbers.unit),
    };
    let is_logarithm = !numbers.is_effect && parameter_words::is_logarithm(name);
    let point = |e: &Estimate| {
        let (value, half) = (f64::from(e.value), WIDE * f64::from(e.error));
        let read = |x: f64| if is_logarithm { (-x).exp() } else { x * factor };
        let ends = [read(value - half), read(value + half)];
        Point {
            ride: e.ride as usize,
            value: read(value),
            ends: [ends[0].min(ends[1]), ends[0].max(ends[1])],
            is_determined: true,
        }
    };
    Series {
        title: title(&Quantity::Number(name.to_owned())),
        key: name.to_owned(),
        unit: if is_logarithm { "1/rad".to_owned() } else { unit.trim().to_owned() },
        source: if numbers.is_effect { "size of the effect alone" } else { "nominal model" },
        points: numbers.estimates.iter().map(point).collect(),
    }
}

/// A coefficient over the rides. `sessions` are those that the estimates count.
pub(crate) fn of_coefficient(
    [tyre, name, unit]: [&str; 3],
    estimates: &[SessionEstimate],
    sessions: &[SessionRow],
    rides: &Rides,
) -> Series {
    let quantity = Quantity::Coefficient { tyre: tyre.to_owned(), name: name.to_owned() };
    let (unit, factor) = readable::unit("", unit);
    let point = |e: &SessionEstimate| {
        let ride = rides.place(&sessions.get(e.session as usize)?.ident.session_id)?;
        let usual = [e.value - 1.96 * e.error, e.value + 1.96 * e.error];
        // tables of an older version have no ends
        let ends = if e.ends[0].is_finite() { e.ends } else { usual };
        Some(Point {
            ride,
            value: f64::from(e.value) * factor,
            ends: ends.map(|end| f64::from(end) * factor),
            is_determined: e.determined,
        })
    };
    let mut points: Vec<Point> = estimates.iter().filter_map(point).collect();
    points.sort_by_key(|p| p.ride);
    Series {
        title: title(&quantity),
        key: format!("{tyre} {name}"),
        unit: labels::unit(unit.trim()),
        source: "coefficient",
        points,
    }
}

/// A quantity as a heading.
fn title(quantity: &Quantity) -> String {
    let words = words(quantity);
    let words = words.strip_prefix("the ").unwrap_or(&words);
    let mut letters = words.chars();
    letters.next().map(|c| c.to_uppercase().chain(letters).collect()).unwrap_or_default()
}
