//! What the fits leave, over everything that could be behind it.
//!
//! A plot per fit and covariate: `residual_<fit>_over_<covariate>`. The trend is the mean of what
//! the fit did not call an outlier, in bins of equally many samples; its band is the 95 %
//! interval of the mean of the bin's manoeuvres, so that one odd manoeuvre is not taken for a
//! dependence.

use std::collections::BTreeMap;

use super::fits::{Used, coasting_force};
use super::sheet::{Cloud, Sheet};
use crate::GRAVITY;
use crate::contract::channel::Channel;
use crate::fit::coasting::{DRAG, ROLLING};
use crate::fit::cornering::{C1, C3, CT};
use crate::fit::{Data, Solution};
use crate::statistics::interval::t95;

/// Largest number of points of a residual cloud.
const POINTS: usize = 240;
/// Bins of the trend, and samples that one needs.
const BINS: usize = 10;
const PER_BIN: usize = 8;
/// Manoeuvres that a bin needs for a band.
const MIN_MANOEUVRES: usize = 3;

/// Residuals of one fit.
struct Residuals<'a> {
    residuals: Vec<f64>,
    weights: &'a [f64],
    clusters: &'a [usize],
    time: &'a [f64],
}

pub(super) fn draw(sheet: &mut Sheet<'_>, data: &Data, solution: &Solution, used: &Used) {
    let temperature = |sheet: &Sheet<'_>, k: Option<usize>, time: &[f64]| {
        let session = sheet.session;
        let own = k.map(|k| [Channel::TyreTemperatureFront, Channel::TyreTemperatureRear][k]);
        let x =
            own.and_then(|c| session.get(c)).or_else(|| session.get(Channel::AirTemperature))?;
        let at = |t: &f64| x.get((t * session.rate).round() as usize).copied().unwrap_or(f64::NAN);
        Some(time.iter().map(at).collect::<Vec<f64>>())
    };
    for (k, end) in ["front", "rear"].into_iter().enumerate() {
        if let Some(fit) = &solution.fits.friction[k] {
            let rows = &solution.samples.friction[k];
            let curve = |i: usize| rows.friction[i] - fit.formula.value(rows.slip[i]);
            let left = Residuals {
                residuals: (0..rows.samples()).map(curve).collect(),
                weights: &fit.weights,
                clusters: &rows.clusters,
                time: &used.straight_time[k],
            };
            let hot = temperature(sheet, Some(k), left.time);
            let name = format!("friction_x_{end}");
            covariates(
                sheet,
                &name,
                &left,
                [
                    ("speed", Some(&rows.speed)),
                    ("load", Some(&used.straight_load[k])),
                    ("camber", Some(&used.straight_roll[k])),
                    ("temperature", hot.as_ref()),
                ],
            );
        }
        let lateral = &solution.fits.lateral[k];
        let rows = &solution.samples.lateral[k];
        let hot = temperature(sheet, Some(k), &used.corner_time);
        let camber = |i: usize| rows.camber[i];
        let slip = lateral.slip.as_ref().map(|fit| {
            let [c1, c3] = [fit.theta[C1], fit.theta[C3]];
            let curve = |i: usize| c1 * camber(i) + c3 * camber(i).powi(3);
            let residual = |i: usize| rows.slip_angle[i] - curve(i);
            ((0..rows.camber.len()).map(residual).collect::<Vec<f64>>(), fit)
        });
        let friction = lateral.friction.as_ref().map(|fit| {
            let residual = |i: usize| rows.friction[i] - fit.theta[CT] * camber(i).tan();
            ((0..rows.camber.len()).map(residual).collect::<Vec<f64>>(), fit)
        });
        for (name, found) in [("slip_angle", slip), ("friction_y", friction)] {
            let Some((residuals, fit)) = found else { continue };
            let left = Residuals {
                residuals,
                weights: &fit.weights,
                clusters: &rows.clusters,
                time: &used.corner_time,
            };
            covariates(
                sheet,
                &format!("{name}_{end}"),
                &left,
                [
                    ("speed", Some(&used.corner_speed)),
                    ("load", Some(&used.corner_load[k])),
                    ("camber", Some(&rows.camber)),
                    ("temperature", hot.as_ref()),
                ],
            );
        }
    }
    let Some(fit) = &solution.fits.coasting.resistance else { return };
    let x = &data.coast;
    let weight = solution.inputs.bike.mass * GRAVITY;
    let force = coasting_force(data, solution, &fit.theta);
    let curve = |i: usize| fit.theta[DRAG] * x.velocity_x[i].powi(2) + fit.theta[ROLLING] * weight;
    let left = Residuals {
        residuals: (0..x.len()).map(|i| force[i] - curve(i)).collect(),
        weights: &fit.weights,
        clusters: &x.segment,
        time: &x.time,
    };
    let hot = temperature(sheet, None, left.time);
    let over = [
        ("speed", Some(&x.velocity_x)),
        ("load", None),
        ("camber", Some(&x.roll)),
        ("temperature", hot.as_ref()),
    ];
    covariates(sheet, "coast_down", &left, over);
}

fn covariates(
    sheet: &mut Sheet<'_>,
    fit: &str,
    left: &Residuals<'_>,
    over: [(&str, Option<&Vec<f64>>); 4],
) {
    let time = left.time.to_vec();
    for (name, x) in over.into_iter().chain([("time", Some(&time))]) {
        let Some(x) = x.filter(|x| x.iter().any(|v| v.is_finite())) else { continue };
        let plot = format!("residual_{fit}_over_{name}");
        let cloud = Cloud {
            x,
            y: &left.residuals,
            weights: left.weights,
            clusters: left.clusters,
            shade: &[],
        };
        sheet.cloud(&plot, &cloud, POINTS);
        for (x, mean, half) in trend(x, left) {
            let y = [Some(mean), half.map(|h| mean - h), half.map(|h| mean + h)];
            sheet.push(&plot, "trend", x, y, None, None);
        }
    }
}

/// Middle, mean and half width of the interval of each bin.
fn trend(x: &[f64], left: &Residuals<'_>) -> Vec<(f64, f64, Option<f64>)> {
    let mut order: Vec<usize> = (0..x.len().min(left.residuals.len()))
        .filter(|&i| x[i].is_finite() && left.residuals[i].is_finite())
        .filter(|&i| left.weights.get(i).is_none_or(|w| *w > 0.0))
        .collect();
    order.sort_by(|&a, &b| x[a].total_cmp(&x[b]));
    let count = (order.len() / PER_BIN).min(BINS);
    if count < 2 {
        return Vec::new();
    }
    let bin = |b: usize| &order[b * order.len() / count..(b + 1) * order.len() / count];
    let mean = |v: &mut dyn Iterator<Item = f64>| {
        let (sum, n) = v.fold((0.0, 0.0), |(s, n), x| (s + x, n + 1.0));
        sum / n
    };
    (0..count)
        .map(|b| {
            let places = bin(b);
            let middle = mean(&mut places.iter().map(|&i| x[i]));
            let residual = mean(&mut places.iter().map(|&i| left.residuals[i]));
            let mut runs: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
            for &i in places {
                runs.entry(left.clusters[i]).or_default().push(left.residuals[i]);
            }
            let means: Vec<f64> = runs.values().map(|r| mean(&mut r.iter().copied())).collect();
            let n = means.len() as f64;
            let centre = mean(&mut means.iter().copied());
            let variance = means.iter().map(|m| (m - centre).powi(2)).sum::<f64>() / (n - 1.0);
            let half =
                (means.len() >= MIN_MANOEUVRES).then(|| t95(n - 1.0) * (variance / n).sqrt());
            (middle, residual, half)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trend_shows_a_dependence_and_ignores_outliers() {
        let x: Vec<f64> = (0..400).map(|i| f64::from(i % 100)).collect();
        let noise = |i: usize| [0.3, -0.2, 0.1, -0.2][(i / 100) % 4];
        let mut residuals: Vec<f64> = (0..400).map(|i| 0.01 * x[i] - 0.5 + noise(i)).collect();
        let mut weights = vec![1.0; 400];
        residuals[37] = 1e6;
        weights[37] = 0.0;
        let clusters: Vec<usize> = (0..400).map(|i| i / 100).collect();
        let left = Residuals { residuals, weights: &weights, clusters: &clusters, time: &x };
        let bins = trend(&x, &left);
        assert_eq!(bins.len(), BINS);
        for (x, mean, half) in bins {
            let half = half.expect("four manoeuvres in each bin");
            assert!((mean - (0.01 * x - 0.5)).abs() < 0.02, "{x} {mean}");
            // four manoeuvres with a spread of 0.24: t95(3) 0.24 / 2
            assert!((half - 3.18 * 0.245 / 2.0).abs() < 0.05, "{half}");
        }
    }
}
