//! `roadbench completions` and `roadbench man`: shell completions and manual pages, generated from
//! the commands' arguments.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use crate::cli::failure::Failure;
use crate::cli::say::{put, say};

/// Print the completions of a shell
#[derive(Debug, clap::Args)]
pub struct Completions {
    /// The shell.
    shell: Shell,
}

/// Write a manual page of every command
#[derive(Debug, clap::Args)]
pub struct Man {
    /// Folder for roadbench.1, roadbench-run.1 and so on; made where it is not there.
    dir: PathBuf,
}

/// Runs `completions`; `command` is the whole program.
///
/// # Errors
/// See [`Failure`].
pub fn completions(arguments: &Completions, mut command: Command) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "roadbench", &mut text);
    put!("{}", String::from_utf8_lossy(&text));
    Ok(())
}

/// Runs `man`; `command` is the whole program.
///
/// # Errors
/// See [`Failure`].
pub fn man(arguments: &Man, command: Command) -> Result<(), Failure> {
    let dir = &arguments.dir;
    let command = command.disable_help_subcommand(true);
    let pages = pages(&command);
    std::fs::create_dir_all(dir).and_then(|()| clap_mangen::generate_to(command, dir)).map_err(
        |e| Failure::Output(format!("cannot write manual pages to {}: {e}", dir.display())),
    )?;
    say!("{pages} pages in {}", dir.display());
    Ok(())
}

/// Manual pages of a command with those below it.
fn pages(command: &Command) -> usize {
    1 + command.get_subcommands().map(pages).sum::<usize>()
}
