//! The form of the paper's equations: corrected or as printed.

use serde::{Deserialize, Serialize};

/// Which form of the paper's equations is used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Formulation {
    /// With the corrections of the book, Estimation, section 4.
    #[default]
    Corrected,
    /// As printed, for comparison.
    Paper,
}
