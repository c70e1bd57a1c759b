//! The paper's fits in their order, and how each coefficient follows what is upstream.
//!
//! METHOD: a coefficient's variance is that of its own manoeuvres (sandwich over clusters) plus,
//! for every independent upstream quantity `u` with standard error `s` (sensor zeros, latency,
//! radii, drag, and each uncertain number of the bike file), the square of its change when `u`
//! moves by `s`. The chain is simply run again with `u` moved, robust weights held: no
//! derivative is written by hand, and what depends on what is never stated twice.

use crate::contract::bike::{Axle, Bike};
use crate::contract::session::Session;
use crate::estimate::samples::{Samples, gather};
use crate::estimate::signals::{Action, Given, Signals};
use crate::estimate::zeros::Zeros;
use crate::model::tyre::trail_0;
use crate::{contract::manoeuvre::ManoeuvreKind, segment::Segment};
use crate::{estimate, model::formulation::Formulation};

use super::Config;
use super::coasting::{self, Coasting};
use super::cornering::{self, Lateral};
use super::friction::{self, Friction};
use crate::statistics::clustered_fit;

/// Coefficients of one tyre, in the order of the tables.
pub const TYRE: usize = 17;
/// All coefficients: front, rear, vehicle.
pub const ALL: usize = 2 * TYRE + 3;

/// Place of a tyre coefficient: see [`super::coefficients::NAMES`].
#[allow(missing_docs)] // the names say it
pub mod place {
    pub const RADIUS: usize = 0;
    pub const PEAK_SLIP: usize = 1;
    pub const MF_B: usize = 2;
    pub const MF_C: usize = 3;
    pub const MF_D: usize = 4;
    pub const MF_E1: usize = 5;
    pub const MF_E2: usize = 6;
    pub const C1: usize = 7;
    pub const C3: usize = 8;
    pub const CT: usize = 9;
    pub const K_ALPHA: usize = 10;
    pub const K_GAMMA: usize = 11;
    pub const RATIO: usize = 12;
    pub const TWIST: usize = 13;
    pub const CROWN: usize = 14;
    pub const RELAXATION: usize = 15;
    pub const TRAIL: usize = 16;
    pub const DRAG: usize = 34;
    pub const ROLLING: usize = 35;
    pub const VEHICLE_CROWN: usize = 36;
}

/// The samples of a session, gathered once.
#[derive(Debug, Clone)]
pub struct Data {
    /// Coasting.
    pub coast: Samples,
    /// Where the front wheel rolls freely.
    pub front_rolling: Samples,
    /// For the front: front braking. For the rear: rear braking and driving.
    pub straight: [Samples; 2],
    /// What acts on each straight sample.
    pub action: [Vec<Action>; 2],
    /// Cornering.
    pub corner: Samples,
    /// Rate of the corner samples, Hz.
    pub corner_rate: f64,
    /// Corner samples that roll faster are not quasi-static, rad/s.
    pub max_roll_rate: f64,
    /// Corner samples nearer to upright say nothing about camber, rad.
    pub min_camber: f64,
    /// Nominal rolling radii, m.
    pub nominal_radius: [f64; 2],
    /// Sensor zeros; the latency is already taken out of the samples.
    pub zeros: Zeros,
}

impl Data {
    /// Gathers the samples of the used segments.
    pub fn gather(
        session: &Session,
        segments: &[Segment],
        bike: &Bike,
        zeros: Zeros,
        config: &estimate::Config,
    ) -> Self {
        let late = zeros.latency;
        let of = |kinds: &[ManoeuvreKind], rate: f64| {
            gather(session, segments, kinds, rate, late, config)
        };
        let front = of(&[ManoeuvreKind::FrontBraking], config.straight_rate);
        let braking = of(&[ManoeuvreKind::RearBraking], config.straight_rate);
        let driving = of(&[ManoeuvreKind::Driving], config.corner_rate);
        let coast = of(&[ManoeuvreKind::Coasting], config.corner_rate);
        let front_rolling = coasting::rolls_freely(&coast, &driving);
        let front_action = vec![Action::Braking(1.0); front.len()];
        let mut rear_action = vec![Action::Braking(0.0); braking.len()];
        rear_action.resize(braking.len() + driving.len(), Action::Driving);
        let mut rear = braking;
        rear.append(driving);
        let step = (session.rate / config.corner_rate).round().max(1.0);
        Data {
            coast,
            front_rolling,
            straight: [front, rear],
            action: [front_action, rear_action],
            corner: of(&[ManoeuvreKind::Cornering], config.corner_rate),
            corner_rate: session.rate / step,
            max_roll_rate: config.max_roll_rate,
            min_camber: config.min_camber,
            nominal_radius: [bike.front.radius, bike.rear.radius],
            zeros: Zeros { latency: 0.0, ..zeros },
        }
    }
}

/// Everything that was fitted.
#[derive(Debug, Clone, Default)]
pub struct Fits {
    /// From coasting.
    pub coasting: Coasting,
    /// Friction curves, front and rear.
    pub friction: [Option<Friction>; 2],
    /// Lateral fits, front and rear.
    pub lateral: [Lateral; 2],
    /// The overturning coefficient.
    pub overturning: Option<clustered_fit::Fitted>,
}

/// What the fits were made of, for the plots.
#[derive(Debug, Clone, Default)]
pub struct Clouds {
    /// Friction samples, front and rear.
    pub friction: [friction::Rows; 2],
    /// Lateral samples, front and rear.
    pub lateral: [cornering::Rows; 2],
    /// Overturning: lever, moment, manoeuvre.
    pub overturning: (Vec<f64>, Vec<f64>, Vec<usize>),
    /// The straight samples that were kept, front and rear.
    pub friction_keep: [Vec<usize>; 2],
    /// The corner samples that were kept: quasi-static and uncombined.
    pub keep: Vec<usize>,
    /// Those of them that are steadiest, for the overturning moment.
    pub keep_steady: Vec<usize>,
}

/// One independent upstream uncertainty: how the inputs look when it is one standard error up.
struct Variation {
    bike: Option<Bike>,
    zeros: Option<Zeros>,
    /// Change of radii, drag and rolling resistance.
    coast: [f64; 4],
}

/// The result: coefficients, and what moves them.
#[derive(Debug, Clone)]
pub struct Solution {
    /// The coefficients; NaN where there is none.
    pub values: Vec<f64>,
    /// Change of every coefficient for one standard error of each upstream quantity.
    pub upstream: Vec<Vec<f64>>,
    /// Numerator and denominator of each tyre's `k_alpha0`: `1 / t1`, or printed (39).
    pub quotient: [[f64; 2]; 2],
    /// Their changes, beside `upstream`.
    pub upstream_quotient: Vec<[[f64; 2]; 2]>,
    /// The fits.
    pub fits: Fits,
    /// Their samples.
    pub clouds: Clouds,
    /// The inputs as they were used.
    pub given: Given,
}

/// Runs the chain and all its variations.
pub fn solve(data: &Data, bike: &Bike, formulation: Formulation, config: &Config) -> Solution {
    let nominal = Given {
        bike: bike.clone(),
        formulation,
        zeros: data.zeros,
        radius: [bike.front.radius, bike.rear.radius],
        drag: bike.drag,
        rolling: bike.rolling_resistance,
    };
    let mut fits = Fits {
        coasting: coasting::fit(&data.coast, &data.front_rolling, &nominal),
        ..Fits::default()
    };
    let mut given = nominal.clone();
    for k in 0..2 {
        if let Some(fitted) = &fits.coasting.radius[k] {
            given.radius[k] = fitted.theta[0];
        }
    }
    if let Some(fitted) = &fits.coasting.resistance {
        given.drag = fitted.theta[0];
        given.rolling = fitted.theta[1];
    }

    let mut clouds = Clouds::default();
    for k in 0..2 {
        let signals = given.straight(&data.straight[k], &data.action[k]);
        clouds.friction_keep[k] = friction_keep(data, &signals, k, bike);
        let keep = &clouds.friction_keep[k];
        clouds.friction[k] = friction_rows(data, &signals, k, keep, &fits.coasting, config);
        fits.friction[k] = friction::fit(&clouds.friction[k], &config.friction);
    }
    let signals = given.corner(&data.corner, data.corner_rate, None);
    clouds.keep = quasi_static(data, &signals, bike);
    clouds.keep_steady = steadiest(data, &clouds.keep);
    clouds.overturning =
        cornering::overturning_rows(&signals, &data.corner.segment, &clouds.keep_steady);
    let (lever, moment, clusters) = &clouds.overturning;
    if clustered_fit::count(clusters) >= 2 {
        let floor = cornering::MOMENT_FLOOR * bike.mass * crate::GRAVITY;
        fits.overturning = clustered_fit::fit(&[lever], moment, clusters, floor);
    }
    // the crowns first: the driven rear wheel's pull beside the plane needs them
    let crown = front_crown(fits.overturning.as_ref().map(|f| f.theta[0]), &given);
    let signals = given.corner(&data.corner, data.corner_rate, crown);
    for k in 0..2 {
        let ratio = bike.wheel(Axle::BOTH[k]).side_force_ratio;
        clouds.lateral[k] = cornering::rows(&signals, &data.corner.segment, &clouds.keep, k, ratio);
        fits.lateral[k] = cornering::fit(&clouds.lateral[k]);
    }

    let (values, quotient) = values_of(&fits, &given);
    let mut upstream = Vec::new();
    let mut upstream_quotient = Vec::new();
    let thin = Thin::new(data, &fits, &clouds);
    for variation in variations(bike, &data.zeros, &fits.coasting, formulation) {
        let (moved, quotients) = follow(&thin, &nominal, &fits, &clouds, &variation, config);
        upstream.push(moved.iter().zip(&values).map(|(m, v)| m - v).collect());
        upstream_quotient.push([0, 1].map(|k| [0, 1].map(|j| quotients[k][j] - quotient[k][j])));
    }
    Solution { values, upstream, quotient, upstream_quotient, fits, clouds, given }
}

/// `k_x` of the front tyre, for the yaw moment (19) of the lateral balance.
fn front_crown(theta: Option<f64>, given: &Given) -> Option<f64> {
    match given.formulation {
        Formulation::Corrected => theta,
        Formulation::Paper => None,
    }
}

/// Width of the friction bins that samples are thinned in.
const FRICTION_BIN: f64 = 0.05;
/// Samples kept of each friction bin: a ride has thousands near zero and dozens at the peak.
const PER_BIN: usize = 80;

/// The straight samples that can carry the friction curve, evenly thinned.
///
/// METHOD: thinned by friction, the precise side. Thinning by the noisy slip ratio would favour
/// samples with a large error among the many of small slip.
fn friction_keep(data: &Data, signals: &Signals, k: usize, bike: &Bike) -> Vec<usize> {
    let samples = &data.straight[k];
    let least = 0.03 * bike.mass * crate::GRAVITY;
    let friction = |i: usize| signals.force_x[k][i] / signals.load[k][i];
    let usable: Vec<usize> = (0..samples.len())
        .filter(|&i| {
            let slip = signals.slip_ratio[k][i];
            slip.is_finite()
                && slip.abs() < 0.95
                && signals.load[k][i] > least
                && friction(i).abs() < 3.0
        })
        .collect();
    let bin = |i: usize| ((friction(i) + 3.0) / FRICTION_BIN) as usize;
    let mut count = vec![0_usize; (6.0 / FRICTION_BIN) as usize + 1];
    usable.iter().for_each(|&i| count[bin(i)] += 1);
    let mut seen = vec![0_usize; count.len()];
    usable
        .into_iter()
        .filter(|&i| {
            let (bin, n) = (bin(i), count[bin(i)]);
            seen[bin] += 1;
            // every n/PER_BIN-th of the bin
            n <= PER_BIN || seen[bin] * PER_BIN / n != (seen[bin] - 1) * PER_BIN / n
        })
        .collect()
}

/// Error of the friction per rate of the slip ratio, s: what a 20 Hz filter leaves of it.
const BLUR: f64 = 0.004;

/// Rows of the kept samples, and the friction's expected errors.
fn friction_rows(
    data: &Data,
    signals: &Signals,
    k: usize,
    keep: &[usize],
    coasting: &Coasting,
    config: &Config,
) -> friction::Rows {
    // what coasting leaves between velocity and wheel is the error of their difference
    let from_coasting = coasting.radius[k].as_ref().map_or(0.0, |f| f.quality.scale);
    let velocity_error = config.friction.velocity_error.max(from_coasting);
    let from_coasting = coasting.resistance.as_ref().map_or(0.0, |f| f.quality.scale);
    let friction_error = config.friction.friction_error.max(from_coasting);
    let mut rows = friction::Rows::with_error(velocity_error);
    let samples = &data.straight[k];
    let mut signs = [0_usize; 2];
    for &i in keep {
        let mu = signals.force_x[k][i] / signals.load[k][i];
        rows.slip.push(signals.slip_ratio[k][i]);
        rows.friction.push(mu);
        let v = signals.speed[i];
        let slip = signals.slip_ratio[k][i];
        // a wheel that locks within a tenth of a second is blurred by the filter
        let wheel = data.nominal_radius[k] * samples.omega_rate[k][i];
        let slip_rate = (wheel - (1.0 + slip) * samples.acceleration_x[i]) / v;
        rows.speed.push(v);
        rows.friction_error.push(friction_error.hypot(BLUR * slip_rate));
        rows.clusters.push(data.straight[k].segment[i]);
        signs[usize::from(mu > 0.0)] += usize::from(mu.abs() > 0.25);
    }
    rows.both_signs = signs.iter().all(|&n| n >= 20);
    rows.index();
    rows
}

/// Corner samples that are quasi-static and uncombined.
fn quasi_static(data: &Data, signals: &Signals, bike: &Bike) -> Vec<usize> {
    let x = &data.corner;
    let weight = bike.mass * crate::GRAVITY;
    // forces and moments do without the lateral velocity; where it is there it must be whole
    let drifts = x.velocity_y.iter().any(|v| v.is_finite());
    (0..x.len())
        .filter(|&i| {
            let finite = [0, 1].iter().all(|&k| {
                (!drifts || signals.slip_angle[k][i].is_finite())
                    && signals.force_y[k][i].is_finite()
                    && signals.overturning[i].is_finite()
            });
            finite
                && x.roll_rate[i].abs() < data.max_roll_rate
                && signals.roll[i].abs() > data.min_camber
                && signals.total_x[i].abs() < 0.15 * weight
        })
        .collect()
}

/// Roll may change by this much within 0.4 s in a steady sample, rad.
const STEADY: f64 = 0.03;

/// The kept corner samples whose roll hardly changes: the roll acceleration times the unknown
/// roll inertia looks like an overturning moment. Where a ride has too few of them all count.
fn steadiest(data: &Data, keep: &[usize]) -> Vec<usize> {
    let x = &data.corner;
    let steady: Vec<usize> = keep.iter().copied().filter(|&i| x.roll_change[i] < STEADY).collect();
    let clusters: Vec<usize> = steady.iter().map(|&i| x.segment[i]).collect();
    if clustered_fit::count(&clusters) >= 6 { steady } else { keep.to_vec() }
}

/// Every coefficient from the fits.
fn values_of(fits: &Fits, given: &Given) -> (Vec<f64>, [[f64; 2]; 2]) {
    let theta =
        |f: &Option<clustered_fit::Fitted>, j: usize| f.as_ref().map_or(f64::NAN, |f| f.theta[j]);
    let radius = [0, 1].map(|k| theta(&fits.coasting.radius[k], 0));
    let resistance = fits.coasting.resistance.as_ref().map(|f| [f.theta[0], f.theta[1]]);
    let friction =
        [0, 1].map(|k| fits.friction[k].as_ref().map(|f| (f.theta.clone(), f.formula.peak_slip())));
    let lateral = [0, 1].map(|k| fits.lateral[k].values());
    assemble(
        given,
        radius,
        resistance,
        &friction,
        &lateral,
        fits.overturning.as_ref().map(|f| f.theta[0]),
    )
}

type FrictionValues = Option<(Vec<f64>, Option<f64>)>;

fn assemble(
    given: &Given,
    radius: [f64; 2],
    resistance: Option<[f64; 2]>,
    friction: &[FrictionValues; 2],
    lateral: &[cornering::Values; 2],
    overturning: Option<f64>,
) -> (Vec<f64>, [[f64; 2]; 2]) {
    let mut v = vec![f64::NAN; ALL];
    let mut quotient = [[f64::NAN; 2]; 2];
    let bike = &given.bike;
    let shares = cornering::overturning_shares(bike, given.formulation);
    let crown = overturning.unwrap_or(f64::NAN);
    for (k, axle) in Axle::BOTH.into_iter().enumerate() {
        let wheel = bike.wheel(axle);
        let at = k * TYRE;
        v[at + place::RADIUS] = radius[k];
        if let Some((theta, peak)) = &friction[k] {
            for (j, value) in theta.iter().enumerate() {
                v[at + place::MF_B + j] = *value;
            }
            if theta.len() == 4 {
                v[at + place::MF_E2] = 0.0;
            }
            v[at + place::PEAK_SLIP] = peak.unwrap_or(f64::NAN);
        }
        let ratio = wheel.side_force_ratio;
        let (slip, ct, compliance) = lateral[k];
        if let Some([c1, c3]) = slip {
            v[at + place::C1] = c1;
            v[at + place::C3] = c3;
        }
        quotient[k] = match given.formulation {
            Formulation::Corrected => [1.0, compliance.unwrap_or(f64::NAN)],
            // (39); its sign as in (22b)
            Formulation::Paper => {
                [-ct.unwrap_or(f64::NAN), slip.map_or(f64::NAN, |c| c[0]) + ratio]
            }
        };
        v[at + place::K_ALPHA] = quotient[k][0] / quotient[k][1];
        v[at + place::K_GAMMA] = ratio * v[at + place::K_ALPHA]; // (13)
        v[at + place::CT] = ct.unwrap_or(f64::NAN);
        v[at + place::RATIO] = ratio;
        v[at + place::TWIST] = wheel.twisting_stiffness;
        v[at + place::CROWN] = crown * shares[k];
        v[at + place::RELAXATION] = wheel.relaxation_length.unwrap_or(given.radius[k]);
        let share = if k == 0 { bike.cg_to_rear() } else { bike.cg_to_front } / bike.wheelbase;
        let load = bike.mass * crate::GRAVITY * share;
        v[at + place::TRAIL] = trail_0(given.radius[k], wheel.vertical_stiffness, load);
    }
    if let Some([drag, rolling]) = resistance {
        v[place::DRAG] = drag;
        v[place::ROLLING] = rolling;
    }
    v[place::VEHICLE_CROWN] = crown * shares[2];
    (v, quotient)
}

/// Every upstream quantity, one standard error up, as independent variations.
fn variations(
    bike: &Bike,
    zeros: &Zeros,
    coasting: &Coasting,
    formulation: Formulation,
) -> Vec<Variation> {
    let mut out = Vec::new();
    let plain = || Variation { bike: None, zeros: None, coast: [0.0; 4] };
    for (key, &sd) in &bike.uncertainty {
        if let (Some(value), true) = (bike.value(key), sd > 0.0) {
            out.push(Variation { bike: Some(bike.with(key, value + sd)), ..plain() });
        }
    }
    if formulation == Formulation::Corrected {
        let mut vary = |change: &dyn Fn(&mut Zeros)| {
            let mut moved = *zeros;
            change(&mut moved);
            if moved != *zeros {
                out.push(Variation { zeros: Some(moved), ..plain() });
            }
        };
        vary(&|z| z.latency += z.latency_se);
        vary(&|z| z.acceleration_x += z.acceleration_x_se);
        vary(&|z| z.roll += z.roll_se);
        for (front, zero) in [(true, zeros.front), (false, zeros.rear)] {
            for [constant, angle] in cholesky(zero.covariance) {
                vary(&|z| {
                    let zero = if front { &mut z.front } else { &mut z.rear };
                    zero.constant += constant;
                    zero.angle += angle;
                });
            }
        }
    }
    for k in 0..2 {
        if let Some(c) = coasting.radius[k].as_ref().and_then(|f| f.covariance.as_ref()) {
            let mut coast = [0.0; 4];
            coast[k] = c.covariance[(0, 0)].max(0.0).sqrt();
            out.push(Variation { coast, ..plain() });
        }
    }
    if let Some(c) = coasting.resistance.as_ref().and_then(|f| f.covariance.as_ref()) {
        let m = &c.covariance;
        for [drag, rolling] in cholesky([m[(0, 0)], m[(0, 1)], m[(1, 1)]]) {
            out.push(Variation { coast: [0.0, 0.0, drag, rolling], ..plain() });
        }
    }
    out
}

/// Columns of the Cholesky factor of a 2x2 covariance `[aa, ab, bb]`.
fn cholesky([aa, ab, bb]: [f64; 3]) -> [[f64; 2]; 2] {
    let a = aa.max(0.0).sqrt();
    if a == 0.0 {
        return [[0.0; 2], [0.0, bb.max(0.0).sqrt()]];
    }
    let b = ab / a;
    [[a, b], [0.0, (bb - b * b).max(0.0).sqrt()]]
}

/// What the variations need of the samples: those that the fits kept, and no more.
struct Thin {
    data: Data,
    /// Of the kept straight samples: all of them.
    straight: [Vec<usize>; 2],
    /// The steady corner samples. Out of their context their lagged slip angles mean nothing,
    /// but the overturning moment does not depend on them.
    steady: Samples,
    /// Slip of the friction peaks, and its gradient.
    peak: [Option<(f64, Vec<f64>)>; 2],
}

impl Thin {
    fn new(data: &Data, fits: &Fits, clouds: &Clouds) -> Self {
        let keep = &clouds.friction_keep;
        let actions = |k: usize| keep[k].iter().map(|&i| data.action[k][i]).collect();
        Thin {
            data: Data {
                straight: [0, 1].map(|k| data.straight[k].select(&keep[k])),
                action: [actions(0), actions(1)],
                coast: data.coast.clone(),
                front_rolling: data.front_rolling.clone(),
                corner: data.corner.clone(),
                ..*data
            },
            straight: [0, 1].map(|k| (0..keep[k].len()).collect()),
            steady: data.corner.select(&clouds.keep_steady),
            peak: [0, 1].map(|k| fits.friction[k].as_ref().and_then(|f| f.peak_slip())),
        }
    }
}

/// The chain with one input moved and every robust weight held. A variation of what coasting
/// gave is not fed back into coasting's own coefficients: their own sandwich has it.
fn follow(
    thin: &Thin,
    nominal: &Given,
    fits: &Fits,
    clouds: &Clouds,
    variation: &Variation,
    config: &Config,
) -> (Vec<f64>, [[f64; 2]; 2]) {
    let data = &thin.data;
    let mut given = nominal.clone();
    if let Some(bike) = &variation.bike {
        given.bike = bike.clone();
        given.drag = bike.drag;
        given.rolling = bike.rolling_resistance;
        given.radius = [bike.front.radius, bike.rear.radius];
    }
    if let Some(zeros) = variation.zeros {
        given.zeros = zeros;
    }
    let (radius, resistance) =
        coasting::refit(&data.coast, &data.front_rolling, &given, &fits.coasting);
    for k in 0..2 {
        given.radius[k] = radius[k].unwrap_or(given.radius[k]) + variation.coast[k];
    }
    if let Some([drag, rolling]) = resistance {
        given.drag = drag;
        given.rolling = rolling;
    }
    given.drag += variation.coast[2];
    given.rolling += variation.coast[3];

    let friction = [0, 1].map(|k| {
        let fitted = fits.friction[k].as_ref()?;
        let signals = given.straight(&data.straight[k], &data.action[k]);
        let all = &thin.straight[k];
        let mut rows = friction_rows(data, &signals, k, all, &fits.coasting, config);
        rows.both_signs = clouds.friction[k].both_signs;
        let theta = fitted.follow(&rows);
        // a curve without a peak still has its factors
        let peak = thin.peak[k].as_ref().map(|(peak, gradient)| {
            let changes = theta.iter().zip(&fitted.theta).zip(gradient);
            peak + changes.map(|((now, then), g)| (now - then) * g).sum::<f64>()
        });
        Some((theta, peak))
    });
    let keep = &clouds.keep;
    let overturning = fits.overturning.as_ref().and_then(|fitted| {
        let signals = given.corner(&thin.steady, data.corner_rate, None);
        let (lever, moment) = (&signals.overturning_lever, &signals.overturning);
        clustered_fit::refit(&[lever], moment, &fitted.weights).map(|t| t[0])
    });
    let crown = front_crown(overturning, &given);
    let signals = given.corner(&data.corner, data.corner_rate, crown);
    let lateral = [0, 1].map(|k| {
        let ratio = given.bike.wheel(Axle::BOTH[k]).side_force_ratio;
        let rows = cornering::rows(&signals, &data.corner.segment, keep, k, ratio);
        cornering::refit(&rows, &fits.lateral[k])
    });
    assemble(
        &given,
        [0, 1].map(|k| radius[k].unwrap_or(f64::NAN)),
        resistance,
        &friction,
        &lateral,
        overturning,
    )
}
