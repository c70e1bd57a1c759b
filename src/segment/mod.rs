//! A session cut into manoeuvres.
//!
//! Assumes a filtered session. A few signals on a coarse clock ([`features`]) are given to one
//! [`Detector`](detector::Detector) per manoeuvre; of those that claim a block the first in
//! [`run`]'s list has it:
//!
//! ```text
//! no velocity  >  standing or slow  >  bend  >  rolling in or out  >  braking  >  coasting  >  driving
//! ```
//! Each detector has a threshold to enter, a lower one to leave and a shortest length. Each
//! judges what it gets: quasi-static? uncombined? long and strong enough? What cannot be used
//! stays in the table with its reason, and so does the rest (`other`), so that the segments
//! cover the session.
//!
//! Adding a manoeuvre: a file with its settings and its `Detector`; here its module, its settings
//! and its place in the list of [`run`]; its declaration in
//! [`contract::manoeuvre`](crate::contract::manoeuvre).
//!
//! Cost: the means over the coarse blocks; a 20-minute session takes a few milliseconds.

use serde::{Deserialize, Serialize};

use crate::contract::bike::Bike;
use crate::contract::session::Session;

pub mod braking;
pub mod coasting;
pub mod cornering;
mod cut;
pub mod detector;
pub mod driving;
pub mod features;
mod heading;
mod mask;
pub mod offroad;
pub mod rolling;
mod segments;
pub mod standing;

pub use segments::Segment;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Below this speed nothing begins, m/s.
    pub min_speed: f64,
    /// Below this speed everything ends, m/s.
    pub end_speed: f64,
    /// Bends.
    pub cornering: cornering::Config,
    /// Brakings.
    pub braking: braking::Config,
    /// Coasting.
    pub coasting: coasting::Config,
    /// Driving.
    pub driving: driving::Config,
    /// Off-road manoeuvres.
    pub offroad: offroad::Config,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            min_speed: 2.0,
            end_speed: 0.5,
            cornering: cornering::Config::default(),
            braking: braking::Config::default(),
            coasting: coasting::Config::default(),
            driving: driving::Config::default(),
            offroad: offroad::Config::default(),
        }
    }
}

/// Cuts a filtered session into segments, in time order, none overlapping, all of it covered.
/// Empty without forward velocity.
pub fn run(session: &Session, bike: &Bike, config: &Config) -> Vec<Segment> {
    let Config { min_speed, end_speed, cornering, braking, coasting, driving, .. } = config;
    let features = features::Features::new(session, bike);
    // the strongest claim first; driving claims all that is left
    let detectors: [&dyn detector::Detector; _] = [
        &standing::NoVelocity,
        &standing::Standing { min_speed: *min_speed, end_speed: *end_speed },
        cornering,
        &rolling::Rolling(cornering),
        braking,
        coasting,
        driving,
    ];
    cut::cut(&features, &detectors, session.len)
}
