//! Brake pressures: which line is the front one, in which unit, and how late.

use super::lag::lowest;
use super::log::Log;
use super::signal::{self, mean, regression};
use super::speeds::Motion;
use super::verdict::{PRESSURE, Verdict, Verdicts, unknown};
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
/// A brake that does this pressed hard is none: the account of it is wrong, m/s².
const SPEEDS_UP: f64 = -0.5;
/// Standard errors beyond which decelerations overrule a name, ...
const STRONG: f64 = 3.0;
/// ... and of one, below which it is not even a doubt of a name.
const HINT: f64 = 1.5;

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
    /// Deceleration when it is pressed hard, m/s², and its standard error.
    most: f64,
    error: f64,
    /// Change of ln(front / rear wheel speed) when pressed hard.
    slip: f64,
    /// t value of that.
    t: f64,
    /// Hardly used beside the other: nothing can be said of it.
    idle: bool,
}

/// Finds the brake pressures.
pub(super) fn brakes(log: &Log<'_>, motion: &Motion, out: &mut Verdicts) {
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
        let v = match log.unknown_unit(brake.place) {
            // its deceleration tells the unit within a factor of 3 only
            Some(unit) => v.doubted(unknown(unit)),
            None => v,
        };
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
    Brake {
        place,
        rest,
        pressed: 0.1 * high,
        gain: 0.0,
        most: 0.0,
        error: 0.0,
        slip: 0.0,
        t: 0.0,
        idle: false,
    }
}

/// Effect of each pressure: deceleration and slip, by least squares where the bike slows down.
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
    if let Some((found, error)) = of(&pull, true) {
        for (k, brake) in brakes.iter_mut().enumerate() {
            brake.gain = -found[k];
            brake.most = -found[k] * high[k];
            brake.error = (error[k] * high[k]).abs();
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

/// Puts the front brake first; the doubt if the evidence does not decide, and the evidence.
fn front_of(log: &Log<'_>, order: &mut [Option<Brake>]) -> (Option<String>, Vec<String>) {
    let [Some(a), Some(b)] = order else { return (None, Vec::new()) };
    let (a, b) = (a.clone(), b.clone());
    if a.idle || b.idle {
        return (None, Vec::new());
    }
    // for the first as the front one: positive; each a weight of evidence
    let bound = |x: &Brake| x.most > REAR_ALONE;
    // no brake speeds up: an account that says so says nothing of the other one either
    let speeds_up = |x: &Brake| x.most < SPEEDS_UP;
    let beyond =
        b.most - REAR_ALONE > STRONG * b.error && b.most - a.most > STRONG * (a.error + b.error);
    let hint = b.most > HINT * b.error;
    let by_force = match (bound(&a), bound(&b)) {
        _ if speeds_up(&a) || speeds_up(&b) => 0,
        // a clear name is not overruled by a number that is not known well
        (false, true) if !beyond => -i32::from(hint),
        (true, false) => 2,
        (false, true) => -2,
        _ if a.most > 2.0 * b.most => 1,
        _ if b.most > 2.0 * a.most => -i32::from(hint),
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

#[cfg(test)]
mod tests {
    use super::super::signal::Clock;
    use super::*;
    use crate::ingest::formats::listing::SourceChannel;

    #[test]
    fn a_clear_name_is_overruled_by_strong_evidence_only() {
        let channels = ["Brake F", "Brake R"]
            .map(|name| SourceChannel { name: name.into(), ..SourceChannel::default() });
        let log = Log::new(&channels, Clock::between(0.0, 1.0));
        let brake = |place: usize, most: f64, error: f64, t: f64| Brake {
            place,
            rest: 0.0,
            pressed: 0.1,
            gain: 1.0,
            most,
            error,
            slip: 0.0,
            t,
            idle: false,
        };
        let first = |a: Brake, b: Brake| {
            let mut order = [Some(a), Some(b)];
            let (doubt, _) = front_of(&log, &mut order);
            (order[0].as_ref().map(|b| b.place), doubt.is_some())
        };
        // exchanged: beyond doubt by force, or by slip
        assert_eq!(first(brake(0, 1.0, 0.1, 0.0), brake(1, 7.0, 0.3, 0.0)), (Some(1), false));
        assert_eq!(first(brake(0, 1.0, 0.1, 9.0), brake(1, 2.0, 0.1, -9.0)), (Some(1), false));
        // an account of stairs: one brake speeds up
        assert_eq!(first(brake(0, -3.6, 0.2, 0.0), brake(1, 6.1, 0.2, 0.0)), (Some(0), false));
        // not known well enough: the name stands, as a guess
        assert_eq!(first(brake(0, 1.0, 1.0, 0.0), brake(1, 5.0, 1.0, 0.0)), (Some(0), true));
        // as good as nothing is known: no doubt of the name
        assert_eq!(first(brake(0, 0.7, 1.3, 0.0), brake(1, 1.5, 1.3, 0.0)), (Some(0), false));
        assert_eq!(first(brake(0, 7.0, 0.3, 0.0), brake(1, 1.0, 0.1, 0.0)), (Some(0), false));
    }
}
