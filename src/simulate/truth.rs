//! What a characterisation of the simulated bike must find.
//!
//! Most coefficients are the plant's own parameters. `c1`, `c3` (eq. 37) and `ct` (eq. 38)
//! describe tyre, bike and course together: they are what the fit itself gives for the true slip
//! angles, cambers and forces of the ride, in the samples that the estimate takes too.

use super::motorcycle::Plant;
use super::ride::MultibodyRide;
use super::simulated::{Label, Simulated};
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part, Values};
use crate::estimate;
use crate::estimate::quasi_static::QuasiStatic;
use crate::estimate::signals::Signals;
use crate::fit::cornering;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::multibody::Wheel;
use crate::tyre::paper::trail_0;

/// True coefficients, in the order of the tables; those that are not known are not there.
pub(crate) type Truth = Vec<(Id, f64)>;

/// True values of both tyres at one sample of a ride, front and rear.
struct Cornering {
    roll: f64,
    roll_rate: f64,
    /// Of both tyres, N.
    longitudinal: f64,
    camber: [f64; 2],
    slip_angle: [f64; 2],
    force_y: [f64; 2],
    load: [f64; 2],
}

/// The true states of a tyre in the quasi-static, uncombined samples of a ride's corners, as
/// rows of the very fit that the estimates go through. `at` gives what is true at one of `len` samples.
fn cornering_rows(
    (labels, rate, len): (&[Label], f64, usize),
    at: &dyn Fn(usize) -> Cornering,
    weight: f64,
    (tyre, side_force_ratio): (usize, f64),
    config: &estimate::Config,
) -> cornering::Rows {
    let step = (rate / config.corner_rate).round().max(1.0) as usize;
    let quasi_static = QuasiStatic::from(config);
    let mut signals = Signals::default();
    let mut clusters = Vec::new();
    for (number, &(kind, start, end, _)) in labels.iter().enumerate() {
        if kind != ManoeuvreKind::Cornering {
            continue;
        }
        let range = (start * rate) as usize..((end * rate) as usize).min(len);
        for i in range.step_by(step) {
            let now = at(i);
            if quasi_static.holds(now.roll, now.roll_rate, now.longitudinal, weight) {
                signals.camber[tyre].push(now.camber[tyre]);
                signals.slip_angle[tyre].push(now.slip_angle[tyre]);
                signals.force_y[tyre].push(now.force_y[tyre]);
                signals.load[tyre].push(now.load[tyre]);
                clusters.push(number);
            }
        }
    }
    let keep: Vec<usize> = (0..clusters.len()).collect();
    cornering::rows(&signals, &clusters, &keep, tyre, side_force_ratio)
}

/// `c1`, `c3`, `ct` and the overturning stiffnesses of both tyres on a ride of the multibody motorcycle, whose
/// side-force ratios are given. The overturning moment of a tyre of another form is not its crown's alone.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn of_corners(
    ride: &MultibodyRide,
    weight: f64,
    side_force_ratio: [f64; 2],
    config: &estimate::Config,
) -> Truth {
    let at = |i: usize| {
        let s = &ride.samples[i];
        let each = |f: fn(&Wheel) -> f64| [f(&s.wheels[0]), f(&s.wheels[1])];
        Cornering {
            roll: s.wheels[1].camber,
            roll_rate: s.motion.spin.x,
            longitudinal: s.wheels[0].force[0] + s.wheels[1].force[0],
            camber: each(|w| w.camber),
            slip_angle: each(|w| w.slip[1]),
            force_y: each(|w| w.force[1]),
            load: each(|w| w.load),
        }
    };
    let ridden = (ride.labels.as_slice(), ride.session.rate, ride.samples.len());
    let of = |(i, axle): (usize, Axle)| {
        let rows = cornering_rows(ridden, &at, weight, (i, side_force_ratio[i]), config);
        lateral(&rows).map(|(coefficient, value)| (Id::from((axle, coefficient)), value))
    };
    let mut out: Truth = Axle::BOTH.into_iter().enumerate().flat_map(of).collect();
    out.extend(overturning(ride, weight, config));
    out
}

/// Overturning stiffness of both tyres and of both together, m: moment over load times tangent of camber, by
/// least squares over the samples that the estimate takes.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
fn overturning(ride: &MultibodyRide, weight: f64, config: &estimate::Config) -> Truth {
    let quasi_static = QuasiStatic::from(config);
    // sums of moment times lever and of lever squared: front, rear, both
    let mut sums = [[0.0; 2]; 3];
    for &(kind, start, end, _) in &ride.labels {
        if kind != ManoeuvreKind::Cornering {
            continue;
        }
        let rate = ride.session.rate;
        for s in
            &ride.samples[(start * rate) as usize..((end * rate) as usize).min(ride.samples.len())]
        {
            let longitudinal = s.wheels[0].force[0] + s.wheels[1].force[0];
            if !quasi_static.holds(s.wheels[1].camber, s.motion.spin.x, longitudinal, weight) {
                continue;
            }
            let lever = [0, 1].map(|k| s.wheels[k].load * s.wheels[k].camber.tan());
            let moment = [0, 1].map(|k| -s.wheels[k].moment_x);
            let all = [(moment[0], lever[0]), (moment[1], lever[1])];
            let both = (moment[0] + moment[1], lever[0] + lever[1]);
            for (sum, (moment, lever)) in sums.iter_mut().zip(all.into_iter().chain([both])) {
                sum[0] += moment * lever;
                sum[1] += lever * lever;
            }
        }
    }
    let parts = [Part::Front, Part::Rear, Part::Vehicle];
    let known = parts.into_iter().zip(sums).filter(|(_, [_, squares])| *squares > 0.0);
    known
        .map(|(part, [sum, squares])| (Id::from((part, C::OverturningStiffness)), sum / squares))
        .collect()
}

/// `c1`, `c3` and `ct` as a fit gives them.
fn lateral(rows: &cornering::Rows) -> [(C, f64); 3] {
    let lateral = cornering::fit(rows).parameters();
    let [c1, c3] = lateral.slip.unwrap_or([f64::NAN; 2]);
    let ct = lateral.ct.unwrap_or(f64::NAN);
    [(C::SlipCamberC1, c1), (C::SlipCamberC3, c3), (C::LateralFrictionCt, ct)]
}

/// Every coefficient of an on-road session; `config` chooses the corner samples as in the estimate.
pub fn coefficients(plant: &Plant, ride: &Simulated, config: &estimate::Config) -> Truth {
    let vehicle = &plant.vehicle;
    let mut v = Values::default();
    let (lf, l) = (vehicle.cg_to_front, vehicle.wheelbase);
    let share = [(l - lf) / l, lf / l];
    let at = |k: usize| {
        let (state, response) = (&ride.states[k], &ride.trace[k]);
        Cornering {
            roll: state.roll,
            roll_rate: state.roll_rate,
            longitudinal: vehicle.mass * response.acceleration[0]
                + vehicle.drag * state.vx * state.vx,
            camber: response.camber,
            slip_angle: state.alpha,
            force_y: response.tyre.map(|t| t.force_y),
            load: response.load,
        }
    };
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let tyre = &plant.tyres[i];
        let ridden = (ride.labels.as_slice(), ride.session.rate, ride.states.len());
        let weight = vehicle.mass * GRAVITY;
        let of = (i, tyre.side_force_ratio);
        for (coefficient, value) in lateral(&cornering_rows(ridden, &at, weight, of, config)) {
            v[(axle, coefficient)] = value;
        }
        let k0 = tyre.stiffness.k_alpha(0.0, tyre.side_force_ratio);
        let mf = tyre.friction;
        let load = vehicle.mass * GRAVITY * share[i];
        for (coefficient, value) in [
            (C::EffectiveRollingRadius, tyre.rolling_radius),
            (C::PeakSlip, tyre.peak_slip),
            (C::MfB, mf.b),
            (C::MfC, mf.c),
            (C::MfD, mf.d),
            (C::MfE1, mf.e1),
            (C::MfE2, mf.e2),
            (C::SlipStiffnessLoad, vehicle.slip_stiffness_load),
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
    v[(Part::Vehicle, C::Drag)] = vehicle.drag;
    v[(Part::Vehicle, C::RollingResistance)] = plant.tyres[0].rolling_resistance;
    v[(Part::Vehicle, C::OverturningStiffness)] =
        (0..2).map(|i| share[i] * plant.tyres[i].overturning_stiffness).sum();
    Id::onroad().map(|id| (id, v[id])).collect()
}
