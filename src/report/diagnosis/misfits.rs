//! How well each channel is reproduced: misfits by kind of manoeuvre, and over the whole ride.

use serde::Serialize;

use crate::report::diagnosis::bars::{self, Axis, Levels};
use crate::report::diagnosis::cause_labels;
use crate::report::diagnosis::overlays::Reproduced;
use crate::report::{kinds, labels};
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::DiscrepancyRow;

/// One channel while one kind of manoeuvre.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Misfit {
    pub channel: String,
    pub name: String,
    pub kind: String,
    pub unit: String,
    pub base: String,
    pub extended: String,
    pub noise_only: String,
    pub bar: String,
    pub with: String,
    pub blocks: i64,
}

/// A channel before and after.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Change {
    pub channel: String,
    pub name: String,
    pub unit: String,
    pub base: String,
    pub extended: String,
    pub change: String,
    pub base_bar: String,
    pub extended_bar: String,
}

/// Discrepancies, the structured ones first, then by how far they are beyond every null.
pub(crate) fn worst_first(rows: &[DiscrepancyRow]) -> Vec<&DiscrepancyRow> {
    let ratio = |r: &DiscrepancyRow| r.rmse_base / r.null_largest.max(f64::MIN_POSITIVE);
    let mut out: Vec<&DiscrepancyRow> = rows.iter().filter(|r| r.rmse_base.is_finite()).collect();
    out.sort_by(|a, b| b.structured.cmp(&a.structured).then(ratio(b).total_cmp(&ratio(a))));
    out
}

pub(super) fn levels(row: &DiscrepancyRow) -> Option<Levels> {
    let noise_only = row.noise_floor;
    (noise_only > 0.0).then(|| Levels {
        base: row.rmse_base / noise_only,
        extended: row.rmse_extended.map(|e| e / noise_only),
        largest: row.null_largest / noise_only,
    })
}

pub(super) fn misfit(row: &DiscrepancyRow, axis: Axis) -> Misfit {
    let (unit, scale) = cause_labels::readable(&row.unit);
    let digits = three(row.noise_floor.min(row.rmse_base) * scale);
    let show = |v: f64| typeset(&fixed(v * scale, digits));
    let with = row.covariate.as_deref().map_or(String::new(), |c| {
        let r = row.correlation.map(|r| format!(" ({})", typeset(&format!("{r:+.2}"))));
        format!("{}{}", labels::spaced(c), r.unwrap_or_default())
    });
    Misfit {
        channel: cause_labels::channel(&row.channel, &row.unit),
        name: row.channel.clone(),
        kind: kinds::label(&row.kind),
        unit,
        base: show(row.rmse_base),
        extended: row.rmse_extended.map(show).unwrap_or_default(),
        noise_only: show(row.noise_floor),
        bar: levels(row).map(|l| axis.draw(l)).unwrap_or_default(),
        with,
        blocks: row.n,
    }
}

/// Decimals that give a misfit at least two digits, three at most.
fn three(value: f64) -> usize {
    number_format::decimals_of(value, None).saturating_sub(1).min(6)
}

pub(super) fn change(row: &Reproduced) -> Change {
    let (unit, scale) = cause_labels::readable(&row.unit);
    let digits = three(row.extended.map_or(row.base, |e| e.min(row.base)) * scale);
    let show = |v: f64| typeset(&fixed(v * scale, digits));
    let longest = row.extended.map_or(row.base, |e| e.max(row.base));
    let change = row.extended.filter(|_| row.base > 0.0).map(|e| 100.0 * (e / row.base - 1.0));
    Change {
        channel: cause_labels::channel(&row.channel, &row.unit),
        name: row.channel.clone(),
        unit,
        base: show(row.base),
        extended: row.extended.map(show).unwrap_or_default(),
        change: change
            .map(|c| typeset(&format!("{}{} %", if c > 0.5 { "+" } else { "" }, fixed(c, 0))))
            .unwrap_or_default(),
        base_bar: bars::share(row.base, longest, "base"),
        extended_bar: row.extended.map(|e| bars::share(e, longest, "extended")).unwrap_or_default(),
    }
}
