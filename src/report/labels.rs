//! Labels: the contract's names as people read them.

use crate::contract::coefficient::{Coefficient, Id, Part};
use crate::contract::reason::ReasonCode as Code;
use crate::store::tables::rows::{Coefficient as Row, Status};

/// Where the coefficient stands in reading order: front, rear, vehicle; names unknown to the
/// contract come last, by name.
pub(crate) fn order(tyre: &str, coefficient: &str) -> (usize, String, usize, String) {
    let part = Part::from_name(tyre).map_or(Part::ALL.len(), |p| p as usize);
    let place = Coefficient::from_name(coefficient).map_or(Coefficient::COUNT, |c| c as usize);
    (part, tyre.to_owned(), place, coefficient.to_owned())
}

/// A coefficient's term, or its name where there is none.
pub(crate) fn coefficient(name: &str) -> &str {
    match Coefficient::from_name(name) {
        // pages give the slip ratio: `as_read`
        Some(Coefficient::PeakSlip) => "slip ratio κ at peak friction (the key is σ = κ/(1 − κ))",
        Some(c) => c.spec().term,
        None => name,
    }
}

/// Why a coefficient is not determined, for who has its interval beside it.
pub(crate) fn why(row: &Row) -> Option<String> {
    let is_wide = row.reason_code.as_deref() == Some(Code::WideInterval.name());
    match row.advice.as_deref().filter(|_| is_wide) {
        Some(advice) => Some(format!("wide interval: {advice}")),
        None => row.why(),
    }
}

/// The riding that determines a coefficient, if the contract knows it.
pub fn riding(tyre: &str, coefficient: &str) -> Option<&'static str> {
    Id::from_names(tyre, coefficient).map(|id| id.requirement().riding.manoeuvres)
}

/// The heading over one tyre's coefficients.
pub(crate) fn tyre(name: &str) -> &str {
    match Part::from_name(name) {
        Some(Part::Front) => "Front tyre",
        Some(Part::Rear) => "Rear tyre",
        Some(Part::Vehicle) => "Vehicle",
        None => name,
    }
}

/// A snake-case name as words: `front_braking` is `front braking`.
pub(crate) fn spaced(name: &str) -> String {
    name.replace('_', " ")
}

/// A unit as people write it; a pure number has none.
pub(crate) fn unit(unit: &str) -> String {
    match unit {
        "1" => String::new(),
        other => other.replace("s2", "s²").replace("rad2", "rad²").replace("degC", "°C"),
    }
}

/// How many statuses of each kind, as a sentence without its full stop.
pub(crate) fn verdict(statuses: impl Iterator<Item = Status>) -> String {
    let (mut ok, mut assumed, mut bound, mut poor, mut none) = (0, 0, 0, 0, 0);
    for status in statuses {
        match status {
            Status::Ok => ok += 1,
            Status::Assumed => assumed += 1,
            Status::LowerBound => bound += 1,
            Status::PoorlyDetermined => poor += 1,
            Status::NotAvailable => none += 1,
        }
    }
    let mut text = {
        let all = ok + assumed + bound + poor + none;
        format!("{ok} of {all} coefficients determined")
    };
    for (count, what) in [
        (assumed, "assumed"),
        (bound, "bounded from below"),
        (poor, "poorly determined"),
        (none, "not available"),
    ] {
        if count > 0 {
            text.push_str(&format!("; {count} {what}"));
        }
    }
    text
}

/// Where the value of a row with status `assumed` is from, by its reason.
pub(crate) fn assumed(row: &Row) -> &'static str {
    let is_it = |code: &&Code| row.reason_code.as_deref() == Some(code.name());
    match Code::ALL.iter().find(is_it) {
        Some(Code::BikeFile) => "bike file",
        Some(Code::BikeFileDefault) => "usual value",
        Some(Code::BikeFileNarrowed) => "bike file or usual value, drawn to the ride",
        Some(Code::Rule) => "rule",
        Some(Code::OneSided) => "wheel not both braked and driven",
        _ => "not from this ride",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::reason::Reason;

    /// The ends stand beside it, with the digits that they have.
    #[test]
    fn the_reason_of_a_wide_interval_does_not_repeat_its_ends() {
        let mut row = Row::default();
        row.explain(Some(Reason::wide_interval(-423.3801, 468.6021).with_advice("brake")));
        assert_eq!(why(&row).as_deref(), Some("wide interval: brake"));
        row.explain(Some(Reason::new(Code::Short, "too short")));
        assert_eq!(why(&row).as_deref(), Some("too short"));
    }

    #[test]
    fn what_is_assumed_says_from_what() {
        let of = |code: Option<&str>| {
            assumed(&Row { reason_code: code.map(str::to_owned), ..Row::default() })
        };
        assert_eq!(of(Some("bike_file")), "bike file");
        for code in ["bike_file_default", "bike_file_narrowed", "rule", "one_sided"] {
            assert!(!["bike file", of(None)].contains(&of(Some(code))), "{code}");
        }
        assert_eq!([of(None), of(Some("of a later version"))], ["not from this ride"; 2]);
    }

    #[test]
    fn verdict_counts_every_status_once() {
        let all = [Status::Ok, Status::Ok, Status::Assumed, Status::NotAvailable];
        assert_eq!(
            verdict(all.into_iter()),
            "2 of 4 coefficients determined; 1 assumed; 1 not available"
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
