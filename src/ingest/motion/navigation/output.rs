//! Level-frame channels and their standard deviations.

use nalgebra::Vector3;

use super::backward::{Smoothed, smooth};
use super::forward::{Begin, Problem, Stand};
use super::jacobian::gradients;
pub(crate) use super::level::OUTPUTS;
use super::level::outputs;
use super::products::times;
use super::state::{Covariance, DELAY, Errors, FORCE, GYRO, MOUNT, SCALE, State, THETA, V};
use crate::statistics::angles::unwrap;

/// Their names in `session.v1`.
pub const NAMES: [&str; OUTPUTS] = [
    "velocity_x",
    "velocity_y",
    "acceleration_x",
    "acceleration_y",
    "roll",
    "pitch",
    "yaw",
    "roll_rate",
    "pitch_rate",
    "yaw_rate",
];

/// Steps between those whose standard deviations are computed.
const EVERY: usize = 5;
/// Cut of the outputs, Hz: what white noise keeps of itself below it.
const CUT: f64 = 8.0;
/// Scale errors of the accelerometer, which the state does not have.
const FORCE_SCALE: f64 = 0.003;

/// Channels of the level frame, in the order of [`NAMES`]; NaN where the log has gaps.
#[derive(Debug, Clone)]
pub struct Level {
    pub values: [Vec<f64>; OUTPUTS],
    pub sd: [Vec<f64>; OUTPUTS],
}

/// One pass with outputs, what [`super::run`] ends with; and the standard deviation of the delay, s.
pub(super) fn level(problem: &Problem<'_>, begin: &Begin, first: &Stand) -> (Smoothed, Level, f64) {
    let mut knots: Vec<(usize, [f64; OUTPUTS])> = Vec::new();
    let nodes = problem.nodes.len();
    let mut delay_sd = f64::NAN;
    let smoothed = smooth(problem, begin, first, |k, state, p, l| {
        if k == 0 {
            let row = p.column(DELAY);
            delay_sd = (p[(DELAY, DELAY)] - row.dot(&(l * row))).max(0.0).sqrt();
        }
        let edge = k + 1 == nodes
            || problem.nodes[k].first
            || problem.nodes.get(k + 1).is_some_and(|n| n.first);
        if k.is_multiple_of(EVERY) || edge {
            knots.push((k, deviations(problem, k, state, p, l)));
        }
    });
    knots.reverse();
    let len = problem.log.len();
    let empty = || [0; OUTPUTS].map(|_| vec![f64::NAN; len]);
    let mut out = Level { values: empty(), sd: empty() };
    let mut put = |at: usize, state: &State| {
        let values = outputs(state, &problem.felt[at], &problem.arm);
        out.values.iter_mut().zip(values).for_each(|(line, x)| line[at] = x);
    };
    for (k, state) in smoothed.states.iter().enumerate() {
        let from = problem.nodes[k].sample;
        put(from, state);
        let Some(next) = problem.nodes.get(k + 1).filter(|n| !n.first) else { continue };
        for at in from + 1..next.sample {
            put(at, &problem.between(state, from, at));
        }
    }
    for pair in knots.windows(2) {
        let [(a, x), (b, y)] = [pair[0], pair[1]];
        let (from, to) = (problem.nodes[a].sample, problem.nodes[b].sample);
        if problem.nodes[b].first && b == a + 1 {
            continue;
        }
        for at in from..=to {
            let part = (at - from) as f64 / (to - from) as f64;
            for (line, (x, y)) in out.sd.iter_mut().zip(x.iter().zip(&y)) {
                line[at] = x + part * (y - x);
            }
        }
    }
    unwrap(&mut out.values[6]);
    (smoothed, out, delay_sd)
}

/// Standard deviations of the outputs at a step.
fn deviations(
    problem: &Problem<'_>,
    k: usize,
    state: &State,
    p: &Covariance,
    l: &Covariance,
) -> [f64; OUTPUTS] {
    const PARTS: [usize; 24] = {
        let mut out = [0; 24];
        let blocks = [(V, 3), (THETA, 3), (GYRO, 3), (FORCE, 3), (SCALE, 9), (MOUNT, 3)];
        let (mut n, mut b) = (0, 0);
        while b < blocks.len() {
            let mut i = 0;
            while i < blocks[b].1 {
                out[n] = blocks[b].0 + i;
                (n, i) = (n + 1, i + 1);
            }
            b += 1;
        }
        out
    };
    let felt = &problem.felt[problem.nodes[k].sample];
    let arm = problem.arm;
    let slopes: [Errors; OUTPUTS] = gradients(&|s| outputs(s, felt, &arm), state, &PARTS);
    let here = outputs(state, felt, &arm);
    let lever: [[f64; OUTPUTS]; 3] = [0, 1, 2].map(|i| {
        let mut moved = arm;
        moved[i] += 0.01;
        let there = outputs(state, felt, &moved);
        std::array::from_fn(|o| (there[o] - here[o]) / 0.01)
    });
    let kept = (2.0 * CUT / problem.log.rate).min(1.0).sqrt();
    let sensor = |o: usize| match o {
        2 | 3 => (kept * problem.noise.force).hypot(FORCE_SCALE * norm(&felt.force)),
        7..=9 => kept * problem.noise.rate,
        _ => 0.0,
    };
    std::array::from_fn(|o| {
        let row = times(p, &slopes[o]);
        let own = slopes[o].dot(&row) - row.dot(&times(l, &row));
        let arm: f64 = lever.iter().map(|d| (d[o] * problem.log.arm_sd).powi(2)).sum();
        (own.max(0.0) + arm + sensor(o).powi(2)).sqrt()
    })
}

fn norm(v: &Vector3<f64>) -> f64 {
    let x = v.norm();
    if x.is_finite() { x } else { 0.0 }
}
