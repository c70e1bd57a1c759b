//! The extended model of a diagnosis: the file that `diagnose` wrote, for its page.

use serde::Serialize;

use crate::report::diagnosis::cause_labels;
use crate::report::{labels, readable};
use crate::statistics::number_format::{self, fixed, typeset};

/// The extended model, as `diagnose` wrote it.
#[derive(Debug, Serialize)]
pub(crate) struct Model {
    /// Its file, below the output folder.
    pub file: String,
    /// Added effects: sentence, name, size with its standard error and unit.
    pub effects: Vec<(String, String, String)>,
    /// Coefficients without these effects: tyre and name, value, 95 % interval, unit, status.
    pub coefficients: Vec<[String; 5]>,
}

/// Reads a model file; `None` where it is none.
pub(crate) fn model(text: &str, file: &str) -> Option<Model> {
    let table: toml::Table = text.parse().ok()?;
    let number = |t: &toml::Table, key: &str| t.get(key).and_then(toml::Value::as_float);
    let effects = table.get("effects").and_then(toml::Value::as_table);
    let effects = effects.into_iter().flatten().filter_map(|(name, effect)| {
        let effect = effect.as_table()?;
        let (value, error) = (number(effect, "value")?, number(effect, "std_error"));
        let unit = effect.get("unit").and_then(toml::Value::as_str).unwrap_or_default();
        let (unit, factor) = readable::unit(name, unit);
        let (shown, error) = (value * factor, error.map(|e| e * factor));
        let digits = number_format::decimals_of(shown, error);
        let error = error.map(|e| format!(" ± {}", fixed(e, digits))).unwrap_or_default();
        let size = typeset(&format!("{}{error}{unit}", fixed(shown, digits)));
        Some((cause_labels::effect(name, Some(value)), name.clone(), size))
    });
    let tyres = table.get("coefficients").and_then(toml::Value::as_table);
    let rows = tyres.into_iter().flatten().filter_map(|(tyre, own)| Some((tyre, own.as_table()?)));
    let coefficients = rows.flat_map(|(tyre, own)| {
        own.iter().filter_map(move |(name, row)| coefficient(tyre, name, row.as_table()?))
    });
    let coefficients = coefficients.collect();
    Some(Model { file: file.to_owned(), effects: effects.collect(), coefficients })
}

fn coefficient(tyre: &str, name: &str, row: &toml::Table) -> Option<[String; 5]> {
    let value = row.get("value")?.as_float()?;
    let ends: Vec<f64> = row
        .get("ci95")
        .and_then(toml::Value::as_array)
        .map(|ends| ends.iter().filter_map(toml::Value::as_float).collect())
        .unwrap_or_default();
    let ends = <[f64; 2]>::try_from(ends).ok();
    let half = ends.map(|[low, high]| (high - low) / 3.92);
    let digits = number_format::decimals_of(value, half);
    let number = |v| typeset(&fixed(v, digits));
    let text = |key: &str| row.get(key).and_then(toml::Value::as_str).unwrap_or_default();
    let interval = ends.map(|[l, h]| format!("{} to {}", number(l), number(h))).unwrap_or_default();
    let label = format!("{tyre} {name}");
    Some([label, number(value), interval, labels::unit(text("unit")), text("status").to_owned()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_file_is_read_with_the_digits_of_its_errors() {
        let text = "session_id = \"s\"\n[effects.latency]\nvalue = 0.0204593\nstd_error = 0.00171\n\
                    unit = \"s\"\n[coefficients.front.mf_d]\nvalue = 1.0453\nci95 = [1.02, 1.07]\n\
                    unit = \"1\"\nstatus = \"ok\"\n";
        let found = model(text, "models/x.toml").expect("a model");
        assert_eq!(found.effects[0].2, "20.5 ± 1.7 ms");
        assert_eq!(found.coefficients, [["front mf_d", "1.045", "1.020 to 1.070", "", "ok"]]);
        assert!(model("not toml =", "x").is_none());
    }
}
