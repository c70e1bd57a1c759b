//! Progress of commands that are no batch: how much there is to do, said before, and a bar at a terminal.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use crate::cli::progress::tick;
use crate::cli::say;

/// Pieces of work of one kind, done one after the other or side by side. The bar goes with it.
#[derive(Debug)]
pub(super) struct Steps(ProgressBar);

impl Steps {
    /// Says how much there is to do; `what` is what a piece is called, many of them. `bar` is hidden still, and log events
    /// step aside for it.
    pub(super) fn begin(bar: ProgressBar, many: usize, what: &str) -> Self {
        tracing::info!("{many} {what}");
        let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}  {eta} left");
        if let Ok(style) = style {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.set_length(many as u64);
        bar.set_message(what.to_owned());
        if !say::is_quiet() {
            bar.set_draw_target(ProgressDrawTarget::stderr()); // draws nothing on no terminal
        }
        bar.reset();
        tick(&bar);
        Steps(bar)
    }

    /// One more is done.
    pub(super) fn done(&self) {
        self.0.inc(1);
    }
}

impl Drop for Steps {
    fn drop(&mut self) {
        self.0.finish_and_clear();
    }
}
