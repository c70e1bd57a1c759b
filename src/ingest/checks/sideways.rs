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
//! the acceleration, each held by what is usual. On 33 rides of three simulated motorcycles `b` is 0.39 to 1.03, turned
//! round -1.03 to -0.39, of km/h read as m/s 2.8 to 3.7. Noise of the accelerometer and filters make it smaller (-0.26 at
//! least, of a velocity filtered over 1 s): a scale that is too small is not seen.

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
const MIN_MEANS: usize = 100;
/// Standard errors that a sign and a scale are sure by, and `b` from which on they are: filters and delays of the channels
/// are not in the errors.
const TURNED: (f64, f64) = (3.0, -0.33);
const LARGE: (f64, f64) = (2.0, 2.2);

/// `b` and its standard error.
#[derive(Debug, Clone, Copy)]
struct Scale {
    value: f64,
    error: f64,
}

impl Scale {
    fn is_large(self) -> bool {
        self.value > LARGE.1 && self.value - LARGE.0 * self.error > 1.5
    }

    fn is_turned(self) -> bool {
        self.value < TURNED.1 && self.value + TURNED.0 * self.error < 0.0
    }
}

pub(crate) fn check(view: &View, out: &mut Findings<'_>) -> Result<(), Error> {
    use Channel::{AccelerationY, Roll, VelocityX, VelocityY, YawRate};
    // what others contradict is no witness
    if [VelocityX, VelocityY, AccelerationY, YawRate, Roll].iter().any(|c| out.concern(*c)) {
        return Ok(());
    }
    let Some(rows) = rows(view).filter(|rows| rows.len() >= MIN_MEANS) else { return Ok(()) };
    let Some(scale) = solved(view, &rows) else { return Ok(()) };
    let (code, what) = if scale.is_turned() {
        (RejectionCode::SignVelocityY, "its sign is wrong; turn it")
    } else if scale.is_large() {
        (RejectionCode::ScaleVelocityY, "check its unit")
    } else {
        return Ok(());
    };
    let (value, half) = (scale.value, LARGE.0 * scale.error);
    out.push(Finding {
        code,
        channel: VelocityY,
        count: rows.len(),
        message: format!(
            "velocity_y changes {value:.2} +- {half:.2} times as acceleration_y and yaw_rate say: {what} in the channel map"
        ),
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
