//! A tyre that gives less force from lap to lap.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::tyre::paper::{Input, Output};
use crate::tyre::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

/// Remaining share of both tyres' forces while they are ridden.
#[derive(Debug, Clone)]
pub(super) struct RemainingGrip(Arc<AtomicU64>);

impl RemainingGrip {
    pub(super) fn all() -> Self {
        RemainingGrip(Arc::new(AtomicU64::new(1.0_f64.to_bits())))
    }

    pub(super) fn set(&self, share: f64) {
        self.0.store(share.to_bits(), Ordering::Relaxed);
    }

    fn get(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }
}

/// A tyre whose horizontal forces, and the moments that they make, are a share of those of its formulas: stiffness and
/// peak friction fall in the same measure at every slip.
#[derive(Debug, Clone)]
pub(super) struct Fading {
    pub base: Box<dyn TyreModel>,
    /// Remaining share of its forces.
    pub left: RemainingGrip,
}

impl TyreModel for Fading {
    fn forces(&self, input: &Input) -> Output {
        let (share, out) = (self.left.get(), self.base.forces(input));
        Output {
            force_x: share * out.force_x,
            force_y: share * out.force_y,
            moment_z: share * out.moment_z,
            ..out
        }
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        self.base.relaxation(load, speed)
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        self.base.rolling_resistance(input, speed)
    }

    fn carcass(&self) -> Carcass {
        self.base.carcass()
    }

    fn rolling_radius(&self, load: f64, versine: f64, speed: f64) -> f64 {
        self.base.rolling_radius(load, versine, speed)
    }

    fn reference(&self) -> Reference {
        self.base.reference()
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(self.clone())
    }
}
