//! The road's side of the diagnosis engine: block residuals of the nominal model, fault-free simulations by the
//! reduced simulator, scores to first order, joint fits.

use std::sync::Arc;

use rayon::prelude::*;

use super::base::{Base, PLAUSIBLE_GAIN, Start};
use super::kept::Key;
use super::left_out::LeftOut;
use super::null_calibration::{RoadCalibration, SizeScale, cells};
use super::null_simulation::NullSimulation;
use super::parameters::{BASE, Parameter};
use super::problem::Linear;
use super::residuals::{Blocks, CHANNELS, UNITS, blocks};
use super::samples::BLOCK;
use super::scan::Score;
use super::stage::{DiagnosisCache, Ride, Stage, true_sizes};
use super::structure::Term;
use crate::contract::verdict::Verdict;
use crate::diagnose::calibration::{Calibration, Rms};
use crate::diagnose::cause::{
    Cause, Estimate, Identification, Judged, Objection, Refusal, Refusals, Structure,
};
use crate::diagnose::engine::{
    CellResiduals, Confirmed, Engine, IdentificationRules, JointFits, Refit, Unexplained, in_cells,
};
use crate::simulate::effects::Effect;
use crate::store::tables::rows::DiscrepancyRow;

/// Least size of an identified cause in standard errors: its 95 % interval does not contain nil.
const EVIDENT: f64 = 1.96;

/// A ride on the road with its base fit and its fault-free simulations.
#[derive(Debug)]
pub(crate) struct RoadEngine<'r, 'a> {
    ride: Ride<'r>,
    memory: &'r DiagnosisCache<'a>,
    start: &'r Start,
    calibration: &'r RoadCalibration,
    simulation: &'r Arc<NullSimulation<'a>>,
    scores: Vec<Score>,
}

impl<'r, 'a> RoadEngine<'r, 'a> {
    /// `calibration` is that of the ride's candidates on `simulation`, near the start; `memory` holds what
    /// is known of the ride already.
    pub(crate) fn new(
        ride: Ride<'r>,
        memory: &'r DiagnosisCache<'a>,
        start: &'r Start,
        calibration: &'r RoadCalibration,
        simulation: &'r Arc<NullSimulation<'a>>,
    ) -> Self {
        let scores = memory.scan(&ride, &start.near, ride.effects).to_vec();
        RoadEngine { ride, memory, start, calibration, simulation, scores }
    }

    fn is_identifiable(&self, judged: &Judged) -> bool {
        self.calibration.is_identifiable(judged.candidate.place)
    }

    fn alarms(&self, judged: &Judged) -> bool {
        judged.score > self.ride.tuning.alarm || judged.makes_plausible && judged.score > 1.0
    }

    /// Whether structure contradicts the causes, or exists without a cause.
    fn objects(&self, structure: Option<(Term, f64)>, named: &[Cause]) -> bool {
        let bar = if named.is_empty() { 1.0 } else { self.ride.tuning.contradicts };
        structure.is_some_and(|(_, times)| times > bar)
    }

    /// Takes the causes out that structure objects to: a weak one that shows where the structure is takes up
    /// part of something else. Structure in channels that a cause does not touch says nothing against it.
    fn contradicted(
        &self,
        stage: &Stage<'a>,
        term: Term,
        linear: &Linear,
        named: &mut Vec<Cause>,
    ) -> Vec<Cause> {
        let tuning = self.ride.tuning;
        let problem = stage.model.problem(self.ride.samples);
        let contradicted = |cause: &mut Cause| {
            let name = cause.candidate.name;
            let place = stage.model.parameters.iter().position(|p| p.name == name);
            let touches =
                |k: usize| problem.share(&linear.columns[k], term.channel) > tuning.touches;
            cause.score < tuning.strong && place.is_some_and(touches)
        };
        let out = named.extract_if(.., contradicted);
        out.map(|c| c.rejected(Objection::Contradicted)).collect()
    }

    /// The identified causes with the sizes that fault-free simulations of the model with them give back, and those of
    /// which they give none within the bounds. While causes are lost the rest is fitted and simulated anew;
    /// so it is first where `stage` has causes that a later step withdrew.
    fn reproduced(
        &self,
        stage: &mut Stage<'a>,
        mut named: Vec<Cause>,
        mut complete: bool,
    ) -> (Vec<Cause>, Vec<Cause>) {
        let ride = &self.ride;
        let mut lost = Vec::new();
        while !named.is_empty() {
            if !complete {
                let more: Vec<_> = named.iter().map(|c| c.candidate).collect();
                let kept = self.memory.extended(ride, &self.start.near, &more, None);
                let first = self.nominal_stage();
                *stage = Stage::next(ride, self.memory, &kept, Vec::new(), &first, &named);
            }
            let fits = &stage.calibration.scale.fits;
            let sizes = true_sizes(ride, &stage.model, &stage.simulated, fits, &named);
            let is = |(cause, size): &(Cause, Estimate)| {
                size.value.abs() >= EVIDENT * size.std_error
                    && cause.candidate.in_bounds(size.value)
            };
            let sized: Vec<(Cause, Estimate)> = named.into_iter().zip(sizes).collect();
            complete = sized.iter().all(is);
            if complete {
                let with = |(cause, size)| Cause { estimate: Some(size), ..cause };
                return (sized.into_iter().map(with).collect(), lost);
            }
            let (kept, without): (Vec<_>, Vec<_>) = sized.into_iter().partition(is);
            lost.extend(without.into_iter().map(|(c, _)| c.rejected(Objection::NotReproduced)));
            named = kept.into_iter().map(|(cause, _)| cause).collect();
        }
        (named, lost)
    }

    /// Result if all causes were withdrawn: they come before the other candidates, which are judged on the nominal model,
    /// and the nominal model is the result's model.
    #[must_use]
    pub(crate) fn withdrawn(
        &self,
        identification: Identification<Base>,
        objection: Objection,
    ) -> Identification<Base> {
        let mut stage = self.nominal_stage();
        let judged = self.judge(&stage);
        stage.model = self.start.base.clone();
        let structure = stage.structure(self.ride.samples).0;
        let out = |c: Cause| if c.verdict.is_cause() { c.rejected(objection) } else { c };
        let mut causes: Vec<Cause> =
            identification.causes.into_iter().map(out).filter(|c| c.objection.is_some()).collect();
        let (at_first, alarm) = (identification.refused_at_first, self.ride.tuning.alarm);
        let rest = self.rest(&judged, &causes).into_iter();
        let mut rest: Vec<Cause> = rest.map(|c| c.refused(&at_first, alarm)).collect();
        rest.sort_by(|a, b| b.score.total_cmp(&a.score));
        causes.extend(rest);
        Identification {
            causes,
            extended: stage.model,
            alarm: identification.alarm,
            structure: structure.map(described),
            unexplained: self.objects(structure, &[]),
            refused_at_first: at_first,
        }
    }

    /// The candidates that are neither identified nor rejected.
    fn rest(&self, judged: &[Judged], rejected: &[Cause]) -> Vec<Cause> {
        let is_open = |j: &&Judged| {
            let same = |c: &Cause| c.candidate.place == j.candidate.place;
            self.is_identifiable(j) && !rejected.iter().any(same)
        };
        let open = judged.iter().filter(is_open).map(|j| j.cause(Verdict::NotNeeded));
        let first = self.judge(&self.nominal_stage());
        let hidden = first.iter().filter(|j| !self.is_identifiable(j));
        open.chain(hidden.map(|j| j.cause(Verdict::NotIdentifiable))).collect()
    }

    fn by_cell(&self, found: &Blocks) -> CellResiduals {
        in_cells(cells(self.ride.samples, found))
    }
}

fn described((term, times): (Term, f64)) -> Structure {
    Structure { description: term.description(), times }
}

impl<'a> Engine for RoadEngine<'_, 'a> {
    type Model = Base;
    type Stage = Stage<'a>;
    type Scale = SizeScale;

    fn rules(&self) -> IdentificationRules {
        let t = self.ride.tuning;
        IdentificationRules { alarm: t.alarm, equivalent: t.equivalent, independent: None }
    }

    /// Extensions are looked for from near the base ([`Base::starting_point`]).
    fn nominal_stage(&self) -> Stage<'a> {
        let near = &self.start.near;
        Stage {
            model: near.clone(),
            simulation: self.simulation.clone(),
            noise_of: Key::of(&"the start"),
            simulated: near.values.clone(),
            open: (0..self.ride.effects.len()).collect(),
            scores: self.scores.clone(),
            calibration: self.calibration.clone(),
            strain_gains: self.start.gains.clone(),
        }
    }

    fn judge(&self, stage: &Stage<'a>) -> Vec<Judged> {
        stage.judge(&self.ride)
    }

    fn refits(&self, stage: &Stage<'a>, judged: &[Judged], _: &[Cause]) -> JointFits<Base> {
        let (ride, tuning) = (&self.ride, self.ride.tuning);
        let mut gated: Vec<&Judged> = judged
            .iter()
            .filter(|j| j.score > tuning.alarm || self.is_identifiable(j) && j.makes_plausible)
            .collect();
        let mut refused: Refusals =
            gated.iter().map(|j| (j.candidate.name, Refusal::NotFitted)).collect();
        // those that can be identified first
        gated.sort_by(|a, b| self.alarms(b).cmp(&self.alarms(a)).then(b.gain.total_cmp(&a.gain)));
        gated.truncate(tuning.refitted);
        let least = tuning.far * gated.first().map_or(0.0, |j| j.gain);
        gated.retain(|j| j.gain > least);
        if gated.is_empty() {
            return JointFits { refits: Vec::new(), refused };
        }
        refused.retain(|name, _| gated.iter().all(|j| j.candidate.name != *name));
        let more: Vec<Parameter> = gated.iter().map(|j| ride.parameter(&j.candidate)).collect();
        let (slopes, own) =
            (stage.model.linear_with(ride.samples, &more), stage.model.parameters.len());
        let sized: Vec<(f64, Refit<Base>)> = gated
            .into_par_iter()
            .enumerate()
            .map(|(k, j)| {
                let slopes = Some(slopes.with(own, own + k));
                let model = self.memory.extended(ride, &stage.model, &[j.candidate], slopes);
                let gain = 2.0 * (stage.model.loss - model.loss);
                let size = ride.size(&j.candidate, &model);
                let std_error = j.estimate.map_or(f64::INFINITY, |e| e.std_error);
                let estimate = Some(Estimate::linear(size - j.bias, std_error));
                (size, Refit { judged: j.clone(), estimate, gain, model: Base::clone(&model) })
            })
            .collect();
        let (within, beyond): (Vec<_>, Vec<_>) =
            sized.into_iter().partition(|(size, refit)| refit.judged.candidate.in_bounds(*size));
        let implausible = |(size, refit): (f64, Refit<Base>)| {
            (refit.judged.candidate.name, Refusal::Implausible(size))
        };
        refused.extend(beyond.into_iter().map(implausible));
        let mut refits: Vec<Refit<Base>> = within.into_iter().map(|(_, refit)| refit).collect();
        refits.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        JointFits { refits, refused }
    }

    fn refuses(&self, stage: &Stage<'a>, refit: &Refit<Base>, _: &[Cause]) -> Option<Refusal> {
        let tuning = self.ride.tuning;
        let further = stage.model.parameters.len() > BASE.len();
        let least = match refit.judged.score {
            score if score <= tuning.alarm => PLAUSIBLE_GAIN,
            _ if further => tuning.further_gain,
            _ => tuning.gain,
        };
        if !self.alarms(&refit.judged) {
            return Some(Refusal::NoAlarm(tuning.alarm));
        }
        let enough = refit.gain > least;
        (!enough).then_some(Refusal::LittleGain { gain: refit.gain, needed: least })
    }

    fn add_cause(&self, stage: Stage<'a>, refit: Refit<Base>, named: &[Cause]) -> Stage<'a> {
        let mut open = stage.open.clone();
        let joined = refit.judged.candidate.place;
        open.retain(|&place| self.calibration.is_identifiable(place) && place != joined);
        Stage::next(&self.ride, self.memory, &refit.model, open, &stage, named)
    }

    /// Further structure is compared with fault-free simulations on the model with the causes: what a large cause
    /// leaves of itself it leaves there too.
    fn confirm(
        &self,
        mut stage: Stage<'a>,
        mut judged: Vec<Judged>,
        mut named: Vec<Cause>,
    ) -> Confirmed<Base> {
        let samples = self.ride.samples;
        if named.is_empty() {
            stage.model = self.start.base.clone();
        }
        let (mut structure, linear) = stage.structure(samples);
        let mut unexplained = self.objects(structure, &named);
        let mut rejected = match structure {
            Some((term, _)) if unexplained => self.contradicted(&stage, term, &linear, &mut named),
            _ => Vec::new(),
        };
        let (named, lost) = self.reproduced(&mut stage, named, rejected.is_empty());
        if named.is_empty() && !(rejected.is_empty() && lost.is_empty()) {
            stage = self.nominal_stage();
            judged = self.judge(&stage);
            stage.model = self.start.base.clone();
        }
        // what they took up is left now
        if !lost.is_empty() && !unexplained {
            structure = stage.structure(samples).0;
            unexplained = self.objects(structure, &named);
        }
        rejected.extend(lost);
        let rest = self.rest(&judged, &rejected);
        let structure = structure.map(described);
        Confirmed { named, rejected, rest, extended: stage.model, structure, unexplained }
    }

    fn channels(&self) -> Vec<(&'static str, &'static str)> {
        CHANNELS.into_iter().zip(UNITS).collect()
    }

    fn base_residuals(&self) -> CellResiduals {
        self.by_cell(&blocks(self.ride.samples, &self.start.base.values))
    }

    fn extended_residuals(&self, identification: &Identification<Base>) -> CellResiduals {
        self.by_cell(&blocks(self.ride.samples, &identification.extended.values))
    }

    fn noise_factors(&self, before: &Rms) -> Vec<f64> {
        let ratio = |(cell, (size, _)): (&_, &(f64, usize))| {
            let largest = self.calibration.noise_rms.get(cell).map_or(0.0, |f| f[1]);
            size / largest.max(f64::MIN_POSITIVE)
        };
        (0..CHANNELS.len())
            .map(|c| {
                let mut ratios: Vec<f64> =
                    before.iter().filter(|((_, own), _)| *own == c).map(ratio).collect();
                ratios.sort_by(f64::total_cmp);
                ratios.get(ratios.len() / 2).map_or(1.0, |r| r.max(1.0))
            })
            .collect()
    }

    fn fewest_blocks(&self) -> usize {
        0
    }

    fn covariates(&self) -> (Vec<(&'static str, Vec<f64>)>, bool) {
        let s = self.ride.samples;
        let mean = |x: &[f64]| -> Vec<f64> {
            let at = |b: usize| x[b * BLOCK..(b + 1) * BLOCK].iter().sum::<f64>() / BLOCK as f64;
            (0..s.blocks()).map(at).collect()
        };
        let all = [
            ("speed", &s.v),
            ("acceleration", &s.vd),
            ("roll", &s.roll),
            ("roll rate", &s.rolld),
            ("yaw rate", &s.yaw_rate),
            ("steering", &s.steer),
            ("front pressure", &s.pressure[0]),
            ("rear pressure", &s.pressure[1]),
            ("heading", &s.along),
            ("time", &s.time),
        ];
        (all.into_iter().map(|(name, x)| (name, mean(x))).collect(), false)
    }

    fn calibration(&self) -> &Calibration<SizeScale> {
        self.calibration
    }

    fn held_out_gains(&self, identification: &Identification<Base>) -> [f64; 2] {
        let (samples, base) = (self.ride.samples, &self.start.base);
        let before = LeftOut::new(base, samples).loss();
        // by the base's own scale: the extended model knows less noise
        let extended = Base { sigma: base.sigma, ..identification.extended.clone() };
        let known = &extended.parameters;
        let others: Vec<_> = self
            .ride
            .effects
            .iter()
            .map(Effect::parameter)
            .filter(|p| known.iter().all(|k| k.name != p.name))
            .collect();
        // the fit with the identified causes is near
        let everything = extended.extended(samples, &others, 2);
        [&extended, &everything].map(|model| 2.0 * (before - LeftOut::new(model, samples).loss()))
    }

    fn unexplained(
        &self,
        identification: &Identification<Base>,
        _: &[DiscrepancyRow],
    ) -> Option<Unexplained> {
        let Structure { description, times } =
            identification.structure.as_ref().filter(|_| identification.unexplained)?;
        Some(Unexplained {
            score: *times,
            parameter: "structure",
            reason: format!(
                "{description} is not explained, {times:.1} times what 19 of 20 fault-free simulations stay below"
            ),
            first: true,
        })
    }
}
