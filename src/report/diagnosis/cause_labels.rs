//! Labels of a diagnosis: effects, channels, verdicts and sizes as people read them.

use std::f64::consts::PI;

use crate::contract::verdict::{UNEXPLAINED, Verdict};
use crate::report::{labels, readable};
use crate::simulate::effects::Effect;
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::CauseRow;

/// Sentence of an effect with a size, as a clause, and what it usually does where its size is not known; a
/// name that this version does not know is read as it stands.
pub(crate) fn effect(name: &str, size: Option<f64>) -> String {
    match Effect::named(name) {
        Ok(effect) => effect.sentence_of(size.unwrap_or(f64::NAN)).to_owned(),
        Err(_) if name == UNEXPLAINED => "something that is no candidate".to_owned(),
        Err(_) => labels::spaced(name),
    }
}

/// Sentence of an effect in a ride, whose rows may have its size.
pub(crate) fn effect_in(causes: &[CauseRow], name: &str) -> String {
    effect(name, causes.iter().find(|c| c.effect == name).and_then(|c| c.value))
}

/// A sentence with its first letter large.
pub(crate) fn sentence(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or(String::new(), |c| c.to_uppercase().chain(rest).collect())
}

/// A residual or a signal; the roll balance has the name of the roll but another unit.
pub(crate) fn channel(name: &str, unit: &str) -> String {
    match name {
        "force_x" => "force along the bike",
        "slip_front" => "front slip for its force",
        "slip_rear" => "rear slip for its force",
        "lateral_front" => "front slip angle for its force",
        "lateral_rear" => "rear slip angle for its force",
        "roll" if unit != "rad" => "roll balance",
        "kinematic_x" => "speed against forward acceleration",
        "kinematic_y" => "sideways speed against acceleration",
        "velocity_x" => "speed",
        "velocity_y" => "sideways speed",
        "acceleration_x" => "forward acceleration",
        "acceleration_y" => "sideways acceleration",
        "steer_angle" => "steering angle",
        "wheel_speed_front" => "front wheel speed",
        "wheel_speed_rear" => "rear wheel speed",
        other => return labels::spaced(other),
    }
    .to_owned()
}

/// Signals in which a residual's misfit shows, the nearest first.
pub(crate) fn signals_of(residual: &str) -> &'static [&'static str] {
    match residual {
        "force_x" => &["acceleration_x", "velocity_x"],
        "slip_front" => &["wheel_speed_front", "velocity_x"],
        "slip_rear" => &["wheel_speed_rear", "velocity_x"],
        "lateral_front" => &["steer_angle", "yaw_rate", "velocity_y"],
        "lateral_rear" => &["velocity_y", "yaw_rate"],
        "roll" => &["roll", "acceleration_y"],
        "kinematic_x" => &["velocity_x", "acceleration_x"],
        "kinematic_y" => &["velocity_y", "acceleration_y"],
        _ => &[],
    }
}

/// The unit in which people read an angle, and from SI to it.
pub(crate) fn readable(unit: &str) -> (String, f64) {
    match unit {
        "rad" => ("°".to_owned(), 180.0 / PI),
        other => (labels::unit(other), 1.0),
    }
}

/// A verdict in words; a name that this version does not know is read as it stands.
pub(crate) fn verdict(name: &str) -> String {
    Verdict::from_name(name).map_or_else(|| labels::spaced(name), |v| v.words().to_owned())
}

/// At which level a cause was found, where it is not the ride itself.
pub(crate) fn level(name: &str) -> String {
    match name {
        "" | "session" => String::new(),
        "bike" => "found over all rides of the bike".to_owned(),
        "site" => "found over all rides at the site".to_owned(),
        "night" => "found over all rides of the night".to_owned(),
        "fleet" => "found over the fleet".to_owned(),
        other => format!("found at the level {}", labels::spaced(other)),
    }
}

/// Value and 95 % interval in a person's unit, with as many digits as the interval's width leaves meaning; empty where there
/// is none.
pub(crate) fn size(row: &CauseRow) -> (String, String) {
    let Some(value) = row.value else { return (String::new(), String::new()) };
    let (unit, factor) = readable::unit(&row.effect, &row.unit);
    let [low, high] = [row.ci95_low, row.ci95_high].map(|end| end.map(|x| x * factor));
    let digits =
        number_format::decimals_of(value * factor, number_format::uncertainty(None, low, high));
    let with_unit = |text: String| typeset(&format!("{text}{unit}").replace(' ', "\u{a0}"));
    let interval = low.zip(high).map(|(low, high)| {
        format!("{} to {}", typeset(&fixed(low, digits)), with_unit(fixed(high, digits)))
    });
    (with_unit(fixed(value * factor, digits)), interval.unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_has_the_digits_of_its_interval() {
        let row = CauseRow {
            value: Some(-0.01234),
            ci95_low: Some(-0.0163),
            ci95_high: Some(-0.0083),
            unit: "rad".into(),
            ..CauseRow::default()
        };
        let (value, interval) = size(&row);
        assert_eq!(value, "−0.71°");
        assert_eq!(interval, "−0.93 to −0.48°");
        let row = CauseRow { unit: "s".into(), ..row };
        assert_eq!(size(&row), ("−12.3\u{a0}ms".to_owned(), "−16.3 to −8.3\u{a0}ms".to_owned()));
        assert_eq!(size(&CauseRow::default()), (String::new(), String::new()));
    }

    #[test]
    fn a_sentence_has_the_sign_of_the_size() {
        assert_eq!(effect("latency", Some(0.01)), "the velocity comes late");
        assert_eq!(effect("latency", Some(-0.01)), "the velocity comes early");
        // its usual size is negative
        assert!(effect("stiffness_load", Some(-0.1)).ends_with("falls with load"));
        assert!(effect("stiffness_load", Some(0.1)).ends_with("rises with load"));
        let row = CauseRow { effect: "lift".into(), value: Some(-0.1), ..CauseRow::default() };
        assert_eq!(effect_in(&[row], "lift"), "the air presses the bike down");
        assert_eq!(effect_in(&[], "lift"), "the air lifts the bike");
    }

    #[test]
    fn unknown_names_are_read_as_they_stand() {
        assert_eq!(effect("latency", None), "the velocity comes late");
        assert_eq!(effect("moon_phase", Some(1.0)), "moon phase");
        assert_eq!(verdict("not_yet"), "not yet");
        assert_eq!(channel("roll", "m/s2"), "roll balance");
        assert_eq!(channel("roll", "rad"), "roll");
        assert_eq!(sentence("é a"), "É a");
    }
}
