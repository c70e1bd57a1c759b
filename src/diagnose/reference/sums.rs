//! Numbers of some rides against the others, and the sums of numbers that show an effect best.
//!
//! ```text
//! sum of ride i = sum_p w_p T_ip (x_ip - middle_p) / sum_p w_p T_ip^2        w_p = 1 / scatter_p^2
//! ```
//!
//! `T_i` is what a unit of the effect moves the ride's numbers by. It is the ride's own, also in the rides that are compared
//! with: so the scatter of the sum from ride to ride has the effect's own variation, and correlations between numbers.
//!
//! Effects that vary in every ride, such as zeros of sensors, move other numbers, too, and more in some rides than in others:
//! in circles one way a roll zero is a crown, on a road it is not. Standard errors of a ride do not have that, as each effect
//! is estimated alone. [`Column::moved`] has it.

use super::belief::Belief;
use super::difference::{Column, Difference, difference};
use super::numbers::History;
use super::sets::Rides;
use crate::statistics::moderated::BELIEF;
use crate::statistics::order::median_of_finite;

/// Share of the rides' usual knowledge of an effect below which a ride says nothing of it.
const LEAST_KNOWN: f64 = 0.1;

/// The difference of every number between some rides and the others.
pub(crate) fn numbers(history: &History, rides: &Rides) -> Vec<Option<Difference>> {
    let moved = moved(history, &variation(history));
    let of = |p: usize| {
        let (values, errors, moved) = (&history.values[p], &history.errors[p], &moved[p]);
        difference(Column { values, errors, moved }, rides, Belief::of(history, p))
    };
    (0..history.numbers.len()).map(of).collect()
}

/// By number how much the effect of that name varies from ride to ride beyond noise, as a standard deviation; 0 of the
/// nominal model's parameters.
fn variation(history: &History) -> Vec<f64> {
    let mut all = vec![0.0; history.numbers.len()];
    for (effect, _) in &history.traces {
        let noise = median_of_finite(&history.errors[*effect]).unwrap_or(0.0);
        let scatter = Belief::of(history, *effect).ratio * noise;
        all[*effect] = (scatter.powi(2) - noise.powi(2)).max(0.0).sqrt();
    }
    all
}

/// By number and ride the variance by which the effects that vary move it more than usual, each but its own, and what may be
/// left of changes.
fn moved(history: &History, variation: &[f64]) -> Vec<Vec<f64>> {
    let mut all = vec![vec![0.0; history.len()]; history.numbers.len()];
    for (effect, by_ride) in history.traces.iter().filter(|(effect, _)| variation[*effect] > 0.0) {
        for (ride, trace) in by_ride.iter().enumerate() {
            for (number, slope) in trace.iter().enumerate() {
                if *slope != 0.0 && number != *effect {
                    all[number][ride] += (slope * variation[*effect]).powi(2);
                }
            }
        }
    }
    for (of_number, left) in all.iter_mut().zip(&history.left) {
        beyond_usual(of_number);
        of_number.iter_mut().zip(left).for_each(|(v, left)| *v += left);
    }
    all
}

/// Leaves of variances what is more than their median, which is in the scatter.
fn beyond_usual(variances: &mut [f64]) {
    let usual = median_of_finite(variances).unwrap_or(0.0);
    // `max` would make 0 of what is not a number
    variances.iter_mut().filter(|v| v.is_finite()).for_each(|v| *v = (*v - usual).max(0.0));
}

/// The sums of a motorcycle's numbers.
pub(crate) struct Sums<'a> {
    history: &'a History,
    /// Difference of each number.
    numbers: &'a [Option<Difference>],
    /// Usual value of each number.
    middle: Vec<f64>,
    variation: Vec<f64>,
}

/// The sum that shows one effect.
pub(crate) struct Sum {
    /// By ride; not a number where a ride knows too little of it.
    pub values: Vec<f64>,
    pub errors: Vec<f64>,
    /// As in [`Column`].
    moved: Vec<f64>,
    /// Of the scatter that independent numbers would have.
    pub belief: Belief,
}

impl<'a> Sums<'a> {
    /// With the scatter of numbers that were compared.
    pub(crate) fn new(history: &'a History, numbers: &'a [Option<Difference>]) -> Self {
        let middle = |v: &Vec<f64>| median_of_finite(v).unwrap_or(0.0);
        let middle = history.values.iter().map(middle).collect();
        Sums { history, numbers, middle, variation: variation(history) }
    }

    /// The difference of an effect's sum between some rides and the others. Its error is at least that of the effect's own
    /// number from its variation alone: no sum is surer of a steering zero than zeros are alike.
    pub(crate) fn difference(&self, effect: usize, rides: &Rides) -> Option<Difference> {
        let sum = self.of(effect, rides)?;
        let belief = sum.belief.learnt(self.history.scatter_of_sums[effect]);
        let column = Column { values: &sum.values, errors: &sum.errors, moved: &sum.moved };
        let by_sum = difference(column, rides, belief)?;
        let Some(own) = self.numbers[effect] else { return Some(by_sum) };
        let noise = median_of_finite(&self.history.errors[effect]).unwrap_or(0.0);
        let varies = (own.scatter.powi(2) - noise.powi(2)).max(0.0).sqrt() / own.scatter;
        let least = own.error * varies;
        Some(match least > by_sum.error {
            true => {
                let freedom = own.freedom.min(by_sum.freedom);
                Difference { error: least, freedom, ..by_sum }
            }
            false => by_sum,
        })
    }

    /// The sum of an effect, for rides that it is looked for in.
    pub(crate) fn of(&self, effect: usize, rides: &Rides) -> Option<Sum> {
        let n = self.history.len();
        let (_, by_ride) = self.history.traces.iter().find(|(number, _)| *number == effect)?;
        let parts: Vec<Part> = (0..n).map(|i| self.part(effect, &by_ride[i], i)).collect();
        let shares = || (0..n).map(|i| rides.share(i));
        let sum: f64 = parts.iter().zip(shares()).map(|(part, share)| share * part.known).sum();
        let information = sum / shares().sum::<f64>();
        if !(information > 0.0 && information.is_finite()) {
            return None;
        }
        let of = |part: &Part| match part.known > LEAST_KNOWN * information {
            true => [part.value, part.noise, part.moved, part.left],
            false => [f64::NAN; 4],
        };
        let columns: Vec<[f64; 4]> = parts.iter().map(of).collect();
        let column = |k: usize| -> Vec<f64> { columns.iter().map(|c| c[k]).collect() };
        let finite = |values: &[f64]| values.iter().filter(|v| v.is_finite()).count();
        let (values, errors, mut moved) = (column(0), column(1), column(2));
        beyond_usual(&mut moved);
        moved.iter_mut().zip(column(3)).for_each(|(v, left)| *v += left);
        // of too few rides the scatter would be no more than what is believed
        if 2 * finite(&values) < finite(&self.history.values[effect]) {
            return None;
        }
        let ratio = information.sqrt().recip() / median_of_finite(&errors)?;
        let belief = Belief { ratio, natural: 0.0, freedom: BELIEF };
        Some(Sum { values, errors, moved, belief })
    }

    /// What a ride says of an effect.
    fn part(&self, effect: usize, trace: &[f64], ride: usize) -> Part {
        let [mut top, mut noise, mut left, mut known] = [0.0; 4];
        let mut weights: Vec<(usize, f64)> = Vec::new();
        for (p, slope) in trace.iter().enumerate() {
            let value = self.history.values[p][ride];
            let Some(d) = self.numbers[p].filter(|_| *slope != 0.0 && value.is_finite()) else {
                continue;
            };
            let weight = slope / d.scatter.powi(2);
            top += weight * (value - self.middle[p]);
            noise += (weight * self.history.errors[p][ride]).powi(2);
            left += weight * weight * self.history.left[p][ride];
            known += weight * slope;
            weights.push((p, weight));
        }
        let others = self.history.traces.iter();
        let others = others.filter(|(e, _)| *e != effect && self.variation[*e] > 0.0);
        let by_others: f64 = others
            .map(|(e, by_ride)| {
                let by_one: f64 = weights.iter().map(|(p, w)| w * by_ride[ride][*p]).sum();
                (by_one * self.variation[*e]).powi(2)
            })
            .sum();
        Part {
            value: top / known,
            noise: noise.sqrt() / known,
            moved: by_others / known.powi(2),
            left: left / known.powi(2),
            known,
        }
    }
}

/// What one ride says of an effect: size, its standard error, the variances from other effects and from what may be left of
/// changes, and the information.
struct Part {
    value: f64,
    noise: f64,
    moved: f64,
    left: f64,
    known: f64,
}
