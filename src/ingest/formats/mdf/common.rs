//! Names, units and warnings that MDF 3 and 4 have in common.

use std::collections::HashMap;

use falcon_mdf::Mf4Error;

use crate::contract::warning::Warning;
use crate::ingest::warning::warning;

/// Unique names for groups: repeated ones are numbered.
pub(super) fn group_names(named: Vec<String>) -> Vec<String> {
    let only = named.len() == 1;
    let mut seen: HashMap<String, usize> = HashMap::new();
    let mut name = |(i, name): (usize, String)| {
        let name = match name.trim() {
            "" if only => return String::new(),
            "" => format!("group {}", i + 1),
            name => name.to_owned(),
        };
        let count = seen.entry(name.clone()).or_insert(0);
        *count += 1;
        if *count == 1 { name } else { format!("{name} #{count}") }
    };
    named.into_iter().enumerate().map(&mut name).collect()
}

/// A unit as the log gives it; an empty one is none.
pub(super) fn unit(text: &str) -> Option<String> {
    let text = text.trim_matches(|c: char| c.is_whitespace() || c == '\0');
    (!text.is_empty()).then(|| text.to_owned())
}

/// A group that could not be read to its end.
pub(super) fn broken(group: &str, samples: usize, last: Option<f64>, error: &Mf4Error) -> Warning {
    let until = last.map(|t| format!(", until {t:.2} s")).unwrap_or_default();
    let group = if group.is_empty() { "its channels" } else { group };
    let message =
        format!("{group}: only the first {samples} samples could be read{until}: {error}");
    warning("damaged", None, 1, None, message)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_get_names_of_their_own() {
        let names = |n: &[&str]| group_names(n.iter().map(|n| (*n).to_owned()).collect());
        assert_eq!(names(&[""]), [""]);
        assert_eq!(names(&["", "IMU", "IMU"]), ["group 1", "IMU", "IMU #2"]);
    }
}
