//! Speed over ground: which of the speeds it is, and which only repeat a wheel.

use super::log::{Log, Unit, unit_of};
use super::signal::{change, line, mean};
use super::speed::{SCALED, SPAN, SPEEDS, Speed, called, in_si, is_wheel};
use super::verdict::{Verdict, Verdicts};
use crate::contract::channel::Channel;

/// A channel farther from a wheel's speed than this is another speed, m/s.
const COPY: f64 = 0.12;
/// Both are rounded: a copy is off by no more than so many times what that does.
const EXACT: f64 = 2.5;
/// Braking that slips a wheel, m/s², ...
const BRAKED: f64 = -2.0;
/// ... riding that does not, ...
const GENTLE: f64 = 0.5;
/// ... and how far a wheel runs behind the ground then, at least, m/s.
const SLIPPED: f64 = 0.03;
/// Fewest points of each: 2 s.
const MIN_POINTS: usize = 40;
/// Words of a speed that is the ground's by its name.
const GROUND: [&str; 6] = ["gps", "gnss", "ground", "satellite", "sog", "vbox"];

/// Speed over ground among the speeds.
pub(super) fn velocity(
    log: &Log<'_>,
    speeds: &[Speed],
    wheels: &[Option<Speed>; 2],
    in_si_wheels: &[Option<Vec<f64>>; 2],
    from: &str,
    out: &mut Verdicts,
) -> Option<Speed> {
    let column = Channel::VelocityX;
    let taken = |s: &&Speed| wheels.iter().flatten().all(|w| w.place != s.place);
    let wheel_name = |place: usize| is_wheel(log, place);
    let mut found: Vec<(bool, usize, &Speed, Unit)> = Vec::new();
    for speed in speeds.iter().filter(taken).filter(|s| !wheel_name(s.place)) {
        let own = log.unit(speed.place, "speed");
        if log.of_other_dimension(speed.place, &["speed"]) {
            continue;
        }
        let scaled = || unit_of(own, "m/s", &SCALED, speed.slope, 0.02);
        let unit = unit_of(own, "m/s", &SPEEDS, speed.slope, 0.06).or_else(scaled);
        let Some(unit) = unit else { continue };
        let x = in_si(log, speed);
        let step = log.live(speed.place).map_or(0.0, |s| s.step);
        let step_of = |s: &Speed| log.live(s.place).map_or(0.0, |l| l.step) / s.slope;
        let by_name = GROUND.iter().any(|w| log.has_word(speed.place, w));
        let chosen = from == called(log, speed.place);
        let repeated = |k: &usize| {
            let (Some(wheel), Some(w)) = (&wheels[*k], &in_si_wheels[*k]) else { return false };
            let rounding = step_of(speed).hypot(step_of(wheel)) / 12.0_f64.sqrt();
            !by_name && repeats(w, &x, rounding, !chosen)
        };
        let copy = (0..wheels.len()).find(repeated);
        if let Some(k) = copy {
            let wheel = wheels[k].as_ref().map(|w| log.name(w.place)).unwrap_or_default();
            out.left.push((speed.place, format!("it is `{wheel}` again, in steps of {step:.3}")));
            continue;
        }
        let named = log.score(speed.place, column);
        found.push((named.is_some(), named.unwrap_or(0), speed, unit));
    }
    for i in log.named(column) {
        let other = found.iter().any(|f| f.2.place == i) || out.left_out(i).is_some();
        if !other && !wheel_name(i) {
            let r = line(&mean(log.x(i), SPAN), &reference_of(log, wheels, i)).map(|l| l.r);
            let seen = r.map_or(String::new(), |r| format!(" (r = {r:.2})"));
            out.left
                .push((i, format!("named like {column}, but it disagrees with the {from}{seen}")));
        }
    }
    // the best name first; of equal names the one that goes best with the position
    found.sort_by(|a, b| (b.0, b.1).cmp(&(a.0, a.1)).then(b.2.r.total_cmp(&a.2.r)));
    let rivals: Vec<&(bool, usize, &Speed, Unit)> =
        found.iter().skip(1).filter(|f| (f.0, f.1) == (found[0].0, found[0].1)).collect();
    let clear = |f: &&&(bool, usize, &Speed, Unit)| (1.0 - f.2.r) > 2.0 * (1.0 - found[0].2.r);
    // the same numbers again are no rival
    let ours = in_si(log, found.first()?.2);
    let same = |f: &Speed| line(&ours, &in_si(log, f)).is_some_and(|l| l.rms < COPY);
    let unclear = rivals.iter().any(|f| !clear(&f) && !same(f.2));
    let best = found.first()?;
    for (i, (named, _, speed, unit)) in found.iter().enumerate().take(4) {
        let mut v = Verdict { confirmed: true, ..Verdict::new(column, speed.place, &unit.name) };
        v = v.because(format!(
            "r = {:.4} with the {from}, {:.4} of its numbers are 1 m/s: {}",
            speed.r, speed.slope, unit.name
        ));
        if let Some(not) = &unit.not {
            v = v.because(format!("the log says {not}, the motion does not"));
        }
        if !named {
            v = v.because("its motion shows this, its name does not");
        }
        if i > 0 {
            v = v.doubted(format!("`{}` suits better", log.name(best.2.place)));
        } else if unclear {
            v = v.doubted(
                "there is more than one such channel, and the motion does not separate them",
            );
        }
        out.entries.push(v);
    }
    Some(best.2.clone())
}

/// A wheel's speed, for the figure of a channel that is none.
fn reference_of(log: &Log<'_>, wheels: &[Option<Speed>; 2], _: usize) -> Vec<f64> {
    wheels.iter().flatten().next().map_or(Vec::new(), |w| mean(&in_si(log, w), SPAN))
}

/// Whether a speed is a wheel's again, both in m/s: rounded anew, or without slip where the brakes slip the wheel.
///
/// `rounding` is what both steps do, rms, m/s; `slip` says whether the second counts.
fn repeats(wheel: &[f64], x: &[f64], rounding: f64, slip: bool) -> bool {
    let Some(l) = line(wheel, x).filter(|l| l.rms < COPY) else { return false };
    if l.rms < EXACT * rounding {
        return true;
    }
    let pull = change(&mean(wheel, SPAN / 2), SPAN / 2);
    let off = |keep: &dyn Fn(f64) -> bool| {
        let off = (0..pull.len().min(x.len())).filter(|&i| keep(pull[i]));
        let off: Vec<f64> = off.map(|i| x[i] - l.slope * wheel[i] - l.offset).collect();
        let off: Vec<f64> = off.into_iter().filter(|o| o.is_finite()).collect();
        (off.len() >= MIN_POINTS).then(|| off.iter().sum::<f64>() / off.len() as f64)
    };
    let (braked, gentle) = (off(&|a| a < BRAKED), off(&|a| a.abs() < GENTLE));
    matches!((braked, gentle), (Some(b), Some(g)) if slip && (b - g).abs() < SLIPPED)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::maps::propose::physics::signal::RATE;

    /// Five minutes of drive and braking, m/s.
    fn ridden() -> Vec<f64> {
        let speed = |t: f64| 24.0 + 8.0 * (0.35 * t).sin() + 2.0 * (0.9 * t).sin();
        (0..6000).map(|i| speed(f64::from(i) / RATE)).collect()
    }

    fn rounded(x: &[f64], step: f64) -> Vec<f64> {
        x.iter().map(|v| (v / step).round() * step).collect()
    }

    #[test]
    fn a_wheel_rounded_anew_is_a_copy_and_what_it_slips_against_is_none() {
        let ground = ridden();
        let pull = change(&ground, 2);
        // 0.1 % of slip a m/s2 under the brakes
        let slips = |i: usize| 1.0 + 0.001 * pull[i].min(0.0);
        let wheel: Vec<f64> = (0..ground.len()).map(|i| ground[i] * slips(i)).collect();
        let whole = 1.0 / 3.6;
        assert!(repeats(&wheel, &rounded(&wheel, whole), whole / 12.0_f64.sqrt(), true));
        let fine = rounded(&ground, 0.01);
        let l = line(&wheel, &fine).expect("a line");
        assert!(l.rms < COPY, "as near as a copy: {l:?}");
        for slip in [true, false] {
            assert!(!repeats(&wheel, &fine, 0.003, slip), "{l:?}");
        }
    }
}
