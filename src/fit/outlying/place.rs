//! Where a manoeuvre was.

use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::segment::Segment;

/// Where the middle of a manoeuvre is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Place {
    /// Ridden since the start, m.
    pub distance: Option<f64>,
    /// Latitude, degrees.
    pub latitude: Option<f64>,
    /// Longitude, degrees.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;
    use crate::segment::manoeuvre::ManoeuvreKind;

    #[test]
    fn a_place_is_the_middle_of_the_manoeuvre() {
        let mut session = Session::new(Meta::default(), 10.0, 100);
        let segment = Segment {
            kind: ManoeuvreKind::Coasting,
            start: 40,
            end: 60,
            direction: None,
            quality: 1.0,
            used: true,
            reason: None,
        };
        assert_eq!(of(&session, &segment), Place::default());
        let mut speed = vec![12.0; 100];
        speed[10..20].fill(f64::NAN);
        session.set(Channel::VelocityX, speed);
        let degrees = |first: f64| (0..100).map(|i| first + 1e-4 * f64::from(i)).collect();
        session.set(Channel::Latitude, degrees(48.0));
        session.set(Channel::Longitude, degrees(11.0));
        let place = of(&session, &segment);
        let near = |x: Option<f64>, wanted: f64| x.is_some_and(|x| (x - wanted).abs() < 1e-9);
        assert!(near(place.distance, 60.0), "{place:?}");
        assert!(near(place.latitude, 48.005) && near(place.longitude, 11.005), "{place:?}");
    }
}
