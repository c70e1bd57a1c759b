//! When to colour, by the conventions of <https://no-color.org> and <https://bixense.com/clicolors>.

use std::ffi::OsString;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU8, Ordering};

use clap::ValueEnum;

/// Of `--color`.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Colour {
    /// On a terminal, unless NO_COLOR is set.
    #[default]
    Auto,
    /// Also into files and pipes.
    Always,
    /// Not at all.
    Never,
}

/// The choice of `--color`, by its place in the enum.
static CHOICE: AtomicU8 = AtomicU8::new(Colour::Auto as u8);

impl Colour {
    /// What the arguments ask for, before they are parsed: help and errors of the parser follow it too.
    pub(super) fn of(arguments: &[OsString]) -> Self {
        let given = arguments.iter().take_while(|a| *a != "--").map(|a| a.to_string_lossy());
        let given: Vec<_> = given.collect();
        let value = given.iter().enumerate().rev().find_map(|(i, argument)| {
            let next = || given.get(i + 1).filter(|_| argument == "--color").map(AsRef::as_ref);
            argument.strip_prefix("--color=").or_else(next)
        });
        value.and_then(|value| Colour::from_str(value, false).ok()).unwrap_or_default()
    }

    /// From now on this is the choice.
    pub(super) fn take(self) {
        CHOICE.store(self as u8, Ordering::Relaxed);
    }
}

impl From<Colour> for clap::ColorChoice {
    fn from(colour: Colour) -> Self {
        match colour {
            Colour::Auto => clap::ColorChoice::Auto,
            Colour::Always => clap::ColorChoice::Always,
            Colour::Never => clap::ColorChoice::Never,
        }
    }
}

/// Whether stderr is to be coloured.
pub(crate) fn on_stderr() -> bool {
    on(std::io::stderr().is_terminal())
}

/// Whether stdout is to be coloured.
pub(crate) fn on_stdout() -> bool {
    on(std::io::stdout().is_terminal())
}

/// `--color` goes before the environment.
fn on(terminal: bool) -> bool {
    match CHOICE.load(Ordering::Relaxed) {
        c if c == Colour::Always as u8 => true,
        c if c == Colour::Never as u8 => false,
        _ => wanted(terminal, |name| std::env::var(name).ok()),
    }
}

/// `NO_COLOR` goes before everything, `CLICOLOR_FORCE` before what the stream is; else a terminal that
/// is not dumb, unless `CLICOLOR` says otherwise.
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

    #[test]
    fn the_choice_is_known_before_the_arguments_are_parsed() {
        let of = |line: &str| Colour::of(&line.split(' ').map(OsString::from).collect::<Vec<_>>());
        assert_eq!(of("roadbench run --color always"), Colour::Always);
        assert_eq!(of("roadbench --color=never run"), Colour::Never);
        assert_eq!(of("roadbench --color never run --color=always"), Colour::Always);
        assert_eq!(of("roadbench run -- --color=never"), Colour::Auto);
        assert_eq!(of("roadbench --color"), Colour::Auto);
    }
}
