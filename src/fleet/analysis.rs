//! All statistics over the sessions of a fleet, bike by bike.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::common::Common;
use super::components::{self, Components, Part};
use super::drift::{self, Drift};
use super::events::Event;
use super::history::History;
use super::observation::Observation;
use super::pool::{self, Pooled};
use super::ratio::{self, Ratio};
use super::{changes, levels, threshold};
use crate::statistics::discovery::discovery_rates;

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
    /// Id of the bike.
    pub bike: String,
    /// Its sessions and values.
    pub history: History,
    /// Events, the strongest first.
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
    let histories: Vec<(&str, History)> =
        bikes.into_par_iter().map(|(bike, rows)| (bike, History::new(&rows))).collect();
    let events = events(&histories);
    let mut bikes: Vec<BikeAnalysis> = histories
        .into_par_iter()
        .zip(events)
        .map(|((bike, history), events)| analyse_bike(bike, history, events))
        .collect();
    let fleet = common(&bikes);
    for bike in &mut bikes {
        for (key, series) in bike.history.keys.iter().zip(&mut bike.series) {
            series.fleet_sd = fleet.get(key).copied().flatten();
        }
    }
    bikes
}

/// The events of every bike, beside what the fleet has in common.
fn events(histories: &[(&str, History)]) -> Vec<Vec<Event>> {
    let limits = threshold::Limits::default();
    let search = |common: &Common| -> Vec<Vec<Event>> {
        let of = |(_, history): &(&str, History)| match common.is_empty() {
            true => changes::find(history, &limits),
            false => changes::find(&common.without(history), &limits),
        };
        histories.par_iter().map(of).collect()
    };
    let with = |events: &[Vec<Event>]| {
        let bikes = histories.iter().zip(events).map(|((_, h), e)| (h, e.as_slice()));
        Common::of(&bikes.collect::<Vec<_>>())
    };
    let none = vec![Vec::new(); histories.len()];
    let first = with(&none);
    let mut found = search(&first);
    if !first.is_empty() {
        // once more beside the events: what happens to many bikes is then no longer taken for common
        found = search(&with(&found));
    }
    // every search ended with a test that found nothing more
    let tests = histories.len() + found.iter().map(Vec::len).sum::<usize>();
    let chances: Vec<f64> = found.iter().flatten().map(|e| e.chance).collect();
    let rates = discovery_rates(&chances, tests);
    found.iter_mut().flatten().zip(rates).for_each(|(event, rate)| event.discovery = rate);
    found
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

fn analyse_bike(bike: &str, history: History, events: Vec<Event>) -> BikeAnalysis {
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
