//! A weighted sum of the values of groups of sessions, with its variance and what that is made of.

use std::collections::BTreeMap;

use super::joint::{ASSUMED, JointEstimate};
use super::sources::plain;
use crate::contract::error_source::{MODEL, TYRES};
use crate::statistics::interval::combined_dof;

/// Spread between tyres of one side where there are too few to tell, a share; as in [`super::super::tyres`].
const BETWEEN_TYRES: f64 = 0.02;
/// Fewest that tell it.
const TYRES_THAT_TELL: usize = 4;

/// The value of one coefficient in one group of sessions.
#[derive(Debug)]
pub(super) struct Member<'a> {
    /// Where it was fitted.
    pub joint: &'a JointEstimate,
    pub key: usize,
    /// Its motorcycle, by number.
    pub bike: usize,
    /// 0 is A, 1 is B.
    pub side: usize,
    /// Key of the tyre that it was ridden on.
    pub tyre: &'a str,
    /// The tyre's part of the model's error, on the scale of the value.
    pub of_tyre: f64,
}

impl Member<'_> {
    fn value(&self) -> f64 {
        self.joint.values[self.key]
    }

    fn variance(&self) -> f64 {
        self.joint.covariance[(self.key, self.key)] + self.of_tyre * self.of_tyre
    }
}

/// All groups of one coefficient.
#[derive(Debug)]
pub(super) struct Members<'a> {
    all: Vec<Member<'a>>,
    /// By side: weight of each group, and the variance between groups.
    weights: [Vec<f64>; 2],
    between: [f64; 2],
}

/// A variance and what it is made of.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Variance {
    pub total: f64,
    /// By side: what averages out over more sessions.
    pub own: [f64; 2],
    /// Degrees of freedom.
    pub dof: f64,
    /// Errors that more sessions do not narrow, by name: the parts that are left of shared errors, and the spread between tyres.
    pub shared: BTreeMap<String, f64>,
}

impl<'a> Members<'a> {
    /// Of the groups of one coefficient.
    pub(super) fn new(all: Vec<Member<'a>>, is_log: bool) -> Self {
        let mut out = Members { all, weights: [Vec::new(), Vec::new()], between: [0.0; 2] };
        for side in 0..2 {
            let own: Vec<(f64, f64)> =
                out.of(side).map(|m| (m.value(), m.variance().max(1e-30))).collect();
            let between = between(&own, is_log);
            let weights: Vec<f64> =
                out.all
                    .iter()
                    .map(|m| {
                        if m.side == side { 1.0 / (m.variance().max(1e-30) + between) } else { 0.0 }
                    })
                    .collect();
            let sum: f64 = weights.iter().sum();
            out.weights[side] =
                weights.iter().map(|w| if sum > 0.0 { w / sum } else { 0.0 }).collect();
            out.between[side] = between;
        }
        out
    }

    fn of(&self, side: usize) -> impl Iterator<Item = &Member<'a>> {
        self.all.iter().filter(move |m| m.side == side)
    }

    /// Sessions of a side.
    pub(super) fn sessions(&self, side: usize) -> usize {
        self.of(side).map(|m| m.joint.rides[m.key]).sum()
    }

    /// Spread between the sessions of both, the largest of the groups.
    pub(super) fn tau(&self) -> f64 {
        self.all.iter().map(|m| m.joint.tau[m.key]).fold(0.0, f64::max)
    }

    /// Whether the spread between sessions is assumed more than seen.
    pub(super) fn is_assumed(&self) -> bool {
        self.all.iter().all(|m| m.joint.dof[m.key] < 2.0 * ASSUMED)
    }

    /// A side's value on the scale.
    pub(super) fn value(&self, side: usize) -> f64 {
        self.all.iter().zip(&self.weights[side]).map(|(m, w)| w * m.value()).sum()
    }

    /// Variance of `b` times the value of B plus `a` times that of A.
    pub(super) fn variance(&self, [a, b]: [f64; 2]) -> Variance {
        let weight = |g: usize| a * self.weights[0][g] + b * self.weights[1][g];
        let c: Vec<f64> = (0..self.all.len()).map(weight).collect();
        let mut total = 0.0;
        let mut shared: BTreeMap<String, f64> = BTreeMap::new();
        let mut tyres: BTreeMap<&str, f64> = BTreeMap::new();
        let mut loadings: BTreeMap<(usize, usize), (f64, &str)> = BTreeMap::new();
        let mut own = [0.0; 2];
        let mut parts = Vec::new();
        for (g, of) in self.all.iter().enumerate() {
            for (h, other) in self.all.iter().enumerate().filter(|(_, m)| m.bike == of.bike) {
                total += c[g] * c[h] * of.joint.covariance[(of.key, other.key)];
            }
            *tyres.entry(of.tyre).or_default() += c[g] * of.of_tyre;
            for (j, name) in of.joint.sources.iter().enumerate() {
                loadings.entry((of.bike, j)).or_insert((0.0, name)).0 +=
                    c[g] * of.joint.loadings[(of.key, j)];
            }
            own[of.side] += c[g] * c[g] * of.joint.own[of.key];
            parts.push((c[g].abs() * of.joint.drawn[of.key].sqrt(), of.joint.dof[of.key]));
        }
        for (loading, name) in loadings.into_values() {
            *shared.entry(plain(name).to_owned()).or_default() += loading * loading;
        }
        let of_tyres: f64 = tyres.values().map(|sum| sum * sum).sum();
        *shared.entry(MODEL.to_owned()).or_default() += of_tyres;
        total += of_tyres;
        for (side, of_side) in self.apart(&c).into_iter().enumerate() {
            total += of_side;
            if of_side > 0.0 {
                *shared.entry(TYRES.to_owned()).or_default() += of_side;
            }
            let groups = self.of(side).count() as f64;
            parts.push((of_side.sqrt(), (groups - 1.0).max(1.0) + ASSUMED));
        }
        let drawn: f64 = parts.iter().map(|(sd, _)| sd * sd).sum();
        parts.push(((total - drawn).max(0.0).sqrt(), f64::INFINITY));
        Variance { total, own, dof: combined_dof(&parts), shared }
    }

    /// Part of the variance by the spread between tyres, for each side. A tyre is the same on both sides: if both rode it,
    /// only the difference of its weights counts.
    fn apart(&self, c: &[f64]) -> [f64; 2] {
        let mut weights: BTreeMap<(usize, &str), (f64, usize)> = BTreeMap::new();
        for (of, weight) in self.all.iter().zip(c).filter(|(_, weight)| **weight != 0.0) {
            let (sum, side) = weights.entry((of.bike, of.tyre)).or_insert((0.0, of.side));
            *sum += weight;
            if self.between[of.side] > self.between[*side] {
                *side = of.side;
            }
        }
        let mut out = [0.0; 2];
        for (sum, side) in weights.into_values() {
            out[side] += sum * sum * self.between[side];
        }
        out
    }
}

/// Variance between the groups of a side beyond their own: none of one group, assumed of few, else by DerSimonian and
/// Laird (1986).
fn between(own: &[(f64, f64)], is_log: bool) -> f64 {
    let n = own.len();
    if n < 2 {
        return 0.0;
    }
    if n < TYRES_THAT_TELL {
        let size = if is_log { 1.0 } else { own.iter().map(|(y, _)| y.abs()).fold(0.0, f64::max) };
        return (BETWEEN_TYRES * size).powi(2);
    }
    let weights: Vec<f64> = own.iter().map(|(_, v)| 1.0 / v).collect();
    let [w, w2] = [1, 2].map(|p| weights.iter().map(|w| w.powi(p)).sum::<f64>());
    let mean = own.iter().zip(&weights).map(|((y, _), w)| y * w).sum::<f64>() / w;
    let q: f64 = own.iter().zip(&weights).map(|((y, _), w)| w * (y - mean).powi(2)).sum();
    ((q - (n as f64 - 1.0)) / (w - w2 / w)).max(0.0)
}
