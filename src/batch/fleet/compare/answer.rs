//! The answer of a comparison, in sentences: the same on the terminal and on the page.

use std::collections::BTreeMap;

use super::words::{noun, percent};
use super::{Chosen, Comparison};
use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::{MODEL, RIDES, TYRES};
use crate::fleet::compare::Verdict;
use crate::report::next_ride::TITLE;
use crate::statistics::number_format::count;
use crate::store::tables::rows::ComparisonRow;

/// Sentences of differences before the rest is counted.
const SENTENCES: usize = 3;

/// Coefficients of the first sentence.
const FIRST: [C; 9] = [
    C::MfD,
    C::CorneringStiffness0,
    C::LateralFrictionCt,
    C::SlipStiffness,
    C::CamberStiffness0,
    C::PeakSlip,
    C::Drag,
    C::RollingResistance,
    C::OverturningStiffness,
];

/// A side in a line.
pub(crate) fn about(side: &Chosen) -> String {
    let mut text = format!("{}, {}", side.text, count(side.sessions.len(), "session"));
    let bikes: Vec<&str> = side.bikes().into_iter().collect();
    match bikes.as_slice() {
        [bike] => text += &format!(" of {bike}"),
        all => text += &format!(" of {}", count(all.len(), "motorcycle")),
    }
    match &side.days {
        Some([first, last]) if first == last => text += &format!(", {first}"),
        Some([first, last]) => text += &format!(", {first} to {last}"),
        None => {}
    }
    text
}

/// The answer in sentences, the most asked first.
pub(crate) fn answer(found: &Comparison, same_tyres: bool) -> Vec<String> {
    let is = |row: &ComparisonRow, verdict: Verdict| row.verdict == verdict.name();
    let mut differ: Vec<&ComparisonRow> = found
        .rows
        .iter()
        .filter(|row| is(row, Verdict::Larger) || is(row, Verdict::Smaller))
        .collect();
    let none = found.rows.iter().filter(|row| is(row, Verdict::NoDifference)).count();
    differ.sort_by_key(|row| {
        // who fits other tyres knows that their radius is another
        let last = FIRST.len() + usize::from(row.coefficient == C::EffectiveRollingRadius.name());
        FIRST.iter().position(|c| c.name() == row.coefficient).unwrap_or(last)
    });
    let friction: Vec<&ComparisonRow> = found
        .rows
        .iter()
        .filter(|row| row.coefficient == C::MfD.name() && is(row, Verdict::NoDifference))
        .collect();
    let mut out: Vec<String> =
        differ.iter().take(SENTENCES).map(|row| row.sentence.clone()).collect();
    if !friction.is_empty() {
        let ends = |row: &&ComparisonRow| {
            let [low, high] = [row.relative_low, row.relative_high].map(Option::unwrap_or_default);
            format!("{} {} to {} %", row.tyre, percent(low), percent(high))
        };
        let ends: Vec<String> = friction.iter().map(ends).collect();
        let larger = |row: &&ComparisonRow| {
            row.probability_larger.map(|p| format!("{} {}", row.tyre, chance(p)))
        };
        let larger: Vec<String> = friction.iter().filter_map(larger).collect();
        let ends = ends.join(", ");
        // the first question
        let mut said = format!("No difference in peak friction is seen (95 %: {ends})");
        if !larger.is_empty() {
            said += &format!("; probability that B has more: {}", larger.join(", "));
        }
        out.insert(0, format!("{said}."));
    }
    if differ.is_empty() && none == 0 {
        return vec![
            "Nothing can be compared: no coefficient is determined on both sides.".to_owned(),
        ];
    }
    let what = if out.is_empty() { "coefficient" } else { "other coefficient" };
    let rest = none - friction.len();
    let unseen = count(rest, what);
    match (differ.len().saturating_sub(SENTENCES), rest) {
        (0, 0) => {}
        (0, _) => out.push(format!("No difference is seen in {unseen}.")),
        (more, 0) => out.push(format!("{more} more differ.")),
        (more, _) => out.push(format!("{more} more differ; no difference is seen in {unseen}.")),
    }
    let [a, b] = &found.sides;
    let both: Vec<&str> = a.bikes().intersection(&b.bikes()).copied().collect();
    out.push(
        match (both.is_empty(), a.bikes() == b.bikes()) {
            (true, _) => {
                "A and B are different motorcycles: the errors of their bike files do not cancel."
            }
            (_, true) => "Both are the same motorcycle: errors that its sessions share cancel.",
            _ => "Some motorcycles are on both sides: errors that their sessions share cancel.",
        }
        .to_owned(),
    );
    let unnamed = |side: &Chosen| side.tyres.iter().any(|t| t.iter().any(Option::is_none));
    if !both.is_empty() && !same_tyres && (unnamed(a) || unnamed(b)) {
        out.push(
            "The logs do not say which tyres were on: they count as two sets (--same-tyres: one)."
                .to_owned(),
        );
    }
    let tested = found.rows.iter().filter(|row| row.difference.is_some()).count();
    let doubtful =
        differ.iter().filter(|row| row.false_discovery_rate.is_some_and(|q| q > 0.1)).count();
    if doubtful > 0 {
        out.push(format!(
            "Of {tested} comparisons about one in twenty differs by chance: {doubtful} of those that differ may."
        ));
    }
    let few = found.rows.iter().filter(|row| row.between_assumed == Some(true)).count();
    if few * 2 > tested {
        out.push(
            "There are too few sessions to see their spread: 2 % are assumed (`between_sd` of the table)."
                .to_owned(),
        );
    }
    out
}

/// A probability; none is certain.
fn chance(p: f64) -> String {
    match 100.0 * p {
        p if p > 99.0 => ">99 %".to_owned(),
        p if p < 1.0 => "<1 %".to_owned(),
        p => format!("{p:.0} %"),
    }
}

/// Sessions that would decide the open comparisons, a paragraph each; lines that belong to one begin with two spaces.
pub(crate) fn undecided(rows: &[&ComparisonRow]) -> Vec<Vec<String>> {
    let open = rows.iter().filter(|row| row.verdict == Verdict::NoDifference.name());
    let (mut shown, mut limited) = (Vec::new(), Vec::new());
    let mut by_riding: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in open {
        let who = format!("{} {}", row.tyre, noun(&row.coefficient));
        let seen = row.more_sessions_for_seen;
        let text = match row.more_sessions_for_5_percent {
            Some(0) => {
                shown.push(who);
                continue;
            }
            Some(n) => format!("{who} {}", sessions(n)),
            // what has no per cent has no 5 of them either
            None if seen.is_some_and(|n| n <= SENSIBLE) => format!("{who} -"),
            None => {
                limited.push(format!("{who} ({})", row.limited_by.as_deref().unwrap_or("rides")));
                continue;
            }
        };
        let seen = seen.map_or("-".to_owned(), sessions);
        by_riding
            .entry(row.advice.as_deref().unwrap_or("any riding"))
            .or_default()
            .push(format!("{text} ({seen})"));
    }
    let mut out = Vec::new();
    if !shown.is_empty() {
        out.push(vec![format!("A difference of 5 % would have shown: {}.", shown.join(", "))]);
    }
    if !by_riding.is_empty() {
        let mut paragraph = vec![format!(
            "{TITLE}: how many sessions more on each side, such as these and with this riding, decide 5 % (in brackets: \
                 the difference seen):"
        )];
        let lines = by_riding.iter().map(|(riding, all)| format!("  {riding}: {}", all.join(", ")));
        paragraph.extend(lines);
        out.push(paragraph);
    }
    if !limited.is_empty() {
        let is_open = |row: &&&ComparisonRow| {
            row.verdict == Verdict::NoDifference.name() && row.more_sessions_for_5_percent.is_none()
        };
        let by: Vec<&str> =
            rows.iter().filter(is_open).filter_map(|row| row.limited_by.as_deref()).collect();
        let mut hint = String::new();
        if by.contains(&TYRES) {
            hint += " Sessions on more tyres of each side would.";
        }
        if by.iter().any(|by| ![MODEL, RIDES, TYRES].contains(by)) {
            hint += " Numbers of the bike file can be measured better.";
        }
        let text = limited.join(", ");
        out.push(vec![format!(
            "No number of such sessions decides, for what limits them (in brackets): {text}.{hint}"
        )]);
    }
    out
}

/// More sessions than these are no plan.
const SENSIBLE: i64 = 99;

fn sessions(n: i64) -> String {
    if n > SENSIBLE { format!(">{SENSIBLE}") } else { n.to_string() }
}

/// Coefficients without a value on one side, a line per reason.
pub(crate) fn not_comparable(rows: &[&ComparisonRow]) -> Vec<String> {
    let mut by_reason: BTreeMap<&str, Vec<String>> = BTreeMap::new();
    for row in rows {
        let who = format!("{} {}", row.tyre, noun(&row.coefficient));
        by_reason.entry(row.sentence.trim_end_matches('.')).or_default().push(who);
    }
    by_reason.iter().map(|(reason, all)| format!("{} ({reason})", all.join(", "))).collect()
}
