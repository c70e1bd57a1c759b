//! The sets of manoeuvres ranked by what they would tell.

use rayon::prelude::*;

use super::information::{Curvature, Information};
use super::sets::{SETS, Set, leaning};
use crate::contract::bike::Bike;
use crate::contract::session::{Meta, Session};
use crate::diagnose::road::base::{self, Base};
use crate::diagnose::road::parameters::{BASE, Parameter, Parameters};
use crate::diagnose::road::replay;
use crate::diagnose::road::residuals::blocks;
use crate::diagnose::road::samples::Samples;
use crate::pipeline::{self, Pipeline};
use crate::simulate;
use crate::simulate::effects::{ALL, Effect, Level};
use crate::simulate::plan::Phase;
use crate::simulate::rider::Disturbance;
use crate::statistics::random::Random;

/// Likeness from which two effects count as one that a ride cannot tell apart: a rival then gains four
/// fifths of what the cause itself gains.
pub const ALIKE: f64 = 0.9;
/// Logging rate of simulated sets, Hz.
const LOGGED: f64 = 100.0;
/// Longest set, s: a fitted model on which a set does not end is advised without it.
const LONGEST: f64 = 400.0;

/// Information of a session on the effects, now and after each additional riding.
#[derive(Debug, Clone)]
pub struct Advice {
    /// The effects' names, in the order of what is known of them.
    pub effects: Vec<&'static str>,
    pub own: Information,
    /// With each set ridden on top.
    pub with: Vec<(Set, Information)>,
}

/// Benefit of a set for a cause and its rivals, or for an effect that is not identifiable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Change {
    /// The set, as the subject of a sentence in the plural.
    pub set: &'static str,
    /// Before and after: standard deviations per usual size, from the rivals or from nothing.
    pub separation: [f64; 2],
    /// Before and after: how much of the response the rivals can make, 0 to 1.
    pub likeness: [f64; 2],
}

impl Change {
    /// Whether rivals are separated after it.
    pub fn resolves(&self) -> bool {
        self.likeness[1] < ALIKE
    }

    pub fn words(&self) -> String {
        let ([from, to], [before, after]) = (self.separation, self.likeness);
        format!(
            "{} would take the separation from {from:.1} to {to:.1} standard deviations per usual size \
             (likeness {before:.2} to {after:.2})",
            self.set
        )
    }
}

impl Advice {
    /// For a session with these samples and the best model of it, `base` and the causes identified with it.
    pub fn new(
        session: &Session,
        samples: &Samples,
        best: &Base,
        effects: &[Effect],
        bike: &Bike,
        pipeline: &Pipeline,
    ) -> Self {
        let (parameters, best) = (parameters(effects), quiet(samples, best));
        let own = Curvature::of(samples, &best, &best.values, &parameters);
        let later = session.duration();
        // the simulated sensors have no zeros
        let values = best.values.with_perfect_sensors();
        let of_a_session = of_a_session();
        let with = SETS
            .par_iter()
            .map(|set| {
                let simulated = |values: &Parameters, phases: Vec<Phase>, later: f64| {
                    simulated_set(set.words, phases, session, values, bike, pipeline, later)
                };
                let phases = (set.phases)();
                let more = match set.leans {
                    [] => {
                        let samples = simulated(&values, phases, later);
                        Curvature::of(&samples, &best, &values, &parameters)
                    }
                    leans => {
                        let each = leans.iter().map(|lean| {
                            let mut values = values.clone();
                            values.model_error.rider_lean += lean;
                            let all = [&*parameters, &of_a_session].concat();
                            let phases = leaning(phases.clone(), *lean, bike.cg_height);
                            let samples = simulated(&values, phases, 0.0);
                            Curvature::of(&samples, &best, &values, &all).without(&of_a_session)
                        });
                        each.reduce(|a, b| a.and(&b)).unwrap_or_else(|| own.clone())
                    }
                };
                (*set, own.and(&more).information(BASE))
            })
            .collect();
        let effects = effects.iter().map(|e| e.name).collect();
        Advice { effects, own: own.information(BASE), with }
    }

    /// Where an effect is among those known.
    pub fn place(&self, effect: &str) -> Option<usize> {
        self.effects.iter().position(|e| *e == effect)
    }

    /// The set that takes an effect farthest from its rivals; one that tells them apart before one that
    /// does not. `None` where no set helps.
    pub fn best_separation(&self, effect: &str, rivals: &[&str]) -> Option<Change> {
        let i = self.place(effect)?;
        let rivals: Vec<usize> = rivals.iter().filter_map(|r| self.place(r)).collect();
        let changes = self.with.iter().map(|(set, with)| Change {
            set: set.words,
            separation: [&self.own, with].map(|k| k.separation(i, &rivals)),
            likeness: [&self.own, with].map(|k| k.likeness(i, &rivals)),
        });
        let rank = |c: &Change| (c.resolves(), c.separation[1]);
        changes.filter(|c| c.separation[1] > c.separation[0]).max_by(|a, b| {
            let (a, b) = (rank(a), rank(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    }

    /// The set that shows an effect best, from whatever it is like.
    pub fn best_detection(&self, effect: &str) -> Option<Change> {
        self.best_separation(effect, &[])
    }
}

/// Information of a ride's samples on effects, on its best model.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn known(samples: &Samples, best: &Base, effects: &[Effect]) -> Information {
    let best = quiet(samples, best);
    Curvature::of(samples, &best, &best.values, &parameters(effects)).information(BASE)
}

fn parameters(effects: &[Effect]) -> Vec<Parameter> {
    BASE.iter().copied().chain(effects.iter().map(Effect::parameter)).collect()
}

/// Parameters that differ between sessions: the rider's lean, and the sensors' zeros.
fn of_a_session() -> Vec<Parameter> {
    let zeros = BASE.iter().filter(|p| p.name.ends_with("_zero")).copied();
    let own = |e: &&Effect| e.level == Level::Session || e.name == "rider_lean";
    zeros.chain(ALL.iter().filter(own).map(Effect::parameter)).collect()
}

/// A model with its noise. Misfit of an identified cause in the nominal model's residuals is not noise.
fn quiet(samples: &Samples, best: &Base) -> Base {
    let sigma = base::noise(samples, &blocks(samples, &best.values));
    Base { sigma, ..best.clone() }
}

/// Phases on the model, as samples, `later` s into the ride.
fn simulated_set(
    name: &str,
    phases: Vec<Phase>,
    session: &Session,
    values: &Parameters,
    bike: &Bike,
    pipeline: &Pipeline,
    later: f64,
) -> Samples {
    let plant = replay::plant(values);
    let (calm, random) = (Disturbance::default(), Random::new(0, name));
    let simulated =
        simulate::simulate_phases(&plant, &phases, calm, random, LOGGED, LONGEST, Meta::default());
    let mut ride = simulated.session;
    plant.model_error.measure(&mut ride);
    let lacking: Vec<_> = ride.channels().filter(|c| !session.has(*c)).collect();
    for channel in lacking {
        ride.remove(channel);
    }
    let (segments, _) = pipeline::segmented(&mut ride.clone(), bike, pipeline);
    let mut samples = Samples::gather(&ride, &segments);
    samples.time.iter_mut().for_each(|t| *t += later);
    samples
}
