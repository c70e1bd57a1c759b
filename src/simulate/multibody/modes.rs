//! Linear analysis: eigenvalues of straight running over speed.

use nalgebra::{Complex, DMatrix};

use super::description::Contact;
use super::model::Model;
use super::rolling;
use super::state::{Action, N, State, joint};
use super::trim::{self, NoTrim};

/// The small motions about a steady state.
#[derive(Debug, Clone)]
pub struct Linear {
    /// Indices into the state's array.
    pub index: Vec<usize>,
    /// Rates per state.
    pub a: DMatrix<f64>,
    /// Rates per steering torque.
    pub by_steer: Vec<f64>,
}

/// Names of lateral modes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Name {
    /// Rear-end yaw and roll, up to about 5 Hz.
    Weave,
    /// Shake of the steering, 5 to 10 Hz.
    Wobble,
    /// Slow fall into the lean.
    Capsize,
    /// Another lateral mode.
    Lateral,
    /// Bounce, pitch, wheel hop, speed.
    InPlane,
}

impl Name {
    pub(crate) fn name(self) -> &'static str {
        match self {
            Name::Weave => "weave",
            Name::Wobble => "wobble",
            Name::Capsize => "capsize",
            Name::Lateral => "lateral",
            Name::InPlane => "in_plane",
        }
    }
}

/// One eigenvalue; of a conjugate pair the one with positive frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mode {
    /// Speed, m/s.
    pub speed: f64,
    pub name: Name,
    /// 1/s and rad/s.
    pub eigenvalue: Complex<f64>,
}

impl Mode {
    /// Hz; zero of a mode that does not swing.
    pub(crate) fn frequency(&self) -> f64 {
        self.eigenvalue.im / std::f64::consts::TAU
    }

    /// Damping ratio; negative when it grows.
    pub(crate) fn damping(&self) -> f64 {
        -self.eigenvalue.re / self.eigenvalue.norm().max(1e-300)
    }
}

/// States that move out of the plane of symmetry; the others are bounce, pitch, speed and what
/// goes with them.
const LATERAL: [usize; 11] = [
    4,                // roll
    6 + joint::TWIST, // joint positions
    6 + joint::STEER,
    13, // roll and yaw rates in frame axes
    15,
    17,                // sideways velocity
    19 + joint::TWIST, // joint rates
    19 + joint::STEER,
    27, // lagged slip angles
    30,
    28, // lagged camber, front; the rear's is added beside it
];

/// Small motions about a state that does not change but for position, heading and wheel angles.
pub fn linearise(model: &Model, state: &State, action: &Action) -> Linear {
    let lags_camber = |i: usize| {
        let tyres = model.motorcycle.tyres.as_ref();
        tyres.is_some_and(|t| t[i].relaxation(1000.0, 10.0).camber.is_some())
    };
    let joint_free = |j: usize| j != joint::RIDER && !model.locked(j);
    let index: Vec<usize> = (0..N)
        .filter(|&i| match i {
            0 | 1 | 3 => false,
            6..=12 => joint_free(i - 6) && i - 6 != joint::REAR && i - 6 != joint::FRONT,
            19..=25 => joint_free(i - 19),
            28 => lags_camber(0),
            31 => lags_camber(1),
            _ => true,
        })
        .collect();
    let mut scratch = model.scratch();
    let base = state.to_array();
    let n = index.len();
    let mut a = DMatrix::zeros(n, n);
    for (column, &i) in index.iter().enumerate() {
        let mut rates = |shift: f64| {
            let mut moved = base;
            moved[i] += shift;
            model.rates(&State::from_array(&moved), action, &mut scratch).to_array()
        };
        let h = 2e-5 * base[i].abs().clamp(1.0, 20.0);
        let slope = fourth_order(&mut rates, h);
        for (row, &k) in index.iter().enumerate() {
            a[(row, column)] = slope[k];
        }
    }
    let mut by_torque = |shift: f64| {
        let pushed = Action { steer_torque: action.steer_torque + shift, ..*action };
        model.rates(state, &pushed, &mut scratch).to_array()
    };
    let slope = fourth_order(&mut by_torque, 0.1);
    Linear { by_steer: index.iter().map(|&k| slope[k]).collect(), index, a }
}

/// Derivative of a vector function at zero, error of order `h^4`.
fn fourth_order(f: &mut impl FnMut(f64) -> [f64; N], h: f64) -> [f64; N] {
    let (near_up, near_down, far_up, far_down) = (f(h), f(-h), f(2.0 * h), f(-2.0 * h));
    std::array::from_fn(|i| {
        (8.0 * (near_up[i] - near_down[i]) - (far_up[i] - far_down[i])) / (12.0 * h)
    })
}

impl Linear {
    /// The part that mixes only the states that `keep` takes.
    pub fn part(&self, keep: impl Fn(usize) -> bool) -> Linear {
        let chosen: Vec<usize> = (0..self.index.len()).filter(|&k| keep(self.index[k])).collect();
        Linear {
            index: chosen.iter().map(|&k| self.index[k]).collect(),
            a: self.a.select_rows(&chosen).select_columns(&chosen),
            by_steer: chosen.iter().map(|&k| self.by_steer[k]).collect(),
        }
    }

    /// The lateral motion of straight running.
    pub fn lateral(&self) -> Linear {
        self.part(|i| LATERAL.contains(&i) || i == 31)
    }

    /// The motion in the plane of symmetry of straight running.
    pub fn in_plane(&self) -> Linear {
        self.part(|i| !LATERAL.contains(&i) && i != 31)
    }
}

/// Eigenvalues, least damped first; conjugate pairs stand together.
pub fn eigenvalues(a: &DMatrix<f64>) -> Vec<Complex<f64>> {
    let mut list: Vec<Complex<f64>> = a.complex_eigenvalues().iter().copied().collect();
    list.sort_by(|x, y| {
        (-x.re, x.im.abs(), x.im).partial_cmp(&(-y.re, y.im.abs(), y.im)).expect("finite")
    });
    list
}

/// Eigenvalues of straight running at each speed, labelled by following each mode from where it is
/// unmistakable.
///
/// # Errors
/// The motorcycle cannot run straight at one of the speeds.
pub(crate) fn over_speed(model: &Model, speeds: &[f64]) -> Result<Vec<Mode>, NoTrim> {
    let mut modes = Vec::new();
    let mut lateral: Vec<(f64, Vec<Complex<f64>>)> = Vec::new();
    for &speed in speeds {
        let (out_of_plane, in_plane) = match model.motorcycle.contact {
            Contact::Rolling => (eigenvalues(&rolling::linearise(model, speed)), Vec::new()),
            Contact::Tyre => {
                let trim = trim::steady(model, speed, 0.0, None)?;
                let linear = linearise(model, &trim.state, &trim.action);
                (eigenvalues(&linear.lateral().a), eigenvalues(&linear.in_plane().a))
            }
        };
        for &eigenvalue in in_plane.iter().filter(|e| e.im >= 0.0) {
            modes.push(Mode { speed, name: Name::InPlane, eigenvalue });
        }
        lateral.push((speed, out_of_plane));
    }
    modes.extend(name(&lateral));
    modes.sort_by(|a, b| {
        (a.speed, a.name).partial_cmp(&(b.speed, b.name)).expect("speeds are numbers")
    });
    Ok(modes)
}

/// Follows weave, wobble and capsize down from the highest speed, where they lie apart.
fn name(lateral: &[(f64, Vec<Complex<f64>>)]) -> Vec<Mode> {
    let mut modes = Vec::new();
    let mut previous: [Option<Complex<f64>>; 3] = [None; 3];
    for (speed, list) in lateral.iter().rev() {
        let upper: Vec<Complex<f64>> = list.iter().copied().filter(|e| e.im >= 0.0).collect();
        let mut taken = vec![false; upper.len()];
        let first = previous.iter().all(Option::is_none);
        for (slot, mode_name) in [Name::Weave, Name::Wobble, Name::Capsize].into_iter().enumerate()
        {
            let suits = |e: &Complex<f64>| match mode_name {
                Name::Weave => e.im > 1e-6 && (!first || e.im < 33.0),
                Name::Wobble => e.im > 1e-6 && (!first || e.im >= 33.0),
                _ => e.im.abs() <= 1e-6,
            };
            let cost = |e: &Complex<f64>| match (previous[slot], mode_name) {
                (_, Name::Capsize) => e.norm(),
                (Some(before), _) => (e - before).norm(),
                (None, _) => -e.re,
            };
            let best = (0..upper.len())
                .filter(|&k| !taken[k] && suits(&upper[k]))
                .min_by(|&a, &b| cost(&upper[a]).total_cmp(&cost(&upper[b])));
            let missing = previous[slot].is_none() && !first;
            if let Some(k) = best
                && !missing
            {
                taken[k] = true;
                previous[slot] = Some(upper[k]);
                modes.push(Mode { speed: *speed, name: mode_name, eigenvalue: upper[k] });
            } else {
                previous[slot] = None;
            }
        }
        for (&eigenvalue, _) in upper.iter().zip(&taken).filter(|(_, taken)| !**taken) {
            modes.push(Mode { speed: *speed, name: Name::Lateral, eigenvalue });
        }
    }
    modes
}
