//! Status of a coefficient and, where it is not determined, the reason and the riding that would
//! change that.

use super::config::Config;
use super::friction::{Friction, is_of_curve};
use super::solution::Solution;
use crate::contract::bike::Bike;
use crate::contract::coefficient::{Coefficient as C, GIVEN, Id, Source};
use crate::contract::reason::{Reason, ReasonCode};
use crate::statistics::clustered_fit::Uncertainty;
use crate::statistics::interval::Interval;
use crate::store::tables::rows::Status;

/// Share of the variance that a friction curve must explain: where the ride's limit is the
/// rider's command and the slip ratio is noise, the samples look like a peak that is none.
const MIN_CURVE: f64 = 0.9;
/// Share of the peak's slip that must have been braked to.
const REACHED: f64 = 0.9;
/// Scale of the symmetric curvature's interval, of a curvature up to 1. The narrowest intervals of it
/// are the luckiest ones: half the usual width is asked.
const CURVATURE_SCALE: f64 = 0.5;
/// Least scale of the interval of `c3`, 1/rad².
const C3_SCALE: f64 = 0.1;

/// A status, and why it is not `ok`.
type Objection = (Status, Reason);

/// Inputs of a verdict.
pub(crate) struct Case<'a> {
    pub solution: &'a Solution,
    pub config: &'a Config,
    pub id: Id,
    /// Uncertainty from its own fit.
    pub own: &'a Uncertainty,
    /// Its 95 % interval.
    pub interval: Interval,
}

impl Case<'_> {
    /// Status and reason; `missing` is the reason where a needed channel is not there.
    pub(crate) fn verdict(&self, missing: Option<Reason>) -> (Status, Option<Reason>) {
        let ridden = self.solution.is_of_changing_lean(self.id);
        let assumed = if ridden { None } else { self.assumed() };
        let missing = missing.filter(|_| !ridden);
        let objection = assumed
            .or_else(|| self.not_available(missing))
            .or_else(|| self.impossible())
            .or_else(|| self.few_manoeuvres())
            .or_else(|| self.unknown_curve())
            .or_else(|| self.wide_interval());
        match objection {
            Some((status, reason)) => (status, Some(reason)),
            None => (Status::Ok, None),
        }
    }

    fn value(&self) -> f64 {
        self.solution.found.values[self.id]
    }

    fn remedy(&self) -> &'static str {
        self.id.requirement().riding.remedy
    }

    /// Poorly determined; the riding that the coefficient takes would change that.
    fn poor(&self, code: ReasonCode, sentence: impl Into<String>) -> Objection {
        (Status::PoorlyDetermined, Reason::new(code, sentence).with_advice(self.remedy()))
    }

    fn assumed(&self) -> Option<Objection> {
        let reason = match self.id.coefficient.spec().source {
            Source::BikeFile(reason) | Source::ChangingLean(reason) => self.taken(reason),
            _ if self.id.coefficient == C::MfE2 && self.value() == 0.0 => {
                let words = "the wheel was not both braked and driven: e1 is the curvature of the ridden side";
                Reason::new(ReasonCode::OneSided, words)
            }
            _ => return None,
        };
        Some((Status::Assumed, reason))
    }

    /// Where a value that is not estimated comes from; `reason` is the coefficient's own.
    fn taken(&self, reason: &str) -> Reason {
        let bike = &self.solution.inputs.bike;
        if is_of_rule(bike, self.id) {
            return Reason::new(ReasonCode::Rule, reason);
        }
        if self.id.coefficient == C::SlipStiffnessLoad && self.is_narrowed() {
            let words =
                "the bike file's or a usual one, drawn to where braking and driving give one curve";
            return Reason::new(ReasonCode::BikeFileNarrowed, words);
        }
        let key = format!("{}.{}", self.id.part, self.id.coefficient);
        match bike.priors_of_missing().get(&key) {
            Some(prior) => {
                let sd = significant(prior.sd);
                let words = format!("default of the bike file's schema, not given: ±{sd}");
                Reason::new(ReasonCode::BikeFileDefault, words)
            }
            None => Reason::new(ReasonCode::BikeFile, GIVEN),
        }
    }

    /// Whether a tyre was braked and driven, and its gain of slip stiffness fitted with the curve.
    fn is_narrowed(&self) -> bool {
        let Some(axle) = self.id.part.axle() else { return false };
        let key = format!("{}.{}", axle.name(), self.id.coefficient);
        let (both, known) =
            (&self.solution.samples.friction[axle as usize], &self.solution.inputs.bike);
        both.both_signs && known.deviation(&key) > 0.0
    }

    fn not_available(&self, missing: Option<Reason>) -> Option<Objection> {
        let unknown = || (!self.value().is_finite()).then(|| self.without_value());
        missing.or_else(unknown).map(|reason| (Status::NotAvailable, reason))
    }

    /// Why no value came out: nothing to fit, too little of it, or a fitted curve that has no peak.
    fn without_value(&self) -> Reason {
        if let Some((_, reason)) = self.few_manoeuvres_of_curve().or_else(|| self.unknown_curve()) {
            return reason;
        }
        let gathered = self.solution.samples.gathered.of(self.id);
        let (_, reason) = match gathered {
            0 => self.poor(ReasonCode::NoManoeuvre, "no usable manoeuvre"),
            n => {
                let words = format!("too few samples for a fit, of {n} usable manoeuvre(s)");
                self.poor(ReasonCode::FewManoeuvres, words)
            }
        };
        reason
    }

    /// A value that no tyre and no motorcycle has.
    fn impossible(&self) -> Option<Objection> {
        let words = self.id.coefficient.impossible(self.value())?;
        Some((Status::PoorlyDetermined, Reason::impossible(words)))
    }

    fn few_manoeuvres(&self) -> Option<Objection> {
        self.fewer(self.own.quality.n_clusters)
    }

    /// Of a coefficient of the friction curve, which may have none of its own: the manoeuvres of the curve.
    fn few_manoeuvres_of_curve(&self) -> Option<Objection> {
        self.fewer(self.curve()?.quality.n_clusters)
    }

    fn fewer(&self, n: usize) -> Option<Objection> {
        (n < self.config.min_manoeuvres)
            .then(|| self.poor(ReasonCode::FewManoeuvres, format!("only {n} usable manoeuvre(s)")))
    }

    /// The fitted friction curve that a coefficient belongs to.
    fn curve(&self) -> Option<&Friction> {
        let axle = self.id.part.axle().filter(|_| is_of_curve(self.id.coefficient))?;
        self.solution.fits.friction[axle as usize].as_ref()
    }

    /// For a coefficient of the friction curve: whether the slip is known and the curve was ridden.
    fn unknown_curve(&self) -> Option<Objection> {
        let fit = self.curve()?;
        let radius = &self.solution.fits.coasting.radius[self.id.part.axle()? as usize];
        if radius.as_ref().is_none_or(|r| r.quality.n_clusters < self.config.min_manoeuvres) {
            let words = "the rolling radius is not known from this ride, and the slip with it";
            let reason = Reason::new(ReasonCode::UnknownRadius, words);
            return Some((Status::PoorlyDetermined, reason.with_advice("coast in neutral")));
        }
        if fit.quality.r_squared < MIN_CURVE {
            let words = format!(
                "the curve explains {:.0} % of the friction only, the rest is noise of the slip ratio",
                100.0 * fit.quality.r_squared.max(0.0)
            );
            return Some(self.poor(ReasonCode::NoisySlip, words));
        }
        // one deep slip may be noise: as many braking manoeuvres as a coefficient needs must have reached it
        let needed = self.config.min_manoeuvres.max(1);
        let deepest = fit.deepest.get(needed - 1).map_or(0.0, |s| -s);
        let deepest = deepest.min(-fit.slip_range[0]).max(0.0);
        let peak = fit.formula.peak_slip();
        let reached = peak.is_some_and(|p| deepest / (1.0 - deepest) > REACHED * p);
        (!reached && self.id.coefficient != C::MfB).then(|| {
            let words = format!("braked to a slip ratio of {deepest:.3} only, short of the peak");
            self.poor(ReasonCode::PeakNotReached, words)
        })
    }

    fn wide_interval(&self) -> Option<Objection> {
        let Some((low, high)) = self.interval.ends() else {
            return Some(self.poor(ReasonCode::Unbounded, "the ride does not bound it"));
        };
        let wide = 0.5 * (high - low) > self.config.max_relative_interval * self.scale();
        let reason = || Reason::wide_interval(low, high).with_advice(self.remedy());
        wide.then(|| (Status::PoorlyDetermined, reason()))
    }

    /// Scale by which the width of the interval is judged, in the coefficient's unit. Curvature and slip over
    /// camber may well be zero: they have a scale of their own.
    fn scale(&self) -> f64 {
        let value = self.value().abs();
        match (self.id.coefficient, self.id.part.axle()) {
            (C::MfE1, _) => CURVATURE_SCALE * value.max(1.0),
            (C::MfE2, _) => value.max(1.0),
            (C::SlipCamberC1, Some(axle)) => {
                value.max(self.solution.inputs.bike.wheel(axle).side_force_ratio)
            }
            (C::SlipCamberC3, _) => value.max(C3_SCALE),
            _ => value,
        }
    }
}

/// Whether a coefficient's value comes from a rule and not from the bike file.
pub(crate) fn is_of_rule(bike: &Bike, id: Id) -> bool {
    let given = |axle| bike.wheel(axle).relaxation_length.is_some();
    match id.coefficient {
        C::PneumaticTrail0 => true,
        C::RelaxationLength => !id.part.axle().is_some_and(given),
        _ => false,
    }
}

/// Two significant digits.
fn significant(x: f64) -> String {
    let decimals = (1.0 - x.abs().log10().floor()).clamp(0.0, 9.0);
    format!("{x:.*}", decimals as usize)
}
