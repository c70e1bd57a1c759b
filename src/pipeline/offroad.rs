//! The off-road order of the stages: the forces come before the segments, which are found in them.
//!
//! ```text
//! filter -> estimate (inverse dynamics) -> segment -> statistics
//! ```

use super::{Input, Outcome, Pipeline, Rejection, manoeuvres, row, session_row};
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate::offroad::{self, Config};
use crate::segment::offroad::Ride;
use crate::tables::rows;
use crate::{filter, ingest, plots, segment};

/// From a session on one clock to its tables.
pub fn run(
    input: &Input<'_>,
    mut session: Session,
    mut warnings: Vec<Warning>,
    bike: &Bike,
    pipeline: &Pipeline,
    config: &Config,
) -> Result<Outcome, Rejection> {
    let refuse = |stage, code, message| Rejection { stage, code, message };
    if session.has(Channel::VelocityX) {
        let checked = ingest::check(&mut session, bike, &pipeline.ingest);
        warnings.extend(checked.map_err(|e| refuse("ingest", e.code, e.message))?);
    }
    warnings.extend(filter::run(&mut session, &pipeline.filter));
    let (estimate, noticed) = offroad::run(&session, bike, config)
        .map_err(|message| refuse("estimate", "bad_bike_file", message))?;
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
    let ident = rows::Ident::from(&session.meta);
    let provenance = rows::Provenance {
        input_hash: input.input_hash.clone(),
        pipeline_hash: input.pipeline_hash.clone(),
        version: crate::VERSION.to_owned(),
    };
    let radii = [bike.front.radius, bike.rear.radius];
    let mut manoeuvres = manoeuvres(&session, &segments, radii, &ident);
    for (row, segment) in manoeuvres.iter_mut().zip(&segments) {
        let figures = estimate.figures(segment);
        row.flight_time = figures.flight_time;
        [row.landing_load_front, row.landing_load_rear] = figures.landing;
        row.load_transfer = figures.load_transfer;
    }
    let forces = estimate.force_rows(&segments, &ident);
    let coefficients = estimate.coefficients(&segments, &ident, &provenance);
    let signals = match input.signals {
        true => Some(
            offroad::table::batch(&session.meta, &estimate, &segments, config.signals_rate)
                .map_err(|message| refuse("estimate", "internal_error", message))?,
        ),
        false => None,
    };
    let plots = plots::offroad::rows(&session, &estimate, &segments);
    let warnings: Vec<rows::WarningRow> = warnings.into_iter().map(|w| row(&ident, w)).collect();
    let session =
        session_row(&session, input, bike, &manoeuvres, &coefficients, &warnings, provenance);
    Ok(Outcome {
        session,
        manoeuvres,
        forces,
        coefficients,
        warnings,
        plots,
        signals,
        ..Outcome::default()
    })
}
