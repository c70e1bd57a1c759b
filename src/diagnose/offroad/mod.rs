//! What the off-road estimate gets wrong, and why.
//!
//! ```text
//! session -> forces with rider B -> residuals no tyre force explains -> fit of every candidate
//!                                           |                                 |
//!                    bike's uncertainty, own scatter = null simulations -> calibration -> naming
//! ```
//!
//! The base model is rider B on the bike of the file. Five equations leave something over once the
//! tyre forces have taken what they can ([`residuals`]); in flight they leave everything. There a
//! rider who follows the bike, friction in the fork or a heavier rider shows, though no tyre force
//! is known ([`candidates`]). What a candidate must gain to be named is measured on null simulations of
//! the same ride ([`calibration`]).
//!
//! Source: `diagnosis.md`, section 2, with the equations of `offroad.md`.

pub mod calibration;
pub mod candidates;
pub mod curve;
pub mod declaration;
pub mod engine;
pub mod fit;
pub mod ground;
pub mod residuals;
pub mod rider_motion;
pub mod session;
pub mod suspension;
pub mod uncertain;

pub use session::{OffroadDiagnosis, diagnose, log};
