//! Logs as other people's loggers write them: each situation is read right, warned of, or refused with the way out;
//! never wrong without a word.
//!
//! One ride is written in every way; the log read by the drafted map is compared with the ride itself.

mod clock;
mod formats;
mod languages;
mod layout;
mod lost;
mod positions;

use std::fmt::Write as _;
use std::path::Path;

use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::checks::judge::{by_motion, draft};
use roadbench::internals::ingest::formats::survey::survey;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::{self, Config};
use roadbench::internals::store::objects::Location;

/// A moment of the ride.
#[derive(Debug, Clone, Copy)]
pub struct Row {
    /// s
    pub t: f64,
    /// m/s
    pub v: f64,
    /// Degrees.
    pub lat: f64,
    pub lon: f64,
    /// Degrees, right positive.
    pub lean: f64,
    /// Degrees, clockwise from north.
    pub course: f64,
}

impl Row {
    pub fn kmh(&self) -> f64 {
        3.6 * self.v
    }
}

/// A ride of bends at 14 to 25 m/s, from 47 N, 8 E.
pub fn ride(rows: usize, step: f64) -> Vec<Row> {
    let (mut lat, mut lon, mut course) = (47.0_f64, 8.0_f64, 1.5_f64);
    let (fine, mut out) = (100, Vec::with_capacity(rows));
    for i in 0..rows {
        let mut t = i as f64 * step;
        let speed = |t: f64| 19.5 + 5.5 * (0.42 * t).sin();
        let lean = |t: f64| 0.6 * (0.5 * t).sin();
        out.push(Row {
            t,
            v: speed(t),
            lat,
            lon,
            lean: lean(t).to_degrees(),
            course: course.to_degrees().rem_euclid(360.0),
        });
        for _ in 0..fine {
            let dt = step / f64::from(fine);
            course += 9.81 * lean(t).tan() / speed(t) * dt;
            lat += speed(t) * course.cos() * dt / 111_170.0;
            lon += speed(t) * course.sin() * dt / (111_320.0 * 47.0_f64.to_radians().cos());
            t += dt;
        }
    }
    out
}

/// The usual ride: 29.5 s at 2 Hz.
pub fn usual() -> Vec<Row> {
    ride(60, 0.5)
}

/// A CSV of the usual columns with a clock in front.
pub fn csv(clock: &str, rows: &[Row], stamp: impl Fn(usize, &Row) -> String) -> String {
    let mut text = format!("{clock},GPS Speed (km/h),Latitude (deg),Longitude (deg),Lean (deg)\n");
    for (i, r) in rows.iter().enumerate() {
        let stamp = stamp(i, r);
        let _ = writeln!(text, "{stamp},{:.2},{:.7},{:.7},{:.1}", r.kmh(), r.lat, r.lon, r.lean);
    }
    text
}

/// The same between seconds.
pub fn plain() -> String {
    csv("Time (s)", &usual(), |_, r| format!("{:.2}", r.t))
}

/// What has to come out.
#[derive(Debug, Clone, Copy)]
pub enum Expected {
    /// The ride, without a word.
    Right,
    /// The ride, and a warning of this code.
    Warned(&'static str),
    /// An error that says this.
    Refused(&'static str),
}

/// A situation: what it is, the log's name and bytes, the ride, what has to come out.
pub struct Case {
    pub what: &'static str,
    pub file: &'static str,
    pub bytes: Vec<u8>,
    pub rows: Vec<Row>,
    pub expected: Expected,
}

pub fn case(what: &'static str, text: impl Into<Vec<u8>>, expected: Expected) -> Case {
    Case { what, file: "ride.csv", bytes: text.into(), rows: usual(), expected }
}

/// Warnings that say nothing of numbers.
const QUIET: [&str; 3] = ["unknown_column", "time_jitter", "down_sampled"];

/// Every situation as expected; the counts are printed.
pub fn hold(cases: Vec<Case>) {
    let (mut right, mut warned, mut refused, mut faults) = (0, 0, 0, Vec::new());
    for case in cases {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(case.file);
        std::fs::write(&path, &case.bytes).expect("written");
        match (read(&path), case.expected) {
            (Ok((session, warnings, map)), expected) => {
                let wrong = off(&session, &case.rows);
                let said: Vec<&str> =
                    warnings.iter().map(|w| w.0).filter(|w| !QUIET.contains(w)).collect();
                match (wrong, expected) {
                    (Some(wrong), _) => {
                        faults.push(format!("{}: {wrong}; {warnings:?}\n{map}", case.what))
                    }
                    (None, Expected::Right) if said.is_empty() => right += 1,
                    (None, Expected::Warned(code)) if said.contains(&code) => warned += 1,
                    (None, expected) => {
                        faults.push(format!(
                            "{}: right with {warnings:?}, expected {expected:?}\n{map}",
                            case.what
                        ));
                    }
                }
            }
            (Err(message), Expected::Refused(words)) if message.contains(words) => refused += 1,
            (Err(message), expected) => {
                faults.push(format!("{}: {message}, expected {expected:?}", case.what))
            }
        }
    }
    println!("right {right}, warned {warned}, refused {refused}, not as expected {}", faults.len());
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// Drafts a map for a log and reads the log by it: the session, the warnings, and the map.
#[allow(clippy::type_complexity)]
fn read(path: &Path) -> Result<(Session, Vec<(&'static str, String)>, String), String> {
    let log = Location::from(path.to_path_buf());
    let said = |e: ingest::Error| e.to_string();
    let aids = Aids::default();
    let seen = survey(&log, &aids).map_err(said)?.ok_or("it cannot be listed")?;
    let verdicts = by_motion(&log, &aids, &seen, None).map_err(said)?;
    let text = draft(&log, &seen, &verdicts);
    let map = ChannelMap::parse(&text, "m.toml")
        .map_err(|e| format!("{e}; {:?}", seen.listing.warnings))?;
    let raw = ingest::read(path, &[map]).map_err(said)?;
    let (session, warnings) = ingest::run(raw, &Config::default()).map_err(said)?;
    let of_listing = seen.listing.warnings.into_iter();
    let warnings = of_listing.chain(warnings).map(|w| (w.code, w.message)).collect();
    Ok((session, warnings, text))
}

/// What is wrong with a session of the ride.
fn off(session: &Session, rows: &[Row]) -> Option<String> {
    let last = rows.last()?.t;
    let duration = (session.len - 1) as f64 / session.rate;
    // a row at the end may be missing
    if (duration - last).abs() > 0.02 * last + 0.6 {
        return Some(format!("{duration:.3} s instead of {last:.3} s at {} Hz", session.rate));
    }
    let between = |t: f64, of: &dyn Fn(&Row) -> f64| {
        let step = rows[1].t - rows[0].t;
        let place = t / step;
        let i = (place.floor() as usize).min(rows.len() - 2);
        let share = place - i as f64;
        of(&rows[i]) * (1.0 - share) + of(&rows[i + 1]) * share
    };
    type Truth<'a> = &'a dyn Fn(&Row) -> f64;
    let checks: [(Channel, Truth<'_>, f64); 3] = [
        (Channel::VelocityX, &|r| r.v, 0.35),
        (Channel::Latitude, &|r| r.lat, 3e-5),
        (Channel::Longitude, &|r| r.lon, 3e-5),
    ];
    for (channel, truth, near) in checks {
        let Some(x) = session.get(channel) else { return Some(format!("{channel} is missing")) };
        let there = x.iter().filter(|v| v.is_finite()).count();
        if there * 4 < x.len() * 3 {
            return Some(format!("{channel}: only {there} of {} samples", x.len()));
        }
        for (k, v) in x.iter().enumerate().filter(|(_, v)| v.is_finite()) {
            let wanted = between(k as f64 / session.rate, truth);
            if (v - wanted).abs() > near {
                return Some(format!(
                    "{channel} is {v} at {:.2} s, not {wanted}",
                    k as f64 / session.rate
                ));
            }
        }
    }
    None
}
