//! Positions that froze while the motorcycle went on: the receiver lost its fix and repeated the last one.

use crate::contract::channel::Channel;
use crate::contract::geodesy::distance;
use crate::contract::warning::Warning;
use crate::ingest::clock::Clocked;
use crate::ingest::clock::held::{RECEIVER, SPEEDS};
use crate::ingest::motion::receiver;
use crate::ingest::warning::warning;
use crate::statistics::order;

/// A frozen position goes on with a hop longer than this, m, ...
const HOP: f64 = 10.0;
/// ... and than so many of those after it: a start from a stop is slow.
const TIMES: f64 = 3.0;
/// Number of hops after it that are compared.
const HOPS_AFTER: usize = 5;

/// Takes out positions that rest for at least so long, s, and then jump, with a warning.
pub(super) fn take_out(log: &mut Clocked, least: f64, warnings: &mut Vec<Warning>) {
    let place = |channel| log.tracks.iter().position(|t| t.channel == channel);
    let (Some(north), Some(east)) = (place(Channel::Latitude), place(Channel::Longitude)) else {
        return;
    };
    let (clock, other) = (log.tracks[north].clock, log.tracks[east].clock);
    let (lat, lon) = (&log.tracks[north].values, &log.tracks[east].values);
    if clock != other || lat.len() != lon.len() {
        return;
    }
    let runs = frozen(&log.clocks[clock].stamps, [lat, lon], least);
    let Some(&(first, _)) = runs.first() else { return };
    let mut count = 0;
    let mut others = Vec::new();
    for &(a, b) in &runs {
        count += b - a - 1;
        for at in [north, east] {
            log.tracks[at].values[a + 1..b].fill(f64::NAN);
        }
        for track in log.tracks.iter_mut().filter(|t| t.clock == clock) {
            let is_speed = SPEEDS.contains(&track.channel);
            let is_own = RECEIVER.contains(&track.channel);
            if is_own && receiver::is_none(&track.values, &(a + 1..b), true, is_speed) {
                track.values[a + 1..b].fill(f64::NAN);
                if !others.contains(&track.channel.name()) {
                    others.push(track.channel.name());
                }
            }
        }
    }
    let time = log.clocks[clock].stamps[first] - log.span().0;
    let message = format!(
        "latitude, longitude: rest {} time(s) for {least} s and more and then jump: the receiver had lost its fix; \
         taken as missing{}",
        runs.len(),
        match others.is_empty() {
            true => String::new(),
            false => format!(", and so are {} there", others.join(", ")),
        }
    );
    warnings.push(warning("stuck", Some(Channel::Latitude), count, Some(time), message));
}

/// Runs `a..b` of equal positions that end with a jump; the first of each was a fix.
pub(crate) fn frozen(stamps: &[f64], [lat, lon]: [&[f64]; 2], least: f64) -> Vec<(usize, usize)> {
    let rests = |i: usize| lat[i] == lat[i - 1] && lon[i] == lon[i - 1];
    let hop = |i: usize| distance([lat[i - 1], lon[i - 1]], [lat[i], lon[i]]);
    let (mut runs, mut i) = (Vec::new(), 1);
    while i < lat.len() {
        if !rests(i) {
            i += 1;
            continue;
        }
        let a = i - 1;
        while i < lat.len() && rests(i) {
            i += 1;
        }
        if i >= lat.len() || stamps[i - 1] - stamps[a] < least {
            continue;
        }
        let jump = hop(i);
        let behind = order::finite((i + 1..lat.len()).take(HOPS_AFTER).map(hop));
        let usual = order::median_of_finite(&behind).unwrap_or(f64::INFINITY);
        if jump > HOP && jump > TIMES * usual {
            runs.push((a, i));
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 15 m/s to the north at 10 Hz; the position is that of the time that `at` gives.
    fn runs(at: impl Fn(f64) -> f64) -> Vec<(usize, usize)> {
        let stamps: Vec<f64> = (0..600).map(|i| f64::from(i) / 10.0).collect();
        let lat: Vec<f64> = stamps.iter().map(|t| 47.0 + 15.0 * at(*t) / 111_000.0).collect();
        frozen(&stamps, [&lat, &[8.0; 600]], 2.0)
    }

    #[test]
    fn a_position_that_freezes_is_none_and_a_stop_is_one() {
        let away = |t: f64| (20.0..28.0).contains(&t);
        assert_eq!(runs(|t| if away(t) { 20.0 } else { t }), [(200, 280)]);
        assert!(runs(|t| if t < 20.0 { t } else { 20.0_f64.max(t - 8.0) }).is_empty(), "a stop");
        assert!(runs(|t| t.floor()).is_empty(), "a slow receiver");
        assert!(runs(|_| 3.0).is_empty());
    }
}
