//! Where the rows of the `plots` table are collected.

use super::thin::thin;
use crate::contract::session::Session;
use crate::tables::rows::PlotPoint;

/// Largest number of points of a cloud.
pub const POINTS: usize = 700;
/// Points of a fitted line.
pub const LINE: usize = 81;
/// Spans of the time line: finer than a page is wide, so that a zoom shows more.
pub const BINS: usize = 1600;

/// Collects the rows of one session.
pub struct Sheet<'a> {
    pub session: &'a Session,
    pub rows: Vec<PlotPoint>,
}

/// Samples of a cloud, side by side; what is shorter than `x` is not known.
#[derive(Default)]
pub struct Cloud<'a> {
    pub x: &'a [f64],
    pub y: &'a [f64],
    /// Robust weights of the fit; none where nothing was fitted.
    pub weights: &'a [f64],
    /// Manoeuvre.
    pub clusters: &'a [usize],
    /// What colours the points.
    pub shade: &'a [f64],
}

impl Sheet<'_> {
    /// Adds a point: `y` with the ends of its interval or range.
    pub fn push(
        &mut self,
        plot: &str,
        series: &str,
        x: f64,
        y: [Option<f64>; 3],
        weight: Option<f64>,
        manoeuvre: Option<usize>,
    ) {
        let single = |v: f64| f64::from(v as f32);
        let keep = |v: Option<f64>| v.filter(|v| v.is_finite()).map(single);
        if !x.is_finite() {
            return;
        }
        self.rows.push(PlotPoint {
            session_id: self.session.meta.session_id.clone(),
            bike_id: self.session.meta.bike_id.clone(),
            plot: plot.to_owned(),
            series: series.to_owned(),
            x: single(x),
            y: keep(y[0]),
            y_low: keep(y[1]),
            y_high: keep(y[2]),
            weight: keep(weight),
            manoeuvre_id: manoeuvre.map(|m| m as i64),
            shade: None,
            n: None,
        });
    }

    /// Adds a cloud, thinned to `most` points.
    pub fn cloud(&mut self, plot: &str, cloud: &Cloud<'_>, most: usize) {
        let outlier = |i: usize| cloud.weights.get(i).is_some_and(|w| *w == 0.0);
        for kept in thin(cloud.x, cloud.y, &outlier, most) {
            let i = kept.place;
            let weight = cloud.weights.get(i).copied().unwrap_or(1.0);
            let manoeuvre = cloud.clusters.get(i).copied().filter(|m| *m != usize::MAX);
            self.push(
                plot,
                "data",
                cloud.x[i],
                [Some(cloud.y[i]), None, None],
                Some(weight),
                manoeuvre,
            );
            if let Some(row) = self.rows.last_mut() {
                row.shade = cloud.shade.get(i).filter(|s| s.is_finite()).map(|s| s.round());
                row.n = Some(kept.n as i64);
            }
        }
    }

    /// Adds a line of a function that gives a value and the half width of its interval.
    pub fn line(
        &mut self,
        plot: &str,
        series: &str,
        from: f64,
        to: f64,
        f: &dyn Fn(f64) -> (f64, Option<f64>),
    ) {
        for i in 0..LINE {
            let x = from + (to - from) * i as f64 / (LINE - 1) as f64;
            let (y, half) = f(x);
            let edge = |sign: f64| half.map(|h| y + sign * h);
            self.push(plot, series, x, [Some(y), edge(-1.0), edge(1.0)], None, None);
        }
    }
}
