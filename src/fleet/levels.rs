//! The level of one coefficient, event by event: weighted least squares on the events' shapes.

use nalgebra::{DMatrix, DVector};

use super::events::Event;
use super::history::History;
use super::scan::Shape;

/// The columns of one coefficient, each as long as the sessions: the constant, then one per event
/// that concerns it. With `lines`, drifts too.
pub(crate) fn regressors(
    history: &History,
    events: &[Event],
    c: usize,
    lines: bool,
) -> Vec<Vec<f64>> {
    let n = history.sessions.len();
    let mut columns = vec![vec![1.0; n]];
    let concerned = events.iter().filter(|e| e.affects(c));
    columns.extend(
        concerned.filter(|e| lines || e.shape != Shape::Line).map(|e| column(history, e.shape)),
    );
    columns
}

/// One shape as a column.
pub(crate) fn column(history: &History, shape: Shape) -> Vec<f64> {
    match shape {
        Shape::Stretch(a, b) => {
            (0..history.sessions.len()).map(|i| f64::from(u8::from((a..b).contains(&i)))).collect()
        }
        Shape::Line => {
            let times = history.times();
            let mean = times.iter().sum::<f64>() / times.len().max(1) as f64;
            times.iter().map(|t| t - mean).collect()
        }
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Level {
    /// Fitted level of every session; NaN where nothing with a value shares its level.
    pub fitted: Vec<f64>,
    /// Variance of the fitted level.
    pub variance: Vec<f64>,
    /// Coefficient of each column.
    pub theta: Vec<f64>,
    /// Values less columns that they determine.
    pub freedom: usize,
}

/// Fits the columns to the values, NaN passed over, by `1 / variances`.
///
/// `None` where there are no values. Columns that the values do not determine get zero.
pub(crate) fn fit(values: &[f64], variances: &[f64], columns: &[Vec<f64>]) -> Option<Level> {
    let known: Vec<usize> =
        (0..values.len()).filter(|i| values[*i].is_finite() && variances[*i] > 0.0).collect();
    if known.is_empty() {
        return None;
    }
    let x = DMatrix::from_fn(known.len(), columns.len(), |r, k| {
        columns[k][known[r]] / variances[known[r]].sqrt()
    });
    let y = DVector::from_fn(known.len(), |r, _| values[known[r]] / variances[known[r]].sqrt());
    let scale: Vec<f64> = x.column_iter().map(|c| c.norm()).collect();
    let unit = DMatrix::from_fn(x.nrows(), x.ncols(), |r, k| {
        if scale[k] > 0.0 { x[(r, k)] / scale[k] } else { 0.0 }
    });
    let svd = unit.svd(true, true);
    let rank = svd.singular_values.iter().filter(|s| **s > 1e-9).count();
    let theta = svd.solve(&y, 1e-9).ok()?;
    let v = svd.v_t.as_ref()?;
    let per = |k: usize| if scale[k] > 0.0 { 1.0 / scale[k] } else { 0.0 };
    let theta: Vec<f64> = (0..columns.len()).map(|k| theta[k] * per(k)).collect();
    let mut fitted = Vec::with_capacity(values.len());
    let mut variance = Vec::with_capacity(values.len());
    for i in 0..values.len() {
        let lost = (0..columns.len()).any(|k| columns[k][i] != 0.0 && scale[k] == 0.0);
        fitted.push(if lost {
            f64::NAN
        } else {
            (0..columns.len()).map(|k| columns[k][i] * theta[k]).sum()
        });
        let mut total = 0.0;
        for (m, s) in svd.singular_values.iter().enumerate().filter(|(_, s)| **s > 1e-9) {
            let along: f64 = (0..columns.len()).map(|k| v[(m, k)] * columns[k][i] * per(k)).sum();
            total += (along / s).powi(2);
        }
        variance.push(total);
    }
    Some(Level { fitted, variance, theta, freedom: known.len() - rank })
}
