//! The keys of a tyre's property file.

use std::collections::BTreeMap;

/// A key that a model needs and a file lacks.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("missing key `{0}`")]
pub(crate) struct Missing(pub String);

/// The keys of a property file, upper case; numbers in SI.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Keys {
    pub(super) numbers: BTreeMap<String, f64>,
    pub(super) texts: BTreeMap<String, String>,
}

impl Keys {
    /// Keys with numbers only.
    pub(crate) fn of(numbers: &[(&str, f64)]) -> Self {
        let numbers = numbers.iter().map(|(key, x)| ((*key).to_owned(), *x)).collect();
        Keys { numbers, texts: BTreeMap::new() }
    }

    /// A number.
    ///
    /// # Errors
    /// The file does not have it.
    pub(crate) fn number(&self, key: &str) -> Result<f64, Missing> {
        self.numbers.get(key).copied().ok_or_else(|| Missing(key.to_owned()))
    }

    /// A number, or a default.
    pub(crate) fn or(&self, key: &str, default: f64) -> f64 {
        self.numbers.get(key).copied().unwrap_or(default)
    }

    pub(crate) fn text(&self, key: &str) -> Option<&str> {
        self.texts.get(key).map(String::as_str)
    }
}
