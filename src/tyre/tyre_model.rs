//! What the simulator asks of a tyre, whatever its formulas.

use super::paper::{Input, Output};

/// Unloaded shape and vertical spring of a tyre.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carcass {
    /// Unloaded radius, m.
    pub radius: f64,
    /// Crown radius `rho`, m.
    pub crown: f64,
    /// Vertical stiffness, N/m.
    pub stiffness: f64,
    /// Vertical damping, N s/m.
    pub damping: f64,
    /// Effective rolling radius = `(R - rho) + rho cos(gamma) - share * deflection`; 1/3 usual.
    pub deflection_share: f64,
}

impl Carcass {
    /// Of a tyre whose rolling radius (m) upright under a load (N) is known.
    pub fn of_rolling(
        rolling_radius: f64,
        load: f64,
        stiffness: f64,
        crown: f64,
        deflection_share: f64,
    ) -> Self {
        let radius = rolling_radius + deflection_share * load / stiffness;
        Carcass { radius, crown, stiffness, damping: 0.0, deflection_share }
    }

    /// Effective rolling radius, m, under a load (N) at a camber with a `versine` of `1 - cos`.
    #[inline(always)]
    pub fn rolling_radius(&self, load: f64, versine: f64) -> f64 {
        self.radius - self.crown * versine - self.deflection_share * load / self.stiffness
    }

    /// Distance of the axle from the contact in the wheel's plane, m: the lever arm of longitudinal
    /// forces.
    #[inline(always)]
    pub fn lever_arm(&self, load: f64, versine: f64) -> f64 {
        self.radius - self.crown * versine - load / self.stiffness
    }
}

/// Share of the deflection that tyres usually roll shorter by (Pacejka 2012, sec. 1.2: about a third).
pub(crate) const USUAL_SHARE: f64 = 1.0 / 3.0;

/// Where a tyre's forces act and its moments are taken about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Reference {
    /// The lowest point of the toroidal carcass.
    Carcass,
    /// Where the wheel plane meets the road (thin disk).
    WheelPlane,
}

/// Relaxation lengths, m: `d(slip')/dt = |v| / sigma (slip - slip')`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relaxation {
    /// Of the slip ratio.
    pub longitudinal: f64,
    /// Of the slip angle.
    pub lateral: f64,
    /// Of the camber, where the whole side force lags (Sharp 1971).
    pub camber: Option<f64>,
}

/// A tyre of the simulator.
pub trait TyreModel: std::fmt::Debug + Send + Sync {
    /// Forces and moments, ISO 8855, contact axes; without rolling resistance.
    fn forces(&self, input: &Input) -> Output;
    /// Relaxation lengths at a load (N) and speed (m/s).
    fn relaxation(&self, load: f64, speed: f64) -> Relaxation;
    /// Moment about the contact's lateral axis that resists the rotation, N m, not negative: the
    /// load's point of action lies ahead of the contact.
    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64;
    /// Shape and vertical spring.
    fn carcass(&self) -> Carcass;
    /// Effective rolling radius, m, under a load (N) of the spring, at a camber with a `versine` of `1 - cos` and
    /// a speed (m/s).
    fn rolling_radius(&self, load: f64, versine: f64, _speed: f64) -> f64 {
        self.carcass().rolling_radius(load, versine)
    }
    /// Where the forces act.
    fn reference(&self) -> Reference;
    /// A copy on the heap.
    fn boxed_clone(&self) -> Box<dyn TyreModel>;
}

impl Clone for Box<dyn TyreModel> {
    fn clone(&self) -> Self {
        self.boxed_clone()
    }
}

/// How far ahead of its axle the load of a rolling wheel acts, m: its moment about the axle is that of the rolling
/// resistance (a coefficient), which the road's pull at the radius (m) overcomes.
pub(crate) fn load_lead(rolling_resistance: f64, radius: f64) -> f64 {
    rolling_resistance * radius
}
