//! The script and the style of the pages: inside each page, or once in a folder beside them.
//!
//! They are 91 KB. A page that holds them can be sent as it is; thousands of pages share them. The
//! name of a shared file is a hash of its content, so that a page of another version never gets it.

use std::path::Path;
use std::sync::LazyLock;

use crate::report::error::Error;
use crate::report::kinds;
use crate::tables::file;

/// The style of all pages.
pub(super) static STYLE: LazyLock<String> =
    LazyLock::new(|| format!("{}{}", kinds::style(), include_str!("../../reports/style.css")));
/// The script of all pages with charts.
pub(super) static SCRIPT: LazyLock<String> = LazyLock::new(|| {
    format!("(async () => {{\n\"use strict\";\n{}{CHARTS}}})();\n", kinds::script())
});
const CHARTS: &str = concat!(
    include_str!("../../reports/charts/base.js"),
    include_str!("../../reports/charts/cloud.js"),
    include_str!("../../reports/charts/fit.js"),
    include_str!("../../reports/charts/timeline.js"),
    include_str!("../../reports/charts/laps.js"),
    include_str!("../../reports/charts/main.js"),
);
/// The script of long tables, on the page of the run alone.
pub(super) const LONG_SCRIPT: &str = include_str!("../../reports/charts/long.js");
pub(super) const UPLOT_SCRIPT: &str = include_str!("../../reports/vendor/uplot/uPlot.iife.min.js");
pub(super) const UPLOT_STYLE: &str = include_str!("../../reports/vendor/uplot/uPlot.min.css");

/// The folder of the shared files, below that of the pages.
pub const FOLDER: &str = "assets";
/// Largest number of pages that each hold all they need, where nothing else is asked for.
pub const MAX_SELF_CONTAINED: usize = 50;
/// First bytes of a shared file.
const ASSET_MARK: &str = "/* roadbench report */\n";

/// What the pages of the sessions are like.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum)]
pub enum Pages {
    /// Self-contained up to 50 sessions, shared above; pages that are there stay as they are.
    #[default]
    Auto,
    /// Each page is one file that opens wherever it is.
    SelfContained,
    /// Script and style once in `assets`, beside the pages.
    Shared,
    /// Of the run, the fleet and diagnoses alone, none of a session.
    None,
}

/// Where a page has its script and style.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Source {
    Page,
    Folder,
}

impl Source {
    /// Name in the comment at the head of a page.
    pub(super) fn name(self) -> &'static str {
        match self {
            Source::Page => "self-contained",
            Source::Folder => "shared",
        }
    }
}

impl Pages {
    /// Where a page that is written now has style and script from, given the number of pages.
    pub(super) fn source(self, pages: usize) -> Source {
        match self {
            Pages::SelfContained | Pages::None => Source::Page,
            Pages::Shared => Source::Folder,
            Pages::Auto if pages > MAX_SELF_CONTAINED => Source::Folder,
            Pages::Auto => Source::Page,
        }
    }

    /// Whether an existing page with that source may be kept.
    pub(super) fn accepts(self, source: Source) -> bool {
        match self {
            Pages::Auto => true,
            Pages::SelfContained => source == Source::Page,
            Pages::Shared => source == Source::Folder,
            Pages::None => false,
        }
    }
}

/// Extension and content of the shared files, script first.
fn contents() -> [(&'static str, String); 2] {
    [
        ("js", format!("{ASSET_MARK}{UPLOT_SCRIPT}\n{}", *SCRIPT)),
        ("css", format!("{ASSET_MARK}{UPLOT_STYLE}\n{}", *STYLE)),
    ]
}

/// Name of the shared files without extension.
fn name() -> String {
    let mut hasher = blake3::Hasher::new();
    for (_, text) in contents() {
        hasher.update(text.as_bytes());
    }
    format!("report-{}", &hasher.finalize().to_hex()[..12])
}

/// Path of the shared files relative to a page, without extension.
pub(super) fn stem() -> String {
    format!("{FOLDER}/{}", name())
}

/// Writes the shared files into the report's folder, unless they are there.
pub(super) fn write(folder: &Path) -> Result<(), Error> {
    let name = name();
    for (ending, text) in contents() {
        let path = folder.join(FOLDER).join(format!("{name}.{ending}"));
        if std::fs::read(&path).is_ok_and(|there| there == text.as_bytes()) {
            continue;
        }
        file::write_bytes(&path, text.as_bytes())?;
    }
    Ok(())
}

/// Removes the shared files of other versions, and all of them unless they are `needed`. A file that
/// cannot be removed stays.
pub(super) fn remove_stale(folder: &Path, needed: bool) {
    let current = name();
    let assets = folder.join(FOLDER);
    let Ok(entries) = std::fs::read_dir(&assets) else { return };
    for path in entries.flatten().map(|e| e.path()) {
        let kept = needed && path.file_stem().is_some_and(|s| s == current.as_str());
        if !kept && std::fs::read(&path).is_ok_and(|bytes| is_own(&bytes)) {
            let _ = std::fs::remove_file(path);
        }
    }
    // only where nothing else is in it
    let _ = std::fs::remove_dir(assets);
}

/// Whether a file is a shared file written by roadbench.
pub(super) fn is_own(file: &[u8]) -> bool {
    file.starts_with(ASSET_MARK.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_pages_share_unless_somebody_says_otherwise() {
        assert_eq!(Pages::Auto.source(MAX_SELF_CONTAINED), Source::Page);
        assert_eq!(Pages::Auto.source(MAX_SELF_CONTAINED + 1), Source::Folder);
        assert_eq!(Pages::SelfContained.source(10_000), Source::Page);
        assert_eq!(Pages::Shared.source(1), Source::Folder);
    }
}
