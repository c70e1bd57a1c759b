//! The `plots` table: what the report draws of a session, thinned while the samples are there.
//!
//! Clouds keep at most [`POINTS`] points each, evenly taken; lines are the fits over the ridden
//! range with the 95 % band of the curve; the time line keeps the mean, least and largest value
//! of each of [`BINS`] spans, so that no peak is lost.

use crate::GRAVITY;
use crate::channel::Channel;
use crate::estimate::signals::Given;
use crate::fit::chain::{Data, Solution};
use crate::fit::interval::t95;
use crate::rows::PlotPoint;
use crate::session::Session;

/// Largest number of points of a cloud.
pub const POINTS: usize = 600;
/// Points of a fitted line.
const LINE: usize = 81;
/// Spans of the time line.
pub const BINS: usize = 800;

/// Collects the rows of one session.
pub(super) struct Sheet<'a> {
    pub(super) session: &'a Session,
    pub(super) rows: Vec<PlotPoint>,
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
        let keep = |v: Option<f64>| v.filter(|v| v.is_finite());
        if !x.is_finite() {
            return;
        }
        self.rows.push(PlotPoint {
            session_id: self.session.meta.session_id.clone(),
            bike_id: self.session.meta.bike_id.clone(),
            plot: plot.to_owned(),
            series: series.to_owned(),
            x,
            y: keep(y[0]),
            y_low: keep(y[1]),
            y_high: keep(y[2]),
            weight: keep(weight),
            manoeuvre_id: manoeuvre.map(|m| m as i64),
        });
    }

    fn cloud(&mut self, plot: &str, x: &[f64], y: &[f64], weights: &[f64], clusters: &[usize]) {
        let step = x.len().div_ceil(POINTS).max(1);
        for i in (0..x.len()).step_by(step) {
            let weight = weights.get(i).copied();
            self.push(plot, "data", x[i], [Some(y[i]), None, None], weight, Some(clusters[i]));
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

/// Everything the report draws of a session.
pub fn rows(session: &Session, data: &Data, solution: &Solution) -> Vec<PlotPoint> {
    let mut sheet = Sheet { session, rows: Vec::new() };
    timeline(&mut sheet, &solution.given);
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        friction(&mut sheet, solution, k, &format!("friction_x_{end}"));
        lateral(&mut sheet, solution, k, end);
    }
    coast_down(&mut sheet, data, solution);
    overturning(&mut sheet, data, solution);
    sheet.rows
}

fn friction(sheet: &mut Sheet<'_>, solution: &Solution, k: usize, plot: &str) {
    let Some(fit) = &solution.fits.friction[k] else { return };
    let rows = &solution.clouds.friction[k];
    sheet.cloud(plot, &rows.slip, &rows.friction, &fit.weights, &rows.clusters);
    let band = |s: f64| {
        let covariance = fit.covariance.as_ref()?;
        let at = |theta: &[f64]| fit.formula_of(theta).value(s);
        let gradient: Vec<f64> = (0..fit.theta.len())
            .map(|j| {
                let step = 1e-4 * fit.theta[j].abs().max(0.1);
                let mut moved = fit.theta.clone();
                moved[j] += step;
                (at(&moved) - at(&fit.theta)) / step
            })
            .collect();
        let (se, dof) = covariance.contrast(&gradient);
        Some(t95(dof.max(1.0)) * se)
    };
    let [from, to] = fit.ridden;
    sheet.line(plot, "fit", from, to.max(0.0), &|s| (fit.formula.value(s), band(s)));
}

fn lateral(sheet: &mut Sheet<'_>, solution: &Solution, k: usize, end: &str) {
    let lateral = &solution.fits.lateral[k];
    let rows = &solution.clouds.lateral[k];
    let (plot_alpha, plot_mu) = (format!("slip_angle_{end}"), format!("friction_y_{end}"));
    let low = rows.camber.iter().copied().fold(0.0, f64::min);
    let high = rows.camber.iter().copied().fold(0.0, f64::max);
    if let Some(fit) = &lateral.slip {
        sheet.cloud(&plot_alpha, &rows.camber, &rows.slip_angle, &fit.weights, &rows.clusters);
        sheet.line(&plot_alpha, "fit", low, high, &|g| {
            let contrast = [g, g.powi(3)];
            let half = fit.covariance.as_ref().map(|c| {
                let (se, dof) = c.contrast(&contrast);
                t95(dof.max(1.0)) * se
            });
            (fit.theta[0] * contrast[0] + fit.theta[1] * contrast[1], half)
        });
    }
    if let Some(fit) = &lateral.friction {
        sheet.cloud(&plot_mu, &rows.camber, &rows.friction, &fit.weights, &rows.clusters);
        sheet.line(&plot_mu, "fit", low, high, &|g| {
            let half = fit.covariance.as_ref().map(|c| {
                t95(c.dof[0].max(1.0)) * c.covariance[(0, 0)].max(0.0).sqrt() * g.tan().abs()
            });
            (fit.theta[0] * g.tan(), half)
        });
    }
    let formulation = solution.given.formulation;
    let wheel = if k == 0 { &solution.given.bike.front } else { &solution.given.bike.rear };
    let ratio = wheel.side_force_ratio;
    if lateral.k_alpha(0.0, ratio, formulation).is_some() {
        for (series, scale) in [("k_alpha", 1.0), ("k_gamma", ratio)] {
            sheet.line(&format!("stiffness_{end}"), series, 0.0, lateral.ridden, &|g| {
                let k = lateral.k_alpha(g, ratio, formulation).unwrap_or(f64::NAN);
                (scale * k, None)
            });
        }
    }
}

/// Force that slows the coasting bike, wheels' inertia included, over the speed squared.
fn coast_down(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution) {
    let given = &solution.given;
    let Some(fit) = &solution.fits.coasting.resistance else { return };
    let x = &data.coast;
    let inertia = given.bike.mass + given.rotating_mass().iter().sum::<f64>();
    let weight = given.bike.mass * GRAVITY;
    let square: Vec<f64> = x.velocity_x.iter().map(|v| v * v).collect();
    let slope = fit.theta.get(2).copied().unwrap_or(0.0);
    let force: Vec<f64> = (0..x.len())
        .map(|i| {
            let a = x.acceleration_x[i] - given.zeros.acceleration_x;
            -inertia * a - slope * weight * x.direction[i]
        })
        .collect();
    sheet.cloud("coast_down", &square, &force, &fit.weights, &x.segment);
    let top = square.iter().copied().fold(0.0, f64::max);
    sheet.line("coast_down", "fit", 0.0, top, &|v2| {
        let half = fit.covariance.as_ref().map(|c| {
            let mut contrast = vec![0.0; fit.theta.len()];
            contrast[0] = v2;
            contrast[1] = weight;
            let (se, dof) = c.contrast(&contrast);
            t95(dof.max(1.0)) * se
        });
        (fit.theta[0] * v2 + fit.theta[1] * weight, half)
    });
}

fn overturning(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution) {
    let Some(fit) = &solution.fits.overturning else { return };
    let given = &solution.given;
    let weight = given.bike.mass * GRAVITY;
    let (lever, moment, clusters) = &solution.clouds.overturning;
    let roll: Vec<f64> = solution
        .clouds
        .keep_steady
        .iter()
        .map(|&i| data.corner.roll[i] - given.zeros.roll)
        .collect();
    let arm: Vec<f64> = moment.iter().map(|m| m / weight).collect();
    sheet.cloud("overturning", &roll, &arm, &fit.weights, clusters);
    // the lever per tangent of roll is all but constant: its mean draws the line
    let tangent: f64 = roll.iter().map(|r| r.tan().powi(2)).sum();
    let per_tangent: f64 = lever.iter().zip(&roll).map(|(l, r)| l * r.tan()).sum::<f64>() / tangent;
    let low = roll.iter().copied().fold(0.0, f64::min);
    let high = roll.iter().copied().fold(0.0, f64::max);
    let scale = per_tangent / weight;
    sheet.line("overturning", "fit", low, high, &|r| {
        let half = fit.covariance.as_ref().map(|c| {
            t95(c.dof[0].max(1.0)) * c.covariance[(0, 0)].max(0.0).sqrt() * (scale * r.tan()).abs()
        });
        (fit.theta[0] * scale * r.tan(), half)
    });
}

fn timeline(sheet: &mut Sheet<'_>, given: &Given) {
    let session = sheet.session;
    let step = session.len.div_ceil(BINS).max(1);
    for channel in [Channel::VelocityX, Channel::AccelerationX, Channel::Roll] {
        if let Some(x) = session.get(channel) {
            bins(sheet, channel.name(), step, &|i| x[i]);
        }
    }
    let Some(v) = session.get(Channel::VelocityX) else { return };
    for (k, (series, channel)) in [
        ("slip_ratio_front", Channel::WheelSpeedFront),
        ("slip_ratio_rear", Channel::WheelSpeedRear),
    ]
    .into_iter()
    .enumerate()
    {
        if let Some(omega) = session.get(channel) {
            let radius = given.radius[k];
            bins(sheet, series, step, &|i| {
                if v[i] > 3.0 { radius * omega[i] / v[i] - 1.0 } else { f64::NAN }
            });
        }
    }
}

pub(super) fn bins(sheet: &mut Sheet<'_>, series: &str, step: usize, f: &dyn Fn(usize) -> f64) {
    let session = sheet.session;
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
        let y = if count > 0.0 { [Some(sum / count), Some(low), Some(high)] } else { [None; 3] };
        sheet.push("timeline", series, time, y, None, None);
    }
}
