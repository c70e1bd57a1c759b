//! A comparison in words.

use crate::contract::coefficient::Coefficient as C;
use crate::contract::status::Status;
use crate::fleet::compare::{Difference, Verdict};
use crate::statistics::number_format::{count, decimals, fixed};

/// Status of a coefficient in a session's row of `coefficients`.
#[derive(Debug, Clone)]
pub(super) struct RowStatus {
    pub(super) status: Status,
    pub(super) unit: String,
}

/// A coefficient in a few words, as a noun.
pub(crate) fn noun(coefficient: &str) -> &str {
    C::from_name(coefficient).map_or(coefficient, |c| c.spec().short)
}

/// Coefficients of which there is more or less.
const AMOUNTS: [C; 7] = [
    C::Drag,
    C::RollingResistance,
    C::MfD,
    C::LateralFrictionCt,
    C::CorneringStiffness0,
    C::CamberStiffness0,
    C::SlipStiffness,
];

/// A change as per cent with two significant digits, one at least before the point.
pub(crate) fn percent(share: f64) -> String {
    let per_cent = 100.0 * share;
    match per_cent.abs() {
        size if size >= 9.95 => fixed(per_cent, 0),
        size if size >= 0.095 => fixed(per_cent, 1),
        _ => fixed(per_cent, 2),
    }
}

/// Sentence on the difference of a coefficient.
pub(super) fn sentence(tyre: &str, coefficient: &str, unit: &str, found: &Difference) -> String {
    let name = noun(coefficient);
    let (who, whose) = match tyre {
        "vehicle" => ("B".to_owned(), String::new()),
        tyre => (format!("The {tyre} tyre of B"), format!(" of the {tyre} tyre")),
    };
    let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
    let places = decimals((found.interval[1] - found.interval[0]) / 4.0);
    let (size, ends) = match found.relative {
        Some([y, low, high]) => {
            (format!("{} %", percent(y.abs())), format!("{} to {} %", percent(low), percent(high)))
        }
        None => (
            format!("{}{unit}", fixed(found.size.abs(), places)),
            format!(
                "{} to {}{unit}",
                fixed(found.interval[0], places),
                fixed(found.interval[1], places)
            ),
        ),
    };
    match found.verdict() {
        Verdict::Larger | Verdict::Smaller => {
            let is_more = found.size > 0.0;
            match AMOUNTS.iter().any(|c| c.name() == coefficient) {
                true => {
                    let way = if is_more { "more" } else { "less" };
                    format!("{who} has {size} {way} {name} (95 %: {ends}).")
                }
                false => {
                    let way = if is_more { "larger" } else { "smaller" };
                    format!("{who}: {name} {size} {way} (95 %: {ends}).")
                }
            }
        }
        _ => format!("No difference in {name}{whose} is seen (95 %: {ends})."),
    }
}

/// Why a coefficient cannot be compared.
pub(super) fn not_comparable(known: &[Vec<RowStatus>; 2]) -> String {
    let side = |name: &str, rows: &[RowStatus]| {
        if rows.iter().any(|t| t.status == Status::Ok) {
            return format!("{name}: determined");
        }
        let of = |status: Status| rows.iter().filter(|t| t.status == status).count();
        let parts = [
            (Status::PoorlyDetermined, "poorly determined"),
            (Status::LowerBound, "bounded from below"),
            (Status::Assumed, "assumed"),
            (Status::NotAvailable, "not available"),
        ];
        let parts: Vec<String> = parts
            .iter()
            .filter(|(status, _)| of(*status) > 0)
            .map(|(status, words)| format!("{words} in {}", count(of(*status), "session")))
            .collect();
        match parts.is_empty() {
            true => format!("{name}: no session has it"),
            false => format!("{name}: {}", parts.join(", ")),
        }
    };
    format!("{}; {}.", side("A", &known[0]), side("B", &known[1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(size: f64, half: f64, is_relative: bool) -> Difference {
        Difference {
            size,
            interval: [size - half, size + half],
            relative: is_relative.then_some([size, size - half, size + half]),
            probability: 0.5,
            false_discovery: 0.5,
            between: 0.01,
            is_assumed: true,
            cancelled: 0.5,
            limited_by: ("rides".into(), 0.6),
            more_for_seen: None,
            more_for_worth: None,
        }
    }

    #[test]
    fn sentences_say_who_has_how_much_more_of_what() {
        assert_eq!(
            sentence("rear", "mf_d", "1", &found(0.08, 0.05, true)),
            "The rear tyre of B has 8.0 % more peak friction (95 %: 3.0 to 13 %)."
        );
        assert_eq!(
            sentence("vehicle", "drag", "kg/m", &found(-0.02, 0.05, true)),
            "No difference in aerodynamic drag is seen (95 %: -7.0 to 3.0 %)."
        );
        assert_eq!(
            sentence("front", "slip_camber_c1", "1", &found(-0.02, 0.01, false)),
            "The front tyre of B: slip/camber, linear 0.0200 smaller (95 %: -0.0300 to -0.0100)."
        );
    }

    #[test]
    fn what_cannot_be_compared_says_why() {
        let rows = |status| RowStatus { status, unit: String::new() };
        let known = [
            vec![rows(Status::PoorlyDetermined), rows(Status::PoorlyDetermined)],
            vec![rows(Status::Ok)],
        ];
        let said = not_comparable(&known);
        assert_eq!(said, "A: poorly determined in 2 sessions; B: determined.");
    }
}
