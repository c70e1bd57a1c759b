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

use super::attitude::Attitude;
use super::parameters::Parameters;
use super::samples::{BLOCK, Samples};
use crate::GRAVITY;
use crate::contract::manoeuvre::ManoeuvreKind;
use crate::model::magic_formula::MagicFormula;

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

/// The residuals' block means in a world.
pub fn blocks(samples: &Samples, world: &Parameters) -> Blocks {
    blocks_at(samples, world, None, &mut Curves::Unknown)
}

/// How the bike lies throughout, in a world.
pub fn attitudes(samples: &Samples, world: &Parameters) -> Vec<Attitude> {
    let caster = world.caster_angle.sin_cos();
    samples
        .manoeuvres
        .iter()
        .flat_map(|(kind, range)| {
            let cornering = *kind == ManoeuvreKind::Cornering;
            range.clone().map(move |i| Attitude::of(samples, world, caster, i, cornering))
        })
        .collect()
}

/// A point of a friction curve: slip ratio, value, slope.
pub type Point = [f64; 3];

/// Points of both wheels' friction curves, sample by sample. Most worlds near another have most of
/// them in common.
#[derive(Debug)]
pub enum Curves<'a> {
    /// Nothing is known.
    Unknown,
    /// They are kept.
    Keep(Vec<[Point; 2]>),
    /// Those of another world with the same curves.
    Known(&'a [[Point; 2]]),
}

impl Curves<'_> {
    /// Value and slope of wheel `k`'s curve at sample `i`.
    fn at(&mut self, curve: &MagicFormula, k: usize, i: usize, ratio: f64) -> (f64, f64) {
        if let Curves::Known(known) = self
            && known[i][k][0] == ratio
        {
            return (known[i][k][1], known[i][k][2]);
        }
        let (value, slope) = curve.value_and_slope(ratio);
        if let Curves::Keep(kept) = self {
            kept[i][k] = [ratio, value, slope];
        }
        (value, slope)
    }
}

/// The same with attitudes that are known already, and points of the friction curves.
pub fn blocks_at(
    samples: &Samples,
    world: &Parameters,
    known: Option<&[Attitude]>,
    curves: &mut Curves<'_>,
) -> Blocks {
    let fixed = Fixed::of(world);
    let mut out: Blocks = std::array::from_fn(|_| Vec::with_capacity(samples.blocks()));
    for (kind, range) in &samples.manoeuvres {
        let mut lagged = [Lag::default(), Lag::default()];
        let mut sums = [0.0; 8];
        let cornering = *kind == ManoeuvreKind::Cornering;
        for (k, i) in range.clone().enumerate() {
            let attitude = match known {
                Some(known) => known[i],
                None => Attitude::of(samples, world, fixed.caster, i, cornering),
            };
            let mut residual = instant(samples, world, &fixed, i, *kind, &attitude, curves);
            for wheel in 0..2 {
                // the residual holds everything but the lagged slip angle
                let [decay, share] = attitude.lag[wheel];
                residual[3 + wheel] += lagged[wheel].next(attitude.alpha[wheel], decay, share);
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
    /// The lagged value after `x` relaxation lengths, `decay = e^-x`, `share = (1 - e^-x)/x`.
    fn next(&mut self, input: f64, decay: f64, share: f64) -> f64 {
        let (last, value) = self.state.unwrap_or((input, input));
        let value = decay * value + (1.0 - share) * input + (share - decay) * last;
        self.state = Some((input, value));
        value
    }
}

/// What a world has that no sample changes.
struct Fixed {
    /// Sine and cosine of the caster angle.
    caster: (f64, f64),
    inertia: [f64; 2],
    ratio: [f64; 2],
    per_mass: f64,
    per_length: f64,
    per_radius: [f64; 2],
    /// Loads at rest.
    still: [f64; 2],
    per_still: [f64; 2],
}

impl Fixed {
    fn of(w: &Parameters) -> Self {
        let (l, lf) = (w.wheelbase, w.cg_to_front);
        let still = [w.mass * GRAVITY * (l - lf) / l, w.mass * GRAVITY * lf / l];
        Fixed {
            caster: w.caster_angle.sin_cos(),
            inertia: w.wheel_inertia.map(|inertia| inertia * (1.0 + w.departure.inertia)),
            ratio: [0, 1].map(|k| w.side_force_ratio[k] + w.departure.side_force_ratio[k]),
            per_mass: 1.0 / w.mass,
            per_length: 1.0 / l,
            per_radius: w.radius.map(|r| 1.0 / r),
            still,
            per_still: still.map(|n| 1.0 / n),
        }
    }
}

fn instant(
    s: &Samples,
    w: &Parameters,
    fixed: &Fixed,
    i: usize,
    kind: ManoeuvreKind,
    a: &Attitude,
    curves: &mut Curves<'_>,
) -> [f64; 8] {
    let d = &w.departure;
    let cornering = kind == ManoeuvreKind::Cornering;
    let (m, h) = (w.mass, w.cg_height);
    let (lf, lr) = (w.cg_to_front, w.wheelbase - w.cg_to_front);
    let &Attitude { v, r, vy, phi, sin_phi, cos_phi, sin_d, cos_d, camber, .. } = a;
    let ax = s.ax[i] - w.ax_zero;
    let ay = s.ay[i] - w.ay_zero;
    let (rolld, rolldd) = (s.rolld[i], s.rolldd[i]);
    // the mass centre goes down while leaning in
    let sinking = if cornering { h * (cos_phi * rolld * rolld + sin_phi * rolldd) } else { 0.0 };
    let weight = m * (GRAVITY - sinking);
    // without a heading nothing is known of what depends on it
    let along_strip = if s.along[i].is_nan() { 0.0 } else { s.along[i] };
    let &Fixed { inertia, ratio, per_mass, per_length, per_radius, still, per_still, .. } = fixed;
    let free = kind == ManoeuvreKind::Coasting;
    let braking = matches!(
        kind,
        ManoeuvreKind::FrontBraking | ManoeuvreKind::RearBraking | ManoeuvreKind::CombinedBraking
    );

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
            * per_radius[k]
    };
    let front = wheel_force(0);
    let whole = m * ax + drag + uphill; // tyre forces, rolling resistance included
    let slip_forces = m * ax + resistance;
    let rear = if free || braking { wheel_force(1) } else { slip_forces - front };
    let spin_rate: f64 = (0..2).map(|k| inertia[k] * s.omegad[k][i]).sum();
    let transferred = h * cos_phi * whole + cos_phi * spin_rate + d.drag_height * drag;
    let load_rear = (weight * lf + transferred) * per_length;
    let lifted = 0.5 * d.lift * v * v;
    let load = [weight - load_rear, load_rear].map(|n| (n - lifted).max(0.05 * weight));
    let more = [0, 1].map(|k| load[k] * per_still[k] - 1.0);

    let force_x =
        if free || braking { ax - (front + rear - resistance) * per_mass } else { f64::NAN };

    let mut slip = [f64::NAN; 2];
    let grip = d.grip(s.time[i], along_strip);
    for (k, force) in [front, rear].into_iter().enumerate() {
        if cornering && k == 1 {
            continue; // the driven wheel slips both ways at once: not on this curve
        }
        let radius = d.radius(w.radius[k], v, load[k] - still[k], a.versine[k]);
        let ratio = radius * s.omega[k][i] / a.rolling[k] - 1.0;
        if ratio < DEEPEST {
            // a constant mask would need the true slip: what is deep in one world is not in another
            // by a thousandth, and weighs nothing in either
            slip[k] = 0.0;
            continue;
        }
        let (value, slope) = curves.at(&w.friction[k], k, i, ratio / grip);
        let value = grip * value * (1.0 - d.friction_per_load * more[k]);
        let sigma_s = 0.02 / v + 0.001;
        slip[k] =
            (force / load[k] - value) / (SIGMA_MU * SIGMA_MU + (slope * sigma_s).powi(2)).sqrt();
    }

    // sideways
    let stiffness = [0, 1].map(|k| {
        let [k0, decay] = w.stiffness[k];
        let g: f64 = camber[k];
        k0 * a.tangent[k] / (1.0 + decay * g * g) * (1.0 + d.stiffness_per_load * more[k])
    });
    let lateral = m * (ay + GRAVITY * d.bank);
    let first = [lateral * lr * per_length, lateral * lf * per_length];
    let mut moment = 0.0;
    for k in 0..2 {
        let by_slip = first[k] + ratio[k] * stiffness[k] * load[k] * camber[k];
        let relative = 1.0 - w.stiffness[k][0] / 3.0 * a.drift[k];
        moment += -(w.twisting_stiffness[k] + d.twisting) * load[k] * camber[k]
            - w.trail[k] * (1.0 + d.trail) * relative.max(0.0) * by_slip;
    }
    let spins = 1.0 + d.gyroscopic;
    let spin = spins * (0..2).map(|k| inertia[k] * s.omega[k][i]).sum::<f64>();
    let turning = w.yaw_inertia * s.yaw_rated[i] - moment
        + h * sin_phi * whole
        + spins * spin_rate * sin_phi
        + spin * cos_phi * rolld;
    let side_front = (lr * lateral + turning) * per_length;
    let side_rear = lateral - side_front;
    let side = [(side_front - front * sin_d) / cos_d, side_rear];
    let balance = [0, 1].map(|k| ratio[k] * camber[k] + side[k] / (stiffness[k] * load[k]));

    let roll = if cornering {
        let aside = h * sin_phi + d.rider_lean * phi;
        let balanced = (weight * (-aside + w.crown * a.tan_road) + w.roll_inertia * rolldd
            - spin * r * cos_phi)
            * per_mass;
        ay - balanced / (h * cos_phi) - w.roll_rate_term * rolld
    } else {
        f64::NAN
    };
    [
        force_x,
        slip[0],
        slip[1],
        balance[0],
        balance[1],
        roll,
        s.vd[i] + d.latency * s.vdd[i] - ax - r * vy,
        ay - (s.vyd[i] + d.latency * s.vydd[i] - d.lever_arm * s.yaw_rated[i]) - v * r,
    ]
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
                let decay = (-step).exp();
                let got = lag.next(x, decay, (1.0 - decay) / step);
                assert!((got - exact).abs() < 1e-12 * (1.0 + x), "{step} {i}");
            }
        }
    }
}
