//! The tuned constants of the diagnosis, with their reasons.
//!
//! `cargo run --release --example constants` varies each by a third on simulated rides and prints how many
//! verdicts change; its table is in `book/src/reference/constants.md`. The prototype of the reasons is that
//! of `book/src/diagnosis.md`, section 3.1.

#![cfg_attr(not(feature = "internals"), allow(dead_code))] // the tables are for the book and for studies

use crate::contract::verdict::{ALARM_OFFROAD, ALARM_ROAD};

#[derive(Debug, Clone, Copy)]
pub struct Constant<T> {
    pub name: &'static str,
    pub words: &'static str,
    /// The measurement or the argument that set it.
    pub reason: &'static str,
    pub get: fn(&T) -> f64,
    /// Puts it; of a count the whole part.
    pub set: fn(&mut T, f64),
}

macro_rules! tuning {
    (
        $(#[doc = $about:literal])+
        $tuning:ident, $list:ident:
        $($name:ident: $type:ty = $value:expr, $words:literal, $reason:literal;)+
    ) => {
        $(#[doc = $about])+
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $tuning {
            $(#[doc = $words] pub $name: $type,)+
        }

        impl Default for $tuning {
            fn default() -> Self {
                $tuning { $($name: $value,)+ }
            }
        }

        #[doc = concat!("Every constant of [`", stringify!($tuning), "`].")]
        pub const $list: &[Constant<$tuning>] = &[
            $(Constant {
                name: stringify!($name),
                words: $words,
                reason: $reason,
                get: |t| t.$name as f64,
                set: |t, value| t.$name = value as $type,
            },)+
        ];
    };
}

tuning! {
    /// Thresholds by which a candidate is identified on the road. Scores are in units of what 19 of 20 fault-free
    /// simulations stay below, gains are falls of twice the loss.
    RoadTuning, ROAD:
    alarm: f64 = ALARM_ROAD,
        "Score from which there is an alarm, and that an identified candidate and its equivalents must have.",
        "fault-free simulations are the model's own: of 57 rides of other machines with nothing hidden a cause is found in five from 1.25, \
         four from 1.5, none from 1.75; of 45 effects above two limits 44 at each";
    gain: f64 = 12.0,
        "Least gain of the joint fit with the first cause.",
        "the prototype's gate, set on its first 106 archives";
    further_gain: f64 = 20.0,
        "Least gain of every further cause.",
        "below a gain of 20 a multibody ride was given a wheel inertia too, and a ride with wind a brake drag";
    refitted: usize = 6,
        "Most candidates that are fitted together with the model.",
        "saves fits: the prototype refitted five; no measurement of a sixth is on record";
    far: f64 = 0.2,
        "Share of the best gain to first order below which a candidate is not refitted.",
        "saves fits; no measurement is on record";
    equivalent: f64 = 0.8,
        "Share of the best gain from which a candidate is an equivalent.",
        "a cosine of 0.9, at which a rival gains four fifths; the prototype's class held the true effect in 0.97 and 0.92 of its archives";
    contradicts: f64 = 1.4,
        "Structure that objects to an identified cause, in what 19 of 20 fault-free simulations on the model stay below.",
        "at 1.0 the prototype flagged 16 to 25 of 100 correctly diagnosed archives as incomplete";
    touches: f64 = 0.1,
        "Share of what a cause changes that is in the structure's channel when the structure objects to it.",
        "no measurement is on record";
    strong: f64 = 3.0,
        "Score from which structure objects to a cause no more.",
        "no measurement is on record";
    model_error: f64 = 0.03,
        "What a size is uncertain by because the model is, as a share of it.",
        "the prototype: intervals covered 81 of 100 without it, 86 with it";
    quieter: f64 = 0.9,
        "Share of a channel's noise below which the noise is learnt anew from the model with the causes.",
        "saves simulations; no measurement is on record";
    look: f64 = 0.7,
        "Score on the stage before from which candidates are compared with fault-free simulations of their own stage.",
        "saves simulations: the margin to `alarm` is for what a score moves between stages; no measurement is on record";
    nulls_of_stage: usize = 16,
        "Most fault-free simulations on a model with causes.",
        "error of the calibration against time";
    nulls_of_sizes: usize = 6,
        "Fault-free simulations of a first look at how much of a size a fit gives back.",
        "saves simulations: only a size that is off by `off_size` is simulated again";
    off_size: f64 = 0.1,
        "How far, as a share, a size may be from the simulated one.",
        "saves simulations; no measurement is on record";
    share_prior: f64 = 0.3,
        "Prior standard deviation, about one, of the share of a true size that a fit gives back.",
        "so few simulations leave the share itself uncertain; a size within its noise says nothing of it";
}

tuning! {
    /// Thresholds by which a candidate is identified off-road. Scores are in units of what 19 of 20 fault-free
    /// simulations stay below, gains are falls of twice the loss.
    OffroadTuning, OFFROAD:
    alarm: f64 = ALARM_OFFROAD,
        "Score from which there is an alarm, and that an identified candidate must have itself.",
        "what 19 of 20 fault-free simulations stay below, by construction";
    gain: f64 = 30.0,
        "Least gain of the joint fit with the first cause.",
        "no measurement is on record";
    further_gain: f64 = 50.0,
        "Least gain of every further cause.",
        "the prototype's advice after its study of two effects";
    further_share: f64 = 0.05,
        "Least gain of every further cause as a share of the first one's.",
        "the prototype's advice after its study of two effects: what the first is not exact by";
    held_out: f64 = 0.5,
        "Share of its gain that a cause keeps on manoeuvres that it was not fitted to.",
        "no measurement is on record";
    equivalent: f64 = 0.8,
        "Share of the best gain from which a candidate is an equivalent.",
        "as on the road";
    independent: f64 = 0.3,
        "Share of its gain that a rival keeps beside the identified one if it is a cause of its own.",
        "no measurement is on record";
    vague: f64 = 0.5,
        "Standard error of a frequency's logarithm from which it is not known.",
        "a factor of 2.7 between the ends of the 95 % interval and the value";
    small: f64 = 0.15,
        "Share of a usual size below which a force of the suspension is not worth reporting.",
        "what a bike file is usually known to";
}

/// The page of the book about the constants: every one with its value and its reason, and, where rides were
/// diagnosed with other values, their number and how many of their verdicts changed at two thirds and at
/// four thirds of each value on the road.
pub fn reference(changes: Option<(usize, &[[usize; 2]])>) -> String {
    let mut text = "# Constants of the identification\n\n\
        `cargo run --release --example constants -- --rides 20 > book/src/reference/constants.md` writes this \
        page. What each constant decides and what set it is declared beside it in `src/diagnose/tuning.rs`; \
        the prototype is that of [Diagnosis](../diagnosis.md), section 3.1. Scores are in units of what 19 of 20 \
        fault-free simulations stay below, gains are falls of twice the loss.\n"
        .to_owned();
    text += "\n## On the road\n\n";
    match changes {
        Some((rides, _)) => {
            text += &format!(
                "The last two columns count the verdicts, of all candidates on {rides} simulated rides, that are \
             others at two thirds and at four thirds of the value.\n\n| constant | value | decides | set by \
             | x 2/3 | x 4/3 |\n|---|---|---|---|---|---|\n"
            )
        }
        None => text += "| constant | value | decides | set by |\n|---|---|---|---|\n",
    }
    for (k, constant) in ROAD.iter().enumerate() {
        text += &row(constant, &RoadTuning::default());
        text += &match changes {
            Some((_, changes)) => format!(" {} | {} |\n", changes[k][0], changes[k][1]),
            None => "\n".to_owned(),
        };
    }
    text += "\n## Off-road\n\n| constant | value | decides | set by |\n|---|---|---|---|\n";
    for constant in OFFROAD {
        text += &row(constant, &OffroadTuning::default());
        text += "\n";
    }
    text
}

/// A constant's cells of its line in [`reference()`].
pub fn row<T>(constant: &Constant<T>, tuning: &T) -> String {
    let Constant { name, words, reason, get, .. } = constant;
    format!("| `{name}` | {} | {words} | {reason} |", get(tuning))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_constant_is_read_and_put_by_its_name() {
        let mut road = RoadTuning::default();
        for constant in ROAD {
            let value = (constant.get)(&road);
            assert!(value > 0.0 && constant.reason.len() > 10, "{}", constant.name);
            (constant.set)(&mut road, value + 1.0);
            assert_eq!((constant.get)(&road), value + 1.0, "{}", constant.name);
        }
        assert!(OFFROAD.iter().all(|c| (c.get)(&OffroadTuning::default()) > 0.0));
    }
}
