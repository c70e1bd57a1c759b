//! Physical effects that the base model leaves out: what each is, where it enters, what it takes to
//! see it and what it looks like.
//!
//! Adding one is adding a file and its line in [`ALL`]; a new way to enter the motion is a field of
//! [`ModelError`] with its formula, which the simulators and the residuals share.

use crate::contract::bike::Bike;
use crate::contract::channel::Channel;
use crate::contract::manoeuvre::ManoeuvreKind;
use crate::contract::session::Session;
use crate::diagnose::parameters::{Parameter, Place};
use model_error::ModelError;

mod brake_drag;
mod brake_fade;
mod drag_height;
pub mod extended_model;
pub mod extended_tyre;
mod friction_load;
mod front_compliance;
mod gyroscopic;
mod latency;
mod lift;
mod low_friction_patch;
pub mod model_error;
mod pneumatic_trail;
mod radius_camber;
mod radius_load;
mod radius_speed;
mod relaxation_length;
pub mod remove;
mod rider_lean;
mod road_bank;
mod road_grade;
mod roll_zero;
mod rolling_speed;
mod side_force_ratio_front;
mod side_force_ratio_rear;
mod steer_zero;
mod stiffness_load;
mod twisting_stiffness;
mod tyre_warm_up;
mod velocity_lever_arm;
mod wheel_inertia;
mod wind;

/// What an effect belongs to, and so what it should be the same for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// One ride.
    Session,
    /// A motorcycle: a part of it, or a sensor on it.
    Bike,
    /// A road.
    Site,
    /// A night of the fleet: the weather, a rider's day.
    Night,
    /// Everything.
    Fleet,
}

impl Level {
    /// As in the tables.
    pub fn name(self) -> &'static str {
        match self {
            Level::Session => "session",
            Level::Bike => "bike",
            Level::Site => "site",
            Level::Night => "night",
            Level::Fleet => "fleet",
        }
    }
}

/// A candidate cause.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// Name in the tables, and of its one number.
    pub name: &'static str,
    /// What it says happens.
    pub sentence: &'static str,
    /// Unit of its number.
    pub unit: &'static str,
    /// Its usual size: steps and priors are in it.
    pub typical: f64,
    /// What is physically believed.
    pub bounds: [f64; 2],
    /// Where that comes from.
    pub source: &'static str,
    /// Where it enters the model.
    pub enters: &'static str,
    /// Channels without which it cannot be seen.
    pub channels: &'static [Channel],
    /// Manoeuvres of which at least one kind must be there.
    pub kinds: &'static [ManoeuvreKind],
    /// What it is hard to tell from, by the names of effects or base parameters.
    pub alike: &'static [&'static str],
    /// The riding or channel that tells them apart.
    pub separate_by: &'static str,
    /// What it is usually the same for.
    pub level: Level,
    /// Reads its number.
    pub get: fn(&ModelError) -> f64,
    /// Puts it.
    pub set: fn(&mut ModelError, f64),
    /// Takes an effect of a size out of what was measured and assumed, so that the base model holds.
    /// `None` where that cannot be done without the tyre.
    pub undo: Option<fn(&mut Session, &mut Bike, f64)>,
}

/// Prior standard deviation of every effect, in usual sizes.
pub const PRIOR: f64 = 3.0;

impl Effect {
    /// As something that can be fitted.
    pub fn parameter(&self) -> Parameter {
        Parameter {
            name: self.name,
            scale: self.typical.abs(),
            prior: PRIOR,
            place: Place::ModelError(self.get, self.set),
        }
    }

    /// The effect of a name.
    ///
    /// # Errors
    /// A sentence with the nearest name.
    pub fn named(name: &str) -> Result<&'static Effect, String> {
        ALL.iter().find(|e| e.name == name).ok_or_else(|| {
            let near = crate::contract::schema::closest(name, ALL.iter().map(|e| e.name));
            let hint = near.map(|n| format!("; did you mean `{n}`?")).unwrap_or_default();
            format!("no effect is called `{name}`{hint}")
        })
    }

    /// Whether a size can be.
    pub fn possible(&self, value: f64) -> bool {
        (self.bounds[0]..=self.bounds[1]).contains(&value)
    }

    /// Whether the rides of a name or base parameter look like it.
    pub fn looks_like(&self, other: &str) -> bool {
        self.alike.contains(&other)
    }
}

/// Every candidate.
pub const ALL: &[Effect] = &[
    road_grade::EFFECT,
    wind::EFFECT,
    road_bank::EFFECT,
    low_friction_patch::EFFECT,
    wheel_inertia::EFFECT,
    rolling_speed::EFFECT,
    radius_speed::EFFECT,
    radius_camber::EFFECT,
    radius_load::EFFECT,
    brake_fade::EFFECT,
    brake_drag::EFFECT,
    steer_zero::EFFECT,
    roll_zero::EFFECT,
    velocity_lever_arm::EFFECT,
    latency::EFFECT,
    side_force_ratio_front::EFFECT,
    side_force_ratio_rear::EFFECT,
    stiffness_load::EFFECT,
    twisting_stiffness::EFFECT,
    pneumatic_trail::EFFECT,
    relaxation_length::EFFECT,
    front_compliance::EFFECT,
    rider_lean::EFFECT,
    friction_load::EFFECT,
    tyre_warm_up::EFFECT,
    lift::EFFECT,
    drag_height::EFFECT,
    gyroscopic::EFFECT,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::parameters::BASE;

    #[test]
    fn rivals_are_known_and_named_by_both() {
        for effect in ALL {
            for rival in effect.alike {
                let other = ALL.iter().find(|e| e.name == *rival);
                let base = BASE.iter().any(|p| p.name == *rival);
                assert!(base || other.is_some(), "{} names {rival}", effect.name);
                if let Some(other) = other {
                    assert!(
                        other.alike.contains(&effect.name),
                        "{rival} knows not {}",
                        effect.name
                    );
                }
            }
        }
    }
}
