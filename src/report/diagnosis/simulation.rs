//! Gain of the identified causes in the simulation of manoeuvres that the fit has not seen.

use serde::Serialize;

use crate::report::diagnosis::bars;
use crate::report::diagnosis::cause_labels::{self, sentence};
use crate::report::kinds;
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::SimulationError;

/// Gains with a sentence each.
const TOLD: usize = 3;

/// A channel in one kind of manoeuvre.
#[derive(Debug, Serialize)]
#[allow(missing_docs)] // headings of the table in the template
pub struct Simulated {
    pub channel: String,
    pub name: String,
    pub kind: String,
    pub unit: String,
    pub base: String,
    pub extended: String,
    pub noise_only: String,
    pub ratio: String,
    pub interval: String,
    pub class: &'static str,
    pub base_bar: String,
    pub extended_bar: String,
    pub manoeuvres: i64,
}

/// The simulation before and after.
#[derive(Debug, Default, Serialize)]
pub struct Simulation {
    /// Largest gains, a clause each.
    pub gains: Vec<String>,
    /// Text about it otherwise.
    pub remark: String,
    /// Where it stays wrong, a clause each.
    pub wrong: Vec<String>,
    /// Whether there is an after.
    pub extended: bool,
    pub changed: Vec<Simulated>,
    pub others: Vec<Simulated>,
}

/// Numbers of a row in the unit that people read.
struct Shown {
    unit: String,
    scale: f64,
    digits: usize,
}

impl Shown {
    fn of(row: &SimulationError) -> Self {
        let (unit, scale) = cause_labels::readable(&row.unit);
        let least =
            row.rmse_extended.unwrap_or(f64::INFINITY).min(row.rmse_base).min(row.noise_floor);
        let digits = number_format::decimals_of(least * scale, None).saturating_sub(2).min(6);
        Shown { unit, scale, digits }
    }

    fn number(&self, value: f64) -> String {
        typeset(&fixed(value * self.scale, self.digits))
    }
}

/// Errors before and after, beside the noise-only rms.
pub(crate) fn errors(row: &SimulationError) -> String {
    let shown = Shown::of(row);
    let number = |v| shown.number(v);
    let after = row.rmse_extended.map_or(String::new(), |e| format!(" → {}", number(e)));
    let gap = if shown.unit == "°" { "" } else { "\u{a0}" };
    let [base, noise_only] = [row.rmse_base, row.noise_floor].map(number);
    format!("{base}{after}{gap}{} (noise only {noise_only})", shown.unit)
}

/// The same with channel and kind of manoeuvre.
pub(crate) fn clause(row: &SimulationError) -> String {
    let channel = cause_labels::channel(&row.channel, &row.unit);
    format!("{channel} while {}: {}", kinds::label(&row.kind), errors(row))
}

/// Changes of a ride's simulation by the causes, as text.
pub(crate) fn simulation(rows: &[SimulationError]) -> Simulation {
    let gains = SimulationError::gains(rows);
    let worse: Vec<&SimulationError> = rows.iter().filter(|r| r.is_worse()).collect();
    let extended = rows.iter().any(|r| r.rmse_extended.is_some());
    let mut remark = String::new();
    if extended && gains.is_empty() {
        remark.push_str(
            "The simulation of manoeuvres that the fit has not seen improves with the identified causes by too \
             little to be seen, or not at all: the gain shows in the residuals only.",
        );
    }
    if let Some(row) = worse.first() {
        let more = match worse.len() {
            1 => String::new(),
            n => format!(", and {} more", n - 1),
        };
        let gap = if remark.is_empty() { "" } else { " " };
        remark.push_str(&format!("{gap}It gets worse in the {}{more}.", clause(row)));
    }
    let (changed, others): (Vec<_>, Vec<_>) =
        rows.iter().filter(|r| !r.is_better()).partition(|r| r.is_worse());
    let lines = |rows: Vec<&SimulationError>| rows.into_iter().map(simulated).collect();
    Simulation {
        gains: gains.iter().take(TOLD).map(|r| sentence(&clause(r))).collect(),
        remark,
        wrong: SimulationError::stays_wrong(rows)
            .into_iter()
            .take(TOLD)
            .map(|r| sentence(&clause(r)))
            .collect(),
        extended,
        changed: lines(gains.into_iter().chain(changed).collect()),
        others: lines(others),
    }
}

/// Largest gain and remarks, in one line; empty without an identified cause.
pub(crate) fn in_short(rows: &[SimulationError]) -> String {
    let Simulation { gains, remark, .. } = simulation(rows);
    let gain = gains.into_iter().next().map(|gain| gain + ".");
    gain.into_iter().chain(Some(remark).filter(|r| !r.is_empty())).collect::<Vec<_>>().join(" ")
}

/// Where the simulation stays wrong, in one line.
pub(crate) fn wrong_in_short(rows: &[SimulationError]) -> String {
    let wrong = SimulationError::stays_wrong(rows);
    wrong.first().map_or(String::new(), |r| format!("{}.", sentence(&clause(r))))
}

fn simulated(row: &SimulationError) -> Simulated {
    let shown = Shown::of(row);
    let ends = row.ratio_ci95_low.zip(row.ratio_ci95_high);
    let longest = row.rmse_extended.unwrap_or(0.0).max(row.rmse_base);
    Simulated {
        channel: cause_labels::channel(&row.channel, &row.unit),
        name: row.channel.clone(),
        kind: kinds::label(&row.kind),
        base: shown.number(row.rmse_base),
        extended: row.rmse_extended.map(|e| shown.number(e)).unwrap_or_default(),
        noise_only: shown.number(row.noise_floor),
        unit: shown.unit,
        ratio: row.ratio.map(|r| fixed(r, 2)).unwrap_or_default(),
        interval: ends
            .map(|(l, h)| format!("{} to {}", fixed(l, 2), fixed(h, 2)))
            .unwrap_or_default(),
        class: match (row.is_better(), row.is_worse()) {
            (true, _) => "better",
            (_, true) => "worse",
            _ => "",
        },
        base_bar: bars::share(row.rmse_base, longest, "base"),
        extended_bar: row
            .rmse_extended
            .map(|e| bars::share(e, longest, "extended"))
            .unwrap_or_default(),
        manoeuvres: row.n,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(after: f64, low: f64, high: f64) -> SimulationError {
        SimulationError {
            channel: "velocity_x".into(),
            kind: "front_braking".into(),
            unit: "m/s".into(),
            rmse_base: 0.21,
            rmse_extended: Some(after),
            noise_floor: 0.05,
            ratio: Some(after / 0.21),
            ratio_ci95_low: Some(low),
            ratio_ci95_high: Some(high),
            n: 12,
            ..SimulationError::default()
        }
    }

    #[test]
    fn a_gain_is_told_in_the_channels_unit() {
        let found = simulation(&[row(0.06, 0.2, 0.5)]);
        let told = "Speed while front braking: 0.210 → 0.060\u{a0}m/s (noise only 0.050)";
        assert_eq!(found.gains, [told]);
        assert!(found.remark.is_empty() && found.changed[0].class == "better");
        assert_eq!(in_short(&[row(0.06, 0.2, 0.5)]), format!("{told}."));
    }

    #[test]
    fn what_stays_wrong_is_told_once_a_channel() {
        let unnamed = |channel: &str, kind: &str, base: f64| SimulationError {
            channel: channel.into(),
            kind: kind.into(),
            rmse_base: base,
            rmse_extended: None,
            ratio: None,
            ..row(0.0, 1.0, 1.0)
        };
        let rows = [
            unnamed("velocity_x", "coasting", 0.15),
            unnamed("velocity_x", "front_braking", 0.4),
            unnamed("velocity_y", "cornering", 0.2),
            unnamed("roll", "cornering", 0.09),
        ];
        let told = simulation(&rows).wrong;
        assert_eq!(told.len(), 2, "{told:?}");
        assert!(told[0].starts_with("Speed while front braking: 0.40"), "{told:?}");
        assert!(told[1].starts_with("Sideways speed while cornering: 0.20"), "{told:?}");
        assert_eq!(wrong_in_short(&rows), format!("{}.", told[0]));
        assert_eq!(wrong_in_short(&rows[3..]), "");
    }

    #[test]
    fn no_gain_and_harm_are_told_too() {
        // within its interval, or smaller than anybody sees
        for same in [row(0.18, 0.7, 1.1), row(0.209, 0.99, 0.999)] {
            let found = simulation(&[same]);
            assert!(found.gains.is_empty() && found.remark.contains("or not at all"), "{found:?}");
        }
        let found = simulation(&[row(0.3, 1.2, 1.7)]);
        assert!(found.remark.contains("worse in the speed while front braking"), "{found:?}");
        assert_eq!(in_short(&[row(0.3, 1.2, 1.7)]), found.remark);
        assert_eq!(in_short(&[]), "");
        // no identified cause: nothing to say
        let none = SimulationError { rmse_extended: None, ratio: None, ..row(0.0, 1.0, 1.0) };
        let found = simulation(&[none]);
        assert!(found.remark.is_empty() && !found.extended && found.others.len() == 1);
    }
}
