//! The way back: what later measurements say of earlier states.
//!
//! ```text
//! l-, L-  before the updates of a step (gain K, slopes H, variance S, innovation n), from l, L after them:
//!     C = 1 - K H      l- = C' l - H' n / S      L- = C' L C + H' H / S
//! over a transition F:  l = F' l-      L = F' L- F
//! smoothed:             x = x^ - P l   with covariance  P - P L P
//! ```
//!
//! Bryson and Frazier (1963) as modified for scalar updates, e.g. Bierman, Factorization Methods for Discrete
//! Sequential Estimation (1977), chapter X. No matrix is inverted, so a state whose prior is a thousand times wider
//! than what the ride says of it does no harm; and only one block of steps is in memory.

use super::forward::{Begin, Problem, Stand, Stored, Tally, Update};
use super::products::{add_outer, times};
use super::rows::Source;
use super::state::{Covariance, Errors, State};

/// Steps that are in memory at a time.
const BLOCK: usize = 2000;

pub(super) struct Smoothed {
    /// At every step.
    pub states: Vec<State>,
    /// How the sources fared.
    pub tally: [Tally; Source::ALL.len()],
}

/// The two sums before an update, from those after it.
fn before(u: &Update, l: &mut Errors, big: &mut Covariance) {
    let along = u.gain.dot(l);
    *l -= u.slopes * (along + u.innovation / u.variance);
    // C' L C + H' H / S, as rank-one changes
    let row = times(big, &u.gain);
    let square = u.gain.dot(&row) + 1.0 / u.variance;
    add_outer(big, -1.0, &u.slopes, &row);
    add_outer(big, -1.0, &row, &u.slopes);
    add_outer(big, square, &u.slopes, &u.slopes);
}

/// Filters and smooths; `look` gets the covariance of every smoothed state as `(step, state, P, L)`.
pub(super) fn smooth(
    problem: &Problem<'_>,
    begin: &Begin,
    first: &Stand,
    mut look: impl FnMut(usize, &State, &Covariance, &Covariance),
) -> Smoothed {
    let n = problem.nodes.len();
    let placed = problem.placed(begin.delay);
    let mut tally = Default::default();
    let mut stands = Vec::new();
    let mut stand = first.clone();
    for from in (0..n).step_by(BLOCK) {
        let steps = from..(from + BLOCK).min(n);
        stands.push((steps.clone(), stand.clone()));
        stand = problem.filter(steps, &stand, (begin, &placed), None, &mut tally);
    }
    let mut states = vec![first.state; n];
    let (mut l, mut big) = (Errors::zeros(), Box::new(Covariance::zeros()));
    for (steps, stand) in stands.into_iter().rev() {
        let mut stored = Vec::with_capacity(steps.len());
        let at = (begin, &placed[..]);
        problem.filter(steps.clone(), &stand, at, Some(&mut stored), &mut Default::default());
        for (k, s) in steps.zip(stored).rev() {
            let Stored { state, covariance, updates, transition } = s;
            if let Some(t) = transition {
                t.back(&mut l, &mut big);
            }
            states[k] = state.corrected(&-times(&covariance, &l));
            look(k, &states[k], &covariance, &big);
            updates.iter().rev().for_each(|u| before(u, &mut l, &mut big));
        }
    }
    Smoothed { states, tally }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ingest::motion::navigation::state::N;
    use crate::ingest::motion::navigation::strapdown::{Top, Transition};
    use crate::statistics::random::Random;

    /// A linear case without driving noise: the first state by filter and way back against all measurements at once.
    #[test]
    fn the_first_state_is_that_of_batch_least_squares() {
        let mut random = Random::new(3, "batch");
        let mut covariance = Covariance::identity() * 0.5;
        let (mut x, mut from_first) = (Errors::zeros(), Covariance::identity());
        let (mut information, mut right) = (Covariance::identity() / 0.5, Errors::zeros());
        let mut steps = Vec::new();
        for _ in 0..6 {
            let mut updates = Vec::new();
            for _ in 0..4 {
                let slopes = Errors::from_fn(|_, _| random.normal());
                let (value, noise) = (3.0 * random.normal(), 0.2);
                let gain = covariance * slopes;
                let variance = slopes.dot(&gain) + noise;
                let innovation = value - slopes.dot(&x);
                covariance.ger(-1.0 / variance, &gain, &gain, 1.0);
                let gain = gain / variance;
                x += gain * innovation;
                updates.push(Update { slopes, gain, variance, innovation });
                let seen = from_first.tr_mul(&slopes);
                information += seen * seen.transpose() / noise;
                right += seen * (value / noise);
            }
            let mut top = Top::from_fn(|_, _| 0.05 * random.normal());
            (0..9).for_each(|i| top[(i, i)] += 1.0);
            let decay = Errors::repeat(0.97);
            let t = Transition { top, decay, added: Errors::zeros() };
            let full = t.matrix();
            steps.push((updates, t.clone()));
            t.advance(&mut covariance);
            x = full * x;
            from_first = full * from_first;
        }
        let (mut l, mut big) = (Errors::zeros(), Covariance::zeros());
        for (updates, t) in steps.iter().rev() {
            t.back(&mut l, &mut big);
            updates.iter().rev().for_each(|u| before(u, &mut l, &mut big));
        }
        let p = Covariance::identity() * 0.5;
        let batch = information.try_inverse().expect("regular");
        assert!(((p * -l) - batch * right).abs().max() < 1e-9);
        assert!((p - p * big * p - batch).abs().max() < 1e-9);
        assert_eq!(N, batch.nrows());
    }
}
