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
    let distance = session.get(Channel::VelocityX).map(|speed| {
        let before = speed.iter().take(middle).filter(|v| v.is_finite());
        before.map(|v| v.abs()).sum::<f64>() / session.rate
    });
    Place { distance, latitude: at(Channel::Latitude), longitude: at(Channel::Longitude) }
}
