//! What the motorcycles of a fleet have in common at a time or at a place: a season, a site.
//!
//! ```text
//! ln y_is = level_i(s) + season(t_s) + site(s) + own        level_i: of motorcycle i, its events in it
//! season(window) = median over motorcycles of the mean of the residuals there;  site likewise
//! ```
//!
//! The search for events uses the residuals: a friction that falls for everybody in winter is no tyre of anybody. The median
//! over motorcycles does not follow what happens to a few of them. A season is as fine as the fleet has values for;
//! each term counts by the share of its variance that is not noise.
//!
//! What is common to a whole fleet and no season (worse sensors everywhere on one day) is removed in the same way and reported nowhere.
//! Coefficients of both signs have no scale to share and no common term.

use std::collections::BTreeMap;

use super::events::Event;
use super::history::History;
use super::levels;
use super::scan;
use crate::statistics::order::{median, spread_about};

/// Fewest motorcycles that have something in common: of fewer each would hide part of its own events.
pub(crate) const BIKES: usize = 16;
/// Fewest of them in a window or at a site.
const THERE: usize = 8;
/// Values per window of the season; no more windows than weeks in a year.
const VALUES: usize = 150;
const WINDOWS: usize = 52;
/// Rounds of levels, season and sites in turn.
const ROUNDS: usize = 4;
/// Standard error of a median over that of a mean.
const MEDIAN: f64 = 1.253;

type Key = (String, String);

/// A coefficient's common terms, on the scale of logarithms.
#[derive(Debug, Clone, Default, PartialEq)]
struct Term {
    /// Middles of the windows, days, and the season there.
    season: Vec<(f64, f64)>,
    sites: BTreeMap<String, f64>,
}

impl Term {
    fn at(&self, day: Option<f64>, site: Option<&String>) -> f64 {
        let season = day.map_or(0.0, |day| interpolated(&self.season, day));
        season + site.and_then(|s| self.sites.get(s)).copied().unwrap_or(0.0)
    }
}

/// Common changes of a fleet: seasons and sites.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Common(BTreeMap<Key, Term>);

/// One value less its motorcycle's level.
struct Residual<'a> {
    bike: usize,
    day: Option<f64>,
    site: Option<&'a String>,
    value: f64,
    variance: f64,
}

impl Common {
    /// Of motorcycles and what is known to have happened to each.
    pub(crate) fn of(bikes: &[(&History, &[Event])]) -> Common {
        let mut places: BTreeMap<&Key, Vec<(usize, usize)>> = BTreeMap::new();
        for (b, (history, _)) in bikes.iter().enumerate() {
            for (c, key) in history.keys.iter().enumerate() {
                places.entry(key).or_default().push((b, c));
            }
        }
        let found = places.into_iter().filter_map(|(key, places)| {
            let term = term(bikes, &places)?;
            (!term.season.is_empty() || !term.sites.is_empty()).then(|| (key.clone(), term))
        });
        Common(found.collect())
    }

    /// Whether there is nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A history less what its motorcycle has in common with the others.
    pub(crate) fn without(&self, history: &History) -> History {
        let mut out = history.clone();
        for (c, key) in history.keys.iter().enumerate() {
            let Some(term) = self.0.get(key) else { continue };
            for i in 0..history.sessions.len() {
                let factor = (-term.at(history.days[i], history.sites[i].as_ref())).exp();
                out.values[c][i] *= factor;
                out.errors[c][i] *= factor;
            }
        }
        out
    }
}

fn term(bikes: &[(&History, &[Event])], places: &[(usize, usize)]) -> Option<Term> {
    let known = |(b, c): &(usize, usize)| {
        bikes[*b].0.values[*c].iter().filter(|v| v.is_finite()).copied().collect::<Vec<_>>()
    };
    let all: Vec<f64> = places.iter().flat_map(known).collect();
    let sign = if all.iter().all(|v| *v > 0.0) {
        1.0
    } else if all.iter().all(|v| *v < 0.0) {
        -1.0
    } else {
        return None;
    };
    let with_values = places.iter().filter(|p| known(p).len() >= scan::SCAN_FROM).count();
    if with_values < BIKES {
        return None;
    }
    let mut term = Term::default();
    for _ in 0..ROUNDS {
        let left = left(bikes, places, sign, &term);
        let seasonless = |l: &Residual<'_>| l.value - l.site.map_or(0.0, |_| term.at(None, l.site));
        let season = season(&left, &seasonless);
        let season_at = |l: &Residual<'_>| l.day.map_or(0.0, |day| interpolated(&season, day));
        let sites = sites(&left, &|l| l.value - season_at(l));
        term = Term { season, sites };
    }
    Some(term)
}

/// The values less the levels of their motorcycles, as logarithms; a level is what the events and `term` leave.
fn left<'a>(
    bikes: &[(&'a History, &[Event])],
    places: &[(usize, usize)],
    sign: f64,
    term: &Term,
) -> Vec<Residual<'a>> {
    let mut out = Vec::new();
    for &(bike, c) in places {
        let (history, events) = bikes[bike];
        let n = history.sessions.len();
        let y: Vec<f64> = history.values[c].iter().map(|v| (sign * v).ln()).collect();
        let errors: Vec<f64> =
            (0..n).map(|i| (history.errors[c][i] / history.values[c][i]).abs()).collect();
        let tau = scan::robust_tau(&y, &errors);
        let variances: Vec<f64> = errors.iter().map(|e| e * e + tau * tau).collect();
        let common: Vec<f64> =
            (0..n).map(|i| term.at(history.days[i], history.sites[i].as_ref())).collect();
        let own: Vec<f64> = (0..n).map(|i| y[i] - common[i]).collect();
        let concerned = events.iter().any(|e| e.affects(c));
        let columns = levels::regressors(history, events, c, true);
        let fitted = match concerned {
            true => levels::fit(&own, &variances, &columns).map(|level| level.fitted),
            false => {
                let mut known: Vec<f64> = own.iter().filter(|y| y.is_finite()).copied().collect();
                median(&mut known).map(|m| vec![m; n])
            }
        };
        let Some(fitted) = fitted else { continue };
        out.extend((0..n).filter(|i| (y[*i] - fitted[*i]).is_finite() && variances[*i] > 0.0).map(
            |i| Residual {
                bike,
                day: history.days[i],
                site: history.sites[i].as_ref(),
                value: y[i] - fitted[i],
                variance: variances[i],
            },
        ));
    }
    out
}

/// Median over motorcycles of the mean of some of their values, with its standard error.
fn over_bikes(some: &[(usize, f64, f64)]) -> Option<(f64, f64)> {
    let mut sums: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    for (bike, value, variance) in some {
        let sum = sums.entry(*bike).or_default();
        sum.0 += value / variance;
        sum.1 += 1.0 / variance;
    }
    let mut means: Vec<f64> = sums.values().map(|(top, bottom)| top / bottom).collect();
    if means.len() < THERE {
        return None;
    }
    let n = means.len() as f64;
    let middle = median(&mut means)?;
    Some((middle, MEDIAN * spread_about(&means, middle) / n.sqrt()))
}

fn season(left: &[Residual<'_>], value: &dyn Fn(&Residual<'_>) -> f64) -> Vec<(f64, f64)> {
    let mut dated: Vec<(f64, usize, f64, f64)> =
        left.iter().filter_map(|l| Some((l.day?, l.bike, value(l), l.variance))).collect();
    dated.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let windows = (dated.len() / VALUES).min(WINDOWS);
    if windows < 3 {
        return Vec::new();
    }
    let found: Vec<(f64, f64, f64)> = (0..windows)
        .filter_map(|w| {
            let part = &dated[w * dated.len() / windows..(w + 1) * dated.len() / windows];
            let some: Vec<(usize, f64, f64)> = part.iter().map(|d| (d.1, d.2, d.3)).collect();
            let (level, error) = over_bikes(&some)?;
            Some((part[part.len() / 2].0, level, error))
        })
        .collect();
    if found.len() < 3 {
        return Vec::new();
    }
    let n = found.len() as f64;
    let mean = found.iter().map(|f| f.1).sum::<f64>() / n;
    let variance = found.iter().map(|f| (f.1 - mean).powi(2)).sum::<f64>() / (n - 1.0);
    let noise = found.iter().map(|f| f.2 * f.2).sum::<f64>() / n;
    let share = if variance > 0.0 { (1.0 - noise / variance).max(0.0) } else { 0.0 };
    found.into_iter().map(|(day, level, _)| (day, share * (level - mean))).collect()
}

fn sites(left: &[Residual<'_>], value: &dyn Fn(&Residual<'_>) -> f64) -> BTreeMap<String, f64> {
    let mut of_site: BTreeMap<&String, Vec<(usize, f64, f64)>> = BTreeMap::new();
    for l in left {
        if let Some(site) = l.site {
            of_site.entry(site).or_default().push((l.bike, value(l), l.variance));
        }
    }
    if of_site.len() < 2 {
        return BTreeMap::new();
    }
    let found = of_site.into_iter().filter_map(|(site, some)| {
        let (level, error) = over_bikes(&some)?;
        let share = if level == 0.0 { 0.0 } else { (1.0 - (error / level).powi(2)).max(0.0) };
        Some((site.clone(), share * level))
    });
    found.collect()
}

/// Straight between the points, even beyond them.
fn interpolated(points: &[(f64, f64)], x: f64) -> f64 {
    let after = points.partition_point(|p| p.0 <= x);
    match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
        (Some(a), Some(b)) => a.1 + (b.1 - a.1) * (x - a.0) / (b.0 - a.0),
        (Some(a), None) => a.1,
        (None, Some(b)) => b.1,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::{Observation, analyse};
    use crate::statistics::random::Random;

    /// Motorcycles of 60 sessions with a season of 4 %, a site that is 8 % off, and another tyre on the first.
    fn fleet(bikes: usize, seed: u64) -> Vec<Observation> {
        let mut random = Random::new(seed, "common");
        let mut out = Vec::new();
        for bike in 0..bikes {
            let level = random.between(0.9, 1.1);
            for i in 0..60 {
                let day = 20_000.0 + 6.0 * i as f64 + random.between(0.0, 5.0);
                let odd = random.between(0.0, 1.0) < 0.05;
                let season = 0.04 * (std::f64::consts::TAU * (day - 20_000.0) / 365.0).sin();
                let swap = if bike == 0 && i >= 30 { 0.06 } else { 0.0 };
                let site = if odd { -0.08 } else { 0.0 };
                let value = level * (season + site + swap + 0.01 * random.normal()).exp();
                out.push(Observation {
                    bike: format!("b{bike:02}"),
                    tyre: "front".into(),
                    coefficient: "mf_d".into(),
                    session: format!("s{bike:02}_{i:02}"),
                    day: Some(day),
                    site: Some(if odd { "wet" } else { "dry" }.into()),
                    value,
                    error: 0.006 * value,
                    determined: true,
                });
            }
        }
        out
    }

    #[test]
    fn a_season_and_a_site_that_all_share_are_no_events() {
        let found = analyse(&fleet(24, 1));
        // one bike in a hundred has an event by chance, of which the rate of false ones says so
        let sure = |b: &&crate::fleet::BikeAnalysis| b.events.iter().any(|e| e.discovery < 1e-3);
        assert_eq!(found.iter().filter(sure).count(), 1, "{found:?}");
        assert!(found.iter().map(|b| b.events.len()).sum::<usize>() <= 3, "{found:?}");
        let swap = &found[0].events[0];
        assert_eq!(swap.sessions(), 30..60, "{swap:?}");
        assert!((swap.moved[0].size - 0.06).abs() < 0.01 && swap.discovery < 1e-6, "{swap:?}");
        // few motorcycles do not show what they have in common
        let alone = analyse(&fleet(6, 1));
        assert!(alone.iter().all(|b| !b.events.is_empty()), "{alone:?}");
    }

    #[test]
    fn what_is_in_common_is_found() {
        let rows = fleet(24, 2);
        let histories: Vec<History> = (0..24)
            .map(|b| {
                let of_bike: Vec<&Observation> =
                    rows.iter().filter(|r| r.bike == format!("b{b:02}")).collect();
                History::new(&of_bike)
            })
            .collect();
        let bikes: Vec<(&History, &[Event])> = histories.iter().map(|h| (h, &[][..])).collect();
        let common = Common::of(&bikes);
        let term = common.0.values().next().expect("one coefficient");
        let wet = term.sites["wet"] - term.sites["dry"];
        assert!((wet + 0.08).abs() < 0.01, "{term:?}");
        let swing = interpolated(&term.season, 20_091.0) - interpolated(&term.season, 20_274.0);
        assert!((swing - 0.08).abs() < 0.02, "{swing} {term:?}");
        // nothing in common where there are few
        assert!(Common::of(&bikes[..8]).is_empty());
    }
}
