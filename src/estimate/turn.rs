//! The yaw rate where none was measured: how fast the course turns, or the path of the position.

use crate::contract::channel::Channel;
use crate::contract::geodesy::metres_per_degree;
use crate::contract::session::Session;
use crate::statistics::angles::wrapped;

/// Half the span of the difference, s: receivers tell 5 to 25 positions a second, rounded; what is quasi-static turns
/// evenly for longer.
const HALF: f64 = 0.4;
/// Slowest path whose direction counts, m/s.
const SLOWEST: f64 = 3.0;

/// Yaw rate by course or position, rad/s, positive to the left; `None` where there is a measured one or neither of those.
///
/// The course turns as the frame does where the side slip is steady.
pub(crate) fn yaw_rate(session: &Session) -> Option<Vec<f64>> {
    if session.has(Channel::YawRate) {
        return None;
    }
    let reach = ((HALF * session.rate).round() as usize).max(1);
    let within = |i: usize| i >= reach && i + reach < session.len;
    let span = reach as f64 / session.rate;
    if let Some(yaw) = session.get(Channel::Yaw) {
        let rate = |i: usize| wrapped(yaw[i + reach] - yaw[i - reach]) / (2.0 * span);
        return Some(over(session.len, within, rate));
    }
    let north = session.get(Channel::Latitude)?;
    let east = session.get(Channel::Longitude)?;
    // of the ride's first position: a direction changes less than the roundings of positions do
    let metres = metres_per_degree(north.iter().copied().find(|x| x.is_finite())?);
    let chord = |a: usize, b: usize| {
        let y = metres[0] * (north[b] - north[a]);
        let x = metres[1] * (east[b] - east[a]);
        if x.hypot(y) > SLOWEST * span { y.atan2(x) } else { f64::NAN }
    };
    // chords before and after the sample: their directions are those half a chord away
    let rate = |i: usize| wrapped(chord(i, i + reach) - chord(i - reach, i)) / span;
    Some(over(session.len, within, rate))
}

fn over(n: usize, within: impl Fn(usize) -> bool, rate: impl Fn(usize) -> f64) -> Vec<f64> {
    (0..n).map(|i| if within(i) { rate(i) } else { f64::NAN }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    /// Two turns to the left and one to the right at 20 m/s, in degrees of latitude and longitude.
    #[test]
    fn course_and_position_turn_as_the_ride_does() {
        let (rate, n, v) = (50.0, 3000_usize, 20.0);
        let turn = |i: usize| if i < 2000 { 0.3 } else { -0.4 };
        let (mut yaw, mut x, mut y) = (vec![0.0], vec![0.0], vec![0.0]);
        for i in 1..n {
            let now: f64 = yaw[i - 1] + turn(i) / rate;
            let middle = now - 0.5 * turn(i) / rate;
            x.push(x[i - 1] + v * middle.cos() / rate);
            y.push(y[i - 1] + v * middle.sin() / rate);
            yaw.push(now);
        }
        let mut course = Session::new(Meta::default(), rate, n);
        course.set(Channel::Yaw, yaw.iter().map(|a| wrapped(*a)).collect());
        let mut position = Session::new(Meta::default(), rate, n);
        let [along, across] = metres_per_degree(47.0);
        position.set(Channel::Latitude, y.iter().map(|y| 47.0 + y / along).collect());
        position.set(Channel::Longitude, x.iter().map(|x| 8.0 + x / across).collect());
        for session in [&course, &position] {
            let found = yaw_rate(session).expect("a course");
            for i in (30..1970).chain(2030..n - 30) {
                assert!((found[i] - turn(i)).abs() < 1e-3, "{i}: {}", found[i]);
            }
            assert!(found[0].is_nan());
        }
        course.set(Channel::YawRate, vec![0.0; n]);
        assert!(yaw_rate(&course).is_none());
    }
}
