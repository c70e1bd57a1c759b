//! Coefficients of the motorcycle Magic Formula that reproduce a characterised tyre.
//!
//! The longitudinal curve carries over as it is. The lateral one does not: the characterised tyre
//! is linear in the slip angle and its stiffness follows camber by eq. 39, the Magic Formula
//! bends and has a peak; and combined slip is weighed by other functions. Those are shaped
//! ([`super::shape`]). What the side force per load gains with load follows in closed form, to first order.

use super::ends::{Ends, steps};
use super::grid::Grid;
use super::over_load::OverLoad;
use super::shape::{Apply, Force, Shape, solve};
use super::tyre::Characterised;
use super::validity::Validity;
use crate::report::export::error::Error;
use crate::tyre::mf_mc::MfMc;
use crate::tyre::paper::trail_0;
use crate::tyre::tyre_model::TyreModel;

/// `pKy3`: so large that the stiffness is proportional to load, as the characterised tyre has it
/// (within 0.2 % up to three times the nominal load).
const PKY3: f64 = 50.0;
/// Shape of the trail over slip.
pub(crate) const QCZ1: f64 = 1.1;
/// How far the lateral peak may lie above the one that is assumed ([`Validity::peak`]): no ride has shown it.
pub(crate) const PEAK: f64 = 1.15;

/// The motorcycle set of a characterised tyre.
///
/// # Errors
/// The fit does not come to an end.
pub(crate) fn motorcycle(tyre: &Characterised) -> Result<MfMc, Error> {
    let over_load = OverLoad::of(tyre);
    let mut set = start(tyre, &over_load);
    lateral(tyre, &mut set, &over_load)?;
    let friction = tyre.tyre.tyre.reference_friction;
    // from the friction of the ride's road to 1
    set.pDx = set.pDx.map(|x| x / friction);
    set.pDy[0] /= friction;
    set.qBz[0] *= friction;
    if tyre.with_bike {
        combined(tyre, &mut set)?;
    }
    Ok(set)
}

/// Parameters that follow in closed form.
fn start(c: &Characterised, over_load: &OverLoad) -> MfMc {
    let t = &c.tyre.tyre;
    let (load, radius) = (c.load(), t.rolling_radius);
    let mf = &t.friction;
    // the form has the odd part as a share of the even one
    let e1 = if mf.e1.abs() < 1e-6 { 1e-6 } else { mf.e1 };
    let k_alpha = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let (side, gain) = (over_load.side_force[0], over_load.side_force_gain());
    let pky3 = proportional(gain);
    let trails = trail_over_load(c, over_load).map(|t| t / radius);
    let [friction, slope] = over_load.friction.map(|share| mf.d * share);
    let [slip_stiffness, gained] = over_load.slip_stiffness_of(mf.stiffness());
    let shrink = trail_shrinks(c, |angle| angle);
    MfMc {
        Fz0: load,
        R0: radius,
        carcass: crate::tyre::tyre_model::Carcass {
            radius,
            crown: c.tyre.carcass().crown.min(0.9 * radius),
            stiffness: t.vertical_stiffness,
            damping: c.tyre.vertical_damping,
            deflection_share: 0.0,
        },
        pCx1: mf.c,
        pDx: [friction, slope],
        pEx: [e1, 0.0, 0.0, -mf.e2 / e1],
        pKx: [slip_stiffness, gained, over_load.friction_exponent],
        pCy: [1.0, 1.5],
        pDy: [1.0, gain, 0.0],
        pEy: [-1.5, 0.0, 0.0, -5.0],
        pKy: [
            -side * k_alpha / share(pky3),
            2.0,
            pky3,
            0.0,
            0.0,
            -side * k_alpha * t.side_force_ratio,
            -side * k_alpha * t.side_force_ratio * gain,
        ],
        rBx: [0.0; 2],
        rCx1: 1.0,
        rBy: [0.0; 3],
        rCy1: 1.0,
        qCz1: QCZ1,
        qBz: [shrink, 0.0, 0.0, 0.0, 0.0, 0.0],
        qDz: [trails[0], trails[1], 0.0, 0.0],
        qDzr: [-t.twisting_stiffness / radius, 0.0, 0.0, 0.0],
        qEz: [0.0; 3],
        qHz: [0.0; 2],
        lag: [0.0; 3],
        lag_x: c.tyre.longitudinal_relaxation,
        // saturated from a thousandth of the nominal load on: the same at every load
        relaxation: Some([t.relaxation_length / radius, 1.0, 0.001]),
        rolling: t.rolling_resistance,
        rolling_speed: c.error.rolling_resistance(0.0, 1.0),
        camber_scale: 1.0,
        overturning: Some({
            let arm = linear(Ends::of(c).camber) * t.overturning_stiffness / radius;
            [arm, 0.0, arm]
        }),
    }
}

/// `QBZ1` with which `cos(QCZ1 atan(QBZ1 alpha))` stays closest to how slip shortens the trail (eq. 11), over all
/// slip angles of the file; `of` is what the form has for the slip angle.
pub(crate) fn trail_shrinks(c: &Characterised, of: fn(f64) -> f64) -> f64 {
    let t = &c.tyre.tyre;
    let k_alpha = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let left = |a: f64| (1.0 - k_alpha / (3.0 * t.reference_friction) * a.tan()).max(0.0);
    let angles = steps([0.0, Validity::of(c).ends.slip_angle], 101);
    let off = |b: f64| {
        let off = |a: &f64| ((QCZ1 * (b * of(*a)).atan()).cos() - left(*a)).abs();
        angles.iter().map(off).fold(0.0, f64::max)
    };
    let shrinks = steps([0.1, 60.0], 600);
    shrinks.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1.0)
}

/// `QDZ1 R0` and `QDZ2 R0`, m: the trail grows with the root of the load (eq. 12), which the form's
/// `load (QDZ1 + QDZ2 dfz)` has right at the nominal load, and as close as it can over the ridden loads and, with a
/// third of the weight, over those of the file.
pub(crate) fn trail_over_load(c: &Characterised, over_load: &OverLoad) -> [f64; 2] {
    let t = &c.tyre.tyre;
    let trail = |load: f64| trail_0(t.rolling_radius, t.vertical_stiffness, load);
    // more trail does not depend on load
    let more = c.error.relative_trail(0.0) * t.trail_0(c.tyre.nominal_load);
    let (side, gain) = (over_load.side_force[0], over_load.side_force_gain());
    // the file's trail acts on its side force, which changes with load
    let wanted =
        |dfz: f64| (trail(c.load() * (1.0 + dfz)) + more) / (side * (1.0 + gain * dfz).max(0.2));
    let first = wanted(0.0);
    let both = [(c.loads, 1.0), (Validity::of(c).ends.load, 0.3)];
    let points: Vec<[f64; 2]> = both
        .into_iter()
        .flat_map(|(loads, weight)| steps(loads, 21).into_iter().map(move |l| [l, weight]))
        .collect();
    let off = |second: f64| {
        let off = |[load, weight]: &[f64; 2]| {
            let dfz = load / c.load() - 1.0;
            weight * ((1.0 + dfz) * (first + second * dfz) - wanted(dfz)).abs()
        };
        points.iter().map(off).fold(0.0, f64::max)
    };
    let seconds = steps([-1.5 * first, 0.5 * first], 401);
    let second = seconds.into_iter().min_by(|a, b| off(*a).total_cmp(&off(*b)));
    [first, second.unwrap_or(-0.5 * first)]
}

/// The slope of the line that stays closest to `tan` up to an angle: the form is linear in camber.
pub(crate) fn linear(most: f64) -> f64 {
    let off = |slope: f64| {
        let angles = (1..=50).map(|i| most * f64::from(i) / 50.0);
        angles.map(|g| (g.tan() - slope * g).abs()).fold(0.0, f64::max)
    };
    let top = most.tan() / most;
    let slope = |i: i32| 1.0 + (top - 1.0) * f64::from(i) / 200.0;
    (0..=200).map(slope).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap_or(1.0)
}

/// Stiffness over load at the nominal load for `pKy1` = 1.
fn share(pky3: f64) -> f64 {
    (2.0 * (1.0 / pky3).atan()).sin()
}

/// `pKy3` with which the stiffness per load gains a share of itself with the nominal load once more, to first
/// order: `1/(1 + (Fz/(pKy3 Fz0))²)` loses `2/(1 + pKy3²)`. The form has no gain.
pub(crate) fn proportional(gain: f64) -> f64 {
    if gain < 0.0 { (-2.0 / gain - 1.0).max(1.0).sqrt().min(PKY3) } else { PKY3 }
}

fn lateral(c: &Characterised, set: &mut MfMc, over_load: &OverLoad) -> Result<(), Error> {
    lateral_at_nominal(c, set)?;
    set.pKy[6] = set.pKy[5] * over_load.side_force_gain();
    Ok(())
}

/// At the nominal load.
fn lateral_at_nominal(c: &Characterised, set: &mut MfMc) -> Result<(), Error> {
    let validity = Validity::of(c);
    let (peak, g2) = (validity.peak, validity.ends.camber.powi(2));
    let stiffness = set.pKy[0];
    let apply: Apply<MfMc> = |set, x| {
        set.pCy = [x[0], x[7]];
        set.pDy = [x[1], set.pDy[1], x[10]];
        set.pEy = [x[2], x[3], x[4], x[8]];
        set.pKy[0] = x[5];
        set.pKy[4] = x[6];
        set.pKy[5] = x[9];
    };
    let bounds = [
        // from 1 on the peak is reached, and beyond it the force falls little
        (1.0, 1.6),
        (peak, PEAK * peak),
        (-60.0, 1.0),
        (-60.0 / g2.max(1.0), 60.0),
        (-25.0, 25.0),
        // what handling is computed with: kept
        (1.01 * stiffness, 0.99 * stiffness),
        (-0.6 / g2, 6.0),
        (0.4, 2.0),
        (-100.0, 1.0),
        (3.0 * set.pKy[5], 0.3 * set.pKy[5]),
        // no camber has a larger peak than the upright wheel
        (0.0, 3.0),
    ];
    let (camber, peak) = (set.pKy[5], 1.1 * peak);
    let starts = [
        vec![1.1, peak, -1.5, 0.0, -3.0, stiffness, 0.0, 1.5, -5.0, camber, 0.05],
        vec![1.4, peak, -1.0, 1.0, 3.0, stiffness, -0.1, 1.5, -5.0, camber, 0.05],
        vec![1.2, peak, -4.0, 0.0, 0.0, stiffness, 0.0, 0.6, -0.5, camber, 0.05],
    ];
    solve(
        c,
        set,
        Grid::lateral,
        &Shape {
            friction: Some(1.0),
            force: SIDE,
            apply,
            bounds: &bounds,
            starts: &starts,
            beyond: LATERAL,
            most: MAX_EXCESS_BEYOND,
        },
    )
}

fn combined(c: &Characterised, set: &mut MfMc) -> Result<(), Error> {
    let apply: Apply<MfMc> = |set, x| {
        set.rBx = [x[0], x[1]];
        set.rCx1 = x[2];
    };
    let starts = [vec![8.0, 8.0, 0.95], vec![30.0, 30.0, 0.95]];
    let along = Shape {
        friction: None,
        force: ALONG,
        apply,
        bounds: &COMBINED,
        starts: &starts,
        beyond: COMBINED_BEYOND,
        most: f64::INFINITY,
    };
    solve(c, set, Grid::combined, &along)?;
    let apply: Apply<MfMc> = |set, x| {
        set.rBy = [x[0], x[1], 0.0];
        set.rCy1 = x[2];
    };
    solve(
        c,
        set,
        Grid::combined,
        &Shape {
            friction: None,
            force: SIDE,
            apply,
            bounds: &COMBINED,
            starts: &starts,
            beyond: COMBINED_BEYOND,
            most: f64::INFINITY,
        },
    )
}

/// Weight of side forces beyond what was ridden: little, the ridden ones are known.
pub(crate) const LATERAL: f64 = 0.006;
/// Of side forces beyond, over the largest: one tyre in 24 was 0.7 off where the form fits ill.
pub(crate) const MAX_EXCESS_BEYOND: f64 = 0.25;
/// Weight of combined slip beyond: nobody rides it, so that small slips count no more than large ones.
pub(crate) const COMBINED_BEYOND: f64 = 0.15;
/// Of the weighting functions: a cosine whose argument stays below a right angle turns no force's sign.
pub(crate) const COMBINED: [(f64, f64); 3] = [(0.0, 100.0), (0.0, 100.0), (0.2, 1.0)];

const ALONG: Force<MfMc> = (MfMc::force_x, |o| o.force_x);
const SIDE: Force<MfMc> = (MfMc::force_y, |o| o.force_y);
