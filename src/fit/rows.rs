//! From selected samples and their signals to the rows of the fits.

use super::coasting::Coasting;
use super::config::FrictionConfig;
use super::data::Data;
use super::{cornering, friction};
use crate::contract::bike::{Axle, Bike};
use crate::estimate::signals::{Inputs, Signals};
use crate::tyre::formulation::Formulation;
use crate::tyre::paper::slip_stiffness_under;

/// Error of the friction per rate of the slip ratio, s: what a 20 Hz filter leaves of it.
const FILTER_BLUR: f64 = 0.004;
/// Friction from which a sample shows that a tyre was driven, or braked.
const LARGE_FRICTION: f64 = 0.25;
/// Such samples of each sign that let `e2` be fitted.
const BOTH_SIGNS: usize = 20;

/// The kept straight samples of tyre `k`, with the friction's expected errors: slips that the load at rest would have,
/// where the slip stiffness goes with the load.
pub(crate) fn friction_rows(
    data: &Data,
    inputs: &Inputs,
    signals: &Signals,
    k: usize,
    keep: &[usize],
    coasting: &Coasting,
    config: &FrictionConfig,
) -> friction::Rows {
    // the residual between velocity and wheel in coasting is the error of their difference
    let from_coasting = coasting.radius[k].as_ref().map_or(0.0, |f| f.quality.scale);
    let velocity_error = config.velocity_error.max(from_coasting);
    let from_coasting = coasting.resistance.as_ref().map_or(0.0, |f| f.quality.scale);
    let friction_error = config.friction_error.max(from_coasting);
    let mut rows = match inputs.rolling_front {
        Some(front) if k == 1 => {
            friction::Rows::with_white_error(config.velocity_error.max(front.error))
        }
        _ => friction::Rows::with_error(velocity_error),
    };
    let samples = &data.straight[k];
    let axle = Axle::BOTH[k];
    let still = inputs.bike.static_load(axle);
    let gain = match inputs.formulation {
        Formulation::Corrected => inputs.bike.slip_stiffness_load(axle),
        Formulation::Paper => 0.0,
    };
    let mut signs = [0_usize; 2];
    for &i in keep {
        let mu = signals.force_x[k][i] / signals.load[k][i];
        let stiffer = slip_stiffness_under(gain, signals.load[k][i] / still - 1.0);
        rows.slip.push(stiffer * signals.slip_ratio[k][i]);
        rows.friction.push(mu);
        let v = signals.speed[i];
        let slip = signals.slip_ratio[k][i];
        // a wheel that locks within a tenth of a second is blurred by the filter
        let wheel = data.nominal_radius[k] * samples.omega_rate[k][i];
        let slip_rate = (wheel - (1.0 + slip) * samples.acceleration_x[i]) / v;
        rows.speed.push(v);
        rows.friction_error.push(friction_error.hypot(FILTER_BLUR * slip_rate));
        rows.clusters.push(data.straight[k].segment[i]);
        signs[usize::from(mu > 0.0)] += usize::from(mu.abs() > LARGE_FRICTION);
    }
    rows.both_signs = signs.iter().all(|&n| n >= BOTH_SIGNS);
    rows.index();
    rows
}

/// The kept corner samples of one tyre.
pub(crate) fn lateral_rows(
    data: &Data,
    signals: &Signals,
    bike: &Bike,
    keep: &[usize],
    axle: Axle,
) -> cornering::Rows {
    let ratio = bike.wheel(axle).side_force_ratio;
    let samples = &data.corner;
    let rows = cornering::rows(signals, &samples.segment, keep, axle as usize, ratio);
    rows.with_sd_of_angle(keep.iter().map(|&i| samples.velocity_y_sd[i] / signals.speed[i]))
}

/// `k_x` of the front tyre, for the yaw moment (19) of the lateral balance.
pub(crate) fn front_overturning(theta: Option<f64>, inputs: &Inputs) -> Option<f64> {
    match inputs.formulation {
        Formulation::Corrected => theta,
        Formulation::Paper => None,
    }
}
