//! Numbers of some rides against the others, and the sums of numbers that show an effect best.
//!
//! ```text
//! sum of ride i = sum_p w_p T_ip (x_ip - middle_p) / sum_p w_p T_ip^2        w_p = 1 / scatter_p^2
//! ```
//!
//! `T_i` is what a unit of the effect moves the ride's numbers by. It is the ride's own, also in the rides that are compared
//! with. So the scatter of the sum from ride to ride has the effect's own variation, and correlations between numbers.
//!
//! Effects that vary in every ride, such as zeros of sensors, move other numbers, too, in some rides more than in others.
//! In circles one way a roll zero is a crown, on a road it is not. Standard errors of a ride do not have that, as each effect
//! is estimated alone. [`Column::extra_variance`] has it.

use super::belief::Belief;
use super::difference::{Column, Difference, difference};
use super::numbers::History;
use super::sets::Rides;
use crate::statistics::moderated::BELIEF;
use crate::statistics::order::median_of_finite;

/// Share of the rides' usual knowledge of an effect below which a ride says nothing of it.
const LEAST_KNOWN: f64 = 0.1;

/// What all rides of a motorcycle say, whatever rides are compared.
pub(crate) struct AllRides<'a> {
    pub history: &'a History,
    /// By number what is believed of its scatter.
    beliefs: Vec<Belief>,
    /// By number its usual value.
    middle: Vec<f64>,
    /// By number its usual standard error.
    noise: Vec<f64>,
    /// By number as of [`variation`].
    variation: Vec<f64>,
    /// By number as in [`Column`].
    extra_variance: Vec<Vec<f64>>,
    /// By ride and number the slopes that are not zero, each with its effect's place among the traces.
    slopes: Vec<Vec<Vec<(usize, f64)>>>,
}

impl<'a> AllRides<'a> {
    pub(crate) fn new(history: &'a History) -> Self {
        let count = history.numbers.len();
        let middle = |all: &[Vec<f64>]| -> Vec<f64> {
            all.iter().map(|v| median_of_finite(v).unwrap_or(0.0)).collect()
        };
        let noise = middle(&history.errors);
        let beliefs: Vec<Belief> = (0..count).map(|p| Belief::of(history, p)).collect();
        let variation = variation(history, &beliefs, &noise);
        let extra_variance = extra_variance(history, &variation);
        let mut slopes = vec![vec![Vec::new(); count]; history.len()];
        for (effect, (_, by_ride)) in history.traces.iter().enumerate() {
            for (of_ride, trace) in slopes.iter_mut().zip(by_ride) {
                let known = of_ride.iter_mut().zip(trace).filter(|(_, slope)| **slope != 0.0);
                known.for_each(|(of_number, slope)| of_number.push((effect, *slope)));
            }
        }
        let middle = middle(&history.values);
        AllRides { history, beliefs, middle, noise, variation, extra_variance, slopes }
    }

    /// The difference of every number between some rides and the others.
    pub(crate) fn differences(&self, rides: &Rides) -> Vec<Option<Difference>> {
        let of = |p: usize| {
            let (values, errors) = (&self.history.values[p], &self.history.errors[p]);
            let extra_variance = &self.extra_variance[p];
            difference(Column { values, errors, extra_variance }, rides, self.beliefs[p])
        };
        (0..self.history.numbers.len()).map(of).collect()
    }
}

/// By number how much the effect of that name varies from ride to ride beyond noise, as a standard deviation; 0 of the
/// nominal model's parameters.
fn variation(history: &History, beliefs: &[Belief], noise: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; history.numbers.len()];
    for (effect, _) in &history.traces {
        let noise = noise[*effect];
        let scatter = beliefs[*effect].ratio * noise;
        all[*effect] = (scatter.powi(2) - noise.powi(2)).max(0.0).sqrt();
    }
    all
}

/// By number and ride the variance by which the effects that vary move it more than usual, each but its own, and that of
/// remainders of changes.
fn extra_variance(history: &History, variation: &[f64]) -> Vec<Vec<f64>> {
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
    for (of_number, remainder) in all.iter_mut().zip(&history.remainder_variance) {
        beyond_usual(of_number);
        of_number.iter_mut().zip(remainder).for_each(|(v, remainder)| *v += remainder);
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
    all: &'a AllRides<'a>,
    /// Difference of each number.
    numbers: &'a [Option<Difference>],
    /// By ride and effect.
    parts: Vec<Vec<Part>>,
}

/// The sum that shows one effect.
pub(crate) struct Sum {
    /// By ride; not a number where a ride knows too little of it.
    pub values: Vec<f64>,
    pub errors: Vec<f64>,
    /// As in [`Column`].
    extra_variance: Vec<f64>,
    /// Of the scatter that independent numbers would have.
    pub belief: Belief,
}

impl<'a> Sums<'a> {
    /// With the scatter of numbers that were compared.
    pub(crate) fn new(all: &'a AllRides<'a>, numbers: &'a [Option<Difference>]) -> Self {
        let parts = (0..all.history.len()).map(|ride| parts(all, numbers, ride)).collect();
        Sums { all, numbers, parts }
    }

    /// The difference of an effect's sum between some rides and the others. Its error is at least that of the effect's own
    /// number from its variation alone: no sum is surer of a steering zero than zeros are alike.
    pub(crate) fn difference(&self, effect: usize, rides: &Rides) -> Option<Difference> {
        let sum = self.of(effect, rides)?;
        let belief = sum.belief.learnt(self.all.history.scatter_of_sums[effect]);
        let (values, errors) = (&sum.values, &sum.errors);
        let column = Column { values, errors, extra_variance: &sum.extra_variance };
        let by_sum = difference(column, rides, belief)?;
        let Some(own) = self.numbers[effect] else { return Some(by_sum) };
        let noise = self.all.noise[effect];
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
        let history = self.all.history;
        let place = history.traces.iter().position(|(number, _)| *number == effect)?;
        let parts = || self.parts.iter().map(|of_ride| &of_ride[place]);
        let shares = || (0..history.len()).map(|i| rides.share(i));
        let sum: f64 = parts().zip(shares()).map(|(part, share)| share * part.known).sum();
        let information = sum / shares().sum::<f64>();
        if !(information > 0.0 && information.is_finite()) {
            return None;
        }
        let column = |of: fn(&Part) -> f64| -> Vec<f64> {
            let known = |part: &Part| part.known > LEAST_KNOWN * information;
            parts().map(|part| if known(part) { of(part) } else { f64::NAN }).collect()
        };
        let finite = |values: &[f64]| values.iter().filter(|v| v.is_finite()).count();
        let (values, errors) = (column(|part| part.value), column(|part| part.noise));
        // of too few rides the scatter would be no more than what is believed
        if 2 * finite(&values) < finite(&history.values[effect]) {
            return None;
        }
        let mut extra_variance = column(|part| part.extra_variance);
        beyond_usual(&mut extra_variance);
        let remainder = column(|part| part.remainder_variance);
        extra_variance.iter_mut().zip(remainder).for_each(|(v, remainder)| *v += remainder);
        let ratio = information.sqrt().recip() / median_of_finite(&errors)?;
        let belief = Belief { ratio, natural: 0.0, freedom: BELIEF };
        Some(Sum { values, errors, extra_variance, belief })
    }
}

/// What one ride says of an effect.
#[derive(Debug, Clone, Default)]
struct Part {
    value: f64,
    /// Standard error of the value.
    noise: f64,
    /// Variance by other effects.
    extra_variance: f64,
    /// Variance of remainders of changes.
    remainder_variance: f64,
    /// The information.
    known: f64,
}

/// What a ride says of each effect.
///
/// METHOD: the sum of effect `e` takes `T_e' W T_f` of a unit of effect `f`, with `W` the inverse squared scatters. That is
/// the same for `f` and `e`. So it is made once for each pair, of the slopes that are not zero.
fn parts(all: &AllRides<'_>, numbers: &[Option<Difference>], ride: usize) -> Vec<Part> {
    let history = all.history;
    let count = history.traces.len();
    let mut parts = vec![Part::default(); count];
    let mut shared = vec![0.0; count * count];
    for (p, slopes) in all.slopes[ride].iter().enumerate() {
        let value = history.values[p][ride];
        let Some(d) = numbers[p].filter(|_| value.is_finite()) else { continue };
        let precision = d.scatter.powi(2).recip();
        let (error, remainder) = (history.errors[p][ride], history.remainder_variance[p][ride]);
        for (k, (effect, slope)) in slopes.iter().enumerate() {
            let weight = slope * precision;
            let part = &mut parts[*effect];
            part.value += weight * (value - all.middle[p]);
            part.noise += (weight * error).powi(2);
            part.remainder_variance += weight * weight * remainder;
            let of_effect = &mut shared[effect * count..][..count];
            slopes[k..].iter().for_each(|(other, slope)| of_effect[*other] += weight * slope);
        }
    }
    for (effect, part) in parts.iter_mut().enumerate() {
        let by_other = |(other, (number, _)): (usize, &(usize, Vec<Vec<f64>>))| {
            let by_one = shared[effect.min(other) * count + effect.max(other)];
            if other == effect { 0.0 } else { (by_one * all.variation[*number]).powi(2) }
        };
        let known = shared[effect * count + effect];
        *part = Part {
            value: part.value / known,
            noise: part.noise.sqrt() / known,
            extra_variance: history.traces.iter().enumerate().map(by_other).sum::<f64>()
                / known.powi(2),
            remainder_variance: part.remainder_variance / known.powi(2),
            known,
        };
    }
    parts
}

#[cfg(test)]
mod tests {
    use super::super::tests::{put, put_trace, ride};
    use super::*;

    /// Rides whose traces differ, and of which some numbers are not known.
    fn rides() -> Vec<super::super::numbers::Ride> {
        let of = |k: usize| {
            let mut ride = ride(5, k, &[]);
            put_trace(&mut ride, "latency", "drag", 0.1 * k as f64);
            put_trace(&mut ride, "wind", "drag", 0.4 - 0.1 * k as f64);
            if k.is_multiple_of(3) {
                put_trace(&mut ride, "latency", "radius_front", 2.0);
                put_trace(&mut ride, "wind", "radius_front", 0.7);
            }
            if k == 4 {
                put(&mut ride, "drag", f64::NAN);
            }
            ride
        };
        (0..8).map(of).collect()
    }

    /// Each part by plain sums over numbers and effects.
    #[test]
    fn parts_are_plain_sums() {
        let mut history = History::new(rides());
        history.remainder_variance.iter_mut().flatten().enumerate().for_each(|(i, v)| {
            *v = 1e-9 * i as f64;
        });
        let all = AllRides::new(&history);
        let numbers = all.differences(&Rides::one(1, history.len()));
        let sums = Sums::new(&all, &numbers);
        let mut most: f64 = 0.0;
        for ride in 0..history.len() {
            for (place, (effect, by_ride)) in history.traces.iter().enumerate() {
                let [mut top, mut noise, mut remainder, mut known] = [0.0; 4];
                let mut by_effect = vec![0.0; history.traces.len()];
                for (p, slope) in by_ride[ride].iter().enumerate() {
                    let Some(d) = numbers[p].filter(|_| history.values[p][ride].is_finite()) else {
                        continue;
                    };
                    let weight = slope / d.scatter.powi(2);
                    top += weight * (history.values[p][ride] - all.middle[p]);
                    noise += (weight * history.errors[p][ride]).powi(2);
                    remainder += weight.powi(2) * history.remainder_variance[p][ride];
                    known += weight * slope;
                    for (by, (_, other)) in by_effect.iter_mut().zip(&history.traces) {
                        *by += weight * other[ride][p];
                    }
                }
                let others =
                    history.traces.iter().zip(&by_effect).filter(|((e, _), _)| e != effect);
                let by_others: f64 =
                    others.map(|((e, _), by)| (by * all.variation[*e]).powi(2)).sum();
                let part = &sums.parts[ride][place];
                let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
                assert!(same(part.value, top / known) && same(part.known, known), "{part:?}");
                assert!(same(part.noise, noise.sqrt() / known), "{part:?}");
                assert!(same(part.extra_variance, by_others / known.powi(2)), "{part:?}");
                assert!(same(part.remainder_variance, remainder / known.powi(2)), "{part:?}");
                most = most.max(part.extra_variance);
            }
        }
        assert!(most > 0.0, "no effect moves another's sum");
    }
}
