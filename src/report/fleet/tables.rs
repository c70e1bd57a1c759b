//! The tables over all sessions, read back in the order of the report: `fleet`, `fleet_events`,
//! `fleet_ratios`, `fleet_pooled`.

use std::collections::BTreeMap;
use std::path::Path;

use crate::report::as_read;
use crate::report::error::Error;
use crate::report::labels;
use crate::store::tables::read;
use crate::store::tables::registry::Row;
use crate::store::tables::rows::{EventRow, FleetRow, PooledRow, RatioRow, SessionRow, Status};

/// Every `fleet` row, by bike, then in the contract's order.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn fleet(out: &Path) -> Result<Vec<FleetRow>, Error> {
    let mut rows: Vec<FleetRow> = read::rows(out)?;
    rows.iter_mut().for_each(as_read::fleet);
    rows.sort_by(|a, b| {
        (&a.bike_id, labels::order(&a.tyre, &a.coefficient))
            .cmp(&(&b.bike_id, labels::order(&b.tyre, &b.coefficient)))
    });
    Ok(rows)
}

/// Every `fleet_events` row, the one of the largest evidence first.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn events(out: &Path) -> Result<Vec<EventRow>, Error> {
    let mut rows: Vec<EventRow> = read::rows(out)?;
    rows.sort_by(|a, b| {
        b.evidence.abs().total_cmp(&a.evidence.abs()).then_with(|| a.bike_id.cmp(&b.bike_id))
    });
    Ok(rows)
}

/// Every `fleet_ratios` row, by bike, the front first.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn ratios(out: &Path) -> Result<Vec<RatioRow>, Error> {
    let mut rows: Vec<RatioRow> = read::rows(out)?;
    // a stable sort: tyres that followed one another on an axle stay in their order
    rows.sort_by(|a, b| (&a.bike_id, &a.tyre).cmp(&(&b.bike_id, &b.tyre)));
    Ok(rows)
}

/// One session's value of a coefficient, its own estimate and the one pooled with the other sessions
/// of the bike. In single precision: a fleet has hundreds of thousands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SessionEstimate {
    /// Its index in the sessions.
    pub session: u32,
    /// Whether its status is `ok`.
    pub determined: bool,
    pub value: f32,
    /// Standard error of that.
    pub error: f32,
    /// Ends of its own 95 % interval; NaN where there are none.
    pub ends: [f32; 2],
    pub pooled: f32,
    /// Lower end of the pooled estimate's 95 % interval.
    pub low: f32,
    /// Upper end of it.
    pub high: f32,
    /// Weight of the other sessions in the pooled estimate, 0 to 1.
    pub shrinkage: f32,
}

/// Estimates by bike, tyre and coefficient.
pub(crate) type Histories = BTreeMap<(String, String, String), Vec<SessionEstimate>>;

/// The table `fleet_pooled`, compact. Rows of sessions that are not among `sessions`, which are in
/// the order of their [`key`](crate::store::tables::rows::Ident::key), are left out.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub(crate) fn histories(out: &Path, sessions: &[SessionRow]) -> Result<Histories, Error> {
    let places: BTreeMap<(&str, &str), usize> =
        sessions.iter().enumerate().map(|(i, s)| (s.ident.key(), i)).collect();
    let mut found = Histories::new();
    for path in read::files(out, PooledRow::spec())? {
        // one file is held at a time
        for mut row in read::file_rows::<PooledRow>(&path)? {
            as_read::pooled(&mut row);
            let Some(place) = places.get(&(row.bike_id.as_str(), row.session_id.as_str())) else {
                continue;
            };
            let estimate = SessionEstimate {
                session: *place as u32,
                determined: row.status == Status::Ok,
                value: row.value as f32,
                error: row.std_error as f32,
                ends: [row.ci95_low, row.ci95_high].map(|end| end.map_or(f32::NAN, |x| x as f32)),
                pooled: row.pooled as f32,
                low: row.pooled_ci95_low as f32,
                high: row.pooled_ci95_high as f32,
                shrinkage: row.shrinkage as f32,
            };
            found.entry((row.bike_id, row.tyre, row.coefficient)).or_default().push(estimate);
        }
    }
    Ok(found)
}

/// All that the page over all sessions is made from.
#[derive(Debug)]
pub(crate) struct FleetTables<'a> {
    /// By bike and session.
    pub sessions: &'a [SessionRow],
    /// The sessions' pages, in their order; an empty name is none.
    pub pages: &'a [String],
    /// The table `fleet`.
    pub rows: &'a [FleetRow],
    /// The table `fleet_events`.
    pub events: &'a [EventRow],
    /// The table `fleet_pooled`.
    pub histories: &'a Histories,
}

impl FleetTables<'_> {
    /// Index of a session.
    pub(crate) fn place(&self, bike: &str, session: &str) -> Option<usize> {
        self.sessions.binary_search_by(|s| s.ident.key().cmp(&(bike, session))).ok()
    }

    /// Every session's estimate of a coefficient, in the order of the table; empty where none is.
    pub(crate) fn history(&self, bike: &str, tyre: &str, coefficient: &str) -> &[SessionEstimate] {
        let key = (bike.to_owned(), tyre.to_owned(), coefficient.to_owned());
        self.histories.get(&key).map_or(&[], Vec::as_slice)
    }

    /// The rows of each coefficient that some session determined, in the contract's order.
    pub(crate) fn coefficients(&self) -> Vec<Vec<&FleetRow>> {
        let mut names: BTreeMap<_, Vec<&FleetRow>> = BTreeMap::new();
        for row in self.rows.iter().filter(|r| r.n_sessions > 0) {
            names.entry(labels::order(&row.tyre, &row.coefficient)).or_default().push(row);
        }
        names.into_values().collect()
    }
}
