//! Names of errors that are no number of the bike file, in the table `evidence`.

/// The ride's own scatter.
pub(crate) const OWN: &str = "own";
/// What the model is wrong by for this motorcycle, of each coefficient on its own.
pub(crate) const MODEL: &str = "model";
/// What tyres of one model, or tyres of one side of a comparison, differ by: more tyres would narrow it.
pub(crate) const TYRES: &str = "tyres";
/// What more rides would narrow: all that is not shared.
pub(crate) const RIDES: &str = "rides";
