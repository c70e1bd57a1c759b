//! What was measured, simulated: the reduced-order motorcycle on the characterised tyres, driven by
//! the measured pressures, lean and - off the brakes - speed.
//!
//! It gives the session as a perfect logger would have recorded it on a motorcycle that is the nominal
//! model and nothing else: beside the measured one it shows what the model gets wrong, and with
//! noise on it, it is a fault-free simulation for calibration. Speed runs free while braking and coasting; elsewhere
//! the throttle brings it back to the measured one, so that the ride stays the same ride.

use std::ops::Range;

use super::dive::{NOISY, true_dive};
use super::parameters::Parameters;
use crate::contract::bike::Axle;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::ingest::clock::gaps::bridge;
use crate::ingest::clock::grid::Interpolation;
use crate::segment::Segment;
use crate::segment::manoeuvre::ManoeuvreKind;
use crate::simulate::effects::ModelError;
use crate::simulate::effects::ride::{BrakeHistory, Brakes, acting_pressure, along_strip};
use crate::simulate::motorcycle::{Action, Exponential, Plant, State};
use crate::simulate::programme::Lean;
use crate::simulate::rider::steer_as_felt;
use crate::statistics::smooth::{gradient, mean_twice, smooth};
use crate::tyre::dive::above_axles;
use crate::tyre::pair::both;
use crate::tyre::paper::NO_LIMIT;
use crate::tyre::{Stiffness, Tyre};

/// How fast the throttle brings the speed back, 1/s.
const THROTTLE: f64 = 0.8;

/// The same of a rider who feels what the motorcycle does.
const FELT_THROTTLE: f64 = 2.0;

/// How fast a rider who feels what the motorcycle does moves the throttle to what it lacks, 1/s: slower than tyres
/// take up a force, well within a manoeuvre.
const FELT: f64 = 8.0;

/// Manoeuvres with a closed throttle, although a brake lever may be at rest for a moment.
const UNDRIVEN: [ManoeuvreKind; 4] = [
    ManoeuvreKind::Coasting,
    ManoeuvreKind::FrontBraking,
    ManoeuvreKind::RearBraking,
    ManoeuvreKind::CombinedBraking,
];

/// Roll angle from which nobody comes back, and below which a motorcycle is upright, rad.
const FALLEN: f64 = 1.5;
const UPRIGHT: f64 = 0.1;

/// The simulated motorcycle that the parameters describe.
pub(crate) fn plant(values: &Parameters) -> Plant {
    let vehicle = values.vehicle.clone();
    // one crown for the vehicle, shared by the tyres' widths
    let share = [1.0, values.width[1] / values.width[0]];
    let load = [vehicle.wheelbase - vehicle.cg_to_front, vehicle.cg_to_front]
        .map(|x| x / vehicle.wheelbase);
    let overturning = values.overturning / (share[0] * load[0] + share[1] * load[1]);
    let tyres = [0, 1].map(|k| {
        let ratio = values.side_force_ratio[k];
        let [k0, decay] = values.stiffness[k];
        Tyre {
            friction: values.friction[k],
            stiffness: Stiffness { ct: -k0 * ratio, c1: 0.0, c3: decay * ratio },
            side_force_ratio: ratio,
            twisting_stiffness: values.twisting_stiffness[k],
            overturning_stiffness: overturning * share[k],
            rolling_radius: values.radius[k],
            rolling_resistance: values.rolling_resistance,
            relaxation_length: values.relaxation_length[k],
            vertical_stiffness: values.vertical_stiffness[k],
            camber_force_decay: 0.0,
            camber_moment_decay: 0.0,
            reference_friction: 1.0,
            peak_slip: values.friction[k].peak_slip().unwrap_or(0.2),
            // a ride that never brakes to the limit shows no peak: its corners are none either
            lateral_peak: NO_LIMIT,
        }
    });
    let (crown, model_error) = (values.crown(), ModelError::default());
    Plant { vehicle, tyres, crown, friction: 1.0, model_error }.with(&values.model_error)
}

/// Where a replay takes up the measured motion again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    /// At the start of the session only: one whole ride.
    Session,
    /// At the start of every used manoeuvre: what the model makes of each.
    Manoeuvres,
}

/// The channels that are simulated.
pub(crate) const CHANNELS: [Channel; 9] = [
    Channel::VelocityX,
    Channel::VelocityY,
    Channel::AccelerationX,
    Channel::AccelerationY,
    Channel::Roll,
    Channel::YawRate,
    Channel::SteerAngle,
    Channel::WheelSpeedFront,
    Channel::WheelSpeedRear,
];

/// The session as a perfect logger would have recorded it; NaN between manoeuvres where it is simulated
/// from them, and in corners that the model cannot ride. Pressures and heading stay the measured ones.
pub fn replay(session: &Session, segments: &[Segment], plant: &Plant, from: From) -> Session {
    let measured = Measured::of(session, segments);
    let (n, dt) = (session.len, 1.0 / session.rate);
    let parts = Parts::of(segments, n, from);
    let mut out: [Vec<f64>; 9] = std::array::from_fn(|_| Vec::with_capacity(n));
    let mut ride = Ride::start(plant, known(&measured.v, 0).max(0.0));
    let mut down = 0..0;
    for i in 0..n {
        if !(ride.state.roll.abs() < FALLEN && ride.state.vx.is_finite()) {
            // a corner that the model cannot ride is left out whole
            down = measured.bend(i);
            out.iter_mut().for_each(|column| column[down.start..i].fill(f64::NAN));
            (ride.state, ride.action) = (State::default(), Action::default());
            ride.load = None;
        }
        if !parts.simulated[i] || down.contains(&i) {
            ride.brakes.update(known(&measured.v, i), measured.pressure(i), dt);
            out.iter_mut().for_each(|column| column.push(f64::NAN));
            continue;
        }
        if parts.starts[i] || i > 0 && i == down.end {
            ride.take_up(&measured, i);
            ride.action.drive = 0.0;
        }
        let values = ride.advance(&measured, i, dt, from == From::Manoeuvres);
        out.iter_mut().zip(values).for_each(|(column, value)| column.push(value));
    }
    let mut recorded = session.clone();
    for (channel, column) in CHANNELS.into_iter().zip(out) {
        if session.has(channel) {
            recorded.set(channel, column);
        }
    }
    if session.has(Channel::Pitch) {
        recorded.set(Channel::Pitch, measured.dive);
    }
    plant.model_error.measure(&mut recorded);
    // what the brakes were really given, without the noise of a lever at rest
    for (channel, pressure) in PRESSURES.into_iter().zip(measured.pressures) {
        if session.has(channel) {
            recorded.set(channel, pressure);
        }
    }
    recorded
}

const PRESSURES: [Channel; 2] = [Channel::BrakePressureFront, Channel::BrakePressureRear];

/// A sample; nil where it is not known.
fn known(x: &[f64], i: usize) -> f64 {
    if x[i].is_finite() { x[i] } else { 0.0 }
}

/// Inputs of a replay: smoothed channels and derivatives of a session, SI; 0 where they are missing.
struct Measured {
    v: Vec<f64>,
    ax: Vec<f64>,
    vy: Vec<f64>,
    yaw_rate: Vec<f64>,
    roll: Vec<f64>,
    roll_rate: Vec<f64>,
    roll_acceleration: Vec<f64>,
    omega: [Vec<f64>; 2],
    pressures: [Vec<f64>; 2],
    /// Cosine of the heading against that of the first straight.
    along: Vec<f64>,
    /// Whether the bike coasts or is braked: the throttle is closed.
    undriven: Vec<bool>,
    /// Pitch beyond the usual one, rad, and its rate.
    dive: Vec<f64>,
    dive_rate: Vec<f64>,
    dive_acceleration: Vec<f64>,
}

impl Measured {
    fn of(session: &Session, segments: &[Segment]) -> Self {
        let (n, rate) = (session.len, session.rate);
        let missing = || vec![0.0; n];
        let column = |c: Channel| session.get(c).map_or_else(missing, |x| smooth(x, rate));
        // through a gap the ride goes on as straight as it can; the noise of a sensor is no motion: a
        // rider and a throttle that follow it would shake the motorcycle
        let motion = |x: Vec<f64>| mean_twice(&bridged(x), rate, NOISY);
        let v = motion(column(Channel::VelocityX));
        let roll = motion(column(Channel::Roll));
        let roll_rate = gradient(&roll, rate);
        let ax = match session.has(Channel::AccelerationX) {
            true => motion(column(Channel::AccelerationX)),
            false => gradient(&v, rate),
        };
        let mut undriven = vec![false; n];
        for s in segments.iter().filter(|s| UNDRIVEN.contains(&s.kind)) {
            undriven[s.start..s.end.min(n)].fill(true);
        }
        let dive = true_dive(session).unwrap_or_else(missing);
        let dive_rate = gradient(&dive, rate);
        Measured {
            ax,
            vy: column(Channel::VelocityY),
            yaw_rate: column(Channel::YawRate),
            roll_acceleration: gradient(&roll_rate, rate),
            omega: [Channel::WheelSpeedFront, Channel::WheelSpeedRear].map(column),
            pressures: PRESSURES.map(|c| acting_pressure(&column(c), rate)),
            along: along_strip(session),
            v,
            roll,
            roll_rate,
            undriven,
            dive_acceleration: gradient(&dive_rate, rate),
            dive_rate,
            dive,
        }
    }

    /// Speed, m/s, that a sensor with these errors showed: what was ridden, not what was read.
    fn speed(&self, error: &ModelError, i: usize) -> f64 {
        error.velocity(known(&self.v, i), known(&self.ax, i))
    }

    /// Lean, rad, that a sensor with these errors showed.
    fn lean(&self, error: &ModelError, i: usize) -> f64 {
        error.roll(known(&self.roll, i))
    }

    /// Pressures of the brakes, Pa.
    fn pressure(&self, i: usize) -> [f64; 2] {
        both(|k| known(&self.pressures[k], i).max(0.0))
    }

    /// The corner around a sample.
    fn bend(&self, i: usize) -> Range<usize> {
        let leaned = |i: &usize| self.roll[*i].abs() > UPRIGHT;
        (0..i).rev().take_while(leaned).last().unwrap_or(i)
            ..(i..self.roll.len()).take_while(leaned).last().unwrap_or(i) + 1
    }
}

/// Which samples are simulated, and which of them start from the measured motion.
struct Parts {
    simulated: Vec<bool>,
    starts: Vec<bool>,
}

impl Parts {
    fn of(segments: &[Segment], n: usize, from: From) -> Self {
        let (mut starts, mut simulated) = (vec![false; n], vec![from == From::Session; n]);
        if from == From::Manoeuvres {
            for s in segments.iter().filter(|s| s.used && s.start < n) {
                starts[s.start] = true;
                simulated[s.start..s.end.min(n)].fill(true);
            }
        }
        Parts { simulated, starts }
    }
}

/// The simulated motorcycle on its way.
struct Ride<'a> {
    plant: &'a Plant,
    scheme: Exponential<'a>,
    state: State,
    action: Action,
    brakes: Brakes,
    /// Loads of the step before, N: what they do to the tyres changes little within one.
    load: Option<[f64; 2]>,
}

impl<'a> Ride<'a> {
    fn start(plant: &'a Plant, speed: f64) -> Self {
        let mut state = State { vx: speed, ..State::default() };
        state.omega = both(|k| speed / plant.tyres[k].rolling_radius);
        let (action, brakes) = (Action::default(), Brakes::default());
        Ride { plant, scheme: Exponential::new(plant), state, action, brakes, load: None }
    }

    /// Takes up the measured motion.
    fn take_up(&mut self, measured: &Measured, i: usize) {
        self.load = None;
        let Ride { plant, state, .. } = self;
        let error = &plant.model_error;
        state.yaw_rate = known(&measured.yaw_rate, i);
        state.vx = measured.speed(error, i).max(0.0);
        state.vy = error.velocity_y(known(&measured.vy, i), state.yaw_rate);
        state.roll = measured.lean(error, i);
        state.roll_rate = known(&measured.roll_rate, i);
        let speed = state.vx;
        state.omega = both(|k| match measured.omega[k][i] > 0.0 {
            true => measured.omega[k][i],
            false => speed / plant.tyres[k].rolling_radius,
        });
    }

    /// One step of `dt` s, and what is recorded before it, in the order of [`CHANNELS`].
    /// `felt`: by a rider who feels what the throttle lacks.
    fn advance(&mut self, measured: &Measured, i: usize, dt: f64, felt: bool) -> [f64; 9] {
        let plant = self.plant;
        let response = plant.response_near(&self.state, &self.action, self.load);
        let pressure = measured.pressure(i);
        let braking = pressure.iter().any(|p| *p > BrakeHistory::PRESSED);
        self.brakes.update(self.state.vx, pressure, dt);
        let (error, Brakes { whole, each }) = (&plant.model_error, self.brakes);
        let gain = both(|k| error.brake_gain(1.0, plant.vehicle.mass, each[k]));
        let drag = both(|k| error.brake_drag(0.0, plant.vehicle.mass, whole, Axle::BOTH[k]));
        let radius = both(|k| plant.tyres[k].rolling_radius);
        let above = above_axles(plant.vehicle.cg_height, radius);
        // what was measured goes on evenly: held from the start of a step it would act half a step late
        let given = |action: Action, i: usize| Action {
            brake: both(|k| {
                drag[k] + plant.vehicle.brake_gain[k] * gain[k] * known(&measured.pressures[k], i)
            }),
            ahead: above * measured.dive[i],
            dive_rate: measured.dive_rate[i],
            dive_acceleration: measured.dive_acceleration[i],
            ..action
        };
        self.action = Action { time: i as f64 * dt, ..given(self.action, i) };
        // where the road climbs and the wind blows is where it was
        if measured.along[i].is_finite() {
            self.state.yaw = measured.along[i].acos();
        }
        self.action.drive = match braking || measured.undriven[i] {
            true => 0.0,
            // what the road, the wind and the brakes do is known from what the motorcycle did a moment ago
            false if felt && self.action.drive != 0.0 => {
                let missing = self.wanted(measured, i, FELT_THROTTLE) - response.acceleration[0];
                let torque = plant.moving_mass() * missing * plant.tyres[1].rolling_radius;
                self.limited(self.action.drive + FELT * dt * torque)
            }
            false => self.throttle(measured, i),
        };
        let lean = Lean {
            angle: measured.lean(error, i),
            rate: known(&measured.roll_rate, i),
            acceleration: known(&measured.roll_acceleration, i),
        };
        self.action.steer = steer_as_felt(plant, &self.state, &response, &lean);
        let before = self.state;
        let next = given(self.action, (i + 1).min(measured.v.len() - 1));
        let response =
            self.scheme.advance(&mut self.state, [&self.action, &next], dt, Some(response.load));
        self.load = Some(response.load);
        if self.state.vx < 0.0 {
            self.state.vx = 0.0;
        }
        [
            before.vx,
            before.vy,
            response.acceleration[0],
            response.acceleration[1],
            before.roll,
            before.yaw_rate,
            before.steer,
            before.omega[0],
            before.omega[1],
        ]
    }

    /// Acceleration, m/s², that brings the speed back to the measured one that fast, 1/s.
    fn wanted(&self, measured: &Measured, i: usize, back: f64) -> f64 {
        let Ride { plant, state, .. } = self;
        known(&measured.ax, i) + back * (measured.speed(&plant.model_error, i) - state.vx)
    }

    /// Drive torque, N m, that gives the wanted acceleration on a level road in still air.
    fn throttle(&self, measured: &Measured, i: usize) -> f64 {
        let Ride { plant, state, .. } = self;
        let rolling = plant.tyres[1].rolling_resistance * plant.vehicle.mass * crate::GRAVITY;
        let force = plant.moving_mass() * self.wanted(measured, i, THROTTLE)
            + plant.vehicle.drag * state.vx * state.vx
            + rolling;
        self.limited(force * plant.tyres[1].rolling_radius)
    }

    /// A drive torque within what engines give, N m.
    fn limited(&self, torque: f64) -> f64 {
        let most = self.plant.vehicle.mass * 9.8 * self.plant.tyres[1].rolling_radius;
        torque.clamp(-0.2 * most, 0.9 * most)
    }
}

/// A column with straight lines through its gaps, held before the first and after the last that is
/// known; zeros where nothing is.
pub(super) fn bridged(mut x: Vec<f64>) -> Vec<f64> {
    let known = |v: &f64| v.is_finite();
    let (Some(first), Some(last)) = (x.iter().position(known), x.iter().rposition(known)) else {
        x.fill(0.0);
        return x;
    };
    let ends = [x[first], x[last]];
    x[..first].fill(ends[0]);
    x[last + 1..].fill(ends[1]);
    bridge(&mut x, usize::MAX, Interpolation::Linear);
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_bridged_and_ends_held() {
        let n = f64::NAN;
        assert_eq!(bridged(vec![n, 1.0, n, n, 4.0, n]), [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
        assert_eq!(bridged(vec![n, n]), [0.0, 0.0]);
        assert_eq!(bridged(Vec::new()), [0.0; 0]);
    }
}
