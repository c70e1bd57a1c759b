//! Laps over the same places: every timed lap on the stations of the fastest.

use super::find::{DetectedLaps, Kind, Lap};
use super::ground::{Ground, Point, dot, interpolated, minus, unit};

/// Between stations, m, unless that were more than [`MAX_STATIONS`].
const STEP: f64 = 5.0;
const MAX_STATIONS: f64 = 1000.0;
/// A sample is looked for this far from where its distance puts it, m.
const REACH: f64 = 60.0;
/// Farther from the fastest lap's line it says nothing, m.
const ASIDE: f64 = 40.0;
/// Half the time over which places are averaged, s.
const HALF: f64 = 1.5;

/// The stations of a track.
#[derive(Debug, Clone)]
pub(crate) struct Stations {
    /// Between two, m.
    pub step: f64,
    /// Length of the lap, m.
    pub length: f64,
    pub at: Vec<Point>,
}

/// When a lap was at each station, s from the lap's start.
#[derive(Debug, Clone)]
pub(crate) struct Trace {
    /// Index of the lap.
    pub lap: usize,
    /// By station, rising.
    pub time: Vec<f64>,
}

impl Stations {
    /// Along the fastest lap.
    pub(crate) fn new(ground: &Ground, lap: &Lap) -> Option<Self> {
        let mut path: Vec<(f64, Point)> = Vec::new();
        for i in within(ground, lap).filter(|&i| ground.known(i)) {
            let p = ground.at[i];
            let along = match path.last() {
                Some((s, q)) => s + minus(p, *q)[0].hypot(minus(p, *q)[1]),
                None => 0.0,
            };
            path.push((along, p));
        }
        let length = path.last()?.0;
        if path.len() < 20 || length < 50.0 {
            return None;
        }
        let count = (length / STEP).round().min(MAX_STATIONS);
        let step = length / count;
        let mut k = 0;
        let at = (0..=count as usize)
            .map(|n| {
                let s = n as f64 * step;
                while k + 2 < path.len() && path[k + 1].0 < s {
                    k += 1;
                }
                let ((a, p), (b, q)) = (path[k], path[k + 1]);
                let share = if b > a { ((s - a) / (b - a)).clamp(0.0, 1.0) } else { 0.0 };
                [0, 1].map(|c| p[c] + share * (q[c] - p[c]))
            })
            .collect();
        Some(Stations { step, length, at })
    }

    fn direction(&self, k: usize) -> Option<Point> {
        unit(minus(self.at[(k + 1).min(self.at.len() - 1)], self.at[k.saturating_sub(1)]))
    }

    /// Station of a point near where it is expected, m.
    fn project(&self, p: Point, about: f64) -> Option<f64> {
        let last = self.at.len() - 1;
        let from = ((about - REACH) / self.step).max(0.0) as usize;
        let to = (((about + REACH) / self.step).max(0.0) as usize).min(last);
        let far = |k: usize| {
            let off = minus(p, self.at[k]);
            off[0].hypot(off[1])
        };
        let near = (from.min(last)..=to).min_by(|&a, &b| far(a).total_cmp(&far(b)))?;
        if far(near) > ASIDE {
            return None;
        }
        Some(near as f64 * self.step + dot(minus(p, self.at[near]), self.direction(near)?))
    }

    /// A lap over the stations: its distance by the speed, put right by its positions.
    fn trace(&self, ground: &Ground, number: usize, lap: &Lap) -> Trace {
        let from = ground.ridden_at(lap.start);
        let scale = self.length / lap.distance;
        let expected = |time: f64| (ground.ridden_at(time) - from) * scale;
        let off: Vec<(f64, f64)> = within(ground, lap)
            .filter(|&i| ground.known(i))
            .filter_map(|i| {
                let time = i as f64 / ground.rate;
                let about = expected(time);
                Some((time, self.project(ground.at[i], about)? - about))
            })
            .collect();
        let off = smoothed(&off);
        let at = |time: f64| match off.partition_point(|o| o.0 < time) {
            0 => off.first().map_or(0.0, |o| o.1),
            n if n == off.len() => off[n - 1].1,
            n => {
                let ((a, x), (b, y)) = (off[n - 1], off[n]);
                x + (time - a) / (b - a) * (y - x)
            }
        };
        // line to line: nothing at both ends
        let ends = [at(lap.start), at(lap.end)];
        let steps = (lap.duration() * 10.0).ceil().max(2.0) as usize;
        let mut known: Vec<(f64, f64)> = vec![(0.0, 0.0)];
        for n in 1..steps {
            let time = lap.duration() * n as f64 / steps as f64;
            let share = n as f64 / steps as f64;
            let tilt = ends[0] + share * (ends[1] - ends[0]);
            let station = expected(lap.start + time) + at(lap.start + time) - tilt;
            let before = known[known.len() - 1].0;
            if station > before && station < self.length {
                known.push((station, time));
            }
        }
        known.push((self.length, lap.duration()));
        let mut k = 0;
        let time = (0..self.at.len())
            .map(|n| {
                let s = n as f64 * self.step;
                while k + 2 < known.len() && known[k + 1].0 < s {
                    k += 1;
                }
                let ((a, t), (b, u)) = (known[k], known[k + 1]);
                t + ((s - a) / (b - a)).clamp(0.0, 1.0) * (u - t)
            })
            .collect();
        Trace { lap: number, time }
    }

    pub(crate) fn traces(&self, ground: &Ground, found: &DetectedLaps) -> Vec<Trace> {
        let timed = found.laps.iter().enumerate().filter(|(_, l)| l.kind == Kind::Timed);
        timed.map(|(number, lap)| self.trace(ground, number, lap)).collect()
    }
}

impl Trace {
    /// A signal of the ride at every station.
    pub(crate) fn of(&self, signal: &[f64], lap: &Lap, rate: f64) -> Vec<f64> {
        self.time.iter().map(|t| interpolated(signal, (lap.start + t) * rate)).collect()
    }
}

/// Samples of a lap, ten a second at most.
fn within(ground: &Ground, lap: &Lap) -> impl Iterator<Item = usize> {
    let step = (ground.rate / 10.0).floor().max(1.0) as usize;
    let last = ground.samples() - 1;
    let from = ((lap.start * ground.rate).ceil() as usize).min(last);
    let to = ((lap.end * ground.rate) as usize).min(last);
    (from..=to).step_by(step)
}

/// Means over [`HALF`] to each side.
fn smoothed(x: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (mut from, mut to, mut sum) = (0, 0, 0.0);
    x.iter()
        .map(|(time, _)| {
            while to < x.len() && x[to].0 <= time + HALF {
                sum += x[to].1;
                to += 1;
            }
            while x[from].0 < time - HALF {
                sum -= x[from].1;
                from += 1;
            }
            (*time, sum / (to - from) as f64)
        })
        .collect()
}
