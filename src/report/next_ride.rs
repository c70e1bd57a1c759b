//! What to ride next: the one place that chooses and words it, for terminal and pages.

use crate::contract::coefficient::Id;
use crate::contract::reason::ReasonCode;
use crate::store::tables::rows::{Coefficient, Status};

/// Start of a sentence or heading with riding advice.
pub(crate) const TITLE: &str = "Next ride";

/// Half of an interval over its value from which more riding is advised although the value is determined.
const WIDE: f64 = 0.25;

/// Aim of the riding, the most urgent first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Want {
    /// A value; there is none that counts.
    Value,
    /// A log without the fault that refuses the value: no riding helps.
    SoundLog,
    /// A narrower interval of a value that is determined.
    NarrowerInterval,
}

/// Riding advice for a coefficient; none where the ride gave what rides give.
pub(crate) fn of(row: &Coefficient) -> Option<(Want, &str)> {
    if row.status == Status::Ok {
        let riding = Id::from_names(&row.tyre, &row.coefficient)?.requirement().riding.remedy;
        return is_wide(row).then_some((Want::NarrowerInterval, riding));
    }
    let advice = row.advice.as_deref()?;
    let refused = [ReasonCode::Impossible, ReasonCode::Contradicted].map(ReasonCode::name);
    let is_refused = row.reason_code.as_deref().is_some_and(|code| refused.contains(&code));
    Some((if is_refused { Want::SoundLog } else { Want::Value }, advice))
}

fn is_wide(row: &Coefficient) -> bool {
    let width = row.ci95_low.zip(row.ci95_high).map(|(low, high)| (high - low) / 2.0);
    width.zip(row.value).is_some_and(|(half, value)| half > WIDE * value.abs())
}

/// The sentence, without its full stop.
pub(crate) fn sentence(want: Want, what: &str, riding: &str) -> String {
    match want {
        Want::Value => format!("{TITLE}, for {what}: {riding}"),
        Want::SoundLog => format!("For {what}: {riding}"),
        Want::NarrowerInterval => format!("{TITLE}, for narrower intervals of {what}: {riding}"),
    }
}

/// Text in place of a value that is not determined: its status, and what to ride.
pub(crate) fn note(row: &Coefficient) -> String {
    let status = row.status.words();
    match of(row) {
        Some((Want::SoundLog, advice)) => format!("{status}: {advice}"),
        Some((_, riding)) => format!("{status}. {TITLE}: {riding}"),
        None => status.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::coefficient::{Coefficient as C, SLALOM};
    use crate::contract::reason::Reason;

    fn row(status: Status, ends: [f64; 2]) -> Coefficient {
        Coefficient {
            tyre: "front".into(),
            coefficient: C::CorneringStiffness0.name().into(),
            status,
            value: Some(10.0),
            ci95_low: Some(ends[0]),
            ci95_high: Some(ends[1]),
            ..Coefficient::default()
        }
    }

    /// What is determined within a quarter needs no riding; what is wider has the riding that would narrow it.
    #[test]
    fn a_determined_value_with_a_wide_interval_says_what_narrows_it() {
        assert_eq!(of(&row(Status::Ok, [8.0, 12.0])), None);
        assert_eq!(of(&row(Status::Ok, [6.0, 14.0])), Some((Want::NarrowerInterval, SLALOM)));
        assert_eq!(of(&row(Status::Assumed, [6.0, 14.0])), None);
        let said = sentence(Want::NarrowerInterval, "cornering stiffness", SLALOM);
        assert!(
            said.starts_with("Next ride, for narrower intervals of cornering stiffness: ride four")
        );
    }

    /// A log that contradicts itself is no reason to ride again.
    #[test]
    fn what_a_map_gets_wrong_no_ride_mends() {
        let mut refused = row(Status::NotAvailable, [0.0, 0.0]);
        refused.explain(Some(Reason::impossible("0.02 m is no radius".into())));
        let (want, advice) = of(&refused).expect("advice");
        assert_eq!(want, Want::SoundLog);
        assert!(!sentence(want, "rolling radius", advice).contains(TITLE));
        assert!(!note(&refused).contains(TITLE));
        let mut poor = row(Status::PoorlyDetermined, [1.0, 30.0]);
        poor.explain(Some(Reason::wide_interval(1.0, 30.0).with_advice("ride corners")));
        assert_eq!(note(&poor), "poorly determined. Next ride: ride corners");
    }
}
