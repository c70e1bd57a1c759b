//! The clocks of one logger.
//!
//! Its channels may come on several clocks (a CAN frame each, or a table's rows that have a sample), but the stamps
//! are those of one logger: what it stamps late, it stamps late for all. So the clocks are repaired once:
//!
//! - a clock that is another one shifted (by a channel map's `delay`), or some of its stamps, moves with it;
//! - of the others each has its own move onto straight lines, and what these moves have in common (their median at
//!   a time) is the logger's jitter, which is taken off all. A clock goes onto its own straight lines only where they
//!   differ from that by no more than [`APART`]; else its samples keep their times to the other channels.

use std::sync::Arc;

use super::single::{Repaired, clock_of, jitter, repair_one};

/// RMS by which a clock may move against the logger's others, s.
const APART: f64 = 2.5e-3;
/// Least share of a clock's moves that is the logger's, if any is.
const MOSTLY: f64 = 0.75;
/// Stamps that differ by less are the same, s.
const SAME: f64 = 1e-9;

/// Every clock repaired; `None` where one has no two usable stamps.
pub(crate) fn repair(times: &[Arc<Vec<f64>>]) -> Vec<Option<Repaired>> {
    let leaders: Vec<Option<Leader>> = (0..times.len()).map(|i| Leader::of(i, times)).collect();
    let mut out: Vec<Option<Repaired>> = times
        .iter()
        .zip(&leaders)
        .map(|(time, leader)| if leader.is_some() { None } else { repair_one(time) })
        .collect();
    keep_together(&mut out);
    for (i, leader) in leaders.into_iter().enumerate() {
        let Some(leader) = leader else { continue };
        let led = out[leader.at].as_ref().and_then(|whole| leader.lead(&times[leader.at], whole));
        out[i] = led.or_else(|| repair_one(&times[i]));
    }
    out
}

/// The clock that another one moves with.
struct Leader {
    at: usize,
    how: Tie,
}

enum Tie {
    /// All stamps are later by this, s.
    Shift(f64),
    /// The rows of the leader.
    Rows(Vec<usize>),
}

impl Leader {
    /// The first clock that leads clock `i` and is not led itself.
    fn of(i: usize, times: &[Arc<Vec<f64>>]) -> Option<Leader> {
        let led = |k: usize| (0..k).any(|j| shift(&times[j], &times[k]).is_some());
        let by_shift = (0..i).find_map(|at| shift(&times[at], &times[i]).map(|s| (at, s)));
        if let Some((at, shift)) = by_shift {
            return Some(Leader { at, how: Tie::Shift(shift) });
        }
        (0..times.len())
            .filter(|&at| at != i && times[at].len() > times[i].len() && !led(at))
            .filter_map(|at| Some((at, rows(&times[at], &times[i])?)))
            // the longest one is nobody's part
            .max_by_key(|(at, _)| times[*at].len())
            .map(|(at, rows)| Leader { at, how: Tie::Rows(rows) })
    }

    /// The led clock; `whole` is the leader's, repaired.
    fn lead(&self, raw: &[f64], whole: &Repaired) -> Option<Repaired> {
        let mut out = whole.clone();
        match &self.how {
            Tie::Shift(shift) => {
                let stamps = whole.clock.stamps.iter().map(|t| t + shift).collect();
                out.clock.stamps = Arc::new(stamps);
            }
            Tie::Rows(rows) => {
                let mut left = vec![usize::MAX; raw.len()];
                match &whole.kept {
                    None => left.iter_mut().enumerate().for_each(|(i, l)| *l = i),
                    Some(kept) => kept.iter().enumerate().for_each(|(i, row)| left[*row] = i),
                }
                let kept: Vec<usize> =
                    (0..rows.len()).filter(|&i| left[rows[i]] != usize::MAX).collect();
                let stamps: Vec<f64> =
                    kept.iter().map(|&i| whole.clock.stamps[left[rows[i]]]).collect();
                if stamps.len() < 2 {
                    return None;
                }
                out.clock = clock_of(stamps);
                out.kept = (kept.len() < rows.len()).then_some(kept);
            }
        }
        // said of the leader already
        (out.missing, out.duplicated, out.backwards) = Default::default();
        out.jitter = (0, 0.0);
        Some(out)
    }
}

/// By how much `other` is later throughout; `None` if it is not `time` shifted.
fn shift(time: &[f64], other: &[f64]) -> Option<f64> {
    if time.len() != other.len() {
        return None;
    }
    let of = |i: usize| other[i] - time[i];
    let first = (0..time.len()).map(of).find(|d| d.is_finite())?;
    let same = |i: usize| (of(i) - first).abs() < SAME || (time[i].is_nan() && other[i].is_nan());
    (0..time.len()).all(same).then_some(first)
}

/// The rows of `time` whose stamps `part` has; `None` if it has others too. In the order of both.
fn rows(time: &[f64], part: &[f64]) -> Option<Vec<usize>> {
    let mut all = time.iter().enumerate();
    part.iter().map(|t| all.find(|(_, whole)| *whole == t).map(|(i, _)| i)).collect()
}

/// Takes off what the clocks' moves have in common, and no more where they differ.
fn keep_together(clocks: &mut [Option<Repaired>]) {
    let voters: Vec<(Vec<f64>, Vec<f64>)> = clocks
        .iter()
        .flatten()
        .filter(|r| !r.coarse)
        .map(|r| {
            let stamps = &r.clock.stamps;
            match &r.raw {
                Some(raw) => (raw.clone(), stamps.iter().zip(raw).map(|(a, b)| a - b).collect()),
                None => (stamps.to_vec(), vec![0.0; stamps.len()]),
            }
        })
        .collect();
    if voters.len() < 2 {
        return;
    }
    for repaired in clocks.iter_mut().flatten().filter(|r| !r.coarse && r.jitter.0 > 0) {
        let Some(raw) = &repaired.raw else { continue };
        let mut cursors = vec![0; voters.len()];
        let mut common: Vec<f64> = raw.iter().map(|t| common(*t, &voters, &mut cursors)).collect();
        let own: Vec<f64> = repaired.clock.stamps.iter().zip(raw).map(|(a, b)| a - b).collect();
        // the median of moves that have nothing in common is no move of the logger
        if rms(&common) < MOSTLY * rms(&own) {
            common.fill(0.0);
        }
        let rest: Vec<f64> = own.iter().zip(&common).map(|(own, common)| own - common).collect();
        if rms(&rest) <= APART {
            continue;
        }
        let moved: Vec<f64> = raw.iter().zip(&common).map(|(t, c)| t + c).collect();
        let in_order = moved.windows(2).all(|w| w[0] < w[1]);
        let stamps = if in_order { moved } else { raw.clone() };
        // what is said is what the stamps do, not what was done
        let said = jitter(&repaired.clock.stamps, raw);
        repaired.clock = clock_of(stamps);
        (repaired.jitter, repaired.own_jitter) = (said, true);
    }
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

/// The median of the clocks' moves at a time, s; of an even number the smaller one of the two in the middle, none
/// where they are to opposite sides.
fn common(time: f64, clocks: &[(Vec<f64>, Vec<f64>)], cursors: &mut [usize]) -> f64 {
    let mut moves: Vec<f64> = clocks
        .iter()
        .zip(cursors)
        .filter_map(|((stamps, moves), at)| {
            while *at + 1 < stamps.len() && stamps[*at + 1] <= time {
                *at += 1;
            }
            let (before, after) = (stamps[*at], *stamps.get(*at + 1)?);
            let share = (time - before) / (after - before);
            (0.0..=1.0).contains(&share).then(|| moves[*at] + share * (moves[*at + 1] - moves[*at]))
        })
        .collect();
    moves.sort_unstable_by(f64::total_cmp);
    let n = moves.len();
    match n {
        0 => 0.0,
        _ if n % 2 == 1 => moves[n / 2],
        _ => {
            let (low, high) = (moves[n / 2 - 1], moves[n / 2]);
            if low * high <= 0.0 { 0.0 } else { low.abs().min(high.abs()).copysign(low) }
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;

    const N: usize = 2000;

    fn jittered(seed: u64, offset: f64, jitter: f64) -> Vec<f64> {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        (0..N).map(|i| 0.1 * i as f64 + offset + jitter * rng.random_range(-1.0..1.0)).collect()
    }

    fn stamps(clocks: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let times: Vec<_> = clocks.iter().map(|c| Arc::new(c.clone())).collect();
        repair(&times).into_iter().map(|r| r.expect("usable").clock.stamps.to_vec()).collect()
    }

    fn apart(a: &[f64], b: &[f64]) -> f64 {
        assert_eq!(a.len(), b.len());
        rms(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>())
    }

    #[test]
    fn samples_of_frames_that_jitter_alone_keep_their_times_to_the_others() {
        let clocks: Vec<Vec<f64>> = (0..5)
            .map(|i| jittered(i, 0.01 * i as f64, if i == 4 { 0.0 } else { 0.045 }))
            .collect();
        for (before, after) in clocks.iter().zip(stamps(&clocks)) {
            // on straight lines each it was 26 ms, up to 45
            assert_eq!(apart(before, &after), 0.0);
        }
        // two clocks
        let two = [jittered(8, 0.0, 0.0), jittered(9, 0.02, 0.045)];
        assert!(apart(&two[1], &stamps(&two)[1]) < 1e-9);
    }

    #[test]
    fn jitter_of_the_logger_is_taken_off_all() {
        let late = jittered(3, 0.0, 0.04);
        let clocks: Vec<Vec<f64>> =
            (0..3).map(|k| late.iter().map(|t| t + 0.002 * f64::from(k)).collect()).collect();
        // one sample each differs, so that none is another one shifted
        let clocks: Vec<Vec<f64>> =
            clocks.iter().enumerate().map(|(k, c)| c[k..].to_vec()).collect();
        for (k, after) in stamps(&clocks).iter().enumerate() {
            let truth: Vec<f64> = (k..N).map(|i| 0.1 * i as f64 + 0.002 * k as f64).collect();
            assert!(apart(after, &truth) < 3e-3, "{:.2} ms", 1e3 * apart(after, &truth));
        }
    }

    #[test]
    fn small_jitter_of_a_bus_is_taken_off_each() {
        let clocks: Vec<Vec<f64>> = (0..4).map(|i| jittered(i, 0.03 * i as f64, 0.003)).collect();
        for (k, after) in stamps(&clocks).iter().enumerate() {
            let truth: Vec<f64> = (0..N).map(|i| 0.1 * i as f64 + 0.03 * k as f64).collect();
            assert!(apart(after, &truth) < 0.3e-3);
        }
    }

    #[test]
    fn shifted_clocks_and_those_of_some_rows_move_with_the_whole() {
        let whole = jittered(5, 0.0, 0.04);
        let shifted: Vec<f64> = whole.iter().map(|t| t - 0.2).collect();
        let some: Vec<f64> = whole.iter().copied().step_by(7).collect();
        let after = stamps(&[some, whole, shifted]);
        let truth: Vec<f64> = (0..N).map(|i| 0.1 * i as f64).collect();
        assert!(apart(&after[1], &truth) < 3e-3);
        let of_rows: Vec<f64> = after[1].iter().copied().step_by(7).collect();
        assert_eq!(after[0], of_rows);
        let later: Vec<f64> = after[2].iter().map(|t| t + 0.2).collect();
        assert!(apart(&after[1], &later) < 1e-9);
    }
}
