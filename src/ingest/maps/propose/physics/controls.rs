//! Engine, gear, throttle and brakes: what the rider does and what comes of it.

use super::brakes::brakes;
use super::delay::{Delay, delay};
use super::lag::{Gearing, Wheel, gearing, lag};
use super::log::Log;
use super::signal::{self, change, line, mean};
use super::speed::SPAN;
use super::speeds::Motion;
use super::throttle;
use super::verdict::{Verdict, Verdicts};
use crate::contract::channel::Channel;

/// Share of an engine's time that its ratios must explain.
const GEARED: f64 = 0.7;

/// Finds what the rider does.
pub(super) fn controls(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    let named = revolutions(log, out).next();
    let engine = engine(log, motion, out);
    gear(log, engine.as_ref(), motion, out);
    let turns = engine.as_ref().map(|e| e.place).or(named);
    let late = engine.as_ref().and_then(|e| e.late);
    throttle::throttle(log, motion, (turns, late), out);
    brakes(log, motion, out);
}

/// An engine's speed in the log.
struct Engine {
    place: usize,
    gearing: Gearing,
    /// After the motion, s.
    late: Option<Delay>,
}

/// Channels with the name of an engine's speed that change like one.
fn revolutions<'a>(log: &'a Log<'_>, out: &'a Verdicts) -> impl Iterator<Item = usize> + use<'a> {
    let taken = |i: usize| out.entries.iter().any(|e| e.source == i) || out.left_out(i).is_some();
    let meant = |i: &usize| {
        let words = ["rpm", "engine", "n", "motor", "revs"];
        let other = ["limit", "target", "max", "temp", "load", "torque"];
        words.iter().any(|w| log.has_word(*i, w)) && !other.iter().any(|w| log.has_word(*i, w))
    };
    let all = (0..log.channels.len()).filter(move |i| !taken(*i) && meant(i));
    all.filter(|i| log.live(*i).is_some_and(|s| s.distinct >= 20 && s.extent[0] >= 0.0))
}

fn engine(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) -> Option<Engine> {
    let live = revolutions(log, out);
    let wheel = motion.wheels[1].as_ref().unwrap_or(&motion.speed);
    let found = live.filter_map(|place| {
        let gearing = gearing(log.x(place), wheel)?;
        (gearing.share > GEARED).then_some((place, gearing))
    });
    let (place, gearing) = found.max_by(|a, b| a.1.share.total_cmp(&b.1.share))?;
    let late = engine_late(motion, &gearing);
    let ratios: Vec<String> = gearing.ratios.iter().map(|r| format!("{r:.1}")).collect();
    let said = late.map_or(String::new(), |d| format!("; {:+.3} s after the speed", d.value));
    out.left.push((place, format!(
        "the engine's speed: {:.0} % of the time it keeps one of the ratios {} to the speed{said}; no column of a ride on the road",
        100.0 * gearing.share,
        ratios.join(", ")
    )));
    Some(Engine { place, gearing, late })
}

/// An engine that is compared with a wheel needs no account of slip; against the ground it does.
fn engine_late(motion: &Motion, gearing: &Gearing) -> Option<Delay> {
    if let Some(rear) = &motion.wheels[1] {
        return delay(&change(rear, 4), &change(&mean(&gearing.speed, 3), 4));
    }
    let speed = mean(&gearing.speed, SPAN);
    let acceleration = change(&speed, 2);
    let wheel = Wheel {
        speed: &speed,
        acceleration: &acceleration,
        lateral: &motion.lateral,
        driven: true,
    };
    let found = lag(&wheel, &mean(&motion.speed, SPAN))?;
    Some(Delay { value: -found.value, ..found })
}

fn gear(log: &Log<'_>, engine: Option<&Engine>, motion: &Motion, out: &mut Verdicts) {
    for place in log.named(Channel::Gear) {
        let Some(signal) = log.live(place) else { continue };
        if !signal.whole || signal.extent[0] < -1.0 || signal.extent[1] > 9.0 {
            out.left.push((
                place,
                format!(
                    "named like gear, but it goes from {} to {}, {}: no gear",
                    signal.extent[0],
                    signal.extent[1],
                    if signal.whole { "whole numbers" } else { "not in whole numbers" }
                ),
            ));
            continue;
        }
        let mut v = Verdict::new(Channel::Gear, place, "1");
        if let Some(engine) = engine {
            let (n, g) = (log.x(engine.place), log.x(place));
            let wheel = motion.wheels[1].as_ref().unwrap_or(&motion.speed);
            let of = |k: f64| {
                let q: Vec<f64> = (0..n.len())
                    .filter(|&i| g[i] == k && wheel[i] > 6.0)
                    .map(|i| n[i] / wheel[i])
                    .filter(|q| q.is_finite())
                    .collect();
                (q.len() > 40).then(|| (signal::quantile(&q, 0.5), q.len()))
            };
            let steps: Vec<f64> = (1..=8).filter_map(|k| of(f64::from(k))).map(|s| s.0).collect();
            let falls = steps.len() >= 2 && steps.windows(2).all(|w| w[1] < 0.97 * w[0]);
            let said: Vec<String> = steps.iter().map(|s| format!("{s:.1}")).collect();
            if falls {
                v.confirmed = true;
                v = v.because(format!(
                    "the engine's speed over the wheel's falls with it: {}",
                    said.join(", ")
                ));
                if !engine.gearing.ratios.is_empty() {
                    let lag = gear_late(n, g, wheel, &steps);
                    if let Some(lag) = lag.filter(|l| l.value.abs() > 0.08) {
                        (v.delay, v.delay_error) = (lag.value, Some(lag.error));
                    }
                }
            } else {
                v = v.doubted(format!(
                    "the engine's speed over the wheel's does not fall with it: {}",
                    said.join(", ")
                ));
            }
        } else {
            v = v.because("small whole numbers; no engine speed to compare it with");
        }
        if out.entries.iter().any(|e| e.channel == Channel::Gear && e.doubt.is_none()) {
            v = v.doubted("there is more than one such channel");
        }
        out.entries.push(v);
    }
}

/// How late the gear is after the ratio that it says, with a least error of a gear change.
fn gear_late(n: &[f64], g: &[f64], wheel: &[f64], steps: &[f64]) -> Option<Delay> {
    let ratio: Vec<f64> = (0..n.len())
        .map(|i| if wheel[i] > 6.0 { (n[i] / wheel[i]).ln() } else { f64::NAN })
        .collect();
    let said: Vec<f64> = g
        .iter()
        .map(|g| steps.get((*g as usize).wrapping_sub(1)).map_or(f64::NAN, |s| s.ln()))
        .collect();
    let found = delay(&ratio, &said)?;
    Some(Delay { error: found.error.max(0.02), ..found })
}

/// Fork and shock by name and unit; the fork dives under braking.
pub(super) fn travel(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    let pull = mean(&motion.pull, 5);
    for column in [Channel::ForkTravel, Channel::ShockTravel] {
        for place in log.named(column) {
            if log.of_other_dimension(place, &["length"]) {
                continue;
            }
            let mut v = super::turning::by_name(log, column, place, "length");
            let x = mean(log.x(place), 5);
            if column == Channel::ForkTravel
                && let Some(l) = line(&pull, &x)
                && l.r.abs() > 0.3
            {
                v.sign = -l.r.signum();
                v.confirmed = true;
                let way = if v.sign > 0.0 { "rises" } else { "falls" };
                v = v.because(format!(
                    "it {way} when the fork dives under braking (r = {:.2} with dv/dt)",
                    l.r
                ));
            } else {
                v = v.because("by its name");
            }
            if out.entries.iter().any(|e| e.channel == column && e.doubt.is_none()) {
                v = v.doubted("there is more than one such channel");
            }
            out.entries.push(
                v.because("its zero must be the fully extended one: the ride does not show it"),
            );
        }
    }
}
