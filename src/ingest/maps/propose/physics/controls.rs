//! Engine, gear, throttle and brakes: what the rider does and what comes of it.

use super::delay::{Delay, delay};
use super::lag::{Gearing, Wheel, gearing, lag, lowest};
use super::log::Log;
use super::signal::{self, change, line, mean, regression};
use super::speed::SPAN;
use super::speeds::Motion;
use super::throttle;
use super::verdict::{PRESSURE, Verdict, Verdicts};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::ingest::maps::units;

/// No rear brake decelerates more than this by itself, m/s² (0.36 g): the rear wheel is too light then.
const REAR_ALONE: f64 = 0.36 * GRAVITY;
/// Deceleration by the front brake per bar, m/s²: 25 to 90 N m/bar on 275 kg and 0.3 m; machines differ by a factor
/// of 2 either way, and rides that use both brakes at once blur it to 3.
const PER_BAR: f64 = 0.6;
/// A unit suits if it is that within this factor.
const USUAL: f64 = 3.0;
const PRESSURES: [&str; 5] = ["bar", "kPa", "psi", "Pa", "mbar"];
/// Delays of the driver's actions are not known better than this, s: what follows them takes its time.
const ACTION: f64 = 0.05;
/// A brake whose largest pressure is this share of the other's was not used.
const IDLE: f64 = 0.05;
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

/// Channels that are named like an engine's speed and change as one.
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

/// An engine that is held against a wheel needs no account of slip; against the ground it does.
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
            v = v.because("small whole numbers; no engine speed to hold it against");
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

/// A brake line's pressure and what it does.
#[derive(Clone)]
struct Brake {
    place: usize,
    /// At rest: taken off for the account of what it does.
    rest: f64,
    /// A pressure that presses, in the log's unit above rest.
    pressed: f64,
    /// Deceleration per unit, m/s².
    gain: f64,
    /// What it does when it is pressed hard, m/s².
    most: f64,
    /// Change of ln(front / rear wheel speed) when pressed hard.
    slip: f64,
    /// t value of that.
    t: f64,
    /// Hardly used beside the other: nothing can be said of it.
    idle: bool,
}

fn brakes(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
    let columns = [Channel::BrakePressureFront, Channel::BrakePressureRear];
    let mut named: [Option<usize>; 2] = [None, None];
    for (k, column) in columns.into_iter().enumerate() {
        for place in log.named(column) {
            if log.of_other_dimension(place, &["pressure"]) {
                continue;
            }
            let signal = log.live(place);
            let rest = signal::quantile(log.x(place), 0.3);
            let zero =
                signal.is_some_and(|s| rest.abs() < (0.03 * s.extent[1].abs()).max(3.0 * s.step));
            let switch = signal.is_some_and(|s| s.distinct == 2 && s.extent[1] == 1.0);
            if switch {
                let why = format!("named like {column}, but it is 0 or 1: a switch");
                out.left.push((place, why));
            } else if !zero && log.unit(place, "pressure").is_none() {
                out.left.push((place, format!("named like {column}, but it is {rest:.2} at rest: a raw signal, no pressure")));
            } else if named[k].is_none() {
                named[k] = Some(place);
            }
        }
    }
    let mut brakes: Vec<Brake> = named.iter().flatten().map(|p| brake(log, *p)).collect();
    let most = brakes.iter().map(|b| b.pressed).fold(0.0, f64::max);
    brakes.iter_mut().for_each(|b| b.idle = b.pressed < IDLE * most);
    account(log, motion, &mut brakes);
    let mut order: Vec<Option<Brake>> = named
        .iter()
        .map(|n| n.and_then(|p| brakes.iter().find(|b| b.place == p).cloned()))
        .collect();
    let (doubt, said) = front_of(log, &mut order);
    let throttle = out.entries.iter().find(|e| e.channel == Channel::Throttle && e.doubt.is_none());
    let shut = throttle.map(|e| -> Vec<f64> {
        let full = if e.unit == "%" { 100.0 } else { 1.0 };
        log.x(e.source).iter().map(|x| x / full).collect()
    });
    for (k, column) in columns.into_iter().enumerate() {
        let Some(brake) = &order[k] else { continue };
        let v = pressure(log, motion, column, brake, shut.as_deref());
        let v = match &doubt {
            Some(doubt) => v.doubted(doubt.clone()),
            None => said.iter().fold(v, |v, s| v.because(s.clone())),
        };
        out.entries.push(v);
    }
}

fn brake(log: &Log<'_>, place: usize) -> Brake {
    let x = log.x(place);
    let rest = signal::quantile(x, 0.3);
    let high = log.live(place).map_or(0.0, |s| s.extent[1]) - rest;
    Brake { place, rest, pressed: 0.1 * high, gain: 0.0, most: 0.0, slip: 0.0, t: 0.0, idle: false }
}

/// What each pressure does: deceleration and slip, by least squares where the bike slows down.
///
/// ```text
/// a = -g1 p1 - g2 p2 - c v^2 - a0        ln(v_front / v_rear) = s1 p1 + s2 p2 + s0
/// ```
fn account(log: &Log<'_>, motion: &Motion, brakes: &mut [Brake]) {
    if brakes.is_empty() {
        return;
    }
    let pressures: Vec<Vec<f64>> = brakes
        .iter()
        .map(|b| mean(log.x(b.place), 2).iter().map(|x| x - b.rest).collect())
        .collect();
    let pull = mean(&motion.pull, 2);
    let slow = |i: usize| pull[i] < -0.8 && motion.speed[i] > 6.0;
    let of = |y: &[f64], drag: bool| {
        let mut columns: Vec<Vec<f64>> = pressures.clone();
        if drag {
            columns.push(motion.speed.iter().map(|v| v * v).collect());
        }
        columns.push(vec![1.0; y.len()]);
        regression(&columns, y, slow)
    };
    let high: Vec<f64> = pressures.iter().map(|p| signal::quantile(p, 0.98)).collect();
    if let Some((found, _)) = of(&pull, true) {
        for (k, brake) in brakes.iter_mut().enumerate() {
            brake.gain = -found[k];
            brake.most = -found[k] * high[k];
        }
    }
    if let [Some(front), Some(rear)] = &motion.wheels {
        let slip: Vec<f64> = front.iter().zip(rear).map(|(f, r)| (f / r).ln()).collect();
        if let Some((found, error)) = of(&mean(&slip, 2), false) {
            for (k, brake) in brakes.iter_mut().enumerate() {
                brake.slip = found[k] * high[k];
                brake.t = found[k] / error[k];
            }
        }
    }
}

/// Puts the front brake first; the doubt if that cannot be told, and what decided.
fn front_of(log: &Log<'_>, order: &mut [Option<Brake>]) -> (Option<String>, Vec<String>) {
    let [Some(a), Some(b)] = order else { return (None, Vec::new()) };
    let (a, b) = (a.clone(), b.clone());
    if a.idle || b.idle {
        return (None, Vec::new());
    }
    // for the first as the front one: positive; each a weight of evidence
    let bound = |x: &Brake| x.most > REAR_ALONE;
    let by_force = match (bound(&a), bound(&b)) {
        (true, false) => 2,
        (false, true) => -2,
        _ if a.most > 2.0 * b.most => 1,
        _ if b.most > 2.0 * a.most => -1,
        _ => 0,
    };
    // engine and pitching slip the rear wheel, too: only opposite signs tell
    let slips = |x: &Brake, y: &Brake| x.t < -4.0 && y.t > 4.0;
    let by_slip = if slips(&a, &b) {
        2
    } else if slips(&b, &a) {
        -2
    } else {
        0
    };
    let said = vec![format!(
        "pressed hard `{}` slows down by {:.1} m/s2 and `{}` by {:.1} (a rear brake alone reaches {REAR_ALONE:.1}); the front wheel's spin over the rear's changes by {:+.1} and {:+.1} %",
        log.name(a.place),
        a.most,
        log.name(b.place),
        b.most,
        100.0 * a.slip,
        100.0 * b.slip
    )];
    let total = by_force + by_slip;
    if total <= -2 {
        order.swap(0, 1);
        let mut said = said;
        said.insert(0, "by its name it is the other brake, the motion says this".into());
        return (None, said);
    }
    if total < 0 {
        return (Some(format!("by its name it is this brake, but {}", said[0])), said);
    }
    (None, said)
}

fn pressure(
    log: &Log<'_>,
    motion: &Motion,
    column: Channel,
    brake: &Brake,
    shut: Option<&[f64]>,
) -> Verdict {
    let own = log.unit(brake.place, "pressure");
    let front = column == Channel::BrakePressureFront;
    let mut v = Verdict::new(column, brake.place, own.unwrap_or("?"));
    if brake.idle {
        return v.because("hardly used beside the other brake: by its name");
    }
    let x: Vec<f64> = log.x(brake.place).iter().map(|x| x - brake.rest).collect();
    let pressed: Vec<f64> = x.iter().map(|p| if *p > brake.pressed { 1.0 } else { 0.0 }).collect();
    let pull = mean(&motion.pull, 2);
    let share = pressed.iter().sum::<f64>() / pressed.len().max(1) as f64;
    let while_pressed = signal::quantile(&signal::masked(&pull, |i| pressed[i] > 0.5), 0.5);
    v = v.because(format!(
        "pressed {:.0} % of the time, at {while_pressed:.1} m/s2 then",
        100.0 * share
    ));
    if !(while_pressed < -0.8 && share < 0.6) {
        return if share < 0.01 && own.is_some() {
            v.because("used too little to check it")
        } else if share < 0.01 {
            Verdict { unit: "?".into(), ..v }.because("used too little to check it")
        } else {
            v.doubted("no deceleration goes with it")
        };
    }
    v.confirmed = true;
    if front || own.is_none() {
        v = with_unit(v, own, brake.gain, front);
    }
    // engine braking comes before the brake: it must not be taken for it
    let slow: Vec<f64> = motion.speed.iter().map(|v| v * v).collect();
    let terms = [mean(&x, 2), slow, vec![1.0; pull.len()]];
    let braked = mean(&pressed, 20);
    let found = lowest(&terms, &pull, |i| braked[i] > 0.0 && shut.is_none_or(|s| s[i] < 0.05));
    if let Some((late, r)) = found.filter(|f| f.1 > 0.6 && front) {
        (v.delay, v.delay_error) = (-late, Some(ACTION));
        v = v.because(format!("deceleration follows it by {late:+.2} s (r = {r:.2})"));
    }
    v
}

/// The front pressure's unit by the deceleration per unit (`gain`, m/s2): the log's, else what suits it best.
fn with_unit(mut v: Verdict, own: Option<&str>, gain: f64, front: bool) -> Verdict {
    let per = |unit: &str| {
        let bars = units::conversion(unit, "bar").map_or(1.0, |c| c.factor);
        (gain / (PER_BAR * bars)).abs().ln().abs()
    };
    let suits = |unit: &str| front && gain > 0.0 && per(unit) < USUAL.ln();
    let best = PRESSURES.iter().copied().min_by(|a, b| per(a).total_cmp(&per(b)));
    match (own, best.filter(|b| suits(b))) {
        (Some(own), _) if suits(own) => v,
        (Some(own), Some(unit)) => {
            v.unit = unit.to_owned();
            v.because(format!("{gain:.3} m/s2 per unit: {unit}, not {own} as the log says"))
                .doubted(PRESSURE)
        }
        (Some(own), None) => v.because(format!(
            "{gain:.3} m/s2 per {own}: no unit suits it, usual are {:.1} to {:.1} m/s2 a bar",
            PER_BAR / USUAL,
            PER_BAR * USUAL
        )),
        (None, Some(unit)) => {
            v.unit = unit.to_owned();
            v.because(format!("{gain:.3} m/s2 per unit: {unit}"))
        }
        // the rear one does too little to tell its unit: the front one's, if that is of the same logger
        (None, None) => Verdict { unit: "?".into(), ..v },
    }
}

/// The rear pressure's unit is the front's, once that is known; and what holds of the log's own unit holds of both.
pub(super) fn same_pressure_unit(log: &Log<'_>, out: &mut Verdicts) {
    let front = out.entries.iter().find(|e| e.channel == Channel::BrakePressureFront).cloned();
    let own = |e: &Verdict| log.unit(e.source, "pressure").map(str::to_owned);
    if let Some(front) = front.as_ref().filter(|f| f.of_two_units()) {
        let rears = out.entries.iter_mut().filter(|e| e.channel == Channel::BrakePressureRear);
        for rear in rears.filter(|e| own(e) == own(front)) {
            rear.unit.clone_from(&front.unit);
            rear.why.push(format!("in {} as the front one", front.unit));
            rear.doubt.get_or_insert(PRESSURE.into());
        }
    }
    let Some(rear) =
        out.entries.iter_mut().find(|e| e.channel == Channel::BrakePressureRear && e.unit == "?")
    else {
        return;
    };
    match front.filter(|f| f.unit != "?" && f.doubt.is_none()) {
        Some(front) => {
            rear.unit.clone_from(&front.unit);
            rear.why.push(format!("in {} as the front one", front.unit));
            // they are of one box
            if let Some(error) = front.delay_error {
                (rear.delay, rear.delay_error) = (front.delay, Some(error));
            }
        }
        None => {
            rear.doubt.get_or_insert("the log does not say its unit".into());
        }
    }
    if let Some(front) =
        out.entries.iter_mut().find(|e| e.channel == Channel::BrakePressureFront && e.unit == "?")
    {
        front
            .doubt
            .get_or_insert("the log does not say its unit, and its deceleration suits none".into());
    }
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
            out.entries
                .push(v.because("its zero must be the fully extended one: the ride does not tell"));
        }
    }
}
