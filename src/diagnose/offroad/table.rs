//! The rows of `causes` and `discrepancies`.

use super::effects::{ALL, Effect};
use super::fit::{Fit, Problem};
use super::name::{Cause, FOLDS, Naming};
use super::null::{Calibration, rms};
use super::residuals::{CHANNELS, Residuals};
use crate::contract::verdict::{UNEXPLAINED, Verdict};
use crate::contract::warning::Warning;
use crate::diagnose::null_calibration::correlation;
use crate::estimate::offroad::Estimate;
use crate::tables::rows::{CauseRow, DiscrepancyRow, Ident};

/// How much more than every null a structured residual is.
const MORE: f64 = 1.25;
/// The same for what the named causes leave: a named cause is not quite exact.
const LEFT: f64 = 1.5;
/// Fewest blocks in which structure is looked for.
const FEW: usize = 20;

/// Whether on the ground more is left than sensors and bike file explain once everything named is in.
pub fn wrong_on_the_ground(
    residuals: &Residuals,
    naming: &Naming,
    calibration: &Calibration,
) -> bool {
    rms(residuals, &naming.extended.residual).iter().any(|((kind, channel), (size, n))| {
        let largest = calibration.floor.get(&(*kind, *channel)).map_or(f64::INFINITY, |f| f[1]);
        !CHANNELS[*channel].off_the_ground() && *n >= FEW && *size > LEFT * largest
    })
}

/// What the rows are made from.
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs)] // the names of their types
pub struct Tables<'a> {
    pub residuals: &'a Residuals,
    pub problem: &'a Problem,
    pub bare: &'a [f64],
    pub everything: &'a Fit,
    pub naming: &'a Naming,
    pub calibration: &'a Calibration,
    pub estimate: &'a Estimate,
    pub warnings: &'a [Warning],
    pub ident: &'a Ident,
}

impl Tables<'_> {
    /// One row per candidate, and one for what none explains.
    pub fn causes(&self, discrepancies: &[DiscrepancyRow]) -> Vec<CauseRow> {
        let named = &self.naming.named;
        let (mut gain, mut bound) = (None, None);
        if !named.is_empty() {
            let out = |included: &[usize], whole: &Fit| {
                self.problem.held_out(self.bare, included, whole, FOLDS)
            };
            let before = out(&[], &self.problem.fit(self.bare, &[], None));
            let every: Vec<usize> = (0..ALL.len()).collect();
            gain = Some(before - out(named, &self.naming.extended));
            bound = Some(before - out(&every, self.everything));
        }
        let mut rows: Vec<CauseRow> = self
            .naming
            .causes
            .iter()
            .map(|c| {
                let effect = &ALL[c.effect];
                let rivals = c.equivalent.join(", ");
                CauseRow {
                    ident: self.ident.clone(),
                    rank: 0,
                    effect: effect.name.to_owned(),
                    verdict: c.verdict.name().to_owned(),
                    pooled_over: None,
                    level: "session".to_owned(),
                    parameter: effect.parameter.to_owned(),
                    value: c.value,
                    unit: effect.unit.to_owned(),
                    ci95_low: c.interval.map(|i| i[0]),
                    ci95_high: c.interval.map(|i| i[1]),
                    score: c.score,
                    false_alarm_rate: self.calibration.false_alarm_rate(c.score),
                    gain_heldout: None,
                    gain_upper_bound: None,
                    equivalent_to: (!rivals.is_empty()).then_some(rivals),
                    separate_by: Some(effect.separate_by.to_owned()),
                    reason: self.reason(c, effect),
                }
            })
            .collect();
        if let Some(row) = self.unexplained(discrepancies) {
            rows.insert(named.len(), row);
        }
        for (k, row) in rows.iter_mut().enumerate() {
            row.rank = k as i64 + 1;
        }
        if let Some(first) = rows.first_mut() {
            (first.gain_heldout, first.gain_upper_bound) = (gain, bound);
        }
        rows
    }

    fn reason(&self, c: &Cause, effect: &Effect) -> String {
        match c.verdict {
            Verdict::Named => {
                let phase = match effect.unit {
                    "Hz" => " (rider C with zero_phase = false)",
                    _ => "",
                };
                format!("{}{phase}: gains {:.0}", effect.sentence, c.gain)
            }
            Verdict::Ambiguous => format!(
                "{}, or one of {}: the ride cannot tell them apart; what would: {}",
                effect.sentence,
                c.equivalent.join(", "),
                effect.separate_by
            ),
            Verdict::NotNeeded if c.score > 1.0 => {
                "beyond the nulls, but explained by what is named, too large to be, or gains too little"
                    .to_owned()
            }
            Verdict::NotNeeded | Verdict::Unexplained => {
                "within what nulls of this ride show".to_owned()
            }
            Verdict::NotIdentifiable => {
                let lost: Vec<&str> = self
                    .warnings
                    .iter()
                    .filter(|w| matches!(w.code, "row_lost" | "negative_travel"))
                    .filter_map(|w| w.channel.map(|c| c.name()))
                    .collect();
                let why = match lost.is_empty() {
                    true => String::new(),
                    false => format!(" without {}", lost.join(", ")),
                };
                format!("the ride says nothing of it{why}; what would: {}", effect.separate_by)
            }
        }
    }

    /// What is left beyond sensors and bike file once everything named is in.
    fn unexplained(&self, discrepancies: &[DiscrepancyRow]) -> Option<CauseRow> {
        let left = |r: &DiscrepancyRow| r.rmse_extended.unwrap_or(r.rmse_base) / r.null_largest;
        let worst = discrepancies
            .iter()
            .filter(|r| r.n >= FEW as i64 && left(r) > LEFT)
            .max_by(|a, b| left(a).total_cmp(&left(b)));
        let (score, reason) = match worst {
            Some(row) => {
                let with = row.covariate.as_deref().map_or(String::new(), |c| {
                    format!(", goes with the {c} ({:+.2})", row.correlation.unwrap_or(0.0))
                });
                let kind = row.kind.replace('_', " ");
                let reason = format!(
                    "{} while {kind}: {:.0} {} are left, sensors and bike file explain {:.0}{with}",
                    row.channel,
                    row.rmse_extended.unwrap_or(row.rmse_base),
                    row.unit,
                    row.null_largest
                );
                (left(row), reason)
            }
            None if self.naming.unexplained => {
                let reason = "beyond the nulls, but no candidate of a possible size explains it";
                (self.naming.alarm, reason.to_owned())
            }
            None => return None,
        };
        Some(CauseRow {
            ident: self.ident.clone(),
            effect: UNEXPLAINED.to_owned(),
            verdict: Verdict::Unexplained.name().to_owned(),
            level: "session".to_owned(),
            unit: "1".to_owned(),
            score,
            reason,
            ..CauseRow::default()
        })
    }

    /// One row per channel and kind of manoeuvre.
    pub fn discrepancies(&self) -> Vec<DiscrepancyRow> {
        let before = rms(self.residuals, self.bare);
        let after = rms(self.residuals, &self.naming.extended.residual);
        before
            .iter()
            .map(|(&(kind, channel), &(size, n))| {
                let own: Vec<usize> = (0..self.bare.len())
                    .filter(|&i| {
                        let b = &self.residuals.blocks[i];
                        b.kind == kind && b.channel == channel
                    })
                    .collect();
                let [floor, largest] =
                    self.calibration.floor.get(&(kind, channel)).copied().unwrap_or([0.0; 2]);
                let extended = (!self.naming.named.is_empty())
                    .then(|| after.get(&(kind, channel)).map(|(size, _)| *size))
                    .flatten();
                let structured = n >= FEW && size > MORE * largest;
                let covariate = structured
                    .then(|| self.covariate(&own, &self.naming.extended.residual))
                    .flatten();
                DiscrepancyRow {
                    ident: self.ident.clone(),
                    channel: CHANNELS[channel].name.to_owned(),
                    kind: kind.name().to_owned(),
                    unit: CHANNELS[channel].unit.to_owned(),
                    rmse_base: size,
                    rmse_extended: extended,
                    bias: own.iter().map(|&i| self.bare[i]).sum::<f64>() / own.len() as f64,
                    noise_floor: floor,
                    null_largest: largest,
                    structured,
                    covariate: covariate.map(|(name, _)| name.to_owned()),
                    correlation: covariate.map(|(_, r)| r),
                    n: n as i64,
                }
            })
            .collect()
    }

    /// What is left of a residual goes with this most.
    fn covariate(&self, own: &[usize], r: &[f64]) -> Option<(&'static str, f64)> {
        let k = &self.estimate.kinematics;
        let at = |x: &[f64], i: usize| {
            let (middle, half) = (self.residuals.blocks[i].at, 10 * self.residuals.step);
            let near = &x[middle.saturating_sub(half)..(middle + half).min(x.len())];
            near.iter().sum::<f64>() / near.len() as f64
        };
        let with = |x: &[f64]| correlation(own.iter().map(|&i| (at(x, i), r[i])));
        [
            ("speed", &k.xd),
            ("forward acceleration", &k.xdd),
            ("vertical acceleration", &k.zdd),
            ("pitch", &k.mu),
            ("pitch rate", &k.mud),
            ("fork travel", &k.z_f),
            ("fork rate", &k.zd_f),
            ("swing-arm angle", &k.a_r),
            ("swing-arm rate", &k.ad_r),
        ]
        .into_iter()
        .filter(|(_, x)| !x.is_empty())
        .map(|(name, x)| (name, with(x)))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }
}
