//! What people ask of a session's tyres first: a card each.

use serde::Serialize;

use crate::contract::coefficient::{Coefficient as C, Part};
use crate::report::answer::{ASKED, explained};
use crate::report::coefficient_text::CoefficientText;
use crate::report::next_ride::{TITLE, Want};
use crate::report::{inline_svg, labels, next_ride};
use crate::statistics::number_format::typeset;
use crate::store::tables::rows::{Coefficient, SessionRow, Status};

#[derive(Debug, Serialize)]
pub(crate) struct Card {
    pub title: String,
    /// Its model, where the session says it.
    pub model: String,
    /// Main numbers of it.
    pub rows: Vec<Main>,
}

/// One number of a card.
#[derive(Debug, Serialize)]
pub(crate) struct Main {
    /// In a person's words.
    pub label: &'static str,
    pub explained: &'static str,
    /// With its unit; empty where the ride does not determine it.
    pub value: String,
    /// 95 %.
    pub interval: String,
    /// The same, drawn.
    pub bar: String,
    /// Error in it, and what to ride; of a lower bound what to ride for the value.
    pub note: String,
}

/// The cards of the tyres that have one of these numbers.
pub(super) fn cards(session: &SessionRow, coefficients: &[Coefficient]) -> Vec<Card> {
    let card = |part: Part| {
        let own: Vec<&Coefficient> =
            coefficients.iter().filter(|c| c.tyre == part.name()).collect();
        let of = |(asked, label): (C, &'static str)| {
            own.iter().find(|c| c.coefficient == asked.name()).map(|c| main(c, label))
        };
        let rows: Vec<Main> = ASKED.into_iter().filter_map(of).collect();
        let model = match part {
            Part::Front => &session.tyre_front,
            _ => &session.tyre_rear,
        };
        let title = labels::tyre(part.name()).to_owned();
        (!rows.is_empty()).then(|| Card { title, model: model.clone().unwrap_or_default(), rows })
    };
    [Part::Front, Part::Rear].into_iter().filter_map(card).collect()
}

fn main(c: &Coefficient, label: &'static str) -> Main {
    let text = CoefficientText::of(c);
    let unit = match labels::unit(&c.unit) {
        unit if unit.is_empty() => unit,
        unit => format!(" {unit}"),
    };
    match c.status {
        Status::Ok => Main {
            label,
            explained: explained(label),
            value: typeset(&format!("{}{unit}", text.value)),
            interval: typeset(&text.interval(" to ")),
            bar: inline_svg::interval(c.value, c.ci95_low, c.ci95_high),
            note: String::new(),
        },
        Status::LowerBound => Main {
            label,
            explained: explained(label),
            value: typeset(&format!("{}{unit}", text.interval(""))),
            interval: String::new(),
            bar: String::new(),
            note: next_ride::of(c).map_or_else(String::new, |(want, riding)| match want {
                Want::SoundLog => riding.to_owned(),
                Want::Value | Want::NarrowerInterval => format!("{TITLE}: {riding}"),
            }),
        },
        _ => {
            let (value, interval, bar) = Default::default();
            let note = next_ride::note(c);
            Main { label, explained: explained(label), value, interval, bar, note }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::reason::{Reason, ReasonCode};

    #[test]
    fn a_lower_bound_says_what_to_ride_for_the_value() {
        let mut row = Coefficient {
            tyre: "rear".into(),
            coefficient: C::MfD.name().into(),
            unit: "1".into(),
            status: Status::LowerBound,
            ci95_low: Some(0.8),
            ..Coefficient::default()
        };
        let reason = Reason::new(ReasonCode::PeakNotReached, "the peak was not reached");
        row.explain(Some(reason.with_advice("brake to the limit")));
        let cards = cards(&SessionRow::default(), &[row]);
        let [Card { rows, .. }] = &cards[..] else { panic!("{cards:?}") };
        assert_eq!(rows[0].value, "at least 0.80");
        assert_eq!(rows[0].note, "Next ride: brake to the limit");
    }
}
