//! What the detectors look at: a few signals on a coarse clock, whatever channels there are.
//!
//! ```text
//! lean      roll; without it -atan(v r / g); without that atan(-a_y / g); else r of heading or track
//! surplus   e = a_x + (c_drag v² / m + g c_rol)      what drives or brakes, m/s²
//! slip      k = ln(omega_r / omega_f) - k0           driving or front braking +, rear braking -
//! push      (e + k S) / 2,  S = stiffness g / 2      drive as both wheels and velocity see it
//! ```
//! The zeros come from the ride itself: the accelerometer's from the change of speed, those of
//! `surplus` (drag and rolling resistance are only roughly known) and of `slip` (`k0`, the ratio
//! of the rolling radii) from where speed is lost gently and evenly, which is coasting. On a slope
//! `surplus` is off by `g` times the grade and `slip` is not, at low slip `slip` is vague and
//! `surplus` is not: `push` halves the errors of both.

use super::course::slope;
use super::engine::{Engine, Ride};
use super::slip::SLIP_STIFFNESS;
use super::slip::front_share;
use super::{course, mask};
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::motorcycle::balance::{
    LARGEST_FRICTION, front_load_line, rear_braking_limit, tyre_force_per_mass,
};
use crate::statistics::angles::unwrap;
use crate::statistics::bisquare;
use crate::statistics::order::upper_median;

/// Coarse clock aimed at, Hz.
const RATE: f64 = 25.0;

/// A line pressure above this is a brake that is on, Pa.
const PRESSED: f64 = 2.5e4;

/// Signals of one session in blocks of `step` samples; all of one length, NaN where unknown.
#[derive(Debug, Clone, Default)]
pub struct Features {
    /// Share of the weight on the front wheel at rest.
    pub static_front: f64,
    /// Load transfer to the front per `g` of deceleration.
    pub transfer: f64,
    /// Samples per block.
    pub step: usize,
    /// Blocks per second.
    pub rate: f64,
    /// Forward velocity, m/s.
    pub speed: Vec<f64>,
    /// Lean to the right, rad.
    pub lean: Vec<f64>,
    /// Its rate, rad/s.
    pub lean_rate: Vec<f64>,
    /// Forward acceleration, m/s², zero taken off.
    pub acceleration: Vec<f64>,
    /// Forward acceleration beyond coasting, m/s².
    pub surplus: Vec<f64>,
    /// Rear against front wheel speed; `None` without both.
    pub slip: Option<Vec<f64>>,
    /// Drive from `surplus` and `slip` over about a second, m/s².
    pub push: Vec<f64>,
    /// Line pressures over their zeros, front and rear, Pa.
    pub pressure: [Option<Vec<f64>>; 2],
    /// Engine braking.
    pub engine: Engine,
    /// Rear slip stiffness per load: of a ride in gear that of its drive, else the usual one.
    pub rear_stiffness: f64,
    /// Usual front share of the force, by slip, while the front brake alone is on, where pressures tell. In gear
    /// the engine has the rest.
    pub front_share: Option<f64>,
    /// Whether sensors of a wheel tell how the tyres share the force.
    pub shares_measured: bool,
    /// Largest deceleration that the rear wheel can give alone, m/s².
    pub rear_limit: f64,
    /// Throttle, 0 to 1.
    pub throttle: Option<Vec<f64>>,
    /// Gear, 0 is neutral.
    pub gear: Option<Vec<f64>>,
    /// Heading since some start, rad.
    pub heading: Option<Vec<f64>>,
}

impl Features {
    pub fn len(&self) -> usize {
        self.speed.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.speed.is_empty()
    }

    /// Blocks in a time, at least one.
    pub fn blocks(&self, seconds: f64) -> usize {
        ((seconds * self.rate).round() as usize).max(1)
    }

    /// Computes them; empty without forward velocity.
    pub fn new(session: &Session, bike: &Bike) -> Self {
        let step = (session.rate / RATE).round().max(1.0) as usize;
        let rate = session.rate / step as f64;
        let mean = |channel| session.get(channel).map(|x| block_means(x, step));
        let Some(speed) = mean(Channel::VelocityX) else { return Features::default() };
        let n = speed.len();
        let yaw_rate = mean(Channel::YawRate);

        let lean = if let Some(roll) = mean(Channel::Roll) {
            roll
        } else if let Some(r) = &yaw_rate {
            (0..n).map(|i| -(speed[i] * r[i] / GRAVITY).atan()).collect()
        } else if let Some(a) = mean(Channel::AccelerationY) {
            a.iter().map(|a| -(a / GRAVITY).atan()).collect()
        } else if let Some(r) = turn(&mean, rate) {
            (0..n).map(|i| -(speed[i] * r[i] / GRAVITY).atan()).collect()
        } else {
            vec![f64::NAN; n]
        };
        let lean_rate = match mean(Channel::RollRate) {
            Some(rate) => smooth(&rate, 2),
            None => smooth(&slope(&lean, rate, 2), 2),
        };

        let change = slope(&speed, rate, 3);
        let acceleration = match mean(Channel::AccelerationX) {
            Some(a) => {
                let off: Vec<f64> = (0..n).map(|i| a[i] - change[i]).collect();
                let zero = median_where(&off, |i| speed[i] > 1.0).unwrap_or(0.0);
                let a: Vec<f64> = a.iter().map(|a| a - zero).collect();
                smooth(&a, 2)
            }
            None => change,
        };
        let mut surplus: Vec<f64> =
            (0..n).map(|i| tyre_force_per_mass(bike, speed[i], acceleration[i])).collect();
        if let Some(grade) = mean(Channel::Grade) {
            let uphill = grade.iter().map(|g| if g.is_finite() { GRAVITY * g } else { 0.0 });
            surplus.iter_mut().zip(uphill).for_each(|(force, uphill)| *force += uphill);
        }
        let rolling = free_rolling(&speed, &lean, &acceleration, &surplus, rate);
        if let Some(zero) = rolling.as_deref().and_then(|on| median_where(&surplus, |i| on[i])) {
            surplus.iter_mut().for_each(|e| *e -= zero);
        }
        let slip = wheel_ratio(
            mean(Channel::WheelSpeedFront).as_deref(),
            mean(Channel::WheelSpeedRear).as_deref(),
            rolling.as_deref(),
            &|i| {
                // the rear tyre's friction under drive, which nobody brakes against
                let driven = (0.2..2.5).contains(&surplus[i]) && upright(lean[i]);
                let rear = 1.0 - bike.cg_to_rear() / bike.wheelbase;
                driven.then(|| surplus[i] / (GRAVITY * rear))
            },
        );
        let half = (0.4 * rate).round() as usize;
        let slow = smooth(&surplus, half);
        let push = match &slip {
            Some(k) => {
                let k = smooth(k, half);
                let gain = 0.5 * SLIP_STIFFNESS * GRAVITY;
                (0..n).map(|i| 0.5 * (slow[i] + gain * k[i])).collect()
            }
            None => slow,
        };
        let pressure = [Channel::BrakePressureFront, Channel::BrakePressureRear]
            .map(|c| mean(c).map(over_zero));
        let (throttle, gear) = (mean(Channel::Throttle), mean(Channel::Gear));
        let (static_front, transfer) = front_load_line(bike);
        let pressed: Vec<bool> =
            (0..n).map(|i| pressure.iter().flatten().any(|p| p[i] > PRESSED)).collect();
        let engine = Engine::learn(&Ride {
            rate,
            speed: &speed,
            lean: &lean,
            surplus: &surplus,
            slip: slip.as_deref(),
            pressed: &pressed,
            brakes_known: pressure.iter().all(Option::is_some),
            throttle: throttle.as_deref(),
            gear: gear.as_deref(),
            static_front,
            transfer,
        });
        let rear_stiffness = match (&engine.level, &slip) {
            (Some(_), Some(slip)) => {
                driven_stiffness(&surplus, slip, &lean, static_front, transfer)
            }
            _ => SLIP_STIFFNESS,
        };
        let front_share = match (&pressure, &slip) {
            ([Some(front), Some(rear)], Some(slip)) => {
                let alone = |i: usize| front[i] > PRESSED && rear[i] < PRESSED && surplus[i] < -1.0;
                let shares: Vec<f64> = (0..n)
                    .map(|i| {
                        let force = -surplus[i] / GRAVITY;
                        let on_front = static_front + transfer * force;
                        front_share(slip[i], force, on_front, rear_stiffness)
                    })
                    .collect();
                median_where(&shares, alone)
            }
            _ => None,
        };
        let rear_limit = rear_braking_limit(bike, LARGEST_FRICTION);
        let heading = match (mean(Channel::Yaw), yaw_rate) {
            (Some(mut yaw), _) => {
                unwrap(&mut yaw);
                Some(yaw)
            }
            (None, Some(r)) => Some(integrate(&r, rate, &speed)),
            _ => None,
        };
        Features {
            static_front,
            transfer,
            step,
            rate,
            speed,
            lean,
            lean_rate,
            acceleration,
            surplus,
            slip,
            push,
            pressure,
            engine,
            rear_stiffness,
            front_share,
            shares_measured: SHARES.into_iter().any(|c| session.has(c)),
            rear_limit,
            throttle,
            gear,
            heading,
        }
    }
}

/// Channels that tell how the tyres share the longitudinal force; the balance has the other one's.
const SHARES: [Channel; 4] = [
    Channel::WheelForceXFront,
    Channel::WheelForceXRear,
    Channel::BrakeTorqueFront,
    Channel::BrakeTorqueRear,
];

/// Whether a lean is so small that the tyres roll on the middle of their treads; one that is not known may be.
fn upright(lean: f64) -> bool {
    lean.is_nan() || lean.abs() <= 0.15
}

/// Rear slip stiffness per load from driving, where only the rear tyre slips; the usual one where there is little of it.
fn driven_stiffness(
    surplus: &[f64],
    slip: &[f64],
    lean: &[f64],
    static_front: f64,
    transfer: f64,
) -> f64 {
    let softness: Vec<f64> = (0..surplus.len())
        .map(|i| {
            let force = surplus[i] / GRAVITY;
            let rear = 1.0 - (static_front - transfer * force).clamp(0.05, 0.95);
            slip[i] * rear / force
        })
        .collect();
    let driven = |i: usize| (1.0..5.0).contains(&surplus[i]) && upright(lean[i]);
    if (0..surplus.len()).filter(|&i| driven(i)).count() < FEW {
        return SLIP_STIFFNESS;
    }
    let softness = median_where(&softness, driven).unwrap_or(1.0 / SLIP_STIFFNESS);
    // beyond this it is no tyre, but a wrong zero
    1.0 / softness.clamp(0.5 / SLIP_STIFFNESS, 2.0 / SLIP_STIFFNESS)
}

/// Rate of turn without a gyro; `None` without heading and track.
fn turn(mean: &dyn Fn(Channel) -> Option<Vec<f64>>, rate: f64) -> Option<Vec<f64>> {
    if let Some(mut yaw) = mean(Channel::Yaw) {
        unwrap(&mut yaw);
        return Some(course::of_heading(&yaw, rate));
    }
    Some(course::of_track(&mean(Channel::Latitude)?, &mean(Channel::Longitude)?, rate))
}

/// Means of `step` samples; NaN where more than half of them are missing. The last block may be shorter.
fn block_means(x: &[f64], step: usize) -> Vec<f64> {
    x.chunks(step)
        .map(|block| {
            let sum: f64 = block.iter().sum();
            if sum.is_finite() {
                return sum / block.len() as f64;
            }
            let (mut sum, mut count) = (0.0, 0);
            for v in block.iter().filter(|v| v.is_finite()) {
                sum += v;
                count += 1;
            }
            if count > 0 && 2 * count >= block.len() { sum / count as f64 } else { f64::NAN }
        })
        .collect()
}

/// Mean over `half` neighbours on each side, missing ones left out; NaN where the value itself
/// is missing.
pub(crate) fn smooth(x: &[f64], half: usize) -> Vec<f64> {
    let n = x.len();
    let (mut sum, mut count) = (0.0, 0.0);
    let mut out = vec![f64::NAN; n];
    let mut take = |i: usize, sign: f64| {
        if x[i].is_finite() {
            sum += sign * x[i];
            count += sign;
        }
        (sum, count)
    };
    for i in 0..half.min(n) {
        take(i, 1.0);
    }
    for i in 0..n {
        if i + half < n {
            take(i + half, 1.0);
        }
        let (sum, count) = if i > half { take(i - half - 1, -1.0) } else { take(i, 0.0) };
        if x[i].is_finite() && count > 0.5 {
            out[i] = sum / count;
        }
    }
    out
}

/// Median of the finite values at the blocks that count.
fn median_where(x: &[f64], counts: impl Fn(usize) -> bool) -> Option<f64> {
    let mut chosen: Vec<f64> =
        (0..x.len()).filter(|&i| x[i].is_finite() && counts(i)).map(|i| x[i]).collect();
    upper_median(&mut chosen)
}

/// Blocks under drive that tell the wheels' ratio.
const FEW: usize = 50;

/// `ln(omega_r / omega_f)` less its value in coasting, or less the slip of the drive (its friction: `driven`, by block) where there is
/// no coasting; clamped, a locked wheel is at the limit.
fn wheel_ratio(
    front: Option<&[f64]>,
    rear: Option<&[f64]>,
    rolling: Option<&[bool]>,
    driven: &dyn Fn(usize) -> Option<f64>,
) -> Option<Vec<f64>> {
    let (front, rear) = (front?, rear?);
    let ratio: Vec<f64> = front
        .iter()
        .zip(rear)
        .map(|(f, r)| (r.max(0.05) / f.max(0.05)).ln().clamp(-1.0, 1.0))
        .collect();
    let turning = |i: usize| front[i] > 8.0;
    // a ride in gear never coasts: there what the drive slips is taken off
    let driven = || {
        let (at, x): (Vec<usize>, Vec<f64>) = (0..ratio.len())
            .filter(|&i| turning(i) && ratio[i].is_finite())
            .filter_map(|i| Some((i, driven(i)?)))
            .unzip();
        let (ones, y) = (vec![1.0; at.len()], at.iter().map(|&i| ratio[i]).collect::<Vec<f64>>());
        let options = bisquare::Options { scale_floor: 1e-3, ..Default::default() };
        let fit = bisquare::linear(&[&ones, &x], &y, &options).ok().filter(|_| at.len() >= FEW)?;
        let softness = fit.coefficients[1].clamp(0.5 / SLIP_STIFFNESS, 2.0 / SLIP_STIFFNESS);
        let less: Vec<f64> = y.iter().zip(&x).map(|(y, x)| y - softness * x).collect();
        median_where(&less, |_| true)
    };
    let zero = rolling
        .and_then(|on| median_where(&ratio, |i| on[i] && turning(i)))
        .or_else(driven)
        .or_else(|| median_where(&ratio, turning))?;
    Some(ratio.iter().map(|k| k - zero).collect())
}

/// Where speed is lost gently and evenly in a straight line: neither held nor driven nor
/// braked, so mostly coasting. `None` where there is too little of it to judge by.
fn free_rolling(
    speed: &[f64],
    lean: &[f64],
    acceleration: &[f64],
    surplus: &[f64],
    rate: f64,
) -> Option<Vec<bool>> {
    let half = (0.5 * rate).round() as usize;
    let (slow, calm) = (smooth(acceleration, half), smooth(surplus, half));
    let mut on: Vec<bool> = (0..speed.len())
        .map(|i| {
            let leaning = lean[i].abs() > 0.06;
            let even = (acceleration[i] - slow[i]).abs() < 0.1;
            speed[i] > 2.5 && !leaning && even && slow[i] < -0.1 && calm[i].abs() < 0.3
        })
        .collect();
    mask::close_holes(&mut on, half / 4);
    mask::drop_short(&mut on, 3 * half);
    let seconds = on.iter().filter(|b| **b).count() as f64 / rate;
    (seconds >= 5.0).then_some(on)
}

/// Pressure over its zero: the lower tenth of the ride, where nobody brakes.
fn over_zero(mut p: Vec<f64>) -> Vec<f64> {
    let mut known: Vec<f64> = p.iter().copied().filter(|v| v.is_finite()).collect();
    if known.is_empty() {
        return p;
    }
    let tenth = known.len() / 10;
    let zero = *known.select_nth_unstable_by(tenth, f64::total_cmp).1;
    p.iter_mut().for_each(|v| *v -= zero);
    p
}

/// Heading from its rate; the zero of the rate is its median at standstill, if there is any.
fn integrate(rate: &[f64], clock: f64, speed: &[f64]) -> Vec<f64> {
    let zero = median_where(rate, |i| speed[i].abs() < 0.2).unwrap_or(0.0);
    let mut heading = 0.0;
    rate.iter()
        .map(|r| {
            heading += if r.is_finite() { (r - zero) / clock } else { 0.0 };
            heading
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smoothing_leaves_gaps_and_means() {
        let x = [1.0, 2.0, f64::NAN, 4.0, 5.0];
        let s = smooth(&x, 1);
        assert_eq!(&s[..2], &[1.5, 1.5]);
        assert!(s[2].is_nan());
        assert_eq!(&s[3..], &[4.5, 4.5]);
        assert_eq!(smooth(&[3.0], 4), vec![3.0]);
        assert!(smooth(&[], 4).is_empty());
    }

    #[test]
    fn slopes_and_blocks() {
        let x: Vec<f64> = (0..20).map(|i| 0.3 * f64::from(i)).collect();
        let s = slope(&x, 10.0, 3);
        assert!(s[3..17].iter().all(|v| (v - 3.0).abs() < 1e-12));
        assert_eq!(block_means(&[1.0, 3.0, f64::NAN, 5.0, 7.0], 2), vec![2.0, 5.0, 7.0]);
        assert!(block_means(&[f64::NAN, f64::NAN], 2)[0].is_nan());
    }

    #[test]
    fn headings_run_on() {
        let mut y: Vec<f64> = (0..100)
            .map(|i| {
                let a = 0.2 * f64::from(i);
                a.sin().atan2(a.cos())
            })
            .collect();
        unwrap(&mut y);
        assert!((y[99] - 0.2 * 99.0).abs() < 1e-9);
        let h = integrate(&[0.5, 0.5, 0.6, 0.6], 10.0, &[0.0, 0.0, 5.0, 5.0]);
        assert!((h[3] - 0.02).abs() < 1e-12);
    }
}
