//! Two rides of the same manoeuvre on different tyres: their peaks, and what is drawn of them.

use super::ride::{MultibodyRide, Sample};
use crate::simulate::multibody::joint;
use crate::store::tables::rows::PeakRow;

/// Which extreme of a channel counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Extreme {
    /// The largest magnitude, with its sign.
    Any,
    /// The most negative value: braking.
    Lowest,
    /// The most positive value: driving.
    Highest,
    /// The largest magnitude before the first change of the roll's sign after it began: the entry.
    Entry,
}

struct Compared {
    name: &'static str,
    unit: &'static str,
    extreme: Extreme,
    value: fn(&Sample) -> f64,
}

#[rustfmt::skip]
const CHANNELS: &[Compared] = &[
    Compared { name: "steer_torque", unit: "N m", extreme: Extreme::Any, value: |s| s.action.steer_torque },
    Compared { name: "steer_angle", unit: "rad", extreme: Extreme::Any, value: |s| s.joints[joint::STEER] },
    Compared { name: "roll", unit: "rad", extreme: Extreme::Any, value: |s| s.wheels[1].camber },
    Compared { name: "slip_ratio_rear_braking", unit: "1", extreme: Extreme::Lowest, value: |s| s.wheels[1].slip[0] },
    Compared { name: "slip_ratio_rear_driving", unit: "1", extreme: Extreme::Highest, value: |s| s.wheels[1].slip[0] },
    Compared { name: "slip_ratio_front_braking", unit: "1", extreme: Extreme::Lowest, value: |s| s.wheels[0].slip[0] },
    Compared { name: "slip_angle_front_entry", unit: "rad", extreme: Extreme::Entry, value: |s| s.wheels[0].slip[1] },
    Compared { name: "slip_angle_front", unit: "rad", extreme: Extreme::Any, value: |s| s.wheels[0].slip[1] },
    Compared { name: "slip_angle_rear", unit: "rad", extreme: Extreme::Any, value: |s| s.wheels[1].slip[1] },
    Compared { name: "force_y_front", unit: "N", extreme: Extreme::Any, value: |s| s.wheels[0].force[1] },
    Compared { name: "force_y_rear", unit: "N", extreme: Extreme::Any, value: |s| s.wheels[1].force[1] },
    Compared { name: "moment_x_front", unit: "N m", extreme: Extreme::Any, value: |s| s.wheels[0].moment_x },
    Compared { name: "moment_x_rear", unit: "N m", extreme: Extreme::Any, value: |s| s.wheels[1].moment_x },
    Compared { name: "moment_z_front", unit: "N m", extreme: Extreme::Any, value: |s| s.wheels[0].moment_z },
    Compared { name: "moment_z_rear", unit: "N m", extreme: Extreme::Any, value: |s| s.wheels[1].moment_z },
];

/// Where the first corner ends: roll has been large and changes its sign.
fn entry(samples: &[Sample]) -> usize {
    let leaned = samples.iter().position(|s| s.wheels[1].camber.abs() > 0.1).unwrap_or(0);
    let sign = samples.get(leaned).map_or(1.0, |s| s.wheels[1].camber.signum());
    let back = samples[leaned..].iter().position(|s| s.wheels[1].camber * sign < 0.0);
    back.map_or(samples.len(), |k| leaned + k)
}

/// The peak of a channel; of a sign if `sign` is not zero.
fn peak(samples: &[Sample], c: &Compared, sign: f64) -> f64 {
    let part = match c.extreme {
        Extreme::Entry => &samples[..entry(samples)],
        _ => samples,
    };
    let values = part.iter().map(c.value);
    match c.extreme {
        Extreme::Lowest => values.fold(0.0, f64::min),
        Extreme::Highest => values.fold(0.0, f64::max),
        _ if sign > 0.0 => values.fold(0.0, f64::max),
        _ if sign < 0.0 => values.fold(0.0, f64::min),
        _ => values.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a }),
    }
}

/// Which of two rides did not come to its end, how and when.
pub(crate) fn falls(reference: &MultibodyRide, other: &MultibodyRide) -> Vec<String> {
    let both = [("its own tyres", reference), ("the given tyres", other)];
    let fell = |(tyres, ride): (&str, &MultibodyRide)| {
        ride.fall.map(|fall| format!("on {tyres} the motorcycle {fall}"))
    };
    both.into_iter().filter_map(fell).collect()
}

/// Peaks of every channel: in the reference, and in the other ride of the same sign.
pub fn peaks(reference: &MultibodyRide, other: &MultibodyRide) -> Vec<PeakRow> {
    let rms = |f: fn(&Sample) -> f64| {
        let pairs = reference.samples.iter().zip(&other.samples);
        let (sum, count) = pairs
            .map(|(a, b)| (f(a) - f(b)).powi(2))
            .fold((0.0, 0.0), |(sum, count), x| (sum + x, count + 1.0));
        (sum / f64::max(count, 1.0)).sqrt()
    };
    CHANNELS
        .iter()
        .map(|c| {
            let first = peak(&reference.samples, c, 0.0);
            let second = peak(&other.samples, c, first.signum());
            PeakRow {
                channel: c.name.to_owned(),
                unit: c.unit.to_owned(),
                reference: first,
                other: second,
                error: second / first - 1.0,
                rms_difference: rms(c.value),
            }
        })
        .collect()
}

/// One quantity over time.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Quantity {
    Motorcycle(fn(&Sample) -> f64),
    /// Of the front and of the rear wheel.
    Wheels([fn(&Sample) -> f64; 2]),
}

/// Drawing of two rides: heading, unit, quantity. As in figure 4 of the paper.
#[rustfmt::skip]
pub(crate) const TRACES: &[(&str, &str, Quantity)] = &[
    ("Steering torque", "N m", Quantity::Motorcycle(|s| s.action.steer_torque)),
    ("Steering angle", "deg", Quantity::Motorcycle(|s| s.joints[joint::STEER] * DEGREE)),
    ("Slip ratio", "1", Quantity::Wheels([|s| s.wheels[0].slip[0], |s| s.wheels[1].slip[0]])),
    ("Slip angle", "deg", Quantity::Wheels([|s| s.wheels[0].slip[1] * DEGREE, |s| s.wheels[1].slip[1] * DEGREE])),
    ("Lateral force", "N", Quantity::Wheels([|s| s.wheels[0].force[1], |s| s.wheels[1].force[1]])),
    ("Load", "N", Quantity::Wheels([|s| s.wheels[0].load, |s| s.wheels[1].load])),
    ("Overturning moment", "N m", Quantity::Wheels([|s| s.wheels[0].moment_x, |s| s.wheels[1].moment_x])),
    ("Yaw moment", "N m", Quantity::Wheels([|s| s.wheels[0].moment_z, |s| s.wheels[1].moment_z])),
];

const DEGREE: f64 = 180.0 / std::f64::consts::PI;
