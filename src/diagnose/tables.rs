//! The rows of `causes` and `discrepancies`.

use super::calibration::{Cell, Rms, correlation, rms};
use super::cause::{Candidate, Cause, Identification, Objection, Refusal};
use super::engine::{CellResiduals, Engine, Unexplained};
use crate::contract::verdict::{UNEXPLAINED, Verdict};
use crate::report::readable;
use crate::store::tables::rows::{CauseRow, DiscrepancyRow, Ident};

/// How many times the largest of its fault-free simulations, and of what its channel has elsewhere, the residual
/// of a structured misfit is.
const STRUCTURED: f64 = 1.25;

/// One row per candidate, and one of what none of them explains.
pub(crate) fn causes<E: Engine>(
    engine: &E,
    identification: &Identification<E::Model>,
    discrepancies: &[DiscrepancyRow],
    ident: &Ident,
) -> Vec<CauseRow> {
    let mut rows: Vec<CauseRow> =
        identification.causes.iter().map(|cause| cause_row(engine, cause, ident)).collect();
    if let Some(first) = rows.first_mut()
        && identification.any_identified()
    {
        let [gain, bound] = engine.held_out_gains(identification);
        (first.gain_heldout, first.gain_upper_bound) = (Some(gain), Some(bound));
    }
    if let Some(own) = engine.unexplained(identification, discrepancies) {
        let place = if own.first { 0 } else { identification.named().count() };
        rows.insert(place, unexplained_row(own, ident));
    }
    for (rank, row) in (1..).zip(&mut rows) {
        row.rank = rank;
    }
    rows
}

fn cause_row<E: Engine>(engine: &E, cause: &Cause, ident: &Ident) -> CauseRow {
    let Cause { candidate, verdict, estimate, score, .. } = cause;
    let interval = estimate.and_then(|e| e.interval());
    // confusions in general are no finding of this ride
    let rivals = (*verdict == Verdict::Ambiguous).then(|| cause.equivalent.join(", "));
    CauseRow {
        ident: ident.clone(),
        effect: candidate.name.to_owned(),
        verdict: verdict.name().to_owned(),
        level: "session".to_owned(),
        parameter: candidate.parameter.to_owned(),
        value: estimate.map(|e| e.value),
        unit: candidate.unit.to_owned(),
        ci95_low: interval.map(|i| i[0]),
        ci95_high: interval.map(|i| i[1]),
        score: *score,
        false_alarm_rate: engine.calibration().false_alarm_rate(*score),
        equivalent_to: rivals,
        separate_by: Some(candidate.separate_by.to_owned()),
        reason: reason(cause, &engine.remark(cause)),
        ..CauseRow::default()
    }
}

fn unexplained_row(own: Unexplained, ident: &Ident) -> CauseRow {
    CauseRow {
        ident: ident.clone(),
        effect: UNEXPLAINED.to_owned(),
        verdict: Verdict::Unexplained.name().to_owned(),
        level: "session".to_owned(),
        parameter: own.parameter.to_owned(),
        unit: "1".to_owned(),
        score: own.score,
        reason: own.reason,
        ..CauseRow::default()
    }
}

/// Why a candidate has its verdict.
fn reason(cause: &Cause, remark: &str) -> String {
    let sentence = cause.candidate.sentence_of(cause.value());
    let separate_by = cause.candidate.separate_by;
    let gain = cause.gain;
    match (cause.verdict, cause.objection) {
        (_, Some(Objection::Contradicted)) => format!(
            "explains part of the misfit (2 x log-likelihood gain {gain:.0}), but leaves more structure in the channels where it \
             shows than a cause may"
        ),
        (_, Some(Objection::NotReproduced)) => format!(
            "explains part of the misfit (2 x log-likelihood gain {gain:.0}), but fault-free simulations with it added do not reproduce its \
             size"
        ),
        (_, Some(Objection::WorseSimulation)) => format!(
            "explains part of the misfit (2 x log-likelihood gain {gain:.0}), but makes the simulation of manoeuvres that were left \
             out worse, as a whole or in more signals than better"
        ),
        (Verdict::Named, None) => {
            format!("{sentence}{remark}: 2 x log-likelihood gain {gain:.0}")
        }
        (Verdict::Ambiguous, None) => format!(
            "{sentence}, or one of {}: this ride cannot tell them apart; what would: {separate_by}",
            cause.equivalent.join(", "),
        ),
        (Verdict::Alternative, None) => format!(
            "{sentence}, instead of the cause above: this ride cannot tell them apart; alone it \
             would have this size (2 x log-likelihood gain {gain:.0})"
        ),
        (Verdict::NotIdentifiable, None) => {
            format!("not identifiable in this ride{remark}; what would show it: {separate_by}")
        }
        (Verdict::NotNeeded | Verdict::Unexplained, None) if cause.score > 1.0 => {
            let known = cause.refusal.map(|why| refusal(why, &cause.candidate));
            let why = known.unwrap_or_else(|| "not confirmed by a joint fit".to_owned());
            format!("beyond what fault-free simulations show, but {why}")
        }
        (Verdict::NotNeeded | Verdict::Unexplained, None) => {
            "within what fault-free simulations of this ride show".to_owned()
        }
    }
}

/// Which rule refused a candidate, as a clause.
fn refusal(why: Refusal, candidate: &Candidate) -> String {
    let Candidate { name, unit, bounds: [low, high], .. } = candidate;
    let size = |x: f64| readable::size(x, name, unit);
    match why {
        Refusal::NoAlarm(needed) => format!(
            "no larger than on fault-free rides of other motorcycles: a cause needs a score of {needed}"
        ),
        Refusal::NotFitted => {
            "it gains far less than the candidates that were fitted with the model".to_owned()
        }
        Refusal::Implausible(found) if found.is_finite() => format!(
            "its size in the joint fit, {}, is implausible: it lies between {} and {}",
            size(found),
            size(*low),
            size(*high)
        ),
        Refusal::LittleGain { gain, needed } => format!(
            "the joint fit gains too little: 2 x log-likelihood gain {gain:.1}, a cause needs {needed:.0}"
        ),
        Refusal::Small(found) if found.is_finite() => {
            format!("its size, {}, is below the usual uncertainty of a bike file", size(found))
        }
        Refusal::Related => "another cause of the same kind is identified".to_owned(),
        Refusal::Implausible(_) | Refusal::Small(_) | Refusal::Vague => {
            "its size is not known well enough".to_owned()
        }
        Refusal::NotHeldOut => "it gains too little on manoeuvres left out of the fit".to_owned(),
        Refusal::Outgained(other) => format!("{other} gains more and was tried in its place"),
    }
}

/// One row per channel and kind of manoeuvre.
pub(crate) fn discrepancies<E: Engine>(
    engine: &E,
    identification: &Identification<E::Model>,
    ident: &Ident,
) -> Vec<DiscrepancyRow> {
    let channels = engine.channels();
    let base = engine.base_residuals();
    let extended = engine.extended_residuals(identification);
    let before = rms_of(&base);
    let after = identification.any_identified().then(|| rms_of(&extended));
    let noisier = engine.noise_factors(&before);
    let (covariates, of_rest) = engine.covariates();
    let followed = if of_rest { &extended } else { &base };
    before
        .iter()
        .map(|(cell, &(size, n))| {
            let (kind, channel) = *cell;
            let own = &base[cell];
            let [noise_rms, largest] =
                engine.calibration().noise_rms.get(cell).copied().unwrap_or([0.0; 2]);
            // nothing is known of what no fault-free simulation could ride
            let structured = largest > 0.0
                && n >= engine.fewest_blocks()
                && size > STRUCTURED * noisier[channel] * largest;
            let covariate = structured.then(|| covariate(&covariates, followed, cell)).flatten();
            DiscrepancyRow {
                ident: ident.clone(),
                channel: channels[channel].0.to_owned(),
                kind: kind.name().to_owned(),
                unit: channels[channel].1.to_owned(),
                rmse_base: size,
                rmse_extended: after.as_ref().and_then(|a| a.get(cell)).map(|(size, _)| *size),
                bias: own.iter().map(|(_, r)| r).sum::<f64>() / own.len() as f64,
                noise_floor: noise_rms,
                null_largest: largest,
                structured,
                covariate: covariate.map(|(name, _)| name.to_owned()),
                correlation: covariate.map(|(_, r)| r),
                n: n as i64,
            }
        })
        .collect()
}

/// Root mean squares of the residuals of every cell.
pub(crate) fn rms_of(cells: &CellResiduals) -> Rms {
    rms(cells.iter().flat_map(|(cell, own)| own.iter().map(|(_, r)| (*cell, *r))))
}

/// The variable that the residuals of a cell follow most, and their correlation with it.
fn covariate(
    covariates: &[(&'static str, Vec<f64>)],
    residuals: &CellResiduals,
    cell: &Cell,
) -> Option<(&'static str, f64)> {
    let own = residuals.get(cell)?;
    covariates
        .iter()
        .map(|(name, x)| (*name, correlation(own.iter().map(|(b, r)| (x[*b], *r)))))
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::cause::Refusals;

    const LATE: Candidate = Candidate {
        place: 0,
        name: "latency",
        parameter: "latency",
        sentence: "the velocity comes late",
        opposite: "the velocity comes early",
        unit: "s",
        separate_by: "riding",
        typical: 0.015,
        bounds: [-0.1, 0.3],
    };

    fn scored(score: f64, at_stage: &[(&'static str, Refusal)]) -> String {
        let cause = Cause {
            candidate: LATE,
            verdict: Verdict::NotNeeded,
            objection: None,
            refusal: None,
            estimate: None,
            bias: 0.0,
            score,
            gain: 0.0,
            equivalent: Vec::new(),
        };
        let at_stage: Refusals = at_stage.iter().copied().collect();
        reason(&cause.refused(&at_stage, 1.75), "")
    }

    /// A score beyond the threshold without a cause left the reader with four alternatives.
    #[test]
    fn the_reason_is_the_rule_that_refused() {
        let within = scored(0.9, &[("latency", Refusal::NotFitted)]);
        assert_eq!(within, "within what fault-free simulations of this ride show");
        assert!(scored(1.3, &[]).ends_with("a cause needs a score of 1.75"));
        let little = Refusal::LittleGain { gain: 8.02, needed: 12.0 };
        let text = scored(2.3, &[("latency", little), ("wind", Refusal::Vague)]);
        assert!(text.ends_with("2 x log-likelihood gain 8.0, a cause needs 12"), "{text}");
        let text = scored(2.3, &[("latency", Refusal::Implausible(0.41))]);
        assert!(text.contains("410 ms") && text.contains("-100 ms and 300 ms"), "{text}");
        for why in [Refusal::Implausible(f64::NAN), Refusal::Small(f64::NAN), Refusal::Vague] {
            assert!(scored(2.3, &[("latency", why)]).ends_with("not known well enough"));
        }
        assert!(scored(2.3, &[]).ends_with("not confirmed by a joint fit"));
    }
}
