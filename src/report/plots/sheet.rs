//! Collecting the rows of one session's plots.

use std::borrow::Cow;
use std::sync::Arc;

use super::downsample::downsample;
use super::plot::{DATA, Plot, Series, TIMELINE};
use crate::contract::session::Session;
use crate::fit::bands::Band;
use crate::store::tables::rows::PlotPoint;

/// Largest number of points of a cloud over part of the ride.
pub(crate) const CLOUD_POINTS: usize = 700;
/// Points of a fitted line.
pub(super) const LINE_POINTS: usize = 81;
/// Spans of the time line: finer than a page is wide, so that a zoom shows more.
pub(crate) const TIMELINE_BINS: usize = 1600;

/// The rows so far.
pub(super) struct Sheet<'a> {
    pub(super) session: &'a Session,
    pub(super) rows: Vec<PlotPoint>,
    session_id: Arc<str>,
    bike_id: Arc<str>,
}

/// Samples of a cloud, side by side; what is shorter than `x` is not known.
#[derive(Default)]
pub(super) struct Cloud<'a> {
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    /// Robust weights of the fit; none where nothing was fitted.
    pub(super) weights: &'a [f64],
    /// Index of each sample's manoeuvre; `usize::MAX` for none.
    pub(super) clusters: &'a [usize],
    /// Quantity that colours the points.
    pub(super) colour: &'a [f64],
}

/// Value, lower and upper edge of the band; `None` where there is none.
pub(super) type Ordinate = [Option<f64>; 3];

impl<'a> Sheet<'a> {
    pub(super) fn new(session: &'a Session) -> Self {
        let (session_id, bike_id) =
            (session.meta.session_id.as_str().into(), session.meta.bike_id.as_str().into());
        Sheet { session, rows: Vec::new(), session_id, bike_id }
    }

    /// The rows; clouds and time line, which are most of them, rounded to what a screen resolves: their numbers then
    /// pack into half the bytes. The lines of fits stay as they are: others read them as the fitted curve.
    pub(super) fn finish(self) -> Vec<PlotPoint> {
        let mut rows = self.rows;
        let of_one = |a: &PlotPoint, b: &PlotPoint| a.plot == b.plot && a.series == b.series;
        for series in rows.chunk_by_mut(of_one) {
            if series.iter().any(|r| r.plot != TIMELINE && r.series != DATA) {
                continue;
            }
            let (x, y) =
                (|r: &PlotPoint| [Some(r.x), None, None], |r: &PlotPoint| [r.y, r.y_low, r.y_high]);
            let (x, y) = (quantum(series.iter().flat_map(x)), quantum(series.iter().flat_map(y)));
            for row in series {
                if row.plot != TIMELINE {
                    row.x = rounded(row.x, x); // the time line's steps are all of one length
                }
                for y_of in [&mut row.y, &mut row.y_low, &mut row.y_high] {
                    *y_of = y_of.map(|v| rounded(v, y));
                }
            }
        }
        rows
    }

    /// One row, without a weight; not finite abscissae are left out.
    pub(super) fn point(&mut self, plot: &Plot, series: &Series, x: f64, y: Ordinate) {
        self.push(plot.name, series.name, x, y);
    }

    /// One point of a curve with its bands.
    pub(super) fn banded(&mut self, plot: &Plot, series: &Series, x: f64, band: &Band) {
        let before = self.rows.len();
        let of = |ends: Option<[f64; 2]>, side: usize| ends.map(|ends| ends[side]);
        let y = [Some(band.value), of(band.interval, 0), of(band.interval, 1)];
        self.point(plot, series, x, y);
        let finite = |side: usize| of(band.scatter, side).filter(|v| v.is_finite()).map(single);
        for row in &mut self.rows[before..] {
            (row.scatter_low, row.scatter_high) = (finite(0), finite(1));
        }
    }

    fn push(
        &mut self,
        plot: &'static str,
        series: impl Into<Cow<'static, str>>,
        x: f64,
        y: Ordinate,
    ) {
        if !x.is_finite() {
            return;
        }
        let [y, y_low, y_high] = y.map(|v| v.filter(|v| v.is_finite()).map(single));
        self.rows.push(PlotPoint {
            session_id: Arc::clone(&self.session_id),
            bike_id: Arc::clone(&self.bike_id),
            plot: Cow::Borrowed(plot),
            series: series.into(),
            x: single(x),
            y,
            y_low,
            y_high,
            ..PlotPoint::default()
        });
    }

    /// Samples, at most about `most` points of them.
    pub(super) fn cloud(&mut self, plot: &Plot, cloud: &Cloud<'_>, most: usize) {
        let outlier = |i: usize| cloud.weights.get(i).is_some_and(|w| *w == 0.0);
        for kept in downsample(cloud.x, cloud.y, outlier, most) {
            let i = kept.place;
            self.push(plot.name, DATA, cloud.x[i], [Some(cloud.y[i]), None, None]);
            if let Some(row) = self.rows.last_mut() {
                let weight = cloud.weights.get(i).copied().unwrap_or(1.0);
                row.weight = Some(weight).filter(|w| w.is_finite()).map(single);
                let cluster = cloud.clusters.get(i).copied().filter(|m| *m != usize::MAX);
                row.manoeuvre_id = cluster.map(|m| m as i64);
                row.shade = cloud.colour.get(i).filter(|s| s.is_finite()).map(|s| s.round());
                row.n = Some(kept.n as i64);
            }
        }
    }

    /// A curve from one abscissa to another with its bands; left out where `f` knows nothing.
    pub(super) fn curve(
        &mut self,
        plot: &Plot,
        series: &Series,
        ends: [f64; 2],
        f: &dyn Fn(f64) -> Option<Band>,
    ) {
        for x in abscissae(ends) {
            if let Some(band) = f(x) {
                self.banded(plot, series, x, &band);
            }
        }
    }

    /// A line of the time line: mean, least and largest value of every `step` samples of `f`.
    pub(super) fn timeline(
        &mut self,
        series: impl Into<Cow<'static, str>>,
        step: usize,
        f: &dyn Fn(usize) -> f64,
    ) {
        let session = self.session;
        let series = series.into();
        for start in (0..session.len).step_by(step) {
            let end = (start + step).min(session.len);
            let (mut sum, mut count) = (0.0, 0.0);
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for i in start..end {
                let y = f(i);
                if y.is_finite() {
                    sum += y;
                    count += 1.0;
                    low = low.min(y);
                    high = high.max(y);
                }
            }
            let time = session.time(start) + 0.5 * (end - start) as f64 / session.rate;
            let y =
                if count > 0.0 { [Some(sum / count), Some(low), Some(high)] } else { [None; 3] };
            self.push(TIMELINE, series.clone(), time, y);
        }
    }
}

/// The abscissae of a line between its ends, [`LINE_POINTS`] of them.
pub(super) fn abscissae([from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
    (0..LINE_POINTS).map(move |i| from + (to - from) * i as f64 / (LINE_POINTS - 1) as f64)
}

fn single(value: f64) -> f64 {
    f64::from(value as f32)
}

/// Parts of its range that a series is rounded to: an eighth of a pixel of a page that is a thousand high.
const PARTS: f64 = 8192.0;

/// A power of two, so that the digits after it are zeros in memory too; 0 where the values are all one.
fn quantum(values: impl Iterator<Item = Option<f64>>) -> f64 {
    let (low, high) =
        values.flatten().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    match high > low {
        true => ((high - low) / PARTS).log2().floor().exp2(),
        false => 0.0,
    }
}

fn rounded(value: f64, quantum: f64) -> f64 {
    if quantum > 0.0 { (value / quantum).round() * quantum } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::session::Meta;

    #[test]
    fn a_series_is_rounded_to_a_part_of_its_range_and_order_stays() {
        let session = Session::new(Meta::default(), 100.0, 1000);
        let mut sheet = Sheet::new(&session);
        let f = |i: usize| 5.0 + (i as f64 * 0.37).sin();
        sheet.timeline("roll", 4, &f);
        let exact: Vec<[f64; 3]> = (0..250)
            .map(|k| {
                let y = (4 * k..4 * k + 4).map(f);
                let mean = y.clone().sum::<f64>() / 4.0;
                [mean, y.clone().fold(f64::INFINITY, f64::min), y.fold(f64::NEG_INFINITY, f64::max)]
            })
            .collect();
        let rows = sheet.finish();
        assert_eq!(rows.len(), 250);
        for (row, exact) in rows.iter().zip(exact) {
            let [y, low, high] = [row.y, row.y_low, row.y_high].map(|v| v.expect("a value"));
            assert!(low <= y && y <= high);
            for (v, exact) in [y, low, high].into_iter().zip(exact) {
                assert!((v - exact).abs() <= 0.5 * 2.0 / PARTS + 1e-6, "{v} is not {exact}");
            }
        }
        let mut flat = Sheet::new(&session);
        flat.timeline("throttle", 4, &|_| 0.1);
        assert_eq!(flat.finish()[0].y, Some(f64::from(0.1_f32)));
    }
}
