//! Points that a tyre bench measured, in the charts of friction: `bench_front.tdx` and `bench_rear.tdx` in the output
//! folder, of every motorcycle in it.
//!
//! | chart | which points |
//! |---|---|
//! | longitudinal friction over slip ratio | straight on and upright |
//! | lateral friction over camber | freely rolling, without slip angle |
//! | lateral friction over slip angle | freely rolling, upright |
//!
//! Corners are drawn as left-hand ones, so bench points are turned to that side. A bench goes further than a ride: what
//! lies far beyond the samples of a chart stays out of it, so that they can still be seen.

use std::path::Path;

use crate::contract::bike::Axle;
use crate::report::charts::chart::{Chart, Cloud};
use crate::report::error::Error;
use crate::report::plots::fits::{FRICTION_X, FRICTION_Y, FRICTION_Y_SLIP};
use crate::report::plots::plot::Plot;
use crate::store::tables::read;
use crate::tyre::tydex::read::parse;
use crate::tyre::tydex::{self, Bench, Point};

/// Slip angle, rad, slip ratio and camber, rad, up to which there is none.
const NO_SLIP_ANGLE: f64 = 0.0045;
const NO_SLIP_RATIO: f64 = 0.005;
const NO_CAMBER: f64 = 0.0175;
/// So far beyond a chart's samples, over their extent, points are drawn.
const BEYOND: f64 = 1.0;
/// Most points of a cloud.
const MAX_POINTS: usize = 2000;

/// Points of both tyres.
#[derive(Debug, Default, Clone, PartialEq)]
pub(crate) struct BenchPoints {
    tyres: [Vec<Point>; 2],
    pub text: String,
}

/// Name of a tyre's file in the output folder.
pub(crate) fn file_name(axle: Axle) -> String {
    format!("bench_{}.tdx", axle.name())
}

/// Reads a TYDEX file.
///
/// # Errors
/// Error text with file and line.
pub(crate) fn check(bytes: &[u8], path: &Path) -> Result<Bench, tydex::Error> {
    parse(bytes, path)
}

impl BenchPoints {
    /// Those of an output folder; none where there are no such files.
    ///
    /// # Errors
    /// A file cannot be read.
    pub(crate) fn read(out: &Path) -> Result<Self, Error> {
        let mut points = BenchPoints::default();
        for axle in Axle::BOTH {
            let path = out.join(file_name(axle));
            if !path.is_file() {
                continue;
            }
            let fail =
                |message: String| -> Error { read::Error { path: path.clone(), message }.into() };
            let bytes = std::fs::read(&path).map_err(|e| fail(e.to_string()))?;
            points.tyres[axle as usize] =
                check(&bytes, &path).map_err(|e| fail(e.to_string()))?.points;
            points.text += &String::from_utf8_lossy(&bytes);
        }
        Ok(points)
    }

    /// The points of one tyre.
    pub(super) fn of(&self, axle: Axle) -> &[Point] {
        &self.tyres[axle as usize]
    }

    /// Puts the points into the charts of friction.
    pub(crate) fn draw(&self, charts: &mut [Chart]) {
        for axle in Axle::BOTH {
            let k = axle as usize;
            for (plot, label, of) in [
                (&FRICTION_X[k], "tyre bench, straight and upright", along as Pick),
                (&FRICTION_Y[k], "tyre bench, no slip angle", by_camber),
                (&FRICTION_Y_SLIP[k], "tyre bench, upright", by_slip_angle),
            ] {
                let points = self.tyres[k].iter().filter_map(of).collect();
                if let Some(chart) = charts.iter_mut().find(|c| c.name == plot.name) {
                    draw(chart, plot, label, points);
                }
            }
        }
    }
}

/// Abscissa and ordinate of a point, SI units; none where the point is of another chart.
type Pick = fn(&Point) -> Option<(f64, f64)>;

fn along(p: &Point) -> Option<(f64, f64)> {
    let straight = p.slip_angle.abs() <= NO_SLIP_ANGLE && p.camber.abs() <= NO_CAMBER;
    straight.then_some((p.slip_ratio, p.force_x? / p.load))
}

fn by_camber(p: &Point) -> Option<(f64, f64)> {
    let free = p.slip_ratio.abs() <= NO_SLIP_RATIO && p.slip_angle.abs() <= NO_SLIP_ANGLE;
    // a left-hand corner has a negative camber
    let side = if p.camber > 0.0 { -1.0 } else { 1.0 };
    free.then_some((side * p.camber, side * p.force_y? / p.load))
}

fn by_slip_angle(p: &Point) -> Option<(f64, f64)> {
    let free = p.slip_ratio.abs() <= NO_SLIP_RATIO && p.camber.abs() <= NO_CAMBER;
    let friction = p.force_y? / p.load;
    // a left-hand corner has a positive side force
    let side = if friction < 0.0 { -1.0 } else { 1.0 };
    free.then_some((side * p.slip_angle, side * friction))
}

fn draw(chart: &mut Chart, plot: &Plot, label: &str, points: Vec<(f64, f64)>) {
    let drawn = chart.clouds.iter().flat_map(|c| c.x.iter().copied());
    let [low, high] = drawn.fold([f64::MAX, f64::MIN], |[low, high], x| [low.min(x), high.max(x)]);
    let more = BEYOND * (high - low).max(0.0);
    let scaled = points.iter().map(|(x, y)| (x * plot.x.scale, y * plot.y.scale));
    let near: Vec<(f64, f64)> =
        scaled.filter(|(x, _)| low > high || (low - more..=high + more).contains(x)).collect();
    if near.is_empty() {
        return;
    }
    let mut cloud =
        Cloud { name: "bench".into(), label: label.into(), r: Some(3.0), ..Cloud::default() };
    for (x, y) in near.iter().step_by(near.len().div_ceil(MAX_POINTS)) {
        cloud.x.push(*x);
        cloud.y.push(*y);
        cloud.w.push(1.0);
        cloud.m.push(None);
        cloud.t.push("bench".into());
    }
    chart.clouds.push(cloud);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::session::bench_values;
    use crate::store::tables::registry;

    /// No option of a command may name them: they are what a report was given.
    #[test]
    fn what_is_kept_of_a_bench_is_on_the_outputs_list() {
        let kept = Axle::BOTH.map(file_name).into_iter().chain([bench_values::FILE.to_owned()]);
        for name in kept {
            assert!(registry::OTHER_FILES.contains(&name.as_str()), "{name}");
        }
    }

    fn point(slip_ratio: f64, slip_angle: f64, camber: f64, force: f64) -> Point {
        let (force_x, force_y) = (Some(force), Some(force));
        Point { slip_ratio, slip_angle, camber, load: 1000.0, force_x, force_y, ..Point::default() }
    }

    #[test]
    fn each_point_is_drawn_where_it_belongs_and_on_the_side_of_the_corners() {
        let points = vec![
            point(-0.1, 0.0, 0.0, -900.0),
            point(0.0, 0.02, 0.0, -200.0),
            point(0.0, 0.0, 0.3, -300.0),
            point(0.0, 0.3, 0.0, -950.0),
            point(-0.1, 0.02, 0.3, -100.0),
        ];
        let bench = BenchPoints { tyres: [points, Vec::new()], text: String::new() };
        let chart = |plot: &Plot, x: [f64; 2]| Chart {
            name: plot.name.into(),
            clouds: vec![Cloud { x: x.to_vec(), ..Cloud::default() }],
            ..Chart::default()
        };
        let mut charts = [
            chart(&FRICTION_X[0], [-0.2, 0.0]),
            chart(&FRICTION_Y[0], [-40.0, -10.0]),
            chart(&FRICTION_Y_SLIP[0], [-1.0, 1.0]),
            chart(&FRICTION_X[1], [-0.2, 0.0]),
        ];
        bench.draw(&mut charts);
        let drawn: Vec<Vec<(f64, f64)>> = charts
            .iter()
            .map(|c| {
                c.clouds
                    .get(1)
                    .map_or(Vec::new(), |c| c.x.iter().copied().zip(c.y.iter().copied()).collect())
            })
            .collect();
        assert_eq!(drawn[0], [(-0.1, -0.9)]);
        assert_eq!(drawn[1], [(-0.3_f64.to_degrees(), 0.3)]);
        // 17 degrees lie far beyond the samples
        assert_eq!(drawn[2], [(-0.02_f64.to_degrees(), 0.2)]);
        assert!(drawn[3].is_empty());
    }
}
