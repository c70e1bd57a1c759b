//! Brakes and throttle against what follows them.

use super::finding::{Finding, Findings};
use super::view::{MIN_MEANS, View, quantile};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;

/// Deceleration that is braking, m/s²: more than an engine gives.
const BRAKES: f64 = 3.0;
/// A pressure that presses, as a share of the largest.
const PRESSED: f64 = 0.15;
/// Deceleration per pressure of both lines together, m/s² per bar: machines differ by a factor of 5
/// either way, units by 10 and more.
const PER_BAR: [f64; 2] = [0.1, 2.8];
/// Pa.
const BAR: f64 = 1e5;
/// Units that loggers write, Pa.
const UNITS: [(&str, f64); 6] =
    [("bar", 1e5), ("psi", 6_894.757), ("kPa", 1e3), ("mbar", 100.0), ("MPa", 1e6), ("Pa", 1.0)];
/// Least pressure of a line that brakes, bar.
const LEAST: f64 = 1.0;
/// Deceleration that needs no brake, m/s², and how many times a line's usual noise it must reach to be one that brakes.
const FREE: f64 = 0.3;
const NOISE: f64 = 15.0;
/// A usual deceleration per bar, m/s².
const USUAL: f64 = 0.5;
/// How much further open the throttle must be under braking than under drive to be turned round.
const OPEN: f64 = 0.2;

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    let Some(v) = view.get(Channel::VelocityX) else { return Ok(()) };
    let pull = view.rate_of(v);
    for channel in [Channel::BrakePressureFront, Channel::BrakePressureRear] {
        if let Some(p) = view.get(channel) {
            sign(view, channel, p, &pull, out)?;
        }
    }
    unit(view, &pull, out)?;
    if let Some(t) = view.get(Channel::Throttle) {
        throttle(view, t, &pull, out)?;
    }
    Ok(())
}

/// Median of a channel where a condition on the acceleration holds.
fn middle(view: &View, x: &[f64], keep: impl Fn(usize) -> bool) -> Option<f64> {
    view.median(|i| if keep(i) { x[i] } else { f64::NAN }).map(|m| m.value)
}

fn sign(
    view: &View,
    channel: Channel,
    p: &[f64],
    pull: &[f64],
    out: &mut Findings<'_>,
) -> Result<(), Error> {
    let mut all = view.moving(|i| p[i]);
    if all.len() < MIN_MEANS {
        return Ok(());
    }
    let range = quantile(&mut all, 0.995) - quantile(&mut all, 0.005);
    let (braked, free) =
        (middle(view, p, |i| pull[i] < -BRAKES), middle(view, p, |i| pull[i] > -FREE));
    let (Some(braked), Some(free)) = (braked, free) else { return Ok(()) };
    if range < 0.5 * BAR || braked - free > -PRESSED * range {
        return Ok(());
    }
    out.push(Finding {
        code: RejectionCode::SignPressure,
        channel,
        count: all.len(),
        message: format!(
            "{channel} falls when it brakes, from {:.1} to {:.1} bar: its sign is wrong; turn it in the channel map",
            free / BAR,
            braked / BAR
        ),
    })
}

/// Deceleration per pressure where it brakes, of both lines together: one logger writes one unit.
fn unit(view: &View, pull: &[f64], out: &mut Findings<'_>) -> Result<(), Error> {
    use Channel::{BrakePressureFront, BrakePressureRear};
    let lines: Vec<(Channel, Vec<f64>)> = [BrakePressureFront, BrakePressureRear]
        .into_iter()
        .filter(|c| !out.concern(*c))
        .filter_map(|c| {
            let p = view.get(c)?;
            let rest = view.median(|i| p[i])?.value;
            Some((c, p.iter().map(|p| (p - rest) / BAR).collect()))
        })
        .collect();
    // a front line alone or both: what the rear one does by itself is too little to tell its unit
    if lines.first().is_none_or(|l| l.0 != BrakePressureFront) {
        return Ok(());
    }
    let whole = |i: usize| lines.iter().map(|l| l.1[i]).sum::<f64>();
    let mut all = view.moving(whole);
    if all.len() < MIN_MEANS {
        return Ok(());
    }
    let most = quantile(&mut all, 0.998);
    let gain = view.median(|i| {
        let p = whole(i);
        if pull[i] < -BRAKES && p > PRESSED * most { -pull[i] / p } else { f64::NAN }
    });
    let Some(gain) = gain.filter(|g| !(PER_BAR[0]..PER_BAR[1]).contains(&g.value)) else {
        return weak(view, &lines, pull, out);
    };
    // read as bar, kPa or psi where it was another: the pair that makes the gain usual
    let pairs = UNITS.iter().flat_map(|is| UNITS.iter().map(move |read| (is, read)));
    let off =
        |(is, read): &(&(&str, f64), &(&str, f64))| (gain.value * read.1 / is.1 / USUAL).ln().abs();
    let pairs = pairs.filter(|(is, read)| is.0 != read.0);
    let near = pairs.min_by(|a, b| off(a).total_cmp(&off(b)));
    let like =
        near.map_or(String::new(), |(is, read)| format!(", as of {} read as {}", is.0, read.0));
    for (channel, _) in &lines {
        out.push(Finding {
            code: RejectionCode::UnitPressure,
            channel: *channel,
            count: gain.n,
            message: format!(
                "{channel}: braking gives {:.3} m/s2 per bar, usual is {USUAL}{like}; give the unit in the channel map",
                gain.value
            ),
        })?;
    }
    Ok(())
}

/// A line that is next to nothing while it brakes hard and the other line does not: its unit alone is wrong.
fn weak(
    view: &View,
    lines: &[(Channel, Vec<f64>)],
    pull: &[f64],
    out: &mut Findings<'_>,
) -> Result<(), Error> {
    for (channel, own) in lines {
        let mut all = view.moving(|i| own[i]);
        let most = quantile(&mut all, 0.998);
        // a brake that nobody uses shows its sensor's noise
        let free = |i: usize| if pull[i] > -FREE { own[i].abs() } else { f64::NAN };
        if view.median(free).is_none_or(|noise| most < NOISE * noise.value) {
            continue;
        }
        let alone = |i: usize| {
            let others = lines.iter().filter(|l| l.0 != *channel).all(|l| l.1[i] < LEAST);
            // a line that does nothing when it brakes is another matter
            pull[i] < -BRAKES && others && own[i] > PRESSED * most
        };
        let count = view.moving(|i| if alone(i) { own[i] } else { f64::NAN }).len();
        if most > 0.0 && most < LEAST && count >= MIN_MEANS {
            out.push(Finding {
                code: RejectionCode::UnitPressure,
                channel: *channel,
                count,
                message: format!(
                    "{channel} is at most {most:.4} bar, and it brakes hard with it alone; give the unit in the channel map"
                ),
            })?;
        }
    }
    Ok(())
}

fn throttle(view: &View, t: &[f64], pull: &[f64], out: &mut Findings<'_>) -> Result<(), Error> {
    let (braked, driven) =
        (middle(view, t, |i| pull[i] < -BRAKES), middle(view, t, |i| pull[i] > 1.5));
    let (Some(braked), Some(driven)) = (braked, driven) else { return Ok(()) };
    if braked < driven + OPEN {
        return Ok(());
    }
    out.push(Finding {
        code: RejectionCode::SignThrottle,
        channel: Channel::Throttle,
        count: view.count_moving(),
        message: format!(
            "throttle is {:.0} % open under braking and {:.0} % under drive: it is inverted, or another channel",
            100.0 * braked,
            100.0 * driven
        ),
    })
}
