//! Lateral velocity against the lateral acceleration and the yaw rate.
//!
//! ```text
//! d(v_y)/dt = a_y - v_x r
//! ```
//! The difference on the right is small beside both of its terms, so it is integrated, with forgetting (`W`), and so is
//! what is not known of it:
//!
//! ```text
//! W d(v_y) = b W(a_y - v_x r) + k W(v_x r) + h W d(roll rate) + l W d(r) + z W(1)
//! ```
//! `b` is 1 where the channel is right; `k` is the error of scales, `h` and `l` the place of the sensor, `z` the zero of
//! the acceleration, each held by what is usual. On rides of both simulators `b` is 0.4 to 1.03, turned round -1.03 to
//! -0.4, of km/h read as m/s 2.8 to 3.7. Noise of the accelerometer makes `b` smaller, so that a scale that is too small
//! is judged by the same equation solved for the right side, which only noise of the velocity makes smaller.

use nalgebra::{SMatrix, SVector};

use super::finding::{Finding, Findings};
use super::view::{MOVING, View};
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::statistics::order::median_of_finite;

/// Time over which the integral forgets, s.
const FORGETS: f64 = 1.0;
/// Times of that until it has forgotten where it began.
const SETTLED: f64 = 3.0;
/// Standard deviations of `k` (a share), `h` (m), `l` (m) and `z` (m/s²) before the ride.
const USUAL: [f64; 4] = [0.03, 0.3, 0.1, 0.3];
/// Rounds of reweighting, and residuals over their scatter from which a mean weighs less.
const ROUNDS: usize = 15;
const CLIP: f64 = 2.0;
/// Least scatter of the residuals, m/s.
const LEAST: f64 = 0.01;
/// Fewest means: 20 s.
const FEWEST: usize = 100;
/// Standard errors that a sign and a scale are sure by: filters and delays of the channels are not in them.
const SURE: [f64; 2] = [3.0, 2.0];
/// Below which `b` the sign is wrong: filters make a right one -0.25 at least.
const TURNED: f64 = -0.3;
/// From which `b` on the velocity is too large, and from which its inverse on too small; what they must be at least.
const LARGE: [f64; 2] = [2.4, 3.0];
const AT_LEAST: f64 = 1.8;
/// Least product of both (a squared correlation): below it they do not go together.
const TOGETHER: f64 = 0.1;

/// `b`, or its inverse, and its standard error.
#[derive(Debug, Clone, Copy)]
struct Scale {
    value: f64,
    error: f64,
}

impl Scale {
    fn is_large(self, limit: f64) -> bool {
        self.value > limit && self.value - SURE[1] * self.error > AT_LEAST
    }

    fn is_negative(self) -> bool {
        self.value + SURE[0] * self.error < 0.0
    }
}

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    use Channel::{AccelerationY, Roll, VelocityX, VelocityY, YawRate};
    // what others contradict is no witness
    if [VelocityX, VelocityY, AccelerationY, YawRate, Roll].iter().any(|c| out.concern(*c)) {
        return Ok(());
    }
    let Some(rows) = rows(view).filter(|rows| rows.len() >= FEWEST) else { return Ok(()) };
    let exchanged: Vec<Row> = rows
        .iter()
        .map(|(y, [x, rest @ ..])| {
            let [a, b, c, d] = *rest;
            (*x, [*y, a, b, c, d])
        })
        .collect();
    let (Some(scale), Some(inverse)) = (solved(view, &rows), solved(view, &exchanged)) else {
        return Ok(());
    };
    if scale.value * inverse.value < TOGETHER {
        return Ok(());
    }
    let seen = |s: Scale| format!("{:.2} +- {:.2} times", s.value, SURE[1] * s.error);
    let is_turned = scale.value < TURNED && scale.is_negative() && inverse.is_negative();
    let (code, message) = if is_turned {
        let seen = seen(scale);
        let message = format!(
            "velocity_y changes {seen} as acceleration_y and yaw_rate say: its sign is wrong; turn it"
        );
        (RejectionCode::SignVelocityY, message)
    } else if scale.is_large(LARGE[0]) {
        let seen = seen(scale);
        let message =
            format!("velocity_y changes {seen} as acceleration_y and yaw_rate say: check its unit");
        (RejectionCode::ScaleVelocityY, message)
    } else if inverse.is_large(LARGE[1]) {
        let seen = seen(inverse);
        let message = format!(
            "acceleration_y and yaw_rate say {seen} the change of velocity_y: check its unit"
        );
        (RejectionCode::ScaleVelocityY, message)
    } else {
        return Ok(());
    };
    out.push(Finding {
        code,
        channel: VelocityY,
        count: rows.len(),
        message: format!("{message} in the channel map"),
    })
}

/// One mean's row: what is known of `v_y`, and what it may be of.
type Row = (f64, [f64; 5]);

/// The first coefficient of the rows.
fn solved(view: &View, rows: &[Row]) -> Option<Scale> {
    // neighbours share what the integral has not forgotten
    let alike = 2.0 * FORGETS / view.step();
    let mut weights = vec![1.0; rows.len()];
    let mut scatter = rms(rows.iter().map(|r| r.0));
    let mut found = None;
    for _ in 0..ROUNDS {
        let mut normal = SMatrix::<f64, 5, 5>::zeros();
        let mut right = SVector::<f64, 5>::zeros();
        for ((y, x), w) in rows.iter().zip(&weights) {
            let x = SVector::from(*x);
            normal += *w * x * x.transpose();
            right += *w * *y * x;
        }
        for (k, usual) in USUAL.iter().enumerate() {
            normal[(k + 1, k + 1)] += alike * (scatter / usual).powi(2);
        }
        let inverse = normal.cholesky()?.inverse();
        let solution = inverse * right;
        let left: Vec<f64> =
            rows.iter().map(|(y, x)| y - SVector::from(*x).dot(&solution)).collect();
        let sizes: Vec<f64> = left.iter().map(|e| e.abs()).collect();
        scatter = (1.4826 * median_of_finite(&sizes)?).max(LEAST);
        for (w, e) in weights.iter_mut().zip(&left) {
            *w = (CLIP * scatter / e.abs()).min(1.0);
        }
        let error = scatter * (alike * inverse[(0, 0)]).sqrt();
        found = Some(Scale { value: solution[0], error });
    }
    found.filter(|s| s.value.is_finite() && s.error.is_finite())
}

fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0_usize), |(sum, n), x| (sum + x * x, n + 1));
    (sum / n.max(1) as f64).sqrt().max(LEAST)
}

/// The rows of all means that move and are settled.
fn rows(view: &View) -> Option<Vec<Row>> {
    let get = |channel| view.get(channel);
    let (v, vy) = (get(Channel::VelocityX)?, get(Channel::VelocityY)?);
    let (ay, r) = (get(Channel::AccelerationY)?, get(Channel::YawRate)?);
    let roll = get(Channel::Roll)?;
    let step = view.step();
    let keep = (-step / FORGETS).exp();
    let settled = (SETTLED * FORGETS / step).ceil() as usize;
    let mut rows = Vec::new();
    // of the row's quantities the first, fourth and fifth are differences, the others integrals
    let mut sums = [0.0; 6];
    let mut since = 0;
    for i in 2..v.len().saturating_sub(1) {
        let at = |i: usize| [ay[i] - v[i] * r[i], v[i] * r[i]];
        let roll_rate = |i: usize| (roll[i + 1] - roll[i - 1]) / (2.0 * step);
        let [[net, turn], [net_before, turn_before]] = [at(i), at(i - 1)];
        let steps = [
            vy[i] - vy[i - 1],
            0.5 * step * (net + net_before),
            0.5 * step * (turn + turn_before),
            roll_rate(i) - roll_rate(i - 1),
            r[i] - r[i - 1],
            step,
        ];
        if steps.iter().any(|x| !x.is_finite()) || v[i] < MOVING {
            (sums, since) = ([0.0; 6], 0);
            continue;
        }
        since += 1;
        for (sum, step) in sums.iter_mut().zip(steps) {
            *sum = keep * *sum + step;
        }
        if since > settled {
            let [y, x @ ..] = sums;
            rows.push((y, x));
        }
    }
    Some(rows)
}
