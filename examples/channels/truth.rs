//! What is true of the logs of the simulator's loggers, and how a map is scored against it.
//!
//! Shared by the study and by `tests/it/channels_by_physics.rs`.

use std::path::Path;

use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::checks::aids::Aids;
use roadbench::internals::ingest::checks::judge::{by_motion, draft};
use roadbench::internals::ingest::formats::listing::Listing;
use roadbench::internals::ingest::formats::survey::survey;
use roadbench::internals::ingest::map_for;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::ingest::maps::propose::compare::{FindingKind, compare, mend};
use roadbench::internals::ingest::maps::propose::physics::Verdicts;
use roadbench::internals::ingest::maps::units;
use roadbench::internals::store::objects::Location;

use Channel::*;

/// A delay within this of the truth is right, s.
pub const DELAY: f64 = 0.05;

/// One channel that a map has to have.
pub struct Expected {
    pub column: Channel,
    pub from: &'static str,
    pub unit: &'static str,
    pub sign: f64,
    /// After the earliest of the log, s.
    pub delay: f64,
}

const fn of(
    column: Channel,
    from: &'static str,
    unit: &'static str,
    sign: f64,
    delay: f64,
) -> Expected {
    Expected { column, from, unit, sign, delay }
}

/// The channels of a profile that a map has to have; everything else must be left out.
///
/// Left out for good reasons: what is fixed to the leaning frame of a log that has a measured lean (the factory's
/// accelerations, yaw and pitch rate), calculated leans, and lengths without a unit.
#[rustfmt::skip]
pub fn expected(profile: &str) -> &'static [Expected] {
    match profile {
        "superbike" => const { &[
            of(VelocityX, "GPS Speed (km/h)", "km/h", 1.0, 0.2), of(Roll, "Lean (deg)", "deg", 1.0, 0.04),
            of(Yaw, "Course (deg)", "deg", -1.0, 0.2), of(WheelSpeedFront, "Wheel Speed F (km/h)", "km/h", 1.0, 0.0),
            of(WheelSpeedRear, "Wheel Speed R (km/h)", "km/h", 1.0, 0.0),
            of(BrakePressureFront, "Brake F (bar)", "bar", 1.0, 0.0),
            of(BrakePressureRear, "Brake R (bar)", "bar", 1.0, 0.0), of(Throttle, "TPS (%)", "%", 1.0, 0.0),
            of(Gear, "Gear", "1", 1.0, 0.0), of(Latitude, "Latitude (deg)", "deg", 1.0, 0.2),
            of(Longitude, "Longitude (deg)", "deg", 1.0, 0.2), of(LapNumber, "Lap", "1", 1.0, 0.0),
            of(Altitude, "Altitude (m)", "m", 1.0, 0.2),
        ] },
        "factory" => const { &[
            of(VelocityX, "v_gps", "km/h", 1.0, 0.12), of(Roll, "lean_imu", "deg", 1.0, 0.02),
            of(RollRate, "rollrate_imu", "deg/s", 1.0, 0.0), of(WheelSpeedFront, "v_front", "km/h", 1.0, 0.0),
            of(WheelSpeedRear, "v_rear", "km/h", 1.0, 0.0), of(BrakePressureFront, "p_brake_fr", "bar", 1.0, 0.0),
            of(BrakePressureRear, "p_brake_rr", "bar", 1.0, 0.0), of(Throttle, "pos_throttle", "%", 1.0, 0.0),
            of(Gear, "gear", "1", 1.0, 0.0), of(Latitude, "lat_gps", "deg", 1.0, 0.12),
            of(Longitude, "lon_gps", "deg", 1.0, 0.12),
        ] },
        "phone" => const { &[
            of(VelocityX, "Speed", "km/h", 1.0, 0.0), of(Latitude, "Latitude", "deg", 1.0, 0.0),
            of(Longitude, "Longitude", "deg", 1.0, 0.0), of(ImuRateX, "GyroX", "deg/s", 1.0, 0.0),
            of(ImuRateY, "GyroY", "deg/s", 1.0, 0.0), of(ImuRateZ, "GyroZ", "deg/s", 1.0, 0.0),
            of(ImuForceX, "GForceX", "g", 1.0, 0.0), of(ImuForceY, "GForceY", "g", 1.0, 0.0),
            of(ImuForceZ, "GForceZ", "g", 1.0, 0.0), of(LapNumber, "Lap", "1", 1.0, 0.0),
        ] },
        "satellite" => const { &[
            of(VelocityX, "velocity", "km/h", 1.0, 0.0), of(Yaw, "heading", "deg", -1.0, 0.0),
            of(Throttle, "throttle", "%", 1.0, 0.08), of(Latitude, "lat", "deg", 1.0, 0.0),
            of(Longitude, "long", "deg", 1.0, 0.0), of(Altitude, "height", "m", 1.0, 0.0),
        ] },
        _ => &[],
    }
}

/// A log and what its motion says.
pub struct Judged {
    pub log: Location,
    pub listing: Listing,
    pub verdicts: Verdicts,
    /// The map that `roadbench map` writes.
    #[allow(dead_code)] // not every study reads it
    pub draft: String,
}

/// Judges a log; usual radii stand in for the logger's.
pub fn judged(log: &Path) -> Judged {
    judged_on(log, [0.3, 0.315])
}

/// Judges a log; the radii of a bike file (front and rear, m) stand in for the logger's.
pub fn judged_on(log: &Path, radii: [f64; 2]) -> Judged {
    let log = Location::from(log.to_path_buf());
    let survey = survey(&log, &Aids::default()).expect("read").expect("listed");
    let verdicts = by_motion(&log, &Aids::default(), &survey, Some(radii)).expect("judged");
    let draft = draft(&log, &survey, &verdicts);
    Judged { log, listing: survey.listing, verdicts, draft }
}

/// How a draft does.
#[derive(Default)]
pub struct Score {
    pub right: usize,
    pub expected: usize,
    /// In force and not right.
    pub wrong: Vec<String>,
    /// Not in force.
    pub missing: Vec<String>,
    /// Errors of the delays that are not 0, s.
    pub late: Vec<f64>,
}

pub fn score(judged: &Judged, profile: &str) -> Score {
    // a counter that never counts cannot be recognised
    let constant = |x: &&Expected| {
        let at = |i: &usize| judged.listing.channels[*i].full() == x.from;
        judged.verdicts.constant.iter().any(at)
    };
    // bundled logs have no altitude
    let listed =
        |x: &&Expected| judged.listing.channels.iter().any(|channel| channel.full() == x.from);
    let expected: Vec<&Expected> =
        expected(profile).iter().filter(|x| listed(x) && !constant(x)).collect();
    let mut score = Score { expected: expected.len(), ..Score::default() };
    let sure = || judged.verdicts.entries.iter().filter(|e| e.doubt.is_none());
    for e in sure() {
        let from = judged.listing.channels[e.source].full();
        let right = expected.iter().find(|x| x.column == e.channel && x.from == from);
        let said = format!("{} <- {from} in {}, {:+}, {} s", e.channel, e.unit, e.sign, e.delay);
        let Some(x) = right else {
            score.wrong.push(said);
            continue;
        };
        let unit = units::same(&e.unit, x.unit) == Some(true);
        if x.delay > 0.0 {
            score.late.push(e.delay - x.delay);
        }
        if unit && e.sign == x.sign && (e.delay - x.delay).abs() <= DELAY {
            score.right += 1;
        } else {
            score.wrong.push(said);
        }
    }
    let absent = expected.iter().filter(|x| !sure().any(|e| e.channel == x.column));
    score.missing = absent.map(|x| format!("{} <- {}", x.column, x.from)).collect();
    score
}

/// Something planted into an entry of a right map.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Planted {
    Sign(Channel),
    /// The number scaled by this.
    Unit(Channel, f64),
    Swapped(Channel, Channel),
    Delay(Channel),
}

/// What is planted into the maps of a profile, one at a time.
pub fn planted(profile: &str) -> Vec<Planted> {
    let has = |c: Channel| expected(profile).iter().any(|x| x.column == c);
    let mut all = Vec::new();
    for c in [Roll, Yaw, RollRate, WheelSpeedFront] {
        all.push((c, Planted::Sign(c)));
    }
    for (c, factor) in
        [(VelocityX, 3.6), (Roll, 57.3), (WheelSpeedRear, 1.0 / 3.6), (BrakePressureFront, 14.5)]
    {
        all.push((c, Planted::Unit(c, factor)));
    }
    all.push((WheelSpeedFront, Planted::Swapped(WheelSpeedFront, WheelSpeedRear)));
    all.push((BrakePressureFront, Planted::Swapped(BrakePressureFront, BrakePressureRear)));
    for c in [VelocityX, Roll, BrakePressureFront, Throttle, Yaw] {
        all.push((c, Planted::Delay(c)));
    }
    all.into_iter().filter(|(c, _)| has(*c)).map(|(_, p)| p).collect()
}

/// The right map of a profile with something planted, or nothing.
pub fn map_text(profile: &str, circumference: [f64; 2], planted: Option<Planted>) -> String {
    let (format, time) = match profile {
        "superbike" => ("csv", "[time]\ncolumn = \"Time (ms)\"\nunit = \"ms\"\n"),
        "factory" => ("csv", "[time]\ncolumn = \"t\"\nunit = \"s\"\n"),
        "phone" => ("racebox", ""),
        _ => ("vbo", ""),
    };
    let mut text = format!("name = \"mine\"\nformat = \"{format}\"\n\n{time}");
    for x in expected(profile).iter().filter(|x| x.column != Altitude) {
        let c = x.column;
        let other = match planted {
            Some(Planted::Swapped(a, b)) if c == a => b,
            Some(Planted::Swapped(a, b)) if c == b => a,
            _ => c,
        };
        let from = expected(profile).iter().find(|x| x.column == other).map_or("", |x| x.from);
        let turned = planted == Some(Planted::Sign(c));
        let sign = if turned { -x.sign } else { x.sign };
        let late = if planted == Some(Planted::Delay(c)) { 0.2 } else { 0.0 };
        text += &format!("\n[channel.{c}]\nfrom = {from:?}\n");
        if x.unit != "1" {
            text += &format!("unit = {:?}\n", x.unit);
        }
        text += &format!("sign = {sign}\ndelay = {}\n", x.delay + late);
        if let Some(k) = [WheelSpeedFront, WheelSpeedRear].iter().position(|w| *w == c) {
            text += &format!("radius = {:.5}\n", circumference[k] / std::f64::consts::TAU);
        }
        if let Some(Planted::Unit(p, factor)) = planted
            && p == c
        {
            text += &format!("scale = {factor}\n");
        }
    }
    text
}

/// Result for a planted error: found, correctly identified, mended completely; and other findings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Checked {
    pub found: bool,
    pub named: bool,
    pub mended: bool,
    /// Findings on columns that are right.
    pub false_alarms: usize,
}

fn fitted(judged: &Judged, text: &str) -> ChannelMap {
    let map = ChannelMap::parse(text, "mine").unwrap_or_else(|e| panic!("{e}\n{text}"));
    map_for(&judged.log, &[map]).expect("fits").expect("needs one")
}

/// Checks a map with something planted, or a right one.
pub fn check(
    judged: &Judged,
    profile: &str,
    circumference: [f64; 2],
    planted: Option<Planted>,
) -> Checked {
    let text = map_text(profile, circumference, planted);
    let found = compare(&fitted(judged, &text), &judged.listing, &judged.verdicts);
    let (columns, wrong): (Vec<Channel>, &[FindingKind]) = match planted {
        Some(Planted::Sign(c)) => (vec![c], &[FindingKind::Sign]),
        Some(Planted::Unit(c, _)) => (vec![c], &[FindingKind::Unit]),
        Some(Planted::Swapped(a, b)) => (vec![a, b], &[FindingKind::Channel]),
        Some(Planted::Delay(c)) => (vec![c], &[FindingKind::Delay]),
        None => (Vec::new(), &[]),
    };
    let on = |c: &Channel| found.findings.iter().filter(|f| f.channel == *c).collect::<Vec<_>>();
    let named =
        columns.iter().all(|c| on(c).len() == 1 && on(c).iter().all(|f| wrong.contains(&f.wrong)));
    let others = found.findings.iter().filter(|f| !columns.contains(&f.channel)).count();
    let mended = mend(&text, &judged.listing, &found.findings);
    let again = compare(&fitted(judged, &mended), &judged.listing, &judged.verdicts);
    let right = fitted(judged, &map_text(profile, circumference, None));
    let same = fitted(judged, &mended).entries.iter().all(|m| {
        let Some(r) = right.entries.iter().find(|r| r.channel == m.channel) else { return false };
        let factor = m.to_si.factor / r.to_si.factor;
        m.from == r.from && (0.85..1.2).contains(&factor) && (m.delay - r.delay).abs() <= 0.1
    });
    Checked {
        found: columns.iter().any(|c| !on(c).is_empty()),
        named: named && !columns.is_empty(),
        mended: same && again.findings.is_empty(),
        false_alarms: others,
    }
}
