//! What was measured, ridden again: the reduced-order motorcycle on the characterised tyres, driven by
//! the measured pressures, lean and - off the brakes - speed.
//!
//! It gives the session as a perfect logger would have recorded it on a motorcycle that is the base
//! model and nothing else: beside the measured one it shows what the model gets wrong, and with
//! noise on it, it is a null for calibration. Speed runs free while braking and coasting; elsewhere
//! the throttle brings it back to the measured one, so that the ride stays the same ride.

use super::parameters::Parameters;
use crate::contract::channel::Channel;
use crate::contract::session::Session;
use crate::effects::ModelError;
use crate::effects::ride::{BrakeHistory, along_strip};
use crate::ingest::gaps::bridge;
use crate::ingest::grid::Interpolation;
use crate::model::{Stiffness, Tyre};
use crate::simulate::motorcycle::{Action, Plant, State};
use crate::simulate::programme::Lean;
use crate::simulate::rider::steer;
use crate::statistics::smooth::{gradient, smooth};
use crate::{contract::manoeuvre::ManoeuvreKind, segment::Segment};

/// How fast the throttle brings the speed back, 1/s.
const THROTTLE: f64 = 0.8;

/// Roll angle from which nobody comes back, and below which a motorcycle is upright, rad.
const FALLEN: f64 = 1.5;
const UPRIGHT: f64 = 0.1;

/// The plant that a base world describes.
pub fn plant(world: &Parameters, widths: [f64; 2], vertical_stiffness: [f64; 2]) -> Plant {
    // one crown for the vehicle, shared by the tyres' widths
    let share = [1.0, widths[1] / widths[0]];
    let load =
        [world.wheelbase - world.cg_to_front, world.cg_to_front].map(|x| x / world.wheelbase);
    let crown = world.crown / (share[0] * load[0] + share[1] * load[1]);
    let tyres = [0, 1].map(|k| {
        let ratio = world.side_force_ratio[k];
        let [k0, decay] = world.stiffness[k];
        Tyre {
            friction: world.friction[k],
            stiffness: Stiffness { ct: -k0 * ratio, c1: 0.0, c3: decay * ratio },
            side_force_ratio: ratio,
            twisting_stiffness: world.twisting_stiffness[k],
            overturning_stiffness: crown * share[k],
            rolling_radius: world.radius[k],
            rolling_resistance: world.rolling_resistance,
            relaxation_length: world.relaxation_length[k],
            vertical_stiffness: vertical_stiffness[k],
            slip_transition: 1.1,
            camber_force_decay: 0.0,
            camber_moment_decay: 0.0,
            reference_friction: 1.0,
            peak_slip: world.friction[k].peak_slip().unwrap_or(0.2),
        }
    });
    Plant {
        mass: world.mass,
        cg_to_front: world.cg_to_front,
        wheelbase: world.wheelbase,
        cg_height: world.cg_height,
        caster_angle: world.caster_angle,
        roll_inertia: world.roll_inertia,
        yaw_inertia: world.yaw_inertia,
        wheel_inertia: world.wheel_inertia,
        tyres,
        drag: world.drag,
        friction: 1.0,
        brake_gain: world.brake_gain,
        model_error: ModelError::default(),
    }
    .with(&world.model_error)
}

/// Where a replay takes up the measured motion again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum From {
    /// At the start of the session only: one whole ride.
    Session,
    /// At the start of every used manoeuvre: what the model makes of each.
    Manoeuvres,
}

/// The session as a perfect logger would have recorded it; NaN between manoeuvres where it is ridden from
/// them, and in bends that the model cannot ride. Pressures and heading stay the measured ones.
pub fn replay(session: &Session, segments: &[Segment], plant: &Plant, from: From) -> Session {
    let (n, rate) = (session.len, session.rate);
    let dt = 1.0 / rate;
    let missing = || vec![0.0; n];
    let column = |c: Channel| session.get(c).map_or_else(missing, |x| smooth(x, rate));
    let known = |x: &[f64], i: usize| if x[i].is_finite() { x[i] } else { 0.0 };
    // through a gap the ride goes on as straight as it can
    let v = bridged(column(Channel::VelocityX));
    let roll = bridged(column(Channel::Roll));
    let (rolld, ax) = (gradient(&roll, rate), gradient(&v, rate));
    let rolldd = gradient(&smooth(&rolld, rate), rate);
    let pressures = [Channel::BrakePressureFront, Channel::BrakePressureRear].map(column);
    let mut free = vec![false; n];
    for s in segments.iter().filter(|s| s.kind == ManoeuvreKind::Coasting) {
        free[s.start..s.end.min(n)].fill(true);
    }

    let mut out: [Vec<f64>; 9] = std::array::from_fn(|_| Vec::with_capacity(n));
    let start = known(&v, 0).max(0.0);
    let mut state = State { vx: start, ..State::default() };
    state.omega = [0, 1].map(|k| start / plant.tyres[k].rolling_radius);
    let mut action = Action::default();
    let mut brakes = BrakeHistory::default();
    let along = along_strip(session);
    let mut starts = vec![false; n];
    let mut ridden = vec![from == From::Session; n];
    if from == From::Manoeuvres {
        for s in segments.iter().filter(|s| s.used && s.start < n) {
            starts[s.start] = true;
            ridden[s.start..s.end.min(n)].fill(true);
        }
    }
    let vy = column(Channel::VelocityY);
    let yaw_rate = column(Channel::YawRate);
    let omega = [Channel::WheelSpeedFront, Channel::WheelSpeedRear].map(column);
    let mut down = 0..0;
    for i in 0..n {
        if !(state.roll.abs() < FALLEN && state.vx.is_finite()) {
            // a bend that the model cannot ride is left out whole
            let leaned = |i: &usize| roll[*i].abs() > UPRIGHT;
            down = (0..i).rev().take_while(leaned).last().unwrap_or(i)
                ..(i..n).take_while(leaned).last().unwrap_or(i) + 1;
            out.iter_mut().for_each(|column| column[down.start..i].fill(f64::NAN));
            (state, action) = (State::default(), Action::default());
        }
        if !ridden[i] || down.contains(&i) {
            brakes.update(known(&v, i), pressures.iter().any(|p| p[i] > BrakeHistory::PRESSED), dt);
            out.iter_mut().for_each(|column| column.push(f64::NAN));
            continue;
        }
        if starts[i] || i > 0 && i == down.end {
            let error = &plant.model_error;
            state.yaw_rate = known(&yaw_rate, i);
            state.vx = error.velocity(known(&v, i), known(&ax, i)).max(0.0);
            state.vy = error.velocity_y(known(&vy, i), state.yaw_rate);
            state.roll = error.roll(known(&roll, i));
            state.roll_rate = known(&rolld, i);
            state.omega = [0, 1].map(|k| match omega[k][i] > 0.0 {
                true => omega[k][i],
                false => state.vx / plant.tyres[k].rolling_radius,
            });
        }
        let response = plant.response(&state, &action);
        let pressure = [0, 1].map(|k| known(&pressures[k], i).max(0.0));
        let braking = pressure.iter().any(|p| *p > BrakeHistory::PRESSED);
        brakes.update(state.vx, braking, dt);
        let gain = plant.model_error.brake_gain(1.0, plant.mass, brakes);
        let drag = plant.model_error.brake_drag(0.0, plant.mass, brakes);
        action.brake = [0, 1].map(|k| {
            let on = pressure[k] > BrakeHistory::PRESSED;
            drag + if on { plant.brake_gain[k] * gain * pressure[k] } else { 0.0 }
        });
        action.time = i as f64 * dt;
        // where the road climbs and the wind blows is where it was
        if along[i].is_finite() {
            state.yaw = along[i].acos();
        }
        action.drive = if braking || free[i] {
            0.0
        } else {
            let wanted = known(&ax, i) + THROTTLE * (known(&v, i) - state.vx);
            let rolling = plant.tyres[1].rolling_resistance * plant.mass * crate::GRAVITY;
            let spinning: f64 = (0..2)
                .map(|k| plant.wheel_inertia[k] / plant.tyres[k].rolling_radius.powi(2))
                .sum();
            let force =
                (plant.mass + spinning) * wanted + plant.drag * state.vx * state.vx + rolling;
            force.clamp(-0.2 * plant.mass * 9.8, 0.9 * plant.mass * 9.8)
                * plant.tyres[1].rolling_radius
        };
        let lean = Lean {
            angle: known(&roll, i),
            rate: known(&rolld, i),
            acceleration: known(&rolldd, i),
        };
        action.steer = steer(plant, &state, &response, &lean);
        let shown = state;
        let response = plant.advance(&mut state, &action, dt);
        for (column, value) in out.iter_mut().zip([
            shown.vx,
            shown.vy,
            response.acceleration[0],
            response.acceleration[1],
            shown.roll,
            shown.yaw_rate,
            shown.steer,
            shown.omega[0],
            shown.omega[1],
        ]) {
            column.push(value);
        }
        if state.vx < 0.0 {
            state.vx = 0.0;
        }
    }
    let mut shown = session.clone();
    for (channel, column) in [
        Channel::VelocityX,
        Channel::VelocityY,
        Channel::AccelerationX,
        Channel::AccelerationY,
        Channel::Roll,
        Channel::YawRate,
        Channel::SteerAngle,
        Channel::WheelSpeedFront,
        Channel::WheelSpeedRear,
    ]
    .into_iter()
    .zip(out)
    {
        if session.has(channel) {
            shown.set(channel, column);
        }
    }
    plant.model_error.measure(&mut shown);
    // what the brakes were really given, without the noise of a lever at rest
    for (channel, pressure) in
        [Channel::BrakePressureFront, Channel::BrakePressureRear].into_iter().zip(pressures)
    {
        if session.has(channel) {
            let on = pressure
                .iter()
                .map(|p| if *p > BrakeHistory::PRESSED { *p } else { 0.0 })
                .collect();
            shown.set(channel, on);
        }
    }
    shown
}

/// A column with straight lines through its gaps, held before the first and after the last that is
/// known; zeros where nothing is.
fn bridged(mut x: Vec<f64>) -> Vec<f64> {
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
    use crate::simulate::{self, scenario::Scenario};

    /// On a rear tyre with a tenth of its cornering stiffness some bends cannot be ridden; the straights can.
    #[test]
    fn bends_that_cannot_be_ridden_are_left_out() {
        let scenario = Scenario::builtin("perfect").expect("scenario");
        let machine = scenario.machine(0);
        let session = simulate::session(&scenario, &machine, 0).session;
        let roll = session.get(Channel::Roll).expect("roll").to_vec();
        let lost = |plant: &Plant| {
            let shown = replay(&session, &[], plant, From::Session);
            let ridden = shown.get(Channel::Roll).expect("roll").to_vec();
            let share = |leaned: bool| {
                let own = roll.iter().zip(&ridden).filter(|(r, _)| (r.abs() > 0.3) == leaned);
                let (lost, all) =
                    own.fold((0, 0), |(lost, all), (_, x)| (lost + u32::from(x.is_nan()), all + 1));
                f64::from(lost) / f64::from(all)
            };
            [share(true), share(false)]
        };
        let mut plant = machine.plant.clone();
        assert_eq!(lost(&plant), [0.0; 2]);
        plant.tyres[1].stiffness.ct *= 0.1;
        let [bends, straights] = lost(&plant);
        assert!(bends > 0.1 && straights < 0.02, "{bends}, {straights}");
    }

    #[test]
    fn gaps_are_bridged_and_ends_held() {
        let n = f64::NAN;
        assert_eq!(bridged(vec![n, 1.0, n, n, 4.0, n]), [1.0, 1.0, 2.0, 3.0, 4.0, 4.0]);
        assert_eq!(bridged(vec![n, n]), [0.0, 0.0]);
        assert_eq!(bridged(Vec::new()), [0.0; 0]);
    }
}
