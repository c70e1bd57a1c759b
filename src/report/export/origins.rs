//! Where each number of an exported tyre is from: fitted with its interval, assumed and from what, or a stand-in.
//!
//! A property file says it beside each number in its own words. Here it is for the files that have the tyre's own
//! numbers (C header, simulation unit, simulator) and for those that have forces made of them (look-up tables, TYDEX).

use super::ends::Ends;
use super::file::origin;
use super::fitted::Fitted;
use super::numbers;
use super::tyre::Characterised;
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::statistics::number_format::short;

/// Text about a number that the ride did not give, nor the bike file.
pub(crate) const STAND_IN: &str = "NOT AVAILABLE from this ride: a stand-in";

/// Quantities that follow from the numbers and has no place of its own in a file, with its unit.
const FOLLOWS: [(C, &str); 3] = [
    (C::CorneringStiffness0, " 1/rad"),
    (C::CamberStiffness0, " 1/rad"),
    (C::PneumaticTrail0, " m"),
];

/// Where a coefficient is from.
fn row(fitted: &Fitted, part: Part, coefficient: C) -> String {
    let found = fitted.value(part, coefficient);
    found.map_or_else(|_| STAND_IN.to_owned(), |(_, row)| origin(row))
}

/// Where a number of [`numbers::ALL`] is from; `None` of what is no number of the tyre (effects, ranges).
pub(crate) fn of(fitted: &Fitted, c: &Characterised, name: &str) -> Option<String> {
    let own = |coefficient: C| row(fitted, Part::from(c.axle), coefficient);
    let adjusted = |coefficient: C| match c.adjusted.is_some() {
        true => format!("{}; adjusted, see the head", own(coefficient)),
        false => own(coefficient),
    };
    Some(match name {
        "mf_b" => own(C::MfB),
        "mf_c" => own(C::MfC),
        "mf_d" => c.friction_note(&own(C::MfD)),
        "mf_e1" => own(C::MfE1),
        "mf_e2" => own(C::MfE2),
        "ct" => own(C::LateralFrictionCt),
        "c1" => adjusted(C::SlipCamberC1),
        "c3" => adjusted(C::SlipCamberC3),
        "side_force_ratio" => {
            let note = c.noted(&own(C::SideForceRatio), "side_force_ratio_front");
            c.noted(&note, "side_force_ratio_rear")
        }
        "twisting_stiffness" => c.noted(&own(C::TwistingStiffness), "twisting_stiffness"),
        "overturning_stiffness" => own(C::OverturningStiffness),
        "rolling_radius" => own(C::EffectiveRollingRadius),
        "rolling_resistance" => match fitted.value(Part::Vehicle, C::RollingResistance) {
            Ok((_, row)) => origin(row),
            Err(_) => c.rolling_from.to_owned(),
        },
        "relaxation_length" => c.noted(&own(C::RelaxationLength), "relaxation_length"),
        "nominal_load" => "assumed: static load from the bike file".to_owned(),
        "slip_stiffness_load" => own(C::SlipStiffnessLoad),
        "vertical_stiffness" => c.vertical_from.to_owned(),
        "camber_force_decay" | "camber_moment_decay" => {
            "assumed: bike file, or 1, which leaves the tangent of camber as it is".to_owned()
        }
        "reference_friction" => "set: --friction".to_owned(),
        // pages and terminal have the slip ratio
        "peak_slip" => format!("{}; sigma = kappa/(1 - kappa)", own(C::PeakSlip)),
        "lateral_peak" => {
            "not reached: the largest side force over load that was ridden".to_owned()
        }
        "deflection_share" => c.share_from.to_owned(),
        _ => return None,
    })
}

/// Lines of a file about the numbers that its forces are made of, one line each, and of what was ridden.
pub(crate) fn lines(fitted: &Fitted, c: &Characterised) -> Vec<String> {
    let (axle, ends) = (c.axle.name(), Ends::of(c));
    let says = |name: &str, value: f64, unit: &str, from: &str| {
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        format!("{axle}: {name} {}{unit} ({from})", short(value))
    };
    let own = |number: &numbers::Number| {
        let from = of(fitted, c, number.name)?;
        Some(says(number.name, (number.value)(c, &ends), number.unit, &from))
    };
    let mut out: Vec<String> = numbers::ALL.iter().filter_map(own).collect();
    out.extend(following(fitted, c));
    out.push(ridden(c));
    out
}

/// The same of what follows from the numbers: the stiffnesses and the trail.
pub(crate) fn following(fitted: &Fitted, c: &Characterised) -> Vec<String> {
    let line = |(coefficient, unit): (C, &str)| {
        let (value, row) = fitted.value(c.axle, coefficient).ok()?;
        Some(format!("{}: {coefficient} {}{unit} ({})", c.axle.name(), short(value), origin(row)))
    };
    FOLLOWS.into_iter().filter_map(line).collect()
}

/// Ridden ranges of a tyre: each by itself, not all of them at once.
pub(crate) fn ridden(c: &Characterised) -> String {
    let r = &c.ranges;
    let of = |name: &str, range: Option<[f64; 2]>, unit: &str| match range {
        Some([low, high]) => format!("{name} {} to {}{unit}", short(low), short(high)),
        None => format!("no {name}"),
    };
    let [low, high] = c.loads;
    format!(
        "{}: ridden, each by itself: {}, {}, {}, load {low:.0} to {high:.0} N",
        c.axle.name(),
        of("slip ratio", r.slip_ratio, ""),
        of("slip angle", r.slip_angle, " rad"),
        of("camber", r.camber, " rad"),
    )
}
