//! What the tyres were used for, sample by sample: the horizontal force on both together over the weight.
//!
//! ```text
//! used = sqrt((a_x + grade g + drag v^2 / m + rolling g)^2 + a_y^2) / g
//! ```
//! Where neither altitude nor climb shows the grade it is left out; it adds its own size, a hundredth for one per cent.

use std::f64::consts::FRAC_PI_2;

use super::ground::{Ground, MOVING};
use crate::GRAVITY;
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::coefficient::Coefficient as C;
use crate::contract::session::Session;
use crate::statistics::order::quantile;
use crate::store::tables::rows::{Coefficient, Status};

/// Half the time over which a speed's change is taken, s.
const HALF: f64 = 0.2;
/// Share of the moving samples below what the tyres have shown.
const SHOWN: f64 = 0.999;

/// Signals of a ride, one value per sample; NaN where there is none.
#[derive(Debug, Clone)]
pub(crate) struct Grip {
    /// Forward acceleration, m/s².
    pub along: Vec<f64>,
    /// Lateral acceleration, positive to the left, m/s².
    pub across: Vec<f64>,
    /// Lean, rad; negative in a left-hand corner.
    pub roll: Option<Vec<f64>>,
    /// Horizontal tyre force over weight.
    pub used: Vec<f64>,
    /// Available friction of both tyres.
    pub available: Option<Available>,
}

/// Available friction of the tyres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Available {
    /// Horizontal force over weight.
    pub friction: f64,
    /// How it is known.
    pub basis: Basis,
}

/// How available friction is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Basis {
    /// Both tyres' peak friction was determined.
    Tyres,
    /// The most that this ride has shown: the tyres can do that at least.
    Shown,
}

impl Basis {
    /// As in the table.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Basis::Tyres => "tyres",
            Basis::Shown => "shown",
        }
    }
}

/// Known properties of the ride before its laps.
#[derive(Debug)]
pub(crate) struct RideEstimates<'a> {
    pub bike: &'a Bike,
    /// Coefficients from the ride.
    pub coefficients: &'a [Coefficient],
    /// Rolling radii, front and rear, m.
    pub radius: [f64; 2],
    /// Drag, kg/m.
    pub drag: f64,
    /// Zero of the lean, rad.
    pub roll_zero: f64,
    /// How late speed and position are after the other channels, s.
    pub latency: f64,
}

impl RideEstimates<'_> {
    fn value(&self, tyre: &str, coefficient: C) -> Option<f64> {
        let own = |c: &&Coefficient| {
            c.tyre == tyre && c.coefficient == coefficient.name() && c.status == Status::Ok
        };
        self.coefficients.iter().find(own)?.value
    }
}

impl Grip {
    /// From a ride and its positions.
    pub(crate) fn new(session: &Session, ground: &Ground, known: &RideEstimates<'_>) -> Self {
        let late = (known.latency * session.rate).round().max(0.0) as usize;
        // of the same moment: what comes with the position is late
        let early = |x: &[f64]| -> Vec<f64> {
            (0..x.len()).map(|i| x.get(i + late).copied().unwrap_or(f64::NAN)).collect()
        };
        let bike = known.bike;
        let speed = early(&ground.speed);
        // the front wheel: no engine drives it, and it is not late
        let wheel = session.get(Channel::WheelSpeedFront);
        let along = match (session.get(Channel::AccelerationX), wheel) {
            (Some(a), _) => a.to_vec(),
            (None, Some(wheel)) => {
                slope(wheel, session.rate).iter().map(|w| known.radius[0] * w).collect()
            }
            (None, None) => slope(&speed, session.rate),
        };
        let roll: Option<Vec<f64>> =
            session.get(Channel::Roll).map(|x| x.iter().map(|r| r - known.roll_zero).collect());
        let across: Vec<f64> = match (session.get(Channel::AccelerationY), &roll) {
            (Some(a), _) => a.to_vec(),
            (None, Some(roll)) => {
                let crown = crown(known);
                let height = bike.cg_height - crown;
                let lateral = |r: &f64| {
                    let r = r.clamp(-FRAC_PI_2, FRAC_PI_2);
                    -GRAVITY * height * r.sin() / (height * r.cos() + crown)
                };
                roll.iter().map(lateral).collect()
            }
            (None, None) => {
                let turn = match session.get(Channel::YawRate) {
                    Some(rate) => rate.to_vec(),
                    None => early(&course(ground)),
                };
                turn.iter().zip(&speed).map(|(w, v)| w * v).collect()
            }
        };
        let drag = known.drag / bike.mass;
        let rolling = bike.rolling_resistance * GRAVITY;
        let grade = session.get(Channel::Grade);
        let uphill =
            |i: usize| grade.map_or(0.0, |x| if x[i].is_finite() { GRAVITY * x[i] } else { 0.0 });
        let used: Vec<f64> = (0..session.len)
            .map(|i| {
                let pull = along[i] + uphill(i) + drag * speed[i] * speed[i] + rolling;
                pull.hypot(across[i]) / GRAVITY
            })
            .collect();
        let available = available(known, &used, &speed);
        // back to the clock of the positions
        let to_position = |x: &[f64]| -> Vec<f64> {
            (0..x.len()).map(|i| i.checked_sub(late).map_or(f64::NAN, |k| x[k])).collect()
        };
        Grip {
            along: to_position(&along),
            across: to_position(&across),
            roll: roll.map(|r| to_position(&r)),
            used: to_position(&used),
            available,
        }
    }
}

fn available(known: &RideEstimates<'_>, used: &[f64], speed: &[f64]) -> Option<Available> {
    let peaks = ["front", "rear"].map(|tyre| known.value(tyre, C::MfD));
    if let [Some(front), Some(rear)] = peaks {
        let share = known.bike.cg_to_front / known.bike.wheelbase;
        let friction = front * (1.0 - share) + rear * share;
        return Some(Available { friction, basis: Basis::Tyres });
    }
    let moving = used.iter().zip(speed).filter(|(u, v)| u.is_finite() && **v > MOVING);
    let mut moving: Vec<f64> = moving.map(|(u, _)| *u).collect();
    let friction = quantile(&mut moving, SHOWN).filter(|f| *f > 0.1)?;
    Some(Available { friction, basis: Basis::Shown })
}

/// Crown radius, the mean of both tyres: determined, else half the width.
fn crown(known: &RideEstimates<'_>) -> f64 {
    let bike = known.bike;
    let of =
        |tyre: &str, width: f64| known.value(tyre, C::OverturningStiffness).unwrap_or(0.5 * width);
    let mean = 0.5 * (of("front", bike.front.width) + of("rear", bike.rear.width));
    mean.clamp(0.0, 0.5 * bike.cg_height)
}

/// Rate of turn of the track, rad/s, left positive.
fn course(ground: &Ground) -> Vec<f64> {
    let reach = (0.5 * ground.rate).ceil() as usize;
    let turn = |i: usize| {
        let (a, b) = (ground.direction(i.checked_sub(reach)?)?, ground.direction(i + reach)?);
        let (sin, cos) = (a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
        Some(sin.atan2(cos) * ground.rate / (2 * reach) as f64)
    };
    let last = ground.samples().saturating_sub(reach);
    (0..ground.samples())
        .map(|i| if i < last { turn(i) } else { None }.unwrap_or(f64::NAN))
        .collect()
}

/// Slope of the least-squares line over [`HALF`] to each side, per s; NaN at the ends.
fn slope(x: &[f64], rate: f64) -> Vec<f64> {
    let half = ((HALF * rate).round() as usize).max(1);
    let norm: f64 = (1..=half).map(|k| 2.0 * (k * k) as f64).sum();
    let at = |i: usize| {
        if i < half || i + half >= x.len() {
            return f64::NAN;
        }
        (1..=half).map(|k| k as f64 * (x[i + k] - x[i - k])).sum::<f64>() / norm * rate
    };
    (0..x.len()).map(at).collect()
}
