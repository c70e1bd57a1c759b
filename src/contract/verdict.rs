//! Verdicts of a diagnosis: each with its name in the table `causes` and its words on pages.

/// `effect` of the row of `causes` that says that no candidate explains what is wrong; its verdict is
/// [`Verdict::Unexplained`], and it is no candidate.
pub const UNEXPLAINED: &str = "unexplained";

/// Score that a cause needs on the road, in what 19 of 20 fault-free simulations stay below; what set it is in
/// `src/diagnose/tuning.rs`.
pub(crate) const ALARM_ROAD: f64 = 1.75;
/// The same off-road.
pub(crate) const ALARM_OFFROAD: f64 = 1.0;

/// Conclusion of a diagnosis about a candidate cause, or about all of them together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// The candidate is a cause.
    Named,
    /// The candidate, or another that the ride cannot tell from it, is a cause.
    Ambiguous,
    /// In the place of an ambiguous one; it is not in the model beside that.
    Alternative,
    /// The ride would show it, and nothing speaks for it.
    NotNeeded,
    /// The ride would not show it.
    NotIdentifiable,
    /// Of no candidate: something is wrong that none of them explains.
    Unexplained,
}

impl Verdict {
    /// All verdicts, in the order of the pages.
    pub const ALL: [Verdict; 6] = [
        Verdict::Named,
        Verdict::Ambiguous,
        Verdict::Alternative,
        Verdict::NotNeeded,
        Verdict::NotIdentifiable,
        Verdict::Unexplained,
    ];

    /// Value of the column `verdict`.
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Named => "named",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Alternative => "alternative",
            Verdict::NotNeeded => "not_needed",
            Verdict::NotIdentifiable => "not_identifiable",
            Verdict::Unexplained => UNEXPLAINED,
        }
    }

    /// Verdict as pages and terminal show it.
    pub fn words(self) -> &'static str {
        match self {
            Verdict::Named => "identified",
            Verdict::Ambiguous => "one of several",
            Verdict::Alternative => "one of several, instead",
            Verdict::NotNeeded => "not needed",
            Verdict::NotIdentifiable => "not visible in this ride",
            Verdict::Unexplained => "unexplained",
        }
    }

    /// The verdict of a name in the tables; `None` of a name that this version does not know.
    pub fn from_name(name: &str) -> Option<Self> {
        Verdict::ALL.into_iter().find(|v| v.name() == name)
    }

    /// Whether the candidate belongs to the model that explains the ride.
    pub fn is_cause(self) -> bool {
        matches!(self, Verdict::Named | Verdict::Ambiguous)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for verdict in Verdict::ALL {
            assert_eq!(Verdict::from_name(verdict.name()), Some(verdict));
        }
        assert_eq!(Verdict::from_name("not_yet"), None);
    }
}
