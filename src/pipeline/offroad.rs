//! The tables of an off-road session.

use super::outcome::{Input, Outcome, Rejection};
use super::rows::{manoeuvres, name_machine, provenance, session, warnings};
use super::settings::Pipeline;
use super::stages::{OffroadForces, offroad_forces};
use crate::contract::bike::Bike;
use crate::contract::rejection::{RejectionCode, Stage};
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::estimate::offroad::{self, Config};
use crate::report::plots;
use crate::store::tables::rows::Ident;

/// From a prepared session to its tables.
///
/// # Errors
/// The bike file lacks what the equations need.
pub(super) fn run(
    input: &Input<'_>,
    ride: Session,
    mut noticed: Vec<Warning>,
    bike: &Bike,
    pipeline: &Pipeline,
    config: &Config,
) -> Result<Outcome, Rejection> {
    let ridden = offroad_forces(ride, bike, pipeline, config)?;
    let OffroadForces { session: ride, estimate, segments, warnings: more } = ridden;
    noticed.extend(more);
    let ident = Ident::from(&ride.meta);
    let provenance = provenance(input);
    let radii = [bike.front.radius, bike.rear.radius];
    let mut manoeuvres = manoeuvres(&ride, &segments, radii, &ident);
    for (row, segment) in manoeuvres.iter_mut().zip(&segments) {
        let figures = estimate.figures(segment);
        row.flight_time = figures.flight_time;
        [row.landing_load_front, row.landing_load_rear] = figures.landing;
        row.load_transfer = figures.load_transfer;
    }
    let forces = estimate.force_rows(&segments, &ident);
    let mut coefficients = estimate.coefficients(&segments, &ident, &provenance);
    name_machine(&mut coefficients, &ride, bike);
    let signals = match input.signals {
        true => Some(
            offroad::table::batch(&ride.meta, &estimate, &segments, config.signals_rate).map_err(
                |e| Rejection {
                    stage: Stage::Estimate,
                    code: RejectionCode::InternalError,
                    message: e.to_string(),
                    limits: None,
                },
            )?,
        ),
        false => None,
    };
    let plots = plots::offroad::rows(&ride, &estimate, &segments);
    let warnings = warnings(&ident, noticed);
    let session = session(&ride, input, bike, &manoeuvres, &coefficients, &warnings, provenance);
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
