//! What the off-road manoeuvres are found in, sample by sample and as means on a coarse clock.

use std::ops::Range;

use super::offroad::Config;
use super::whoops;

/// A ride after the off-road estimate, sample by sample; NaN where unknown.
#[derive(Debug, Clone, Copy)]
pub struct Ride<'a> {
    /// Rate, Hz.
    pub rate: f64,
    /// Forward speed, m/s.
    pub speed: &'a [f64],
    /// Forward acceleration, m/s².
    pub acceleration: &'a [f64],
    /// Nose up, rad.
    pub pitch: &'a [f64],
    /// Whether both wheels are off the ground.
    pub airborne: &'a [bool],
    /// Braking forces, N.
    pub braking: [&'a [f64]; 2],
    /// Any force, N: it is missing where the estimate is.
    pub load: &'a [f64],
    /// Yaw rate, where logged, rad/s.
    pub yaw_rate: Option<&'a [f64]>,
}

/// Rate of the means, Hz.
const RATE: f64 = 50.0;

/// Means of `step` samples each; NaN where none of them is known.
#[derive(Debug)]
pub(crate) struct Means {
    /// Samples per mean.
    pub step: usize,
    /// Means per second.
    pub rate: f64,
    /// Forward speed, m/s.
    pub speed: Vec<f64>,
    /// Forward acceleration, smoothed over 0.6 s, m/s².
    pub acceleration: Vec<f64>,
    /// Braking forces, front and rear, N.
    pub braking: [Vec<f64>; 2],
    /// Where the pitch swings as over whoops.
    pub waves: Vec<bool>,
}

impl Means {
    pub(crate) fn new(ride: &Ride<'_>, config: &Config) -> Self {
        let step = (ride.rate / RATE).round().max(1.0) as usize;
        let rate = ride.rate / step as f64;
        let coarse = |x: &[f64]| -> Vec<f64> { x.chunks(step).map(known_mean).collect() };
        Means {
            step,
            rate,
            speed: coarse(ride.speed),
            acceleration: smooth(&coarse(ride.acceleration), (0.3 * rate) as usize),
            braking: ride.braking.map(coarse),
            waves: whoops::waves(&coarse(ride.pitch), rate, config),
        }
    }

    /// Means in a time.
    pub(crate) fn count(&self, seconds: f64) -> usize {
        (seconds * self.rate) as usize
    }

    /// Sum of the known values of `x` in a range.
    pub(crate) fn sum(x: &[f64], at: &Range<usize>) -> f64 {
        x[at.clone()].iter().filter(|v| v.is_finite()).sum()
    }
}

/// Mean of the finite values; NaN of none.
fn known_mean(x: &[f64]) -> f64 {
    let known = x.iter().filter(|v| v.is_finite());
    known.clone().sum::<f64>() / known.count() as f64
}

/// Centred mean over `2 half + 1` known values.
pub(crate) fn smooth(x: &[f64], half: usize) -> Vec<f64> {
    (0..x.len())
        .map(|i| known_mean(&x[i.saturating_sub(half)..(i + half + 1).min(x.len())]))
        .collect()
}
