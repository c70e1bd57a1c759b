//! Front, rear and combined braking in a straight line.
//!
//! With pressures: a wheel with pressure brakes. Without: a deceleration that exceeds what coasting
//! and a closed throttle give, from where it begins. Which wheel it is follows from the wheels'
//! speeds: with slip stiffness `k` per load, a share `x` of the braking force in front and the
//! loads `N` (as parts of the weight, load transfer included),
//!
//! ```text
//! ln(omega_r / omega_f) = (|a| / g) / k (x / N_f - (1 - x) / N_r)
//! ```
//! solved for `x` over the whole braking: 1 is the front brake alone, 0 the rear brake alone,
//! 0.6 to 0.8 the usual mix. `k` is known to a quarter, which moves the ends by 0.1. In gear the engine's part
//! ([`engine`](super::engine)) is taken off the rear wheel's force first: what a closed throttle takes is no braking.
//! A deceleration beyond what the rear wheel can give is never the rear brake alone.

use crate::contract::reason::{Reason, ReasonCode};
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::declaration::{Course, Declaration, Peak, Terrain};
use super::detector::{Claim, Detector, Verdict};
use super::features::Features;
use super::mask::{close_holes, drop_short, hysteresis, runs};
use super::slip::SLIP_STIFFNESS;
use crate::GRAVITY;

pub(super) static FRONT_BRAKING: Declaration = Declaration {
    name: "front_braking",
    words: "front braking",
    description: "Front brake only, straight.",
    letter: "F",
    letter_by_side: None,
    colour: "#c0392b",
    colour_dark: "#e2695c",
    terrain: Terrain::Both,
    course: Course::Straight,
    brakes: [true, false],
    peak: Peak::Acceleration,
    force_row: Some(3),
};

pub(super) static REAR_BRAKING: Declaration = Declaration {
    name: "rear_braking",
    words: "rear braking",
    description: "Rear brake only, straight.",
    letter: "R",
    letter_by_side: None,
    colour: "#d98324",
    colour_dark: "#e8a555",
    terrain: Terrain::Both,
    course: Course::Straight,
    brakes: [false, true],
    peak: Peak::Acceleration,
    force_row: Some(4),
};

pub(super) static COMBINED_BRAKING: Declaration = Declaration {
    name: "combined_braking",
    words: "combined braking",
    description: "Both brakes, straight.",
    letter: "FR",
    letter_by_side: None,
    colour: "#8e44ad",
    colour_dark: "#b27fd0",
    terrain: Terrain::Both,
    course: Course::Straight,
    brakes: [true, true],
    peak: Peak::Acceleration,
    force_row: Some(5),
};

/// Braking with one brake alone of which a tyre's friction curve needs none with both: those need no shares.
pub(crate) const ENOUGH_ALONE: usize = 6;

/// Share of the last half second's hold at which the lever is being let go.
const LETTING_GO: f64 = 0.7;

/// Thresholds of braking manoeuvres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// A line pressure above this brakes, Pa.
    pub pressure: f64,
    /// It ends below this, Pa.
    pub pressure_end: f64,
    /// A wheel takes part when it brakes for this share of the time.
    pub least_share: f64,
    /// Without pressures: deceleration beyond coasting that no closed throttle gives, m/s².
    pub deceleration: f64,
    /// Without pressures: deceleration beyond coasting from which it has begun, m/s².
    pub deceleration_start: f64,
    /// It has ended below this share of its peak: letting go is not braking.
    pub end_share: f64,
    /// Without pressures: front share of the force above which it is the front brake alone.
    pub front_share: f64,
    /// Without pressures: front share below which it is the rear brake alone.
    pub rear_share: f64,
    /// Shortest, s.
    pub shortest: f64,
    /// Deceleration that must be reached for it to be used, m/s².
    pub least_peak: f64,
}

impl Default for Config {
    fn default() -> Self {
        Config {
            pressure: 6e4,
            pressure_end: 2.5e4,
            least_share: 0.2,
            deceleration: 1.3,
            deceleration_start: 0.25,
            end_share: 0.45,
            front_share: 0.87,
            rear_share: 0.2,
            shortest: 0.4,
            least_peak: 1.0,
        }
    }
}

/// Braking manoeuvres and the wheels that took part.
fn brakings(f: &Features, config: &Config) -> Vec<Claim> {
    let pressed = |p: &Option<Vec<f64>>| {
        p.as_ref().map(|p| {
            let mut on = hysteresis(p.iter().copied(), config.pressure, config.pressure_end);
            for run in runs(&on) {
                let over = config.end_share * p[run.clone()].iter().copied().fold(0.0, f64::max);
                for i in run.rev().take_while(|&i| p[i] < over) {
                    on[i] = false;
                }
            }
            close_holes(&mut on, f.blocks(0.1));
            on
        })
    };
    let on = [pressed(&f.pressure[0]), pressed(&f.pressure[1])];
    let mut events = Vec::new();
    if on.iter().all(Option::is_some) {
        let mut any: Vec<bool> = (0..f.len()).map(|i| on.iter().flatten().any(|m| m[i])).collect();
        drop_short(&mut any, f.blocks(0.12));
        for run in runs(&any) {
            let share = |m: &Option<Vec<bool>>| {
                m.iter().flat_map(|m| &m[run.clone()]).filter(|b| **b).count() as f64
                    / run.len() as f64
            };
            let kind = match on.each_ref().map(|m| share(m) >= config.least_share) {
                [true, true] => &COMBINED_BRAKING,
                [false, true] => &REAR_BRAKING,
                _ => &FRONT_BRAKING,
            };
            events.push(Claim::new(run, kind));
        }
        return events;
    }
    for run in decelerations(f, config) {
        let share = |m: &Option<Vec<bool>>| {
            m.as_ref().map(|m| {
                m[run.clone()].iter().filter(|b| **b).count() as f64 / run.len() as f64
                    >= config.least_share
            })
        };
        let kind = match (share(&on[0]), share(&on[1])) {
            // one pressure is known and that brake was not used: it was the other
            (Some(false), None) => &REAR_BRAKING,
            (None, Some(false)) => &FRONT_BRAKING,
            // a brake that is pressed is on, whatever the engine does to the rear wheel
            (Some(true), None) if by_slip(f, &run, config) != &FRONT_BRAKING => &COMBINED_BRAKING,
            (None, Some(true)) if by_slip(f, &run, config) != &REAR_BRAKING => &COMBINED_BRAKING,
            _ => by_slip(f, &run, config),
        };
        events.push(Claim::new(run, kind));
    }
    events
}

/// Where it slows down more than a closed throttle does.
fn decelerations(f: &Features, config: &Config) -> Vec<Range<usize>> {
    let n = f.len();
    // beyond what the engine takes
    let excess = |i: usize| f.surplus[i] + f.engine.at(i);
    let below = |i: usize, limit: f64| excess(i) < -limit;
    let mut out: Vec<Range<usize>> = Vec::new();
    let hard: Vec<bool> = (0..n).map(|i| below(i, config.deceleration)).collect();
    let longest_start = f.blocks(1.5);
    for run in runs(&hard) {
        let mut start = run.start;
        while start > 0
            && run.start - start < longest_start
            && below(start - 1, config.deceleration_start)
        {
            start -= 1;
        }
        let peak = run.clone().map(|i| -excess(i)).fold(0.0, f64::max);
        let over = (config.end_share * peak).max(config.deceleration_start);
        let mut end = run.end;
        while end < n && below(end, over) {
            end += 1;
        }
        // letting go takes a moment and is blurred by the mean: back to the last firm hold
        let hold = (end.saturating_sub(f.blocks(0.5)).max(run.start)..end)
            .map(|i| -excess(i))
            .fold(0.0, f64::max);
        while end > run.start + 1 && !below(end - 1, LETTING_GO * hold) {
            end -= 1;
        }
        match out.last_mut() {
            Some(last) if start <= last.end + f.blocks(0.3) => last.end = last.end.max(end),
            _ => out.push(start..end),
        }
    }
    out
}

/// Brake in use, by the motion of the wheels; both if that does not decide.
fn by_slip(f: &Features, run: &Range<usize>, config: &Config) -> &'static Declaration {
    let Some(slip) = &f.slip else { return &COMBINED_BRAKING };
    let (mut in_front, mut all, mut most) = (0.0, 0.0, 0.0_f64);
    for i in run.clone().filter(|&i| f.surplus[i] < -0.5 && slip[i].is_finite()) {
        let force = -f.surplus[i] / GRAVITY;
        let front = (f.static_front + f.transfer * force).clamp(0.05, 0.95);
        let rear = 1.0 - front;
        // beyond the peak the wheel locks and the proportion is lost
        let rear = rear * (f.rear_stiffness / SLIP_STIFFNESS);
        in_front += slip[i].clamp(-0.4, 0.4) * SLIP_STIFFNESS + force / rear;
        let by_brakes = (force - f.engine.at(i) / GRAVITY).max(0.1 * force);
        all += by_brakes / front + by_brakes / rear;
        most = most.max(-f.surplus[i]);
    }
    let share = if all > 0.0 { in_front / all } else { 0.5 };
    if share > config.front_share {
        &FRONT_BRAKING
    } else if share < config.rear_share && most < f.rear_limit {
        &REAR_BRAKING
    } else {
        &COMBINED_BRAKING
    }
}

/// The engine's part in a braking.
struct Engine {
    /// Share of the time in which it may brake.
    may: f64,
    /// Whether it is known what it takes.
    known: bool,
    /// Its share of the force, as far as it is known.
    share: f64,
}

impl Engine {
    fn of(f: &Features, at: &Range<usize>) -> Engine {
        let sum =
            |x: &dyn Fn(usize) -> f64| -> f64 { at.clone().map(x).filter(|x| x.is_finite()).sum() };
        Engine {
            may: sum(&|i| f64::from(u8::from(f.engine.may[i]))) / at.len().max(1) as f64,
            known: f.engine.level.is_some(),
            share: sum(&|i| f.engine.at(i)) / sum(&|i| -f.surplus[i]).max(1e-9),
        }
    }
}

impl Detector for Config {
    fn find(&self, f: &Features) -> Vec<Claim> {
        brakings(f, self)
    }

    fn shortest(&self) -> f64 {
        self.shortest
    }

    fn judge(&self, f: &Features, claim: &Claim, _: &[bool]) -> Verdict {
        let peak = claim.at.clone().map(|i| -f.acceleration[i]).fold(0.0, f64::max);
        let engine = Engine::of(f, &claim.at);
        let reason = if claim.kind == &COMBINED_BRAKING && !f.shares_measured {
            let known = f.slip.is_some() || f.pressure.iter().any(Option::is_some);
            Some(if known {
                let words = "both brakes: the tyres' shares of the force are not known";
                Reason::new(ReasonCode::UnknownShares, words)
            } else {
                let words = "which brake is unknown without wheel speeds or pressures";
                Reason::new(ReasonCode::UnknownBrake, words)
            })
        } else if peak < self.least_peak {
            Some(Reason::new(
                ReasonCode::Weak,
                format!(
                    "decelerates with {peak:.1} m/s² at most, less than {:.1}",
                    self.least_peak
                ),
            ))
        } else if claim.kind == &REAR_BRAKING
            && f.pressure[1].is_none()
            && engine.may > 0.5
            && !engine.known
        {
            Some(Reason::new(
                ReasonCode::UnknownBrake,
                "rear brake or engine: neither pressures nor throttle and gear show which",
            ))
        } else if claim.kind == &FRONT_BRAKING
            && engine.share > 1.0 - self.front_share
            && f.front_share.is_none_or(|share| share < self.front_share)
        {
            Some(Reason::new(
                ReasonCode::EngineBraking,
                format!(
                    "in gear: the engine takes {:.0} % of the force, at the rear tyre",
                    100.0 * engine.share
                ),
            ))
        } else {
            None
        };
        Verdict { quality: (peak / 5.0).min(1.0), reason }
    }
}
