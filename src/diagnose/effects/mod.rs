//! Physical effects that the base model leaves out, each with where it enters the world.
//!
//! Adding one is adding a file, its line in [`ALL`] and, where it needs a number of its own, a field of
//! [`World`](super::world::World) with its line in [`residuals`](super::residuals).

use super::world::Parameter;

mod brake_fade;
mod drag_height;
mod friction_load;
mod front_compliance;
mod latency;
mod lift;
mod radius_camber;
mod radius_load;
mod radius_speed;
mod relaxation_length;
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
mod velocity_lever_arm;
mod wheel_inertia;
mod wind;

/// A candidate cause.
#[derive(Debug, Clone, Copy)]
pub struct Effect {
    /// Name in the tables.
    pub name: &'static str,
    /// What it says happens.
    pub sentence: &'static str,
    /// Unit of its parameter.
    pub unit: &'static str,
    /// What it is hard to tell from, by the names of effects or base parameters.
    pub alike: &'static [&'static str],
    /// The riding or channel that tells them apart.
    pub separate_by: &'static str,
    /// Its number; the scale is its usual size.
    pub parameter: Parameter,
}

/// Every candidate.
pub const ALL: &[Effect] = &[
    road_grade::EFFECT,
    wind::EFFECT,
    wheel_inertia::EFFECT,
    rolling_speed::EFFECT,
    radius_speed::EFFECT,
    radius_camber::EFFECT,
    radius_load::EFFECT,
    brake_fade::EFFECT,
    steer_zero::EFFECT,
    roll_zero::EFFECT,
    road_bank::EFFECT,
    rider_lean::EFFECT,
    velocity_lever_arm::EFFECT,
    latency::EFFECT,
    side_force_ratio_front::EFFECT,
    side_force_ratio_rear::EFFECT,
    stiffness_load::EFFECT,
    twisting_stiffness::EFFECT,
    relaxation_length::EFFECT,
    front_compliance::EFFECT,
    friction_load::EFFECT,
    lift::EFFECT,
    drag_height::EFFECT,
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::world::BASE;

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
