//! The command line: one file per command, nothing here but the list and the exit codes.

use std::ffi::OsString;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use indicatif::ProgressBar;

use logging::LogFormat;

pub mod convert;
pub mod diagnose;
pub mod export;
pub mod inspect;
pub mod inspect_source;
pub mod logging;
pub mod modes;
pub mod plan;
pub mod replay;
pub mod report;
pub mod run;
pub mod say;
pub mod schema;
pub mod simulate;
pub mod tyre;

/// Motorcycle tyre coefficients, with honest uncertainty, from recorded riding logs.
#[derive(Debug, Parser)]
#[command(name = "roadbench", version, about, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    /// How log events are written to stderr.
    #[arg(long, value_name = "FORMAT", default_value = "text", global = true)]
    log_format: LogFormat,
    /// Log more.
    #[arg(short, long, global = true)]
    verbose: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    Run(run::Arguments),
    Diagnose(diagnose::Arguments),
    Plan(plan::Arguments),
    Simulate(simulate::Arguments),
    Modes(modes::Arguments),
    Replay(replay::Arguments),
    Tyre(tyre::Arguments),
    Inspect(inspect::Arguments),
    Convert(convert::Arguments),
    Report(report::Arguments),
    Export(export::Arguments),
    Schema(schema::Arguments),
}

/// Why a command did not do what it was asked; each has its exit code.
#[derive(Debug)]
pub enum Failure {
    /// Bad usage or configuration, nothing written: 2.
    Usage(String),
    /// Some inputs were rejected, and are listed, or the run was stopped before its end: 1.
    Rejected(String),
    /// The output could not be written: 3.
    Output(String),
}

/// The program.
pub fn main() -> ExitCode {
    ExitCode::from(main_with(std::env::args_os()))
}

/// Parses the arguments, the program's name first, runs the command, prints what went wrong, and
/// gives back the exit code.
pub fn main_with<T: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = T>) -> u8 {
    let arguments = Arguments::parse_from(arguments);
    let bar = ProgressBar::hidden();
    logging::init(arguments.log_format, arguments.verbose, &bar);
    let result = match arguments.command {
        Command::Run(a) => run::run(a, bar),
        Command::Diagnose(a) => diagnose::run(a),
        Command::Plan(a) => plan::run(&a),
        Command::Simulate(a) => simulate::run(a),
        Command::Modes(a) => modes::run(&a),
        Command::Replay(a) => replay::run(&a),
        Command::Tyre(a) => tyre::run(&a),
        Command::Inspect(a) => inspect::run(a),
        Command::Convert(a) => convert::run(a),
        Command::Report(a) => report::run(a),
        Command::Export(a) => export::run(a),
        Command::Schema(a) => schema::run(a),
    };
    let (code, message): (u8, String) = match result {
        Ok(()) => return 0,
        Err(Failure::Rejected(message)) => (1, message),
        Err(Failure::Usage(message)) => (2, message),
        Err(Failure::Output(message)) => (3, message),
    };
    match arguments.log_format {
        _ if message.is_empty() => {}
        LogFormat::Text => eprintln!("roadbench: {message}"),
        LogFormat::Json => tracing::error!(exit_code = code, "{message}"),
    }
    code
}
