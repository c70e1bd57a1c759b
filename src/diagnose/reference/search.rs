//! What changed on one motorcycle, ride by ride and since when: the search over rides and dates.
//!
//! Of all [sets](super::sets) of rides the one that differs most from the others is taken, if
//! chance alone does not make one so different; its cause is looked for, taken out of the rides, and the rest is
//! searched again.

use rayon::prelude::*;

use super::difference::Difference;
use super::explain::{Candidate, candidates};
use super::numbers::History;
use super::sets::{Kind, Rides};
use super::sums::{AllRides, Sums};
use crate::contract::fleet_event::Affected;
use crate::statistics::order::median_of_finite;

/// Chance that a motorcycle of which nothing changed is said to have changed, per search.
pub(crate) const FALSE_ALARMS: f64 = 0.05;
/// Most findings of a motorcycle, and of each set of rides.
const MAX_FINDINGS: [usize; 2] = [12, 3];
/// Sets of rides whose causes are compared, those whose difference is least by chance.
const COMPARED: usize = 6;
/// A rival explains as much but for this difference of log-likelihood: 1 in 20.
const RIVAL: f64 = 3.0;
/// Squared standard deviations by which a rival's own size may be less clear.
const CLEARER: f64 = 9.0;
/// Rides by which the start of a step may be off before each ride is put to the nearer level.
pub(super) const NEAR: usize = 2;
/// Share of the squared clearness of the cause from which a rival is as clear: sizes to first order differ by so much.
const AS_CLEAR: f64 = 0.72;
/// Largest difference over its error of a further change of a ride, as a share of that of a change before, below which
/// it is the remainder of that.
pub(super) const SHADOW: f64 = 0.15;
/// Standard errors from which on an effect's own number says its size.
const CLEAR: f64 = 4.0;
/// Share of what a cause moves that may be left when it is taken out.
const LEFT: f64 = 0.2;
/// Share of a size that is not known, as it is found to first order only.
const FIRST_ORDER: f64 = 0.06;
/// Effects of which a usual size is so far from the first order that no interval is given: at 0.03 simulated rides give
/// 0.017 to 0.023.
const ROUGH: [&str; 2] = ["side_force_ratio_front", "side_force_ratio_rear"];
/// Most numbers that are listed of a change, and the chance of each below which it is.
pub(super) const LISTED: usize = 5;
pub(super) const MOVED: f64 = 0.001;

/// A number that moved.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Moved {
    /// Its place in the history's numbers.
    pub number: usize,
    /// Difference and its standard error.
    pub by: Difference,
}

#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Change {
    /// The rides that differ.
    pub rides: Rides,
    /// The number that explains most: an effect, or a parameter of the nominal model whose cause is not known.
    pub cause: usize,
    /// Size of the change, in the number's unit.
    pub size: f64,
    /// Half of its 95 % interval; infinite where none can be given.
    pub half_width: f64,
    /// Over its standard error.
    pub t: f64,
    /// Effects that explain it as well.
    pub rivals: Vec<usize>,
    /// The numbers that moved most.
    pub moved: Vec<Moved>,
    /// Chance that any number of these rides differs as much where nothing changed.
    pub chance: f64,
    /// The tyres that were changed, where that explains it ([`tyre_swap`](super::tyre_swap)).
    pub swap: Option<Affected>,
}

/// A ride's largest difference, whether beyond chance or not.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Largest {
    /// Index of the ride in the history.
    pub ride: usize,
    pub moved: Moved,
    /// Chance that any number of the ride differs as much where nothing changed.
    pub chance: f64,
}

#[derive(Debug, Clone, Default)]
pub(crate) struct SearchResult {
    /// Changes, in the order in which they were found.
    pub changes: Vec<Change>,
    /// Of each ride that can be compared the largest difference that is left.
    pub largest: Vec<Largest>,
    /// Sets of rides that were tried.
    pub tried: usize,
}

/// Searches a motorcycle's rides.
pub(crate) fn search(history: &History) -> SearchResult {
    search_of(history, &Rides::all(history))
}

/// Searches these sets of a motorcycle's rides.
pub(crate) fn search_of(history: &History, sets: &[Rides]) -> SearchResult {
    let mut rest = history.clone();
    let mut changes: Vec<Change> = Vec::new();
    while changes.len() < MAX_FINDINGS[0].max(history.len() / 5) {
        let Some(change) = strongest(&rest, sets, &changes) else { break };
        take_out(&mut rest, &change);
        changes.push(change);
    }
    let all = AllRides::new(&rest);
    let largest = (0..history.len()).filter_map(|ride| {
        let (moved, chance) = Evidence::new(&all, &Rides::one(ride, history.len())).largest()?;
        Some(Largest { ride, moved, chance })
    });
    // the remainder after a change is searched again
    let tried = sets.len() + changes.len();
    SearchResult { changes, largest: largest.collect(), tried }
}

/// Differences between some rides and the others.
#[derive(Debug, Clone)]
pub(crate) struct Evidence {
    /// The difference of every number.
    pub numbers: Vec<Option<Difference>>,
    /// Of every effect the difference of the sum of numbers that shows it best: its place in the numbers first.
    pub sums: Vec<(usize, Difference)>,
}

impl Evidence {
    pub(crate) fn new(all: &AllRides<'_>, rides: &Rides) -> Self {
        let numbers = all.differences(rides);
        let of_effects = Sums::new(all, &numbers);
        let of = |effect: usize| Some((effect, of_effects.difference(effect, rides)?));
        let sums = all.history.traces.iter().filter_map(|(effect, _)| of(*effect)).collect();
        Evidence { sums, numbers }
    }

    /// Every number and sum, in the order of their chance.
    fn by_chance(&self) -> Vec<(Moved, f64)> {
        let numbers = self.numbers.iter().enumerate().filter_map(|(p, d)| Some((p, (*d)?)));
        let all = numbers.chain(self.sums.iter().copied());
        let mut all: Vec<(Moved, f64)> =
            all.map(|(number, by)| (Moved { number, by }, by.chance())).collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    }

    /// The number that differs most, and the chance that any does as much (Bonferroni).
    pub(crate) fn largest(&self) -> Option<(Moved, f64)> {
        let all = self.by_chance();
        let count = all.len() as f64;
        all.into_iter().next().map(|(moved, chance)| (moved, (chance * count).min(1.0)))
    }

    /// How well the size of a cause is known: by all numbers or by its own, what is clearer.
    fn of_cause(&self, cause: usize) -> Option<Difference> {
        let sum = self.sums.iter().find(|(effect, _)| *effect == cause).map(|(_, d)| *d);
        let by_chance = |a: &Difference, b: &Difference| a.chance().total_cmp(&b.chance());
        sum.into_iter().chain(self.numbers[cause]).min_by(by_chance)
    }
}

fn middle(values: &[f64]) -> f64 {
    median_of_finite(values).unwrap_or(0.0)
}

/// Of the sets of rides whose difference is beyond chance, the change that explains most.
fn strongest(history: &History, sets: &[Rides], known: &[Change]) -> Option<Change> {
    let limit = FALSE_ALARMS / sets.len() as f64;
    let all = AllRides::new(history);
    let is_open =
        |rides: &&Rides| known.iter().filter(|c| c.rides == **rides).count() < MAX_FINDINGS[1];
    let mut tried: Vec<(&Rides, Evidence, f64)> = sets
        .par_iter()
        .filter(is_open)
        .filter_map(|rides| {
            let evidence = Evidence::new(&all, rides);
            let (_, chance) = evidence.largest()?;
            (chance <= limit).then_some((rides, evidence, chance))
        })
        .collect();
    tried.sort_by(|a, b| a.2.total_cmp(&b.2));
    let changes = tried.into_iter().filter_map(|(rides, evidence, chance)| {
        let found = caused(history, rides, &evidence, chance)?;
        let is_left = known.iter().any(|c| is_remainder(history, &found.change, c));
        (!is_left).then_some(found)
    });
    let found: Vec<Caused> = changes.take(COMPARED).collect();
    // of those that differ most, what explains most; of two that explain it alike the smaller set comes first
    let best = found.iter().reduce(|best, next| if next.gain > best.gain { next } else { best })?;
    let start = best.is_own_step().then(|| nearer_start(history, &best.change));
    let is_nearer = |c: &&Caused| {
        c.is_own_step()
            && c.change.cause == best.change.cause
            && Some(c.change.rides.first()) == start
    };
    Some(found.iter().find(is_nearer).unwrap_or(best).change.clone())
}

/// The first ride of a step, each ride near it put to the side whose level it is nearer to.
///
/// METHOD: a robust fit passes over one ride on the wrong side, and of more equal numbers of rides the difference of the means
/// is surer. So of eighteen rides, the last four of which differ, one in ten to four steps would begin with the ride before.
fn nearer_start(history: &History, change: &Change) -> usize {
    let (values, first) = (&history.values[change.cause], change.rides.first());
    let [before, after] = [&values[..first], &values[first..]].map(middle);
    let is_after = |i: &usize| (values[*i] - after).abs() < (values[*i] - before).abs();
    let is_before = |i: &usize| (values[*i] - after).abs() > (values[*i] - before).abs();
    let later = (first..values.len()).take(NEAR).take_while(is_before).count();
    let earlier = (0..first).rev().take(NEAR).take_while(is_after).count();
    if later > 0 { first + later } else { first - earlier }
}

/// Whether a change is the remainder of a large one before, beyond the first order: in rides of that, and small beside
/// what they have of it.
fn is_remainder(history: &History, change: &Change, before: &Change) -> bool {
    let clearest = |c: &Change| c.moved.iter().map(|m| m.by.t().abs()).fold(0.0, f64::max);
    let of_ride = |i: usize| if change.rides.has(i) { before.rides.share(i) } else { 0.0 };
    let most = (0..history.len()).map(of_ride).fold(0.0, f64::max);
    clearest(change) < SHADOW * most * clearest(before)
}

/// A change with its cause.
struct Caused {
    change: Change,
    /// What the cause explains, as a difference of log-likelihoods.
    gain: f64,
    /// Whether the cause's own number shows it.
    is_own: bool,
}

impl Caused {
    /// Whether it is a step that the cause's own number shows.
    fn is_own_step(&self) -> bool {
        self.is_own && self.change.rides.kind == Kind::Since
    }
}

/// The change of some rides with its cause.
fn caused(history: &History, rides: &Rides, evidence: &Evidence, chance: f64) -> Option<Caused> {
    let differences = &evidence.numbers;
    let all = candidates(history, differences, rides);
    let is_possible = |c: &&Candidate| {
        let plausible = history.numbers[c.number].effect.is_none_or(|e| e.in_bounds(c.size));
        plausible && evidence.of_cause(c.number).is_some_and(|d| d.chance() < MOVED)
    };
    let possible: Vec<&Candidate> = all.iter().filter(is_possible).collect();
    let best = possible.first()?;
    // of effects that explain as much, the one whose own size is clearest
    let near: Vec<&Candidate> = possible
        .iter()
        .filter(|c| c.gain >= best.gain - RIVAL && history.numbers[c.number].effect.is_some())
        .copied()
        .collect();
    let clear = |c: &Candidate, other: &Candidate| clearness(history, rides, differences, c, other);
    let is_as_clear = |a: &Candidate, b: &Candidate| {
        let [a, b] = [clear(a, b), clear(b, a)];
        b - a < CLEARER || a > AS_CLEAR * b
    };
    let belongs =
        |c: &Candidate| history.numbers[c.number].effect.is_some_and(|e| rides.kind.suits(e.level));
    // a slope belongs to a site and a wind to a day, where a ride shows both alike
    let is_better = |a: &Candidate, b: &Candidate| match (belongs(a), belongs(b)) {
        (true, false) => is_as_clear(a, b),
        (false, true) => !is_as_clear(b, a),
        _ => clear(a, b) > clear(b, a),
    };
    let cause = near.iter().copied().fold(*best, |best, c| {
        let both = history.numbers[best.number].effect.is_some();
        if both && is_better(c, best) { c } else { best }
    });
    let rivals = near
        .iter()
        .filter(|c| c.number != cause.number && is_as_clear(c, cause))
        .map(|c| c.number)
        .collect();
    let error = evidence.of_cause(cause.number)?;
    // a large size of its own is beyond the first order, unless no motorcycle can have it
    let is_plausible =
        |size: f64| history.numbers[cause.number].effect.is_none_or(|e| e.in_bounds(size));
    let own = differences[cause.number].filter(|d| d.t().abs() > CLEAR && is_plausible(d.size));
    let error = own.unwrap_or(error);
    let size = own.map_or(cause.size, |d| d.size);
    let moved = |(number, by): (usize, &Option<Difference>)| Some(Moved { number, by: (*by)? });
    let mut seen: Vec<Moved> = differences.iter().enumerate().filter_map(moved).collect();
    seen.retain(|m| m.by.chance() < MOVED);
    seen.sort_by(|a, b| a.by.chance().total_cmp(&b.by.chance()));
    // of an effect that only all numbers together show, what shows it
    if seen.is_empty() {
        seen.extend(evidence.by_chance().into_iter().next().map(|(moved, _)| moved));
    }
    seen.truncate(LISTED);
    let change = Change {
        rides: rides.clone(),
        cause: cause.number,
        size,
        half_width: match ROUGH.contains(&history.numbers[cause.number].name.as_str()) {
            true => f64::INFINITY,
            false => error.half_width().hypot(1.96 * FIRST_ORDER * size),
        },
        t: error.t(),
        rivals,
        moved: seen,
        chance,
        swap: None,
    };
    Some(Caused { change, gain: cause.gain, is_own: own.is_some() })
}

/// Squared size of a candidate's own number in standard errors from noise, times the larger scatter of the two over the
/// noise.
fn clearness(
    history: &History,
    rides: &Rides,
    differences: &[Option<Difference>],
    of: &Candidate,
    other: &Candidate,
) -> f64 {
    let usual = |errors: Vec<f64>| median_of_finite(&errors).unwrap_or(f64::NAN);
    let inside = |c: &Candidate| {
        let own = (0..history.len()).filter(|i| rides.has(*i));
        usual(own.map(|i| history.errors[c.number][i]).collect())
    };
    let ratio = |c: &Candidate| {
        let noise = usual(history.errors[c.number].clone());
        differences[c.number].map_or(f64::NAN, |d| (d.error / noise).max(1.0))
    };
    let own = differences[of.number].map_or(0.0, |d| d.size / inside(of));
    (own / ratio(of).max(ratio(other))).powi(2)
}

/// Takes a change out of the rides that differ: an effect with all that it moves; of a change whose cause is not known
/// the number itself.
fn take_out(history: &mut History, change: &Change) {
    let inside: Vec<usize> = (0..history.len()).filter(|i| change.rides.has(*i)).collect();
    let traces = history.traces.iter().find(|(number, _)| *number == change.cause).cloned();
    let of_number = |by_ride: &[Vec<f64>], p: usize| {
        // rides without such manoeuvres have no slope
        let own = by_ride.iter().map(|of_ride| of_ride[p]).filter(|slope| *slope != 0.0);
        middle(&own.collect::<Vec<_>>())
    };
    let usual: Vec<f64> = match &traces {
        Some((_, by_ride)) => (0..history.numbers.len()).map(|p| of_number(by_ride, p)).collect(),
        None => Vec::new(),
    };
    for i in inside {
        let share = change.rides.share(i);
        match &traces {
            Some((_, by_ride)) => {
                for (p, t) in by_ride[i].iter().enumerate().filter(|(_, t)| **t != 0.0) {
                    let moved = change.size * share * t;
                    history.values[p][i] -= moved;
                    // its remainder is known as well as its size is, and as the trace, which is that of the ride's own
                    // optimum and has another sign at another one
                    let unsure = change.size * share * (t - usual[p]);
                    history.remainder_variance[p][i] += (LEFT * moved).powi(2) + unsure.powi(2);
                }
            }
            None => history.values[change.cause][i] -= change.size * share,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{put_trace, ride};
    use super::*;

    /// A latency that moves a radius in three of ten rides, alike in each: the remainder is the share that is left of it. A
    /// fourth slope of the other sign is not known better than to twice its amount.
    #[test]
    fn a_ride_without_a_slope_says_nothing_of_the_usual_one() {
        let of = |last: f64| {
            let of_ride = |k: usize| {
                let mut ride = ride(1, k, &[]);
                if k >= 7 {
                    let slope = if k == 9 { last } else { 0.5 };
                    put_trace(&mut ride, "latency", "radius_front", slope);
                }
                ride
            };
            let mut history = History::of(&(0..10).map(of_ride).collect::<Vec<_>>());
            let place = |name: &str| history.numbers.iter().position(|n| n.name == name);
            let (cause, radius) = place("latency").zip(place("radius_front")).expect("numbers");
            let slopes = history.traces.iter().find(|t| t.0 == cause).expect("a trace").1.clone();
            let change = Change {
                rides: Rides::from(Kind::Since, 5, 10),
                cause,
                size: 2.0,
                half_width: 0.1,
                t: 20.0,
                rivals: vec![],
                moved: vec![],
                chance: 1e-9,
                swap: None,
            };
            take_out(&mut history, &change);
            let relative = |i: usize| {
                let variance = history.remainder_variance[radius][i];
                if variance == 0.0 {
                    0.0
                } else {
                    variance.sqrt() / (2.0 * slopes[i][radius]).abs()
                }
            };
            (0..10).map(relative).collect::<Vec<_>>()
        };
        let is_near = |a: f64, b: f64| (a - b).abs() < 1e-9;
        let alike = of(0.5);
        assert!(alike[..7].iter().all(|r| *r == 0.0), "{alike:?}");
        assert!(alike[7..].iter().all(|r| is_near(*r, LEFT)), "{alike:?}");
        let other = of(-0.5);
        assert!(is_near(other[8], LEFT) && is_near(other[9], LEFT.hypot(2.0)), "{other:?}");
    }

    /// A steering zero of 10 mrad with t = -10 of its own number, and -4 of the sum: it is a cause.
    #[test]
    fn a_cause_is_as_clear_as_its_own_number_where_the_sum_is_not() {
        let of = |size: f64| Difference { size, error: 1.0, freedom: 12.0, scatter: 1.0 };
        let evidence = Evidence { numbers: vec![Some(of(-10.0)), None], sums: vec![(0, of(-4.0))] };
        assert_eq!(evidence.of_cause(0), Some(of(-10.0)));
        assert_eq!(evidence.of_cause(1), None);
        let clear_sum = Evidence { sums: vec![(0, of(12.0))], ..evidence };
        assert_eq!(clear_sum.of_cause(0), Some(of(12.0)));
    }
}
