//! A coefficient's numbers as text, for pages, the terminal and exports.

use crate::statistics::number_format::{self, fixed};
use crate::store::tables::rows::Coefficient;

/// A coefficient's numbers with the digits its uncertainty leaves meaning.
pub(crate) struct CoefficientText {
    /// Estimate; empty where there is none.
    pub value: String,
    /// Standard error; empty where there is none.
    pub std_error: String,
    /// Ends of the interval; empty where there is none.
    pub ends: Option<(String, String)>,
    /// The lower end where there is no upper one.
    pub at_least: Option<String>,
    /// Robust spread between manoeuvres; empty where there is none.
    pub dispersion: String,
}

impl CoefficientText {
    pub(crate) fn of(c: &Coefficient) -> Self {
        let u = number_format::uncertainty(c.std_error, c.ci95_low, c.ci95_high);
        let digits = c.value.map_or(3, |v| number_format::decimals_of(v, u));
        CoefficientText {
            value: c.value.map(|v| fixed(v, digits)).unwrap_or_default(),
            std_error: c.std_error.map(|s| fixed(s, digits)).unwrap_or_default(),
            ends: c.ci95_low.zip(c.ci95_high).map(|(l, h)| (fixed(l, digits), fixed(h, digits))),
            at_least: c.ci95_low.filter(|_| c.ci95_high.is_none()).map(|l| fixed(l, 2)),
            dispersion: c.dispersion.map(|d| fixed(d, digits)).unwrap_or_default(),
        }
    }

    /// The interval as one text, its ends parted by `between`.
    pub(crate) fn interval(&self, between: &str) -> String {
        match (&self.ends, &self.at_least) {
            (Some((low, high)), _) => format!("{low}{between}{high}"),
            (None, Some(low)) => format!("at least {low}"),
            (None, None) => String::new(),
        }
    }
}
