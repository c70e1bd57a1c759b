//! The off-road side of the diagnosis engine: residuals that no tyre force explains, fault-free simulations on
//! the measured motion, a fit of every candidate at every stage.

use std::cell::OnceCell;

use super::calibration::{GainScale, OffroadCalibration, cells};
use super::candidates::ALL;
use super::curve::Curve;
use super::fit::{Fit, Problem};
use super::residuals::{CHANNELS, Residuals};
use crate::contract::verdict::Verdict;
use crate::contract::warning::Warning;
use crate::diagnose::calibration::{Calibration, Rms};
use crate::diagnose::cause::{
    Candidate, Cause, Estimate, Identification, Judged, Refusal, Refusals,
};
use crate::diagnose::engine::{
    CellResiduals, Confirmed, Engine, IdentificationRules, JointFits, Refit, Unexplained, in_cells,
};
use crate::diagnose::tables::rms_of;
use crate::diagnose::tuning::OffroadTuning;
use crate::estimate::offroad::Estimate as Forces;
use crate::store::tables::rows::DiscrepancyRow;

/// How many times the largest of its fault-free simulations the residual is that identified causes leave where
/// something is unexplained: an identified cause is not quite exact.
const LEFT: f64 = 1.5;
/// Fewest blocks in which structure is looked for.
const MIN_BLOCKS: usize = 20;

/// Codes of the warnings about rows of the equations that are missing.
const LOST: [&str; 2] = ["row_lost", "negative_travel"];

/// Warnings about rows of the equations that are missing.
pub(crate) fn lost_rows(warnings: &[Warning]) -> impl Iterator<Item = &Warning> {
    warnings.iter().filter(|w| LOST.contains(&w.code))
}

/// An off-road ride with its residuals and fault-free simulations.
#[derive(Debug)]
pub(crate) struct OffroadEngine<'a> {
    pub residuals: &'a Residuals,
    /// Candidates and the bike's uncertainty.
    pub problem: &'a Problem,
    /// Residuals under the base, rider B on the bike of the file.
    pub bare: &'a [f64],
    /// The fit with every candidate free.
    pub everything: &'a Fit,
    /// Calibration by fault-free simulations.
    pub calibration: &'a OffroadCalibration,
    /// The tyre forces that the residuals belong to.
    pub forces: &'a Forces,
    /// Warnings of their estimate.
    pub warnings: &'a [Warning],
    pub tuning: OffroadTuning,
}

/// A model, and a fit of every other candidate with it.
#[derive(Debug)]
pub(crate) struct Stage {
    model: Fit,
    /// Places of the candidates that are in it.
    named: Vec<usize>,
    tried: Vec<Tried>,
    /// Twice the loss of the model on manoeuvres left out.
    held_out: OnceCell<f64>,
}

/// A candidate fitted together with the model.
#[derive(Debug)]
struct Tried {
    place: usize,
    gain: f64,
    fit: Fit,
}

fn candidate(place: usize) -> Candidate {
    Candidate { place, ..ALL[place].candidate }
}

fn with(named: &[usize], place: usize) -> Vec<usize> {
    let mut out = named.to_vec();
    out.push(place);
    out
}

impl OffroadEngine<'_> {
    fn stage(&self, model: Fit, named: Vec<usize>) -> Stage {
        let open = (0..ALL.len()).filter(|j| !named.contains(j));
        let tried = open
            .map(|place| {
                let fit = self.problem.fit(self.bare, &with(&named, place), Some(&model));
                Tried { place, gain: 2.0 * (model.loss - fit.loss), fit }
            })
            .collect();
        Stage { model, named, tried, held_out: OnceCell::new() }
    }

    /// Number of a candidate among others of a fit.
    fn estimate(&self, fit: &Fit, included: &[usize], place: usize) -> Option<Estimate> {
        let value = fit.values[place]? - self.calibration.bias[place];
        let at = included.iter().position(|k| *k == place)?;
        let std_error = self.problem.std_errors(fit, included)[at];
        let logarithmic = self.problem.curves[place].logarithmic();
        Some(Estimate { value, std_error, logarithmic })
    }

    /// Why a candidate could not be a cause whatever the bounds of its number; `None` of one that could.
    fn irrelevant(&self, tried: &Tried, score: f64, named: &[Cause]) -> Option<Refusal> {
        let Tried { place, gain, fit } = tried;
        let tuning = &self.tuning;
        let least = named.first().map_or(tuning.gain, |first| {
            tuning.further_gain.max(tuning.further_share * first.gain)
        });
        let size = fit.values[*place].unwrap_or(f64::NAN);
        let small = match self.problem.curves[*place] {
            // less than the file is usually known to
            Curve::Line(_) if size.abs() > tuning.small * ALL[*place].candidate.typical => None,
            Curve::Line(_) => Some(Refusal::Small(size)),
            // at an end of the frequencies there is only noise to smooth
            Curve::Nodes { .. } if is_inside(*place, size) => None,
            Curve::Nodes { .. } => Some(Refusal::Implausible(size)),
        };
        // of one family only one is identified: together they would only share out what is seen
        let family = ALL[*place].family;
        let related =
            family.is_some() && named.iter().any(|c| ALL[c.candidate.place].family == family);
        let loud = score > tuning.alarm;
        let enough = *gain > least;
        (!loud)
            .then_some(Refusal::NoAlarm(tuning.alarm))
            .or((!enough).then_some(Refusal::LittleGain { gain: *gain, needed: least }))
            .or(small)
            .or(related.then_some(Refusal::Related))
    }

    /// Whether a candidate of usual size would be beyond the fault-free simulations, and its number known to
    /// half of itself.
    fn is_identifiable(&self, model: &Fit, place: usize) -> bool {
        let problem = self.problem;
        let usual = ALL[place].candidate.typical;
        let mut r = vec![0.0; problem.weight.len()];
        problem.curves[place].add(usual, &mut r);
        // what a bike off its file would not explain of it
        let without = problem.fit(&r, &[], None);
        let mut there = model.clone();
        there.values[place] = Some(usual);
        let sigma = problem.std_errors(&there, &[place])[0];
        let most = match problem.curves[place] {
            Curve::Line(_) => 0.5 * usual,
            Curve::Nodes { .. } => self.tuning.vague,
        };
        let gain = 2.0 * without.loss;
        let score = self.calibration.score(place, gain);
        score > 1.0 && gain > self.tuning.gain && sigma < most
    }

    /// Whether, on the ground, a misfit remains with all identified causes beyond what sensors and bike file explain.
    pub(crate) fn is_wrong_on_the_ground(&self, identification: &Identification<Fit>) -> bool {
        let left = rms_of(&self.by_cell(&identification.extended.residual));
        left.iter().any(|(cell, (size, n))| {
            let largest = self.calibration.noise_rms.get(cell).map_or(f64::INFINITY, |f| f[1]);
            !CHANNELS[cell.1].off_the_ground() && *n >= MIN_BLOCKS && *size > LEFT * largest
        })
    }

    fn by_cell(&self, r: &[f64]) -> CellResiduals {
        in_cells(cells(self.residuals, r))
    }
}

/// Whether a number is within its bounds.
fn is_inside(place: usize, value: f64) -> bool {
    let [low, high] = ALL[place].candidate.bounds;
    // 2 % inside a range of frequencies, from which a search may stop short
    value > low * if low > 0.0 { 1.02 } else { 1.0 } && value < 0.98 * high
}

impl Engine for OffroadEngine<'_> {
    type Model = Fit;
    type Stage = Stage;
    type Scale = GainScale;

    fn rules(&self) -> IdentificationRules {
        IdentificationRules {
            alarm: self.tuning.alarm,
            equivalent: self.tuning.equivalent,
            independent: Some(self.tuning.independent),
        }
    }

    fn nominal_stage(&self) -> Stage {
        self.stage(self.problem.fit(self.bare, &[], None), Vec::new())
    }

    fn judge(&self, stage: &Stage) -> Vec<Judged> {
        let judged = |t: &Tried| Judged {
            candidate: candidate(t.place),
            estimate: self.estimate(&t.fit, &with(&stage.named, t.place), t.place),
            bias: self.calibration.bias[t.place],
            score: self.calibration.score(t.place, t.gain),
            gain: t.gain,
            makes_plausible: false,
        };
        stage.tried.iter().map(judged).collect()
    }

    fn refits(&self, stage: &Stage, judged: &[Judged], named: &[Cause]) -> JointFits<Fit> {
        let (mut refits, mut refused) = (Vec::new(), Refusals::new());
        for (t, judged) in stage.tried.iter().zip(judged) {
            let size = t.fit.values[t.place].unwrap_or(f64::NAN);
            let beyond = || (!is_inside(t.place, size)).then_some(Refusal::Implausible(size));
            match self.irrelevant(t, judged.score, named).or_else(beyond) {
                Some(why) => drop(refused.insert(judged.candidate.name, why)),
                None => refits.push(Refit {
                    judged: judged.clone(),
                    estimate: judged.estimate,
                    gain: t.gain,
                    model: t.fit.clone(),
                }),
            }
        }
        refits.sort_by(|a, b| b.gain.total_cmp(&a.gain));
        JointFits { refits, refused }
    }

    /// A cause has a known number, and is one on jumps and whoops that it was not fitted to as well.
    fn refuses(&self, stage: &Stage, refit: &Refit<Fit>, _: &[Cause]) -> Option<Refusal> {
        let (problem, place) = (self.problem, refit.judged.candidate.place);
        let joined = with(&stage.named, place);
        let sigma = problem.std_errors(&refit.model, &joined)[stage.named.len()];
        let is_known = match problem.curves[place] {
            Curve::Line(_) => refit.model.values[place].is_some_and(|v| v.abs() > 1.96 * sigma),
            Curve::Nodes { .. } => sigma < self.tuning.vague,
        };
        let held_out = |included: &[usize], fit| problem.held_out(self.bare, included, fit);
        let before = || *stage.held_out.get_or_init(|| held_out(&stage.named, &stage.model));
        let least = self.tuning.held_out * refit.gain;
        if !is_known {
            return Some(Refusal::Vague);
        }
        let carries = before() - held_out(&joined, &refit.model) > least;
        (!carries).then_some(Refusal::NotHeldOut)
    }

    fn add_cause(&self, stage: Stage, refit: Refit<Fit>, _: &[Cause]) -> Stage {
        self.stage(refit.model, with(&stage.named, refit.judged.candidate.place))
    }

    fn confirm(&self, stage: Stage, judged: Vec<Judged>, mut named: Vec<Cause>) -> Confirmed<Fit> {
        let too_much = |(t, j): (&Tried, &Judged)| self.irrelevant(t, j.score, &[]).is_none();
        let unexplained = named.is_empty() && stage.tried.iter().zip(&judged).any(too_much);
        for cause in &mut named {
            // a rival that was identified itself is no equivalent
            cause.retain_equivalents(|rival| {
                stage.named.iter().all(|&k| ALL[k].candidate.name != rival)
            });
            cause.estimate = self.estimate(&stage.model, &stage.named, cause.candidate.place);
        }
        let rest = judged.iter().map(|j| {
            j.cause(match self.is_identifiable(&stage.model, j.candidate.place) {
                true => Verdict::NotNeeded,
                false => Verdict::NotIdentifiable,
            })
        });
        let rest = rest.collect();
        Confirmed {
            named,
            rejected: Vec::new(),
            rest,
            extended: stage.model,
            structure: None,
            unexplained,
        }
    }

    fn channels(&self) -> Vec<(&'static str, &'static str)> {
        CHANNELS.iter().map(|c| (c.name, c.unit)).collect()
    }

    fn base_residuals(&self) -> CellResiduals {
        self.by_cell(self.bare)
    }

    fn extended_residuals(&self, identification: &Identification<Fit>) -> CellResiduals {
        self.by_cell(&identification.extended.residual)
    }

    fn noise_factors(&self, _: &Rms) -> Vec<f64> {
        vec![1.0; CHANNELS.len()]
    }

    fn fewest_blocks(&self) -> usize {
        MIN_BLOCKS
    }

    fn covariates(&self) -> (Vec<(&'static str, Vec<f64>)>, bool) {
        let k = &self.forces.kinematics;
        let half = 10 * self.residuals.step;
        let mean = |x: &[f64]| -> Vec<f64> {
            let at = |middle: usize| {
                let near = &x[middle.saturating_sub(half)..(middle + half).min(x.len())];
                near.iter().sum::<f64>() / near.len() as f64
            };
            self.residuals.blocks.iter().map(|b| at(b.at)).collect()
        };
        let all = [
            ("speed", &k.xd),
            ("forward acceleration", &k.xdd),
            ("vertical acceleration", &k.zdd),
            ("pitch", &k.mu),
            ("pitch rate", &k.mud),
            ("fork travel", &k.z_f),
            ("fork rate", &k.zd_f),
            ("swing-arm angle", &k.a_r),
            ("swing-arm rate", &k.ad_r),
        ];
        let known = all.into_iter().filter(|(_, x)| !x.is_empty());
        (known.map(|(name, x)| (name, mean(x))).collect(), true)
    }

    fn calibration(&self) -> &Calibration<GainScale> {
        self.calibration
    }

    fn held_out_gains(&self, identification: &Identification<Fit>) -> [f64; 2] {
        let out =
            |included: &[usize], whole: &Fit| self.problem.held_out(self.bare, included, whole);
        let named: Vec<usize> = identification.named().map(|c| c.candidate.place).collect();
        let before = out(&[], &self.problem.fit(self.bare, &[], None));
        let every: Vec<usize> = (0..ALL.len()).collect();
        [before - out(&named, &identification.extended), before - out(&every, self.everything)]
    }

    /// The misfit that sensors, bike file and causes do not explain.
    fn unexplained(
        &self,
        identification: &Identification<Fit>,
        discrepancies: &[DiscrepancyRow],
    ) -> Option<Unexplained> {
        let left = |r: &DiscrepancyRow| r.rmse_extended.unwrap_or(r.rmse_base) / r.null_largest;
        let worst = discrepancies
            .iter()
            .filter(|r| r.n >= MIN_BLOCKS as i64 && left(r) > LEFT)
            .max_by(|a, b| left(a).total_cmp(&left(b)));
        let (score, reason) = match worst {
            Some(row) => {
                let with = row.covariate.as_deref().map_or(String::new(), |c| {
                    format!(", goes with the {c} ({:+.2})", row.correlation.unwrap_or(0.0))
                });
                let reason = format!(
                    "{} while {}: a misfit of {:.0} {} remains, sensors and bike file explain {:.0}{with}",
                    row.channel,
                    row.kind.replace('_', " "),
                    row.rmse_extended.unwrap_or(row.rmse_base),
                    row.unit,
                    row.null_largest
                );
                (left(row), reason)
            }
            None if identification.unexplained => {
                let reason = "beyond what fault-free simulations show, but no candidate of a plausible size explains it";
                (identification.alarm, reason.to_owned())
            }
            None => return None,
        };
        Some(Unexplained { score, parameter: "", reason, first: false })
    }

    fn remark(&self, cause: &Cause) -> String {
        match cause.verdict {
            Verdict::Named if cause.candidate.unit == "Hz" => {
                " (rider C with zero_phase = false)".to_owned()
            }
            Verdict::NotIdentifiable => {
                let lost: Vec<&str> =
                    lost_rows(self.warnings).filter_map(|w| w.channel.map(|c| c.name())).collect();
                match lost.is_empty() {
                    true => String::new(),
                    false => format!(" without {}", lost.join(", ")),
                }
            }
            _ => String::new(),
        }
    }
}
