//! Which wheel slips: the braked and the driven one, or the channels are exchanged.
//!
//! ```text
//! (1)  D = ln(omega_f / omega_r) - its median in steady straight riding
//! ```
//! Front brake alone slows the front wheel, `D < 0`; drive speeds up the rear wheel, `D < 0`.

use super::view::{FEWEST, View, quantile};
use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::ingest::error::Error;
use crate::statistics::order::SD_PER_MAD;

/// A slip difference below this is no evidence: tyres grow with speed.
const LEAST_SLIP: f64 = 0.004;
/// Nor is one above: no tyre lasts that long so.
const LARGEST_SLIP: f64 = 0.3;
/// Standard errors that make evidence.
const SURE: f64 = 5.0;
/// Lean below which radii are those of upright wheels, rad.
const UPRIGHT: f64 = 0.2;

pub(super) fn check(view: &View, bike: &Bike) -> Result<(), Error> {
    let (Some(v), Some(front), Some(rear)) = (
        view.get(Channel::VelocityX),
        view.get(Channel::WheelSpeedFront),
        view.get(Channel::WheelSpeedRear),
    ) else {
        return Ok(());
    };
    let dv = view.rate_of(v);
    let (front_brake, rear_brake) =
        (applied(view, Channel::BrakePressureFront), applied(view, Channel::BrakePressureRear));
    let straight = straight(view);
    let nominal = (bike.front.radius / bike.rear.radius).ln();
    let difference = |i: usize| {
        let ok = straight(i) && front[i] > 0.0 && rear[i] > 0.0;
        if ok { (front[i] / rear[i]).ln() + nominal } else { f64::NAN }
    };
    let only = |wanted: bool, x: f64| if wanted { x } else { f64::NAN };
    let Some(zero) = view.median(|i| only(dv[i].abs() < 0.5, difference(i))) else {
        return Ok(());
    };
    let evidence = |wanted: &dyn Fn(usize) -> bool| {
        evidence(view.moving(|i| only(wanted(i), difference(i) - zero.value)))
    };
    let free = |b: &Option<Brake>, i: usize| b.as_ref().is_none_or(|b| b.off(i));
    let driving = evidence(&|i| dv[i] > 1.0 && free(&front_brake, i) && free(&rear_brake, i));
    let braking = match (&front_brake, &rear_brake) {
        (Some(f), Some(r)) => evidence(&|i| dv[i] < -1.0 && f.on(i) && r.off(i)),
        _ => None,
    };
    let seen = |d: Option<f64>, what: &str| match d {
        Some(d) => format!("{what} the front wheel runs {:+.1} % to the rear", 100.0 * d),
        None => String::new(),
    };
    let (b, d) = (seen(braking, "under the front brake alone"), seen(driving, "under drive"));
    match (braking.map(|x| x > 0.0), driving.map(|x| x > 0.0)) {
        (Some(true), Some(false)) => Err(Error {
            code: "brakes_swapped",
            message: format!(
                "brake_pressure_front and brake_pressure_rear seem exchanged: {b}, but {d}; \
                 exchange them in the channel map"
            ),
        }),
        (Some(true), _) | (None, Some(true)) => {
            let joint = if b.is_empty() || d.is_empty() { "" } else { " and " };
            Err(Error {
                code: "wheels_swapped",
                message: format!(
                    "wheel_speed_front and wheel_speed_rear seem exchanged: {b}{joint}{d}, it \
                     must be slower there; exchange them in the channel map"
                ),
            })
        }
        _ => Ok(()),
    }
}

/// The median, if it is far enough from zero to be evidence.
fn evidence(mut d: Vec<f64>) -> Option<f64> {
    if d.len() < FEWEST / 2 {
        return None;
    }
    let median = quantile(&mut d, 0.5);
    let n = d.len() as f64;
    d.iter_mut().for_each(|x| *x = (*x - median).abs());
    let error = SD_PER_MAD * quantile(&mut d, 0.5) * (std::f64::consts::FRAC_PI_2 / n).sqrt();
    let sure = (LEAST_SLIP.max(SURE * error)..LARGEST_SLIP).contains(&median.abs());
    sure.then_some(median)
}

/// A predicate: upright at sample `i`, by the channels that are there.
fn straight(view: &View) -> impl Fn(usize) -> bool + '_ {
    let roll = view.get(Channel::Roll);
    let r = view.get(Channel::YawRate);
    move |i| {
        // a missing sample is no straight
        roll.is_none_or(|x| x[i].abs() < UPRIGHT) && r.is_none_or(|x| x[i].abs() < UPRIGHT)
    }
}

/// When a brake is on: well above its resting pressure.
struct Brake<'a> {
    pressure: &'a [f64],
    rest: f64,
    range: f64,
}

impl Brake<'_> {
    fn on(&self, i: usize) -> bool {
        self.pressure[i] > self.rest + 0.25 * self.range
    }

    fn off(&self, i: usize) -> bool {
        self.pressure[i] < self.rest + 0.05 * self.range
    }
}

fn applied(view: &View, channel: Channel) -> Option<Brake<'_>> {
    let pressure = view.get(channel)?;
    let mut p = view.moving(|i| pressure[i]);
    if p.len() < FEWEST {
        return None;
    }
    let (rest, full) = (quantile(&mut p, 0.2), quantile(&mut p, 0.998));
    // 1 bar: below it nothing brakes, and the brake was never on
    let range = if full - rest > 1e5 { full - rest } else { f64::INFINITY };
    Some(Brake { pressure, rest, range })
}
