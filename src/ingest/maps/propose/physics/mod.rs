//! Channels by what motion demands of them.
//!
//! A name or a unit makes a channel a candidate for a column; the log's own motion decides. Speeds go with the
//! position, wheels with the speed, lean and yaw rate with the path's turn, accelerations with the speed's change,
//! brakes and throttle with what follows them. Each comparison gives unit, sign and delay besides, and the figure
//! that is said.
//!
//! ```text
//! samples -> signal (one even clock) -> speeds -> turning -> accelerations -> controls -> inertial -> the rest -> Verdicts
//! ```
//!
//! Nothing here knows a logger. Without a position and without a speed in a known unit nothing is decided, and the
//! names alone speak.

mod accelerations;
mod brakes;
mod calculated;
mod controls;
mod course;
mod delay;
mod ground;
mod inertial;
mod lag;
mod log;
mod mirrored;
mod rest;
mod signal;
mod speed;
mod speeds;
mod throttle;
mod turning;
pub(crate) mod verdict;
mod wheel;

use crate::contract::channel::Channel;

pub(crate) use self::log::Log;
pub(crate) use self::signal::Clock;
use self::verdict::FAR;
pub(crate) use self::verdict::{Verdict, Verdicts};
pub(crate) use self::wheel::RADIUS;

/// Delays below this are not written, s, ...
const LATE: f64 = 0.015;
/// ... and those that are not known better than so many standard errors.
const SURE: f64 = 2.0;
/// A channel is on another clock than its bus only beyond this, s.
const OVERWHELMING: f64 = 0.15;
/// A channel that is earlier than the reference by more than this is the reference, s.
const EARLY: f64 = 0.05;
/// A satellite receiver's channels whose delays are nearer than this are equally late, s.
const RECEIVER: f64 = 0.12;

/// Judges a log whose samples were put in.
///
/// `radii` are those of the bike file, front and rear, m.
pub(crate) fn judge(log: &Log<'_>, radii: Option<[f64; 2]>) -> Verdicts {
    let mut out = Verdicts { remarks: log.remarks.clone(), ..Verdicts::default() };
    rest::still(log, &mut out);
    match speeds::speeds(log, radii, &mut out) {
        Some(mut motion) => {
            turning::turning(log, &mut motion, &mut out);
            accelerations::accelerations(log, &motion, &mut out);
            controls::controls(log, &motion, &mut out);
            brakes::same_pressure_unit(log, &mut out);
            controls::travel(log, &motion, &mut out);
            inertial::inertial(log, &motion, &mut out);
            rest::others(log, &motion, &mut out);
        }
        None => out.remarks.push(
            "the log has no position and no speed in a known unit that moves: there is nothing to compare channels with"
                .into(),
        ),
    }
    delays(&mut out);
    out.entries.sort_by_key(|e| (e.channel, e.doubt.is_some()));
    out
}

/// Whether a yaw angle is the frame's, positive to the left: a receiver's is a compass course.
fn of_frame(verdict: &Verdict) -> bool {
    verdict.channel == Channel::Yaw && verdict.sign > 0.0
}

/// The least delay of the receiver after the wheels: its course turns that much after the lean, and no sensor of a
/// lean is early.
fn after_lean(out: &Verdicts) -> Option<f64> {
    let of = |c: Channel| out.entries.iter().find(|e| e.channel == c && e.doubt.is_none());
    let wheels = [Channel::WheelSpeedFront, Channel::WheelSpeedRear];
    let wheel = out.entries.iter().any(|e| wheels.contains(&e.channel));
    let roll = of(Channel::Roll).filter(|e| e.delay_error.is_some_and(|s| s < 0.1))?;
    let turn = of(Channel::Yaw).filter(|e| !of_frame(e)).or_else(|| of(Channel::Latitude))?;
    wheel.then_some(turn.delay - roll.delay - turning::LEADS)
}

/// What the rider does and what the wheels do is on one bus: its channels are on one clock. A delay of one of them is
/// evidence of a delay only where it is large and beyond doubt: brake and throttle act before the speed changes.
fn one_clock(out: &mut Verdicts) {
    use Channel::*;
    let wheels = [WheelSpeedFront, WheelSpeedRear];
    let bus = [BrakePressureFront, BrakePressureRear, Throttle, Gear];
    let wheel = out.entries.iter().any(|e| wheels.contains(&e.channel));
    let throttle = out.entries.iter().find(|e| e.channel == Throttle && e.doubt.is_none());
    let clock = match throttle {
        _ if wheel => Some((0.0, None)),
        // without wheels the throttle's account of drive is the bus's clock
        Some(e) => e.delay_error.map(|error| (e.delay, Some(error))),
        None => None,
    };
    for e in out.entries.iter_mut().filter(|e| bus.contains(&e.channel)) {
        if !wheel && e.channel == Throttle {
            continue;
        }
        let sure = |clock: f64, error: f64| e.delay - clock > OVERWHELMING.max(FAR * error);
        match (clock, e.delay_error) {
            (Some((clock, _)), Some(error)) if sure(clock, error) => {}
            (Some((clock, error)), own) => {
                e.delay = clock;
                e.delay_error = error.or(own);
            }
            // no clock of a bus: what comes before the speed changes is no delay
            (None, Some(error)) if sure(0.0, error) => {}
            (None, _) => e.delay = 0.0,
        }
    }
}

/// Delays after the earliest channel; the satellite receiver's are one.
fn delays(out: &mut Verdicts) {
    one_clock(out);
    let receiver = [
        Channel::VelocityX,
        Channel::Latitude,
        Channel::Longitude,
        Channel::Yaw,
        Channel::Altitude,
    ];
    let speed =
        out.entries.iter().find(|e| e.channel == Channel::VelocityX && e.delay_error.is_some());
    let place =
        out.entries.iter().find(|e| e.channel == Channel::Latitude && e.delay_error.is_some());
    let bound = after_lean(out);
    // two measurements of one delay
    let own = match (speed, place) {
        (Some(a), Some(b)) if (a.delay - b.delay).abs() < RECEIVER => {
            Some((0.5 * (a.delay + b.delay), a.delay_error))
        }
        (a, b) => a.or(b).map(|e| (e.delay, e.delay_error)),
    };
    let own = own.map(|(delay, error)| (bound.map_or(delay, |b| delay.max(b)), error));
    for e in out.entries.iter_mut().filter(|e| receiver.contains(&e.channel) && !of_frame(e)) {
        let Some((delay, error)) = own else { continue };
        let near = e.delay_error.is_none() || (e.delay - delay).abs() < RECEIVER;
        if near {
            (e.delay, e.delay_error) = (delay, error);
        }
    }
    for e in &mut out.entries {
        let known = e.delay_error.is_some_and(|s| e.delay.abs() > SURE * s);
        if !known || e.delay.abs() < LATE {
            e.delay = 0.0;
        }
        e.delay = (1000.0 * e.delay).round() / 1000.0;
    }
    let sure = |e: &&Verdict| e.doubt.as_ref().is_none_or(|d| d == RADIUS);
    let far = |e: &&Verdict| e.delay_error.is_none_or(|s| e.delay.abs() > FAR * s);
    let first = out.entries.iter().filter(sure).filter(far).map(|e| e.delay).fold(0.0, f64::min);
    if first < -EARLY {
        out.entries
            .iter_mut()
            .for_each(|e| e.delay = (1000.0 * (e.delay - first)).round() / 1000.0);
    }
    out.entries.iter_mut().for_each(|e| e.delay = e.delay.max(0.0));
}
