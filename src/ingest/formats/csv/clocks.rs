//! The clocks of a table whose columns were sampled at different rates.
//!
//! A row is written whenever any channel has a sample; the cells of the slower ones stay empty.
//! Such a channel's clock is that of its own samples: on the table's clock it would be nothing
//! but gaps.

use std::sync::Arc;

use crate::ingest::raw::Column;
use crate::statistics::order::upper_median;

/// A channel is slower than its table when its samples are so many rows apart.
const SLOWER: f64 = 1.5;

/// A channel's rate is not estimated from fewer samples than this.
const FEW: usize = 6;

/// Columns of one table, each on its own clock.
///
/// `together` says which columns must share a clock whatever their samples (those that are
/// averaged); it gets two places in `columns`.
pub(crate) fn separate(
    time: Vec<f64>,
    columns: Vec<(String, Vec<f64>)>,
    together: impl Fn(usize, usize) -> bool,
) -> Vec<Column> {
    let row = median_step(time.iter().copied());
    let whole = Arc::new(time);
    let slow: Vec<bool> = columns.iter().map(|(_, values)| is_slow(&whole, values, row)).collect();
    let mut clocks: Vec<(Vec<bool>, Arc<Vec<f64>>)> = Vec::new();
    let mut out = Vec::with_capacity(columns.len());
    for (i, (name, values)) in columns.iter().enumerate() {
        let others: Vec<usize> = (0..columns.len()).filter(|&k| together(i, k)).collect();
        if !slow[i] || others.iter().any(|&k| !slow[k]) {
            out.push(Column {
                name: name.clone(),
                time: Arc::clone(&whole),
                values: values.clone(),
            });
            continue;
        }
        let mut there: Vec<bool> = values.iter().map(|v| !v.is_nan()).collect();
        for &k in &others {
            there.iter_mut().zip(&columns[k].1).for_each(|(t, v)| *t |= !v.is_nan());
        }
        let chosen = |from: &[f64]| -> Vec<f64> {
            from.iter().zip(&there).filter(|(_, t)| **t).map(|(x, _)| *x).collect()
        };
        let values = chosen(values);
        let known =
            clocks.iter().find(|(pattern, _)| *pattern == there).map(|(_, t)| Arc::clone(t));
        let time = known.unwrap_or_else(|| {
            let time = Arc::new(chosen(&whole));
            clocks.push((there.clone(), Arc::clone(&time)));
            time
        });
        out.push(Column { name: name.clone(), time, values });
    }
    out
}

/// Whether a column's samples are by nature further apart than the rows.
fn is_slow(time: &[f64], values: &[f64], row: Option<f64>) -> bool {
    let there = time.iter().zip(values).filter(|(_, v)| !v.is_nan()).map(|(t, _)| *t);
    if there.clone().count() < FEW {
        return false;
    }
    match (median_step(there), row) {
        (Some(own), Some(row)) => own > SLOWER * row,
        _ => false,
    }
}

/// Middle one of the steps ahead.
pub(crate) fn median_step(stamps: impl Iterator<Item = f64>) -> Option<f64> {
    let mut last = f64::NAN;
    let mut steps = Vec::new();
    for t in stamps.filter(|t| t.is_finite()) {
        if t - last > 0.0 {
            steps.push(t - last);
        }
        last = t;
    }
    upper_median(&mut steps)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NAN: f64 = f64::NAN;

    #[test]
    fn slow_columns_get_their_own_clock_and_lost_samples_do_not() {
        let n = 200;
        let time: Vec<f64> = (0..n).map(|i| f64::from(i) * 0.01).collect();
        let every = |k: i32, at: i32| -> Vec<f64> {
            (0..n).map(|i| if i % k == at { f64::from(i) } else { NAN }).collect()
        };
        let mut lossy = every(1, 0);
        lossy[50..90].fill(NAN);
        let columns = [
            ("fast", lossy),
            ("gps", every(10, 0)),
            ("gps 2", every(10, 0)),
            ("obd", every(25, 3)),
            ("none", vec![NAN; n as usize]),
        ];
        let columns = columns.map(|(name, values)| (name.to_owned(), values)).to_vec();
        let out = separate(time.clone(), columns.clone(), |_, _| false);
        let lengths: Vec<usize> = out.iter().map(|c| c.time.len()).collect();
        assert_eq!(lengths, [200, 20, 20, 8, 200]);
        assert!(Arc::ptr_eq(&out[1].time, &out[2].time), "logged together");
        assert!(Arc::ptr_eq(&out[0].time, &out[4].time));
        assert_eq!(out[3].time[1], 0.28);
        assert_eq!(out[3].values[1], 28.0);
        // averaged columns keep one clock
        let mean = |a: usize, b: usize| a != b && a + b == 4; // gps and obd
        let out = separate(time, columns, mean);
        assert!(Arc::ptr_eq(&out[1].time, &out[3].time));
        assert_eq!((out[1].time.len(), out[1].values[1].is_nan()), (28, true));
    }
}
