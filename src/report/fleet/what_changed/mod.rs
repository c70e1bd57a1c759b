//! What changed on each motorcycle: events of the coefficients of `run` and changes that `diagnose` finds by comparing rides, in
//! one list in order of time, and the numbers that moved over the rides.
//!
//! ```text
//! rides       a motorcycle's rides in order of time
//! evidence    what one way says of a change, in the words of both
//! related     whether two ways say it of the same quantity
//! entries     one list of both
//! numbers     each ride's numbers, of the nominal model and of effects
//! timeline    one number over the rides, drawn
//! motorcycle  all of it for one motorcycle
//! ```

pub(crate) mod entries;
pub(crate) mod evidence;
pub(crate) mod motorcycle;
pub(crate) mod numbers;
pub(crate) mod related;
pub(crate) mod rides;
#[cfg(test)]
mod tests;
pub(crate) mod timeline;
