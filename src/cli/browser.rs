//! Opening a page in the browser.

use std::io::IsTerminal;
use std::path::Path;

/// Opens the report on an interactive terminal with a display.
pub(crate) fn open(page: &Path) {
    let has = |name: &str| std::env::var_os(name).is_some_and(|v| !v.is_empty());
    let display = !cfg!(target_os = "linux") || has("DISPLAY") || has("WAYLAND_DISPLAY");
    if !(display && std::io::stdout().is_terminal()) {
        return;
    }
    if let Err(e) = open::that_detached(page) {
        tracing::warn!("cannot open {}: {e}", page.display());
    }
}
