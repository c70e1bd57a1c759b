//! Rigid wheels that roll without slip: bicycles, and the limit of ever stiffer tyres.
//!
//! The wheel's point at the contact has no velocity: three constraints per wheel, whose six
//! forces follow from the accelerations that they have to undo (the response to a force is
//! linear, so seven runs of the forward dynamics give it). Knife-edge wheels.

use nalgebra::{DMatrix, DVector, Matrix4, SMatrix, SVector, Vector3};

use super::contact::Geometry;
use super::link;
use super::model::{Model, Scratch};
use super::state::{Action, State, joint, spin};
use crate::simulate::multibody::bodies::Motion;

/// Contact of one wheel for the constraint.
struct Touch {
    /// From the wheel's centre to the contact, and its rate.
    arm: Vector3<f64>,
    arm_rate: Vector3<f64>,
    contact: Vector3<f64>,
}

fn touch(model: &Model, scratch: &Scratch, i: usize) -> Touch {
    let carrier = &scratch.work.links[link::CARRIERS[i]];
    let centre = scratch.work.links[link::WHEELS[i]].position;
    let radius = model.motorcycle.centres[i].z;
    let axle = carrier.rotation.column(1).into_owned();
    let geometry = Geometry::new(&axle);
    let (cos, _) = geometry.camber;
    let turn = carrier.spin().cross(&axle);
    let cos_rate = -axle.z * turn.z / cos;
    let down_rate = (axle * turn.z + turn * axle.z) / cos - geometry.down * (cos_rate / cos);
    let arm = geometry.down * radius;
    Touch { arm, arm_rate: down_rate * radius, contact: centre + arm }
}

/// Velocity of the wheels' points at their contacts, world axes, front first.
fn contact_velocities(model: &Model, state: &State, scratch: &mut Scratch) -> SVector<f64, 6> {
    model.kinematics(state, scratch);
    let mut v = SVector::<f64, 6>::zeros();
    for i in 0..2 {
        let point = touch(model, scratch, i).contact;
        let velocity = scratch.work.links[link::WHEELS[i]].velocity_at(&point);
        v.fixed_rows_mut::<3>(3 * i).copy_from(&velocity);
    }
    v
}

/// Rates of the state under the rolling constraints, and the contact forces in world axes.
pub fn rates(
    model: &Model,
    state: &State,
    action: &Action,
    scratch: &mut Scratch,
) -> (State, SVector<f64, 6>) {
    model.kinematics(state, scratch);
    model.prepare(state, action, scratch);
    let touches = [touch(model, scratch, 0), touch(model, scratch, 1)];
    let torque = scratch.work.torque.clone();
    let external: [_; 2] = link::WHEELS.map(|w| scratch.work.links[w].external);
    let mut accelerations = |force: Option<usize>| {
        scratch.work.torque.copy_from_slice(&torque);
        for i in 0..2 {
            scratch.work.links[link::WHEELS[i]].external = external[i];
        }
        if let Some(k) = force {
            let push = Vector3::ith(k % 3, 1.0);
            scratch.work.links[link::WHEELS[k / 3]].push(&push, &touches[k / 3].contact);
        }
        let rates = model.solve(state, [[0.0; 3]; 2], scratch);
        let mut a = SVector::<f64, 6>::zeros();
        for i in 0..2 {
            let wheel = &scratch.work.links[link::WHEELS[i]];
            let centre = wheel.acceleration_at(&wheel.position, &scratch.gravity);
            let turn = wheel.angular_acceleration().cross(&touches[i].arm)
                + wheel.spin().cross(&touches[i].arm_rate);
            a.fixed_rows_mut::<3>(3 * i).copy_from(&(centre + turn));
        }
        (a, rates)
    };
    let (free, _) = accelerations(None);
    let mut response = SMatrix::<f64, 6, 6>::zeros();
    for k in 0..6 {
        response.set_column(k, &(accelerations(Some(k)).0 - free));
    }
    let forces = response.lu().solve(&-free).unwrap_or(SVector::repeat(f64::NAN));
    scratch.work.torque.copy_from_slice(&torque);
    for i in 0..2 {
        let wheel = &mut scratch.work.links[link::WHEELS[i]];
        wheel.external = external[i];
        wheel.push(&forces.fixed_rows::<3>(3 * i).into_owned(), &touches[i].contact);
    }
    (model.solve(state, [[0.0; 3]; 2], scratch), forces)
}

/// The state with both wheels on the road and no slip: pitch and height from roll and steer,
/// velocities from the rates of roll and steer and the rear wheel's spin.
///
/// Returns `None` when there is no such state (a roll too large for the geometry).
pub fn compatible(
    model: &Model,
    [roll, steer]: [f64; 2],
    [roll_rate, steer_rate]: [f64; 2],
    rear_spin: f64,
) -> Option<State> {
    let mut scratch = model.scratch();
    let mut state = State::default();
    state.angles[1] = roll;
    state.joints[joint::STEER] = steer;
    // both contacts at height zero
    for _ in 0..30 {
        let mut heights = |state: &State| {
            model.kinematics(state, &mut scratch);
            [touch(model, &scratch, 0).contact.z, touch(model, &scratch, 1).contact.z]
        };
        let at = heights(&state);
        if at[0].abs().max(at[1].abs()) < 1e-15 {
            break;
        }
        let h = 1e-6;
        let (mut up, mut down) = (state, state);
        up.angles[2] += h;
        down.angles[2] -= h;
        let (up, down) = (heights(&up), heights(&down));
        let slope = [(up[0] - down[0]) / (2.0 * h), (up[1] - down[1]) / (2.0 * h)];
        let pitch = -(at[0] - at[1]) / (slope[0] - slope[1]);
        state.angles[2] += pitch;
        state.position.z -= at[1] + slope[1] * pitch;
    }
    state.rates[joint::STEER] = steer_rate;
    state.rates[joint::REAR] = rear_spin;
    // seven unknown velocities: yaw and pitch rates, three of the base, front spin; and the
    // six constraints are linear in them
    let put = |x: &SVector<f64, 6>| {
        let mut s = state;
        let angular = spin(&s.angles, &[x[0], roll_rate, x[1]]);
        s.velocity = Motion::new(angular, Vector3::new(x[2], x[3], x[4]));
        s.rates[joint::FRONT] = x[5];
        s
    };
    let zero = contact_velocities(model, &put(&SVector::zeros()), &mut scratch);
    let mut matrix = SMatrix::<f64, 6, 6>::zeros();
    for k in 0..6 {
        let mut unit = SVector::<f64, 6>::zeros();
        unit[k] = 1.0;
        let column = contact_velocities(model, &put(&unit), &mut scratch) - zero;
        matrix.set_column(k, &column);
    }
    let x = matrix.lu().solve(&-zero)?;
    let state = put(&x);
    state.to_array().iter().all(|x| x.is_finite()).then_some(state)
}

/// Accelerations of roll and steer.
fn accelerations(model: &Model, state: &State, torque: f64, scratch: &mut Scratch) -> [f64; 2] {
    let action = Action { steer_torque: torque, ..Action::default() };
    let (rates, _) = rates(model, state, &action, scratch);
    let roll = state.angle_accelerations(&rates)[1];
    [roll, rates.rates[joint::STEER]]
}

/// Small motions of roll and steer and their rates about upright straight rolling.
pub fn linearise(model: &Model, speed: f64) -> DMatrix<f64> {
    let mut scratch = model.scratch();
    let rear_spin = speed / model.motorcycle.centres[1].z;
    let mut a = Matrix4::zeros();
    a[(0, 2)] = 1.0;
    a[(1, 3)] = 1.0;
    let h = 1e-4;
    for k in 0..4 {
        let mut at = |shift: f64| {
            let mut x = [0.0; 4];
            x[k] = shift;
            let state = compatible(model, [x[0], x[1]], [x[2], x[3]], rear_spin);
            state.map_or([f64::NAN; 2], |s| accelerations(model, &s, 0.0, &mut scratch))
        };
        let (up, down, far_up, far_down) = (at(h), at(-h), at(2.0 * h), at(-2.0 * h));
        for row in 0..2 {
            let slope = (8.0 * (up[row] - down[row]) - (far_up[row] - far_down[row])) / (12.0 * h);
            a[(2 + row, k)] = slope;
        }
    }
    DMatrix::from_column_slice(4, 4, a.as_slice())
}

/// A steady turn of rolling wheels: steer angle and torque at a rear wheel speed and a lean.
///
/// Returns `None` when Newton's method does not settle.
#[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
pub fn steady(model: &Model, rear_speed: f64, roll: f64, near: [f64; 2]) -> Option<(State, f64)> {
    let mut scratch = model.scratch();
    let rear_spin = rear_speed / model.motorcycle.centres[1].z;
    let mut x = DVector::from_row_slice(&near);
    let mut residual = |x: &DVector<f64>| {
        let state = compatible(model, [roll, x[0]], [0.0; 2], rear_spin)?;
        Some(DVector::from_row_slice(&accelerations(model, &state, x[1], &mut scratch)))
    };
    for _ in 0..50 {
        let r = residual(&x)?;
        if r.amax() < 1e-12 {
            break;
        }
        let mut jacobian = DMatrix::zeros(2, 2);
        for k in 0..2 {
            let h = 1e-6;
            let (mut up, mut down) = (x.clone(), x.clone());
            up[k] += h;
            down[k] -= h;
            jacobian.set_column(k, &((residual(&up)? - residual(&down)?) / (2.0 * h)));
        }
        let dx = jacobian.lu().solve(&r)?;
        x -= dx.map(|d| d.clamp(-0.2, 0.2));
    }
    let state = compatible(model, [roll, x[0]], [0.0; 2], rear_spin)?;
    Some((state, x[1]))
}
