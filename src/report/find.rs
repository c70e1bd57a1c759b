//! A session looked for by its id; where it is not there, what was probably meant.

use crate::contract::schema;
use crate::report::error::Error;

/// Most names that are proposed for one that is not there.
const PROPOSED: usize = 3;

/// Place of a session among `keys`, each a bike and a session. The bike is needed where several have a session of that
/// name.
///
/// # Errors
/// [`Error::NoSession`]: there is none, with the nearest ids; or several, with their bikes.
pub(crate) fn find(
    keys: &[(&str, &str)],
    session: &str,
    bike: Option<&str>,
) -> Result<usize, Error> {
    let named: Vec<usize> = (0..keys.len()).filter(|i| keys[*i].1 == session).collect();
    let bikes = || named.iter().map(|i| keys[*i].0).collect::<Vec<_>>().join(", ");
    let of = |b: &str| named.iter().copied().find(|i| keys[*i].0 == b);
    match (named.as_slice(), bike) {
        ([], _) => {
            let hint = nearest(session, keys.iter().map(|k| k.1).collect());
            let hint = if hint.is_empty() { "; `roadbench show OUT` lists them" } else { &hint };
            Err(Error::NoSession(format!("no session `{session}` in the table `sessions`{hint}")))
        }
        (_, Some(bike)) => of(bike).ok_or_else(|| {
            Error::NoSession(format!(
                "bike `{bike}` has no session `{session}`; it is of {}",
                bikes()
            ))
        }),
        ([one], None) => Ok(*one),
        (_, None) => Err(Error::NoSession(format!(
            "several bikes have a session `{session}`: say which with --bike ({})",
            bikes()
        ))),
    }
}

/// `; did you mean ...?` with the names nearest to a misspelt one, the nearest first; nothing where none is near.
pub(crate) fn nearest(word: &str, mut names: Vec<&str>) -> String {
    let mut found = Vec::new();
    while found.len() < PROPOSED {
        let Some(near) = schema::nearest(word, names.iter().copied()) else { break };
        names.retain(|name| *name != near);
        found.push(format!("`{near}`"));
    }
    match found.split_last() {
        None => String::new(),
        Some((last, [])) => format!("; did you mean {last}?"),
        Some((last, before)) => format!("; did you mean {} or {last}?", before.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_session_is_found_or_the_sentence_says_what_to_do() {
        let keys = [("a", "one"), ("a", "two"), ("b", "two")];
        assert_eq!(find(&keys, "one", None).ok(), Some(0));
        assert_eq!(find(&keys, "two", Some("b")).ok(), Some(2));
        let says = |session, bike| find(&keys, session, bike).expect_err("no session").to_string();
        assert!(says("onee", None).contains("did you mean `one`?"));
        assert!(says("entirely else", None).contains("`roadbench show OUT` lists them"));
        assert!(says("two", None).contains("--bike (a, b)"));
        assert!(says("one", Some("b")).contains("it is of a"));
    }

    #[test]
    fn the_nearest_names_are_proposed_each_once_and_no_more_than_three() {
        let names = vec!["ride_01", "ride_02", "ride_02", "lap", "ride_03", "ride_04"];
        assert_eq!(
            nearest("ride_02x", names.clone()),
            "; did you mean `ride_02`, `ride_01` or `ride_03`?"
        );
        assert_eq!(nearest("lapp", names.clone()), "; did you mean `lap`?");
        assert_eq!(nearest("nothing of the kind", names), "");
    }
}
