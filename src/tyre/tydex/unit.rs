//! Units of channels, and how many SI units each is.

/// Quantity of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Quantity {
    /// rad.
    Angle,
    /// 1.
    Ratio,
    /// N.
    Force,
    /// N m.
    Moment,
    /// m.
    Length,
}

const DEGREE: f64 = std::f64::consts::PI / 180.0;

impl Quantity {
    /// Spellings, lower case without blanks, and the size of each in SI units.
    fn units(self) -> &'static [(&'static str, f64)] {
        match self {
            Quantity::Angle => &[
                ("rad", 1.0),
                ("mrad", 1e-3),
                ("deg", DEGREE),
                ("degree", DEGREE),
                ("degrees", DEGREE),
                ("°", DEGREE),
            ],
            Quantity::Ratio => &[
                ("-", 1.0),
                ("1", 1.0),
                ("none", 1.0),
                ("m/m", 1.0),
                ("%", 0.01),
                ("percent", 0.01),
            ],
            Quantity::Force => &[
                ("n", 1.0),
                ("newton", 1.0),
                ("kn", 1e3),
                ("dan", 10.0),
                ("kp", crate::GRAVITY),
                ("kgf", crate::GRAVITY),
                ("lbf", 4.448_221_615_260_5),
                ("lb", 4.448_221_615_260_5),
            ],
            Quantity::Moment => &[
                ("nm", 1.0),
                ("n*m", 1.0),
                ("n-m", 1.0),
                ("n.m", 1.0),
                ("knm", 1e3),
                ("nmm", 1e-3),
                ("danm", 10.0),
                ("ftlb", 1.355_817_948_331_4),
                ("ft-lb", 1.355_817_948_331_4),
            ],
            Quantity::Length => &[("m", 1.0), ("meter", 1.0), ("mm", 1e-3), ("cm", 1e-2)],
        }
    }

    /// SI units in one of a unit; the format's own (SI) where none is given.
    pub(crate) fn factor(self, unit: &str) -> Option<f64> {
        let plain = unit.trim_matches(['[', ']', '(', ')']);
        let plain: String = plain.chars().filter(|c| !c.is_whitespace()).collect();
        let plain = plain.to_lowercase();
        if plain.is_empty() {
            return Some(1.0);
        }
        self.units().iter().find(|(name, _)| *name == plain).map(|(_, factor)| *factor)
    }

    /// The units that are read, for a message.
    pub(crate) fn known(self) -> String {
        let names: Vec<&str> = self.units().iter().map(|(name, _)| *name).collect();
        names.join(", ")
    }
}
