//! The tables over all sessions: how coefficients spread, what changed, what all rides say of a tyre.

pub(crate) mod compare;
#[cfg(feature = "fleet")]
pub(crate) mod dispersion;
pub(crate) mod rows;
#[cfg(feature = "fleet")]
pub(crate) mod tables;
#[cfg(feature = "fleet")]
pub(crate) mod tyres;
