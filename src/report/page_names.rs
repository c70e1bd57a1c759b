//! File names of pages: readable, valid on every system, unique.

use std::collections::BTreeSet;

const MAX: usize = 80;

/// One file name per (bike, session), in their order.
///
/// An id that is safe as it stands keeps its name; any other has its odd characters replaced
/// and a short hash appended, so that `a/b` and `a_b` do not meet, nor `A` and `a` on a disk
/// that takes them for one.
pub fn sessions<'a>(sessions: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<String> {
    let mut taken = BTreeSet::from(["index", "fleet", "tyres"].map(str::to_owned));
    sessions
        .map(|(bike, session)| {
            let safe: String = session.chars().take(MAX).map(safe_char).collect();
            let plain = !safe.is_empty() && safe == session && !safe.starts_with('.');
            let stem = if plain && !taken.contains(&safe.to_lowercase()) {
                safe
            } else {
                let hash = blake3::hash(format!("{bike}\0{session}").as_bytes()).to_hex();
                format!("{}-{}", safe.trim_start_matches('.'), &hash[..12])
            };
            taken.insert(stem.to_lowercase());
            format!("{stem}.html")
        })
        .collect()
}

/// One file name per diagnosed (bike, session), in their order; never one of the `taken`.
///
/// A session may itself be called `diagnosis_x`: then the diagnosis of `x` gets a hash.
pub(crate) fn diagnoses<'a>(
    sessions: impl Iterator<Item = (&'a str, &'a str)> + Clone,
    taken: &[String],
) -> Vec<String> {
    let taken: BTreeSet<String> = taken.iter().map(|n| n.to_lowercase()).collect();
    self::sessions(sessions.clone())
        .into_iter()
        .zip(sessions)
        .map(|(page, (bike, session))| {
            let name = format!("diagnosis_{page}");
            if !taken.contains(&name.to_lowercase()) {
                return name;
            }
            let hash = blake3::hash(format!("diagnosis\0{bike}\0{session}").as_bytes()).to_hex();
            format!("{}-{}.html", name.trim_end_matches(".html"), &hash[..12])
        })
        .collect()
}

/// One file name per bike, in their order; never one of the `taken`.
pub(crate) fn bikes<'a>(
    bikes: impl Iterator<Item = &'a str>,
    taken: impl Iterator<Item = &'a str>,
) -> Vec<String> {
    let mut taken: BTreeSet<String> = taken.map(str::to_lowercase).collect();
    bikes
        .map(|bike| {
            let mut name = format!("bike_{}.html", stem(bike));
            if taken.contains(&name.to_lowercase()) {
                let hash = blake3::hash(format!("bike\0{bike}").as_bytes()).to_hex();
                name = format!("{}-{}.html", name.trim_end_matches(".html"), &hash[..12]);
            }
            taken.insert(name.to_lowercase());
            name
        })
        .collect()
}

/// A file name without its ending for any text: as it is where it is safe, else with a hash.
pub(crate) fn stem(text: &str) -> String {
    let safe: String = text.chars().take(MAX).map(safe_char).collect();
    if safe == text && !safe.is_empty() && !safe.starts_with('.') {
        return safe;
    }
    let hash = blake3::hash(text.as_bytes()).to_hex();
    format!("{}-{}", safe.trim_start_matches('.'), &hash[..8])
}

fn safe_char(c: char) -> char {
    if c.is_ascii_alphanumeric() || matches!(c, '-' | '_' | '.') { c } else { '_' }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hostile_and_equal_names_get_their_own_safe_file() {
        let ids = ["lap-1", "../../etc/passwd", "Lap-1", "a/b", "a_b", "", "index", "</script>"];
        let names = sessions(ids.iter().map(|id| ("bike", *id)));
        assert_eq!(names[0], "lap-1.html");
        assert_eq!(names[4], "a_b.html");
        let distinct: BTreeSet<String> = names.iter().map(|n| n.to_lowercase()).collect();
        assert_eq!(distinct.len(), ids.len(), "{names:?}");
        for name in &names {
            assert!(name.chars().all(|c| safe_char(c) == c), "{name}");
            assert!(!name.starts_with('.') && name.len() < 120, "{name}");
        }
        assert_ne!(names[6], "index.html");
    }

    #[test]
    fn a_diagnosis_never_takes_the_page_of_a_session() {
        let taken = sessions([("b", "diagnosis_X"), ("b", "x")].into_iter());
        let names = diagnoses([("b", "x"), ("b", "y")].into_iter(), &taken);
        assert!(names[0].starts_with("diagnosis_x-"), "{names:?}");
        assert_eq!(names[1], "diagnosis_y.html");
    }

    #[test]
    fn a_bike_takes_no_page_of_another() {
        let taken = ["bike_x.html"];
        let names = bikes(["X", "y", "Y", "a/b"].into_iter(), taken.into_iter());
        let distinct: BTreeSet<String> =
            names.iter().map(String::as_str).chain(taken).map(str::to_lowercase).collect();
        assert_eq!((distinct.len(), names[1].as_str()), (5, "bike_y.html"), "{names:?}");
        assert!(names.iter().all(|n| n.chars().all(|c| safe_char(c) == c)), "{names:?}");
    }
}
