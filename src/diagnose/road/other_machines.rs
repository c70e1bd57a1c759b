//! What effects show on machines of which they are not true, beyond what fault-free simulations show: small things
//! that the nominal model leaves out look like them, and of a fault-free simulation's bias some is its own. And how much
//! structure is left on them that nothing explains.
//!
//! Learnt from a population of machines by `examples/blind --learn`, which writes the file that is read here.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

const FILE: &str = include_str!("../../../pipelines/other_machines.toml");

/// Size of an effect on fault-free rides of other machines.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutOfModelError {
    /// Share of the fault-free simulations' bias that rides have too.
    pub bias_share: f64,
    /// Standard deviation beyond that of the fault-free simulations, in usual sizes.
    pub sd: f64,
    /// Share of a true size that the estimates show on these machines, of what they show on fault-free simulations.
    #[serde(default = "whole")]
    pub size_share: f64,
}

/// The share where none is learnt.
const fn whole() -> f64 {
    1.0
}

/// Effects and structure on fault-free rides of other machines.
#[derive(Debug, Default, Deserialize)]
struct OtherMachines {
    /// Residual structure by channel that nearly all of them stay below, in what 19 of 20 fault-free simulations do.
    structure: BTreeMap<String, f64>,
    /// Spread and bias of each effect, by its name.
    #[serde(flatten)]
    effects: BTreeMap<String, OutOfModelError>,
}

static ALL: LazyLock<OtherMachines> = LazyLock::new(|| toml::from_str(FILE).unwrap_or_default());

/// Residual structure of a channel, in what 19 of 20 fault-free simulations stay below, that other machines do not show;
/// one where they show none.
pub(crate) fn structure(channel: &str) -> f64 {
    ALL.structure.get(channel).map_or(1.0, |x| x.max(1.0))
}

/// Size of an effect by name; zero spread if unknown.
pub fn shown(effect: &str) -> OutOfModelError {
    ALL.effects.get(effect).copied().unwrap_or(OutOfModelError {
        bias_share: 1.0,
        sd: 0.0,
        size_share: whole(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::road::residuals::CHANNELS;

    #[test]
    fn the_file_is_about_effects_and_holds_shares_and_deviations() {
        let all: OtherMachines = toml::from_str(FILE).expect("a table per effect");
        assert!(!all.structure.is_empty());
        for (channel, times) in &all.structure {
            assert!(CHANNELS.contains(&channel.as_str()) && (1.0..20.0).contains(times));
            assert_eq!(structure(channel), *times);
        }
        for (name, OutOfModelError { bias_share, sd, size_share }) in all.effects {
            assert!(crate::simulate::effects::ALL.iter().any(|e| e.name == name), "{name}");
            assert!((0.1..=1.0).contains(&bias_share) && (0.0..10.0).contains(&sd), "{name}");
            assert!((0.1..=1.0).contains(&size_share), "{name}");
        }
    }
}
