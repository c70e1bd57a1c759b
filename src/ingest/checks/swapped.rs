//! Exchanged wheels and exchanged brakes, also of a motorcycle ridden in gear.
//!
//! In gear the engine slows the rear wheel whenever the throttle is closed, mostly more than the front brake
//! slows the front one: which wheel turns slower under a brake tells nothing by itself.
//!
//! - *Wheels*: the more the engine drives, the faster the rear wheel turns against the front one; engine braking
//!   is the same line's other end ([`slip`](super::slip), (2)). The line rises where the wheels are exchanged.
//! - *Brakes, by the bound*: rear wheel, engine included, cannot decelerate beyond `mu g a / (l + mu h)`. A channel
//!   that alone does so is the front one's.
//! - *Brakes, by likelihood*, where nobody brakes that hard: what the wheels of a braking with one channel alone do,
//!   against what they would do under the front brake and the engine, and under the rear brake.
//!
//! ```text
//! (1)  front:  D = D_0 - (d - e) / (g K n_f) + e / (g K n_r)        rear:  D = D_0 + d / (g K n_r)
//! (2)  LLR = sum(min(z_r², 9) - min(z_f², 9)) / 6                   z: residuals over their sd
//! ```
//! with the deceleration `d` by the tyres and `e` that of the engine, from the unbraked ride with a closed throttle.
//! What stays undecided is no finding.

use super::finding::{Finding, Findings};
use super::slip::{Free, Motion};
use super::view::{MIN_MEANS, View, quantile};
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::rejection::RejectionCode;
use crate::ingest::error::Error;
use crate::motorcycle::balance::{LARGEST_FRICTION, USUAL_SLIP_STIFFNESS};

/// Means with one brake alone that the bound is judged by: 2 s.
const ENOUGH: usize = 10;
/// Standard errors that make evidence.
const SURE: f64 = 5.0;
/// A slope of slip over force below this is no evidence, as a share of that of [`USUAL_SLIP_STIFFNESS`].
const LEAST_SLOPE: f64 = 0.2;
/// The force must vary by this much, m/s².
const LEAST_RANGE: f64 = 1.5;
/// Sum of (2) that decides, and what one braking may add.
const DECIDED: (f64, f64) = (6.0, 5.0);
/// Decelerations below this say nothing, m/s².
const LEAST_BRAKING: f64 = 1.0;
/// Standard deviation of `D`: wheel speeds and radii; and of a predicted slip, relative.
const SLIP_ERROR: (f64, f64) = (0.004, 0.25);
/// Speeds this near to each other have the same engine braking, relative.
const SPEED_TOLERANCE: f64 = 0.3;
/// Standard deviation of the engine's deceleration, relative and in m/s².
const ENGINE_ERROR: (f64, f64) = (0.3, 0.3);

pub(crate) fn check(view: &View, bike: &Bike, out: &mut Findings<'_>) -> Result<(), Error> {
    let Some(motion) = Motion::new(view, bike) else { return Ok(()) };
    let free = motion.free(view);
    let usual = -1.0 / (GRAVITY * USUAL_SLIP_STIFFNESS * motion.loads(0.0)[1]);
    if let Some(free) = free.filter(|f| exchanged(f, usual)) {
        out.push(Finding {
            code: RejectionCode::WheelsSwapped,
            channel: Channel::WheelSpeedFront,
            count: free.n,
            message: format!(
                "wheel_speed_front and wheel_speed_rear seem exchanged: per m/s2 of drive the \
                 front wheel gains {:+.2} % on the rear one (+-{:.2} %), although the driven wheel \
                 must gain; exchange them in the channel map",
                100.0 * free.by_force,
                100.0 * free.error
            ),
        })?;
    }
    brakes(view, &motion, free, usual, out)
}

/// Whether slip over force has the slope of exchanged wheels.
fn exchanged(free: &Free, usual: f64) -> bool {
    let [low, high] = free.range;
    let [least, most] = [LEAST_SLOPE, 5.0].map(|x| -x * usual);
    high - low > LEAST_RANGE
        && (least..most).contains(&free.by_force)
        && free.by_force > SURE * free.error
}

fn brakes(
    view: &View,
    motion: &Motion<'_>,
    free: Option<Free>,
    usual: f64,
    out: &mut Findings<'_>,
) -> Result<(), Error> {
    const NAMES: [Channel; 2] = [Channel::BrakePressureFront, Channel::BrakePressureRear];
    let limit = motion.rear_limit();
    let hardest = [0, 1].map(|brake| {
        let mut d = view.moving(|i| match motion.alone(i) {
            Some(alone) if alone == brake => -motion.force[i],
            _ => f64::NAN,
        });
        (d.len() >= ENOUGH).then(|| (quantile(&mut d, 0.9), d.len()))
    });
    let beyond = hardest.map(|d| d.filter(|d| d.0 > limit));
    let bound = format!(
        "rear brake and engine together give {limit:.1} m/s2 at most (friction {LARGEST_FRICTION}, the bike \
         file's wheelbase and centre of mass)"
    );
    match beyond {
        [Some((front, n)), Some((rear, m))] => out.push(Finding {
            code: RejectionCode::BrakesUnclear,
            channel: NAMES[1],
            count: n + m,
            message: format!(
                "with brake_pressure_front alone it decelerates by {front:.1} m/s2, with \
                 brake_pressure_rear alone by {rear:.1}, but {bound}: linked brakes, a pressure of \
                 both circuits, or wrong numbers in the bike file? Which brake is which was not checked"
            ),
        }),
        [Some(_), None] => Ok(()),
        [None, Some((rear, n))] => out.push(Finding {
            code: RejectionCode::BrakesSwapped,
            channel: NAMES[1],
            count: n,
            message: format!(
                "brake_pressure_front and brake_pressure_rear seem exchanged: with \
                 brake_pressure_rear alone it decelerates by {rear:.1} m/s2, but {bound}; exchange \
                 them in the channel map"
            ),
        }),
        [None, None] => {
            let Some(free) = free else { return Ok(()) };
            let evidence = likelihood(view, motion, free, usual);
            if evidence.sum > -DECIDED.0 {
                return Ok(());
            }
            out.push(Finding {
                code: RejectionCode::BrakesSwapped,
                channel: NAMES[1],
                count: evidence.n,
                message: format!(
                    "brake_pressure_front and brake_pressure_rear seem exchanged: in {} stops with \
                     one of them alone the wheels turn as they do under the other brake (log \
                     likelihood ratio {:.1}, {:.0} decides); exchange them in the channel map",
                    evidence.brakings, -evidence.sum, DECIDED.0
                ),
            })
        }
    }
}

/// Evidence of the wheels about the brakes.
#[derive(Debug, Default)]
struct Evidence {
    /// Sum of (2) over the braking manoeuvres; positive where the channels are what their names say.
    sum: f64,
    brakings: usize,
    n: usize,
}

fn likelihood(view: &View, motion: &Motion<'_>, free: Free, usual: f64) -> Evidence {
    // a slope of no use: that of a usual tyre, the wheels in between as they are
    let plausible = (5.0 * usual..LEAST_SLOPE * usual).contains(&free.by_force)
        && free.by_force < -2.0 * free.error;
    let by_force = if plausible { free.by_force } else { usual };
    let engine = engine(view, motion);
    let mut all = Evidence::default();
    let mut i = 0;
    while i < view.len() {
        let Some(brake) = motion.alone(i) else {
            i += 1;
            continue;
        };
        let (mut llr, mut n) = (0.0, 0);
        while i < view.len() && motion.alone(i) == Some(brake) {
            let (d, slip) = (-motion.force[i], motion.slip[i]);
            // where it is not known what the engine does, the rear wheel's slip tells nothing
            if d > LEAST_BRAKING
                && slip.abs() < 0.2
                && let Some(engine) = engine(i)
            {
                let zero = free.zero + free.by_speed * motion.v[i].powi(2);
                llr += ratio(motion, slip - zero, d, engine.min(d), by_force / usual) / 6.0;
                n += 1;
            }
            i += 1;
        }
        if n > 0 {
            let sign = if brake == 0 { 1.0 } else { -1.0 };
            all.sum += sign * llr.clamp(-DECIDED.1, DECIDED.1);
            all.brakings += 1;
            all.n += n;
        }
    }
    all
}

/// `min(z_r², 9) - min(z_f², 9)` of one mean: positive for the front brake. `softness` is the tyres' slip per
/// force over that of [`USUAL_SLIP_STIFFNESS`].
fn ratio(motion: &Motion<'_>, slip: f64, d: f64, engine: f64, softness: f64) -> f64 {
    let [front, rear] = motion.loads(-d).map(|n| softness / (GRAVITY * USUAL_SLIP_STIFFNESS * n));
    let (by_front, by_rear) = ((engine - d) * front + engine * rear, d * rear);
    let engine_error = (ENGINE_ERROR.0 * engine).hypot(ENGINE_ERROR.1) * (front + rear);
    let tyres = SLIP_ERROR.1 * by_front.abs().max(by_rear.abs());
    let sd = SLIP_ERROR.0.hypot(tyres).hypot(engine_error);
    let z2 = |expected: f64| ((slip - expected) / sd).powi(2).min(9.0);
    z2(by_rear) - z2(by_front)
}

/// Deceleration by the engine at a mean, m/s²: what the unbraked ride with a closed throttle does at speeds near
/// that, `None` where there is none; the throttle counts as closed where there is none and it does not drive.
fn engine<'a>(view: &View, motion: &'a Motion<'a>) -> impl Fn(usize) -> Option<f64> + 'a {
    let closed = |i: usize| match &motion.closed {
        Some(closed) => closed[i.saturating_sub(2)..(i + 3).min(closed.len())].iter().all(|c| *c),
        None => motion.force[i] < -0.1,
    };
    let free = |i: usize| motion.unbraked(i) && closed(i) && motion.force[i].is_finite();
    let at = view.moving(|i| if free(i) { i as f64 } else { f64::NAN });
    let mut samples: Vec<(f64, f64)> =
        at.into_iter().map(|i| (motion.v[i as usize], -motion.force[i as usize])).collect();
    samples.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    move |i| {
        // the twenty at speeds nearest to this one
        let (v, half) = (motion.v[i], MIN_MEANS / 2);
        let last = samples.len().checked_sub(MIN_MEANS)?;
        let start = samples.partition_point(|s| s.0 < v).saturating_sub(half).min(last);
        let near = &samples[start..start + MIN_MEANS];
        let middle = near[half].0;
        if (middle / v - 1.0).abs() > SPEED_TOLERANCE {
            return None;
        }
        let mut taken: Vec<f64> = near.iter().map(|s| s.1).collect();
        Some(quantile(&mut taken, 0.5).max(0.0))
    }
}
