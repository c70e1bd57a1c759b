//! The numbers of a comparison as texts of a terminal's width.

use super::words::percent;
use crate::contract::coefficient::Coefficient as C;
use crate::fleet::compare::Verdict;
use crate::statistics::number_format::{decimals_of, fixed};
use crate::store::tables::rows::ComparisonRow;

/// Width of a value with half of its interval.
const VALUE: usize = 12;
/// Width of an interval.
const INTERVAL: usize = 12;

/// The text of numbers with as many decimals as there is room for.
fn fitted(places: usize, width: usize, text: impl Fn(usize) -> String) -> String {
    let all = (0..=places).rev().map(&text);
    all.into_iter().find(|t| t.chars().count() <= width).unwrap_or_else(|| text(0))
}

/// A value with half of its interval.
pub(crate) fn value(value: Option<f64>, low: Option<f64>, high: Option<f64>) -> String {
    let (Some(value), Some(low), Some(high)) = (value, low, high) else { return "-".to_owned() };
    let half = 0.5 * (high - low);
    let bare = |x: f64, places| match fixed(x, places) {
        text if text.starts_with("0.") => text[1..].to_owned(),
        text => text,
    };
    let text = |places| format!("{}±{}", fixed(value, places), bare(half, places));
    fitted(decimals_of(value, Some(half)).min(6), VALUE, text)
}

/// Difference, its interval, probability that B is larger and verdict, as texts.
#[derive(Debug, Clone)]
pub(crate) struct Change {
    pub(crate) size: String,
    pub(crate) ends: String,
    pub(crate) chance: String,
    pub(crate) verdict: String,
}

/// The difference of a row in words.
pub(crate) fn change(row: &ComparisonRow) -> Change {
    let (size, ends) = match (row.relative, row.relative_low, row.relative_high) {
        (Some(size), Some(low), Some(high)) => (
            format!("{} %", signed(percent(size))),
            format!("{} to {}", percent(low), percent(high)),
        ),
        _ => {
            let [low, high] = [row.ci95_low, row.ci95_high].map(|x| x.unwrap_or(f64::NAN));
            let half = 0.5 * (high - low);
            let places = decimals_of(half, Some(half)).min(6);
            let size = row.difference.unwrap_or(f64::NAN);
            (
                fitted(places, 7, |n| signed(fixed(size, n))),
                fitted(places, INTERVAL, |n| format!("±{}", fixed(half, n))),
            )
        }
    };
    let chance = row.probability_larger.map_or("-".to_owned(), |p| match p {
        p if p >= 0.995 => ">99%".to_owned(),
        p if p < 0.005 => "<1%".to_owned(),
        p => format!("{:.0}%", 100.0 * p),
    });
    let verdict = match row.verdict.as_str() {
        v if v == Verdict::NoDifference.name() => "unclear",
        v => v,
    };
    Change { size, ends, chance, verdict: verdict.to_owned() }
}

fn signed(text: String) -> String {
    let is_bare = text.starts_with('-') || text.chars().all(|c| c == '0' || c == '.');
    if is_bare { text } else { format!("+{text}") }
}

/// A number of both tyres' curves at a load.
#[derive(Debug)]
pub(crate) struct AtLoad<'a> {
    pub(crate) row: &'a ComparisonRow,
    pub(crate) name: &'static str,
    pub(crate) a: String,
    pub(crate) b: String,
}

/// The curves of both tyres at a load (N): their height and their slope.
pub(crate) fn at_load<'a>(rows: &[&'a ComparisonRow], load: f64) -> Vec<AtLoad<'a>> {
    const OF: [(C, &str); 4] = [
        (C::MfD, "peak brake force, N"),
        (C::SlipStiffness, "slip stiffness, N"),
        (C::CorneringStiffness0, "cornering, N/rad"),
        (C::CamberStiffness0, "camber, N/rad"),
    ];
    let force = |v: Option<f64>| v.map_or("-".to_owned(), |v| fixed(v * load, 0));
    let of = |row: &&'a ComparisonRow| {
        let (_, name) = OF.iter().find(|(c, _)| c.name() == row.coefficient)?;
        Some(AtLoad { row, name, a: force(row.value_a), b: force(row.value_b) })
    };
    rows.iter().filter_map(of).collect()
}
