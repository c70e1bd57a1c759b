//! The fits over their data.

use super::plot::{Axis, FIT, Plot, Series, front_and_rear};
use super::sheet::{CLOUD_POINTS, Cloud, Sheet, abscissae};
use crate::GRAVITY;
use crate::fit::bands::Bands;
use crate::fit::coasting::GRADE;
use crate::fit::cornering::{C1, C3};
use crate::fit::{Data, Solution, cornering};

pub(super) const CAMBER: Axis = Axis::degrees("camber");
pub(super) const ROLL: Axis = Axis::degrees("roll");
const SLIP: Axis = Axis::new("slip ratio", "", 1.0);
const MU_X: Axis = Axis::new("longitudinal friction Fx/Fz", "", 1.0);
const MU_Y: Axis = Axis::new("lateral friction Fy/Fz", "", 1.0);
const ALPHA: Axis = Axis::degrees("slip angle");
const PER_LOAD: Axis = Axis::new("stiffness per load", "1/rad", 1.0);
const V_SQUARED: Axis = Axis::new("speed squared", "m²/s²", 1.0);
const FORCE: Axis = Axis::new("resisting force", "N", 1.0);
const ARM: Axis = Axis::new("overturning arm Mx/(m g)", "mm", 1000.0);

/// Longitudinal friction over slip ratio, front and rear.
pub(crate) const FRICTION_X: [Plot; 2] = front_and_rear!(
    "friction_x",
    "longitudinal friction",
    [SLIP, MU_X],
    "Magic Formula (eq. 28) through the straight-line runs."
);

/// Slip angle over camber in steady corners, front and rear.
pub(crate) const SLIP_ANGLE: [Plot; 2] = front_and_rear!(
    "slip_angle",
    "slip angle",
    [CAMBER, ALPHA],
    "Slip angle c1 γ + c3 γ³ (eq. 37) in steady corners."
);

/// Lateral friction over camber in steady corners, front and rear.
pub(crate) const FRICTION_Y: [Plot; 2] = front_and_rear!(
    "friction_y",
    "lateral friction over camber",
    [CAMBER, MU_Y],
    "Lateral friction ct tan γ (eq. 38) in steady corners."
);

/// Lateral friction over slip angle in steady corners, front and rear.
pub(crate) const FRICTION_Y_SLIP: [Plot; 2] = {
    let [front, rear] = front_and_rear!(
        "friction_y_slip",
        "lateral friction over slip angle",
        [ALPHA, MU_Y],
        "Steady corners: to each slip angle its camber, so the curve runs through both fits \
         (eqs. 37, 38); it is no sweep at a fixed camber. The bands are of the friction at that \
         camber."
    );
    [Plot { turns_back: true, ..front }, Plot { turns_back: true, ..rear }]
};

/// Cornering stiffness per load, a line of [`STIFFNESS`].
pub(crate) const K_ALPHA: Series = Series::new("k_alpha", "cornering kα");
/// Camber stiffness per load, the other line.
pub(crate) const K_GAMMA: Series = Series::new("k_gamma", "camber kγ");

/// Cornering and camber stiffness per load over camber, front and rear.
pub(crate) const STIFFNESS: [Plot; 2] = {
    let [front, rear] = front_and_rear!(
        "stiffness",
        "stiffness",
        [CAMBER, PER_LOAD],
        "Cornering and camber stiffness (eq. 39, multiplied through)."
    );
    const LINES: &[Series] = &[K_ALPHA, K_GAMMA];
    [Plot { series: LINES, ..front }, Plot { series: LINES, ..rear }]
};

/// Force that slows the coasting bike over the speed squared.
pub(crate) const COAST_DOWN: Plot = Plot::new(
    "coast_down",
    "Coast-down",
    [V_SQUARED, FORCE],
    "Drag is the slope, rolling resistance the height at standstill (eq. 23).",
);

/// Lever arm of the overturning moment over roll.
pub(crate) const OVERTURNING: Plot = Plot::new(
    "overturning",
    "Overturning",
    [ROLL, ARM],
    "Overturning moment over weight, by roll (eqs. 34–36).",
);

/// Signals of the samples that the fits used, front and rear, beside those in the fits' own clouds.
pub(super) struct Used {
    /// Wheel load of the friction samples, N.
    pub straight_load: [Vec<f64>; 2],
    /// Camber of the friction samples, rad: the roll of a wheel that is not steered.
    pub straight_roll: [Vec<f64>; 2],
    /// Time of the friction samples, s.
    pub straight_time: [Vec<f64>; 2],
    /// Wheel load of the corner samples, N.
    pub corner_load: [Vec<f64>; 2],
    /// Speed of the corner samples, m/s.
    pub corner_speed: Vec<f64>,
    /// Time of the corner samples, s.
    pub corner_time: Vec<f64>,
}

impl Used {
    pub(super) fn new(data: &Data, solution: &Solution) -> Self {
        let (inputs, samples) = (&solution.inputs, &solution.samples);
        let of = |x: &[f64], keep: &[usize]| keep.iter().map(|&i| x[i]).collect::<Vec<f64>>();
        let straight = [0, 1].map(|k| {
            let keep = &samples.keep_straight[k];
            let signals = inputs.straight(&data.straight[k], &data.action[k]);
            (of(&signals.load[k], keep), of(&signals.roll, keep), of(&data.straight[k].time, keep))
        });
        // loads and speeds of a corner do not depend on the overturning stiffness
        let corner = inputs.corner(&data.corner, data.corner_rate, None);
        let [front, rear] = straight;
        Used {
            straight_load: [front.0, rear.0],
            straight_roll: [front.1, rear.1],
            straight_time: [front.2, rear.2],
            corner_load: [0, 1].map(|k| of(&corner.load[k], &samples.keep_corner)),
            corner_speed: of(&corner.speed, &samples.keep_corner),
            corner_time: of(&data.corner.time, &samples.keep_corner),
        }
    }
}

pub(super) fn draw(
    sheet: &mut Sheet<'_>,
    data: &Data,
    solution: &Solution,
    used: &Used,
    bands: &Bands<'_>,
) {
    for k in 0..2 {
        friction(sheet, solution, used, bands, k);
        lateral(sheet, solution, used, bands, k);
        stiffness(sheet, solution, bands, k);
    }
    coast_down(sheet, data, solution, bands);
    overturning(sheet, data, solution, bands);
}

fn friction(sheet: &mut Sheet<'_>, solution: &Solution, used: &Used, bands: &Bands<'_>, k: usize) {
    let Some(fit) = &solution.fits.friction[k] else { return };
    let rows = &solution.samples.friction[k];
    let cloud = Cloud {
        x: &rows.slip,
        y: &rows.friction,
        weights: &fit.weights,
        clusters: &rows.clusters,
        colour: &used.straight_load[k],
    };
    let plot = &FRICTION_X[k];
    sheet.cloud(plot, &cloud, CLOUD_POINTS);
    let [from, to] = fit.slip_range;
    sheet.curve(plot, &FIT, [from, to.max(0.0)], &|s| bands.friction(k, s));
}

fn lateral(sheet: &mut Sheet<'_>, solution: &Solution, used: &Used, bands: &Bands<'_>, k: usize) {
    let lateral = &solution.fits.lateral[k];
    let rows = &solution.samples.lateral[k];
    let low = rows.camber.iter().copied().fold(0.0, f64::min);
    let high = rows.camber.iter().copied().fold(0.0, f64::max);
    let cloud =
        Cloud { clusters: &rows.clusters, colour: &used.corner_load[k], ..Cloud::default() };
    if let Some(fit) = &lateral.slip {
        let own = Cloud { x: &rows.camber, y: &rows.slip_angle, weights: &fit.weights, ..cloud };
        sheet.cloud(&SLIP_ANGLE[k], &own, CLOUD_POINTS);
        sheet.curve(&SLIP_ANGLE[k], &FIT, [low, high], &|g| bands.slip_angle(k, g));
    }
    let Some(fit) = &lateral.friction else { return };
    let at = |g: f64| bands.lateral_friction(k, g);
    let own = Cloud { x: &rows.camber, y: &rows.friction, weights: &fit.weights, ..cloud };
    sheet.cloud(&FRICTION_Y[k], &own, CLOUD_POINTS);
    sheet.curve(&FRICTION_Y[k], &FIT, [low, high], &at);
    // a steady corner has one slip angle to its camber: the curve runs through both fits
    let Some(slip) = &lateral.slip else { return };
    let plot = &FRICTION_Y_SLIP[k];
    let own = Cloud { x: &rows.slip_angle, y: &rows.friction, weights: &fit.weights, ..cloud };
    sheet.cloud(plot, &own, CLOUD_POINTS);
    for g in abscissae([low, high]) {
        let x = slip.theta[C1] * g + slip.theta[C3] * g.powi(3);
        if let Some(band) = at(g) {
            sheet.banded(plot, &FIT, x, &band);
        }
    }
}

fn stiffness(sheet: &mut Sheet<'_>, solution: &Solution, bands: &Bands<'_>, wheel: usize) {
    let ends = [0.0, solution.fits.lateral[wheel].max_camber];
    for (series, of_camber) in [(K_ALPHA, false), (K_GAMMA, true)] {
        if bands.stiffness(wheel, of_camber, 0.0).is_none() {
            continue;
        }
        let plot = &STIFFNESS[wheel];
        for g in abscissae(ends) {
            match bands.stiffness(wheel, of_camber, g) {
                Some(band) => sheet.banded(plot, &series, g, &band),
                None => sheet.point(plot, &series, g, [None; 3]),
            }
        }
    }
}

/// Force that slows the coasting bike, wheels' inertia included, over the speed squared.
fn coast_down(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution, bands: &Bands<'_>) {
    let inputs = &solution.inputs;
    let Some(fit) = &solution.fits.coasting.resistance else { return };
    let x = &data.coast;
    let weight = inputs.bike.mass * GRAVITY;
    let square: Vec<f64> = x.velocity_x.iter().map(|v| v * v).collect();
    let force = coasting_force(data, solution, &fit.theta);
    let own =
        Cloud { x: &square, y: &force, weights: &fit.weights, clusters: &x.segment, colour: &[] };
    sheet.cloud(&COAST_DOWN, &own, CLOUD_POINTS);
    let top = square.iter().copied().fold(0.0, f64::max);
    sheet.curve(&COAST_DOWN, &FIT, [0.0, top], &|v2| bands.resistance(v2, weight));
}

/// Force that slows each coasting sample, the grade taken off, N.
pub(super) fn coasting_force(data: &Data, solution: &Solution, theta: &[f64]) -> Vec<f64> {
    let (inputs, x) = (&solution.inputs, &data.coast);
    let inertia = inputs.bike.mass + inputs.rotating_mass().iter().sum::<f64>();
    let weight = inputs.bike.mass * GRAVITY;
    let slope = theta.get(GRADE).copied().unwrap_or(0.0);
    (0..x.len())
        .map(|i| {
            let a = x.acceleration_x[i] - inputs.zeros.acceleration_x;
            -inertia * a - slope * weight * x.direction[i]
        })
        .collect()
}

fn overturning(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution, bands: &Bands<'_>) {
    let Some(fit) = &solution.fits.overturning else { return };
    let inputs = &solution.inputs;
    let weight = inputs.bike.mass * GRAVITY;
    let cornering::OverturningRows { lever, moment, clusters } = &solution.samples.overturning;
    let roll: Vec<f64> = solution
        .samples
        .keep_steady
        .iter()
        .map(|&i| data.corner.roll[i] - inputs.zeros.roll)
        .collect();
    let arm: Vec<f64> = moment.iter().map(|m| m / weight).collect();
    let own = Cloud { x: &roll, y: &arm, weights: &fit.weights, clusters, colour: &[] };
    sheet.cloud(&OVERTURNING, &own, CLOUD_POINTS);
    // the lever per tangent of roll is all but constant: its mean draws the line
    let tangent: f64 = roll.iter().map(|r| r.tan().powi(2)).sum();
    let per_tangent: f64 = lever.iter().zip(&roll).map(|(l, r)| l * r.tan()).sum::<f64>() / tangent;
    let low = roll.iter().copied().fold(0.0, f64::min);
    let high = roll.iter().copied().fold(0.0, f64::max);
    let scale = per_tangent / weight;
    let of_lever = bands.overturning();
    let at = |r: f64| of_lever.map(|band| band.times(scale * r.tan()));
    sheet.curve(&OVERTURNING, &FIT, [low, high], &at);
}
