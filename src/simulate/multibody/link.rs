//! Links of the tree of bodies, in its order.

use super::state::joint;

/// Main frame.
pub const FRAME: usize = 0;
/// Swing arm.
pub const SWING: usize = 1;
/// Rear wheel.
pub const REAR: usize = 2;
/// Handlebar and upper fork.
pub const STEER: usize = 4;
/// Lower fork.
pub const FORK: usize = 5;
/// Front wheel.
pub const FRONT: usize = 6;
/// Rider's upper body.
pub const RIDER: usize = 7;
/// Wheels, front and rear.
pub const WHEELS: [usize; 2] = [FRONT, REAR];
/// What carries them.
pub const CARRIERS: [usize; 2] = [FORK, SWING];
/// Their joints.
pub const WHEEL_JOINTS: [usize; 2] = [joint::FRONT, joint::REAR];
