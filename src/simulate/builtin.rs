//! Scenarios that are built in, or in a file.

use std::path::PathBuf;

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
    table.contains_key(key).then_some((text, path))
}
