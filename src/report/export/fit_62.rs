//! Coefficients of Magic Formula 6.2 that reproduce a characterised tyre.
//!
//! As with the motorcycle set ([`super::fit`]), the longitudinal curve carries over and the lateral one is shaped.
//! The form differs where a motorcycle needs it: camber enters as a shift of the slip angle (`PKY6`, `PKY7`) with a
//! share of its own (`PVY3`), the cornering stiffness follows camber (`PKY3`, `PKY5`), and so does the weighting by
//! the other slip (`RBX3`, `RBY4`). Camber is its sine throughout, but for the overturning moment.

use super::ends::{Ends, steps};
use super::fit::{
    COMBINED, COMBINED_BEYOND, LATERAL, MAX_EXCESS_BEYOND, PEAK, QCZ1, proportional,
    trail_over_load, trail_shrinks,
};
use super::grid::Grid;
use super::over_load::OverLoad;
use super::shape::{Apply, Force, Shape, solve};
use super::tyre::Characterised;
use super::validity::Validity;
use crate::report::export::error::Error;
use crate::tyre::keys::Keys;
use crate::tyre::mf_62::Mf62;
use crate::tyre::tyre_model::TyreModel;

/// `PKY2`: so large that the stiffness is proportional to load (within 1 % up to twice the nominal load).
pub(crate) const PKY2: f64 = 20.0;

/// The 6.2 set of a characterised tyre.
///
/// # Errors
/// The fit does not come to an end.
pub(crate) fn magic_formula_62(c: &Characterised) -> Result<Mf62, Error> {
    let over_load = OverLoad::of(c);
    let mut set = start(c, &over_load)?;
    lateral(c, &mut set)?;
    let gain = over_load.side_force_gain();
    set.pDy[1] = set.pDy[0] * gain;
    set.pKy[6] = set.pKy[5] * gain;
    set.pVy[3] = set.pVy[2] * gain;
    let length = c.tyre.tyre.relaxation_length;
    set.stiffness = [
        set.Kxk(c.load()) / c.tyre.longitudinal_relaxation.max(1e-3),
        -set.Kya(c.load(), 0.0) / length,
    ];
    let along = OverLoad::carcass(c, |load| set.Kxk(load));
    let across = OverLoad::carcass(c, |load| set.Kya(load, 0.0));
    set.pcfx = [along[0], along[1], 0.0];
    set.pcfy = [across[0], across[1], 0.0];
    on_a_road_of_one(&mut set, c.tyre.tyre.reference_friction);
    if c.with_bike {
        combined(c, &mut set)?;
    }
    Ok(set)
}

/// From the friction of the ride's road to 1: peaks, and what the form has in proportion to them.
fn on_a_road_of_one(set: &mut Mf62, friction: f64) {
    for x in set.pDx[..2].iter_mut().chain(&mut set.pDy[..2]).chain(&mut set.pVy[2..]) {
        *x /= friction;
    }
    for k in [7, 9] {
        set.qDz[k] /= friction;
    }
    set.qBz[0] *= friction;
}

/// Parameters that follow in closed form.
fn start(c: &Characterised, over_load: &OverLoad) -> Result<Mf62, Error> {
    let t = &c.tyre.tyre;
    let (load, radius) = (c.load(), t.rolling_radius);
    let mf = &t.friction;
    // the form has the odd part as a share of the even one
    let e1 = if mf.e1.abs() < 1e-6 { 1e-6 } else { mf.e1 };
    let k_alpha = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let (side, gain) = (over_load.side_force[0], over_load.side_force_gain());
    let pky2 = PKY2.min(proportional(gain));
    let share = (2.0 * (1.0 / pky2).atan()).sin();
    let trails = trail_over_load(c, over_load).map(|t| t / radius);
    let [friction, slope] = over_load.friction.map(|share| mf.d * share);
    let [slip_stiffness, gained] = over_load.slip_stiffness_of(mf.stiffness());
    // camber is its sine in the yaw moment, an angle in the overturning moment
    let twist = odd_terms(c, |g| g, f64::sin).map(|x| -x * t.twisting_stiffness / radius);
    let tangent = odd_terms(c, f64::tan, |g| g).map(|x| x * t.overturning_stiffness / radius);
    let [arm, _] = odd_terms(c, f64::tan, f64::sin);
    let keys = Keys::of(&[
        ("FNOMIN", load),
        ("UNLOADED_RADIUS", radius),
        ("VERTICAL_STIFFNESS", t.vertical_stiffness),
        ("CROWN_RADIUS", c.tyre.carcass().crown.min(0.9 * radius)),
        ("DREFF", 0.0),
        ("FREFF", 0.0),
        ("PCX1", mf.c),
        ("PDX1", friction),
        ("PDX2", slope),
        ("PEX1", e1),
        ("PEX4", -mf.e2 / e1),
        ("PKX1", slip_stiffness),
        ("PKX2", gained),
        ("PKX3", over_load.friction_exponent),
        ("RCX1", 1.0),
        ("PCY1", 1.3),
        ("PDY1", Validity::of(c).peak),
        ("PKY1", -side * k_alpha / share),
        ("PKY2", pky2),
        ("PKY4", 2.0),
        ("PKY6", -side * k_alpha * t.side_force_ratio),
        ("RCY1", 1.0),
        ("QSX2", tangent[0]),
        ("QSX12", tangent[1]),
        ("QBZ1", trail_shrinks(c, f64::tan)),
        ("QCZ1", QCZ1),
        ("QDZ1", trails[0]),
        ("QDZ2", trails[1]),
        ("QDZ8", twist[0]),
        ("QDZ10", twist[1]),
        ("SSZ3", arm * t.overturning_stiffness / radius),
        ("QSY1", t.rolling_resistance),
    ]);
    Mf62::from_keys(&keys).map_err(|e| Error::Fit(e.to_string()))
}

/// `a, b` with which `a x + b x |x|` is closest to a function of camber in least squares, `x` being what the form has
/// for camber: over the ridden cambers, and with a tenth of the weight over those of the file.
fn odd_terms(c: &Characterised, wanted: fn(f64) -> f64, x: fn(f64) -> f64) -> [f64; 2] {
    let [mut xx, mut xy, mut yy, mut xw, mut yw] = [0.0; 5];
    for (most, weight) in [(Ends::of(c).camber, 1.0), (Validity::of(c).ends.camber, 0.1)] {
        for g in steps([0.0, most], 41) {
            let (x, w) = (x(g), wanted(g));
            let y = x * x;
            xx += weight * x * x;
            xy += weight * x * y;
            yy += weight * y * y;
            xw += weight * x * w;
            yw += weight * y * w;
        }
    }
    let det = xx * yy - xy * xy;
    [(xw * yy - yw * xy) / det, (yw * xx - xw * xy) / det]
}

/// At the nominal load.
fn lateral(c: &Characterised, set: &mut Mf62) -> Result<(), Error> {
    let validity = Validity::of(c);
    let (peak, g2) = (validity.peak, validity.ends.camber.sin().powi(2));
    let (stiffness, camber, pky2) = (set.pKy[0], set.pKy[5], set.pKy[1]);
    let apply: Apply<Mf62> = |set, x| {
        set.pCy = [x[0]];
        set.pDy[0] = x[1];
        set.pDy[2] = x[2];
        set.pEy = [x[3], 0.0, 0.0, x[4], x[5]];
        set.pKy[0] = x[6];
        set.pKy[2] = x[7];
        set.pKy[4] = x[8];
        set.pKy[5] = x[9];
        set.pVy[2] = x[10];
    };
    let bounds = [
        // from 1 on the peak is reached, and beyond it the force falls little
        (1.0, 1.8),
        (peak, PEAK * peak),
        // no camber has a larger peak than the upright wheel, nor half of it
        (0.0, 0.5),
        (-30.0, 1.0),
        (-20.0, 20.0),
        (-20.0, 20.0),
        // what handling is computed with: kept
        (1.01 * stiffness, 0.99 * stiffness),
        // the stiffness keeps its sign at every camber
        (-2.0, 0.8),
        (-0.6 * pky2 / g2, 3.0 * pky2),
        (3.0 * camber, 0.3 * camber),
        (-1.0, 1.0),
    ];
    let d = 1.1 * peak;
    let starts = [
        vec![1.3, d, 0.05, -1.0, 0.0, 0.0, stiffness, 0.0, 0.0, camber, 0.0],
        // near where most tyres end
        vec![1.3, d, 0.0, -3.0, 1.0, 2.0, stiffness, 0.05, 0.25 * pky2, camber, -0.01],
        vec![1.3, d, 0.05, -1.0, 2.0, 0.0, stiffness, -0.3, 0.0, camber, -0.2],
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

/// The camber's share is relative: the weighting keeps its sense at every camber.
fn combined(c: &Characterised, set: &mut Mf62) -> Result<(), Error> {
    let [b1, b2, curve] = COMBINED;
    let bounds = [b1, b2, curve, (-0.9, 5.0), (-10.0, 1.0)];
    let starts = [vec![8.0, 8.0, 0.95, 0.0, 0.0], vec![30.0, 30.0, 0.95, 0.0, 0.0]];
    let apply: Apply<Mf62> = |set, x| {
        set.rBx = [x[0], x[1], x[0] * x[3]];
        set.rCx = [x[2]];
        set.rEx = [x[4], 0.0];
    };
    let along = Shape {
        friction: None,
        force: ALONG,
        apply,
        bounds: &bounds,
        starts: &starts,
        beyond: COMBINED_BEYOND,
        most: f64::INFINITY,
    };
    solve(c, set, Grid::combined, &along)?;
    let apply: Apply<Mf62> = |set, x| {
        set.rBy = [x[0], x[1], 0.0, x[0] * x[3]];
        set.rCy = [x[2]];
        set.rEy = [x[4], 0.0];
    };
    solve(
        c,
        set,
        Grid::combined,
        &Shape {
            friction: None,
            force: SIDE,
            apply,
            bounds: &bounds,
            starts: &starts,
            beyond: COMBINED_BEYOND,
            most: f64::INFINITY,
        },
    )
}

const ALONG: Force<Mf62> = (Mf62::force_x, |o| o.force_x);
const SIDE: Force<Mf62> = (Mf62::force_y, |o| o.force_y);
