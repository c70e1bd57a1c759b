//! Two sets of sessions, A and B: how much each coefficient differs, without the errors that both share.
//!
//! ```text
//! d = y_B - y_A        logarithms where all values have one sign and are known within a third: d is a ratio of sizes
//! var d = var y_A + var y_B - 2 cov(y_A, y_B)
//! ```
//!
//! The sessions of a motorcycle are fitted together ([`joint`]), so that what is wrong with its bike file, its sensors or its
//! model moves both sides alike and cancels as far as it does ([`sources`]). What differs from session to session does
//! not: a difference is one between sets of sessions such as these. The interval is Student's t, with the degrees of
//! freedom of the spread between sessions. Other sessions of the motorcycles that take part tell of that spread, too.
//!
//! A motorcycle's rides make one value of each tyre; several tyres or motorcycles of a side are averaged with a spread
//! between them, which cancels as far as both sides rode the same ones ([`contrast`]).

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use statrs::distribution::{ContinuousCDF, StudentsT};

use self::contrast::{Member, Members, Variance};
use self::joint::{JointEstimate, joint};
use self::sources::{Group, Renamed};
use super::combine::{Key, Ride, Scale};
use super::evidence::Piece;
use crate::contract::error_source::RIDES;
use crate::statistics::discovery::discovery_rates;
use crate::statistics::interval::t95;
use crate::statistics::order::median;

mod contrast;
mod joint;
mod more;
mod session;
mod sources;

pub use self::session::Session;

/// A value is compared as a ratio where its error is less than this share of it.
const KNOWN: f64 = 0.3;
/// A difference that sessions are to show where they show none, a share.
const WORTH_KNOWING: f64 = 0.05;

/// Mean and interval of a coefficient over the sessions of one side.
#[derive(Debug, Clone, PartialEq)]
pub struct Side {
    /// Mean of the side's sessions, in the coefficient's unit.
    pub value: f64,
    /// 95 % interval, with all errors.
    pub interval: [f64; 2],
    /// Number of sessions with a value.
    pub sessions: usize,
}

/// B against A.
#[derive(Debug, Clone, PartialEq)]
pub struct Difference {
    /// B less A; where both are below zero, of the sizes.
    pub size: f64,
    /// Its 95 % interval.
    pub interval: [f64; 2],
    /// The same over A, and its interval; none of values of both signs.
    pub relative: Option<[f64; 3]>,
    /// Probability that B is larger.
    pub probability: f64,
    /// Share of the differences at least as sure that chance alone would make (Benjamini and Hochberg).
    pub false_discovery: f64,
    /// Spread between sessions, in the unit of the value.
    pub between: f64,
    /// Whether that is more assumed than seen.
    pub is_assumed: bool,
    /// Share of the two sides' variances that is in both and cancels.
    pub cancelled: f64,
    /// Source of most of the variance, and its share: `rides`, `tyres`, or the name of a shared error. It is not `rides` if no
    /// number of rides would suffice.
    pub limited_by: (String, f64),
    /// Sessions more on each side after which the seen difference would be beyond its interval; none where no number of
    /// them suffices.
    pub more_for_seen: Option<usize>,
    /// The same of a difference of 5 %; none of values of both signs, too.
    pub more_for_worth: Option<usize>,
}

impl Difference {
    /// Whether the interval excludes zero, and on which side.
    pub fn verdict(&self) -> Verdict {
        match self.interval {
            [low, _] if low > 0.0 => Verdict::Larger,
            [_, high] if high < 0.0 => Verdict::Smaller,
            _ => Verdict::NoDifference,
        }
    }
}

/// Verdict of a comparison on a coefficient.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// B is larger.
    Larger,
    /// B is smaller.
    Smaller,
    /// The interval of the difference has zero in it.
    NoDifference,
    /// One side has no value.
    NotComparable,
}

impl Verdict {
    /// As the column `verdict` has it.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Larger => "larger",
            Verdict::Smaller => "smaller",
            Verdict::NoDifference => "no difference seen",
            Verdict::NotComparable => "not comparable",
        }
    }
}

/// One coefficient of both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Compared {
    /// `front`, `rear` or `vehicle`.
    pub tyre: String,
    pub coefficient: String,
    /// Unit of the coefficient.
    pub unit: String,
    /// A and B, where sessions of theirs determine it.
    pub sides: [Option<Side>; 2],
    /// B against A, where both do.
    pub difference: Option<Difference>,
}

/// A motorcycle's groups, and whose each is.
struct OfBike {
    joint: JointEstimate,
    groups: Vec<Group>,
    of_tyre: Vec<(Key, Piece)>,
}

type Name = (String, String);

/// Compares B with A: coefficients in order of tyre and name.
pub fn compare(sessions: &[Session]) -> Vec<Compared> {
    let mut values: BTreeMap<Name, (Vec<f64>, String)> = BTreeMap::new();
    let of_sides = sessions.iter().filter(|s| s.side < 2);
    let compared: BTreeSet<(&str, &str)> = of_sides
        .flat_map(|s| s.pieces.iter().map(|p| (p.tyre.as_str(), p.coefficient.as_str())))
        .collect();
    let is_compared = |p: &&Piece| compared.contains(&(p.tyre.as_str(), p.coefficient.as_str()));
    for piece in sessions.iter().flat_map(|s| &s.pieces).filter(is_compared) {
        let of = values.entry((piece.tyre.clone(), piece.coefficient.clone())).or_default();
        of.0.push(piece.value);
        of.1.clone_from(&piece.unit);
    }
    let mut shares = shares(sessions);
    let scales: BTreeMap<Name, Scale> = values
        .iter()
        .map(|(name, (values, _))| {
            let share = shares.get_mut(name).and_then(|all| median(all)).unwrap_or(0.0);
            (name.clone(), if share < KNOWN { Scale::of(values) } else { Scale::Linear })
        })
        .collect();
    let bikes: BTreeSet<&str> = sessions.iter().map(|s| s.bike.as_str()).collect();
    let bikes: Vec<&str> = bikes.into_iter().collect();
    let fitted: Vec<Option<OfBike>> = bikes
        .par_iter()
        .map(|bike| {
            let of_bike: Vec<&Session> = sessions.iter().filter(|s| s.bike == **bike).collect();
            fit(&of_bike, &scales)
        })
        .collect();
    let mut found: Vec<Compared> =
        values.into_iter().map(|(name, (_, unit))| one(name, unit, &fitted, &scales)).collect();
    let chance = |d: &Difference| 2.0 * d.probability.min(1.0 - d.probability);
    let chances: Vec<f64> =
        found.iter().filter_map(|c| c.difference.as_ref().map(chance)).collect();
    let rates = discovery_rates(&chances, chances.len());
    let differences = found.iter_mut().filter_map(|c| c.difference.as_mut());
    differences.zip(rates).for_each(|(d, rate)| d.false_discovery = rate.min(1.0));
    found
}

/// Errors over values, session by session.
fn shares(sessions: &[Session]) -> BTreeMap<Name, Vec<f64>> {
    let mut out: BTreeMap<Name, Vec<f64>> = BTreeMap::new();
    for session in sessions.iter().filter(|s| s.side < 2) {
        let mut squares: BTreeMap<Name, f64> = BTreeMap::new();
        for piece in &session.pieces {
            let share = piece.shift / piece.value;
            *squares.entry((piece.tyre.clone(), piece.coefficient.clone())).or_default() +=
                share * share;
        }
        for (name, sum) in squares {
            out.entry(name).or_default().push(sum.sqrt());
        }
    }
    out
}

fn fit(sessions: &[&Session], scales: &BTreeMap<Name, Scale>) -> Option<OfBike> {
    let renamed = Renamed::of(sessions);
    let rides: Vec<Ride<'_>> = sessions
        .iter()
        .zip(&renamed.pieces)
        .map(|(session, pieces)| Ride {
            session: &session.session,
            pieces: pieces.iter().map(|(key, piece)| (key.clone(), piece)).collect(),
        })
        .collect();
    let scale = |key: &Key| {
        let name = (key.tyre.clone(), key.coefficient.clone());
        scales.get(&name).copied().unwrap_or(Scale::Linear)
    };
    let joint = joint(&rides, scale)?;
    Some(OfBike { joint, groups: renamed.groups, of_tyre: renamed.of_tyre })
}

impl OfBike {
    /// The groups of one coefficient.
    fn members(&self, bike: usize, (tyre, coefficient): &Name) -> Vec<Member<'_>> {
        let is_own = |key: &Key| key.tyre == *tyre && key.coefficient == *coefficient;
        let keys = self.joint.keys.iter().enumerate().filter(|(_, key)| is_own(key));
        keys.filter_map(|(k, key)| {
            let group = self.groups.get(key.specimen).filter(|group| group.side < 2)?;
            let scale = self.joint.scales[k];
            let mut of_tyre: Vec<f64> = self
                .of_tyre
                .iter()
                .filter(|(of, _)| of == key)
                .map(|(_, piece)| scale.shift(piece.value, piece.shift).abs())
                .collect();
            Some(Member {
                joint: &self.joint,
                key: k,
                bike,
                side: group.side,
                tyre: &group.tyre,
                of_tyre: median(&mut of_tyre).unwrap_or(0.0),
            })
        })
        .collect()
    }
}

fn one(
    name: Name,
    unit: String,
    fitted: &[Option<OfBike>],
    scales: &BTreeMap<Name, Scale>,
) -> Compared {
    let scale = scales.get(&name).copied().unwrap_or(Scale::Linear);
    let bikes = fitted.iter().enumerate().filter_map(|(i, of)| Some((i, of.as_ref()?)));
    let all = bikes.flat_map(|(i, of)| of.members(i, &name)).collect();
    let members = Members::new(all, scale != Scale::Linear);
    let side = |side: usize| -> Option<Side> {
        let sessions = members.sessions(side);
        let mut weights = [0.0; 2];
        weights[side] = 1.0;
        let variance = members.variance(weights);
        (sessions > 0 && variance.total > 0.0).then(|| {
            let (y, half) = (members.value(side), t95(variance.dof) * variance.total.sqrt());
            let [a, b] = [y - half, y + half].map(|y| scale.value(y));
            Side { value: scale.value(y), interval: [a.min(b), a.max(b)], sessions }
        })
    };
    let sides = [side(0), side(1)];
    let difference = match &sides {
        [Some(a), Some(b)] => difference(&members, scale, a, b),
        _ => None,
    };
    let (tyre, coefficient) = name;
    Compared { tyre, coefficient, unit, sides, difference }
}

fn difference(members: &Members<'_>, scale: Scale, a: &Side, b: &Side) -> Option<Difference> {
    let variance = members.variance([-1.0, 1.0]);
    let apart = members.variance([1.0, 0.0]).total + members.variance([0.0, 1.0]).total;
    let is_log = scale != Scale::Linear;
    // of values below zero the sizes are compared, on either scale
    let sign = if !is_log && a.value < 0.0 && b.value < 0.0 { -1.0 } else { 1.0 };
    let y = sign * (members.value(1) - members.value(0));
    let sd = variance.total.max(0.0).sqrt();
    if !(y.is_finite() && sd.is_finite() && sd > 0.0) {
        return None;
    }
    let half = t95(variance.dof) * sd;
    let middle = (a.value * b.value).abs().sqrt();
    // of the same sign as the ratio
    let size = |y: f64| if is_log { 2.0 * middle * (0.5 * y).sinh() } else { y };
    let sessions = [a.sessions, b.sessions];
    let more_for_seen = more::sessions(&variance, sessions, y.abs());
    let worth = (1.0 + WORTH_KNOWING).ln();
    let more_for_worth = is_log.then(|| more::sessions(&variance, sessions, worth)).flatten();
    let cancelled = (1.0 - variance.total / apart).max(0.0);
    Some(Difference {
        size: size(y),
        interval: [size(y - half), size(y + half)],
        relative: is_log.then(|| [y, y - half, y + half].map(f64::exp_m1)),
        probability: StudentsT::new(0.0, 1.0, variance.dof.min(1e6)).map_or(0.5, |t| t.cdf(y / sd)),
        false_discovery: 1.0,
        between: members.tau() * if is_log { middle } else { 1.0 },
        is_assumed: members.is_assumed(),
        // without the noise of sums
        cancelled: (cancelled * 1e9).round() / 1e9,
        limited_by: limit(&variance, more_for_seen.or(more_for_worth).is_some()),
        more_for_seen,
        more_for_worth,
    })
}

/// Source of most of a variance, and its share; the rides only if more of them would suffice.
fn limit(variance: &Variance, rides_do: bool) -> (String, f64) {
    let own: f64 = variance.own.iter().sum();
    let most = variance.shared.iter().max_by(|a, b| a.1.total_cmp(b.1));
    match most {
        Some((name, part)) if *part > own || (!rides_do && *part > 0.0) => {
            (name.clone(), part / variance.total)
        }
        _ => (RIDES.to_owned(), own / variance.total),
    }
}
