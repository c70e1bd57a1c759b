//! How late one channel is after another: the lag at which their changes agree best.

use super::signal::RATE;
use crate::statistics::order;

/// Longest delay that is looked for, s.
const LONGEST: f64 = 1.0;
/// Parts of a ride that are timed one by one: they tell how well the delay is known.
const PARTS: usize = 12;
/// Points of a part, at least: 6 s.
const LEAST: usize = 120;
/// Least agreement at the best lag.
const AGREES: f64 = 0.6;

/// A delay and how well it is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Delay {
    /// s; positive where the channel is later than the reference.
    pub value: f64,
    /// Standard error, s.
    pub error: f64,
    /// Correlation at that lag, with the sign of the channel.
    pub r: f64,
}

/// The delay of `channel` after `reference`, both such that only their shape counts; `None` where they do not agree
/// at any lag or do not change.
pub(super) fn delay(reference: &[f64], channel: &[f64]) -> Option<Delay> {
    let most = (LONGEST * RATE) as i64;
    let n = reference.len().min(channel.len());
    let (whole, r) = peak(&reference[..n], &channel[..n], -most, most)?;
    if r.abs() < AGREES {
        return None;
    }
    let around = whole.round() as i64;
    let size = (n / PARTS).max(LEAST);
    let mut parts = Vec::new();
    for start in (0..n).step_by(size) {
        let end = (start + size).min(n);
        let (a, b) = (&reference[start..end], &channel[start..end]);
        let found =
            peak(a, b, around - 6, around + 6).filter(|p| p.1.abs() > AGREES && p.1 * r > 0.0);
        parts.extend(found.map(|p| p.0 / RATE));
    }
    if parts.len() < 3 {
        return Some(Delay { value: whole / RATE, error: 0.1, r });
    }
    let count = parts.len() as f64;
    let (first, second) = parts.split_at(parts.len() / 2);
    let halves = [first, second].map(|half| order::median(&mut half.to_vec()));
    let middle = order::median(&mut parts)?;
    // of a median, and never less than a hundredth of a step
    let error = (1.25 * order::spread_about(&parts, middle) / count.sqrt()).max(0.01 / RATE);
    let error = halves_error(halves, error);
    Some(Delay { value: whole / RATE, error, r })
}

/// A standard error of a delay, s: as much as two halves of the log are apart, and not less than `least`.
pub(super) fn halves_error(halves: [Option<f64>; 2], least: f64) -> f64 {
    match halves {
        [Some(a), Some(b)] => least.max(0.5 * (a - b).abs()),
        // a half that does not tell is no witness
        _ => 1.5 * least,
    }
}

/// Lag of the largest correlation, in steps and parts of one, and that correlation.
fn peak(a: &[f64], b: &[f64], from: i64, to: i64) -> Option<(f64, f64)> {
    let all: Vec<f64> = (from..=to).map(|lag| at_lag(a, b, lag).unwrap_or(0.0)).collect();
    let best = (0..all.len()).max_by(|i, j| all[*i].abs().total_cmp(&all[*j].abs()))?;
    // a peak at the edge is none
    let (before, after) = (all.get(best.checked_sub(1)?)?, all.get(best + 1)?);
    let (y0, y1, y2) = (before.abs(), all[best].abs(), after.abs());
    let bend = y0 - 2.0 * y1 + y2;
    if y1 == 0.0 || bend >= 0.0 {
        return None;
    }
    Some((from as f64 + best as f64 + 0.5 * (y0 - y2) / bend, all[best]))
}

fn at_lag(a: &[f64], b: &[f64], lag: i64) -> Option<f64> {
    let (mut n, mut sa, mut sb, mut saa, mut sbb, mut sab) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (i, x) in a.iter().enumerate() {
        let at = i as i64 + lag;
        if at < 0 || at as usize >= b.len() {
            continue;
        }
        let y = b[at as usize];
        if x.is_finite() && y.is_finite() {
            n += 1.0;
            sa += x;
            sb += y;
            saa += x * x;
            sbb += y * y;
            sab += x * y;
        }
    }
    if n < 0.5 * LEAST as f64 {
        return None;
    }
    let (aa, bb) = (saa - sa * sa / n, sbb - sb * sb / n);
    (aa > 0.0 && bb > 0.0).then(|| (sab - sa * sb / n) / (aa * bb).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_is_found_to_a_few_milliseconds_with_its_sign() {
        let of = |t: f64| (0.7 * t).sin() + 0.5 * (2.3 * t).sin() + 0.3 * (0.31 * t).cos();
        for late in [-0.33, -0.05, 0.0, 0.012, 0.2, 0.47] {
            let at = |shift: f64| (0..4000).map(|i| of(f64::from(i) / RATE - shift)).collect();
            let (a, b): (Vec<f64>, Vec<f64>) = (at(0.0), at(late));
            let turned: Vec<f64> = b.iter().map(|x| -3.0 * x).collect();
            for (channel, sign) in [(&b, 1.0), (&turned, -1.0)] {
                let found = delay(&a, channel).expect("found");
                assert!((found.value - late).abs() < 0.004, "{late}: {found:?}");
                assert!(found.r * sign > 0.99, "{found:?}");
            }
        }
    }

    #[test]
    fn channels_that_do_not_agree_have_none() {
        let a: Vec<f64> = (0..4000).map(|i| (f64::from(i) * 0.04).sin()).collect();
        let b: Vec<f64> = (0..4000).map(|i| (f64::from(i * i) * 1e-5).sin()).collect();
        assert_eq!(delay(&a, &b), None);
        assert_eq!(delay(&a, &[1.0; 4000]), None);
    }
}
