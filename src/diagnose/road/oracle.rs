//! How far the simulation of a ride is off where its hidden effects are known: what a perfect diagnosis would gain.

use super::left_out::SizedCause;
use super::null_simulation::NullSimulation;
use super::replays::{Replays, shown, simulated};
use super::session::{fitted, seed};
use super::simulation_errors::simulation_errors;
use crate::contract::bike::Bike;
use crate::contract::session::Session;
use crate::pipeline::{Pipeline, Rejection};
use crate::simulate::effects::Effect;
use crate::store::tables::rows::{Ident, SimulationError};

/// Gauss-Newton rounds of the base beside the true effects.
const ROUNDS: usize = 6;

/// Rows of `simulation_errors` of a clean, unfiltered session, in which the extended model has the true effects at their
/// true sizes, in their units; the base is fitted beside them, without the manoeuvres that are simulated.
///
/// # Errors
/// It does not hold what a diagnosis needs.
pub fn errors_with_the_truth(
    session: &Session,
    bike: &Bike,
    pipeline: &Pipeline,
    truth: &[(&Effect, f64)],
) -> Result<Vec<SimulationError>, Rejection> {
    let fitted = fitted(session, bike, pipeline)?;
    let (session, samples, base) = (&fitted.session, &fitted.samples, &fitted.base);
    let effects: Vec<Effect> = truth.iter().map(|(effect, _)| **effect).collect();
    let start = base.clone().starting_point(samples, &effects);
    let parameters: Vec<_> = effects.iter().map(Effect::parameter).collect();
    let mut near = start.near.clone();
    for (parameter, (_, size)) in parameters.iter().zip(truth) {
        parameter.set(&mut near.values, parameter.get(&near.start) + size);
    }
    let extended = near.extended(samples, &parameters, ROUNDS);
    let found: Vec<SizedCause> = parameters
        .iter()
        .zip(truth)
        .map(|(&parameter, &(_, size))| SizedCause { parameter, share: 1.0, interval: [size; 2] })
        .collect();
    let seed = seed(&session.meta.session_id);
    let simulation = NullSimulation::new(session, &fitted.ridden.segments, &start.noise, seed);
    let replays = Replays {
        measured: shown(session, &simulation, |_| true),
        base: simulated(samples, &simulation, &start.base, &[]),
        extended: Some(simulated(samples, &simulation, &extended, &found)),
    };
    let right = simulation.with_parameters(&extended.values);
    Ok(simulation_errors(&replays, &right, seed, &Ident::from(&session.meta)))
}
