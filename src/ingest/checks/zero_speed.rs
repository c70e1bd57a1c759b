//! A speed over ground of 0 while the wheels turn or the position goes on: the receiver had lost its fix, or its message did not come.

use crate::contract::channel::Channel;
use crate::contract::warning::Warning;
use crate::ingest::clock::{Clocked, Timed};
use crate::ingest::motion::track;
use crate::ingest::warning::warning;

/// Slower is none, m/s.
const NONE: f64 = 0.05;
/// A wheel that turns faster rolls at about 3 m/s, rad/s.
const TURNS: f64 = 10.0;
/// Positions that go on faster, m/s, ...
const GOES_ON: f64 = 3.0;
/// ... over so long to either side, s.
const SPAN: f64 = 0.5;
/// A receiver is late by no more than this when a motorcycle starts, s.
const LATE: f64 = 1.0;
/// No motorcycle stops or starts by more than this from sample to sample while its wheels turn, m/s, ...
const JUMP: f64 = 3.0;
/// ... and this for each second between them, m/s².
const MAX_ACCELERATION: f64 = 12.0;

/// Takes such speeds out, with a warning. The front wheel has to turn, and the rear one where there is one: a burnout
/// turns the rear wheel alone. Without wheels the positions beside the speed have to go on.
pub(super) fn take_out(log: &mut Clocked, warnings: &mut Vec<Warning>) {
    let place = |channel| log.tracks.iter().position(|t| t.channel == channel);
    let Some(v) = place(Channel::VelocityX) else { return };
    let clock = log.tracks[v].clock;
    let stamps = &log.clocks[clock].stamps;
    let values = &log.tracks[v].values;
    if !values.iter().any(|v| v.abs() < NONE) {
        return;
    }
    let front = place(Channel::WheelSpeedFront);
    let wheels: Vec<&Timed> = front
        .into_iter()
        .chain(place(Channel::WheelSpeedRear).filter(|_| front.is_some()))
        .map(|i| &log.tracks[i])
        .collect();
    let beside = |channel| place(channel).filter(|i| log.tracks[*i].clock == clock);
    let ways = match [Channel::Latitude, Channel::Longitude].map(beside) {
        [Some(lat), Some(lon)] if wheels.is_empty() => {
            let position = [lat, lon].map(|i| &log.tracks[i].values[..]);
            track::speed(stamps, position, SPAN)
        }
        _ => Vec::new(),
    };
    let turn = |i: usize| wheels.iter().all(|w| at(log, w, stamps[i]).is_some_and(|w| w > TURNS));
    let goes_on = |i: usize| match wheels.is_empty() {
        true => ways.get(i).is_some_and(|w| *w > GOES_ON),
        false => turn(i),
    };
    let is_none = |i: usize| values[i].abs() < NONE && goes_on(i);
    let mut runs: Vec<(usize, usize)> = Vec::new();
    let mut i = 0;
    while i < values.len() {
        let a = i;
        while i < values.len() && is_none(i) {
            i += 1;
        }
        if i == a {
            i += 1;
            continue;
        }
        let jumps = |from: usize, to: Option<usize>| {
            let to = to.filter(|to| *to < values.len());
            to.is_some_and(|to| {
                values[to].abs() > JUMP + MAX_ACCELERATION * (stamps[from] - stamps[to]).abs()
            })
        };
        let sudden = || jumps(a, a.checked_sub(1)) || jumps(i - 1, Some(i));
        if stamps[i - 1] - stamps[a] >= LATE || sudden() {
            runs.push((a, i));
        }
    }
    let Some(&(first, _)) = runs.first() else { return };
    // a speed that was never there is another fault
    if values.iter().all(|v| v.is_nan() || v.abs() < NONE) {
        return;
    }
    let time = stamps[first] - log.span().0;
    let wheels_turn = !wheels.is_empty();
    let count = runs.iter().map(|(a, b)| b - a).sum();
    for &(a, b) in &runs {
        log.tracks[v].values[a..b].fill(f64::NAN);
    }
    let message = format!(
        "{count} samples are 0 although {}, in {} place(s): the receiver gave no speed; taken as missing",
        match wheels_turn {
            true => "the wheels turn",
            false => "the position goes on",
        },
        runs.len()
    );
    warnings.push(warning("zero_speed", Some(Channel::VelocityX), count, Some(time), message));
}

/// A wheel's speed at a time, of its sample before that, if this is near.
fn at(log: &Clocked, wheel: &Timed, time: f64) -> Option<f64> {
    let clock = &log.clocks[wheel.clock];
    let i = clock.stamps.partition_point(|t| *t <= time).checked_sub(1)?;
    let near = time - clock.stamps[i] < 1.5 * clock.period;
    wheel.values.get(i).copied().filter(|w| near && w.is_finite()).map(f64::abs)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::ingest::clock::Clock;

    /// 20 m/s at 10 Hz for 20 s; speed and wheels as they are at a time.
    fn log(speed: impl Fn(f64) -> f64, wheels: impl Fn(f64) -> [f64; 2]) -> Clocked {
        let stamps: Vec<f64> = (0..200).map(|i| 0.1 * f64::from(i)).collect();
        let track = |channel, f: &dyn Fn(f64) -> f64| Timed {
            channel,
            clock: 0,
            values: stamps.iter().map(|t| f(*t)).collect(),
        };
        let tracks = vec![
            track(Channel::VelocityX, &speed),
            track(Channel::WheelSpeedFront, &|t| wheels(t)[0]),
            track(Channel::WheelSpeedRear, &|t| wheels(t)[1]),
        ];
        let clock = Clock { stamps: Arc::new(stamps.clone()), period: 0.1, uniform: true };
        Clocked { clocks: vec![clock], tracks }
    }

    fn lost(mut log: Clocked) -> usize {
        let mut warnings = Vec::new();
        take_out(&mut log, &mut warnings);
        let lost = log.tracks[0].values.iter().filter(|v| v.is_nan()).count();
        assert_eq!(lost, warnings.first().map_or(0, |w| w.count));
        lost
    }

    #[test]
    fn a_speed_of_zero_while_the_wheels_turn_is_missing() {
        let away = |t: f64| (4.95..7.95).contains(&t);
        let rides = |_: f64| [66.0, 66.0];
        assert_eq!(lost(log(|t| if away(t) { 0.0 } else { 20.0 }, rides)), 30);
        assert_eq!(lost(log(|t| if (4.95..5.05).contains(&t) { 0.0 } else { 20.0 }, rides)), 1);
        // the positions alone
        let mut alone = log(|t| if away(t) { 0.0 } else { 20.0 }, rides);
        alone.tracks[1].channel = Channel::Latitude;
        alone.tracks[2].channel = Channel::Longitude;
        for (i, t) in (0..200).zip(0..) {
            alone.tracks[1].values[i] = 47.0 + 20.0 * 0.1 * f64::from(t) / 111_170.0;
            alone.tracks[2].values[i] = 8.0;
        }
        assert_eq!(lost(alone), 30);
        assert_eq!(lost(log(|_| 0.0, rides)), 0, "it was never there");
    }

    #[test]
    fn a_stop_a_start_and_a_burnout_have_a_speed_of_zero() {
        let away = |t: f64| (4.95..7.95).contains(&t);
        let speed = |t: f64| if away(t) { 0.0 } else { 20.0 };
        assert_eq!(lost(log(speed, |t| if away(t) { [0.0; 2] } else { [66.0; 2] })), 0);
        assert_eq!(lost(log(speed, |t| if away(t) { [0.0, 66.0] } else { [66.0; 2] })), 0);
        // the receiver is 0.6 s late at 5 m/s²
        let start = |t: f64| 5.0 * (t - 5.0).max(0.0);
        let wheels = |t: f64| [start(t) / 0.3; 2];
        assert_eq!(lost(log(|t| if t < 5.6 { 0.0 } else { start(t - 0.6) }, wheels)), 0);
    }
}
