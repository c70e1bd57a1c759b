//! The filter from the first sample to the last.

use crate::statistics::angles::wrapped;
use nalgebra::{Rotation3, Vector3};

use super::align::Alignment;
use super::fault::Fault;
use super::level::Felt;
use super::log::{Epoch, Log};
use super::products::{add_outer, times};
use super::rows::{Kind, Measurement, Source, running};
use super::state::{Covariance, Errors, GYRO, P, State, THETA, V, prior};
use super::strapdown::{Noise, Transition, forgetting, step, transition};
use crate::filter::band::high_cut;
use crate::statistics::runs::runs;

/// Steps of the filter, Hz, at most.
const STEPS: f64 = 50.0;
/// Cuts of what stands in rows and outputs, Hz: force and rate at an epoch, and both in the outputs.
const CUTS: [f64; 3] = [3.0, 6.0, 8.0];
/// Slow readings of the other sensors, Hz.
const WHEEL_RATE: f64 = 10.0;
/// Of the lean, Hz.
const LEAN_RATE: f64 = 2.0;
/// Of straight running, Hz: its errors last, so more readings would not know more.
const STRAIGHT_RATE: f64 = 2.0;

/// Everything that a pass does not change.
pub(super) struct Problem<'a> {
    pub log: &'a Log,
    pub epochs: Vec<Epoch>,
    /// Measured rates and forces, body axes; and low-passed for rows.
    w: Vec<Vector3<f64>>,
    f: Vec<Vector3<f64>>,
    w_row: Vec<Vector3<f64>>,
    f_row: Vec<Vector3<f64>>,
    pub felt: Vec<Felt>,
    pub noise: Noise,
    /// The filter's steps, in order.
    pub nodes: Vec<Node>,
    pub arm: Vector3<f64>,
    /// Least steps of the receiver's numbers: speed, course.
    step: [f64; 2],
    course: bool,
    climb: bool,
    /// Mean velocity noise over the usual, found by an earlier pass.
    pub noisier: f64,
}

/// A step of the filter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Node {
    pub sample: usize,
    /// Whether the log begins anew with it.
    pub first: bool,
}

/// Where a stretch without gaps begins.
#[derive(Debug, Clone)]
pub(super) struct Start {
    pub node: usize,
    /// Position, velocity and attitude.
    pub state: State,
    /// How well they are known.
    pub sd: Errors,
}

/// Start of a pass.
#[derive(Debug, Clone)]
pub(super) struct Begin {
    pub starts: Vec<Start>,
    /// Delay that epochs are placed by, s.
    pub delay: f64,
}

/// A scalar update that was made.
pub(super) struct Update {
    pub slopes: Errors,
    pub gain: Errors,
    pub variance: f64,
    pub innovation: f64,
}

/// A step with everything that the way back needs.
pub(super) struct Stored {
    pub state: State,
    pub covariance: Box<Covariance>,
    pub updates: Vec<Update>,
    /// To the next step.
    pub transition: Option<Transition>,
}

/// How a source fared.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Tally {
    pub used: usize,
    pub refused: usize,
    /// Sum of squared innovations over their variances, of those used.
    pub squares: f64,
}

/// Where the filter stands before the measurements of a step.
#[derive(Clone)]
pub(super) struct Stand {
    pub state: State,
    pub covariance: Box<Covariance>,
}

/// Low-passes three axes stretch by stretch.
fn slow(
    x: &[Vector3<f64>],
    stretches: &[std::ops::Range<usize>],
    rate: f64,
    cut: f64,
) -> Vec<Vector3<f64>> {
    let mut out = x.to_vec();
    for stretch in stretches {
        for k in 0..3 {
            let mut line: Vec<f64> = x[stretch.clone()].iter().map(|v| v[k]).collect();
            high_cut(&mut line, rate, cut);
            line.iter().zip(&mut out[stretch.clone()]).for_each(|(y, v)| v[k] = *y);
        }
    }
    out
}

/// White noise per sample: its part above 10 Hz, over the whole band.
fn white(x: &[Vector3<f64>], stretches: &[std::ops::Range<usize>], rate: f64) -> f64 {
    let cut = f64::min(10.0, 0.2 * rate);
    let smooth = slow(x, stretches, rate, cut);
    let (mut n, mut sum) = (0.0, 0.0);
    for i in stretches.iter().cloned().flatten() {
        n += 3.0;
        sum += (x[i] - smooth[i]).norm_squared();
    }
    1.2 * (sum / f64::max(n, 1.0) * 0.5 * rate / (0.5 * rate - cut)).sqrt()
}

/// Least step between the numbers of a receiver; zero if they are as good as continuous.
fn quantum(of: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = of.filter(|x| x.is_finite()).collect();
    all.sort_by(f64::total_cmp);
    let steps = all.windows(2).map(|p| p[1] - p[0]).filter(|d| *d > 1e-9);
    steps.fold(f64::INFINITY, f64::min).min(1.0)
}

impl<'a> Problem<'a> {
    /// A log in its body axes.
    ///
    /// # Errors
    /// No stretch of it can be begun.
    pub(super) fn new(log: &'a Log, alignment: &Alignment) -> Result<(Self, Begin), Fault> {
        let sign = if alignment.reversed { -1.0 } else { 1.0 };
        let turned = |x: &[Vec<f64>; 3], sign: f64| -> Vec<Vector3<f64>> {
            (0..log.len())
                .map(|i| alignment.mounting * Vector3::from_fn(|k, _| sign * x[k][i]))
                .collect()
        };
        let (w, f) = (turned(&log.rates, 1.0), turned(&log.forces, sign));
        let sound: Vec<f64> =
            (0..log.len()).map(|i| if log.whole(i) { 0.0 } else { f64::NAN }).collect();
        let stretches: Vec<_> =
            runs(&sound).into_iter().filter(|r| r.len() as f64 > 2.0 * log.rate).collect();
        let every = (log.rate / STEPS).ceil().max(1.0) as usize;
        let mut nodes = Vec::new();
        for stretch in &stretches {
            let last = stretch.end - 1;
            let samples = stretch
                .clone()
                .step_by(every)
                .chain((!(last - stretch.start).is_multiple_of(every)).then_some(last));
            nodes.extend(samples.map(|sample| Node { sample, first: sample == stretch.start }));
        }
        let mut epochs = log.epochs.clone();
        if alignment.mirrored {
            epochs.iter_mut().for_each(|e| e.course = -e.course);
        }
        let has = |of: &dyn Fn(&Epoch) -> f64| {
            epochs.iter().filter(|e| of(e).is_finite()).count() * 2 > epochs.len()
        };
        let (course, climb) = (has(&|e| e.course), has(&|e| e.climb));
        let step = [
            quantum(epochs.iter().map(|e| e.speed)),
            quantum(epochs.iter().map(|e| wrapped(e.course))),
        ];
        let [row_force, row_rate, out] = CUTS;
        let (w_out, f_out) =
            (slow(&w, &stretches, log.rate, out), slow(&f, &stretches, log.rate, out));
        let felt = (0..log.len())
            .map(|i| {
                let (a, b) = (i.saturating_sub(1), (i + 1).min(log.len() - 1));
                let change = (w_out[b] - w_out[a]) * log.rate / (b - a).max(1) as f64;
                let rate_rate =
                    if change.iter().all(|x| x.is_finite()) { change } else { Vector3::zeros() };
                Felt { rate: w_out[i], rate_rate, force: f_out[i] }
            })
            .collect();
        let noise = Noise {
            rate: white(&w, &stretches, log.rate).max(3e-4),
            force: white(&f, &stretches, log.rate).max(0.02),
        };
        let problem = Problem {
            w_row: slow(&w, &stretches, log.rate, row_rate),
            f_row: slow(&f, &stretches, log.rate, row_force),
            log,
            epochs,
            w,
            f,
            felt,
            noise,
            nodes,
            arm: Vector3::from(log.arm.unwrap_or_default()),
            step,
            course,
            climb,
            noisier: 1.0,
        };
        let starts = problem.starts(alignment);
        if starts.first().is_none_or(|s| s.node > 0) {
            return Err(Fault::from(
                "the log never runs straight at 5 m/s or more while the receiver sees it",
            ));
        }
        Ok((problem, Begin { starts, delay: alignment.delay }))
    }

    /// Time of a node, s.
    pub(super) fn time(&self, node: usize) -> f64 {
        self.nodes[node].sample as f64 / self.log.rate
    }

    /// Where stretches begin: a straight epoch near the beginning gives the heading, and the rates lead back to the
    /// first sample. A stretch without one is left out.
    fn starts(&self, alignment: &Alignment) -> Vec<Start> {
        let bias = alignment.mounting * alignment.bias;
        let epochs = super::align::with_course(&self.epochs);
        let rate = self.log.rate;
        let mut out = Vec::new();
        for (node, _) in self.nodes.iter().enumerate().filter(|(_, n)| n.first) {
            let first = self.nodes[node].sample;
            let last = self.last_of(node);
            let begun = epochs.iter().find_map(|e| {
                let sample = ((e.time - alignment.delay) * rate).round();
                let there = sample >= first as f64 && sample <= last as f64;
                let fine = there && e.speed > 5.0 && e.course.is_finite();
                let at = sample.max(0.0) as usize;
                (fine && (self.w_row[at.min(last)] - bias).norm() < 0.1).then_some((at, e))
            });
            let Some((at, epoch)) = begun else { continue };
            let mut state = State::usual();
            state.other.fixed_rows_mut::<3>(GYRO).copy_from(&bias);
            state.attitude = Rotation3::from_axis_angle(&Vector3::z_axis(), epoch.course);
            for i in (first..at).rev() {
                let w = 0.5 * (self.w[i] + self.w[i + 1]) - bias;
                state.attitude *= Rotation3::from_scaled_axis(w * (-1.0 / rate));
            }
            let near = epochs.iter().min_by(|a, b| {
                let far = |e: &Epoch| (e.time - alignment.delay - self.time(node)).abs();
                far(a).total_cmp(&far(b))
            });
            let mut sd = prior();
            if let Some(e) = near {
                let far = (e.time - alignment.delay - self.time(node)).abs();
                if e.speed.is_finite() {
                    let forward = state.attitude * Vector3::x();
                    let course =
                        if e.course.is_finite() { e.course } else { forward.y.atan2(forward.x) };
                    state.velocity = Vector3::new(course.cos(), course.sin(), 0.0) * e.speed;
                }
                if e.place.iter().all(|x| x.is_finite()) {
                    state.position = Vector3::from(e.place);
                }
                for i in 0..3 {
                    sd[V + i] += 8.0 * far.min(3.0);
                    sd[P + i] += e.speed.max(1.0) * far.min(10.0);
                }
            }
            let away = (at - first) as f64 / rate;
            for i in 0..3 {
                sd[THETA + i] = (sd[THETA + i] + 9e-4 * away).min(0.35);
            }
            out.push(Start { node, state, sd });
        }
        out
    }

    /// Last sample of the stretch that begins with a node.
    pub(super) fn last_of(&self, node: usize) -> usize {
        let next = self.nodes[node + 1..].iter().position(|n| n.first);
        let end = next.map_or(self.nodes.len(), |k| node + 1 + k);
        self.nodes[end - 1].sample
    }

    /// Epochs by node.
    pub(super) fn placed(&self, delay: f64) -> Vec<Vec<usize>> {
        let mut out = vec![Vec::new(); self.nodes.len()];
        let rate = self.log.rate;
        let reach = (rate / STEPS).ceil().max(1.0) / rate;
        for (i, e) in self.epochs.iter().enumerate() {
            let place = (e.time - delay) * rate;
            let after = self.nodes.partition_point(|n| (n.sample as f64) < place);
            let near = [after.wrapping_sub(1), after].into_iter().filter(|&k| k < self.nodes.len());
            let far = |k: usize| (self.nodes[k].sample as f64 - place).abs() / rate;
            if let Some(k) = near.min_by(|&a, &b| far(a).total_cmp(&far(b)))
                && far(k) <= reach
            {
                out[k].push(i);
            }
        }
        out
    }

    /// Measurements at a step.
    fn measurements(
        &self,
        k: usize,
        state: &State,
        epochs: &[usize],
        delay: f64,
    ) -> Vec<Measurement> {
        let sample = self.nodes[k].sample;
        let (rate, force, arm) = (self.w_row[sample], self.f_row[sample], self.arm);
        let mut out = Vec::new();
        let mut put = |kind: Kind, value: f64, sd: f64, ahead: f64| {
            if value.is_finite() {
                out.push(Measurement { kind, value, variance: sd * sd, rate, force, ahead, arm });
            }
        };
        for e in epochs.iter().map(|&i| &self.epochs[i]) {
            self.epoch(e, e.time - delay - self.time(k), &mut put);
        }
        let due = |hertz: f64| {
            let every = self.log.rate / hertz;
            let before = (sample as f64 - (self.log.rate / STEPS).ceil().max(1.0)).max(-1.0);
            (sample as f64 / every).floor() > (before / every).floor()
        };
        let (speed, forward, straight) = running(state, &rate, &force);
        if due(STRAIGHT_RATE) && straight {
            let degree = 1_f64.to_radians();
            put(Kind::Roll, 0.0, 1.2 * degree, 0.0);
            if forward.abs() < 1.0 {
                put(Kind::Pitch, 0.0, 1.5 * degree, 0.0);
            }
            put(Kind::Side, 0.0, 0.3 * degree * speed + 0.03, 0.0);
        }
        if due(WHEEL_RATE) && forward > -1.0 && speed > 3.0 {
            for (wheel, spin) in self.log.wheels.iter().enumerate() {
                let Some(spin) = spin.as_ref().filter(|_| wheel == 0 || forward < 2.0) else {
                    continue;
                };
                let sd =
                    (speed * (0.015 + 0.015 * forward.abs()) + 0.1) / super::state::USUAL_RADIUS;
                put(Kind::Wheel(wheel), spin[sample], sd, 0.0);
            }
        }
        if let Some(lean) = self.log.lean.as_ref().filter(|_| due(LEAN_RATE)) {
            put(Kind::Lean, lean[sample], 0.5_f64.to_radians() + 0.02 * lean[sample].abs(), 0.0);
        }
        out
    }

    fn epoch(&self, e: &Epoch, ahead: f64, put: &mut dyn FnMut(Kind, f64, f64, f64)) {
        let step = |q: f64| q / 12_f64.sqrt();
        let usual = self.noisier * if self.epochs_per_second() > 15.0 { 0.06 } else { 0.04 };
        let along = usual.hypot(step(self.step[0]));
        if e.speed < 0.3 {
            put(Kind::Along(Vector3::x()), 0.0, 0.15, ahead);
            put(Kind::Along(Vector3::y()), 0.0, 0.15, ahead);
        } else if self.course && e.course.is_finite() {
            let (sin, cos) = e.course.sin_cos();
            // a slow receiver does not know its course
            let slow = if e.speed < 3.0 { 0.3 } else { 0.0 };
            let across = usual.hypot(step(self.step[1]) * e.speed).hypot(slow);
            put(Kind::Along(Vector3::new(cos, sin, 0.0)), e.speed, along, ahead);
            put(Kind::Along(Vector3::new(-sin, cos, 0.0)), 0.0, across, ahead);
        } else if e.speed > 1.0 {
            put(Kind::Speed, e.speed, along, ahead);
        }
        if self.climb {
            put(Kind::Along(Vector3::z()), e.climb, 2.0 * usual, ahead);
        } else {
            // roads are not steep
            let sparse = self.epochs_per_second().max(1.0).sqrt();
            put(Kind::Along(Vector3::z()), 0.0, sparse * (0.3 + 0.05 * e.speed.max(0.0)), ahead);
            put(Kind::Place(2), e.place[2], 1.0, ahead);
        }
        if !self.course {
            put(Kind::Place(0), e.place[0], 0.1, ahead);
            put(Kind::Place(1), e.place[1], 0.1, ahead);
        }
    }

    fn epochs_per_second(&self) -> f64 {
        let (Some(first), Some(last)) = (self.epochs.first(), self.epochs.last()) else {
            return 1.0;
        };
        (self.epochs.len() - 1) as f64 / (last.time - first.time).max(1e-3)
    }

    /// The state at a step from that of the step before.
    fn onwards(&self, k: usize, state: &State, begin: &Begin) -> (State, Transition) {
        if self.nodes[k + 1].first {
            let start = begin.starts.iter().find(|s| s.node == k + 1);
            let anew = start.map_or(*state, |s| State { other: state.other, ..s.state });
            let sd = start.map_or_else(prior, |s| s.sd);
            return (anew, forgetting(&sd));
        }
        let (from, to) = (self.nodes[k].sample, self.nodes[k + 1].sample);
        let dt = 1.0 / self.log.rate;
        let mut after = *state;
        let (mut w, mut f) = (Vector3::zeros(), Vector3::zeros());
        for i in from..to {
            after = step(&after, [&self.w[i], &self.w[i + 1]], [&self.f[i], &self.f[i + 1]], dt);
            w += 0.5 * (self.w[i] + self.w[i + 1]);
            f += 0.5 * (self.f[i] + self.f[i + 1]);
        }
        let n = (to - from) as f64;
        let t = transition([state, &after], &(w / n), &(f / n), (to - from, dt), self.noise);
        after.other.component_mul_assign(&t.decay);
        (after, t)
    }

    /// The state some samples after a step, within it.
    pub(super) fn between(&self, state: &State, from: usize, to: usize) -> State {
        let dt = 1.0 / self.log.rate;
        (from..to).fold(*state, |s, i| {
            step(&s, [&self.w[i], &self.w[i + 1]], [&self.f[i], &self.f[i + 1]], dt)
        })
    }

    /// Filters the steps of a range from where it stands before the first; `keep` gets each, `tally` how the sources
    /// fared. Returns where it stands before the step after the last.
    pub(super) fn filter(
        &self,
        steps: std::ops::Range<usize>,
        from: &Stand,
        (begin, placed): (&Begin, &[Vec<usize>]),
        mut keep: Option<&mut Vec<Stored>>,
        tally: &mut [Tally; Source::ALL.len()],
    ) -> Stand {
        let mut stand = from.clone();
        for k in steps {
            let mut updates = Vec::new();
            for m in self.measurements(k, &stand.state, &placed[k], begin.delay) {
                let (innovation, slopes) = m.innovation(&stand.state);
                let gain = times(&stand.covariance, &slopes);
                let variance = slopes.dot(&gain) + m.variance;
                let source = m.kind.source();
                let t = &mut tally[source as usize];
                let square = innovation * innovation / variance;
                if square.is_nan() || square > source.gate() {
                    t.refused += 1;
                    continue;
                }
                t.used += 1;
                t.squares += square;
                add_outer(&mut stand.covariance, -1.0 / variance, &gain, &gain);
                let gain = gain / variance;
                stand.state = stand.state.corrected(&(gain * innovation));
                if keep.is_some() {
                    updates.push(Update { slopes, gain, variance, innovation });
                }
            }
            let next = (k + 1 < self.nodes.len()).then(|| self.onwards(k, &stand.state, begin));
            if let Some(keep) = &mut keep {
                keep.push(Stored {
                    state: stand.state,
                    covariance: stand.covariance.clone(),
                    updates,
                    transition: next.as_ref().map(|(_, t)| t.clone()),
                });
            }
            if let Some((state, transition)) = next {
                transition.advance(&mut stand.covariance);
                stand.state = state;
            }
        }
        stand
    }
}
