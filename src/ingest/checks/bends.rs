//! How much it turns: lean, yaw rate, heading, track over ground and lateral acceleration are accounts of one thing.
//!
//! ```text
//! -tan(roll) = v r / g = v d(yaw)/dt / g = v d(course)/dt / g = a_y / g
//! ```
//! each in g, to the left. Two that agree outvote one that does not, and that one is left out; where there are only
//! two, neither is believed. An account that needs the velocity speaks of it, too.

use super::finding::{Finding, Findings};
use super::view::{Pair, View};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Lateral acceleration above which it is a corner, g.
const BEND: f64 = 0.1;
/// Accounts agree within this factor: tyres are wide, riders hang off, receivers smooth; units differ by more.
const EQUAL: f64 = 1.45;
/// Less than this of each other is left of accounts that do not go together.
const TOGETHER: f64 = 0.25;
/// No motorcycle turns faster, rad/s.
pub(super) const FASTEST: f64 = 2.5;
/// Degrees per radian.
const DEGREES: f64 = 57.295_78;
/// Largest ratio of two units of speed.
const OF_SPEED: f64 = 4.0;

struct Account {
    channel: Channel,
    /// Whether it is by the velocity.
    by_speed: bool,
    /// In g, left positive.
    values: Vec<f64>,
}

pub(crate) fn check(view: &View, speed_agrees: bool, out: &mut Findings<'_>) -> Result<(), Error> {
    let mut accounts = accounts(view);
    // what is known to be wrong is no witness, and is not said twice
    let mirrored = out.warnings.iter().any(|w| w.code == "sign_lateral");
    accounts.retain(|a| !(out.concern(a.channel) || mirrored && a.channel == Channel::Latitude));
    let pairs: Vec<(usize, usize, Pair)> = (0..accounts.len())
        .flat_map(|i| (0..i).map(move |j| (j, i)))
        .filter_map(|(i, j)| Some((i, j, compared(view, &accounts[i], &accounts[j])?)))
        .collect();
    let agrees =
        |p: &Pair| p.scale > 0.0 && p.together > TOGETHER && p.scale.ln().abs() < EQUAL.ln();
    let friends =
        |k: usize| pairs.iter().filter(|(i, j, p)| (*i == k || *j == k) && agrees(p)).count();
    let mut said: Vec<usize> = Vec::new();
    for (i, j, pair) in pairs.iter().filter(|p| !agrees(&p.2)) {
        let (i, j) = (*i, *j);
        if said.contains(&i) || said.contains(&j) {
            continue;
        }
        let odd = match (friends(i), friends(j)) {
            (0, 1..) => Some(i),
            (1.., 0) => Some(j),
            _ => None,
        };
        // a wrong velocity puts all accounts by it on one side: then no number of them outvotes the rest
        let by_unit =
            pair.scale > 0.0 && pair.together > TOGETHER && pair.scale.ln().abs() < OF_SPEED.ln();
        let side = |k: usize| {
            let with = pairs.iter().filter(move |(a, b, p)| (*a == k || *b == k) && agrees(p));
            let with = with.flat_map(|(a, b, _)| [*a, *b]).chain([k]);
            let speeds: Vec<bool> = with.map(|n| accounts[n].by_speed).collect();
            speeds.iter().all(|s| *s == speeds[0]).then(|| speeds[0])
        };
        let speed =
            !speed_agrees && by_unit && matches!((side(i), side(j)), (Some(a), Some(b)) if a != b);
        let odd = odd.filter(|_| !speed);
        // signs of the others are judged by checks of their own
        let side = |k: usize| accounts[k].channel == Channel::AccelerationY;
        let own = odd.map_or(side(i) || side(j), side) && !mirrored;
        if pair.scale < 0.0 && agrees(&Pair { scale: -pair.scale, ..*pair }) && !own {
            continue;
        }
        let (of, other) = odd.map_or((j, i), |odd| (odd, if odd == i { j } else { i }));
        let scale = if of == i { pair.scale } else { 1.0 / pair.scale };
        let finding = finding(&accounts[of], &accounts[other], scale, pair, odd.is_some());
        match odd {
            // a track is no channel that could be left out
            Some(odd) if accounts[odd].channel == Channel::Latitude => {
                said.push(odd);
                out.push_contradiction(finding, &[Channel::Latitude, Channel::Longitude])?;
            }
            Some(odd) => {
                said.push(odd);
                out.push(finding)?;
            }
            None => {
                let mut channels = vec![accounts[i].channel, accounts[j].channel];
                // latitude and longitude are one account
                if channels.contains(&Channel::Latitude) {
                    channels.push(Channel::Longitude);
                }
                if speed {
                    channels.push(Channel::VelocityX);
                }
                out.push_contradiction(finding, &channels)?;
            }
        }
    }
    Ok(())
}

/// Two accounts as smooth as the smoother of them.
fn compared(view: &View, a: &Account, b: &Account) -> Option<Pair> {
    match (a.channel == Channel::Latitude, b.channel == Channel::Latitude) {
        (true, false) => view.pair(&a.values, &view.as_track(&b.values), BEND),
        (false, true) => view.pair(&view.as_track(&a.values), &b.values, BEND),
        _ => view.pair(&a.values, &b.values, BEND),
    }
}

fn accounts(view: &View) -> Vec<Account> {
    let Some(v) = view.get(Channel::VelocityX) else { return Vec::new() };
    let in_g = |turn: &[f64]| turn.iter().zip(v).map(|(r, v)| r * v / GRAVITY).collect();
    let mut out = Vec::new();
    let mut put = |channel, by_speed, values| out.push(Account { channel, by_speed, values });
    if let Some(roll) = view.get(Channel::Roll) {
        put(Channel::Roll, false, view.smooth(roll).iter().map(|x| -x.tan()).collect());
    }
    if let Some(rate) = view.get(Channel::YawRate) {
        put(Channel::YawRate, true, in_g(&view.smooth(rate)));
    }
    if let Some(yaw) = view.get(Channel::Yaw) {
        let turn = view.rate_of(yaw);
        let fast = |r: f64| r.abs() > FASTEST;
        // where an angle closes its circle it does not turn; in another unit it would do so all the time
        let all = view.moving(|i| turn[i]);
        let rare = all.iter().filter(|r| fast(**r)).count() * 20 < all.len();
        let turn: Vec<f64> =
            turn.iter().map(|r| if rare && fast(*r) { f64::NAN } else { *r }).collect();
        put(Channel::Yaw, true, in_g(&turn));
    }
    if let Some((_, turn)) = view.track() {
        put(Channel::Latitude, true, in_g(&turn));
    }
    if let Some(ay) = view.get(Channel::AccelerationY) {
        let values = view.smooth(ay).iter().map(|a| a / GRAVITY).collect();
        put(Channel::AccelerationY, false, values);
    }
    out
}

fn words(channel: Channel) -> &'static str {
    match channel {
        Channel::Roll => "the lean",
        Channel::YawRate => "yaw rate and speed",
        Channel::Yaw => "yaw and speed",
        Channel::AccelerationY => "acceleration_y",
        _ => "the track over ground",
    }
}

fn finding(of: &Account, other: &Account, scale: f64, pair: &Pair, outvoted: bool) -> Finding {
    let degrees = |x: f64| (0.6 * DEGREES..1.6 * DEGREES).contains(&x.abs());
    let what = if degrees(scale) {
        "it looks like degrees read as rad"
    } else if degrees(1.0 / scale) {
        "it looks like rad read as degrees"
    } else if pair.together <= TOGETHER {
        "they disagree: is one another axis of its sensor, or a sensor turned?"
    } else if scale < 0.0 {
        "one of them has the wrong sign"
    } else {
        "one of them, or the speed, is in another unit"
    };
    let vote = if outvoted {
        ", and the others agree with that"
    } else {
        ", and no other channel shows which is right"
    };
    Finding {
        code: RejectionCode::ScaleLateral,
        channel: of.channel,
        count: pair.n,
        message: format!(
            "{} gives {scale:.2} times the lateral acceleration that {} gives{vote}: {what}; check unit and sign of \
             {} in the channel map",
            words(of.channel),
            words(other.channel),
            of.channel
        ),
    }
}
