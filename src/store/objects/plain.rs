//! What the system says of files, in plain words: the one place that words it.

use std::borrow::Cow;
use std::io::{Error, ErrorKind};

/// Suffix of the standard library after the system's own words.
const MARK: &str = " (os error ";

/// A message in which the system's own words, `No such file or directory (os error 2)`, are plain ones. Other errors
/// carry them within their own sentences, so it is the text that is looked at; a text without them stays as it is.
pub(crate) fn plain(message: &str) -> Cow<'_, str> {
    if !message.contains(MARK) {
        return Cow::Borrowed(message);
    }
    let mut text = String::new();
    let mut rest = message;
    while let Some((before, after)) = rest.split_once(MARK) {
        let number = after.split_once(')').and_then(|(n, end)| Some((n.parse().ok()?, end)));
        let Some((code, end)) = number else {
            text = text + before + MARK;
            rest = after;
            continue;
        };
        let said = Error::from_raw_os_error(code);
        let whole = said.to_string();
        let system = whole.split_once(MARK).map_or("", |(words, _)| words);
        match before.strip_suffix(system) {
            Some(kept) => text = text + kept + &words(said.kind(), system),
            None => text += before,
        }
        rest = end;
    }
    Cow::Owned(text + rest)
}

/// Plain words for a kind of error; the system's own, which are plain enough, for the others.
fn words(kind: ErrorKind, system: &str) -> String {
    let words = match kind {
        ErrorKind::NotFound => "file not found",
        ErrorKind::PermissionDenied => "permission denied",
        ErrorKind::IsADirectory => "it is a folder, not a file",
        ErrorKind::NotADirectory => "a part of the path is a file, not a folder",
        ErrorKind::AlreadyExists => "it exists already",
        ErrorKind::ReadOnlyFilesystem => "the disk is read-only",
        _ => system,
    };
    words.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_words_become_plain_ones() {
        for (kind, want) in [
            (ErrorKind::NotFound, "file not found"),
            (ErrorKind::PermissionDenied, "permission denied"),
            (ErrorKind::IsADirectory, "it is a folder, not a file"),
        ] {
            let code = (1..200).find(|n| Error::from_raw_os_error(*n).kind() == kind);
            let e = Error::from_raw_os_error(code.expect("the system has it"));
            let message = format!("cannot read a.toml: {e}; twice: {e}");
            assert_eq!(plain(&message), format!("cannot read a.toml: {want}; twice: {want}"));
        }
    }

    #[test]
    fn other_texts_stay() {
        for text in ["", "a (os error", "a (os error x) b", "100 % (é) (os errors 2)"] {
            assert_eq!(plain(text), text);
        }
        let alien = format!("{MARK}2): not what the system says");
        assert_eq!(plain(&alien), ": not what the system says");
    }
}
