//! `roadbench completions` and `roadbench man`: shell completions and manual pages, generated from
//! the commands' arguments.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use crate::cli::failure::Failure;
use crate::cli::say::{note, put};
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Print the completions of a shell
#[derive(Debug, clap::Args)]
pub(crate) struct Completions {
    /// The shell.
    shell: Shell,
}

/// Write a manual page of every command
#[derive(Debug, clap::Args)]
pub(crate) struct Man {
    /// Folder for roadbench.1, roadbench-run.1 and so on; made where it is not there.
    dir: PathBuf,
}

/// Runs `completions`; `command` is the whole program.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn completions(arguments: &Completions, mut command: Command) -> Result<(), Failure> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command, "roadbench", &mut text);
    put!("{}", String::from_utf8_lossy(&text));
    Ok(())
}

/// Runs `man`; `command` is the whole program.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn man(arguments: &Man, command: Command) -> Result<(), Failure> {
    let dir = &arguments.dir;
    let command = command.disable_help_subcommand(true);
    let mut pages = Vec::new();
    let failed = |e: &dyn std::fmt::Display| {
        Failure::Output(format!("cannot write manual pages to {}: {e}", dir.display()))
    };
    let mut command = command;
    command.build();
    collect(command, &mut pages).map_err(|e| failed(&e))?;
    let mut outputs = Outputs::default();
    outputs.folder("DIR", &dir.into())?;
    pages.iter().try_for_each(|(name, _)| outputs.file("DIR", &dir.join(name).into()))?;
    for (name, page) in &pages {
        output::write(dir.join(name), page).map_err(|e| failed(&e))?;
    }
    note!("{} pages in {}", pages.len(), dir.display());
    Ok(())
}

/// Names and manual pages of a command and those below it.
fn collect(command: Command, pages: &mut Vec<(String, Vec<u8>)>) -> std::io::Result<()> {
    for below in command.get_subcommands().filter(|c| !c.is_hide_set()).cloned() {
        collect(below, pages)?;
    }
    let (page, mut text) = (clap_mangen::Man::new(command), Vec::new());
    page.render(&mut text)?;
    pages.push((page.get_filename(), text));
    Ok(())
}
