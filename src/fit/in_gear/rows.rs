//! What the in-gear fit puts into the table: only where the ordinary fits have nothing, or nothing that
//! is determined.
//!
//! A parameter is determined where its 95 % interval is less than half as wide as what was known before the
//! ride. A peak that was not reached is a lower bound, never a value.

use super::InGear;
use super::parameters::*;
use crate::contract::bike::Axle;
use crate::contract::coefficient::{Coefficient as C, Id, Part};
use crate::contract::reason::{Reason, ReasonCode};
use crate::statistics::interval::t95;
use crate::store::tables::rows::{Coefficient, Ident, Provenance, Status};

/// Share of the prior's interval below which a parameter is determined.
const NARROWED: f64 = 0.5;
/// Share of the fitted peak that must have been used before the peak is a value.
const REACHED: f64 = 0.85;
/// Relative error of velocity over wheel speed under drive.
const AS_THEY_ARE: f64 = 0.004;
/// 95 % of a normal distribution.
const NORMAL: f64 = 1.96;

/// Result of the in-gear fit for a coefficient.
struct Word {
    value: Option<f64>,
    std_error: Option<f64>,
    interval: [Option<f64>; 2],
    status: Status,
    reason: Option<Reason>,
}

/// Whether the ordinary fits lack what the in-gear fit gives: without the rear rolling radius there
/// is no slip.
pub fn lacking(rows: &[Coefficient]) -> bool {
    rows.iter().any(|row| {
        row.status == Status::NotAvailable
            && row.coefficient == C::EffectiveRollingRadius.name()
            && row.tyre == Part::Rear.name()
    })
}

/// Fills what is lacking and adds what only this fit gives. Intervals wider than `max_relative` of
/// the value are not determined.
pub fn fill(
    rows: &mut Vec<Coefficient>,
    fit: &InGear,
    max_relative: f64,
    ident: &Ident,
    provenance: &Provenance,
) {
    for row in rows.iter_mut() {
        let Some(id) = Id::from_names(&row.tyre, &row.coefficient) else { continue };
        if fit.withdraws(row, id, max_relative) {
            fit.put(row, assumed_shape(id.requirement().riding.remedy));
        }
        // without coasting the ordinary front radius is that of driving, velocity over wheel speed as
        // they are: latency, growth and load move it by 0.2 to 0.6 %
        let radius = id.coefficient == C::EffectiveRollingRadius;
        if !radius && !matches!(row.status, Status::NotAvailable | Status::PoorlyDetermined) {
            continue;
        }
        let Some(word) = fit.word(id, max_relative) else { continue };
        let better = matches!(word.status, Status::Ok | Status::LowerBound);
        if better || row.status == Status::NotAvailable {
            fit.put(row, word);
        }
    }
    for axle in Axle::BOTH {
        for coefficient in [C::SlipStiffness, C::BrakeGain] {
            let id = Id::from((axle, coefficient));
            let Some(word) = fit.word(id, max_relative) else { continue };
            let spec = coefficient.spec();
            let mut row = Coefficient {
                ident: ident.clone(),
                tyre: id.part.name().to_owned(),
                coefficient: spec.name.to_owned(),
                term: Some(spec.term.to_owned()),
                symbol: spec.symbol.to_owned(),
                unit: spec.unit.to_owned(),
                provenance: provenance.clone(),
                ..Coefficient::default()
            };
            fit.put(&mut row, word);
            rows.push(row);
        }
    }
}

/// The ordinary front radius where there is no coasting and this fit found none: velocity over wheel
/// speed under gentle drive, as they are.
pub(crate) fn doubt(rows: &mut [Coefficient]) {
    let own = |row: &&mut Coefficient| {
        row.coefficient == C::EffectiveRollingRadius.name() && row.tyre == Part::Front.name()
    };
    for row in rows.iter_mut().filter(own).filter(|row| row.status == Status::Ok) {
        let Some(value) = row.value else { continue };
        let error = AS_THEY_ARE * value;
        let half = |end: f64| (end - value).hypot(NORMAL * error);
        row.std_error = row.std_error.map(|sd| sd.hypot(error));
        row.ci95_low = row.ci95_low.map(|low| value - half(low));
        row.ci95_high = row.ci95_high.map(|high| value + half(high));
        row.status = Status::PoorlyDetermined;
        let words = "estimated under drive: latency, growth and load move it by 0.2 to 0.6 %";
        let reason = Reason::new(ReasonCode::UnderDrive, words);
        row.explain(Some(reason.with_advice("coast in neutral")));
    }
}

impl InGear {
    fn put(&self, row: &mut Coefficient, word: Word) {
        let known = word.status != Status::NotAvailable;
        row.value = word.value;
        row.std_error = word.std_error;
        [row.ci95_low, row.ci95_high] = word.interval;
        row.dispersion = None;
        row.n_manoeuvres = if known { self.fitted.clusters as i64 } else { 0 };
        row.n_samples = if known { self.fitted.held.len() as i64 } else { 0 };
        row.residual_scale = None;
        row.outlier_fraction = known.then_some(self.fitted.outliers);
        row.r_squared = None;
        row.status = word.status;
        row.explain(word.reason);
    }

    /// Whether a row is of the ordinary friction curve, which took the bike file's rolling radius, and this fit knows
    /// the wheel's: the curve's slips are then not those of the ride.
    fn withdraws(&self, row: &Coefficient, id: Id, max_relative: f64) -> bool {
        let unknown = row.reason_code.as_deref() == Some(ReasonCode::UnknownRadius.name());
        let radius = Id { coefficient: C::EffectiveRollingRadius, ..id };
        unknown && self.word(radius, max_relative).is_some_and(|w| w.status == Status::Ok)
    }

    /// `None` of what this fit says nothing about.
    fn word(&self, id: Id, max_relative: f64) -> Option<Word> {
        self.found(id, max_relative).map(|word| word.checked(id.coefficient))
    }

    fn found(&self, id: Id, max_relative: f64) -> Option<Word> {
        let axle = id.part.axle().map(|axle| axle as usize);
        let remedy = id.requirement().riding.remedy;
        let of = |k: usize, error: f64| self.linear(k, error, max_relative, remedy);
        let log = |k: usize, scale: f64, error: f64| {
            self.logarithmic(k, scale, error, max_relative, remedy)
        };
        Some(match (id.coefficient, axle) {
            (C::EffectiveRollingRadius, Some(k)) => of(R_F + k, MODEL_ERROR_RADIUS[k]),
            (C::OverturningStiffness, Some(k)) if self.is_roll_measured => {
                of(RHO_F + k, MODEL_ERROR_CROWN[k])
            }
            (C::Drag, None) => of(DRAG, MODEL_ERROR_DRAG),
            (C::RollingResistance, None) => of(ROLLING, 0.0),
            (C::SlipStiffness, Some(k)) => log(K_F + k, 1.0, MODEL_ERROR_STIFFNESS[k]),
            (C::BrakeGain, Some(k)) if self.pressures => log(BRAKE_F + k, 1.0 / BAR, 0.0),
            (C::MfD, Some(k)) => self.peak(k, max_relative, remedy),
            (C::MfB, Some(k)) => self.factor(k, remedy),
            _ => return None,
        })
    }

    /// Half of the 95 % interval of a parameter in its own scale, with the model's own error.
    fn half(&self, k: usize, error: f64) -> (f64, f64) {
        let sd = self.fitted.covariance[(k, k)].sqrt().hypot(error);
        (sd, t95(self.fitted.clusters as f64 - 1.0) * sd)
    }

    fn narrowed(&self, k: usize, half: f64) -> bool {
        half < NARROWED * NORMAL * self.prior.sd[k]
    }

    fn linear(&self, k: usize, error: f64, max_relative: f64, remedy: &str) -> Word {
        let value = self.fitted.theta[k];
        let (sd, half) = self.half(k, error * value);
        if !self.narrowed(k, half) {
            return undetermined(value, half, remedy);
        }
        Word::of(value, sd, [value - half, value + half], half > max_relative * value.abs(), remedy)
    }

    fn logarithmic(
        &self,
        k: usize,
        scale: f64,
        error: f64,
        max_relative: f64,
        remedy: &str,
    ) -> Word {
        let value = scale * self.fitted.theta[k].exp();
        let (sd, half) = self.half(k, error);
        if !self.narrowed(k, half) {
            return undetermined(value, value * half, remedy);
        }
        let ends = [value * (-half).exp(), value * half.exp()];
        Word::of(value, value * sd, ends, half > max_relative, remedy)
    }

    /// The peak: a value only where it was reached and the ride narrows it.
    fn peak(&self, wheel: usize, max_relative: f64, remedy: &str) -> Word {
        let found = self.logarithmic(D_F + wheel, 1.0, 0.0, max_relative, remedy);
        let Some(bound) = self.bounds[wheel] else {
            let words = "no bound of the peak without the tyre's own force".to_owned();
            return Word::none(because(ReasonCode::UnknownShares, words, remedy));
        };
        let reached = bound > REACHED * self.fitted.theta[D_F + wheel].exp();
        if reached && found.status == Status::Ok {
            return found;
        }
        Word {
            value: None,
            std_error: None,
            interval: [Some(bound), None],
            status: Status::LowerBound,
            reason: because(
                ReasonCode::PeakNotReached,
                format!("at least {bound:.2} was used (95 %, upright); the peak was not reached"),
                remedy,
            ),
        }
    }

    /// `b = K / (c d)`: the stiffness is of the ride, shape and peak are assumed.
    fn factor(&self, wheel: usize, remedy: &str) -> Word {
        let theta = &self.fitted.theta;
        let [k, c, d] = [K_F + wheel, C_F + wheel, D_F + wheel];
        let value = (theta[k] - theta[c] - theta[d]).exp();
        let by = [(k, 1.0), (c, -1.0), (d, -1.0)];
        let covariance = &self.fitted.covariance;
        let pairs = by.iter().flat_map(|i| by.iter().map(move |j| (i, j)));
        let variance: f64 = pairs.map(|(i, j)| i.1 * j.1 * covariance[(i.0, j.0)]).sum();
        let sd = variance.max(0.0).sqrt();
        let half = t95(self.fitted.clusters as f64 - 1.0) * sd;
        let stiffness = theta[k].exp();
        Word {
            value: Some(value),
            std_error: Some(value * sd),
            interval: [Some(value * (-half).exp()), Some(value * half.exp())],
            status: Status::PoorlyDetermined,
            reason: because(
                ReasonCode::AssumedShape,
                format!(
                    "slip stiffness {stiffness:.1} over c and d, which are assumed ({:.2}, {:.2})",
                    theta[c].exp(),
                    theta[d].exp()
                ),
                remedy,
            ),
        }
    }
}

/// Error of the model itself, of the value: biases of simulated rides with slope and wind, in
/// quadrature.
const MODEL_ERROR_RADIUS: [f64; 2] = [0.001, 0.004];
/// The front wheel is not leant as the frame is: by steering, up to half a degree.
const MODEL_ERROR_CROWN: [f64; 2] = [0.05, 0.04];
/// It trades with the engine's drag and with the rider's posture.
const MODEL_ERROR_DRAG: f64 = 0.18;
/// Tyres whose slip stiffness goes with the load in another way.
const MODEL_ERROR_STIFFNESS: [f64; 2] = [0.08, 0.10];

fn because(code: ReasonCode, sentence: String, remedy: &str) -> Option<Reason> {
    Some(Reason::new(code, sentence).with_advice(remedy))
}

/// Of a coefficient of the friction curve that this fit does not free.
fn assumed_shape(remedy: &str) -> Word {
    let words = "the fit of the ride in gear assumes the shape of the friction curve".to_owned();
    Word::none(because(ReasonCode::AssumedShape, words, remedy))
}

fn undetermined(value: f64, half: f64, remedy: &str) -> Word {
    // two digits of the uncertainty
    let digits = (1.0 - half.log10().floor()).clamp(0.0, 9.0) as usize;
    let words = format!(
        "the ride in gear hardly narrows what was assumed ({value:.digits$} ± {half:.digits$})"
    );
    Word::none(because(ReasonCode::HardlyNarrowed, words, remedy))
}

impl Word {
    fn of(value: f64, sd: f64, ends: [f64; 2], wide: bool, remedy: &str) -> Word {
        Word {
            value: Some(value),
            std_error: Some(sd),
            interval: ends.map(Some),
            status: if wide { Status::PoorlyDetermined } else { Status::Ok },
            reason: wide.then(|| Reason::wide_interval(ends[0], ends[1]).with_advice(remedy)),
        }
    }

    /// A coefficient without a value, with the reason.
    fn none(reason: Option<Reason>) -> Word {
        Word {
            value: None,
            std_error: None,
            interval: [None, None],
            status: Status::NotAvailable,
            reason,
        }
    }

    /// The same, unless no motorcycle has such a value; of a lower bound the upper end counts.
    fn checked(self, coefficient: C) -> Word {
        if let Some(words) = self.value.and_then(|value| coefficient.impossible(value)) {
            let (status, reason) = (Status::PoorlyDetermined, Some(Reason::impossible(words)));
            return Word { status, reason, ..self };
        }
        let beyond = |bound: &f64| *bound >= coefficient.spec().bounds[1];
        let bound = self.interval[0].filter(|_| self.value.is_none()).filter(beyond);
        match bound.and_then(|bound| coefficient.impossible(bound)) {
            Some(words) => Word::none(Some(Reason::impossible(words))),
            None => self,
        }
    }
}
