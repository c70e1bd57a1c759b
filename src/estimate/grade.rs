//! Grade of the road along the ride, from altitude and climb.
//!
//! A state-space model at 1 Hz, forward filter and Rauch-Tung-Striebel smoother:
//!
//! ```text
//! h' = v g                      height of the road, m
//! g' = -v g/L + noise           grade: correlated over L = 200 m, spread s_g
//! e' = -e/T + noise             slow error of a receiver: correlated over T = 80 s, spread s_e
//! altitude = h + e + k v^2/(2 G) + noise s_r
//! climb    = v g + noise
//! ```
//!
//! METHOD: `s_g`, `s_e` and `s_r` are those of the most level road under which the ride's own altitude is hardly less likely
//! than it can be. A coarse altitude on a level road so gives a grade of nearly nothing, instead of its own noise divided
//! by the distance. `k` is the share of the
//! dynamic pressure that a barometer under a fairing feels; a hard stop tells it from a hill.

use nalgebra::{Matrix4, RowVector4, Vector4};

use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;

/// Distance over which roads keep their grade, m.
const ROAD: f64 = 200.0;
/// Time over which a receiver's slow error of altitude lasts, s.
const SLOW: f64 = 80.0;
/// Standard deviation of a satellite receiver's upward velocity, m/s, of a mean over a second.
const CLIMB_ERROR: f64 = 0.15;
/// Share of the dynamic pressure that a barometer may feel, one standard deviation.
const PRESSURE_SHARE: f64 = 0.1;
/// Steepest road that counts, rise over run.
const STEEPEST: f64 = 0.35;
/// Altitudes of a ride that are needed, s.
const LEAST: usize = 30;
/// How much of a ride shows the spreads, s.
const LONGEST: usize = 900;
/// Spreads of the grade that are tried, rise over run.
const GRADES: [f64; 7] = [0.0003, 0.002, 0.004, 0.008, 0.016, 0.032, 0.064];
/// Spreads of the slow error of the altitude that are tried, m.
const SLOW_ERRORS: [f64; 9] = [0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 5.6];
/// Noises of the altitude that are tried, m.
const NOISES: [f64; 6] = [0.03, 0.06, 0.12, 0.25, 0.5, 1.0];
/// A road is as level as a likelihood lower by this allows, natural logarithm.
const MARGIN: f64 = 8.0;
/// Innovation from which on an altitude weighs less, in standard deviations.
const FAR: f64 = 3.0;

/// The places next to one in the lists of slow errors and noises.
fn around([i, j]: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    let near = |i: usize, n: usize| i.saturating_sub(1)..(i + 2).min(n);
    near(i, SLOW_ERRORS.len())
        .flat_map(move |a| near(j, NOISES.len()).map(move |b| [a, b]))
        .filter(move |at| *at != [i, j])
}

/// Grade of the road by sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Grade {
    /// Rise over run, uphill positive.
    pub value: Vec<f64>,
    pub sd: Vec<f64>,
}

/// The grade of a session's road; `None` without altitude and climb, and where the session has its grade already.
pub(crate) fn grade(session: &Session) -> Option<Grade> {
    if session.has(Channel::Grade) {
        return None;
    }
    let speed = session.get(Channel::VelocityX)?;
    let (altitude, climb) = (session.get(Channel::Altitude), session.get(Channel::Climb));
    let step = session.rate.round().max(1.0) as usize;
    let seconds = |x: Option<&[f64]>| x.map(|x| means(x, step));
    let (altitude, climb) = (seconds(altitude), seconds(climb));
    let seen = |x: &Option<Vec<f64>>| x.iter().flatten().filter(|x| x.is_finite()).count();
    if seen(&altitude) < LEAST && seen(&climb) < LEAST {
        return None;
    }
    let mut last = 0.0;
    let speed = means(speed, step).into_iter().map(|v| {
        last = if v.is_finite() { v.max(0.0) } else { last };
        last
    });
    let ride = Ride { step: step as f64 / session.rate, speed: speed.collect(), altitude, climb };
    let knots = ride.smoothed(&ride.likeliest())?;
    let last = knots.len() - 1;
    // a knot stands in the middle of its second
    let (value, sd) = (0..session.len)
        .map(|i| {
            let at = ((i as f64 + 0.5) / step as f64 - 0.5).clamp(0.0, last as f64);
            let (k, f) = (at.floor() as usize, at.fract());
            let next = knots[(k + 1).min(last)];
            let of = |a: f64, b: f64| a + f * (b - a);
            (of(knots[k].0, next.0).clamp(-STEEPEST, STEEPEST), of(knots[k].1, next.1))
        })
        .unzip();
    Some(Grade { value, sd })
}

/// Means over `step` samples; NaN where less than half of them are known.
fn means(x: &[f64], step: usize) -> Vec<f64> {
    let mean = |chunk: &[f64]| {
        let known = chunk.iter().filter(|x| x.is_finite());
        let (n, sum) = known.fold((0, 0.0), |(n, sum), x| (n + 1, sum + x));
        if 2 * n >= chunk.len() { sum / n as f64 } else { f64::NAN }
    };
    x.chunks(step).map(mean).collect()
}

/// A ride by seconds.
struct Ride {
    /// Distance of the means, s.
    step: f64,
    /// Speed, m/s.
    speed: Vec<f64>,
    /// Altitude, m.
    altitude: Option<Vec<f64>>,
    /// Climb, m/s.
    climb: Option<Vec<f64>>,
}

/// Standard deviations of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Spread {
    /// Of the road's grade.
    grade: f64,
    /// Of the altitude's slow error, m.
    slow: f64,
    /// Of its noise, m.
    noise: f64,
}

/// Mean and covariance of `[h, g, e, k]`.
#[derive(Clone, Copy)]
struct Belief {
    mean: Vector4<f64>,
    covariance: Matrix4<f64>,
}

impl Belief {
    fn start(altitude: f64, spread: &Spread) -> Self {
        let sd =
            Vector4::new(30.0, spread.grade, spread.slow, PRESSURE_SHARE).map(|sd: f64| sd * sd);
        Belief {
            mean: Vector4::new(altitude, 0.0, 0.0, 0.0),
            covariance: Matrix4::from_diagonal(&sd),
        }
    }

    /// Takes a measurement in; its log-likelihood.
    fn take(&mut self, row: RowVector4<f64>, value: f64, sd: f64) -> f64 {
        let off = value - (row * self.mean)[0];
        let predicted = (row * self.covariance * row.transpose())[0];
        // a jump of the receiver is believed less, the farther it is
        let variance = (predicted + sd * sd).max((off / FAR).powi(2));
        let gain = self.covariance * row.transpose() / variance;
        self.mean += gain * off;
        self.covariance -= gain * (row * self.covariance);
        -0.5 * (off * off / variance + variance.ln())
    }
}

impl Ride {
    /// The step of the state at a speed: transition and variances of the noise.
    fn transition(&self, speed: f64, spread: &Spread) -> (Matrix4<f64>, Vector4<f64>) {
        let distance = speed * self.step;
        let (road, slow) = ((-distance / ROAD).exp(), (-self.step / SLOW).exp());
        let mut by = Matrix4::from_diagonal(&Vector4::new(1.0, road, slow, 1.0));
        by[(0, 1)] = distance;
        let noise = Vector4::new(
            0.0,
            spread.grade.powi(2) * (1.0 - road * road),
            spread.slow.powi(2) * (1.0 - slow * slow),
            0.0,
        );
        (by, noise)
    }

    /// Filters forward; `each` gets the belief before and after each second's measurements. Gives the log-likelihood.
    fn filtered(&self, spread: &Spread, mut each: impl FnMut(Belief, Belief)) -> f64 {
        let first = self.altitude.iter().flatten().find(|x| x.is_finite()).copied().unwrap_or(0.0);
        let mut belief = Belief::start(first, spread);
        let mut likelihood = 0.0;
        for (i, &v) in self.speed.iter().enumerate() {
            if i > 0 {
                let (by, noise) = self.transition(self.speed[i - 1], spread);
                belief.mean = by * belief.mean;
                belief.covariance =
                    by * belief.covariance * by.transpose() + Matrix4::from_diagonal(&noise);
            }
            let before = belief;
            let at = |x: &Option<Vec<f64>>| x.as_ref().map(|x| x[i]).filter(|x| x.is_finite());
            if let Some(altitude) = at(&self.altitude) {
                let row = RowVector4::new(1.0, 0.0, 1.0, v * v / (2.0 * GRAVITY));
                likelihood += belief.take(row, altitude, spread.noise);
            }
            if let Some(climb) = at(&self.climb) {
                likelihood += belief.take(RowVector4::new(0.0, v, 0.0, 0.0), climb, CLIMB_ERROR);
            }
            each(before, belief);
        }
        likelihood
    }

    /// The spreads under which the measurements are likeliest; of those that are hardly less likely the most level road.
    /// METHOD: hills and a receiver's wander are alike in part. A descent, or a coarser grid, ends in the wrong one.
    fn likeliest(&self) -> Spread {
        let beginning = self.first(LONGEST);
        // places in the lists of slow errors and noises, from which the next grade's are looked for
        let mut at = [SLOW_ERRORS.len() / 2, NOISES.len() / 2];
        let of_grade = |grade: f64| {
            let of = |[i, j]: [usize; 2]| Spread { grade, slow: SLOW_ERRORS[i], noise: NOISES[j] };
            let likelihood = |at| beginning.filtered(&of(at), |_, _| ());
            let mut highest = likelihood(at);
            loop {
                let before = at;
                for [i, j] in around(before) {
                    let now = likelihood([i, j]);
                    if now > highest {
                        (at, highest) = ([i, j], now);
                    }
                }
                if at == before {
                    return (highest, of(at));
                }
            }
        };
        let best = GRADES.map(of_grade);
        let highest = best.iter().map(|b| b.0).fold(f64::NEG_INFINITY, f64::max);
        // the last one without a likelihood: nothing finite was measured
        best.iter().find(|b| b.0 >= highest - MARGIN).map_or(best[0].1, |b| b.1)
    }

    /// Its beginning, in seconds.
    fn first(&self, seconds: usize) -> Ride {
        let of = |x: &[f64]| x[..x.len().min(seconds)].to_vec();
        let some = |x: &Option<Vec<f64>>| x.as_deref().map(of);
        Ride {
            step: self.step,
            speed: of(&self.speed),
            altitude: some(&self.altitude),
            climb: some(&self.climb),
        }
    }

    /// Grade and its standard deviation by second, of the whole ride; `None` of an empty one.
    fn smoothed(&self, spread: &Spread) -> Option<Vec<(f64, f64)>> {
        let mut beliefs = Vec::with_capacity(self.speed.len());
        self.filtered(spread, |before, after| beliefs.push((before, after)));
        let (_, mut smooth) = beliefs.last().copied()?;
        let knot = |b: &Belief| (b.mean[1], b.covariance[(1, 1)].max(0.0).sqrt());
        let mut knots = vec![knot(&smooth); beliefs.len()];
        for i in (0..beliefs.len() - 1).rev() {
            let (after, predicted) = (beliefs[i].1, beliefs[i + 1].0);
            let (by, _) = self.transition(self.speed[i], spread);
            let Some(factor) = predicted.covariance.cholesky() else { continue };
            // C = P F' M^-1
            let gain = factor.solve(&(by * after.covariance)).transpose();
            smooth = Belief {
                mean: after.mean + gain * (smooth.mean - predicted.mean),
                covariance: after.covariance
                    + gain * (smooth.covariance - predicted.covariance) * gain.transpose(),
            };
            knots[i] = knot(&smooth);
        }
        Some(knots)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;
    use crate::statistics::random::{Coloured, Random};

    /// A ride of 20 minutes that brakes and accelerates over hills of `steep`, 1 km long; the altitude has an error
    /// of `slow` m and a barometer's share of the dynamic pressure.
    fn ridden(steep: f64, slow: f64, share: f64, seed: u64) -> (Session, Vec<f64>) {
        let (rate, n) = (10.0, 12_000);
        let mut random = Random::new(seed, "grade");
        let mut error = Coloured::new(slow, 60.0, 1.0 / rate, &mut random);
        let (mut along, mut height) = (0.0_f64, 300.0);
        let mut session = Session::new(Meta::default(), rate, n);
        let (mut speed, mut altitude, mut truth) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..n {
            let v: f64 = 20.0 + 9.0 * (i as f64 / 170.0).sin();
            let g = steep * 2_f64.sqrt() * (along / 160.0).sin();
            along += v / rate;
            height += g * v / rate;
            let seen = height + error.next(&mut random) + share * v * v / (2.0 * GRAVITY);
            altitude.push(((seen + 0.2 * random.normal()) / 0.1).round() * 0.1);
            speed.push(v);
            truth.push(g);
        }
        session.set(Channel::VelocityX, speed);
        session.set(Channel::Altitude, altitude);
        (session, truth)
    }

    fn rms(x: impl Iterator<Item = f64>, n: usize) -> f64 {
        (x.map(|x| x * x).sum::<f64>() / n as f64).sqrt()
    }

    #[test]
    fn hills_are_found_within_the_stated_error_and_level_roads_stay_level() {
        for (steep, slow, share, most) in [
            // at any instant, of hills a kilometre long; a prototype had 0.010, 0.0043, 0.007
            (0.04, 2.0, 0.0, 0.013),
            (0.04, 0.3, 0.15, 0.006),
            (0.015, 2.0, 0.0, 0.009),
            (0.0, 2.0, 0.0, 0.003),
            (0.0, 0.3, 0.15, 0.001),
        ] {
            let (session, truth) = ridden(steep, slow, share, 7);
            let found = grade(&session).expect("there is altitude");
            let off = found.value.iter().zip(&truth).map(|(a, b)| a - b);
            let error = rms(off.clone(), truth.len());
            let stated = rms(found.sd.iter().copied(), truth.len());
            println!("{steep} {slow} {share}: {error:.4} stated {stated:.4}");
            assert!(error < most, "{steep} {slow} {share}: {error}");
            let fair = (0.4..2.5).contains(&(stated / error)) || error < 0.001;
            assert!(fair, "{steep}: {error}, stated {stated}");
        }
    }

    #[test]
    fn a_climb_by_a_receiver_is_enough_and_a_measured_grade_is_left_alone() {
        let (mut session, truth) = ridden(0.05, 0.0, 0.0, 3);
        session.remove(Channel::Altitude);
        assert_eq!(grade(&session), None);
        let speed = session.get(Channel::VelocityX).expect("set").to_vec();
        let mut random = Random::new(1, "climb");
        let climb = speed.iter().zip(&truth).map(|(v, g)| v * g + 0.2 * random.normal());
        session.set(Channel::Climb, climb.collect());
        let found = grade(&session).expect("there is a climb");
        let off = found.value.iter().zip(&truth).map(|(a, b)| a - b);
        assert!(rms(off, truth.len()) < 0.006);
        session.set(Channel::Grade, truth);
        assert_eq!(grade(&session), None);
    }

    #[test]
    fn jumps_and_holes_of_the_altitude_do_no_harm() {
        let (mut session, truth) = ridden(0.04, 1.0, 0.0, 5);
        let altitude = session.get_mut(Channel::Altitude).expect("set");
        altitude[2000..2600].fill(f64::NAN);
        altitude[6000..].iter_mut().for_each(|x| *x += 40.0);
        let found = grade(&session).expect("there is altitude");
        assert!(found.value.iter().all(|x| x.is_finite()));
        let far = |i: &usize| !(1900..2700).contains(i) && !(5800..6200).contains(i);
        let (mut n, mut sum) = (0, 0.0);
        for i in (0..truth.len()).filter(far) {
            n += 1;
            sum += (found.value[i] - truth[i]).powi(2);
        }
        assert!((sum / f64::from(n)).sqrt() < 0.012, "{}", (sum / f64::from(n)).sqrt());
    }
}
