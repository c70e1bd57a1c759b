//! The tyre of a row of `tyre_parameters`, for pages: apart from what fills the rows.

use crate::store::tables::rows::TyreParameters;
use crate::tyre::custom::Custom;
use crate::tyre::magic_formula::MagicFormula;
use crate::tyre::paper::{Stiffness, Tyre};

/// The tyre of a row, on the road of the ride.
pub fn tyre(row: &TyreParameters) -> Custom {
    let tyre = Tyre {
        friction: MagicFormula {
            b: row.mf_b,
            c: row.mf_c,
            d: row.mf_d,
            e1: row.mf_e1,
            e2: row.mf_e2,
        },
        stiffness: Stiffness {
            ct: row.lateral_friction_ct,
            c1: row.slip_camber_c1,
            c3: row.slip_camber_c3,
        },
        side_force_ratio: row.side_force_ratio,
        twisting_stiffness: row.twisting_stiffness,
        overturning_stiffness: row.overturning_stiffness,
        rolling_radius: row.effective_rolling_radius,
        rolling_resistance: row.rolling_resistance,
        relaxation_length: row.relaxation_length,
        vertical_stiffness: row.vertical_stiffness,
        camber_force_decay: row.camber_force_decay,
        camber_moment_decay: row.camber_moment_decay,
        reference_friction: 1.0,
        peak_slip: row.peak_slip,
        lateral_peak: row.lateral_peak,
    };
    Custom {
        slip_stiffness_load: row.slip_stiffness_load,
        longitudinal_relaxation: row.longitudinal_relaxation,
        deflection_share: row.deflection_share,
        ..Custom::new(tyre, row.load_at_rest)
    }
}
