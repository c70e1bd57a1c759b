//! How far the simulation is off on manoeuvres left out of the fit, before and after the identified causes, in
//! the channels' own units: rows of `simulation_errors` (`book/src/diagnosis.md`, section 2.10).

use crate::contract::schema;
use std::collections::BTreeMap;
use std::f64::consts::{PI, SQRT_2, TAU};

use rayon::prelude::*;
use statrs::function::erf::erf;

use super::null_simulation::NullSimulation;
use super::replays::{ChannelSamples, Replays, SHOWN, shown};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::statistics::random::Random;
use crate::store::tables::rows::{Ident, SimulationError};

/// Fault-free simulations, which show what a correct model leaves.
const NULLS: usize = 4;
/// Draws of manoeuvres for an interval.
const DRAWS: usize = 400;
/// Fewest manoeuvres that are drawn from.
const MIN_MANOEUVRES: usize = 3;

/// Rows by channel and kind of manoeuvre; `simulation` is on the model that is taken for right.
pub(crate) fn simulation_errors(
    replays: &Replays,
    simulation: &NullSimulation<'_>,
    seed: u64,
    ident: &Ident,
) -> Vec<SimulationError> {
    let nulls: Vec<[ChannelSamples; 2]> = (0..NULLS)
        .into_par_iter()
        .map(|number| simulation.noise_alone(number).map(|s| shown(&s, simulation, |_| true)))
        .collect();
    let mut kinds: BTreeMap<ManoeuvreKind, Vec<usize>> = BTreeMap::new();
    for (m, (kind, _)) in simulation.picks().iter().enumerate() {
        kinds.entry(*kind).or_default().push(m);
    }
    let definition = schema::session();
    let mut rows = Vec::new();
    for (c, channel) in SHOWN.into_iter().enumerate() {
        let unit = definition.column(channel.name()).and_then(|c| c.unit.clone());
        for (kind, own) in &kinds {
            let cell = Cell { replays, nulls: &nulls, channel: c, manoeuvres: own };
            let mut random = Random::new(seed, &format!("{channel:?} {}", kind.name()));
            let Some(row) = cell.row(&mut random) else { continue };
            rows.push(SimulationError {
                ident: ident.clone(),
                channel: channel.name().to_owned(),
                kind: kind.name().to_owned(),
                unit: unit.clone().unwrap_or_default(),
                ..row
            });
        }
    }
    rows
}

/// One channel in one kind of manoeuvre.
struct Cell<'a> {
    replays: &'a Replays,
    nulls: &'a [[ChannelSamples; 2]],
    channel: usize,
    manoeuvres: &'a [usize],
}

/// Samples of a manoeuvre and the sums of squared errors of two models, on the same samples: where one
/// cannot be ridden the other does not count.
#[derive(Debug, Clone, Copy, Default)]
struct Errors {
    n: f64,
    before: f64,
    after: f64,
}

impl Errors {
    fn sum(of: impl Iterator<Item = Errors>) -> Errors {
        of.fold(Errors::default(), |a, b| Errors {
            n: a.n + b.n,
            before: a.before + b.before,
            after: a.after + b.after,
        })
    }

    /// Root mean squares.
    fn rms(self) -> [f64; 2] {
        [self.before, self.after].map(|sum| (sum / self.n).sqrt())
    }
}

impl Cell<'_> {
    /// Numbers of the row; `None` where nothing can be compared.
    fn row(&self, random: &mut Random) -> Option<SimulationError> {
        let Replays { measured, base, extended } = self.replays;
        let noise_rms = self.nulls.iter().flat_map(|[m, s]| self.errors(m, [s, s]));
        let [noise_rms, _] = Errors::sum(noise_rms).rms();
        let own: Vec<Errors> =
            self.errors(measured, [base, extended.as_ref().unwrap_or(base)]).collect();
        let [rmse_base, rmse_extended] = Errors::sum(own.iter().copied()).rms();
        let is_compared = extended.is_some();
        let ratio = |of: Errors| of.rms()[1] / of.rms()[0];
        let interval = (is_compared && own.len() >= MIN_MANOEUVRES).then(|| {
            let mut any =
                || own[(random.between(0.0, own.len() as f64) as usize).min(own.len() - 1)];
            let mut draws: Vec<f64> =
                (0..DRAWS).map(|_| ratio(Errors::sum((0..own.len()).map(|_| any())))).collect();
            draws.sort_by(f64::total_cmp);
            [draws[DRAWS / 40], draws[DRAWS - 1 - DRAWS / 40]]
        });
        let crps = |x: &ChannelSamples| self.crps(measured, x, noise_rms);
        (rmse_base.is_finite() && noise_rms > 0.0).then(|| SimulationError {
            rmse_base,
            rmse_extended: is_compared.then_some(rmse_extended),
            noise_floor: noise_rms,
            crps_base: crps(base),
            crps_extended: extended.as_ref().map(crps),
            ratio: is_compared.then_some(rmse_extended / rmse_base),
            ratio_ci95_low: interval.map(|i| i[0]),
            ratio_ci95_high: interval.map(|i| i[1]),
            n: own.len() as i64,
            ..SimulationError::default()
        })
    }

    /// Measured less simulated of one manoeuvre, sample by sample.
    fn differences<'b>(
        &self,
        measured: &'b ChannelSamples,
        simulated: &'b ChannelSamples,
        m: usize,
    ) -> impl Iterator<Item = f64> + 'b {
        let of =
            |x: &'b ChannelSamples| x[self.channel].get(m).map(Vec::as_slice).unwrap_or_default();
        of(measured).iter().zip(of(simulated)).map(|(measured, simulated)| measured - simulated)
    }

    /// Errors of two models in every manoeuvre that can be compared.
    fn errors(
        &self,
        measured: &ChannelSamples,
        models: [&ChannelSamples; 2],
    ) -> impl Iterator<Item = Errors> {
        self.manoeuvres.iter().filter_map(move |&m| {
            let [before, after] = models.map(|model| self.differences(measured, model, m));
            let known = before.zip(after).filter(|(a, b)| (a + b).is_finite());
            let own = known.map(|(a, b)| Errors { n: 1.0, before: a * a, after: b * b });
            Some(Errors::sum(own)).filter(|own| own.n > 0.0)
        })
    }

    /// Mean continuous ranked probability score of simulations whose error is normal.
    fn crps(&self, measured: &ChannelSamples, model: &ChannelSamples, sd: f64) -> f64 {
        let all = self.manoeuvres.iter().flat_map(|&m| self.differences(measured, model, m));
        let (n, sum) = all
            .filter(|error| error.is_finite())
            .fold((0.0, 0.0), |(n, sum), error| (n + 1.0, sum + crps(error, sd)));
        sum / n
    }
}

/// Continuous ranked probability score of an error under a normal distribution about zero (Gneiting and
/// Raftery 2007, eq. 21): the error itself where it is large, 0.23 `sd` where there is none.
fn crps(error: f64, sd: f64) -> f64 {
    let z = error / sd;
    let density = (-0.5 * z * z).exp() / TAU.sqrt();
    sd * (z * erf(z / SQRT_2) + 2.0 * density - 1.0 / PI.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the integral of the squared difference of distribution and step.
    #[test]
    fn the_score_is_the_integral_that_defines_it() {
        let (error, sd) = (0.7, 0.4);
        let step = 1e-4;
        let integral: f64 = (-60_000..60_000)
            .map(|k| {
                let x = f64::from(k) * step;
                let below = 0.5 * (1.0 + erf(x / sd / SQRT_2));
                let is = if x >= error { 1.0 } else { 0.0 };
                (below - is) * (below - is) * step
            })
            .sum();
        assert!((crps(error, sd) - integral).abs() < 1e-4, "{} {integral}", crps(error, sd));
        assert!((crps(100.0, sd) - (100.0 - sd / PI.sqrt())).abs() < 1e-9);
    }

    #[test]
    fn errors_are_compared_where_both_models_could_be_ridden() {
        let of = |x: &[f64]| -> ChannelSamples {
            std::array::from_fn(|c| if c == 0 { vec![x.to_vec(); 3] } else { Vec::new() })
        };
        let replays = Replays {
            measured: of(&[1.0, 2.0, 3.0, f64::NAN]),
            base: of(&[0.0, 1.0, 2.0, 3.0]),
            extended: Some(of(&[0.9, f64::NAN, 2.9, 3.0])),
        };
        let nulls = [[of(&[0.0; 4]), of(&[0.1; 4])]];
        let cell = Cell { replays: &replays, nulls: &nulls, channel: 0, manoeuvres: &[0, 1, 2] };
        let row = cell.row(&mut Random::new(1, "test")).expect("a row");
        assert!((row.rmse_base - 1.0).abs() < 1e-12 && row.n == 3);
        assert!((row.ratio.expect("a ratio") - 0.1).abs() < 1e-12);
        assert!((row.noise_floor - 0.1).abs() < 1e-12);
        assert!(row.crps_extended.expect("a score") < row.crps_base);
    }
}
