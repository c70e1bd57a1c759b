//! Candidates, causes and what a diagnosis makes of all of them: the types that road and off-road share.

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
    /// Name of its one number in the tables.
    pub parameter: &'static str,
    /// What happens where its number has the sign of `typical`, as a main clause.
    pub sentence: &'static str,
    /// What happens where it has the other sign.
    pub opposite: &'static str,
    /// Unit of its number.
    pub unit: &'static str,
    /// The riding or the channel that tells it from others.
    pub separate_by: &'static str,
    /// A usual size, in the unit.
    pub typical: f64,
    /// Smallest and largest size that is physically plausible, in the unit.
    pub bounds: [f64; 2],
}

impl Candidate {
    /// Whether a size is physically plausible.
    pub fn in_bounds(&self, size: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&size)
    }

    /// What happens at a size; at one that is not known, what usually does.
    pub fn sentence_of(&self, size: f64) -> &'static str {
        by_sign(size, self.typical, [self.sentence, self.opposite])
    }
}

/// A size with its standard error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// In the candidate's unit, the method's bias taken off.
    pub value: f64,
    /// Standard error, in the unit; of the natural logarithm of the value where that is `logarithmic`.
    pub std_error: f64,
    /// Whether the error is symmetric in the logarithm of the value.
    pub logarithmic: bool,
}

impl Estimate {
    /// Of a size whose error is in its own unit.
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

/// Why a candidate that would have been named is not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objection {
    /// It leaves more structure in the channels where it shows itself than a cause may.
    Contradicted,
    /// Null simulations on the model with it do not give its size back, or only one out of bounds.
    NotReproduced,
    /// The simulation of manoeuvres left out of the fit gets worse with what is named.
    WorseSimulation,
}

/// Which rule of the naming leaves a candidate out that is beyond what fault-free simulations show.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Refusal {
    /// Other motorcycles score as much where nothing is wrong; the score that a cause needs.
    NoAlarm(f64),
    /// To first order it gains far less than those that were fitted together with the model.
    NotFitted,
    /// Its size in the joint fit is out of its bounds.
    Implausible(f64),
    /// The joint fit gains too little.
    LittleGain {
        /// Fall of twice the loss.
        gain: f64,
        /// What a cause needs.
        needed: f64,
    },
    /// Its size in the joint fit is smaller than what a bike file is usually known to.
    Small(f64),
    /// Another of its family is identified.
    Related,
    /// Its size is not known well enough.
    Vague,
    /// It gains too little on manoeuvres left out of the fit.
    NotHeldOut,
    /// This one gains more and joined the model.
    Behind(&'static str),
}

/// What refuses candidates at a stage of the naming, by their names.
pub(crate) type Refusals = BTreeMap<&'static str, Refusal>;

/// A candidate at a stage of the naming, before any verdict.
#[derive(Debug, Clone)]
pub(crate) struct Judged {
    /// The candidate.
    pub candidate: Candidate,
    /// Its size; `None` where no size is better than none.
    pub estimate: Option<Estimate>,
    /// Size that the method itself shows on null simulations, already taken off `estimate`.
    pub bias: f64,
    /// Over one is beyond what fault-free simulations show.
    pub score: f64,
    /// Fall of twice the loss when it joins the model, to first order or by a fit.
    pub gain: f64,
    /// Whether it is an alarm whatever its score: it relieves a base model that is strained.
    pub relieves: bool,
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
    /// The candidate.
    pub candidate: Candidate,
    /// What is concluded about it.
    pub verdict: Verdict,
    /// Why it is not needed though it alarmed and gained enough.
    pub objection: Option<Objection>,
    /// Why it did not join the model though it is beyond what fault-free simulations show.
    pub refusal: Option<Refusal>,
    /// Its size; `None` where no size is better than none.
    pub estimate: Option<Estimate>,
    /// Size that the method itself shows on null simulations, already taken off `estimate`.
    pub bias: f64,
    /// Over one is beyond what fault-free simulations show.
    pub score: f64,
    /// Fall of twice the loss when it joined the model; zero where that was not tried.
    pub gain: f64,
    /// Names of other candidates that the ride cannot tell from it.
    pub equivalent: Vec<&'static str>,
}

impl Cause {
    /// The same, not needed after all.
    #[must_use]
    pub fn rejected(self, objection: Objection) -> Self {
        Cause { verdict: Verdict::NotNeeded, objection: Some(objection), ..self }
    }

    /// The same with what refused it at its stage, where it is beyond what fault-free simulations show; `alarm` is the score
    /// that a cause needs.
    #[must_use]
    pub(crate) fn refused(self, at_stage: &Refusals, alarm: f64) -> Self {
        let is_beyond = self.verdict == Verdict::NotNeeded && self.score > 1.0;
        let quiet = (self.score <= alarm).then_some(Refusal::NoAlarm(alarm));
        let refusal = at_stage.get(self.candidate.name).copied().or(quiet);
        Cause { refusal: refusal.filter(|_| is_beyond), ..self }
    }

    /// Keeps some of the equivalents; without any the cause is named.
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

/// Residual structure: what is left of the misfit and follows a variable of the ride.
#[derive(Debug, Clone, PartialEq)]
pub struct Structure {
    /// Channel and variable, in words.
    pub description: String,
    /// How many times what 19 of 20 fault-free simulations stay below.
    pub times: f64,
}

/// The outcome of the naming; `M` is a fitted model.
#[derive(Debug, Clone)]
pub struct Naming<M> {
    /// Every candidate: those named in the order of their naming, those objected to, then the others by
    /// their score.
    pub causes: Vec<Cause>,
    /// The model with what is named.
    pub extended: M,
    /// Largest score before anything was named.
    pub alarm: f64,
    /// The largest residual structure, where it is looked for.
    pub structure: Option<Structure>,
    /// Whether something is wrong that no candidate explains.
    pub unexplained: bool,
    /// What refuses candidates beside the nominal model.
    pub refused_at_first: Refusals,
}

impl<M> Naming<M> {
    /// The causes that are in the extended model.
    pub fn named(&self) -> impl Iterator<Item = &Cause> {
        self.causes.iter().filter(|c| c.verdict.is_cause())
    }

    /// Whether anything is named.
    pub fn any_named(&self) -> bool {
        self.named().next().is_some()
    }
}
