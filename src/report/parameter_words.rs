//! Parameters of the nominal model of `diagnose`, and the coefficients of `run` that are the same quantity, in one set of words.

use crate::contract::coefficient::{Coefficient, Part};

/// Parameters of the nominal model as a rider calls them.
const PARAMETERS: &[(&str, &str)] = &[
    ("drag", "the aerodynamic drag"),
    ("rolling_resistance", "the rolling resistance"),
    ("brake_gain_front", "the front brake's torque per pressure"),
    ("brake_gain_rear", "the rear brake's torque per pressure"),
    ("radius_front", "the front rolling radius"),
    ("radius_rear", "the rear rolling radius"),
    ("mf_b_front", "the front slip stiffness factor"),
    ("mf_d_front", "the front peak friction"),
    ("mf_e1_front", "the shape of the front friction curve"),
    ("mf_b_rear", "the rear slip stiffness factor"),
    ("mf_d_rear", "the rear peak friction"),
    ("mf_e1_rear", "the shape of the rear friction curve"),
    ("mf_e2_rear", "the load dependence of the rear friction curve"),
    ("cornering_stiffness_front", "the front cornering stiffness"),
    ("stiffness_decay_front", "the loss of front cornering stiffness with camber"),
    ("cornering_stiffness_rear", "the rear cornering stiffness"),
    ("stiffness_decay_rear", "the loss of rear cornering stiffness with camber"),
    (
        "overturning_stiffness",
        "the height over which the motorcycle leans (crowns, place of the rider)",
    ),
    ("crown_ratio", "the crown radius of the tyres over their width"),
    ("deflection_share", "the share of a tyre's deflection by which it rolls shorter"),
    ("slip_stiffness_load", "the growth of the slip stiffness with load"),
    ("vertical_stiffness_front", "the front vertical stiffness"),
    ("dive_arm_front", "the motion of the front contact in a dive"),
    ("dive_arm_rear", "the motion of the rear contact in a dive"),
    ("pitch_gyration", "the pitch inertia"),
    ("roll_inertia", "the roll inertia"),
    ("roll_rate_term", "the lateral acceleration per roll rate"),
    ("yaw_rate_zero", "the zero of the yaw rate"),
    ("acceleration_y_zero", "the zero of the lateral acceleration"),
    ("acceleration_x_zero", "the zero of the longitudinal acceleration"),
    ("velocity_y_zero", "the zero of the lateral velocity"),
    ("attitude_scale", "the scale of the measured lean"),
    ("sag_front", "how far the front springs give"),
    ("sag_rear", "how far the rear springs give"),
    ("attitude_delay", "the delay of the measured lean"),
    ("velocity_height", "the height at which the lateral velocity is measured"),
    ("accelerometer_ahead", "how far ahead the accelerometer sits"),
    ("accelerometer_height", "the height of the accelerometer"),
    ("accelerometer_yaw", "how far the accelerometer is turned"),
];

/// Names of quantities that differ between the nominal model and the table `coefficients`, without the tyre.
const RENAMED: [(&str, &str); 2] =
    [("radius", "effective_rolling_radius"), ("cornering_stiffness", "cornering_stiffness_0")];

/// Beginnings of the names of parameters that people read as a share of their usual value.
const RELATIVE: [&str; 6] =
    ["drag", "rolling_resistance", "brake_gain", "mf_b", "mf_d", "vertical_stiffness"];

/// A parameter of the nominal model in words; its name where there are none.
pub(crate) fn parameter(name: &str) -> &str {
    PARAMETERS.iter().find(|(known, _)| *known == name).map_or(name, |(_, words)| words)
}

/// Whether people read a change of a parameter as a share of its usual value.
pub(crate) fn is_relative(name: &str) -> bool {
    RELATIVE.iter().any(|start| name.starts_with(start))
}

/// Whether the nominal model holds minus the logarithm of a parameter, so that its errors are even.
pub(crate) fn is_logarithm(name: &str) -> bool {
    name.starts_with("cornering_stiffness")
}

/// Tyre and name in the table `coefficients` of a parameter of the nominal model: `radius_front` is `front`,
/// `effective_rolling_radius`.
pub(crate) fn coefficient(parameter: &str) -> (&'static str, &str) {
    let of = |part: Part| Some((part, parameter.strip_suffix(part.name())?.strip_suffix('_')?));
    let (part, name) =
        of(Part::Front).or_else(|| of(Part::Rear)).unwrap_or((Part::Vehicle, parameter));
    let other = RENAMED.iter().find(|(own, _)| *own == name);
    (part.name(), other.map_or(name, |(_, coefficient)| coefficient))
}

/// A coefficient of a tyre in the words of the parameter that is the same quantity; in its own where there is none.
pub(crate) fn of_coefficient(tyre: &str, name: &str) -> String {
    let is_it = |known: &&(&str, &str)| coefficient(known.0) == (tyre, name);
    match PARAMETERS.iter().find(is_it) {
        Some((_, words)) => (*words).to_owned(),
        None => {
            let short = Coefficient::from_name(name).map_or(name, |c| c.spec().short);
            format!("the {tyre} {short}")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::coefficient::Id;

    #[test]
    fn one_quantity_has_one_name_whichever_command_says_it() {
        assert_eq!(coefficient("radius_front"), ("front", "effective_rolling_radius"));
        assert_eq!(coefficient("mf_d_rear"), ("rear", "mf_d"));
        assert_eq!(coefficient("drag"), ("vehicle", "drag"));
        assert_eq!(of_coefficient("rear", "mf_d"), parameter("mf_d_rear"));
        assert_eq!(of_coefficient("front", "mf_c"), "the front Magic Formula C");
        // the names on the right are those of the contract
        for name in ["radius_front", "cornering_stiffness_rear", "mf_b_front", "drag"] {
            let (tyre, coefficient) = coefficient(name);
            assert!(Id::from_names(tyre, coefficient).is_some(), "{name}");
        }
    }
}
