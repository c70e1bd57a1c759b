//! The rows of laps, field by field as in `schemas/`.

use serde::{Deserialize, Serialize};

use super::ident::Ident;

/// A row of `laps`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct LapRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub lap: i64,
    pub kind: String,
    pub line: String,
    pub line_latitude: Option<f64>,
    pub line_longitude: Option<f64>,
    pub timed_by: String,
    pub position_difference: Option<f64>,
    pub best: bool,
    pub start: f64,
    pub duration: f64,
    pub duration_std_error: Option<f64>,
    pub distance: f64,
    pub speed_max: Option<f64>,
    pub speed_min: Option<f64>,
    pub roll_left: Option<f64>,
    pub roll_right: Option<f64>,
    pub acceleration_x_min: Option<f64>,
    pub acceleration_x_max: Option<f64>,
    pub friction_used_max: Option<f64>,
    pub friction_used_95: Option<f64>,
    pub friction_available: Option<f64>,
    pub friction_basis: Option<String>,
}

/// A row of `lap_coefficients`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct LapCoefficientRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub lap: i64,
    pub tyre: String,
    pub coefficient: String,
    pub unit: String,
    pub value: f64,
    pub change: f64,
    pub change_std_error: f64,
    pub n_samples: i64,
}

/// A row of `lap_trends`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct LapTrendRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub tyre: String,
    pub coefficient: String,
    pub unit: String,
    pub value: f64,
    pub n_laps: i64,
    pub change_per_lap: f64,
    pub std_error: f64,
    pub ci95_low: f64,
    pub ci95_high: f64,
    pub change: f64,
    pub change_low: f64,
    pub change_high: f64,
    pub scatter: f64,
    pub verdict: String,
}

/// A row of `lap_corners`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct LapCornerRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub lap: i64,
    pub corner: i64,
    pub direction: String,
    pub station_start: f64,
    pub station_apex: f64,
    pub station_end: f64,
    pub time: f64,
    pub time_difference: f64,
    pub speed_min: Option<f64>,
    pub roll_peak: Option<f64>,
    pub friction_used_max: Option<f64>,
}

/// A row of `lap_points`.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct LapPointRow {
    #[serde(flatten)]
    pub ident: Ident,
    pub lap: i64,
    pub station: f64,
    pub latitude: f64,
    pub longitude: f64,
    pub x: f64,
    pub y: f64,
    pub time: f64,
    pub time_difference: f64,
    pub speed: Option<f64>,
    pub roll: Option<f64>,
    pub acceleration_x: Option<f64>,
    pub acceleration_y: Option<f64>,
    pub friction_used: Option<f64>,
}
