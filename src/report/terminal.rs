//! What a run prints on stdout: plain text as wide as the terminal, 100 columns elsewhere, no control characters.

use std::collections::{BTreeMap, BTreeSet};

use crate::contract::coefficient::Coefficient as C;
use crate::contract::instant;
use crate::report::answer;
use crate::report::as_read;
use crate::report::coefficient_text::CoefficientText;
use crate::report::labels;
use crate::statistics::number_format::{self, fixed};
use crate::statistics::order::median_of_finite;
use crate::store::tables::rows::{Coefficient, Rejected, SessionRow, Status, WarningRow};

/// Columns where there is no terminal.
pub(crate) const WIDTH: usize = 100;
/// Columns from which the standard errors have a column of their own.
const WIDE: usize = 99;
/// Columns from which the short terms of the coefficients have one, too.
const WITH_TERMS: usize = 120;

/// The main coefficients, one column each in the batch's summary.
const MAIN: [(C, &str); 5] = [
    (C::EffectiveRollingRadius, "rolling r, m"),
    (C::MfD, "friction"),
    (C::CorneringStiffness0, "cornering"),
    (C::CamberStiffness0, "camber"),
    (C::OverturningStiffness, "crown r, m"),
];

/// Those of off-road sessions.
const OFFROAD: [(C, &str); 2] =
    [(C::EngagedFrictionBraking, "braking B/N"), (C::EngagedFrictionDriving, "driving D/N")];

/// One session: who, what it gives in sentences, its warnings, and every coefficient with its interval, by tyre; under those
/// that are not determined, why. Lines of at most `width` characters, 80 or more.
pub fn summary(
    session: &SessionRow,
    coefficients: &[Coefficient],
    warnings: &[WarningRow],
    width: usize,
) -> String {
    let mut out = String::new();
    line(&mut out, &heading(session));
    let mut read = coefficients.to_vec();
    read.iter_mut().for_each(as_read::coefficient);
    sentences(&mut out, &answer::of_session(&read), width);
    let verdict = labels::verdict(coefficients.iter().map(|c| c.status));
    let (used, all) = (session.n_used, session.n_manoeuvres);
    let counted = number_format::count(usize::try_from(session.n_warnings).unwrap_or(0), "warning");
    let verdict = format!("{verdict}; {used} of {all} manoeuvres used; {counted}.");
    sentences(&mut out, &[verdict], width);
    sentences(&mut out, &answer::assumed(coefficients).into_iter().collect::<Vec<_>>(), width);
    sentences(&mut out, &answer::of_warnings(warnings), width);
    let mut rows: Vec<&Coefficient> = coefficients.iter().collect();
    rows.sort_by_key(|c| labels::order(&c.tyre, &c.coefficient));
    let mut tyre = "";
    for (i, c) in rows.iter().enumerate() {
        if c.tyre != tyre {
            tyre = &c.tyre;
            line(&mut out, "");
            let tyre = clean(labels::tyre(tyre));
            let head = match width >= WIDE {
                true => format!(
                    "{tyre:<26}{:>11}   {:<10}{:>22}  {:<6}  status",
                    "value", "std error", "95 % interval", "unit"
                ),
                false => {
                    format!("{tyre:<26}{:>9} {:>19} {:<5} status", "value", "95 % interval", "unit")
                }
            };
            line(&mut out, &with_term(&head, "term", width));
        }
        let mut read = (*c).clone();
        as_read::coefficient(&mut read);
        let shown = CoefficientText::of(&read);
        let short = C::from_name(&c.coefficient).map_or("", |c| c.spec().short);
        let (name, short) = match read.symbol == c.symbol {
            true => (c.coefficient.clone(), short),
            false => (format!("{}, kappa", c.coefficient), "slip ratio of peak"),
        };
        let sign = if shown.std_error.is_empty() { ' ' } else { '±' };
        let value = if shown.value.is_empty() { "-" } else { &shown.value };
        let (name, unit) = (clean(&name), clean(&labels::unit(&c.unit)));
        let (interval, status) = (shown.interval(" to "), c.status.words());
        let row = match width >= WIDE {
            true => format!(
                "  {name:<24}{value:>11} {sign} {:<10}{interval:>22}  {unit:<6}  {status}",
                shown.std_error
            ),
            false => format!("  {name:<24}{value:>9} {interval:>19} {unit:<5} {status}"),
        };
        line(&mut out, &with_term(&row, short, width));
        // once under those that share it
        let shared = rows.get(i + 1).is_some_and(|next| {
            (&next.tyre, next.status, labels::why(next)) == (&c.tyre, c.status, labels::why(c))
        });
        if c.status != Status::Ok
            && !shared
            && let Some(reason) = labels::why(&read)
        {
            for text in wrap(&clean(&reason), width - 6) {
                line(&mut out, &format!("      {text}"));
            }
        }
    }
    out
}

/// A line of the table with its last column, where there is room for it.
fn with_term(row: &str, term: &str, width: usize) -> String {
    match width >= WITH_TERMS {
        true => format!("{row:<WIDE$}  {term}").trim_end().to_owned(),
        false => row.to_owned(),
    }
}

/// Costs of numbers that the bike file lacks or is not sure of; nothing where it knows all that matter.
pub(crate) fn costs(costs: &[String], width: usize) -> String {
    let mut out = String::new();
    if !costs.is_empty() {
        line(&mut out, "");
        line(&mut out, "What the bike file lacks or is not sure of costs most");
    }
    for cost in costs {
        let lines = wrap(&clean(cost), width - 4);
        for (i, text) in lines.iter().enumerate() {
            let indent = if i == 0 { "  " } else { "    " };
            line(&mut out, &format!("{indent}{text}"));
        }
    }
    out
}

/// A batch: what went in and came out, how long it took, what its tyres have and what is missing in sentences, its warnings,
/// and for each bike and tyre the medians of the main coefficients over its sessions. It is of these sessions alone:
/// `elsewhere` is how many others the output has, which the report and the fleet's tables are of, too.
pub fn batch_summary(
    sessions: &[SessionRow],
    coefficients: &[Coefficient],
    rejected: &[Rejected],
    warnings: &[WarningRow],
    elsewhere: usize,
    (seconds, width): (f64, usize),
) -> String {
    let mut out = String::new();
    let inputs = sessions.len() + rejected.len();
    line(
        &mut out,
        &format!(
            "{} in, {} out, {} rejected, {}",
            number_format::count(inputs, "log"),
            number_format::count(sessions.len(), "session"),
            rejected.len(),
            number_format::duration(seconds)
        ),
    );
    if elsewhere > 0 {
        let others = number_format::count(elsewhere, "more session");
        let says = format!(
            "This summary is of the logs of this run alone. The output has {others} of other logs; report and fleet \
             tables are of all."
        );
        sentences(&mut out, &[says], width);
    }
    sentences(&mut out, &answer::of_batch(sessions, coefficients), width);
    sentences(&mut out, &answer::of_warnings(warnings), width);
    medians(&mut out, sessions, coefficients, elsewhere > 0);
    out
}

/// Each sentence on lines of its own, the second and later ones indented.
pub(crate) fn sentences(out: &mut String, all: &[String], width: usize) {
    for sentence in all {
        for (i, text) in wrap(&clean(sentence), width - 2).into_iter().enumerate() {
            line(out, &if i == 0 { text } else { format!("  {text}") });
        }
    }
}

/// Rejections, one after the other, in lines of `width`; of more than `most` only the first.
pub(crate) fn rejections(rejected: &[Rejected], most: usize, width: usize) -> String {
    let mut out = String::new();
    for r in rejected.iter().take(most) {
        line(&mut out, &format!("  {}", clean(&r.path)));
        for text in wrap(&clean(&format!("{} ({}): {}", r.stage, r.code, r.message)), width - 6) {
            line(&mut out, &format!("      {text}"));
        }
    }
    if rejected.len() > most {
        line(&mut out, &format!("  and {} more, see rejected/", rejected.len() - most));
    }
    out
}

fn medians(out: &mut String, sessions: &[SessionRow], coefficients: &[Coefficient], is_part: bool) {
    let bikes: BTreeSet<&str> = sessions.iter().map(|s| s.ident.bike_id.as_str()).collect();
    if bikes.is_empty() {
        return;
    }
    let mut good: BTreeMap<(&str, &str, &str), Vec<f64>> = BTreeMap::new();
    for c in coefficients.iter().filter(|c| c.status == Status::Ok) {
        let key = (c.ident.bike_id.as_str(), c.tyre.as_str(), c.coefficient.as_str());
        good.entry(key).or_default().extend(c.value);
    }
    let offroad = !coefficients.is_empty()
        && coefficients.iter().all(|c| OFFROAD.iter().any(|o| o.0.name() == c.coefficient));
    let main = if offroad { OFFROAD.as_slice() } else { MAIN.as_slice() };
    let width = bikes.iter().map(|b| b.chars().count()).max().unwrap_or(4).clamp(4, 20);
    line(out, "");
    let which = if is_part { "this run's" } else { "the" };
    line(out, &format!("medians over {which} sessions where each is determined (how many)"));
    let mut rows: Vec<Vec<String>> =
        vec![main.iter().map(|(_, title)| (*title).to_owned()).collect()];
    let mut labels = vec![format!("{:<width$} {:>8} {:<5}", "bike", "sessions", "tyre")];
    for bike in bikes {
        let n = sessions.iter().filter(|s| s.ident.bike_id == bike).count();
        for (i, tyre) in ["front", "rear"].into_iter().enumerate() {
            let name: String = clean(bike).chars().take(width).collect();
            let (name, n) = if i == 0 { (name, n.to_string()) } else { Default::default() };
            labels.push(format!("{name:<width$} {n:>8} {tyre:<5}"));
            let cell = |coefficient: &C| {
                let key = (bike, tyre, coefficient.name());
                let values = good.get(&key).map_or(&[][..], Vec::as_slice);
                median_of_finite(values).map_or("-".to_owned(), |m| {
                    let spread = number_format::robust_sd(values);
                    let digits = number_format::decimals_of(m, spread).min(4);
                    format!("{} ({})", fixed(m, digits), values.len())
                })
            };
            rows.push(main.iter().map(|(coefficient, _)| cell(coefficient)).collect());
        }
    }
    // as narrow as the cells allow: a terminal may have 80 columns
    let widest = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..main.len()).map(widest).collect();
    for (label, row) in labels.into_iter().zip(&rows) {
        let cells = row.iter().zip(&widths).map(|(cell, width)| format!(" {cell:>width$}"));
        line(out, &(label + &cells.collect::<String>()));
    }
}

fn heading(session: &SessionRow) -> String {
    let mut parts = vec![clean(&session.ident.session_id), clean(&session.ident.bike_id)];
    parts.extend(session.ident.start_time.as_deref().map(|t| clean(&started(t))));
    parts.push(number_format::duration(session.duration));
    parts.extend(session.distance.map(|d| format!("{:.2} km", d / 1000.0)));
    parts.join("  ")
}

/// A start time as the tables and pages have it: UTC, whatever offset the log gave. A day stays a day.
fn started(text: &str) -> String {
    let utc = text.contains('T').then(|| instant::text(instant::microseconds(text)?)).flatten();
    number_format::timestamp(utc.as_deref().unwrap_or(text))
}

/// Lines of a text broken at blanks to at most `width` characters; what a long line goes on with is indented by two more than
/// its begin. Columns before the break stay.
pub(crate) fn wrapped(text: &str, width: usize) -> String {
    let mut out = String::new();
    for whole in text.lines() {
        let indent = whole.len() - whole.trim_start().len();
        let mut left = whole.to_owned();
        while left.chars().count() > width {
            let begin = left.len() - left.trim_start().len();
            let end = left.char_indices().nth(width + 1).map_or(left.len(), |(at, _)| at);
            // a longer word stands alone
            let at = left[begin..end].rfind(' ').or_else(|| left[begin..].find(' '));
            let Some(at) = at.map(|at| begin + at).filter(|at| *at > begin) else { break };
            line(&mut out, &left[..at]);
            left = format!("{:1$}{2}", "", indent + 2, left[at..].trim_start());
        }
        line(&mut out, &left);
    }
    out
}

/// Text from a log without control characters, which would act on the terminal.
pub(crate) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

fn line(out: &mut String, text: &str) {
    out.push_str(text.trim_end());
    out.push('\n');
}

/// Words on lines of at most `width` characters; a longer word stands alone.
pub(crate) fn wrap(text: &str, width: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(last) if last.chars().count() + 1 + word.chars().count() <= width => {
                last.push(' ');
                last.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::tables::rows::{Ident, Provenance};

    #[test]
    fn long_lines_break_at_blanks_and_columns_stay() {
        let text = "name      1.0   one two three\n  a b\nverylongwordthatstandsalone x";
        let said = wrapped(text, 20);
        assert_eq!(
            said,
            "name      1.0   one\n  two three\n  a b\nverylongwordthatstandsalone\n  x\n"
        );
        assert_eq!(wrapped("a  b\n\nc", usize::MAX), "a  b\n\nc\n");
    }

    fn session() -> SessionRow {
        SessionRow {
            ident: Ident {
                session_id: "lap\u{1b}[31m-042".into(),
                bike_id: "supersport".into(),
                start_time: Some("2024-05-03T10:11:12Z".into()),
            },
            path: "lap.parquet".into(),
            duration: 751.0,
            rate: 100.0,
            n_samples: 75_100,
            distance: Some(14_203.0),
            channels: "velocity_x".into(),
            n_manoeuvres: 57,
            n_used: 23,
            n_coefficients_ok: 1,
            n_warnings: 2,
            tyre_front: None,
            tyre_rear: None,
            site: None,
            rider_id: None,
            provenance: Provenance::default(),
        }
    }

    fn coefficient(
        tyre: &str,
        name: &str,
        value: Option<f64>,
        reason: Option<&str>,
    ) -> Coefficient {
        Coefficient {
            ident: session().ident,
            tyre: tyre.into(),
            coefficient: name.into(),
            symbol: "x".into(),
            value,
            unit: "m".into(),
            std_error: value.map(|v| v.abs() / 100.0),
            ci95_low: value.map(|v| v - v.abs() / 50.0),
            ci95_high: value.map(|v| v + v.abs() / 50.0),
            dispersion: None,
            n_manoeuvres: 4,
            n_samples: 400,
            residual_scale: None,
            outlier_fraction: None,
            r_squared: None,
            status: if value.is_some() { Status::Ok } else { Status::NotAvailable },
            reason: reason.map(str::to_owned),
            ..Coefficient::default()
        }
    }

    #[test]
    fn a_summary_fits_the_page_and_cannot_steer_the_terminal() {
        let long = "no rear braking above 0.3 g was found; ride several hard stops with the rear \
                    brake alone, clutch in, from 80 km/h or more, on an even surface";
        let mut poor = coefficient("rear", "effective_rolling_radius", Some(0.3), Some(long));
        poor.status = Status::PoorlyDetermined;
        let rows = [
            poor,
            coefficient("rear", "mf_d", None, Some(long)),
            coefficient("front", "effective_rolling_radius", Some(0.298_712), None),
        ];
        let text = summary(&session(), &rows, &[], WIDTH);
        assert!(text.lines().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert!(!text.contains('\u{1b}'));
        assert!(text.contains("0.2987 ± 0.0030"), "{text}");
        assert!(text.contains("0.2927 to 0.3047"), "{text}");
        assert!(text.find("Front tyre") < text.find("Rear tyre"));
        assert!(
            text.contains(
                "1 of 3 coefficients determined; 1 poorly determined; 1 not available; 23"
            )
        );
    }

    /// Warning that medians of some of an output's sessions differ from those of its tables and pages.
    #[test]
    fn a_wide_terminal_has_the_terms_beside_the_keys() {
        let rows = [
            coefficient("front", "overturning_stiffness", Some(0.055), None),
            coefficient("front", "peak_slip", Some(0.2), None),
        ];
        let ends = |width: usize, end: &str| {
            let text = summary(&session(), &rows, &[], width);
            assert!(text.lines().all(|l| l.chars().count() <= width), "{text}");
            text.lines().filter(|l| l.ends_with(end)).count()
        };
        assert_eq!(
            ["crown radius", "slip ratio of peak", "term"].map(|end| ends(120, end)),
            [1; 3]
        );
        assert_eq!(ends(100, "crown radius"), 0);
    }

    #[test]
    fn a_summary_of_some_sessions_says_so() {
        let rows = [coefficient("front", "mf_d", Some(1.2), None)];
        let text = batch_summary(&[session()], &rows, &[], &[], 4, (1.0, 80));
        assert!(text.lines().all(|l| l.chars().count() <= 80), "{text}");
        let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(joined.contains("The output has 4 more sessions of other logs"), "{text}");
        assert!(text.contains("medians over this run's sessions"), "{text}");
    }

    /// A ride after midnight east of Greenwich has one date, here and in the tables.
    #[test]
    fn a_ride_starts_at_the_time_of_the_tables() {
        let at = |start: &str| {
            let mut session = session();
            session.ident.start_time = Some(start.to_owned());
            heading(&session)
        };
        assert!(at("2026-06-02T01:30:00+02:00").contains("  2026-06-01 23:30:00Z  "));
        assert!(at("2026-06-02T01:30:00").contains("  2026-06-02 01:30:00Z  "));
        assert!(at("2026-06-02").contains("  2026-06-02  "));
    }

    #[test]
    fn costs_fit_the_page() {
        assert_eq!(costs(&[], WIDTH), "");
        let long = "wheel_inertia not given: vehicle overturning_stiffness ±38 % instead of ±5.1 %; \
                    swing the wheel, or coast and brake in neutral";
        let text = costs(&[long.to_owned()], WIDTH);
        assert!(text.lines().all(|l| l.chars().count() <= WIDTH), "{text}");
        assert!(text.contains("\n  wheel_inertia not given: vehicle"), "{text}");
    }

    #[test]
    fn a_batch_accounts_for_every_input() {
        let rejected = Rejected {
            path: "bad.csv".into(),
            session_id: None,
            bike_id: None,
            stage: "ingest".into(),
            code: "empty".into(),
            message: "the file has no rows".into(),
            input_hash: None,
            version: "0".into(),
            limits: None,
        };
        let rows = [coefficient("front", "mf_d", Some(1.2), None)];
        let rejected = [rejected];
        let text = batch_summary(&[session()], &rows, &rejected, &[], 0, (12.34, WIDTH));
        assert!(text.starts_with("2 logs in, 1 session out, 1 rejected, 12.3 s\n"), "{text}");
        assert!(
            text.contains("medians over the sessions") && !text.contains("other logs"),
            "{text}"
        );
        assert!(text.contains("1.2000 (1)") || text.contains("1.200 (1)"), "{text}");
        let list = rejections(&rejected, 20, WIDTH);
        assert!(list.contains("ingest (empty): the file has no rows"), "{list}");
        assert!(rejections(&rejected, 0, WIDTH).contains("and 1 more"));
        assert!(text.lines().chain(list.lines()).all(|l| l.chars().count() <= WIDTH), "{text}");
    }
}
