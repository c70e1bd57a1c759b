//! What the off-road estimate gets wrong, and why.
//!
//! ```text
//! session -> forces with rider B -> residuals no tyre force explains -> fit of every candidate
//!                                           |                                 |
//!                    bike's uncertainty, own scatter = fault-free simulations -> calibration -> identification
//! ```
//!
//! The nominal model is rider B on the bike of the file. Five equations leave something over once the
//! tyre forces have taken what they can ([`residuals`]); in flight they leave everything. There a
//! rider who follows the bike, friction in the fork or a heavier rider shows, though no tyre force
//! is known ([`candidates`]). The gain that identifies a candidate is measured on fault-free simulations of
//! the same ride ([`calibration`]).
//!
//! Source: `book/src/diagnosis.md`, section 2, with the equations of `book/src/offroad.md`.

pub(crate) mod calibration;
pub(crate) mod candidates;
pub(crate) mod curve;
pub(crate) mod declaration;
pub(crate) mod engine;
pub(crate) mod fit;
pub(crate) mod ground;
pub(crate) mod residuals;
pub(crate) mod rider_motion;
pub(crate) mod session;
pub(crate) mod suspension;
pub(crate) mod uncertain;

pub(crate) use session::{OffroadDiagnosis, diagnose};
