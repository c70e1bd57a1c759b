//! A simulated session and its truth as tables, whichever motorcycle rode it.

use arrow::array::RecordBatch;

use super::motocross::{self, scenario::Motocross};
use super::pilot::Skill;
use super::scenario::{Machine, Scenario};
use super::simulated::{Label, Simulated};
use super::tour::Tour;
use super::truth;
use super::{reduced, ride, tyre_truth};
use crate::contract::coefficient::Id;
use crate::contract::session::{Meta, Session};
use crate::estimate;
use crate::simulate::error::Error;
use crate::store::tables::file;
use crate::store::tables::registry::Row;
use crate::store::tables::rows::{Truth, TruthSegment};

/// One session with its truth.
#[derive(Debug)]
pub struct SimulatedSession {
    pub session: Session,
    /// The truth: tables by name.
    pub truth: Vec<(&'static str, RecordBatch)>,
    /// How it fell, if it did: the log ends there.
    pub fall: Option<String>,
}

/// The folder below `truth/` of a table of truth.
pub(crate) fn folder_of(table: &str) -> &str {
    table.strip_prefix("truth_").unwrap_or("coefficients")
}

fn batch<R: Row>(rows: &[R]) -> Result<(&'static str, RecordBatch), file::Error> {
    Ok((R::spec().name, file::batch(rows)?))
}

/// A session of the reduced-order motorcycle.
///
/// # Errors
/// A row does not fit its schema: our own mistake.
pub(crate) fn of_fleet(
    machine: &Machine,
    simulated: Simulated,
) -> Result<SimulatedSession, file::Error> {
    let meta = &simulated.session.meta;
    let coefficients = truth_rows(
        meta,
        &truth::coefficients(&machine.plant, &simulated, &estimate::Config::default()),
    );
    let segments = segment_rows(meta, &simulated.labels);
    let truth = vec![batch(&coefficients)?, batch(&segments)?];
    Ok(SimulatedSession { session: simulated.session, truth, fall: None })
}

/// A session of the nonlinear motorcycle.
///
/// # Errors
/// As [`of_fleet`].
pub(crate) fn of_tour(
    coefficients: &[(Id, f64)],
    ridden: ride::MultibodyRide,
) -> Result<SimulatedSession, file::Error> {
    let meta = &ridden.session.meta;
    let truth = vec![
        batch(&truth_rows(meta, coefficients))?,
        batch(&segment_rows(meta, &ridden.labels))?,
        batch(&ride::truth_signals(&ridden))?,
    ];
    let fall = ridden.fall.as_ref().map(ToString::to_string);
    Ok(SimulatedSession { session: ridden.session, truth, fall })
}

/// A session off-road.
///
/// # Errors
/// As [`of_fleet`].
pub(crate) fn of_motocross(
    scenario: &Motocross,
    ridden: motocross::MotocrossRide,
) -> Result<SimulatedSession, file::Error> {
    let segments = segment_rows(&ridden.session.meta, &ridden.labels);
    let forces = motocross::truth_rows(&ridden, scenario.truth_rate);
    let truth = vec![batch(&segments)?, batch(&forces)?];
    let fall = ridden.fall.as_ref().map(ToString::to_string);
    Ok(SimulatedSession { session: ridden.session, truth, fall })
}

/// Every coefficient of a machine as rows of the `truth` table.
fn truth_rows(session: &Meta, coefficients: &[(Id, f64)]) -> Vec<Truth> {
    coefficients
        .iter()
        .map(|&(id, value)| Truth {
            session_id: session.session_id.clone(),
            bike_id: session.bike_id.clone(),
            tyre: id.part.name().to_owned(),
            coefficient: id.coefficient.name().to_owned(),
            value,
            unit: id.coefficient.spec().unit.to_owned(),
        })
        .collect()
}

fn segment_rows(meta: &Meta, labels: &[Label]) -> Vec<TruthSegment> {
    labels
        .iter()
        .map(|&(kind, start, end, direction)| TruthSegment {
            session_id: meta.session_id.clone(),
            bike_id: meta.bike_id.clone(),
            kind: kind.name().to_owned(),
            start,
            end,
            direction: direction.map(|d| d.name().to_owned()),
        })
        .collect()
}

/// A scenario of any kind, ready to be ridden.
#[derive(Debug)]
pub enum Rideable {
    /// The reduced-order motorcycle.
    Fleet(Box<Scenario>),
    /// The nonlinear motorcycle, and its rider.
    Tour(Box<(Tour, Skill)>),
    /// A motocross scenario.
    Motocross(Box<Motocross>),
}

impl Rideable {
    /// A built-in scenario or a scenario file.
    ///
    /// # Errors
    /// Error text that names the file and the key.
    pub fn load(name_or_path: &str) -> Result<Self, Error> {
        if let Some(motocross) = Motocross::load(name_or_path)? {
            return Ok(Rideable::Motocross(Box::new(motocross)));
        }
        if let Some(tour) = Tour::load(name_or_path)? {
            let skill = Skill::learn(&tour.model, ride::period(tour.rate))
                .map_err(|e| Error::Ride(format!("scenario {}: {e}", tour.name)))?;
            return Ok(Rideable::Tour(Box::new((tour, skill))));
        }
        Ok(Rideable::Fleet(Box::new(Scenario::load(name_or_path)?)))
    }

    /// Number of sessions of the scenario.
    pub fn sessions(&self) -> usize {
        match self {
            Rideable::Fleet(s) => s.fleet.bikes * s.fleet.sessions_per_bike,
            Rideable::Tour(tour) => tour.0.sessions,
            Rideable::Motocross(s) => s.sessions,
        }
    }

    /// Whether its logs hold samples of seven digits.
    pub fn float32(&self) -> bool {
        match self {
            Rideable::Fleet(s) => s.float32,
            Rideable::Tour(tour) => tour.0.float32,
            Rideable::Motocross(s) => s.float32,
        }
    }

    /// Rides a session, counted from 0; gives the bike file's text too.
    ///
    /// # Errors
    /// As [`of_fleet`].
    pub fn ride(&self, number: usize) -> Result<(SimulatedSession, String), file::Error> {
        match self {
            Rideable::Fleet(s) => {
                let machine = s.machine(number / s.fleet.sessions_per_bike.max(1));
                let known = of_fleet(&machine, reduced::session(s, &machine, number))?;
                Ok((known, machine.bike.to_toml()))
            }
            Rideable::Tour(tour) => {
                let (tour, skill) = tour.as_ref();
                let coefficients = tyre_truth::coefficients(&tour.model);
                let known = of_tour(&coefficients, ride::ride(tour, skill, number))?;
                Ok((known, tour.bike.to_toml()))
            }
            Rideable::Motocross(s) => {
                Ok((of_motocross(s, motocross::ride(s, number))?, s.bike.to_toml()))
            }
        }
    }
}
