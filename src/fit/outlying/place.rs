//! Where a manoeuvre was.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;

/// Where the middle of a manoeuvre is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Place {
    /// Ridden since the start, m.
    pub distance: Option<f64>,
    /// Degrees.
    pub latitude: Option<f64>,
    /// Degrees.
    pub longitude: Option<f64>,
}

/// The place of a segment's middle.
pub(super) fn of(session: &Session, segment: &Segment) -> Place {
    let middle = (segment.start + segment.end.min(session.len)) / 2;
    let at = |channel: Channel| {
        session.get(channel).and_then(|x| x.get(middle).copied()).filter(|v| v.is_finite())
    };
    let distance = session.get(Channel::VelocityX).and_then(|speed| {
        let known: Vec<f64> =
            speed.iter().take(middle).copied().filter(|v| v.is_finite()).collect();
        // through a gap it goes on as fast as on average
        let mean = known.iter().map(|v| v.abs()).sum::<f64>() / known.len() as f64;
        Some(mean * middle as f64 / session.rate).filter(|d| d.is_finite())
    });
    Place { distance, latitude: at(Channel::Latitude), longitude: at(Channel::Longitude) }
}
