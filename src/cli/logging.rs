//! Where log events go: stderr, as text or JSON lines, around the progress bar.

use std::io::{self, IsTerminal, Write};

use indicatif::ProgressBar;
use tracing::level_filters::LevelFilter;
use tracing_subscriber::fmt;

use crate::store::objects::plain::plain;

/// How log events are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum LogFormat {
    /// For people.
    #[default]
    Text,
    /// One JSON object per line.
    Json,
}

/// Sends events to stderr; the bar steps aside for each line.
///
/// Text at a terminal is for a person, who sees the bar and the list of what was rejected:
/// only what needs attention is logged. Elsewhere there is an event per session, unless `quiet`.
/// `verbose` shows more, above 1 what the libraries trace too.
pub(crate) fn init(format: LogFormat, verbose: u8, quiet: bool, bar: &ProgressBar) {
    let level = match (verbose, format) {
        (2.., _) => LevelFilter::TRACE,
        (1, _) => LevelFilter::DEBUG,
        (0, _) if quiet => LevelFilter::WARN,
        (0, LogFormat::Text) if io::stderr().is_terminal() => LevelFilter::WARN,
        (0, _) => LevelFilter::INFO,
    };
    let bar = bar.clone();
    let writer = move || Lines { bar: bar.clone() };
    let builder = fmt().with_max_level(level).with_writer(writer);
    // a second initialisation (in tests) keeps the first
    let _ = match format {
        LogFormat::Text => builder
            .with_target(false)
            .with_ansi(super::colour::on_stderr())
            .without_time()
            .try_init(),
        LogFormat::Json => builder
            .json()
            .flatten_event(true)
            .with_target(false)
            .with_current_span(false)
            .with_span_list(false)
            .try_init(),
    };
    std::panic::set_hook(Box::new(|panic| {
        // the batch catches it and goes on; the place is what a bug report needs
        let text = panic.to_string();
        tracing::error!(
            "internal error: {}",
            text.split_whitespace().collect::<Vec<_>>().join(" ")
        );
    }));
}

/// Stderr, with the bar out of the way.
struct Lines {
    bar: ProgressBar,
}

impl Write for Lines {
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        let text = String::from_utf8_lossy(line);
        // a full disk or a pipe that has ended behind stderr is no reason to stop; an error would make the
        // subscriber say so on stderr, which panics
        let _ = self.bar.suspend(|| io::stderr().write_all(plain(&text).as_bytes()));
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        let _ = io::stderr().flush();
        Ok(())
    }
}
