//! How far a run is: a bar for people at a terminal, one log event per session for everybody.

use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::batch::workers::watch::{Finished, State, Watch};

/// Draws the bar and writes the events.
#[derive(Debug)]
pub(crate) struct Progress {
    bar: ProgressBar,
    show: bool,
    bytes: AtomicU64,
    rejected: AtomicUsize,
}

impl Progress {
    /// On a bar that is hidden still; it appears with the first session if `show`, and only
    /// where stderr is a terminal.
    pub(crate) fn new(bar: ProgressBar, show: bool) -> Self {
        Progress { bar, show, bytes: AtomicU64::new(0), rejected: AtomicUsize::new(0) }
    }

    /// Does something, such as writing to the terminal, while the bar is out of the way.
    pub(crate) fn aside<T>(&self, what: impl FnOnce() -> T) -> T {
        self.bar.suspend(what)
    }

    /// Takes the bar away.
    pub(crate) fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

/// Has a bar move by itself, where it is seen and there is a thread for that: without one its own call ends the program.
pub(crate) fn tick(bar: &ProgressBar) {
    if !bar.is_hidden() && std::thread::Builder::new().spawn(|| {}).is_ok() {
        bar.enable_steady_tick(Duration::from_millis(250));
    }
}

impl<R> Watch<R> for Progress {
    fn planned(&self, logs: &[String], bytes: u64) {
        let inputs = logs.len();
        tracing::debug!(inputs, bytes, "planned");
        if !self.show || inputs < 2 {
            return;
        }
        let style = ProgressStyle::with_template(
            "{bar:30} {pos}/{len} sessions  {per_sec}  {msg}  {eta} left",
        );
        if let Ok(style) = style {
            self.bar.set_style(style.progress_chars("=> ").with_key(
                "per_sec",
                |state: &indicatif::ProgressState, out: &mut dyn std::fmt::Write| {
                    let _ = write!(out, "{:.1}/s", state.per_sec());
                },
            ));
        }
        self.bar.set_length(inputs as u64);
        self.bar.set_draw_target(ProgressDrawTarget::stderr()); // draws nothing on no terminal
        self.bar.reset();
        tick(&self.bar);
    }

    fn finished(&self, f: &Finished<'_>, _: Option<R>) {
        let id = f.session_id.unwrap_or("");
        let (seconds, samples) = ((f.seconds * 1e3).round() / 1e3, f.samples);
        match (f.state, f.why) {
            (State::Done, _) => {
                tracing::info!(session = id, log = f.log, seconds, samples, status = "done");
            }
            (State::Unchanged, _) => {
                tracing::info!(session = id, log = f.log, seconds, status = "unchanged");
            }
            (State::Rejected, why) => {
                let (code, message) = why.unwrap_or_default();
                tracing::info!(
                    session = id,
                    log = f.log,
                    seconds,
                    status = "rejected",
                    code,
                    "{message}"
                );
            }
        }
        let rejected = match f.state {
            State::Rejected => self.rejected.fetch_add(1, Ordering::Relaxed) + 1,
            _ => self.rejected.load(Ordering::Relaxed),
        };
        let bytes = self.bytes.fetch_add(f.bytes, Ordering::Relaxed) + f.bytes;
        let rate = bytes as f64 / 1e6 / self.bar.elapsed().as_secs_f64().max(1e-3);
        let refused = if rejected > 0 { format!("  {rejected} rejected") } else { String::new() };
        self.bar.set_message(format!("{rate:.1} MB/s{refused}"));
        self.bar.inc(1);
        if f.state == State::Unchanged {
            self.bar.reset_eta(); // it took no time: the time left is that of the others
        }
    }
}
