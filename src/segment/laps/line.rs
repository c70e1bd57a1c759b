//! A start line, and when it was crossed.

use super::config::Config;
use super::ground::{Ground, MOVING, Point, dot, minus, unit};

/// Longest gap of the position that a crossing may be in, s.
const GAP: f64 = 4.0;
/// Half the time over which the position places a crossing, s; twice and thrice that where too much is missing.
const HALF: f64 = 1.5;
/// How long before the fastest point the line is put, s: braking begins after it.
const BEFORE: f64 = 1.5;
/// Places that are tried for a line.
const PLACES: usize = 12;
/// Between two of them, m.
const APART: f64 = 150.0;
/// Share of the top speed that a place must have been ridden at.
const FAST: f64 = 0.6;
/// Cosine of the angle by which a crossing may be askew.
const ASKEW: f64 = 0.7;

/// Where a line came from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Source {
    Given,
    Markers,
    /// The log's own line.
    Log,
    Logger,
    Detected,
}

impl Source {
    /// As in the table.
    pub fn name(self) -> &'static str {
        match self {
            Source::Given => "given",
            Source::Markers => "markers",
            Source::Log => "log",
            Source::Logger => "logger",
            Source::Detected => "found",
        }
    }
}

/// A line across the track.
#[derive(Debug, Clone, Copy)]
pub struct Line {
    /// Its middle, m.
    pub middle: Point,
    /// Direction of travel across it, a unit vector.
    pub along: Point,
    /// Half its length, m.
    pub half_width: f64,
    /// Where it came from.
    pub source: Source,
}

/// A crossing of the line.
#[derive(Debug, Clone, Copy)]
pub struct Crossing {
    /// Between samples, s.
    pub time: f64,
    /// Its standard deviation, s.
    pub error: f64,
    /// Speed, m/s.
    #[cfg_attr(not(feature = "internals"), allow(dead_code))] // for tests and studies
    pub speed: f64,
    /// Distance ridden until then, m.
    pub ridden: f64,
}

impl Line {
    /// Before the line is negative, and to the left of its middle positive, m.
    fn coordinates(&self, p: Point) -> Point {
        let off = minus(p, self.middle);
        [dot(off, self.along), dot(off, [-self.along[1], self.along[0]])]
    }

    /// The same line, crossed the other way.
    fn reversed(self) -> Self {
        Line { along: self.along.map(|v| -v), ..self }
    }

    /// Every crossing in its direction, in order; of two without a lap between them the first.
    pub fn crossings(&self, ground: &Ground, config: &Config) -> Vec<Crossing> {
        let step = (ground.rate / 10.0).floor().max(1.0) as usize;
        let mut out: Vec<Crossing> = Vec::new();
        let mut last: Option<usize> = None;
        for i in (0..ground.samples()).step_by(step).filter(|&i| ground.known(i)) {
            let Some(j) = last.replace(i) else { continue };
            if (i - j) as f64 > GAP * ground.rate {
                continue;
            }
            let [before, after] = [j, i].map(|k| self.coordinates(ground.at[k]));
            if !(before[0] < 0.0 && after[0] >= 0.0) || ground.speed[i] < MOVING {
                continue;
            }
            let share = before[0] / (before[0] - after[0]);
            let aside = before[1] + share * (after[1] - before[1]);
            let straight =
                unit(minus(ground.at[i], ground.at[j])).is_some_and(|d| dot(d, self.along) > ASKEW);
            if aside.abs() > self.half_width || !straight {
                continue;
            }
            let about = (j as f64 + share * (i - j) as f64) / ground.rate;
            let crossing = self.refined(ground, about, config);
            if out.last().is_none_or(|c| crossing.ridden - c.ridden > config.shortest_lap) {
                out.push(crossing);
            }
        }
        out
    }

    /// The time at which the positions around say the line was crossed, the speed carrying them to it.
    ///
    /// ```text
    /// along the line's normal:  a(t) = c + b (t - t0) + ridden(t) - ridden(t0),   a = 0 at the crossing
    /// ```
    /// `c` and `b` are the least squares of the positions; `b` takes a speed that is late or a little wrong.
    fn refined(&self, ground: &Ground, about: f64, config: &Config) -> Crossing {
        let rate = ground.rate;
        let at_line = ground.ridden_at(about);
        let mut sums = [0.0; 6];
        let mut offsets: Vec<(f64, f64)> = Vec::new();
        for wider in [1.0, 2.0, 3.0] {
            let half = wider * HALF;
            let from = ((about - half) * rate).ceil().max(0.0) as usize;
            let to = (((about + half) * rate) as usize).min(ground.samples() - 1);
            let known = (from..=to).filter(|&i| ground.raw[i][0].is_finite());
            offsets = known
                .map(|i| {
                    let along = self.coordinates(ground.raw[i])[0];
                    (i as f64 / rate - about, along - (ground.ridden[i] - at_line))
                })
                .collect();
            if 2 * offsets.len() > to - from {
                break;
            }
        }
        for &(t, r) in &offsets {
            for (sum, term) in sums.iter_mut().zip([1.0, t, t * t, r, r * t, r * r]) {
                *sum += term;
            }
        }
        let [n, t1, t2, r1, rt, _] = sums;
        let spread = n * t2 - t1 * t1;
        let slope = if n > 2.0 && spread > 1e-9 { (n * rt - t1 * r1) / spread } else { 0.0 };
        let level = if n > 0.0 { (r1 - slope * t1) / n } else { 0.0 };
        let mut time = about;
        for _ in 0..4 {
            let v = ground.speed[((time * rate) as usize).min(ground.samples() - 1)].max(MOVING);
            let along = level + slope * (time - about) + ground.ridden_at(time) - at_line;
            time -= along / v;
        }
        // positions that contradict the speed place nothing
        if !time.is_finite() || (time - about).abs() > 3.0 * HALF {
            time = about;
        }
        let scatter: f64 =
            offsets.iter().map(|(t, r)| (r - level - slope * t).powi(2)).sum::<f64>();
        let own = if n > 2.0 { scatter / (n - 2.0) / n } else { 0.0 };
        let speed = ground.speed[((time * rate).max(0.0) as usize).min(ground.samples() - 1)];
        let error = (own + config.position_error.powi(2)).sqrt() / speed.max(MOVING);
        Crossing { time, error, speed, ridden: ground.ridden_at(time) }
    }

    /// A line from end to end (latitude and longitude, degrees), in the direction in which it is crossed more often.
    pub fn given(
        ground: &Ground,
        ends: [[f64; 2]; 2],
        source: Source,
        config: &Config,
    ) -> Option<Self> {
        let [a, b] = ends.map(|end| ground.point(end));
        let across = unit(minus(b, a))?;
        let line = Line {
            middle: [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])],
            along: [across[1], -across[0]],
            half_width: 0.5 * minus(b, a)[0].hypot(minus(b, a)[1]),
            source,
        };
        let counts = [line, line.reversed()].map(|l| l.crossings(ground, config).len());
        Some(if counts[1] > counts[0] { line.reversed() } else { line })
    }

    /// Through the middle of places with their directions of travel, across their mean direction.
    pub fn through(places: &[(Point, Point)], half_width: f64, source: Source) -> Option<Self> {
        let mean = |of: fn(&(Point, Point)) -> f64| {
            places.iter().map(of).sum::<f64>() / places.len() as f64
        };
        let middle = [mean(|p| p.0[0]), mean(|p| p.0[1])];
        let along = unit([mean(|p| p.1[0]), mean(|p| p.1[1])])?;
        Some(Line { middle, along, half_width, source })
    }

    /// Where the logger's counter goes up by one: the middle of those places.
    pub fn of_counter(ground: &Ground, counter: &[f64], config: &Config) -> Option<Self> {
        let rises =
            (1..counter.len()).filter(|&i| (counter[i] - counter[i - 1] - 1.0).abs() < 0.01);
        let places: Vec<(Point, Point)> = rises
            .filter(|&i| ground.known(i))
            .filter_map(|i| Some((ground.at[i], ground.direction(i)?)))
            .collect();
        let line = Line::through(&places, config.half_width, Source::Logger)?;
        // a counter that rises anywhere is none of laps
        let far = |p: &(Point, Point)| {
            line.coordinates(p.0).iter().any(|d| d.abs() > 2.0 * config.half_width)
        };
        (places.iter().filter(|p| far(p)).count() * 4 <= places.len()).then_some(line)
    }

    /// Places on the fastest parts, fastest first.
    pub fn candidates(ground: &Ground, config: &Config) -> Vec<Self> {
        let step = (ground.rate / 5.0).floor().max(1.0) as usize;
        let mut fast: Vec<usize> = (0..ground.samples()).step_by(step).collect();
        fast.retain(|&i| ground.known(i));
        fast.sort_by(|&a, &b| ground.speed[b].total_cmp(&ground.speed[a]));
        let top = fast.first().map_or(0.0, |&i| ground.speed[i]);
        let mut taken: Vec<Point> = Vec::new();
        let mut out = Vec::new();
        for i in fast.into_iter().take_while(|&i| ground.speed[i] > FAST * top) {
            let near = |p: &Point| {
                let off = minus(ground.at[i], *p);
                off[0].hypot(off[1]) < APART
            };
            if taken.iter().any(near) {
                continue;
            }
            taken.push(ground.at[i]);
            let early = i.saturating_sub((BEFORE * ground.rate) as usize);
            let early = if ground.known(early) { early } else { i };
            let straight = |k: usize| {
                let (a, b) = (ground.direction(k)?, ground.direction(i)?);
                (dot(a, b) > 0.97).then_some(a)
            };
            let found = straight(early).map(|d| (early, d));
            let Some((at, along)) = found.or_else(|| Some((i, ground.direction(i)?))) else {
                continue;
            };
            out.push(Line {
                middle: ground.at[at],
                along,
                half_width: config.half_width,
                source: Source::Detected,
            });
            if out.len() == PLACES {
                break;
            }
        }
        out
    }
}
