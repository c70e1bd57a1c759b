//! Manoeuvres that are not as the others of their ride: a stop on a slippery place, a coasting run in a gust, a wheel
//! that stood.
//!
//! A robust fit gives such a manoeuvre no weight and says nothing of it. Here each manoeuvre is compared with the ride's
//! others, quantity by quantity ([`comparison`]); one that differs by more than chance is a row of
//! `outlying_manoeuvres` and a warning, with place, time and what may have caused it.
//!
//! A quantity is a file and its line in the list below.

use crate::tyre::formulation::Formulation;
#[cfg(feature = "internals")]
use comparison::Compared;
use comparison::{Shown, outlying};
use quantity::Compare;

pub(crate) mod comparison;
mod friction;
mod locked;
mod place;
pub(crate) mod quantity;
mod resistance;
pub(crate) mod rows;

pub(crate) use quantity::{Fitted, Outlying};

pub(crate) static COMPARED: &[&Compare] =
    &[&friction::FRONT, &friction::REAR, &resistance::COASTING];

/// Chance that a ride without anything odd is said to have a manoeuvre of another friction or resistance, where rides
/// scatter as simulated ones.
const FALSE_ALARM: f64 = 0.01;

/// Everything that is compared of a session, by quantity.
#[cfg(feature = "internals")]
pub fn comparisons(fitted: &Fitted<'_>) -> Vec<(&'static str, Vec<Compared>)> {
    let of = |c: &&'static Compare| {
        (c.quantity.name, comparison::compare(&(c.shown)(fitted), c.scatter))
    };
    COMPARED.iter().map(of).collect()
}

/// The manoeuvres of a session that are not as its others, in the order of time.
///
/// The printed equations know neither slope nor sensor zeros, which then differ from manoeuvre to manoeuvre: nothing is
/// compared.
pub fn find(fitted: &Fitted<'_>) -> Vec<Outlying> {
    if fitted.solution.inputs.formulation == Formulation::Paper {
        return Vec::new();
    }
    let shown: Vec<(&Compare, Vec<Shown>)> =
        COMPARED.iter().map(|c| (*c, (c.shown)(fitted))).collect();
    let comparisons = shown.iter().map(|(_, shown)| shown.len()).sum::<usize>().max(1);
    let least = FALSE_ALARM / comparisons as f64;
    let mut out: Vec<Outlying> = Vec::new();
    for (of, shown) in shown {
        let found = outlying(shown, of.scatter, least).into_iter();
        let quantity = of.quantity;
        out.extend(
            found
                .filter(|c| (c.value - c.expected).abs() >= quantity.least)
                .map(|compared| Outlying { quantity, compared, comparisons }),
        );
    }
    out.extend(locked::find(fitted));
    out.sort_by_key(|o| fitted.segments[o.compared.segment].start);
    out
}
