//! Channels that are faster than the common clock, brought down to it.
//!
//! Every point of the clock is the weighted mean of the samples around it: a windowed sinc,
//! symmetric and so without delay. The weights depend on the stamps alone; channels that were
//! logged together share them, and so do the points of a clock that fits into another.

use std::sync::OnceLock;

use rayon::prelude::*;

use crate::ingest::clock::grid::{Grid, ON_CLOCK};

/// Half length of the low-pass, in periods of the clock.
const HALF_LENGTH: f64 = 4.0;
/// Its cut-off, as a share of the clock's rate.
pub(crate) const CUT_OFF: f64 = 0.45;
/// Steps of the table of weights per period of the clock: it is right to eleven digits.
const STEPS: f64 = 256.0;
/// Points of the clock that are computed at a time.
const POINTS: usize = 4096;
/// So nearly equal distances have equal weights, in periods of the clock.
const EQUAL: f64 = 1e-9;

/// The samples of one clock, channel by channel, on the grid. NaN within a gap (of samples more
/// than `limit` apart, s), and beyond the first and the last sample.
pub(crate) fn low_passed(
    times: &[f64],
    tracks: &[&[f64]],
    grid: Grid,
    limit: f64,
) -> Vec<Vec<f64>> {
    let mut out: Vec<Vec<f64>> = tracks.iter().map(|_| vec![f64::NAN; grid.len]).collect();
    let mut parts: Vec<Vec<&mut [f64]>> = Vec::new();
    parts.resize_with(grid.len.div_ceil(POINTS), Vec::new);
    for column in &mut out {
        for (part, points) in parts.iter_mut().zip(column.chunks_mut(POINTS)) {
            part.push(points);
        }
    }
    let first = |track: &&[f64]| track.iter().position(|v| v.is_finite()).unwrap_or(track.len());
    let source = Source {
        times,
        tracks,
        first: tracks.iter().map(first).collect(),
        whole: times.windows(2).all(|w| w[1] - w[0] <= limit),
        limit,
        grid,
    };
    parts.into_par_iter().enumerate().for_each(|(i, mut out)| source.fill(i * POINTS, &mut out));
    out
}

/// Signal to be resampled.
struct Source<'a> {
    times: &'a [f64],
    tracks: &'a [&'a [f64]],
    /// The first sample that is there, track by track.
    first: Vec<usize>,
    /// Whether no stamps are further apart than the limit.
    whole: bool,
    limit: f64,
    grid: Grid,
}

impl Source<'_> {
    /// The points from `first` on, track by track.
    fn fill(&self, first: usize, out: &mut [&mut [f64]]) {
        let Source { times, tracks, grid, .. } = *self;
        let half = HALF_LENGTH / grid.rate;
        let slack = ON_CLOCK / grid.rate;
        let at = |j: usize| grid.start + j as f64 / grid.rate;
        let mut right = times.partition_point(|s| *s < at(first) - slack);
        let mut low = times.partition_point(|s| *s <= at(first) - half);
        let mut high = low;
        let mut row = Row::default();
        for j in 0..out.first().map_or(0, |o| o.len()) {
            let t = at(first + j);
            right += times[right..].iter().take_while(|s| **s < t - slack).count();
            low += times[low..].iter().take_while(|s| **s <= t - half).count();
            high = high.max(low);
            high += times[high..].iter().take_while(|s| **s < t + half).count();
            if !self.is_inside(right, t + slack) {
                continue;
            }
            let around = if self.whole { low..high } else { self.one_side(low, right, high) };
            row.set(&times[around.clone()], t, grid.rate);
            for ((out, track), first) in out.iter_mut().zip(tracks).zip(&self.first) {
                let mean = dot(&row.weights, &track[around.clone()]) / row.sum;
                // not a number where samples are missing
                out[j] = if mean.is_finite() { mean } else { self.patchy(track, *first, right, t) };
            }
        }
    }

    /// Whether a point is between samples, of which the one on its right is given.
    fn is_inside(&self, right: usize, latest: f64) -> bool {
        let Some(after) = self.times.get(right) else { return false };
        match right.checked_sub(1) {
            None => *after <= latest,
            Some(left) => *after - self.times[left] <= self.limit,
        }
    }

    /// The stamps `low..high`, as far as no gap is between them and the one at `right`.
    fn one_side(&self, low: usize, right: usize, high: usize) -> std::ops::Range<usize> {
        let together = |k: &usize| self.times[*k] - self.times[*k - 1] <= self.limit;
        let from = right - (low + 1..=right).rev().take_while(together).count();
        let to = from + 1 + (from + 1..high).take_while(together).count();
        from..to.min(high).max(from)
    }

    /// One point of a track of which samples are missing around it: as if their stamps were not
    /// there either.
    fn patchy(&self, track: &[f64], first: usize, right: usize, t: f64) -> f64 {
        let Source { times, grid, limit, .. } = *self;
        let half = HALF_LENGTH / grid.rate;
        let slack = ON_CLOCK / grid.rate;
        let there = |k: &usize| track[*k].is_finite();
        // a later one could not be near enough to the one before
        let mut after = (right..times.len()).take_while(|k| times[*k] <= t + limit + slack);
        let Some(right) = after.find(there) else { return f64::NAN };
        if first >= right && times[right] > t + slack {
            return f64::NAN;
        }
        let mut from = right;
        for k in (first..right).rev() {
            if times[from] - times[k] > limit || (times[k] <= t - half && from < right) {
                break;
            }
            from = if there(&k) { k } else { from };
        }
        if from == right && first < right {
            return f64::NAN; // the one before it is too far away
        }
        let (mut sum, mut weights, mut last) = (0.0, 0.0, from);
        for k in (from..times.len()).take_while(|k| times[*k] < t + half).filter(there) {
            if times[k] - times[last] > limit {
                break;
            }
            last = k;
            if times[k] > t - half {
                let weight = weight((times[k] - t) * grid.rate);
                sum += weight * track[k];
                weights += weight;
            }
        }
        sum / weights
    }
}

/// The weights of the samples around a point.
#[derive(Default)]
struct Row {
    /// Their distances from it, in periods of the clock.
    distances: Vec<f64>,
    weights: Vec<f64>,
    sum: f64,
}

impl Row {
    fn set(&mut self, times: &[f64], t: f64, rate: f64) {
        if self.distances.len() == times.len() {
            let off = |(d, s): (&f64, &f64)| u64::from(((s - t) * rate - d).abs() > EQUAL);
            // not `any`: without a way out it is done for several at once
            if self.distances.iter().zip(times).map(off).sum::<u64>() == 0 {
                return;
            }
        }
        self.distances.clear();
        self.distances.extend(times.iter().map(|s| (s - t) * rate));
        self.weights.clear();
        self.weights.extend(self.distances.iter().map(|d| weight(*d)));
        self.sum = self.weights.iter().sum();
    }
}

/// The weight of a sample at a distance, in periods of the clock.
fn weight(distance: f64) -> f64 {
    static TABLE: OnceLock<Vec<[f64; 4]>> = OnceLock::new();
    let place = distance.abs() * STEPS;
    let step = place as usize;
    // a cubic through the table's points, with their slopes
    let Some([a, b, c, d]) = TABLE.get_or_init(table).get(step) else { return 0.0 };
    let x = place - step as f64;
    ((d * x + c) * x + b) * x + a
}

/// Cubics from each step of the weights to the next.
fn table() -> Vec<[f64; 4]> {
    let value = |place: f64| exactly(place / STEPS);
    let slope = |place: f64| 0.5 * (value(place + 0.01) - value(place - 0.01)) / 0.01;
    let cubic = |step: usize| {
        let from = step as f64;
        let (y0, y1) = (value(from), value(from + 1.0));
        let (m0, m1) = (slope(from), slope(from + 1.0));
        [y0, m0, 3.0 * (y1 - y0) - 2.0 * m0 - m1, 2.0 * (y0 - y1) + m0 + m1]
    };
    (0..(HALF_LENGTH * STEPS) as usize).map(cubic).collect()
}

/// A sinc under a squared cosine.
fn exactly(distance: f64) -> f64 {
    let x = std::f64::consts::TAU * CUT_OFF * distance;
    let sinc = if x.abs() < 1e-9 { 1.0 } else { x.sin() / x };
    let window = (0.5 * std::f64::consts::PI * distance / HALF_LENGTH).cos();
    sinc * window * window
}

/// In lanes, which the compiler can do side by side.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let ((a, a_rest), (b, b_rest)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for k in 0..LANES {
            sums[k] += a[k] * b[k];
        }
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(rate: f64, len: usize) -> Grid {
        Grid { start: 0.0, rate, len }
    }

    fn one(times: &[f64], samples: &[f64], grid: Grid, limit: f64) -> Vec<f64> {
        low_passed(times, &[samples], grid, limit).remove(0)
    }

    #[test]
    fn going_down_keeps_the_band_and_its_phase_and_stops_what_would_fold() {
        let fine: Vec<f64> = (0..4000).map(|i| f64::from(i) / 1000.0).collect();
        let wave = |f: f64| {
            let samples: Vec<f64> =
                fine.iter().map(|t| (std::f64::consts::TAU * f * t).sin()).collect();
            one(&fine, &samples, grid(100.0, 400), 0.25)
        };
        let kept = wave(20.0);
        for (j, y) in kept.iter().enumerate().take(390).skip(10) {
            let truth = (std::f64::consts::TAU * 20.0 * j as f64 / 100.0).sin();
            assert!((y - truth).abs() < 0.02, "{j}: {y} not {truth}");
        }
        let stopped = wave(90.0);
        assert!(stopped[10..390].iter().all(|y| y.abs() < 0.03));
    }

    #[test]
    fn the_table_is_the_formula() {
        for i in 0..40_000 {
            let d = f64::from(i) * 1e-4;
            assert!((weight(d) - exactly(d)).abs() < 2e-11 && weight(d) == weight(-d), "{d}");
        }
        assert_eq!(weight(HALF_LENGTH), 0.0);
    }

    /// The plain formula, of the samples that are there.
    fn plainly(times: &[f64], samples: &[f64], grid: Grid, limit: f64) -> Vec<f64> {
        let there = times.iter().zip(samples).filter(|(_, v)| v.is_finite());
        let (times, samples): (Vec<f64>, Vec<f64>) = there.unzip();
        let (half, slack) = (HALF_LENGTH / grid.rate, ON_CLOCK / grid.rate);
        let point = |j: usize| {
            let t = grid.start + j as f64 / grid.rate;
            let right = times.iter().position(|s| *s >= t - slack)?;
            let inside = if right == 0 {
                times[0] <= t + slack
            } else {
                times[right] - times[right - 1] <= limit
            };
            let mut from = right;
            while from > 0 && times[from] - times[from - 1] <= limit && times[from - 1] > t - half {
                from -= 1;
            }
            let (mut sum, mut weights) = (0.0, 0.0);
            for k in from..times.len() {
                let gap = k > from && times[k] - times[k - 1] > limit;
                if times[k] >= t + half || gap {
                    break;
                }
                let w = exactly((times[k] - t) * grid.rate);
                sum += w * samples[k];
                weights += w;
            }
            inside.then_some(sum / weights)
        };
        (0..grid.len).map(|j| point(j).unwrap_or(f64::NAN)).collect()
    }

    #[test]
    fn gaps_and_missing_samples_are_as_if_their_stamps_were_not_there() {
        let mut state = 7_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state >> 8) / f64::from(1 << 24)
        };
        for limit in [0.012, 0.06, 0.25] {
            let mut times: Vec<f64> = Vec::new();
            let mut t = 0.004;
            for i in 0..6000 {
                t += 0.0013 + 0.0004 * random();
                t += if i % 700 == 699 { 0.4 * random() } else { 0.0 };
                times.push(t);
            }
            let mut samples: Vec<f64> = times.iter().map(|t| t.sin() + random()).collect();
            for start in [0, 40, 300, 301, 900, 1500, 1504, 2200, 3000, 5900] {
                let len = (120.0 * random()) as usize;
                samples[start..start + len].fill(f64::NAN);
            }
            for k in (2000..2300).step_by(3) {
                samples[k] = f64::NAN;
            }
            let grid = grid(100.0, 1200);
            let whole: Vec<f64> = times.iter().map(|t| t.cos()).collect();
            let tracks = [&samples[..], &whole[..]];
            for (track, got) in tracks.iter().zip(low_passed(&times, &tracks, grid, limit)) {
                let wanted = plainly(&times, track, grid, limit);
                for (j, (a, b)) in got.iter().zip(&wanted).enumerate() {
                    let equal = (a - b).abs() < 1e-9 * b.abs().max(1.0);
                    assert!(equal || (a.is_nan() && b.is_nan()), "{limit} {j}: {a} not {b}");
                }
                let there = got.iter().filter(|v| v.is_finite()).count();
                assert!((500..1200).contains(&there), "{there}");
            }
        }
    }
}
