//! Sensors: what the logger makes of the true signals.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::statistics::random::{Coloured, Random};

/// One channel's errors, in the channel's unit.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// White noise, standard deviation.
    pub white: f64,
    /// Slow error, standard deviation.
    pub slow: f64,
    /// Correlation time of the slow error, s.
    pub slow_time: f64,
    /// Constant error, drawn once per session, standard deviation.
    pub bias: f64,
    /// Relative error, drawn once per session, standard deviation.
    pub scale: f64,
    /// Step of the digital value.
    pub quantum: f64,
    /// The channel lags the truth by this much, s.
    pub latency: f64,
}

/// Sensors by channel; a channel without a sensor is perfect.
pub type Sensors = BTreeMap<String, Sensor>;

/// Replaces the true channels of a session by what the sensors show.
pub fn measure(session: &mut Session, sensors: &Sensors, seed: u64) {
    let rate = session.rate;
    let id = session.meta.session_id.clone();
    for &channel in Channel::ALL {
        let Some(sensor) = sensors.get(channel.name()) else { continue };
        let Some(samples) = session.get_mut(channel) else { continue };
        // a stream of its own: the other channels stay the same when one is changed
        let mut random = Random::new(seed, &format!("sensor {id} {channel}"));
        sensor.apply(samples, rate, &mut random);
    }
}

/// Sets negative readings of throttle and brake pressures to zero.
pub fn clamp_physical(session: &mut Session) {
    for channel in [Channel::Throttle, Channel::BrakePressureFront, Channel::BrakePressureRear] {
        if let Some(x) = session.get_mut(channel) {
            x.iter_mut().for_each(|x| *x = x.max(0.0));
        }
    }
}

impl Sensor {
    fn apply(&self, samples: &mut [f64], rate: f64, random: &mut Random) {
        if self.latency > 0.0 {
            delay(samples, self.latency * rate);
        }
        let bias = self.bias * random.normal();
        let scale = if self.scale > 0.0 { 1.0 + self.scale * random.normal() } else { 1.0 };
        let mut slow = Coloured::new(self.slow, self.slow_time, 1.0 / rate, random);
        for x in samples.iter_mut() {
            let slow = slow.next(random);
            *x = *x * scale + bias + slow + self.white * random.normal();
            if self.quantum > 0.0 {
                *x = (*x / self.quantum).round() * self.quantum;
            }
        }
    }
}

/// Delays samples in place by a number of sampling intervals, linearly between samples.
fn delay(samples: &mut [f64], by: f64) {
    let (whole, part) = (by.floor() as usize, by.fract());
    for i in (0..samples.len()).rev() {
        let newer = samples[i.saturating_sub(whole)];
        let older = samples[i.saturating_sub(whole + 1)];
        samples[i] = newer + part * (older - newer);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_has_the_stated_size_and_steps() {
        let sensor =
            Sensor { white: 0.3, slow: 0.4, slow_time: 0.5, quantum: 0.01, ..Sensor::default() };
        let mut x = vec![5.0; 200_000];
        sensor.apply(&mut x, 100.0, &mut Random::new(1, "test"));
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let sd = (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt();
        assert!((mean - 5.0).abs() < 0.05 && (sd - 0.5).abs() < 0.02, "{mean} {sd}");
        assert!(x.iter().all(|v| (v * 100.0 - (v * 100.0).round()).abs() < 1e-6));
    }

    #[test]
    fn latency_shifts_a_ramp() {
        let mut x: Vec<f64> = (0..50).map(f64::from).collect();
        delay(&mut x, 2.5);
        assert_eq!(x[20], 17.5);
    }
}
