//! The `plots` table: what the report draws of a session, thinned while the samples are there.
//!
//! Of a cloud the samples that would lie under others are left away ([`thin()`]); lines are the
//! fits over the ridden range with the 95 % band of the curve; the time line keeps the mean,
//! least and largest value of each of [`BINS`] spans, so that no peak is lost. Numbers are kept
//! in single precision: a thousandth of a pixel.

use crate::contract::session::Session;
use crate::fit::chain::{Data, Solution};
use crate::segment::Segment;
use crate::tables::rows::PlotPoint;

pub mod thin;

mod fits;
pub mod offroad;
mod residuals;
mod ride;

use thin::thin;

/// Largest number of points of a cloud.
pub const POINTS: usize = 700;
/// Points of a fitted line.
const LINE: usize = 81;
/// Spans of the time line: finer than a page is wide, so that a zoom shows more.
pub const BINS: usize = 1600;

/// Everything the report draws of a session.
pub fn rows(
    session: &Session,
    segments: &[Segment],
    data: &Data,
    solution: &Solution,
) -> Vec<PlotPoint> {
    let mut sheet = Sheet { session, rows: Vec::new() };
    ride::timeline(&mut sheet, &solution.given);
    let used = fits::Used::new(data, solution);
    fits::draw(&mut sheet, data, solution, &used);
    ride::draw(&mut sheet, segments, &solution.given);
    residuals::draw(&mut sheet, data, solution, &used);
    sheet.rows
}

/// Collects the rows of one session.
pub(super) struct Sheet<'a> {
    pub(super) session: &'a Session,
    pub(super) rows: Vec<PlotPoint>,
}

/// Samples of a cloud, side by side; what is shorter than `x` is not known.
#[derive(Default)]
struct Cloud<'a> {
    x: &'a [f64],
    y: &'a [f64],
    /// Robust weights of the fit; none where nothing was fitted.
    weights: &'a [f64],
    /// Manoeuvre.
    clusters: &'a [usize],
    /// What colours the points.
    shade: &'a [f64],
}

impl Sheet<'_> {
    pub(super) fn push(
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

    fn cloud(&mut self, plot: &str, cloud: &Cloud<'_>, most: usize) {
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

    fn line(
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
