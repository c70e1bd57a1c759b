//! File names from session ids: nothing an id says may lead out of the output folder.

use std::fmt::Write;

/// Longest file name made from an id, without extension.
const LONGEST: usize = 120;

/// The file name, without extension, under which a session's tables are stored.
///
/// Letters, digits, `.`, `_` and `-` stay; every other byte, and every leading dot, becomes
/// `%XX`, so that two ids never share a name. A name that would be too long for common file
/// systems is cut and ends in a hash of the whole id; so is one that is just as long as those that are cut, so that no id
/// is written like another's cut name. Names of devices, which Windows takes for no file, begin with `%XX`, too.
pub fn file_name(id: &str) -> String {
    let mut name = String::with_capacity(id.len());
    let dots = id.bytes().take_while(|&b| b == b'.').count();
    for (i, byte) in id.bytes().enumerate() {
        let plain = byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'_' | b'-');
        if plain && i >= dots && !(i == 0 && is_device(id)) {
            name.push(char::from(byte));
        } else {
            let _ = write!(name, "%{byte:02X}"); // writing to a String cannot fail
        }
    }
    if name.is_empty() {
        return "%".to_owned(); // no other id gives this
    }
    if name.len() >= LONGEST {
        let hash = blake3::hash(id.as_bytes()).to_hex();
        name.truncate(LONGEST - 17); // ASCII only: any cut is between characters
        name.push('-');
        name.push_str(&hash[..16]);
    }
    name
}

/// Whether Windows takes a file of this name, whatever its extension, for a device.
fn is_device(id: &str) -> bool {
    let stem = id.split('.').next().unwrap_or_default().to_ascii_uppercase();
    let numbered =
        |port: &str| stem.strip_prefix(port).is_some_and(|n| matches!(n.as_bytes(), [b'0'..=b'9']));
    matches!(stem.as_str(), "CON" | "PRN" | "AUX" | "NUL") || numbered("COM") || numbered("LPT")
}

/// Whether an id can be a file or folder name as it is.
pub(crate) fn is_plain(id: &str) -> bool {
    file_name(id) == id
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn ordinary_ids_stay_readable() {
        assert_eq!(file_name("2024-05-01_lap.3"), "2024-05-01_lap.3");
        assert!(is_plain("2024-05-01_lap.3"));
    }

    #[test]
    fn nothing_climbs() {
        assert_eq!(file_name("../../etc/passwd"), "%2E%2E%2F..%2Fetc%2Fpasswd");
        assert_eq!(file_name(".."), "%2E%2E");
        assert_eq!(file_name("/abs"), "%2Fabs");
        assert_eq!(file_name("a\0b\nc"), "a%00b%0Ac");
        assert_eq!(file_name("Fahrt Süd"), "Fahrt%20S%C3%BCd");
        assert_eq!(file_name(""), "%");
    }

    #[test]
    fn no_name_is_a_device() {
        let names = ["CON", "con.monday", "Com1", "COM", "console", "lpt0.x"].map(file_name);
        assert_eq!(names, ["%43ON", "%63on.monday", "%43om1", "COM", "console", "%6Cpt0.x"]);
    }

    #[test]
    fn long_ids_are_cut_and_stay_apart() {
        let a = file_name(&format!("{}a", "x".repeat(4000)));
        let b = file_name(&format!("{}b", "x".repeat(4000)));
        assert!(a.len() <= LONGEST && b.len() <= LONGEST);
        assert_ne!(a, b);
        assert_ne!(file_name(&a), a, "an id that is written like a cut name");
    }

    proptest! {
        #[test]
        fn a_name_is_one_path_component(id in ".{0,200}") {
            let name = file_name(&id);
            let path = std::path::Path::new(&name);
            prop_assert_eq!(path.components().count(), 1);
            prop_assert!(matches!(path.components().next(), Some(std::path::Component::Normal(_))));
            prop_assert!(name.len() <= LONGEST && !name.starts_with('.'));
        }

        #[test]
        fn different_ids_have_different_names(a in ".{0,60}", b in ".{0,60}") {
            prop_assert_eq!(a == b, file_name(&a) == file_name(&b));
        }
    }
}
