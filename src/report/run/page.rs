//! The content of the run's page: counts, each bike's tyres over its sessions, what was rejected
//! and why.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use crate::report::number_format::{self, fixed, typeset};
use crate::report::tables::RunTables;
use crate::report::{diagnosis, inline_svg, labels};
use crate::statistics::order::median_of_finite;
use crate::tables::rows::{Coefficient, FleetRow, Rejected, SessionRow, Status, WarningRow};

/// The run's page, as its template reads it.
#[derive(Debug, Serialize)]
pub struct Page {
    /// Number of inputs, used and rejected.
    pub inputs: usize,
    /// The line that sums it up.
    pub verdict: String,
    /// Sum of durations and distances.
    pub ridden: String,
    /// One per bike, by its id.
    pub bikes: Vec<BikePart>,
    /// One per session, by bike and id.
    pub sessions: Vec<Entry>,
    /// Whether there is a page of the fleet, and how many events it tells of.
    pub fleet: Option<usize>,
    /// Each diagnosed session.
    pub diagnoses: Vec<diagnosis::outcome::Entry>,
    /// Each rejected input.
    pub rejected: Vec<Rejected>,
    /// Warnings by code: stage, code, sessions, occurrences, one message.
    pub warnings: Vec<(String, String, usize, i64, String)>,
    /// Versions that wrote the rows.
    pub versions: String,
}

/// One bike's coefficients over its sessions.
#[derive(Debug, Serialize)]
pub struct BikePart {
    /// Id of the bike, as in the tables.
    pub bike_id: String,
    /// How many sessions.
    pub sessions: usize,
    /// Whether the table `fleet` says more than the medians.
    pub fleet: bool,
    /// Front, rear and vehicle, as far as there are coefficients.
    pub tyres: Vec<TyrePart>,
}

/// One tyre of a bike.
#[derive(Debug, Serialize)]
pub struct TyrePart {
    /// Heading over the tyre's coefficients.
    pub title: String,
    /// Tyre models ridden.
    pub models: String,
    /// Its coefficients.
    pub rows: Vec<Overview>,
}

/// One coefficient over a bike's sessions.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Overview {
    pub label: String,
    pub name: String,
    pub unit: String,
    pub median: String,
    pub spread: String,
    pub within: String,
    pub between: String,
    pub drift: String,
    pub determined: usize,
    pub of: usize,
    pub strip: String,
    pub note: String,
    pub flagged: String,
}

/// One session in the list.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Entry {
    pub href: String,
    pub session_id: String,
    pub bike_id: String,
    pub start: String,
    pub duration: String,
    pub distance: String,
    pub determined: usize,
    pub of: usize,
    pub used: i64,
    pub manoeuvres: i64,
    pub warnings: usize,
}

/// The content of the page but for fleet and diagnoses. `pages` are the sessions' pages, in the
/// sessions' order.
pub fn build(
    tables: &RunTables,
    pages: &[String],
    rejected: Vec<Rejected>,
    fleet: &[FleetRow],
) -> Page {
    let RunTables { sessions, coefficients, warnings } = tables;
    let mut versions: BTreeSet<&str> =
        sessions.iter().map(|s| s.provenance.version.as_str()).collect();
    versions.extend(rejected.iter().map(|r| r.version.as_str()));
    let inputs = sessions.len() + rejected.len();
    let duration: f64 = sessions.iter().map(|s| s.duration).filter(|d| d.is_finite()).sum();
    let distance: f64 = sessions.iter().filter_map(|s| s.distance).sum();
    let bikes: BTreeSet<&str> = sessions.iter().map(|s| s.ident.bike_id.as_str()).collect();
    Page {
        inputs,
        verdict: format!(
            "{} of {} processed; {} rejected; {}.",
            sessions.len(),
            number_format::count(inputs, "session"),
            rejected.len(),
            number_format::count(warnings.len(), "warning")
        ),
        ridden: format!(
            "{}, {} ridden, {:.1} km.",
            number_format::count(bikes.len(), "bike"),
            number_format::duration(duration),
            distance / 1000.0
        ),
        bikes: bikes.iter().map(|b| bike(b, sessions, coefficients, fleet)).collect(),
        sessions: entries(sessions, pages, coefficients, warnings),
        fleet: None,
        diagnoses: Vec::new(),
        warnings: summed(warnings),
        versions: versions.into_iter().collect::<Vec<_>>().join(", "),
        rejected,
    }
}

fn bike(
    bike_id: &str,
    sessions: &[SessionRow],
    coefficients: &[Coefficient],
    fleet: &[FleetRow],
) -> BikePart {
    let own: Vec<&SessionRow> = sessions.iter().filter(|s| s.ident.bike_id == bike_id).collect();
    // rows come by session; by coefficient here, each still in the sessions' order
    let mut by: BTreeMap<_, Vec<&Coefficient>> = BTreeMap::new();
    for c in coefficients.iter().filter(|c| c.ident.bike_id == bike_id) {
        by.entry(labels::order(&c.tyre, &c.coefficient)).or_default().push(c);
    }
    let mut tyres: Vec<TyrePart> = Vec::new();
    let mut current = "";
    for rows in by.values_mut() {
        // time order, where the sessions know their time
        rows.sort_by(|a, b| {
            (&a.ident.start_time, &a.ident.session_id)
                .cmp(&(&b.ident.start_time, &b.ident.session_id))
        });
        let first = rows[0];
        if first.tyre != current {
            current = &first.tyre;
            let models: BTreeSet<&str> = own
                .iter()
                .filter_map(|s| match current {
                    "front" => s.tyre_front.as_deref(),
                    "rear" => s.tyre_rear.as_deref(),
                    _ => None,
                })
                .collect();
            tyres.push(TyrePart {
                title: labels::tyre(current).to_owned(),
                models: models.into_iter().collect::<Vec<_>>().join(", "),
                rows: Vec::new(),
            });
        }
        let known = fleet.iter().find(|f| {
            f.bike_id == bike_id && f.tyre == first.tyre && f.coefficient == first.coefficient
        });
        if let Some(tyre) = tyres.last_mut() {
            tyre.rows.push(overview(rows, known));
        }
    }
    let fleet = fleet.iter().any(|f| f.bike_id == bike_id);
    BikePart { bike_id: bike_id.to_owned(), sessions: own.len(), fleet, tyres }
}

fn overview(rows: &[&Coefficient], fleet: Option<&FleetRow>) -> Overview {
    let first = rows[0];
    let good: Vec<&&Coefficient> = rows.iter().filter(|c| c.status == Status::Ok).collect();
    let values: Vec<f64> = good.iter().filter_map(|c| c.value).collect();
    let errors: Vec<f64> = good.iter().filter_map(|c| c.std_error).collect();
    let median = fleet.and_then(|f| f.median).or_else(|| median_of_finite(&values));
    let spread = fleet.and_then(|f| f.robust_sd).or_else(|| number_format::robust_sd(&values));
    let within = median_of_finite(&errors);
    let digits = median.map_or(3, |m| {
        // two sessions may agree by chance: the wider of the two says what the digits mean
        let u = spread.unwrap_or(0.0).max(within.unwrap_or(0.0));
        number_format::decimals_of(m, Some(u))
    });
    let show = |v: Option<f64>| v.map(|v| typeset(&fixed(v, digits))).unwrap_or_default();
    let estimates: Vec<inline_svg::Estimate> = good
        .iter()
        .filter_map(|c| {
            let value = c.value?;
            Some((value, c.ci95_low.unwrap_or(value), c.ci95_high.unwrap_or(value)))
        })
        .collect();
    Overview {
        label: labels::coefficient(&first.coefficient).to_owned(),
        name: first.coefficient.clone(),
        unit: labels::unit(&first.unit),
        median: show(median),
        spread: show(spread),
        within: show(within),
        between: show(fleet.and_then(|f| f.between_sd)),
        drift: fleet
            .and_then(|f| f.drift_per_day)
            .map(|d| typeset(&fixed(d, number_format::decimals_of(d, None).min(digits + 2))))
            .unwrap_or_default(),
        determined: good.len(),
        of: rows.len(),
        strip: inline_svg::strip(&estimates, median.unwrap_or(f64::NAN)),
        note: if good.is_empty() { undetermined(rows) } else { String::new() },
        flagged: fleet.and_then(|f| f.flagged_sessions.clone()).unwrap_or_default(),
    }
}

/// Why a coefficient has no median: assumed, or the first reason given.
fn undetermined(rows: &[&Coefficient]) -> String {
    let assumed = rows.iter().find(|c| c.status == Status::Assumed);
    if let Some((c, value)) = assumed.and_then(|c| Some((c, c.value?))) {
        let value = typeset(&fixed(value, number_format::decimals_of(value, None)));
        return format!("assumed {value} {}", labels::unit(&c.unit)).trim_end().to_owned();
    }
    match rows.iter().find_map(|c| c.reason.as_deref()) {
        Some(reason) => format!("{}: {reason}", rows[0].status.words()),
        None => rows[0].status.words().to_owned(),
    }
}

fn entries(
    sessions: &[SessionRow],
    pages: &[String],
    coefficients: &[Coefficient],
    warnings: &[WarningRow],
) -> Vec<Entry> {
    let mut determined: BTreeMap<(&str, &str), (usize, usize)> = BTreeMap::new();
    for c in coefficients {
        let entry = determined.entry(c.ident.key()).or_default();
        entry.0 += usize::from(c.status == Status::Ok);
        entry.1 += 1;
    }
    let mut noticed: BTreeMap<(&str, &str), usize> = BTreeMap::new();
    for w in warnings {
        *noticed.entry(w.ident.key()).or_default() += 1;
    }
    sessions
        .iter()
        .zip(pages)
        .map(|(s, href)| {
            let key = s.ident.key();
            let (ok, of) = determined.get(&key).copied().unwrap_or_default();
            Entry {
                href: href.clone(),
                session_id: s.ident.session_id.clone(),
                bike_id: s.ident.bike_id.clone(),
                start: s
                    .ident
                    .start_time
                    .as_deref()
                    .map(number_format::timestamp)
                    .unwrap_or_default(),
                duration: number_format::duration(s.duration),
                distance: s.distance.map(|d| format!("{:.1}", d / 1000.0)).unwrap_or_default(),
                determined: ok,
                of,
                used: s.n_used,
                manoeuvres: s.n_manoeuvres,
                warnings: noticed.get(&key).copied().unwrap_or_default(),
            }
        })
        .collect()
}

fn summed(warnings: &[WarningRow]) -> Vec<(String, String, usize, i64, String)> {
    let mut by: BTreeMap<(&str, &str), Vec<&WarningRow>> = BTreeMap::new();
    for w in warnings {
        by.entry((&w.stage, &w.code)).or_default().push(w);
    }
    by.into_iter()
        .map(|((stage, code), rows)| {
            let sessions: BTreeSet<_> = rows.iter().map(|w| w.ident.key()).collect();
            let count = rows.iter().map(|w| w.count).sum();
            let example = rows[0].message.clone();
            (stage.to_owned(), code.to_owned(), sessions.len(), count, example)
        })
        .collect()
}
