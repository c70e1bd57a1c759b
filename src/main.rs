//! The `roadbench` command: parses the arguments and calls the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    roadbench::command()
}
