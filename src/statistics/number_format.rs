//! Number formats: as many digits as the uncertainty leaves meaning.

use crate::statistics::order::{SD_PER_MAD, median_of_finite};

/// Decimals that show an uncertainty with two significant digits.
pub(crate) fn decimals(uncertainty: f64) -> usize {
    if !(uncertainty > 0.0 && uncertainty.is_finite()) {
        return 4;
    }
    let exponent = uncertainty.log10().floor();
    // 0.0996 shown with two digits is 0.10: one decimal less than its exponent says
    let exponent =
        if uncertainty / 10f64.powf(exponent) >= 9.95 { exponent + 1.0 } else { exponent };
    (1.0 - exponent).clamp(0.0, 12.0) as usize
}

/// Decimals for a value: by its uncertainty, else for four significant digits.
pub(crate) fn decimals_of(value: f64, uncertainty: Option<f64>) -> usize {
    match uncertainty {
        Some(u) if u > 0.0 && u.is_finite() => decimals(u),
        _ if value == 0.0 => 1,
        _ => (3.0 - value.abs().log10().floor()).clamp(0.0, 12.0) as usize,
    }
}

/// A number with that many decimals; never a negative zero; scientific where plain figures
/// would be unreadable.
pub(crate) fn fixed(value: f64, decimals: usize) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    if value.abs() >= 1e7 || decimals > 8 && value != 0.0 {
        return format!("{value:.2e}");
    }
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        _ => text,
    }
}

/// A number with four significant digits.
pub(crate) fn short(value: f64) -> String {
    fixed(value, decimals_of(value, None))
}

/// A number's text with the typographic minus (U+2212), for pages.
pub(crate) fn typeset(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// The same for a sentence, where a hyphen may belong to a word or a name: before a digit and after a space or bracket.
pub(crate) fn typeset_sentence(text: &str) -> String {
    let characters: Vec<char> = text.chars().collect();
    let is_minus = |i: usize| {
        let before = i.checked_sub(1).map(|k| characters[k]);
        let after = characters.get(i + 1);
        characters[i] == '-'
            && before.is_none_or(|c| c == ' ' || c == '(')
            && after.is_some_and(char::is_ascii_digit)
    };
    (0..characters.len()).map(|i| if is_minus(i) { '\u{2212}' } else { characters[i] }).collect()
}

/// Rounds to a number of decimals, for data written as JSON.
pub(crate) fn round(value: f64, decimals: usize) -> f64 {
    let scale = 10f64.powi(decimals as i32);
    let rounded = (value * scale).round() / scale;
    if rounded == 0.0 { 0.0 } else { rounded }
}

/// Half the width of an interval, or the standard error: what the digits go by.
pub(crate) fn uncertainty(
    std_error: Option<f64>,
    low: Option<f64>,
    high: Option<f64>,
) -> Option<f64> {
    let half = match (low, high) {
        (Some(low), Some(high)) => Some((high - low) / 4.0),
        _ => None,
    };
    std_error.or(half).filter(|u| *u > 0.0 && u.is_finite())
}

/// A duration: `42 s`, `12 min 31 s`, `1 h 2 min`.
pub(crate) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "-".to_owned();
    }
    let s = seconds.round() as i64;
    match s {
        0..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {} s", s / 60, s % 60),
        _ => format!("{} h {} min", s / 3600, s % 3600 / 60),
    }
}

/// An RFC 3339 time with a space for the `T`; anything else as it is.
pub(crate) fn timestamp(text: &str) -> String {
    match text.split_once('T') {
        Some((date, time)) if date.len() == 10 => format!("{date} {time}"),
        _ => text.to_owned(),
    }
}

/// `1 session`, `3 sessions`.
pub(crate) fn count(n: usize, what: &str) -> String {
    format!("{n} {what}{}", if n == 1 { "" } else { "s" })
}

/// Robust standard deviation, 1.4826 MAD; `None` of fewer than two.
pub(crate) fn robust_sd(values: &[f64]) -> Option<f64> {
    if values.len() < 2 {
        return None;
    }
    let centre = median_of_finite(values)?;
    let away: Vec<f64> = values.iter().map(|v| (v - centre).abs()).collect();
    median_of_finite(&away).map(|mad| SD_PER_MAD * mad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_follow_the_uncertainty() {
        // two significant digits of the uncertainty (GUM 7.2.6)
        for (value, u, shown) in [
            (12.4683, 0.31, "12.47"),
            (0.298_712, 0.000_42, "0.29871"),
            (1234.5, 120.0, "1234"), // Rust rounds half to even
            (-0.0001, 0.5, "0.00"),
            (0.123, 0.0999, "0.12"),
        ] {
            assert_eq!(fixed(value, decimals(u)), shown);
        }
        assert_eq!(fixed(0.034_567_8, decimals_of(0.034_567_8, None)), "0.03457");
        assert_eq!(fixed(f64::NAN, 3), "-");
    }

    #[test]
    fn a_spread_is_that_of_r() {
        // R: mad(c(1,2,4,8)) = 2.2239
        assert!((robust_sd(&[8.0, 1.0, 4.0, 2.0]).expect("four") - 2.2239).abs() < 1e-4);
        assert_eq!(robust_sd(&[1.0]), None);
    }

    #[test]
    fn durations_read_well() {
        assert_eq!(duration(42.04), "42.0 s");
        assert_eq!(duration(751.0), "12 min 31 s");
        assert_eq!(duration(3720.0), "1 h 2 min");
    }
}
