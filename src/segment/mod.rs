//! A session cut into manoeuvres.
//!
//! Assumes a filtered session. A few signals on a coarse clock
//! ([`features`](crate::segment::manoeuvre::features)) are given to one
//! [`Detector`](crate::segment::manoeuvre::detector::Detector) per manoeuvre; of those that claim a block
//! the first in the list ([`Config::detectors`]) has it:
//!
//! ```text
//! no velocity  >  standing or slow  >  corner  >  rolling in or out  >  braking  >  coasting  >  driving
//! ```
//! Each detector has a threshold to enter, a lower one to leave and a shortest length. Each
//! judges what it gets: quasi-static? uncombined? long and strong enough? What cannot be used
//! stays in the table with its reason, and so does the rest (`other`), so that the segments
//! cover the session.
//!
//! Which kinds there are, with their detectors and thresholds, is in [`manoeuvre`](crate::segment::manoeuvre).
//!
//! Cost: the means over the coarse blocks; a 20-minute session takes a few milliseconds.

use crate::contract::bike::Bike;
use crate::contract::reason::{Reason, ReasonCode};
use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::segment::manoeuvre::braking::ENOUGH_ALONE;
use crate::segment::manoeuvre::features::Features;

mod cut;
mod heading;
pub(crate) mod laps;
pub(crate) mod manoeuvre;
pub(crate) mod offroad;
pub(crate) mod segments;

pub(crate) use crate::segment::manoeuvre::Config;
pub(crate) use segments::Segment;

/// Cuts a filtered session into segments, in time order, none overlapping, all of it covered.
/// Empty without forward velocity.
pub fn run(session: &Session, bike: &Bike, config: &Config) -> Vec<Segment> {
    let features = Features::new(session, bike);
    let mut segments = cut::cut(&features, &config.detectors(), session.len);
    leave_out_combined(&mut segments);
    segments
}

/// Leaves out braking with both brakes, whose shares need sensors, where both tyres have enough with one brake alone.
fn leave_out_combined(segments: &mut [Segment]) {
    let alone = |kind| segments.iter().filter(|s| s.used && s.kind == kind).count();
    let needed = [ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking]
        .into_iter()
        .any(|kind| alone(kind) < ENOUGH_ALONE);
    let combined = |s: &&mut Segment| s.used && s.kind == ManoeuvreKind::CombinedBraking;
    for segment in segments.iter_mut().filter(combined).filter(|_| !needed) {
        segment.used = false;
        let words = "both brakes: stops with one brake show the same better";
        segment.reason = Some(Reason::new(ReasonCode::NotNeeded, words));
    }
}
