//! Wheels that stood while the motorcycle moved, where the ride's other stops of the kind did not have it.

use super::comparison::Compared;
use super::quantity::{Fitted, Outlying, Quantity};
use crate::contract::channel::Channel;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;

/// Share of the wheel's speed over the road's below which it stands.
const STANDS: f64 = 0.15;
/// Slowest motorcycle of which that is said, m/s.
const MOVING: f64 = 4.0;
/// Least time that it stands, s.
const LONG: f64 = 0.1;

/// A standing time of a name for tables and for people.
const fn quantity(name: &'static str, words: &'static str) -> Quantity {
    let causes = ["the brake locked it, it was off the ground, or its sensor dropped out", ""];
    Quantity { name, unit: "s", words, least: LONG, shown: ("s", 1.0), causes }
}

static FRONT: Quantity = quantity("locked_front", "the front wheel stood");
static REAR: Quantity = quantity("locked_rear", "the rear wheel stood");

/// Wheels that stood in fewer than half of the stops of a kind.
pub(super) fn find(fitted: &Fitted<'_>) -> Vec<Outlying> {
    let mut out = Vec::new();
    for (k, quantity, channel) in
        [(0, &FRONT, Channel::WheelSpeedFront), (1, &REAR, Channel::WheelSpeedRear)]
    {
        for kind in [
            ManoeuvreKind::FrontBraking,
            ManoeuvreKind::RearBraking,
            ManoeuvreKind::CombinedBraking,
        ] {
            let stops: Vec<(usize, f64)> = fitted
                .segments
                .iter()
                .enumerate()
                .filter(|(_, s)| s.kind == kind)
                .filter_map(|(i, s)| Some((i, standing(fitted, s, k, channel)?)))
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

/// How long wheel `k` stands at a stretch in a segment while the motorcycle moves, s; `None` where it is not known.
fn standing(fitted: &Fitted<'_>, segment: &Segment, k: usize, channel: Channel) -> Option<f64> {
    let session = fitted.session;
    let (wheel, speed) = (session.get(channel)?, session.get(Channel::VelocityX)?);
    let radius = fitted.solution.inputs.radius[k];
    let end = segment.end.min(session.len);
    let (mut longest, mut now, mut known) = (0_usize, 0_usize, 0_usize);
    for i in segment.start..end {
        known += usize::from(wheel[i].is_finite());
        let stands = speed[i] > MOVING && radius * wheel[i].abs() < STANDS * speed[i];
        now = if stands { now + 1 } else { 0 };
        longest = longest.max(now);
    }
    (2 * known > end.saturating_sub(segment.start)).then_some(longest as f64 / session.rate)
}
