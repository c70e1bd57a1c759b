//! The tables of an off-road session.

use super::stages::{OffroadForces, offroad_forces};
use super::{Input, Outcome, Pipeline, Rejection, manoeuvres, row, session_row};
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate::offroad::{self, Config};
use crate::plots;
use crate::tables::rows;

/// From a session on one clock to its tables.
pub fn run(
    input: &Input<'_>,
    session: Session,
    mut warnings: Vec<Warning>,
    bike: &Bike,
    pipeline: &Pipeline,
    config: &Config,
) -> Result<Outcome, Rejection> {
    let ridden = offroad_forces(session, bike, pipeline, config)?;
    let OffroadForces { session, estimate, segments, warnings: noticed } = ridden;
    warnings.extend(noticed);
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
                .map_err(|message| Rejection {
                    stage: "estimate",
                    code: "internal_error",
                    message,
                })?,
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
