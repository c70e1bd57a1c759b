//! Propagation of state and covariance between two steps of the filter.
//!
//! ```text
//! theta' = -[w]x theta - db_g - dM w      dv' = -R [f]x theta - R db_a      dp' = dv
//! ```

use nalgebra::{Matrix3, Rotation3, SMatrix, Vector3};

use super::products::{product, product_transposed};
use super::state::{
    Covariance, DOPPLER, DOPPLER_TIME, Errors, FORCE, GYRO, LEAN, LEAN_TIME, N, P, SCALE, State,
    THETA, V, prior,
};
use crate::GRAVITY;

/// The rows of position, velocity and attitude of a transition.
pub(super) type Top = SMatrix<f64, 9, N>;

/// A transition: `top` for the first nine errors, `decay` times itself for each other.
#[derive(Debug, Clone)]
pub(super) struct Transition {
    /// Rows of the first nine.
    pub top: Top,
    /// Of the others; the first nine are not used.
    pub decay: Errors,
    /// Variance that is added.
    pub added: Errors,
}

/// White noise of the unit, per sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Noise {
    /// Of a rate, rad/s.
    pub rate: f64,
    /// Of a specific force, m/s².
    pub force: f64,
}

/// Walk of the rates' bias: 0.03 degrees a second with a correlation time of 100 s.
const GYRO_WALK: [f64; 2] = [5.2e-4, 100.0];
/// Walk of the forces' bias, m/s² and s.
const FORCE_WALK: [f64; 2] = [0.03, 100.0];
/// Walk of the receiver's place, horizontal, m and s.
const PLACE_WALK: [f64; 2] = [1.0, 30.0];
/// Walk of its height, m and s.
const HEIGHT_WALK: [f64; 2] = [2.0, 30.0];

/// Gravity in the world.
pub(super) fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -GRAVITY)
}

/// One sample of the unit to the next, `dt` s later: rates and forces go evenly between.
pub(super) fn step(
    state: &State,
    [w0, w1]: [&Vector3<f64>; 2],
    [f0, f1]: [&Vector3<f64>; 2],
    dt: f64,
) -> State {
    let w = 0.5 * (state.rate(w0) + state.rate(w1));
    let attitude = state.attitude * Rotation3::from_scaled_axis(w * dt);
    let force = 0.5 * (state.attitude * state.force(f0) + attitude * state.force(f1));
    let acceleration = force + gravity();
    State {
        position: state.position + (state.velocity + acceleration * (0.5 * dt)) * dt,
        velocity: state.velocity + acceleration * dt,
        attitude,
        other: state.other,
    }
}

/// The transition over `samples` samples of `dt` s that together turned the state `before` into `after`, with the
/// mean measured rate and force between.
pub(super) fn transition(
    [before, after]: [&State; 2],
    w: &Vector3<f64>,
    f: &Vector3<f64>,
    (samples, dt): (usize, f64),
    noise: Noise,
) -> Transition {
    let span = samples as f64 * dt;
    let w = before.rate(w);
    let turned = after.attitude.inverse() * before.attitude;
    // in the middle, where an attitude error has turned with the body
    let turn = Rotation3::from_scaled_axis(w * (0.5 * span));
    let half = before.attitude * turn;
    let force = half.matrix() * before.force(f).cross_matrix() * turn.inverse().matrix();
    let mut top = Top::zeros();
    let identity = Matrix3::identity();
    let mut put = |row: usize, column: usize, m: Matrix3<f64>| {
        top.fixed_view_mut::<3, 3>(row, column).copy_from(&m);
    };
    put(P, P, identity);
    put(P, V, identity * span);
    put(P, THETA, force * (-0.5 * span * span));
    put(V, V, identity);
    put(V, THETA, force * -span);
    put(V, GYRO, force * (0.5 * span * span));
    put(V, FORCE, half.matrix() * -span);
    put(THETA, THETA, *turned.matrix());
    put(THETA, GYRO, identity * -span);
    for i in 0..3 {
        for j in 0..3 {
            let column = SCALE + 3 * i + j;
            top[(THETA + i, column)] = -w[j] * span;
            for k in 0..3 {
                top[(V + k, column)] = force[(k, i)] * (0.5 * span * span * w[j]);
            }
        }
    }
    let mut decay = Errors::repeat(1.0);
    let mut added = Errors::zeros();
    let walk = |[sd, time]: [f64; 2]| 2.0 * sd * sd / time * span;
    let each = samples as f64 * dt * dt;
    for i in 0..3 {
        added[P + i] = walk(if i < 2 { PLACE_WALK } else { HEIGHT_WALK });
        added[V + i] = noise.force.powi(2) * each;
        added[THETA + i] = noise.rate.powi(2) * each;
        added[GYRO + i] = walk(GYRO_WALK);
        added[FORCE + i] = walk(FORCE_WALK);
    }
    let sd = prior();
    let mut markov = |at: usize, time: f64| {
        decay[at] = (-span / time).exp();
        added[at] = sd[at].powi(2) * (1.0 - decay[at].powi(2));
    };
    (DOPPLER..DOPPLER + 3).for_each(|i| markov(i, DOPPLER_TIME));
    markov(LEAN, LEAN_TIME);
    Transition { top, decay, added }
}

/// Forgets position, velocity and attitude, which are known anew with these standard deviations.
pub(super) fn forgetting(sd: &Errors) -> Transition {
    let mut added = Errors::zeros();
    for i in 0..9 {
        added[i] = sd[i].powi(2);
    }
    Transition { top: Top::zeros(), decay: Errors::repeat(1.0), added }
}

impl Transition {
    /// The covariance a step later.
    pub(super) fn advance(&self, p: &mut Covariance) {
        let rows = product(&self.top, p);
        let corner = product(&rows, &self.top.transpose());
        for j in 9..N {
            for i in 9..N {
                p[(i, j)] *= self.decay[i] * self.decay[j];
            }
            for i in 0..9 {
                let x = rows[(i, j)] * self.decay[j];
                p[(i, j)] = x;
                p[(j, i)] = x;
            }
        }
        p.fixed_view_mut::<9, 9>(0, 0).copy_from(&(0.5 * (corner + corner.transpose())));
        for i in 0..N {
            p[(i, i)] += self.added[i];
        }
    }

    /// Quantities that follow from later measurements, a step earlier: `F' l` and `F' L F`.
    pub(super) fn back(&self, vector: &mut Errors, matrix: &mut Covariance) {
        let from_top = product_transposed(&self.top, &vector.fixed_rows::<9>(0).into_owned());
        for i in 0..N {
            let own = if i < 9 { 0.0 } else { self.decay[i] * vector[i] };
            vector[i] = own + from_top[i];
        }
        let mut right = product(&matrix.fixed_columns::<9>(0).into_owned(), &self.top);
        for j in 9..N {
            for i in 0..N {
                right[(i, j)] += matrix[(i, j)] * self.decay[j];
            }
        }
        *matrix = product_transposed(&self.top, &right.fixed_rows::<9>(0).into_owned());
        for j in 0..N {
            for i in 9..N {
                matrix[(i, j)] += self.decay[i] * right[(i, j)];
            }
        }
    }

    /// The transition as one matrix.
    #[cfg(test)]
    pub(crate) fn matrix(&self) -> Covariance {
        let mut f = Covariance::zeros();
        (9..N).for_each(|i| f[(i, i)] = self.decay[i]);
        f.fixed_rows_mut::<9>(0).copy_from(&self.top);
        f
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::statistics::random::Random;

    fn some_state(random: &mut Random) -> State {
        let mut errors = Errors::zeros();
        errors.iter_mut().for_each(|x| *x = 0.05 * random.normal());
        errors.fixed_rows_mut::<9>(SCALE).scale_mut(0.1);
        let mut state = State::usual();
        state.attitude = Rotation3::from_euler_angles(-0.6, 0.1, 2.0);
        state.velocity = Vector3::new(-8.0, 15.0, 0.3);
        state.corrected(&errors)
    }

    /// Error of a state against another.
    fn difference(a: &State, b: &State) -> Errors {
        let mut out = a.other - b.other;
        out.fixed_rows_mut::<3>(P).copy_from(&(a.position - b.position));
        out.fixed_rows_mut::<3>(V).copy_from(&(a.velocity - b.velocity));
        let turn = (b.attitude.inverse() * a.attitude).scaled_axis();
        out.fixed_rows_mut::<3>(THETA).copy_from(&turn);
        out
    }

    #[test]
    fn the_transition_is_the_derivative_of_the_step() {
        let mut random = Random::new(1, "transition");
        let state = some_state(&mut random);
        let (w, f) = (Vector3::new(0.4, -0.2, 0.7), Vector3::new(1.0, 0.3, 12.0));
        let dt = 0.01;
        let twice = |s: &State| step(&step(s, [&w, &w], [&f, &f], dt), [&w, &w], [&f, &f], dt);
        let after = twice(&state);
        let noise = Noise { rate: 0.0, force: 0.0 };
        let found = transition([&state, &after], &w, &f, (2, dt), noise).matrix();
        for j in 0..N {
            // correlated errors decay by their own law, not by the step
            if (DOPPLER..DOPPLER + 3).contains(&j) || j == LEAN {
                continue;
            }
            // a rotation of less than a millionth is lost in its matrix
            let mut errors = Errors::zeros();
            errors[j] = 1e-3;
            let above = difference(&twice(&state.corrected(&errors)), &after);
            errors[j] = -1e-3;
            let below = difference(&twice(&state.corrected(&errors)), &after);
            for i in 0..N {
                let true_one = (above[i] - below[i]) / 2e-3;
                // first order over 20 ms, of entries up to 0.25
                assert!(
                    (found[(i, j)] - true_one).abs() < 1e-3,
                    "{i} {j}: {} {true_one}",
                    found[(i, j)]
                );
            }
        }
    }

    #[test]
    fn covariance_and_its_adjoint_go_by_the_matrix() {
        let mut random = Random::new(2, "transition");
        let state = some_state(&mut random);
        let (w, f) = (Vector3::new(0.4, -0.2, 0.7), Vector3::new(1.0, 0.3, 12.0));
        let after = step(&state, [&w, &w], [&f, &f], 0.02);
        let noise = Noise { rate: 0.01, force: 0.2 };
        let t = transition([&state, &after], &w, &f, (1, 0.02), noise);
        let root = Covariance::from_fn(|_, _| random.normal());
        let p = root * root.transpose();
        let full = t.matrix();
        let mut advanced = p;
        t.advance(&mut advanced);
        let expected = full * p * full.transpose() + Covariance::from_diagonal(&t.added);
        assert!((advanced - expected).abs().max() < 1e-9);
        let (mut vector, mut matrix) = (root.column(3).into_owned(), p);
        t.back(&mut vector, &mut matrix);
        assert!((vector - full.transpose() * root.column(3)).abs().max() < 1e-9);
        assert!((matrix - full.transpose() * p * full).abs().max() < 1e-8);
    }
}
