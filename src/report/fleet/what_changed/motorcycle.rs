//! What changed on one motorcycle: the list, the numbers that moved over the rides, and those that did not.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use crate::contract::coefficient::Coefficient;
use crate::report::diagnosis::sessions::Diagnosed;
use crate::report::error::Error;
use crate::report::fleet::tables::Histories;
use crate::report::fleet::what_changed::entries::{Entry, Shown, entries};
use crate::report::fleet::what_changed::evidence::Quantity;
use crate::report::fleet::what_changed::numbers::{
    self, Estimates, Numbers, Series, of_coefficient, of_estimates,
};
use crate::report::fleet::what_changed::rides::{self, Rides};
use crate::report::fleet::what_changed::timeline::{Mark, TimeLine, draw};
use crate::report::inline_svg;
use crate::statistics::number_format::{decimals, fixed, typeset};
use crate::statistics::order::median_of_finite;
use crate::store::tables::changes::head;
use crate::store::tables::rows::{ChangeRow, EventRow, FleetRow, SessionRow};

/// Most numbers of a motorcycle that are drawn, and of each change.
const DRAWN: [usize; 2] = [18, 3];

/// All tables that these are made from.
pub(crate) struct Sources<'a> {
    /// The table `changes`, by motorcycle.
    changes: BTreeMap<&'a str, Vec<ChangeRow>>,
    /// The table `fleet_events`, by motorcycle.
    events: BTreeMap<&'a str, Vec<EventRow>>,
    /// The table `fleet`: units.
    fleet: &'a [FleetRow],
    /// The table `fleet_pooled`.
    histories: &'a Histories,
    /// Sessions that the histories count.
    sessions: &'a [SessionRow],
    /// By motorcycle.
    rides: BTreeMap<String, Rides>,
    estimates: Estimates,
}

#[derive(Debug, Serialize)]
pub(crate) struct Motorcycle {
    pub bike_id: String,
    /// File name of its page, once it has one.
    pub page: String,
    /// Number of rides that are as before; empty where rides are not compared.
    pub head: String,
    /// Changes, in order of time.
    pub entries: Vec<Shown>,
    /// The largest size over its standard error of each entry.
    #[serde(skip)]
    pub strengths: Vec<f64>,
}

#[derive(Debug, Serialize)]
pub(crate) struct Lines {
    /// The numbers that moved, over the rides.
    pub moved: Vec<TimeLine>,
    pub others: Vec<Usual>,
}

/// A number that did not move.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // parts of the line in the template
pub(crate) struct Usual {
    pub title: String,
    pub key: String,
    pub source: &'static str,
    pub value: String,
    pub unit: String,
    pub strip: String,
}

impl<'a> Sources<'a> {
    /// Reads the rides and their numbers.
    ///
    /// # Errors
    /// A file cannot be read or lacks a column.
    pub(crate) fn read(
        out: &Path,
        (sessions, pages): (&'a [SessionRow], &[String]),
        diagnosed: &'a Diagnosed,
        (fleet, events, histories): (&'a [FleetRow], &'a [EventRow], &'a Histories),
    ) -> Result<Self, Error> {
        let changes = diagnosed.changes();
        let rides = rides::read(out, sessions, pages, changes, |ident| diagnosed.page_of(ident))?;
        let estimates = numbers::estimates(out, &rides)?;
        let (mut by_changes, mut by_events) = (BTreeMap::new(), BTreeMap::new());
        for row in changes {
            let own: &mut Vec<ChangeRow> =
                by_changes.entry(row.ident.bike_id.as_str()).or_default();
            own.push(row.clone());
        }
        for row in events {
            let own: &mut Vec<EventRow> = by_events.entry(row.bike_id.as_str()).or_default();
            own.push(row.clone());
        }
        let (changes, events) = (by_changes, by_events);
        Ok(Sources { changes, events, fleet, histories, sessions, rides, estimates })
    }

    /// The motorcycles of which something can be said, in order of their ids: rides are compared, or an event is known.
    pub(crate) fn motorcycles(&self) -> Vec<Motorcycle> {
        let of = |bike: &String| {
            let head = head(of_bike(&self.changes, bike)).unwrap_or_default();
            let own = self.entries(bike);
            let rides = self.rides.get(bike)?;
            (!head.is_empty() || !own.is_empty()).then(|| Motorcycle {
                bike_id: bike.clone(),
                page: String::new(),
                head,
                entries: own.iter().map(|e| e.shown(rides)).collect(),
                strengths: own.iter().map(Entry::strength).collect(),
            })
        };
        self.rides.keys().filter_map(of).collect()
    }

    fn entries(&self, bike: &str) -> Vec<Entry> {
        let Some(rides) = self.rides.get(bike) else { return Vec::new() };
        entries(of_bike(&self.changes, bike), of_bike(&self.events, bike), rides)
    }

    /// The numbers of a motorcycle: those that moved, each drawn with the changes that moved it, and the others.
    pub(crate) fn lines(&self, bike: &str) -> Lines {
        let mut lines = Lines { moved: Vec::new(), others: Vec::new() };
        let Some(rides) = self.rides.get(bike) else { return lines };
        let mut wanted: Vec<(Quantity, Vec<Mark>)> = Vec::new();
        for evidence in self.entries(bike).iter().flat_map(|e| &e.evidence) {
            for (i, quantity) in evidence.quantities.iter().enumerate() {
                let mark = Mark {
                    members: evidence.members.clone(),
                    is_drift: evidence.row.rides == "drift",
                    label: evidence.label.clone(),
                };
                match wanted.iter_mut().find(|(known, _)| known == quantity) {
                    Some((_, marks)) => marks.push(mark),
                    None if i < DRAWN[1] => wanted.push((quantity.clone(), vec![mark])),
                    None => {}
                }
            }
        }
        wanted.truncate(DRAWN[0]);
        let none = BTreeMap::new();
        let own = self.estimates.get(bike).unwrap_or(&none);
        for (quantity, marks) in &wanted {
            let series = self.series(bike, quantity, own, rides);
            lines.moved.extend(series.and_then(|series| draw(&series, rides, marks)));
        }
        let is_drawn =
            |name: &str| wanted.iter().any(|(q, _)| matches!(q, Quantity::Number(n) if n == name));
        let others = own.iter().filter(|(name, _)| !is_drawn(name));
        lines.others = others.map(|(name, numbers)| usual(of_estimates(name, numbers))).collect();
        // effects have keys for names, and come last
        lines.others.sort_by_key(|o| o.source != "nominal model");
        lines
    }

    fn series(
        &self,
        bike: &str,
        quantity: &Quantity,
        own: &BTreeMap<String, Numbers>,
        rides: &Rides,
    ) -> Option<Series> {
        match quantity {
            Quantity::Number(name) => own.get(name).map(|numbers| of_estimates(name, numbers)),
            Quantity::Coefficient { tyre, name } => {
                let key = (bike.to_owned(), tyre.clone(), name.clone());
                let is_it =
                    |r: &&FleetRow| r.bike_id == bike && r.tyre == *tyre && r.coefficient == *name;
                let row = self.fleet.iter().find(is_it);
                // a coefficient that no session determines has no row
                let unit: &str = match (row, Coefficient::from_name(name)) {
                    (Some(row), _) => &row.unit,
                    (None, Some(known)) => known.spec().unit,
                    (None, None) => "1",
                };
                let history = self.histories.get(&key)?;
                Some(of_coefficient([tyre, name, unit], history, self.sessions, rides))
            }
        }
    }
}

fn of_bike<'a, R>(rows: &'a BTreeMap<&str, Vec<R>>, bike: &str) -> &'a [R] {
    rows.get(bike).map_or(&[], Vec::as_slice)
}

fn usual(series: Series) -> Usual {
    let values: Vec<f64> = series.points.iter().map(|p| p.value).collect();
    let halves: Vec<f64> = series.points.iter().map(|p| (p.ends[1] - p.ends[0]) / 2.0).collect();
    let middle = median_of_finite(&values).unwrap_or(f64::NAN);
    let digits = decimals(median_of_finite(&halves).unwrap_or(f64::NAN));
    let estimates: Vec<inline_svg::Estimate> =
        series.points.iter().map(|p| (p.value, p.ends[0], p.ends[1])).collect();
    Usual {
        title: series.title,
        key: series.key,
        source: series.source,
        value: typeset(&fixed(middle, digits)),
        unit: series.unit,
        strip: inline_svg::strip(&estimates, middle),
    }
}
