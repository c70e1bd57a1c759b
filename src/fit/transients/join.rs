//! The tyres of the fit to changing lean in the session's solution: stiffness, ratio and, where it is known, relaxation
//! length take the place of what steady corners give with an assumed ratio. What (39) gains with camber is fitted to the
//! steady corners once more, about the new stiffness.

use nalgebra::DMatrix;

use super::Transients;
use super::parameters::{LN_STIFFNESS, OF_TYRE, RATIO, RELAXATION};
use super::solve::OUTPUTS;
use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::error_source::MODEL;
use crate::fit::assemble::{Assembled, Quotient};
use crate::fit::cornering;
use crate::fit::solution::{Ridden, Solution, Upstream};
use crate::fit::variation::Source;
use crate::statistics::clustered_fit::{Fitted, Quality};

/// A stiffness that is known worse than this, as a standard deviation of its logarithm, is none.
const WORST_STIFFNESS: f64 = 0.35;
/// A relaxation length whose 95 % interval is wider than this share on either side stays the rule's.
const WORST_RELAXATION: f64 = 0.5;
/// What the law of the tyre is wrong by: standard deviations of the logarithms of stiffness, ratio and camber stiffness.
const LAW: [f64; 3] = [0.02, 0.04, 0.03];
/// What a relaxation length is wrong by beside that, m: those of the independent plant are 0.1 to 0.2 m too long.
const RELAXATION_ERROR: f64 = 0.12;
/// 95 % of a normal distribution.
const NORMAL: f64 = 1.96;

/// Puts the tyres into a solution whose upstream changes are there; says whether there were any.
pub(crate) fn join(solution: &mut Solution, found: &Transients) -> bool {
    let axles: Vec<Axle> =
        Axle::BOTH.into_iter().filter(|axle| is_known(solution, found, *axle)).collect();
    for axle in &axles {
        put(solution, found, *axle);
    }
    let outputs: Vec<Output> = axles.iter().map(|axle| Output::of(solution, *axle)).collect();
    errors(solution, found, &outputs);
    !axles.is_empty()
}

/// The fitted number `j` of a tyre.
fn number(found: &Transients, axle: Axle, j: usize) -> f64 {
    found.fitted.theta[axle as usize * OF_TYRE + j]
}

/// Standard deviation of the result `j` of a tyre.
fn sd(found: &Transients, axle: Axle, j: usize) -> f64 {
    let mut contrast = [0.0; OUTPUTS];
    contrast[3 * axle as usize + j] = 1.0;
    found.fitted.variance(&contrast).sqrt()
}

/// Whether the ride tells a tyre's stiffness, and its ratio better than the bike file does.
fn is_known(solution: &Solution, found: &Transients, axle: Axle) -> bool {
    let before = solution.inputs.bike.deviation(&format!("{}.side_force_ratio", axle.name()));
    let ratio = sd(found, axle, 1);
    sd(found, axle, 0) < WORST_STIFFNESS && (ratio < before || before == 0.0)
}

/// Values and fits of one tyre.
fn put(solution: &mut Solution, found: &Transients, axle: Axle) {
    let k = axle as usize;
    let (stiffness, ratio) =
        (number(found, axle, LN_STIFFNESS).exp(), number(found, axle, RATIO));
    let relaxation = number(found, axle, RELAXATION);
    let relaxation_sd = sd(found, axle, 2).hypot(RELAXATION_ERROR);
    let is_told = NORMAL * relaxation_sd < WORST_RELAXATION * relaxation;
    let bike = &mut solution.inputs.bike;
    *bike = bike.with(&format!("{}.side_force_ratio", axle.name()), ratio);
    let values = &mut solution.found.values;
    values[(axle, C::CorneringStiffness0)] = stiffness;
    values[(axle, C::CamberStiffness0)] = stiffness * ratio;
    values[(axle, C::SideForceRatio)] = ratio;
    if is_told {
        values[(axle, C::RelaxationLength)] = relaxation;
    }
    let quality = Quality {
        n_clusters: found.fitted.stretches,
        n_samples: found.fitted.samples,
        scale: f64::NAN,
        outlier_fraction: found.fitted.outliers,
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
    solution.ridden[k] = Some(Ridden { quality, relaxation: is_told });
}

/// A tyre whose numbers changed.
struct Output {
    axle: Axle,
    stiffness: f64,
    ratio: f64,
    relaxation: bool,
}

impl Output {
    fn of(solution: &Solution, axle: Axle) -> Self {
        let values = &solution.found.values;
        Output {
            axle,
            stiffness: values[(axle, C::CorneringStiffness0)],
            ratio: values[(axle, C::SideForceRatio)],
            relaxation: solution.ridden[axle as usize].as_ref().is_some_and(|r| r.relaxation),
        }
    }

    /// Changes a set of coefficients by changes of the logarithm of the stiffness, of the ratio and of the relaxation length.
    fn add(&self, change: &mut Assembled, [stiffness, ratio, relaxation]: [f64; 3]) {
        let (axle, k) = (self.axle, self.axle as usize);
        change.stiffness[k].denominator -= stiffness / self.stiffness;
        let by = self.stiffness * stiffness;
        change.values[(axle, C::CorneringStiffness0)] += by;
        change.values[(axle, C::SideForceRatio)] += ratio;
        change.values[(axle, C::CamberStiffness0)] += by * self.ratio + self.stiffness * ratio;
        if self.relaxation {
            change.values[(axle, C::RelaxationLength)] += relaxation;
        }
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
        if self.relaxation {
            change.values[(axle, C::RelaxationLength)] = 0.0;
        }
    }
}

/// What the new numbers of some tyres depend on, in place of what the old ones did.
fn errors(solution: &mut Solution, found: &Transients, outputs: &[Output]) {
    for upstream in &mut solution.upstream {
        outputs.iter().for_each(|output| output.clear(&mut upstream.change));
    }
    let mut none = solution.found.minus(&solution.found);
    outputs.iter().for_each(|output| output.clear(&mut none));
    for (source, shift) in &found.fitted.shifts {
        add(solution, outputs, &none, source.clone(), shift);
    }
    let noise = found.fitted.noise.clone();
    if let Some(factor) = noise.cholesky() {
        let factor: DMatrix<f64> = factor.unpack();
        for j in 0..OUTPUTS {
            let mut shift = [0.0; OUTPUTS];
            (0..OUTPUTS).for_each(|i| shift[i] = factor[(i, j)]);
            let source = Source::of_ride(format!("changing_lean_{}", j + 1));
            add(solution, outputs, &none, source, &shift);
        }
    }
    // the errors of stiffness and ratio are such that that of their product is as said
    let [stiffness, ratio, product] = LAW;
    let common = (product * product - stiffness * stiffness - ratio * ratio) / 2.0 / stiffness;
    let rest = (ratio * ratio - common * common).sqrt();
    for output in outputs {
        for [of_stiffness, of_ratio, of_relaxation] in
            [[stiffness, common, 0.0], [0.0, rest, 0.0], [0.0, 0.0, RELAXATION_ERROR]]
        {
            let mut change = none.clone();
            output.add(&mut change, [of_stiffness, of_ratio * output.ratio, of_relaxation]);
            let source = Source::of_motorcycle(MODEL, None);
            solution.upstream.push(Upstream { source, missing: None, change });
        }
    }
}

fn add(
    solution: &mut Solution,
    outputs: &[Output],
    none: &Assembled,
    source: Source,
    shift: &[f64; OUTPUTS],
) {
    let of = |output: &Output| {
        let k = 3 * output.axle as usize;
        [shift[k], shift[k + 1], shift[k + 2]]
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
        match (id.part.axle().and_then(of), id.coefficient) {
            (Some(ridden), C::RelaxationLength) => ridden.relaxation,
            (Some(_), C::CorneringStiffness0 | C::CamberStiffness0 | C::SideForceRatio) => true,
            _ => false,
        }
    }
}

/// A fit whose first coefficient came from elsewhere.
pub(crate) fn about(first: f64, second: Option<Fitted>, quality: Quality) -> Fitted {
    let none = || (0.0, Vec::new(), None, None);
    let (theta, weights, covariance, dispersion) = second.map_or_else(none, |fit| {
        let spread = fit.dispersion.first().copied().flatten();
        (fit.theta[0], fit.weights, fit.covariance, spread)
    });
    Fitted {
        theta: vec![first, theta],
        weights,
        covariance: Some(crate::statistics::cluster_covariance::ClusterCovariance::with_exact(
            covariance.as_ref(),
            quality.n_clusters,
        )),
        dispersion: vec![None, dispersion],
        quality,
    }
}
