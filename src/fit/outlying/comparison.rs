//! One manoeuvre against the others of its ride.
//!
//! METHOD: each manoeuvre is predicted from the others by least squares, and its difference divided by what it would
//! scatter by in a ride without anything odd. With `w = 1 / (1 + (error / s0)^2)`, over the others:
//!
//! ```text
//! b   = (X' W X)^-1 X' W y
//! s^2 = (n0 s0^2 + sum w r^2) / (n0 + n - p)          prior: s0, worth n0 manoeuvres
//! q   = x' (X' W X)^-1 x
//! t   = (y - x' b) / sqrt(max(s^2 (1 / w + q), s^2 (1 + q) + error^2)),  n0 + n - p degrees of freedom
//! ```
//! A ride has few stops: their own scatter alone says little of what is usual, what other rides scattered by says most.

use nalgebra::{DMatrix, DVector};
use statrs::distribution::{ContinuousCDF, StudentsT};

use crate::statistics::interval::t95;

/// Value of a quantity in one manoeuvre.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Shown {
    /// Index of the segment.
    pub segment: usize,
    /// The quantity, in its unit.
    pub value: f64,
    /// Standard error of it from the manoeuvre's own samples.
    pub error: f64,
    /// Covariates of the quantity, the same number for each manoeuvre.
    pub columns: Vec<f64>,
}

/// How much manoeuvres of one ride differ where nothing is odd.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Scatter {
    /// Standard deviation, in the quantity's unit.
    pub sd: f64,
    /// Manoeuvres that this knowledge is worth.
    pub worth: f64,
}

/// A manoeuvre beside the others of its ride.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// Index of the segment.
    pub segment: usize,
    pub value: f64,
    /// Value expected from the others.
    pub expected: f64,
    /// 95 % interval of the difference.
    pub interval: [f64; 2],
    /// Difference in units of its standard deviation.
    pub t: f64,
    /// Probability of so large a difference where nothing is odd.
    pub chance: f64,
    pub others: usize,
}

/// Others beyond the coefficients that are fitted to them.
const SPARE: usize = 1;

/// Each manoeuvre beside those that are left.
pub(crate) fn compare(shown: &[Shown], scatter: Scatter) -> Vec<Compared> {
    (0..shown.len()).filter_map(|place| against_others(shown, place, scatter)).collect()
}

/// Odd manoeuvres of a quantity: more are none.
const MAX_ODD: usize = 10;

/// The manoeuvres whose difference has a chance below `least`, the most unlikely first.
///
/// METHOD: two like ones hide each other, as each moves and widens what the other is compared with. So the most unlikely
/// is taken out again and again, up to a third of them, and all up to the last one with a chance below `least` are
/// outlying (generalised extreme Studentised deviates, Rosner 1983, Technometrics 25). Each is then compared with those
/// that are left.
pub(crate) fn outlying(mut shown: Vec<Shown>, scatter: Scatter, least: f64) -> Vec<Compared> {
    shown.retain(|s| s.value.is_finite() && s.columns.iter().all(|x| x.is_finite()));
    let mut usual = shown.clone();
    let mut out: Vec<usize> = Vec::new();
    let mut kept = 0;
    while out.len() < (shown.len() / 3).min(MAX_ODD) {
        let compared = compare(&usual, scatter).into_iter();
        let Some(worst) = compared.min_by(|a, b| a.chance.total_cmp(&b.chance)) else { break };
        usual.retain(|s| s.segment != worst.segment);
        out.push(worst.segment);
        if worst.chance < least {
            kept = out.len();
        }
    }
    out.truncate(kept);
    let usual: Vec<Shown> = shown.iter().filter(|s| !out.contains(&s.segment)).cloned().collect();
    let odd = shown.into_iter().filter(|s| out.contains(&s.segment));
    let mut found: Vec<Compared> = odd
        .filter_map(|own| {
            let mut all = usual.clone();
            all.push(own);
            against_others(&all, all.len() - 1, scatter)
        })
        .collect();
    found.sort_by(|a, b| a.chance.total_cmp(&b.chance));
    found
}

fn against_others(shown: &[Shown], place: usize, scatter: Scatter) -> Option<Compared> {
    let own = &shown[place];
    let p = own.columns.len();
    let others: Vec<&Shown> =
        shown.iter().enumerate().filter(|(i, _)| *i != place).map(|(_, s)| s).collect();
    let n = others.len();
    if n < p + SPARE {
        return None;
    }
    let weight = |s: &Shown| 1.0 / (1.0 + (s.error / scatter.sd).powi(2));
    let mut information = DMatrix::<f64>::zeros(p, p);
    let mut sum = DVector::<f64>::zeros(p);
    for s in &others {
        let w = weight(s);
        for j in 0..p {
            sum[j] += w * s.columns[j] * s.value;
            for k in 0..p {
                information[(j, k)] += w * s.columns[j] * s.columns[k];
            }
        }
    }
    let inverse = information.cholesky()?.inverse();
    let b = &inverse * sum;
    let predicted = |s: &Shown| s.columns.iter().zip(b.iter()).map(|(x, b)| x * b).sum::<f64>();
    let left: f64 = others.iter().map(|s| weight(s) * (s.value - predicted(s)).powi(2)).sum();
    let dof = scatter.worth + (n - p) as f64;
    let variance = (scatter.worth * scatter.sd * scatter.sd + left) / dof;
    let x = DVector::from_column_slice(&own.columns);
    let reach = (x.transpose() * &inverse * &x)[(0, 0)];
    // its own error is none of the others' scatter, and does not shrink with it
    let with_own = variance * (1.0 + reach) + own.error * own.error;
    let sd = (variance * (1.0 / weight(own) + reach)).max(with_own).sqrt();
    let expected = predicted(own);
    let difference = own.value - expected;
    let t = difference / sd;
    let half = t95(dof) * sd;
    let chance = 2.0 * StudentsT::new(0.0, 1.0, dof).ok()?.sf(t.abs());
    let interval = [difference - half, difference + half];
    let finite = t.is_finite();
    finite.then_some(Compared {
        segment: own.segment,
        value: own.value,
        expected,
        interval,
        t,
        chance,
        others: n,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    const SCATTER: Scatter = Scatter { sd: 0.02, worth: 5.0 };

    fn shown(values: &[f64]) -> Vec<Shown> {
        let of = |(segment, value): (usize, &f64)| Shown {
            segment,
            value: *value,
            error: 0.004,
            columns: vec![1.0],
        };
        values.iter().enumerate().map(of).collect()
    }

    /// As often as it says, whatever the number of stops and their true scatter about the usual one.
    #[test]
    fn a_chance_is_how_often_it_happens() {
        let mut random = Random::new(3, "stops");
        for n in [3, 6, 12] {
            let (mut rare, mut covered, mut all) = (0, 0, 0);
            for _ in 0..1500 {
                // inverse chi squared: what a prior worth five manoeuvres says
                let drawn: f64 = (0..5).map(|_| random.normal().powi(2)).sum();
                let sd = SCATTER.sd * (5.0 / drawn).sqrt();
                let own = 0.004 * sd / SCATTER.sd;
                let values: Vec<f64> =
                    (0..n).map(|_| 1.0 + sd.hypot(own) * random.normal()).collect();
                for compared in compare(&shown(&values), SCATTER) {
                    all += 1;
                    rare += usize::from(compared.chance < 0.02);
                    covered +=
                        usize::from(compared.interval[0] < 0.0 && compared.interval[1] > 0.0);
                }
            }
            let share = |count: usize| count as f64 / all as f64;
            assert!((share(rare) - 0.02).abs() < 0.006, "{n}: {}", share(rare));
            assert!((share(covered) - 0.95).abs() < 0.012, "{n}: {}", share(covered));
        }
    }

    #[test]
    fn one_of_three_is_found_and_a_second_does_not_hide_it() {
        let odd = |values: &[f64]| -> Vec<usize> {
            outlying(shown(values), SCATTER, 2e-3).into_iter().map(|c| c.segment).collect()
        };
        assert_eq!(odd(&[1.01, 0.70, 0.99]), [1]);
        let two = [1.0, 1.01, 0.99, 1.0, 0.70, 1.02, 0.98, 0.70, 1.0];
        for least in [2e-3, 5e-4] {
            let found = outlying(shown(&two), SCATTER, least);
            let mut places: Vec<usize> = found.iter().map(|c| c.segment).collect();
            places.sort_unstable();
            assert_eq!(places, [4, 7], "{least}");
            // compared with the other seven
            assert!(
                found.iter().all(|c| c.others == 7 && c.interval[0] < -0.3 && -0.3 < c.interval[1])
            );
        }
        assert!(odd(&[1.0, 1.01, 0.99, 1.0]).is_empty());
        assert!(odd(&[1.0, 0.7]).is_empty(), "two do not say which of them is odd");
    }

    /// However little the others scatter, an error of its own stays one.
    #[test]
    fn a_vague_stop_is_not_held_to_the_scatter_of_good_ones() {
        let mut random = Random::new(5, "vague");
        let mut said = 0;
        for _ in 0..400 {
            let values: Vec<f64> = (0..40).map(|_| 1.0 + 0.005 * random.normal()).collect();
            let mut stops = shown(&values);
            stops[0].error = 0.06;
            stops[0].value = 1.0 + 0.06 * random.normal();
            said += usize::from(!outlying(stops, SCATTER, 0.01 / 40.0).is_empty());
        }
        assert!(said <= 4, "{said} of 400");
    }

    #[test]
    fn what_goes_with_the_speed_is_no_difference() {
        let run = |(segment, speed): (usize, f64)| Shown {
            segment,
            value: 0.015 + 1e-4 * speed * speed,
            error: 1e-4,
            columns: vec![1.0, speed * speed],
        };
        let mut runs: Vec<Shown> =
            [10.0, 14.0, 18.0, 22.0, 26.0].into_iter().enumerate().map(run).collect();
        let scatter = Scatter { sd: 1e-3, worth: 5.0 };
        assert!(outlying(runs.clone(), scatter, 0.01).is_empty());
        runs[2].value += 0.03;
        let found = outlying(runs, scatter, 0.01);
        assert_eq!(found.iter().map(|c| c.segment).collect::<Vec<_>>(), [2]);
        assert!((found[0].value - found[0].expected - 0.03).abs() < 1e-9);
    }
}
