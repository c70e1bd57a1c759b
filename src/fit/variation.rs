//! The independent upstream uncertainties of a session's coefficients.

use super::coasting::{Coasting, DRAG, RADIUS, ROLLING};
use crate::contract::bike::{Axle, Bike};
use crate::contract::coefficient::RULE;
use crate::estimate::measured::{Quantity, SensorErrors};
use crate::estimate::zeros::{LateralZero, Zeros};
use crate::tyre::dive::PITCH_GYRATION;
use crate::tyre::formulation::Formulation;

/// Source of an error of a coefficient.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Source {
    /// Its name; the key, where it is a number of the bike file.
    pub name: String,
    /// Whether every ride of the motorcycle has the same error; else each has its own.
    pub shared: bool,
    /// The number that was taken, where it is one that can be corrected, and its standard error.
    pub taken: Option<[f64; 2]>,
}

impl Source {
    pub fn of_ride(name: impl Into<String>) -> Self {
        Source { name: name.into(), shared: false, taken: None }
    }

    /// Of all rides of a motorcycle.
    pub fn of_motorcycle(name: impl Into<String>, taken: Option<[f64; 2]>) -> Self {
        Source { name: name.into(), shared: true, taken }
    }
}

/// One upstream quantity, or one direction of correlated ones, moved by one standard error.
#[derive(Debug, Clone, Default)]
pub struct Variation {
    pub source: Source,
    /// The key that the bike file does not have, where that is what is varied.
    pub missing: Option<String>,
    /// The bike file with one of its numbers moved.
    pub bike: Option<Bike>,
    /// The sensor zeros with one of them moved.
    pub zeros: Option<Zeros>,
    /// Change of the rolling radii, m.
    pub radius: [f64; 2],
    /// Change of the drag, kg/m.
    pub drag: f64,
    /// Change of the rolling resistance.
    pub rolling: f64,
    /// Change of the pneumatic trail over that of the rule.
    pub trail_ratio: f64,
    /// Change of the pitch inertia over the mass, m².
    pub pitch_gyration: f64,
    /// Change of the true over the measured lean.
    pub roll_scale: f64,
    /// Change of the front slip angle beyond the rear one per sine of the lean, rad; moves only what has no handlebar.
    pub slip_difference: f64,
    /// Errors of the wheels' own sensors.
    pub sensors: SensorErrors,
}

/// Front slip angle beyond the rear one per sine of the lean, standard deviation, rad, an estimate: the slips of a
/// leaning motorcycle differ by what the tyres' camber forces lack or have too much, 1 to 2 degrees at 45 degrees of
/// lean.
const SLIP_DIFFERENCE: f64 = 0.03;

/// The rear crown over the front's is the ratio of the widths within this share: an estimate, tyres
/// of one set are not equally round; that of the independent simulator is 7 % off.
const CROWN_SPREAD: f64 = 0.1;

/// Lean that an attitude filter measures in a corner, beyond its zero: relative error, standard deviation. A
/// filter that leans on the accelerometer reads too little; those of a simulated population read -0.3 % with a
/// deviation of 0.4 %.
const ROLL_SCALE: f64 = 0.004;

/// Every upstream quantity in turn, one standard error up.
pub fn variations(
    bike: &Bike,
    zeros: &Zeros,
    coasting: &Coasting,
    formulation: Formulation,
    sensors: &[(Quantity, Axle)],
) -> Vec<Variation> {
    let mut out = Vec::new();
    let missing = bike.priors_of_missing();
    for (key, &sd) in bike.uncertainty.iter().filter(|(key, _)| !missing.contains_key(*key)) {
        if let (Some(value), true) = (bike.value(key), sd > 0.0) {
            let source = Source::of_motorcycle(key, Some([value, sd]));
            let moved = bike.with(key, value + sd);
            out.push(Variation { source, bike: Some(moved), ..Variation::default() });
        }
    }
    // what the ride itself gives is not taken from the bike file
    let ridden = |key: &str| key.starts_with("aerodynamics.") && coasting.resistance.is_some();
    for (key, prior) in missing.iter().filter(|(key, p)| p.sd > 0.0 && !ridden(key)) {
        let bike = Some(bike.with(key, prior.value + prior.sd));
        let source = Source::of_motorcycle(key, Some([prior.value, prior.sd]));
        out.push(Variation { source, missing: Some(key.clone()), bike, ..Variation::default() });
    }
    // the fit knows the crowns of both tyres together, (36) shares them
    let wider = bike.with("rear.width", bike.rear.width * (1.0 + CROWN_SPREAD));
    let shared = |name: &str| Source::of_motorcycle(name, None);
    let source = shared("crown_split");
    out.push(Variation { source, bike: Some(wider), ..Variation::default() });
    let trail_ratio = 0.25 * (RULE[1] - RULE[0]);
    out.push(Variation { source: shared("trail_rule"), trail_ratio, ..Variation::default() });
    if formulation == Formulation::Corrected {
        let pitch_gyration = PITCH_GYRATION[1];
        let source = Source::of_motorcycle("roll_scale", Some([1.0, ROLL_SCALE]));
        out.push(Variation { source, roll_scale: ROLL_SCALE, ..Variation::default() });
        let (source, slip_difference) = (shared("slip_difference"), SLIP_DIFFERENCE);
        out.push(Variation { source, slip_difference, ..Variation::default() });
        let source = shared("pitch_gyration");
        out.push(Variation { source, pitch_gyration, ..Variation::default() });
        for &(quantity, axle) in sensors.iter().filter(|(quantity, _)| quantity.has_scale()) {
            let channel = quantity.channels()[axle as usize];
            let source = shared(&format!("sensor_{channel}"));
            let sensors = SensorErrors::of(quantity, axle);
            out.push(Variation { source, sensors, ..Variation::default() });
        }
        let moved = zero_variations(zeros).into_iter().filter(|(_, moved)| moved != zeros);
        out.extend(moved.map(|(name, moved)| Variation {
            source: Source::of_ride(format!("zero_of_{name}")),
            zeros: Some(moved),
            ..Variation::default()
        }));
    }
    for k in 0..2 {
        if let Some(c) = coasting.radius[k].as_ref().and_then(|f| f.covariance.as_ref()) {
            let mut radius = [0.0; 2];
            radius[k] = c.covariance[(RADIUS, RADIUS)].max(0.0).sqrt();
            let source = Source::of_ride(["front_radius", "rear_radius"][k]);
            out.push(Variation { source, radius, ..Variation::default() });
        }
    }
    if let Some(c) = coasting.resistance.as_ref().and_then(|f| f.covariance.as_ref()) {
        let m = &c.covariance;
        let covariance = [m[(DRAG, DRAG)], m[(DRAG, ROLLING)], m[(ROLLING, ROLLING)]];
        for ([drag, rolling], name) in cholesky(covariance).into_iter().zip(["drag", "rolling"]) {
            let source = Source::of_ride(format!("resistance_{name}"));
            out.push(Variation { source, drag, rolling, ..Variation::default() });
        }
    }
    out
}

/// The zeros with each independent one moved by its standard error in turn, and what was moved.
fn zero_variations(zeros: &Zeros) -> Vec<(&'static str, Zeros)> {
    let mut out = vec![
        ("latency", Zeros { latency: zeros.latency + zeros.latency_se, ..*zeros }),
        (
            "acceleration_x",
            Zeros { acceleration_x: zeros.acceleration_x + zeros.acceleration_x_se, ..*zeros },
        ),
        ("roll", Zeros { roll: zeros.roll + zeros.roll_se, ..*zeros }),
        (
            "slip_of_lean",
            Zeros { slip_of_lean: zeros.slip_of_lean + zeros.slip_of_lean_se, ..*zeros },
        ),
    ];
    let front = lateral_variations(zeros.front).map(|front| Zeros { front, ..*zeros });
    let rear = lateral_variations(zeros.rear).map(|rear| Zeros { rear, ..*zeros });
    out.extend(["front_slip", "front_slip_angle"].into_iter().zip(front));
    out.extend(["rear_slip", "rear_slip_angle"].into_iter().zip(rear));
    for (k, name) in ["front_slip_sensor", "rear_slip_sensor"].into_iter().enumerate() {
        let mut moved = *zeros;
        moved.slip_angle[k] += zeros.slip_angle_se[k];
        out.push((name, moved));
    }
    out
}

fn lateral_variations(zero: LateralZero) -> [LateralZero; 2] {
    cholesky(zero.covariance).map(|[constant, angle]| LateralZero {
        constant: zero.constant + constant,
        angle: zero.angle + angle,
        ..zero
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tyre::tyre_model::USUAL_SHARE;
    use std::path::Path;

    const SHORT: &str = "mass = 260.0\nwheelbase = 1.4\ncg_to_front = 0.7\ncg_height = 0.6\n\
        caster_angle = 0.42\nfront.radius = 0.3\nfront.width = 0.12\nrear.radius = 0.31\n\
        rear.width = 0.18\n";

    fn varied(more: &str) -> Vec<Variation> {
        let bike = Bike::parse(&format!("{SHORT}{more}"), "b", Path::new("b.toml")).expect("bike");
        let (zeros, coasting) = (Zeros::default(), Coasting::default());
        variations(&bike, &zeros, &coasting, Formulation::Corrected, &[])
    }

    fn of<'a>(all: &'a [Variation], key: &str) -> Option<&'a Bike> {
        let found = all.iter().find(|v| v.missing.as_deref() == Some(key));
        found.and_then(|v| v.bike.as_ref())
    }

    #[test]
    fn what_is_not_given_is_varied_by_the_schemas_width() {
        let all = varied("");
        let bike = of(&all, "front.wheel_inertia").expect("varied");
        assert_eq!(bike.front.wheel_inertia, Some(0.45 + 0.135));
        let bike = of(&all, "rear.side_force_ratio").expect("varied");
        assert_eq!(bike.rear.side_force_ratio, 0.078 + 0.039);
        let share = of(&all, "rear.deflection_share").and_then(|b| b.rear.deflection_share);
        assert_eq!(share, Some(USUAL_SHARE + 0.1));
        assert!(of(&all, "aerodynamics.drag").is_some() && of(&all, "yaw_inertia").is_some());
    }

    #[test]
    fn what_is_given_without_uncertainty_is_exact() {
        let all = varied("front.wheel_inertia = 0.45\nrear.side_force_ratio = 0.078\n");
        assert!(of(&all, "front.wheel_inertia").is_none());
        assert!(of(&all, "rear.side_force_ratio").is_none());
        let moved = |v: &Variation| v.bike.as_ref().is_some_and(|b| b.mass != 260.0);
        assert!(!all.iter().any(moved));
        let all = varied("[uncertainty]\nmass = 2.0\n\"front.wheel_inertia\" = 0.05\n");
        assert_eq!(all.iter().filter(|v| moved(v)).count(), 1);
        let bike = of(&all, "front.wheel_inertia").expect("varied");
        assert_eq!(bike.front.wheel_inertia, Some(0.5));
    }

    #[test]
    fn the_split_of_the_crowns_is_uncertain() {
        let wider = |v: &Variation| v.bike.as_ref().is_some_and(|b| b.rear.width > 0.18);
        assert_eq!(varied("").iter().filter(|v| wider(v)).count(), 1);
    }
}
