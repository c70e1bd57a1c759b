//! The tables of a road session.

use std::ops::Range;

use arrow::array::RecordBatch;

use super::outcome::{Input, Outcome, Rejection, table};
use super::rows::{manoeuvres, name_machine, provenance, session, warnings};
use super::settings::Pipeline;
use super::stages::{Characterised, characterise};
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::coefficient;
use crate::contract::reason::{Reason, ReasonCode};
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate;
use crate::fit::in_gear::InGear;
use crate::fit::in_gear::by_lap::{self, ByLap};
use crate::fit::in_gear::parameters::{DRAG, LATENCY, LEAN_ZERO};
use crate::fit::outlying::{self, Fitted};
use crate::fit::{
    Data, Solution, by_course, coefficients, contradicted, cornering, evidence, in_gear, measured,
    missing, transients, wheel_scale,
};
use crate::report::export::parameters;
use crate::report::plots;
use crate::segment::laps::RideEstimates;
use crate::segment::laps::find::Kind;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::segment::{Segment, laps};
use crate::store::tables::rows::{Ident, LapRow};
use crate::tyre::formulation::Formulation;

/// From a prepared session to its tables.
///
/// # Errors
/// The signals do not fit their table: our own mistake.
pub(super) fn run(
    input: &Input<'_>,
    mut ride: Session,
    mut noticed: Vec<Warning>,
    bike: &Bike,
    pipeline: &Pipeline,
) -> Result<Outcome, Rejection> {
    let mut known = None;
    if let Some(models) = &pipeline.models {
        let mut extended = bike.clone();
        noticed.extend(models.apply(&mut ride, &mut extended));
        known = Some(extended);
    }
    let bike = known.as_ref().unwrap_or(bike);
    let is_grade_logged = ride.has(Channel::Grade);
    let mut ridden = characterise(ride, bike, pipeline, pipeline.estimate.formulation);
    let mut leant = Vec::new();
    // a diagnosis' model has its own side force ratios
    if pipeline.transients.enabled
        && pipeline.models.is_none()
        && pipeline.estimate.formulation == Formulation::Corrected
        && let Some(found) = ridden.transients(&pipeline.transients)
        && transients::join::join(&mut ridden.solution, &found.fitted)
    {
        leant = changing_lean(&ridden.session, &found.stretches);
    }
    let Characterised { session: mut ride, segments, data, solution, warnings: more, .. } = ridden;
    noticed.extend(more);

    let ident = Ident::from(&ride.meta);
    let provenance = provenance(input);
    let reason = |id| missing_channels(&ride, id);
    // the bike file with the side force ratio that was ridden
    let shod = &solution.inputs.bike;
    let mut coefficients =
        coefficients::rows(&solution, shod, &pipeline.fit, &reason, &ident, &provenance);
    let mut radius = radii(bike, &solution);
    let zeros = &solution.inputs.zeros;
    let [mut roll_zero, mut latency] = [zeros.roll, data.zeros.latency];
    let mut drag = solution.inputs.drag;
    let ridden_in_gear = pipeline.in_gear.enabled
        && pipeline.estimate.formulation == Formulation::Corrected
        && in_gear::rows::lacking(&coefficients);
    let whole = match ridden_in_gear {
        true => in_gear::run(&ride, bike, &pipeline.in_gear),
        false => None,
    };
    if ridden_in_gear && whole.is_none() {
        in_gear::rows::doubt(&mut coefficients);
    }
    if let Some(fit) = &whole {
        let widest = pipeline.fit.max_relative_interval;
        in_gear::rows::fill(&mut coefficients, fit, widest, &ident, &provenance);
        radius = fit.radii();
        [roll_zero, latency, drag] = [LEAN_ZERO, LATENCY, DRAG].map(|k| fit.fitted.theta[k]);
    }
    by_course::widen(&mut coefficients, &ride);
    wheel_scale::widen(&mut coefficients, ride.wheel_scale_sd);
    contradicted::object(&mut coefficients, &ride);
    name_machine(&mut coefficients, &ride, bike);
    let evidence = evidence::rows(&solution, shod, &coefficients, &ride.meta);
    let known =
        RideEstimates { bike, coefficients: &coefficients, radius, drag, roll_zero, latency };
    let (mut laps, of_markers) = laps::run(&ride, &known, &ident, &pipeline.laps);
    noticed.extend(of_markers);
    if let Some(found) = over_laps(&ride, bike, pipeline, whole, &laps.laps) {
        (laps.coefficients, laps.trends) = in_gear::lap_rows::rows(&found, &ident);
    }
    // after the others, which keep their numbers: they overlap them
    let listed: Vec<Segment> = segments.iter().cloned().chain(leant).collect();
    let manoeuvres = manoeuvres(&ride, &listed, radius, &ident);
    let signals = match input.signals {
        true => Some(signals(&ride, &data, &solution)?),
        false => None,
    };
    let compared = measured::compared(&data, &solution);
    let plots =
        plots::road::rows(&ride, &segments, &data, &solution, &coefficients, &laps, &compared);
    noticed.extend(measured::warnings(&compared));
    let fitted = Fitted { session: &ride, segments: &segments, data: &data, solution: &solution };
    let outlying = outlying::find(&fitted);
    noticed.extend(outlying::rows::warnings(&fitted, &outlying));
    let outlying = outlying::rows::rows(&fitted, &outlying, &ident);
    let warnings = warnings(&ident, noticed);
    if !is_grade_logged {
        // what the altitude gave is no channel of the log
        ride.remove(Channel::Grade);
    }
    let session = session(&ride, input, bike, &manoeuvres, &coefficients, &warnings, provenance);
    let tyres = parameters::rows(&session, &coefficients, &manoeuvres, &plots, bike);
    let mut other_tables = Vec::new();
    if !outlying.is_empty() {
        other_tables.push(table(&outlying).map_err(|e| Rejection::unwritable(&e))?);
    }
    if !tyres.is_empty() {
        other_tables.push(table(&tyres).map_err(|e| Rejection::unwritable(&e))?);
    }
    let costs = missing::costs_of_rows(&solution, &coefficients);
    Ok(Outcome {
        session,
        manoeuvres,
        coefficients,
        evidence,
        warnings,
        laps,
        plots,
        signals,
        costs: costs.iter().map(ToString::to_string).collect(),
        other_tables,
        ..Outcome::default()
    })
}

/// Tyres lap by lap, where there are laps enough: about the fit of the ride in gear, which is made for it where nothing
/// else needed it.
fn over_laps(
    ride: &Session,
    bike: &Bike,
    pipeline: &Pipeline,
    whole: Option<InGear>,
    laps: &[LapRow],
) -> Option<Vec<ByLap>> {
    let timed = laps.iter().filter(|l| l.kind == Kind::Timed.name());
    let timed: Vec<(i64, f64, f64)> =
        timed.map(|l| (l.lap, l.start, l.start + l.duration)).collect();
    let corrected = pipeline.estimate.formulation == Formulation::Corrected;
    if timed.len() < by_lap::MIN_LAPS || !pipeline.in_gear.enabled || !corrected {
        return None;
    }
    let fit = whole.or_else(|| in_gear::run(ride, bike, &pipeline.in_gear))?;
    Some(by_lap::run(ride, bike, &pipeline.in_gear, &fit, &timed))
}

/// Range of lean of a stretch of the best quality, rad: 20 degrees to either side.
const WIDE: f64 = 0.7;

/// The stretches of changing lean that the stiffnesses came from. The corners within them keep their own rows and fits.
fn changing_lean(session: &Session, stretches: &[Range<usize>]) -> Vec<Segment> {
    let roll = session.get(Channel::Roll).unwrap_or_default();
    let segment = |at: &Range<usize>| {
        let leans = || roll[at.clone()].iter().copied();
        let range =
            leans().fold(f64::NEG_INFINITY, f64::max) - leans().fold(f64::INFINITY, f64::min);
        Segment {
            kind: ManoeuvreKind::ChangingLean,
            start: at.start,
            end: at.end,
            direction: None,
            quality: (range / WIDE).clamp(0.0, 1.0),
            used: true,
            reason: None,
        }
    };
    stretches.iter().map(segment).collect()
}

/// Why the channels do not allow a coefficient, if they do not.
fn missing_channels(session: &Session, id: coefficient::Id) -> Option<Reason> {
    let missing = id.requirement().missing(session);
    let names: Vec<&str> = missing.into_iter().map(Channel::name).collect();
    if names.is_empty() {
        return None;
    }
    if names == [Channel::Gear.name()] {
        let words = match session.has(Channel::Gear) {
            true => "the gear never changes between neutral and engaged",
            false => {
                "the log has no channel gear, nor throttle, both wheels and acceleration instead"
            }
        };
        return Some(Reason::new(ReasonCode::UnknownCoasting, words));
    }
    let plural = if names.len() == 1 { "channel" } else { "channels" };
    let words = format!("the log has no {plural} {}", names.join(", "));
    Some(Reason::new(ReasonCode::MissingChannel, words))
}

/// Rolling radii, front and rear: estimated where they were, else the bike file's.
fn radii(bike: &Bike, solution: &Solution) -> [f64; 2] {
    let nominal = [bike.front.radius, bike.rear.radius];
    [0, 1].map(|k| {
        let known = solution.inputs.radius[k];
        if known.is_finite() { known } else { nominal[k] }
    })
}

fn signals(session: &Session, data: &Data, solution: &Solution) -> Result<RecordBatch, Rejection> {
    let inputs = &solution.inputs;
    let straight = [0, 1].map(|k| inputs.straight(&data.straight[k], &data.action[k]));
    let front_k_x = solution.fits.overturning.as_ref().map(|f| f.theta[cornering::K_X]);
    let corner = inputs.corner(&data.corner, data.corner_rate, front_k_x);
    let sets = [
        (&data.straight[0], &straight[0]),
        (&data.straight[1], &straight[1]),
        (&data.corner, &corner),
    ];
    estimate::table::batch(&session.meta, &sets).map_err(|e| Rejection {
        stage: Stage::Estimate,
        code: RejectionCode::InternalError,
        message: e.to_string(),
        limits: None,
    })
}
