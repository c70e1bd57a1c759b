//! What a real ride may have and the base model has not: one number per physical effect.
//!
//! The simulators have a [`ModelError`] that can be switched on, diagnosis has one that it can
//! free: where an effect enters and by which formula is written once, here. All numbers are zero in
//! the base model. SI, ISO 8855; what an effect means to a user is told in
//! [`diagnose::effects`](crate::effects).

use crate::contract::channel::Channel;
use crate::contract::session::Session;

/// Energy that one unit of fading and of warm-brake drag is for, J.
pub const HEAT: f64 = 50e3;
/// Time over which brakes cool, s.
const COOLING: f64 = 60.0;
/// Time over which tyres warm up, s.
const WARMING: f64 = 150.0;
/// Speed of the stated growth of the rolling radii, m/s.
const GROWN_AT: f64 = 20.0;

/// How a ride departs from the base model.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ModelError {
    /// Slope along the first straight's heading, rise over run.
    pub grade: f64,
    /// Head wind along the first straight's heading, m/s.
    pub wind: f64,
    /// Roll of the road, positive when it falls to the right, rad.
    pub bank: f64,
    /// Loss of friction at the end of the strip that the first straight leads to.
    pub patch: f64,
    /// Relative error of both wheels' spin inertia.
    pub inertia: f64,
    /// Rolling resistance coefficient per speed, s/m.
    pub rolling_per_speed: f64,
    /// Relative growth of the rolling radii at 20 m/s, quadratic in speed.
    pub radius_per_speed: f64,
    /// Radius of the tyres' cross section, by whose versine camber shortens the rolling radius, m.
    pub radius_crown: f64,
    /// Relative loss of rolling radius per load beyond the static one, 1/kN.
    pub radius_per_load: f64,
    /// Relative loss of brake gain per 50 kJ of a stop.
    pub fade: f64,
    /// Drag torque that brakes keep while they are warm, per wheel and 50 kJ, N m.
    pub brake_drag: f64,
    /// Steering angle that is missing in the reading, rad.
    pub steer_zero: f64,
    /// Roll that is missing in the reading, rad.
    pub roll_zero: f64,
    /// How far ahead of the stated place the velocity is measured, m.
    pub lever_arm: f64,
    /// Delay of the velocities, s.
    pub latency: f64,
    /// Relative change of cornering stiffness per load, per relative change of load.
    pub stiffness_per_load: f64,
    /// Relative loss of friction per relative change of load.
    pub friction_per_load: f64,
    /// Loss of friction of cold tyres at the start of the ride.
    pub cold: f64,
    /// Error of the side-force ratios, front and rear.
    pub side_force_ratio: [f64; 2],
    /// Error of both twisting stiffnesses, m/rad.
    pub twisting: f64,
    /// Relative error of both pneumatic trails.
    pub trail: f64,
    /// Error of both relaxation lengths, m.
    pub relaxation: f64,
    /// Steering angle lost per front side force, rad/N.
    pub compliance: f64,
    /// Sideways shift of the mass centre per roll, m/rad.
    pub rider_lean: f64,
    /// Lift over speed squared, shared by both wheels, twice: kg/m.
    pub lift: f64,
    /// Height of the drag above the mass centre, m.
    pub drag_height: f64,
    /// Spin that is not the wheels' (a crankshaft), over the wheels'.
    pub gyroscopic: f64,
}

impl ModelError {
    /// Rolling radius over its base value, at a speed (m/s), a load beyond the static one (N) and a
    /// camber's `1 - cos`.
    pub fn radius(&self, base: f64, speed: f64, more: f64, versine: f64) -> f64 {
        let grown = speed / GROWN_AT;
        base * (1.0 + self.radius_per_speed * grown * grown - self.radius_per_load * more / 1000.0)
            - self.radius_crown * versine
    }

    /// Force of drag, `coefficient v²` on still air, riding `along` the strip (1) or back (-1).
    pub fn drag(&self, coefficient: f64, speed: f64, along: f64) -> f64 {
        let air = speed + self.wind * along;
        coefficient * air * air.abs()
    }

    /// Share of the brake gain that is left within a stop.
    pub fn fading(&self, mass: f64, brakes: &BrakeHistory) -> f64 {
        1.0 - self.fade * mass * brakes.stop / HEAT
    }

    /// Torque of released brakes on each wheel, N m.
    pub fn brake_drag(&self, mass: f64, brakes: &BrakeHistory) -> f64 {
        self.brake_drag * mass * brakes.warm / HEAT
    }

    /// Friction over its usual, `time` s into the ride, riding `along` the strip or back.
    pub fn grip(&self, time: f64, along: f64) -> f64 {
        let there = if along > 0.5 { self.patch } else { 0.0 };
        let warm = if self.cold == 0.0 { 1.0 } else { 1.0 - self.cold * (-time / WARMING).exp() };
        warm * (1.0 - there)
    }

    /// Whether it matters which way the motorcycle goes.
    pub fn by_heading(&self) -> bool {
        self.wind != 0.0 || self.grade != 0.0 || self.patch != 0.0
    }

    /// Whether wheel loads change what a tyre does per load.
    pub fn by_load(&self) -> bool {
        self.radius_per_load != 0.0
            || self.stiffness_per_load != 0.0
            || self.friction_per_load != 0.0
    }

    /// What the sensors make of it: zeros, lever arm and delay on the true channels.
    pub fn measure(&self, session: &mut Session) {
        let mut shift = |channel: Channel, by: f64| {
            if let Some(x) = session.get_mut(channel).filter(|_| by != 0.0) {
                x.iter_mut().for_each(|x| *x -= by);
            }
        };
        shift(Channel::SteerAngle, self.steer_zero);
        shift(Channel::Roll, self.roll_zero);
        if self.lever_arm != 0.0
            && let Some(rate) = session.get(Channel::YawRate).map(<[f64]>::to_vec)
            && let Some(x) = session.get_mut(Channel::VelocityY)
        {
            x.iter_mut().zip(rate).for_each(|(x, r)| *x += self.lever_arm * r);
        }
        if self.latency != 0.0 {
            let by = self.latency * session.rate;
            for channel in [Channel::VelocityX, Channel::VelocityY] {
                if let Some(x) = session.get_mut(channel) {
                    *x = delayed(x, by);
                }
            }
        }
    }
}

/// Samples that come `by` sampling intervals late (early where negative), linear between samples.
fn delayed(x: &[f64], by: f64) -> Vec<f64> {
    let last = x.len().saturating_sub(1) as f64;
    (0..x.len())
        .map(|i| {
            let at = (i as f64 - by).clamp(0.0, last);
            let (low, share) = (at.floor() as usize, at.fract());
            let high = (low + 1).min(x.len() - 1);
            x[low] + share * (x[high] - x[low])
        })
        .collect()
}

/// What the brakes have been through, in J per kg of motorcycle.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BrakeHistory {
    /// Heat of the stop under way.
    pub stop: f64,
    /// Heat of the stops so far that has not gone yet.
    pub warm: f64,
    on: Option<f64>,
}

impl BrakeHistory {
    /// Line pressure from which a brake is on, Pa.
    pub const PRESSED: f64 = 2e4;

    /// Looks at the speed `dt` s later.
    pub fn see(&mut self, speed: f64, braking: bool, dt: f64) {
        self.warm *= (-dt / COOLING).exp();
        if !braking {
            self.on = None;
            self.stop = 0.0;
            return;
        }
        let from = *self.on.get_or_insert(speed);
        let stop = 0.5 * (from * from - speed * speed).max(0.0);
        self.warm += (stop - self.stop).max(0.0);
        self.stop = stop;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_delay_moves_a_ramp_both_ways() {
        let x: Vec<f64> = (0..20).map(f64::from).collect();
        assert_eq!(delayed(&x, 2.5)[10], 7.5);
        assert_eq!(delayed(&x, -1.5)[10], 11.5);
    }

    #[test]
    fn a_stop_heats_and_a_pause_cools() {
        let mut brakes = BrakeHistory::default();
        let mut speed = 20.0;
        while speed > 5.0 {
            brakes.see(speed, true, 0.01);
            speed -= 0.05;
        }
        // (20² - 5²) / 2, less what has gone in 3 s of 60
        assert!((brakes.stop - 187.5).abs() < 1.0, "{}", brakes.stop);
        assert!(brakes.warm > 0.95 * brakes.stop && brakes.warm < brakes.stop);
        for _ in 0..6000 {
            brakes.see(5.0, false, 0.01);
        }
        assert!(brakes.stop == 0.0 && (brakes.warm / 187.5 - 0.36).abs() < 0.02);
    }
}
