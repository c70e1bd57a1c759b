//! Archives that hide something: what `diagnose` is tested on.
//!
//! A case is drawn from its number alone: motorcycle, tyres, ride plan, sensors and what is hidden in
//! them. [`Case::write`] writes the log and the bike file and nothing of the answer.

use std::path::{Path, PathBuf};

use super::odd_manoeuvre::OddManoeuvre;
use super::scenario::{Machine, Scenario};
use super::transients::Transients;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::ingest::write_session;
use crate::simulate::effects::{ALL, Effect, ModelError};
use crate::simulate::error::Error;
use crate::statistics::random::Random;
use crate::store::tables::file;

/// Kind of a case.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// Nothing is hidden.
    Null,
    /// Nothing is hidden, sensors are half as noisy again as the scenario says.
    Noisy,
    Single,
    /// Two effects.
    Double,
    /// One effect that diagnosis does not know of.
    Removed,
    /// Something that no effect of the library describes.
    Foreign,
}

pub const PLANS: [&str; 2] = ["paper", "naturalistic"];

/// Mixed riding with transients in it, as `naturalistic` otherwise. No case is drawn with them: a study asks
/// for them by name ([`plan_named`]).
pub const TRANSIENT_PLANS: [(&str, Transients); 2] = [
    ("mixed + 2 fast passes", Transients { slow_passes: 0, fast_passes: 2, lane_changes: 0 }),
    ("full transient programme", Transients { slow_passes: 4, fast_passes: 4, lane_changes: 6 }),
];

/// A plan of [`PLANS`] or [`TRANSIENT_PLANS`].
pub fn plan_named(name: &str) -> Option<&'static str> {
    let transient = TRANSIENT_PLANS.iter().map(|(name, _)| *name);
    PLANS.into_iter().chain(transient).find(|plan| *plan == name)
}

/// Hidden effects of one archive.
#[derive(Debug, Clone)]
pub struct Case {
    /// Seed of the draw.
    pub seed: u64,
    pub number: usize,
    /// Kind of the case.
    pub kind: Kind,
    /// Ride plan, of [`PLANS`] or [`TRANSIENT_PLANS`].
    pub plan: &'static str,
    /// Hidden effects and their sizes, in their units.
    pub hidden: Vec<(&'static Effect, f64)>,
    /// Cause that is not among the effects, and its size.
    pub foreign: Option<(&'static str, f64)>,
    /// Manoeuvres that are not as the others; none is drawn, a study puts them in.
    pub odd: Vec<OddManoeuvre>,
}

/// Things outside the library: gains of sensors and the like.
const FOREIGN: [(&str, f64); 4] = [
    ("steer_gain", 0.15),
    ("yaw_rate_gain", 0.06),
    ("pressure_curve", 0.15),
    ("deflating_front", 0.012),
];

impl Case {
    /// Draws a case; `sizes` is the range of sizes in usual ones.
    pub fn draw(seed: u64, number: usize, kind: Kind, sizes: [f64; 2]) -> Self {
        let mut random = Random::new(seed, &format!("case {number}"));
        let plan = PLANS[number % 2];
        let mut hidden: Vec<(&'static Effect, f64)> = Vec::new();
        let wanted = match kind {
            Kind::Null | Kind::Noisy | Kind::Foreign => 0,
            Kind::Single | Kind::Removed => 1,
            Kind::Double => 2,
        };
        while hidden.len() < wanted {
            let effect = &ALL[(random.between(0.0, ALL.len() as f64) as usize).min(ALL.len() - 1)];
            // one in three hardly visible effects, and none in the studies of what is identified
            let keep = if kind == Kind::Single { random.between(0.0, 1.0) < 0.33 } else { false };
            if effect.faint && !keep {
                continue;
            }
            let familiar = |e: &Effect| {
                e.name == effect.name
                    || e.is_confounded_with(effect.name)
                    || effect.confusions().any(|rival| e.is_confounded_with(rival))
            };
            if hidden.iter().any(|(e, _)| familiar(e)) {
                continue;
            }
            let size = random.between(sizes[0].ln(), sizes[1].ln()).exp();
            let sign = if random.between(0.0, 1.0) < 0.5 { -1.0 } else { 1.0 };
            let mut value = sign * size * effect.typical;
            if !effect.in_bounds(1.25 * value) {
                value = -value;
            }
            // what cannot be is not hidden
            if effect.in_bounds(1.25 * value) {
                hidden.push((effect, value));
            }
        }
        let foreign = (kind == Kind::Foreign).then(|| {
            let (name, size) = FOREIGN[number / 2 % FOREIGN.len()];
            (name, size * random.between(0.7, 1.5))
        });
        Case { seed, number, kind, plan, hidden, foreign, odd: Vec::new() }
    }

    /// The motorcycle of the case: its bike file says the truth but for what is hidden.
    pub fn machine(&self) -> Result<(Scenario, Machine), Error> {
        let more = TRANSIENT_PLANS.iter().find(|(name, _)| *name == self.plan);
        let base = more.map_or(self.plan, |_| "naturalistic");
        let mut scenario = Scenario::builtin(base)?.certain();
        if let Some((_, transients)) = more {
            scenario.plans.iter_mut().for_each(|plan| plan.transients = *transients);
        }
        scenario.seed = scenario.seed.wrapping_add(self.seed);
        scenario.odd_manoeuvres.clone_from(&self.odd);
        let named = ["acceleration_x", "acceleration_y", "yaw_rate"];
        let more = if self.kind == Kind::Noisy { 1.5 } else { 1.0 };
        for (name, sensor) in &mut scenario.sensors {
            // zeros and delays are effects
            if !named.contains(&name.as_str()) {
                sensor.bias = 0.0;
            }
            sensor.latency = 0.0;
            sensor.white *= more;
            sensor.slow *= more;
        }
        let mut machine = scenario.machine(self.number);
        let mut error = ModelError::default();
        for (effect, value) in &self.hidden {
            (effect.set)(&mut error, *value);
        }
        machine.plant = machine.plant.with(&error);
        Ok((scenario, machine))
    }

    /// Rides it: the log as the logger wrote it, and the motorcycle.
    ///
    /// # Errors
    /// The built-in scenario does not load (a defect that a test would find).
    pub fn ride(&self) -> Result<(Session, Machine), Error> {
        let (scenario, machine) = self.machine()?;
        let mut session = super::session(&scenario, &machine, self.number).session;
        self.distort(&mut session);
        Ok((session, machine))
    }

    /// Puts what no effect describes into a session.
    pub(super) fn distort(&self, session: &mut Session) {
        if let Some((name, size)) = self.foreign {
            distort(session, name, size);
        }
    }

    /// Writes log and bike file into a folder; the paths of both.
    ///
    /// # Errors
    /// The files cannot be written.
    pub fn write(&self, folder: &Path) -> Result<(PathBuf, PathBuf), Error> {
        let (session, machine) = self.ride()?;
        files(folder, &session, &machine.bike)
    }
}

/// Writes log and bike file into a folder; the paths of both.
pub(super) fn files(
    folder: &Path,
    session: &Session,
    bike: &Bike,
) -> Result<(PathBuf, PathBuf), Error> {
    let log = folder.join("sessions").join(format!("{}.parquet", session.meta.session_id));
    let path = folder.join("bikes").join(format!("{}.toml", bike.bike_id));
    write_session(&log, session, false).map_err(|e| Error::Ride(e.to_string()))?;
    file::write_bytes(&path, bike.to_toml().as_bytes()).map_err(|e| Error::Ride(e.to_string()))?;
    Ok((log, path))
}

fn distort(session: &mut Session, name: &str, size: f64) {
    let duration = session.duration();
    let rate = session.rate;
    let mut on = |channel: Channel, f: &dyn Fn(usize, f64) -> f64| {
        if let Some(x) = session.get_mut(channel) {
            x.iter_mut().enumerate().for_each(|(i, x)| *x = f(i, *x));
        }
    };
    match name {
        "steer_gain" => on(Channel::SteerAngle, &|_, x| x * (1.0 + size)),
        "yaw_rate_gain" => on(Channel::YawRate, &|_, x| x * (1.0 + size)),
        "pressure_curve" => {
            for channel in [Channel::BrakePressureFront, Channel::BrakePressureRear] {
                on(channel, &|_, x| x * (1.0 + size * (x / 2e6 - 0.5)));
            }
        }
        _ => on(Channel::WheelSpeedFront, &|i, x| {
            x * (1.0 + size * (i as f64 / rate / duration - 0.5))
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_depends_on_its_number_alone_and_its_bike_file_tells_nothing() {
        for number in 0..40 {
            let draw = || Case::draw(5, number, Kind::Double, [1.0, 2.5]);
            let (a, b) = (draw(), draw());
            assert_eq!(a.hidden.len(), 2);
            for ((e, x), (f, y)) in a.hidden.iter().zip(&b.hidden) {
                assert!(e.name == f.name && x == y && e.in_bounds(*x));
            }
            let null = Case { kind: Kind::Null, hidden: Vec::new(), ..a.clone() };
            let bikes = [a, null].map(|c| c.machine().expect("scenario").1.bike.to_toml());
            assert_eq!(bikes[0], bikes[1]);
        }
    }
}
