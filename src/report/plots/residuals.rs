//! Residuals of the fits over what could explain them.
//!
//! A plot per fit and covariate. The trend is the mean of what the fit did not call an outlier, in
//! bins of equally many samples; its band is the 95 % interval of the mean of the bin's manoeuvres,
//! so that one odd manoeuvre is not taken for a dependence.

use std::collections::BTreeMap;

use super::fits::{CAMBER, Used, coasting_force};
use super::plot::{Axis, Plot, Section, Series};
use super::ride::SPEED;
use super::sheet::{Cloud, Sheet};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::fit::coasting::{DRAG, ROLLING};
use crate::fit::cornering::{C1, C3, CT};
use crate::fit::{Data, Solution};
use crate::statistics::interval::t95;

const SLIP_ANGLE: Axis = Axis::degrees("slip angle residual");
const FRICTION: Axis = Axis::new("friction residual", "", 1.0);
const FORCE: Axis = Axis::new("force residual", "N", 1.0);

/// The mean of the samples that the fit did not reject, in bins.
const TREND: Series = Series::new("trend", "mean");

/// Covariates, in the order of a fit's plots: speed, load, camber, temperature, time.
const COVARIATES: usize = 5;

/// The residuals of one fit over every covariate, under the fit's heading.
macro_rules! over_covariates {
    ($fit:literal, $title:literal, $y:expr) => {
        over_covariates! { $fit, $title, $y;
            "speed", SPEED;
            "load", Axis::new("wheel load", "N", 1.0);
            "camber", CAMBER;
            "temperature", Axis::new("temperature", "°C", 1.0);
            "time", Axis::new("time", "s", 1.0);
        }
    };
    ($fit:literal, $title:literal, $y:expr; $($covariate:literal, $x:expr;)*) => {
        [$(Plot {
            section: Section::Residual,
            series: &[TREND],
            ..Plot::new(concat!("residual_", $fit, "_over_", $covariate), $title, [$x, $y], "")
        }),*]
    };
}

const FRICTION_X: [[Plot; COVARIATES]; 2] = [
    over_covariates!("friction_x_front", "Front · longitudinal friction", FRICTION),
    over_covariates!("friction_x_rear", "Rear · longitudinal friction", FRICTION),
];
const SLIP: [[Plot; COVARIATES]; 2] = [
    over_covariates!("slip_angle_front", "Front · slip angle", SLIP_ANGLE),
    over_covariates!("slip_angle_rear", "Rear · slip angle", SLIP_ANGLE),
];
const FRICTION_Y: [[Plot; COVARIATES]; 2] = [
    over_covariates!("friction_y_front", "Front · lateral friction", FRICTION),
    over_covariates!("friction_y_rear", "Rear · lateral friction", FRICTION),
];
const COAST_DOWN: [Plot; COVARIATES] = over_covariates!("coast_down", "Coast-down", FORCE);

/// Every plot of residuals, by fit in the order of the page.
pub(crate) const PLOTS: [[Plot; COVARIATES]; 7] =
    [FRICTION_X[0], FRICTION_X[1], SLIP[0], SLIP[1], FRICTION_Y[0], FRICTION_Y[1], COAST_DOWN];

/// Largest number of points of a residual cloud.
const POINTS: usize = 240;
/// Bins of the trend.
const BINS: usize = 10;
/// Samples that a bin needs.
const SAMPLES_PER_BIN: usize = 8;
/// Manoeuvres that a bin needs for a band.
const MANOEUVRES_PER_BAND: usize = 3;

/// The residuals of one fit, sample by sample.
struct Residuals<'a> {
    /// Data less fit.
    values: Vec<f64>,
    /// Robust weights; 0 is an outlier.
    weights: &'a [f64],
    /// Index of each sample's manoeuvre.
    clusters: &'a [usize],
    /// Time, s.
    time: &'a [f64],
}

pub(super) fn draw(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution, used: &Used) {
    for k in 0..2 {
        longitudinal(sheet, solution, used, k);
        lateral(sheet, solution, used, k);
    }
    coast_down(sheet, data, solution);
}

fn longitudinal(sheet: &mut Sheet<'_>, solution: &Solution, used: &Used, k: usize) {
    let Some(fit) = &solution.fits.friction[k] else { return };
    let rows = &solution.samples.friction[k];
    let residual = |i: usize| rows.friction[i] - fit.formula.value(rows.slip[i]);
    let residuals = Residuals {
        values: (0..rows.samples()).map(residual).collect(),
        weights: &fit.weights,
        clusters: &rows.clusters,
        time: &used.straight_time[k],
    };
    let temperature = temperature(sheet.session, Some(k), residuals.time);
    let over: [Option<&[f64]>; 4] = [
        Some(&rows.speed),
        Some(&used.straight_load[k]),
        Some(&used.straight_roll[k]),
        temperature.as_deref(),
    ];
    covariates(sheet, &FRICTION_X[k], &residuals, over);
}

fn lateral(sheet: &mut Sheet<'_>, solution: &Solution, used: &Used, k: usize) {
    let lateral = &solution.fits.lateral[k];
    let rows = &solution.samples.lateral[k];
    let temperature = temperature(sheet.session, Some(k), &used.corner_time);
    let over: [Option<&[f64]>; 4] = [
        Some(&used.corner_speed),
        Some(&used.corner_load[k]),
        Some(&rows.camber),
        temperature.as_deref(),
    ];
    let residuals = |values: Vec<f64>, weights| Residuals {
        values,
        weights,
        clusters: &rows.clusters,
        time: &used.corner_time,
    };
    if let Some(fit) = &lateral.slip {
        let [c1, c3] = [fit.theta[C1], fit.theta[C3]];
        let curve = |camber: f64| c1 * camber + c3 * camber.powi(3);
        let pairs = rows.slip_angle.iter().zip(&rows.camber);
        let values = pairs.map(|(angle, camber)| angle - curve(*camber)).collect();
        covariates(sheet, &SLIP[k], &residuals(values, &fit.weights), over);
    }
    if let Some(fit) = &lateral.friction {
        let pairs = rows.friction.iter().zip(&rows.camber);
        let values = pairs.map(|(mu, camber)| mu - fit.theta[CT] * camber.tan()).collect();
        covariates(sheet, &FRICTION_Y[k], &residuals(values, &fit.weights), over);
    }
}

fn coast_down(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution) {
    let Some(fit) = &solution.fits.coasting.resistance else { return };
    let x = &data.coast;
    let weight = solution.inputs.bike.mass * GRAVITY;
    let force = coasting_force(data, solution, &fit.theta);
    let curve = |i: usize| fit.theta[DRAG] * x.velocity_x[i].powi(2) + fit.theta[ROLLING] * weight;
    let residuals = Residuals {
        values: (0..x.len()).map(|i| force[i] - curve(i)).collect(),
        weights: &fit.weights,
        clusters: &x.segment,
        time: &x.time,
    };
    let temperature = temperature(sheet.session, None, residuals.time);
    let over: [Option<&[f64]>; 4] =
        [Some(&x.velocity_x), None, Some(&x.roll), temperature.as_deref()];
    covariates(sheet, &COAST_DOWN, &residuals, over);
}

/// Temperature at some times, °C: of a tyre where it was measured, else of the air.
fn temperature(session: &Session, tyre: Option<usize>, time: &[f64]) -> Option<Vec<f64>> {
    let own = tyre.map(|k| [Channel::TyreTemperatureFront, Channel::TyreTemperatureRear][k]);
    let x = own.and_then(|c| session.get(c)).or_else(|| session.get(Channel::AirTemperature))?;
    let at = |t: &f64| x.get((t * session.rate).round() as usize).copied().unwrap_or(f64::NAN);
    Some(time.iter().map(at).collect())
}

/// The plots of one fit: over speed, load, camber and temperature as far as they are known, and time.
fn covariates(
    sheet: &mut Sheet<'_>,
    plots: &[Plot; COVARIATES],
    residuals: &Residuals<'_>,
    over: [Option<&[f64]>; 4],
) {
    for (plot, x) in plots.iter().zip(over.into_iter().chain([Some(residuals.time)])) {
        let Some(x) = x.filter(|x| x.iter().any(|v| v.is_finite())) else { continue };
        let cloud = Cloud {
            x,
            y: &residuals.values,
            weights: residuals.weights,
            clusters: residuals.clusters,
            colour: &[],
        };
        sheet.cloud(plot, &cloud, POINTS);
        for (x, mean, half) in trend(x, residuals) {
            sheet.point(
                plot,
                &TREND,
                x,
                [Some(mean), half.map(|h| mean - h), half.map(|h| mean + h)],
            );
        }
    }
}

/// Mean abscissa, mean residual and half the width of its 95 % interval in each bin.
fn trend(x: &[f64], residuals: &Residuals<'_>) -> Vec<(f64, f64, Option<f64>)> {
    let mut order: Vec<(f64, usize)> = (0..x.len().min(residuals.values.len()))
        .filter(|&i| x[i].is_finite() && residuals.values[i].is_finite())
        .filter(|&i| residuals.weights.get(i).is_none_or(|w| *w > 0.0))
        .map(|i| (x[i], i))
        .collect();
    let count = (order.len() / SAMPLES_PER_BIN).min(BINS);
    if count < 2 {
        return Vec::new();
    }
    let (all, mut rest, mut start) = (order.len(), order.as_mut_slice(), 0);
    let mut bins = Vec::with_capacity(count);
    for b in 1..=count {
        let end = b * all / count;
        // what belongs to a bin counts, not its order within
        if end < all {
            let by_abscissa =
                |a: &(f64, usize), b: &(f64, usize)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
            rest.select_nth_unstable_by(end - start, by_abscissa);
        }
        let (bin, after) = rest.split_at_mut(end - start);
        bins.push(of_bin(bin, residuals));
        (rest, start) = (after, end);
    }
    bins
}

/// The same of one bin: abscissae and places of its samples.
fn of_bin(bin: &[(f64, usize)], residuals: &Residuals<'_>) -> (f64, f64, Option<f64>) {
    let mut by_manoeuvre: BTreeMap<usize, (f64, f64)> = BTreeMap::new();
    let (mut abscissae, mut level) = (0.0, 0.0);
    for &(x, i) in bin {
        abscissae += x;
        level += residuals.values[i];
        let (sum, n) = by_manoeuvre.entry(residuals.clusters[i]).or_default();
        *sum += residuals.values[i];
        *n += 1.0;
    }
    let n = by_manoeuvre.len() as f64;
    let means = by_manoeuvre.values().map(|(sum, n)| sum / n);
    let centre = means.clone().sum::<f64>() / n;
    let variance = means.map(|m| (m - centre).powi(2)).sum::<f64>() / (n - 1.0);
    let half =
        (by_manoeuvre.len() >= MANOEUVRES_PER_BAND).then(|| t95(n - 1.0) * (variance / n).sqrt());
    let samples = bin.len() as f64;
    (abscissae / samples, level / samples, half)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_shows_a_dependence_and_ignores_outliers() {
        let x: Vec<f64> = (0..400).map(|i| f64::from(i % 100)).collect();
        let noise = |i: usize| [0.3, -0.2, 0.1, -0.2][(i / 100) % 4];
        let mut values: Vec<f64> = (0..400).map(|i| 0.01 * x[i] - 0.5 + noise(i)).collect();
        let mut weights = vec![1.0; 400];
        values[37] = 1e6;
        weights[37] = 0.0;
        let clusters: Vec<usize> = (0..400).map(|i| i / 100).collect();
        let residuals = Residuals { values, weights: &weights, clusters: &clusters, time: &x };
        let bins = trend(&x, &residuals);
        assert_eq!(bins.len(), BINS);
        for (x, mean, half) in bins {
            let half = half.expect("four manoeuvres in each bin");
            assert!((mean - (0.01 * x - 0.5)).abs() < 0.02, "{x} {mean}");
            // four manoeuvres with a spread of 0.24: t95(3) 0.24 / 2
            assert!((half - 3.18 * 0.245 / 2.0).abs() < 0.05, "{half}");
        }
    }
}
