//! `roadbench schema`.

use crate::cli::failure::Failure;
use crate::cli::say::{put, say};
use crate::contract::schema;
use crate::store::tables::registry;

/// Print the definition of a table or file of the contract
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// Its name, e.g. `session` or `coefficients`; without it all names are listed.
    name: Option<String>,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let Some(name) = arguments.name else {
        for (name, _) in registry::schema_files() {
            say!("{name}");
        }
        return Ok(());
    };
    match registry::schema_text(&name) {
        Some(text) => {
            put!("{text}");
            Ok(())
        }
        None => {
            let names: Vec<&str> = registry::schema_files().map(|(n, _)| n).collect();
            let meant = schema::meant(&name, names.iter().copied());
            Err(Failure::Usage(format!(
                "no schema `{name}`{meant}; there are {}",
                names.join(", ")
            )))
        }
    }
}
