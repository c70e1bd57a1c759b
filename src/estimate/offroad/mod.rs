//! Off-road: tyre forces from inverse dynamics, with a standing rider.
//!
//! ```text
//! session -> kinematics -> contact -> riders -> solve -> forces per rider
//!            17 variables  wheel off  f_r       f_t
//! ```
//!
//! Assumes a filtered session and a bike file with `[offroad]`. The motorcycle is planar, four bodies and five
//! coordinates ([`equations`](crate::motorcycle::offroad::equations)); it needs no model of the tyre. Inside this folder
//! the axes are the paper's: Z down, pitch nose up. [`kinematics`] and [`planar`](crate::motorcycle::offroad::planar)
//! turn them over on the way in, [`table`] on the way out.
//!
//! Source: Vasquez, Lot, Rustighi, Pegoraro (2019), "Rider model for the estimation of tyre forces
//! in off-road motorcycles", with the corrections of the book's chapter
//! "Off the road".

pub(crate) mod contact;
pub(crate) mod kinematics;
pub(crate) mod nnls;
pub(crate) mod rider;
pub(crate) mod solve;
pub(crate) mod statistics;
pub(crate) mod synchrony;
pub(crate) mod table;
pub(crate) mod weights;

use serde::{Deserialize, Serialize};

use crate::contract::bike::Bike;
use crate::contract::key_error::KeyError;
use crate::contract::session::Session;
use crate::contract::warning::Warning;

use crate::motorcycle::offroad::chain::Chain;
use crate::motorcycle::offroad::planar::PlanarMotorcycle;
use contact::Contact;
use kinematics::Kinematics;
use rider::{Base, Forces, Rider};
use solve::{Solver, TyreForces};

/// How the chain's pull is taken into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ChainLever {
    /// As well as the bike file knows it: geometry, else teeth, else not.
    #[default]
    Known,
    /// Ratio of teeth, or of sprocket radii.
    ToothRatio,
    /// Not at all, as in the paper.
    Ignored,
}

/// Settings of the off-road estimate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Rider models; the first is the one whose forces coefficients and manoeuvres are made from,
    /// the others stand beside it.
    pub riders: Vec<Rider>,
    /// Source of the lever arm of the chain's pull.
    pub chain: ChainLever,
    /// Samples per second of the `signals` table, Hz.
    pub signals_rate: f64,
    /// Largest lag between front and rear logger that is not reported, s.
    pub max_lag: f64,
    /// Flights of the wheels.
    pub contact: contact::Config,
    /// The least-squares solution.
    pub solve: solve::Config,
    /// Settings of the rider models.
    pub rider: rider::Config,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            riders: vec![Rider::C, Rider::None, Rider::A, Rider::B],
            chain: ChainLever::Known,
            signals_rate: 200.0,
            max_lag: 0.005,
            contact: contact::Config::default(),
            solve: solve::Config::default(),
            rider: rider::Config::default(),
        }
    }
}

impl Config {
    /// Checks the settings.
    ///
    /// # Errors
    /// Error text that names the key.
    pub fn check(&self) -> Result<(), KeyError> {
        for (key, value, low, high) in [
            ("signals_rate", self.signals_rate, 1.0, 1e5),
            ("max_lag", self.max_lag, 0.0, 1.0),
            ("solve.constraint", self.solve.constraint, 0.0, 1e6),
            ("solve.dead_band", self.solve.dead_band, 0.0, 1000.0),
        ] {
            if !(low..=high).contains(&value) {
                return Err(KeyError::Values(format!(
                    "[offroad] `{key}` = {value} is not between {low} and {high}"
                )));
            }
        }
        let mut seen = self.riders.clone();
        seen.sort_unstable();
        seen.dedup();
        if seen.is_empty() || seen.len() != self.riders.len() {
            return Err(KeyError::Values(
                "[offroad] `riders` must name each rider once, and one at least".to_owned(),
            ));
        }
        self.contact.check()?;
        self.rider.check()
    }
}

/// The estimate of one session.
#[derive(Debug, Clone)]
pub struct Estimate {
    pub machine: PlanarMotorcycle,
    pub kinematics: Kinematics,
    /// Wheels off the ground.
    pub contact: Contact,
    /// The riders, in the order of the settings, with their forces and the tyres'.
    pub riders: Vec<RiderEstimate>,
    /// The first rider's tyre forces with half of the force at the bar moved to the pegs: what the
    /// rider model leaves open, for the intervals.
    pub half_at_pegs: TyreForces,
}

/// Result of one rider model.
#[derive(Debug, Clone)]
pub struct RiderEstimate {
    pub rider: Rider,
    /// On the bike, ground axes.
    pub forces: Forces,
    /// On the tyres, chassis axes.
    pub tyres: TyreForces,
}

/// Estimates the forces of a filtered session.
///
/// # Errors
/// The bike file does not know enough; a sentence that names the keys.
pub fn run(
    session: &Session,
    bike: &Bike,
    config: &Config,
) -> Result<(Estimate, Vec<Warning>), KeyError> {
    let mut machine = PlanarMotorcycle::new(bike)?;
    machine.chain = lever(machine.chain, config.chain);
    let (kinematics, mut warnings) = Kinematics::new(session, &machine);
    let incomplete = |message: String| warning("bike_file_incomplete", 1, None, message);
    warnings.extend(machine.notes.iter().map(|n| incomplete(format!("bike file: {n}"))));
    if machine.chain == Chain::Ignored && config.chain != ChainLever::Ignored {
        let message = "bike file: neither sprockets nor teeth: the chain's pull is left out";
        warnings.push(incomplete(message.to_owned()));
    }
    warnings.extend(synchrony::check(session, &kinematics, &machine, config.max_lag));
    let contact = Contact::detect(&kinematics, &machine, &config.contact);
    if kinematics.lost[3] || kinematics.lost[4] {
        let message = "the flights of a wheel without its row of the equations cannot be found: \
                       both wheels count as off the ground while the loads are near zero";
        warnings.push(warning("flights_by_load", 1, None, message.to_owned()));
    }
    let ridden = rider_forces(&machine, &kinematics, &contact, config, &mut warnings)?;
    let solver = Solver::new(&machine, kinematics.lost, &config.solve);
    let unavailable = solver.unavailable();
    if !unavailable.is_empty() {
        let message = format!(
            "the remaining channels do not determine {}; all other forces are estimated",
            unavailable.join(", ")
        );
        warnings.push(warning("force_unavailable", unavailable.len(), None, message));
    }
    let (riders, mut forces): (Vec<Rider>, Vec<Forces>) = ridden.into_iter().unzip();
    forces.push(forces[0].half_at_pegs());
    let mut tyres = solver.run(&kinematics, &contact, &forces);
    let half_at_pegs = tyres.pop().unwrap_or_default();
    let riders = riders.into_iter().zip(forces).zip(tyres);
    let riders =
        riders.map(|((rider, forces), tyres)| RiderEstimate { rider, forces, tyres }).collect();
    Ok((Estimate { machine, kinematics, contact, riders, half_at_pegs }, warnings))
}

/// The forces of every rider of the settings that can stand on the motorcycle, at least the first.
fn rider_forces(
    machine: &PlanarMotorcycle,
    kinematics: &Kinematics,
    contact: &Contact,
    config: &Config,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<(Rider, Forces)>, KeyError> {
    let p = machine.equations.p;
    let base = Base {
        rate: kinematics.rate,
        mu: &kinematics.mu,
        mud: &kinematics.mud,
        xdd: &kinematics.xdd,
        zdd: &kinematics.zdd,
        airborne: &contact.airborne,
    };
    let mut ridden: Vec<(Rider, Forces)> = Vec::with_capacity(config.riders.len());
    for &rider in &config.riders {
        let body = &machine.rider;
        match rider::forces(rider, body, p.peg, p.bar, &base, &config.rider) {
            Ok(forces) => ridden.push((rider, forces)),
            // without the first one there is nothing to make coefficients from
            Err(message) if ridden.is_empty() => {
                return Err(message);
            }
            Err(message) => warnings.push(warning("rider_left_out", 1, None, message.to_string())),
        }
    }
    for (rider, forces) in &ridden {
        if let Some(&first) = forces.toppled.first() {
            let count = forces.toppled.len();
            let time = first as f64 / kinematics.rate;
            let message = format!(
                "rider {} toppled over {count} times, the first at {time:.2} s, and was stood up again: \
                 passive limbs do not hold a rider through this motion",
                rider.name()
            );
            warnings.push(warning("rider_toppled", count, Some(time), message));
        }
    }
    Ok(ridden)
}

fn warning(code: &'static str, count: usize, time: Option<f64>, message: String) -> Warning {
    Warning { stage: "estimate", code, channel: None, count, time, message }
}

fn lever(chain: Chain, wanted: ChainLever) -> Chain {
    match (wanted, chain) {
        (ChainLever::Known, chain) => chain,
        (ChainLever::Ignored, _) => Chain::Ignored,
        (ChainLever::ToothRatio, Chain::Geometry { r_p, r_s, .. }) => Chain::ToothRatio(r_p / r_s),
        (ChainLever::ToothRatio, chain) => chain,
    }
}
