//! Coefficients of the motorcycle Magic Formula that reproduce a characterised tyre.
//!
//! The longitudinal curve carries over as it is. The lateral one does not: the characterised tyre
//! is linear in the slip angle and its stiffness follows camber by eq. 39, the Magic Formula
//! bends; and combined slip is weighed by other functions. Those are fitted by least squares
//! over the ridden ranges, then by fourth powers, which spreads what is left evenly. What the side force
//! per load gains with load follows in closed form, to first order.

use super::grid;
use super::over_load::OverLoad;
use super::tyre::Characterised;
use crate::model::mf_mc::MfMc;
use crate::model::tyre::{Input, Output, trail_0};
use crate::model::tyre_model::TyreModel;
use crate::statistics::nonlinear::{self, Model, Options};

/// `pKy3`: so large that the stiffness is proportional to load, as the characterised tyre has it
/// (within 0.2 % up to three times the nominal load).
const PKY3: f64 = 50.0;
/// Shape of the trail over slip.
const QCZ1: f64 = 1.1;
/// Share of the peak lateral friction above what was ridden, which no ride has shown.
const PEAK: [f64; 2] = [1.15, 1.8];

/// The motorcycle set of a characterised tyre.
///
/// # Errors
/// A sentence: the fit does not come to an end.
pub fn motorcycle(tyre: &Characterised) -> Result<MfMc, String> {
    let over_load = OverLoad::of(tyre);
    let mut set = start(tyre, &over_load);
    lateral(tyre, &mut set, &over_load)?;
    let length = tyre.tyre.tyre.relaxation_length;
    set.lag = [length / set.Kya(tyre.load(), 0.0).abs(), 0.0, 0.0];
    if tyre.with_bike {
        combined(tyre, &mut set)?;
    }
    Ok(set)
}

/// What follows in closed form.
fn start(c: &Characterised, over_load: &OverLoad) -> MfMc {
    let t = &c.tyre.tyre;
    let (load, radius) = (c.load(), t.rolling_radius);
    let mf = &t.friction;
    // the form has the odd part as a share of the even one
    let e1 = if mf.e1.abs() < 1e-6 { 1e-6 } else { mf.e1 };
    let k_alpha = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let trail = trail_0(radius, t.vertical_stiffness, load);
    // more trail does not depend on load
    let more = c.error.relative_trail(0.0) * t.trail_0(c.tyre.nominal_load);
    let (side, gain) = (over_load.side_force[0], over_load.side_force_gain());
    let pky3 = proportional(gain);
    // the file's trail acts on its side force, which changes with load
    let trails = [(trail + more) / (radius * side), -(0.5 * trail + more) / (radius * side)];
    let [friction, slope] = over_load.friction.map(|share| mf.d * share);
    let [slip_stiffness, gained] = over_load.slip_stiffness_of(mf.stiffness());
    let angle = grid::Ends::of(c).slip_angle;
    // cos(QCZ1 atan(QBZ1 alpha)) meets eq. 11 at the largest slip angle ridden
    let left = (1.0 - k_alpha / (3.0 * t.reference_friction) * angle.tan()).clamp(0.0, 1.0);
    let shrink = (left.acos() / QCZ1).min(1.5).tan() / angle;
    MfMc {
        Fz0: load,
        R0: radius,
        carcass: crate::model::tyre_model::Carcass {
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
        // the trail grows with the root of the load
        qDz: [trails[0], trails[1] - gain * trails[0], 0.0, 0.0],
        qDzr: [-t.twisting_stiffness / radius, 0.0, 0.0, 0.0],
        qEz: [0.0; 3],
        qHz: [0.0; 2],
        lag: [0.0; 3],
        lag_x: c.tyre.longitudinal_relaxation,
        rolling: t.rolling_resistance,
        rolling_speed: c.error.rolling_resistance(0.0, 1.0),
        camber_scale: 1.0,
        overturning: Some({
            let arm = linear(grid::Ends::of(c).camber) * t.overturning_stiffness / radius;
            [arm, 0.0, arm]
        }),
    }
}

/// The slope of the line that stays closest to `tan` up to an angle: the form is linear in camber.
pub fn linear(most: f64) -> f64 {
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
pub fn proportional(gain: f64) -> f64 {
    if gain < 0.0 { (-2.0 / gain - 1.0).max(1.0).sqrt().min(PKY3) } else { PKY3 }
}

fn lateral(c: &Characterised, set: &mut MfMc, over_load: &OverLoad) -> Result<(), String> {
    lateral_at_nominal(c, set)?;
    set.pKy[6] = set.pKy[5] * over_load.side_force_gain();
    Ok(())
}

/// At the nominal load.
fn lateral_at_nominal(c: &Characterised, set: &mut MfMc) -> Result<(), String> {
    let inputs = grid::lateral(c, c.load());
    let ends = grid::Ends::of(c);
    let most = c.ridden_side().max(c.tyre.tyre.friction.d / PEAK[0]);
    let g2 = ends.camber * ends.camber;
    let stiffness = set.pKy[0];
    let apply: Apply = |set, x| {
        set.pCy = [x[0], x[7]];
        set.pDy = [x[1], set.pDy[1], x[10]];
        set.pEy = [x[2], x[3], x[4], x[8]];
        set.pKy[0] = x[5];
        set.pKy[4] = x[6];
        set.pKy[5] = x[9];
    };
    let bounds = [
        (0.5, 2.0),
        (0.999 * PEAK[0] * most, PEAK[1] * most),
        (-60.0, 1.0),
        (-60.0 / g2.max(1.0), 60.0),
        (-25.0, 25.0),
        (3.0 * stiffness, 0.3 * stiffness),
        (-0.9 / g2, 6.0),
        (0.4, 2.0),
        (-100.0, 1.0),
        (3.0 * set.pKy[5], 0.3 * set.pKy[5]),
        (-0.5 / g2, 3.0),
    ];
    let camber = set.pKy[5];
    let starts = [
        vec![1.0, 1.4 * most, -1.5, 0.0, -3.0, stiffness, 0.0, 1.5, -5.0, camber, 0.0],
        vec![1.2, 1.2 * most, -4.0, 0.0, 0.0, stiffness, 0.0, 0.6, -0.5, camber, 0.0],
    ];
    solve(c, set, &inputs, SIDE, apply, &bounds, &starts)
}

fn combined(c: &Characterised, set: &mut MfMc) -> Result<(), String> {
    let inputs = grid::combined(c, c.load());
    let apply_x: Apply = |set, x| {
        set.rBx = [x[0], x[1]];
        set.rCx1 = x[2];
    };
    let bounds_x = [(0.0, 60.0), (0.0, 60.0), (0.2, 1.6)];
    solve(c, set, &inputs, ALONG, apply_x, &bounds_x, &[vec![8.0, 8.0, 1.0]])?;
    let apply_y: Apply = |set, x| {
        set.rBy = [x[0], x[1], 0.0];
        set.rCy1 = x[2];
    };
    let bounds_y = [(0.0, 60.0), (0.0, 60.0), (0.2, 1.6)];
    solve(c, set, &inputs, SIDE, apply_y, &bounds_y, &[vec![10.0, 8.0, 1.0]])
}

/// Puts parameters into a set.
type Apply = fn(&mut MfMc, &[f64]);

struct Curve<'a> {
    set: MfMc,
    apply: Apply,
    of: fn(&MfMc, &Input) -> f64,
    inputs: &'a [Input],
    wanted: &'a [f64],
    /// Over load.
    peak: f64,
    parameters: usize,
    /// Fourth powers instead of squares.
    even: bool,
}

impl Model for Curve<'_> {
    fn parameters(&self) -> usize {
        self.parameters
    }

    fn len(&self) -> usize {
        self.inputs.len()
    }

    fn residuals(&self, theta: &[f64], out: &mut [f64]) {
        let mut set = self.set;
        (self.apply)(&mut set, theta);
        for (o, (input, wanted)) in out.iter_mut().zip(self.inputs.iter().zip(self.wanted)) {
            let e = ((self.of)(&set, input) - wanted) / (self.peak * input.load);
            *o = if self.even { 1e3 * e * e.abs() } else { e };
        }
    }
}

/// A force of a set by itself, and that of a tyre.
type Force = (fn(&MfMc, &Input) -> f64, fn(&Output) -> f64);
const ALONG: Force = (MfMc::force_x, |o| o.force_x);
const SIDE: Force = (MfMc::force_y, |o| o.force_y);

/// Fits one force of a set to the characterised tyre and leaves the parameters in the set.
fn solve(
    c: &Characterised,
    set: &mut MfMc,
    inputs: &[Input],
    (of, wanted): Force,
    apply: Apply,
    bounds: &[(f64, f64)],
    starts: &[Vec<f64>],
) -> Result<(), String> {
    let wanted: Vec<f64> = inputs.iter().map(|i| wanted(&c.forces(i))).collect();
    let shares = wanted.iter().zip(inputs).map(|(x, input)| x.abs() / input.load);
    let peak = shares.fold(1e-12, f64::max);
    let mut curve = Curve {
        set: *set,
        apply,
        of,
        inputs,
        wanted: &wanted,
        peak,
        parameters: bounds.len(),
        even: false,
    };
    let options = Options { tuning: f64::INFINITY, max_iterations: 40, ..Options::default() };
    let fail = |e: nonlinear::Error| format!("the property file's fit failed: {e}");
    let fit = |curve: &Curve<'_>, starts: &[Vec<f64>]| {
        nonlinear::fit(curve, starts, Some(bounds), &options).map_err(fail)
    };
    let first = fit(&curve, starts)?.theta;
    curve.even = true;
    let best = fit(&curve, std::slice::from_ref(&first))?.theta;
    apply(set, &best);
    Ok(())
}
