//! Engine, gearbox and rear wheel: throttle to drive torque, speed to revolutions.
//!
//! ```text
//! crank torque = throttle * peak * curve(n) - (1 - throttle) * drag(n)      drag = e0 + e1 n/1000
//! wheel torque = ratio * crank torque                  n = ratio * wheel spin
//! ```

use serde::Serialize;

use crate::simulate::multibody::Motorcycle;

/// rad/s to revolutions per minute.
pub(crate) const RPM: f64 = 60.0 / std::f64::consts::TAU;
/// Shifts up beyond, rev/min.
const UP: f64 = 10_800.0;
/// Shifts down below, rev/min.
const DOWN: f64 = 6_300.0;

/// The engine and its gears. `n` in thousands of revolutions per minute.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Drivetrain {
    /// Largest torque at the crank, N m.
    pub peak: f64,
    /// Drag of the closed engine at standstill, N m at the crank.
    pub drag: f64,
    /// Its rise per thousand revolutions per minute, N m.
    pub drag_slope: f64,
    /// Inertia of the crank, kg m².
    pub inertia: f64,
    /// Crank turns per wheel turn, first gear first.
    pub ratios: [f64; 6],
    /// Ignition cut of an upshift, and the blip of a downshift, s.
    pub shift_time: f64,
}

impl Drivetrain {
    /// Of a motorcycle, with a drag of the closed engine (N m at the crank, and per 1000/min).
    pub fn of(m: &Motorcycle, drag: f64, drag_slope: f64, inertia: f64) -> Self {
        Drivetrain {
            peak: m.engine_torque,
            drag,
            drag_slope,
            inertia,
            ratios: m.ratios,
            shift_time: 0.07,
        }
    }

    /// Crank speed, rev/min, at a spin of the rear wheel, rad/s.
    pub fn revolutions(&self, gear: usize, spin: f64) -> f64 {
        spin * self.ratios[gear - 1] * RPM
    }

    /// Torque of the open engine at the crank, N m.
    pub fn open(&self, revolutions: f64) -> f64 {
        // a four-cylinder's curve: fullest at 9000/min, three quarters of it at 5000
        let x = (revolutions - 9000.0) / 8000.0;
        let cut = ((12_500.0 - revolutions) / 500.0).clamp(0.0, 1.0);
        self.peak * (1.0 - x * x).max(0.3) * cut
    }

    /// Torque with which the closed engine holds back, at the crank, N m.
    pub fn closed(&self, revolutions: f64) -> f64 {
        self.drag + self.drag_slope * revolutions / 1000.0
    }

    /// Torque at the rear wheel, N m.
    pub fn wheel_torque(&self, gear: usize, spin: f64, throttle: f64) -> f64 {
        let n = self.revolutions(gear, spin);
        self.ratios[gear - 1] * (throttle * self.open(n) - (1.0 - throttle) * self.closed(n))
    }

    /// Throttle for a torque at the rear wheel, 0 to 1.
    pub fn throttle(&self, gear: usize, spin: f64, torque: f64) -> f64 {
        let n = self.revolutions(gear, spin);
        let (open, closed) = (self.open(n), self.closed(n));
        ((torque / self.ratios[gear - 1] + closed) / (open + closed).max(1.0)).clamp(0.0, 1.0)
    }

    /// The gear after this one at a spin of the rear wheel, if the rider would change; a decided throttle
    /// shifts up, a closed one down.
    pub fn change(&self, gear: usize, spin: f64, driving: bool) -> Option<usize> {
        let n = self.revolutions(gear, spin);
        if driving && n > UP && gear < 6 {
            return Some(gear + 1);
        }
        let down = gear > 1 && n < DOWN && self.revolutions(gear - 1, spin) < UP - 500.0;
        down.then(|| gear - 1)
    }

    /// The gear in which the engine turns freely but not too fast at a spin of the rear wheel, rad/s.
    pub fn usual_gear(&self, spin: f64) -> usize {
        (1..=6).find(|g| self.revolutions(*g, spin) < UP - 1500.0).unwrap_or(6)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn throttle_and_torque_are_each_others_inverse() {
        let m = Motorcycle::load("sports_small").expect("built in");
        let d = Drivetrain::of(&m, 6.0, 1.7, 0.02);
        for gear in 1..=6 {
            for spin in [60.0, 90.0] {
                for throttle in [0.0, 0.2, 0.9] {
                    let torque = d.wheel_torque(gear, spin, throttle);
                    let back = d.throttle(gear, spin, torque);
                    assert!((back - throttle).abs() < 1e-9, "{gear} {spin}: {back} {throttle}");
                }
            }
        }
        // closed at 9000/min in second: 21.3 N m at the crank
        let spin = 9000.0 / RPM / d.ratios[1];
        assert!((d.wheel_torque(2, spin, 0.0) + 21.3 * d.ratios[1]).abs() < 1e-9);
        assert_eq!(d.change(2, 11_000.0 / RPM / d.ratios[1], true), Some(3));
        assert_eq!(d.change(2, 11_000.0 / RPM / d.ratios[1], false), None);
    }
}
