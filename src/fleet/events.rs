//! Events of one bike and what each of them is.
//!
//! What tells a tyre from a bike file is physics, seen by refitting simulated sessions with wrong files:
//! the effective rolling radius is measured (wheel speed against speed) and no key of the file
//! moves it, while a wrong mass centre or wheelbase moves stiffness, friction or moments of *both*
//! axles, and a wrong mass the drag. A tyre moves its own axle, mostly with the radius.

use std::ops::Range;

use super::history::History;
use super::scan::Shape;
use crate::contract::coefficient::{Coefficient as C, Part};

/// From so many sessions on it can be a tyre.
const SWAP_FROM: usize = 3;

/// What an event is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Another tyre.
    TyreSwap,
    /// The bike file was not this bike's, or had a wrong figure.
    BikeFile,
    /// Slow change.
    Drift,
    /// One or two sessions unlike the others.
    Outlier,
    /// Another level, for a reason that the coefficients do not tell.
    Change,
}

impl Kind {
    /// As in the table.
    pub fn name(self) -> &'static str {
        match self {
            Kind::TyreSwap => "tyre_swap",
            Kind::BikeFile => "bike_file",
            Kind::Drift => "drift",
            Kind::Outlier => "outlier",
            Kind::Change => "change",
        }
    }
}

/// A coefficient that takes part in an event.
#[derive(Debug, Clone, PartialEq)]
pub struct Moved {
    /// Its place in the history's keys.
    pub coefficient: usize,
    /// Change as a share of its level; of a drift, over the whole time.
    pub size: f64,
    /// Contrast over its standard deviation.
    pub score: f64,
}

/// Something that happened to a bike.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// What.
    pub kind: Kind,
    /// `front`, `rear`, `both` or `vehicle`.
    pub tyre: &'static str,
    /// When: which sessions.
    pub shape: Shape,
    /// Sessions in the history.
    pub n: usize,
    /// Coefficients that show it.
    pub moved: Vec<Moved>,
    /// The largest score.
    pub score: f64,
    /// For people.
    pub reason: String,
}

impl Event {
    /// Whether a coefficient's level is fitted with this event. What a wrong file does not visibly
    /// move is not to be believed either.
    pub fn moves(&self, c: usize) -> bool {
        self.kind == Kind::BikeFile || self.moved.iter().any(|m| m.coefficient == c)
    }

    /// The sessions concerned.
    pub fn sessions(&self) -> Range<usize> {
        match self.shape {
            Shape::Stretch(a, b) => a..b,
            Shape::Line => 0..self.n,
        }
    }

    /// The event in words.
    pub fn say(&self, history: &History, limit: f64) -> String {
        let mut moved: Vec<&Moved> = self.moved.iter().collect();
        moved.sort_by(|a, b| b.score.abs().total_cmp(&a.score.abs()));
        let list: Vec<String> = moved
            .iter()
            .take(4)
            .map(|m| {
                let (tyre, coefficient) = &history.keys[m.coefficient];
                format!("{tyre} {coefficient} {:+.1} %", 100.0 * m.size)
            })
            .collect();
        let more =
            if moved.len() > 4 { format!(" and {} more", moved.len() - 4) } else { String::new() };
        let why = match self.kind {
            Kind::TyreSwap => "one axle has another level from here on: another tyre",
            Kind::BikeFile => {
                "both axles or the drag moved together and no rolling radius, which the bike file cannot \
                 change: a wrong mass, wheelbase or mass centre"
            }
            Kind::Drift => "a steady change over time explains it better than any step",
            Kind::Outlier => "unlike the bike's other sessions",
            Kind::Change => "another level, but not as a tyre or a bike file would make it",
        };
        format!(
            "{why}; {}{more} ({:.1} standard deviations, chance stays below {limit:.1})",
            list.join(", "),
            self.score
        )
    }
}

/// Names an event by which coefficients moved and for how long.
pub fn classify(history: &History, shape: Shape, moved: Vec<Moved>, score: f64) -> Event {
    let n = history.sessions.len();
    let key = |m: &Moved| &history.keys[m.coefficient];
    let count = |tyre: &str| moved.iter().filter(|m| key(m).0 == tyre).count();
    let radius = |tyre: &str| {
        moved.iter().any(|m| key(m).0 == tyre && key(m).1 == C::EffectiveRollingRadius.name())
    };
    let drag = moved.iter().any(|m| key(m).0 == Part::Vehicle.name() && key(m).1 == C::Drag.name());
    let (front, rear) = (count("front"), count("rear"));
    let tyre = match (front > 0, rear > 0) {
        (true, true) => "both",
        (true, false) => "front",
        (false, true) => "rear",
        (false, false) => "vehicle",
    };
    let radii = radius("front") || radius("rear");
    let file = !radii && ((front > 0 && rear > 0) || (drag && front + rear > 0));
    let lasts = match shape {
        Shape::Stretch(a, b) => b - a >= SWAP_FROM,
        Shape::Line => true,
    };
    let own = match tyre {
        "both" => radius("front") && radius("rear"),
        "vehicle" => false,
        _ => radii || front + rear >= 2,
    };
    let kind = match shape {
        Shape::Line => Kind::Drift,
        _ if file => Kind::BikeFile,
        _ if !lasts => Kind::Outlier,
        _ if own && !drag => Kind::TyreSwap,
        _ => Kind::Change,
    };
    Event { kind, tyre, shape, n, moved, score, reason: String::new() }
}

/// Sessions that events set apart from the others of a coefficient: outlying, or with a wrong file.
pub fn apart(events: &[Event], c: usize) -> Vec<usize> {
    let apart = |e: &&Event| matches!(e.kind, Kind::BikeFile | Kind::Outlier) && e.moves(c);
    let mut sessions: Vec<usize> = events.iter().filter(apart).flat_map(Event::sessions).collect();
    sessions.sort_unstable();
    sessions.dedup();
    sessions
}
