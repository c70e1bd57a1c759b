//! One joint fit to a ride in gear: both tyres, brakes, engine and drag, from wheel speeds, lean, throttle,
//! a late velocity and, where there are some, brake pressures and the gear (`book/src/estimation.md`,
//! section 10).
//!
//! [`columns`] brings every channel through one kernel to 10 Hz, [`parameters`] says what is known before
//! the ride, [`model`] gives forces, slips ([`curve`]) and residuals of every sample, [`solve`] fits, and
//! [`rows`] puts what is determined where the ordinary fits have nothing.

pub(crate) mod by_lap;
pub(crate) mod columns;
pub(crate) mod config;
pub(crate) mod curve;
pub(crate) mod lap_rows;
pub(crate) mod model;
pub(crate) mod parameters;
pub(crate) mod rows;
pub(crate) mod solve;

pub(crate) use self::config::Config;
use self::model::Model;
use self::parameters::Prior;
use crate::contract::bike::Bike;
use crate::contract::session::Session;

#[derive(Debug)]
pub struct InGear {
    /// Prior knowledge.
    pub prior: Prior,
    pub fitted: solve::Fitted,
    /// Lower bound of the peak friction: front braking, rear driving or braking.
    pub bounds: [Option<f64>; 2],
    /// Whether there were pressures.
    pub pressures: bool,
    /// Whether the lean was measured.
    pub is_roll_measured: bool,
}

/// Fits a ride; `None` where it lacks the channels, is too short, or does not come to rest.
pub fn run(session: &Session, bike: &Bike, config: &Config) -> Option<InGear> {
    let columns = columns::columns(session, config)?;
    let prior = Prior::new(bike, config, &columns);
    let model = Model::new(&columns, bike, config.max_lean);
    let fitted = solve::fit(&model, &prior, config.min_speed)?;
    if fitted.clusters < config.min_manoeuvres || !fitted.converged {
        return None;
    }
    let (pressures, is_roll_measured) = (columns.pressure[0].is_some(), columns.is_roll_measured);
    let front = pressures.then(|| solve::bound(&model, &fitted, 0, false)).flatten();
    let rear = [true, false].into_iter().filter_map(|d| solve::bound(&model, &fitted, 1, d));
    let bounds = [front, rear.max_by(f64::total_cmp)];
    Some(InGear { prior, fitted, bounds, pressures, is_roll_measured })
}

impl InGear {
    /// Rolling radii, front and rear, m.
    pub fn radii(&self) -> [f64; 2] {
        [0, 1].map(|k| self.fitted.theta[parameters::R_F + k])
    }
}
