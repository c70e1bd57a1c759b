//! The off-road machine and rider as rigid bodies: geometry, equations of motion, linkage curves, chain.
//!
//! Used by the inverse dynamics ([`crate::estimate::offroad`]) and by the motocross simulator.

pub mod body;
pub mod chain;
pub mod curve;
pub mod equations;
pub mod machine;
