//! The row of `outlying_manoeuvres`, field by field as in `schemas/`.

use serde::{Deserialize, Serialize};

use super::ident::Ident;

/// A row of `outlying_manoeuvres`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct OutlyingManoeuvre {
    #[serde(flatten)]
    pub ident: Ident,
    pub manoeuvre_id: i64,
    pub kind: String,
    pub start: f64,
    pub end: f64,
    pub quantity: String,
    pub unit: String,
    pub value: f64,
    pub expected: f64,
    pub difference: f64,
    pub ci95_low: f64,
    pub ci95_high: f64,
    pub n_others: i64,
    pub chance: Option<f64>,
    pub cause: String,
    pub distance: Option<f64>,
    pub latitude: Option<f64>,
    pub longitude: Option<f64>,
}
