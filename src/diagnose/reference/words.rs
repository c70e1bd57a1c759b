//! Changes in words.

use super::difference::Difference;
use super::numbers::{History, Number};
use super::search::Change;
use super::sets::{Kind, Rides};
use crate::report::readable;
use crate::statistics::number_format::{decimals, fixed};
use crate::store::tables::changes::{head, is_change, place};
use crate::store::tables::rows::ChangeRow;

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
    ("cornering_stiffness_front", "the front cornering stiffness (minus its logarithm)"),
    ("stiffness_decay_front", "the loss of front cornering stiffness with camber"),
    ("cornering_stiffness_rear", "the rear cornering stiffness (minus its logarithm)"),
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

/// A parameter of the nominal model in words; its name where there are none.
pub(crate) fn parameter(name: &str) -> &str {
    PARAMETERS.iter().find(|(known, _)| *known == name).map_or(name, |(_, words)| words)
}

/// The unit that a number is read in, with the blank before it, and the factor to it. A share that is no effect's stays one:
/// per cent of it would be read as relative.
pub(crate) fn unit(number: &Number) -> (String, f64) {
    readable::unit(number.effect.map_or("", |effect| effect.name), &number.unit)
}

/// A size with its interval and unit: `2.02 m/s (1.84 to 2.20)`, or `about 0.020` where there is no interval.
pub(crate) fn size(value: f64, half_width: f64, (space, factor): (String, f64)) -> String {
    let [value, half_width] = [value, half_width].map(|x| x * factor);
    if !half_width.is_finite() {
        return format!("about {}{space}", fixed(value, decimals(value.abs())));
    }
    let places = decimals(half_width);
    let [low, high] = [value - half_width, value + half_width].map(|x| fixed(x, places));
    format!("{}{space} ({low} to {high})", fixed(value, places))
}

/// What changed, of each motorcycle that has rides enough: how many are as before, then each change. A motorcycle of which
/// nothing changed has one line. Nothing where none can be compared.
pub(crate) fn of_motorcycles(rows: &[ChangeRow]) -> String {
    let mut text = String::new();
    for rows in rows.chunk_by(|a, b| a.ident.bike_id == b.ident.bike_id) {
        let Some(head) = head(rows) else { continue };
        text += &format!("{}: {head}\n", rows[0].ident.bike_id);
        for row in rows.iter().filter(|r| is_change(r)) {
            text += &format!("  {}: {}\n", place(row), row.sentence);
        }
    }
    text
}

/// From which rides a change is.
fn from(rides: &Rides) -> String {
    let [inside, others] = rides.counts();
    match rides.kind {
        Kind::One | Kind::Common(_) => format!("from the motorcycle's {others} other rides"),
        Kind::Since => format!("from the {others} rides before"),
        Kind::Drift => format!("from the first to the last of {inside} rides"),
        Kind::Chosen => format!("from the {others} rides of the reference"),
    }
}

/// A change as a sentence.
pub(crate) fn sentence(history: &History, change: &Change) -> String {
    let number = &history.numbers[change.cause];
    let size = size(change.size, change.half_width, unit(number));
    let from = from(&change.rides);
    let differs = match change.rides.kind {
        Kind::Drift => "drifts",
        _ => "differs",
    };
    let text = match number.effect {
        Some(effect) => {
            let what = effect.sentence_of(change.size);
            format!("{} {differs} by {size} {from}, as if {what}", number.name)
        }
        None => {
            let what = parameter(&number.name);
            format!("{what} {differs} by {size} {from}, the cause is not known")
        }
    };
    let rivals: Vec<&str> =
        change.rivals.iter().map(|p| history.numbers[*p].name.as_str()).collect();
    match rivals.is_empty() {
        true => text,
        false => format!("{text}; or {}", rivals.join(", ")),
    }
}

/// A number that moved, by how much, and over its standard error: `radius_front 0.61 mm (t 7.3)`.
pub(crate) fn moved(number: &Number, by: Difference) -> String {
    let (unit, factor) = unit(number);
    let value = fixed(by.size * factor, decimals(by.error * factor));
    format!("{} {value}{unit} (t {:.1})", number.name, by.t())
}
