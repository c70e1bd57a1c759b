//! What `roadbench inspect` found, for people.

use std::fmt::Write as _;

use super::facts::{ChannelFacts, Estimate, Facts, Inspection};
use crate::cli::number::number;
use crate::cli::say;
use crate::report::terminal;

impl Inspection {
    /// All of it.
    pub(super) fn to_text(&self) -> String {
        let mut out = String::new();
        // writing to a String cannot fail
        let _ = self.session.write(&mut out);
        let _ = write_channels(&self.channels, &mut out);
        let _ = self.write_findings(&mut out);
        let _ = write_estimates(&self.estimates, &mut out);
        out.push_str(&terminal::costs(&self.costs, say::width()));
        terminal::wrapped(&out, say::line_width())
    }

    fn write_findings(&self, out: &mut String) -> std::fmt::Result {
        if self.session.bike_file.is_none() {
            writeln!(out, "\nNot checked against a bike: give --bikes to check units and signs.")?;
        }
        if !self.warnings.is_empty() {
            writeln!(out, "\nWarnings")?;
        }
        for w in &self.warnings {
            let time = w.time.map(|t| format!(" (first at {t:.1} s)")).unwrap_or_default();
            writeln!(out, "  {}: {}{time}", w.code, w.message)?;
        }
        if let Some(reason) = &self.rejected {
            writeln!(
                out,
                "\nThis session would be rejected\n  {}: {}",
                reason.code, reason.message
            )?;
        }
        Ok(())
    }
}

impl Facts {
    fn write(&self, out: &mut String) -> std::fmt::Result {
        writeln!(out, "Session {}, bike {}", self.session_id, self.bike_id)?;
        let known = [
            ("started", &self.start_time),
            ("site", &self.site),
            ("rider", &self.rider_id),
            ("front tyre", &self.tyre_front),
            ("rear tyre", &self.tyre_rear),
        ];
        for (name, value) in known {
            if let Some(value) = value {
                writeln!(out, "  {name}: {value}")?;
            }
        }
        write!(out, "  {:.1} s, {} samples at {:.4} Hz", self.duration, self.samples, self.rate)?;
        match self.distance {
            Some(d) => writeln!(out, ", {:.2} km recorded", d / 1000.0),
            None => writeln!(out),
        }
    }
}

fn write_channels(channels: &[ChannelFacts], out: &mut String) -> std::fmt::Result {
    if say::width() < WIDE {
        return write_channels_narrow(channels, out);
    }
    writeln!(
        out,
        "\n{:<24}{:>6}{:>9}{:>9}{:>10}{:>6}{:>11}{:>11}{:>11}  verdict",
        "channel", "unit", "rate Hz", "samples", "missing %", "gaps", "min", "median", "max"
    )?;
    for c in channels {
        let rate = c.rate.map(|r| format!("{r:.1}")).unwrap_or_default();
        writeln!(
            out,
            "{:<24}{:>6}{rate:>9}{:>9}{:>10.1}{:>6}{:>11}{:>11}{:>11}  {}",
            c.channel,
            c.unit.replace("s2", "s²"),
            c.samples,
            c.missing,
            c.gaps,
            number(c.min),
            number(c.median),
            number(c.max),
            c.verdict
        )?;
    }
    Ok(())
}

/// Columns from which every figure of a channel has one.
const WIDE: usize = 100;

/// Without rate, samples and gaps, in 80 columns.
fn write_channels_narrow(channels: &[ChannelFacts], out: &mut String) -> std::fmt::Result {
    writeln!(
        out,
        "\n{:<22}{:>6}{:>7}{:>10}{:>10}{:>10}  verdict",
        "channel", "unit", "miss %", "min", "median", "max"
    )?;
    for c in channels {
        let [min, median, max] = [c.min, c.median, c.max].map(number);
        writeln!(
            out,
            "{:<22}{:>6}{:>7.1}{min:>10}{median:>10}{max:>10}  {}",
            c.channel,
            c.unit.replace("s2", "s²"),
            c.missing,
            c.verdict
        )?;
    }
    Ok(())
}

fn write_estimates(estimates: &[Estimate], out: &mut String) -> std::fmt::Result {
    let titles = [
        ("possible", "Can be estimated, if it was ridden"),
        ("not_available", "Cannot be estimated"),
        ("assumed", "Taken from the bike file, its defaults or a rule"),
    ];
    for (status, title) in titles {
        let rows: Vec<&Estimate> = estimates.iter().filter(|e| e.status == status).collect();
        if !rows.is_empty() {
            writeln!(out, "\n{title}")?;
        }
        // what both tyres take alike is said once
        let same = |a: &Estimate, b: &Estimate| {
            (&a.coefficients, &a.riding, &a.missing_channels)
                == (&b.coefficients, &b.riding, &b.missing_channels)
        };
        for (i, e) in rows.iter().enumerate() {
            if rows[..i].iter().any(|before| same(before, e)) {
                continue;
            }
            let tyre = match rows[i + 1..].iter().any(|after| same(after, e)) {
                true => "both",
                false => e.tyre,
            };
            write!(out, "  {tyre:<8}{}", e.coefficients.join(", "))?;
            match status {
                "assumed" => writeln!(out)?,
                "possible" => writeln!(out, "\n          from {}", e.riding)?,
                _ => writeln!(
                    out,
                    "\n          missing: {}; then from {}",
                    e.missing_channels.join(", "),
                    e.riding
                )?,
            }
        }
    }
    Ok(())
}
