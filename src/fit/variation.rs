//! The independent upstream uncertainties of a session's coefficients.

use super::coasting::{Coasting, DRAG, RADIUS, ROLLING};
use crate::contract::bike::Bike;
use crate::estimate::zeros::{LateralZero, Zeros};
use crate::model::formulation::Formulation;

/// One upstream quantity, or one direction of correlated ones, moved by one standard error.
#[derive(Debug, Clone, Default)]
pub struct Variation {
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
}

/// Every upstream quantity in turn, one standard error up.
pub fn variations(
    bike: &Bike,
    zeros: &Zeros,
    coasting: &Coasting,
    formulation: Formulation,
) -> Vec<Variation> {
    let mut out = Vec::new();
    for (key, &sd) in &bike.uncertainty {
        if let (Some(value), true) = (bike.value(key), sd > 0.0) {
            let moved = bike.with(key, value + sd);
            out.push(Variation { bike: Some(moved), ..Variation::default() });
        }
    }
    if formulation == Formulation::Corrected {
        let moved = zero_variations(zeros).into_iter().filter(|moved| moved != zeros);
        out.extend(moved.map(|z| Variation { zeros: Some(z), ..Variation::default() }));
    }
    for k in 0..2 {
        if let Some(c) = coasting.radius[k].as_ref().and_then(|f| f.covariance.as_ref()) {
            let mut radius = [0.0; 2];
            radius[k] = c.covariance[(RADIUS, RADIUS)].max(0.0).sqrt();
            out.push(Variation { radius, ..Variation::default() });
        }
    }
    if let Some(c) = coasting.resistance.as_ref().and_then(|f| f.covariance.as_ref()) {
        let m = &c.covariance;
        let covariance = [m[(DRAG, DRAG)], m[(DRAG, ROLLING)], m[(ROLLING, ROLLING)]];
        for [drag, rolling] in cholesky(covariance) {
            out.push(Variation { drag, rolling, ..Variation::default() });
        }
    }
    out
}

/// The zeros with each independent one moved by its standard error in turn.
fn zero_variations(zeros: &Zeros) -> Vec<Zeros> {
    let mut out = vec![
        Zeros { latency: zeros.latency + zeros.latency_se, ..*zeros },
        Zeros { acceleration_x: zeros.acceleration_x + zeros.acceleration_x_se, ..*zeros },
        Zeros { roll: zeros.roll + zeros.roll_se, ..*zeros },
    ];
    out.extend(lateral_variations(zeros.front).map(|front| Zeros { front, ..*zeros }));
    out.extend(lateral_variations(zeros.rear).map(|rear| Zeros { rear, ..*zeros }));
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
