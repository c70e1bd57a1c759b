//! What the tyres did over the laps, as riders read it.

use serde::Serialize;

use crate::report::labels;
use crate::statistics::number_format::{count, fixed, typeset};
use crate::store::tables::rows::LapTrendRow;

/// Shares in per cent.
const PERCENT: f64 = 100.0;

/// The tyres over the laps.
#[derive(Debug, Serialize)]
pub(crate) struct Trends {
    /// Changes, in words.
    pub verdict: String,
    pub rows: Vec<Line>,
}

/// One line of the table.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // as in the schema file, in words
pub(crate) struct Line {
    pub tyre: String,
    pub coefficient: String,
    pub laps: i64,
    pub change: String,
    pub interval: String,
    pub per_lap: String,
    pub scatter: String,
    pub verdict: &'static str,
}

fn share(x: f64, digits: usize) -> String {
    let sign = if x > 0.0 { "+" } else { "" };
    typeset(&format!("{sign}{}", fixed(PERCENT * x, digits)))
}

/// Decimals of a change: two digits of its interval's half width.
fn digits(row: &LapTrendRow) -> usize {
    let half = 0.5 * PERCENT * (row.change_high - row.change_low).abs();
    (1.0 - half.log10().floor()).clamp(0.0, 4.0) as usize
}

fn said(row: &LapTrendRow) -> String {
    let digits = digits(row);
    let half = 0.5 * (row.change_high - row.change_low).abs();
    format!(
        "{} {} {} % ± {} %",
        row.tyre,
        labels::coefficient(&row.coefficient),
        share(row.change, digits),
        fixed(PERCENT * half, digits)
    )
}

/// Changes over the laps, in a sentence; `None` where the session has no trends.
pub(crate) fn sentence(rows: &[LapTrendRow]) -> Option<String> {
    let laps = count(usize::try_from(rows.first()?.n_laps).unwrap_or_default(), "lap");
    let found: Vec<String> = rows.iter().filter(|r| r.verdict != "none").map(said).collect();
    if !found.is_empty() {
        return Some(format!("Tyres over {laps}: {}.", found.join("; ")));
    }
    let finest: Vec<String> = rows.iter().map(said).collect();
    Some(format!("Tyres over {laps}: no change is found ({}).", finest.join("; ")))
}

/// That line for the terminal; empty without trends.
pub(crate) fn terminal(rows: &[LapTrendRow]) -> String {
    sentence(rows).map(|s| format!("{s}\n")).unwrap_or_default()
}

/// The page's part; `None` without trends.
pub(crate) fn page(rows: &[LapTrendRow]) -> Option<Trends> {
    let line = |row: &LapTrendRow| {
        let digits = digits(row);
        Line {
            tyre: labels::tyre(&row.tyre).to_owned(),
            coefficient: labels::coefficient(&row.coefficient).to_owned(),
            laps: row.n_laps,
            change: share(row.change, digits),
            interval: format!(
                "{} to {}",
                share(row.change_low, digits),
                share(row.change_high, digits)
            ),
            per_lap: share(row.change_per_lap, digits + 1),
            scatter: fixed(row.scatter, 1),
            verdict: match row.verdict.as_str() {
                "falls" => "falls",
                "rises" => "rises",
                _ => "no change found",
            },
        }
    };
    Some(Trends { verdict: sentence(rows)?, rows: rows.iter().map(line).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(coefficient: &str, change: f64, half: f64, verdict: &str) -> LapTrendRow {
        LapTrendRow {
            tyre: "rear".into(),
            coefficient: coefficient.into(),
            n_laps: 10,
            change,
            change_low: change - half,
            change_high: change + half,
            change_per_lap: change / 9.0,
            verdict: verdict.into(),
            ..LapTrendRow::default()
        }
    }

    #[test]
    fn what_changed_is_said_and_what_did_not_with_its_interval() {
        let rows = [
            row("slip_stiffness", -0.031, 0.012, "falls"),
            row("effective_rolling_radius", 0.0001, 0.0004, "none"),
        ];
        let said = sentence(&rows).expect("trends");
        assert!(said.contains("Tyres over 10 laps: rear"), "{said}");
        assert!(said.contains("3.1 % ± 1.2 %") && !said.contains("radius"), "{said}");
        let none = sentence(&rows[1..]).expect("trends");
        assert!(none.contains("no change is found") && none.contains("0.040 %"), "{none}");
        let page = page(&rows).expect("trends");
        assert_eq!((page.rows[0].verdict, page.rows[1].verdict), ("falls", "no change found"));
        assert!(super::page(&[]).is_none());
    }
}
