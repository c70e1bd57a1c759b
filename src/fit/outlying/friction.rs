//! Friction of a stop, over the ride's friction curve.
//!
//! On another surface the tyre keeps its slip stiffness and reaches another peak: the curve is scaled in both
//! directions (similarity method, Pacejka 2012, section 4.2).
//!
//! ```text
//! mu = l mu_x(s/l) - mu_x'(s/l) (1 + s)/v e,   e of the velocity's own spread
//! ```
//! The scale `l` (over that of the median stop, as an odd stop has moved the curve) and the velocity's offset `e` of each
//! manoeuvre by least squares: where a tyre slips little, an error of the velocity looks like one of the friction, near
//! the peak it does not.

use super::comparison::{Scatter, Shown};
use super::quantity::{Compare, Fitted, Quantity};
use crate::fit::friction::Rows;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::order::median;
use crate::tyre::MagicFormula;

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

/// Steps of Gauss and Newton: a scale of a half needs five to be exact to a thousandth.
const STEPS: usize = 6;
/// Scales that are looked for.
const SCALES: [f64; 2] = [0.05, 3.0];

/// Sums of one manoeuvre's least squares, of the difference to the scaled curve.
#[derive(Default)]
struct Sums {
    ll: f64,
    le: f64,
    ee: f64,
    yl: f64,
    ye: f64,
}

/// Scale of a stop's friction curve and its standard error, from its samples; NaN where they do not tell.
fn scale(rows: &Rows, curve: &MagicFormula, own: &[usize]) -> (f64, f64) {
    let mut scale = 1.0;
    let mut error = f64::NAN;
    for _ in 0..STEPS {
        let mut sums = Sums { ee: rows.velocity_error.powi(-2), ..Sums::default() };
        for &i in own {
            let (s, v) = (rows.slip[i], rows.speed[i]);
            let (value, slope) = curve.value_and_slope(s / scale);
            let sigma = rows.friction_error[i].hypot(slope * rows.velocity_error / v);
            let l = (value - s / scale * slope) / sigma;
            let e = -slope * (1.0 + s) / v / sigma;
            let y = (rows.friction[i] - scale * value) / sigma;
            sums.ll += l * l;
            sums.le += l * e;
            sums.ee += e * e;
            sums.yl += y * l;
            sums.ye += y * e;
        }
        let determinant = sums.ll * sums.ee - sums.le * sums.le;
        scale += (sums.yl * sums.ee - sums.ye * sums.le) / determinant;
        error = (sums.ee / determinant).sqrt();
        if scale.is_nan() {
            break;
        }
        scale = scale.clamp(SCALES[0], SCALES[1]);
    }
    (scale, error)
}

fn shown(fitted: &Fitted<'_>, k: usize) -> Vec<Shown> {
    let rows = &fitted.solution.samples.friction[k];
    let Some(fit) = &fitted.solution.fits.friction[k] else { return Vec::new() };
    // without coasting nobody knows the velocity's error nor the radius, which look like friction
    if fitted.solution.fits.coasting.radius[k].is_none() {
        return Vec::new();
    }
    let mut samples: Vec<Vec<usize>> = fitted.segments.iter().map(|_| Vec::new()).collect();
    for i in 0..rows.samples() {
        samples[rows.clusters[i]].push(i);
    }
    let of = |(segment, own): (usize, &Vec<usize>)| {
        // driven out of a corner a tyre slips too little to tell its friction; of both brakes the shares have errors
        let kind = fitted.segments[segment].kind;
        let braked = [ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking].contains(&kind);
        let largest = own.iter().map(|i| rows.friction[*i].abs()).fold(0.0, f64::max);
        if !braked || own.len() < FEW || largest < USED {
            return None;
        }
        let (value, error) = scale(rows, &fit.formula, own);
        (error < VAGUE && value.is_finite()).then(|| Shown {
            segment,
            value,
            error,
            columns: vec![1.0],
        })
    };
    let mut shown: Vec<Shown> = samples.iter().enumerate().filter_map(of).collect();
    // an odd stop has moved the curve that all are held against
    let usual = median(&mut shown.iter().map(|s| s.value).collect::<Vec<f64>>());
    for s in &mut shown {
        s.value /= usual.unwrap_or(1.0);
    }
    shown
}
