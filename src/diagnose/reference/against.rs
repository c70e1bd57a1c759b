//! Chosen rides as the reference: all other rides of the motorcycle, together, against them.
//!
//! One question instead of one per ride and date, so that a smaller change is beyond chance: a part was changed, and the
//! rides before and after it are known.

use std::collections::BTreeMap;

use super::numbers::{History, Ride};
use super::search::{Change, Evidence, search_of};
use super::sets::{Kind, OTHERS, Rides};
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
    bikes.retain(|_, [reference, others]| !reference.is_empty() && !others.is_empty());
    let few = bikes.iter().filter(|(_, [reference, _])| reference.len() < OTHERS);
    let few: Vec<String> = few.map(|(bike, [r, _])| format!("{bike} has {}", r.len())).collect();
    if !few.is_empty() && few.len() == bikes.len() {
        return Err(format!(
            "of these rides {}; how much a motorcycle's rides scatter is seen in {OTHERS} at least",
            few.join(", ")
        ));
    }
    Ok(bikes.into_iter().map(|(bike_id, sides)| of_motorcycle(bike_id, sides)).collect())
}

fn of_motorcycle(bike_id: String, sides: [Vec<Ride>; 2]) -> Against {
    let rides = [sides[0].len(), sides[1].len()];
    if rides[0] < OTHERS {
        let largest = format!("too few rides of the reference: {OTHERS} are the least");
        return Against { bike_id, rides, changes: Vec::new(), largest };
    }
    let history = History::of(&sides.concat());
    let others = Rides::from(Kind::Chosen, rides[0], history.len());
    let found = search_of(&history, std::slice::from_ref(&others)).changes;
    let found = tyre_swap::explained(&history, found);
    let row = |change: &Change| ChangeRow {
        // one question: chance needs no further discount
        ..changed(&history, change, change.chance)
    };
    let changes: Vec<ChangeRow> = found.iter().map(row).collect();
    let largest = match changes.is_empty() {
        true => Evidence::new(&history, &others).largest(),
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
