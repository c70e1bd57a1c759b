//! Delay of the velocities.

use super::physics::{Physics, Reach, Remove};
use super::spec::{EffectSpec, Level};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::manoeuvre::ManoeuvreKind;

pub(super) struct Latency;

impl Physics for Latency {
    const SPEC: EffectSpec = EffectSpec {
        sentence: "the velocity comes late",
        opposite: "the velocity comes early",
        unit: "s",
        typical: 0.015,
        bounds: [-0.1, 0.3],
        source: "satellite receivers are 10 to 100 ms late",
        enters: "velocities over time",
        channels: &[Channel::VelocityX, Channel::AccelerationX],
        kinds: &[
            ManoeuvreKind::FrontBraking,
            ManoeuvreKind::RearBraking,
            ManoeuvreKind::CombinedBraking,
            ManoeuvreKind::Driving,
        ],
        confounded_with: &[],
        separate_by: "hard braking",
        level: Level::Bike,
        faint: false,
    };
    const REACH: Reach = Reach::ATTITUDE;
    const REMOVE: Option<Remove> = Some(|session, _, size| delay(session, -size));

    fn velocity(size: f64, reading: f64, rate: f64) -> f64 {
        reading + size * rate
    }

    fn measure(size: f64, session: &mut Session) {
        delay(session, size);
    }
}

/// Takes the velocities `by` s later (earlier where negative).
fn delay(session: &mut Session, by: f64) {
    let samples = by * session.rate;
    for channel in [Channel::VelocityX, Channel::VelocityY] {
        if let Some(x) = session.get_mut(channel) {
            *x = delayed(x, samples);
        }
    }
}

/// Samples that come `by` sampling intervals late (early where negative), linear between samples.
fn delayed(x: &[f64], by: f64) -> Vec<f64> {
    let last = x.len().saturating_sub(1) as f64;
    (0..x.len())
        .map(|i| {
            let at = (i as f64 - by).clamp(0.0, last);
            let (low, share) = (at.floor() as usize, at.fract());
            let high = (low + 1).min(x.len() - 1);
            x[low] + share * (x[high] - x[low])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_moves_a_ramp_both_ways() {
        let x: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(delayed(&x, 2.5)[10], 7.5);
        assert_eq!(delayed(&x, -1.5)[10], 11.5);
    }
}
