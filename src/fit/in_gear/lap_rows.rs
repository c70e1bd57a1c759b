//! What the laps say of the tyres, as rows of `lap_coefficients` and `lap_trends`.

use super::by_lap::ByLap;
use crate::store::tables::rows::{Ident, LapCoefficientRow, LapTrendRow};

/// Probability with which all intervals of a session hold at once, for a verdict.
const AT_ONCE: f64 = 0.95;

/// Rows of both tables.
pub fn rows(found: &[ByLap], ident: &Ident) -> (Vec<LapCoefficientRow>, Vec<LapTrendRow>) {
    let of_laps = found.iter().flat_map(|one| {
        one.laps.iter().map(|lap| LapCoefficientRow {
            ident: ident.clone(),
            lap: lap.lap,
            tyre: one.axle.name().to_owned(),
            coefficient: one.coefficient.name().to_owned(),
            unit: one.coefficient.spec().unit.to_owned(),
            value: one.value * (1.0 + lap.change),
            change: lap.change,
            change_std_error: lap.std_error,
            n_samples: lap.samples as i64,
        })
    });
    // Bonferroni: each of m intervals a m-th as often wrong
    let each = 1.0 - (1.0 - AT_ONCE) / found.len().max(1) as f64;
    let trend = |one: &ByLap| {
        let numbers = || one.laps.iter().map(|l| l.lap);
        let over = (numbers().max().unwrap_or(0) - numbers().min().unwrap_or(0)) as f64;
        let half = one.half_95();
        let verdict = match one.per_lap.abs() > one.half(each) {
            true if one.per_lap < 0.0 => "falls",
            true => "rises",
            false => "none",
        };
        LapTrendRow {
            ident: ident.clone(),
            tyre: one.axle.name().to_owned(),
            coefficient: one.coefficient.name().to_owned(),
            unit: one.coefficient.spec().unit.to_owned(),
            value: one.value,
            n_laps: one.laps.len() as i64,
            change_per_lap: one.per_lap,
            std_error: one.error(),
            ci95_low: one.per_lap - half,
            ci95_high: one.per_lap + half,
            change: over * one.per_lap,
            change_low: over * (one.per_lap - half),
            change_high: over * (one.per_lap + half),
            scatter: one.scatter,
            verdict: verdict.to_owned(),
        }
    };
    (of_laps.collect(), found.iter().map(trend).collect())
}
