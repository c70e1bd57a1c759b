//! Downsampling of data clouds: a sample that is left out lies under one that is drawn.
//!
//! One sample of every cell of a fine grid is kept, with the number of samples that it stands for.
//! The grid covers the whole plane, so a single extreme has a cell to itself and is always kept;
//! taking every n-th sample would lose it.

use ahash::AHashMap;

/// Cells across the middle 98 % of a cloud, at first: finer than the dots of the page.
const CELLS: f64 = 120.0;
/// Cells across over those of the grid before, at most.
const COARSER: f64 = 0.85;
/// Samples that the range of a cloud is taken of.
const SAMPLES_OF_RANGE: usize = 4096;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Kept {
    pub place: usize,
    /// Samples it stands for, itself included.
    pub n: usize,
}

/// At most about `most` samples, in their order. Samples of different `kind` (an outlier and one
/// with weight) never stand for each other; samples that are not finite are left out.
pub(crate) fn downsample(
    x: &[f64],
    y: &[f64],
    kind: impl Fn(usize) -> bool,
    most: usize,
) -> Vec<Kept> {
    let mut kept: Vec<Kept> = (0..x.len().min(y.len()))
        .filter(|&i| x[i].is_finite() && y[i].is_finite())
        .map(|place| Kept { place, n: 1 })
        .collect();
    if kept.len() <= most {
        return kept;
    }
    let middle = [x, y].map(|values| Middle::of(values, &kept));
    let mut cells = CELLS;
    let mut taken = Taken::default();
    // coarser and coarser, each time of what the last grid left
    loop {
        let per_cell = [0, 1].map(|k| cells / middle[k].range);
        taken.clear(&middle, per_cell);
        // in place: what is kept stands at or before what is looked at
        let mut count = 0;
        for i in 0..kept.len() {
            let k = kept[i];
            let cell = [cell(x[k.place], per_cell[0]), cell(y[k.place], per_cell[1])];
            let first = taken.first(cell, kind(k.place), count);
            if first == count {
                kept[count] = k;
                count += 1;
            } else {
                kept[first].n += k.n;
            }
        }
        kept.truncate(count);
        if count <= most || cells < 4.0 {
            return kept;
        }
        // a cloud that fills the plane has as many as the square of the cells across, any other one more than that
        cells *= (most as f64 / count as f64).sqrt().min(COARSER);
    }
}

/// The middle 98 % of a cloud along one axis, whose range sets the size of a cell.
struct Middle {
    low: f64,
    high: f64,
    /// Never 0.
    range: f64,
}

impl Middle {
    /// Of every n-th of many samples: the size of a cell need not be exact.
    fn of(values: &[f64], kept: &[Kept]) -> Self {
        let step = kept.len().div_ceil(SAMPLES_OF_RANGE);
        let mut values: Vec<f64> = kept.iter().step_by(step).map(|k| values[k.place]).collect();
        let skip = values.len() / 100;
        let last = values.len() - 1 - skip;
        let low = *values.select_nth_unstable_by(skip, f64::total_cmp).1;
        let high = *values.select_nth_unstable_by(last, f64::total_cmp).1;
        Middle { low, high, range: if high > low { high - low } else { 1.0 } }
    }
}

/// The cell of a value along one axis, `per_cell` of them to a unit.
fn cell(value: f64, per_cell: f64) -> i64 {
    let at = value * per_cell;
    // the floor, without a call
    let towards_zero = at as i64;
    towards_zero.saturating_sub(i64::from((towards_zero as f64) > at))
}

/// Which sample each cell has: by place in a table for the middle of the cloud, by name for the rest of the plane.
#[derive(Default)]
struct Taken {
    table: Vec<u32>,
    origin: [i64; 2],
    size: [i64; 2],
    beyond: AHashMap<(i64, i64, bool), u32>,
}

/// No sample.
const NONE: u32 = u32::MAX;

impl Taken {
    fn clear(&mut self, middle: &[Middle; 2], per_cell: [f64; 2]) {
        self.origin = [0, 1].map(|k| cell(middle[k].low, per_cell[k]));
        self.size = [0, 1].map(|k| cell(middle[k].high, per_cell[k]) - self.origin[k] + 1);
        self.table.clear();
        self.table.resize(2 * (self.size[0] * self.size[1]) as usize, NONE);
        self.beyond.clear();
    }

    /// The sample of a cell: `next` where there is none yet.
    fn first(&mut self, cell: [i64; 2], kind: bool, next: usize) -> usize {
        let [column, row] = [0, 1].map(|k| cell[k].wrapping_sub(self.origin[k]));
        let inside = (0..self.size[0]).contains(&column) && (0..self.size[1]).contains(&row);
        let slot = match inside {
            true => &mut self.table[2 * (row * self.size[0] + column) as usize + usize::from(kind)],
            false => self.beyond.entry((cell[0], cell[1], kind)).or_insert(NONE),
        };
        if *slot == NONE {
            *slot = next as u32;
        }
        *slot as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sample_is_stood_for_once_and_extremes_stay() {
        let n = 50_000;
        let angle = |i: usize| i as f64 * 2.399_963;
        let radius = |i: usize| (i as f64 / n as f64).sqrt();
        let mut x: Vec<f64> = (0..n).map(|i| radius(i) * angle(i).cos()).collect();
        let mut y: Vec<f64> = (0..n).map(|i| 20.0 * radius(i) * angle(i).sin()).collect();
        x[12_345] = 3.0;
        y[12_345] = -90.0;
        x[777] = f64::NAN;
        let kept = downsample(&x, &y, |i| i % 1000 == 1, 800);
        assert!(kept.len() <= 800 && kept.len() > 300, "{}", kept.len());
        assert_eq!(kept.iter().map(|k| k.n).sum::<usize>(), n - 1);
        assert!(kept.contains(&Kept { place: 12_345, n: 1 }), "the lone extreme stays");
        // the rim of the disc is kept to within a cell
        let top = |places: &mut dyn Iterator<Item = usize>| {
            places
                .filter(|i| *i != 12_345)
                .map(|i| y[i])
                .filter(|v| v.is_finite())
                .fold(0.0, f64::max)
        };
        let (all, drawn) = (top(&mut (0..n)), top(&mut kept.iter().map(|k| k.place)));
        assert!(all - drawn < 40.0 / 15.0, "{drawn} of {all}");
        assert!(kept.windows(2).all(|p| p[0].place < p[1].place));
    }

    #[test]
    fn few_samples_all_stay() {
        let kept = downsample(&[1.0, 1.0, f64::NAN], &[2.0, 2.0, 2.0], |_| false, 10);
        assert_eq!(kept.len(), 2);
        assert!(downsample(&[], &[], |_| false, 10).is_empty());
        // a cloud without width
        assert_eq!(downsample(&[1.0; 100], &[2.0; 100], |_| false, 10)[0].n, 100);
    }
}
