//! Sets of a motorcycle's rides that may differ from its others.
//!
//! ```text
//! One      a ride by itself
//! Since    all from a ride on
//! Common   all at a site, with a rider, on a tyre or in a night
//! Drift    all, more and more with time
//! ```
//!
//! Two sets of the same rides are one: nobody can tell them apart, and a sentence says both.

use super::difference::OTHERS;
use super::numbers::History;
use crate::contract::instant;

/// Fewest rides of a set that is not one odd ride.
const SET: usize = 2;
/// Fewest rides that show a drift.
pub(super) const DRIFT: usize = 6;

/// What makes rides a set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// One ride.
    One,
    /// All from a ride on.
    Since,
    /// What rides have in common.
    Common(Common),
    /// All, the later the more.
    Drift,
    /// Chosen by a person.
    Chosen,
}

/// What rides can have in common.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Common {
    /// Where.
    Site,
    /// Who.
    Rider,
    /// On which front tyre.
    FrontTyre,
    /// On which rear tyre.
    RearTyre,
    /// On which date.
    Night,
}

impl Common {
    /// All of them; of equal sets the first is shown first.
    pub(crate) const ALL: [Common; 5] =
        [Common::FrontTyre, Common::RearTyre, Common::Rider, Common::Site, Common::Night];

    /// As in the table.
    fn name(self) -> &'static str {
        match self {
            Common::Site => "site",
            Common::Rider => "rider",
            Common::FrontTyre => "tyre_front",
            Common::RearTyre => "tyre_rear",
            Common::Night => "night",
        }
    }

    /// In words, with its value: `rider anna`.
    fn words(self, value: &str) -> String {
        match self {
            Common::Site => format!("site {value}"),
            Common::Rider => format!("rider {value}"),
            Common::FrontTyre => format!("front tyre {value}"),
            Common::RearTyre => format!("rear tyre {value}"),
            Common::Night => format!("night {value}"),
        }
    }

    /// Its value of a ride.
    fn of(self, history: &History, ride: usize) -> Option<&str> {
        let around = &history.circumstances[ride];
        match self {
            Common::Site => around.site.as_deref(),
            Common::Rider => around.rider_id.as_deref(),
            Common::FrontTyre => around.tyre_front.as_deref(),
            Common::RearTyre => around.tyre_rear.as_deref(),
            Common::Night => history.rides[ride].start_time.as_deref().and_then(|t| t.get(..10)),
        }
        .filter(|value| !value.is_empty())
    }
}

/// Rides that are held against the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rides {
    /// What makes them a set.
    pub kind: Kind,
    /// By ride how much of a change of theirs it has: 0 or 1; of a drift from 0 at the first to 1 at the last.
    shares: Vec<f64>,
    /// What they have in common, in words: `rider anna`.
    pub common: Vec<String>,
}

impl Rides {
    fn new(kind: Kind, shares: Vec<f64>) -> Self {
        Rides { kind, shares, common: Vec::new() }
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
                add(&mut sets, Rides::new(Kind::Common(common), shares), common.words(value));
            }
        }
        sets.extend(is_dated.then(|| drift(history)).flatten());
        sets
    }
}

/// Adds rides that have something in common, unless they are a set already, most rides or too few.
fn add(sets: &mut Vec<Rides>, rides: Rides, words: String) {
    let [inside, others] = rides.counts();
    if inside < SET || others == 0 {
        return;
    }
    if let Some(same) = sets.iter_mut().find(|s| s.shares == rides.shares) {
        same.common.push(words);
        return;
    }
    let is_rest = |s: &Rides| s.shares.iter().zip(&rides.shares).all(|(a, b)| a + b == 1.0);
    // of two halves the first one differs from the second
    if inside > others || others < OTHERS || sets.iter().any(is_rest) {
        return;
    }
    sets.push(Rides { common: vec![words], ..rides });
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
