//! Scenarios that are built in, or in a file: the one list of them all.

use std::path::PathBuf;

use crate::contract::schema::meant;

/// Name and text of scenarios of one kind.
pub(crate) type List = &'static [(&'static str, &'static str)];

/// Of the reduced-order motorcycle.
pub(crate) const REDUCED: List = &[
    ("archive", include_str!("../../pipelines/scenarios/archive.toml")),
    ("perfect", include_str!("../../pipelines/scenarios/perfect.toml")),
    ("paper", include_str!("../../pipelines/scenarios/paper.toml")),
    ("naturalistic", include_str!("../../pipelines/scenarios/naturalistic.toml")),
    ("demo", include_str!("../../pipelines/scenarios/demo.toml")),
];

/// Of the nonlinear motorcycle.
pub(crate) const TOURS: List = &[
    ("characterise", include_str!("../../pipelines/scenarios/characterise.toml")),
    ("lane_change", include_str!("../../pipelines/scenarios/lane_change.toml")),
    ("slalom", include_str!("../../pipelines/scenarios/slalom.toml")),
    ("grip_limit", include_str!("../../pipelines/scenarios/grip_limit.toml")),
];

/// On a closed track.
pub(crate) const TRACKS: List = &[("track", include_str!("../../pipelines/scenarios/track.toml"))];

pub(crate) const MOTOCROSS: List =
    &[("motocross", include_str!("../../pipelines/scenarios/motocross.toml"))];

/// Every built-in scenario, by what rides it.
pub(crate) const ALL: [(&str, List); 4] = [
    ("reduced-order motorcycle", REDUCED),
    ("nonlinear motorcycle", TOURS),
    ("nonlinear motorcycle on a closed track", TRACKS),
    ("motocross, off-road", MOTOCROSS),
];

/// Names of every built-in scenario.
pub fn names() -> impl Iterator<Item = &'static str> {
    ALL.iter().flat_map(|(_, list)| list.iter().map(|(name, _)| *name))
}

/// Their names by what rides them, for a sentence.
pub(crate) fn listed() -> String {
    let one = |(what, list): &(&str, List)| {
        let names: Vec<&str> = list.iter().map(|(name, _)| *name).collect();
        format!("{} ({what})", names.join(", "))
    };
    ALL.iter().map(one).collect::<Vec<_>>().join("; ")
}

/// Message about a scenario that is not there.
pub(crate) fn unknown(name: &str) -> String {
    let all: Vec<&str> = names().collect();
    format!(
        "no scenario `{name}`{}; give a file, or one of {}",
        meant(name, all.iter().copied()),
        all.join(", ")
    )
}

/// The text of a built-in scenario, or of a scenario file that has a key by which its kind is known.
pub(super) fn text_with_key(
    builtin: &[(&str, &str)],
    name_or_path: &str,
    key: &str,
) -> Option<(String, PathBuf)> {
    let path = PathBuf::from(name_or_path);
    if let Some((_, text)) = builtin.iter().find(|(name, _)| *name == name_or_path) {
        return Some(((*text).to_owned(), path));
    }
    let text = std::fs::read_to_string(&path).ok()?;
    let table: toml::Table = text.parse().ok()?;
    // settings of a pipeline have a table of that name
    table.get(key).is_some_and(|value| !value.is_table()).then_some((text, path))
}
