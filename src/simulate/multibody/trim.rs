//! Steady turns: the state, steering torque and drive with which nothing changes.

use nalgebra::{DMatrix, DVector, Vector3};

use super::link;
use super::model::{Model, Scratch};
use super::state::{Action, State, Wheel, joint, spin};

#[derive(Debug, Clone)]
pub struct Trim {
    /// Forward velocity of the frame's centre of mass along the frame plane's trace, m/s.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub speed: f64,
    /// rad/s, positive to the left.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub yaw_rate: f64,
    /// The state; position and heading are zero.
    pub state: State,
    /// Steering torque and drive.
    pub action: Action,
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub wheels: [Wheel; 2],
    /// Largest remaining rate, SI.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub residual: f64,
}

/// Why there is none.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("no steady turn at {speed:.1} m/s and {yaw_rate:.2} rad/s: {residual:.1e} remains")]
pub struct NoTrim {
    speed: f64,
    yaw_rate: f64,
    residual: f64,
}

/// Unknowns of Newton's method, in the order of its vector.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Unknown {
    Height,
    Roll,
    Pitch,
    Joint(usize),
    Sideways,
    Spin(usize),
    Steer,
    Drive,
    Lag(usize, usize),
}

fn unknowns(model: &Model) -> Vec<Unknown> {
    use Unknown as U;
    let mut list = vec![U::Height, U::Roll, U::Pitch, U::Joint(joint::STEER), U::Sideways];
    for j in [joint::SWING, joint::FORK, joint::TWIST] {
        if !model.locked(j) {
            list.push(U::Joint(j));
        }
    }
    list.extend([U::Spin(0), U::Spin(1), U::Steer, U::Drive]);
    for i in 0..2 {
        list.extend([U::Lag(i, 0), U::Lag(i, 1)]);
        if lags_camber(model, i) {
            list.push(U::Lag(i, 2));
        }
    }
    list
}

fn lags_camber(model: &Model, i: usize) -> bool {
    let tyres = model.motorcycle.tyres.as_ref();
    tyres.is_some_and(|t| t[i].relaxation(1000.0, 10.0).camber.is_some())
}

/// The steady turn at a speed and yaw rate; `near` is where to start from.
///
/// # Errors
/// Newton's method does not settle: no such turn, or too far from `near`.
pub fn steady(
    model: &Model,
    speed: f64,
    yaw_rate: f64,
    near: Option<&Trim>,
) -> Result<Trim, NoTrim> {
    let list = unknowns(model);
    let mut scratch = model.scratch();
    let (state, action) = match near {
        Some(trim) => (trim.state, trim.action),
        None => {
            let mut state = model.straight(speed);
            state.angles[1] = -(yaw_rate * speed / model.motorcycle.gravity).atan() * 1.1;
            for i in 0..2 {
                state.lag[i][2] = state.angles[1];
            }
            (state, Action::default())
        }
    };
    let sideways = 0.0;
    let mut x = DVector::from_iterator(
        list.len(),
        list.iter().map(|u| match *u {
            Unknown::Height => state.position.z,
            Unknown::Roll => state.angles[1],
            Unknown::Pitch => state.angles[2],
            Unknown::Joint(j) => state.joints[j],
            Unknown::Sideways => sideways,
            Unknown::Spin(i) => state.rates[link::WHEEL_JOINTS[i]],
            Unknown::Steer => action.steer_torque,
            Unknown::Drive => action.drive,
            Unknown::Lag(i, k) => state.lag[i][k],
        }),
    );
    let mut residual = f64::INFINITY;
    for _ in 0..60 {
        let r = residuals(model, speed, yaw_rate, &list, &x, &mut scratch);
        let size = r.amax();
        if !size.is_finite() {
            break;
        }
        // at the floor of rounding no step makes it smaller
        if size < 1e-12 || (size < 1e-8 && size >= residual) {
            residual = size;
            break;
        }
        residual = size;
        let n = list.len();
        let mut jacobian = DMatrix::zeros(n, n);
        for k in 0..n {
            let h = 1e-6 * x[k].abs().max(step(list[k]));
            let mut moved = x.clone();
            moved[k] = x[k] + h;
            let up = residuals(model, speed, yaw_rate, &list, &moved, &mut scratch);
            moved[k] = x[k] - h;
            let down = residuals(model, speed, yaw_rate, &list, &moved, &mut scratch);
            jacobian.set_column(k, &((up - down) / (2.0 * h)));
        }
        let Some(dx) = jacobian.lu().solve(&r) else { break };
        // the first steps may be long: angles are held to a few degrees
        let mut scale: f64 = 1.0;
        for k in 0..n {
            let most = match list[k] {
                Unknown::Roll | Unknown::Pitch | Unknown::Joint(_) | Unknown::Lag(..) => 0.1,
                Unknown::Height => 0.03,
                Unknown::Sideways => 0.5,
                Unknown::Spin(_) => 5.0,
                Unknown::Steer | Unknown::Drive => 300.0,
            };
            scale = scale.min(most / dx[k].abs().max(1e-300));
        }
        x -= dx * scale.min(1.0);
    }
    if residual > 1e-6 {
        return Err(NoTrim { speed, yaw_rate, residual });
    }
    let (state, action) = unpack(model, speed, yaw_rate, &list, &x);
    model.rates(&state, &action, &mut scratch);
    Ok(Trim { speed, yaw_rate, state, action, wheels: scratch.wheels, residual })
}

fn step(unknown: Unknown) -> f64 {
    match unknown {
        Unknown::Spin(_) | Unknown::Steer | Unknown::Drive => 10.0,
        Unknown::Height => 0.1,
        _ => 1.0,
    }
}

fn unpack(
    model: &Model,
    speed: f64,
    yaw_rate: f64,
    list: &[Unknown],
    x: &DVector<f64>,
) -> (State, Action) {
    let mut state = State::default();
    let mut action = Action::default();
    let mut sideways = 0.0;
    for (unknown, &x) in list.iter().zip(x.iter()) {
        match *unknown {
            Unknown::Height => state.position.z = x,
            Unknown::Roll => state.angles[1] = x,
            Unknown::Pitch => state.angles[2] = x,
            Unknown::Joint(j) => state.joints[j] = x,
            Unknown::Sideways => sideways = x,
            Unknown::Spin(i) => state.rates[link::WHEEL_JOINTS[i]] = x,
            Unknown::Steer => action.steer_torque = x,
            Unknown::Drive => action.drive = x,
            Unknown::Lag(i, k) => state.lag[i][k] = x,
        }
    }
    state.velocity.angular = spin(&state.angles, &[yaw_rate, 0.0, 0.0]);
    // level velocity of the frame's centre of mass, along and across the trace
    let level = Vector3::new(speed, sideways, 0.0);
    let own = state.rotation().tr_mul(&level);
    let centre = model.motorcycle.frame.centre;
    state.velocity.linear = own - state.velocity.angular.cross(&centre);
    (state, action)
}

fn residuals(
    model: &Model,
    speed: f64,
    yaw_rate: f64,
    list: &[Unknown],
    x: &DVector<f64>,
    scratch: &mut Scratch,
) -> DVector<f64> {
    let (state, action) = unpack(model, speed, yaw_rate, list, x);
    let rates = model.rates(&state, &action, scratch);
    let mut r = Vec::with_capacity(list.len());
    r.extend(rates.velocity.angular.iter());
    r.extend(rates.velocity.linear.iter());
    for j in [joint::STEER, joint::FRONT, joint::REAR] {
        r.push(rates.rates[j]);
    }
    for unknown in list {
        match *unknown {
            Unknown::Joint(j) if j != joint::STEER => r.push(rates.rates[j]),
            Unknown::Lag(i, k) => r.push(rates.lag[i][k]),
            _ => {}
        }
    }
    DVector::from_vec(r)
}
