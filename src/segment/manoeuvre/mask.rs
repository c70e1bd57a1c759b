//! Runs of blocks in which something holds.

use std::ops::Range;

/// The runs of `true`.
pub(super) fn runs(mask: &[bool]) -> Vec<Range<usize>> {
    let mut out = Vec::new();
    let mut start = None;
    for (i, &on) in mask.iter().chain([&false]).enumerate() {
        match (on, start) {
            (true, None) => start = Some(i),
            (false, Some(s)) => {
                out.push(s..i);
                start = None;
            }
            _ => {}
        }
    }
    out
}

/// Where `x` is at least `leave` in a run that reaches `enter`; NaN ends a run.
pub(super) fn hysteresis(
    x: impl ExactSizeIterator<Item = f64> + Clone,
    enter: f64,
    leave: f64,
) -> Vec<bool> {
    let mut mask: Vec<bool> = x.clone().map(|v| v >= leave).collect();
    let reached: Vec<bool> = x.map(|v| v >= enter).collect();
    for run in runs(&mask) {
        if !reached[run.clone()].contains(&true) {
            mask[run].fill(false);
        }
    }
    mask
}

/// Takes out runs shorter than `least` blocks.
pub(super) fn drop_short(mask: &mut [bool], least: usize) {
    for run in runs(mask) {
        if run.len() < least {
            mask[run].fill(false);
        }
    }
}

/// Closes holes of at most `most` blocks between runs.
pub(super) fn close_holes(mask: &mut [bool], most: usize) {
    let found = runs(mask);
    for pair in found.windows(2) {
        if pair[1].start - pair[0].end <= most {
            mask[pair[0].end..pair[1].start].fill(true);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_holes_and_hysteresis() {
        let mut m = [true, false, true, true, false, false, true];
        assert_eq!(runs(&m), vec![0..1, 2..4, 6..7]);
        close_holes(&mut m, 1);
        assert_eq!(runs(&m), vec![0..4, 6..7]);
        drop_short(&mut m, 2);
        assert_eq!(runs(&m), vec![0..4]);
        let x = [0.0, 0.6, 1.2, 0.6, 0.0, 0.7, f64::NAN, 2.0];
        let m = hysteresis(x.iter().copied(), 1.0, 0.5);
        assert_eq!(runs(&m), vec![1..4, 7..8]);
        assert!(runs(&[]).is_empty());
    }
}
