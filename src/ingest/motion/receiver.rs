//! What a satellite receiver writes while it has no fix: 0, -1 or its last numbers, in each of its channels.
//!
//! Such numbers rest. A speed that changes in these rows is of a wheel, and a motorcycle that stands has the speed 0.

use std::ops::Range;

use super::track;

/// A number that rests over so many rows without a fix is none.
const RESTS: usize = 5;
/// Less of a channel's range is no jump.
const JUMP: f64 = 0.05;

/// Rows without a fix, as runs: those that hold what no receiver gives for a position, and whether each is one of them or has
/// no position at all.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct Lost {
    pub(crate) runs: Vec<(Range<usize>, bool)>,
    /// Rows with a position that no receiver gave.
    pub(crate) count: usize,
}

/// Takes positions out that no receiver gave.
pub(crate) fn positions(latitude: &mut [f64], longitude: &mut [f64]) -> Lost {
    let missing = |lat: &[f64], lon: &[f64]| -> Vec<bool> {
        lat.iter().zip(lon).map(|(a, b)| a.is_nan() || b.is_nan()).collect()
    };
    let before = missing(latitude, longitude);
    let count = track::without_fix(latitude, longitude);
    let after = missing(latitude, longitude);
    let (mut runs, mut i) = (Vec::new(), 0);
    for run in after.chunk_by(|a, b| a == b) {
        let rows = i..i + run.len();
        i = rows.end;
        if run[0] {
            let placeholder = before[rows.clone()].contains(&false);
            runs.push((rows, placeholder));
        }
    }
    Lost { runs, count }
}

/// Takes the numbers of another channel of the receiver out, in rows without a fix. How many.
pub(crate) fn take_out(values: &mut [f64], lost: &Lost, is_speed: bool) -> usize {
    let mut count = 0;
    for (rows, placeholder) in &lost.runs {
        if is_none(values, rows, *placeholder, is_speed) {
            count += values[rows.clone()].iter().filter(|v| v.is_finite()).count();
            values[rows.clone()].fill(f64::NAN);
        }
    }
    count
}

/// Whether what a channel holds in rows without a fix is no number of the receiver: it rests, and jumps at their ends or rests
/// for long. `known`: these rows are surely without a fix.
pub(crate) fn is_none(values: &[f64], rows: &Range<usize>, known: bool, is_speed: bool) -> bool {
    let Some(within) = values.get(rows.clone()) else { return false };
    let mut there = within.iter().copied().filter(|v| v.is_finite());
    let Some(first) = there.next() else { return false };
    if there.any(|v| v != first) {
        return false;
    }
    let finite = || values.iter().copied().filter(|v| v.is_finite());
    let (least, most) =
        finite().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
    let before = values[..rows.start].iter().rev().copied().find(|v| v.is_finite());
    let behind = values[rows.end..].iter().copied().find(|v| v.is_finite());
    let jumps =
        [before, behind].into_iter().flatten().any(|v| (v - first).abs() > JUMP * (most - least));
    // who stands may do so for long
    let rests = known && within.len() >= RESTS && !(is_speed && first == 0.0);
    jumps && (known || within.len() >= RESTS) || rests
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 100 rows to the north, without a fix in rows 40 to 60.
    fn ride(lost: [f64; 2]) -> [Vec<f64>; 2] {
        let of = |k: usize, f: &dyn Fn(f64) -> f64| {
            (0..100)
                .map(|i| if (40..60).contains(&i) { lost[k] } else { f(f64::from(i)) })
                .collect()
        };
        [of(0, &|i| 47.0 + 1e-4 * i), of(1, &|i| 8.0 + 1e-5 * i)]
    }

    fn speed(lost: Option<f64>) -> Vec<f64> {
        let of = |i: i32| 15.0 + (0.1 * f64::from(i)).sin();
        (0..100).map(|i| lost.filter(|_| (40..60).contains(&i)).unwrap_or(of(i))).collect()
    }

    #[test]
    fn all_that_a_receiver_writes_without_a_fix_is_missing() {
        for position in [[0.0, 0.0], [90.0, 180.0], [-999.0, -999.0], [0.0, 8.0004], [47.004, 0.0]]
        {
            let [mut lat, mut lon] = ride(position);
            let lost = positions(&mut lat, &mut lon);
            assert_eq!(lost, Lost { runs: vec![(40..60, true)], count: 20 }, "{position:?}");
            for held in [0.0, -0.28, 15.0] {
                let mut v = speed(Some(held));
                assert_eq!(take_out(&mut v, &lost, true), 20, "{held}");
                assert!(
                    v[39].is_finite() && v[40..60].iter().all(|v| v.is_nan()) && v[60].is_finite()
                );
            }
            let mut wheel = speed(None);
            assert_eq!(take_out(&mut wheel, &lost, true), 0, "it goes on");
            let mut altitude = vec![450.0; 100];
            assert_eq!(take_out(&mut altitude, &lost, false), 20);
        }
    }

    #[test]
    fn who_stands_has_a_speed() {
        let [mut lat, mut lon] = ride([0.0, 0.0]);
        let lost = positions(&mut lat, &mut lon);
        let mut v = speed(None);
        v[20..80].fill(0.0);
        assert_eq!(take_out(&mut v, &lost, true), 0);
        // rows without any position: only a jump tells
        let [mut lat, mut lon] = ride([f64::NAN, f64::NAN]);
        let lost = positions(&mut lat, &mut lon);
        assert_eq!(lost, Lost { runs: vec![(40..60, false)], count: 0 });
        assert_eq!(take_out(&mut speed(Some(0.0)), &lost, true), 20);
        let mut cruise = speed(None);
        let steady = cruise[39];
        cruise[39..61].fill(steady);
        assert_eq!(take_out(&mut cruise, &lost, true), 0);
    }

    #[test]
    fn a_ride_at_the_equator_has_positions() {
        let mut lat: Vec<f64> = (0..100).map(|i| 1e-4 * f64::from(i - 50)).collect();
        let mut lon = vec![33.0; 100];
        assert_eq!(positions(&mut lat, &mut lon), Lost::default());
    }
}
