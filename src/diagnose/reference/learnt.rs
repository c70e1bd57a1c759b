//! What the other motorcycles of an output teach of the scatter of numbers between rides.
//!
//! METHOD: the scatter that is stated ([`Belief`]) is that of some simulated machines. Where sensors are switched on with
//! another zero in each ride it is five times too small. Of what a ride hardly determines it is too large. Both are
//! the same on most motorcycles of a fleet. So each number's stated scatter is put right by the others' (empirical Bayes,
//! [`moderated`](crate::statistics::moderated)), and counts for more the more they agree. A motorcycle alone keeps what
//! is stated.
//!
//! The scatter of a motorcycle is that between each ride and the last one of an earlier day. So a new tyre makes one large
//! difference, which is clipped, and not as many as there are rides.

use std::cmp::Reverse;
use std::collections::BTreeMap;

use rayon::prelude::*;

use super::belief::Belief;
use super::numbers::History;
use super::sets::{Kind, OTHERS, Rides};
use super::sums::{AllRides, Sums};
use crate::statistics::moderated::{GroupVariance, Scatter, clipped_variance, learnt};
use crate::statistics::order::median_of_finite;

/// Least number of differences between days that show a scatter.
const LEAST_PAIRS: usize = 3;
/// Degrees of freedom of a difference, of which two have a ride in common.
const FREEDOM_OF_PAIR: f64 = 0.5;

/// By number, or by effect, of a motorcycle.
type Variances = Vec<(usize, GroupVariance)>;

/// Puts what is believed of each motorcycle's scatter right by the others.
pub(crate) fn learn(histories: &mut [History]) {
    let of = |h: &History| -> Variances {
        let all = (0..h.numbers.len()).filter_map(|p| {
            let (values, errors) = (&h.values[p], &h.errors[p]);
            Some((p, variance(h, values, errors, Belief::stated(h, p))?))
        });
        all.collect()
    };
    let numbers: Vec<Variances> = histories.par_iter().map(of).collect();
    let scatter = by_others(histories, &numbers);
    histories.iter_mut().zip(scatter).for_each(|(history, s)| history.scatter = s);
    let sums: Vec<Variances> = histories.par_iter().map(of_sums).collect();
    let scatter = by_others(histories, &sums);
    histories.iter_mut().zip(scatter).for_each(|(history, s)| history.scatter_of_sums = s);
}

/// Variances of the sums that show effects.
fn of_sums(history: &History) -> Variances {
    if history.len() <= OTHERS {
        return Vec::new();
    }
    let all_rides = AllRides::new(history);
    // a number that the ride lacks has no difference
    let known = |ride: usize| history.values.iter().filter(|v| v[ride].is_finite()).count();
    let ride = (0..history.len()).max_by_key(|ride| (known(*ride), Reverse(*ride)));
    let numbers = all_rides.differences(&Rides::one(ride.unwrap_or(0), history.len()));
    let sums = Sums::new(&all_rides, &numbers);
    let all = Rides::from(Kind::Chosen, 0, history.len());
    let of = |effect: usize| {
        let sum = sums.of(effect, &all)?;
        Some((effect, variance(history, &sum.values, &sum.errors, sum.belief)?))
    };
    history.traces.iter().filter_map(|(effect, _)| of(*effect)).collect()
}

/// By motorcycle and number what the other motorcycles teach.
fn by_others(histories: &[History], variances: &[Variances]) -> Vec<Vec<Scatter>> {
    let mut by_name: BTreeMap<&str, Vec<(usize, GroupVariance)>> = BTreeMap::new();
    for (bike, (history, of_bike)) in histories.iter().zip(variances).enumerate() {
        for (p, variance) in of_bike {
            by_name.entry(&history.numbers[*p].name).or_default().push((bike, *variance));
        }
    }
    let of = |(bike, history): (usize, &History)| {
        let numbers = history.numbers.iter().map(|number| {
            let all = by_name.get(number.name.as_str()).into_iter().flatten();
            let others = all.filter(|(of_bike, _)| *of_bike != bike).map(|(_, v)| *v);
            learnt(&others.collect::<Vec<_>>())
        });
        numbers.collect()
    };
    histories.par_iter().enumerate().map(of).collect()
}

/// The variance of a number over what is stated of it, from differences between days.
fn variance(
    history: &History,
    values: &[f64],
    errors: &[f64],
    stated: Belief,
) -> Option<GroupVariance> {
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    if known.len() <= OTHERS {
        return None;
    }
    let usual = median_of_finite(&known.iter().map(|i| errors[*i]).collect::<Vec<_>>())?;
    let expected =
        |i: usize| (stated.ratio * errors[i].max(usual)).powi(2) + stated.natural.powi(2);
    let pairs = pairs(history, known);
    let squares: Vec<f64> = pairs
        .iter()
        .map(|(i, j)| (values[*j] - values[*i]).powi(2) / (expected(*i) + expected(*j)))
        .collect();
    if squares.len() < LEAST_PAIRS {
        return None;
    }
    let freedom = FREEDOM_OF_PAIR * squares.len() as f64;
    Some(GroupVariance { log: clipped_variance(&squares)?.ln(), freedom })
}

/// Each ride with the last one of another day before it; rides without a date are each of their own day.
fn pairs(history: &History, mut rides: Vec<usize>) -> Vec<(usize, usize)> {
    rides.sort_by_key(|i| (&history.rides[*i].start_time, &history.rides[*i].session_id));
    let is_other =
        |i: usize, j: usize| history.day(i).is_none() || history.day(i) != history.day(j);
    let earlier = |k: usize| rides[..k].iter().rfind(|i| is_other(**i, rides[k]));
    (0..rides.len()).filter_map(|k| Some((*earlier(k)?, rides[k]))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::tests::ride;
    use super::*;

    /// The first ride has one number only. The others teach as much as they do without it.
    #[test]
    fn a_first_ride_that_knows_little_hides_no_sum() {
        let of = |k: usize| {
            let mut ride = ride(7, k, &[]);
            if k == 0 {
                ride.estimates.retain(|row| row.parameter == "drag");
            }
            ride
        };
        let rides: Vec<_> = (0..9).map(of).collect();
        let effects = |history: History| of_sums(&history).iter().map(|(p, _)| *p).collect();
        let [with, without]: [Vec<usize>; 2] =
            [effects(History::of(&rides)), effects(History::of(&rides[1..]))];
        assert_eq!((with.len(), &with), (4, &without));
    }
}
