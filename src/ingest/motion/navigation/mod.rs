//! From an inertial unit that is fixed to the frame any way round, and a satellite receiver, to the
//! level frame: attitude, velocity and acceleration of the centre of mass, each with a standard deviation.
//!
//! ```text
//! Log -> alignment: mounting, sign, delay, by straight running         (align)
//!     -> forward error-state Kalman filter over the whole log          (forward: strapdown, rows)
//!     -> backward smoother (Bryson and Frazier)                        (backward)
//!     -> the same again about the smoothed delay and start, until the delay rests
//!     -> level-frame channels and their standard deviations            (output)
//! ```
//!
//! # Frames
//!
//! World: x along the direction from which courses count, y to its left, z up. Unit: the three axes of
//! the sensor. Body: the unit's axes turned by the alignment, nearly those of the main frame. Main frame:
//! x forward, y left, z up, fixed to the motorcycle. Level frame: x along the trace of the main frame's
//! plane on the road, z up.
//!
//! # Model
//!
//! ```text
//! w = (1 - M)(w_m - b_g)      f = f_m - b_a
//! R' = R [w]x                 v' = R f + g        p' = v + the walk of the receiver's error
//! ```
//!
//! Errors are additive but for the attitude, `R = R^ exp[theta]`. What each number of the state is stands
//! in [`state`]; the equations are derived in the book, chapter "Any inertial unit".

mod align;
mod backward;
mod fault;
mod forward;
mod jacobian;
pub(crate) mod level;
pub(crate) mod log;
pub(crate) mod output;
mod products;
mod rows;
pub(crate) mod run;
pub(crate) mod state;
mod strapdown;

pub(crate) use log::{Epoch, Log};
pub(crate) use output::NAMES;
#[cfg(any(test, feature = "internals"))]
pub(crate) use output::OUTPUTS;
pub(crate) use run::{Navigation, Share, run};
