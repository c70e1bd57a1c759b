//! What was measured beside what the simulator makes of it, before and after: rows of `replays`.
//!
//! Every manoeuvre is simulated on models that were fitted without it.

use crate::contract::schema;
use rayon::prelude::*;

use super::base::Base;
use super::left_out::{LeftOut, SizedCause};
use super::null_simulation::NullSimulation;
use super::samples::Samples;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::diagnose::cause::Identification;
use crate::diagnose::held_out::FOLDS;
use crate::statistics::smooth::smooth;
use crate::store::tables::rows::{Ident, SimulatedSample};

/// Channels in the table.
pub(crate) const SHOWN: [Channel; 9] = [
    Channel::VelocityX,
    Channel::VelocityY,
    Channel::AccelerationX,
    Channel::AccelerationY,
    Channel::YawRate,
    Channel::Roll,
    Channel::SteerAngle,
    Channel::WheelSpeedFront,
    Channel::WheelSpeedRear,
];

/// `[channel][manoeuvre][sample]`: smoothed signals where they are looked at; empty without the channel.
pub(crate) type ChannelSamples = [Vec<Vec<f64>>; 9];

/// The signals of a session at the looked-at samples of the manoeuvres that are wanted; of others none.
pub(crate) fn shown(
    session: &Session,
    simulation: &NullSimulation<'_>,
    of: impl Fn(usize) -> bool,
) -> ChannelSamples {
    SHOWN.map(|channel| {
        let Some(x) = session.get(channel) else { return Vec::new() };
        let x = smooth(x, session.rate);
        let own = |(m, (_, at)): (usize, &(_, Vec<usize>))| match of(m) {
            true => at.iter().map(|&i| x[i]).collect(),
            false => Vec::new(),
        };
        simulation.picks().iter().enumerate().map(own).collect()
    })
}

/// Every looked-at manoeuvre simulated from its own start on a model fitted without it, with the effects that
/// were found.
pub(crate) fn simulated(
    samples: &Samples,
    simulation: &NullSimulation<'_>,
    model: &Base,
    found: &[SizedCause],
) -> ChannelSamples {
    let left_out = LeftOut::new(model, samples);
    let folds: Vec<ChannelSamples> = (0..FOLDS)
        .into_par_iter()
        .map(|fold| {
            let own = |m: usize| left_out.fold_of.get(m) == Some(&fold);
            let session = simulation.noiseless_of(&left_out.without(fold, found), own);
            shown(&session, simulation, own)
        })
        .collect();
    // each manoeuvre from the fold that left it out
    std::array::from_fn(|c| {
        let own = |(m, fold): (usize, &usize)| folds[*fold][c].get(m).cloned().unwrap_or_default();
        left_out.fold_of.iter().enumerate().map(own).collect()
    })
}

/// Measured and simulated signals.
#[derive(Debug)]
pub(crate) struct Replays {
    pub measured: ChannelSamples,
    /// On the nominal model.
    pub base: ChannelSamples,
    /// On the extended model; `None` without causes.
    pub extended: Option<ChannelSamples>,
}

impl Replays {
    /// Simulates all manoeuvres.
    pub(crate) fn new(
        session: &Session,
        samples: &Samples,
        simulation: &NullSimulation<'_>,
        base: &Base,
        identification: &Identification<Base>,
    ) -> Self {
        let of = |model: &Base, found: &[_]| simulated(samples, simulation, model, found);
        let start = &identification.extended.start;
        // a fit gives a share of a size; what was found of it is simulated
        let found: Vec<SizedCause> = identification
            .named()
            .filter_map(|cause| {
                let name = cause.candidate.name;
                let parameter =
                    *identification.extended.parameters.iter().find(|p| p.name == name)?;
                let fitted = parameter.get(&identification.extended.values) - parameter.get(start);
                let interval = cause.estimate?.interval()?;
                let share = cause.value() / fitted;
                share.is_finite().then_some(SizedCause { parameter, share, interval })
            })
            .collect();
        // by the base's own scale: the extended model knows less noise
        let extended = || Base { sigma: base.sigma, ..identification.extended.clone() };
        Replays {
            measured: shown(session, simulation, |_| true),
            base: of(base, &[]),
            extended: identification.any_identified().then(|| of(&extended(), &found)),
        }
    }

    pub(crate) fn rows(
        &self,
        rate: f64,
        simulation: &NullSimulation<'_>,
        ident: &Ident,
    ) -> Vec<SimulatedSample> {
        let definition = schema::session();
        let known = |x: &f64| Some(*x).filter(|x| x.is_finite());
        let mut rows = Vec::new();
        for (c, channel) in
            SHOWN.into_iter().enumerate().filter(|(c, _)| !self.measured[*c].is_empty())
        {
            let unit = definition.column(channel.name()).and_then(|c| c.unit.clone());
            for (m, (kind, picks)) in simulation.picks().iter().enumerate() {
                let at = |x: &ChannelSamples, k: usize| {
                    x[c].get(m).and_then(|x| x.get(k)).and_then(known)
                };
                rows.extend(picks.iter().enumerate().map(|(k, &i)| SimulatedSample {
                    ident: ident.clone(),
                    replay_id: m as i64 + 1,
                    kind: kind.name().to_owned(),
                    channel: channel.name().to_owned(),
                    unit: unit.clone().unwrap_or_default(),
                    time: i as f64 / rate,
                    measured: at(&self.measured, k),
                    base: at(&self.base, k),
                    extended: self.extended.as_ref().and_then(|x| at(x, k)),
                }));
            }
        }
        rows
    }
}
