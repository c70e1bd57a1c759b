//! The command line: one file per command, nothing here but the list and the exit codes.

use std::any::Any;
use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use indicatif::ProgressBar;
use say::tell;

use crate::batch::workers::threads::STACK;
use crate::batch::workers::{fence, threads};

use colour::Colour;
use failure::Failure;
use logging::LogFormat;

pub(crate) mod batch;
pub(crate) mod bike;
pub(crate) mod browser;
pub(crate) mod choices;
pub(crate) mod colour;
pub(crate) mod compare;
pub(crate) mod convert;
pub(crate) mod demo;
pub(crate) mod diagnose;
pub(crate) mod examples;
pub(crate) mod export;
pub(crate) mod failure;
pub(crate) mod forget;
pub(crate) mod inspect;
pub(crate) mod inspect_source;
mod json;
mod location;
mod log;
pub(crate) mod logging;
mod machine;
pub(crate) mod map;
pub(crate) mod modes;
mod number;
pub(crate) mod plan;
pub(crate) mod progress;
pub(crate) mod replay;
pub(crate) mod report;
pub(crate) mod run;
pub(crate) mod say;
pub(crate) mod schema;
pub(crate) mod shell;
pub(crate) mod show;
pub(crate) mod simulate;
mod steps;
pub(crate) mod tyre;
pub(crate) mod tyre_measured;
pub(crate) mod verify;
mod version;

/// Motorcycle tyre coefficients, with confidence intervals, from riding logs.
#[derive(Debug, Parser)]
#[command(name = "roadbench", version, long_version = version::long(), about, max_term_width = 80)]
#[command(after_help = examples::ROADBENCH)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

/// Options of every command.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = GLOBAL)]
struct Global {
    /// Sessions, rides or pages at the same time; 0 takes one per core.
    #[arg(short, long, value_name = "N", default_value_t = 0, global = true)]
    #[arg(env = "ROADBENCH_JOBS", hide_env_values = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(..=1024))]
    jobs: u16,
    /// No progress, summary or notes: warnings, errors and what was asked for.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    /// Log more; -vv logs what the libraries trace, too.
    #[arg(short, long, action = clap::ArgAction::Count, global = true)]
    verbose: u8,
    /// How log events are written to stderr.
    #[arg(long, value_name = "FORMAT", default_value = "text", global = true)]
    log_format: LogFormat,
    /// When to use colours.
    #[arg(long, value_name = "WHEN", default_value = "auto", global = true)]
    color: Colour,
}

/// Heading of the options of every command.
const GLOBAL: &str = "Global options";

/// The commands as `--help` lists them. One that is in no group is not listed, and a test fails.
const GROUPS: [(&str, &[&str]); 4] = [
    ("Analyse", &["run", "diagnose", "show", "compare", "report", "export"]),
    ("Prepare", &["inspect", "map", "convert", "bike"]),
    ("Simulate", &["demo", "plan", "simulate", "replay", "modes", "tyre"]),
    ("Maintain", &["verify", "forget", "schema", "completions", "man"]),
];

#[derive(Debug, Subcommand)]
enum Command {
    #[command(after_help = examples::RUN)]
    Run(run::Arguments),
    #[command(after_help = examples::DIAGNOSE)]
    Diagnose(diagnose::Arguments),
    #[command(after_help = examples::SHOW)]
    Show(show::Arguments),
    #[command(after_help = examples::COMPARE)]
    Compare(compare::Arguments),
    #[command(after_help = examples::PLAN)]
    Plan(plan::Arguments),
    #[command(after_help = examples::SIMULATE)]
    Simulate(simulate::Arguments),
    #[command(after_help = examples::MODES)]
    Modes(modes::Arguments),
    #[command(after_help = examples::REPLAY)]
    Replay(replay::Arguments),
    #[command(after_help = examples::TYRE)]
    Tyre(tyre::Arguments),
    #[command(after_help = examples::INSPECT)]
    Inspect(inspect::Arguments),
    #[command(after_help = examples::BIKE)]
    Bike(bike::Arguments),
    #[command(after_help = examples::MAP)]
    Map(map::Arguments),
    #[command(after_help = examples::CONVERT)]
    Convert(convert::Arguments),
    #[command(after_help = examples::REPORT)]
    Report(report::Arguments),
    #[command(after_help = examples::FORGET)]
    Forget(forget::Arguments),
    #[command(after_help = examples::VERIFY)]
    Verify(verify::Arguments),
    #[command(after_help = examples::EXPORT)]
    Export(export::Arguments),
    #[command(after_help = examples::SCHEMA)]
    Schema(schema::Arguments),
    #[command(after_help = examples::DEMO)]
    Demo(demo::Arguments),
    #[command(after_help = examples::COMPLETIONS)]
    Completions(shell::Completions),
    #[command(after_help = examples::MAN)]
    Man(shell::Man),
}

/// The program.
pub fn main() -> ExitCode {
    ExitCode::from(main_with(std::env::args_os()))
}

/// Parses the arguments, the program's name first, runs the command, prints what went wrong, and
/// gives back the exit code.
pub fn main_with<T: Into<OsString> + Clone>(arguments: impl IntoIterator<Item = T>) -> u8 {
    outgrown_files_are_errors();
    let arguments: Vec<OsString> = arguments.into_iter().map(Into::into).collect();
    if arguments.get(1).is_some_and(|first| first == fence::WORKER) {
        return fence::serve::serve();
    }
    // the main thread's stack may be small (`ulimit -s`)
    let done = std::thread::scope(|scope| {
        let thread = std::thread::Builder::new().name("roadbench".to_owned()).stack_size(STACK);
        match thread.spawn_scoped(scope, || commanded(&arguments)) {
            Ok(thread) => thread.join(),
            Err(_) => catch_unwind(|| commanded(&arguments)), // where there is no other, this one
        }
    });
    done.unwrap_or_else(|panic| {
        let (code, message) = ended(&*panic).parts();
        tell!("roadbench: {message}\n");
        code
    })
}

/// A command that came to an end nobody had foreseen.
fn ended(panic: &(dyn Any + Send)) -> Failure {
    let text = panic.downcast_ref::<&str>().map(|s| (*s).to_owned());
    let text = text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_default();
    Failure::Output(format!(
        "it ended unforeseen ({}). If that says that memory, processes or open files are missing, give it more (`ulimit -a`), or \
         fewer --jobs; else it is a mistake in roadbench, please report it",
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    ))
}

fn commanded(arguments: &[OsString]) -> u8 {
    let program = without_empty(command()).color(Colour::of(arguments).into());
    let parsed = Arguments::from_arg_matches(&program.get_matches_from(arguments));
    let arguments = parsed.unwrap_or_else(|e| e.exit());
    let Global { jobs, quiet, verbose, log_format, color } = arguments.global;
    color.take();
    say::set_quiet(quiet);
    say::set_verbose(verbose > 0);
    let bar = ProgressBar::hidden();
    logging::init(log_format, verbose, quiet, &bar);
    let command = || match arguments.command {
        Command::Run(a) => run::run(a, bar),
        Command::Diagnose(a) => diagnose::run(a, bar),
        Command::Show(a) => show::run(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Plan(a) => plan::run(&a, bar),
        Command::Simulate(a) => simulate::run(a, bar),
        Command::Modes(a) => modes::run(&a),
        Command::Replay(a) => replay::run(&a, bar),
        Command::Tyre(a) => tyre::run(&a),
        Command::Inspect(a) => inspect::run(a),
        Command::Bike(a) => bike::run(a),
        Command::Map(a) => map::run(a),
        Command::Convert(a) => convert::run(a),
        Command::Report(a) => report::run(a),
        Command::Forget(a) => forget::run(a),
        Command::Verify(a) => verify::run(a),
        Command::Export(a) => export::run(a),
        Command::Schema(a) => schema::run(a),
        Command::Demo(a) => demo::run(&a, bar),
        Command::Completions(a) => shell::completions(&a, self::command()),
        Command::Man(a) => shell::man(&a, self::command()),
    };
    // nothing that is looked at afterwards is left half-done
    let done = catch_unwind(AssertUnwindSafe(|| with_jobs(jobs, command)));
    let result = done.unwrap_or_else(|panic| Err(ended(&*panic)));
    let Err(failure) = result else { return 0 };
    let (code, message) = failure.parts();
    match log_format {
        _ if message.is_empty() => {}
        LogFormat::Text => {
            tell!("{} {message}\n", colour::red("roadbench:", colour::on_stderr()));
        }
        LogFormat::Json => tracing::error!(exit_code = code, "{message}"),
    }
    code
}

/// A file that grows beyond what its user may write (`ulimit -f`) is an error then, as a full disk is: by itself the system
/// ends the program without a word.
fn outgrown_files_are_errors() {
    #[cfg(unix)]
    {
        let seen = std::sync::Arc::default(); // nobody asks: the write fails, too
        let _ = signal_hook::flag::register(signal_hook::consts::SIGXFSZ, seen);
    }
}

/// The whole command line, its commands in groups.
pub fn command() -> clap::Command {
    let program = Arguments::command();
    let template = grouped(&program);
    program.help_template(template)
}

/// The help of the program, with a heading for each of [`GROUPS`]; clap has one for all commands.
fn grouped(program: &clap::Command) -> String {
    let (heading, literal) =
        (program.get_styles().get_header(), program.get_styles().get_literal());
    let width = GROUPS.iter().flat_map(|g| g.1).map(|name| name.len()).max().unwrap_or(0);
    let mut text = "{about-with-newline}\n{usage-heading} {usage}\n\n".to_owned();
    for (group, names) in GROUPS {
        text += &format!("{heading}{group}:{heading:#}\n");
        for command in names.iter().filter_map(|name| program.find_subcommand(name)) {
            let (name, about) = (command.get_name(), command.get_about());
            let about = about.map(ToString::to_string).unwrap_or_default();
            text +=
                &format!("  {literal}{name}{literal:#}{:1$}  {about}\n", "", width - name.len());
        }
        text.push('\n');
    }
    text += &format!("{heading}{GLOBAL}:{heading:#}\n{{options}}{{after-help}}");
    text
}

/// Takes variables that are set, but to nothing, as not set.
fn without_empty(program: clap::Command) -> clap::Command {
    let argument = |a: clap::Arg| {
        let is_empty = a.get_env().and_then(std::env::var_os).is_some_and(|value| value.is_empty());
        if is_empty { a.env(clap::builder::Resettable::Reset) } else { a }
    };
    program.mut_args(argument).mut_subcommands(without_empty)
}

/// A command whose parallel work has so many threads.
fn with_jobs(
    jobs: u16,
    command: impl FnOnce() -> Result<(), Failure> + Send,
) -> Result<(), Failure> {
    let taken = threads::taken(jobs.into());
    if usize::from(jobs) > taken {
        tracing::warn!(
            "--jobs {jobs}: more than {taken} make nothing faster on this machine; {taken} are taken"
        );
    }
    let most = machine::most_threads()?;
    if most < taken {
        tracing::warn!(
            "the memory that is allowed (`ulimit -v`, `ulimit -d`) has room for {most} of {taken} threads"
        );
    }
    match threads::pool(taken.min(most)) {
        Some(pool) => pool.install(command),
        None => threads::alone(command),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The words of a line as a shell would hand them over; nothing after a redirection or a
    /// remark after three spaces.
    fn words(line: &str) -> Vec<String> {
        let line = line.split(" > ").next().unwrap_or(line);
        let line = line.split("   ").next().unwrap_or(line);
        line.split_whitespace().map(|w| w.trim_matches('\'').to_owned()).collect()
    }

    #[test]
    fn a_command_has_the_jobs_that_it_is_given() {
        for jobs in [1, 3] {
            let has = || match rayon::current_num_threads() == usize::from(jobs) {
                true => Ok(()),
                false => Err(Failure::Usage(format!("not {jobs}"))),
            };
            assert!(with_jobs(jobs, has).is_ok(), "{jobs}");
        }
    }

    #[test]
    fn every_command_shows_examples_that_parse() {
        let mut program = Arguments::command();
        program.build();
        let commands = program.get_subcommands().filter(|c| c.get_name() != "help");
        for command in std::iter::once(&program).chain(commands) {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<&str> =
                help.lines().map(str::trim).filter(|l| l.starts_with("roadbench ")).collect();
            assert!(!lines.is_empty(), "`{}` shows no example", command.get_name());
            for line in lines {
                let with_jobs = [words(line), vec!["--jobs".into(), "2".into()]].concat();
                for line in [words(line), with_jobs] {
                    if let Err(e) = Arguments::try_parse_from(&line) {
                        panic!("{line:?}\n{e}");
                    }
                }
                let own = command.get_name() == "roadbench"
                    || line.starts_with(&format!("roadbench {}", command.get_name()));
                assert!(own, "`{line}` in the help of `{}`", command.get_name());
            }
        }
    }
}
