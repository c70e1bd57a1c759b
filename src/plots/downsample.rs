//! Downsampling of data clouds: a sample that is left out lies under one that is drawn.
//!
//! One sample of every cell of a fine grid is kept, with the number of samples that it stands for.
//! The grid covers the whole plane, so a single extreme has a cell to itself and is always kept;
//! taking every n-th sample would lose it.

use ahash::AHashMap;

/// Cells across the middle 98 % of a cloud, at first: finer than the dots of the page.
const CELLS: f64 = 120.0;

/// One kept sample.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Kept {
    /// Its index.
    pub place: usize,
    /// Samples it stands for, itself included.
    pub n: usize,
}

/// At most about `most` samples, in their order. Samples of different `kind` (an outlier and one
/// with weight) never stand for each other; samples that are not finite are left out.
pub fn downsample(x: &[f64], y: &[f64], kind: &dyn Fn(usize) -> bool, most: usize) -> Vec<Kept> {
    let finite: Vec<usize> =
        (0..x.len().min(y.len())).filter(|&i| x[i].is_finite() && y[i].is_finite()).collect();
    if finite.len() <= most {
        return finite.into_iter().map(|place| Kept { place, n: 1 }).collect();
    }
    let (width, height) = (bulk(x, &finite), bulk(y, &finite));
    let mut kept: Vec<Kept> = finite.into_iter().map(|place| Kept { place, n: 1 }).collect();
    let mut cells = CELLS;
    // coarser and coarser, each time of what the last grid left
    loop {
        let mut taken: AHashMap<(i64, i64, bool), Kept> = AHashMap::new();
        for k in &kept {
            let cell = |v: f64, size: f64| (v / size * cells).floor() as i64;
            let at = (cell(x[k.place], width), cell(y[k.place], height), kind(k.place));
            taken.entry(at).or_insert(Kept { place: k.place, n: 0 }).n += k.n;
        }
        kept = taken.into_values().collect();
        kept.sort_unstable_by_key(|k| k.place);
        if kept.len() <= most || cells < 4.0 {
            return kept;
        }
        cells *= 0.85;
    }
}

/// Range of the middle 98 %, which sets the size of a cell; never 0.
fn bulk(values: &[f64], places: &[usize]) -> f64 {
    let mut values: Vec<f64> = places.iter().map(|&i| values[i]).collect();
    let skip = values.len() / 100;
    let last = values.len() - 1 - skip;
    let low = *values.select_nth_unstable_by(skip, f64::total_cmp).1;
    let high = *values.select_nth_unstable_by(last, f64::total_cmp).1;
    let range = high - low;
    if range > 0.0 { range } else { 1.0 }
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
        let kept = downsample(&x, &y, &|i| i % 1000 == 1, 800);
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
        let kept = downsample(&[1.0, 1.0, f64::NAN], &[2.0, 2.0, 2.0], &|_| false, 10);
        assert_eq!(kept.len(), 2);
        assert!(downsample(&[], &[], &|_| false, 10).is_empty());
        // a cloud without width
        assert_eq!(downsample(&[1.0; 100], &[2.0; 100], &|_| false, 10)[0].n, 100);
    }
}
