//! The rows of `tyre_parameters`: a session's tyres as the model has them.

use super::fitted::Fitted;
use super::ranges::Ranges;
use super::tyre::{Characterised, Setting};
use crate::contract::bike::{Axle, Bike};
use crate::store::tables::rows::{Coefficient, Manoeuvre, PlotPoint, SessionRow, TyreParameters};

/// The tyres of a session of which at least a half was ridden, front first.
pub(crate) fn rows(
    session: &SessionRow,
    coefficients: &[Coefficient],
    manoeuvres: &[Manoeuvre],
    plots: &[PlotPoint],
    bike: &Bike,
) -> Vec<TyreParameters> {
    let fitted = Fitted {
        session: session.clone(),
        coefficients: coefficients.to_vec(),
        ranges: Ranges::of(manoeuvres, plots),
        curves: Default::default(),
        named: Vec::new(),
    };
    let setting = Setting { bike: Some(bike), ..Setting::default() };
    let of = |axle| Characterised::new(&fitted, axle, &setting).ok().map(|c| row(session, &c));
    Axle::BOTH.into_iter().filter_map(of).collect()
}

fn row(session: &SessionRow, c: &Characterised) -> TyreParameters {
    let tyre = &c.tyre.tyre;
    let model = match c.axle {
        Axle::Front => &session.tyre_front,
        Axle::Rear => &session.tyre_rear,
    };
    TyreParameters {
        ident: session.ident.clone(),
        tyre: c.axle.name().to_owned(),
        tyre_model: model.clone(),
        longitudinal: c.longitudinal,
        lateral: c.lateral,
        load_at_rest: c.tyre.nominal_load,
        mf_b: tyre.friction.b,
        mf_c: tyre.friction.c,
        mf_d: tyre.friction.d,
        mf_e1: tyre.friction.e1,
        mf_e2: tyre.friction.e2,
        peak_slip: tyre.peak_slip,
        slip_stiffness_load: c.tyre.slip_stiffness_load,
        lateral_friction_ct: tyre.stiffness.ct,
        slip_camber_c1: tyre.stiffness.c1,
        slip_camber_c3: tyre.stiffness.c3,
        side_force_ratio: tyre.side_force_ratio,
        lateral_peak: tyre.lateral_peak,
        twisting_stiffness: tyre.twisting_stiffness,
        overturning_stiffness: tyre.overturning_stiffness,
        effective_rolling_radius: tyre.rolling_radius,
        rolling_resistance: tyre.rolling_resistance,
        relaxation_length: tyre.relaxation_length,
        longitudinal_relaxation: c.tyre.longitudinal_relaxation,
        vertical_stiffness: tyre.vertical_stiffness,
        deflection_share: c.tyre.deflection_share,
        camber_force_decay: tyre.camber_force_decay,
        camber_moment_decay: tyre.camber_moment_decay,
        ridden_slip_low: c.ranges.slip_ratio.map(|r| r[0]),
        ridden_slip_high: c.ranges.slip_ratio.map(|r| r[1]),
        ridden_slip_angle: Ranges::both_ways(c.ranges.slip_angle),
        ridden_camber: Ranges::both_ways(c.ranges.camber),
        ridden_load_low: c.loads[0],
        ridden_load_high: c.loads[1],
        braked_load_low: c.braked_loads.map(|loads| loads[0]),
        braked_load_high: c.braked_loads.map(|loads| loads[1]),
    }
}
