//! Throttle: shut under braking, open under drive, and what follows it tells how late it is.

use super::delay::{Delay, delay};
use super::lag::lowest;
use super::log::Log;
use super::signal::{self, change, mean};
use super::speeds::Motion;
use super::verdict::{UNTIMED, Verdict, Verdicts};
use crate::contract::channel::Channel;

/// Least error of a delay of the throttle, s: 0.05 rms on simulated rides of known delay, most of it too late.
const FOLLOWS: f64 = 0.025;
/// A throttle that opens further while drive no longer grows seems late by up to this, s.
const ASTRAY: f64 = 0.2;
/// How late the motorcycle follows the engine's torque, s: without it the account's delays were so much too small in the
/// mean of those 28 of 54 simulated logs (seeds 7101 to 7103) in which its correlation `r` was above 0.99.
const FOLLOWS_TORQUE: f64 = 0.028;
/// Error of a delay by the account of drive, s, for all of the drive that it leaves unexplained (`1 - r^2`), and the least:
/// in those logs the scatter was 0.007 where `r` is above 0.99, 0.014 from 0.985 on, and 0.023 below.
const BY_DRIVE: f64 = 0.57;
const BY_DRIVE_LEAST: f64 = 0.008;
/// Without wheels, a delay whose error is larger than this (`r` below 0.99) is not put in force, s: with 0.02 two of twenty
/// logs (seed 6180) had one that was 0.06 s wrong. The account goes wrong by more than its scatter where it explains less.
const TIMED: f64 = 0.0114;
/// Error of a delay without account: what an engine's slip, or what follows the throttle, leaves (rms 0.05 and more).
const UNEXPLAINED: f64 = 0.05;
/// Points either side over which drive is accounted for: 0.2 s.
const ACCOUNT: usize = 4;
/// Points either side over which the gear must not change, and the throttle not shut.
const GEAR: usize = 10;
const OPEN: usize = 12;
/// Ratios nearer than this are one gear's.
const SAME_GEAR: f64 = 0.05;
/// Least agreement of that account, as a correlation.
const EXPLAINED: f64 = 0.9;
/// Slowest that is accounted for, m/s.
const SLOWEST: f64 = 8.0;

/// The channel of the engine's speed, if there is one, and how late it is after the motion, if that is known.
type Engine = (Option<usize>, Option<Delay>);

pub(super) fn throttle(log: &Log<'_>, motion: &Motion, engine: Engine, out: &mut Verdicts) {
    let pull = mean(&motion.pull, 2);
    for place in log.named(Channel::Throttle) {
        let Some(signal) = log.live(place) else { continue };
        if log.of_other_dimension(place, &["ratio"]) {
            continue;
        }
        let x = mean(log.x(place), 2);
        let unit = match log.unit(place, "ratio") {
            Some(unit) if unit != "1" && unit != "-" && !unit.is_empty() => unit,
            _ if signal.extent[1] > 1.6 => "%",
            _ => "1",
        };
        let full = if unit == "%" { 100.0 } else { 1.0 };
        let hard = signal::quantile(&signal::masked(&x, |i| pull[i] < -4.0), 0.75);
        let drive = signal::quantile(&signal::masked(&x, |i| pull[i] > 1.5), 0.5);
        let mut v = Verdict::new(Channel::Throttle, place, unit);
        if signal.extent[1] > 1.3 * full || signal.extent[0] < -0.2 * full {
            out.left.push((
                place,
                format!(
                    "named like throttle, but it goes from {} to {}: no share of an opening",
                    signal.extent[0], signal.extent[1]
                ),
            ));
            continue;
        }
        if hard.is_finite() && drive.is_finite() {
            let said = format!(
                "{:.0} % under hard braking, {:.0} % under drive",
                100.0 * hard / full,
                100.0 * drive / full
            );
            if hard < 0.35 * drive {
                v.confirmed = true;
                v = v.because(said);
            } else {
                v = v.doubted(format!("it is not shut under braking: {said}"));
            }
        } else {
            v = v.because("by its name and range; too little braking and drive to check it");
        }
        late(&mut v, log, motion, engine, (place, full));
        if out.entries.iter().any(|e| e.channel == Channel::Throttle && e.doubt.is_none()) {
            v = v.doubted("there is more than one such channel");
        }
        out.entries.push(v);
    }
}

/// How late the throttle is: by the account of drive, as the engine's speed of the same line, or by what follows it.
fn late(
    v: &mut Verdict,
    log: &Log<'_>,
    motion: &Motion,
    engine: Engine,
    (place, full): (usize, f64),
) {
    let pull = mean(&motion.pull, 2);
    let acts = delay(&mean(log.x(place), 2), &pull).filter(|d| d.r > 0.0);
    // what follows the throttle is late, not the throttle
    let wheels = motion.wheels.iter().any(Option::is_some);
    let Some(own) = acts.map(|d| -d.value) else {
        if !wheels {
            v.doubt.get_or_insert(UNTIMED.into());
        }
        return;
    };
    let turns = engine.0.filter(|_| !wheels);
    let account = turns
        .and_then(|turns| by_drive(log, motion, turns, (place, full)))
        .filter(|(late, _)| (own - late).abs() < ASTRAY);
    let (delay, error, why) = match (account, engine.1) {
        (Some((late, error)), _) => {
            (late, error, "as late as drive by gear, engine speed and opening has it".to_owned())
        }
        (_, Some(with)) if (own - with.value).abs() < ASTRAY => {
            let why = "as late as the engine's speed, of the same line".to_owned();
            (with.value, with.error.min(FOLLOWS), why)
        }
        _ => (own, FOLLOWS, format!("drive follows it by {:+.2} s", -own)),
    };
    v.why.push(why);
    if wheels {
        (v.delay, v.delay_error) = (delay, Some(error));
        return;
    }
    let error = if account.is_some() { error } else { UNEXPLAINED };
    (v.delay, v.delay_error) = (delay, Some(error));
    if error > TIMED {
        v.why.push(format!("late by {delay:.2} +- {error:.2} s, it seems"));
        v.doubt.get_or_insert(UNTIMED.into());
    }
}

/// How late throttle and engine speed are after the receiver and the error of that, s, by least squares of
///
/// ```text
/// a(t + L) = g p (c1 + c2 n + c3 n^2) + g (1 - p) (c4 + c5 n) + c6 v^2 + c7 + c8 |a_y|
/// ```
///
/// with opening p, engine speed n and the gear's ratio g, where the throttle is open and the gear stays. A correlation of
/// opening and drive is late by 0.1 s and more: drive falls with the engine's speed while the throttle opens further.
fn by_drive(
    log: &Log<'_>,
    motion: &Motion,
    turns: usize,
    (place, full): (usize, f64),
) -> Option<(f64, f64)> {
    let (n, x) = (log.x(turns), log.x(place));
    let most = signal::quantile(n, 0.99);
    let (v, p, n) = (mean(&motion.speed, ACCOUNT), mean(x, ACCOUNT), mean(n, ACCOUNT));
    // no gear's number is needed, and a few per cent of slip do not matter
    let ratio: Vec<f64> = n.iter().zip(&v).map(|(n, v)| n / v).collect();
    let stays = |i: usize| {
        let far = [i.checked_sub(GEAR), Some(i + GEAR)];
        far.iter().all(|j| {
            let other = j.and_then(|j| ratio.get(j)).copied().unwrap_or(f64::NAN);
            (other / ratio[i] - 1.0).abs() < SAME_GEAR
        })
    };
    let of = |f: &dyn Fn(usize) -> f64| (0..v.len()).map(f).collect::<Vec<f64>>();
    let (p, n) = (of(&|i| p[i] / full), of(&|i| n[i] / most));
    let open = |i: usize| {
        let near = x.get(i.saturating_sub(OPEN)..(i + OPEN + 1).min(x.len())).unwrap_or_default();
        near.iter().all(|x| *x > 0.03 * full)
    };
    let keep = |i: usize| v[i] > SLOWEST && stays(i) && open(i);
    let top = signal::quantile(&ratio, 0.99);
    let g = |i: usize| ratio[i] / top;
    let terms = [
        of(&|i| g(i) * p[i]),
        of(&|i| g(i) * p[i] * n[i]),
        of(&|i| g(i) * p[i] * n[i] * n[i]),
        of(&|i| g(i) * (1.0 - p[i])),
        of(&|i| g(i) * (1.0 - p[i]) * n[i]),
        of(&|i| 1e-3 * v[i] * v[i]),
        vec![1.0; v.len()],
        of(&|i| motion.lateral[i].abs()),
    ];
    let (lag, r) = lowest(&terms, &change(&motion.speed, ACCOUNT), keep)?;
    let error = (BY_DRIVE * (1.0 - r * r)).max(BY_DRIVE_LEAST);
    (r > EXPLAINED).then_some((FOLLOWS_TORQUE - lag, error))
}
