//! The base model as residuals that vanish when it is right (`diagnosis.md`, section 2.1).
//!
//! | channel | residual | where |
//! |---|---|---|
//! | `force_x` | `ax - (Fxf + Fxr - resistance)/m`, `Fx = -(G p + I omega')/R` | coasting, braking |
//! | `slip_front`, `slip_rear` | `Fx/Fz - mu_x(s)` over its own uncertainty (Sampson) | all; rear not in corners |
//! | `lateral_front`, `lateral_rear` | `alpha_lagged + C gamma + Fy/(k_alpha Fz)` | all |
//! | `roll` | `ay` less that of the roll balance, less a roll-rate term | corners |
//! | `kinematic_x`, `kinematic_y` | `v' - ax - r vy`, `ay - vy' - v r` | all |
//!
//! Loads follow the longitudinal force at once; forces of a wheel from the balances, as in
//! [`estimate`](crate::estimate). Where a channel says nothing its residual is NaN, whatever the
//! world, so that two worlds are compared on the same blocks.

use super::samples::{BLOCK, RATE, Samples};
use super::world::World;
use crate::GRAVITY;
use crate::estimate::Formulation::Corrected;
use crate::model::kinematics::{front_camber, kinematic_steer};
use crate::segment::Kind;

/// The channels, in their order.
pub const CHANNELS: [&str; 8] = [
    "force_x",
    "slip_front",
    "slip_rear",
    "lateral_front",
    "lateral_rear",
    "roll",
    "kinematic_x",
    "kinematic_y",
];

/// Their units; slips are in standard deviations.
pub const UNITS: [&str; 8] = ["m/s2", "1", "1", "rad", "rad", "m/s2", "m/s2", "m/s2"];

/// Deeper slip is sliding: the curve beyond its peak belongs to the stop, not to the tyre.
const DEEPEST: f64 = -0.16;
/// What the friction curve itself is uncertain by.
const SIGMA_MU: f64 = 0.02;

/// Block means, channel after channel: `[channel][block]`.
pub type Blocks = [Vec<f64>; 8];

/// Everything at one sample.
struct Instant {
    residual: [f64; 8],
    alpha: [f64; 2],
}

/// The residuals' block means in a world.
pub fn blocks(samples: &Samples, world: &World) -> Blocks {
    let mut out: Blocks = std::array::from_fn(|_| Vec::with_capacity(samples.blocks()));
    for (kind, range) in &samples.manoeuvres {
        let length = world.relaxation_length.map(|l| (l + world.departure.relaxation).max(0.02));
        let mut lagged = [Lag::default(), Lag::default()];
        let mut sums = [0.0; 8];
        for (k, i) in range.clone().enumerate() {
            let now = instant(samples, world, i, *kind);
            let mut residual = now.residual;
            for wheel in 0..2 {
                let travelled = samples.v[i] / RATE / length[wheel];
                // the residual holds everything but the lagged slip angle
                residual[3 + wheel] += lagged[wheel].next(now.alpha[wheel], travelled);
            }
            for (sum, r) in sums.iter_mut().zip(residual) {
                *sum += r;
            }
            if k % BLOCK == BLOCK - 1 {
                for (column, sum) in out.iter_mut().zip(&mut sums) {
                    column.push(*sum / BLOCK as f64);
                    *sum = 0.0;
                }
            }
        }
    }
    out
}

/// First-order lag of a signal that runs in straight lines between samples: exact.
#[derive(Debug, Clone, Copy, Default)]
struct Lag {
    state: Option<(f64, f64)>,
}

impl Lag {
    /// The lagged value after `x` relaxation lengths.
    fn next(&mut self, input: f64, x: f64) -> f64 {
        let (last, value) = self.state.unwrap_or((input, input));
        let decay = (-x).exp();
        let share = if x > 1e-9 { (1.0 - decay) / x } else { 1.0 };
        let value = decay * value + (1.0 - share) * input + (share - decay) * last;
        self.state = Some((input, value));
        value
    }
}

fn instant(s: &Samples, w: &World, i: usize, kind: Kind) -> Instant {
    let d = &w.departure;
    let cornering = kind == Kind::Cornering;
    let (m, h, l) = (w.mass, w.cg_height, w.wheelbase);
    let (lf, lr) = (w.cg_to_front, w.wheelbase - w.cg_to_front);
    let v = s.v[i] + d.latency * s.vd[i];
    let r = s.yaw_rate[i] - w.yaw_rate_zero;
    let vy = s.vy[i] + d.latency * s.vyd[i] - w.vy_zero - d.lever_arm * r;
    let ax = s.ax[i] - w.ax_zero;
    let ay = s.ay[i] - w.ay_zero;
    let phi = s.roll[i] + d.roll_zero;
    let (sin_phi, cos_phi) = phi.sin_cos();
    let (rolld, rolldd) = (s.rolld[i], s.rolldd[i]);
    // the mass centre goes down while leaning in
    let sinking = if cornering { h * (cos_phi * rolld * rolld + sin_phi * rolldd) } else { 0.0 };
    let weight = m * (GRAVITY - sinking);
    // without a heading nothing is known of what depends on it
    let along_strip = if s.along[i].is_nan() { 0.0 } else { s.along[i] };
    let inertia = w.wheel_inertia.map(|inertia| inertia * (1.0 + d.inertia));
    let free = kind == Kind::Coasting;
    let braking = matches!(kind, Kind::FrontBraking | Kind::RearBraking | Kind::CombinedBraking);

    // forces along the bike
    let drag = d.drag(w.drag, v, along_strip);
    let uphill = m * GRAVITY * d.grade * along_strip;
    let rolling = w.rolling_resistance + d.rolling_per_speed * v;
    let resistance = drag + rolling * weight + uphill;
    let fading = d.fading(m, &s.brakes[i]);
    let dragging = d.brake_drag(m, &s.brakes[i]);
    let wheel_force = |k: usize| {
        let pressure = if s.pressure[k][i].is_nan() && free { 0.0 } else { s.pressure[k][i] };
        -(w.brake_gain[k] * fading * pressure + dragging + inertia[k] * s.omegad[k][i])
            / w.radius[k]
    };
    let front = wheel_force(0);
    let whole = m * ax + drag + uphill; // tyre forces, rolling resistance included
    let slip_forces = m * ax + resistance;
    let rear = if free || braking { wheel_force(1) } else { slip_forces - front };
    let spin_rate: f64 = (0..2).map(|k| inertia[k] * s.omegad[k][i]).sum();
    let transferred = h * cos_phi * whole + cos_phi * spin_rate + d.drag_height * drag;
    let load_rear = (weight * lf + transferred) / l;
    let lifted = 0.5 * d.lift * v * v;
    let load = [weight - load_rear, load_rear].map(|n| (n - lifted).max(0.05 * weight));
    let still = [m * GRAVITY * lr / l, m * GRAVITY * lf / l];
    let more = [0, 1].map(|k| load[k] / still[k] - 1.0);

    let force_x = if free || braking { ax - (front + rear - resistance) / m } else { f64::NAN };

    // where the tyres go
    let steer = s.steer[i] + d.steer_zero;
    let delta = kinematic_steer(steer, phi, w.caster_angle, Corrected)
        - d.compliance * m * s.ay[i] * lr / l;
    let camber = [front_camber(steer, phi, w.caster_angle, Corrected), phi].map(|g| g - d.bank);
    let along = v - r * h * sin_phi;
    let across = vy + h * cos_phi * rolld;
    let (across_f, across_r) = (across + lf * r, across - lr * r);
    let (sin_d, cos_d) = delta.sin_cos();
    let velocity = if cornering {
        [along * cos_d + across_f * sin_d, along]
    } else {
        [v, v] // straight runs need neither roll nor steering
    };
    let mut slip = [f64::NAN; 2];
    let grip = d.grip(s.time[i], along_strip);
    for (k, force) in [front, rear].into_iter().enumerate() {
        if cornering && k == 1 {
            continue; // the driven wheel slips both ways at once: not on this curve
        }
        let radius = d.radius(w.radius[k], v, load[k] - still[k], camber[k]);
        let ratio = radius * s.omega[k][i] / velocity[k] - 1.0;
        if ratio < DEEPEST {
            // a constant mask would need the true slip: what is deep in one world is not in another
            // by a thousandth, and weighs nothing in either
            slip[k] = 0.0;
            continue;
        }
        let (value, slope) = w.friction[k].value_and_slope(ratio / grip);
        let value = grip * value * (1.0 - d.friction_per_load * more[k]);
        let sigma_s = 0.02 / v + 0.001;
        slip[k] = (force / load[k] - value) / SIGMA_MU.hypot(slope * sigma_s);
    }

    // sideways
    let alpha = [
        (across_f * cos_d - along * sin_d).atan2(along * cos_d + across_f * sin_d),
        across_r.atan2(along),
    ];
    let stiffness = [0, 1].map(|k| {
        let [k0, decay] = w.stiffness[k];
        let g: f64 = camber[k];
        let tangent = if g.abs() < 1e-6 { 1.0 } else { g.tan() / g };
        k0 * tangent / (1.0 + decay * g * g) * (1.0 + d.stiffness_per_load * more[k])
    });
    let lateral = m * (ay + GRAVITY * d.bank);
    let first = [lateral * lr / l, lateral * lf / l];
    let ratio = [0, 1].map(|k| w.side_force_ratio[k] + d.side_force_ratio[k]);
    let mut moment = 0.0;
    for k in 0..2 {
        let by_slip = first[k] + ratio[k] * stiffness[k] * load[k] * camber[k];
        let relative = 1.0 - w.stiffness[k][0] / 3.0 * alpha[k].tan().abs();
        moment += -(w.twisting_stiffness[k] + d.twisting) * load[k] * camber[k]
            - w.trail[k] * (1.0 + d.trail) * relative.max(0.0) * by_slip;
    }
    let spins = 1.0 + d.gyroscopic;
    let spin = spins * (0..2).map(|k| inertia[k] * s.omega[k][i]).sum::<f64>();
    let turning = w.yaw_inertia * s.yaw_rated[i] - moment
        + h * sin_phi * whole
        + spins * spin_rate * sin_phi
        + spin * cos_phi * rolld;
    let side_front = (lr * lateral + turning) / l;
    let side_rear = lateral - side_front;
    let side = [(side_front - front * sin_d) / cos_d, side_rear];
    let balance = [0, 1].map(|k| ratio[k] * camber[k] + side[k] / (stiffness[k] * load[k]));

    let roll = if cornering {
        let aside = h * sin_phi + d.rider_lean * phi;
        let balanced = weight / m * (-aside + w.crown * (phi - d.bank).tan())
            + (w.roll_inertia * rolldd - spin * r * cos_phi) / m;
        ay - balanced / (h * cos_phi) - w.roll_rate_term * rolld
    } else {
        f64::NAN
    };
    Instant {
        residual: [
            force_x,
            slip[0],
            slip[1],
            balance[0],
            balance[1],
            roll,
            s.vd[i] - ax - r * vy,
            ay - s.vyd[i] - v * r,
        ],
        alpha,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `a' = x'(u - a)` for a ramp has a closed form; the filter is exact for it at any step.
    #[test]
    fn the_lag_of_a_ramp_is_exact() {
        for step in [0.05_f64, 0.7, 4.0] {
            let mut lag = Lag::default();
            for i in 0..20 {
                let x = f64::from(i) * step;
                let exact = x - 1.0 + (-x).exp();
                let got = lag.next(x, step);
                assert!((got - exact).abs() < 1e-12 * (1.0 + x), "{step} {i}");
            }
        }
    }
}
