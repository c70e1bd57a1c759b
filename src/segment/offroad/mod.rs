//! Off-road manoeuvres: flights, whoops, corners, braking manoeuvres, drives.
//!
//! ```text
//! flight  >  whoops  >  corner (braking, slowest point, exit)  >  braking  >  driving  >  other
//! ```
//! Works on 50 Hz means of what the off-road estimate gave: the flights of the wheels and the
//! braking forces are known by then. Flights are exact to the sample; one that begins in whoops
//! belongs to them.

use crate::segment::manoeuvre::airborne;
use crate::segment::manoeuvre::means::Means;
use crate::segment::manoeuvre::{ManoeuvreKind, OFF_ROAD};

use super::segments::Segment;

mod cover;

pub(crate) use crate::segment::manoeuvre::means::Ride;
pub(crate) use crate::segment::manoeuvre::offroad::Config;

/// Cuts a ride into segments, in time order, none overlapping, all of it covered.
pub fn run(ride: &Ride<'_>, config: &Config) -> Vec<Segment> {
    let means = Means::new(ride, config);
    let mut kinds = vec![ManoeuvreKind::Other; means.speed.len()];
    for claim in OFF_ROAD.iter().flat_map(|detect| detect(&means, config)) {
        kinds[claim.at].fill(ManoeuvreKind::of(claim.kind));
    }
    let mut kinds: Vec<ManoeuvreKind> =
        (0..ride.load.len()).map(|i| kinds[i / means.step]).collect();
    for flight in airborne::flights(ride, &means, config) {
        kinds[flight].fill(ManoeuvreKind::Airborne);
    }
    cover::cover(ride, &kinds, config)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lap_is_told_apart() {
        let rate = 400.0;
        let n = 400 * 30;
        let t = |i: usize| i as f64 / rate;
        let speed: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if t < 5.0 => 12.0,
                t if t < 7.0 => 12.0 - 3.0 * (t - 5.0),
                t if t < 10.0 => 6.0 + 2.0 * (t - 7.0),
                _ => 12.0,
            })
            .collect();
        let acceleration: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if (5.0..7.0).contains(&t) => -3.0,
                t if (7.0..10.0).contains(&t) => 2.0,
                t if (26.0..28.0).contains(&t) => -4.0,
                _ => 0.0,
            })
            .collect();
        let airborne: Vec<bool> = (0..n).map(|i| (12.0..12.8).contains(&t(i))).collect();
        let pitch: Vec<f64> = (0..n)
            .map(|i| match t(i) {
                t if (15.0..19.0).contains(&t) => 0.2 * (std::f64::consts::TAU * 2.0 * t).sin(),
                _ => 0.0,
            })
            .collect();
        let (front, zero) = (vec![400.0; n], vec![0.0; n]);
        let ride = Ride {
            rate,
            speed: &speed,
            acceleration: &acceleration,
            pitch: &pitch,
            airborne: &airborne,
            braking: [&front, &zero],
            load: &front,
            yaw_rate: None,
        };
        let segments = run(&ride, &Config::default());
        assert_eq!(segments.first().map(|s| s.start), Some(0));
        assert_eq!(segments.last().map(|s| s.end), Some(n));
        assert!(segments.windows(2).all(|w| w[0].end == w[1].start));
        let found = |kind: ManoeuvreKind| -> Vec<(f64, f64)> {
            segments.iter().filter(|s| s.kind == kind).map(|s| (t(s.start), t(s.end))).collect()
        };
        assert_eq!(found(ManoeuvreKind::Airborne), [(12.0, 12.8)]);
        let near = |got: &[(f64, f64)], start: f64, end: f64, by: f64| {
            assert_eq!(got.len(), 1, "{got:?}");
            assert!((got[0].0 - start).abs() < by && (got[0].1 - end).abs() < by, "{got:?}");
        };
        near(&found(ManoeuvreKind::Whoops), 15.0, 19.0, 0.3);
        near(&found(ManoeuvreKind::Cornering), 5.0, 10.0, 0.4);
        near(&found(ManoeuvreKind::FrontBraking), 26.0, 28.0, 0.4);
    }
}
