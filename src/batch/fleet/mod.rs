//! The tables over all sessions: how coefficients spread, what changed, what all rides say of a tyre.

#[cfg(feature = "fleet")]
pub mod dispersion;
pub mod rows;
#[cfg(feature = "fleet")]
pub mod tables;
#[cfg(feature = "fleet")]
pub mod tyres;
