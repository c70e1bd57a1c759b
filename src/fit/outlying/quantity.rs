//! What manoeuvres are compared in: names, units and words.

use super::comparison::{Compared, Scatter, Shown};
use crate::contract::session::Session;
use crate::fit::{Data, Solution};
use crate::segment::Segment;

/// A quantity that manoeuvres of a ride have alike.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    pub name: &'static str,
    /// Unit of value and difference in the table.
    pub unit: &'static str,
    /// For people: `friction of the front tyre`.
    pub words: &'static str,
    /// Smallest difference that is worth a word, in its unit.
    pub least: f64,
    /// Unit for people, and how many of it make one of [`Quantity::unit`].
    pub shown: (&'static str, f64),
    /// Possible causes of a larger and a smaller value.
    pub causes: [&'static str; 2],
}

/// A session as it was fitted.
#[derive(Debug, Clone, Copy)]
pub struct Fitted<'a> {
    pub session: &'a Session,
    pub segments: &'a [Segment],
    /// The samples of the fits.
    pub data: &'a Data,
    pub solution: &'a Solution,
}

/// A quantity in which manoeuvres of a ride are compared.
#[derive(Debug)]
pub(crate) struct Compare {
    /// Its name, unit and words.
    pub quantity: &'static Quantity,
    /// How much it differs where nothing is odd.
    pub scatter: Scatter,
    /// Values in the manoeuvres.
    pub shown: fn(&Fitted<'_>) -> Vec<Shown>,
}

/// A manoeuvre that is not as the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Outlying {
    /// In which quantity.
    pub quantity: &'static Quantity,
    pub compared: Compared,
    /// How many comparisons the ride has in all: its chance counts as often.
    pub comparisons: usize,
}
