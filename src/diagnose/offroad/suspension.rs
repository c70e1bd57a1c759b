//! What the bike file does not know of fork and shock: Coulomb friction, preload.
//!
//! Friction is `F clamp(v / 0.02 m/s, -1, 1)` beyond that of the file, as
//! [`Strut`] has it. What acts on the measured accelerations
//! went through the filter with them; so does its column here.

use super::curve::Curve;
use super::declaration::{Declaration, Ride};
use crate::diagnose::cause::Candidate;
use crate::filter::high_cut;
use crate::motorcycle::offroad::planar::Strut;

/// Coulomb friction of the fork.
pub(crate) const FORK_FRICTION: Declaration = Declaration {
    candidate: Candidate {
        place: 0,
        name: "fork_friction",
        parameter: "fork_friction",
        sentence: "the fork has more Coulomb friction than the bike file says",
        opposite: "the fork has less Coulomb friction than the bike file says",
        unit: "N",
        separate_by: "flights, in which the fork comes out slowly; a fork on a test bench",
        typical: 60.0,
        bounds: [-300.0, 600.0],
    },
    family: Some("fork force"),
    curve: |ride| {
        let k = &ride.estimate.kinematics;
        let unit: Vec<f64> = k.zd_f.iter().map(|v| Strut::unit_friction(*v)).collect();
        along_fork(ride, unit)
    },
};

/// Force of the fork's spring at any travel.
pub(crate) const FORK_PRELOAD: Declaration = Declaration {
    candidate: Candidate {
        place: 0,
        name: "fork_preload",
        parameter: "fork_preload",
        sentence: "the fork's spring is preloaded more than the bike file says",
        opposite: "the fork's spring is preloaded less than the bike file says",
        unit: "N",
        separate_by: "the fork's force at rest, extended and at sag",
        typical: 60.0,
        bounds: [-600.0, 600.0],
    },
    family: Some("fork force"),
    curve: |ride| along_fork(ride, vec![1.0; ride.estimate.kinematics.len()]),
};

/// Coulomb friction of the shock.
pub(crate) const SHOCK_FRICTION: Declaration = Declaration {
    candidate: Candidate {
        place: 0,
        name: "shock_friction",
        parameter: "shock_friction",
        sentence: "the shock has more Coulomb friction than the bike file says",
        opposite: "the shock has less Coulomb friction than the bike file says",
        unit: "N",
        separate_by: "flights, in which the shock comes out slowly; a shock on a test bench",
        typical: 150.0,
        bounds: [-600.0, 1500.0],
    },
    family: None,
    curve: |ride| {
        let k = &ride.estimate.kinematics;
        let linkage = &ride.estimate.machine.linkage;
        let moment = |i: usize| {
            let slope = linkage.at(k.shock[i])[1];
            Strut::unit_friction(k.ad_r[i] / slope) / slope
        };
        let column = passed(ride, (0..k.len()).map(moment).collect());
        let r = ride.residuals;
        Curve::Line(r.response(|i, _| [0.0, 0.0, 0.0, 0.0, column[i * r.step]]))
    },
};

fn along_fork(ride: &Ride<'_>, unit: Vec<f64>) -> Curve {
    let column = passed(ride, unit);
    let r = ride.residuals;
    Curve::Line(r.response(|i, _| [0.0, 0.0, 0.0, column[i * r.step], 0.0]))
}

/// The signal after the filter.
fn passed(ride: &Ride<'_>, mut x: Vec<f64>) -> Vec<f64> {
    x.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = 0.0);
    high_cut(&mut x, ride.estimate.kinematics.rate, ride.high_cut);
    x
}
