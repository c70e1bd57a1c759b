//! Why a coefficient is not determined, a manoeuvre not used or a number doubted: a code for programs, a sentence
//! for people, and what to do about it.

use std::fmt;
use std::ops::Deref;

macro_rules! codes {
    ($($variant:ident: $name:literal, $words:literal;)+) => {
        /// Kind of a reason: what programs tell reasons apart by. Sentences may change, codes stay.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum ReasonCode {
            $(#[doc = $words] $variant,)+
        }

        impl ReasonCode {
            /// Every code, in the order of the book's list.
            pub const ALL: &'static [ReasonCode] = &[$(ReasonCode::$variant),+];

            pub fn name(self) -> &'static str {
                match self { $(ReasonCode::$variant => $name,)+ }
            }

            pub fn words(self) -> &'static str {
                match self { $(ReasonCode::$variant => $words,)+ }
            }
        }
    };
}

codes! {
    MissingChannel: "missing_channel", "The log lacks a channel that it takes.";
    UnknownCoasting: "unknown_coasting", "Nothing in the log distinguishes coasting from drive and engine braking.";
    Contradicted: "contradicted", "Other channels contradict a channel that it depends on.";
    Impossible: "impossible", "No motorcycle, bicycle or car has such a value: a unit, a sign or a channel is wrong.";
    NoManoeuvre: "no_manoeuvre", "No manoeuvre of the ride can be used for it.";
    FewManoeuvres: "few_manoeuvres", "Too few manoeuvres for a fit or for an interval.";
    UnknownRadius: "unknown_radius", "The rolling radius is not known from the ride, and the slip with it.";
    NoisySlip: "noisy_slip", "Noise of the slip ratio hides the friction curve.";
    PeakNotReached: "peak_not_reached", "The ride stays short of the peak of friction.";
    WideInterval: "wide_interval", "The interval is wider than the pipeline allows.";
    Unbounded: "unbounded", "The ride does not bound it at all.";
    HardlyNarrowed: "hardly_narrowed", "The ride in gear hardly narrows what was assumed.";
    AssumedShape: "assumed_shape", "It rests on a shape or a peak of the curve that is assumed.";
    UnderDrive: "under_drive", "It was estimated under drive, where other errors move it.";
    Rule: "rule", "It follows from a rule, not from the ride.";
    BikeFile: "bike_file", "It is the bike file's number.";
    BikeFileDefault: "bike_file_default", "The bike file does not give it; it is the usual number.";
    BikeFileNarrowed: "bike_file_narrowed", "The bike file's or a usual number, drawn to the ride.";
    OneSided: "one_sided", "The wheel was not both braked and driven.";
    UnknownShares: "unknown_shares", "How the force divides between tyres or contacts is not known.";
    SegmentsDiffer: "segments_differ", "The segments differ too much among themselves.";
    AlikeSessions: "alike_sessions", "The sessions are too alike to tell.";
    DoubtedNumber: "doubted_number", "The rides contradict the bike file's number.";
    NotSteady: "not_steady", "The lean is not steady.";
    Combined: "combined", "Braking or accelerating while leaning.";
    UnknownBrake: "unknown_brake", "It is unknown which brake acts.";
    EngineBraking: "engine_braking", "The engine brakes along, or instead.";
    NotNeeded: "not_needed", "Other manoeuvres of the ride show the same better.";
    Weak: "weak", "Too gentle to learn from.";
    Short: "short", "Too short.";
    MissingSamples: "missing_samples", "Too many of its samples are missing.";
    Slow: "slow", "Standing, or too slow.";
    NoVelocity: "no_velocity", "There is no forward velocity.";
    Transition: "transition", "On the way into or out of a corner.";
    NoKind: "no_kind", "It is none of the manoeuvres that are used.";
}

impl fmt::Display for ReasonCode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// Advice about a value that no log should give.
const CHECK_MAP: &str = "check units, signs and the channel map: `roadbench map LOG --map MAP`";

/// A reason; as a text it is its sentence.
#[derive(Debug, Clone, PartialEq)]
pub struct Reason {
    pub code: ReasonCode,
    /// Reason, without advice.
    pub sentence: String,
    /// Advice that would change it.
    pub advice: Option<String>,
}

impl Reason {
    /// A reason without advice.
    pub fn new(code: ReasonCode, sentence: impl Into<String>) -> Self {
        Reason { code, sentence: sentence.into(), advice: None }
    }

    /// Of a value that no motorcycle has, in its coefficient's words.
    pub fn impossible(sentence: String) -> Self {
        Reason::new(ReasonCode::Impossible, sentence).with_advice(CHECK_MAP)
    }

    /// Of a channel that others contradict, with what they say.
    pub fn contradicted(sentence: String) -> Self {
        Reason::new(ReasonCode::Contradicted, sentence).with_advice(CHECK_MAP)
    }

    /// Of an interval by its ends, in the unit of the value beside it.
    pub fn wide_interval(low: f64, high: f64) -> Self {
        let words = format!("the interval is wide, {low:.3} to {high:.3}");
        Reason::new(ReasonCode::WideInterval, words)
    }

    /// The same with what would change it.
    #[must_use]
    pub fn with_advice(self, advice: impl Into<String>) -> Self {
        Reason { advice: Some(advice.into()), ..self }
    }
}

impl Deref for Reason {
    type Target = str;

    fn deref(&self) -> &str {
        &self.sentence
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::store::tables::registry;

    /// Where a table has the column, its description lists every code that its rows may have; so does the book.
    #[test]
    fn codes_are_documented_once_each() {
        let names: BTreeSet<&str> = ReasonCode::ALL.iter().map(|code| code.name()).collect();
        assert_eq!(names.len(), ReasonCode::ALL.len());
        let mut listed: BTreeSet<&str> = BTreeSet::new();
        for table in registry::ALL.iter().map(|spec| spec.table()) {
            let Some(column) = table.column("reason_code") else { continue };
            assert!(table.column("reason").is_some() && column.nullable, "{}", table.name);
            let (_, codes) = column.description.split_once("one of ").expect("a list");
            for code in codes.trim_end_matches('.').split(", ") {
                let known = names.get(code).unwrap_or_else(|| panic!("{}: {code}", table.name));
                listed.insert(known);
            }
        }
        assert_eq!(listed, names);
        let book = include_str!("../../book/src/output.md");
        for code in ReasonCode::ALL {
            let line = format!("| `{}` | {} |", code.name(), code.words());
            assert!(book.contains(&line), "output.md lacks {line}");
        }
    }
}
