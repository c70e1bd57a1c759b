//! The stages in their order, each order once: what tables, diagnosis, advice and replay are made from.
//!
//! ```text
//! prepare        read -> run -> check                                        one clean session
//! segmented      filter -> grade -> segment                                  its manoeuvres
//! characterise   segmented -> sensor zeros -> gather -> solve                the tyres
//! offroad_forces filter -> inverse dynamics -> segment                       tyre forces, off-road
//! ```

use super::outcome::{Input, Rejection};
use super::settings::Pipeline;
use crate::contract::bike::{Bike, DEFAULT};
use crate::contract::channel::Channel;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate::offroad::{self, Estimate};
use crate::estimate::zeros::{self, Zeros};
use crate::estimate::{grade, turn};
use crate::fit::cornering::K_X;
use crate::fit::solution::Upstream;
use crate::fit::transients::{self, Transients};
use crate::fit::{Data, Solution, chain};
use crate::ingest::maps::ChannelMap;
use crate::segment::Segment;
use crate::segment::offroad::Ride;
use crate::store::objects::Location;
use crate::tyre::formulation::Formulation;
use crate::{filter, ingest, segment};

/// The log of an input.
///
/// # Errors
/// It cannot be read.
pub(crate) fn read(input: &Input<'_>) -> Result<ingest::Raw, Rejection> {
    ingest::read(&input.log, input.maps).map_err(Rejection::from)
}

/// A log as a clean session on one clock, checked against its bike, unfiltered.
///
/// # Errors
/// The log cannot be read, or lacks what every session needs.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn prepare(
    log: impl Into<Location>,
    maps: &[ChannelMap],
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<(Session, Vec<Warning>), Rejection> {
    prepare_raw(ingest::read(log, maps).map_err(Rejection::from)?, bike, pipeline)
}

/// The same of a log that is in memory. Off-road a session without velocity has nothing that could be
/// checked.
///
/// # Errors
/// As [`prepare`].
pub(crate) fn prepare_raw(
    raw: ingest::Raw,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<(Session, Vec<Warning>), Rejection> {
    let (mut session, mut warnings) =
        ingest::run(raw, &pipeline.ingest).map_err(Rejection::from)?;
    warnings.extend(default_bike(bike));
    warnings.extend(removed_keys(bike));
    if pipeline.offroad.is_none() || session.has(Channel::VelocityX) {
        warnings.extend(
            ingest::check(&mut session, Some(bike), &pipeline.ingest).map_err(Rejection::from)?,
        );
    }
    Ok((session, warnings))
}

/// Says that a session was read with a bike file that is not its motorcycle's.
fn default_bike(bike: &Bike) -> Option<Warning> {
    bike.stands_in.then(|| Warning {
        stage: "ingest",
        code: "default_bike",
        channel: None,
        count: 1,
        time: None,
        message: format!(
            "there is no bike file for `{id}`: {DEFAULT}.toml stands in, and its uncertainties widen the intervals; \
             `roadbench bike new {id}` writes one",
            id = bike.bike_id
        ),
    })
}

/// Says which keys of the bike file nothing reads any more.
fn removed_keys(bike: &Bike) -> Option<Warning> {
    let keys = &bike.removed_keys;
    (!keys.is_empty()).then(|| Warning {
        stage: "ingest",
        code: "removed_key",
        channel: None,
        count: keys.len(),
        time: None,
        message: format!("bike file `{}`: {}", bike.bike_id, keys.join("; ")),
    })
}

/// Filters a session in place and finds its manoeuvres.
pub(crate) fn segmented(
    session: &mut Session,
    bike: &Bike,
    pipeline: &Pipeline,
) -> (Vec<Segment>, Vec<Warning>) {
    let warnings = filter::run(session, &pipeline.filter);
    let grade = if pipeline.estimate.grade { grade::grade(session) } else { None };
    if let Some(grade) = grade {
        session.set(Channel::Grade, grade.value);
    }
    (segment::run(session, bike, &pipeline.segment), warnings)
}

/// A session with the tyres that it gives.
#[derive(Debug)]
pub struct Characterised {
    pub session: Session,
    pub segments: Vec<Segment>,
    /// The signals that the fits are made of.
    pub data: Data,
    pub solution: Solution,
    /// Warnings of the stages.
    pub warnings: Vec<Warning>,
    /// Latency of the velocities, s, which the signals have no more.
    pub latency: f64,
}

/// From a prepared session to its tyres.
pub fn characterise(
    session: Session,
    bike: &Bike,
    pipeline: &Pipeline,
    formulation: Formulation,
) -> Characterised {
    let mut ridden = characterise_once(session, bike, pipeline, formulation);
    ridden.solution.upstream = ridden.upstream(bike, pipeline);
    ridden
}

impl Characterised {
    /// Quantities that move the coefficients besides their own manoeuvres; `bike` and `pipeline` as it was characterised with.
    pub fn upstream(&self, bike: &Bike, pipeline: &Pipeline) -> Vec<Upstream> {
        chain::upstream(&self.solution, &self.data, bike, &pipeline.fit)
    }

    /// The fit to the changes of lean; `None` where there is none.
    pub fn transients(&self, config: &transients::Config) -> Option<Transients> {
        let Solution { inputs, fits, .. } = &self.solution;
        let crown = fits.overturning.as_ref().map(|f| f.theta[K_X]);
        let zeros = Zeros { latency: self.latency, ..inputs.zeros };
        transients::run(&self.session, inputs, &zeros, crown, config)
    }
}

/// [`characterise`] without the errors of upstream quantities: for where values are all that is needed.
pub(crate) fn characterise_once(
    mut session: Session,
    bike: &Bike,
    pipeline: &Pipeline,
    formulation: Formulation,
) -> Characterised {
    let (segments, mut warnings) = segmented(&mut session, bike, pipeline);
    // for the estimate alone: what was not measured is nothing to compare a simulation with
    let derived = match formulation {
        Formulation::Corrected => turn::yaw_rate(&session),
        Formulation::Paper => None,
    };
    let is_derived = derived.is_some();
    if let Some(rate) = derived {
        session.set(Channel::YawRate, rate);
    }
    let (zeros, noticed) = match formulation {
        Formulation::Corrected => zeros::run(&session, bike),
        Formulation::Paper => (Zeros::default(), Vec::new()), // the paper takes sensors as they are
    };
    warnings.extend(noticed);
    // an accelerometer whose zero nothing shows would be a slope: the change of speed has none
    let unknown = formulation == Formulation::Corrected && !zeros.acceleration_known;
    let acceleration = if unknown { session.remove(Channel::AccelerationX) } else { None };
    let data = Data::gather(&session, &segments, bike, zeros, &pipeline.estimate);
    if let Some(measured) = acceleration {
        session.set(Channel::AccelerationX, measured);
    }
    if is_derived {
        session.remove(Channel::YawRate);
    }
    let solution = chain::solve_once(&data, bike, formulation, &pipeline.fit);
    Characterised { session, segments, data, solution, warnings, latency: zeros.latency }
}

/// An off-road session with its tyre forces.
#[derive(Debug)]
pub(crate) struct OffroadForces {
    pub session: Session,
    /// The forces by inverse dynamics.
    pub estimate: Estimate,
    /// Manoeuvres, which are found in the forces under the first rider.
    pub segments: Vec<Segment>,
    /// Warnings of the stages.
    pub warnings: Vec<Warning>,
}

/// From a prepared session to its tyre forces: off-road the forces come before the segments, which are
/// found in them.
///
/// # Errors
/// The bike file lacks what the equations need.
pub(crate) fn offroad_forces(
    mut session: Session,
    bike: &Bike,
    pipeline: &Pipeline,
    config: &offroad::Config,
) -> Result<OffroadForces, Rejection> {
    let mut warnings = filter::run(&mut session, &pipeline.filter);
    let (estimate, noticed) = offroad::run(&session, bike, config).map_err(|e| Rejection {
        stage: Stage::Estimate,
        code: RejectionCode::BadBikeFile,
        message: e.to_string(),
        limits: None,
    })?;
    warnings.extend(noticed);
    let tyres = &estimate.riders[0].tyres;
    let kinematics = &estimate.kinematics;
    let ride = Ride {
        rate: session.rate,
        speed: &kinematics.xd,
        acceleration: &kinematics.xdd,
        pitch: &kinematics.mu,
        airborne: &estimate.contact.airborne,
        braking: [&tyres.b_f, &tyres.b_r],
        load: &tyres.n_r,
        yaw_rate: session.get(Channel::YawRate),
    };
    let segments = segment::offroad::run(&ride, &pipeline.segment.offroad);
    Ok(OffroadForces { session, estimate, segments, warnings })
}
