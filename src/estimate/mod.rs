//! Tyre slips, loads and forces, sample by sample, from what was measured.

use serde::{Deserialize, Serialize};

/// Which form of the paper's equations is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// With the corrections of `onroad.md`, section 4.
    #[default]
    Corrected,
    /// As printed, for comparison.
    Paper,
}
