//! The row of `tyre_parameters`, field by field as in `schemas/`.

use serde::{Deserialize, Serialize};

use super::ident::Ident;

/// A row of `tyre_parameters`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the schema file describes each field
pub struct TyreParameters {
    #[serde(flatten)]
    pub ident: Ident,
    pub tyre: String,
    pub tyre_model: Option<String>,
    pub longitudinal: bool,
    pub lateral: bool,
    pub load_at_rest: f64,
    pub mf_b: f64,
    pub mf_c: f64,
    pub mf_d: f64,
    pub mf_e1: f64,
    pub mf_e2: f64,
    pub peak_slip: f64,
    pub slip_stiffness_load: f64,
    pub lateral_friction_ct: f64,
    pub slip_camber_c1: f64,
    pub slip_camber_c3: f64,
    pub side_force_ratio: f64,
    pub lateral_peak: f64,
    pub twisting_stiffness: f64,
    pub overturning_stiffness: f64,
    pub effective_rolling_radius: f64,
    pub rolling_resistance: f64,
    pub relaxation_length: f64,
    pub longitudinal_relaxation: f64,
    pub vertical_stiffness: f64,
    pub deflection_share: f64,
    pub camber_force_decay: f64,
    pub camber_moment_decay: f64,
    pub ridden_slip_low: Option<f64>,
    pub ridden_slip_high: Option<f64>,
    pub ridden_slip_angle: Option<f64>,
    pub ridden_camber: Option<f64>,
    pub ridden_load_low: f64,
    pub ridden_load_high: f64,
    pub braked_load_low: Option<f64>,
    pub braked_load_high: Option<f64>,
}
