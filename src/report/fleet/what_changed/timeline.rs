//! A number over a motorcycle's rides: each ride's value with its interval, those that changed marked, and a line where a change
//! begins, with its cause. The template draws it, so that every text is escaped there.

use std::fmt::Write as _;

use serde::Serialize;

use crate::report::fleet::what_changed::numbers::{Point, Series};
use crate::report::fleet::what_changed::rides::Rides;
use crate::statistics::number_format::{decimals, fixed, typeset};
use crate::statistics::order::median_of_finite;

/// Width of a drawing, as many px as it has on most screens.
pub(super) const WIDTH: f64 = 360.0;
/// Ends of the abscissa.
const X: [f64; 2] = [52.0, 352.0];
/// Height of the ordinate.
const HEIGHT: f64 = 92.0;
/// Height of a line of labels above it.
const ROW: f64 = 13.0;
/// Most lines of labels.
const ROWS: usize = 3;
/// Width of a letter of a label.
const LETTER: f64 = 5.6;
/// Rides up to which each has a hint and a link.
const HINTS: usize = 60;
/// Rides up to which each has its interval drawn.
const INTERVALS: usize = 400;

/// A change, as a chart of one number shows it.
#[derive(Debug, Clone)]
pub(crate) struct Mark {
    /// By ride whether it differs.
    pub members: Vec<bool>,
    /// Whether it is a drift.
    pub is_drift: bool,
    pub label: String,
}

/// A drawing's geometry and texts.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[allow(missing_docs)] // parts of the drawing in the template
pub(crate) struct TimeLine {
    pub title: String,
    pub key: String,
    pub unit: String,
    pub source: &'static str,
    pub width: f64,
    pub height: f64,
    pub grid: String,
    pub intervals: [String; 2],
    pub rides: [String; 3],
    pub levels: String,
    pub rules: Vec<Rule>,
    pub ticks: Vec<Tick>,
    pub dates: Vec<Tick>,
    pub hints: Vec<Hint>,
}

/// Where a change begins.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub(crate) struct Rule {
    pub path: String,
    pub label: String,
    pub x: String,
    pub y: String,
    pub anchor: &'static str,
}

/// A text at an axis.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub(crate) struct Tick {
    pub at: String,
    pub label: String,
    pub anchor: &'static str,
}

/// Text for the pointer over a ride.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
#[allow(missing_docs)]
pub(crate) struct Hint {
    pub x: String,
    pub y: String,
    pub text: String,
    pub page: String,
}

/// Draws a number; `None` of fewer than two rides.
pub(crate) fn draw(series: &Series, rides: &Rides, marks: &[Mark]) -> Option<TimeLine> {
    let points = &series.points;
    if points.len() < 2 {
        return None;
    }
    let times = rides.times();
    let along = Along::new(times.as_deref(), rides.rides.len());
    let rules = rules(marks, points, &along);
    let rows = rules.iter().map(|(_, row)| row + 1).max().unwrap_or(0);
    let top = 6.0 + ROW * rows as f64;
    let axis = Ordinate::new(points, top);
    let is_changed = |p: &Point| marks.iter().any(|m| m.members.get(p.ride) == Some(&true));
    let mut line = TimeLine {
        title: series.title.clone(),
        key: series.key.clone(),
        unit: series.unit.clone(),
        source: series.source,
        width: WIDTH,
        height: top + HEIGHT + 20.0,
        rules: rules.into_iter().map(|(rule, row)| rule.at(top, row)).collect(),
        dates: along.dates(rides),
        ..TimeLine::default()
    };
    for (value, label) in axis.ticks() {
        let y = axis.at(value);
        // writing to a String cannot fail
        let _ = write!(line.grid, "M{:.0} {y:.1}H{:.0}", X[0] - 4.0, X[1] + 4.0);
        line.ticks.push(Tick { at: format!("{:.1}", y + 3.5), label, anchor: "end" });
    }
    for p in points {
        let (x, y) = (along.at(p.ride), axis.at(p.value));
        let changed = is_changed(p);
        let [low, high] = p.ends.map(|end| axis.at(end));
        if points.len() <= INTERVALS {
            let _ = write!(line.intervals[usize::from(changed)], "M{x:.1} {low:.1}V{high:.1}");
        }
        let kind = if !p.is_determined { 2 } else { usize::from(changed) };
        let _ = write!(line.rides[kind], "M{x:.1} {y:.1}h0");
        if points.len() <= HINTS {
            let text = hint(series, p, rides);
            let (x, y) = (format!("{x:.1}"), format!("{y:.1}"));
            let page = rides.rides.get(p.ride).map(|r| r.page.clone()).unwrap_or_default();
            line.hints.push(Hint { x, y, text, page });
        }
    }
    line.levels = levels(points, marks, &along, &axis);
    Some(line)
}

/// The usual value of the rides that did not change, and of those of each change that lasts; of a drift the way from the
/// usual value of its first to that of its last third.
fn levels(points: &[Point], marks: &[Mark], along: &Along<'_>, axis: &Ordinate) -> String {
    let mut path = String::new();
    let middle = |own: &[&Point]| {
        let values: Vec<f64> = own.iter().map(|p| p.value).collect();
        median_of_finite(&values)
    };
    let mut rule = |from: f64, to: f64, [start, end]: [f64; 2]| {
        let _ = write!(path, "M{from:.1} {:.1}L{to:.1} {:.1}", axis.at(start), axis.at(end));
    };
    let of = |m: &Mark| -> Vec<&Point> {
        points.iter().filter(|p| m.members.get(p.ride) == Some(&true)).collect()
    };
    if let Some(drift) = marks.iter().find(|m| m.is_drift) {
        let own = of(drift);
        let third = own.len().div_ceil(3);
        let ends = [&own[..third.min(own.len())], &own[own.len().saturating_sub(third)..]];
        let [start, end] = ends.map(middle);
        if let (Some(start), Some(end)) = (start, end) {
            rule(X[0], X[1], [start, end]);
        }
        return path;
    }
    let is_usual = |p: &&Point| !marks.iter().any(|m| m.members.get(p.ride) == Some(&true));
    let usual: Vec<&Point> = points.iter().filter(is_usual).collect();
    let usual_level = middle(&usual);
    let mut until = X[1];
    for mark in marks {
        let own = of(mark);
        let [Some(first), Some(last)] = [own.first(), own.last()] else { continue };
        let is_lasting =
            own.len() > 2 && own.len() == points.iter().filter(|p| p.ride >= first.ride).count();
        if let (true, Some(level)) = (is_lasting, middle(&own)) {
            rule(along.at(first.ride), along.at(last.ride).max(X[1]), [level, level]);
            until = until.min(along.at(first.ride));
        }
    }
    if let Some(level) = usual_level {
        rule(X[0], until, [level, level]);
    }
    path
}

fn hint(series: &Series, p: &Point, rides: &Rides) -> String {
    let [low, high] = p.ends;
    let digits = decimals((high - low) / 2.0);
    let [value, low, high] = [p.value, low, high].map(|x| fixed(x, digits));
    let unit = if series.unit.is_empty() { String::new() } else { format!(" {}", series.unit) };
    let ident = rides.rides.get(p.ride).map(|r| r.ident.clone()).unwrap_or_default();
    let date = ident.start_time.as_deref().and_then(|t| t.get(..10));
    let date = date.map(|d| format!(" ({d})")).unwrap_or_default();
    let doubt = if p.is_determined { "" } else { ", poorly determined" };
    let numbers = typeset(&format!("{value}{unit} ({low} to {high})"));
    format!("{}{date}: {numbers}{doubt}", ident.session_id)
}

/// The abscissa: time, or the rides one after another.
struct Along<'a> {
    times: Option<&'a [f64]>,
    count: usize,
}

impl<'a> Along<'a> {
    fn new(times: Option<&'a [f64]>, count: usize) -> Self {
        Along { times, count }
    }

    fn at(&self, ride: usize) -> f64 {
        let share = match self.times {
            Some(times) => (times[ride] - times[0]) / (times[times.len() - 1] - times[0]),
            None => ride as f64 / (self.count.max(2) - 1) as f64,
        };
        X[0] + share * (X[1] - X[0])
    }

    /// First and last ride.
    fn dates(&self, rides: &Rides) -> Vec<Tick> {
        let ends = [(0, X[0], "start"), (self.count.saturating_sub(1), X[1], "end")];
        let days: Vec<Option<&str>> = ends
            .iter()
            .map(|(i, ..)| rides.rides.get(*i)?.ident.start_time.as_deref()?.get(..10))
            .collect();
        let is_one_day = days[0] == days[1];
        let tick = |(i, x, anchor): (usize, f64, &'static str)| {
            let start = rides.rides.get(i).and_then(|r| r.ident.start_time.as_deref());
            let label = match start.filter(|_| self.times.is_some()) {
                Some(text) if is_one_day => text.get(..16).unwrap_or(text).replace('T', " "),
                Some(text) => text.get(..10).unwrap_or(text).to_owned(),
                None => format!("ride {}", i + 1),
            };
            Tick { at: format!("{x:.0}"), label, anchor }
        };
        ends.into_iter().map(tick).collect()
    }
}

/// The ordinate: it goes by the values, so that one hopeless interval does not flatten the others.
struct Ordinate {
    low: f64,
    high: f64,
    top: f64,
}

impl Ordinate {
    fn new(points: &[Point], top: f64) -> Self {
        let halves: Vec<f64> = points.iter().map(|p| (p.ends[1] - p.ends[0]) / 2.0).collect();
        let half = median_of_finite(&halves).unwrap_or(0.0);
        let (low, high) = points
            .iter()
            .filter(|p| p.value.is_finite())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| (l.min(p.value), h.max(p.value)));
        let (low, high) = (low - 1.3 * half, high + 1.3 * half);
        let flat = if high > low { 0.0 } else { 0.5 * low.abs().max(1e-9) };
        Ordinate { low: low - flat, high: high + flat, top }
    }

    fn at(&self, value: f64) -> f64 {
        let share = ((value - self.low) / (self.high - self.low)).clamp(0.0, 1.0);
        self.top + (1.0 - share) * HEIGHT
    }

    /// Round values between the ends, two to five.
    fn ticks(&self) -> Vec<(f64, String)> {
        let range = self.high - self.low;
        let power = 10f64.powf((range / 3.0).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|s| s * power);
        let step = steps.into_iter().find(|s| range / s <= 4.0).unwrap_or(10.0 * power);
        let digits = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
        let first = (self.low / step).ceil();
        let count = ((self.high / step).floor() - first).max(0.0) as usize;
        (0..=count)
            .map(|k| (first + k as f64) * step)
            .map(|value| (value, typeset(&fixed(value, digits))))
            .collect()
    }
}

/// A line at the beginning of a change and its label.
struct Begin {
    x: f64,
    label: String,
    is_drift: bool,
    is_left: bool,
}

impl Begin {
    fn at(self, top: f64, row: usize) -> Rule {
        let y = 6.0 + ROW * row as f64 + 6.0;
        let (beside, anchor) = if self.is_left { (-4.0, "end") } else { (4.0, "start") };
        Rule {
            path: match self.is_drift {
                true => String::new(),
                false => format!("M{:.1} {:.1}V{:.1}", self.x, y - 8.0, top + HEIGHT),
            },
            x: format!("{:.1}", self.x + beside),
            y: format!("{y:.1}"),
            anchor,
            label: self.label,
        }
    }
}

/// The lines with the rows of their labels, none over another. Changes of the same ride share a line.
fn rules(marks: &[Mark], points: &[Point], along: &Along<'_>) -> Vec<(Begin, usize)> {
    let mut begins: Vec<Begin> = Vec::new();
    for mark in marks {
        let first = points.iter().find(|p| mark.members.get(p.ride) == Some(&true));
        let Some(first) = first else { continue };
        let x = if mark.is_drift { X[0] } else { along.at(first.ride) };
        let label =
            if mark.is_drift { format!("drift: {}", mark.label) } else { mark.label.clone() };
        match begins.iter_mut().find(|b| b.x == x && b.is_drift == mark.is_drift) {
            Some(same) if same.label.split(", ").any(|l| l == label) => {}
            Some(same) => same.label += &format!(", {label}"),
            None => {
                let is_left = x > 0.55 * (X[0] + X[1]);
                begins.push(Begin { x, label, is_drift: mark.is_drift, is_left });
            }
        }
    }
    begins.sort_by(|a, b| a.x.total_cmp(&b.x));
    let mut taken: [Vec<[f64; 2]>; ROWS] = Default::default();
    let mut placed = Vec::new();
    for begin in begins {
        let length = LETTER * begin.label.chars().count() as f64 + 8.0;
        let span = match begin.is_left {
            true => [begin.x - length, begin.x],
            false => [begin.x, begin.x + length],
        };
        let is_free = |row: &usize| taken[*row].iter().all(|t| span[1] < t[0] || t[1] < span[0]);
        let row = (0..ROWS).find(is_free).unwrap_or(ROWS - 1);
        taken[row].push(span);
        placed.push((begin, row));
    }
    placed
}
