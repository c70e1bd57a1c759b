//! What the name of a position's column says of its notation.

use super::coordinate::Form;

/// Degrees of one unit of Garmin's positions.
pub(super) const SEMICIRCLE: f64 = 180.0 / 2_147_483_648.0;

/// A text's words in lower case: letters and digits without anything else between.
pub(super) fn tokens(name: &str) -> Vec<String> {
    let words = name.split(|c: char| !c.is_alphanumeric()).filter(|w| !w.is_empty());
    words.map(str::to_lowercase).collect()
}

/// Whether a column of letters is called so: `lat_ref`, `Longitude Hemisphere`.
pub(super) fn is_half(words: &[String]) -> bool {
    let of = |w: &String| {
        w.starts_with("hemi") || ["ref", "dir", "direction", "indicator"].contains(&w.as_str())
    };
    words.iter().any(of)
}

/// The notation that a column's name says.
pub(super) fn form_of_name(name: &str) -> Option<Form> {
    let plain: String =
        name.to_lowercase().chars().filter(|c| !c.is_whitespace() && !"*^_".contains(*c)).collect();
    let words = tokens(name);
    let has = |word: &str| words.iter().any(|w| w == word);
    let scale = |digit: char| {
        let e = ["e", "1e-", "1e", "10-", "10e-"].iter().any(|e| {
            let end = format!("{e}{digit}");
            let whole = |rest: &str| !rest.starts_with(|c: char| c.is_ascii_digit());
            plain.rsplit_once(&end).is_some_and(|(before, rest)| {
                let word = *e != "e"
                    || before.ends_with(|c: char| "de)([/".contains(c) || c == 't' || c == 'n');
                word && whole(rest)
            })
        });
        e.then(|| Form::Scaled(10_f64.powi(-(digit as i32 - '0' as i32))))
    };
    if plain.contains("semicirc") {
        return Some(Form::Scaled(SEMICIRCLE));
    }
    if plain.contains("ddmmss") {
        return Some(Form::Seconds);
    }
    if plain.contains("ddmm") || has("nmea") {
        return Some(Form::Minutes);
    }
    if ["min", "mins", "minutes", "arcmin"].iter().any(|w| has(w)) {
        return Some(Form::Scaled(1.0 / 60.0));
    }
    ['7', '6', '5'].into_iter().find_map(scale)
}
