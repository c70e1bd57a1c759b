//! One session from its log to its causes.

use std::borrow::Cow;
use std::path::Path;

use super::advice::Advice;
use super::base::{self, Base};
use super::dive;
use super::extended_model::extended_model;
use super::name::{self, Naming, Objection};
use super::null_calibration::{Calibration, SEEN, correlation, rms};
use super::null_simulation::Rides;
use super::parameters::Parameters;
use super::residuals::{CHANNELS, UNITS, blocks};
use super::samples::{BLOCK, Samples};
use super::show;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::verdict::{UNEXPLAINED, Verdict};
use crate::effects::extended_model::ExtendedModel;
use crate::effects::{self, Effect};
use crate::ingest;
use crate::ingest::map::ChannelMap;
use crate::model::formulation::Formulation;
use crate::pipeline::{self, Characterised, Pipeline, Rejection};
use crate::segment::Segment;
use crate::statistics::smooth::{gradient, smooth};
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident, SimulatedSample};

/// Fewest blocks that are worth a diagnosis: half a minute of manoeuvres.
const FEWEST: usize = 100;
/// Folds of held-out manoeuvres.
const FOLDS: usize = 5;
/// How much more than every null, and than its channel elsewhere, a structured residual is.
const MORE: f64 = 1.25;

/// How a diagnosis is done.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Simulated nulls, from which the thresholds come.
    pub nulls: usize,
    /// Candidate causes.
    pub effects: Vec<Effect>,
    /// Whether riding is also simulated for what the ride says nothing of, not only for what it cannot
    /// tell apart.
    pub advise: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings { nulls: 24, effects: effects::ALL.to_vec(), advise: false }
    }
}

/// What a session says.
#[derive(Debug, Clone)]
pub struct Diagnosis {
    /// Who and when.
    pub ident: Ident,
    /// Candidates, judged.
    pub naming: Naming,
    /// The base that they extend.
    pub base: Base,
    /// What nulls show.
    pub calibration: Calibration,
    /// What more riding would show, where it was asked.
    pub advice: Option<Advice>,
    /// Rows of `causes`.
    pub causes: Vec<CauseRow>,
    /// Rows of `discrepancies`.
    pub discrepancies: Vec<DiscrepancyRow>,
    /// Rows of `replays`.
    pub replays: Vec<SimulatedSample>,
    /// The extended model.
    pub model: ExtendedModel,
    /// Where it was ridden.
    pub site: Option<String>,
    /// What was looked at.
    pub samples: Samples,
}

impl Diagnosis {
    /// Whether its sizes may be pooled with those of other sessions.
    pub fn is_poolable(&self) -> bool {
        let sound = self.naming.named() || self.naming.alarm <= name::ALARM;
        sound && !self.naming.unexplained
    }

    /// Held-out gain, in twice the loss, of the base with some effects free: with the true ones of a
    /// simulated ride it is what a perfect diagnosis would gain.
    pub fn gain_of(&self, effects: &[Effect]) -> f64 {
        let more: Vec<_> = effects.iter().map(Effect::parameter).collect();
        // a base that was dragged astray has no way back to a large effect: from what was named, too
        let mut elsewhere = self.naming.extended.world.clone();
        for p in &self.naming.extended.parameters[self.base.parameters.len()..] {
            p.set(&mut elsewhere, p.get(&self.base.start));
        }
        let from = |world: Parameters| {
            Base { world, ..self.base.clone() }.extended(&self.samples, &more, 6)
        };
        let [here, there] = [self.base.world.clone(), elsewhere].map(from);
        let extended = if there.loss < here.loss { there } else { here };
        2.0 * (self.base.held_out(&self.samples, FOLDS) - extended.held_out(&self.samples, FOLDS))
    }
}

/// Diagnoses a log.
///
/// # Errors
/// The log cannot be used, or does not hold what a diagnosis needs.
pub fn log(
    path: &Path,
    maps: &[ChannelMap],
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare(path, maps, bike, pipeline)?;
    diagnose(&session, bike, pipeline, settings)
}

/// Diagnoses a log that is in memory already.
///
/// # Errors
/// As [`log`].
pub fn raw(
    raw: ingest::Raw,
    bike: &Bike,
    pipeline: &Pipeline,
    settings: &Settings,
) -> Result<Diagnosis, Rejection> {
    let (session, _) = pipeline::prepare_raw(raw, bike, pipeline)?;
    diagnose(&session, bike, pipeline, settings)
}

/// A session as far as its base fit.
#[derive(Debug, Clone)]
pub struct Fitted<'a> {
    /// Clean, unfiltered, with an acceleration.
    pub session: Cow<'a, Session>,
    /// Its manoeuvres.
    pub segments: Vec<Segment>,
    /// What is looked at of them.
    pub samples: Samples,
    /// The base model.
    pub base: Base,
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
    let refuse = |code, message| Rejection { stage: "diagnose", code, message };
    let wheels = [Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    if !session.has(Channel::VelocityX) || !wheels.iter().any(|c| session.has(*c)) {
        let message = "a diagnosis needs velocity_x and wheel_speed_front or wheel_speed_rear";
        return Err(refuse("missing_column", message.to_owned()));
    }
    let session = match session.has(Channel::AccelerationX) {
        true => Cow::Borrowed(session),
        false => Cow::Owned(accelerated(session)),
    };
    let unfiltered = session.as_ref().clone();
    let Characterised { segments, solution, .. } =
        pipeline::characterise(unfiltered, bike, pipeline, Formulation::Corrected);
    // the estimate above knows of dive, the base model does not
    let session = dive::level(&session, bike).map_or(session, Cow::Owned);
    let samples = Samples::gather(&session, &segments);
    if samples.blocks() < FEWEST {
        let message = format!(
            "only {:.0} s of used manoeuvres: {:.0} s are the least for a diagnosis",
            samples.len() as f64 / super::samples::RATE,
            (FEWEST * BLOCK) as f64 / super::samples::RATE
        );
        return Err(refuse("too_few_manoeuvres", message));
    }
    let base = base::fit(&samples, &Parameters::new(bike, &solution));
    Ok(Fitted { session, segments, samples, base })
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
) -> Result<Diagnosis, Rejection> {
    let Fitted { session, segments, samples, base } = fitted(session, bike, pipeline)?;
    let session = session.as_ref();
    let start = base.believable(&samples, &settings.effects);
    let ident = Ident::from(&session.meta);
    // a session's nulls depend on the session alone
    let hash = blake3::hash(ident.session_id.as_bytes());
    let seed = hash.as_bytes().iter().take(4).fold(0, |seed, b| seed << 8 | u64::from(*b));
    let rides = Rides::new(session, &segments, bike, &start.noise, seed).on(&start.near.world);
    let calibration = Calibration::new(&rides, &start.near, &settings.effects, settings.nulls);
    let naming = name::name(&samples, &start, &settings.effects, &calibration, &rides);
    let base = start.base;
    let open = |c: &name::Cause| match c.verdict {
        Verdict::Ambiguous => true,
        Verdict::NotIdentifiable => settings.advise,
        _ => false,
    };
    let advice = naming.causes.iter().any(open).then(|| {
        Advice::new(session, &samples, &naming.extended, &settings.effects, bike, pipeline)
    });
    let mut causes = cause_rows(&samples, &base, &naming, &calibration, &settings.effects, &ident);
    if let Some(advice) = &advice {
        advise(&mut causes, &naming, &calibration, advice, settings.advise);
    }
    let discrepancies = discrepancy_rows(&samples, &base, &naming, &calibration, &ident);
    let replays = show::replays(session, &rides, &base.world, &naming, &ident);
    let model = extended_model(&naming, &ident);
    let site = session.meta.site.clone();
    Ok(Diagnosis {
        ident,
        naming,
        base,
        calibration,
        advice,
        causes,
        discrepancies,
        replays,
        model,
        site,
        samples,
    })
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

fn cause_rows(
    samples: &Samples,
    base: &Base,
    naming: &Naming,
    calibration: &Calibration,
    effects: &[Effect],
    ident: &Ident,
) -> Vec<CauseRow> {
    let is_named = |v: Verdict| matches!(v, Verdict::Named | Verdict::Ambiguous);
    let any = naming.causes.first().is_some_and(|c| is_named(c.verdict));
    let (mut gain, mut bound) = (None, None);
    if any {
        let before = base.held_out(samples, FOLDS);
        // by the base's own scale: the extended model knows less noise
        let extended = Base { sigma: base.sigma, ..naming.extended.clone() };
        gain = Some(2.0 * (before - extended.held_out(samples, FOLDS)));
        let known = &extended.parameters;
        let others: Vec<_> = effects
            .iter()
            .map(Effect::parameter)
            .filter(|p| known.iter().all(|k| k.name != p.name))
            .collect();
        // from where the named ones are it is not far
        let everything = extended.extended(samples, &others, 2);
        bound = Some(2.0 * (before - everything.held_out(samples, FOLDS)));
    }
    let own = unexplained(naming, ident);
    let first = 1 + i64::from(own.is_some());
    let rows = naming.causes.iter().enumerate().map(|(k, c)| {
        let over = calibration.tops.iter().filter(|t| **t >= c.score).count();
        let half = 1.96 * c.std_error;
        // what it is hard to tell from in general is no finding of this ride
        let rivals = match c.verdict {
            Verdict::Ambiguous => c.equivalent.join(", "),
            _ => String::new(),
        };
        CauseRow {
            ident: ident.clone(),
            rank: k as i64 + first,
            effect: c.effect.name.to_owned(),
            verdict: c.verdict.name().to_owned(),
            level: "session".to_owned(),
            pooled_over: None,
            parameter: c.effect.name.to_owned(),
            value: Some(c.value),
            unit: c.effect.unit.to_owned(),
            ci95_low: Some(c.value - half),
            ci95_high: Some(c.value + half),
            score: c.score,
            false_alarm_rate: over as f64 / calibration.nulls as f64,
            gain_heldout: gain.filter(|_| k == 0),
            gain_upper_bound: bound.filter(|_| k == 0),
            equivalent_to: (!rivals.is_empty()).then_some(rivals),
            separate_by: Some(c.effect.separate_by.to_owned()),
            reason: reason(c),
        }
    });
    own.into_iter().chain(rows).collect()
}

/// Puts computed riding in the place of the library's words, where simulated riding helps.
fn advise(
    causes: &mut [CauseRow],
    naming: &Naming,
    calibration: &Calibration,
    advice: &Advice,
    unseen: bool,
) {
    for row in causes {
        let Some(cause) = naming.causes.iter().find(|c| c.effect.name == row.effect) else {
            continue;
        };
        let words = cause.effect.separate_by;
        match cause.verdict {
            Verdict::Ambiguous => {
                let Some(change) = advice.apart(cause.effect.name, &cause.equivalent) else {
                    continue;
                };
                let separate_by = match change.resolves() {
                    true => change.words(),
                    false => format!("{words}; {}, which is not enough", change.words()),
                };
                row.reason = row.reason.replace(words, &separate_by);
                row.separate_by = Some(separate_by);
            }
            Verdict::NotIdentifiable if unseen => {
                let place = advice.place(cause.effect.name);
                let (Some(j), Some(change)) = (place, advice.shown(cause.effect.name)) else {
                    continue;
                };
                // nulls know of more than noise; what more riding gains is the same share of it
                let limit = calibration.limit(j);
                let lowered = limit * change.separation[0] / change.separation[1];
                if lowered < SEEN {
                    row.separate_by = Some(change.set.to_owned());
                    row.reason = format!(
                        "the ride says nothing of it below {limit:.1} usual sizes; {} would lower that \
                         to {lowered:.1}",
                        change.set
                    );
                }
            }
            _ => {}
        }
    }
}

/// The row of what no candidate explains.
fn unexplained(naming: &Naming, ident: &Ident) -> Option<CauseRow> {
    let (term, times) = naming.left.filter(|_| naming.unexplained)?;
    Some(CauseRow {
        ident: ident.clone(),
        rank: 1,
        effect: UNEXPLAINED.to_owned(),
        verdict: Verdict::Unexplained.name().to_owned(),
        level: "session".to_owned(),
        parameter: "structure".to_owned(),
        unit: "1".to_owned(),
        score: times,
        reason: format!(
            "{} has structure, {times:.1} times what 19 of 20 nulls stay below",
            term.describe()
        ),
        ..CauseRow::default()
    })
}

fn reason(c: &name::Cause) -> String {
    match c.objection {
        Some(Objection::Contradicted) => {
            return format!(
                "takes up part of the misfit (gains {:.0}) but leaves more structure where it shows than a cause may",
                c.gain
            );
        }
        Some(Objection::NotReproduced) => {
            return format!(
                "takes up part of the misfit (gains {:.0}), but rides on the model with it do not give its size back",
                c.gain
            );
        }
        None => {}
    }
    match c.verdict {
        Verdict::Named => format!("{}: gains {:.0}", c.effect.sentence, c.gain),
        Verdict::Ambiguous => format!(
            "{}, or one of {}: the ride cannot tell them apart; what would: {}",
            c.effect.sentence,
            c.equivalent.join(", "),
            c.effect.separate_by
        ),
        Verdict::NotNeeded if c.score > 1.0 => {
            "beyond the nulls, but explained by what is named, too large to be, or gains too little"
                .to_owned()
        }
        Verdict::NotNeeded | Verdict::Unexplained => {
            "within what nulls of this ride show".to_owned()
        }
        Verdict::NotIdentifiable => {
            format!("the ride says nothing of it; what would: {}", c.effect.separate_by)
        }
    }
}

fn discrepancy_rows(
    samples: &Samples,
    base: &Base,
    naming: &Naming,
    calibration: &Calibration,
    ident: &Ident,
) -> Vec<DiscrepancyRow> {
    let found = blocks(samples, &base.world);
    let before = rms(samples, &found);
    let named = naming
        .causes
        .first()
        .is_some_and(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous));
    let after = named.then(|| rms(samples, &blocks(samples, &naming.extended.world)));
    let floor_of = |kind, c| calibration.floor.get(&(kind, c)).copied().unwrap_or([0.0; 2]);
    // a channel that is noisier than its nulls in every kind of manoeuvre is noisy, not wrong
    let usual: Vec<f64> = (0..CHANNELS.len())
        .map(|c| {
            let mut ratios: Vec<f64> = before
                .iter()
                .filter(|((_, own), _)| *own == c)
                .map(|((kind, _), (size, _))| size / floor_of(*kind, c)[1].max(f64::MIN_POSITIVE))
                .collect();
            ratios.sort_by(f64::total_cmp);
            ratios.get(ratios.len() / 2).map_or(1.0, |r| r.max(1.0))
        })
        .collect();
    before
        .iter()
        .map(|(&(kind, c), &(size, n))| {
            let own: Vec<(usize, f64)> = samples
                .manoeuvres
                .iter()
                .filter(|(k, _)| *k == kind)
                .flat_map(|(_, r)| r.start / BLOCK..r.end / BLOCK)
                .map(|b| (b, found[c][b]))
                .filter(|(_, r)| r.is_finite())
                .collect();
            let bias = own.iter().map(|(_, r)| r).sum::<f64>() / own.len() as f64;
            let [floor, largest] = floor_of(kind, c);
            // nothing is known of what no null could ride
            let structured = largest > 0.0 && size > MORE * usual[c] * largest;
            let covariate = structured.then(|| covariate(samples, &own)).flatten();
            DiscrepancyRow {
                ident: ident.clone(),
                channel: CHANNELS[c].to_owned(),
                kind: kind.name().to_owned(),
                unit: UNITS[c].to_owned(),
                rmse_base: size,
                rmse_extended: after.as_ref().and_then(|a| a.get(&(kind, c))).map(|(s, _)| *s),
                bias,
                noise_floor: floor,
                null_largest: largest,
                structured,
                covariate: covariate.map(|(name, _)| name.to_owned()),
                correlation: covariate.map(|(_, r)| r),
                n: n as i64,
            }
        })
        .collect()
}

/// What a residual goes with most.
fn covariate(samples: &Samples, own: &[(usize, f64)]) -> Option<(&'static str, f64)> {
    let at = |x: &[f64], b: usize| x[b * BLOCK..(b + 1) * BLOCK].iter().sum::<f64>() / BLOCK as f64;
    let with = |x: &[f64]| correlation(own.iter().map(|(b, r)| (at(x, *b), *r)));
    [
        ("speed", &samples.v),
        ("acceleration", &samples.vd),
        ("roll", &samples.roll),
        ("roll rate", &samples.rolld),
        ("yaw rate", &samples.yaw_rate),
        ("steering", &samples.steer),
        ("front pressure", &samples.pressure[0]),
        ("rear pressure", &samples.pressure[1]),
        ("heading", &samples.along),
        ("time", &samples.time),
    ]
    .into_iter()
    .map(|(name, x)| (name, with(x)))
    .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}
