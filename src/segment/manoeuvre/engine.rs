//! What the engine takes on a closed throttle, learnt from the ride itself.
//!
//! In gear the rear wheel is braked whenever the throttle is closed, by 0.5 to 3 m/s² on the road and as much as a light
//! hand on a brake. Nothing is known of the engine; its deceleration is the usual one of the ride's closed throttle
//! without a brake, by gear and speed.

use super::mask::runs;
use super::slip::{SLIP_STIFFNESS, front_share};
use crate::GRAVITY;
use crate::statistics::{bisquare, order};

/// A throttle this much above its least is closed.
const CLOSED: f64 = 0.03;
/// The throttle has been closed and the brakes off for this long, s.
const SETTLED: f64 = 0.3;
/// Below this speed the clutch slips, m/s.
const LEAST_SPEED: f64 = 5.0;
/// Lean beyond this is not learnt from, rad.
const UPRIGHT: f64 = 0.4;
/// Samples next in speed that a level is the median of, s; fewer of a gear give no level of its own.
const MEDIAN_WINDOW_S: f64 = 1.5;
/// Front share of the force beyond which the front brake is on, where no pressure tells.
const FRONT: f64 = 0.3;
/// Where pressures do not tell, some of the samples are braked at the rear: the level is below their median.
const LOW: f64 = 0.4;
/// Less than this is no engine braking, m/s².
const LEAST: f64 = 0.3;
/// More than this no engine takes, m/s².
const MAX_ENGINE_BRAKING: f64 = 3.0;

/// The engine's part in the deceleration, by block.
#[derive(Debug, Clone, Default)]
pub struct Engine {
    /// Where nothing that is known rules out that it brakes: a closed throttle, or none that is known, and a gear.
    pub may: Vec<bool>,
    /// Its deceleration where it may, m/s²; `None` where the ride does not tell.
    pub level: Option<Vec<f64>>,
}

/// Data it is learnt from; all by block, of one length.
pub(super) struct Ride<'a> {
    pub rate: f64,
    pub speed: &'a [f64],
    pub lean: &'a [f64],
    pub surplus: &'a [f64],
    pub slip: Option<&'a [f64]>,
    /// Whether a known brake is on.
    pub pressed: &'a [bool],
    /// Whether both brakes are known.
    pub brakes_known: bool,
    pub throttle: Option<&'a [f64]>,
    pub gear: Option<&'a [f64]>,
    pub static_front: f64,
    pub transfer: f64,
}

impl Engine {
    pub(super) fn learn(ride: &Ride<'_>) -> Engine {
        let n = ride.speed.len();
        let least = ride
            .throttle
            .and_then(|t| order::quantile(&mut order::finite(t.iter().copied()), 0.02));
        let closed =
            |i: usize| ride.throttle.is_none_or(|t| least.is_some_and(|l| t[i] < l + CLOSED));
        let in_gear = |i: usize| ride.gear.is_none_or(|g| g[i] >= 0.5);
        let may: Vec<bool> = (0..n).map(|i| closed(i) && in_gear(i)).collect();
        let level = ride.throttle.and_then(|_| level(ride, &may));
        Engine { may, level }
    }

    /// Its deceleration at a block, 0 where it is not known, m/s².
    pub fn at(&self, i: usize) -> f64 {
        self.level.as_ref().map_or(0.0, |l| l[i])
    }
}

/// Deceleration by block.
fn level(ride: &Ride<'_>, may: &[bool]) -> Option<Vec<f64>> {
    let n = may.len();
    let settling = (SETTLED * ride.rate).round() as usize;
    let quiet: Vec<bool> = (0..n).map(|i| may[i] && !ride.pressed[i]).collect();
    let mut samples: Vec<Sample> = Vec::new();
    for run in runs(&quiet) {
        let after = run.end.saturating_sub(settling);
        for i in run.start + settling..after.max(run.start + settling) {
            let upright = ride.lean[i].is_nan() || ride.lean[i].abs() < UPRIGHT;
            let (speed, taken) = (ride.speed[i], -ride.surplus[i]);
            if upright && speed > LEAST_SPEED && taken.is_finite() && !by_front(ride, i) {
                samples.push(Sample { gear: gear(ride, i), speed, taken });
            }
        }
    }
    let near = ((MEDIAN_WINDOW_S * ride.rate).round() as usize).max(5);
    if samples.len() < 2 * near {
        return None;
    }
    samples.sort_unstable_by(|a, b| a.speed.total_cmp(&b.speed));
    let share = if ride.brakes_known { 0.5 } else { LOW };
    let mut gears: Vec<i64> = samples.iter().map(|s| s.gear).collect();
    gears.sort_unstable();
    gears.dedup();
    let all = Curve::new(&samples.iter().collect::<Vec<_>>(), near, share)?;
    // in a gear it is a straight line over the engine's turns, which a brake now and then does not bend
    let by_gear: Vec<(i64, [f64; 2])> = gears
        .iter()
        .filter(|g| **g > 0)
        .filter_map(|g| {
            let own = || samples.iter().filter(|s| s.gear == *g);
            let (speed, taken): (Vec<f64>, Vec<f64>) = own().map(|s| (s.speed, s.taken)).unzip();
            let ones = vec![1.0; speed.len()];
            let enough = speed.len() >= 2 * near && speed[speed.len() - 1] > 1.2 * speed[0];
            let options = bisquare::Options { scale_floor: 0.05, ..Default::default() };
            let fit =
                bisquare::linear(&[&ones, &speed], &taken, &options).ok().filter(|_| enough)?;
            Some((*g, [fit.coefficients[0], fit.coefficients[1]]))
        })
        .collect();
    let usual = order::median(&mut all.level.clone())?;
    if usual < LEAST {
        return None;
    }
    let of = |i: usize| {
        let own = by_gear.iter().find(|(g, _)| *g == gear(ride, i));
        match own {
            Some((_, [level, slope])) => {
                (level + slope * ride.speed[i]).clamp(0.0, MAX_ENGINE_BRAKING)
            }
            None => all.at(ride.speed[i]),
        }
    };
    Some((0..n).map(|i| if may[i] { of(i) } else { 0.0 }).collect())
}

struct Sample {
    gear: i64,
    speed: f64,
    taken: f64,
}

fn gear(ride: &Ride<'_>, i: usize) -> i64 {
    ride.gear.map_or(0, |g| if g[i].is_finite() { g[i].round() as i64 } else { 0 })
}

/// Whether the front wheel's slip says that it brakes; not asked where both pressures are known.
fn by_front(ride: &Ride<'_>, i: usize) -> bool {
    let Some(slip) = ride.slip.filter(|_| !ride.brakes_known) else { return false };
    let force = -ride.surplus[i] / GRAVITY;
    if force < 0.05 {
        return false;
    }
    let on_front = ride.static_front + ride.transfer * force;
    front_share(slip[i], force, on_front, SLIP_STIFFNESS) > FRONT
}

/// Deceleration over speed.
struct Curve {
    /// At whole m/s.
    level: Vec<f64>,
}

impl Curve {
    /// From samples in the order of speed; `None` of too few.
    fn new(samples: &[&Sample], near: usize, share: f64) -> Option<Curve> {
        if samples.len() < near {
            return None;
        }
        let fastest = samples.last()?.speed.ceil().clamp(0.0, 150.0) as usize;
        let level = (0..=fastest)
            .map(|v| {
                let k = samples.partition_point(|s| s.speed < v as f64);
                let start = k.saturating_sub(near / 2).min(samples.len() - near);
                let mut taken: Vec<f64> =
                    samples[start..start + near].iter().map(|s| s.taken).collect();
                order::quantile(&mut taken, share).unwrap_or(0.0).clamp(0.0, MAX_ENGINE_BRAKING)
            })
            .collect();
        Some(Curve { level })
    }

    fn at(&self, speed: f64) -> f64 {
        // a missing speed is as good as none
        let last = self.level.len() - 1;
        self.level[(speed.max(0.0).round() as usize).min(last)]
    }
}
