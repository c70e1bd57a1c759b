//! Physical effects that the nominal model leaves out: what each is, its formula, what it takes to identify
//! it and what it is confounded with.
//!
//! An effect is a file and its line in the list below. The file implements [`Physics`]: words, unit,
//! prior and bounds, and a function at each place where the effect acts. Residuals and both simulators
//! call the functions of the same names of [`ModelError`], which go over all effects; none of them knows
//! one by name.

use std::ops::Deref;

use crate::contract::bike::Axle;
use crate::contract::key_error::KeyError;
use crate::contract::schema::closest;
use crate::contract::session::Session;
use model_error::{Step, compose, effects};
use physics::{Multibody, Physics, Reach, Remove, Rolling, hooks};
use ride::BrakeHistory;
pub(crate) use spec::{EffectSpec, Level, SessionRef};

mod brake_drag;
mod brake_fade;
pub(crate) mod composed;
mod drag_height;
pub(crate) mod extended_model;
pub(crate) mod extended_tyre;
mod friction_load;
mod front_brake_drag;
mod front_compliance;
mod gyroscopic;
mod latency;
mod lift;
mod low_friction_patch;
mod model_error;
pub(crate) mod models;
mod pad_heat;
pub(crate) mod physics;
mod pneumatic_trail;
pub(crate) mod pooled_effects;
mod radius_camber;
mod radius_load;
mod radius_speed;
mod relaxation_length;
pub(crate) mod remove;
pub(crate) mod ride;
mod rider_lean;
mod road_bank;
mod road_grade;
mod roll_zero;
mod rolling_speed;
mod side_force_ratio_front;
mod side_force_ratio_rear;
pub(crate) mod spec;
mod steer_zero;
mod stiffness_load;
mod twisting_stiffness;
pub(crate) mod tyre_file;
mod tyre_warm_up;
mod velocity_lever_arm;
mod wheel_inertia;
mod wind;

effects! {
    road_grade::RoadGrade,
    wind::Wind,
    road_bank::RoadBank,
    low_friction_patch::LowFrictionPatch,
    wheel_inertia::WheelInertia,
    rolling_speed::RollingSpeed,
    radius_speed::RadiusSpeed,
    radius_camber::RadiusCamber,
    radius_load::RadiusLoad,
    brake_fade::BrakeFade,
    pad_heat::PadHeat,
    brake_drag::BrakeDrag,
    front_brake_drag::FrontBrakeDrag,
    steer_zero::SteerZero,
    roll_zero::RollZero,
    velocity_lever_arm::VelocityLeverArm,
    latency::Latency,
    side_force_ratio_front::SideForceRatioFront,
    side_force_ratio_rear::SideForceRatioRear,
    stiffness_load::StiffnessLoad,
    twisting_stiffness::TwistingStiffness,
    pneumatic_trail::PneumaticTrail,
    relaxation_length::RelaxationLength,
    front_compliance::FrontCompliance,
    rider_lean::RiderLean,
    friction_load::FrictionLoad,
    tyre_warm_up::TyreWarmUp,
    lift::Lift,
    drag_height::DragHeight,
    gyroscopic::Gyroscopic,
}

hooks!(compose);

/// A candidate cause: an effect as data. Its formula is in its [`Physics`].
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// Name in the tables, of its one number too: the name of its file.
    pub name: &'static str,
    /// Declaration of its file.
    pub spec: EffectSpec,
    /// Where the multibody motorcycle has it from.
    pub multibody: Multibody,
    /// Reads its size.
    pub get: fn(&ModelError) -> f64,
    /// Puts its size.
    pub set: fn(&mut ModelError, f64),
    /// Takes an effect of a size out of what was measured and assumed, so that the nominal model holds.
    /// `None` where that cannot be done without the tyre.
    pub remove: Option<Remove>,
    /// Tyres of whose it is; none where it is not the tyres'.
    pub tyres: &'static [Axle],
    /// Parts of the model that it acts on.
    pub reach: Reach,
    /// Whether people read a size of unit 1 in per cent.
    pub in_per_cent: bool,
}

/// The fields of the declaration are read as the effect's own.
impl Deref for Effect {
    type Target = EffectSpec;

    fn deref(&self) -> &EffectSpec {
        &self.spec
    }
}

/// Prior standard deviation of every effect, in usual sizes.
pub(crate) const PRIOR: f64 = 3.0;

impl Effect {
    /// The effect of a name.
    ///
    /// # Errors
    /// Error text with the nearest name.
    pub fn named(name: &str) -> Result<&'static Effect, KeyError> {
        ALL.iter().find(|e| e.name == name).ok_or_else(|| {
            let near = closest(name, ALL.iter().map(|e| e.name));
            let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            KeyError::Values(format!("no effect is called `{name}`{hint}"))
        })
    }

    /// Whether a size is physically plausible.
    pub fn in_bounds(&self, size: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&size)
    }

    /// Checks a size that somebody wrote down.
    ///
    /// # Errors
    /// It is not physically plausible; the sentence has the bounds.
    pub fn check_size(&self, size: f64) -> Result<(), KeyError> {
        let [low, high] = self.bounds;
        match self.in_bounds(size) {
            true => Ok(()),
            false => Err(KeyError::Values(format!(
                "{size} {} is not between {low} and {high}",
                self.unit
            ))),
        }
    }

    /// Whether it is an error of a tyre's own numbers.
    pub fn is_number(&self) -> bool {
        let mut error = ModelError::default();
        (self.set)(&mut error, self.typical);
        Axle::BOTH.iter().any(|axle| error.changes_numbers(*axle))
    }

    /// Effects and base parameters that change a ride alike: those that this effect declares, then
    /// the effects that declare this one.
    pub fn confusions(&self) -> impl Iterator<Item = &'static str> {
        let own = self.spec.confounded_with;
        let name = self.name;
        let others = ALL
            .iter()
            .filter(move |e| e.spec.confounded_with.contains(&name) && !own.contains(&e.name));
        own.iter().copied().chain(others.map(|e| e.name))
    }

    /// Whether an effect or base parameter of a name changes a ride alike.
    pub fn is_confounded_with(&self, other: &str) -> bool {
        self.confusions().any(|name| name == other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_of_two_effects_declares_that_they_are_confounded_and_both_know_it() {
        for effect in ALL {
            for rival in effect.confounded_with {
                assert!(effect.is_confounded_with(rival));
                if let Some(other) = ALL.iter().find(|e| e.name == *rival) {
                    assert!(
                        !other.confounded_with.contains(&effect.name),
                        "{rival} declares it too"
                    );
                    assert!(other.is_confounded_with(effect.name));
                }
            }
        }
    }

    /// Effects of which one sentence is true with either sign: zeros and numbers that are not the assumed
    /// ones, and what has only a direction against the first straight's.
    const NEUTRAL: [&str; 9] = [
        "wind",
        "road_bank",
        "steer_zero",
        "roll_zero",
        "velocity_lever_arm",
        "side_force_ratio_front",
        "side_force_ratio_rear",
        "twisting_stiffness",
        "pneumatic_trail",
    ];

    #[test]
    fn the_sentence_of_a_size_has_its_sign() {
        for effect in ALL {
            let neutral = NEUTRAL.contains(&effect.name);
            assert_eq!(effect.sentence == effect.opposite, neutral, "{}", effect.name);
            assert_eq!(effect.sentence_of(effect.typical), effect.sentence);
            assert_eq!(effect.sentence_of(-effect.typical), effect.opposite);
            assert_eq!(effect.sentence_of(f64::NAN), effect.sentence);
        }
    }

    /// What is added to a ratio of the bike file; every other size of unit 1 is a share or a slope.
    #[test]
    fn sizes_that_are_added_to_a_ratio_are_not_read_in_per_cent() {
        let plain: Vec<&str> = ALL.iter().filter(|e| !e.in_per_cent).map(|e| e.name).collect();
        assert_eq!(plain, ["side_force_ratio_front", "side_force_ratio_rear"]);
        assert!(ALL.iter().all(|e| e.in_per_cent || e.unit == "1"));
    }

    #[test]
    fn sizes_are_read_and_put_by_name() {
        for effect in ALL {
            let mut error = ModelError::default();
            (effect.set)(&mut error, effect.typical);
            assert_eq!((effect.get)(&error), effect.typical);
            assert!(ALL.iter().filter(|e| (e.get)(&error) != 0.0).count() == 1);
            assert!(effect.in_bounds(effect.typical), "{}", effect.name);
        }
    }
}
