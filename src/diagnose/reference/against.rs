//! Chosen rides as the reference: all other rides of the motorcycle, together, against them.
//!
//! One question instead of one per ride and date, so that a smaller change is beyond chance: a part was changed, and the
//! rides before and after it are known.

use std::collections::BTreeMap;

use super::learnt::learn;
use super::numbers::{History, Ride};
use super::search::{Change, Evidence, search_of};
use super::sets::{Kind, OTHERS, Rides};
use super::sums::AllRides;
use super::{changed, tyre_swap, words};
use crate::store::tables::rows::{ChangeRow, Ident};

/// Differences of a motorcycle's other rides from the given ones.
#[derive(Debug)]
pub(crate) struct Against {
    pub bike_id: String,
    /// Rides of the reference, and other rides.
    pub rides: [usize; 2],
    /// Differences, the clearest first; rows as of the table `changes`, their `rides` is `against`.
    pub changes: Vec<ChangeRow>,
    /// Text if nothing differs beyond chance, with the number that differs most.
    pub largest: String,
}

/// Of each motorcycle that has rides of the reference and others, in order of its id.
///
/// # Errors
/// Every motorcycle has too few rides of the reference.
pub(crate) fn against(
    rides: Vec<Ride>,
    is_reference: impl Fn(&Ident) -> bool,
) -> Result<Vec<Against>, String> {
    let mut bikes: BTreeMap<String, [Vec<Ride>; 2]> = BTreeMap::new();
    for ride in rides {
        let side = usize::from(!is_reference(&ride.ident));
        bikes.entry(ride.ident.bike_id.clone()).or_default()[side].push(ride);
    }
    let is_compared = |[reference, others]: &[usize; 2]| *reference > 0 && *others > 0;
    let sizes = bikes.into_iter().map(|(bike_id, sides)| {
        let rides = [sides[0].len(), sides[1].len()];
        ((bike_id, rides), History::of(&sides.concat()))
    });
    let (of_bikes, mut histories): (Vec<(String, [usize; 2])>, Vec<History>) = sizes.unzip();
    let compared = || of_bikes.iter().filter(|(_, rides)| is_compared(rides));
    let few: Vec<String> = compared()
        .filter(|(_, [reference, _])| *reference < OTHERS)
        .map(|(bike, [reference, _])| format!("{bike} has {reference}"))
        .collect();
    if !few.is_empty() && few.len() == compared().count() {
        return Err(format!(
            "of these rides {}; how much a motorcycle's rides scatter is seen in {OTHERS} at least",
            few.join(", ")
        ));
    }
    // motorcycles that are not compared teach the scatter, too
    learn(&mut histories);
    let all = of_bikes.into_iter().zip(histories);
    let all = all.filter(|((_, rides), _)| is_compared(rides));
    Ok(all.map(|((bike_id, rides), history)| of_motorcycle(bike_id, rides, &history)).collect())
}

fn of_motorcycle(bike_id: String, rides: [usize; 2], history: &History) -> Against {
    if rides[0] < OTHERS {
        let largest = format!("too few rides of the reference: {OTHERS} are the least");
        return Against { bike_id, rides, changes: Vec::new(), largest };
    }
    let others = Rides::from(Kind::Chosen, rides[0], history.len());
    let found = search_of(history, std::slice::from_ref(&others)).changes;
    let found = tyre_swap::explained(history, found);
    let row = |change: &Change| ChangeRow {
        // one question: chance needs no further discount
        ..changed(history, change, change.chance)
    };
    let changes: Vec<ChangeRow> = found.iter().map(row).collect();
    let largest = match changes.is_empty() {
        true => Evidence::new(&AllRides::new(history), &others).largest(),
        false => None,
    };
    let largest = largest.map(|(moved, chance)| {
        let what = words::moved(&history.numbers[moved.number], moved.by);
        format!(
            "nothing differs beyond chance; most: {what}, by chance in {:.0} % of comparisons",
            100.0 * chance
        )
    });
    Against { bike_id, rides, changes, largest: largest.unwrap_or_default() }
}
