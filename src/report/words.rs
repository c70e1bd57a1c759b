//! What the names of the contract are called when people read them.

use crate::tables::rows::Status;

/// A coefficient in words.
#[derive(Debug, Clone, Copy)]
pub struct Word {
    /// Name in the tables.
    pub name: &'static str,
    /// What it is called.
    pub words: &'static str,
    /// The riding that determines it.
    pub ride: &'static str,
}

const COAST: &str = "coasting in neutral on a straight, both directions, at two or more speeds";
const SLIP: &str = "hard straight-line braking and, for the rear, hard acceleration: several runs \
                    that reach well into the slip range";
const CORNER: &str = "steady cornering both ways, over as wide a range of lean as the road allows";
const OFFROAD: &str = "off-road: firm braking and drive on the ground, in several corners";
const BENCH: &str = "no riding manoeuvre: a tyre bench; until then it is taken from the bike file";

macro_rules! words {
    ($($name:literal, $words:literal, $ride:expr;)*) => {
        /// Every coefficient of the contract, in reading order.
        pub const WORDS: &[Word] = &[$(Word { name: $name, words: $words, ride: $ride }),*];
    };
}

words! {
    "effective_rolling_radius", "effective rolling radius", COAST;
    "peak_slip", "slip ratio at peak friction", SLIP;
    "mf_b", "Magic Formula B", SLIP;
    "mf_c", "Magic Formula C", SLIP;
    "mf_d", "Magic Formula D", SLIP;
    "mf_e1", "Magic Formula E, symmetric part", SLIP;
    "mf_e2", "Magic Formula E, braking/driving part", SLIP;
    "slip_camber_c1", "slip angle over camber, linear", CORNER;
    "slip_camber_c3", "slip angle over camber, cubic", CORNER;
    "lateral_friction_ct", "lateral friction over tan(camber)", CORNER;
    "cornering_stiffness_0", "cornering stiffness per load, upright", CORNER;
    "camber_stiffness_0", "camber stiffness per load, upright", CORNER;
    "side_force_ratio", "camber to cornering stiffness ratio", BENCH;
    "twisting_stiffness", "twisting stiffness per load", BENCH;
    "overturning_stiffness", "overturning stiffness (crown radius)", CORNER;
    "relaxation_length", "relaxation length", BENCH;
    "pneumatic_trail_0", "pneumatic trail at small slip", BENCH;
    "drag", "aerodynamic drag", COAST;
    "rolling_resistance", "rolling resistance", COAST;
    "engaged_friction_braking", "friction engaged by braking", OFFROAD;
    "engaged_friction_driving", "friction engaged by driving", OFFROAD;
}

/// Where the coefficient stands in reading order: front, rear, vehicle; names unknown to the
/// list come last, by name.
pub fn order(tyre: &str, coefficient: &str) -> (usize, String, usize, String) {
    let end = TYRES.iter().position(|t| *t == tyre).unwrap_or(TYRES.len());
    let place = WORDS.iter().position(|w| w.name == coefficient).unwrap_or(WORDS.len());
    (end, tyre.to_owned(), place, coefficient.to_owned())
}

/// The values of the column `tyre`, in reading order.
pub const TYRES: [&str; 3] = ["front", "rear", "vehicle"];

/// A coefficient's entry, if the contract knows the name.
pub fn word(coefficient: &str) -> Option<&'static Word> {
    WORDS.iter().find(|w| w.name == coefficient)
}

/// A coefficient in words, or its name where there are none.
pub fn coefficient(name: &str) -> &str {
    word(name).map_or(name, |w| w.words)
}

/// The heading over one tyre's coefficients.
pub fn tyre(name: &str) -> &str {
    match name {
        "front" => "Front tyre",
        "rear" => "Rear tyre",
        "vehicle" => "Vehicle",
        other => other,
    }
}

/// A status in words.
pub fn status(status: Status) -> &'static str {
    match status {
        Status::Ok => "determined",
        Status::Assumed => "assumed",
        Status::PoorlyDetermined => "poorly determined",
        Status::NotAvailable => "not available",
    }
}

/// A status as the tables write it.
pub fn status_code(status: Status) -> &'static str {
    match status {
        Status::Ok => "ok",
        Status::Assumed => "assumed",
        Status::PoorlyDetermined => "poorly_determined",
        Status::NotAvailable => "not_available",
    }
}

/// A sign that tells statuses apart without colour.
pub fn status_sign(status: Status) -> &'static str {
    match status {
        Status::Ok => "●",
        Status::Assumed => "◇",
        Status::PoorlyDetermined => "◐",
        Status::NotAvailable => "○",
    }
}

/// A snake-case name as words: `front_braking` is `front braking`.
pub fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

/// A unit as people write it; a pure number has none.
pub fn unit(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        other => other.replace("s2", "s²").replace("rad2", "rad²").replace("degC", "°C"),
    }
}

/// How many statuses of each kind, as a sentence without its full stop.
pub fn verdict(statuses: impl Iterator<Item = Status>) -> String {
    let (mut ok, mut assumed, mut poor, mut none) = (0, 0, 0, 0);
    for status in statuses {
        match status {
            Status::Ok => ok += 1,
            Status::Assumed => assumed += 1,
            Status::PoorlyDetermined => poor += 1,
            Status::NotAvailable => none += 1,
        }
    }
    let mut text = format!("{ok} of {} coefficients determined", ok + assumed + poor + none);
    for (count, what) in [
        (assumed, "assumed from the bike file"),
        (poor, "poorly determined"),
        (none, "not available"),
    ] {
        if count > 0 {
            text.push_str(&format!("; {count} {what}"));
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn verdict_counts_every_status_once() {
        let all = [Status::Ok, Status::Ok, Status::Assumed, Status::NotAvailable];
        assert_eq!(
            verdict(all.into_iter()),
            "2 of 4 coefficients determined; 1 assumed from the bike file; 1 not available"
        );
        assert_eq!(verdict(std::iter::empty()), "0 of 0 coefficients determined");
    }

    #[test]
    fn front_comes_before_rear_before_vehicle_before_the_unknown() {
        let mut keys = [
            order("vehicle", "drag"),
            order("front", "unheard_of"),
            order("sidecar", "mf_b"),
            order("rear", "mf_b"),
            order("front", "mf_c"),
            order("front", "mf_b"),
        ];
        keys.sort();
        let names: Vec<(&str, &str)> = keys.iter().map(|k| (k.1.as_str(), k.3.as_str())).collect();
        assert_eq!(
            names,
            [
                ("front", "mf_b"),
                ("front", "mf_c"),
                ("front", "unheard_of"),
                ("rear", "mf_b"),
                ("vehicle", "drag"),
                ("sidecar", "mf_b")
            ]
        );
    }
}
