//! `roadbench show`.

use std::path::{Path, PathBuf};

use clap::builder::NonEmptyStringValueParser;

use crate::batch::store::intact;
use crate::batch::store::mark;
use crate::batch::store::reading::Reading;
use crate::cli::batch::print;
use crate::cli::failure::Failure;
use crate::cli::json;
use crate::cli::location::require_folder;
use crate::cli::report::failure;
use crate::cli::say;
use crate::diagnose::reference::words;
use crate::report::diagnosis::answer;
use crate::report::diagnosis::tables::{causes, causes_and_shared};
use crate::report::find::{find, nearest};
use crate::report::session::printed::{self, Stored};
use crate::report::{Error, list_of_sessions, page_names, tables, terminal};
use crate::store::objects::Location;
use crate::store::tables::changes::is_change;
use crate::store::tables::read;
use crate::store::tables::rows::{CauseRow, ChangeRow, Ident, Rejected, SessionRow};

/// Print what a session gave, or list the sessions
///
/// Without --session: every session of the output and what was rejected. Of what `diagnose` wrote: the causes that it
/// found, and what changed between the rides. Nothing is computed again.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder that `roadbench run --out` or `roadbench diagnose --out` wrote.
    out: PathBuf,
    /// The session to show, by its id.
    #[arg(long, value_name = "ID", value_parser = NonEmptyStringValueParser::new())]
    session: Option<String>,
    /// Its bike, where several have a session of that name; without --session, the bike whose sessions are listed.
    #[arg(long, value_name = "ID", value_parser = NonEmptyStringValueParser::new())]
    bike: Option<String>,
    /// Print the rows of the tables `sessions`, `coefficients`, `warnings`, `rejected`, `causes` and `changes` as JSON, one
    /// object a line; its key `table` says of which.
    #[arg(long)]
    json: bool,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { out, session, bike, json } = arguments;
    require_folder(out)?;
    mark::require(&Location::from(out))?;
    match session {
        Some(session) => one(out, session, bike.as_deref(), *json),
        None => list(out, bike.as_deref(), *json),
    }
}

/// One session.
fn one(out: &Path, session: &str, bike: Option<&str>, json: bool) -> Result<(), Failure> {
    let _reading = Reading::of_session(out, printed::TABLES, session)?;
    let sessions = tables::sessions(out).map_err(failure)?;
    let keys: Vec<(&str, &str)> = sessions.iter().map(|s| s.ident.key()).collect();
    let place = match find(&keys, session, bike) {
        Ok(place) => place,
        // of a ride that was diagnosed and not run
        Err(e) => match diagnosed(out, session, bike, json)? {
            true => return Ok(()),
            false => return Err(unknown(out, session, e)?),
        },
    };
    let ident = &sessions[place].ident;
    let stored = Stored::read(out, ident).map_err(failure)?;
    if json {
        print(&json::line("sessions", &stored.session));
        stored.coefficients.iter().for_each(|row| print(&json::line("coefficients", row)));
        stored.warnings.iter().for_each(|row| print(&json::line("warnings", row)));
        return Ok(());
    }
    print(&stored.printed().text(say::width()));
    let found = of_ride(out, ident.key())?;
    if !found.is_empty() {
        print(&format!("\nDiagnosis\n{}", terminal::wrapped(&found, say::width())));
    }
    let page = page_names::sessions(keys.iter().copied()).swap_remove(place);
    print(&format!("\n{}", page_of(out, &page, ident)));
    Ok(())
}

/// Prints what a diagnosis found in a ride; whether it was diagnosed.
fn diagnosed(out: &Path, session: &str, bike: Option<&str>, json: bool) -> Result<bool, Failure> {
    let _reading = Reading::of(out)?;
    let mut rows = causes(out).map_err(failure)?;
    rows.retain(|row| {
        row.ident.session_id == session && bike.is_none_or(|b| row.ident.bike_id == b)
    });
    // without fault-free simulations a ride has no causes
    let changes = changes(out)?;
    let is_own = |row: &&ChangeRow| {
        row.ident.session_id == session && bike.is_none_or(|b| row.ident.bike_id == b)
    };
    let changes: Vec<&ChangeRow> = changes.iter().filter(is_own).collect();
    let first = rows.first().map(|row| &row.ident).or(changes.first().map(|row| &row.ident));
    let Some(first) = first else { return Ok(false) };
    if json {
        rows.iter().for_each(|row| print(&json::line("causes", row)));
        changes.iter().for_each(|row| print(&json::line("changes", row)));
        return Ok(true);
    }
    let (bike, session) = first.key();
    let head = format!("{}  {}\n", terminal::clean(session), terminal::clean(bike));
    print(&head);
    print(&terminal::wrapped(&of_ride(out, (bike, session))?, say::width()));
    print(&format!("Report: {}\n", out.join("report/index.html").display()));
    Ok(true)
}

/// What a diagnosis found in a ride, in sentences, and how the ride compares with the motorcycle's others; empty where it
/// was not diagnosed.
fn of_ride(out: &Path, ride: (&str, &str)) -> Result<String, Failure> {
    let mut rows = causes(out).map_err(failure)?;
    rows.retain(|row| row.ident.key() == ride);
    let mut text = String::new();
    if !rows.is_empty() {
        text = answer::of_ride(&rows).join("\n") + "\n";
    }
    let changes = changes(out)?;
    let own = || changes.iter().filter(|row| row.ident.key() == ride);
    for row in own().filter(|row| is_change(row)) {
        text += &format!("{}.\n", row.sentence);
    }
    // a ride that was only compared has an answer, too
    if text.is_empty() {
        text.extend(own().map(|row| format!("{}.\n", row.sentence)));
    }
    Ok(text)
}

/// What `diagnose` found in all rides of an output and between them, as it printed it; empty where nothing was diagnosed.
fn of_rides(out: &Path, bike: Option<&str>) -> Result<String, Failure> {
    let (rows, shared) = causes_and_shared(out).map_err(failure)?;
    let is_own = |row: &&CauseRow| bike.is_none_or(|bike| row.ident.bike_id == bike);
    let rows: Vec<CauseRow> = rows.iter().filter(is_own).cloned().collect();
    let mut changes = changes(out)?;
    changes.retain(|row| bike.is_none_or(|bike| row.ident.bike_id == bike));
    // without fault-free simulations rides are only compared
    if rows.is_empty() {
        return Ok(words::of_motorcycles(&changes));
    }
    let rides: Vec<Vec<CauseRow>> =
        rows.chunk_by(|a, b| a.ident.key() == b.ident.key()).map(<[CauseRow]>::to_vec).collect();
    // what rides share is of all motorcycles
    let shared: &[CauseRow] = if bike.is_some() { &[] } else { &shared };
    let said = answer::of_sessions(&rides, shared, usize::MAX);
    Ok(said + &words::of_motorcycles(&changes))
}

fn changes(out: &Path) -> Result<Vec<ChangeRow>, Failure> {
    read::rows(out).map_err(|e| Failure::Output(e.to_string()))
}

/// Where a session's page is, or the command that writes it.
fn page_of(out: &Path, name: &str, ident: &Ident) -> String {
    let page = out.join("report").join(name);
    if page.is_file() {
        return format!("Page: {}\n", page.display());
    }
    let (bike, session) = ident.key();
    let command = format!(
        "roadbench report {} --open={} --bike={}",
        out.display(),
        quoted(session),
        quoted(bike)
    );
    terminal::wrapped(&format!("Its page is not written; `{command}` writes it."), say::width())
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    match word.chars().all(is_plain) {
        true => word.to_owned(),
        false => format!("'{}'", word.replace('\'', "'\\''")),
    }
}

/// Why there is no session of a name: it was rejected, or what [`find`] says.
fn unknown(out: &Path, session: &str, e: Error) -> Result<Failure, Failure> {
    let of_name = |row: &Rejected| {
        let stem = Path::new(&row.path).file_stem().map(|stem| stem.to_string_lossy());
        row.session_id.as_deref() == Some(session) || stem.is_some_and(|stem| stem == session)
    };
    let mut rejected = tables::rejected(out).map_err(failure)?;
    rejected.retain(of_name);
    if rejected.is_empty() {
        return Ok(failure(e));
    }
    let why = terminal::rejections(&rejected, rejected.len(), say::width());
    Ok(Failure::Usage(format!("`{session}` was rejected:\n{}", why.trim_end())))
}

/// All sessions, or those of a bike.
fn list(out: &Path, bike: Option<&str>, json: bool) -> Result<(), Failure> {
    let _reading = Reading::of(out)?;
    intact::require_lists(&Location::from(out))?;
    let mut sessions = tables::sessions(out).map_err(failure)?;
    let mut rejected = tables::rejected(out).map_err(failure)?;
    let found = of_rides(out, bike)?;
    if let Some(bike) = bike.filter(|_| !sessions.is_empty() || found.is_empty()) {
        let of_bike = |row: &SessionRow| row.ident.bike_id == bike;
        if !sessions.iter().any(of_bike) {
            let mut bikes: Vec<&str> = sessions.iter().map(|s| s.ident.bike_id.as_str()).collect();
            bikes.dedup();
            let hint = nearest(bike, bikes);
            return Err(Failure::Usage(format!("no bike `{bike}` in the table `sessions`{hint}")));
        }
        sessions.retain(of_bike);
        rejected.retain(|row| row.bike_id.as_deref() == Some(bike));
    }
    if json {
        sessions.iter().for_each(|row| print(&json::line("sessions", row)));
        rejected.iter().for_each(|row| print(&json::line("rejected", row)));
        let is_own = |row: &&CauseRow| bike.is_none_or(|bike| row.ident.bike_id == bike);
        let rows = causes(out).map_err(failure)?;
        rows.iter().filter(is_own).for_each(|row| print(&json::line("causes", row)));
        let is_own = |row: &&ChangeRow| bike.is_none_or(|bike| row.ident.bike_id == bike);
        changes(out)?.iter().filter(is_own).for_each(|row| print(&json::line("changes", row)));
        return Ok(());
    }
    if sessions.is_empty() && !found.is_empty() {
        print(&terminal::wrapped(&found, say::width()));
        print(&format!("Report: {}\n", out.join("report/index.html").display()));
        return Ok(());
    }
    print(&list_of_sessions::text(&sessions, &rejected, say::width()));
    if let Some(first) = sessions.first() {
        let command = format!(
            "roadbench show {} --session {}",
            out.display(),
            quoted(&first.ident.session_id)
        );
        print(&terminal::wrapped(&format!("\nTo show one: `{command}`"), say::width()));
    }
    if !found.is_empty() {
        print(&format!("\nDiagnosis\n{}", terminal::wrapped(&found, say::width())));
    }
    Ok(())
}
