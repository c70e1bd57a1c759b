//! Results on stdout and remarks on stderr, where a closed pipe is no error.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

use crate::store::objects::plain::plain;

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

/// Writes to stderr; where that fails nobody can be told.
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

pub(crate) use {put, say, tell};
