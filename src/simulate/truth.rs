//! What a characterisation of the simulated bike must find.
//!
//! Most coefficients are the plant's own parameters. `c1`, `c3` (eq. 37) and `ct` (eq. 38)
//! describe tyre, bike and course together: they are what the fit itself gives for the true slip
//! angles, cambers and forces of the ride, in the samples that the estimate takes too.

use super::motorcycle::Plant;
use super::simulated::Simulated;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part, Values};
use crate::estimate;
use crate::estimate::quasi_static::QuasiStatic;
use crate::estimate::signals::Signals;
use crate::fit::cornering;
use crate::manoeuvre::ManoeuvreKind;
use crate::model::tyre::trail_0;

/// True coefficients, in the order of the tables; those that are not known are not there.
pub type Truth = Vec<(Id, f64)>;

/// The true states of a tyre in the quasi-static, uncombined samples of a ride's corners, as
/// rows of the very fit that the estimates go through.
fn cornering_rows(
    plant: &Plant,
    ride: &Simulated,
    tyre: usize,
    config: &estimate::Config,
) -> cornering::Rows {
    let rate = ride.session.rate;
    let weight = plant.mass * GRAVITY;
    let step = (rate / config.corner_rate).round().max(1.0) as usize;
    let quasi_static = QuasiStatic::from(config);
    let mut signals = Signals::default();
    let mut clusters = Vec::new();
    for (number, &(kind, start, end, _)) in ride.labels.iter().enumerate() {
        if kind != ManoeuvreKind::Cornering {
            continue;
        }
        let range = (start * rate) as usize..((end * rate) as usize).min(ride.states.len());
        for i in range.step_by(step) {
            let (state, response) = (&ride.states[i], &ride.trace[i]);
            let pull = plant.mass * response.acceleration[0] + plant.drag * state.vx * state.vx;
            if quasi_static.holds(state.roll, state.roll_rate, pull, weight) {
                signals.camber[tyre].push(response.camber[tyre]);
                signals.slip_angle[tyre].push(state.alpha[tyre]);
                signals.force_y[tyre].push(response.tyre[tyre].force_y);
                signals.load[tyre].push(response.load[tyre]);
                clusters.push(number);
            }
        }
    }
    let keep: Vec<usize> = (0..clusters.len()).collect();
    cornering::rows(&signals, &clusters, &keep, tyre, plant.tyres[tyre].side_force_ratio)
}

/// Every coefficient of an on-road session; `config` chooses the corner samples as in the estimate.
pub fn coefficients(plant: &Plant, ride: &Simulated, config: &estimate::Config) -> Truth {
    let mut v = Values::default();
    let (lf, l) = (plant.cg_to_front, plant.wheelbase);
    let share = [(l - lf) / l, lf / l];
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let tyre = &plant.tyres[i];
        let lateral = cornering::fit(&cornering_rows(plant, ride, i, config)).parameters();
        let [c1, c3] = lateral.slip.unwrap_or([f64::NAN; 2]);
        let k0 = tyre.stiffness.k_alpha(0.0, tyre.side_force_ratio);
        let mf = tyre.friction;
        let load = plant.mass * GRAVITY * share[i];
        for (coefficient, value) in [
            (C::EffectiveRollingRadius, tyre.rolling_radius),
            (C::PeakSlip, tyre.peak_slip),
            (C::MfB, mf.b),
            (C::MfC, mf.c),
            (C::MfD, mf.d),
            (C::MfE1, mf.e1),
            (C::MfE2, mf.e2),
            (C::SlipCamberC1, c1),
            (C::SlipCamberC3, c3),
            (C::LateralFrictionCt, lateral.ct.unwrap_or(f64::NAN)),
            (C::CorneringStiffness0, k0),
            (C::CamberStiffness0, k0 * tyre.side_force_ratio),
            (C::SideForceRatio, tyre.side_force_ratio),
            (C::TwistingStiffness, tyre.twisting_stiffness),
            (C::OverturningStiffness, tyre.overturning_stiffness),
            (C::RelaxationLength, tyre.relaxation_length),
            (C::PneumaticTrail0, trail_0(tyre.rolling_radius, tyre.vertical_stiffness, load)),
        ] {
            v[(axle, coefficient)] = value;
        }
    }
    v[(Part::Vehicle, C::Drag)] = plant.drag;
    v[(Part::Vehicle, C::RollingResistance)] = plant.tyres[0].rolling_resistance;
    v[(Part::Vehicle, C::OverturningStiffness)] =
        (0..2).map(|i| share[i] * plant.tyres[i].overturning_stiffness).sum();
    Id::onroad().map(|id| (id, v[id])).collect()
}
