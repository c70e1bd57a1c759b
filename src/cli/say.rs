//! Results on stdout and remarks on stderr, where a closed pipe is no error.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::report::terminal::WIDTH;
use crate::store::objects::plain::plain;

/// Whether `--quiet` was given.
static QUIET: AtomicBool = AtomicBool::new(false);

/// Whether `--verbose` was given.
static VERBOSE: AtomicBool = AtomicBool::new(false);

/// From now on results have their details, or not.
pub(super) fn set_verbose(verbose: bool) {
    VERBOSE.store(verbose, Ordering::Relaxed);
}

/// Whether results have their details.
pub(crate) fn is_verbose() -> bool {
    VERBOSE.load(Ordering::Relaxed)
}

/// From now on notes are left out, or not.
pub(super) fn set_quiet(quiet: bool) {
    QUIET.store(quiet, Ordering::Relaxed);
}

/// Whether progress, summaries and notes are left out.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Ordering::Relaxed)
}

/// Columns of lines on stdout: the terminal's, else those of `COLUMNS`, from 80 to 120; 100 where there is none.
pub(crate) fn width() -> usize {
    let of_terminal = terminal_size::terminal_size_of(std::io::stdout());
    let columns = of_terminal.map(|(columns, _)| usize::from(columns.0)).or_else(asked);
    columns.map_or(WIDTH, |columns| columns.clamp(80, 120))
}

/// Columns that `COLUMNS` asks for where there is no terminal.
fn asked() -> Option<usize> {
    std::env::var("COLUMNS").ok()?.trim().parse().ok()
}

/// Columns that free text is wrapped to: the terminal's; elsewhere a line stays whole, for whatever reads it.
pub(crate) fn line_width() -> usize {
    match terminal_size::terminal_size_of(std::io::stdout()) {
        None if asked().is_none() => usize::MAX,
        _ => width(),
    }
}

/// Writes to stdout. A closed pipe is no error; any other failure is reported on
/// stderr, once per line.
pub(crate) fn write(text: Arguments<'_>) {
    match std::io::stdout().write_fmt(text) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            remark(format_args!("roadbench: cannot write to stdout: {e}\n"));
        }
        _ => {}
    }
}

/// Writes to stderr; a failure is ignored, since nothing could report it.
pub(crate) fn remark(text: Arguments<'_>) {
    let _ = std::io::stderr().write_all(plain(&text.to_string()).as_bytes());
}

/// As `eprint!`, without its panic.
macro_rules! tell {
    ($($text:tt)*) => { $crate::cli::say::remark(format_args!($($text)*)) };
}

/// As `print!`, without its panic.
macro_rules! put {
    ($($text:tt)*) => { $crate::cli::say::write(format_args!($($text)*)) };
}

/// As `println!`, without its panic.
macro_rules! say {
    () => { $crate::cli::say::write(format_args!("\n")) };
    ($($text:tt)*) => {
        $crate::cli::say::write(format_args!("{}\n", format_args!($($text)*)))
    };
}

/// As `say!`, for what nobody asked for: where a file was written, what a command did. `--quiet` leaves it out.
macro_rules! note {
    ($($text:tt)*) => {
        if !$crate::cli::say::is_quiet() {
            $crate::cli::say::say!($($text)*);
        }
    };
}

pub(crate) use {note, put, say, tell};
