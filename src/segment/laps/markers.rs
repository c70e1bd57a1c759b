//! The logger's own markers: which of them can be passages of one start line, and what the others are.

use super::config::Config;
use super::ground::{Ground, MOVING, Point, dot, minus};
use super::line::{Crossing, Line, Source};
use crate::contract::warning::Warning;

/// Two markers with less between them are one, s.
const DOUBLED: f64 = 1.0;
/// So near to an end of the log a marker may be that end, s: loggers list it among the laps.
const END: f64 = 0.5;
/// Cosine of the angle by which two passages of one line may differ.
const ALIKE: f64 = 0.7;
/// A crossing by position belongs to a marker this near, s: positions are late.
const SAME: f64 = 3.0;

/// Why a marker is no passage of the line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Not within the ride.
    Outside,
    /// Earlier than the one before it in the log; it is kept, in its order.
    Unsorted,
    /// With the one before.
    Doubled,
    /// Less than the shortest lap after the one before.
    Short,
    /// Where most others are not.
    Elsewhere,
}

impl Fault {
    /// In words, after "3 of 12 markers".
    fn words(self) -> &'static str {
        match self {
            Fault::Outside => "are not within the ride and left out",
            Fault::Unsorted => "stand before an earlier one and are put in order",
            Fault::Doubled => "repeat the one before and are left out",
            Fault::Short => "come sooner after the one before than a lap can take and are left out",
            Fault::Elsewhere => {
                "are where most others are not (a split, the end of the log, a button) and left out"
            }
        }
    }
}

/// Markers as passages of one line.
#[derive(Debug, Clone, Default)]
pub(crate) struct Judged {
    pub passages: Vec<Crossing>,
    /// Across the track where most of them are; none without positions.
    pub line: Option<Line>,
    /// Kinds of faults, how many, and the time of the first, s.
    pub faults: Vec<(Fault, usize, f64)>,
}

/// Judges markers, s since the start in the order of the log.
pub(crate) fn judge(ground: &Ground, times: &[f64], config: &Config) -> Judged {
    let end = (ground.samples() - 1) as f64 / ground.rate;
    let mut out = Judged::default();
    let mut kept: Vec<f64> = Vec::with_capacity(times.len());
    for &time in times {
        match (0.0..=end + 1.0 / ground.rate).contains(&time) {
            true => kept.push(time.min(end)),
            false => out.note(Fault::Outside, time),
        }
    }
    for pair in kept.windows(2).filter(|pair| pair[1] < pair[0]) {
        out.note(Fault::Unsorted, pair[1]);
    }
    kept.sort_by(f64::total_cmp);
    let mut one: Vec<f64> = Vec::with_capacity(kept.len());
    for time in kept {
        match one.last().is_some_and(|last| time - last < DOUBLED) {
            true => out.note(Fault::Doubled, time),
            false => one.push(time),
        }
    }
    let places: Vec<(usize, Point, Point)> = one
        .iter()
        .enumerate()
        .filter_map(|(k, time)| {
            let i = ((time * ground.rate).round() as usize).min(ground.samples() - 1);
            Some((k, ground.at[i], ground.direction(i)?)).filter(|_| ground.known(i))
        })
        .collect();
    let reach = 2.0 * config.half_width;
    let together = |a: &(usize, Point, Point), b: &(usize, Point, Point)| {
        let off = minus(a.1, b.1);
        off[0].hypot(off[1]) < reach && dot(a.2, b.2) > ALIKE
    };
    let count = |a: &(usize, Point, Point)| places.iter().filter(|b| together(a, b)).count();
    let mut elsewhere = vec![false; one.len()];
    // of two places with as many the first
    if let Some(middle) = places.iter().rev().max_by_key(|p| count(p)) {
        for place in places.iter().filter(|p| !together(middle, p)) {
            elsewhere[place.0] = true;
        }
        let own: Vec<(Point, Point)> =
            places.iter().filter(|p| together(middle, p)).map(|p| (p.1, p.2)).collect();
        out.line =
            Line::through(&own, config.half_width, Source::Markers).filter(|_| own.len() > 1);
    }
    for (time, elsewhere) in one.into_iter().zip(elsewhere) {
        let passage = passage(ground, time, config);
        if elsewhere {
            // no one has to hear that a list of laps ends with the log
            if time > END && end - time > END {
                out.note(Fault::Elsewhere, time);
            }
        } else if let Some(last) = out.passages.last()
            && passage.ridden - last.ridden < config.shortest_lap
        {
            out.note(Fault::Short, time);
        } else {
            out.passages.push(passage);
        }
    }
    out
}

/// A marker as a passage. Its error is that of a position over the speed, as though the logger had found it by its
/// receiver: what it found it by, a beacon beside the track or a satellite receiver, is not in the log.
fn passage(ground: &Ground, time: f64, config: &Config) -> Crossing {
    let at = ((time * ground.rate) as usize).min(ground.samples() - 1);
    let speed = ground.speed[at];
    let error = config.position_error / speed.max(MOVING);
    Crossing { time, error, speed, ridden: ground.ridden_at(time) }
}

/// The crossing by position that belongs to each passage.
pub(crate) fn by_position(passages: &[Crossing], crossings: &[Crossing]) -> Vec<Option<f64>> {
    let nearest = |time: f64| {
        let far = |c: &&Crossing| (c.time - time).abs();
        crossings.iter().min_by(|a, b| far(a).total_cmp(&far(b))).filter(|c| far(c) < SAME)
    };
    passages.iter().map(|p| nearest(p.time).map(|c| c.time)).collect()
}

impl Judged {
    fn note(&mut self, fault: Fault, time: f64) {
        match self.faults.iter_mut().find(|f| f.0 == fault) {
            Some(known) => known.1 += 1,
            None => self.faults.push((fault, 1, time)),
        }
    }

    /// Faults, for the table of warnings; `all` is how many markers there were.
    pub(crate) fn warnings(&self, all: usize) -> Vec<Warning> {
        let warning = |&(fault, count, time): &(Fault, usize, f64)| Warning {
            stage: "segment",
            code: "lap_markers",
            channel: None,
            count,
            time: Some(time),
            message: format!("{count} of the logger's {all} lap markers {}", fault.words()),
        };
        self.faults.iter().map(warning).collect()
    }
}
