//! `roadbench verify`.

use crate::batch::store::verify::{Mended, mend, verify};
use crate::cli::failure::Failure;
use crate::cli::location::{location, require_folder};
use crate::cli::say::say;
use crate::statistics::number_format::count;
use crate::store::objects::Location;

/// Check an output for damaged or missing data
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder, or s3://, gs:// or az:// prefix, that `roadbench run --out` wrote.
    #[arg(value_parser = location())]
    out: Location,
    /// Do not read the logs: only the output itself.
    #[arg(long)]
    no_logs: bool,
    /// Remove damaged tables and leftovers of killed runs: the next run computes their sessions again. Tables with
    /// sessions whose logs are gone or changed stay.
    #[arg(long)]
    mend: bool,
    /// With --mend: those tables, too; what they had of these sessions is lost.
    #[arg(long, requires = "mend")]
    lose: bool,
}

/// Runs the command; lists what is wrong.
///
/// # Errors
/// See [`Failure`]; exit code 1 where the output is damaged.
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let Arguments { out, no_logs, mend: mends, lose } = arguments;
    out.as_path().map_or(Ok(()), require_folder)?;
    let done = verify(&out, !no_logs)?;
    for finding in &done.findings {
        say!("{finding}");
    }
    let damaged = done.findings.iter().filter(|f| f.wrong.is_damage()).count();
    let others = done.findings.len() - damaged;
    let logs = if no_logs { String::new() } else { format!(", {}", count(done.logs, "log")) };
    say!(
        "{} of {}{logs}: {damaged} damaged, {others} notes{}",
        count(done.files, "file"),
        count(done.sessions, "session"),
        match done.unlisted {
            0 => String::new(),
            n => format!("; {n} have no checksum yet"),
        }
    );
    if mends {
        let Mended { removed, kept } = mend(&out, lose)?;
        for (path, sessions) in &kept {
            let (n, first) = (sessions.len(), sessions.iter().next().map_or("", String::as_str));
            let whose = if n == 1 { String::new() } else { format!(" and {} more", n - 1) };
            say!("stays        {path}: the log of {first}{whose} is gone, changed or unknown");
        }
        if !removed.is_empty() {
            say!("{} removed; the next run makes them again", count(removed.len(), "file"));
        }
        return match kept.len() {
            0 => Ok(()),
            n => Err(Failure::Rejected(format!(
                "{} may be impossible to compute again: restore the logs and run over all of them, \
                 restore a backup, or remove the rows of these sessions with `roadbench verify OUT \
                 --mend --lose`",
                count(n, "table")
            ))),
        };
    }
    match damaged {
        0 => Ok(()),
        _ => Err(Failure::Rejected(
            "the output is damaged: run over its logs again to repair it; for sessions without a \
             log use `roadbench verify OUT --mend`"
                .to_owned(),
        )),
    }
}
