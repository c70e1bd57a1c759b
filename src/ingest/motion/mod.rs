//! From what a sensor feels to how the motorcycle moves: the course over ground, yaw of the trace, and
//! an inertial unit that is fixed to the frame, brought into the level frame.

pub mod inertial;
pub mod low_pass;
pub mod navigation;
pub mod track;
pub mod yaw;
