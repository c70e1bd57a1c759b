//! What a run gave, in sentences: the first thing that the terminal says.

use std::collections::{BTreeMap, BTreeSet};

use crate::contract::coefficient::{Coefficient as C, Part};
use crate::contract::warning::OUTLYING_MANOEUVRE;
use crate::report::coefficient_text::CoefficientText;
use crate::report::labels;
use crate::report::next_ride::{self, Want};
use crate::statistics::number_format;
use crate::store::tables::rows::{Coefficient, SessionRow, Status, WarningRow};

/// Main numbers of a tyre, in the order of the sentence, with its short term.
pub(crate) const ASKED: [(C, &str); 7] = [
    asked_of(C::MfD),
    asked_of(C::CorneringStiffness0),
    asked_of(C::CamberStiffness0),
    asked_of(C::OverturningStiffness),
    asked_of(C::EffectiveRollingRadius),
    asked_of(C::EngagedFrictionBraking),
    asked_of(C::EngagedFrictionDriving),
];

const fn asked_of(coefficient: C) -> (C, &'static str) {
    (coefficient, coefficient.spec().short)
}

/// Meanings of these words, for who hovers over them.
const EXPLAINED: [(&str, &str); 8] = [
    ("peak friction", "Largest longitudinal force over the wheel's load, on the road of the ride"),
    ("cornering stiffness", "Side force per slip angle over the load, upright, per radian"),
    ("camber stiffness", "Side force per lean of the wheel over the load, upright, per radian"),
    (
        "crown radius",
        "Radius of the tyre's cross-section: how far the contact moves sideways with lean",
    ),
    ("rolling radius", "Distance per turn of the free rolling wheel, over two pi"),
    ("friction braking", "Longitudinal force over load that braking reached off the road"),
    ("friction driving", "Longitudinal force over load that driving reached off the road"),
    ("slip stiffness", "Longitudinal force per slip ratio over the load, at small slips"),
];

/// Meanings of the words of [`ASKED`].
pub(crate) fn explained(words: &str) -> &'static str {
    EXPLAINED.iter().find(|(w, _)| *w == words).map_or("", |(_, text)| text)
}

/// Asked of the tyre where its peak friction is not known.
const INSTEAD: (C, &str) = asked_of(C::SlipStiffness);
/// Advice that is given.
const ADVICE: usize = 2;
/// Warnings that are written out.
const WARNINGS: usize = 3;
/// Manoeuvres unlike the others that are written out.
pub(crate) const FINDINGS: usize = 3;

/// A sentence for each tyre of one session, and what to ride for what is missing.
pub(crate) fn of_session(rows: &[Coefficient]) -> Vec<String> {
    let mut out = Vec::new();
    for part in [Part::Front, Part::Rear] {
        let mut known = Vec::new();
        for (row, words) in asked(rows, part) {
            let text = CoefficientText::of(row);
            let unit = labels::unit(&row.unit);
            let unit = if unit.is_empty() { unit } else { format!(" {unit}") };
            match row.status {
                Status::Ok => {
                    known.push(format!("{words} {}{unit} ({})", text.value, text.interval(" to ")));
                }
                Status::LowerBound => known.push(format!("{words} {}{unit}", text.interval(""))),
                _ => {}
            }
        }
        if rows.iter().any(|r| r.tyre == part.name()) {
            let known = if known.is_empty() { "not determined".into() } else { known.join(", ") };
            out.push(format!("{}: {known}.", labels::tyre(part.name())));
        }
    }
    out.extend(advice(rows));
    out
}

/// Main numbers of a tyre, as far as there are rows of it.
fn asked(rows: &[Coefficient], part: Part) -> Vec<(&Coefficient, &'static str)> {
    let own = |c: C| rows.iter().find(|r| r.tyre == part.name() && r.coefficient == c.name());
    let peak = own(C::MfD).is_some_and(|r| r.status == Status::Ok);
    let instead = (!peak).then_some(INSTEAD);
    let all = ASKED.into_iter().chain(instead);
    all.filter_map(|(coefficient, words)| Some((own(coefficient)?, words))).collect()
}

/// Missing coefficients and the riding that gives them, with the words of what lacks it and the tyres.
type Wanted<'a, T> = BTreeMap<(Want, &'a str), (Vec<&'a str>, BTreeSet<T>)>;

/// Riding advice for what a session lacks, and for what it knows badly, in sentences.
pub(crate) fn advice(rows: &[Coefficient]) -> Vec<String> {
    let mut wanted: Wanted<'_, &str> = Wanted::new();
    for (row, words) in [Part::Front, Part::Rear].into_iter().flat_map(|part| asked(rows, part)) {
        if let Some(want) = next_ride::of(row) {
            let (what, tyres) = wanted.entry(want).or_default();
            tyres.insert(&row.tyre);
            if !what.contains(&words) {
                what.push(words);
            }
        }
    }
    // what is narrower comes with the value
    let given: Vec<&str> =
        wanted.keys().filter(|(want, _)| *want == Want::Value).map(|(_, riding)| *riding).collect();
    wanted.retain(|(want, riding), _| *want != Want::NarrowerInterval || !given.contains(riding));
    let mut wanted: Vec<_> = wanted.into_iter().collect();
    wanted.sort_by_key(|((want, _), (what, _))| (*want, std::cmp::Reverse(what.len())));
    let mut out = Vec::new();
    for ((want, riding), (what, tyres)) in wanted.into_iter().take(ADVICE) {
        let what = match tyres.first() {
            Some(tyre) if tyres.len() == 1 => format!("{} of the {tyre} tyre", listed(&what)),
            _ => listed(&what),
        };
        out.push(format!("{}.", next_ride::sentence(want, &what, riding)));
    }
    out
}

/// Words as a list: "a, b and c".
fn listed(words: &[&str]) -> String {
    match words {
        [] => String::new(),
        [one] => (*one).to_owned(),
        [all @ .., last] => format!("{} and {last}", all.join(", ")),
    }
}

/// The coefficients of a session that are not from its ride, by the names of the tables; none where all are.
pub(crate) fn assumed(rows: &[Coefficient]) -> Option<String> {
    let is_assumed = |row: &&Coefficient| row.status == Status::Assumed;
    let mut parts: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    let mut order: Vec<&str> = Vec::new();
    for row in rows.iter().filter(is_assumed) {
        let of = parts.entry(&row.coefficient).or_default();
        of.push(&row.tyre);
        if of.len() == 1 {
            order.push(&row.coefficient);
        }
    }
    let mut by: BTreeMap<(usize, &[&str]), Vec<&str>> = BTreeMap::new();
    for name in order {
        let of = parts[name].as_slice();
        by.entry((of.len(), of)).or_default().push(name);
    }
    let whose = |of: &[&str]| match of {
        ["front", "rear"] => "both tyres".to_owned(),
        of => of.join(", "),
    };
    // those of both tyres first
    let groups: Vec<String> = by
        .iter()
        .rev()
        .map(|((_, of), names)| format!("{} ({})", names.join(", "), whose(of)))
        .collect();
    (!groups.is_empty()).then(|| format!("Assumed, not from this ride: {}.", groups.join("; ")))
}

/// Which of the numbers that people ask of a tyre a session determines, and for which it has a lower bound alone.
pub(crate) fn determined(rows: &[Coefficient]) -> String {
    let [front, rear] = [Part::Front, Part::Rear].map(|part| asked(rows, part));
    let is = |tyre: &[(&Coefficient, &str)], words: &str, status: Status| {
        tyre.iter().any(|(row, w)| *w == words && row.status == status)
    };
    let mut groups: [(&str, Vec<&str>); 4] = [
        ("for both tyres", Vec::new()),
        ("for the front tyre alone", Vec::new()),
        ("for the rear tyre alone", Vec::new()),
        ("for neither", Vec::new()),
    ];
    let mut bounded = Vec::new();
    for (_, words) in ASKED.into_iter().chain([INSTEAD]) {
        if !front.iter().chain(&rear).any(|(_, w)| *w == words) {
            continue;
        }
        let of = |status| [&front, &rear].map(|tyre| is(tyre, words, status));
        // a tyre whose peak was not reached has no peak, however low the bound is
        let bounds = of(Status::LowerBound);
        match bounds {
            [true, true] => bounded.push(format!("{words} of both tyres")),
            [true, false] => bounded.push(format!("{words} of the front tyre")),
            [false, true] => bounded.push(format!("{words} of the rear tyre")),
            [false, false] => {}
        }
        let place = match of(Status::Ok) {
            [true, true] => 0,
            [true, false] => 1,
            [false, true] => 2,
            [false, false] if bounds.contains(&true) => continue,
            [false, false] => 3,
        };
        groups[place].1.push(words);
    }
    let mut said = if groups[..3].iter().all(|(_, words)| words.is_empty()) {
        "Nothing that is asked of a tyre first is determined.".to_owned()
    } else {
        let parts = groups.iter().filter(|(_, words)| !words.is_empty());
        let parts: Vec<String> =
            parts.map(|(whose, words)| format!("{whose}: {}", words.join(", "))).collect();
        format!("Determined {}.", parts.join("; "))
    };
    if !bounded.is_empty() {
        said.push_str(&format!(" A lower bound alone: {}.", bounded.join(", ")));
    }
    said
}

/// How many tyres of all sessions have each of the numbers, in a sentence, and what would tell more.
pub(crate) fn of_batch(sessions: &[SessionRow], rows: &[Coefficient]) -> Vec<String> {
    let mut known = Vec::new();
    let mut wanted: Wanted<'_, (&str, &str, &str)> = Wanted::new();
    let mut tyres: BTreeSet<(&str, &str, &str)> = BTreeSet::new();
    for (coefficient, words) in ASKED {
        let own = |r: &&Coefficient| {
            r.coefficient == coefficient.name()
                && [Part::Front.name(), Part::Rear.name()].contains(&r.tyre.as_str())
        };
        let all: Vec<&Coefficient> = rows.iter().filter(own).collect();
        let ok = all.iter().filter(|r| r.status == Status::Ok).count();
        for row in &all {
            let tyre = (&*row.ident.bike_id, &*row.ident.session_id, &*row.tyre);
            tyres.insert(tyre);
            if let Some(want) = next_ride::of(row) {
                let (what, of) = wanted.entry(want).or_default();
                of.insert(tyre);
                if !what.contains(&words) {
                    what.push(words);
                }
            }
        }
        if !all.is_empty() {
            known.push(format!("{words} {ok} of {}", all.len()));
        }
    }
    let mut out = Vec::new();
    if !known.is_empty() {
        let sessions = number_format::count(sessions.len(), "session");
        out.push(format!("Tyres of {sessions} with {}.", known.join(", ")));
    }
    // what most lack; where nothing is missing, what most know badly
    let most =
        wanted.into_iter().min_by_key(|((want, _), (_, of))| (*want, std::cmp::Reverse(of.len())));
    if let Some(((want, riding), (what, of))) = most {
        let what = format!("{} (of {} of {} tyres)", listed(&what), of.len(), tyres.len());
        out.push(format!("{}.", next_ride::sentence(want, &what, riding)));
    }
    out
}

/// The warnings of one session, or how many sessions have which ones with an example.
pub(crate) fn of_warnings(warnings: &[WarningRow]) -> Vec<String> {
    let sessions: BTreeSet<&str> = warnings.iter().map(|w| w.ident.session_id.as_str()).collect();
    let mut by_code: BTreeMap<&str, Vec<&WarningRow>> = BTreeMap::new();
    for warning in warnings {
        by_code.entry(&warning.code).or_default().push(warning);
    }
    let mut codes: Vec<(&str, Vec<&WarningRow>)> = by_code.into_iter().collect();
    codes.sort_by_key(|(_, all)| std::cmp::Reverse(all.len()));
    let left = codes.len().saturating_sub(WARNINGS);
    let say = |(code, all): (&str, Vec<&WarningRow>)| -> Vec<String> {
        let Some(first) = all.first() else { return Vec::new() };
        let of: BTreeSet<&str> = all.iter().map(|w| w.ident.session_id.as_str()).collect();
        match (sessions.len(), all.len()) {
            // each is another finding
            (1, n) if n == 1 || code == OUTLYING_MANOEUVRE => {
                let said = all.iter().take(FINDINGS);
                let mut said: Vec<String> =
                    said.map(|w| format!("Warning ({code}): {}", w.message)).collect();
                if n > FINDINGS {
                    said.push(format!("{} more of these: table `{code}s`.", n - FINDINGS));
                }
                said
            }
            (1, n) => vec![format!("Warning ({code}, {n} times): {}", first.message)],
            _ => vec![format!(
                "Warning ({code}, {}), as of {}: {}",
                number_format::count(of.len(), "session"),
                first.ident.session_id,
                first.message
            )],
        }
    };
    let mut out: Vec<String> = codes.into_iter().take(WARNINGS).flat_map(say).collect();
    if left > 0 {
        out.push(format!("{} more: table `warnings`.", number_format::count(left, "kind")));
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::Ident;

    fn row(tyre: &str, c: C, status: Status, [value, low, high]: [Option<f64>; 3]) -> Coefficient {
        Coefficient {
            tyre: tyre.into(),
            coefficient: c.name().into(),
            unit: c.spec().unit.into(),
            status,
            value,
            ci95_low: low,
            ci95_high: high,
            advice: Some("ride corners".into()),
            ..Coefficient::default()
        }
    }

    #[test]
    fn a_session_has_a_sentence_for_each_tyre_and_what_to_ride() {
        let some = [Some(1.052), Some(1.02), Some(1.083)];
        let rows = [
            row("front", C::MfD, Status::Ok, some),
            row("rear", C::MfD, Status::LowerBound, [None, Some(0.8), None]),
            row("front", C::CorneringStiffness0, Status::PoorlyDetermined, some),
            row("rear", C::CamberStiffness0, Status::NotAvailable, [None; 3]),
        ];
        let said = of_session(&rows);
        assert_eq!(
            said,
            [
                "Front tyre: peak friction 1.052 (1.020 to 1.083).",
                "Rear tyre: peak friction at least 0.80.",
                "Next ride, for cornering stiffness, peak friction and camber stiffness: ride corners.",
            ]
        );
        assert_eq!(
            determined(&rows),
            "Determined for the front tyre alone: peak friction; for neither: cornering stiffness, camber stiffness. \
             A lower bound alone: peak friction of the rear tyre."
        );
        assert!(determined(&rows[2..]).starts_with("Nothing"));
        let batch = of_batch(&[], &rows);
        assert!(batch[0].contains("peak friction 1 of 2, cornering stiffness 0 of 1"), "{batch:?}");
        assert_eq!(
            batch[1],
            "Next ride, for peak friction, cornering stiffness and camber stiffness (of 2 of 2 tyres): ride corners."
        );
    }

    /// What is assumed of both tyres is said once.
    #[test]
    fn what_is_assumed_is_said_by_name() {
        let assumed_of = |tyre, c| row(tyre, c, Status::Assumed, [Some(0.2), None, None]);
        let rows = [
            assumed_of("front", C::MfE2),
            assumed_of("front", C::RelaxationLength),
            row("front", C::MfD, Status::Ok, [Some(1.0); 3]),
            assumed_of("rear", C::RelaxationLength),
        ];
        assert_eq!(
            assumed(&rows).as_deref(),
            Some("Assumed, not from this ride: relaxation_length (both tyres); mf_e2 (front).")
        );
        assert_eq!(assumed(&rows[2..3]), None);
    }

    /// A bound says that a peak was not reached: neither the sentence nor the advice takes it for a value.
    #[test]
    fn a_bounded_peak_is_not_determined_and_has_its_advice() {
        let bound = |tyre| row(tyre, C::MfD, Status::LowerBound, [None, Some(0.06), None]);
        let nothing = "Nothing that is asked of a tyre first is determined.";
        assert_eq!(
            determined(&[bound("rear")]),
            format!("{nothing} A lower bound alone: peak friction of the rear tyre.")
        );
        assert_eq!(
            determined(&[bound("front"), bound("rear")]),
            format!("{nothing} A lower bound alone: peak friction of both tyres.")
        );
        assert_eq!(
            advice(&[bound("rear")]),
            ["Next ride, for peak friction of the rear tyre: ride corners."]
        );
    }

    #[test]
    fn every_word_that_is_asked_is_explained() {
        for (_, words) in ASKED.into_iter().chain([INSTEAD]) {
            assert!(!explained(words).is_empty(), "{words}");
        }
    }

    #[test]
    fn warnings_are_counted_by_code_the_most_frequent_first() {
        let warning = |session: &str, code: &str| WarningRow {
            ident: Ident { session_id: session.into(), ..Ident::default() },
            code: code.into(),
            message: format!("{code} of {session}"),
            ..WarningRow::default()
        };
        let rows = [warning("a", "gap"), warning("b", "gap"), warning("a", "clock")];
        assert_eq!(
            of_warnings(&rows),
            [
                "Warning (gap, 2 sessions), as of a: gap of a",
                "Warning (clock, 1 session), as of a: clock of a"
            ]
        );
        assert_eq!(of_warnings(&rows[2..]), ["Warning (clock): clock of a"]);
        // each of one ride's odd manoeuvres is said, the first few of many
        let odd = |n: usize| of_warnings(&vec![warning("a", OUTLYING_MANOEUVRE); n]);
        assert_eq!(odd(FINDINGS).len(), FINDINGS);
        let many = odd(FINDINGS + 2);
        assert_eq!(many.len(), FINDINGS + 1);
        assert_eq!(many[FINDINGS], "2 more of these: table `outlying_manoeuvres`.");
        assert!(of_warnings(&[]).is_empty());
    }
}
