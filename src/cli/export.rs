//! `roadbench export`.

use std::io::{IsTerminal, Write};
use std::path::PathBuf;

use clap::ValueHint;

use crate::batch::jobs::models;
use crate::batch::store::mark;
use crate::batch::store::reading::Reading;
use crate::cli::batch::BIKES;
use crate::cli::choices::{CoefficientSet, Tyre, TyreFormat};
use crate::cli::failure::Failure;
use crate::cli::location::{location, require_folder};
use crate::report::export::written;
use crate::report::export::written::{Request, Written};
use crate::store::objects::Location;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;

/// Write a fitted tyre for other programs
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder that `roadbench run --out` wrote.
    out: PathBuf,
    /// The session whose tyre it is.
    #[arg(long)]
    session: String,
    /// Its bike, where two bikes have a session of that name.
    #[arg(long)]
    bike: Option<String>,
    /// What to write.
    #[arg(long, value_enum)]
    format: TyreFormat,
    /// Which tyre; a tir, tydex, fmu or simulator file holds one, the others both where this is not given.
    #[arg(long, value_enum)]
    tyre: Option<Tyre>,
    /// Folder of bike files: dimensions, static load, and what no ride gives. A c, fmu, tydex or
    /// simulator file needs it; a tir file has placeholders and no combined slip without it.
    #[arg(long, value_name = "DIR", env = BIKES, hide_env_values = true)]
    bikes: Option<PathBuf>,
    /// Which set of coefficients a tir file has; the reduced one where the ride gave half of a tyre.
    #[arg(long, value_enum, default_value = "5.2")]
    set: CoefficientSet,
    /// Road friction of the ride.
    #[arg(long, default_value_t = 1.0)]
    friction: f64,
    /// Nominal load of a tir file and of the combined csv table instead of the bike's static one, N; the tyre is
    /// the same.
    #[arg(long)]
    load: Option<f64>,
    /// Add what `diagnose` found of the tyres.
    ///
    /// PATH is its output, here or in an object store, or one session's model file, as for `run --model`. Best with an OUT that `run --model` wrote with the same PATH.
    #[arg(long, value_name = "PATH")]
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    model: Option<Location>,
    /// Where to write; stdout without it.
    #[arg(short = 'o', long = "out", value_name = "FILE")]
    #[arg(value_parser = location(), value_hint = ValueHint::AnyPath)]
    file: Option<Location>,
}

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    require_folder(&arguments.out)?;
    mark::require(&Location::from(&arguments.out))?;
    arguments.bikes.as_deref().map_or(Ok(()), require_folder)?;
    if let Some(file) = &arguments.file {
        let mut outputs = Outputs::default();
        outputs.tables(&(&arguments.out).into());
        outputs.file("--out", file)?;
        outputs.apart_from(&arguments.model)?;
        outputs.apart_from_files(&arguments.bikes)?;
    }
    let models = match &arguments.model {
        Some(at) => Some(models::read(at)?),
        None => {
            if arguments.out.join("models").is_dir() {
                let out = arguments.out.display();
                tracing::warn!(
                    "{out} has a diagnosis as well; --model {out} adds the tyre effects that it identified"
                );
            }
            None
        }
    };
    let request = Request {
        out: &arguments.out,
        session: &arguments.session,
        bike: arguments.bike.as_deref(),
        format: arguments.format.into(),
        tyre: arguments.tyre.map(Into::into),
        bikes: arguments.bikes.as_deref(),
        set: arguments.set.into(),
        friction: arguments.friction,
        load: arguments.load,
        models: models.as_ref(),
    };
    let reading = Reading::of_session(&arguments.out, Request::TABLES, &arguments.session)
        .map_err(|e| Failure::Output(e.to_string()))?;
    let written = written::write(&request).map_err(Failure::usage)?;
    drop(reading);
    match &arguments.file {
        None if matches!(written, Written::Binary(_)) && std::io::stdout().is_terminal() => {
            return Err(Failure::Usage("this format is binary: give --out FILE".to_owned()));
        }
        None => match std::io::stdout().write_all(written.bytes()) {
            // who reads has seen enough
            Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => {}
            other => other.map_err(|e| Failure::Output(format!("cannot write to stdout: {e}")))?,
        },
        Some(path) => {
            output::write(path, written.bytes()).map_err(|e| Failure::Output(e.to_string()))?
        }
    }
    Ok(())
}
