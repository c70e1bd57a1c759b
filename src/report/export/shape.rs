//! Coefficients of a Magic Formula shaped to the characterised tyre.
//!
//! By least squares over what was ridden, then by fourth powers, which spreads the residual evenly. Beyond what was
//! ridden the wish is the estimated tyre up to its peak friction and that peak from there on, with a weight
//! ([`Shape::beyond`]) that decides the shape there and costs little within. Tyre and form are the same on both sides,
//! so that points that lean to one are enough.

use super::grid::Grid;
use super::tyre::Characterised;
use super::validity::Validity;
use crate::report::export::error::Error;
use crate::statistics::nonlinear::{self, Model, Options};
use crate::tyre::paper::{Input, Output};

/// Puts parameters into a set.
pub(crate) type Apply<S> = fn(&mut S, &[f64]);

/// A force of a set by itself, and that of a tyre.
pub(crate) type Force<S> = (fn(&S, &Input) -> f64, fn(&Output) -> f64);

/// Shaped parameters and their bounds.
pub(crate) struct Shape<'a, S> {
    pub force: Force<S>,
    /// Road friction at which the set is asked, where it is not that of the ride.
    pub friction: Option<f64>,
    /// Where the parameters go.
    pub apply: Apply<S>,
    pub bounds: &'a [(f64, f64)],
    /// From where the search begins.
    pub starts: &'a [Vec<f64>],
    /// Weight of all points of the file's ranges together, over that of all ridden ones: of residuals.
    pub beyond: f64,
    /// Largest difference beyond, over the largest force there; where it is more, beyond weighs more.
    pub most: f64,
}

impl<S> Shape<'_, S> {
    /// Wanted output of the set for an input of the tyre.
    fn of_set(&self, input: &Input) -> Input {
        Input { friction: self.friction.unwrap_or(input.friction), ..*input }
    }
}

/// How much more beyond weighs, one after the other, as long as it is too far off.
const HEAVIER: [f64; 3] = [1.0, 4.0, 16.0];

/// Which points a shape is fitted to.
pub(crate) type Points = fn(&Grid, &Characterised, f64) -> Vec<Input>;

struct Curve<'a, S> {
    set: &'a S,
    shape: &'a Shape<'a, S>,
    inputs: &'a [Input],
    wanted: &'a [f64],
    /// Weight over the largest ridden force.
    scale: &'a [f64],
    /// Largest ridden force, N.
    largest: f64,
    /// Fourth powers instead of squares.
    even: bool,
}

impl<S: Clone> Model for Curve<'_, S> {
    fn parameters(&self) -> usize {
        self.shape.bounds.len()
    }

    fn len(&self) -> usize {
        self.inputs.len()
    }

    fn residuals(&self, theta: &[f64], out: &mut [f64]) {
        let mut set = self.set.clone();
        (self.shape.apply)(&mut set, theta);
        let points = self.inputs.iter().zip(self.wanted).zip(self.scale);
        for (o, ((input, wanted), scale)) in out.iter_mut().zip(points) {
            let e = (self.shape.force.0)(&set, &self.shape.of_set(input)) - wanted;
            *o = if self.even { 1e3 * scale * e * e.abs() / self.largest } else { e * scale };
        }
    }
}

/// Fits one force of a set to the characterised tyre at the nominal load and leaves the parameters in the set.
///
/// # Errors
/// The fit does not come to an end.
pub(crate) fn solve<S: Clone>(
    c: &Characterised,
    set: &mut S,
    points: Points,
    shape: &Shape<'_, S>,
) -> Result<(), Error> {
    let load = c.load();
    let peak = Validity::of(c).peak * load;
    let of = shape.force.1;
    let one_side = |grid: &Grid| -> Vec<Input> {
        points(grid, c, load).into_iter().filter(|i| i.camber <= 1e-9).collect()
    };
    let ridden = one_side(&Grid::ridden(c));
    let beyond = one_side(&Grid::whole(c));
    let most = |inputs: &[Input]| {
        inputs.iter().map(|i| of(&c.wanted(i)).abs()).fold(1e-9 * load, f64::max)
    };
    let largest = most(&ridden);
    let share = (ridden.len() as f64 / beyond.len().max(1) as f64).sqrt();
    let first_beyond = ridden.len();
    let inputs: Vec<Input> = ridden.into_iter().chain(beyond).collect();
    let wanted: Vec<f64> =
        inputs.iter().map(|input| of(&c.wanted(input)).clamp(-peak, peak)).collect();
    let before = set.clone();
    let options = Options { tuning: f64::INFINITY, least_gain: 1e-5, ..Options::default() };
    let fit = |curve: &Curve<'_, S>, starts: &[Vec<f64>]| {
        nonlinear::fit(curve, starts, Some(shape.bounds), &options)
            .map_err(|e| Error::Fit(e.to_string()))
    };
    let shaped = |heavier: f64| -> Result<Vec<f64>, Error> {
        let beyond = heavier * shape.beyond * share / largest;
        let scale: Vec<f64> = (0..inputs.len())
            .map(|i| if i < first_beyond { 1.0 / largest } else { beyond })
            .collect();
        let mut curve = Curve {
            set: &before,
            shape,
            inputs: &inputs,
            wanted: &wanted,
            scale: &scale,
            largest,
            even: false,
        };
        let first = fit(&curve, shape.starts)?.theta;
        curve.even = true;
        Ok(fit(&curve, std::slice::from_ref(&first))?.theta)
    };
    // where the tyre itself is believed
    let off = |theta: &[f64]| {
        let mut set = before.clone();
        (shape.apply)(&mut set, theta);
        let believed = inputs[first_beyond..]
            .iter()
            .zip(&wanted[first_beyond..])
            .filter(|(_, wanted)| wanted.abs() < peak);
        let (mut off, mut most) = (0.0_f64, 1e-9 * load);
        for (input, wanted) in believed {
            off = off.max(((shape.force.0)(&set, &shape.of_set(input)) - wanted).abs());
            most = most.max(wanted.abs());
        }
        off / most
    };
    let mut best = shaped(HEAVIER[0])?;
    let mut least = off(&best);
    for heavier in &HEAVIER[1..] {
        if least <= shape.most {
            break;
        }
        let other = shaped(*heavier)?;
        let its = off(&other);
        if its < least {
            (best, least) = (other, its);
        }
    }
    (shape.apply)(set, &best);
    Ok(())
}
