//! Names of errors that are no number of the bike file, in the table `evidence`.

/// The ride's own scatter.
pub(crate) const OWN: &str = "own";
/// Error of the model for this motorcycle, of each coefficient on its own.
pub(crate) const MODEL: &str = "model";
/// Difference between tyres of one model, or between tyres of one side of a comparison: more tyres would narrow it.
pub(crate) const TYRES: &str = "tyres";
/// Error that more rides would narrow: all that is not shared.
pub(crate) const RIDES: &str = "rides";
