//! Comparisons of the bikes: one coefficient's values by bike and tyre model.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::report::fleet::tables::FleetTables;
use crate::report::{inline_svg, labels};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::statistics::order::median_of_finite;
use crate::store::tables::rows::FleetRow;

/// One coefficient over the bikes.
#[derive(Debug, Serialize)]
pub(crate) struct Compared {
    /// Name of the coefficient.
    pub label: String,
    /// Name in the tables.
    pub name: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Ends of the common axis.
    pub axis: (String, String),
    /// Whether it is unfolded.
    pub open: bool,
    /// A line per bike and tyre model.
    pub rows: Vec<Row>,
    /// Bikes that were left out.
    pub left: usize,
}

/// Bikes up to which every comparison is unfolded and has lines of each.
pub(crate) const ALL: usize = 12;
/// Of more bikes so many have.
const MAX_BIKES: usize = 8;

/// One bike, or one of its tyre models.
#[derive(Debug, Default, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Row {
    pub bike: String,
    pub model: String,
    pub sessions: usize,
    pub median: String,
    pub spread: String,
    pub drawing: String,
    pub between: String,
    pub drift: String,
    pub drifts: bool,
    pub shrinkage: String,
    pub flags: i64,
}

/// One coefficient's values by bike, for a figure of its own.
#[derive(Debug)]
pub(crate) struct Boxes {
    /// Tyre and coefficient, as in the tables.
    pub name: String,
    /// Tyre and coefficient, as people read them.
    pub title: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Bikes with their values.
    pub groups: Vec<(String, Vec<f64>)>,
}

/// Every coefficient of every tyre with the bikes' values.
pub(crate) fn boxes(fleet: &FleetTables<'_>) -> Vec<Boxes> {
    fleet
        .coefficients()
        .into_iter()
        .map(|rows| Boxes {
            name: format!("{}_{}", rows[0].tyre, rows[0].coefficient),
            title: format!(
                "{} · {}",
                labels::tyre(&rows[0].tyre),
                labels::coefficient(&rows[0].coefficient)
            ),
            unit: labels::unit(&rows[0].unit),
            groups: rows
                .iter()
                .flat_map(|row| {
                    let named = |model: String| match model.is_empty() {
                        true => row.bike_id.clone(),
                        false => format!("{} {model}", row.bike_id),
                    };
                    let by = by_model(fleet, row);
                    let several = by.len() > 1;
                    by.into_iter()
                        .map(move |(m, v)| (named(if several { m } else { String::new() }), v))
                })
                .collect(),
        })
        .collect()
}

/// Sorted values by tyre model.
type ByModel = Vec<(String, Vec<f64>)>;

/// A bike's values by the tyre model that was on.
fn by_model(fleet: &FleetTables<'_>, row: &FleetRow) -> ByModel {
    let mut by: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    let estimates = fleet.history(&row.bike_id, &row.tyre, &row.coefficient);
    for estimate in estimates.iter().filter(|s| s.determined) {
        let session = &fleet.sessions[estimate.session as usize];
        let model = match row.tyre.as_str() {
            "front" => session.tyre_front.clone(),
            "rear" => session.tyre_rear.clone(),
            _ => None,
        };
        by.entry(model.unwrap_or_default()).or_default().push(f64::from(estimate.value));
    }
    by.values_mut().for_each(|v| v.sort_by(f64::total_cmp));
    by.into_iter().collect()
}

/// Every coefficient by tyre; unfolded if `open`.
pub(crate) fn by_tyre(fleet: &FleetTables<'_>, open: bool) -> Vec<(String, Vec<Compared>)> {
    let mut out: Vec<(String, Vec<Compared>)> = Vec::new();
    for rows in &fleet.coefficients() {
        let title = labels::tyre(&rows[0].tyre);
        if out.last().is_none_or(|(t, _)| t != title) {
            out.push((title.to_owned(), Vec::new()));
        }
        if let Some((_, list)) = out.last_mut() {
            list.push(coefficient(fleet, rows, open));
        }
    }
    out
}

/// One coefficient: the bikes' boxes over a common axis.
fn coefficient(fleet: &FleetTables<'_>, rows: &[&FleetRow], open: bool) -> Compared {
    let parts: Vec<(&FleetRow, ByModel)> =
        rows.iter().map(|row| (*row, by_model(fleet, row))).collect();
    let (low, high) = inline_svg::common_axis(
        parts.iter().flat_map(|(_, by)| by.iter().map(|(_, values)| values.as_slice())),
    );
    let digits = number_format::decimals_of(high, Some((high - low) / 20.0));
    let axis = Scale { low, high, digits };
    let shown = notable(&parts);
    let left = parts.len() - shown.len();
    let lines = shown.into_iter().flat_map(|(bike, by)| {
        by.iter().enumerate().map(|(i, (model, values))| {
            let row = row(&axis, model, values);
            // what is known of the bike stands in its first line
            if i == 0 { with_bike(row, fleet, bike, &axis) } else { row }
        })
    });
    Compared {
        label: labels::coefficient(&rows[0].coefficient).to_owned(),
        name: rows[0].coefficient.clone(),
        unit: labels::unit(&rows[0].unit),
        axis: (typeset(&fixed(low, digits)), typeset(&fixed(high, digits))),
        open,
        rows: lines.collect(),
        left,
    }
}

/// Of many bikes those with events or outlying sessions, then those farthest from the others; in their
/// order.
fn notable<'a, 'b>(parts: &'b [(&'a FleetRow, ByModel)]) -> Vec<&'b (&'a FleetRow, ByModel)> {
    if parts.len() <= ALL {
        return parts.iter().collect();
    }
    let medians: Vec<f64> = parts.iter().filter_map(|(row, _)| row.median).collect();
    let centre = median_of_finite(&medians).unwrap_or(0.0);
    let rank = |row: &FleetRow| {
        let away = row.median.map_or(0.0, |m| (m - centre).abs());
        (row.n_events.max(row.n_flagged), away)
    };
    let mut places: Vec<usize> = (0..parts.len()).collect();
    places.sort_by(|a, b| {
        let (a, b) = (rank(parts[*a].0), rank(parts[*b].0));
        b.0.cmp(&a.0).then(b.1.total_cmp(&a.1))
    });
    places.truncate(MAX_BIKES);
    places.sort_unstable();
    places.into_iter().map(|i| &parts[i]).collect()
}

/// The common axis of one coefficient's boxes, and the decimals of its numbers.
struct Scale {
    low: f64,
    high: f64,
    digits: usize,
}

impl Scale {
    fn show(&self, value: Option<f64>) -> String {
        value.map(|v| typeset(&fixed(v, self.digits))).unwrap_or_default()
    }
}

/// The line of one tyre model.
fn row(axis: &Scale, model: &str, values: &[f64]) -> Row {
    Row {
        model: model.to_owned(),
        sessions: values.len(),
        median: axis.show(median_of_finite(values)),
        spread: axis.show(number_format::robust_sd(values)),
        drawing: inline_svg::boxes(values, axis.low, axis.high),
        ..Row::default()
    }
}

/// The same with what is known of the bike, over its tyre models.
fn with_bike(line: Row, fleet: &FleetTables<'_>, bike: &FleetRow, axis: &Scale) -> Row {
    let estimates = fleet.history(&bike.bike_id, &bike.tyre, &bike.coefficient);
    let shrinkage: Vec<f64> = estimates.iter().map(|s| f64::from(s.shrinkage)).collect();
    let shrinkage = median_of_finite(&shrinkage);
    let drift = bike.drift_settled_per_day.or(bike.drift_per_day);
    let ends = bike.drift_ci95_low.zip(bike.drift_ci95_high);
    Row {
        bike: bike.bike_id.clone(),
        between: axis.show(bike.between_sd_settled.or(bike.between_sd)),
        drift: drift_text(drift, ends),
        drifts: ends.is_some_and(|(l, h)| l > 0.0 || h < 0.0),
        shrinkage: shrinkage.map(|s| format!("{} %", fixed(100.0 * s, 0))).unwrap_or_default(),
        flags: bike.n_events.max(bike.n_flagged),
        ..line
    }
}

/// A drift per 100 days with its interval: per day its digits would be too small to read.
fn drift_text(drift: Option<f64>, ends: Option<(f64, f64)>) -> String {
    let Some(drift) = drift else { return String::new() };
    let digits =
        number_format::decimals_of(100.0 * drift, ends.map(|(l, h)| 100.0 * (h - l) / 2.0)).min(8);
    let show = |v: f64| typeset(&fixed(100.0 * v, digits));
    match ends {
        Some((low, high)) => format!("{} ({} to {})", show(drift), show(low), show(high)),
        None => show(drift),
    }
}
