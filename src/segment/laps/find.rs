//! The laps of a ride: the line that gives most, and whether it is a track at all.

use std::collections::HashMap;

use super::config::Config;
use super::ground::{Ground, Point, dot, minus};
use super::line::{Crossing, Line, Source};
use super::markers::{Judged, by_position};
use crate::contract::session::Markers;

/// A lap may be this much longer or shorter than the others, as a share.
const SAME: f64 = 0.06;
/// How near to a lap is on the track, m.
const ON_TRACK_M: f64 = 15.0;
/// Share of a lap that must have been ridden a second time.
const AGAIN: f64 = 0.5;
/// Cosine of the angle between directions that are one.
const ALIKE: f64 = 0.7;
/// A lap that comes back this near to itself is ridden there and back, m; more than this share of one
/// is not.
const BACK: f64 = 25.0;
const MOST_BACK: f64 = 0.6;
/// Standard deviation of a lap's places across its long axis, m: less is a strip, though a ride put together from parts
/// may jump back to its beginning.
const WIDE: f64 = 8.0;
/// Share of the laps that the distance on the track is enough for, less the ways in and out.
const TIMED: f64 = 0.5;
/// Standing longer than this, a lap was broken off, s.
const STANDING: f64 = 3.0;

/// Kind of a stretch between crossings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// From the start of the log to the line.
    Out,
    /// From line to line.
    Timed,
    /// From line to line, but not a lap: a halt, a detour, a missed crossing, places that jump.
    Broken,
    /// From the line to the end of the log.
    In,
}

impl Kind {
    /// As in the table.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Out => "out",
            Kind::Timed => "timed",
            Kind::Broken => "broken",
            Kind::In => "in",
        }
    }
}

#[derive(Debug, Clone, Copy)]
pub struct Lap {
    pub kind: Kind,
    /// s from the start of the log.
    pub start: f64,
    /// End, s.
    pub end: f64,
    /// Standard deviation of its duration, s; of timed laps.
    pub error: f64,
    /// m by the speed.
    pub distance: f64,
    /// Of a lap by the logger's markers: its time by position over the same line less that by the markers, s.
    pub position_difference: Option<f64>,
}

impl Lap {
    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.end - self.start
    }
}

/// The laps of a ride.
#[derive(Debug, Clone)]
pub struct DetectedLaps {
    /// The line; of markers without positions its middle is NaN.
    pub line: Line,
    /// Whether the times are the logger's own.
    pub by_markers: bool,
    /// In order, the out lap first.
    pub laps: Vec<Lap>,
    /// Which is the fastest timed lap.
    pub best: usize,
}

/// `None` where the ride is not one round a track.
pub(crate) fn find(
    ground: &Ground,
    counter: Option<&[f64]>,
    markers: &Markers,
    judged: &Judged,
    config: &Config,
) -> Option<DetectedLaps> {
    let of = |line: Line| laps(ground, line, config);
    if let Some(ends) = config.line {
        return Line::given(ground, ends, Source::Given, config).and_then(of);
    }
    if let Some(found) = by_markers(ground, judged, config) {
        return Some(found);
    }
    let own = markers.line.and_then(|ends| Line::given(ground, ends, Source::Log, config));
    if let Some(found) = own.and_then(of) {
        return Some(found);
    }
    let logger = counter.and_then(|c| Line::of_counter(ground, c, config)).and_then(of);
    if logger.is_some() {
        return logger;
    }
    let mut best: Option<(usize, DetectedLaps)> = None;
    for line in Line::candidates(ground, config) {
        let Some(found) = of(line) else { continue };
        let timed = found.laps.iter().filter(|l| l.kind == Kind::Timed).count();
        // the faster places come first
        if best.as_ref().is_none_or(|(most, _)| timed > *most) {
            best = Some((timed, found));
        }
    }
    best.map(|(_, found)| found)
}

/// The laps from the logger's markers, each compared with the time by position.
fn by_markers(ground: &Ground, judged: &Judged, config: &Config) -> Option<DetectedLaps> {
    let nowhere = Line {
        middle: [f64::NAN; 2],
        along: [f64::NAN; 2],
        half_width: config.half_width,
        source: Source::Markers,
    };
    let line = judged.line.unwrap_or(nowhere);
    let mut found = between_crossings(ground, line, &judged.passages, config)?;
    found.by_markers = true;
    let crossings = judged.line.map(|l| l.crossings(ground, config)).unwrap_or_default();
    let times = by_position(&judged.passages, &crossings);
    let at = |time: f64| judged.passages.iter().position(|p| p.time == time);
    let mut squares = Vec::new();
    for lap in found.laps.iter_mut().filter(|l| l.kind == Kind::Timed) {
        let [start, end] = [lap.start, lap.end].map(|t| at(t).and_then(|k| times[k]));
        if let (Some(start), Some(end)) = (start, end) {
            let difference = end - start - lap.duration();
            lap.position_difference = Some(difference);
            squares.push(difference * difference);
        }
    }
    // markers and positions that disagree by more than a position's error: one of them is that wrong
    let rms = (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt();
    for lap in found.laps.iter_mut().filter(|l| l.kind == Kind::Timed) {
        lap.error = lap.error.max(rms);
    }
    Some(found)
}

/// The laps from a line's crossings.
fn laps(ground: &Ground, line: Line, config: &Config) -> Option<DetectedLaps> {
    between_crossings(ground, line, &line.crossings(ground, config), config)
}

fn between_crossings(
    ground: &Ground,
    line: Line,
    crossings: &[Crossing],
    config: &Config,
) -> Option<DetectedLaps> {
    let (first, last) = (crossings.first()?, crossings.last()?);
    let lengths: Vec<f64> = crossings.windows(2).map(|c| c[1].ridden - c[0].ridden).collect();
    let usual = most_common(&lengths)?;
    let total = ground.ridden.last().copied().unwrap_or(0.0);
    let mut laps = vec![Lap {
        kind: Kind::Out,
        start: 0.0,
        end: first.time,
        error: 0.0,
        distance: first.ridden,
        position_difference: None,
    }];
    // who gives a line says that it is a track, and so does a logger that times laps
    let said = matches!(line.source, Source::Given | Source::Markers);
    let jumps: &[[f64; 2]] = if said { &[] } else { &ground.jumps };
    laps.extend(crossings.windows(2).map(|c| between(ground, jumps, &c[0], &c[1], usual)));
    let end = (ground.samples() - 1) as f64 / ground.rate;
    laps.push(Lap {
        kind: Kind::In,
        start: last.time,
        end,
        error: 0.0,
        distance: total - last.ridden,
        position_difference: None,
    });
    // a log that begins or ends on the line
    laps.retain(|l| l.duration() > 0.5 || l.kind == Kind::Timed);
    let timed = |(_, l): &(usize, &Lap)| l.kind == Kind::Timed;
    let best = laps.iter().enumerate().filter(timed);
    let best = best.min_by(|a, b| a.1.duration().total_cmp(&b.1.duration()))?.0;
    let track = said || is_track(ground, &laps, best, config);
    track.then_some(DetectedLaps { line, by_markers: false, laps, best })
}

/// The length that most others are like, the shortest of such.
fn most_common(lengths: &[f64]) -> Option<f64> {
    let like = |a: f64| lengths.iter().filter(|b| (*b / a - 1.0).abs() < SAME).count();
    let better = |a: &&f64, b: &&f64| like(**a).cmp(&like(**b)).then(b.total_cmp(a));
    lengths.iter().max_by(better).copied()
}

/// From crossing to crossing; not a lap if its length is not the usual one, if it stood, or if its places jump.
fn between(ground: &Ground, jumps: &[[f64; 2]], from: &Crossing, to: &Crossing, usual: f64) -> Lap {
    let distance = to.ridden - from.ridden;
    let samples = (from.time * ground.rate) as usize..(to.time * ground.rate) as usize;
    let standing = ground.speed[samples].iter().filter(|v| **v < 1.0).count() as f64 / ground.rate;
    let jumped = jumps.iter().any(|[start, end]| *start < to.time && from.time < *end);
    let whole = (distance / usual - 1.0).abs() < SAME && standing < STANDING && !jumped;
    Lap {
        kind: if whole { Kind::Timed } else { Kind::Broken },
        start: from.time,
        end: to.time,
        error: from.error.hypot(to.error),
        distance,
        position_difference: None,
    }
}

/// Whether most of the ride is on the lap, half of the lap at least was ridden again and about as often as
/// there are laps, and it is not a way there and back: a test strip with a turn at each end goes round, too.
fn is_track(ground: &Ground, laps: &[Lap], best: usize, config: &Config) -> bool {
    let lap = &laps[best];
    let timed = laps.iter().filter(|l| l.kind == Kind::Timed).count() as f64;
    let step = (ground.rate / 5.0).floor().max(1.0) as usize;
    let samples = |from: f64, to: f64| {
        let last = ((to * ground.rate) as usize).min(ground.samples() - 1);
        ((from * ground.rate).max(0.0) as usize..=last).step_by(step).filter(|&i| ground.known(i))
    };
    let cell = |p: Point| [0, 1].map(|k| (p[k] / BACK).floor() as i64);
    let mut cells: HashMap<[i64; 2], Vec<(Point, Point)>> = HashMap::new();
    for i in samples(lap.start, lap.end) {
        if let Some(direction) = ground.direction(i) {
            cells.entry(cell(ground.at[i])).or_default().push((ground.at[i], direction));
        }
    }
    // whether the lap comes past a sample that near, in its direction (1) or against it (-1)
    let passes = |i: usize, within: f64, sense: f64| {
        let Some(direction) = ground.direction(i) else { return false };
        let here = cell(ground.at[i]);
        let about = (-1..=1).flat_map(|x| (-1..=1).map(move |y| [here[0] + x, here[1] + y]));
        about.filter_map(|c| cells.get(&c)).flatten().any(|(p, d)| {
            let off = minus(ground.at[i], *p);
            off[0].hypot(off[1]) < within && sense * dot(direction, *d) > ALIKE
        })
    };
    let ridden = |from: f64, to: f64, counts: &dyn Fn(usize) -> bool| -> f64 {
        let metres = |i: usize| ground.speed[i] * step as f64 / ground.rate;
        samples(from, to).filter(|&i| counts(i)).map(metres).sum()
    };
    let total = ridden(0.0, f64::MAX, &|_| true);
    let on_lap = ridden(0.0, f64::MAX, &|i| passes(i, ON_TRACK_M, 1.0));
    let back = ridden(lap.start, lap.end, &|i| passes(i, BACK, -1.0));
    on_lap > config.least_on_track * total
        && on_lap > (1.0 + AGAIN) * lap.distance
        && timed >= TIMED * (on_lap / lap.distance - 2.0)
        && back < MOST_BACK * lap.distance
        && width(samples(lap.start, lap.end).map(|i| ground.at[i])) > WIDE
}

/// The smaller of the standard deviations of places along their principal axes, m.
fn width(places: impl Iterator<Item = Point>) -> f64 {
    let mut sums = [0.0; 6];
    for [x, y] in places {
        for (sum, term) in sums.iter_mut().zip([1.0, x, y, x * x, y * y, x * y]) {
            *sum += term;
        }
    }
    let [n, x, y, xx, yy, xy] = sums;
    let [xx, yy, xy] = [xx / n - x * x / n / n, yy / n - y * y / n / n, xy / n - x * y / n / n];
    let least = 0.5 * (xx + yy) - f64::hypot(0.5 * (xx - yy), xy);
    least.max(0.0).sqrt()
}
