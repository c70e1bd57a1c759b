//! A first alignment from straight running: which way round the unit is mounted, to within a degree.
//!
//! ```text
//! up       mean specific force over straight, steady running
//! forward  slope of the specific force on the change of speed over straight running, made square to up
//! delay    where speed and course explain the forces and rates best
//! sign     rates about up must have the sign of the change of course; else the forces are reversed
//! ```
//!
//! Means over the windows between two epochs are compared with differences over the same windows: no filter, so no
//! delay of its own.

use crate::statistics::angles::wrapped;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::fault::Fault;
use super::log::{Epoch, Log};

/// Shortest window, s.
const WINDOW: f64 = 0.9;
/// Epochs further apart than this make no window, s.
const LONGEST: f64 = 2.6;
/// Least straight running, s.
const LEAST: f64 = 10.0;
/// Delays that are tried, s.
const DELAYS: f64 = 0.6;
/// Step between them, s.
const DELAY_STEP: f64 = 0.02;

/// Mounting and delay as estimated from the log.
#[derive(Debug, Clone, PartialEq)]
pub struct Alignment {
    /// The unit's axes to the body's.
    pub mounting: Rotation3<f64>,
    /// Whether the forces are of the opposite sign, as in units that give gravity instead of what holds against it.
    pub reversed: bool,
    /// Whether the course counts clockwise.
    pub mirrored: bool,
    /// Of the receiver, s.
    pub delay: f64,
    /// Bias of the rates, unit's axes, rad/s.
    pub bias: Vector3<f64>,
    /// Specific force per change of speed; one if everything fits.
    pub slope: f64,
    /// Straight running that it is from, s.
    pub straight: f64,
}

/// Between two epochs.
struct Window {
    from: f64,
    to: f64,
    /// Speed, m/s.
    speed: f64,
    /// Mean change of speed, m/s².
    change: f64,
    /// Mean change of course, rad/s; NaN where there is no course.
    turn: f64,
    /// Mean rate and force, unit's axes.
    rate: Vector3<f64>,
    force: Vector3<f64>,
}

/// Integrals of the unit's channels over time, to have means over any window.
struct Sums {
    rate: f64,
    sums: Vec<[f64; 7]>,
}

impl Sums {
    fn new(log: &Log) -> Self {
        let mut sums = Vec::with_capacity(log.len() + 1);
        let mut sum = [0.0; 7];
        sums.push(sum);
        for i in 0..log.len() {
            if log.whole(i) {
                for k in 0..3 {
                    sum[k] += log.rates[k][i];
                    sum[3 + k] += log.forces[k][i];
                }
            } else {
                sum[6] += 1.0;
            }
            sums.push(sum);
        }
        Sums { rate: log.rate, sums }
    }

    /// Up to a time; sample `i` stands for the time from half a sample before it to half a sample after.
    fn until(&self, time: f64) -> Option<[f64; 7]> {
        let place = time * self.rate + 0.5;
        if !(0.0..(self.sums.len() - 1) as f64).contains(&place) {
            return None;
        }
        let (i, part) = (place as usize, place.fract());
        Some(std::array::from_fn(|k| {
            self.sums[i][k] + part * (self.sums[i + 1][k] - self.sums[i][k])
        }))
    }

    fn means(&self, from: f64, to: f64) -> Option<[Vector3<f64>; 2]> {
        let (a, b) = (self.until(from)?, self.until(to)?);
        if b[6] - a[6] > 0.0 {
            return None;
        }
        let n = (to - from) * self.rate;
        Some([0, 3].map(|at| Vector3::from_fn(|k, _| (b[at + k] - a[at + k]) / n)))
    }
}

/// Course from the places, where the receiver gives none.
pub(super) fn with_course(epochs: &[Epoch]) -> Vec<Epoch> {
    let mut out = epochs.to_vec();
    if epochs.iter().any(|e| e.course.is_finite()) {
        return out;
    }
    for (i, e) in epochs.iter().enumerate() {
        let near = |j: &usize| (epochs[*j].time - e.time).abs() <= 0.5 * WINDOW + 0.6;
        let far = |j: &usize| (epochs[*j].time - e.time).abs() >= 0.5 * WINDOW;
        let (Some(a), Some(b)) =
            ((0..i).rev().find(far).filter(near), (i + 1..epochs.len()).find(far).filter(near))
        else {
            continue;
        };
        let [x, y] = [0, 1].map(|k| epochs[b].place[k] - epochs[a].place[k]);
        if e.speed > 4.0 && x.hypot(y) > 2.0 {
            out[i].course = y.atan2(x);
        }
    }
    out
}

/// Whether courses count clockwise against the places; `None` if the places do not say.
fn clockwise(epochs: &[Epoch]) -> Option<bool> {
    let mut sums = [[0.0_f64; 2]; 2];
    let mut n = 0.0;
    for pair in epochs.windows(2) {
        let [x, y] = [0, 1].map(|k| pair[1].place[k] - pair[0].place[k]);
        if !(pair[0].speed > 4.0 && pair[0].course.is_finite() && x.hypot(y) > 0.3) {
            continue;
        }
        n += 1.0;
        for (sum, sign) in sums.iter_mut().zip([1.0, -1.0]) {
            let off = y.atan2(x) - sign * pair[0].course;
            *sum = [sum[0] + off.cos(), sum[1] + off.sin()];
        }
    }
    let [plain, turned] = sums.map(|[c, s]| c.hypot(s) / n);
    (n > 20.0 && (plain - turned).abs() > 0.05).then_some(turned > plain)
}

/// Windows between epochs, with the receiver's differences; the unit's means are still missing.
fn windows(epochs: &[Epoch]) -> Vec<Window> {
    let mut out = Vec::new();
    for (i, a) in epochs.iter().enumerate() {
        let Some(b) = epochs[i + 1..].iter().find(|b| b.time - a.time >= WINDOW) else { break };
        let span = b.time - a.time;
        if span > LONGEST || !(a.speed.is_finite() && b.speed.is_finite()) {
            continue;
        }
        out.push(Window {
            from: a.time,
            to: b.time,
            speed: 0.5 * (a.speed + b.speed),
            change: (b.speed - a.speed) / span,
            turn: wrapped(b.course - a.course) / span,
            rate: Vector3::zeros(),
            force: Vector3::zeros(),
        });
    }
    out
}

/// The windows with the unit's means, the receiver being `delay` late.
fn filled(windows: &[Window], sums: &Sums, delay: f64) -> Vec<Window> {
    let fill = |w: &Window| {
        let [rate, force] = sums.means(w.from - delay, w.to - delay)?;
        Some(Window { rate, force, ..*w })
    };
    windows.iter().filter_map(fill).collect()
}

/// Fit at one delay.
struct Seen {
    up: Vector3<f64>,
    /// Specific force per change of speed.
    slope: Vector3<f64>,
    bias: Vector3<f64>,
    /// Rate about up per rate of course, and how well it explains.
    turning: f64,
    explained: [f64; 2],
    straight: f64,
}

fn mean(of: impl Iterator<Item = Vector3<f64>>) -> Vector3<f64> {
    let (n, sum) = of.fold((0.0, Vector3::zeros()), |(n, sum), x| (n + 1.0, sum + x));
    sum / f64::max(n, 1.0)
}

fn look(windows: &[Window], epoch: f64) -> Result<Seen, Fault> {
    let straight_at = |bias: &Vector3<f64>| -> Vec<&Window> {
        let calm = |w: &&Window| {
            let turning = if w.turn.is_finite() { w.turn.abs() < 0.06 } else { true };
            w.speed > 5.0 && turning && (w.rate - bias).norm() < 0.12
        };
        windows.iter().filter(calm).collect()
    };
    let standing: Vec<&Window> =
        windows.iter().filter(|w| w.speed < 0.2 && w.change.abs() < 0.1).collect();
    let enough = |n: usize| n as f64 * epoch;
    let mut bias = Vector3::zeros();
    if enough(standing.len()) > 5.0 {
        bias = mean(standing.iter().map(|w| w.rate));
    }
    let mut straight = straight_at(&bias);
    let steady =
        |all: &[&Window]| mean(all.iter().filter(|w| w.change.abs() < 0.5).map(|w| w.force));
    if enough(standing.len()) <= 5.0 {
        let up = steady(&straight).normalize();
        let turn = |w: &Window| if w.turn.is_finite() { w.turn } else { 0.0 };
        bias = mean(straight.iter().map(|w| w.rate - up * turn(w)));
        straight = straight_at(&bias);
    }
    let seconds = enough(straight.len());
    if seconds < LEAST {
        return Err(Fault::from(format!(
            "{seconds:.0} s of straight running above 5 m/s with satellite speed; {LEAST:.0} s are needed to find \
             how the unit is mounted"
        )));
    }
    let up = steady(&straight).normalize();
    if !up.iter().all(|x| x.is_finite()) {
        return Err(Fault::from(
            "no straight running at steady speed; the vertical cannot be found",
        ));
    }
    let level = |w: &Window| w.force - up * up.dot(&w.force);
    let middle = straight.iter().map(|w| w.change).sum::<f64>() / straight.len() as f64;
    let around = mean(straight.iter().map(|w| level(w)));
    let spread: f64 = straight.iter().map(|w| (w.change - middle).powi(2)).sum();
    if spread / (straight.len() as f64) < 0.04 {
        return Err("speed hardly changes in straight running; brake and accelerate on straights, so that the unit's \
             forward direction shows"
            .into());
    }
    let slope: Vector3<f64> =
        straight.iter().map(|w| (level(w) - around) * (w.change - middle)).sum::<Vector3<f64>>()
            / spread;
    let all: f64 = straight.iter().map(|w| (level(w) - around).norm_squared()).sum();
    let turns: Vec<&Window> =
        windows.iter().filter(|w| w.speed > 5.0 && w.turn.abs() < 2.0).collect();
    let (mut xy, mut xx, mut yy) = (0.0, 0.0, 1e-9);
    for w in turns {
        let about = up.dot(&(w.rate - bias));
        (xy, xx, yy) = (xy + w.turn * about, xx + w.turn * w.turn, yy + about * about);
    }
    let turning = if xx > 0.0 { xy / xx } else { f64::NAN };
    let explained = [slope.norm_squared() * spread / all.max(1e-9), xy * xy / (xx * yy).max(1e-12)];
    Ok(Seen { up, slope, bias, turning, explained, straight: seconds })
}

/// Looks for mounting, sign and delay.
///
/// # Errors
/// A sentence that says what the ride lacks.
pub(super) fn align(log: &Log) -> Result<Alignment, Fault> {
    let epochs = with_course(&log.epochs);
    let mirrored = clockwise(&epochs);
    let mut plain = windows(&epochs);
    if mirrored == Some(true) {
        plain.iter_mut().for_each(|w| w.turn = -w.turn);
    }
    if plain.len() < 10 {
        return Err(Fault::from(
            "hardly any satellite speed; without it the unit cannot be aligned",
        ));
    }
    let mut gaps: Vec<f64> = epochs.windows(2).map(|p| p[1].time - p[0].time).collect();
    gaps.sort_by(f64::total_cmp);
    let epoch = gaps[gaps.len() / 2];
    let sums = Sums::new(log);
    let best = match log.delay {
        Some(delay) => Some((delay, look(&filled(&plain, &sums, delay), epoch)?)),
        None => {
            let steps = (DELAYS / DELAY_STEP) as i32;
            let mut best: Option<(f64, Seen)> = None;
            let mut why = None;
            let quality = |s: &Seen| {
                s.explained[0] + if s.turning.is_finite() { s.explained[1] } else { 0.0 }
            };
            // from zero outwards: among equals the smallest
            for i in (0..=2 * steps).map(|i| if i % 2 == 0 { i / 2 } else { -(i + 1) / 2 }) {
                let delay = f64::from(i) * DELAY_STEP;
                match look(&filled(&plain, &sums, delay), epoch) {
                    Ok(seen) if best.as_ref().is_none_or(|(_, b)| quality(&seen) > quality(b)) => {
                        best = Some((delay, seen));
                    }
                    Ok(_) => {}
                    Err(e) => why = why.or(Some(e)),
                }
            }
            if best.is_none() {
                return Err(why.unwrap_or_else(|| Fault::from("")));
            }
            best
        }
    };
    let Some((delay, seen)) = best else {
        return Err(Fault::from("the unit cannot be aligned"));
    };
    let slope = seen.slope.norm();
    if !(0.6..1.4).contains(&slope) || seen.explained[0] < 0.2 {
        return Err(Fault::from(format!(
            "the unit feels {slope:.2} m/s2 for each 1 m/s2 of change of satellite speed, explained to {:.0} %; units, \
             clocks or the mounting of the unit (loose?) are wrong",
            100.0 * seen.explained[0]
        )));
    }
    // a force of the wrong sign turns up and forward round, but not left: rates about up then contradict the course
    let reversed = seen.explained[1] > 0.3 && seen.turning < 0.0;
    let sign = if reversed { -1.0 } else { 1.0 };
    let (up, forward) = (seen.up * sign, seen.slope.normalize() * sign);
    let forward = (forward - up * up.dot(&forward)).normalize();
    let left = up.cross(&forward);
    let rows = Matrix3::from_rows(&[forward.transpose(), left.transpose(), up.transpose()]);
    Ok(Alignment {
        mounting: Rotation3::from_matrix_unchecked(rows),
        reversed,
        mirrored: mirrored == Some(true),
        delay,
        bias: seen.bias,
        slope,
        straight: seen.straight,
    })
}
