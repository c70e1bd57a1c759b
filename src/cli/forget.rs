//! `roadbench forget`.

use crate::batch::store::forget::{Selection, forget};
use crate::cli::failure::Failure;
use crate::cli::location::{location, require_folder};
use crate::cli::say::say;
use crate::statistics::number_format::count;
use crate::store::objects::Location;

/// Remove sessions from an output
///
/// Their rows go from every table and their pages from the report; the logs stay.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder, or s3://, gs:// or az:// prefix, that `roadbench run --out` wrote.
    #[arg(value_parser = location())]
    out: Location,
    #[command(flatten)]
    named: Named,
    /// Only list what would go.
    #[arg(long)]
    dry_run: bool,
}

/// Which sessions.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = true)]
struct Named {
    /// A session, by its id; may be repeated.
    #[arg(long, value_name = "ID")]
    session: Vec<String>,
    /// All sessions of a motorcycle; may be repeated.
    #[arg(long, value_name = "BIKE")]
    bike: Vec<String>,
    /// Every session and every rejected input whose log is not there any more.
    #[arg(long)]
    missing: bool,
}

/// Runs the command; lists what is gone.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let Arguments { out, named, dry_run } = arguments;
    out.as_path().map_or(Ok(()), require_folder)?;
    let which = Selection { sessions: named.session, bikes: named.bike, missing: named.missing };
    let gone = forget(&out, &which, !dry_run)?;
    for one in &gone {
        match one.session_id.is_empty() {
            true => say!("{}", one.log),
            false => say!("{}  {}  {}", one.session_id, one.bike_id, one.log),
        }
    }
    let said = if dry_run { "would be removed from" } else { "removed from" };
    let rejected = gone.iter().filter(|one| one.session_id.is_empty()).count();
    let sessions = count(gone.len() - rejected, "session");
    let rejected = count(rejected, "rejected input");
    say!("{sessions} and {rejected} {said} {out}");
    Ok(())
}
