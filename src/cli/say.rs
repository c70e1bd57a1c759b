//! Results on stdout, where a closed pipe is no error.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

/// Writes to stdout. A closed pipe is no error; any other failure is reported on
/// stderr, once per line.
pub fn write(text: Arguments<'_>) {
    match std::io::stdout().write_fmt(text) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            eprintln!("roadbench: cannot write to stdout: {e}");
        }
        _ => {}
    }
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

pub(crate) use {put, say};
