//! What the model of a ride gets wrong, and why.
//!
//! ```text
//! session -> samples -> residuals of the base model -> base fit -> scan of every effect
//!                                                        |              |
//!                                   replay + noise = nulls -> the same -> calibration -> names
//! ```
//!
//! The base model is the one that [`fit`](crate::fit) characterises, written as eight residuals that
//! vanish when it is right ([`residuals`]): block means of 0.3 s, channel by channel. A *world*
//! ([`world`]) holds every number that enters them, those of the base and those of the [`effects`]
//! that the base leaves out. What a candidate must score to be believed is not computed but seen: on
//! the same ride, ridden again by the simulator on the base model alone ([`null`]).
//!
//! The method is that of `diagnosis.md`, section 2. Not here yet: generic terms for what no candidate
//! explains (2.6), the manoeuvre that would separate rivals (2.7), fleets. Off-road sessions: [`offroad`].

pub mod attitude;
pub mod base;
pub mod effects;
pub mod generic;
pub mod levels;
pub mod model;
pub mod name;
pub mod null;
pub mod offroad;
pub mod replay;
pub mod residuals;
pub mod ride;
pub mod rides;
pub mod samples;
pub mod scan;
pub mod scatter;
pub mod show;
pub mod slow;
pub mod smooth;
pub mod undo;
pub mod world;
