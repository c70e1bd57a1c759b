//! Kinds of events between the sessions of a bike: names in the table `fleet_events`, and words on
//! the fleet's page.

use super::bike::Axle;

/// Kind of an event of a bike.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum EventKind {
    /// Another tyre on one axle or on both.
    TyreSwap,
    /// The bike file was not this bike's, or had a wrong figure.
    BikeFile,
    /// A steady change over time.
    Drift,
    /// One or two sessions unlike the others.
    Outlier,
    /// Another level, for a reason that the coefficients do not show.
    Change,
}

impl EventKind {
    pub const ALL: [EventKind; 5] = [
        EventKind::TyreSwap,
        EventKind::BikeFile,
        EventKind::Drift,
        EventKind::Outlier,
        EventKind::Change,
    ];

    pub fn name(self) -> &'static str {
        match self {
            EventKind::TyreSwap => "tyre_swap",
            EventKind::BikeFile => "bike_file",
            EventKind::Drift => "drift",
            EventKind::Outlier => "outlier",
            EventKind::Change => "change",
        }
    }

    /// On pages, for counting: "2 tyre swaps".
    pub fn words(self) -> &'static str {
        match self {
            EventKind::TyreSwap => "tyre swap",
            EventKind::BikeFile => "wrong bike file",
            EventKind::Drift => "drift",
            EventKind::Outlier => "outlying session",
            EventKind::Change => "change",
        }
    }

    /// How the coefficients show it, as the column `reason` begins.
    pub fn evidence(self) -> &'static str {
        match self {
            EventKind::TyreSwap => "one axle has another level from here on: another tyre",
            EventKind::BikeFile => {
                "both axles or the drag moved together and no rolling radius, which the bike file cannot \
                 change: a wrong mass, wheelbase or centre of mass"
            }
            EventKind::Drift => "a steady change over time explains it better than any step",
            EventKind::Outlier => "unlike the bike's other sessions",
            EventKind::Change => "another level, but not as a tyre or a bike file would make it",
        }
    }

    /// The kind of a name in the tables; `None` of a name that this version does not know.
    pub fn from_name(name: &str) -> Option<Self> {
        EventKind::ALL.into_iter().find(|k| k.name() == name)
    }
}

/// The part of a bike whose coefficients an event moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Affected {
    Front,
    Rear,
    /// Those of both tyres.
    Both,
    Vehicle,
}

impl Affected {
    /// In the column `tyre` of `fleet_events`.
    pub fn name(self) -> &'static str {
        match self {
            Affected::Front => "front",
            Affected::Rear => "rear",
            Affected::Both => "both",
            Affected::Vehicle => "vehicle",
        }
    }

    /// The key of a changed tyre as a cause, in the column `cause` of `changes`: `tyre_swap_rear`, as an event has the kind
    /// `tyre_swap` and the tyre `rear`.
    pub fn swap_key(self) -> String {
        format!("{}_{}", EventKind::TyreSwap.name(), self.name())
    }

    /// The tyres of such a key; `None` of another cause.
    pub fn of_swap_key(key: &str) -> Option<Self> {
        [Affected::Front, Affected::Rear, Affected::Both].into_iter().find(|a| a.swap_key() == key)
    }

    /// The part of a name in the column `tyre` of `fleet_events`; `None` of one that this version does not know.
    pub fn from_name(name: &str) -> Option<Self> {
        [Affected::Front, Affected::Rear, Affected::Both, Affected::Vehicle]
            .into_iter()
            .find(|a| a.name() == name)
    }

    /// A changed tyre as a cause, as a main clause.
    pub fn swap_sentence(self) -> &'static str {
        match self {
            Affected::Front => "another front tyre was fitted",
            Affected::Rear => "another rear tyre was fitted",
            Affected::Both | Affected::Vehicle => "other tyres were fitted",
        }
    }

    /// A changed tyre in three words, for a chart.
    pub fn swap_label(self) -> &'static str {
        match self {
            Affected::Front => "front tyre changed",
            Affected::Rear => "rear tyre changed",
            Affected::Both | Affected::Vehicle => "tyres changed",
        }
    }

    /// Whether a tyre's coefficients are among them.
    pub fn includes(self, axle: Axle) -> bool {
        match self {
            Affected::Front => axle == Axle::Front,
            Affected::Rear => axle == Axle::Rear,
            Affected::Both => true,
            Affected::Vehicle => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back() {
        for kind in EventKind::ALL {
            assert_eq!(EventKind::from_name(kind.name()), Some(kind));
        }
        assert_eq!(EventKind::from_name("tyre swap"), None);
    }

    #[test]
    fn a_changed_tyre_has_one_key_in_both_tables() {
        let rear = Affected::of_swap_key("tyre_swap_rear");
        assert_eq!(rear.map(Affected::name), Some("rear"));
        assert_eq!(Affected::of_swap_key("tyre_swap_vehicle"), None);
        assert_eq!(Affected::of_swap_key("wind"), None);
        assert_eq!(Affected::from_name("both"), Some(Affected::Both));
    }
}
