//! Wheels that stood while the motorcycle moved, where the ride's other stops of the kind did not have it.

use std::ops::Range;

use super::comparison::Compared;
use super::quantity::{Fitted, Outlying, Quantity};
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Share of the wheel's speed over the road's below which it stands.
const STANDS: f64 = 0.15;
/// Slowest motorcycle of which that is said, m/s.
const MOVING: f64 = 4.0;
/// Least time that it stands, s.
const LONG: f64 = 0.1;
/// Time after a stop in which it counts as well, s: a motorcycle whose wheel locks rolls, and the stop ends there.
const AFTER: f64 = 1.0;

const STOPS: [ManoeuvreKind; 3] =
    [ManoeuvreKind::FrontBraking, ManoeuvreKind::RearBraking, ManoeuvreKind::CombinedBraking];

/// A standing time of a name for tables and for people.
const fn quantity(name: &'static str, words: &'static str) -> Quantity {
    let causes = ["the brake locked it, it was off the ground, or its sensor dropped out", ""];
    Quantity { name, unit: "s", words, least: LONG, shown: ("s", 1.0), causes }
}

static FRONT: Quantity = quantity("locked_front", "the front wheel stood still");
static REAR: Quantity = quantity("locked_rear", "the rear wheel stood still");

/// Wheels that stood in fewer than half of the stops of a kind.
pub(super) fn find(fitted: &Fitted<'_>) -> Vec<Outlying> {
    let mut out = Vec::new();
    for (k, quantity, channel) in
        [(0, &FRONT, Channel::WheelSpeedFront), (1, &REAR, Channel::WheelSpeedRear)]
    {
        let radius = fitted.solution.inputs.radius[k];
        for kind in STOPS {
            let stops: Vec<(usize, f64)> = fitted
                .segments
                .iter()
                .enumerate()
                .filter(|(_, s)| s.kind == kind)
                .filter_map(|(i, s)| {
                    let end = end_with_after(&fitted.segments[i..], fitted.session.rate);
                    Some((i, standing(fitted.session, s.start..end, channel, radius)?))
                })
                .collect();
            let stood: Vec<&(usize, f64)> = stops.iter().filter(|(_, t)| *t >= LONG).collect();
            if 2 * stood.len() >= stops.len() {
                continue;
            }
            let others = stops.len() - 1;
            out.extend(stood.into_iter().map(|&(segment, value)| Outlying {
                quantity,
                compared: Compared {
                    segment,
                    value,
                    expected: 0.0,
                    interval: [value, value],
                    t: f64::INFINITY,
                    chance: 0.0,
                    others,
                },
                comparisons: 1,
            }));
        }
    }
    out
}

/// End of the first of some segments with the time after it, up to the next stop.
fn end_with_after(segments: &[Segment], rate: f64) -> usize {
    let end = segments[0].end;
    let next = segments[1..].iter().find(|s| STOPS.contains(&s.kind));
    let latest = end + (AFTER * rate) as usize;
    next.map_or(latest, |s| latest.min(s.start)).max(end)
}

/// How long a wheel of `radius`, m, stands at a stretch in some samples while the motorcycle moves, s; `None` where it is
/// not known.
fn standing(session: &Session, samples: Range<usize>, wheel: Channel, radius: f64) -> Option<f64> {
    let (wheel, speed) = (session.get(wheel)?, session.get(Channel::VelocityX)?);
    let (start, end) = (samples.start, samples.end.min(session.len));
    let (mut longest, mut now, mut known) = (0_usize, 0_usize, 0_usize);
    for i in start..end {
        known += usize::from(wheel[i].is_finite());
        let stands = speed[i] > MOVING && radius * wheel[i].abs() < STANDS * speed[i];
        now = if stands { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    (2 * known > end.saturating_sub(start)).then_some(longest as f64 / session.rate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    /// Ten seconds at 20 m/s, slowed to `last` at the end; the wheel stands from 3 s on for `stood` s.
    fn stop(last: f64, stood: f64) -> Session {
        let mut session = Session::new(Meta::default(), 100.0, 1000);
        let speed = |i: u32| 20.0 + (last - 20.0) * f64::from(i) / 999.0;
        session.set(Channel::VelocityX, (0..1000).map(speed).collect());
        let turns = |i: u32| {
            let time = f64::from(i) / 100.0;
            if (3.0..3.0 + stood).contains(&time) { 0.0 } else { speed(i) / 0.3 }
        };
        session.set(Channel::WheelSpeedFront, (0..1000).map(turns).collect());
        session
    }

    #[test]
    fn a_wheel_stands_as_long_as_it_does_and_not_where_the_motorcycle_does() {
        let of = |session: &Session| standing(session, 200..1000, Channel::WheelSpeedFront, 0.3);
        assert_eq!(of(&stop(10.0, 0.0)), Some(0.0));
        assert_eq!(of(&stop(10.0, 0.25)), Some(0.25));
        // at walking pace a wheel that stands is the end of the stop
        let mut slow = stop(10.0, 0.0);
        slow.set(Channel::VelocityX, vec![3.0; 1000]);
        slow.set(Channel::WheelSpeedFront, vec![0.0; 1000]);
        assert_eq!(of(&slow), Some(0.0));
        let mut unknown = stop(10.0, 0.25);
        unknown.set(Channel::WheelSpeedFront, vec![f64::NAN; 1000]);
        assert_eq!(of(&unknown), None);
        unknown.remove(Channel::WheelSpeedFront);
        assert_eq!(of(&unknown), None);
    }

    fn segment(kind: ManoeuvreKind, start: usize, end: usize) -> Segment {
        Segment { kind, start, end, direction: None, quality: 1.0, used: true, reason: None }
    }

    /// A wheel locks, the motorcycle rolls, and the stop ends before the wheel stands.
    #[test]
    fn a_wheel_that_stands_just_after_a_stop_stands_in_it() {
        let after = |next: ManoeuvreKind, start: usize| {
            let both = [segment(ManoeuvreKind::FrontBraking, 200, 290), segment(next, start, 1000)];
            let end = end_with_after(&both, 100.0);
            standing(&stop(10.0, 0.25), 200..end, Channel::WheelSpeedFront, 0.3)
        };
        assert_eq!(after(ManoeuvreKind::Other, 290), Some(0.25));
        // what is of the next stop is not of this one
        assert_eq!(after(ManoeuvreKind::RearBraking, 300), Some(0.0));
    }
}
