//! Candidates, causes and verdicts: the types that road and off-road share.

use std::collections::BTreeMap;

use crate::contract::verdict::Verdict;
use crate::simulate::effects::spec::by_sign;

/// A candidate cause: an effect of the road model or of the off-road one.
#[derive(Debug, Clone, Copy)]
pub struct Candidate {
    /// Place among the candidates of the diagnosis.
    pub place: usize,
    /// Name in the tables.
    pub name: &'static str,
    /// Name of its size in the tables.
    pub parameter: &'static str,
    /// Effect of a size with the sign of `typical`, as a main clause.
    pub sentence: &'static str,
    /// Effect of a size with the other sign, as a main clause.
    pub opposite: &'static str,
    /// Unit of its size.
    pub unit: &'static str,
    /// Riding or channel that separates it from other candidates.
    pub separate_by: &'static str,
    /// Usual size, in the unit.
    pub typical: f64,
    /// Smallest and largest size that is physically plausible, in the unit.
    pub bounds: [f64; 2],
}

impl Candidate {
    /// Whether a size is physically plausible.
    pub fn in_bounds(&self, size: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&size)
    }

    /// Sentence for a size; for NaN that of the usual sign.
    pub fn sentence_of(&self, size: f64) -> &'static str {
        by_sign(size, self.typical, [self.sentence, self.opposite])
    }
}

/// A size with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Size in the candidate's unit, without the method's bias.
    pub value: f64,
    /// Standard error, in the unit; of the natural logarithm of the value where that is `logarithmic`.
    pub std_error: f64,
    /// Whether the error is symmetric in the logarithm of the value.
    pub logarithmic: bool,
}

impl Estimate {
    /// Estimate with a standard error in the size's unit.
    pub fn linear(value: f64, std_error: f64) -> Self {
        Estimate { value, std_error, logarithmic: false }
    }

    /// 95 % confidence interval, in the unit; `None` where the standard error is not known.
    pub fn interval(&self) -> Option<[f64; 2]> {
        let half = 1.96 * self.std_error;
        self.std_error.is_finite().then(|| match self.logarithmic {
            true => [self.value * (-half).exp(), self.value * half.exp()],
            false => [self.value - half, self.value + half],
        })
    }
}

/// Reason why a candidate that would have been identified is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objection {
    /// It leaves too much structure in the channels where it acts.
    Contradicted,
    /// Fault-free simulations on the model with it do not reproduce its size, or only a size out of bounds.
    NotReproduced,
    /// The causes make the simulation of manoeuvres left out of the fit worse.
    WorseSimulation,
}

/// Rule that refuses a candidate although its score is beyond fault-free simulations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// Fault-free rides of other motorcycles score as much; holds the score that a cause needs.
    NoAlarm(f64),
    /// Its first-order gain is far below that of the candidates that were fitted.
    NotFitted,
    /// The size in the joint fit, which is out of bounds.
    Implausible(f64),
    /// The joint fit gains too little.
    LittleGain {
        /// Fall of twice the loss.
        gain: f64,
        /// Gain that a cause needs.
        needed: f64,
    },
    /// The size in the joint fit, smaller than the usual uncertainty of a bike file.
    Small(f64),
    /// Another of its family is identified.
    Related,
    /// The standard error of its size is too large.
    Vague,
    /// It gains too little on manoeuvres left out of the fit.
    NotHeldOut,
    /// The candidate that gains more and joined the model instead.
    Outgained(&'static str),
}

/// Reasons that refuse candidates at a stage, by candidate name.
pub(crate) type Refusals = BTreeMap<&'static str, Refusal>;

/// A candidate at a stage of the search, before any verdict.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    /// Effect, with its unit, bounds and sentences.
    pub candidate: Candidate,
    /// Its size; `None` if no size fits better than zero.
    pub estimate: Option<Estimate>,
    /// Bias of the method: the size shown by fault-free simulations, already subtracted from `estimate`.
    pub bias: f64,
    /// Score: 19 of 20 fault-free simulations stay below 1.
    pub score: f64,
    /// Fall of twice the loss when it joins the model, to first order or by a fit.
    pub gain: f64,
    /// Whether it makes an implausible fit plausible: then it alarms whatever its score.
    pub makes_plausible: bool,
}

impl Judged {
    /// A cause with a verdict, without a refit.
    pub(crate) fn cause(&self, verdict: Verdict) -> Cause {
        Cause {
            candidate: self.candidate,
            verdict,
            objection: None,
            refusal: None,
            estimate: self.estimate,
            bias: self.bias,
            score: self.score,
            gain: 0.0,
            equivalent: Vec::new(),
        }
    }
}

/// A candidate with its verdict.
#[derive(Debug, Clone)]
pub struct Cause {
    /// Effect, with its unit, bounds and sentences.
    pub candidate: Candidate,
    /// Conclusion about the candidate.
    pub verdict: Verdict,
    /// Test that withdrew it although it alarmed and gained enough.
    pub objection: Option<Objection>,
    /// Rule that kept it out of the model although its score is above 1.
    pub refusal: Option<Refusal>,
    /// Its size; `None` if no size fits better than zero.
    pub estimate: Option<Estimate>,
    /// Bias of the method: the size shown by fault-free simulations, already subtracted from `estimate`.
    pub bias: f64,
    /// Score: 19 of 20 fault-free simulations stay below 1.
    pub score: f64,
    /// Fall of twice the loss when it joined the model; zero where that was not tried.
    pub gain: f64,
    /// Names of the candidates that the ride cannot separate from it.
    pub equivalent: Vec<&'static str>,
}

impl Cause {
    /// The same cause, withdrawn: not needed.
    #[must_use]
    pub fn rejected(self, objection: Objection) -> Self {
        Cause { verdict: Verdict::NotNeeded, objection: Some(objection), ..self }
    }

    /// The same with the rule that refused it at its stage, if its score is above 1; `alarm` is the score that a cause
    /// needs.
    #[must_use]
    pub(crate) fn refused(self, at_stage: &Refusals, alarm: f64) -> Self {
        let is_beyond = self.verdict == Verdict::NotNeeded && self.score > 1.0;
        let quiet = (self.score <= alarm).then_some(Refusal::NoAlarm(alarm));
        let refusal = at_stage.get(self.candidate.name).copied().or(quiet);
        Cause { refusal: refusal.filter(|_| is_beyond), ..self }
    }

    /// Keeps some of the equivalents; a cause without any has the verdict `Named`.
    pub fn retain_equivalents(&mut self, keep: impl Fn(&str) -> bool) {
        self.equivalent.retain(|name| keep(name));
        if self.equivalent.is_empty() {
            self.verdict = Verdict::Named;
        }
    }

    /// Its size, NaN where there is none.
    pub fn value(&self) -> f64 {
        self.estimate.map_or(f64::NAN, |e| e.value)
    }

    /// Standard error of its size, NaN where there is none.
    pub fn std_error(&self) -> f64 {
        self.estimate.map_or(f64::NAN, |e| e.std_error)
    }
}

/// Residual structure: a remaining misfit that follows a variable of the ride.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Channel and variable, in words.
    pub description: String,
    /// Size over the threshold that 19 of 20 fault-free simulations stay below.
    pub times: f64,
}

/// Result of the search for causes; `M` is a fitted model.
#[derive(Debug, Clone)]
pub struct Identification<M> {
    /// Every candidate: causes in the order of their identification, withdrawn ones, then the others by score.
    pub causes: Vec<Cause>,
    /// The model with the causes.
    pub extended: M,
    /// Largest score on the nominal model.
    pub alarm: f64,
    /// The largest residual structure; `None` off the road, where none is sought.
    pub structure: Option<Structure>,
    /// Whether the ride has a misfit that no candidate explains.
    pub unexplained: bool,
    /// Reasons that refused candidates on the nominal model.
    pub refused_at_first: Refusals,
}

impl<M> Identification<M> {
    /// The causes that are in the extended model.
    pub fn named(&self) -> impl Iterator<Item = &Cause> {
        self.causes.iter().filter(|c| c.verdict.is_cause())
    }

    /// Whether there is a cause in the extended model.
    pub fn any_identified(&self) -> bool {
        self.named().next().is_some()
    }
}
