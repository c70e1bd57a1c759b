//! A diagnosis in words for the terminal.

use std::fmt::Write;

use super::cause::Cause;
use super::offroad::OffroadDiagnosis;
use super::road::RoadDiagnosis;
use super::tuning::RoadTuning;
use crate::contract::verdict::Verdict;
use crate::tables::rows::CauseRow;

/// Most parts of the misfit that are listed.
const TOLD: usize = 5;

/// Adds a line to a string, which cannot fail.
macro_rules! line {
    ($out:ident, $($text:tt)*) => {
        { let _ = writeln!($out, $($text)*); }
    };
}

/// The verdict in words.
pub fn road(d: &RoadDiagnosis) -> String {
    let mut out = String::new();
    let naming = &d.naming;
    let structure = naming.structure.as_ref();
    let structure = structure.map_or(String::new(), |s| format!(": {}", s.description));
    line!(out, "{}  {}", d.ident.session_id, d.ident.bike_id);
    let named: Vec<&Cause> = naming.named().collect();
    match (named.is_empty(), naming.unexplained) {
        (true, true) => line!(
            out,
            "  Something is wrong that no candidate explains{} (largest score of a candidate {:.1}; 19 of \
             20 nulls stay below 1).",
            structure,
            naming.alarm
        ),
        (true, false) if naming.alarm > RoadTuning::default().alarm => line!(
            out,
            "  Nothing is named. A candidate scores {:.1} (19 of 20 nulls stay below 1), but none has a size \
             that can be and gains enough.",
            naming.alarm
        ),
        (true, false) if naming.causes.iter().all(|c| c.verdict == Verdict::NotIdentifiable) => {
            line!(
                out,
                "  This ride can show none of the {} candidates: nothing can be said of what is wrong.",
                naming.causes.len()
            )
        }
        (true, false) => line!(
            out,
            "  Nothing is wrong that this ride could show: the largest score is {:.1} (19 of 20 nulls stay \
             below 1).",
            naming.alarm
        ),
        (false, true) => line!(out, "  Something more is wrong than is named{}.", structure),
        (false, false) => {}
    }
    for cause in &named {
        describe_cause(&mut out, d, cause);
    }
    if let Some(row) = d.causes.iter().find(|r| r.gain_heldout.is_some())
        && let (Some(gain), Some(bound)) = (row.gain_heldout, row.gain_upper_bound)
    {
        line!(
            out,
            "  On manoeuvres left out it gains {gain:.0}; with every candidate free {bound:.0}."
        );
    }
    list_misfits(&mut out, d);
    out.truncate(out.trim_end().len());
    out
}

/// A named cause with its size, and what the ride cannot tell it from.
fn describe_cause(out: &mut String, d: &RoadDiagnosis, cause: &Cause) {
    let half = 1.96 * cause.std_error();
    line!(
        out,
        "  {}: {}\n      {:.4} {}, 95 % interval {:.4} to {:.4}; score {:.1}, gain {:.0}",
        cause.candidate.name,
        cause.candidate.sentence,
        cause.value(),
        cause.candidate.unit,
        cause.value() - half,
        cause.value() + half,
        cause.score,
        cause.gain
    );
    if cause.verdict == Verdict::Ambiguous {
        let row = d.causes.iter().find(|r| r.effect == cause.candidate.name);
        line!(
            out,
            "      or {}: this ride cannot tell; what would: {}",
            cause.equivalent.join(" or "),
            row.and_then(|r| r.separate_by.as_deref()).unwrap_or(cause.candidate.separate_by)
        );
    }
}

/// The largest structured residuals, in units of what null simulations show.
fn list_misfits(out: &mut String, d: &RoadDiagnosis) {
    let mut wrong: Vec<_> = d.discrepancies.iter().filter(|r| r.structured).collect();
    wrong.sort_by(|a, b| (b.rmse_base / b.null_largest).total_cmp(&(a.rmse_base / a.null_largest)));
    for row in wrong.into_iter().take(TOLD) {
        let after =
            row.rmse_extended.map_or(String::new(), |r| format!(", {r:.4} with the causes"));
        let with = row.covariate.as_deref().map_or(String::new(), |c| {
            format!(", goes with {c} ({:+.2})", row.correlation.unwrap_or(0.0))
        });
        line!(
            out,
            "  misfit of {} while {}: {:.4}{} against {:.4} in nulls{after}{with}",
            row.channel,
            row.kind.replace('_', " "),
            row.rmse_base,
            if row.unit == "1" { " sd".to_owned() } else { format!(" {}", row.unit) },
            row.noise_floor
        );
    }
}

/// What several sessions share, of a pooled row of `causes`; `None` of one without a size.
pub fn pooled(row: &CauseRow) -> Option<String> {
    let (value, low, high) = (row.value?, row.ci95_low?, row.ci95_high?);
    Some(format!(
        "{} {}: {}\n      {value:.4} {}, 95 % interval {low:.4} to {high:.4}; {}",
        row.level,
        row.pooled_over.as_deref().unwrap_or(""),
        row.effect,
        row.unit,
        row.reason
    ))
}

/// An off-road session's verdict, several lines.
pub fn offroad(d: &OffroadDiagnosis) -> String {
    let mut out = format!("{}  {}\n", d.ident.session_id, d.ident.bike_id);
    let named = |verdict: &str| Verdict::from_name(verdict).is_some_and(Verdict::is_cause);
    if !d.causes.iter().any(|c| named(&c.verdict)) {
        line!(
            out,
            "  No cause is named: the largest score is {:.1} (19 of 20 nulls stay below 1).",
            d.naming.alarm
        );
    }
    for c in d.causes.iter().filter(|c| named(&c.verdict)) {
        let number = |v: Option<f64>| v.map_or("?".to_owned(), |v| format!("{v:.3}"));
        line!(
            out,
            "  {}: {}\n      {} {}, 95 % interval {} to {}; score {:.1}",
            c.effect,
            c.reason,
            number(c.value),
            c.unit,
            number(c.ci95_low),
            number(c.ci95_high),
            c.score
        );
    }
    if let Some(row) = d.causes.first()
        && let (Some(gain), Some(bound)) = (row.gain_heldout, row.gain_upper_bound)
    {
        line!(
            out,
            "  On jumps, whoops and corners left out it gains {gain:.0}; with every candidate free \
             {bound:.0}."
        );
    }
    for c in d.causes.iter().filter(|c| c.verdict == Verdict::Unexplained.name()) {
        line!(out, "  Not explained: {}", c.reason);
    }
    for c in d.causes.iter().filter(|c| c.verdict == Verdict::NotIdentifiable.name()) {
        line!(out, "  {}: {}", c.effect, c.reason);
    }
    let mut wrong: Vec<_> = d.discrepancies.iter().filter(|r| r.structured).collect();
    wrong.sort_by(|a, b| (b.rmse_base / b.null_largest).total_cmp(&(a.rmse_base / a.null_largest)));
    for row in wrong.into_iter().take(TOLD) {
        let after =
            row.rmse_extended.map_or(String::new(), |r| format!(", {r:.0} with the causes"));
        line!(
            out,
            "  misfit of {} while {}: {:.0} {} against {:.0} in nulls{after}",
            row.channel,
            row.kind.replace('_', " "),
            row.rmse_base,
            row.unit,
            row.noise_floor
        );
    }
    out.truncate(out.trim_end().len());
    out
}
