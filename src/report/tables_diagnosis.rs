//! The tables of `diagnose`, read back from a folder.

use std::path::{Path, PathBuf};

use crate::report::Error;
use crate::report::tables::{Columns, collect, key, read};
use crate::tables::rows::POOLED;
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident, SimulatedSample};

/// Every `causes` row, by bike, session and rank.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn causes(out: &Path) -> Result<Vec<CauseRow>, Error> {
    let mut rows = collect(out, "causes", |c, i| CauseRow {
        ident: c.ident(i),
        rank: c.integer("rank", i),
        effect: c.text("effect", i),
        verdict: c.text("verdict", i),
        level: c.text("level", i),
        pooled_over: c.maybe_text("pooled_over", i),
        parameter: c.text("parameter", i),
        value: c.maybe("value", i),
        unit: c.text("unit", i),
        ci95_low: c.maybe("ci95_low", i),
        ci95_high: c.maybe("ci95_high", i),
        score: c.number("score", i),
        false_alarm_rate: c.number("false_alarm_rate", i),
        gain_heldout: c.maybe("gain_heldout", i),
        gain_upper_bound: c.maybe("gain_upper_bound", i),
        equivalent_to: c.maybe_text("equivalent_to", i),
        separate_by: c.maybe_text("separate_by", i),
        reason: c.text("reason", i),
    })?;
    // what several sessions share has no page
    rows.retain(|r| r.ident.session_id != POOLED);
    rows.sort_by(|a, b| (key(&a.ident), a.rank).cmp(&(key(&b.ident), b.rank)));
    Ok(rows)
}

/// Every `discrepancies` row, by bike and session, then as the diagnosis wrote them.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn discrepancies(out: &Path) -> Result<Vec<DiscrepancyRow>, Error> {
    let mut rows = collect(out, "discrepancies", |c, i| DiscrepancyRow {
        ident: c.ident(i),
        channel: c.text("channel", i),
        kind: c.text("kind", i),
        unit: c.text("unit", i),
        rmse_base: c.number("rmse_base", i),
        rmse_extended: c.maybe("rmse_extended", i),
        bias: c.number("bias", i),
        noise_floor: c.number("noise_floor", i),
        null_largest: c.number("null_largest", i),
        structured: c.flag("structured", i),
        covariate: c.maybe_text("covariate", i),
        correlation: c.maybe("correlation", i),
        n: c.integer("n", i),
    })?;
    rows.sort_by(|a, b| key(&a.ident).cmp(&key(&b.ident)));
    Ok(rows)
}

/// One session's `replays` rows, from the files of
/// [`session_files`](crate::report::tables::session_files), by time within a manoeuvre and channel.
///
/// # Errors
/// A file cannot be read or lacks a column.
pub fn replays(
    files: &[PathBuf],
    bike: &str,
    session: &str,
) -> Result<Vec<SimulatedSample>, Error> {
    let mut rows = Vec::new();
    for path in files {
        for batch in read(path, None)? {
            let c = Columns::new(path, "replays", &batch, &[])?;
            for i in 0..batch.num_rows() {
                let time = c.number("time", i);
                let own = c.str("session_id", i) == session && c.str("bike_id", i) == bike;
                if !own || !time.is_finite() {
                    continue;
                }
                rows.push(SimulatedSample {
                    ident: Ident::default(), // the caller knows; thousands of copies help nobody
                    manoeuvre: c.integer("manoeuvre", i),
                    kind: c.text("kind", i),
                    channel: c.text("channel", i),
                    unit: c.text("unit", i),
                    time,
                    measured: c.maybe("measured", i),
                    base: c.maybe("base", i),
                    extended: c.maybe("extended", i),
                });
            }
        }
    }
    rows.sort_by(|a, b| {
        (&a.channel, &a.kind, a.manoeuvre)
            .cmp(&(&b.channel, &b.kind, b.manoeuvre))
            .then(a.time.total_cmp(&b.time))
    });
    Ok(rows)
}
