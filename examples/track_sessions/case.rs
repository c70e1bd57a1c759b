//! A session on the track as one logger wrote it: read as a user would, beside its truth.
//!
//! Shared by the study and by `tests/it/track_sessions.rs`.

use std::path::{Path, PathBuf};

use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part};
use roadbench::internals::estimate;
use roadbench::internals::ingest::maps::ChannelMap;
use roadbench::internals::pipeline::{self, Input, Outcome, Pipeline};
use roadbench::internals::segment::manoeuvre::ManoeuvreKind as Kind;
use roadbench::internals::simulate::loggers::{self, Profile};
use roadbench::internals::simulate::track::{self, Track, TrackRide};
use roadbench::internals::simulate::{truth, tyre_truth};
use roadbench::internals::store::objects::Location;

use super::channels::{Judged, judged_on};

/// The loggers, in the order of the tables.
pub const PROFILES: [Profile; 4] =
    [Profile::Superbike, Profile::Factory, Profile::Phone, Profile::Satellite];
/// Of the comparison of manoeuvres, Hz.
const RATE: f64 = 50.0;

/// The built-in track with everything varied: machine, circuit, rider, slope, wind, unevenness.
pub fn varied(seed: u64) -> Track {
    let track = Track::load("track").expect("built in").expect("a track");
    Track { seed, unevenness: [2.0, 16.0], varied_circuit: true, ..track }
}

/// A number of TOML, which a whole one may be without a point.
fn number(value: &toml::Value) -> f64 {
    value.as_float().or(value.as_integer().map(|x| x as f64)).expect("a number")
}

/// What is asked of a session.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Asked {
    pub id: Id,
    /// As the table has it.
    pub words: &'static str,
    pub truth: f64,
    /// The truth in the scale of the log: wheel speeds in km/h hide the circumference that they were computed with.
    pub in_scale: f64,
    /// Whether a lower bound counts.
    pub bound: bool,
}

/// The truth of what a track session may give, on a log whose wheel speeds were computed with circumferences (m).
pub fn asked(ridden: &TrackRide, circumference: [f64; 2]) -> Vec<Asked> {
    let (model, bike) = (&ridden.entry.model, &ridden.entry.bike);
    let bench = tyre_truth::coefficients(model);
    let of = |id: Id| bench.iter().find(|(known, _)| *known == id).map_or(f64::NAN, |(_, x)| *x);
    let notes: toml::Table = track::notes(ridden).parse().expect("TOML");
    let pair = |key: &str, k: usize| number(&notes[key][k]);
    let m = &model.motorcycle;
    let weight = m.mass() * m.gravity;
    let ratio = Axle::BOTH.map(|axle| of(Id::from((axle, C::SideForceRatio))));
    let corners = truth::of_corners(&ridden.ride, weight, ratio, &estimate::Config::default());
    let cornering =
        |id: Id| corners.iter().find(|(known, _)| *known == id).map_or(f64::NAN, |(_, x)| *x);
    let mut all = Vec::new();
    for (k, axle) in Axle::BOTH.into_iter().enumerate() {
        let word = |front, rear| if k == 0 { front } else { rear };
        let mut ask = |coefficient, words, truth, in_scale, bound| {
            let id = Id::from((axle, coefficient));
            all.push(Asked { id, words, truth, in_scale, bound });
        };
        let radius = of(Id::from((axle, C::EffectiveRollingRadius)));
        let scale = bike.wheel(axle).radius / (circumference[k] / std::f64::consts::TAU);
        let words = word("front rolling radius", "rear rolling radius");
        ask(C::EffectiveRollingRadius, words, radius, radius * scale, false);
        let words = word("front slip stiffness", "rear slip stiffness");
        let stiffness = pair("slip_stiffness", k);
        ask(C::SlipStiffness, words, stiffness, stiffness, false);
        let words = word("front peak friction", "rear peak friction");
        let peak = of(Id::from((axle, C::MfD)));
        ask(C::MfD, words, peak, peak, true);
        let words = word("front lateral friction", "rear lateral friction");
        let ct = cornering(Id::from((axle, C::LateralFrictionCt)));
        ask(C::LateralFrictionCt, words, ct, ct, false);
        let words = word("front overturning stiffness", "rear overturning stiffness");
        let crown = pair("crown_radius", k);
        ask(C::OverturningStiffness, words, crown, crown, false);
    }
    let drag = of(Id::from((Part::Vehicle, C::Drag)));
    let id = Id::from((Part::Vehicle, C::Drag));
    all.push(Asked { id, words: "drag", truth: drag, in_scale: drag, bound: false });
    all
}

/// A log of one session and what came of it.
pub struct Read {
    pub judged: Judged,
    /// Nominal circumferences, m.
    pub circumference: [f64; 2],
    /// By the map as drafted.
    pub outcome: Result<Outcome, String>,
    /// The same without the brake pressures in the map, where it has some.
    pub without: Option<Result<Outcome, String>>,
    /// How much earlier than the log's the sessions' clocks begin, s.
    pub earlier: f64,
    /// How far the wheels' scales may be off by the map: a share, one standard deviation.
    pub scale_sd: [f64; 2],
}

/// A log and what its motion says, nothing computed from it.
pub struct Drafted {
    pub log: PathBuf,
    pub judged: Judged,
    /// Nominal circumferences, m.
    pub circumference: [f64; 2],
}

/// Writes what a logger saw into a folder and drafts its map with the bike file.
///
/// # Panics
/// Where the folder cannot be written.
pub fn drafted(profile: Profile, ridden: &TrackRide, seed: u64, folder: &Path) -> Drafted {
    let foreign = loggers::write(profile, ridden, seed);
    let known: toml::Table = foreign.truth.parse().expect("TOML");
    let circumference = [0, 1].map(|k| number(&known["circumference"][k]));
    let log = folder.join(format!("{}_{}", ridden.ride.session.meta.session_id, foreign.file));
    std::fs::write(&log, &foreign.text).expect("written");
    let bike = &ridden.entry.bike;
    let judged = judged_on(&log, Axle::BOTH.map(|axle| bike.wheel(axle).radius));
    Drafted { log, judged, circumference }
}

/// Drafts a logger's map and runs its log by it.
///
/// # Panics
/// Where the folder cannot be written or a drafted map is none.
pub fn read(
    profile: Profile,
    ridden: &TrackRide,
    seed: u64,
    folder: &Path,
    pipeline: &Pipeline,
) -> Read {
    let Drafted { log, judged, circumference } = drafted(profile, ridden, seed, folder);
    let bike = &ridden.entry.bike;
    let map = ChannelMap::parse(&judged.draft, "draft.toml")
        .unwrap_or_else(|e| panic!("{e}\n{}", judged.draft));
    let run = |map: ChannelMap| {
        let maps = [map];
        let input = Input {
            log: Location::from(log.clone()),
            maps: &maps,
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        pipeline::run(&input, bike, pipeline).map_err(|e| format!("{}: {}", e.code, e.message))
    };
    let pressure =
        |c: Channel| matches!(c, Channel::BrakePressureFront | Channel::BrakePressureRear);
    let earlier = map.entries.iter().map(|e| e.delay).fold(0.0, f64::max);
    let scale_sd = map.wheel_scale_sd();
    let without = map.entries.iter().any(|e| pressure(e.channel)).then(|| {
        let mut map = map.clone();
        map.entries.retain(|e| !pressure(e.channel));
        run(map)
    });
    Read { outcome: run(map), judged, circumference, without, earlier, scale_sd }
}

/// Kinds of manoeuvre that a track session has.
pub const KINDS: [Kind; 5] =
    [Kind::Driving, Kind::FrontBraking, Kind::RearBraking, Kind::CombinedBraking, Kind::Cornering];

/// Where the braking manoeuvres are in them.
const BRAKINGS: std::ops::Range<usize> = 1..4;

/// Seconds by kind: right, of the truth, found; and what engine braking was taken for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Segmented {
    pub right: [f64; KINDS.len()],
    pub truth: [f64; KINDS.len()],
    pub found: [f64; KINDS.len()],
    /// Of braking manoeuvres of any kind.
    pub braking: [f64; 3],
    /// Upright with a closed throttle and no brake.
    pub engine: f64,
    /// Of that found to be rear braking, ...
    pub as_rear: f64,
    /// ... and used as such.
    pub as_rear_used: f64,
}

impl Segmented {
    pub fn add(&mut self, other: &Segmented) {
        for k in 0..KINDS.len() {
            self.right[k] += other.right[k];
            self.truth[k] += other.truth[k];
            self.found[k] += other.found[k];
        }
        (0..3).for_each(|k| self.braking[k] += other.braking[k]);
        self.engine += other.engine;
        self.as_rear += other.as_rear;
        self.as_rear_used += other.as_rear_used;
    }

    /// Of braking manoeuvres of any kind.
    pub fn f1_braking(&self) -> f64 {
        2.0 * self.braking[0] / (self.braking[1] + self.braking[2])
    }

    /// `None` of a kind that neither is there nor was found.
    pub fn f1(&self, kind: usize) -> Option<f64> {
        let all = self.truth[kind] + self.found[kind];
        (all > 0.0).then(|| 2.0 * self.right[kind] / all)
    }
}

/// A wheel takes part in a braking when it brakes for this share of the time, as the segmenter has it.
const TAKES_PART: f64 = 0.2;

/// The ride's manoeuvres; a braking is one from its beginning to its end, though the rear brake comes and goes in it.
fn whole_brakings(ridden: &TrackRide) -> Vec<(Kind, f64, f64)> {
    let is_braking = |k: Kind| KINDS[BRAKINGS].contains(&k);
    let mut out: Vec<(Kind, f64, f64)> = Vec::new();
    let mut seconds = [0.0; 2];
    for &(kind, start, end, _) in &ridden.ride.labels {
        let on = [Kind::RearBraking, Kind::FrontBraking].map(|alone| kind != alone);
        let add =
            |seconds: [f64; 2]| [0, 1].map(|k| seconds[k] + if on[k] { end - start } else { 0.0 });
        match out.last_mut() {
            Some(last) if is_braking(last.0) && is_braking(kind) => {
                seconds = add(seconds);
                last.2 = end;
                let length = end - last.1;
                last.0 = match seconds.map(|s| s >= TAKES_PART * length) {
                    [true, false] => Kind::FrontBraking,
                    [false, true] => Kind::RearBraking,
                    _ => Kind::CombinedBraking,
                };
            }
            _ => {
                seconds = add([0.0; 2]);
                out.push((kind, start, end));
            }
        }
    }
    out
}

/// Manoeuvres found against those ridden.
pub fn segmented(ridden: &TrackRide, outcome: &Outcome, earlier: f64) -> Segmented {
    let n = (ridden.ride.session.duration() * RATE) as usize;
    let range = |start: f64, end: f64| {
        let at = |t: f64| ((t * RATE).round().max(0.0) as usize).min(n);
        at(start)..at(end)
    };
    let mut truth = vec![None; n];
    for (kind, start, end) in whole_brakings(ridden) {
        truth[range(start, end)].fill(KINDS.iter().position(|k| *k == kind));
    }
    let mut found = vec![(None, false); n];
    for m in &outcome.manoeuvres {
        let kind = KINDS.iter().position(|k| k.name() == m.kind);
        found[range(m.start - earlier, m.end - earlier)].fill((kind, m.used));
    }
    let mut out = Segmented::default();
    let span = 1.0 / RATE;
    for (truth, (found, _)) in truth.iter().zip(&found) {
        let (a, b) = (*truth, *found);
        if let Some(k) = a {
            out.truth[k] += span;
            out.right[k] += if a == b { span } else { 0.0 };
        }
        if let Some(k) = b {
            out.found[k] += span;
        }
        let [there, seen] = [a, b].map(|k| k.is_some_and(|k| BRAKINGS.contains(&k)));
        let counted = [there && seen, there, seen].map(|x| if x { span } else { 0.0 });
        (0..3).for_each(|k| out.braking[k] += counted[k]);
    }
    for doing in track::doings(ridden).iter().filter(|d| d.what == "engine_braking") {
        for (found, used) in &found[range(doing.start, doing.end)] {
            let rear = found.is_some_and(|k| KINDS[k] == Kind::RearBraking);
            out.engine += span;
            out.as_rear += if rear { span } else { 0.0 };
            out.as_rear_used += if rear && *used { span } else { 0.0 };
        }
    }
    out
}
