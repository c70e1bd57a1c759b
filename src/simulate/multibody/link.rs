//! Links of the tree of bodies, in its order.

use super::state::joint;

/// Main frame.
pub(crate) const FRAME: usize = 0;
/// Swing arm.
pub(crate) const SWING: usize = 1;
/// Rear wheel.
pub(crate) const REAR: usize = 2;
/// Handlebar and upper fork.
pub(crate) const STEER: usize = 4;
/// Lower fork.
pub(crate) const FORK: usize = 5;
/// Front wheel.
pub(crate) const FRONT: usize = 6;
/// Wheels, front and rear.
pub(crate) const WHEELS: [usize; 2] = [FRONT, REAR];
pub(crate) const CARRIERS: [usize; 2] = [FORK, SWING];
pub(crate) const WHEEL_JOINTS: [usize; 2] = [joint::FRONT, joint::REAR];
