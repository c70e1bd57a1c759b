//! The nominal model as residuals that vanish when it is right (`book/src/diagnosis.md`, section 2.1).
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
//! parameters, so that any two sets of them are compared on the same blocks.

use std::borrow::Borrow;

use super::attitude::{Attitude, Lean, Posture};
use super::parameters::Parameters;
use super::samples::Samples;
use crate::GRAVITY;
use crate::contract::bike::Axle;
use crate::contract::residual_channel::{PerChannel, ResidualChannel};
use crate::motorcycle::balance::{Lengths, pitching};
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::physics::{Reach, Rolling};
use crate::tyre::dive::above_axles;
use crate::tyre::kinematics::height_in_plane;
use crate::tyre::pair::both;
use crate::tyre::paper::slip_stiffness_under;
use crate::tyre::tyre_model::{Carcass, load_lead};

/// Names of the channels, in their order.
pub const CHANNELS: [&str; 8] = ResidualChannel::NAMES;

/// Their units; slips are in standard deviations.
pub(crate) const UNITS: [&str; 8] = ResidualChannel::UNITS;

/// Deeper slip is sliding: the curve beyond its peak belongs to the stop, not to the tyre.
const DEEPEST: f64 = -0.16;
/// Uncertainty of the friction curve itself.
const SIGMA_MU: f64 = 0.02;

/// Block means, channel after channel: `[channel][block]`.
pub type Blocks = [Vec<f64>; 8];

/// The residuals' block means under some parameters.
pub fn blocks(samples: &Samples, values: &Parameters) -> Blocks {
    let posture = Posture::of(values);
    let attitude = |i, cornering| Attitude::of(samples, &posture, i, cornering);
    let curve = |k: usize, _, ratio| values.friction[k].value_and_slope(ratio);
    let (forces, everything) = (|_, own: &Instant<'_>| own.longitudinal(), Reach::ATTITUDE);
    blocks_of(samples, values, everything, attitude, forces, curve)
}

/// Block means of the residuals within a reach, of others nil: attitudes by sample and whether it is in a corner,
/// forces by sample, value and slope of a wheel's friction curve by wheel, sample and slip.
#[inline(always)]
pub(super) fn blocks_of<A: Borrow<Attitude>, F: Borrow<Forces>>(
    samples: &Samples,
    values: &Parameters,
    reach: Reach,
    mut attitude: impl FnMut(usize, bool) -> A,
    mut forces: impl FnMut(usize, &Instant<'_>) -> F,
    mut curve: impl FnMut(usize, usize, f64) -> (f64, f64),
) -> Blocks {
    let fixed = Fixed::of(values);
    let mut out: Blocks = std::array::from_fn(|_| Vec::with_capacity(samples.blocks()));
    for (kind, range) in &samples.manoeuvres {
        let mut lagged = [Lag::default(), Lag::default()];
        let mut sums = PerChannel::<f64>::default();
        let cornering = *kind == ManoeuvreKind::Cornering;
        for (k, i) in range.clone().enumerate() {
            let attitude = attitude(i, cornering);
            let attitude: &Attitude = attitude.borrow();
            let [ax, ay] = accelerations(samples, values, attitude, i, cornering);
            let instant = Instant {
                s: samples,
                p: values,
                fixed: &fixed,
                a: attitude,
                i,
                kind: *kind,
                ax,
                ay,
                // without a heading nothing is known of what depends on it
                along: if samples.along[i].is_nan() { 0.0 } else { samples.along[i] },
            };
            let forces = forces(i, &instant);
            let mut residual = instant.residuals(forces.borrow(), reach, &mut curve);
            if reach.lateral {
                for wheel in 0..2 {
                    // the residual holds everything but the lagged slip angle
                    let [decay, share] = attitude.lag[wheel];
                    residual[ResidualChannel::LATERAL[wheel]] +=
                        lagged[wheel].next(attitude.alpha[wheel], decay, share);
                }
            }
            for (sum, r) in sums.iter_mut().zip(residual) {
                *sum += r;
            }
            if k % samples.block == samples.block - 1 {
                for (column, sum) in out.iter_mut().zip(&mut sums) {
                    column.push(*sum / samples.block as f64);
                    *sum = 0.0;
                }
            }
        }
    }
    out
}

/// Level accelerations of the centre of mass, m/s²: what a sensor somewhat ahead, above and turned reads beside them
/// is taken off.
#[inline(always)]
fn accelerations(s: &Samples, p: &Parameters, a: &Attitude, i: usize, bend: bool) -> [f64; 2] {
    // of the other reading, whatever its zero; a log without the lateral one keeps its slips
    let turned = p.sensors.accelerometer_yaw;
    let aside = if s.ay[i].is_nan() { 0.0 } else { s.ay[i] };
    // above the centre of mass a frame that begins to dive pushes the sensor ahead
    let ahead = p.sensors.accelerometer[1] * s.divedd[i];
    let ax = s.ax[i] - p.sensors.ax_zero - turned * aside - ahead;
    let ay = s.ay[i] - p.sensors.ay_zero + turned * s.ax[i];
    if !bend {
        return [ax, ay]; // and neither roll nor yaw rate need be there
    }
    let yaw = [a.r, s.yaw_rated[i]];
    let off = beside(
        p.sensors.accelerometer,
        yaw,
        (a.lean.sin_phi, a.lean.cos_phi),
        [s.rolld[i], s.rolldd[i]],
    );
    [ax - off[0], ay - off[1]]
}

/// Acceleration of a point `x` ahead and `z` above less that of the centre of mass, along and to the left, m/s², in the
/// frame that turns with the yaw rate `r`:
///
/// ```text
/// -r^2 x + z (r' sin(phi) + 2 r phi' cos(phi)),   r' x + z ((phi'^2 + r^2) sin(phi) - phi'' cos(phi))
/// ```
#[inline(always)]
pub(super) fn beside(
    [x, z]: [f64; 2],
    [r, turning]: [f64; 2],
    (sin_phi, cos_phi): (f64, f64),
    [rolld, rolldd]: [f64; 2],
) -> [f64; 2] {
    [
        z * (turning * sin_phi + 2.0 * r * rolld * cos_phi) - r * r * x,
        turning * x + z * ((rolld * rolld + r * r) * sin_phi - rolldd * cos_phi),
    ]
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

/// Quantities that depend on the parameters only, not on the sample.
struct Fixed {
    inertia: [f64; 2],
    ratio: [f64; 2],
    per_mass: f64,
    lengths: Lengths,
    per_length: f64,
    carcass: [Carcass; 2],
    /// Crowns over the front's.
    crown: [f64; 2],
    /// How far the springs below the centre of mass give at rest, m.
    sag: f64,
    /// Height of the centre of mass above the axles, m.
    above_axles: f64,
    /// Of both wheels, m.
    mean_radius: f64,
    /// Loads at rest.
    still: [f64; 2],
    per_still: [f64; 2],
}

impl Fixed {
    fn of(w: &Parameters) -> Self {
        let vehicle = &w.vehicle;
        let (l, lf) = (vehicle.wheelbase, vehicle.cg_to_front);
        let lengths = Lengths::new(lf, l);
        let still = lengths.loads(vehicle.mass * GRAVITY, 0.0, 0.0);
        let error = &w.model_error;
        Fixed {
            inertia: vehicle.wheel_inertia.map(|inertia| error.wheel_inertia(inertia)),
            ratio: both(|k| error.side_force_ratio(w.side_force_ratio[k], Axle::BOTH[k])),
            per_mass: 1.0 / vehicle.mass,
            lengths,
            per_length: 1.0 / l,
            carcass: w.carcasses(),
            crown: w.width.map(|width| width / w.width[0]),
            sag: vehicle.at_mass_centre(vehicle.sag),
            above_axles: above_axles(vehicle.cg_height, w.radius),
            mean_radius: 0.5 * (w.radius[0] + w.radius[1]),
            still,
            per_still: still.map(|n| 1.0 / n),
        }
    }
}

/// One sample of a manoeuvre.
pub(super) struct Instant<'a> {
    s: &'a Samples,
    p: &'a Parameters,
    fixed: &'a Fixed,
    a: &'a Attitude,
    i: usize,
    kind: ManoeuvreKind,
    ax: f64,
    ay: f64,
    /// Cosine of the heading against the strip.
    along: f64,
}

/// Forces along the bike and the loads that they leave. Pairs are front and rear.
#[derive(Debug, Clone, Copy)]
pub(super) struct Forces {
    weight: f64,
    /// Tyre forces, rolling resistance included.
    whole: f64,
    /// Rate of the wheels' angular momentum.
    spin_rate: f64,
    force: [f64; 2],
    load: [f64; 2],
    /// Load beyond the static one, over it.
    extra_load: [f64; 2],
    residual: f64,
}

impl Instant<'_> {
    #[inline(always)]
    fn cornering(&self) -> bool {
        self.kind == ManoeuvreKind::Cornering
    }

    /// Distance of the centre of mass from the ground along the plane, m; upright where corners do not count.
    #[inline(always)]
    fn height(&self) -> f64 {
        match self.cornering() {
            true => {
                let centre = self.p.overturning - self.fixed.sag;
                height_in_plane(self.p.vehicle.cg_height, centre, self.a.lean.cos_phi)
            }
            false => self.p.vehicle.cg_height,
        }
    }

    #[inline(always)]
    pub(super) fn longitudinal(&self) -> Forces {
        let &Instant { s, p, fixed, a, i, along, .. } = self;
        let error = &p.model_error;
        let m = p.vehicle.mass;
        let (v, &Lean { sin_phi, cos_phi, versine, .. }) = (a.v, &a.lean);
        let h = self.height();
        let (rolld, rolldd) = (s.rolld[i], s.rolldd[i]);
        // the centre of mass goes down while leaning in
        let sinking = match self.cornering() {
            true => {
                let rising = p.vehicle.cg_height - p.overturning + fixed.sag;
                rising * (cos_phi * rolld * rolld + sin_phi * rolldd)
            }
            false => 0.0,
        };
        let weight = m * (GRAVITY - sinking);
        let free = self.kind == ManoeuvreKind::Coasting;
        let braking = matches!(
            self.kind,
            ManoeuvreKind::FrontBraking
                | ManoeuvreKind::RearBraking
                | ManoeuvreKind::CombinedBraking
        );
        let drag = error.drag(p.vehicle.drag, v, along);
        let uphill = error.uphill(m * GRAVITY * s.grade[i], m * GRAVITY, along);
        let rolling = error.rolling_resistance(p.rolling_resistance, v);
        let resistance = drag + rolling * weight + uphill;
        let whole = m * self.ax + drag + uphill;
        let spin_rate: f64 = (0..2).map(|k| fixed.inertia[k] * s.omegad[k][i]).sum();
        let turning = spin_rate + m * p.vehicle.pitch_gyration * s.divedd[i];
        let transferred = error.pitch_moment(pitching(whole, h, turning, cos_phi), drag);
        let ahead = fixed.above_axles * s.dive[i] - load_lead(rolling, fixed.mean_radius);
        let carried = fixed.lengths.loads(weight, ahead, transferred);
        let lifted = error.lift(0.0, v);
        let load = both(|k| (carried[k] - lifted).max(0.05 * weight));
        let heat = &s.brakes[i];
        let gain = both(|k| error.brake_gain(1.0, m, heat.each[k]));
        let dragging = both(|k| error.brake_drag(0.0, m, heat.whole, Axle::BOTH[k]));
        let wheel_force = |k: usize| {
            let pressure = if s.pressure[k][i].is_nan() && free { 0.0 } else { s.pressure[k][i] };
            -(p.vehicle.brake_gain[k] * gain[k] * pressure
                + dragging[k]
                + fixed.inertia[k] * s.omegad[k][i])
                / fixed.carcass[k].lever_arm(load[k], versine[k])
        };
        let front = wheel_force(0);
        let slip_forces = m * self.ax + resistance;
        let rear = if free || braking { wheel_force(1) } else { slip_forces - front };
        let residual = if free || braking {
            self.ax - (front + rear - resistance) * fixed.per_mass
        } else {
            f64::NAN
        };
        Forces {
            weight,
            whole,
            spin_rate,
            force: [front, rear],
            load,
            extra_load: both(|k| load[k] * fixed.per_still[k] - 1.0),
            residual,
        }
    }

    #[inline(always)]
    fn slips(
        &self,
        x: &Forces,
        curve: &mut impl FnMut(usize, usize, f64) -> (f64, f64),
    ) -> [f64; 2] {
        let &Instant { s, p, fixed, a, i, along, .. } = self;
        let error = &p.model_error;
        let v = a.v;
        let mut slip = [f64::NAN; 2];
        let grip = error.grip(1.0, s.time[i], along);
        for (k, force) in x.force.into_iter().enumerate() {
            if self.cornering() && k == 1 {
                continue; // the driven wheel slips both ways at once: not on this curve
            }
            let extra_load = x.load[k] - fixed.still[k];
            let rolling =
                Rolling { speed: v, extra_load, versine: a.lean.versine[k], crown: fixed.crown[k] };
            let radius = fixed.carcass[k].rolling_radius(x.load[k], a.lean.versine[k]);
            let ratio = error.radius(radius, rolling) * s.omega[k][i] / a.rolling[k] - 1.0;
            if ratio < DEEPEST {
                // a constant mask would need the true slip: what is deep with some parameters is not
                // with others by a thousandth, and weighs nothing with either
                slip[k] = 0.0;
                continue;
            }
            let stiffer = slip_stiffness_under(p.vehicle.slip_stiffness_load, x.extra_load[k]);
            let (value, slope) = curve(k, i, stiffer * ratio / grip);
            let value = grip * value * error.relative_friction(1.0, x.extra_load[k]);
            let sigma_s = 0.02 / v + 0.001;
            slip[k] = (force / x.load[k] - value)
                / (SIGMA_MU * SIGMA_MU + (stiffer * slope * sigma_s).powi(2)).sqrt();
        }
        slip
    }

    /// Slip angles that the side forces ask for, with camber's share, less the lagged ones.
    #[inline(always)]
    fn lateral(&self, x: &Forces) -> [f64; 2] {
        let &Instant { s, p, fixed, a, i, ay, .. } = self;
        let error = &p.model_error;
        let &Lean { sin_phi, cos_phi, sin_d, cos_d, camber, tangent, .. } = &a.lean;
        let (lf, lr) = (p.vehicle.cg_to_front, p.vehicle.wheelbase - p.vehicle.cg_to_front);
        let &Fixed { ratio, per_length, .. } = fixed;
        let stiffness = both(|k| {
            let [k0, decay] = p.stiffness[k];
            let g: f64 = camber[k];
            k0 * tangent[k] / (1.0 + decay * g * g) * error.relative_stiffness(1.0, x.extra_load[k])
        });
        let lateral = p.vehicle.mass * (ay - GRAVITY * error.weight_across(0.0));
        let first = [lateral * lr * per_length, lateral * lf * per_length];
        let mut moment = 0.0;
        for k in 0..2 {
            let by_slip = first[k] + ratio[k] * stiffness[k] * x.load[k] * camber[k];
            let relative = 1.0 - p.stiffness[k][0] / 3.0 * a.drift[k].abs();
            moment += -error.twisting_stiffness(p.twisting_stiffness[k]) * x.load[k] * camber[k]
                - p.trail[k] * error.relative_trail(1.0) * relative.max(0.0) * by_slip;
        }
        let turning = p.vehicle.yaw_inertia * s.yaw_rated[i] - moment
            + self.height() * sin_phi * x.whole
            + error.spin(1.0) * x.spin_rate * sin_phi
            + self.spin() * cos_phi * s.rolld[i];
        let side_front = (lr * lateral + turning) * per_length;
        let side_rear = lateral - side_front;
        let side = [(side_front - x.force[0] * sin_d) / cos_d, side_rear];
        both(|k| ratio[k] * camber[k] + side[k] / (stiffness[k] * x.load[k]))
    }

    /// Angular momentum of all that spins, kg m²/s.
    #[inline(always)]
    fn spin(&self) -> f64 {
        let wheels = (0..2).map(|k| self.fixed.inertia[k] * self.s.omega[k][self.i]).sum::<f64>();
        self.p.model_error.spin(1.0) * wheels
    }

    #[inline(always)]
    fn roll(&self, x: &Forces) -> f64 {
        let &Instant { s, p, fixed, a, i, .. } = self;
        if !self.cornering() {
            return f64::NAN;
        }
        let &Lean { phi, sin_phi, cos_phi, tan_road, handlebar, sin_handlebar, .. } = &a.lean;
        let (h, rolld, rolldd) = (self.height(), s.rolld[i], s.rolldd[i]);
        let aside = p.model_error.mass_centre_aside(h * sin_phi, phi);
        // the steered front wheel stands beside the plane
        let steered = match handlebar.is_finite() {
            true => p.vehicle.normal_trail * sin_handlebar / cos_phi * x.load[0],
            false => 0.0,
        };
        let balanced = (x.weight * (-aside + p.overturning * tan_road)
            + steered
            + p.vehicle.roll_inertia * rolldd
            - self.spin() * a.r * cos_phi)
            * fixed.per_mass;
        self.ay - balanced / (h * cos_phi) - p.roll_rate_term * rolld
    }

    /// The residuals of the channels within a reach, without the lagged slip angles; of others nil.
    #[inline(always)]
    fn residuals(
        &self,
        x: &Forces,
        reach: Reach,
        curve: &mut impl FnMut(usize, usize, f64) -> (f64, f64),
    ) -> PerChannel<f64> {
        let &Instant { s, p, a, i, ax, ay, .. } = self;
        let error = &p.model_error;
        let mut out = PerChannel::default();
        if reach.forces {
            out[ResidualChannel::ForceX] = x.residual;
        }
        if reach.slips {
            let slip = self.slips(x, curve);
            out[ResidualChannel::SlipFront] = slip[0];
            out[ResidualChannel::SlipRear] = slip[1];
        }
        if reach.lateral {
            let lateral = self.lateral(x);
            out[ResidualChannel::LateralFront] = lateral[0];
            out[ResidualChannel::LateralRear] = lateral[1];
        }
        if reach.roll {
            out[ResidualChannel::Roll] = self.roll(x);
        }
        if reach.kinematic {
            let vd = error.velocity(s.vd[i], s.vdd[i]);
            let vyd = error.velocity_y(error.velocity(s.vyd[i], s.vydd[i]), s.yaw_rated[i]);
            out[ResidualChannel::KinematicX] = vd - ax - a.r * a.vy;
            // in the other balances the same error of the lean stands on the other side
            let off =
                p.sensors.attitude_scale * a.lean.sin_phi + p.sensors.attitude_delay * s.rolld[i];
            let above = if self.cornering() {
                p.sensors.velocity_height * a.lean.cos_phi * s.rolldd[i]
            } else {
                0.0
            };
            let vyd = vyd + above;
            out[ResidualChannel::KinematicY] = ay - GRAVITY * off - vyd - a.v * a.r;
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A point that is carried round by yaw and roll, differentiated twice in the frame of the road.
    #[test]
    fn a_point_beside_the_mass_centre_accelerates_as_it_moves() {
        let (x, z) = (0.3, 0.25);
        let yaw = |t: f64| 0.4 * t + 0.2 * (1.3 * t).sin();
        let roll = |t: f64| 0.5 * (0.9 * t + 0.3).sin();
        let place = |t: f64| {
            let (ahead, left) = (x, -z * roll(t).sin());
            let (sin, cos) = yaw(t).sin_cos();
            [ahead * cos - left * sin, ahead * sin + left * cos]
        };
        let step = 1e-4;
        let second = |f: &dyn Fn(f64) -> f64, t: f64| {
            (f(t + step) - 2.0 * f(t) + f(t - step)) / (step * step)
        };
        let first = |f: &dyn Fn(f64) -> f64, t: f64| (f(t + step) - f(t - step)) / (2.0 * step);
        for t in [0.0, 0.7, 2.1] {
            let of_world = [0, 1].map(|k| second(&|t| place(t)[k], t));
            let (sin, cos) = yaw(t).sin_cos();
            let level =
                [of_world[0] * cos + of_world[1] * sin, of_world[1] * cos - of_world[0] * sin];
            let rates = [first(&yaw, t), second(&yaw, t)];
            let rolls = [first(&roll, t), second(&roll, t)];
            let found = beside([x, z], rates, roll(t).sin_cos(), rolls);
            for k in 0..2 {
                assert!((found[k] - level[k]).abs() < 1e-5, "{t}: {found:?} {level:?}");
            }
        }
    }

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
