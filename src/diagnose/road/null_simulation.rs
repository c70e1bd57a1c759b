//! The measured ride, ridden again with all the noise it has: on the base model it is a null, on the
//! extended one it tells how well a size is found.
//!
//! White noise is that of the channels themselves, from their second differences; slow errors of
//! velocities and roll come from the ride ([`sensor_drift`](mod@super::sensor_drift)), differences between manoeuvres
//! too ([`scatter`](mod@super::scatter)). What the residuals scatter beyond all that over seconds is added
//! to them as coloured noise, so that a noisier ride has noisier nulls.

use rayon::prelude::*;

use super::base::{self, Base, Quick};
use super::parameters::{Parameter, Parameters};
use super::replay::{self, From, replay};
use super::residuals::{Blocks, blocks};
use super::samples::{BLOCK, RATE, Samples, picks};
use super::scatter::Scatter;
use super::sensor_drift::{self, Slow};
use super::white_noise::white_noise;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::statistics::random::Random;
use crate::{contract::manoeuvre::ManoeuvreKind, segment::Segment};

/// NullSimulation with sensor noise only, by which what else there is is known.
const QUIET: usize = 3;
/// Time over which the coloured noise forgets, s.
const MEMORY: f64 = 1.5;

/// A ride that can be ridden again and again.
#[derive(Debug)]
pub struct NullSimulation<'a> {
    session: &'a Session,
    segments: &'a [Segment],
    bike: &'a Bike,
    picks: Vec<(ManoeuvreKind, Vec<usize>)>,
    world: Parameters,
    clean: Session,
    white: Vec<(Channel, f64)>,
    wander: Vec<Slow>,
    scatter: Scatter,
    colour: [f64; 8],
    seed: u64,
}

impl<'a> NullSimulation<'a> {
    /// Learns a ride's noise, and simulates it on the fitted base.
    pub fn new(
        session: &'a Session,
        segments: &'a [Segment],
        bike: &'a Bike,
        base: &Base,
        seed: u64,
    ) -> Self {
        let clean = ridden(session, segments, bike, &base.world, From::Session);
        let white = clean
            .channels()
            .filter(|c| clean.get(*c) != session.get(*c))
            .filter_map(|c| session.get(c).map(|x| (c, white_noise(x))))
            .collect();
        let measured = Samples::gather(session, segments);
        let found = blocks(&measured, &base.world);
        let wander = sensor_drift::slow(session, segments, &measured, &found, &base.world);
        let problem = base.problem(&measured);
        let scatter = Scatter::of(&measured, &problem, &problem.linear(&base.world));
        let picks = picks(session, segments);
        let mut simulation = NullSimulation {
            session,
            segments,
            bike,
            picks,
            world: base.world.clone(),
            clean,
            white,
            wander,
            scatter,
            colour: [0.0; 8],
            seed,
        };
        simulation.correct(base);
        simulation
    }

    /// The ride on a better model, its noise learnt anew from what that leaves.
    #[must_use]
    pub fn with_noise_of(&self, model: &Base) -> Self {
        Self::new(self.session, self.segments, self.bike, model, self.seed)
    }

    /// The same noise on another model.
    pub fn with_parameters(&self, world: &Parameters) -> NullSimulation<'a> {
        let clean = match *world == self.world {
            true => self.clean.clone(),
            false => self.noiseless(world, From::Session),
        };
        NullSimulation {
            clean,
            world: world.clone(),
            picks: self.picks.clone(),
            white: self.white.clone(),
            wander: self.wander.clone(),
            scatter: self.scatter.clone(),
            ..*self
        }
    }

    /// What a perfect logger would have recorded on a model.
    pub fn noiseless(&self, world: &Parameters, from: From) -> Session {
        ridden(self.session, self.segments, self.bike, world, from)
    }

    /// The samples that are looked at, per manoeuvre.
    pub fn picks(&self) -> &[(ManoeuvreKind, Vec<usize>)] {
        &self.picks
    }

    fn noisy(&self, number: usize) -> (Session, Random) {
        let mut random = Random::new(self.seed, &format!("null {number}"));
        let mut session = self.clean.clone();
        sensor_drift::add(&mut session, &self.wander, &mut random);
        for (channel, sigma) in &self.white {
            if let Some(x) = session.get_mut(*channel) {
                x.iter_mut().for_each(|x| *x += sigma * random.normal());
            }
        }
        (session, random)
    }

    /// Holds the noise against what it looks like in rides of this plan.
    fn correct(&mut self, base: &Base) {
        let seen: Vec<Vec<Slow>> = (0..QUIET)
            .into_par_iter()
            .map(|number| {
                let (session, _) = self.noisy(number);
                let samples = Samples::take(&session, &self.picks);
                let found = blocks(&samples, &base.world);
                sensor_drift::slow(&session, self.segments, &samples, &found, &base.world)
            })
            .collect();
        for error in &mut self.wander {
            let own = |s: &Vec<Slow>| s.iter().find(|s| s.channel == error.channel).map(|s| s.sd);
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

    /// One noisy ride and the fit to it of `fitted`, from `model`, whose ride it is; `more` is
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

fn ridden(
    session: &Session,
    segments: &[Segment],
    bike: &Bike,
    world: &Parameters,
    from: From,
) -> Session {
    let plant = replay::plant(
        world,
        [bike.front.width, bike.rear.width],
        [bike.front.vertical_stiffness, bike.rear.vertical_stiffness],
    );
    replay(session, segments, &plant, from)
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
