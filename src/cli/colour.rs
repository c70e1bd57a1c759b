//! When to colour, by the conventions of <https://no-color.org> and <https://bixense.com/clicolors>.

use std::io::IsTerminal;

/// Whether stderr is to be coloured.
pub(crate) fn on_stderr() -> bool {
    wanted(std::io::stderr().is_terminal(), |name| std::env::var(name).ok())
}

/// Whether stdout is to be coloured.
pub(crate) fn on_stdout() -> bool {
    wanted(std::io::stdout().is_terminal(), |name| std::env::var(name).ok())
}

/// `NO_COLOR` goes before everything, `CLICOLOR_FORCE` before what the stream is; else a terminal that
/// is not dumb and not told otherwise by `CLICOLOR`.
fn wanted(terminal: bool, variable: impl Fn(&str) -> Option<String>) -> bool {
    let is = |name: &str| variable(name).filter(|value| !value.is_empty());
    if is("NO_COLOR").is_some() {
        return false;
    }
    if is("CLICOLOR_FORCE").is_some_and(|value| value != "0") {
        return true;
    }
    let told_not_to = is("CLICOLOR").is_some_and(|value| value == "0");
    terminal && !told_not_to && variable("TERM").as_deref() != Some("dumb")
}

/// Text in bold, where colours are wanted.
pub(crate) fn bold(text: &str, wanted: bool) -> String {
    if wanted { format!("\u{1b}[1m{text}\u{1b}[0m") } else { text.to_owned() }
}

/// Text in bold red, where colours are wanted.
pub(crate) fn red(text: &str, wanted: bool) -> String {
    if wanted { format!("\u{1b}[1;31m{text}\u{1b}[0m") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_conventions_in_their_order() {
        let at = |terminal: bool, set: &[(&str, &str)]| {
            wanted(terminal, |name| {
                set.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned())
            })
        };
        assert!(at(true, &[]) && !at(false, &[]));
        assert!(!at(true, &[("NO_COLOR", "1")]) && at(true, &[("NO_COLOR", "")]));
        assert!(!at(true, &[("NO_COLOR", "1"), ("CLICOLOR_FORCE", "1")]));
        assert!(at(false, &[("CLICOLOR_FORCE", "1")]) && !at(false, &[("CLICOLOR_FORCE", "0")]));
        assert!(!at(true, &[("CLICOLOR", "0")]) && at(true, &[("CLICOLOR", "1")]));
        assert!(!at(true, &[("TERM", "dumb")]));
    }
}
