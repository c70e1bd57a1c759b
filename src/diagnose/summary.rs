//! A diagnosis in words for the terminal, the same on the road and off it: from its rows.

use std::fmt::Write;

use crate::contract::verdict::Verdict;
use crate::report::diagnosis::cause_labels;
use crate::report::diagnosis::outcome::refused;
use crate::report::readable::sized;
use crate::store::tables::rows::{CauseRow, DiscrepancyRow, Ident, SimulationError};

/// Most misfits that are listed.
const MISFITS: usize = 5;
/// Most channels that are listed as better simulated.
const GAINS: usize = 3;
/// Digits of a number that is not known more precisely.
const DIGITS: i32 = 4;

/// The verdict on a session, several lines of which the last is not ended. `alarm` is the largest score of
/// a candidate on the nominal model, and the score that a cause needs.
pub fn session(
    ident: &Ident,
    causes: &[CauseRow],
    discrepancies: &[DiscrepancyRow],
    errors: &[SimulationError],
    alarm: [f64; 2],
) -> String {
    let mut lines = vec![format!("{}  {}", ident.session_id, ident.bike_id)];
    let is_cause = |c: &&CauseRow| Verdict::from_name(&c.verdict).is_some_and(Verdict::is_cause);
    let named: Vec<&CauseRow> = causes.iter().filter(is_cause).collect();
    let unexplained = causes.iter().find(|c| c.verdict == Verdict::Unexplained.name());
    lines.extend(unnamed(causes, &named, unexplained, alarm));
    lines.extend(named.iter().map(|c| cause(c, alarm[1])));
    let gains = causes.iter().find_map(|c| c.gain_heldout.zip(c.gain_upper_bound));
    if let Some((gain, bound)) = gains {
        lines.push(format!(
            "On manoeuvres left out of the fit: 2 x log-likelihood gain {gain:.0}; with every candidate free {bound:.0}."
        ));
    }
    lines.extend(simulated(errors));
    if let (true, Some(_)) = (named.is_empty(), unexplained) {
        lines.extend(wrong(errors));
    }
    if let (false, Some(row)) = (named.is_empty(), unexplained) {
        lines.push(format!("The identified causes do not explain everything: {}.", row.reason));
    }
    lines.extend(misfits(discrepancies));
    lines.join("\n  ")
}

/// Text without causes: the largest score, and the rule that refused candidates with a high score.
fn unnamed(
    causes: &[CauseRow],
    named: &[&CauseRow],
    unexplained: Option<&CauseRow>,
    [largest, needed]: [f64; 2],
) -> Vec<String> {
    if !named.is_empty() {
        return Vec::new();
    }
    let blind = |c: &CauseRow| c.verdict == Verdict::NotIdentifiable.name();
    let score = format!(
        "the largest score is {largest:.1}; 19 of 20 fault-free simulations stay below 1, a cause needs {needed}"
    );
    let first = match unexplained {
        Some(row) => {
            format!("Something is wrong that no candidate explains: {} ({score}).", row.reason)
        }
        None if causes.iter().all(blind) => {
            format!("This ride can identify none of the {} candidates.", causes.len())
        }
        None => format!("No cause is identified: {score}."),
    };
    std::iter::once(first).chain(refused(causes)).collect()
}

/// An identified cause with its size and its equivalents; `needed` is the score that identifies a cause elsewhere.
fn cause(row: &CauseRow, needed: f64) -> String {
    let mut text = format!("{}: {}", row.effect, row.reason);
    let size = sized(row).map_or_else(
        || "size unknown".to_owned(),
        |(value, interval)| format!("{value}, 95 % interval {interval}"),
    );
    // writing to a string cannot fail
    let _ = write!(text, "\n      {size}; score {:.1}", row.score);
    if row.score <= needed {
        let _ = write!(text, " (below {needed}, but without it the fit is implausible)");
    }
    text
}

/// The structured misfits, those farthest beyond fault-free simulations first.
fn misfits(discrepancies: &[DiscrepancyRow]) -> Vec<String> {
    let mut structured: Vec<_> = discrepancies.iter().filter(|r| r.structured).collect();
    let ratio = |r: &DiscrepancyRow| r.rmse_base / r.null_largest;
    structured.sort_by(|a, b| ratio(b).total_cmp(&ratio(a)));
    let misfit = |row: &DiscrepancyRow| {
        let (unit, factor) = match row.unit.as_str() {
            "1" => (" standard deviations".to_owned(), 1.0),
            unit => shown(unit),
        };
        let number = |x: f64| significant(factor * x);
        let after =
            row.rmse_extended.map_or(String::new(), |r| format!(", {} with the causes", number(r)));
        let with = row.covariate.as_deref().map_or(String::new(), |c| {
            format!("; correlates with {c} ({:+.2})", row.correlation.unwrap_or(0.0))
        });
        format!(
            "misfit of {} while {}: {}{unit}, {} in fault-free simulations{after}{with}",
            row.channel,
            row.kind.replace('_', " "),
            number(row.rmse_base),
            number(row.noise_floor)
        )
    };
    structured.into_iter().take(MISFITS).map(misfit).collect()
}

/// Where the simulation of manoeuvres left out of the fit is wrong, and nothing is known that would mend it.
fn wrong(errors: &[SimulationError]) -> impl Iterator<Item = String> {
    SimulationError::stays_wrong(errors).into_iter().take(GAINS).map(|row| {
        let (unit, factor) = shown(&row.unit);
        format!(
            "simulated wrong: {} while {} {}{unit} (noise only {})",
            row.channel,
            row.kind.replace('_', " "),
            significant(factor * row.rmse_base),
            significant(factor * row.noise_floor)
        )
    })
}

/// Changes of the simulation of manoeuvres left out of the fit by the causes.
fn simulated(errors: &[SimulationError]) -> Vec<String> {
    let clause = |row: &SimulationError| {
        let (unit, factor) = shown(&row.unit);
        let number = |x: f64| significant(factor * x);
        format!(
            "{} while {} {} -> {}{unit} (noise only {})",
            row.channel,
            row.kind.replace('_', " "),
            number(row.rmse_base),
            row.rmse_extended.map_or("?".to_owned(), number),
            number(row.noise_floor)
        )
    };
    let gains = SimulationError::gains(errors);
    let share = SimulationError::explained(errors).map(|share| {
        let percent = (100.0 * share.max(0.0)).round();
        format!("The causes explain {percent} % of the simulation error beyond noise on manoeuvres left out.")
    });
    let better = gains.iter().take(GAINS).map(|row| format!("simulated: {}", clause(row)));
    let worse = errors.iter().find(|r| r.is_worse());
    let mut lines: Vec<String> = share
        .into_iter()
        .chain(better)
        .chain(worse.map(|row| format!("simulated worse: {}", clause(row))))
        .collect();
    if gains.is_empty() && errors.iter().any(|r| r.rmse_extended.is_some()) {
        let none = "The causes do not visibly improve the simulation of manoeuvres left out.";
        lines.insert(0, none.to_owned());
    }
    lines
}

/// Sentence for a pooled row of `causes`; `None` if it has no size.
pub(crate) fn pooled(row: &CauseRow) -> Option<String> {
    let (value, interval) = sized(row)?;
    Some(format!(
        "{} {}: {}\n      {value}, 95 % interval {interval}; {}",
        row.level,
        row.pooled_over.as_deref().unwrap_or(""),
        row.effect,
        row.reason
    ))
}

/// The unit that a residual or a signal is read in, with the blank before it, and the factor to it.
fn shown(si: &str) -> (String, f64) {
    let (unit, factor) = cause_labels::readable(si);
    match unit.as_str() {
        "" | "°" => (unit, factor),
        _ => (format!(" {unit}"), factor),
    }
}

/// A number with [`DIGITS`] digits.
fn significant(value: f64) -> String {
    let size = value.abs();
    if !value.is_finite() || size != 0.0 && !(1e-3..1e4).contains(&size) {
        return format!("{value:.*e}", DIGITS as usize - 1);
    }
    let before = if size > 0.0 { size.log10().floor() as i32 + 1 } else { 1 };
    format!("{value:.*}", (DIGITS - before).max(0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits() {
        let of = [0.02204, -5e-6, 1813.5154, 0.0, 12.0, 1e6];
        let texts = ["0.02204", "-5.000e-6", "1814", "0.000", "12.00", "1.000e6"];
        assert_eq!(of.map(significant), texts);
    }

    #[test]
    fn sizes_are_in_the_units_of_the_pages() {
        let late = CauseRow {
            effect: "latency".into(),
            verdict: "named".into(),
            value: Some(0.02059),
            ci95_low: Some(0.017),
            ci95_high: Some(0.02418),
            unit: "s".into(),
            score: 4.0,
            ..CauseRow::default()
        };
        let ratio =
            CauseRow { effect: "side_force_ratio_front".into(), unit: "1".into(), ..late.clone() };
        let text = session(&Ident::default(), &[late, ratio], &[], &[], [4.0, 1.75]);
        assert!(text.contains("20.6 ms, 95 % interval 17.0 to 24.2 ms; score 4.0"), "{text}");
        assert!(text.contains("0.0206, 95 % interval 0.0170 to 0.0242; score 4.0"), "{text}");
        assert_eq!(shown("rad"), ("°".to_owned(), 180.0 / std::f64::consts::PI));
        assert_eq!(shown("m/s"), (" m/s".to_owned(), 1.0));
    }

    #[test]
    fn a_session_without_a_name_says_how_large_the_largest_score_is() {
        let row = CauseRow { verdict: "not_needed".into(), ..CauseRow::default() };
        let text = session(&Ident::default(), &[row], &[], &[], [0.7, 1.75]);
        assert!(text.contains("No cause is identified: the largest score is 0.7"), "{text}");
        let late = CauseRow {
            effect: "latency".into(),
            verdict: "not_needed".into(),
            value: Some(0.0202),
            ci95_low: Some(0.0102),
            ci95_high: Some(0.0302),
            unit: "s".into(),
            score: 2.3,
            reason: "beyond what fault-free simulations show, but vague".into(),
            ..CauseRow::default()
        };
        let text = session(&Ident::default(), &[late], &[], &[], [2.3, 1.75]);
        let why = "latency: the velocity comes late, 20.2 ms, score 2.3; beyond what fault-free simulations show, but vague";
        assert!(text.ends_with(why), "{text}");
        let row = CauseRow { verdict: "not_identifiable".into(), ..CauseRow::default() };
        let text = session(&Ident::default(), &[row], &[], &[], [0.0, 1.75]);
        assert!(text.contains("identify none of the 1 candidates"), "{text}");
    }
}
