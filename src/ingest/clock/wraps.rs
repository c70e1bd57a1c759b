//! Counters that begin again at a border of their own: 16 and 32 bits, the minute, the day, the week of GPS; and clocks
//! that are put right while they log.
//!
//! A restarted logger falls back by any time. A counter that came to its end stands at that end before, at its beginning
//! after, and goes on at the pace of its rows.

use super::stamps::unit::usual_step;

/// Largest value of a counter, s.
#[rustfmt::skip]
const TURNS: [(f64, &str); 12] = [
    (65.536, "a counter of 16 bits, in ms"), (655.36, "a counter of 16 bits, in 10 ms"), (6553.6, "a counter of 16 bits, in 0.1 s"),
    (4_294.967_296, "a counter of 32 bits, in us"), (42_949.672_96, "a counter of 32 bits, in 10 us"),
    (429_496.729_6, "a counter of 32 bits, in 100 us"), (4_294_967.296, "a counter of 32 bits, in ms"),
    (60.0, "the seconds of a minute"), (3600.0, "the seconds of an hour"), (86_400.0, "the seconds of a day"),
    (604_800.0, "the seconds of a week of GPS"), (43_200.0, "the seconds of half a day"),
];
/// Seconds by which a receiver's clock is ahead of UTC until it has heard of the leap seconds: of all of them, or of those
/// since it was made.
const LEAPS: [f64; 4] = [2.0, 3.0, 4.0, 18.0];
/// Such a clock goes on at the pace of its rows, but for this share of it.
const PACE: f64 = 0.3;
/// s that the end of summer time puts a clock back.
const SUMMER: f64 = 3600.0;
/// Stamps beyond this count from a day, s.
const DATED: f64 = 1e8;
/// Rows that may be lost at the border.
const LOST: f64 = 5.0;
/// A border is no further from the next than so many such gaps.
const SHARE: f64 = 8.0;

/// Lets stamps, s, go on over the border of their counter, in place. What was seen, and how often.
pub(crate) fn unroll(stamps: &mut [f64]) -> Option<(usize, String)> {
    let falls = |s: &[f64]| s.windows(2).any(|w| w[1] < w[0]);
    if !falls(stamps) && !stamps.iter().any(|t| t.is_nan()) {
        return None;
    }
    let step = usual_step(stamps)?;
    let near = LOST * step;
    let there: Vec<usize> = (0..stamps.len()).filter(|&i| stamps[i].is_finite()).collect();
    let own: Vec<f64> = there.iter().map(|&i| stamps[i]).collect();
    let (mut turn, mut count, mut what) = (None, 0, String::new());
    // rows from which on something is added
    let mut added = vec![0.0; own.len()];
    let mut all = 0.0;
    for k in 1..own.len() {
        let (before, at) = (own[k - 1], own[k]);
        if at < before {
            let goes_on = |by: f64| (0.0..=near).contains(&(at + by - before)) && at + by > before;
            let known = turn.map_or(&TURNS[..], |i: usize| &TURNS[i..=i]);
            let found = known.iter().find(|(by, _)| {
                let from_zero = before <= *by && before > by - near && (0.0..near).contains(&at);
                let signed = before < 0.5 * by && (-0.5 * by..near - 0.5 * by).contains(&at);
                SHARE * near < *by && goes_on(*by) && (from_zero || signed)
            });
            if let Some((by, name)) = found {
                turn = TURNS.iter().position(|t| t.0 == *by);
                all += by;
                count += 1;
                what = format!("the stamps are {name}, which began again: the clock continues");
            } else if SHARE * near < SUMMER && goes_on(SUMMER) {
                all += SUMMER;
                count += 1;
                "the clock was put back by one hour, the end of summer time: the clock continues"
                    .clone_into(&mut what);
            } else if let Some(leap) = LEAPS
                .into_iter()
                .find(|by| at > DATED && (at + by - before - step).abs() < PACE * step.min(1.0))
            {
                // those before it are wrong
                added[..k].iter_mut().for_each(|a| *a -= leap);
                count += 1;
                what = format!(
                    "the receiver put its clock back by {leap} s, leap seconds of UTC: earlier \
                     stamps are corrected"
                );
            }
        }
        added[k] = all;
    }
    for (i, by) in there.into_iter().zip(added) {
        stamps[i] += by;
    }
    (count > 0).then_some((count, what))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 200 s at 10 Hz from `start`, as a counter that has `turn`; and how it should go on.
    fn counted(start: f64, turn: f64) -> (Vec<f64>, Vec<f64>) {
        let plain: Vec<f64> = (0..2000).map(|i| start + 0.1 * f64::from(i)).collect();
        (plain.iter().map(|t| t.rem_euclid(turn)).collect(), plain)
    }

    #[test]
    fn counters_go_on_over_their_end() {
        for (start, turn, times) in [
            (0.0, 65.536, 3),
            (4_294_947.3, 4_294_967.296, 1),
            (4200.0, 4_294.967_296, 1),
            (604_780.0, 604_800.0, 1),
            (50.0, 60.0, 4),
        ] {
            let (mut stamps, plain) = counted(start, turn);
            let (count, what) = unroll(&mut stamps).expect("seen");
            assert_eq!(count, times, "{turn}: {what}");
            let off = stamps.iter().zip(&plain).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "{turn}: {off}");
        }
        // signed
        let mut stamps: Vec<f64> = counted(0.0, 65.536)
            .0
            .iter()
            .map(|t| if *t >= 32.768 { t - 65.536 } else { *t })
            .collect();
        assert_eq!(unroll(&mut stamps).map(|u| u.0), Some(3));
        assert!(stamps.windows(2).all(|w| w[1] > w[0]));
    }

    #[test]
    fn restarts_are_none() {
        for (first, restart) in [(80.0, 0.0), (64.0, 0.0), (65.5, 3.0), (1.79e9, 1.79e9 - 25.0)] {
            let mut stamps: Vec<f64> =
                (0..400).map(|i| first - 40.0 + 0.1 * f64::from(i)).collect();
            stamps.extend((0..400).map(|i| restart + 0.1 * f64::from(i)));
            let as_is = stamps.clone();
            assert_eq!(unroll(&mut stamps), None, "{first} {restart}");
            assert_eq!(stamps, as_is);
        }
    }

    #[test]
    fn clocks_that_are_put_right_go_on() {
        let start = 1_792_836_000.0;
        let plain: Vec<f64> = (0..600).map(|i| start + 0.1 * f64::from(i)).collect();
        let with =
            |by: f64| plain.iter().enumerate().map(move |(i, t)| if i < 200 { t + by } else { *t });
        for by in [18.0, 2.0] {
            let mut leap: Vec<f64> = with(by).collect();
            assert_eq!(unroll(&mut leap).map(|u| u.0), Some(1));
            assert!(leap.iter().zip(&plain).all(|(a, b)| (a - b).abs() < 1e-6));
        }
        let mut other: Vec<f64> = with(7.0).collect();
        assert_eq!(unroll(&mut other), None);
        let mut summer: Vec<f64> = with(3600.0).collect();
        assert_eq!(unroll(&mut summer).map(|u| u.0), Some(1));
        assert!(
            summer.iter().zip(&plain).all(|(a, b)| (a - b - 3600.0).abs() < 1e-6),
            "the hour before stands"
        );
    }
}
