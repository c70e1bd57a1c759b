//! A lean that some logger calculated of the lateral acceleration: it says nothing of the tyres.
//!
//! ```text
//! -tan(roll) = a_y / g = v r / g          number by number
//! ```
//! A motorcycle's own lean is 2.5 to 7 % larger, and more: tyres are wide. It is also the lean of another sensor, with
//! noise of its own. Apps compute a lean of the speed and course of a receiver; as a measurement it would give a lateral
//! friction of about -1 for every tyre.

use super::finding::{Finding, Findings};
use super::view::{FEWEST, View, quantile};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Lateral acceleration from which a bend is steep enough that a lean in tenths of a degree is not coarse, g.
const STEEP: f64 = 0.15;
/// Half of the means agree within this share, ...
const EXACT: f64 = 0.005;
/// ... and three quarters within this.
const NEAR: f64 = 0.01;
/// A lean larger than what the turn asks for by this share is measured: then the other is made of it.
const LARGER: f64 = 1.03;

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
    let Some(count) = by_side.and_then(|side| same(view, &lean, &side)) else { return Ok(()) };
    // which of the two is made of the other shows in the turn
    let by_course = view.get(Channel::Yaw).map(|yaw| in_g(&view.rate_of(yaw)));
    let smooth = view.smooth(&lean);
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
    let is_same =
        all.len() >= FEWEST && quantile(&mut all, 0.5) < EXACT && quantile(&mut all, 0.75) < NEAR;
    is_same.then_some(all.len())
}

fn finding(of: &str, count: usize) -> Finding {
    Finding {
        code: RejectionCode::CalculatedLean,
        channel: Channel::Roll,
        count,
        message: format!(
            "roll is -atan({of}) number by number: one of them is calculated of the other, and as a measurement of the \
             lean it would say of every tyre the same; map a lean that an inertial unit measures"
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
