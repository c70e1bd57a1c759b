//! Sets of a motorcycle's rides that may differ from its others.
//!
//! ```text
//! One      a ride by itself
//! Since    all from a ride on
//! Common   all at a site, with a rider, on a tyre or of a day; the rest, where they are most rides
//! Drift    all, more and more with time
//! ```
//!
//! Two sets of the same rides are one: nobody can tell them apart, and a sentence says both.

use std::collections::BTreeSet;

use super::numbers::History;
use crate::contract::instant;
use crate::simulate::effects::Level;
use crate::store::tables::changes::{REST, common_words};

/// Fewest rides on the other side.
pub(crate) const OTHERS: usize = 3;
/// Fewest rides of a set that is not one odd ride.
const SET: usize = 2;
/// Fewest rides that show a drift.
pub(super) const DRIFT: usize = 6;
/// Correlation with a step from which on a drift is not looked for; of many rides at even times it is 0.87.
const LIKE: f64 = 0.92;

/// Kind of a set of rides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    One,
    /// All from a ride on.
    Since,
    /// Rides with something in common.
    Common(Common),
    /// All, the later the more.
    Drift,
    /// Chosen by a person.
    Chosen,
}

impl Kind {
    /// Whether rides of such a set share what belongs to a level: a slope to the site, a wind to the day.
    pub(crate) fn suits(self, level: Level) -> bool {
        matches!(
            (self, level),
            (Kind::Common(Common::Site), Level::Site) | (Kind::Common(Common::Day), Level::Night)
        )
    }
}

/// Property that rides can have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Common {
    /// Rides at one site.
    Site,
    /// Rides with one rider.
    Rider,
    /// Rides on one front tyre.
    FrontTyre,
    /// Rides on one rear tyre.
    RearTyre,
    /// Rides of one date, UTC.
    Day,
}

impl Common {
    /// All of them; of equal sets the first is shown first.
    pub(crate) const ALL: [Common; 5] =
        [Common::FrontTyre, Common::RearTyre, Common::Rider, Common::Site, Common::Day];

    /// As in the table.
    fn name(self) -> &'static str {
        match self {
            Common::Site => "site",
            Common::Rider => "rider",
            Common::FrontTyre => "tyre_front",
            Common::RearTyre => "tyre_rear",
            Common::Day => "day",
        }
    }

    /// In words, with its value: `rider anna`.
    fn words(self, value: &str) -> String {
        common_words(self.name(), value)
    }

    /// Its value of a ride.
    fn of(self, history: &History, ride: usize) -> Option<&str> {
        let around = &history.circumstances[ride];
        match self {
            Common::Site => around.site.as_deref(),
            Common::Rider => around.rider_id.as_deref(),
            Common::FrontTyre => around.tyre_front.as_deref(),
            Common::RearTyre => around.tyre_rear.as_deref(),
            Common::Day => history.day(ride),
        }
        .filter(|value| !value.is_empty())
    }
}

/// Rides that are compared with the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rides {
    /// Kind of the set.
    pub kind: Kind,
    /// By ride how much of a change of theirs it has: 0 or 1; of a drift from 0 at the first to 1 at the last.
    shares: Vec<f64>,
    /// Their common property, in words: `rider anna`.
    pub common: Vec<String>,
    /// Factor on the variance of natural scatter: it varies from day to day, so it counts once a day, not once a ride.
    pub by_day: f64,
}

impl Rides {
    fn new(kind: Kind, shares: Vec<f64>) -> Self {
        Rides { kind, shares, common: Vec::new(), by_day: 0.0 }
    }

    /// One ride of so many.
    pub(crate) fn one(ride: usize, count: usize) -> Self {
        Self::new(Kind::One, (0..count).map(|i| f64::from(u8::from(i == ride))).collect())
    }

    /// All from one on, of so many.
    pub(crate) fn from(kind: Kind, first: usize, count: usize) -> Self {
        Self::new(kind, (0..count).map(|i| f64::from(u8::from(i >= first))).collect())
    }

    /// How much of a change of theirs a ride has.
    pub(crate) fn share(&self, ride: usize) -> f64 {
        self.shares[ride]
    }

    /// Whether a ride is one of them; of a drift all are.
    pub(crate) fn has(&self, ride: usize) -> bool {
        self.kind == Kind::Drift || self.shares[ride] != 0.0
    }

    /// The first of them.
    pub(crate) fn first(&self) -> usize {
        (0..self.shares.len()).find(|i| self.has(*i)).unwrap_or(0)
    }

    /// How many of them must know a number: half, and two where several share the change.
    pub(crate) fn least_known(&self) -> usize {
        if self.is_shared() { self.counts()[0].div_ceil(2).max(SET) } else { 1 }
    }

    /// How many they are, and how many others there are.
    pub(crate) fn counts(&self) -> [usize; 2] {
        let inside = (0..self.shares.len()).filter(|i| self.has(*i)).count();
        [inside, self.shares.len() - inside]
    }

    /// Whether several rides share the change.
    pub(crate) fn is_shared(&self) -> bool {
        self.kind != Kind::One
    }

    /// As in the table.
    pub(crate) fn name(&self) -> &'static str {
        match self.kind {
            Kind::One => "ride",
            Kind::Since => "since",
            Kind::Common(common) => common.name(),
            Kind::Drift => "drift",
            Kind::Chosen => "against",
        }
    }

    /// All sets of a motorcycle's rides. Of rides without a time nobody knows which came first.
    pub(crate) fn all(history: &History) -> Vec<Rides> {
        let n = history.len();
        let is_dated = history.rides.iter().all(|r| r.start_time.is_some());
        let mut sets: Vec<Rides> = (0..n).map(|ride| Rides::one(ride, n)).collect();
        let last = if is_dated { (n + 1).saturating_sub(SET) } else { 0 };
        sets.extend((OTHERS..last).map(|first| Rides::from(Kind::Since, first, n)));
        for common in Common::ALL {
            let mut values: Vec<&str> = (0..n).filter_map(|i| common.of(history, i)).collect();
            values.sort_unstable();
            values.dedup();
            for value in values {
                let is_own = |i: usize| common.of(history, i) == Some(value);
                let shares = (0..n).map(|i| f64::from(u8::from(is_own(i)))).collect();
                add(
                    history,
                    &mut sets,
                    Rides::new(Kind::Common(common), shares),
                    common.words(value),
                );
            }
        }
        let drift = is_dated.then(|| drift(history)).flatten();
        sets.extend(drift.filter(|drift| !sets.iter().any(|s| drift.is_like(s))));
        sets.iter_mut().for_each(|s| s.by_day = s.by_day(history));
        sets
    }

    /// Whether a drift and a step are almost the same line, as with rides at two times only.
    fn is_like(&self, step: &Rides) -> bool {
        step.kind == Kind::Since && correlation(&self.shares, &step.shares) > LIKE
    }

    fn by_day(&self, history: &History) -> f64 {
        if self.kind == Kind::One {
            return 0.0;
        }
        if self.kind == Kind::Drift {
            let n = self.shares.len() as f64;
            let days: BTreeSet<_> = (0..self.shares.len()).map(|i| history.day(i)).collect();
            let mean = self.shares.iter().sum::<f64>() / n;
            let spread: f64 = self.shares.iter().map(|s| (s - mean).powi(2)).sum();
            return (n / days.len() as f64 - 1.0) / spread;
        }
        let side = |is_in: bool| {
            let own = (0..self.shares.len()).filter(|i| (self.shares[*i] != 0.0) == is_in);
            let (mut rides, mut days) = (0_usize, BTreeSet::new());
            for i in own {
                rides += 1;
                // a rider has one posture
                days.insert(match (self.kind, is_in, history.day(i)) {
                    (Kind::Common(Common::Rider), true, _) => String::new(),
                    (_, _, Some(day)) => day.to_owned(),
                    (_, _, None) => history.rides[i].session_id.clone(),
                });
            }
            (days.len().max(1) as f64).recip() - (rides.max(1) as f64).recip()
        };
        side(true) + side(false)
    }
}

fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len() as f64;
    let mean = |x: &[f64]| x.iter().sum::<f64>() / n;
    let (ma, mb) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).map(|(a, b)| f(a - ma, b - mb)).sum()
    };
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

/// Adds rides that have something in common, or the rest where they are most rides; unless either is a set already, or
/// there are too few.
fn add(history: &History, sets: &mut Vec<Rides>, mut rides: Rides, mut words: String) {
    let [inside, others] = rides.counts();
    if inside == 0 || others == 0 {
        return;
    }
    let is_same = |s: &&mut Rides| s.shares == rides.shares;
    if let Some(same) = sets.iter_mut().find(is_same) {
        // a last day is a date already
        let is_said = same.kind == Kind::Since && rides.kind == Kind::Common(Common::Day);
        if same.kind != Kind::One && !(is_said && history.day(same.first()) == day_of(&words)) {
            same.common.push(words);
        }
        return;
    }
    let is_rest = |s: &Rides| s.shares.iter().zip(&rides.shares).all(|(a, b)| a + b == 1.0);
    if sets.iter().any(is_rest) {
        return;
    }
    if inside > others {
        rides.shares.iter_mut().for_each(|s| *s = 1.0 - *s);
        words = format!("{REST}{words}");
    }
    let [inside, others] = rides.counts();
    if inside >= SET && others >= OTHERS {
        sets.push(Rides { common: vec![words], ..rides });
    }
}

/// The date in the words of a day.
fn day_of(words: &str) -> Option<&str> {
    words.strip_prefix("day ")
}

/// The drift over a motorcycle's rides, by their times; `None` of too few, or all at one time.
fn drift(history: &History) -> Option<Rides> {
    let times: Vec<f64> = history
        .rides
        .iter()
        .map(|r| Some(instant::microseconds(r.start_time.as_deref()?)? as f64))
        .collect::<Option<_>>()?;
    let (first, last) = (*times.first()?, *times.last()?);
    let span = last - first;
    (times.len() >= DRIFT && span > 0.0)
        .then(|| Rides::new(Kind::Drift, times.iter().map(|t| (t - first) / span).collect()))
}
