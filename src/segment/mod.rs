//! A session cut into manoeuvres.
//!
//! Assumes a filtered session. A few signals on a coarse clock ([`features`]) are looked at by
//! one detector per manoeuvre; the first in the list below that claims a block has it:
//!
//! ```text
//! standing or slow  >  bend  >  rolling in or out  >  braking  >  coasting  >  driving
//! ```
//! Each detector has a threshold to enter, a lower one to leave and a shortest length. What
//! they found is judged: quasi-static? uncombined? long and strong enough? What cannot be used
//! stays in the table with its reason, and so does the rest (`other`), so that the segments
//! cover the session.
//!
//! Adding a manoeuvre: its file, its line in `Claim` and in [`run`].
//!
//! Cost: the means over the coarse blocks; a 20-minute session takes a few milliseconds.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::contract::bike::Bike;
use crate::contract::manoeuvre::{Direction, ManoeuvreKind};
use crate::contract::session::Session;

pub mod braking;
pub mod coasting;
pub mod cornering;
pub mod driving;
pub mod features;
mod heading;
mod mask;
pub mod offroad;

use features::Features;

/// Settings of the stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Below this speed nothing begins, m/s.
    pub min_speed: f64,
    /// Below this speed everything ends, m/s.
    pub end_speed: f64,
    /// Bends.
    pub cornering: cornering::Config,
    /// Brakings.
    pub braking: braking::Config,
    /// Coasting.
    pub coasting: coasting::Config,
    /// Driving.
    pub driving: driving::Config,
    /// Off-road manoeuvres.
    pub offroad: offroad::Config,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            min_speed: 2.0,
            end_speed: 0.5,
            cornering: cornering::Config::default(),
            braking: braking::Config::default(),
            coasting: coasting::Config::default(),
            driving: driving::Config::default(),
            offroad: offroad::Config::default(),
        }
    }
}

/// One manoeuvre: samples `start..end` of the session.
#[derive(Debug, Clone, PartialEq)]
pub struct Segment {
    /// What.
    pub kind: ManoeuvreKind,
    /// First sample.
    pub start: usize,
    /// One past the last sample.
    pub end: usize,
    /// Which way, where it can be told.
    pub direction: Option<Direction>,
    /// 0 (unusable) to 1.
    pub quality: f64,
    /// Whether estimation may use it.
    pub used: bool,
    /// Why not.
    pub reason: Option<String>,
}

/// What a judge says of a segment.
#[derive(Debug, Clone, PartialEq)]
pub struct Verdict {
    /// 0 to 1.
    pub quality: f64,
    /// Why it cannot be used.
    pub reason: Option<String>,
}

/// What several judges ask for.
#[derive(Debug)]
pub struct Evidence {
    /// Blocks in which a brake is on, in bends too.
    pub braking: Vec<bool>,
}

/// Who has a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Claim {
    Unknown,
    Slow,
    Cornering(Direction),
    Rolling,
    Braking(ManoeuvreKind),
    Coasting,
    Driving,
}

impl Claim {
    fn kind(self) -> ManoeuvreKind {
        match self {
            Claim::Unknown | Claim::Slow | Claim::Rolling => ManoeuvreKind::Other,
            Claim::Cornering(_) => ManoeuvreKind::Cornering,
            Claim::Braking(kind) => kind,
            Claim::Coasting => ManoeuvreKind::Coasting,
            Claim::Driving => ManoeuvreKind::Driving,
        }
    }
}

/// Cuts a filtered session into segments, in time order, none overlapping, all of it covered.
/// Empty without forward velocity.
pub fn run(session: &Session, bike: &Bike, config: &Config) -> Vec<Segment> {
    let f = Features::new(session, bike);
    if f.is_empty() {
        return Vec::new();
    }
    let n = f.len();
    let brakings = braking::detect(&f, &config.braking);
    let mut evidence = Evidence { braking: vec![false; n] };
    for (run, _) in &brakings {
        evidence.braking[run.clone()].fill(true);
    }
    let corners = cornering::detect(&f, &config.cornering);
    let rolling = cornering::transitions(&f, &corners, &config.cornering);
    let free = coasting::detect(&f, &config.coasting);
    let moving = mask::hysteresis(f.speed.iter().copied(), config.min_speed, config.end_speed);

    let mut claims = vec![Claim::Driving; n];
    for i in 0..n {
        if free[i] {
            claims[i] = Claim::Coasting;
        }
    }
    for (run, kind) in &brakings {
        claims[run.clone()].fill(Claim::Braking(*kind));
    }
    for i in 0..n {
        if !f.speed[i].is_finite() {
            claims[i] = Claim::Unknown;
        } else if !moving[i] {
            claims[i] = Claim::Slow;
        } else if corners[i] {
            let left = f.lean[i] < 0.0;
            claims[i] = Claim::Cornering(if left { Direction::Left } else { Direction::Right });
        } else if rolling[i] {
            claims[i] = Claim::Rolling;
        }
    }
    let pieces = pieces(claims, &f, config);
    let axis = heading::Axis::new(&f, &pieces);
    // without any sign of lean a straight is only believed to be one
    let trust = if f.lean.iter().any(|l| l.is_finite()) { 1.0 } else { 0.5 };
    pieces
        .into_iter()
        .map(|(at, claim)| {
            let verdict = judge(&f, &at, claim, &evidence, config);
            let direction = match claim {
                Claim::Cornering(side) => Some(side),
                Claim::Braking(_) | Claim::Coasting | Claim::Driving => axis.direction(&f, &at),
                Claim::Unknown | Claim::Slow | Claim::Rolling => None,
            };
            Segment {
                kind: claim.kind(),
                start: at.start * f.step,
                end: (at.end * f.step).min(session.len),
                direction,
                quality: if verdict.quality.is_finite() { trust * verdict.quality } else { 0.0 },
                used: verdict.reason.is_none(),
                reason: verdict.reason,
            }
        })
        .collect()
}

/// Runs of equal claims; ones too short to be anything go to the longer neighbour.
fn pieces(claims: Vec<Claim>, f: &Features, config: &Config) -> Vec<(Range<usize>, Claim)> {
    let mut out: Vec<(Range<usize>, Claim)> = Vec::new();
    for (i, claim) in claims.into_iter().enumerate() {
        match out.last_mut() {
            Some((at, last)) if *last == claim => at.end = i + 1,
            _ => out.push((i..i + 1, claim)),
        }
    }
    let shortest = |claim: Claim| match claim {
        Claim::Unknown | Claim::Slow | Claim::Cornering(_) => 0,
        Claim::Rolling => f.blocks(0.2),
        Claim::Braking(_) => f.blocks(config.braking.shortest),
        Claim::Coasting => f.blocks(config.coasting.shortest),
        Claim::Driving => f.blocks(0.3),
    };
    while let Some(k) = (0..out.len())
        .filter(|&k| out.len() > 1 && out[k].0.len() < shortest(out[k].1))
        .min_by_key(|&k| out[k].0.len())
    {
        let before = k.checked_sub(1).map_or(0, |j| out[j].0.len());
        let after = out.get(k + 1).map_or(0, |p| p.0.len());
        let (at, _) = out.remove(k);
        let heir = if before >= after { k - 1 } else { k };
        let whole = &mut out[heir].0;
        *whole = whole.start.min(at.start)..whole.end.max(at.end);
        // what was on both sides of it may be of one kind
        if k > 0 && k < out.len() && out[k - 1].1 == out[k].1 {
            let (next, _) = out.remove(k);
            out[k - 1].0.end = next.end;
        }
    }
    out
}

fn judge(
    f: &Features,
    at: &Range<usize>,
    claim: Claim,
    evidence: &Evidence,
    config: &Config,
) -> Verdict {
    let never = |reason: String| Verdict { quality: 0.0, reason: Some(reason) };
    match claim {
        Claim::Unknown => never("no forward velocity recorded".into()),
        Claim::Slow => never(format!("standing or slower than {:.1} m/s", config.min_speed)),
        Claim::Rolling => never("rolling into or out of a bend".into()),
        Claim::Cornering(_) => cornering::judge(f, at, evidence, &config.cornering),
        Claim::Braking(kind) => braking::judge(f, at, kind, evidence, &config.braking),
        Claim::Coasting => coasting::judge(f, at, &config.coasting),
        Claim::Driving => driving::judge(f, at, &config.driving),
    }
}
