//! What the nominal model (rider B, the bike file's fork) may leave out.

use super::declaration::Declaration;
use super::{rider_motion, suspension};

pub(crate) const ALL: &[Declaration] = &[
    rider_motion::VERTICAL,
    rider_motion::HORIZONTAL,
    suspension::FORK_FRICTION,
    suspension::FORK_PRELOAD,
    suspension::SHOCK_FRICTION,
];
