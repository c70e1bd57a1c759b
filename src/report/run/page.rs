//! The content of the run's page: counts, each bike's tyres over its sessions, what was rejected
//! and why.

use std::collections::{BTreeMap, BTreeSet};

use crate::report::answer;
use crate::report::diagnosis;
use crate::report::explorer::pooled::pooled;
use crate::report::run::bikes::{self, BikePart};
use crate::report::tables::RunTables;
use crate::statistics::number_format;
use crate::store::tables::rows::{FleetRow, Rejected, Status, TyreParameters, TyreRow, WarningRow};

#[derive(Debug)]
pub(crate) struct Page {
    /// Number of inputs, used and rejected.
    pub inputs: usize,
    /// The line that sums it up.
    pub verdict: String,
    /// Results of the tyres of all sessions, and missing ones, in sentences.
    pub answer: Vec<String>,
    /// Sum of durations and distances.
    pub ridden: String,
    /// One per bike, by its id.
    pub bikes: Vec<BikePart>,
    /// One per session, by bike and id.
    pub sessions: Vec<Entry>,
    /// Whether there is a page of the fleet, and how many events it tells of.
    pub fleet: Option<usize>,
    /// Whether there is a page of the tyre explorer.
    pub explorer: bool,
    pub diagnoses: Vec<diagnosis::outcome::Entry>,
    pub rejected: Vec<Rejected>,
    /// Warnings by code: stage, code, sessions, occurrences, one message.
    pub warnings: Vec<(String, String, usize, i64, String)>,
    /// Versions that wrote the rows.
    pub versions: String,
}

/// One session in the list.
#[derive(Debug)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Entry {
    /// Name of its page; empty where it is to have none.
    pub page: String,
    /// Whether that has been written.
    pub there: bool,
    pub session_id: String,
    pub bike_id: String,
    pub start: String,
    pub duration: String,
    pub seconds: f64,
    pub distance: String,
    pub determined: usize,
    pub of: usize,
    pub used: i64,
    pub manoeuvres: i64,
    pub warnings: usize,
}

/// The content of the page but for fleet and diagnoses. `pages` are the sessions' pages, in the
/// sessions' order.
pub(crate) fn build(
    tables: &RunTables,
    pages: &[String],
    rejected: Vec<Rejected>,
    fleet: &[FleetRow],
    all_rides: &[TyreRow],
) -> Page {
    let RunTables { sessions, warnings, .. } = tables;
    let mut versions: BTreeSet<&str> =
        sessions.iter().map(|s| s.provenance.version.as_str()).collect();
    versions.extend(rejected.iter().map(|r| r.version.as_str()));
    let inputs = sessions.len() + rejected.len();
    let duration: f64 = sessions.iter().map(|s| s.duration).filter(|d| d.is_finite()).sum();
    let distance: f64 = sessions.iter().filter_map(|s| s.distance).sum();
    let bikes: BTreeSet<&str> = sessions.iter().map(|s| s.ident.bike_id.as_str()).collect();
    let shown: Vec<&TyreParameters> = tables.parameters.iter().collect();
    let over_all = pooled(all_rides, &tables.parameters, &shown);
    Page {
        inputs,
        verdict: format!(
            "{} of {} processed; {} rejected; {}.",
            sessions.len(),
            number_format::count(inputs, "log"),
            rejected.len(),
            number_format::count(warnings.len(), "warning")
        ),
        answer: answer::of_batch(sessions, &tables.coefficients),
        ridden: format!(
            "{}, {} ridden, {:.1} km.",
            number_format::count(bikes.len(), "bike"),
            number_format::duration(duration),
            distance / 1000.0
        ),
        bikes: bikes.iter().map(|b| bikes::part(b, tables, fleet, all_rides, &over_all)).collect(),
        sessions: entries(tables, pages),
        fleet: None,
        explorer: false,
        diagnoses: Vec::new(),
        warnings: summed(warnings),
        versions: versions.into_iter().collect::<Vec<_>>().join(", "),
        rejected,
    }
}

fn entries(tables: &RunTables, pages: &[String]) -> Vec<Entry> {
    tables
        .sessions
        .iter()
        .zip(pages)
        .map(|(s, page)| {
            let coefficients = tables.coefficients_of(&s.ident);
            let start = s.ident.start_time.as_deref();
            Entry {
                page: page.clone(),
                there: !page.is_empty(),
                session_id: s.ident.session_id.clone(),
                bike_id: s.ident.bike_id.clone(),
                start: start.map(number_format::timestamp).unwrap_or_default(),
                duration: number_format::duration(s.duration),
                seconds: s.duration,
                distance: s.distance.map(|d| format!("{:.1}", d / 1000.0)).unwrap_or_default(),
                determined: coefficients.iter().filter(|c| c.status == Status::Ok).count(),
                of: coefficients.len(),
                used: s.n_used,
                manoeuvres: s.n_manoeuvres,
                warnings: tables.warnings_of(&s.ident).len(),
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
