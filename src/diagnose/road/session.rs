//! One session of road riding from its log to its causes.

use std::borrow::Cow;
use std::sync::Arc;

use super::advice::{self, Advice};
use super::base::{self, Base, Start};
use super::dive;
use super::engine::RoadEngine;
use super::estimates::{self, Nominal};
use super::extended_model::extended_model;
use super::left_out::LeftOut;
use super::null_calibration::{RoadCalibration, calibrate};
use super::null_simulation::NullSimulation;
use super::parameters::Parameters;
use super::replays::Replays;
use super::samples::{BLOCK, RATE, Samples};
use super::scan::{Score, scan};
use super::simulation_errors::simulation_errors;
use super::stage::{DiagnosisCache, Ride};
use crate::contract::bike::{Axle, Bike};
use crate::contract::channel::Channel;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Session;
use crate::contract::verdict::Verdict;
use crate::diagnose::cause::{Cause, Identification, Objection};
use crate::diagnose::engine::identify_causes;
use crate::diagnose::settings::Settings;
use crate::diagnose::tables;
use crate::diagnose::tuning::RoadTuning;
use crate::fit::transients::join::join;
use crate::ingest::maps::ChannelMap;
use crate::pipeline::{self, Characterised, Pipeline, Rejection, characterise_once};
use crate::simulate::effects::extended_model::ExtendedModel;
use crate::simulate::effects::{ALL, Effect};
use crate::statistics::smooth::{gradient, smooth};
use crate::store::objects::Location;
use crate::store::tables::rows::{
    CauseRow, Circumstances, DiscrepancyRow, EffectTrace, EstimateRow, Ident, SimulatedSample,
    SimulationError,
};
use crate::tyre::formulation::Formulation;

/// Name of the effect that characterising a ride corrects as well.
const LATENCY: &str = "latency";
/// Fewest blocks that are worth a diagnosis: half a minute of manoeuvres.
const MIN_BLOCKS: usize = 100;
/// Rise of the simulation's errors as a whole, in logarithms, from which the causes are withdrawn. Without the
/// noise in it right names of 12 rides of `examples/gains` change them by -1.2 to -0.01 and one by +0.12, wrong
/// ones of 6 by +0.07 to +0.29.
const WORSE: f64 = 0.02;

/// The diagnosis of a road session with everything that it was made from.
#[derive(Debug, Clone)]
pub struct RoadDiagnosis {
    /// Session, bike and start.
    pub ident: Ident,
    /// Candidates with their verdicts.
    pub identification: Identification<Base>,
    /// The base that they extend.
    pub base: Base,
    /// Calibration by fault-free simulations.
    pub calibration: RoadCalibration,
    /// Recommended riding, if it was requested.
    pub advice: Option<Advice>,
    /// Rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `discrepancies`.
    pub discrepancies: Vec<DiscrepancyRow>,
    /// Rows of `replays`.
    pub replays: Vec<SimulatedSample>,
    /// Rows of `simulation_errors`.
    pub simulation_errors: Vec<SimulationError>,
    /// Rows of `estimates`.
    pub estimates: Vec<EstimateRow>,
    /// Rows of `effect_traces`.
    pub effect_traces: Vec<EffectTrace>,
    pub model: ExtendedModel,
    /// Where, by whom and on what tyres it was ridden.
    pub circumstances: Circumstances,
    /// Samples on the session's common clock.
    pub n_samples: i64,
    /// The samples that the residuals are made of.
    pub samples: Samples,
}

impl RoadDiagnosis {
    /// Whether its sizes are pooled with those of other sessions with their own errors: nothing stays
    /// unexplained, nor an alarm without a name.
    pub fn is_poolable(&self) -> bool {
        let sound = self.identification.any_identified()
            || self.identification.alarm <= RoadTuning::default().alarm;
        sound && !self.identification.unexplained
    }

    /// Held-out gain, in twice the loss, of the base with some effects free: with the true ones of a
    /// simulated ride it is what a perfect diagnosis would gain.
    pub fn gain_of(&self, effects: &[Effect]) -> f64 {
        let more: Vec<_> = effects.iter().map(Effect::parameter).collect();
        // a base that was dragged astray has no way back to a large effect: from the causes, too
        let mut elsewhere = self.identification.extended.values.clone();
        for p in &self.identification.extended.parameters[self.base.parameters.len()..] {
            p.set(&mut elsewhere, p.get(&self.base.start));
        }
        let from = |values: Parameters| {
            Base { values, ..self.base.clone() }.extended(&self.samples, &more, 6)
        };
        let [here, there] = [self.base.values.clone(), elsewhere].map(from);
        let extended = if there.loss < here.loss { there } else { here };
        let [before, after] =
            [&self.base, &extended].map(|m| LeftOut::new(m, &self.samples).loss());
        2.0 * (before - after)
    }
}

/// Diagnoses a log.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn log(
    log: impl Into<Location>,
    maps: &[ChannelMap],
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<RoadDiagnosis, Rejection> {
    let (session, _) = pipeline::prepare(log, maps, bike, pipeline)?;
    diagnose(&session, bike, pipeline, settings)
}

/// A session as far as its base fit.
#[derive(Debug)]
pub struct Fitted<'a> {
    /// Clean, unfiltered, with an acceleration.
    pub session: Cow<'a, Session>,
    /// Its manoeuvres, and the values of its coefficients without the errors of upstream quantities.
    pub ridden: Characterised,
    /// The samples in use.
    pub samples: Samples,
    pub base: Base,
    /// The nominal model with the side force ratios that the ride's changes of lean give, in place of the bike file's.
    /// Comparisons of rides use [`base`](Fitted::base): a ratio of each ride's own would scatter from ride to ride.
    pub leaning: Option<Base>,
    /// Latency of the velocity that characterising the ride finds and corrects, s; nil where it finds none. The base
    /// does not know of it.
    pub latency: f64,
}

/// Fits the base to a clean, unfiltered session.
///
/// # Errors
/// It does not hold what a diagnosis needs.
pub fn fitted<'a>(
    session: &'a Session,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Fitted<'a>, Rejection> {
    let refuse = |code, message| Rejection { stage: Stage::Diagnose, code, message, limits: None };
    let wheels = [Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    if !session.has(Channel::VelocityX) || !wheels.iter().any(|c| session.has(*c)) {
        let message = "a diagnosis needs velocity_x and wheel_speed_front or wheel_speed_rear";
        return Err(refuse(RejectionCode::MissingColumn, message.to_owned()));
    }
    let session = match session.has(Channel::AccelerationX) {
        true => Cow::Borrowed(session),
        false => Cow::Owned(accelerated(session)),
    };
    let unfiltered = session.as_ref().clone();
    let ridden = characterise_once(unfiltered, bike, pipeline, Formulation::Corrected);
    let Characterised { segments, solution, .. } = &ridden;
    // the estimate above knows of dive, the nominal model does not
    let session = match ridden.session.get(Channel::Grade) {
        Some(grade) => Cow::Owned(on_the_road(session.into_owned(), grade)),
        None => session,
    };
    let session = dive::level(&session, bike).map_or(session, Cow::Owned);
    let samples = Samples::gather(&session, segments);
    if samples.blocks() < MIN_BLOCKS {
        let message = format!(
            "only {:.0} s of used manoeuvres: {:.0} s are the least for a diagnosis",
            samples.len() as f64 / RATE,
            (MIN_BLOCKS * BLOCK) as f64 / RATE
        );
        return Err(refuse(RejectionCode::TooFewManoeuvres, message));
    }
    let base = base::fit(&samples, &Parameters::new(bike, solution));
    let latency = ridden.latency;
    Ok(Fitted { session, ridden, samples, base, leaning: None, latency })
}

impl Fitted<'_> {
    /// With the side force ratios of the ride's changes of lean, where it has enough of them.
    #[must_use]
    pub fn with_changing_lean(mut self, bike: &Bike, pipeline: &Pipeline) -> Self {
        if !pipeline.transients.enabled {
            return self;
        }
        let Some(fit) = self.ridden.transients(&pipeline.transients) else { return self };
        let mut solution = self.ridden.solution.clone();
        if join(&mut solution, &fit.fitted) {
            let ratio = |bike: Bike, axle: Axle| {
                let ratio = solution.inputs.bike.wheel(axle).side_force_ratio;
                bike.with(&format!("{}.side_force_ratio", axle.name()), ratio)
            };
            let bike = Axle::BOTH.into_iter().fold(bike.clone(), ratio);
            self.leaning = Some(base::fit(&self.samples, &Parameters::new(&bike, &solution)));
        }
        self
    }
}

/// A fitted session with its fault-free simulations: all that the identification needs but its constants.
#[derive(Debug)]
pub struct Prepared<'a> {
    fitted: &'a Fitted<'a>,
    effects: &'a [Effect],
    start: Start,
    simulation: Arc<NullSimulation<'a>>,
    calibration: RoadCalibration,
    memory: DiagnosisCache<'a>,
}

impl<'a> Prepared<'a> {
    /// Simulates the session and scores the candidates on its fault-free simulations.
    pub fn new(fitted: &'a Fitted<'a>, settings: &'a Settings) -> Self {
        let Fitted { session, ridden, samples, base, leaning, .. } = fitted;
        let segments = &ridden.segments;
        let effects = &settings.effects;
        let start = leaning.as_ref().unwrap_or(base).clone().starting_point(samples, effects);
        let seed = seed(&session.meta.session_id);
        let simulation = NullSimulation::new(session, segments, &start.noise, seed)
            .with_parameters(&start.near.values);
        let calibration = calibrate(&simulation, &start.near, effects, settings.nulls);
        let (simulation, memory) = (Arc::new(simulation), DiagnosisCache::default());
        Prepared { fitted, effects, start, simulation, calibration, memory }
    }

    /// With the intermediate results of one identification kept for the next, so that many with different constants take little
    /// longer than one. A simulated ride is as large as the session, and there are a few for every cause.
    #[must_use]
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub fn keeping(self) -> Self {
        Prepared { memory: DiagnosisCache::keeping(), ..self }
    }

    fn engine<'b>(&'b self, tuning: &'b RoadTuning) -> RoadEngine<'b, 'a> {
        let ride = Ride { samples: &self.fitted.samples, effects: self.effects, tuning };
        RoadEngine::new(ride, &self.memory, &self.start, &self.calibration, &self.simulation)
    }

    /// Scale of the candidates' scores.
    pub fn calibration(&self) -> &RoadCalibration {
        &self.calibration
    }

    /// Sizes of all candidates to first order.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for studies
    pub fn scores(&self) -> Vec<Score> {
        scan(&self.fitted.samples, &self.start.near, self.effects)
    }

    /// The causes under some constants.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub fn identification(&self, tuning: &RoadTuning) -> Identification<Base> {
        identify_causes(&self.engine(tuning))
    }
}

/// Diagnoses a clean, unfiltered session.
///
/// # Errors
/// It does not hold what a diagnosis needs.
pub fn diagnose(
    session: &Session,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<RoadDiagnosis, Rejection> {
    let fitted = fitted(session, bike, pipeline)?.with_changing_lean(bike, pipeline);
    let prepared = Prepared::new(&fitted, settings);
    let tuning = RoadTuning::default();
    let engine = prepared.engine(&tuning);
    let logged = session;
    let (session, samples, effects) = (&fitted.session, &fitted.samples, &settings.effects);
    let ident = Ident::from(&session.meta);
    let simulation = &prepared.simulation;
    let seed = seed(&session.meta.session_id);
    let simulated = |identification: &Identification<Base>| {
        let replays =
            Replays::new(session, samples, simulation, &prepared.start.base, identification);
        let right = simulation.with_parameters(&identification.extended.values);
        let errors = simulation_errors(&replays, &right, seed, &ident);
        (replays, errors)
    };
    let mut identification = identify_causes(&engine);
    let (mut replays, mut simulation_errors) = simulated(&identification);
    if worsens(&simulation_errors) {
        identification = engine.withdrawn(identification, Objection::WorseSimulation);
        (replays, simulation_errors) = simulated(&identification);
    }
    let open = |c: &Cause| match c.verdict {
        Verdict::Ambiguous => true,
        Verdict::NotIdentifiable => settings.advise,
        _ => false,
    };
    let advice =
        identification.causes.iter().any(open).then(|| {
            Advice::new(session, samples, &identification.extended, effects, bike, pipeline)
        });
    let discrepancies = tables::discrepancies(&engine, &identification, &ident);
    let mut causes = tables::causes(&engine, &identification, &discrepancies, &ident);
    corrected_already(&mut causes, fitted.latency);
    if let Some(advice) = &advice {
        let calibration = &prepared.calibration;
        advice::amend(&mut causes, &identification, calibration, advice, settings.advise);
    }
    // where the acceleration was measured, the base fit has characterised the session as it was logged
    let measured = logged.has(Channel::AccelerationX).then_some(&fitted.ridden);
    let replays = replays.rows(session.rate, simulation, &ident);
    let model = extended_model(&identification, &ident, (logged, measured), bike, pipeline);
    let circumstances = Circumstances::from(&session.meta);
    let Prepared { start, calibration, .. } = prepared;
    let nominal = match &fitted.leaning {
        // comparisons are of the bike file's ratios
        Some(_) => Nominal::alone(&fitted.base.clone().starting_point(samples, ALL).base),
        None => {
            let identified = identification.named();
            let identified = identified.map(|cause| (cause.candidate.name, cause.value()));
            Nominal::beside(&start.base, &identification.extended, identified, ALL)
        }
    };
    let (estimates, effect_traces) = estimates::estimates(samples, &nominal, ALL, &ident);
    Ok(RoadDiagnosis {
        ident,
        identification,
        base: start.base,
        calibration,
        advice,
        causes,
        discrepancies,
        replays,
        simulation_errors,
        estimates,
        effect_traces,
        model,
        circumstances,
        n_samples: session.len as i64,
        samples: fitted.samples.clone(),
    })
}

/// A road session as far as a comparison with the motorcycle's other rides needs it.
#[derive(Debug, Clone)]
pub struct Estimated {
    /// Session, bike and start.
    pub ident: Ident,
    /// Where, by whom and on what tyres it was ridden.
    pub circumstances: Circumstances,
    /// Samples on the session's common clock.
    pub n_samples: i64,
    /// Rows of `estimates`.
    pub estimates: Vec<EstimateRow>,
    /// Rows of `effect_traces`.
    pub effect_traces: Vec<EffectTrace>,
}

/// Estimates all numbers of a clean, unfiltered session, without fault-free simulations.
///
/// # Errors
/// As [`diagnose`].
pub(crate) fn estimated(
    session: &Session,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Estimated, Rejection> {
    let Fitted { session: used, samples, base, .. } = fitted(session, bike, pipeline)?;
    let ident = Ident::from(&used.meta);
    let start = base.starting_point(&samples, ALL);
    let nominal = Nominal::alone(&start.base);
    let (estimates, effect_traces) = estimates::estimates(&samples, &nominal, ALL, &ident);
    let (circumstances, n_samples) = (Circumstances::from(&session.meta), session.len as i64);
    Ok(Estimated { ident, circumstances, n_samples, estimates, effect_traces })
}

/// Says of a latency that is found here what `run` does about it.
fn corrected_already(causes: &mut [CauseRow], latency: f64) {
    let is_latency = |row: &&mut CauseRow| {
        let is_cause = Verdict::from_name(&row.verdict).is_some_and(Verdict::is_cause);
        row.effect == LATENCY && is_cause
    };
    for row in causes.iter_mut().filter(is_latency) {
        let known = match latency {
            0.0 => "`run` finds none to correct".to_owned(),
            late => format!(
                "`run` finds {:.1} ms and corrects them, so its coefficients are free of it",
                1e3 * late
            ),
        };
        row.reason = format!("{}; {known}", row.reason);
    }
}

/// Whether the causes are withdrawn: the simulation of manoeuvres left out gets worse with them as a whole, or in more
/// signals than it gets better in.
fn worsens(errors: &[SimulationError]) -> bool {
    let count = |is: fn(&SimulationError) -> bool| errors.iter().filter(|e| is(e)).count();
    SimulationError::change_of_all(errors).is_some_and(|c| c > WORSE)
        || count(SimulationError::is_worse) > count(SimulationError::is_better)
}

/// Seed of a session's fault-free simulations, which so depend on the session alone.
pub(super) fn seed(session_id: &str) -> u64 {
    let hash = blake3::hash(session_id.as_bytes());
    hash.as_bytes().iter().take(4).fold(0, |seed, b| seed << 8 | u64::from(*b))
}

/// A session with the grade of its road, whose pitch is that of the frame against the road.
fn on_the_road(mut session: Session, grade: &[f64]) -> Session {
    if let Some(pitch) = session.get_mut(Channel::Pitch) {
        pitch.iter_mut().zip(grade).for_each(|(pitch, grade)| *pitch += grade.atan());
    }
    session.set(Channel::Grade, grade.to_vec());
    session
}

/// A session with the acceleration that its velocity has; nothing is learnt from comparing the two.
fn accelerated(session: &Session) -> Session {
    let mut session = session.clone();
    let column = |c: Channel| session.get(c).map(|x| smooth(x, session.rate));
    if let Some(v) = column(Channel::VelocityX) {
        let mut along = gradient(&v, session.rate);
        if let (Some(r), Some(vy)) = (column(Channel::YawRate), column(Channel::VelocityY)) {
            along.iter_mut().zip(r.iter().zip(&vy)).for_each(|(a, (r, vy))| *a -= r * vy);
        }
        session.set(Channel::AccelerationX, along);
    }
    session
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(before: f64, after: f64) -> SimulationError {
        let ratio = after / before;
        SimulationError {
            rmse_base: before,
            rmse_extended: Some(after),
            noise_floor: 1.0,
            ratio: Some(ratio),
            ratio_ci95_low: Some(0.98 * ratio),
            ratio_ci95_high: Some(1.02 * ratio),
            n: 10,
            ..SimulationError::default()
        }
    }

    #[test]
    fn a_latency_says_that_run_corrects_it() {
        let row = |verdict: Verdict| CauseRow {
            effect: LATENCY.into(),
            verdict: verdict.name().into(),
            reason: "it is late".into(),
            ..CauseRow::default()
        };
        let mut rows = [row(Verdict::Named), row(Verdict::NotNeeded)];
        corrected_already(&mut rows, 0.0194);
        assert!(rows[0].reason.contains("`run` finds 19.4 ms and corrects"), "{}", rows[0].reason);
        assert_eq!(rows[1].reason, "it is late");
        let mut rows = [row(Verdict::Named)];
        corrected_already(&mut rows, 0.0);
        assert!(rows[0].reason.contains("finds none"), "{}", rows[0].reason);
    }

    /// Two signals much better, three a little worse: as a whole it is better, and yet no cause.
    #[test]
    fn what_makes_more_signals_worse_than_better_is_taken_back() {
        let better = [row(9.0, 3.0), row(8.0, 3.0)];
        let worse = [row(2.0, 2.3), row(3.0, 3.3), row(2.5, 2.8)];
        let rows: Vec<SimulationError> = better.into_iter().chain(worse).collect();
        assert!(SimulationError::change_of_all(&rows).is_some_and(|c| c < WORSE));
        assert!(worsens(&rows));
        assert!(!worsens(&rows[..4]), "as many worse as better");
        assert!(!worsens(&[row(2.0, 2.001)]) && !worsens(&[]));
        // squares beyond the noise: 81 - 1 and 64 - 1 before, twice 9 - 1 after
        let explained = SimulationError::explained(&rows[..2]).expect("something was wrong");
        assert!((explained - (1.0 - 16.0 / 143.0)).abs() < 1e-12, "{explained}");
    }
}
