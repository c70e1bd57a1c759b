//! What a characterisation of the simulated bike must find.
//!
//! Most coefficients are the plant's own parameters. `c1`, `c3` (eq. 37) and `ct` (eq. 38)
//! describe tyre, bike and course together: they are what the fit itself gives for the true slip
//! angles, cambers and forces of the ride.

use super::Simulated;
use super::motorcycle::Plant;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::manoeuvre::ManoeuvreKind;
use crate::estimate::signals::Signals;
use crate::fit::cornering;
use crate::model::tyre::trail_0;

/// One true coefficient: tyre, name, value, unit.
pub type True = (&'static str, &'static str, f64, &'static str);

/// The true states of a tyre in the quasi-static, uncombined samples of a ride's corners, as
/// rows of the very fit that the estimates go through.
fn cornering_rows(plant: &Plant, ride: &Simulated, tyre: usize) -> cornering::Rows {
    let rate = ride.session.rate;
    let weight = plant.mass * GRAVITY;
    let step = (rate / 12.5).round().max(1.0) as usize;
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
            if state.roll_rate.abs() < 0.1 && state.roll.abs() > 0.07 && pull.abs() < 0.15 * weight
            {
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

/// Every coefficient of the contract.
pub fn coefficients(plant: &Plant, ride: &Simulated) -> Vec<True> {
    let mut rows = Vec::new();
    let (lf, l) = (plant.cg_to_front, plant.wheelbase);
    let share = [(l - lf) / l, lf / l];
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let tyre = &plant.tyres[i];
        let name = axle.name();
        let (slip, ct, _) = cornering::fit(&cornering_rows(plant, ride, i)).values();
        let [c1, c3] = slip.unwrap_or([f64::NAN; 2]);
        let k0 = tyre.stiffness.k_alpha(0.0, tyre.side_force_ratio);
        let mf = tyre.friction;
        let load = plant.mass * GRAVITY * share[i];
        rows.extend([
            (name, "effective_rolling_radius", tyre.rolling_radius, "m"),
            (name, "peak_slip", tyre.peak_slip, "1"),
            (name, "mf_b", mf.b, "1"),
            (name, "mf_c", mf.c, "1"),
            (name, "mf_d", mf.d, "1"),
            (name, "mf_e1", mf.e1, "1"),
            (name, "mf_e2", mf.e2, "1"),
            (name, "slip_camber_c1", c1, "1"),
            (name, "slip_camber_c3", c3, "1/rad2"),
            (name, "lateral_friction_ct", ct.unwrap_or(f64::NAN), "1"),
            (name, "cornering_stiffness_0", k0, "1/rad"),
            (name, "camber_stiffness_0", k0 * tyre.side_force_ratio, "1/rad"),
            (name, "side_force_ratio", tyre.side_force_ratio, "1"),
            (name, "twisting_stiffness", tyre.twisting_stiffness, "m/rad"),
            (name, "overturning_stiffness", tyre.overturning_stiffness, "m"),
            (name, "relaxation_length", tyre.relaxation_length, "m"),
            (
                name,
                "pneumatic_trail_0",
                trail_0(tyre.rolling_radius, tyre.vertical_stiffness, load),
                "m",
            ),
        ]);
    }
    let crown: f64 = (0..2).map(|i| share[i] * plant.tyres[i].overturning_stiffness).sum();
    rows.extend([
        ("vehicle", "drag", plant.drag, "kg/m"),
        ("vehicle", "rolling_resistance", plant.tyres[0].rolling_resistance, "1"),
        ("vehicle", "overturning_stiffness", crown, "m"),
    ]);
    rows
}
