//! Identified causes of a diagnosis, seen from a tyre: what the export adds to it, what its coefficients have already and what
//! is no tyre's.
//!
//! | the effect is | `run --model` took it out | in the export |
//! |---|---|---|
//! | a number of the tyre (side-force ratio) | yes | in the coefficients already |
//! | a number of the tyre | no | put into the tyre; the slips over camber stay as measured |
//! | what no recording can be freed of (friction over load) | cannot be | added |
//! | what a recording can be freed of (growth with speed) | yes | added |
//! | what a recording can be freed of | no | not added: the coefficients have its mean |
//! | no tyre's (sensors, road, rider) | | listed, no more |

use serde::Serialize;

use crate::contract::bike::Axle;
use crate::simulate::effects::models::{Models, was_taken_out};
use crate::simulate::effects::{Effect, ModelError, SessionRef};
use crate::statistics::interval::t95;
use crate::statistics::number_format;
use crate::store::tables::rows::{SessionRow, WarningRow};

/// An identified cause of a diagnosis.
#[derive(Debug, Clone)]
pub struct Named {
    pub effect: &'static Effect,
    pub value: f64,
    pub std_error: f64,
    /// Where the size comes from, in words.
    pub origin: String,
    /// Whether `run --model` took it out of the recording that the coefficients are from.
    pub taken_out: bool,
}

/// Place of an effect in an export.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Place {
    /// The export adds it to the tyre.
    Added,
    /// `run --model` put it into the coefficients.
    InCoefficients,
    /// The recordings had it in them, and a mean of it is in the coefficients.
    InRecording,
    /// It is the tyre's of the other end.
    OtherTyre,
    /// It is no tyre's.
    NoTyre,
}

impl Named {
    /// Those of a session.
    pub fn all(models: &Models, session: &SessionRow, warnings: &[WarningRow]) -> Vec<Named> {
        let who = SessionRef {
            session_id: &session.ident.session_id,
            bike_id: &session.ident.bike_id,
            site: session.site.as_deref(),
            start_time: session.ident.start_time.as_deref(),
        };
        let of_session = |w: &&WarningRow| w.ident.key() == session.ident.key();
        let mine: Vec<&WarningRow> = warnings.iter().filter(of_session).collect();
        let named = |has: crate::simulate::effects::models::Has<'_>| Named {
            effect: has.effect,
            value: has.value,
            std_error: has.std_error,
            origin: has.origin.to_owned(),
            taken_out: mine.iter().any(|w| was_taken_out(&w.code, &w.message, has.effect)),
        };
        models.of(&who).into_iter().map(named).collect()
    }

    /// Place in the export, seen from a tyre.
    pub fn place(&self, axle: Axle) -> Place {
        let tyres = self.effect.tyres;
        if tyres.is_empty() {
            return Place::NoTyre;
        }
        if !tyres.contains(&axle) {
            return Place::OtherTyre;
        }
        match (self.effect.is_number(), self.taken_out) {
            (true, true) => Place::InCoefficients,
            (false, false) if self.effect.remove.is_some() => Place::InRecording,
            _ => Place::Added,
        }
    }

    /// 95 % interval, in its unit.
    pub fn interval(&self) -> [f64; 2] {
        let half = t95(f64::INFINITY) * self.std_error;
        [self.value - half, self.value + half]
    }

    /// Its name, size and interval.
    pub fn words(&self) -> String {
        let decimals = number_format::decimals_of(self.value, Some(self.std_error));
        let [low, high] = self.interval().map(|end| number_format::fixed(end, decimals));
        let value = number_format::fixed(self.value, decimals);
        let unit = match self.effect.unit {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        format!("{} {value}{unit}, 95 % {low} to {high}", self.effect.name)
    }
}

/// Those that the export adds to a tyre, together.
pub(crate) fn added(all: &[Named], axle: Axle) -> ModelError {
    let mut error = ModelError::default();
    for one in all.iter().filter(|one| one.place(axle) == Place::Added) {
        (one.effect.set)(&mut error, one.value);
    }
    error
}

/// The note of a number that an effect changed, here or in `run --model`.
pub(crate) fn noted(note: &str, all: &[Named], axle: Axle, name: &str) -> String {
    let is_it = |one: &&Named| {
        one.effect.name == name && matches!(one.place(axle), Place::Added | Place::InCoefficients)
    };
    match all.iter().find(is_it) {
        None => note.to_owned(),
        Some(one) if note.is_empty() => format!("identified by diagnose: {}", one.words()),
        Some(one) => format!("{note}; identified by diagnose: {}", one.words()),
    }
}

/// Lines of a file about the effects of some tyres, line by line; `left_out` are those that its form has no place for.
pub fn lines(all: &[Named], tyres: &[Axle], left_out: &[&str]) -> Vec<String> {
    let is_left_out = |one: &Named| left_out.contains(&one.effect.name);
    let at = |one: &Named, place: Place| tyres.iter().any(|axle| one.place(*axle) == place);
    let mut lines = Vec::new();
    let mut put = |says: &str, has: &dyn Fn(&Named) -> bool| {
        let which = all.iter().filter(|one| has(one));
        lines.extend(which.map(|one| format!("{says}: {} ({})", one.words(), one.origin)));
    };
    put("identified by diagnose, in the tyre", &|one| at(one, Place::Added) && !is_left_out(one));
    put("identified by diagnose, in the coefficients already", &|one| {
        at(one, Place::InCoefficients)
    });
    put("identified by diagnose, this file has no place for it", &|one| {
        at(one, Place::Added) && is_left_out(one)
    });
    put(
        "identified by diagnose, not added: the output was computed without `run --model`, its coefficients have a mean of it",
        &|one| at(one, Place::InRecording),
    );
    put("identified by diagnose, not part of the tyre", &|one| at(one, Place::NoTyre));
    lines
}
