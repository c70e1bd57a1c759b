//! What several sessions share: an effect of a motorcycle, a road or a night.
//!
//! Every session has its own estimate of every effect that it sees. Per effect the sessions are
//! grouped - all together, by bike, by site, by night, each for itself - and the grouping is taken
//! whose means explain the estimates best for their number (Schwarz 1978, BIC). A group's mean is
//! told when it is beyond chance and predicts each of its sessions from the others.

use std::collections::{BTreeMap, BTreeSet};

use crate::effects::{ALL, Effect, Level};
use crate::tables::rows::POOLED;
use crate::tables::rows::{CauseRow, Ident};

/// Standard errors that a group's mean is from nothing: one in a thousand fleets of thirty effects.
const BEYOND: f64 = 4.2;
/// Share of a session's error that all of them may have in common - what null simulations do not know of the
/// method's own bias - and that no number of sessions averages out.
const COMMON: f64 = 0.35;
/// What the sizes of an archive's sessions may be off by together, as a share: in five simulated archives
/// of six to twelve rides the mean of their late velocities was 4 to 13 % too large.
const TOGETHER: f64 = 0.08;
/// Least gain on sessions left out, in twice the loss.
const GAIN: f64 = 9.0;

/// A session's estimate of an effect.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// The session.
    pub ident: Ident,
    /// Where it was ridden.
    pub site: Option<String>,
    /// Estimate.
    pub value: f64,
    /// Its standard error.
    pub std_error: f64,
}

impl Evidence {
    /// That of a row of `causes`; nothing where the session cannot see the effect.
    pub fn of(row: &CauseRow, site: Option<&str>) -> Option<Self> {
        let (value, low, high) = (row.value?, row.ci95_low?, row.ci95_high?);
        let std_error = (high - low) / (2.0 * 1.96);
        let seen = row.level == "session" && row.verdict != "not_identifiable" && std_error > 0.0;
        seen.then(|| Evidence {
            ident: row.ident.clone(),
            site: site.map(str::to_owned),
            value,
            std_error,
        })
    }

    /// The group of a level it belongs to.
    fn group(&self, level: Level) -> String {
        match level {
            Level::Session => self.ident.session_id.clone(),
            Level::Bike => self.ident.bike_id.clone(),
            Level::Site => self.site.clone().unwrap_or_default(),
            // the date of the start
            Level::Night => {
                self.ident.start_time.as_deref().unwrap_or_default().chars().take(10).collect()
            }
            Level::Fleet => String::new(),
        }
    }
}

/// The estimates in a session's rows of `causes`, by effect; rows of what is not a candidate on the road,
/// or what the session cannot identify, give none.
pub fn evidence(causes: &[CauseRow], site: Option<&str>) -> Vec<(&'static str, Evidence)> {
    let of =
        |row: &CauseRow| Some((Effect::named(&row.effect).ok()?.name, Evidence::of(row, site)?));
    causes.iter().filter_map(of).collect()
}

/// Weighted mean, its standard error with the scatter between sessions, and the squared misfit.
fn mean(says: &[&Evidence]) -> (f64, f64, f64) {
    let weight = |s: &&&Evidence| s.std_error.powi(-2);
    let total: f64 = says.iter().map(|s| weight(&s)).sum();
    let mean = says.iter().map(|s| weight(&s) * s.value).sum::<f64>() / total;
    let misfit: f64 = says.iter().map(|s| weight(&s) * (s.value - mean).powi(2)).sum();
    // sessions that differ more than their errors say make the mean less sure (Birge 1932)
    let degrees = (says.len() as f64 - 1.0).max(1.0);
    let scatter = (misfit / degrees).max(1.0).sqrt() / total.sqrt();
    let usual = (says.len() as f64 / total).sqrt();
    (mean, scatter.hypot(COMMON * usual), misfit)
}

/// Fall of twice the loss when each session is predicted from the others of its group.
fn left_out(says: &[&Evidence]) -> f64 {
    (0..says.len())
        .map(|k| {
            let others: Vec<&Evidence> =
                says.iter().enumerate().filter(|(i, _)| *i != k).map(|(_, s)| *s).collect();
            let (by, _, _) = mean(&others);
            let own = says[k];
            by * (2.0 * own.value - by) / own.std_error.powi(2)
        })
        .sum()
}

/// Rows of `causes` for what sessions share, of every effect by name.
pub fn pool(says: &BTreeMap<&'static str, Vec<Evidence>>) -> Vec<CauseRow> {
    ALL.iter()
        .filter_map(|effect| says.get(effect.name).map(|says| (effect, says)))
        .filter(|(_, says)| says.len() > 1)
        .flat_map(|(effect, says)| pool_one(effect, says))
        .collect()
}

fn pool_one(effect: &Effect, says: &[Evidence]) -> Vec<CauseRow> {
    let n = says.len() as f64;
    let grouped = |level: Level| {
        let mut groups: BTreeMap<String, Vec<&Evidence>> = BTreeMap::new();
        for say in says {
            groups.entry(say.group(level)).or_default().push(say);
        }
        groups
    };
    let partition = |level: Level| -> BTreeSet<Vec<String>> {
        grouped(level)
            .values()
            .map(|says| says.iter().map(|s| s.ident.session_id.clone()).collect())
            .collect()
    };
    let levels = [Level::Fleet, Level::Bike, Level::Site, Level::Night, Level::Session];
    let cost = |level: Level| {
        let groups = grouped(level);
        groups.values().map(|g| mean(g).2).sum::<f64>() + groups.len() as f64 * n.ln()
    };
    let nothing: f64 = says.iter().map(|s| (s.value / s.std_error).powi(2)).sum();
    let Some(best) = levels.into_iter().min_by(|a, b| cost(*a).total_cmp(&cost(*b))) else {
        return Vec::new();
    };
    if cost(best) >= nothing || best == Level::Session {
        return Vec::new(); // nothing, or each session by itself: their own rows say it
    }
    // levels that these sessions cannot tell apart; the one the effect usually has speaks
    let same: Vec<Level> =
        levels.into_iter().filter(|l| partition(*l) == partition(best)).collect();
    let level = if same.contains(&effect.level) { effect.level } else { best };
    let others: Vec<&str> = same.iter().filter(|l| **l != level).map(|l| l.name()).collect();
    grouped(level)
        .into_iter()
        .filter_map(|(name, group)| {
            let (value, std_error, _) = mean(&group);
            let gain = left_out(&group);
            let score = (value / std_error).abs() / BEYOND;
            let sound = score >= 1.0 && gain >= GAIN && effect.in_bounds(value);
            let half_width = 1.96 * std_error.hypot(TOGETHER * value);
            if group.len() < 2 || !sound {
                return None;
            }
            let bikes: BTreeSet<&str> = group.iter().map(|s| s.ident.bike_id.as_str()).collect();
            let bike = bikes.first().filter(|_| bikes.len() == 1).copied().unwrap_or(POOLED);
            let also = match others.is_empty() {
                true => String::new(),
                false => format!("; these sessions cannot tell it from {}", others.join(", ")),
            };
            Some(CauseRow {
                ident: Ident {
                    session_id: POOLED.to_owned(),
                    bike_id: bike.to_owned(),
                    ..Ident::default()
                },
                rank: 1,
                effect: effect.name.to_owned(),
                verdict: "named".to_owned(),
                level: level.name().to_owned(),
                pooled_over: Some(name).filter(|n| !n.is_empty()),
                parameter: effect.name.to_owned(),
                value: Some(value),
                unit: effect.unit.to_owned(),
                ci95_low: Some(value - half_width),
                ci95_high: Some(value + half_width),
                score,
                false_alarm_rate: 0.001,
                gain_heldout: Some(gain),
                separate_by: Some(effect.separate_by.to_owned()),
                reason: format!(
                    "{}: shared by {} sessions{also}",
                    effect.sentence_of(value),
                    group.len()
                ),
                ..CauseRow::default()
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn say(k: usize, bike: &str, site: &str, night: usize, value: f64) -> Evidence {
        Evidence {
            ident: Ident {
                session_id: format!("s{k}"),
                bike_id: bike.to_owned(),
                start_time: Some(format!("2026-05-{:02}T20:00:00Z", night + 1)),
            },
            site: Some(site.to_owned()),
            value: 0.01 * value,
            std_error: 0.01,
        }
    }

    /// Two bikes on two sites over three nights, twelve sessions; `shift` is the truth in standard errors.
    fn told(shift: impl Fn(usize, usize, usize) -> f64) -> Vec<(String, Option<String>)> {
        let noise = [0.3, -0.8, 0.5, -0.2, 0.9, -0.6, 0.1, -0.4, 0.7, -0.9, 0.2, 0.4];
        let says: Vec<Evidence> = (0..12)
            .map(|k| {
                let (bike, site, night) = (k % 2, k / 2 % 2, k / 4);
                let value = shift(bike, site, night) + noise[k];
                say(k, ["a", "b"][bike], ["x", "y"][site], night, value)
            })
            .collect();
        let says = BTreeMap::from([("latency", says)]);
        pool(&says).into_iter().map(|r| (r.level, r.pooled_over)).collect()
    }

    #[test]
    fn an_effect_is_attributed_to_what_shares_it() {
        let own = |level: &str, name: &str| vec![(level.to_owned(), Some(name.to_owned()))];
        assert_eq!(told(|bike, _, _| if bike == 1 { 5.0 } else { 0.0 }), own("bike", "b"));
        assert_eq!(told(|_, site, _| if site == 0 { -5.0 } else { 0.0 }), own("site", "x"));
        assert_eq!(
            told(|_, _, night| if night == 2 { 5.0 } else { 0.0 }),
            own("night", "2026-05-03")
        );
        assert_eq!(told(|_, _, _| 4.0), vec![("fleet".to_owned(), None)]);
        assert!(told(|_, _, _| 0.0).is_empty());
    }

    #[test]
    fn no_number_of_sessions_makes_a_size_surer_than_they_may_be_off_by_together() {
        let says = |n: usize| (0..n).map(|k| say(k, "a", "x", k, 5.0)).collect::<Vec<_>>();
        let rows = pool(&BTreeMap::from([("latency", says(400))]));
        let (Some(low), Some(high)) = (rows[0].ci95_low, rows[0].ci95_high) else { panic!() };
        assert!(high - low > 2.0 * 1.96 * TOGETHER * 0.05, "{low} to {high}");
    }
}
