//! Fault-free simulations: the measured ride simulated with all the noise it has. On the nominal model they tell
//! what candidates show where nothing is left out, on the extended one also how well a size is found.
//!
//! White noise is that of the channels themselves, from their second differences; drifts of
//! velocities and roll come from the ride ([`sensor_drift`](mod@super::sensor_drift)), differences between manoeuvres
//! too ([`scatter`](mod@super::scatter)). What the residuals scatter beyond all that over seconds is added
//! to them as coloured noise, so that a noisier ride has noisier fault-free simulations.

use rayon::prelude::*;

use super::base::{self, Base, Quick};
use super::parameters::{Parameter, Parameters};
use super::replay::{self, From, replay};
use super::residuals::{Blocks, blocks};
use super::samples::{BLOCK, RATE, Samples, picks};
use super::scatter::Scatter;
use super::sensor_drift::{self, Drift};
use super::sensors;
use super::white_noise::white_noise;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::ALL;
use crate::statistics::random::Random;

/// Simulations with sensor noise only, from which follows what other noise there is.
const QUIET: usize = 3;
/// How much noise there is at most for that which is left with every effect free: they take some up.
const TAKEN_UP: f64 = 1.15;
/// Time over which the coloured noise forgets, s.
const MEMORY: f64 = 1.5;

/// A ride that can be simulated again and again.
#[derive(Debug)]
pub struct NullSimulation<'a> {
    session: &'a Session,
    segments: &'a [Segment],
    picks: Vec<(ManoeuvreKind, Vec<usize>)>,
    values: Parameters,
    clean: Session,
    white: Vec<(Channel, f64)>,
    drift: Vec<Drift>,
    scatter: Scatter,
    colour: [f64; 8],
    seed: u64,
}

impl<'a> NullSimulation<'a> {
    /// Learns a ride's noise, and simulates it on the fitted base.
    pub fn new(session: &'a Session, segments: &'a [Segment], base: &Base, seed: u64) -> Self {
        let clean = ridden(session, segments, &base.values, From::Session);
        let white = clean
            .channels()
            .filter(|c| clean.get(*c) != session.get(*c))
            .filter_map(|c| session.get(c).map(|x| (c, white_noise(x))))
            .collect();
        let measured = Samples::gather(session, segments);
        // what an effect explains is neither drift nor scatter nor noise, or a large one would hide itself
        let free = base.with_everything(&measured, ALL);
        let problem = free.problem(&measured);
        let linear = problem.linear(&free.values);
        let drift =
            sensor_drift::drifts(session, segments, &measured, &linear.residuals, &free.values);
        let scatter = Scatter::of(&measured, &problem, &linear, &free.values);
        let sigma = [0, 1, 2, 3, 4, 5, 6, 7].map(|c| base.sigma[c].min(TAKEN_UP * free.sigma[c]));
        let picks = picks(session, segments);
        let mut simulation = NullSimulation {
            session,
            segments,
            picks,
            values: base.values.clone(),
            clean,
            white,
            drift,
            scatter,
            colour: [0.0; 8],
            seed,
        };
        simulation.correct(&Base { sigma, ..base.clone() });
        simulation
    }

    /// The simulation of a better model, its noise learnt anew from what that leaves.
    #[must_use]
    pub fn with_noise_of(&self, model: &Base) -> Self {
        Self::new(self.session, self.segments, model, self.seed)
    }

    /// The same noise on another model.
    pub fn with_parameters(&self, values: &Parameters) -> NullSimulation<'a> {
        let clean = match *values == self.values {
            true => self.clean.clone(),
            false => self.noiseless(values, From::Session),
        };
        NullSimulation {
            clean,
            values: values.clone(),
            picks: self.picks.clone(),
            white: self.white.clone(),
            drift: self.drift.clone(),
            scatter: self.scatter.clone(),
            ..*self
        }
    }

    /// Recording of a perfect logger on a model.
    pub fn noiseless(&self, values: &Parameters, from: From) -> Session {
        ridden(self.session, self.segments, values, from)
    }

    /// The samples that are looked at, per manoeuvre.
    pub fn picks(&self) -> &[(ManoeuvreKind, Vec<usize>)] {
        &self.picks
    }

    /// A fault-free simulation and what the same model makes of its inputs, manoeuvre by manoeuvre: what a model
    /// that is right leaves of a ride with the sensors' noise.
    pub fn noise_alone(&self, number: usize) -> [Session; 2] {
        let (measured, _) = self.noisy(QUIET + number);
        let simulated = ridden(&measured, self.segments, &self.values, From::Manoeuvres);
        [measured, simulated]
    }

    /// Recording of a perfect logger in some of the manoeuvres in use.
    pub fn noiseless_of(&self, values: &Parameters, wanted: impl Fn(usize) -> bool) -> Session {
        let starts = self.picks.iter().enumerate().filter(|(m, _)| wanted(*m));
        let starts: Vec<usize> = starts.filter_map(|(_, (_, own))| own.first().copied()).collect();
        let mut segments = self.segments.to_vec();
        for s in &mut segments {
            s.used &= starts.iter().any(|i| (s.start..s.end).contains(i));
        }
        ridden(self.session, &segments, values, From::Manoeuvres)
    }

    fn noisy(&self, number: usize) -> (Session, Random) {
        let mut random = Random::new(self.seed, &format!("null {number}"));
        let mut session = self.clean.clone();
        sensor_drift::add(&mut session, &self.drift, &mut random);
        for (channel, sigma) in &self.white {
            if let Some(x) = session.get_mut(*channel) {
                x.iter_mut().for_each(|x| *x += sigma * random.normal());
            }
        }
        (session, random)
    }

    /// Scales the noise so that simulations of this ride show as much of it as the ride.
    fn correct(&mut self, base: &Base) {
        let seen: Vec<Vec<Drift>> = (0..QUIET)
            .into_par_iter()
            .map(|number| {
                let (session, _) = self.noisy(number);
                let samples = Samples::take(&session, &self.picks);
                let found = blocks(&samples, &base.values);
                sensor_drift::drifts(&session, self.segments, &samples, &found, &base.values)
            })
            .collect();
        for error in &mut self.drift {
            let own = |s: &Vec<Drift>| s.iter().find(|s| s.channel == error.channel).map(|s| s.sd);
            let sizes: Vec<f64> = seen.iter().filter_map(own).collect();
            let mean = sizes.iter().sum::<f64>() / sizes.len().max(1) as f64;
            if mean > 0.0 {
                error.sd *= (error.sd / mean).clamp(0.4, 1.5);
            }
        }
        // what sensor noise explains of the residuals' scatter, once a base is fitted to it
        let alone: Vec<[f64; 8]> = (0..QUIET)
            .into_par_iter()
            .map(|number| {
                let samples = Samples::take(&self.noisy(number).0, &self.picks);
                let none: Blocks = std::array::from_fn(|_| vec![0.0; samples.blocks()]);
                let fitted = &base.parameters;
                base::fit_quick(&samples, base, fitted, &[], none, |_, _| {}).base.sigma
            })
            .collect();
        self.colour = std::array::from_fn(|c| {
            let alone = alone.iter().map(|s| s[c] * s[c]).sum::<f64>() / QUIET as f64;
            (base.sigma[c].powi(2) - alone).max(0.0).sqrt()
        });
    }

    /// One fault-free simulation and the fit to it of `fitted`, from `model`, which it simulates; `more` is
    /// linearised along with it.
    pub fn fit(
        &self,
        number: usize,
        model: &Base,
        fitted: &[Parameter],
        more: &[Parameter],
    ) -> (Samples, Quick) {
        let (session, mut random) = self.noisy(QUIET + number);
        let samples = Samples::take(&session, &self.picks);
        let extra = coloured(&samples, &self.colour, &mut random);
        let quick = base::fit_quick(&samples, model, fitted, more, extra, |linear, to| {
            self.scatter.add(&samples, linear, &mut random, to);
        });
        (samples, quick)
    }
}

/// Recording of a logger with the sensors of a model, without their noise.
fn ridden(session: &Session, segments: &[Segment], values: &Parameters, from: From) -> Session {
    let as_ridden = sensors::as_ridden(session, values);
    let ridden = replay(&as_ridden, segments, &replay::plant(values), from);
    sensors::as_recorded(ridden, values)
}

/// Coloured noise per channel whose long-run standard deviation is given.
fn coloured(samples: &Samples, long_run: &[f64; 8], random: &mut Random) -> Blocks {
    let keep = (-(BLOCK as f64) / RATE / MEMORY).exp();
    std::array::from_fn(|c| {
        let sd = long_run[c] * ((1.0 - keep) / (1.0 + keep)).sqrt();
        let mut out = Vec::with_capacity(samples.blocks());
        for (_, range) in &samples.manoeuvres {
            let mut value = sd * random.normal();
            for _ in 0..range.len() / BLOCK {
                out.push(value);
                value = keep * value + sd * (1.0 - keep * keep).sqrt() * random.normal();
            }
        }
        out
    })
}
