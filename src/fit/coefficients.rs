//! From fits to the rows of the `coefficients` table: standard errors, intervals, status and,
//! where there is nothing to believe, the manoeuvre that would change it.

use crate::contract::bike::{Axle, Bike};
use crate::model::formulation::Formulation;
use crate::tables::rows::{Coefficient, Ident, Provenance, Status};

use super::Config;
use super::chain::{ALL, Solution, TYRE, place};
use crate::statistics::clustered_fit::Quality;
use crate::statistics::interval::{Interval, combined_dof, delta, ratio, ratio_se};

/// Name, symbol and unit of every tyre coefficient, in the order of [`place`].
pub const NAMES: [(&str, &str, &str); TYRE] = [
    ("effective_rolling_radius", "R_rol", "m"),
    ("peak_slip", "sigma_x_max", "1"),
    ("mf_b", "b", "1"),
    ("mf_c", "c", "1"),
    ("mf_d", "d", "1"),
    ("mf_e1", "e1", "1"),
    ("mf_e2", "e2", "1"),
    ("slip_camber_c1", "c1", "1"),
    ("slip_camber_c3", "c3", "1/rad2"),
    ("lateral_friction_ct", "ct", "1"),
    ("cornering_stiffness_0", "k_alpha0", "1/rad"),
    ("camber_stiffness_0", "k_gamma0", "1/rad"),
    ("side_force_ratio", "C", "1"),
    ("twisting_stiffness", "k_t", "m/rad"),
    ("overturning_stiffness", "k_x", "m"),
    ("relaxation_length", "r_l", "m"),
    ("pneumatic_trail_0", "t_p0", "m"),
];

/// Those of the vehicle.
pub const VEHICLE_NAMES: [(&str, &str, &str); 3] = [
    ("drag", "c_drag", "kg/m"),
    ("rolling_resistance", "c_rol", "1"),
    ("overturning_stiffness", "k_x", "m"),
];

/// Tyre, name, symbol and unit of the coefficient at a place.
pub fn name(place: usize) -> (&'static str, &'static str, &'static str, &'static str) {
    let (tyre, (name, symbol, unit)) = if place < TYRE {
        ("front", NAMES[place])
    } else if place < 2 * TYRE {
        ("rear", NAMES[place - TYRE])
    } else {
        ("vehicle", VEHICLE_NAMES[place - 2 * TYRE])
    };
    (tyre, name, symbol, unit)
}

/// Share of the variance that a friction curve must explain: where the ride's limit is the
/// rider's command and the slip ratio is noise, the cloud looks like a peak that is none.
const MIN_CURVE: f64 = 0.9;

/// What a coefficient's own fit says of it.
#[derive(Debug, Clone, Default)]
struct Own {
    variance: f64,
    dof: f64,
    dispersion: Option<f64>,
    quality: Quality,
}

/// What stands in the way of believing a coefficient.
#[derive(Debug, Clone, Default)]
struct Verdict {
    status: Option<Status>,
    reason: Option<String>,
}

/// The rows of one session. `missing` says per place why a channel does not allow it.
pub fn rows(
    solution: &Solution,
    bike: &Bike,
    config: &Config,
    missing: &dyn Fn(&str, &str) -> Option<String>,
    ident: &Ident,
    provenance: &Provenance,
) -> Vec<Coefficient> {
    (0..ALL)
        .map(|at| {
            let (tyre, coefficient, symbol, unit) = name(at);
            let value = solution.values[at];
            let own = own(solution, at);
            let estimate = estimate(solution, bike, at, &own);
            let verdict =
                verdict(solution, config, at, &own, &estimate, missing(tyre, coefficient));
            let status = verdict.status.unwrap_or(Status::Ok);
            let shown = status != Status::NotAvailable && value.is_finite();
            let finite = |x: f64| Some(x).filter(|x| x.is_finite() && shown);
            let fitted = own.quality.n_samples > 0 && shown;
            Coefficient {
                ident: ident.clone(),
                tyre: tyre.to_owned(),
                coefficient: coefficient.to_owned(),
                symbol: symbol.to_owned(),
                value: finite(value),
                unit: unit.to_owned(),
                std_error: finite(estimate.std_error),
                ci95_low: estimate.interval.ends().and_then(|e| finite(e.0)),
                ci95_high: estimate.interval.ends().and_then(|e| finite(e.1)),
                dispersion: own.dispersion.and_then(finite),
                n_manoeuvres: if fitted { own.quality.n_clusters as i64 } else { 0 },
                n_samples: if fitted { own.quality.n_samples as i64 } else { 0 },
                residual_scale: fitted.then_some(own.quality.scale).and_then(finite),
                outlier_fraction: fitted.then_some(own.quality.outlier_fraction).and_then(finite),
                r_squared: fitted.then_some(own.quality.r_squared).and_then(finite),
                status,
                reason: verdict.reason,
                provenance: provenance.clone(),
            }
        })
        .collect()
}

/// A standard error and an interval.
struct Estimate {
    std_error: f64,
    interval: Interval,
}

/// Sum of squares of the upstream changes of a coefficient.
fn upstream_variance(solution: &Solution, at: usize) -> f64 {
    solution.upstream.iter().map(|u| u[at]).filter(|d| d.is_finite()).map(|d| d * d).sum()
}

fn own(solution: &Solution, at: usize) -> Own {
    let fits = &solution.fits;
    let linear =
        |fitted: &Option<crate::statistics::clustered_fit::Fitted>, j: usize, scale: f64| {
            let Some(f) = fitted else { return Own::default() };
            let (variance, dof) =
                f.covariance.as_ref().map_or((f64::NAN, 0.0), |c| (c.covariance[(j, j)], c.dof[j]));
            Own {
                variance: variance * scale * scale,
                dof,
                dispersion: f.dispersion[j].map(|d| d * scale),
                quality: f.quality.clone(),
            }
        };
    if at >= 2 * TYRE {
        return match at {
            place::DRAG => linear(&fits.coasting.resistance, 0, 1.0),
            place::ROLLING => linear(&fits.coasting.resistance, 1, 1.0),
            _ => linear(&fits.overturning, 0, crown_share(solution, 2)),
        };
    }
    let (k, j) = (at / TYRE, at % TYRE);
    match j {
        place::RADIUS => linear(&fits.coasting.radius[k], 0, 1.0),
        place::MF_B..=place::MF_E2 | place::PEAK_SLIP => {
            let Some(f) = &fits.friction[k] else { return Own::default() };
            let p = f.theta.len();
            let mut contrast = vec![0.0; p];
            let mut dispersion = None;
            if j == place::PEAK_SLIP {
                let Some((_, gradient)) = f.peak_slip() else { return Own::default() };
                contrast = gradient;
            } else if j - place::MF_B < p {
                contrast[j - place::MF_B] = 1.0;
                dispersion = f.dispersion[j - place::MF_B];
            } else {
                return Own::default();
            }
            let covariance = match j {
                place::PEAK_SLIP | place::MF_D => &f.covariance,
                _ => &f.shape_covariance,
            };
            let (se, dof) = covariance.as_ref().map_or((f64::NAN, 0.0), |c| c.contrast(&contrast));
            Own { variance: se * se, dof, dispersion, quality: f.quality.clone() }
        }
        place::C1 => linear(&fits.lateral[k].slip, 0, 1.0),
        place::C3 => linear(&fits.lateral[k].slip, 1, 1.0),
        place::CT => linear(&fits.lateral[k].friction, 0, 1.0),
        place::CROWN => linear(&fits.overturning, 0, crown_share(solution, k)),
        place::K_ALPHA | place::K_GAMMA => {
            // the quotient's interval is formed below; here is what its denominator's fit says
            let lateral = &fits.lateral[k];
            let fitted = match solution.given.formulation {
                Formulation::Corrected => &lateral.compliance,
                Formulation::Paper => &lateral.slip,
            };
            let scale = solution.values[at] / solution.quotient[k][1];
            linear(fitted, 0, scale.abs())
        }
        _ => Own::default(),
    }
}

fn crown_share(solution: &Solution, j: usize) -> f64 {
    super::cornering::overturning_shares(&solution.given.bike, solution.given.formulation)[j]
}

/// Standard error and interval of the coefficient at a place.
fn estimate(solution: &Solution, bike: &Bike, at: usize, own: &Own) -> Estimate {
    let value = solution.values[at];
    let (k, j) = (at / TYRE, at % TYRE);
    if at < 2 * TYRE && (j == place::K_ALPHA || j == place::K_GAMMA) {
        return stiffness(solution, bike, k, own, j == place::K_GAMMA);
    }
    let outside = upstream_variance(solution, at);
    let std_error = (own.variance + outside).sqrt();
    let dof = if own.dof > 0.0 {
        combined_dof(&[(own.variance.sqrt(), own.dof), (outside.sqrt(), f64::INFINITY)])
    } else if own.quality.n_samples > 0 {
        0.0 // fitted, but from too few manoeuvres to know how well
    } else {
        f64::INFINITY
    };
    if std_error == 0.0 {
        return Estimate { std_error: f64::NAN, interval: Interval::Unbounded };
    }
    Estimate { std_error, interval: delta(value, std_error, dof) }
}

/// `k_alpha0` or `k_gamma0 = C k_alpha0`: a quotient of two uncertain numbers, so its interval
/// is Fieller's, which opens where the denominator may vanish.
fn stiffness(solution: &Solution, bike: &Bike, k: usize, own: &Own, camber: bool) -> Estimate {
    let [numerator, denominator] = solution.quotient[k];
    let value = numerator / denominator;
    let c = bike.wheel(Axle::BOTH[k]).side_force_ratio;
    let scale = if camber { c } else { 1.0 };
    // own variance is that of the quotient: as if all of it were the denominator's
    let own_relative = own.variance.sqrt() / (scale * value).abs();
    let mut covariance = [0.0, 0.0, (own_relative * denominator).powi(2)];
    for (change, moved) in solution.upstream.iter().zip(&solution.upstream_quotient) {
        let [mut d_n, d_d] = moved[k];
        if camber {
            d_n = c * d_n + numerator * change[k * TYRE + place::RATIO];
        }
        if d_n.is_finite() && d_d.is_finite() {
            covariance[0] += d_n * d_n;
            covariance[1] += d_n * d_d;
            covariance[2] += d_d * d_d;
        }
    }
    let std_error = ratio_se(scale * numerator, denominator, covariance);
    let relative = std_error / (scale * value).abs();
    let outside = (relative * relative - own_relative * own_relative).max(0.0).sqrt();
    let dof = combined_dof(&[(own_relative, own.dof), (outside, f64::INFINITY)]);
    Estimate { std_error, interval: ratio(scale * numerator, denominator, covariance, dof) }
}

/// The manoeuvre that would supply a coefficient.
fn remedy(at: usize) -> &'static str {
    if at >= 2 * TYRE {
        return match at {
            place::VEHICLE_CROWN => "ride steady corners with more than 15 degrees of lean",
            _ => "coast in neutral at two speeds, in both directions",
        };
    }
    match at % TYRE {
        place::RADIUS => "coast in neutral",
        place::PEAK_SLIP | place::MF_B..=place::MF_D if at < TYRE => {
            "brake with the front brake alone, progressively to the limit, in neutral"
        }
        place::PEAK_SLIP | place::MF_B..=place::MF_D => {
            "brake with the rear brake alone, progressively to the limit, in neutral"
        }
        place::MF_E1 | place::MF_E2 if at < TYRE => {
            "brake with the front brake alone past the friction peak"
        }
        place::MF_E1 | place::MF_E2 => {
            "brake the rear wheel alone past the friction peak and accelerate hard in first gear"
        }
        _ => "ride steady corners of varied lean, without brake and throttle",
    }
}

fn verdict(
    solution: &Solution,
    config: &Config,
    at: usize,
    own: &Own,
    estimate: &Estimate,
    missing: Option<String>,
) -> Verdict {
    let say =
        |status: Status, reason: String| Verdict { status: Some(status), reason: Some(reason) };
    let j = if at < 2 * TYRE { at % TYRE } else { usize::MAX };
    match j {
        place::RATIO | place::TWIST => {
            return say(Status::Assumed, "taken from the bike file".into());
        }
        place::RELAXATION => {
            return say(
                Status::Assumed,
                "the wheel radius, or the bike file's value (eq. 1)".into(),
            );
        }
        place::TRAIL => {
            return say(Status::Assumed, "from the bike file's vertical stiffness (eq. 12)".into());
        }
        place::MF_E2 if solution.values[at] == 0.0 => {
            return say(
                Status::Assumed,
                "the wheel was not both braked and driven: e1 is the curvature of the ridden side"
                    .into(),
            );
        }
        _ => {}
    }
    let value = solution.values[at];
    if let Some(missing) = missing {
        return say(Status::NotAvailable, missing);
    }
    if !value.is_finite() {
        return say(Status::NotAvailable, format!("no usable manoeuvre: {}", remedy(at)));
    }
    if own.quality.n_clusters < config.min_manoeuvres {
        return say(
            Status::PoorlyDetermined,
            format!("only {} usable manoeuvre(s): {}", own.quality.n_clusters, remedy(at)),
        );
    }
    if at < 2 * TYRE
        && (place::PEAK_SLIP..=place::MF_E2).contains(&j)
        && let Some(f) = &solution.fits.friction[at / TYRE]
    {
        let radius = &solution.fits.coasting.radius[at / TYRE];
        if radius.as_ref().is_none_or(|r| r.quality.n_clusters < config.min_manoeuvres) {
            return say(
                Status::PoorlyDetermined,
                "the rolling radius is not known from this ride, and the slip with it: coast in \
                 neutral"
                    .into(),
            );
        }
        if f.quality.r_squared < MIN_CURVE {
            return say(
                Status::PoorlyDetermined,
                format!(
                    "the curve explains {:.0} % of the friction only, the rest is noise of the \
                     slip ratio: {}",
                    100.0 * f.quality.r_squared.max(0.0),
                    remedy(at)
                ),
            );
        }
        let deepest = (-f.ridden[0]).max(0.0);
        let reached = f.formula.peak_slip().is_some_and(|p| deepest / (1.0 - deepest) > 0.9 * p);
        if !reached && j != place::MF_B {
            return say(
                Status::PoorlyDetermined,
                format!("braked to a slip of {deepest:.3} only, short of the peak: {}", remedy(at)),
            );
        }
    }
    let Some((low, high)) = estimate.interval.ends() else {
        return say(
            Status::PoorlyDetermined,
            format!("the ride does not bound it: {}", remedy(at)),
        );
    };
    // curvature and slip over camber may well be zero: they are judged on a scale of their own
    let yardstick = match j {
        // the narrowest intervals of e1 are the luckiest ones: half the usual width is asked
        place::MF_E1 => 0.5 * value.abs().max(1.0),
        place::MF_E2 => value.abs().max(1.0),
        place::C1 => {
            value.abs().max(solution.given.bike.wheel(Axle::BOTH[at / TYRE]).side_force_ratio)
        }
        place::C3 => value.abs().max(0.1),
        _ => value.abs(),
    };
    if 0.5 * (high - low) > config.max_relative_interval * yardstick {
        return say(
            Status::PoorlyDetermined,
            format!("the interval is wide, {low:.3} to {high:.3}: {}", remedy(at)),
        );
    }
    Verdict::default()
}
