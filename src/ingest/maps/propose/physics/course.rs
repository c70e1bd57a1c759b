//! Course and yaw angle: `yaw rate = d(course)/dt`, the turn of the path.

use super::delay::delay;
use super::log::{Log, unit_of};
use super::signal::{self, change, earlier, line, unwrapped};
use super::speed::SPAN;
use super::speeds::{MOVING, Motion};
use super::verdict::{Verdict, Verdicts};
use crate::contract::channel::Channel;
use crate::ingest::maps::units;

const ANGLES: [&str; 2] = ["deg", "rad"];
/// The turn of a path tells delays no better than this, s: up to 0.2 off on simulated rides, as the motorcycle slips to
/// the side. Nor does a course or yaw angle, whose own delay is by the path.
pub(super) const BY_POSITION: f64 = 0.08;

/// A compass course or heading.
pub(super) fn course(log: &Log<'_>, motion: &mut Motion, out: &mut Verdicts) {
    let mut first = true;
    for place in log.named(Channel::Yaw) {
        let Some(signal) = log.live(place) else { continue };
        if log.of_other_dimension(place, &["angle"]) {
            continue;
        }
        let own = log.unit(place, "angle");
        let size = signal.extent[0].abs().max(signal.extent[1].abs());
        let unit = own.unwrap_or(if size > 7.0 { "deg" } else { "rad" });
        let to_rad = units::conversion(unit, "rad").map_or(1.0, |c| c.factor);
        // the samples between which the circle closes are no samples
        let x = unwrapped(&jumps_out(&signal.x), std::f64::consts::TAU / to_rad);
        let turn = signal::masked(&change(&x, SPAN), |i| motion.speed[i] > MOVING);
        let compass =
            ["course", "bearing", "heading", "compass"].iter().any(|w| log.has_word(place, w));
        let mut v = Verdict::new(Channel::Yaw, place, unit);
        let Some(reference) = motion.turn.clone() else {
            v.sign = if compass { -1.0 } else { 1.0 };
            v = v.because("by its name; no other channel shows which way it turns");
            if own.is_none() {
                v = v.doubted("the log does not say its unit");
            }
            if compass && first {
                motion.turn = Some(turn.iter().map(|w| -w * to_rad).collect());
                motion.turn_from = format!("`{}`", log.name(place));
                (v.delay, v.delay_error) =
                    motion.receiver.map_or((0.0, None), |d| (d.value, Some(d.error)));
                motion.turn = motion.turn.take().map(|t| earlier(&t, v.delay));
            }
            first = false;
            out.entries.push(v);
            continue;
        };
        let late = delay(&reference, &turn);
        let shifted = earlier(&turn, late.map_or(0.0, |d| d.value));
        let together = line(&reference, &shifted);
        let found = together.filter(|l| l.r.abs() > 0.9);
        let said = found.and_then(|l| Some((l, unit_of(own, "rad", &ANGLES, l.slope, 0.1)?)));
        match said {
            Some((l, unit)) => {
                v.unit = unit.name;
                v.sign = l.slope.signum();
                v.confirmed = true;
                (v.delay, v.delay_error) =
                    late.map_or((0.0, None), |d| (d.value, Some(d.error.hypot(BY_POSITION))));
                let way = if v.sign < 0.0 {
                    "a compass course, positive to the right"
                } else {
                    "positive to the left"
                };
                v = v.because(format!(
                    "r = {:.4} with the turn of {}: {way}",
                    l.r, motion.turn_from
                ));
                if first {
                    // finer than the position
                    let sign = v.sign;
                    let shifted = earlier(&turn, v.delay);
                    motion.turn = Some(shifted.iter().map(|w| sign * to_rad * w).collect());
                    motion.turn_from = format!("`{}`", log.name(place));
                } else {
                    v = v.doubted("there is more than one such channel");
                }
                first = false;
            }
            None => {
                let seen = match together {
                    Some(l) => format!("r = {:.2} between its turn and that of", l.r),
                    None => "too few turns to compare it with".to_owned(),
                };
                out.left.push((place, format!("named like yaw, but {seen} {}", motion.turn_from)));
                continue;
            }
        }
        out.entries.push(v);
    }
}

/// Interpolation across the end of a circle makes samples in its middle: those beside a jump go.
fn jumps_out(x: &[f64]) -> Vec<f64> {
    let size = x.iter().copied().filter(|v| v.is_finite()).fold(0.0_f64, |a, b| a.max(b.abs()));
    let jump = |i: usize, j: usize| (x[i] - x[j]).abs() > 0.2 * size;
    (0..x.len())
        .map(|i| {
            let near = i.saturating_sub(3)..(i + 4).min(x.len());
            let bad = near.clone().skip(1).any(|j| jump(j, j - 1));
            // at rest in between: the last good one stays
            if bad && size > 5.0 { f64::NAN } else { x[i] }
        })
        .collect::<Vec<f64>>()
        .into_iter()
        .scan(f64::NAN, |last, v| {
            if v.is_finite() {
                *last = v;
            }
            Some(v)
        })
        .collect()
}
