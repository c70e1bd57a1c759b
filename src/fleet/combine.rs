//! One estimate of each tyre from all its rides: shared errors stay, independent ones average out.
//!
//! ```text
//! y_s = theta + S_s d + b_s + e_s        d ~ N(0, 1): errors that all rides of the motorcycle share
//!                                        b_s ~ N(0, tau^2): what differs from ride to ride
//!                                        e_s: the ride's own errors, correlated through its zeros
//! H = sum_s [1 S_s]' R_s^-1 [1 S_s] + diag(0, 1),   g = sum_s [1 S_s]' R_s^-1 y_s,   (theta, d) = H^-1 g
//! R_s = own scatter + sum_k shift_k shift_k' + tau^2 + (0.3 S_s)^2
//! ```
//!
//! All coefficients of a motorcycle are combined at once, so that a shared error which moves several of them, or moves them
//! more in one ride than in another, is estimated: that is what variety of riding tells of the bike file. A shared error
//! that moves every ride alike leaves the estimate as uncertain as one ride does. How much a ride is moved is itself known
//! to a third only (the last term), and slopes that vary by less than their size count as one: their noise goes with the
//! values' and would be taken for variety. Taken for it, they moved the crown radius by 6 % over thirty simulated rides;
//! this way it moves by 1 %.
//! An error that a ride is too sure to state apart (`fit::evidence` counts small ones to the model's) is there all the same: it
//! has the middle of what the other rides state, or, where most do not state it, it is the model's in all. Left out, it
//! looked like variety: a hundred rides moved the front cornering stiffness by 14 %, and 2 % since.
//!
//! Coefficients of one sign are combined as logarithms: errors of stiffnesses and friction go with their size.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use super::evidence::Piece;
use super::slopes::{self, Slopes};
use crate::contract::coefficient::Coefficient;
use crate::contract::error_source::{MODEL, OWN};
use crate::statistics::interval::{combined_dof, t95};

/// How well it is known what a shared error does to a ride, a share.
const SLOPE: f64 = 0.3;
/// Rounds of the spread between rides.
const ROUNDS: usize = 6;
/// Fewest rides that a spread is estimated from; of fewer it is `FEW` of the value.
const RIDES: usize = 4;
const FEW: f64 = 0.02;
/// The same of a rolling radius: pressure, temperature and wear of one tyre leave it within this, an estimate.
const FEW_RADIUS: f64 = 0.003;

/// A coefficient of one tyre on one motorcycle: its rides are combined.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    /// Which of the tyres that were on that wheel, the first is 0.
    pub specimen: usize,
    /// Name of the coefficient.
    pub coefficient: String,
}

/// A ride's pieces with the key that each belongs to.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ride<'a> {
    /// Id of the session.
    pub session: &'a str,
    /// Its pieces, those of one key one after the other.
    pub pieces: Vec<(Key, &'a Piece)>,
}

/// One coefficient of one tyre.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Motorcycle, tyre and coefficient.
    pub key: Key,
    /// Weighted mean of the rides, in the coefficient's unit.
    pub value: f64,
    pub std_error: f64,
    /// Ends of the 95 % interval.
    pub interval: [f64; 2],
    /// Rides that took part.
    pub rides: usize,
    /// Share of the variance that more rides of the same motorcycle cannot take away.
    pub shared: f64,
    /// Spread between rides beyond their errors.
    pub between: f64,
    /// Median of the rides' own values.
    pub median: f64,
    /// The shared error that makes most of the variance, and its share.
    pub most: Option<(String, f64)>,
    /// Shift of the value by one standard deviation of each remaining shared error, with its sign.
    pub parts: Vec<(String, f64)>,
}

/// A shared error after all rides, in its own standard deviations.
#[derive(Debug, Clone, PartialEq)]
pub struct Shared {
    /// Name of the error.
    pub source: String,
    /// The number that was taken and its standard error, where it is one.
    pub taken: Option<[f64; 2]>,
    pub found: f64,
    /// Its standard error; 1 where the rides tell nothing of it.
    pub std_error: f64,
}

/// All of one motorcycle.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Combined {
    /// Coefficients in order of key.
    pub estimates: Vec<Estimate>,
    /// Shared errors of more than one coefficient, in order of name.
    pub shared: Vec<Shared>,
    /// Whether each coefficient is its rides' median, because together they could not be solved.
    pub alone: bool,
}

/// A ride on the scales of the fit.
pub(super) struct Rows {
    /// Places among the keys.
    keys: Vec<usize>,
    y: DVector<f64>,
    /// Slopes on the shared errors, row by row: place and shift.
    slopes: Slopes,
    /// Covariance of the ride's own errors.
    own: DMatrix<f64>,
}

/// The scale of a key: of one sign, the logarithm of the size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Scale {
    /// Logarithm, of values of this sign.
    Log(f64),
    Linear,
}

impl Scale {
    /// That of some values.
    pub(super) fn of(values: &[f64]) -> Scale {
        match () {
            () if values.iter().all(|x| *x > 0.0) => Scale::Log(1.0),
            () if values.iter().all(|x| *x < 0.0) => Scale::Log(-1.0),
            () => Scale::Linear,
        }
    }

    /// A number of the scale as a value.
    pub(super) fn value(self, y: f64) -> f64 {
        match self {
            Scale::Log(sign) => sign * y.exp(),
            Scale::Linear => y,
        }
    }

    fn scaled(self, value: f64) -> f64 {
        match self {
            Scale::Log(sign) => (sign * value).ln(),
            Scale::Linear => value,
        }
    }

    /// A shift of a value on this scale.
    pub(super) fn shift(self, value: f64, shift: f64) -> f64 {
        match self {
            Scale::Log(_) => shift / value,
            Scale::Linear => shift,
        }
    }
}

/// The rides of one motorcycle as equations.
pub(super) struct Problem {
    pub(super) keys: Vec<Key>,
    pub(super) scales: Vec<Scale>,
    /// Names of the shared errors, with the key's place where it is that coefficient's alone.
    pub(super) sources: Vec<(String, Option<usize>)>,
    taken: Vec<Option<[f64; 2]>>,
    rides: Vec<Rows>,
    /// By key: rides and the place of its row in each.
    pub(super) places: Vec<Vec<(usize, usize)>>,
}

/// Combines the rides of one motorcycle.
pub(crate) fn combine(rides: &[Ride<'_>]) -> Combined {
    let Some(problem) = Problem::new(rides, |_, values| Scale::of(values)) else {
        return Combined::default();
    };
    let mut tau = vec![0.0; problem.keys.len()];
    let mut solution = None;
    for round in 0..ROUNDS {
        let Some(found) = problem.solve(&tau) else { break };
        for (k, tau) in tau.iter_mut().enumerate() {
            *tau = problem.between(&found, k);
        }
        if round + 1 == ROUNDS {
            solution = problem.solve(&tau);
        }
    }
    match solution.filter(|found| found.x.iter().all(|x| x.is_finite())) {
        Some(found) => problem.combined(&found, &tau),
        None => problem.alone(),
    }
}

/// `H^-1 g`, `H^-1`, and the covariance of the coefficients if the shared errors were known.
pub(super) struct PooledSolution {
    pub(super) x: DVector<f64>,
    pub(super) covariance: DMatrix<f64>,
    pub(super) alone: DMatrix<f64>,
}

impl Problem {
    /// Of some rides, each key on the scale that `scale` gives it by its values; `None` of none.
    pub(super) fn new(
        rides: &[Ride<'_>],
        scale: impl Fn(&Key, &[f64]) -> Scale,
    ) -> Option<Problem> {
        let mut values: BTreeMap<&Key, Vec<f64>> = BTreeMap::new();
        for ride in rides {
            let mut last = None;
            for (key, piece) in &ride.pieces {
                if last != Some(key) {
                    values.entry(key).or_default().push(piece.value);
                }
                last = Some(key);
            }
        }
        let keys: Vec<Key> = values.keys().map(|k| (*k).clone()).collect();
        let scales: Vec<Scale> = values.iter().map(|(key, v)| scale(key, v)).collect();
        let place: BTreeMap<&Key, usize> = keys.iter().enumerate().map(|(i, k)| (k, i)).collect();
        let mut sources: BTreeMap<(String, Option<usize>), Option<[f64; 2]>> = BTreeMap::new();
        for (key, piece) in rides.iter().flat_map(|r| &r.pieces).filter(|p| p.1.shared) {
            sources.insert(source(piece, place[key]), piece.taken);
        }
        // takes what most rides do not state apart
        for k in 0..keys.len() {
            sources.entry((MODEL.to_owned(), Some(k))).or_default();
        }
        let names: Vec<(String, Option<usize>)> = sources.keys().cloned().collect();
        let number: BTreeMap<&(String, Option<usize>), usize> =
            names.iter().enumerate().map(|(i, n)| (n, i)).collect();
        let mut places = vec![Vec::new(); keys.len()];
        let mut rows = Vec::with_capacity(rides.len());
        for (r, ride) in rides.iter().enumerate() {
            let mut own: BTreeMap<&str, Vec<(usize, f64)>> = BTreeMap::new();
            let mut of_ride = Rows {
                keys: Vec::new(),
                y: DVector::zeros(0),
                slopes: Vec::new(),
                own: DMatrix::zeros(0, 0),
            };
            let mut y = Vec::new();
            for (key, piece) in &ride.pieces {
                let k = place[key];
                let scale = scales[k];
                if of_ride.keys.last() != Some(&k) {
                    places[k].push((r, of_ride.keys.len()));
                    of_ride.keys.push(k);
                    of_ride.slopes.push(Vec::new());
                    y.push(scale.scaled(piece.value));
                }
                let row = of_ride.keys.len() - 1;
                let shift = scale.shift(piece.value, piece.shift);
                match piece.shared {
                    true => of_ride.slopes[row].push((number[&source(piece, k)], shift)),
                    false => own.entry(&piece.source).or_default().push((row, shift)),
                }
            }
            let n = y.len();
            let mut covariance = DMatrix::zeros(n, n);
            for (name, shifts) in own {
                for (i, a) in &shifts {
                    for (j, b) in &shifts {
                        // the scatter of each coefficient is its own
                        if i == j || name != OWN {
                            covariance[(*i, *j)] += a * b;
                        }
                    }
                }
            }
            of_ride.y = DVector::from_vec(y);
            of_ride.own = covariance;
            rows.push(of_ride);
        }
        let model = |k: usize| number[&(MODEL.to_owned(), Some(k))];
        let mut of_rides: Vec<Slopes> =
            rows.iter_mut().map(|r| std::mem::take(&mut r.slopes)).collect();
        slopes::stated(&mut of_rides, &places, names.len(), model);
        let varied: Vec<bool> =
            keys.iter().map(|k| !slopes::is_of_its_ride(&k.coefficient)).collect();
        slopes::steady(&mut of_rides, &places, &varied, names.len());
        rows.iter_mut().zip(of_rides).for_each(|(row, slopes)| row.slopes = slopes);
        let taken = sources.into_values().collect();
        (!keys.is_empty()).then_some(Problem {
            keys,
            scales,
            sources: names,
            taken,
            rides: rows,
            places,
        })
    }

    /// Least squares at given spreads between rides.
    pub(super) fn solve(&self, tau: &[f64]) -> Option<PooledSolution> {
        let (keys, size) = (self.keys.len(), self.keys.len() + self.sources.len());
        let (mut h, mut g) = (DMatrix::zeros(size, size), DVector::zeros(size));
        (keys..size).for_each(|i| h[(i, i)] = 1.0);
        for ride in self.rides.iter().filter(|r| !r.keys.is_empty()) {
            let n = ride.keys.len();
            let mut r = ride.own.clone();
            let mut a = DMatrix::zeros(n, size);
            for (i, k) in ride.keys.iter().enumerate() {
                let slopes = &ride.slopes[i];
                let unsure: f64 = slopes.iter().map(|s| (SLOPE * s.1).powi(2)).sum();
                let size = match self.scales[*k] {
                    Scale::Log(_) => 1.0,
                    Scale::Linear => ride.y[i].abs().max(1e-9),
                };
                r[(i, i)] += tau[*k] * tau[*k] + unsure + (1e-6 * size).powi(2);
                a[(i, *k)] = 1.0;
                slopes.iter().for_each(|(j, shift)| a[(i, keys + j)] += shift);
            }
            let weighed = r.cholesky()?.solve(&a);
            h += a.transpose() * &weighed;
            g += weighed.transpose() * &ride.y;
        }
        let alone = h.view((0, 0), (keys, keys)).clone_owned().cholesky()?.inverse();
        let whole = h.cholesky()?;
        Some(PooledSolution { x: whole.solve(&g), covariance: whole.inverse(), alone })
    }

    /// A ride's value less the estimate and the shared errors, and its own variance.
    pub(super) fn residual(
        &self,
        found: &PooledSolution,
        k: usize,
        (r, row): (usize, usize),
    ) -> (f64, f64) {
        let ride = &self.rides[r];
        let slopes = &ride.slopes[row];
        let shared: f64 = slopes.iter().map(|(j, s)| s * found.x[self.keys.len() + j]).sum();
        let unsure: f64 = slopes.iter().map(|s| (SLOPE * s.1).powi(2)).sum();
        (ride.y[row] - found.x[k] - shared, ride.own[(row, row)] + unsure)
    }

    /// Spread between rides where there are too few to tell it.
    pub(super) fn few(&self, found: &PooledSolution, k: usize) -> f64 {
        let size = match self.scales[k] {
            Scale::Log(_) => 1.0,
            Scale::Linear => found.x[k].abs(),
        };
        let radius = self.keys[k].coefficient == Coefficient::EffectiveRollingRadius.name();
        (if radius { FEW_RADIUS } else { FEW }) * size
    }

    /// Spread between rides: the squared residuals are as large as they should be.
    fn between(&self, found: &PooledSolution, k: usize) -> f64 {
        let all: Vec<(f64, f64)> =
            self.places[k].iter().map(|p| self.residual(found, k, *p)).collect();
        if all.len() < RIDES {
            return self.few(found, k);
        }
        let free = all.len() as f64 - 1.0;
        let excess =
            |t2: f64| all.iter().map(|(r, v)| r * r / (v + t2 + 1e-30)).sum::<f64>() - free;
        if excess(0.0) <= 0.0 {
            return 0.0;
        }
        let (mut low, mut high) = (0.0, all.iter().map(|(r, _)| r * r).sum::<f64>());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if excess(middle) > 0.0 { low = middle } else { high = middle }
        }
        high.sqrt()
    }

    fn combined(&self, found: &PooledSolution, tau: &[f64]) -> Combined {
        let keys = self.keys.len();
        let estimate = |k: usize| -> Option<Estimate> {
            let variance = found.covariance[(k, k)];
            let rides = self.places[k].len();
            if rides == 0 || variance <= 0.0 {
                return None;
            }
            let part = |j: usize| {
                let at = keys + j;
                found.covariance[(k, at)] / found.covariance[(at, at)].sqrt()
            };
            let parts = (0..self.sources.len())
                .map(|j| (self.sources[j].0.clone(), part(j).powi(2) / variance));
            let most = parts.max_by(|a, b| a.1.total_cmp(&b.1));
            let shared = (1.0 - found.alone[(k, k)] / variance).clamp(0.0, 1.0);
            let free = (rides as f64 - 1.0).max(1.0);
            let own = (variance * (1.0 - shared)).sqrt();
            let dof =
                combined_dof(&[(own, free + 2.0), ((variance * shared).sqrt(), f64::INFINITY)]);
            let (y, half, scale) = (found.x[k], t95(dof) * variance.sqrt(), self.scales[k]);
            let value = scale.value(y);
            let ends = [y - half, y + half].map(|y| scale.value(y));
            let size = if scale == Scale::Linear { 1.0 } else { value.abs() };
            let mut values: Vec<f64> =
                self.places[k].iter().map(|(r, row)| scale.value(self.rides[*r].y[*row])).collect();
            Some(Estimate {
                key: self.keys[k].clone(),
                value,
                std_error: variance.sqrt() * size,
                interval: [ends[0].min(ends[1]), ends[0].max(ends[1])],
                rides,
                shared,
                between: tau[k] * size,
                median: crate::statistics::order::median(&mut values)?,
                most,
                parts: (0..self.sources.len())
                    .map(|j| (self.sources[j].0.clone(), part(j) * size))
                    .filter(|(_, part)| *part != 0.0)
                    .collect(),
            })
        };
        let shared = |j: usize| {
            let (source, alone) = &self.sources[j];
            alone.is_none().then(|| Shared {
                source: source.clone(),
                taken: self.taken[j],
                found: found.x[keys + j],
                std_error: found.covariance[(keys + j, keys + j)].sqrt(),
            })
        };
        Combined {
            estimates: (0..keys).filter_map(estimate).collect(),
            shared: (0..self.sources.len()).filter_map(shared).collect(),
            alone: false,
        }
    }

    /// Each coefficient as the median of its rides with the error of the middle one, of which nothing averages out: for
    /// motorcycles whose matrices have no inverse.
    fn alone(&self) -> Combined {
        let middle = |mut all: Vec<f64>| crate::statistics::order::median(&mut all);
        let estimate = |k: usize| -> Option<Estimate> {
            let scale = self.scales[k];
            let of = |f: &dyn Fn(&Rows, usize) -> f64| -> Option<f64> {
                let all = self.places[k].iter().map(|(r, row)| f(&self.rides[*r], *row));
                middle(all.filter(|x| x.is_finite()).collect())
            };
            let y = of(&|ride, row| ride.y[row])?;
            let error = of(&|ride, row| {
                let shared: f64 = ride.slopes[row].iter().map(|s| s.1 * s.1).sum();
                (ride.own[(row, row)] + shared).sqrt()
            })?;
            let value = scale.value(y);
            let ends = [-1.0, 1.0].map(|side| scale.value(y + side * t95(1e9) * error));
            let std_error = error * if scale == Scale::Linear { 1.0 } else { value.abs() };
            Some(Estimate {
                key: self.keys[k].clone(),
                value,
                std_error,
                interval: [ends[0].min(ends[1]), ends[0].max(ends[1])],
                rides: self.places[k].len(),
                shared: 1.0,
                between: 0.0,
                median: value,
                most: Some((MODEL.to_owned(), 1.0)),
                parts: vec![(MODEL.to_owned(), -std_error)],
            })
        };
        Combined {
            estimates: (0..self.keys.len()).filter_map(estimate).collect(),
            shared: Vec::new(),
            alone: true,
        }
    }
}

/// A shared error: of the model each coefficient has its own.
fn source(piece: &Piece, key: usize) -> (String, Option<usize>) {
    (piece.source.clone(), (piece.source == MODEL).then_some(key))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    const TRUTH: f64 = 12.0;

    fn piece(session: &str, value: f64, source: &str, shared: bool, shift: f64) -> Piece {
        Piece {
            session: session.into(),
            tyre: "front".into(),
            coefficient: "c".into(),
            value,
            source: source.into(),
            shared,
            shift,
            taken: (source == "mass").then_some([250.0, 2.0]),
            ..Piece::default()
        }
    }

    fn key() -> Key {
        Key { tyre: "front".into(), specimen: 0, coefficient: "c".into() }
    }

    /// Rides whose value is off by a shared error of 5 % and own errors of 3 %, with a shift of the shared one by ride.
    fn rides<'a>(pieces: &'a [[Piece; 2]]) -> Vec<Ride<'a>> {
        pieces
            .iter()
            .map(|of_ride| Ride {
                session: &of_ride[0].session,
                pieces: of_ride.iter().map(|p| (key(), p)).collect(),
            })
            .collect()
    }

    fn drawn(random: &mut Random, n: usize, slope: impl Fn(usize) -> f64) -> Vec<[Piece; 2]> {
        let shared = random.normal();
        (0..n)
            .map(|i| {
                let value = TRUTH * (1.0 + 0.05 * slope(i) * shared + 0.03 * random.normal());
                let session = format!("s{i}");
                [
                    piece(&session, value, "mass", true, 0.05 * slope(i) * value),
                    piece(&session, value, OWN, false, 0.03 * value),
                ]
            })
            .collect()
    }

    #[test]
    fn shared_errors_stay_and_independent_ones_average_out() {
        let mut random = Random::new(7, "shared");
        for n in [1, 10, 100] {
            let mut held = 0;
            for _ in 0..200 {
                let pieces = drawn(&mut random, n, |_| 1.0);
                let found = combine(&rides(&pieces));
                let e = &found.estimates[0];
                held += usize::from((e.interval[0]..=e.interval[1]).contains(&TRUTH));
            }
            assert!(held >= 182, "{n} rides: {held} of 200");
        }
        let pieces = drawn(&mut random, 100, |_| 1.0);
        let e = &combine(&rides(&pieces)).estimates[0];
        assert!((0.045..0.062).contains(&(e.std_error / e.value)), "{e:?}");
        assert!(e.shared > 0.9 && e.most.as_ref().is_some_and(|m| m.0 == "mass"), "{e:?}");
    }

    #[test]
    fn variety_shows_the_shared_error() {
        let mut random = Random::new(8, "variety");
        // the mass moves every other ride the other way
        let slope = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
        let pieces = drawn(&mut random, 60, slope);
        let found = combine(&rides(&pieces));
        let (e, mass) = (&found.estimates[0], &found.shared[0]);
        assert!(e.std_error / e.value < 0.01, "{e:?}");
        assert!(mass.std_error < 0.25 && mass.taken == Some([250.0, 2.0]), "{mass:?}");
        // and where every ride is moved alike nothing of it
        let pieces = drawn(&mut random, 60, |_| 1.0);
        let mass = &combine(&rides(&pieces)).shared[0];
        assert!(mass.std_error > 0.98 && mass.found.abs() < 0.2, "{mass:?}");
    }

    /// Every third ride does not state the mass apart: it is no ride without that error.
    #[test]
    fn an_error_that_some_rides_do_not_state_is_no_variety() {
        let mut random = Random::new(11, "unstated");
        let mut pieces = drawn(&mut random, 60, |_| 1.0);
        for (i, of_ride) in pieces.iter_mut().enumerate() {
            if i % 3 == 0 {
                of_ride[0].source = MODEL.into();
                of_ride[0].taken = None;
            }
        }
        let found = combine(&rides(&pieces));
        let e = &found.estimates[0];
        let middle = crate::statistics::order::median(
            &mut pieces.iter().map(|p| p[0].value).collect::<Vec<_>>(),
        );
        assert!((e.value / middle.expect("rides") - 1.0).abs() < 0.01, "{e:?}");
        assert!((0.04..0.08).contains(&(e.std_error / e.value)), "{e:?}");
        assert!(found.shared.iter().all(|s| s.std_error > 0.98), "{found:?}");
    }

    #[test]
    fn what_cannot_be_solved_is_not_lost() {
        let mut random = Random::new(12, "alone");
        let mut pieces = drawn(&mut random, 7, |_| 1.0);
        // an error beyond all numbers leaves a matrix without an inverse
        pieces[3][0].shift = f64::INFINITY;
        let found = combine(&rides(&pieces));
        assert!(found.alone && found.estimates.len() == 1, "{found:?}");
        let e = &found.estimates[0];
        assert!((e.interval[0]..=e.interval[1]).contains(&TRUTH), "{e:?}");
        assert!((0.05..0.07).contains(&(e.std_error / e.value)) && e.shared == 1.0, "{e:?}");
    }

    #[test]
    fn one_ride_has_its_own_interval_and_none_is_no_matter() {
        assert_eq!(combine(&[]), Combined::default());
        let mut random = Random::new(9, "one");
        let pieces = drawn(&mut random, 1, |_| 1.0);
        let e = &combine(&rides(&pieces)).estimates[0];
        let alone = 0.05_f64.hypot(0.03);
        let relative = e.std_error / e.value;
        assert!((alone..1.15 * alone).contains(&relative), "{relative}");
        assert!((e.value - pieces[0][0].value).abs() < 1e-9);
    }
}
