//! A tyre's lateral friction on the bench: `Fy / Fz` over slip angle and camber, free rolling.

use crate::store::tables::rows::BenchRow;
use crate::tyre::paper::Input;
use crate::tyre::tyre_model::TyreModel;

/// A tyre under a load on a road.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LateralBench<'a> {
    pub tyre: &'a dyn TyreModel,
    /// Load, N.
    pub load: f64,
    /// Friction of the road, 1.
    pub friction: f64,
}

impl LateralBench<'_> {
    /// `Fy / Fz` at a slip angle and a camber in degrees.
    pub(crate) fn at(&self, slip: f64, camber: f64) -> f64 {
        let Self { tyre, load, friction } = *self;
        let input = Input {
            slip_ratio: 0.0,
            slip_angle: slip.to_radians(),
            camber: camber.to_radians(),
            load,
            friction,
        };
        tyre.forces(&input).force_y / load
    }

    /// Every 5 degrees of camber to 60 and every half degree of slip to 10, on both sides.
    pub(crate) fn rows(&self, name: &str) -> Vec<BenchRow> {
        let mut rows = Vec::new();
        for camber in (-60..=60).step_by(5).map(f64::from) {
            for slip in (-20..=20).map(|i| f64::from(i) * 0.5) {
                rows.push(BenchRow {
                    tyre: name.to_owned(),
                    load: self.load,
                    camber: camber.to_radians(),
                    slip_angle: slip.to_radians(),
                    friction_y: self.at(slip, camber),
                });
            }
        }
        rows
    }

    /// `Fy / Fz` over slip angles of -6 to 6 degrees at a camber, degrees.
    pub(crate) fn curve(&self, camber: f64) -> Vec<(f64, f64)> {
        let slips = (-60..=60).map(|i| f64::from(i) * 0.1);
        slips.map(|slip| (slip, self.at(slip, camber))).collect()
    }

    /// Largest and root-mean-square difference from another tyre over slip angles of -3 to 3 degrees
    /// at a camber, degrees.
    pub(crate) fn difference(&self, other: &Self, camber: f64) -> [f64; 2] {
        let slips = (-30..=30).map(|i| f64::from(i) * 0.1);
        let off: Vec<f64> =
            slips.map(|slip| self.at(slip, camber) - other.at(slip, camber)).collect();
        let most = off.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        let rms = (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt();
        [most, rms]
    }
}
