//! A change on a motorcycle as a sentence. Terminal, table `changes` and pages have it from here, and so do events of
//! coefficients: what differs, by how much, from which rides, why, or what else it can be.

use crate::statistics::number_format::{decimals, fixed};

/// The parts of the sentence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Parts<'a> {
    /// Difference: the key of an effect, or a quantity in words.
    pub what: &'a str,
    /// By how much, with unit and interval; empty where that is not known.
    pub size: &'a str,
    /// Which rides, as the column `rides` of the table `changes`.
    pub rides: &'a str,
    /// Number of rides that differ, and of those they are compared with.
    pub counts: [usize; 2],
    /// Cause, as a main clause; `None` where that is not known.
    pub cause: Option<&'a str>,
    /// Other causes that explain it as well.
    pub rivals: &'a [&'a str],
}

/// The sentence, without a full stop.
pub(crate) fn sentence(of: &Parts<'_>) -> String {
    let verb = if of.rides == "drift" { "drifts" } else { "differs" };
    let by = if of.size.is_empty() { String::new() } else { format!(" by {}", of.size) };
    let cause = match of.cause {
        Some(cause) => format!("as if {cause}"),
        None => "the cause is not known".to_owned(),
    };
    let text = format!("{} {verb}{by} {}, {cause}", of.what, from(of.rides, of.counts));
    match of.rivals.is_empty() {
        true => text,
        false => format!("{text}; or {}", of.rivals.join(", ")),
    }
}

/// From which rides a change is.
fn from(rides: &str, [inside, others]: [usize; 2]) -> String {
    let s = if others == 1 { "" } else { "s" };
    match rides {
        "since" => format!("from the {others} ride{s} before"),
        "drift" => format!("from the first to the last of {inside} rides"),
        "against" => format!("from the {others} ride{s} of the reference"),
        _ => format!("from the motorcycle's {others} other ride{s}"),
    }
}

/// A size with its interval and unit, each times a factor: `2.02 m/s (1.84 to 2.20)`, or `about 0.020` where there is no
/// interval. The unit has the blank before it.
pub(crate) fn size(value: f64, half_width: f64, (unit, factor): (&str, f64)) -> String {
    let [value, half_width] = [value, half_width].map(|x| x * factor);
    if !half_width.is_finite() {
        return format!("about {}{unit}", fixed(value, decimals(value.abs())));
    }
    let places = decimals(half_width);
    let [low, high] = [value - half_width, value + half_width].map(|x| fixed(x, places));
    format!("{}{unit} ({low} to {high})", fixed(value, places))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_pattern_says_what_by_how_much_from_which_rides_and_why() {
        let wind = Parts {
            what: "wind",
            size: "2.02 m/s (1.84 to 2.20)",
            rides: "ride",
            counts: [1, 9],
            cause: Some("a steady wind blows along the strip"),
            rivals: &["road_grade"],
        };
        assert_eq!(
            sentence(&wind),
            "wind differs by 2.02 m/s (1.84 to 2.20) from the motorcycle's 9 other rides, as if a steady wind blows along \
             the strip; or road_grade"
        );
        let unknown = Parts { rides: "since", counts: [4, 1], cause: None, rivals: &[], ..wind };
        assert!(sentence(&unknown).ends_with("from the 1 ride before, the cause is not known"));
        let drift = Parts { rides: "drift", counts: [6, 0], size: "", ..unknown };
        assert!(sentence(&drift).starts_with("wind drifts from the first to the last of 6 rides"));
    }

    #[test]
    fn a_size_has_the_digits_of_its_interval() {
        assert_eq!(size(-0.00628, 0.00196, ("°", 57.29578)), "-0.36° (-0.47 to -0.25)");
        assert_eq!(size(0.02, f64::INFINITY, ("", 1.0)), "about 0.020");
    }
}
