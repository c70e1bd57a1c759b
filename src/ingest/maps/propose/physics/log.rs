//! The channels of a log with their samples, and what their names and units say.

use std::sync::Arc;

use super::super::words::{RULES, words};
use super::signal::{Clock, Signal};
use crate::contract::channel::Channel;
use crate::ingest::checks::frozen::frozen;
use crate::ingest::clock::held::{self, RECEIVER};
use crate::ingest::formats::listing::SourceChannel;
use crate::ingest::maps::units;
use crate::ingest::motion::receiver;
use crate::ingest::raw::Column;

/// A position that rests so long, s, and then jumps had lost its fix.
const FROZEN: f64 = 2.0;

/// A log as the motion judges it.
pub(crate) struct Log<'a> {
    pub(crate) channels: &'a [SourceChannel],
    /// As many as channels; `None` where there is no number.
    pub(crate) signals: Vec<Option<Signal>>,
    /// The words of the channels' names.
    words: Vec<Vec<String>>,
    /// Channels that a map assigns although their names say nothing: their places, and the columns.
    claims: Vec<(usize, Channel)>,
    clock: Clock,
    /// Observations of the samples.
    pub(crate) remarks: Vec<String>,
}

impl<'a> Log<'a> {
    /// Without samples yet.
    pub(crate) fn new(channels: &'a [SourceChannel], clock: Clock) -> Self {
        let words = channels.iter().map(|c| words(units::of_name(&c.name).0)).collect();
        let signals = channels.iter().map(|_| None).collect();
        Log { channels, signals, words, claims: Vec::new(), clock, remarks: Vec::new() }
    }

    /// Takes what a map makes of channels (their places) as names; a channel whose own name says something keeps that.
    pub(crate) fn claimed(mut self, claims: &[(usize, Channel)]) -> Self {
        let unnamed = |(place, _): &&(usize, Channel)| !self.is_named(*place);
        self.claims = claims.iter().filter(unnamed).copied().collect();
        self
    }

    /// Whether only a map says what a channel is.
    pub(crate) fn is_claimed(&self, place: usize) -> bool {
        self.claims.iter().any(|(p, _)| *p == place)
    }

    /// Takes the samples of the channels from a place on; what only repeats a receiver's fix is none.
    pub(crate) fn take(&mut self, place: usize, mut columns: Vec<Column>) {
        let named = |i: &usize| RECEIVER.iter().any(|c| self.score(place + i, *c).is_some());
        let receiver: Vec<usize> = (0..columns.len()).filter(named).collect();
        self.without_fix(place, &mut columns, &receiver, None);
        self.remarks.extend(held::thin_columns(&mut columns, &receiver));
        self.without_fix(place, &mut columns, &receiver, Some(FROZEN));
        columns.iter().enumerate().for_each(|(i, column)| self.put(place + i, column));
    }

    /// Takes out what a receiver without a fix writes for its course, speed and altitude; or, where positions that rest for
    /// so long, s, and then jump are looked for, these too.
    fn without_fix(
        &self,
        place: usize,
        columns: &mut [Column],
        of_receiver: &[usize],
        frozen_for: Option<f64>,
    ) {
        let called = |i: usize, column: Channel| self.score(place + i, column).is_some();
        let best = |column: Channel| of_receiver.iter().copied().find(|i| called(*i, column));
        let (Some(north), Some(east)) = (best(Channel::Latitude), best(Channel::Longitude)) else {
            return;
        };
        let time = Arc::clone(&columns[north].time);
        if !Arc::ptr_eq(&time, &columns[east].time) {
            return;
        }
        let [mut lat, mut lon] = [north, east].map(|i| columns[i].values.clone());
        let mut lost = receiver::positions(&mut lat, &mut lon);
        if let Some(least) = frozen_for {
            let runs = frozen(&time, [&lat, &lon], least);
            lost.runs = runs.into_iter().map(|(a, b)| (a + 1..b, true)).collect();
            for (rows, _) in &lost.runs {
                for i in [north, east] {
                    columns[i].values[rows.clone()].fill(f64::NAN);
                }
            }
        }
        for &i in of_receiver.iter().filter(|i| **i != north && **i != east) {
            if Arc::ptr_eq(&columns[i].time, &time) {
                let is_speed = held::SPEEDS.iter().any(|c| called(i, *c));
                receiver::take_out(&mut columns[i].values, &lost, is_speed);
            }
        }
    }

    /// Takes the samples of a channel, without those that its name says are none: positions before the first fix, a
    /// speed that is suddenly zero.
    fn put(&mut self, place: usize, column: &Column) {
        use Channel::*;
        let named = |columns: &[Channel]| columns.iter().any(|c| self.score(place, *c).is_some());
        let there: Option<Vec<bool>> = if named(&[Latitude, Longitude]) {
            // some receivers write the pole and the date line before their first fix
            let none = if named(&[Latitude]) { 90.0 } else { 180.0 };
            let is_place = |x: &f64| *x != 0.0 && x.abs() < 999.0 && x.abs() != none;
            Some(column.values.iter().map(is_place).collect())
        } else if named(&[VelocityX, WheelSpeedFront, WheelSpeedRear]) {
            without_dropouts(&column.values)
        } else {
            None
        };
        self.signals[place] = match there.filter(|t| t.contains(&false)) {
            None => Signal::of(column, self.clock),
            Some(there) => {
                let kept = column.values.iter().zip(&there);
                let values = kept.map(|(x, t)| if *t { *x } else { f64::NAN }).collect();
                let time = Arc::clone(&column.time);
                Signal::of(&Column { name: column.name.clone(), time, values }, self.clock)
            }
        };
    }

    /// Points of the common clock.
    pub(crate) fn len(&self) -> usize {
        self.clock.len
    }

    /// A channel's samples on the common clock; none of a channel without numbers.
    pub(crate) fn x(&self, place: usize) -> &[f64] {
        self.signals[place].as_ref().map_or(&[], |s| &s.x)
    }

    /// A channel that changes.
    pub(crate) fn live(&self, place: usize) -> Option<&Signal> {
        self.signals[place].as_ref().filter(|s| !s.constant())
    }

    /// Name and group of a channel, for people.
    pub(crate) fn name(&self, place: usize) -> String {
        self.channels[place].full()
    }

    /// How many words of a channel's name are those of a column; `None` if it is not meant.
    pub(crate) fn score(&self, place: usize, channel: Channel) -> Option<usize> {
        if self.channels[place].name == channel.name() {
            return Some(100);
        }
        if self.claims.contains(&(place, channel)) {
            return Some(1);
        }
        RULES.iter().find(|r| r.channel == channel)?.score(&self.words[place])
    }

    /// Channels with the name of a column that change, the best name first.
    pub(crate) fn named(&self, channel: Channel) -> Vec<usize> {
        let scored = |i: usize| Some((self.score(i, channel)?, i));
        let live = (0..self.channels.len()).filter(|i| self.live(*i).is_some());
        let mut found: Vec<(usize, usize)> = live.filter_map(scored).collect();
        found.sort_by_key(|(score, i)| (std::cmp::Reverse(*score), *i));
        found.into_iter().map(|f| f.1).collect()
    }

    /// Whether a name is like that of any column, or a map says what the channel is.
    pub(crate) fn is_named(&self, place: usize) -> bool {
        self.is_claimed(place) || RULES.iter().any(|r| self.score(place, r.channel).is_some())
    }

    /// Whether a word is in a channel's name.
    pub(crate) fn has_word(&self, place: usize, word: &str) -> bool {
        self.words[place].iter().any(|w| w == word)
    }

    /// A channel's unit by the log, if it is known and measures that.
    pub(crate) fn unit(&self, place: usize, dimension: &str) -> Option<&str> {
        let unit = self.channels[place].unit.as_deref()?.trim();
        (units::dimension(unit) == Some(dimension)).then_some(unit)
    }

    /// Unit of a channel by the log, where it is unknown to roadbench.
    pub(crate) fn unknown_unit(&self, place: usize) -> Option<&str> {
        let channel = &self.channels[place];
        let own = channel.unit.as_deref().map(str::trim).filter(|u| !u.is_empty());
        let said = own.or_else(|| in_brackets(&channel.name).filter(|text| is_like_a_unit(text)));
        said.filter(|unit| units::dimension(unit).is_none())
    }

    /// Whether the log gives a unit that measures something else.
    pub(crate) fn of_other_dimension(&self, place: usize, dimensions: &[&str]) -> bool {
        let unit = self.channels[place].unit.as_deref().map(str::trim).filter(|u| !u.is_empty());
        unit.and_then(units::dimension).is_some_and(|d| !dimensions.contains(&d))
    }

    /// Common part of three channels of one sensor: the name without its axis, and the axis.
    pub(crate) fn axis(&self, place: usize) -> Option<(String, char)> {
        let words = &self.words[place];
        let found = words.iter().find_map(|w| axis_of(w))?.0;
        let rest: Vec<&str> =
            words.iter().filter_map(|w| axis_of(w).map_or(Some(w.as_str()), |a| a.1)).collect();
        Some((format!("{} {}", self.channels[place].group, rest.join(" ")), found))
    }
}

/// Text in brackets at the end of a name.
fn in_brackets(name: &str) -> Option<&str> {
    let name = name.trim();
    let within = |(open, close): (char, char)| Some(name.strip_suffix(close)?.rsplit_once(open)?.1);
    let text = [('(', ')'), ('[', ']'), ('{', '}'), ('<', '>')].into_iter().find_map(within)?;
    Some(text.trim())
}

/// Whether a text is a unit of somebody's: a number of some (`0.5bar`), a fraction (`kp/cm2`) or a known one with a
/// prefix (`dbar`). Places, names of sensors and notes are none.
fn is_like_a_unit(text: &str) -> bool {
    let number = |c: char| c.is_ascii_digit() || matches!(c, '.' | ',' | ' ' | '*' | 'x');
    let after = text.trim_start_matches(number);
    let scaled = after.len() < text.len() && after.starts_with(char::is_alphabetic);
    let fraction = text.split_once('/').is_some_and(|(above, below)| {
        above.chars().count() >= 2 && !below.is_empty() && !below.contains('/')
    });
    let prefixed = ["bar", "Pa", "psi", "deg", "rad", "rpm", "dps"];
    scaled
        || fraction
        || prefixed.iter().any(|unit| text.len() > unit.len() && text.ends_with(unit))
}

/// A fall to zero from more than this share of the largest speed, between two samples, is none.
const SUDDEN: f64 = 0.25;

/// Which samples of a speed are none: runs of zeros that begin or end from a speed at once. `None` where there are none.
fn without_dropouts(speed: &[f64]) -> Option<Vec<bool>> {
    let most = speed.iter().filter(|v| v.is_finite()).fold(0.0_f64, |m, v| m.max(v.abs()));
    let mut there = vec![true; speed.len()];
    let (mut at, mut any) = (0, false);
    for run in speed.chunk_by(|a, b| (*a == 0.0) == (*b == 0.0)) {
        let end = at + run.len();
        let sudden = |place: Option<usize>| {
            place.and_then(|i| speed.get(i)).is_some_and(|v| v.abs() > SUDDEN * most)
        };
        if run[0] == 0.0 && (sudden(at.checked_sub(1)) || sudden(Some(end))) {
            there[at..end].fill(false);
            any = true;
        }
        at = end;
    }
    any.then_some(there)
}

/// The axis that a word says, and what else it says: `ax`, `gyroz`, `yawrate`.
fn axis_of(word: &str) -> Option<(char, Option<&str>)> {
    let alone = match word {
        "x" | "long" | "lon" | "longitudinal" | "inline" | "roll" => Some('x'),
        "y" | "lat" | "lateral" | "pitch" => Some('y'),
        "z" | "vert" | "vertical" | "yaw" => Some('z'),
        _ => None,
    };
    if let Some(axis) = alone {
        return Some((axis, None));
    }
    for (turn, axis) in [("roll", 'x'), ("pitch", 'y'), ("yaw", 'z')] {
        if let Some("rate") = word.strip_prefix(turn) {
            return Some((axis, Some("rate")));
        }
    }
    let stems = ["a", "acc", "accel", "g", "gforce", "gyro", "rate", "w", "omega"];
    let axis = word.chars().last().filter(|c| matches!(c, 'x' | 'y' | 'z'))?;
    let stem = &word[..word.len() - 1];
    stems.contains(&stem).then_some((axis, Some(stem)))
}

/// A unit by the motion, and whether the log's word contradicts it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Unit {
    pub name: String,
    /// Unit in the log, if it is another.
    pub not: Option<String>,
}

/// The unit in which `slope` units are one of `si`: the log's if it fits within `near` (relative), else the nearest
/// of `units`.
pub(super) fn unit_of(
    own: Option<&str>,
    si: &str,
    units: &[&str],
    slope: f64,
    near: f64,
) -> Option<Unit> {
    let off = |unit: &str| {
        let factor = units::conversion(si, unit).ok()?.factor;
        Some((slope.abs() / factor).ln().abs())
    };
    let fits = |unit: &str| off(unit).is_some_and(|o| o < (1.0 + near).ln());
    if let Some(own) = own.filter(|own| fits(own)) {
        return Some(Unit { name: own.to_owned(), not: None });
    }
    let best = units.iter().min_by(|a, b| {
        let of = |u: &str| off(u).unwrap_or(f64::INFINITY);
        of(a).total_cmp(&of(b))
    })?;
    fits(best).then(|| Unit { name: (*best).to_owned(), not: own.map(str::to_owned) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_that_nobody_knows_is_seen_and_a_note_is_none() {
        for unit in ["0.25qbar", "0.1 zar", "kp/cm2", "ybar", "zPa"] {
            assert!(is_like_a_unit(unit), "{unit}");
        }
        for note in ["front", "GPS", "F", "2", "ch1", "F/R", "raw", "bar", "left hand", "0-100"] {
            assert!(!is_like_a_unit(note), "{note}");
        }
        assert_eq!(in_brackets("Brake F [ybar]"), Some("ybar"));
        assert_eq!(in_brackets("Brake F"), None);
    }
}
