//! Motocross archives that hide something: what off-road `diagnose` is tested on. Like
//! [`hidden`](super::hidden), a case is drawn from its number alone and its files tell nothing of it.

use std::path::{Path, PathBuf};

use super::motocross::scenario::{Legs, Motocross, VerticalMotion};
use super::motocross::{self};
use crate::ingest::write_session;
use crate::simulate::error::Error;
use crate::statistics::random::Random;
use crate::store::tables::file;

/// Hidden effect; the rider of all but the last is one without a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Hidden {
    /// Nothing: rider B on the fork of the bike file.
    Nothing,
    /// The same with sensors half as noisy again.
    Noise,
    /// The rider follows the bike up and down only below this, Hz.
    VerticalMotion(f64),
    /// Friction in the fork beyond the bike file's, N.
    ForkFriction(f64),
    /// Legs that push: no number of the library is the truth.
    Legs,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OffroadCase {
    pub number: usize,
    pub hidden: Hidden,
    seed: u64,
}

impl OffroadCase {
    pub fn draw(seed: u64, number: usize) -> Self {
        let mut random = Random::new(seed, &format!("off-road case {number}"));
        let mut between = |low: f64, high: f64| random.between(low.ln(), high.ln()).exp();
        let hidden = match number % 6 {
            0 => Hidden::Nothing,
            1 => Hidden::Noise,
            2 => Hidden::VerticalMotion(between(1.2, 4.0)),
            3 | 4 => Hidden::ForkFriction(between(10.0, 120.0)),
            _ => Hidden::Legs,
        };
        OffroadCase { number, hidden, seed }
    }

    /// Name of the hidden cause in the tables, and its size where it has one.
    pub fn truth(&self) -> Option<(&'static str, Option<f64>)> {
        match self.hidden {
            Hidden::Nothing | Hidden::Noise => None,
            Hidden::VerticalMotion(cut_off) => Some(("rider_vertical_motion", Some(cut_off))),
            Hidden::ForkFriction(force) => Some(("fork_friction", Some(force))),
            Hidden::Legs => Some(("rider_vertical_motion", None)),
        }
    }

    /// Rides `duration` seconds and writes log and bike file into a folder; the paths of both.
    ///
    /// # Errors
    /// The rider fell, or the files cannot be written.
    pub fn write(&self, folder: &Path, duration: f64) -> Result<(PathBuf, PathBuf), Error> {
        let mut scenario = Motocross::load("motocross")?.ok_or_else(|| {
            Error::Ride("the built-in motocross scenario is not there".to_owned())
        })?;
        scenario.duration = duration;
        scenario.seed = self.seed + 1000 * self.number as u64;
        let effects = &mut scenario.effects;
        // the fork has what its file says
        let said = scenario.bike.value("offroad.fork_friction").unwrap_or(0.0);
        scenario.machine.fork.friction = said;
        effects.fork_friction = 0.0;
        effects.rider_vertical_motion = VerticalMotion::CutOff(0.0);
        match self.hidden {
            Hidden::Nothing => {}
            Hidden::Noise => {
                for sensor in scenario.sensors.values_mut() {
                    sensor.white *= 1.5;
                    sensor.slow *= 1.5;
                }
            }
            Hidden::VerticalMotion(cut_off) => {
                effects.rider_vertical_motion = VerticalMotion::CutOff(cut_off);
            }
            Hidden::ForkFriction(force) => scenario.machine.fork.friction += force,
            Hidden::Legs => effects.rider_vertical_motion = VerticalMotion::Legs(Legs::Active),
        }
        let ridden = motocross::ride(&scenario, 0);
        if let Some(fall) = ridden.fall {
            return Err(Error::Ride(fall));
        }
        let log = folder.join(format!("{}.parquet", ridden.session.meta.session_id));
        let bike = folder.join(format!("{}.toml", scenario.bike.bike_id));
        write_session(&log, &ridden.session, false).map_err(|e| Error::Ride(e.to_string()))?;
        file::write_bytes(&bike, scenario.bike.to_toml().as_bytes())
            .map_err(|e| Error::Ride(e.to_string()))?;
        Ok((log, bike))
    }
}
