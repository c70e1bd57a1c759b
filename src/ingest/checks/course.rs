//! Signs of roll and yaw where no yaw rate is mapped: lean, course and track over ground turn the same way.
//!
//! [`angles`](super::angles) judges them by the yaw rate; many loggers have none. Then `v d(yaw)/dt`, `v` times the turn
//! of the track, and `-g tan(roll)` are three accounts of one lateral acceleration, and the odd one out is wrong.

use super::finding::{Finding, Findings};
use super::view::{Median, View};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Lateral acceleration above which it is a corner, g.
const BEND: f64 = 0.1;
/// A median ratio below this is that of a wrong sign.
const WRONG: f64 = -0.3;

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    let Some(v) = view.get(Channel::VelocityX).filter(|_| view.get(Channel::YawRate).is_none())
    else {
        return Ok(());
    };
    let in_g =
        |turn: Vec<f64>| -> Vec<f64> { turn.iter().zip(v).map(|(r, v)| r * v / GRAVITY).collect() };
    let lean = view
        .get(Channel::Roll)
        .map(|roll| view.smooth(roll).iter().map(|r| -r.tan()).collect::<Vec<f64>>());
    let yaw = view.get(Channel::Yaw).map(|yaw| in_g(view.rate_of(yaw)));
    let track = view.track().map(|(_, turn)| in_g(turn));
    // the ratio of two accounts, if it tells that they turn opposite ways
    let opposite = |a: &Option<Vec<f64>>, b: &Option<Vec<f64>>| -> Option<Median> {
        let (a, b) = (a.as_ref()?, b.as_ref()?);
        view.ratio(|i| a[i], |i| b[i], BEND).filter(|m| m.value < WRONG)
    };
    let by_track = |a| opposite(a, &track);
    let (lean_track, yaw_track) = (by_track(&lean), by_track(&yaw));
    if let Some(m) = opposite(&lean, &yaw) {
        return match (lean_track, yaw_track) {
            (None, Some(of)) => {
                out.push(yaw_turned(of, "the track over ground, and lean with it,"))
            }
            (lean_track, _) => out.push(roll_turned(m, lean_track.is_some())),
        };
    }
    match (lean_track, yaw_track) {
        (Some(m), Some(_)) => out.push(mirrored(m, Channel::Roll, "roll and yaw")),
        // nothing else tells whether it is the lean or the track (latitude and longitude exchanged)
        (Some(m), None) => {
            out.push_contradiction(mirrored(m, Channel::Roll, "roll"), &[Channel::Roll])
        }
        (None, Some(m)) => out.push(yaw_turned(m, "the track over ground")),
        (None, None) => Ok(()),
    }
}

fn yaw_turned(m: Median, witness: &str) -> Finding {
    Finding {
        code: RejectionCode::SignYaw,
        channel: Channel::Yaw,
        count: m.n,
        message: format!(
            "{witness} turns the other way than yaw ({:+.2} times in {} means of 0.2 s): a compass \
             course is positive to the right; give it `sign = -1` in the channel map",
            m.value, m.n
        ),
    }
}

fn roll_turned(m: Median, track: bool) -> Finding {
    let which = if track {
        "the track over ground agrees with yaw: turn the sign of roll in the channel map"
    } else {
        "one of them has the wrong sign, and no track over ground shows which (a compass course \
         needs `sign = -1`)"
    };
    Finding {
        code: RejectionCode::SignRollYaw,
        channel: Channel::Roll,
        count: m.n,
        message: format!(
            "roll leans out of the corners that yaw turns: -tan(roll) is {:+.2} times v d(yaw)/dt / g \
             in {} means of 0.2 s (left corner: roll negative, yaw growing); {which}",
            m.value, m.n
        ),
    }
}

fn mirrored(m: Median, channel: Channel, which: &str) -> Finding {
    Finding {
        code: RejectionCode::SignLateral,
        channel,
        count: m.n,
        message: format!(
            "the track over ground turns the other way than {which} ({:+.2} times in {} means of \
             0.2 s): either the sign is wrong (left corner: roll negative) or latitude and longitude \
             are exchanged",
            m.value, m.n
        ),
    }
}
