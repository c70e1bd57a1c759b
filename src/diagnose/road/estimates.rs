//! The whole vector of a session's diagnosis: every parameter of the nominal model, the size that every effect would have
//! alone, and the trace of each effect in all of them.
//!
//! ```text
//! H = J' W J + priors                     nominal parameters b, effects e, at the nominal model's optimum
//! size_e   = g_e / S_ee,   S = H_ee - H_eb H_bb^-1 H_be       alone, to first order, nominal model refitted
//! trace of a size d of e:  b moves by H_bb^-1 H_be d,  the size of f by (S_fe / S_ff) d
//! ```
//!
//! `S` is without the effects' priors in its numerator. So which nominal parameters an effect moves is not
//! declared by hand: it follows from the ride.
//!
//! Where causes have been identified the model is linearised with them in it, at their sizes, and every number gets what
//! the causes move it by. Of a large effect the first order at the nominal model is wrong in all numbers: a latency of
//! 80 ms was 60 ms, and the rest of it looked like two further changes.
//!
//! A parameter of the nominal model that the fit has taken far from the ride's own coefficient says nothing of the
//! motorcycle, and has no row: the friction of a tyre that never braked.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::base::Base;
use super::parameters::Parameter;
use super::problem::{Linear, Problem};
use super::samples::Samples;
use crate::simulate::effects::Effect;
use crate::store::tables::rows::{EffectTrace, EstimateRow, Ident};

/// Share of a standard error that a trace of a usual size must reach in a number to be listed.
const LISTED: f64 = 0.1;

/// Sizes, in usual ones, from which the first order is not enough, and how large, in standard errors.
const FAR: f64 = 0.7;
const SURE: f64 = 5.0;
/// Sets of slopes of a refit.
const TIMES: usize = 8;
/// Distance of a nominal parameter from where its prior is centred, in prior standard deviations, from which it has no
/// row.
const STRAINED: f64 = 2.5;

/// Coefficients of a ride with the nominal model alone, or with the identified causes.
#[derive(Debug)]
pub struct Nominal {
    /// The model, with the causes in its values.
    pub base: Base,
    /// The causes: places in the list of effects, and sizes.
    pub causes: Vec<(usize, f64)>,
}

impl Nominal {
    /// A model beside which nothing is identified.
    pub fn alone(base: &Base) -> Self {
        Nominal { base: base.clone(), causes: Vec::new() }
    }

    /// A model beside causes, by name and size, that `extended` has.
    pub(crate) fn beside<'a>(
        base: &Base,
        extended: &Base,
        causes: impl Iterator<Item = (&'a str, f64)>,
        effects: &[Effect],
    ) -> Self {
        let place = |(name, size): (&str, f64)| {
            let place = effects.iter().position(|e| e.name == name)?;
            size.is_finite().then_some((place, size))
        };
        let causes: Vec<(usize, f64)> = causes.filter_map(place).collect();
        match causes.is_empty() {
            true => Nominal::alone(base),
            false => {
                Nominal { base: Base { values: extended.values.clone(), ..base.clone() }, causes }
            }
        }
    }
}

/// The size of the effect at a place of `all` when the nominal model is refitted with it.
fn refitted(
    samples: &Samples,
    base: &Base,
    linear: &Linear,
    place: usize,
    all: &[Parameter],
) -> Option<f64> {
    let known = linear.with(base.parameters.len(), place);
    let effect = all[place];
    let refit = base.extended_along(Some(known), samples, &[effect], TIMES);
    let size = effect.get(&refit.values);
    size.is_finite().then_some(size)
}

/// The rows of `estimates` and `effect_traces` of a session; none where the model's curvature has no inverse.
pub fn estimates(
    samples: &Samples,
    nominal: &Nominal,
    effects: &[Effect],
    ident: &Ident,
) -> (Vec<EstimateRow>, Vec<EffectTrace>) {
    let Nominal { base, causes } = nominal;
    let more: Vec<Parameter> = effects.iter().map(Effect::parameter).collect();
    let all: Vec<Parameter> = base.parameters.iter().chain(&more).copied().collect();
    let (b, n) = (base.parameters.len(), all.len());
    let mut linear = base.linear_with(samples, &more);
    let values = base.problem(samples).relax(&mut linear, &base.values);
    let problem = Problem::new(samples, &base.start, base.sigma, &all);
    let (matrix, gradient) = problem.normal_of(&linear, &values, true);
    // an effect that the base lacks is in what it leaves, and is no noise
    let free = base.with_everything(samples, effects);
    let noise = Problem::new(samples, &base.start, free.sigma, &all);
    let (known, _) = noise.normal_of(&noise.linear(&free.values), &free.values, true);
    let Some(vector) = Vector::of(&matrix, &gradient, &known, &more, b) else {
        return (Vec::new(), Vec::new());
    };
    let sizes: Vec<f64> = (0..effects.len())
        .map(|e| {
            let (size, error) = (vector.sizes[e], vector.errors[b + e]);
            let first = size * more[e].scale;
            match size.abs() > FAR * effects[e].typical.abs() / more[e].scale
                && size.abs() > SURE * error
            {
                // an impossible size is another optimum: it would look like a change beside a ride that stayed in the first
                true => refitted(samples, base, &linear, b + e, &all)
                    .filter(|size| effects[e].in_bounds(*size))
                    .unwrap_or(first),
                false => first,
            }
        })
        .collect();
    let trace_of = |e: usize, k: usize| vector.traces[(k, e)] * all[k].scale / all[b + e].scale;
    let value = |k: usize| {
        // the size of a cause that is in the model is what the diagnosis says of it, fitted bias taken off
        let is_cause = |e: usize| causes.iter().any(|(cause, _)| *cause == e);
        let beside = match k.checked_sub(b) {
            None => all[k].get(&values),
            Some(e) if is_cause(e) => 0.0,
            Some(e) => sizes[e],
        };
        beside + causes.iter().map(|(e, size)| trace_of(*e, k) * size).sum::<f64>()
    };
    let strained: Vec<&str> = (0..b)
        .filter(|k| problem.prior(&all[*k], &values).0.abs() > STRAINED)
        .map(|k| whole(all[k].name))
        .collect();
    let is_strained = |k: usize| k < b && strained.contains(&whole(all[k].name));
    let error = |k: usize| vector.errors[k] * all[k].scale;
    let unit = |k: usize| match k < b {
        true => unit_of(all[k].name),
        false => effects[k - b].unit,
    };
    let rows = (0..n).filter(|k| !is_strained(*k)).map(|k| EstimateRow {
        ident: ident.clone(),
        parameter: all[k].name.to_owned(),
        part: if k < b { "nominal" } else { "effect" }.to_owned(),
        unit: unit(k).to_owned(),
        value: value(k),
        std_error: error(k),
    });
    let trace = |e: usize, k: usize| EffectTrace {
        ident: ident.clone(),
        effect: effects[e].name.to_owned(),
        parameter: all[k].name.to_owned(),
        slope: trace_of(e, k),
    };
    let is_listed = |e: usize, k: usize| {
        let size = vector.traces[(k, e)];
        k == b + e || size.is_finite() && size.abs() > LISTED * vector.errors[k] && !is_strained(k)
    };
    let traces = (0..effects.len())
        .flat_map(|e| (0..n).filter(move |k| is_listed(e, *k)).map(move |k| trace(e, k)));
    (rows.collect(), traces.collect())
}

/// Name of a parameter's group: the numbers of a friction curve are estimated together, all others alone.
fn whole(name: &str) -> &str {
    const CURVES: [(&str, &str); 2] = [("front", "front curve"), ("rear", "rear curve")];
    let of_curve = |(axle, curve): &(&str, &'static str)| {
        (name.starts_with("mf_") && name.ends_with(axle)).then_some(*curve)
    };
    CURVES.iter().find_map(of_curve).unwrap_or(name)
}

/// The vector, in the parameters' scales.
struct Vector {
    /// Sizes of the effects.
    sizes: Vec<f64>,
    /// Standard errors of all.
    errors: Vec<f64>,
    /// By parameter and effect: what a usual size of the effect moves the parameter by.
    traces: DMatrix<f64>,
}

impl Vector {
    /// From curvature and downhill direction, with the priors; the first `b` are the nominal model's. `known` is the
    /// curvature with the noise that all effects leave: the errors are from it.
    fn of(
        matrix: &DMatrix<f64>,
        gradient: &DVector<f64>,
        known: &DMatrix<f64>,
        more: &[Parameter],
        b: usize,
    ) -> Option<Self> {
        let effects = more.len();
        let own = matrix.view((0, 0), (b, b)).into_owned().cholesky()?;
        let (moved, left) = without_nominal(matrix, b, &own);
        let pull = gradient.rows(b, effects) - moved.transpose() * gradient.rows(0, b);
        let prior = |e: usize| more[e].prior.powi(-2);
        let sizes = (0..effects).map(|e| pull[e] / left[(e, e)]).collect();
        let own = known.view((0, 0), (b, b)).into_owned().cholesky()?;
        let (nominal, alone) = (own.inverse(), without_nominal(known, b, &own).1);
        let errors = (0..b)
            .map(|k| nominal[(k, k)].sqrt())
            .chain((0..effects).map(|e| alone[(e, e)].sqrt().recip()))
            .collect();
        let traces = DMatrix::from_fn(b + effects, effects, |k, e| match k < b {
            true => moved[(k, e)],
            false => {
                let f = k - b;
                (left[(f, e)] - if f == e { prior(e) } else { 0.0 }) / left[(f, f)]
            }
        });
        Some(Vector { sizes, errors, traces })
    }
}

/// Shift of the nominal parameters by each effect, and the effects' curvature with the nominal model refitted.
fn without_nominal(
    matrix: &DMatrix<f64>,
    b: usize,
    own: &Cholesky<f64, Dyn>,
) -> (DMatrix<f64>, DMatrix<f64>) {
    let effects = matrix.nrows() - b;
    let across = matrix.view((0, b), (b, effects));
    let moved = own.solve(&across);
    let left = matrix.view((b, b), (effects, effects)) - across.transpose() * &moved;
    (moved, left)
}

/// Unit of a parameter of the nominal model.
fn unit_of(name: &str) -> &'static str {
    match name {
        "drag" => "kg/m",
        "brake_gain_front" | "brake_gain_rear" => "N m/Pa",
        "radius_front"
        | "radius_rear"
        | "overturning_stiffness"
        | "dive_arm_front"
        | "dive_arm_rear"
        | "sag_front"
        | "sag_rear"
        | "velocity_height"
        | "accelerometer_ahead"
        | "accelerometer_height" => "m",
        "stiffness_decay_front" | "stiffness_decay_rear" => "1/rad^2",
        "vertical_stiffness_front" => "N/m",
        "pitch_gyration" => "m^2",
        "roll_inertia" => "kg m^2",
        "roll_rate_term" | "velocity_y_zero" => "m/s",
        "yaw_rate_zero" => "rad/s",
        "acceleration_y_zero" | "acceleration_x_zero" => "m/s^2",
        "attitude_delay" => "s",
        "accelerometer_yaw" => "rad",
        _ => "1",
    }
}
