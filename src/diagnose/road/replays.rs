//! What was measured beside what the simulator makes of it, before and after: rows of `replays`.

use super::base::Base;
use super::null_simulation::NullSimulation;
use super::parameters::Parameters;
use super::replay::From;
use crate::contract::channel::Channel;
use crate::contract::schema::Table;
use crate::contract::session::Session;
use crate::diagnose::cause::Naming;
use crate::statistics::smooth::smooth;
use crate::tables::rows::{Ident, SimulatedSample};

/// What is shown.
const SHOWN: [Channel; 9] = [
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

/// Every looked-at manoeuvre simulated from its own start, on the base model and, where causes were
/// named, on the one with them.
pub fn replays(
    session: &Session,
    simulation: &NullSimulation<'_>,
    base: &Parameters,
    naming: &Naming<Base>,
    ident: &Ident,
) -> Vec<SimulatedSample> {
    let before = simulation.noiseless(base, From::Manoeuvres);
    let after =
        naming.any_named().then(|| simulation.noiseless(&naming.extended.values, From::Manoeuvres));
    let definition = Table::embedded("session");
    let mut rows = Vec::new();
    for channel in SHOWN.into_iter().filter(|c| session.has(*c)) {
        let rate = session.rate;
        let column = |s: &Session| s.get(channel).map(|x| smooth(x, rate)).unwrap_or_default();
        let (measured, base) = (column(session), column(&before));
        let extended = after.as_ref().map(column);
        let known = |x: &[f64], i: usize| x.get(i).copied().filter(|v| v.is_finite());
        let unit = definition.column(channel.name()).and_then(|c| c.unit.clone());
        for (number, (kind, picks)) in simulation.picks().iter().enumerate() {
            rows.extend(picks.iter().map(|&i| SimulatedSample {
                ident: ident.clone(),
                manoeuvre: number as i64 + 1,
                kind: kind.name().to_owned(),
                channel: channel.name().to_owned(),
                unit: unit.clone().unwrap_or_default(),
                time: i as f64 / rate,
                measured: known(&measured, i),
                base: known(&base, i),
                extended: extended.as_ref().and_then(|x| known(x, i)),
            }));
        }
    }
    rows
}
