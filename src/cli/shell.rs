//! `roadbench completions` and `roadbench man`: what a shell and `man` want to know of the commands.

use std::path::PathBuf;

use clap::CommandFactory;
use clap_complete::Shell;

use crate::cli::Failure;
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

/// Runs `completions`.
///
/// # Errors
/// See [`Failure`].
pub fn completions(arguments: &Completions) -> Result<(), Failure> {
    let mut command = super::Arguments::command();
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "roadbench", &mut text);
    put!("{}", String::from_utf8_lossy(&text));
    Ok(())
}

/// Runs `man`.
///
/// # Errors
/// See [`Failure`].
pub fn man(arguments: &Man) -> Result<(), Failure> {
    let dir = &arguments.dir;
    let command = super::Arguments::command().disable_help_subcommand(true);
    let pages = 1 + command.get_subcommands().count();
    std::fs::create_dir_all(dir).and_then(|()| clap_mangen::generate_to(command, dir)).map_err(
        |e| Failure::Output(format!("cannot write manual pages to {}: {e}", dir.display())),
    )?;
    say!("{pages} pages in {}", dir.display());
    Ok(())
}
