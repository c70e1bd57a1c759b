//! A diagnosis in words.

use std::fmt::Write;

use super::Diagnosis;

/// Most parts of the misfit that are told.
const TOLD: usize = 5;

impl Diagnosis {
    /// The verdict in words, several lines.
    pub fn words(&self) -> String {
        let mut out = format!("{}  {}\n", self.ident.session_id, self.ident.bike_id);
        // writing to a string cannot fail
        let named = |verdict: &str| matches!(verdict, "named" | "ambiguous");
        if !self.causes.iter().any(|c| named(&c.verdict)) {
            let _ = writeln!(
                out,
                "  No cause is named: the largest score is {:.1} (19 of 20 nulls stay below 1).",
                self.naming.alarm
            );
        }
        for c in self.causes.iter().filter(|c| named(&c.verdict)) {
            let number = |v: Option<f64>| v.map_or("?".to_owned(), |v| format!("{v:.3}"));
            let _ = writeln!(
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
        if let Some(row) = self.causes.first()
            && let (Some(gain), Some(bound)) = (row.gain_heldout, row.gain_upper_bound)
        {
            let _ = writeln!(
                out,
                "  On jumps, whoops and corners left out it gains {gain:.0}; with every candidate free \
                 {bound:.0}."
            );
        }
        for c in self.causes.iter().filter(|c| c.verdict == "unexplained") {
            let _ = writeln!(out, "  Not explained: {}", c.reason);
        }
        for c in self.causes.iter().filter(|c| c.verdict == "not_identifiable") {
            let _ = writeln!(out, "  {}: {}", c.effect, c.reason);
        }
        let mut wrong: Vec<_> = self.discrepancies.iter().filter(|r| r.structured).collect();
        wrong.sort_by(|a, b| {
            (b.rmse_base / b.null_largest).total_cmp(&(a.rmse_base / a.null_largest))
        });
        for row in wrong.into_iter().take(TOLD) {
            let after =
                row.rmse_extended.map_or(String::new(), |r| format!(", {r:.0} with the causes"));
            let _ = writeln!(
                out,
                "  misfit of {} while {}: {:.0} {} against {:.0} in nulls{after}",
                row.channel,
                row.kind.replace('_', " "),
                row.rmse_base,
                row.unit,
                row.noise_floor
            );
        }
        out
    }
}
