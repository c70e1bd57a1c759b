//! Zeros of the sensors, and the latency of the velocity.
//!
//! A steering zero of 0.1 degrees is a tenth of a front slip angle at 30 degrees of lean; a
//! latency of 10 ms under full braking is a slip of 1 %. The ride itself determines them:
//!
//! - latency and the zero of `acceleration_x`: `v' = a_x + psi' v_y` (inertial unit against
//!   satellite velocity), but for what an inertial unit above reads of a frame that begins to pitch;
//! - the zero of `yaw_rate`: the change of heading over the ride, else standstill;
//! - the zero of `roll`: straight running, `phi = -v psi' / g` on average;
//! - the zeros of `velocity_y` and steering: straight running, where slip angles are zero.
//!
//! Each comes with its standard error, which the fits pass on.

use super::measured::SLIP_ANGLE_ZERO;
use super::samples::SLIP_ANGLE;
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::contract::warning::Warning;
use crate::statistics::bisquare::{self, Options};
use crate::statistics::cluster_covariance::{Scores, sandwich};
use crate::statistics::order::upper_median;
use crate::tyre::kinematics::kinematic_steer;

use crate::tyre::formulation::Formulation::Corrected;

/// An error of lateral velocity at an axle, `constant + angle v`, with its covariance.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LateralZero {
    /// Constant part, m/s.
    pub constant: f64,
    /// Part in proportion to speed, rad.
    pub angle: f64,
    /// Variances and covariance `[cc, ca, aa]`.
    pub covariance: [f64; 3],
}

/// The zeros of one session.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Zeros {
    /// Lag of the velocity channels, s.
    pub latency: f64,
    /// Standard error of the latency, s.
    pub latency_se: f64,
    /// Zero of `acceleration_x`, m/s².
    pub acceleration_x: f64,
    /// Whether that zero was found; without it the change of speed stands for the acceleration.
    pub acceleration_known: bool,
    /// Standard error of that zero, m/s².
    pub acceleration_x_se: f64,
    /// Zero of `pitch`, rad: its value on straights without acceleration.
    pub pitch: f64,
    /// Zero of `yaw_rate`, rad/s.
    pub yaw_rate: f64,
    /// Zero of `roll`, rad.
    pub roll: f64,
    /// Standard error of that zero, rad.
    pub roll_se: f64,
    /// Error of the lateral velocity over the front wheel, steering zero included.
    pub front: LateralZero,
    /// Error of the lateral velocity over the rear wheel.
    pub rear: LateralZero,
    /// Whether there was enough straight running for the lateral zeros.
    pub lateral_known: bool,
    /// Error of the side slip per lean, common to both axles.
    pub slip_of_lean: f64,
    /// Its standard error: that of an estimated lateral velocity, which keeps its error for corners on end.
    pub slip_of_lean_se: f64,
    /// Zeros of measured slip angles, front and rear, rad: their values in straight running.
    pub slip_angle: [f64; 2],
    pub slip_angle_se: [f64; 2],
}

/// Smallest latency that is acted upon, s.
const MIN_LATENCY: f64 = 1e-3;
/// Largest latency that is looked for, s.
const MAX_LATENCY: f64 = 0.4;
/// Evidence, in squares of a standard deviation, below which a lag of more than a sample counts as chance. Rides without braking
/// have a best lag by chance: 129 ms with an evidence of 7 in one of three. A latency of 80 ms in a ride with stops has 1,300.
const FAR_EVIDENCE: f64 = 25.0;

/// Rolling faster than this over 0.6 s the bike is about to turn, rad/s: then roll leads yaw, to
/// the same side whether it leans in or out, and the roll zero would be biased.
const MAX_ROLL_RATE: f64 = 0.03;

/// Longest block of straight running, s.
const BLOCK: f64 = 5.0;

/// Speed changes slower than this, m/s², count as none for the pitch zero.
const STEADY: f64 = 0.6;

/// Median pitch of straight, steady running; zero where there is too little of it.
fn pitch_zero(v: &[f64], pitch: &[f64], turn: &[f64], coarse: &Coarse) -> f64 {
    let near = (0.3 * coarse.rate).round() as usize;
    let mut found: Vec<f64> = (near..v.len().saturating_sub(near))
        .filter(|&i| {
            let change = (v[i + near] - v[i - near]) * coarse.rate / (2 * near) as f64;
            v[i] > 3.0 && change.abs() < STEADY && turn[i].abs() < 0.05
        })
        .map(|i| pitch[i])
        .filter(|p| p.is_finite())
        .collect();
    if (found.len() as f64) < 2.0 * coarse.rate {
        return 0.0;
    }
    upper_median(&mut found).unwrap_or(0.0)
}

/// A channel in means of consecutive samples, about `rate` Hz.
struct Coarse {
    rate: f64,
    len: usize,
    step: usize,
}

impl Coarse {
    fn new(session: &Session, rate: f64) -> Self {
        let step = (session.rate / rate).round().max(1.0) as usize;
        Coarse { rate: session.rate / step as f64, len: session.len / step, step }
    }

    fn mean(&self, x: &[f64]) -> Vec<f64> {
        x.chunks_exact(self.step).map(|c| c.iter().sum::<f64>() / c.len() as f64).collect()
    }
}

/// Central difference over two neighbours on each side, smoothing noise; NaN at the ends.
fn slope(x: &[f64], rate: f64) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    for i in 2..x.len().saturating_sub(2) {
        out[i] = rate * (2.0 * (x[i + 2] - x[i - 2]) + (x[i + 1] - x[i - 1])) / 10.0;
    }
    out
}

/// The moving average that belongs to [`slope`]: the slope of an integral, exactly.
fn smooth(x: &[f64]) -> Vec<f64> {
    let mut out = vec![f64::NAN; x.len()];
    for i in 2..x.len().saturating_sub(2) {
        // slope of the trapezoid integral: weights 2,3(+..),.. over the five samples
        let (a, b) = (x[i - 2] + x[i + 2], x[i - 1] + x[i + 1]);
        out[i] = (a + 2.5 * b + 3.0 * x[i]) / 10.0;
    }
    out
}

/// Finds the zeros of a filtered session.
pub fn run(session: &Session, bike: &Bike) -> (Zeros, Vec<Warning>) {
    let mut zeros = Zeros::default();
    let mut warnings = Vec::new();
    let coarse = Coarse::new(session, 25.0);
    let get = |channel| session.get(channel).map(|x| coarse.mean(x));
    let Some(v) = get(Channel::VelocityX) else { return (zeros, warnings) };
    let yaw_rate = get(Channel::YawRate);
    let velocity_y = get(Channel::VelocityY);

    zeros.yaw_rate = yaw_rate_zero(&v, yaw_rate.as_deref(), get(Channel::Yaw).as_deref(), &coarse);
    let turn: Vec<f64> = match &yaw_rate {
        Some(r) => r.iter().map(|r| r - zeros.yaw_rate).collect(),
        None => vec![0.0; coarse.len],
    };
    if let Some(ax) = get(Channel::AccelerationX) {
        let along: Vec<f64> = match &velocity_y {
            Some(vy) => (0..coarse.len).map(|i| ax[i] + turn[i] * vy[i]).collect(),
            None => ax,
        };
        let pitch_rate = match get(Channel::Pitch) {
            Some(pitch) => Some(slope(&pitch, coarse.rate)),
            None => get(Channel::PitchRate),
        };
        let pitching = pitch_rate.map(|rate| slope(&rate, coarse.rate));
        // leaning is turning, too
        let leaning = get(Channel::Roll).map(|roll| {
            roll.iter().zip(&v).map(|(roll, v)| GRAVITY * roll.tan() / v.max(1.0)).collect()
        });
        let turn: Option<Vec<f64>> = if yaw_rate.is_some() { Some(turn.clone()) } else { leaning };
        longitudinal(
            &v,
            &along,
            turn.as_deref(),
            pitching.as_deref(),
            &coarse,
            &mut zeros,
            &mut warnings,
        );
    }
    if let Some(pitch) = get(Channel::Pitch) {
        zeros.pitch = pitch_zero(&v, &pitch, &turn, &coarse);
    }
    if let (Some(sd), Some(roll)) = (get(Channel::VelocityYSd), get(Channel::Roll)) {
        zeros.slip_of_lean_se = slip_of_lean(&v, &sd, &roll);
    }
    let delayed =
        |x: Vec<f64>| if zeros.latency == 0.0 { x } else { shift(&x, zeros.latency * coarse.rate) };
    let v = delayed(v);
    let roll = get(Channel::Roll);
    let blocks = straight_blocks(&v, &turn, roll.as_deref(), &coarse);
    let velocity_y = velocity_y.map(delayed);
    if let Some(roll) = &roll
        && let Some((zero, se)) = roll_zero(&v, &turn, roll, &blocks)
    {
        zeros.roll = zero;
        zeros.roll_se = se;
    }
    for (k, angle) in SLIP_ANGLE.into_iter().enumerate() {
        if let Some(angle) = get(angle) {
            let lean = roll.as_ref().map(|roll| roll.iter().map(|r| r - zeros.roll).collect());
            let found = slip_angle_zero(&angle, lean, &blocks);
            (zeros.slip_angle[k], zeros.slip_angle_se[k]) = found.unwrap_or((0.0, SLIP_ANGLE_ZERO));
        }
    }
    if let (Some(vy), Some(roll), Some(_)) = (velocity_y, roll, &yaw_rate) {
        let roll_rate = get(Channel::RollRate).unwrap_or_else(|| slope(&roll, coarse.rate));
        let steer = get(Channel::SteerAngle);
        let lean = roll.iter().map(|r| r - zeros.roll).collect();
        let [front, rear] =
            Straight { v, vy, turn, lean, roll_rate, steer }.lateral_zeros(bike, &blocks);
        zeros.lateral_known = rear.is_some();
        zeros.rear = rear.unwrap_or_default();
        zeros.front = front.unwrap_or_default();
    }
    (zeros, warnings)
}

/// Standard error of the side slip per lean, from standard deviations of the lateral velocity. What is as uncertain in
/// straight running is a zero, which straight running finds; the rest is counted as if it had one sign in all left
/// corners and the other in all right ones, the worst for stiffnesses.
fn slip_of_lean(v: &[f64], sd: &[f64], roll: &[f64]) -> f64 {
    let mut straight = [0.0_f64; 2];
    let mut corner = [0.0_f64; 3];
    for ((v, sd), roll) in v.iter().zip(sd).zip(roll) {
        let square = (sd / v).powi(2);
        if *v < 5.0 || !square.is_finite() {
            continue;
        }
        if roll.abs() < 0.05 {
            straight = [straight[0] + 1.0, straight[1] + square];
        } else if roll.abs() > 0.15 {
            corner = [corner[0] + 1.0, corner[1] + square, corner[2] + roll * roll];
        }
    }
    if corner[0] < 1.0 {
        return 0.0;
    }
    let zero = if straight[0] > 0.0 { straight[1] / straight[0] } else { 0.0 };
    // at least a third of it is not of the zero's kind
    let rest = (corner[1] / corner[0] - zero).max(corner[1] / corner[0] / 9.0);
    (rest * corner[0] / corner[2]).sqrt()
}

/// Zero of `roll` and its standard error, rad: straight running, where the motorcycle leans by what
/// the turn needs.
fn roll_zero(
    v: &[f64],
    turn: &[f64],
    roll: &[f64],
    blocks: &[(usize, usize)],
) -> Option<(f64, f64)> {
    let y: Vec<f64> =
        blocks.iter().map(|&(i, _)| roll[i] + 1.08 * (v[i] * turn[i] / GRAVITY).atan()).collect();
    let ones = vec![1.0; y.len()];
    let (theta, covariance) = robust(&[&ones], &y, blocks)?;
    Some((theta[0], covariance[0].sqrt()))
}

/// Zero of a measured slip angle and its standard error, rad: straight running, where it goes with the little lean
/// there is.
fn slip_angle_zero(
    angle: &[f64],
    lean: Option<Vec<f64>>,
    blocks: &[(usize, usize)],
) -> Option<(f64, f64)> {
    let lean = lean.unwrap_or_else(|| vec![0.0; angle.len()]);
    let whole = |&(i, _): &(usize, usize)| angle[i].is_finite() && lean[i].is_finite();
    let usable: Vec<(usize, usize)> = blocks.iter().copied().filter(whole).collect();
    let y: Vec<f64> = usable.iter().map(|&(i, _)| angle[i]).collect();
    let leans: Vec<f64> = usable.iter().map(|&(i, _)| lean[i]).collect();
    let ones = vec![1.0; y.len()];
    let (theta, covariance) = robust(&[&ones, &leans], &y, &usable)?;
    Some((theta[0], covariance[0].max(0.0).sqrt()))
}

/// The coarse motion of a ride, whose straight parts show the lateral zeros.
struct Straight {
    /// V, m/s.
    v: Vec<f64>,
    /// Lateral velocity, m/s.
    vy: Vec<f64>,
    /// Yaw rate, rad/s.
    turn: Vec<f64>,
    /// Roll without its zero, rad.
    lean: Vec<f64>,
    /// Roll rate, rad/s.
    roll_rate: Vec<f64>,
    /// Handlebar angle, rad.
    steer: Option<Vec<f64>>,
}

impl Straight {
    /// Lateral velocity of the contact line below the centre of mass, m/s.
    fn below_mass_centre(&self, bike: &Bike, i: usize) -> f64 {
        let height = bike.cg_height + bike.velocity_sensor_z;
        self.vy[i] + height * self.lean[i].cos() * self.roll_rate[i]
            - bike.velocity_sensor_x * self.turn[i]
    }

    /// Errors of the lateral velocity over the front (steering zero included) and the rear wheel.
    fn lateral_zeros(&self, bike: &Bike, blocks: &[(usize, usize)]) -> [Option<LateralZero>; 2] {
        let base = |i: usize| self.below_mass_centre(bike, i);
        let usable: Vec<(usize, usize)> = blocks
            .iter()
            .copied()
            .filter(|&(i, _)| {
                base(i).is_finite() && self.steer.as_ref().is_none_or(|s| s[i].is_finite())
            })
            .collect();
        let ones = vec![1.0; usable.len()];
        let speed: Vec<f64> = usable.iter().map(|&(i, _)| self.v[i]).collect();
        let leaning: Vec<f64> = usable.iter().map(|&(i, _)| self.v[i] * self.lean[i]).collect();
        let columns: [&[f64]; 3] = [&ones, &speed, &leaning];
        let fit = |y: &[f64]| {
            robust(&columns, y, &usable).map(|(theta, c)| LateralZero {
                constant: theta[0],
                angle: theta[1],
                covariance: [c[0], c[1], c[4]],
            })
        };
        let rear: Vec<f64> =
            usable.iter().map(|&(i, _)| base(i) - bike.cg_to_rear() * self.turn[i]).collect();
        let front: Option<Vec<f64>> = self.steer.as_ref().map(|steer| {
            let at = |i: usize| {
                let delta = kinematic_steer(steer[i], self.lean[i], bike.caster_angle, Corrected);
                base(i) + bike.cg_to_front * self.turn[i] - self.v[i] * delta
            };
            usable.iter().map(|&(i, _)| at(i)).collect()
        });
        [front.and_then(|y| fit(&y)), fit(&rear)]
    }
}

/// Heading over the ride if there is one, else the mean at standstill, else nothing.
fn yaw_rate_zero(v: &[f64], rate: Option<&[f64]>, yaw: Option<&[f64]>, coarse: &Coarse) -> f64 {
    let Some(rate) = rate else { return 0.0 };
    if let Some(yaw) = yaw {
        let (mut turned, mut integral, mut time) = (0.0, 0.0, 0.0);
        for i in 1..coarse.len {
            let step = yaw[i] - yaw[i - 1];
            let both = 0.5 * (rate[i] + rate[i - 1]);
            if step.is_finite() && both.is_finite() {
                // the heading may wrap; it never turns half round in one step
                turned += (step + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU)
                    - std::f64::consts::PI;
                integral += both / coarse.rate;
                time += 1.0 / coarse.rate;
            }
        }
        if time > 30.0 {
            return (integral - turned) / time;
        }
    }
    let mut still: Vec<f64> = (0..coarse.len)
        .filter(|&i| v[i].abs() < 0.15 && rate[i].is_finite())
        .map(|i| rate[i])
        .collect();
    if still.len() as f64 > 1.5 * coarse.rate {
        return upper_median(&mut still).unwrap_or(0.0);
    }
    0.0
}

/// Latency of the velocity and zero of the acceleration.
fn longitudinal(
    v: &[f64],
    along: &[f64],
    turn: Option<&[f64]>,
    pitching: Option<&[f64]>,
    coarse: &Coarse,
    zeros: &mut Zeros,
    warnings: &mut Vec<Warning>,
) {
    let dv = slope(v, coarse.rate);
    let a = smooth(along);
    let reach = (MAX_LATENCY * coarse.rate).ceil() as usize;
    let rows: Vec<usize> = (reach..v.len().saturating_sub(reach))
        .filter(|&i| v[i] > 3.0 && dv[i].is_finite())
        .filter(|&i| (i - reach..=i + reach).all(|k| a[k].is_finite()))
        .collect();
    if (rows.len() as f64) < 20.0 * coarse.rate {
        return;
    }
    let apart = Separation { a: &a, dv: &dv, pitching, rows: &rows };
    let Some(found) = lag(&apart, reach as i64, coarse.rate) else { return };
    let Lag { latency, latency_se, .. } = found;
    let best = if found.is_certain() { found.best } else { 0 };
    if found.is_certain() && latency.abs() > MIN_LATENCY.max(2.0 * latency_se) {
        zeros.latency = latency;
        zeros.latency_se = latency_se;
        if latency.abs() > 5e-3 {
            let late = 1e3 * latency;
            let message = format!(
                "the velocity lags the acceleration by {late:.1} ms; `run` corrects this, \
                 `diagnose` lists it as `latency`"
            );
            warnings.push(noticed("velocity_latency", Channel::VelocityX, message));
        }
    }
    // the zero from straight running only: in a corner an error of the lateral velocity comes in
    let Some(turn) = turn else { return };
    let straight: Vec<usize> = rows.iter().copied().filter(|&i| turn[i].abs() < 0.1).collect();
    if (straight.len() as f64) < 10.0 * coarse.rate {
        return;
    }
    let seconds = straight.len() as f64 / coarse.rate;
    let zero = straight.iter().map(|&i| a[(i as i64 - best) as usize] - dv[i]).sum::<f64>()
        / straight.len() as f64;
    let differences: Vec<f64> =
        straight.iter().map(|&i| a[(i as i64 - best) as usize] - dv[i] - zero).collect();
    zeros.acceleration_known = true;
    zeros.acceleration_x = zero;
    zeros.acceleration_x_se = of_ends(&straight, &differences, coarse.rate) / seconds;
    if zero.abs() > 0.1 {
        let message = format!("acceleration_x reads {zero:.3} m/s² too much; corrected");
        warnings.push(noticed("acceleration_bias", Channel::AccelerationX, message));
    }
}

/// Standard error, m/s, of the integral of `differences` (m/s², mean zero; of the samples `straight`
/// at `rate` Hz).
///
/// The integral of the acceleration less the velocity's derivative is the velocity's error at both ends of each stretch.
/// The size of that error follows from the blocks of the stretches, whose integrals have two such errors each.
fn of_ends(straight: &[usize], differences: &[f64], rate: f64) -> f64 {
    let longest = (BLOCK * rate) as usize;
    let (mut blocks, mut stretches): (Vec<f64>, usize) = (Vec::new(), 0);
    let mut since = 0;
    for (k, &i) in straight.iter().enumerate() {
        let begins = k == 0 || straight[k - 1] + 1 != i;
        stretches += usize::from(begins);
        if begins || i - since >= longest {
            blocks.push(0.0);
            since = i;
        }
        if let Some(block) = blocks.last_mut() {
            *block += differences[k] / rate;
        }
    }
    // the zero is one of the blocks' degrees of freedom
    let free = blocks.len().saturating_sub(1).max(1) as f64;
    let of_both_ends = blocks.iter().map(|b| b * b).sum::<f64>() / free;
    (stretches as f64 * of_both_ends).sqrt()
}

/// How far one signal is behind another.
struct Lag {
    /// In whole samples.
    best: i64,
    /// Latency, s.
    latency: f64,
    latency_se: f64,
    /// By how many squares of a standard deviation no latency at all explains the ride worse.
    evidence: f64,
}

impl Lag {
    /// Whether it is more than the best of many lags: without braking or driving the velocity's own noise has its dip anywhere.
    fn is_certain(&self) -> bool {
        self.best.abs() <= 1 || self.evidence > FAR_EVIDENCE
    }
}

/// An acceleration and the rate of a velocity, with what an accelerometer above the place of the velocity reads of a
/// frame that begins to pitch.
///
/// METHOD: that part leads the braking, as the velocity would if it came late; 0.3 m of height without it were 7 ms.
struct Separation<'a> {
    a: &'a [f64],
    dv: &'a [f64],
    /// Pitch acceleration, on the clock of `a`; where it is not known.
    pitching: Option<&'a [f64]>,
    rows: &'a [usize],
}

impl Separation<'_> {
    /// Spread of `a(t - lag) - dv(t)` that no height of the accelerometer explains, (m/s²)².
    fn spread(&self, lag: i64) -> f64 {
        let n = self.rows.len() as f64;
        let (mut sums, mut squares, mut product) = ([0.0; 2], [0.0; 2], 0.0);
        for &i in self.rows {
            let at = (i as i64 - lag) as usize;
            let d = self.a[at] - self.dv[i];
            let q = self.pitching.map_or(0.0, |p| p[at]);
            let q = if q.is_finite() { q } else { 0.0 };
            sums = [sums[0] + d, sums[1] + q];
            squares = [squares[0] + d * d, squares[1] + q * q];
            product += d * q;
        }
        let [of_d, of_q] = [0, 1].map(|k| squares[k] / n - (sums[k] / n).powi(2));
        let both = product / n - sums[0] * sums[1] / (n * n);
        of_d - if of_q > 0.0 { both * both / of_q } else { 0.0 }
    }
}

/// The lag, of `reach` samples at most, at which `a(t - lag) - dv(t)` spreads least; `None` where the
/// two have nothing in common. `rate` in Hz.
fn lag(apart: &Separation<'_>, reach: i64, rate: f64) -> Option<Lag> {
    let n = apart.rows.len() as f64;
    let spread = |lag| apart.spread(lag);
    let best = (-reach..=reach)
        .map(|lag| (spread(lag), lag))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(0, |(_, lag)| lag);
    if best.abs() == reach {
        return None; // no dip
    }
    let (low, here, high) = (spread(best - 1), spread(best), spread(best + 1));
    let curvature = low - 2.0 * here + high;
    if curvature <= 0.0 {
        return None;
    }
    let shift = 0.5 * (low - high) / curvature;
    // residual noise is correlated over the five-sample window
    let least = (here - 0.125 * (low - high) * (low - high) / curvature).max(0.0);
    let latency_se = (5.0 * least / (0.5 * curvature) / n).sqrt() / rate;
    let evidence = (spread(0) - least) * n / (5.0 * least);
    Some(Lag { best, latency: (best as f64 + shift) / rate, latency_se, evidence })
}

fn noticed(code: &'static str, channel: Channel, message: String) -> Warning {
    Warning { stage: "estimate", code, channel: Some(channel), count: 1, time: None, message }
}

/// Reads a signal `by` samples later (it lags by that much), linearly.
fn shift(x: &[f64], by: f64) -> Vec<f64> {
    let last = x.len().saturating_sub(1);
    (0..x.len())
        .map(|i| {
            let at = (i as f64 + by).clamp(0.0, last as f64);
            let k = (at.floor() as usize).min(last.saturating_sub(1));
            let f = at - k as f64;
            x[k] + f * (x[(k + 1).min(last)] - x[k])
        })
        .collect()
}

/// Coarse samples of straight running with the number of their block (at most 5 s long).
fn straight_blocks(
    v: &[f64],
    turn: &[f64],
    roll: Option<&[f64]>,
    coarse: &Coarse,
) -> Vec<(usize, usize)> {
    let longest = (BLOCK * coarse.rate) as usize;
    let reach = (0.3 * coarse.rate).round() as usize;
    let mut rows = Vec::new();
    let (mut block, mut since) = (0, usize::MAX);
    for i in (0..coarse.len).step_by(2) {
        let straight = v[i] > 4.0
            && turn[i].abs() < 0.06
            && roll.is_none_or(|r| {
                let (before, after) = (i.saturating_sub(reach), (i + reach).min(coarse.len - 1));
                let rate = (r[after] - r[before]) * coarse.rate / (after - before).max(1) as f64;
                r[i].abs() < 0.09 && rate.abs() < MAX_ROLL_RATE
            });
        if !straight {
            since = usize::MAX;
            continue;
        }
        if since == usize::MAX || i - since >= longest {
            block += 1;
            since = i;
        }
        rows.push((i, block));
    }
    rows
}

/// Bisquare fit with its covariance from blocks, row by row; `None` where there are too few.
fn robust(x: &[&[f64]], y: &[f64], blocks: &[(usize, usize)]) -> Option<(Vec<f64>, Vec<f64>)> {
    let first = blocks.first()?.1;
    let n_blocks = blocks.last()?.1 - first + 1;
    if n_blocks < 4 + x.len() || y.len() < 50 {
        return None;
    }
    let fit = bisquare::linear(x, y, &Options { leverage: false, ..Options::default() }).ok()?;
    let jacobian = nalgebra::DMatrix::from_fn(y.len(), x.len(), |i, j| x[j][i]);
    let clusters: Vec<usize> = blocks.iter().map(|b| b.1).collect();
    let covariance = sandwich(&Scores {
        jacobian: &jacobian,
        residuals: &fit.residuals,
        weights: &fit.weights,
        psi_derivatives: Some(&fit.psi_derivatives),
        clusters: &clusters,
    })
    .ok()?;
    Some((fit.coefficients, covariance.covariance.iter().copied().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    #[test]
    fn the_error_of_the_acceleration_zero_has_both_ends_of_every_stretch() {
        let (rate, error, stretches, length) = (25.0, 0.08, 40, 250);
        let mut random = Random::new(1, "zeros");
        let (mut straight, mut differences) = (Vec::new(), Vec::new());
        for stretch in 0..stretches {
            // minus the slope of a velocity with an error that is new at every sample
            let noise: Vec<f64> = (0..=length).map(|_| error * random.normal()).collect();
            for k in 0..length {
                straight.push(stretch * (length + 10) + k);
                differences.push((noise[k] - noise[k + 1]) * rate);
            }
        }
        let mean = differences.iter().sum::<f64>() / differences.len() as f64;
        differences.iter_mut().for_each(|d| *d -= mean);
        let got = of_ends(&straight, &differences, rate);
        let want = error * (2.0 * stretches as f64).sqrt();
        assert!((got / want - 1.0).abs() < 0.25, "{got} {want}");
    }

    /// Speed held, as in a slalom: the velocity's own noise has its best lag anywhere.
    #[test]
    fn a_ride_without_braking_has_no_latency() {
        let (rate, n) = (25.0, 6000);
        let coarse = Coarse { rate, len: n, step: 1 };
        let turn = vec![0.0; n];
        let mut far = 0;
        for seed in 0..40 {
            let mut random = Random::new(seed, "latency");
            // a receiver's error lasts for a second, the accelerometer's is white
            let mut error = 0.0;
            let mut v = Vec::new();
            for i in 0..n {
                error += -error / rate + 0.05 * (2.0_f64 / rate).sqrt() * random.normal();
                v.push(15.0 + 0.3 * (i as f64 / rate / 20.0).sin() + error);
            }
            let along: Vec<f64> = (0..n).map(|_| 0.03 * random.normal()).collect();
            let mut zeros = Zeros::default();
            let mut warnings = Vec::new();
            longitudinal(&v, &along, Some(&turn), None, &coarse, &mut zeros, &mut warnings);
            far += usize::from(zeros.latency.abs() > 0.02 || !warnings.is_empty());
        }
        assert_eq!(far, 0, "rides with a latency that is none");
    }

    /// A unit 0.3 m above the place of the velocity, on a frame that follows the deceleration like a damped spring: its
    /// pitching is no latency, and a true one is found beside it.
    #[test]
    fn a_unit_above_the_velocity_is_not_taken_for_a_latency() {
        let (rate, fine, height) = (25.0, 20, 0.3);
        let (n, step) = (3000, 1.0 / (25.0 * 20.0));
        // brakes go on within 0.3 s, stay for two and are let go; 0.02 rad of pitch per m/s^2 on 1.8 Hz
        let braking = |t: f64| -6.0 * ((t % 5.0) / 0.3).min((2.3 - t % 5.0) / 0.3).clamp(0.0, 1.0);
        let (stiffness, damping) = (128.0, 9.0);
        let (mut speed, mut pitch, mut pitch_rate) = (400.0, 0.0, 0.0);
        let (mut speeds, mut along, mut angle) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..n * fine {
            let a = braking(k as f64 * step);
            let pitching = stiffness * (-0.02 * a - pitch) - damping * pitch_rate;
            if k % fine == 0 {
                along.push(a + height * pitching);
                angle.push(pitch);
            }
            speeds.push(speed);
            speed += a * step;
            pitch_rate += pitching * step;
            pitch += pitch_rate * step;
        }
        let second = slope(&slope(&angle, rate), rate);
        let turn = vec![0.0; n];
        let coarse = Coarse { rate, len: n, step: 1 };
        for late in [0_usize, 15] {
            let v: Vec<f64> = (0..n).map(|i| speeds[(i * fine).saturating_sub(late)]).collect();
            let found = |pitching: Option<&[f64]>| {
                let mut zeros = Zeros::default();
                longitudinal(
                    &v,
                    &along,
                    Some(&turn),
                    pitching,
                    &coarse,
                    &mut zeros,
                    &mut Vec::new(),
                );
                zeros.latency
            };
            let [with, without] = [found(Some(&second)), found(None)];
            let truth = late as f64 * step;
            assert!((with - truth).abs() < 2e-3, "{truth}: {with} {without}");
            assert!((without - truth).abs() > 4e-3, "{truth}: {with} {without}");
        }
    }
}
