//! Events of one bike and what each of them is.
//!
//! A tyre differs from a bike file by its physics, found by refitting simulated sessions with wrong files:
//! the effective rolling radius is measured (wheel speed against speed) and no key of the file
//! moves it, while a wrong centre of mass or wheelbase moves stiffness, friction or moments of *both*
//! axles, and a wrong mass the drag. A tyre moves its own axle, mostly with the radius; over hundreds of sessions
//! it shows a little in what is estimated together with it, too: the drag, the other axle.

use std::ops::Range;

use super::history::History;
use super::scan::Shape;
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::contract::fleet_event::{Affected, EventKind};

/// From so many sessions on it can be a tyre.
const SWAP_FROM: usize = 3;

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
    /// Kind of the event.
    pub kind: EventKind,
    /// The part whose coefficients moved.
    pub affected: Affected,
    pub shape: Shape,
    /// Sessions in the history.
    pub n: usize,
    /// Coefficients that show it.
    pub moved: Vec<Moved>,
    /// The largest score of a coefficient, in standard deviations.
    pub score: f64,
    /// Chance that a search finds one as strong where nothing happened.
    pub chance: f64,
    /// Share of false ones among the events of the whole fleet that are at least as sure; not a number before the
    /// whole fleet is known.
    pub discovery: f64,
    /// The evidence as a sentence, as the column `reason` has it.
    pub reason: String,
}

impl Event {
    /// Whether a coefficient's level is fitted with this event. A wrong bike file affects all
    /// coefficients, also those that it does not visibly move.
    pub fn affects(&self, c: usize) -> bool {
        self.kind == EventKind::BikeFile || self.moved.iter().any(|m| m.coefficient == c)
    }

    pub fn sessions(&self) -> Range<usize> {
        match self.shape {
            Shape::Stretch(a, b) => a..b,
            Shape::Line => 0..self.n,
        }
    }

    /// The evidence as a sentence: the coefficients that moved most, and the score against `limit`,
    /// the largest that chance alone makes.
    pub fn describe(&self, history: &History, limit: f64) -> String {
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
        format!(
            "{}; {}{more} ({:.1} standard deviations, chance stays below {limit:.1})",
            self.kind.evidence(),
            list.join(", "),
            self.score
        )
    }
}

/// Names an event by which coefficients moved and for how long.
pub(crate) fn classify(history: &History, shape: Shape, moved: Vec<Moved>, score: f64) -> Event {
    let n = history.sessions.len();
    let key = |m: &Moved| &history.keys[m.coefficient];
    let count = |tyre: &str| moved.iter().filter(|m| key(m).0 == tyre).count();
    let radius = |tyre: &str| {
        moved.iter().any(|m| key(m).0 == tyre && key(m).1 == C::EffectiveRollingRadius.name())
    };
    let drag = moved.iter().any(|m| key(m).0 == Part::Vehicle.name() && key(m).1 == C::Drag.name());
    let (front, rear) = (count("front"), count("rear"));
    let affected = match (front > 0, rear > 0) {
        // the one radius that moved tells whose tyre it is
        _ if radius("front") && !radius("rear") => Affected::Front,
        _ if radius("rear") && !radius("front") => Affected::Rear,
        (true, true) => Affected::Both,
        (true, false) => Affected::Front,
        (false, true) => Affected::Rear,
        (false, false) => Affected::Vehicle,
    };
    let radii = radius("front") || radius("rear");
    let file = !radii && ((front > 0 && rear > 0) || (drag && front + rear > 0));
    let lasts = match shape {
        Shape::Stretch(a, b) => b - a >= SWAP_FROM,
        Shape::Line => true,
    };
    let like_a_tyre = match affected {
        // a wrong scale of the speed moves both radii and the drag
        Affected::Both => radius("front") && radius("rear") && !drag,
        Affected::Vehicle => false,
        Affected::Front | Affected::Rear => radii || (front + rear >= 2 && !drag),
    };
    let kind = match shape {
        Shape::Line => EventKind::Drift,
        _ if file => EventKind::BikeFile,
        _ if !lasts => EventKind::Outlier,
        _ if like_a_tyre => EventKind::TyreSwap,
        _ => EventKind::Change,
    };
    Event {
        kind,
        affected,
        shape,
        n,
        moved,
        score,
        chance: f64::NAN,
        discovery: f64::NAN,
        reason: String::new(),
    }
}
