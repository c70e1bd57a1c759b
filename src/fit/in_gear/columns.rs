//! The channels of a ride at 10 Hz, every one through the same kernel, and what may be used of them.

use std::f64::consts::PI;

use super::config::Config;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::statistics::order::quantile;

/// Of the columns, Hz. Central differences reach over one step to each side.
pub(crate) const RATE: f64 = 10.0;
/// Every this many columns is a sample of the fit: 5 Hz.
pub(crate) const STEP: usize = 2;
/// Half the width of the kernel, s.
const HALF: f64 = 0.25;
/// Pressure below which a brake is off, Pa.
pub(crate) const FREE_PRESSURE: f64 = 0.3e5;
/// Pressure from which a brake is on, Pa.
const ON: f64 = 0.5e5;
/// Throttle over its closed stop that still counts as closed.
const CLOSED: f64 = 0.03;
/// Around a change of gear, s.
const SHIFT: f64 = 0.55;
/// Around an opening or closing throttle or brake, s.
const SWITCH: f64 = 0.45;
/// Shortest manoeuvre, s.
const SHORTEST: f64 = 4.0;

/// A ride at [`RATE`]; NaN where a channel has a hole.
#[derive(Debug, Clone)]
pub struct Columns {
    pub len: usize,
    /// Forward velocity, m/s, late by what is to be found.
    pub speed: Vec<f64>,
    /// Wheel speeds, rad/s, front and rear.
    pub omega: [Vec<f64>; 2],
    /// Wheel speed of the front before the average over the span of the difference.
    pub omega_sharp: Vec<f64>,
    /// Rates of the wheel speeds, rad/s².
    pub omega_rate: [Vec<f64>; 2],
    /// Lean, rad.
    pub roll: Vec<f64>,
    /// Whether it was measured: else it follows from the yaw rate.
    pub is_roll_measured: bool,
    /// Grade of the road, uphill positive; 0 where nothing shows it.
    pub grade: Vec<f64>,
    /// Lean before that average.
    pub roll_sharp: Vec<f64>,
    /// Brake pressures, Pa, where they were logged.
    pub pressure: [Option<Vec<f64>>; 2],
    /// Whether the throttle is closed.
    pub closed: Vec<bool>,
    /// Whether a brake is on; never where there is no pressure.
    pub braked: [Vec<bool>; 2],
    /// Gear, where it was logged; 0 is neutral.
    pub gear: Option<Vec<f64>>,
    /// No change of gear is near.
    pub settled: Vec<bool>,
    /// Nor of throttle or brake.
    pub steady: Vec<bool>,
    /// Manoeuvre: a new one begins where the throttle closes.
    pub cluster: Vec<usize>,
}

/// `None` where the ride lacks what the fit cannot do without: both wheels, a velocity, lean or yaw
/// rate, throttle.
pub fn columns(session: &Session, config: &Config) -> Option<Columns> {
    let get = |c: Channel| {
        session.get(c).filter(|x| x.iter().filter(|v| v.is_finite()).count() > x.len() / 4)
    };
    let velocity = get(Channel::VelocityX)?;
    let wheels = [get(Channel::WheelSpeedFront)?, get(Channel::WheelSpeedRear)?];
    let throttle = get(Channel::Throttle)?;
    if session.rate < 0.99 * RATE || session.duration() < config.shortest_ride {
        return None;
    }
    let grid = Grid::new(session);
    let lean: Vec<f64> = match (get(Channel::Roll), get(Channel::YawRate)) {
        (Some(roll), _) => roll.to_vec(),
        (None, Some(rate)) => {
            let of = |(v, r): (&f64, &f64)| -(v * r / crate::GRAVITY).atan();
            velocity.iter().zip(rate).map(of).collect()
        }
        (None, None) => return None,
    };
    let sharp = |x: &[f64]| grid.smooth(x);
    let omega_sharp = [sharp(wheels[0]), sharp(wheels[1])];
    let roll_sharp = sharp(&lean);
    let pressures = [get(Channel::BrakePressureFront), get(Channel::BrakePressureRear)];
    let raw = |x: &[f64]| grid.nearest(x);

    let throttle = raw(throttle);
    let mut known: Vec<f64> = throttle.iter().copied().filter(|x| x.is_finite()).collect();
    let stop = quantile(&mut known, 0.05)?.max(0.0);
    let closed: Vec<bool> = throttle.iter().map(|x| *x < stop + CLOSED).collect();
    let braked = pressures.map(|p| match p {
        Some(p) => raw(p).iter().map(|p| *p > ON).collect(),
        None => vec![false; grid.len],
    });
    let gear = get(Channel::Gear).map(raw);
    let settled = match &gear {
        Some(gear) => away(grid.len, SHIFT, |i| gear[i] != gear[i - 1]),
        None => vec![true; grid.len],
    };
    let switched = |i: usize| closed[i] != closed[i - 1] || braked.iter().any(|b| b[i] != b[i - 1]);
    let steady = away(grid.len, SWITCH, switched);
    let cluster = clusters(&closed);
    Some(Columns {
        len: grid.len,
        speed: average(&sharp(velocity)),
        omega: [average(&omega_sharp[0]), average(&omega_sharp[1])],
        omega_rate: [difference(&omega_sharp[0]), difference(&omega_sharp[1])],
        omega_sharp: omega_sharp[0].clone(),
        roll: average(&roll_sharp),
        is_roll_measured: get(Channel::Roll).is_some(),
        grade: match session.get(Channel::Grade) {
            Some(x) => raw(x).iter().map(|g| if g.is_finite() { *g } else { 0.0 }).collect(),
            None => vec![0.0; grid.len],
        },
        roll_sharp,
        pressure: pressures.map(|p| p.map(|p| average(&sharp(p)))),
        closed,
        braked,
        gear,
        settled,
        steady,
        cluster,
    })
}

/// Samples that are further than `near` s from any change.
fn away(len: usize, near: f64, changed: impl Fn(usize) -> bool) -> Vec<bool> {
    let reach = (near * RATE).ceil() as usize;
    let mut out = vec![true; len];
    for i in 1..len {
        if changed(i) {
            out[i.saturating_sub(reach)..(i + reach).min(len)].fill(false);
        }
    }
    out
}

fn clusters(closed: &[bool]) -> Vec<usize> {
    let (mut number, mut begun) = (0, 0);
    (0..closed.len())
        .map(|i| {
            if i > 0 && closed[i] && !closed[i - 1] && (i - begun) as f64 >= SHORTEST * RATE {
                number += 1;
                begun = i;
            }
            number
        })
        .collect()
}

/// Central difference per s.
pub(crate) fn difference(x: &[f64]) -> Vec<f64> {
    neighbours(x, |before, _, after| 0.5 * RATE * (after - before))
}

/// Average that a central difference takes: `[1 4 1]/6`.
fn average(x: &[f64]) -> Vec<f64> {
    neighbours(x, |before, at, after| (before + 4.0 * at + after) / 6.0)
}

/// Of each sample and its neighbours; NaN at the ends.
pub(crate) fn neighbours(x: &[f64], of: impl Fn(f64, f64, f64) -> f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    for (o, w) in out.iter_mut().skip(1).zip(x.windows(3)) {
        *o = of(w[0], w[1], w[2]);
    }
    out
}

/// The kernel on a session's clock and the columns on theirs.
struct Grid {
    len: usize,
    rate: f64,
    weights: Vec<f64>,
}

impl Grid {
    fn new(session: &Session) -> Self {
        let half = (HALF * session.rate).ceil() as usize;
        // the raised cosine that ends a step beyond HALF
        let width = half as f64 + 1.0;
        let weights: Vec<f64> =
            (0..=2 * half).map(|k| 1.0 + (PI * (k as f64 - half as f64) / width).cos()).collect();
        let sum: f64 = weights.iter().sum();
        Grid {
            len: (session.duration() * RATE).floor() as usize,
            rate: session.rate,
            weights: weights.into_iter().map(|w| w / sum).collect(),
        }
    }

    fn at(&self, i: usize) -> usize {
        (i as f64 * self.rate / RATE).round() as usize
    }

    fn nearest(&self, x: &[f64]) -> Vec<f64> {
        (0..self.len).map(|i| x[self.at(i).min(x.len() - 1)]).collect()
    }

    fn smooth(&self, x: &[f64]) -> Vec<f64> {
        let half = self.weights.len() / 2;
        (0..self.len)
            .map(|i| {
                let at = self.at(i);
                if at < half || at + half >= x.len() {
                    return f64::NAN;
                }
                x[at - half..=at + half].iter().zip(&self.weights).map(|(x, w)| x * w).sum()
            })
            .collect()
    }
}
