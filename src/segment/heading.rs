//! Direction along the road: outbound is that of the first straight of the ride.

use std::ops::Range;

use crate::segment::manoeuvre::Direction;
use crate::segment::manoeuvre::detector::Claim;
use crate::segment::manoeuvre::features::Features;

/// Share of the way along the axis (cosine) from which a straight counts as out or back.
const ALONG: f64 = 0.5;

/// The heading of the first straight.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis(Option<f64>);

impl Axis {
    /// From the first straight piece of at least a second.
    pub(super) fn new<'a>(f: &Features, pieces: impl Iterator<Item = &'a Claim>) -> Self {
        let long = |piece: &Claim| piece.kind.is_straight() && piece.at.len() >= f.blocks(1.0);
        Axis(pieces.filter(|p| long(p)).find_map(|p| mean(f, &p.at)))
    }

    /// Outbound or inbound; `None` across the axis or without a heading.
    pub(super) fn direction(self, f: &Features, at: &Range<usize>) -> Option<Direction> {
        let along = (mean(f, at)? - self.0?).cos();
        if along > ALONG {
            Some(Direction::Outbound)
        } else if along < -ALONG {
            Some(Direction::Inbound)
        } else {
            None
        }
    }
}

/// Mean heading, rad; `None` where it is not known.
fn mean(f: &Features, at: &Range<usize>) -> Option<f64> {
    let known = f.heading.as_ref()?[at.clone()].iter().filter(|h| h.is_finite());
    let (sum, count) = known.fold((0.0, 0), |(sum, count), h| (sum + h, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
