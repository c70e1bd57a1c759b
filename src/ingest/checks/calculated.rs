//! A lean that some logger calculated of the lateral acceleration: it says nothing of the tyres.
//!
//! ```text
//! -tan(roll) = a_y / g = v r / g          number by number, or late and smoothed
//! ```
//! A motorcycle's own lean is 2.5 to 7 % larger, and more: tyres are wide. It is also the lean of another sensor, with
//! noise of its own. Apps compute a lean of the speed and course of a receiver; as a measurement it would give a lateral
//! friction of about -1 for every tyre.
//!
//! METHOD: a lean of 1 Hz, or a smoothed one, is another number at each sample. Its mean over 2.2 s, moved by up to 2 s, still is the
//! turn's, and as large. Measured leans of an independent simulator and of the archive (33 rides) are 9 to 16 % larger, and
//! 1.3 % off their own ratio at the least, so that a rider who hangs off as far as the tyres are wide loses none of them. A
//! lean that is as large as the turn asks for, and farther off, may be either: it stays, with a warning.

use super::bends::FASTEST;
use super::finding::{Finding, Findings};
use super::view::{MIN_MEANS, View, quantile};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Lateral acceleration from which a corner is steep enough that a lean in tenths of a degree is not coarse, g.
const STEEP: f64 = 0.15;
/// Half of the means agree within this share, ...
const EXACT: f64 = 0.005;
/// ... and three quarters within this.
const UPPER_QUARTILE_TOLERANCE: f64 = 0.01;
/// A lean larger than what the turn asks for by this share is measured: then the other is made of it.
const LARGER: f64 = 1.03;
/// Most by which a lean is moved against the turn, in means of 0.2 s.
const LATEST: usize = 10;
/// Means in steep corners from which a smoothed lean is judged: 20 s.
const ENOUGH: usize = 100;
/// Ratios to the turn that a calculated lean has, smoothed or not, ...
const AS_LARGE: std::ops::Range<f64> = 0.97..1.01;
/// ... and half of its means are within this share of that ratio.
const CLOSE: f64 = 0.011;
/// The same of a lean that may be calculated or measured.
const MAYBE_CLOSE: f64 = 0.05;

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    let (Some(v), Some(roll)) = (view.get(Channel::VelocityX), view.get(Channel::Roll)) else {
        return Ok(());
    };
    let lean: Vec<f64> = roll.iter().map(|x| -x.tan()).collect();
    let in_g =
        |turn: &[f64]| -> Vec<f64> { turn.iter().zip(v).map(|(r, v)| r * v / GRAVITY).collect() };
    let by_rate = view.get(Channel::YawRate).map(in_g);
    let side = view.get(Channel::AccelerationY);
    let by_side = side.map(|a| a.iter().map(|a| a / GRAVITY).collect::<Vec<f64>>());
    if let Some(count) = by_rate.as_ref().and_then(|turn| same(view, &lean, turn)) {
        return out.push(finding("v x yaw_rate / g", count));
    }
    // where an angle closes its circle it does not turn
    let course = |yaw: &[f64]| -> Vec<f64> {
        let rates = view.rate_of(yaw).into_iter();
        rates.map(|r| if r.abs() > FASTEST { f64::NAN } else { r }).collect()
    };
    let by_course = view.get(Channel::Yaw).map(|yaw| in_g(&course(yaw)));
    let smooth = view.smooth(&lean);
    let Some(count) = by_side.and_then(|side| same(view, &lean, &side)) else {
        let rate = by_rate.and_then(|turn| Follows::of(view, &lean, &turn, "v x yaw_rate / g"));
        let course = by_course.and_then(|turn| Follows::of(view, &smooth, &turn, "v x turn / g"));
        let both = [rate, course].into_iter().flatten();
        let closest = both.min_by(|a, b| a.off.total_cmp(&b.off));
        return match closest {
            Some(follows) => follows.say(out),
            None => Ok(()),
        };
    };
    // which of the two is made of the other shows in the turn
    let turns = [by_rate.map(|turn| view.smooth(&turn)), by_course];
    let mut scales = turns.iter().flatten().filter_map(|t| view.pair(&smooth, t, STEEP));
    let finding = finding("acceleration_y / g", count);
    match scales.any(|p| p.scale > LARGER) {
        true => out.push_contradiction(finding, &[Channel::Roll, Channel::AccelerationY]),
        false => out.push(finding),
    }
}

/// In how many means the lean is another account, number by number; `None` where it is another.
fn same(view: &View, lean: &[f64], other: &[f64]) -> Option<usize> {
    let off = |i: usize| match other[i].abs() > STEEP {
        true => (lean[i] / other[i] - 1.0).abs(),
        false => f64::NAN,
    };
    let mut all = view.moving(off);
    let is_same = all.len() >= MIN_MEANS
        && quantile(&mut all, 0.5) < EXACT
        && quantile(&mut all, 0.75) < UPPER_QUARTILE_TOLERANCE;
    is_same.then_some(all.len())
}

/// How a lean follows an account of the turn, both over 2.2 s.
#[derive(Debug)]
struct Follows {
    /// Source of the turn.
    of: &'static str,
    /// Lean over turn.
    scale: f64,
    /// Half of the means are within this share of that.
    off: f64,
    /// Means in steep corners.
    count: usize,
}

impl Follows {
    /// At the delay at which it follows best; `None` of too few corners, and of a lean that is larger or smaller than the turn
    /// asks for.
    fn of(view: &View, lean: &[f64], turn: &[f64], of: &'static str) -> Option<Self> {
        let (lean, turn) = (view.as_slow(lean), view.as_slow(turn));
        let at = |late: usize| {
            // by so much later than the turn, or earlier
            let ratio = |i: usize| {
                let place = (i + late).checked_sub(LATEST);
                match place.and_then(|place| lean.get(place)).filter(|_| turn[i].abs() > STEEP) {
                    Some(lean) => lean / turn[i],
                    None => f64::NAN,
                }
            };
            // an offset of the lean makes left and right corners differ, and is no share
            let side = |is_left| {
                let is_it = |i: usize| (turn[i] > 0.0) == is_left;
                view.moving(|i| if is_it(i) { ratio(i) } else { f64::NAN })
            };
            let mut sides = [side(true), side(false)];
            let mut off = sides.concat();
            let count = off.len();
            if count < ENOUGH {
                return None;
            }
            let of_side = |all: &mut Vec<f64>| (all.len() >= MIN_MEANS).then(|| quantile(all, 0.5));
            let scales: Vec<f64> = sides.iter_mut().filter_map(of_side).collect();
            let scale = scales.iter().sum::<f64>() / scales.len() as f64;
            off.iter_mut().for_each(|ratio| *ratio = (*ratio / scale - 1.0).abs());
            Some(Follows { of, scale, off: quantile(&mut off, 0.5), count })
        };
        let best = (0..=2 * LATEST).filter_map(at).min_by(|a, b| a.off.total_cmp(&b.off));
        best.filter(|best| AS_LARGE.contains(&best.scale) && best.off < MAYBE_CLOSE)
    }

    /// Leaves the lean out if it is too close for a sensor of its own; else says that it may be calculated.
    fn say(&self, out: &mut Findings<'_>) -> Result<(), Error> {
        let Follows { of, scale, off, count } = self;
        let size = format!(
            "roll is {scale:.3} times -atan({of}), both over 2 s, within {:.1} %",
            100.0 * off
        );
        let finding = |message: String| Finding {
            code: RejectionCode::CalculatedLean,
            channel: Channel::Roll,
            count: *count,
            message,
        };
        if *off < CLOSE {
            return out.push(finding(format!(
                "{size}: it was calculated from the turn and smoothed, not measured, so every tyre \
                 would get the same coefficients; map a lean that an inertial unit measures"
            )));
        }
        let doubt = format!(
            "{size}: a measured lean is 2.5 to 7 % larger, as tyres are wide, unless the rider hangs off. If a receiver or an \
             app calculated it, leave it out of the map: every tyre would have a lateral friction of about -1"
        );
        // a warning: a measured one stays, and what it determines
        out.push_contradiction(finding(doubt), &[])
    }
}

fn finding(of: &str, count: usize) -> Finding {
    Finding {
        code: RejectionCode::CalculatedLean,
        channel: Channel::Roll,
        count,
        message: format!(
            "roll is -atan({of}) number by number: one was calculated from the other, not \
             measured, so every tyre would get the same coefficients; map a lean that an inertial \
             unit measures"
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::super::check as check_session;
    use super::super::tests::{bike, ride, without};
    use super::*;
    use crate::contract::session::Session;
    use crate::ingest::config::Config;

    /// The ride with a lean that an app calculated, in tenths of a degree, and what the checks say.
    fn said(mut session: Session, larger: f64, gone: &[Channel]) -> (Vec<&'static str>, bool) {
        let get = |c: Channel| session.get(c).expect("there").to_vec();
        let (v, r) = (get(Channel::VelocityX), get(Channel::YawRate));
        let side: Vec<f64> = v.iter().zip(&r).map(|(v, r)| v * r).collect();
        let tenths = |a: &f64| (-10.0 * (larger * a / GRAVITY).atan().to_degrees()).round() / 10.0;
        session.set(Channel::Roll, side.iter().map(|a| tenths(a).to_radians()).collect());
        session.set(Channel::AccelerationY, side);
        let mut session = without(session, gone);
        let warnings = check_session(&mut session, Some(&bike()), &Config::default());
        let codes = warnings.expect("no refusal").iter().map(|w| w.code).collect();
        (codes, session.has(Channel::Roll))
    }

    /// Lean of a turn with a share more, as a receiver of 1 Hz has it: the mean of a second, held or drawn straight.
    fn of_receiver(session: &Session, larger: f64, is_held: bool) -> Vec<f64> {
        let get = |c: Channel| session.get(c).expect("there");
        let turn = get(Channel::VelocityX).iter().zip(get(Channel::YawRate));
        let lean: Vec<f64> = turn.map(|(v, r)| -(larger * v * r / GRAVITY).atan()).collect();
        let size = session.rate as usize;
        let means: Vec<f64> =
            lean.chunks(size).map(|all| all.iter().sum::<f64>() / all.len() as f64).collect();
        let at = |i: usize| {
            let (k, share) = (i / size, (i % size) as f64 / size as f64);
            let next = means.get(k + 1).unwrap_or(&means[k]);
            if is_held { means[k] } else { means[k] + share * (next - means[k]) }
        };
        (0..lean.len()).map(at).collect()
    }

    /// Findings of the checks on a ride with another lean and no lateral acceleration, and whether the lean stays.
    fn said_of(mut session: Session, lean: Vec<f64>) -> (Vec<String>, bool) {
        session.set(Channel::Roll, lean);
        let mut session = without(session, &[Channel::AccelerationY, Channel::RollRate]);
        let warnings = check_session(&mut session, Some(&bike()), &Config::default());
        let all = warnings.expect("no refusal").into_iter();
        let own = all.filter(|w| w.code == "calculated_lean").map(|w| w.message).collect();
        (own, session.has(Channel::Roll))
    }

    #[test]
    fn a_calculated_lean_of_1_hz_is_seen_without_a_lateral_acceleration() {
        for seed in 0..4 {
            for is_held in [true, false] {
                let ride = ride(seed);
                let (messages, stays) = said_of(ride.clone(), of_receiver(&ride, 1.0, is_held));
                assert_eq!(messages.len(), 1, "{seed}, held {is_held}: {messages:?}");
                // drawn straight it is twice as far off as a sensor may be: that is said, and it stays
                assert_eq!(stays, !is_held, "{seed}: {messages:?}");
                // as wide tyres lean
                let (messages, stays) = said_of(ride.clone(), of_receiver(&ride, 1.05, is_held));
                assert!(messages.is_empty() && stays, "{seed}, held {is_held}: {messages:?}");
            }
        }
    }

    /// A rider who hangs off as far as the tyres are wide: as large as calculated, but of a sensor of its own.
    #[test]
    fn a_measured_lean_stays_even_where_it_is_no_larger_than_the_turn() {
        for seed in 0..4 {
            let ride = ride(seed);
            let get = |c: Channel| ride.get(c).expect("there");
            let turn = get(Channel::VelocityX).iter().zip(get(Channel::YawRate));
            let ideal: Vec<f64> = turn.map(|(v, r)| -(v * r / GRAVITY).atan()).collect();
            // the rider moves: 4 % more and less within 12 s
            let lean = |(i, x): (usize, &f64)| x * (1.0 + 0.04 * (i as f64 / 100.0).sin());
            let lean = ideal.iter().enumerate().map(lean).collect();
            let (messages, stays) = said_of(ride, lean);
            assert!(stays, "{seed}: {messages:?}");
        }
    }

    #[test]
    fn a_calculated_lean_is_left_out_and_a_measured_one_stays() {
        use Channel as C;
        let of_receiver = [C::YawRate, C::RollRate, C::SteerAngle, C::VelocityY];
        for seed in 0..4 {
            for gone in [&of_receiver[..], &[C::RollRate, C::VelocityY]] {
                let (codes, has_roll) = said(ride(seed), 1.0, gone);
                assert!(codes.contains(&"calculated_lean") && !has_roll, "{seed}: {codes:?}");
                // a lean as large as that of wide tyres
                let (codes, has_roll) = said(ride(seed), 1.05, gone);
                assert!(!codes.contains(&"calculated_lean") && has_roll, "{seed}: {codes:?}");
            }
        }
    }
}
