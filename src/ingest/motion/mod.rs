//! From what a sensor feels to how the motorcycle moves: the course over ground, yaw of the trace, and
//! an inertial unit that is fixed to the frame, brought into the level frame.

pub(crate) mod inertial;
pub(crate) mod low_pass;
pub(crate) mod navigation;
pub(crate) mod receiver;
pub(crate) mod track;
pub(crate) mod yaw;
