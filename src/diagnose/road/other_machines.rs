//! What effects show on machines of which they are not true, beyond what null simulations show: small things
//! that the base model leaves out look like them, and of a null simulation's bias some is its own.
//!
//! Learnt from a population of machines by `examples/blind --learn`, which writes the file that is read here.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

const FILE: &str = include_str!("../../../pipelines/other_machines.toml");

/// What an effect shows on other machines.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shown {
    /// Share of the null simulations' bias that rides have too.
    pub bias_share: f64,
    /// Standard deviation beyond that of the null simulations, in usual sizes.
    pub sd: f64,
}

static ALL: LazyLock<BTreeMap<String, Shown>> =
    LazyLock::new(|| toml::from_str(FILE).unwrap_or_default());

/// What the effect of a name shows; nothing of its own where nothing is known.
pub fn shown(effect: &str) -> Shown {
    ALL.get(effect).copied().unwrap_or(Shown { bias_share: 1.0, sd: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_is_about_effects_and_holds_shares_and_deviations() {
        let all: BTreeMap<String, Shown> = toml::from_str(FILE).expect("a table per effect");
        for (name, Shown { bias_share, sd }) in all {
            assert!(crate::effects::ALL.iter().any(|e| e.name == name), "{name}");
            assert!((0.1..=1.0).contains(&bias_share) && (0.0..10.0).contains(&sd), "{name}");
        }
    }
}
