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

/// Steps of Gauss and Newton, and the last one's largest size: a scale of a half needs five.
const STEPS: usize = 8;
const CONVERGED: f64 = 0.003;
/// Scales that a place or a cold tyre may have.
const SCALES: [f64; 2] = [0.2, 2.0];

/// Sums of one manoeuvre's least squares, of the difference to the scaled curve.
#[derive(Default)]
struct Sums {
    ll: f64,
    le: f64,
    ee: f64,
    yl: f64,
    ye: f64,
    yy: f64,
}

impl Sums {
    /// Of some samples at a scale of the curve.
    fn at(scale: f64, rows: &Rows, curve: &MagicFormula, own: &[usize]) -> Self {
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
            sums.yy += y * y;
        }
        sums
    }

    fn determinant(&self) -> f64 {
        self.ll * self.ee - self.le * self.le
    }

    /// To the best scale.
    fn step(&self) -> f64 {
        (self.yl * self.ee - self.ye * self.le) / self.determinant()
    }

    /// Standard error of the scale.
    fn error(&self) -> f64 {
        (self.ee / self.determinant()).sqrt()
    }

    /// Sum of squared residuals at this scale with the best offset of the velocity.
    fn cost(&self) -> f64 {
        self.yy - self.ye * self.ye / self.ee
    }
}

/// Scale of a stop's friction curve and its standard error, from its samples; `None` where they do not tell.
///
/// A gentle stop stays where the curve rises as it does on any road: there the scale is not known, and another solution,
/// far down on the plateau of a slippery road, explains it with an offset of the velocity. So the error is at least that
/// at the ride's own curve.
fn scale(rows: &Rows, curve: &MagicFormula, own: &[usize]) -> Option<(f64, f64)> {
    let usual = Sums::at(1.0, rows, curve, own);
    let (mut scale, mut step) = (1.0, f64::NAN);
    for _ in 0..STEPS {
        step = Sums::at(scale, rows, curve, own).step();
        scale += step;
        if !(SCALES[0]..SCALES[1]).contains(&scale) {
            return None;
        }
    }
    let found = Sums::at(scale, rows, curve, own);
    let is_best = step.abs() < CONVERGED && found.cost() <= usual.cost();
    let error = usual.error().max(found.error());
    (is_best && error.is_finite()).then_some((scale, error))
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
        let (value, error) = scale(rows, &fit.formula, own).filter(|(_, error)| *error < VAGUE)?;
        Some(Shown { segment, value, error, columns: vec![1.0] })
    };
    let mut shown: Vec<Shown> = samples.iter().enumerate().filter_map(of).collect();
    // an odd stop has moved the curve that all are compared with
    let usual = median(&mut shown.iter().map(|s| s.value).collect::<Vec<f64>>());
    for s in &mut shown {
        s.value /= usual.unwrap_or(1.0);
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    const CURVE: MagicFormula = MagicFormula { b: 13.0, c: 1.4, d: 1.1, e1: 0.3, e2: 0.0 };
    const VELOCITY: f64 = 0.05;
    const FRICTION: f64 = 0.03;

    /// Slip ratio of the curve's peak.
    const PEAK: f64 = -0.19;

    /// A stop from 20 m/s on a curve of a scale, up to a share of its peak: 40 samples.
    fn stop(random: &mut Random, scale: f64, share: f64) -> Rows {
        let mut rows = Rows::with_error(VELOCITY);
        let offset = VELOCITY * random.normal();
        let peak = scale * CURVE.value(PEAK);
        // slip of a friction on the rising branch
        let slip_of = |wanted: f64| {
            let (mut low, mut high) = (PEAK * scale, 0.0);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                match scale * CURVE.value(middle / scale) < wanted {
                    true => low = middle,
                    false => high = middle,
                }
            }
            low
        };
        for k in 0..40 {
            let friction = share * peak * (f64::from(k + 1) / 20.0).min(1.0);
            let v = 20.0 - 0.3 * f64::from(k);
            rows.slip.push(slip_of(friction) + offset / v);
            rows.friction.push(friction + FRICTION * random.normal());
            rows.speed.push(v);
            rows.friction_error.push(FRICTION);
            rows.clusters.push(0);
        }
        rows.index();
        rows
    }

    #[test]
    fn a_gentle_stop_is_no_slippery_place() {
        let mut random = Random::new(3, "gentle");
        for share in [0.25, 0.35, 0.45] {
            let of = |_| {
                let rows = stop(&mut random, 1.0, share);
                let own: Vec<usize> = (0..rows.samples()).collect();
                scale(&rows, &CURVE, &own).filter(|(_, error)| *error < VAGUE)
            };
            let shown: Vec<(f64, f64)> = (0..200).filter_map(of).collect();
            let odd = shown.iter().filter(|(value, error)| (value - 1.0).abs() > 4.0 * error);
            assert!(odd.count() <= 2, "{share}: {} of {}", shown.len(), 200);
        }
    }

    #[test]
    fn a_hard_stop_shows_the_scale_of_its_place() {
        let mut random = Random::new(4, "hard");
        for wanted in [1.0, 0.85, 0.7, 0.5, 1.2] {
            let of = |_| {
                let rows = stop(&mut random, wanted, 0.97);
                let own: Vec<usize> = (0..rows.samples()).collect();
                scale(&rows, &CURVE, &own).filter(|(_, error)| *error < VAGUE)
            };
            let shown: Vec<(f64, f64)> = (0..100).filter_map(of).collect();
            // of half the friction some stops do not say which of two solutions it is
            let least = if wanted < 0.6 { 60 } else { 90 };
            assert!(shown.len() >= least, "{wanted}: {}", shown.len());
            let mean = shown.iter().map(|s| s.0).sum::<f64>() / shown.len() as f64;
            assert!((mean - wanted).abs() < 0.02, "{wanted}: {mean}");
            let covered = shown.iter().filter(|(v, e)| (v - wanted).abs() < 2.0 * e).count();
            assert!(10 * covered >= 9 * shown.len(), "{wanted}: {covered} of {}", shown.len());
        }
    }
}
