//! Kinds of manoeuvre on pages and in figures: words, style and script made from their
//! declarations ([`crate::segment::manoeuvre`]).

use std::fmt::Write as _;

use serde_json::json;

use crate::report::labels;
use crate::segment::manoeuvre::{Declaration, ManoeuvreKind};

/// The declaration of a kind by its name in the tables; that of `other` where this version does not
/// know the name.
pub(crate) fn declaration(name: &str) -> &'static Declaration {
    ManoeuvreKind::from_name(name).unwrap_or(ManoeuvreKind::Other).declaration()
}

/// A kind in words, by its name in the tables.
pub(crate) fn label(name: &str) -> String {
    match ManoeuvreKind::from_name(name) {
        Some(kind) => kind.declaration().words.to_owned(),
        None => labels::spaced(name),
    }
}

fn all() -> impl Iterator<Item = &'static Declaration> {
    ManoeuvreKind::ALL.iter().map(|k| k.declaration())
}

/// The colours as variables of the pages' style: `--kind-coasting` and so on.
pub(super) fn style() -> String {
    let variables = |colour: fn(&Declaration) -> &str| {
        all().fold(String::new(), |mut out, d| {
            let _ = write!(out, " --kind-{}: {};", d.name, colour(d));
            out
        })
    };
    format!(
        ":root {{{} }}\n@media (prefers-color-scheme: dark) {{\n  :root:not([data-print]) {{{} }}\n}}\n",
        variables(|d| d.colour),
        variables(|d| d.colour_dark)
    )
}

/// The start of the pages' script: `KINDS` by name, with `words`, `letter`, letters of `sides`
/// where they differ, whether it is the `rest` that no detector claimed, and whether it is a `strip` below the others.
pub(super) fn script() -> String {
    let kinds: serde_json::Map<_, _> = all()
        .map(|d| {
            let sides = d.letter_by_side.map(|[left, right]| json!({"left": left, "right": right}));
            let rest = d.name == ManoeuvreKind::Other.name();
            // it overlaps the kinds that cover the ride
            let strip = d.name == ManoeuvreKind::ChangingLean.name();
            let kind = json!({"words": d.words, "letter": d.letter, "sides": sides, "rest": rest, "strip": strip});
            (d.name.to_owned(), kind)
        })
        .collect();
    format!("const KINDS = {};\n", serde_json::Value::Object(kinds))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::assets::{SCRIPT, STYLE};

    /// Every colour of a kind that style or script name is declared, in light and in dark.
    #[test]
    fn pages_know_the_declared_kinds_and_no_others() {
        let named = |text: &str| -> Vec<String> {
            let in_name = |c: &char| c.is_ascii_lowercase() || *c == '_';
            let names = text.split("--kind-").skip(1);
            names.map(|rest| rest.chars().take_while(in_name).collect::<String>()).collect()
        };
        for (text, least) in [(STYLE.as_str(), 2), (SCRIPT.as_str(), 0)] {
            let names = named(text);
            // the script builds names of variables from the names of kinds
            let known = |n: &String| n.is_empty() || ManoeuvreKind::from_name(n).is_some();
            assert!(names.iter().all(known), "{names:?}");
            for d in all() {
                assert!(names.iter().filter(|n| *n == d.name).count() >= least, "{}", d.name);
            }
        }
        for d in all() {
            let quoted = format!("\"{}\"", d.name);
            assert_eq!(
                SCRIPT.matches(&quoted).count(),
                1 + usize::from(d.name == d.words),
                "{quoted}"
            );
        }
    }
}
