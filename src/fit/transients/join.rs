//! The tyres of the fit to changing lean in the session's solution: stiffness and ratio take
//! the place of what steady corners give with an assumed ratio. The relaxation length of the fit is none that a ride tells:
//! springs and frames lag as tyres do (it came out 0.1 to 0.4 m too long), so the rule stays. What (39) gains with camber is fitted to the
//! steady corners once more, about the new stiffness.

use nalgebra::DMatrix;

use super::parameters::{LN_STIFFNESS, OF_TYRE, RATIO};
use super::solve::{Fitted, OUT, OUTPUTS};
use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::MODEL;
use crate::fit::assemble::{Assembled, Quotient};
use crate::fit::cornering;
use crate::fit::solution::{Solution, Upstream};
use crate::fit::variation::Source;
use crate::statistics::clustered_fit::Quality;

/// A stiffness that is known worse than this, as a standard deviation of its logarithm, is none.
const WORST_STIFFNESS: f64 = 0.35;
/// What tyre, frame and springs make the results wrong by beside what is fitted: standard deviations of the logarithms of
/// stiffness, ratio and camber stiffness, of 24 simulated machines in slaloms (`examples/transients --population`) and seven
/// rides of the independent simulator.
const LAW: [f64; 3] = [0.04, 0.06, 0.045];
/// What is added to each where the lean never changes fast, and the time of fast changes that halves it, s: of 24 simulated
/// machines, half of which ride the paper's plan.
const SLOW: [f64; 3] = [0.09, 0.15, 0.04];
const ENOUGH: f64 = 3.0;
/// What is added instead where corners of more than the usual lean took part: springs and frames of their own made simulated
/// machines 15 to 35 % too stiff. These cover 14 rides of the independent simulator.
const STEEP: [f64; 3] = [0.12, 0.22, 0.09];

/// The larger standard deviation of the logarithm of a stiffness, with the law's.
pub(crate) fn worst(fitted: &Fitted) -> f64 {
    let law: f64 = law(fitted).iter().map(|l| l[0] * l[0]).sum();
    let of = |k: usize| {
        let mut contrast = [0.0; OUTPUTS];
        contrast[OUT.len() * k] = 1.0;
        (fitted.variance(&contrast) + law).sqrt()
    };
    of(0).max(of(1))
}

/// What the parts of a ride's own noise are called, before their number.
pub(crate) const NOISE: &str = "changing_lean_";

/// Puts the tyres that the ride tells into a solution whose upstream changes are there; whether there is any.
pub(crate) fn join(solution: &mut Solution, found: &Fitted) -> bool {
    let axles: Vec<Axle> =
        Axle::BOTH.into_iter().filter(|axle| is_known(solution, found, *axle)).collect();
    for axle in &axles {
        put(solution, found, *axle);
    }
    let outputs: Vec<Output> = axles.iter().map(|axle| Output::of(solution, *axle)).collect();
    errors(solution, found, &outputs);
    !outputs.is_empty()
}

/// The fitted number `j` of a tyre.
fn number(found: &Fitted, axle: Axle, j: usize) -> f64 {
    found.theta[axle as usize * OF_TYRE + j]
}

/// Standard deviation of the result `j` of a tyre.
fn sd(found: &Fitted, axle: Axle, j: usize) -> f64 {
    let mut contrast = [0.0; OUTPUTS];
    contrast[OUT.len() * axle as usize + j] = 1.0;
    found.variance(&contrast).sqrt()
}

/// Whether the ride gives a tyre's stiffness, and its ratio better than the bike file does: one without uncertainty is exact.
/// Corners alone, steep ones or others, have to be better with the law's error as well.
fn is_known(solution: &Solution, found: &Fitted, axle: Axle) -> bool {
    let before = solution.inputs.bike.deviation(&format!("{}.side_force_ratio", axle.name()));
    let of_law = law(found).map(|[_, of_ratio]| (of_ratio * number(found, axle, RATIO)).powi(2));
    let corners = found.steep || found.fast < ENOUGH;
    let more = if corners { of_law[0] + of_law[1] } else { 0.0 };
    let ratio = (sd(found, axle, 1).powi(2) + more).sqrt();
    sd(found, axle, 0) < WORST_STIFFNESS && ratio < before
}

/// Values and fits of one tyre.
fn put(solution: &mut Solution, found: &Fitted, axle: Axle) {
    let k = axle as usize;
    let (stiffness, ratio) = (number(found, axle, LN_STIFFNESS).exp(), number(found, axle, RATIO));
    let bike = &mut solution.inputs.bike;
    *bike = bike.with(&format!("{}.side_force_ratio", axle.name()), ratio);
    let values = &mut solution.found.values;
    values[(axle, C::CorneringStiffness0)] = stiffness;
    values[(axle, C::CamberStiffness0)] = stiffness * ratio;
    values[(axle, C::SideForceRatio)] = ratio;
    let quality = Quality {
        n_clusters: found.stretches,
        n_samples: found.samples,
        scale: f64::NAN,
        outlier_fraction: found.outliers,
        r_squared: f64::NAN,
    };
    let upright = 1.0 / stiffness;
    let rows = &mut solution.samples.lateral[k];
    rows.assume(ratio);
    let lateral = &mut solution.fits.lateral[k];
    let compliance = cornering::growth(rows, upright, quality.clone());
    solution.found.stiffness[k] = Quotient { numerator: 1.0, denominator: upright };
    solution.found.growth[k] = compliance.theta[cornering::T2];
    lateral.compliance = Some(compliance);
    solution.ridden[k] = Some(quality);
}

/// A tyre whose numbers changed.
struct Output {
    axle: Axle,
    stiffness: f64,
    ratio: f64,
}

impl Output {
    fn of(solution: &Solution, axle: Axle) -> Self {
        let values = &solution.found.values;
        Output {
            axle,
            stiffness: values[(axle, C::CorneringStiffness0)],
            ratio: values[(axle, C::SideForceRatio)],
        }
    }

    /// Changes a set of coefficients by changes of the logarithm of the stiffness and of the ratio.
    fn add(&self, change: &mut Assembled, [stiffness, ratio]: [f64; 2]) {
        let (axle, k) = (self.axle, self.axle as usize);
        change.stiffness[k].denominator -= stiffness / self.stiffness;
        let by = self.stiffness * stiffness;
        change.values[(axle, C::CorneringStiffness0)] += by;
        change.values[(axle, C::SideForceRatio)] += ratio;
        change.values[(axle, C::CamberStiffness0)] += by * self.ratio + self.stiffness * ratio;
    }

    /// No change of what the fit to changing lean gives.
    fn clear(&self, change: &mut Assembled) {
        let (axle, k) = (self.axle, self.axle as usize);
        change.stiffness[k] = Quotient { numerator: 0.0, denominator: 0.0 };
        if !change.growth[k].is_finite() {
            change.growth[k] = 0.0;
        }
        for coefficient in [C::CorneringStiffness0, C::SideForceRatio, C::CamberStiffness0] {
            change.values[(axle, coefficient)] = 0.0;
        }
    }
}

/// What the new numbers of some tyres depend on, in place of what the old ones did.
fn errors(solution: &mut Solution, found: &Fitted, outputs: &[Output]) {
    for upstream in &mut solution.upstream {
        outputs.iter().for_each(|output| output.clear(&mut upstream.change));
    }
    let mut none = solution.found.minus(&solution.found);
    outputs.iter().for_each(|output| output.clear(&mut none));
    for (source, shift) in &found.shifts {
        add(solution, outputs, &none, source.clone(), shift);
    }
    let noise = found.noise.clone();
    if let Some(factor) = noise.cholesky() {
        let factor: DMatrix<f64> = factor.unpack();
        for j in 0..OUTPUTS {
            let mut shift = [0.0; OUTPUTS];
            (0..OUTPUTS).for_each(|i| shift[i] = factor[(i, j)]);
            let source = Source::of_ride(format!("{NOISE}{}", j + 1));
            add(solution, outputs, &none, source, &shift);
        }
    }
    let law = law(found);
    for output in outputs {
        for [of_stiffness, of_ratio] in law {
            let mut change = none.clone();
            output.add(&mut change, [of_stiffness, of_ratio * output.ratio]);
            let source = Source::of_motorcycle(MODEL, None);
            solution.upstream.push(Upstream { source, missing: None, change });
        }
    }
}

/// Two independent errors of the logarithms of stiffness and ratio, such that that of their product is as [`LAW`] says.
pub fn law(fitted: &Fitted) -> [[f64; 2]; 2] {
    let slow = SLOW.map(|sd| sd / (1.0 + fitted.fast / ENOUGH));
    let added = if fitted.steep { STEEP } else { slow };
    let [stiffness, ratio, product] = [0, 1, 2].map(|i| LAW[i].hypot(added[i]));
    let common = (product * product - stiffness * stiffness - ratio * ratio) / 2.0 / stiffness;
    // no smaller than what makes the two errors each other's opposite
    let common = common.max(-ratio);
    [[stiffness, common], [0.0, (ratio * ratio - common * common).max(0.0).sqrt()]]
}

fn add(
    solution: &mut Solution,
    outputs: &[Output],
    none: &Assembled,
    source: Source,
    shift: &[f64; OUTPUTS],
) {
    let of = |output: &Output| {
        let k = OUT.len() * output.axle as usize;
        [shift[k], shift[k + 1]]
    };
    let same = solution.upstream.iter_mut().find(|u| u.source.name == source.name);
    if let Some(upstream) = same {
        outputs.iter().for_each(|output| output.add(&mut upstream.change, of(output)));
        return;
    }
    let missing = solution.inputs.bike.priors_of_missing().contains_key(&source.name);
    let missing = missing.then(|| source.name.clone());
    let mut change = none.clone();
    outputs.iter().for_each(|output| output.add(&mut change, of(output)));
    solution.upstream.push(Upstream { source, missing, change });
}

impl Solution {
    /// Whether the ride's changes of lean gave a coefficient.
    pub(crate) fn is_of_changing_lean(&self, id: crate::contract::coefficient::Id) -> bool {
        let of = |axle: Axle| self.ridden[axle as usize].as_ref();
        let is_side = matches!(
            id.coefficient,
            C::CorneringStiffness0 | C::CamberStiffness0 | C::SideForceRatio
        );
        is_side && id.part.axle().and_then(of).is_some()
    }
}
