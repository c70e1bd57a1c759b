//! All statistics over the sessions of a fleet, bike by bike.

use std::collections::BTreeMap;

use super::components::{self, Components, Part};
use super::drift::{self, Drift};
use super::events::Event;
use super::history::History;
use super::observation::Observation;
use super::pool::{self, Pooled};
use super::ratio::{self, Ratio};
use super::{changes, levels, threshold};

/// One coefficient of one bike over its sessions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Series {
    /// Spread between sessions, events taken out; with interval.
    pub components: Option<Components>,
    /// Spread between sessions that all bikes share: one figure from all of them.
    pub fleet_sd: Option<f64>,
    /// Slope over time, steps taken out; with interval.
    pub drift: Option<Drift>,
}

/// All statistics of one bike.
#[derive(Debug, Clone)]
pub struct BikeAnalysis {
    /// The bike.
    pub bike: String,
    /// Its sessions and values.
    pub history: History,
    /// What happened to it, the strongest first.
    pub events: Vec<Event>,
    /// Per coefficient, in the order of `history.keys`.
    pub series: Vec<Series>,
    /// Per coefficient and session: pooled values.
    pub pooled: Vec<Vec<Option<Pooled>>>,
    /// Side force ratio of each tyre that was on it.
    pub ratios: Vec<Ratio>,
}

/// All statistics, bike by bike in order of name.
pub fn analyse(observations: &[Observation]) -> Vec<BikeAnalysis> {
    let mut bikes: BTreeMap<&str, Vec<&Observation>> = BTreeMap::new();
    for o in observations {
        bikes.entry(&o.bike).or_default().push(o);
    }
    let mut limits = threshold::Limits::default();
    let mut bikes: Vec<BikeAnalysis> =
        bikes.into_iter().map(|(bike, rows)| analyse_bike(bike, &rows, &mut limits)).collect();
    let fleet = common(&bikes);
    for bike in &mut bikes {
        for (key, series) in bike.history.keys.iter().zip(&mut bike.series) {
            series.fleet_sd = fleet.get(key).copied().flatten();
        }
    }
    bikes
}

/// Per tyre and coefficient the spread between sessions that all bikes share.
fn common(bikes: &[BikeAnalysis]) -> BTreeMap<(String, String), Option<f64>> {
    let mut parts: BTreeMap<&(String, String), Vec<Part<'_>>> = BTreeMap::new();
    for bike in bikes {
        for (c, key) in bike.history.keys.iter().enumerate() {
            parts.entry(key).or_default().push(part(&bike.history, &bike.events, c));
        }
    }
    let solve = |parts: &Vec<Part<'_>>| components::common(&parts.iter().collect::<Vec<_>>());
    parts.iter().map(|(key, parts)| ((*key).clone(), solve(parts))).collect()
}

fn part<'a>(history: &'a History, events: &[Event], c: usize) -> Part<'a> {
    let columns = levels::regressors(history, events, c, true);
    Part { values: &history.values[c], errors: &history.errors[c], columns }
}

fn analyse_bike(bike: &str, rows: &[&Observation], limits: &mut threshold::Limits) -> BikeAnalysis {
    let history = History::new(rows);
    let events = changes::find(&history, limits);
    let mut series = Vec::with_capacity(history.keys.len());
    let mut pooled = Vec::with_capacity(history.keys.len());
    for c in 0..history.keys.len() {
        let part = part(&history, &events, c);
        let steps = levels::regressors(&history, &events, c, false);
        let components = components::between(&part);
        let tau = components.as_ref().map(|k| k.sd);
        let drift = tau.and_then(|tau| drift::slope(&history, c, &steps, tau));
        pooled.push(pool::pool(&history, c, &part.columns, components.as_ref()));
        series.push(Series { components, fleet_sd: None, drift });
    }
    let ratios = ratio::ratios(&history, &events);
    BikeAnalysis { bike: bike.to_owned(), history, events, series, pooled, ratios }
}
