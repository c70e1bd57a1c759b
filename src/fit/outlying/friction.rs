//! Friction of a stop, over the ride's friction curve at the same slip.
//!
//! ```text
//! mu = g mu_x(s) - mu_x'(s) (1 + s)/v e,   e of the velocity's own spread
//! ```
//! `g` (over that of the median stop, as an odd stop has moved the curve) and the velocity's offset `e` of each manoeuvre
//! by least squares: where a tyre slips little, an error of the velocity looks like one of the friction, near the peak it
//! does not.

use super::comparison::{Scatter, Shown};
use super::quantity::{Compare, Fitted, Quantity};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::order::median;

/// Friction from which a manoeuvre tells of the tyre.
const USED: f64 = 0.3;
/// Samples of a manoeuvre.
const FEW: usize = 8;
/// Standard error of a manoeuvre's own ratio beyond which it tells nothing.
const VAGUE: f64 = 0.1;

const LESS: &str =
    "a slippery place (dust, paint, damp) or a cold tyre; less by a slope downhill or a tail wind";
const MORE: &str = "a place with more grip, a warmer tyre or help of the other brake; more by a slope uphill or a head wind";

/// A friction of a name for tables and for people.
const fn quantity(name: &'static str, words: &'static str) -> Quantity {
    Quantity { name, unit: "1", words, least: 0.05, shown: ("%", 100.0), causes: [MORE, LESS] }
}

static FRICTION_FRONT: Quantity = quantity("friction_front", "friction of the front tyre");
static FRICTION_REAR: Quantity = quantity("friction_rear", "friction of the rear tyre");
pub(super) static FRONT: Compare = Compare {
    quantity: &FRICTION_FRONT,
    scatter: Scatter { sd: 0.02, worth: 4.0 },
    shown: |f| shown(f, 0),
};

pub(super) static REAR: Compare = Compare {
    quantity: &FRICTION_REAR,
    scatter: Scatter { sd: 0.02, worth: 4.0 },
    shown: |f| shown(f, 1),
};

/// Sums of one manoeuvre's least squares.
#[derive(Default)]
struct Sums {
    n: usize,
    largest: f64,
    gg: f64,
    ge: f64,
    ee: f64,
    yg: f64,
    ye: f64,
}

fn shown(fitted: &Fitted<'_>, k: usize) -> Vec<Shown> {
    let rows = &fitted.solution.samples.friction[k];
    let Some(fit) = &fitted.solution.fits.friction[k] else { return Vec::new() };
    // without coasting nobody knows the velocity's error nor the radius, which look like friction
    if fitted.solution.fits.coasting.radius[k].is_none() {
        return Vec::new();
    }
    let mut sums: Vec<Sums> = fitted.segments.iter().map(|_| Sums::default()).collect();
    for i in 0..rows.samples() {
        let (s, v) = (rows.slip[i], rows.speed[i]);
        let (value, slope) = fit.formula.value_and_slope(s);
        let sigma = rows.friction_error[i].hypot(slope * rows.velocity_error / v);
        let (g, e, y) = (value / sigma, -slope * (1.0 + s) / v / sigma, rows.friction[i] / sigma);
        let sum = &mut sums[rows.clusters[i]];
        sum.n += 1;
        sum.largest = sum.largest.max(rows.friction[i].abs());
        sum.gg += g * g;
        sum.ge += g * e;
        sum.ee += e * e;
        sum.yg += y * g;
        sum.ye += y * e;
    }
    let ratio = |(segment, sum): (usize, &Sums)| {
        let ee = sum.ee + 1.0 / rows.velocity_error.powi(2);
        let determinant = sum.gg * ee - sum.ge * sum.ge;
        let value = (sum.yg * ee - sum.ye * sum.ge) / determinant;
        let error = (ee / determinant).sqrt();
        // driven out of a corner a tyre slips too little to tell its friction; of both brakes the shares have errors
        let kind = fitted.segments[segment].kind;
        let braked = [ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking].contains(&kind);
        let usable = sum.n >= FEW && sum.largest >= USED && error < VAGUE && value.is_finite();
        (braked && usable).then(|| Shown { segment, value, error, columns: vec![1.0] })
    };
    let mut shown: Vec<Shown> = sums.iter().enumerate().filter_map(ratio).collect();
    // an odd stop has moved the curve that all are held against
    let usual = median(&mut shown.iter().map(|s| s.value).collect::<Vec<f64>>());
    for s in &mut shown {
        s.value /= usual.unwrap_or(1.0);
    }
    shown
}
