//! Side force ratios on the fleet's page: each tyre's, or why it has none.

use std::collections::BTreeSet;

use crate::contract::coefficient::Coefficient;
use crate::report::labels;
use crate::statistics::number_format::{self, fixed, typeset};
use crate::store::tables::rows::{FleetRow, RatioRow, Status};

/// Tyres without a ratio that are listed; of more only the number is given.
const NAMED: usize = 10;

#[derive(Debug)]
#[allow(missing_docs)] // headings of the table in the template
pub(crate) struct Ratio {
    pub bike: String,
    pub tyre: String,
    pub sessions: i64,
    pub first: String,
    pub last: String,
    pub value: String,
    pub interval: String,
    pub stiffness: String,
    pub status: &'static str,
    pub status_label: &'static str,
    pub sign: &'static str,
    pub reason: String,
}

/// The ratios that there are, in the fleet's order, and a sentence on the tyres that have none; `None`
/// where no session determined the lateral friction that they are estimated from.
pub(crate) fn build(rows: &[RatioRow], fleet: &[FleetRow]) -> Option<(Vec<Ratio>, String)> {
    let had: BTreeSet<(&str, &str)> =
        rows.iter().map(|r| (r.bike_id.as_str(), r.tyre.as_str())).collect();
    let lacking: Vec<String> = fleet
        .iter()
        .filter(|r| r.coefficient == Coefficient::LateralFrictionCt.name() && r.n_sessions > 0)
        .map(|r| (r.bike_id.as_str(), r.tyre.as_str()))
        .filter(|tyre| !had.contains(tyre))
        .map(|(bike, tyre)| format!("{bike} {tyre}"))
        .collect();
    if rows.is_empty() && lacking.is_empty() {
        return None;
    }
    let none = match lacking.is_empty() {
        true => String::new(),
        false => format!(
            "Not available for {}: a line needs six sessions of one tyre that determine lateral friction and slip angle.",
            match lacking.len() {
                0..=NAMED => lacking.join(", "),
                n => format!("{} and {} more", lacking[..NAMED].join(", "), n - NAMED),
            }
        ),
    };
    Some((rows.iter().map(ratio).collect(), none))
}

fn ratio(row: &RatioRow) -> Ratio {
    let status = row.status;
    // a value whose interval is open means nothing
    let available = status != Status::NotAvailable;
    let ends = row.ci95_low.zip(row.ci95_high).filter(|_| available);
    let value = row.side_force_ratio.filter(|_| available);
    let digits = |v: f64| number_format::decimals_of(v, ends.map(|(low, high)| 0.5 * (high - low)));
    let show = |v: f64| typeset(&fixed(v, value.map_or(3, digits)));
    Ratio {
        bike: row.bike_id.clone(),
        tyre: labels::tyre(&row.tyre).to_owned(),
        sessions: row.n_sessions,
        first: row.first_session.clone(),
        last: row.last_session.clone(),
        value: value.map(show).unwrap_or_default(),
        interval: ends.map(|(l, h)| format!("{} to {}", show(l), show(h))).unwrap_or_default(),
        stiffness: row
            .cornering_stiffness_0
            .filter(|_| available)
            .map(|k| typeset(&fixed(k, number_format::decimals_of(k, Some(0.05 * k.abs())))))
            .unwrap_or_default(),
        status: status.name(),
        status_label: status.words(),
        sign: status.sign(),
        reason: row.why().unwrap_or_default(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(tyre: &str, status: Status, ends: Option<(f64, f64)>) -> RatioRow {
        RatioRow {
            bike_id: "b".into(),
            tyre: tyre.into(),
            n_sessions: 9,
            side_force_ratio: Some(0.0912),
            ci95_low: ends.map(|e| e.0),
            ci95_high: ends.map(|e| e.1),
            cornering_stiffness_0: Some(12.34),
            status,
            reason: (status != Status::Ok).then(|| "all ride alike".into()),
            ..RatioRow::default()
        }
    }

    #[test]
    fn a_ratio_has_its_interval_or_its_reason() {
        let rows = [
            row("front", Status::Ok, Some((0.081, 0.1014))),
            row("rear", Status::NotAvailable, None),
        ];
        let of = |bike: &str, tyre: &str, n_sessions| FleetRow {
            bike_id: bike.into(),
            tyre: tyre.into(),
            coefficient: "lateral_friction_ct".into(),
            n_sessions,
            ..FleetRow::default()
        };
        let fleet =
            [of("b", "front", 9), of("b", "rear", 9), of("c", "rear", 2), of("d", "rear", 0)];
        let (ratios, none) = build(&rows, &fleet).expect("ratios");
        assert_eq!(
            (ratios[0].value.as_str(), ratios[0].interval.as_str()),
            ("0.091", "0.081 to 0.101")
        );
        assert_eq!(ratios[0].status_label, "determined");
        assert_eq!((ratios[1].value.as_str(), ratios[1].interval.as_str()), ("", ""));
        assert_eq!(ratios[1].reason, "all ride alike");
        assert!(none.starts_with("Not available for c rear:"), "{none}");
        assert!(build(&[], &fleet[3..]).is_none());
    }
}
