//! What to ride next: manoeuvres that would tell what this ride cannot, and by how much.
//!
//! Every set of [`sets`] is simulated on the fitted model, put through filter, segmentation and
//! linearisation like a ride, and what it knows is added to what the session knows
//! ([`information`]). Noise is the session's own; a channel that the session lacks stays lacking.
//! What the figures leave out is what is not in them: manoeuvres that differ among each other, and
//! the method's bias.

pub(crate) mod information;
pub(crate) mod ranking;
mod rows;
pub(crate) mod sets;

pub(crate) use ranking::{ALIKE, Advice};
pub(crate) use rows::amend;
