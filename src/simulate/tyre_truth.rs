//! What a characterisation of the nonlinear motorcycle's tyres would find if it were perfect.
//!
//! The tyres are not the paper's: its coefficients are read off them, upright and at the static
//! load, as a bench would. `c1`, `c3` and `ct` belong to a ride and are not given.

use super::truth::Truth;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::simulate::multibody::Model;
use crate::statistics::search;
use crate::tyre::magic_formula::MagicFormula;
use crate::tyre::paper::{Input, Stiffness, Tyre};
use crate::tyre::tyre_model::TyreModel;

/// The paper's coefficients of one tyre at a load, by central differences about rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bench {
    /// Cornering stiffness, 1/rad.
    pub cornering_stiffness: f64,
    /// Camber stiffness, 1/rad.
    pub camber_stiffness: f64,
    /// Twisting stiffness, m/rad.
    pub twisting_stiffness: f64,
    /// Overturning stiffness, m.
    pub overturning_stiffness: f64,
    /// Trail, m.
    pub trail: f64,
    /// Braking friction at its peak.
    pub peak_friction: f64,
    /// Normalised slip (`sigma_x`) of that peak.
    pub peak_slip: f64,
    /// Slip stiffness per load gained with the load once more, over itself: between 0.7 and 1.3 times the load.
    pub slip_stiffness_load: f64,
    /// Without slip, m.
    pub rolling_radius: f64,
    /// Speed over spin of a wheel that nothing but the road turns: it slips by what overcomes its rolling
    /// resistance, m.
    pub free_rolling_radius: f64,
    /// Relaxation length, m.
    pub relaxation_length: f64,
    /// Force that holds a freely rolling wheel back, over its load.
    pub rolling_resistance: f64,
}

/// Measures a tyre on the bench at a load (N) and a road friction.
pub fn bench(tyre: &dyn TyreModel, load: f64, friction: f64) -> Bench {
    let at = |slip_ratio: f64, slip_angle: f64, camber: f64| {
        tyre.forces(&Input { slip_ratio, slip_angle, camber, load, friction })
    };
    let h = 1e-4;
    let by_slip = (at(0.0, h, 0.0).force_y - at(0.0, -h, 0.0).force_y) / (2.0 * h);
    let by_camber = (at(0.0, 0.0, h).force_y - at(0.0, 0.0, -h).force_y) / (2.0 * h);
    let twist = (at(0.0, 0.0, h).moment_z - at(0.0, 0.0, -h).moment_z) / (2.0 * h);
    let aligning = (at(0.0, h, 0.0).moment_z - at(0.0, -h, 0.0).moment_z) / (2.0 * h);
    let braking = |s: f64| at(-s, 0.0, 0.0).force_x / load;
    let slip = search::minimum(braking, 0.005, 0.8, 1e-9).map_or(f64::NAN, |(slip, _)| slip);
    let carcass = tyre.carcass();
    let deflection = load / carcass.stiffness;
    let input = Input { slip_ratio: 0.0, slip_angle: 0.0, camber: 0.0, load, friction };
    let rolling_radius = carcass.rolling_radius(load, 0.0);
    let resistance = tyre.rolling_resistance(&input, 15.0) / (load * carcass.lever_arm(load, 0.0));
    let pull = |slip: f64| at(slip, 0.0, 0.0).force_x / load;
    let stiffness = |share: f64| {
        let load = share * load;
        let at = |slip_ratio: f64| {
            tyre.forces(&Input { slip_ratio, slip_angle: 0.0, camber: 0.0, load, friction })
        };
        (at(h).force_x - at(-h).force_x) / (2.0 * h * load)
    };
    let free_slip = -resistance * 2.0 * h / (pull(h) - pull(-h));
    Bench {
        cornering_stiffness: -by_slip / load,
        camber_stiffness: -by_camber / load,
        twisting_stiffness: -twist / load,
        overturning_stiffness: (carcass.crown - deflection).max(0.0),
        trail: aligning / -by_slip,
        peak_friction: -braking(slip),
        // a friction that never falls has no peak
        peak_slip: if slip < 0.75 { slip / (1.0 - slip) } else { f64::NAN },
        slip_stiffness_load: (stiffness(1.3) - stiffness(0.7)) / (0.6 * stiffness(1.0)),
        rolling_radius,
        free_rolling_radius: rolling_radius / (1.0 + free_slip),
        relaxation_length: tyre.relaxation(load, 15.0).lateral,
        rolling_resistance: resistance,
    }
}

/// The paper's tyre that is most like another: what the bench shows of it at a load (N), on its own road.
pub(crate) fn like(tyre: &dyn TyreModel, load: f64) -> Tyre {
    let b = bench(tyre, load, 1.0);
    let (peak_friction, peak_slip) = (b.peak_friction, b.peak_slip);
    let ratio = b.camber_stiffness / b.cornering_stiffness;
    let pull = |slip_ratio: f64| {
        let input = Input { slip_ratio, slip_angle: 0.0, camber: 0.0, load, friction: 1.0 };
        tyre.forces(&input).force_x / load
    };
    let stiffness = (pull(1e-4) - pull(-1e-4)) / 2e-4;
    let c = 1.5;
    Tyre {
        friction: MagicFormula {
            b: stiffness / (c * peak_friction),
            c,
            d: peak_friction,
            e1: 0.0,
            e2: 0.0,
        },
        stiffness: Stiffness { ct: -b.cornering_stiffness * ratio, c1: 0.0, c3: 0.0 },
        side_force_ratio: ratio,
        twisting_stiffness: b.twisting_stiffness,
        overturning_stiffness: b.overturning_stiffness,
        rolling_radius: b.rolling_radius,
        rolling_resistance: b.rolling_resistance,
        relaxation_length: b.relaxation_length,
        vertical_stiffness: tyre.carcass().stiffness,
        camber_force_decay: 1.0,
        camber_moment_decay: 1.0,
        reference_friction: 1.0,
        peak_slip: if peak_slip.is_finite() { peak_slip } else { 0.2 },
        lateral_peak: 0.0,
    }
}

/// Peak of the friction that braking asks of a tyre upright at a load (N), and its normalised slip. As an
/// estimate counts them: beyond the rolling resistance, from free rolling on.
pub(crate) fn braked_peak(tyre: &dyn TyreModel, load: f64, friction: f64) -> [f64; 2] {
    let b = bench(tyre, load, friction);
    let locked = 1.0 / (1.0 + b.peak_slip);
    let slip = 1.0 - locked * b.free_rolling_radius / b.rolling_radius;
    [b.peak_friction - b.rolling_resistance, slip / (1.0 - slip)]
}

/// The truth of a motorcycle; none where its tyres are not known.
pub fn coefficients(model: &Model) -> Truth {
    let m = &model.motorcycle;
    let loads = m.static_loads();
    let Some(tyres) = &m.tyres else { return Vec::new() };
    let friction = model.road.friction;
    let both: [Bench; 2] = std::array::from_fn(|i| bench(tyres[i].as_ref(), loads[i], friction));
    let mut truth = Vec::new();
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let b = &both[i];
        let [peak_friction, peak_slip] = braked_peak(tyres[i].as_ref(), loads[i], friction);
        truth.extend(
            [
                (C::EffectiveRollingRadius, b.free_rolling_radius),
                (C::PeakSlip, peak_slip),
                (C::MfD, peak_friction),
                (C::SlipStiffnessLoad, b.slip_stiffness_load),
                (C::CorneringStiffness0, b.cornering_stiffness),
                (C::CamberStiffness0, b.camber_stiffness),
                (C::SideForceRatio, b.camber_stiffness / b.cornering_stiffness),
                (C::TwistingStiffness, b.twisting_stiffness),
                (C::OverturningStiffness, b.overturning_stiffness),
                (C::RelaxationLength, b.relaxation_length),
                (C::PneumaticTrail0, b.trail),
            ]
            .map(|(coefficient, value)| (Id::from((axle, coefficient)), value)),
        );
    }
    let weight = loads[0] + loads[1];
    let mean = |f: fn(&Bench) -> f64| (f(&both[0]) * loads[0] + f(&both[1]) * loads[1]) / weight;
    truth.extend(
        [
            (C::Drag, 0.5 * m.air_density * m.aerodynamics[0]),
            (C::RollingResistance, mean(|b| b.rolling_resistance)),
            (C::OverturningStiffness, mean(|b| b.overturning_stiffness)),
        ]
        .map(|(coefficient, value)| (Id::from((Part::Vehicle, coefficient)), value)),
    );
    truth
}
