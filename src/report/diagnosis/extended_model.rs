//! The extended model of a diagnosis: the file that `diagnose` wrote, for its page.

use serde::Serialize;

use crate::report::diagnosis::cause_labels;
use crate::report::labels;
use crate::report::number_format::{self, fixed, typeset};

/// The extended model, as `diagnose` wrote it.
#[derive(Debug, Serialize)]
pub struct Model {
    /// Its file, below the output folder.
    pub file: String,
    /// What was added: sentence, name, size with its standard error, unit.
    pub effects: Vec<(String, String, String, String)>,
    /// The base model beside it: name and value.
    pub base: Vec<(String, String)>,
}

/// Reads a model file; `None` where it is none.
pub fn model(text: &str, file: &str) -> Option<Model> {
    let table: toml::Table = text.parse().ok()?;
    let number = |t: &toml::Table, key: &str| t.get(key).and_then(toml::Value::as_float);
    let effects = table.get("effects").and_then(toml::Value::as_table);
    let effects = effects.into_iter().flatten().filter_map(|(name, effect)| {
        let effect = effect.as_table()?;
        let (value, error) = (number(effect, "value")?, number(effect, "std_error"));
        let digits = number_format::decimals_of(value, error);
        let error = error.map(|e| format!(" ± {}", fixed(e, digits))).unwrap_or_default();
        let unit = effect.get("unit").and_then(toml::Value::as_str).unwrap_or_default();
        let size = typeset(&format!("{}{error}", fixed(value, digits)));
        Some((cause_labels::effect(name, Some(value)), name.clone(), size, labels::unit(unit)))
    });
    let base = table.get("base").and_then(toml::Value::as_table);
    let base = base.into_iter().flatten().filter_map(|(name, value)| {
        let value = value.as_float()?;
        Some((name.clone(), typeset(&fixed(value, number_format::decimals_of(value, None)))))
    });
    Some(Model { file: file.to_owned(), effects: effects.collect(), base: base.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_model_file_is_read_with_the_digits_of_its_errors() {
        let text = "session_id = \"s\"\n[effects.latency]\nvalue = 0.0204593\nstd_error = 0.00171\n\
                    unit = \"s\"\n[base]\ndrag = 0.42833\n";
        let found = model(text, "models/x.toml").expect("a model");
        assert_eq!(found.effects[0].2, "0.0205 ± 0.0017");
        assert_eq!(found.effects[0].3, "s");
        assert_eq!(found.base, [("drag".to_owned(), "0.4283".to_owned())]);
        assert!(model("not toml =", "x").is_none());
    }
}
