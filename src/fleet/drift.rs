//! Drift of a coefficient over time, with its interval.
//!
//! Slope: Theil and Sen's, of the values less their steps. Interval: Sen's (1968), the slopes whose
//! ranks lie `1.96 sqrt(n (n-1) (2n+5) / 18)` apart; it holds for any scatter that does not depend
//! on time. Above `ALL_PAIRS` sessions weighted least squares gives both.

use super::history::History;
use super::levels;
use crate::statistics::order::median;

/// Fewest values that a drift is estimated from.
const DRIFT_FROM: usize = 5;

/// Least time between the first value and the last, days: of an hour's sessions a slope per day is no drift.
const LEAST_SPAN: f64 = 1.0;

/// Above so many values all pairs are too many.
const ALL_PAIRS: usize = 1500;

#[derive(Debug, Clone, PartialEq)]
pub struct Drift {
    /// Per day; per session where fewer than half of the sessions have a day.
    pub slope: f64,
    /// Lower end of its 95 % interval.
    pub low: f64,
    /// Upper end of its 95 % interval.
    pub high: f64,
}

/// Whether times, days, are far enough apart for a slope per day.
pub(crate) fn spans_enough(times: impl Iterator<Item = f64>) -> bool {
    let ends = |[low, high]: [f64; 2], t: f64| [low.min(t), high.max(t)];
    let [low, high] = times.fold([f64::INFINITY, f64::NEG_INFINITY], ends);
    high - low >= LEAST_SPAN
}

/// Drift of coefficient `c` beside the steps in `columns`; `tau` is the spread between sessions.
///
/// `None` of too few values, or of less than a day.
pub(crate) fn slope(history: &History, c: usize, columns: &[Vec<f64>], tau: f64) -> Option<Drift> {
    let times = history.times();
    let values = &history.values[c];
    let variances: Vec<f64> = history.errors[c].iter().map(|e| tau * tau + e * e).collect();
    // steps and line together: a step alone would take part of the slope with it
    let mut all = columns.to_vec();
    all.push(levels::column(history, super::scan::Shape::Line));
    let level = levels::fit(values, &variances, &all)?;
    if level.freedom + all.len() < DRIFT_FROM {
        return None;
    }
    let line = *level.theta.last()?;
    // a value with a level of its own does not determine the slope
    let has_own_level = |i: usize| level.variance[i] > 0.999 * variances[i];
    let points: Vec<(f64, f64)> = (0..values.len())
        .filter(|i| values[*i].is_finite() && !has_own_level(*i) && history.is_timed(*i))
        .map(|i| (times[i], values[i] - level.fitted[i]))
        .collect();
    if points.len() < DRIFT_FROM || !spans_enough(points.iter().map(|p| p.0)) {
        return None;
    }
    let n = points.len();
    if n > ALL_PAIRS || columns.len() > 1 {
        let error = line_error(&level, &variances, values, &all)?;
        return Some(Drift { slope: line, low: line - 1.96 * error, high: line + 1.96 * error });
    }
    let mut slopes: Vec<f64> = Vec::with_capacity(n * (n - 1) / 2);
    for i in 0..n {
        for j in i + 1..n {
            if points[j].0 > points[i].0 {
                slopes.push(line + (points[j].1 - points[i].1) / (points[j].0 - points[i].0));
            }
        }
    }
    let middle = median(&mut slopes)?;
    slopes.sort_unstable_by(f64::total_cmp);
    let sd = ((n * (n - 1) * (2 * n + 5)) as f64 / 18.0).sqrt();
    let (count, half) = (slopes.len() as f64, 1.96 * sd);
    let at = |rank: f64| slopes[(rank.max(0.0) as usize).min(slopes.len() - 1)];
    let (low, high) = (at(((count - half) / 2.0).floor() - 1.0), at(((count + half) / 2.0).ceil()));
    Some(Drift { slope: middle, low, high })
}

/// Standard error of the last column, scaled where the residuals are wider than expected.
fn line_error(
    level: &levels::Level,
    variances: &[f64],
    values: &[f64],
    columns: &[Vec<f64>],
) -> Option<f64> {
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let (line, others) = columns.split_last()?;
    // what of the line the other columns do not explain
    let masked: Vec<f64> =
        (0..line.len()).map(|i| if values[i].is_finite() { line[i] } else { f64::NAN }).collect();
    let rest = levels::fit(&masked, variances, others)?;
    let own: f64 = known.iter().map(|i| (line[*i] - rest.fitted[*i]).powi(2) / variances[*i]).sum();
    let q: f64 =
        known.iter().map(|i| (values[*i] - level.fitted[*i]).powi(2) / variances[*i]).sum();
    let scale = (q / level.freedom.max(1) as f64).max(1.0);
    (own > 0.0).then(|| (scale / own).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fleet::observation::Observation;

    /// Six sessions, one every so many days, whose value rises by a thousandth from each to the next.
    fn drift(apart: f64) -> Option<Drift> {
        drift_of(apart, &[])
    }

    /// The same beside sessions without a day, with these values.
    fn drift_of(apart: f64, undated: &[f64]) -> Option<Drift> {
        let row = |i: usize| Observation {
            tyre: "front".into(),
            coefficient: "mf_d".into(),
            session: format!("s{i}"),
            day: Some(20_000.0 + i as f64 * apart),
            value: 1.0 + 1e-3 * i as f64,
            error: 1e-3,
            determined: true,
            ..Observation::default()
        };
        let other = |(i, value): (usize, &f64)| Observation {
            session: format!("undated{i}"),
            day: None,
            value: *value,
            ..row(0)
        };
        let rows: Vec<Observation> =
            (0..6).map(row).chain(undated.iter().enumerate().map(other)).collect();
        let history = History::new(&rows.iter().collect::<Vec<_>>());
        slope(&history, 0, &[vec![1.0; rows.len()]], 0.0)
    }

    /// It has no date, whatever its value: the slope of the others stays one per day.
    #[test]
    fn one_session_without_a_day_leaves_the_slope_per_day() {
        for value in [0.99, 1.0025, 1.02] {
            let days = drift_of(3.0, &[value]).expect("fifteen days");
            assert!((days.slope - 1e-3 / 3.0).abs() < 1e-9, "{value}: {days:?}");
        }
    }

    #[test]
    fn three_quarters_of_an_hour_have_no_drift_per_day() {
        let days = drift(1.0).expect("five days");
        assert!((days.slope - 1e-3).abs() < 1e-9, "{days:?}");
        assert_eq!(drift(45.0 / 60.0 / 24.0 / 5.0), None);
        assert!(drift(0.21).is_some(), "a day and an hour");
    }
}
