//! The off-road motorcycle and rider as rigid bodies: geometry, equations of motion, linkage curves, chain.
//!
//! Used by the inverse dynamics ([`crate::estimate::offroad`]) and by the motocross simulator.

pub(crate) mod body;
pub(crate) mod chain;
pub(crate) mod curve;
pub(crate) mod equations;
pub(crate) mod planar;
