//! The script and the style of the pages: inside each page, or once in a folder beside them.
//!
//! They are some 145 KB. A page that holds them can be sent as it is; thousands of pages share them. The
//! name of a shared file is a hash of its content, so that a page of another version never gets it.

use std::path::Path;
use std::sync::LazyLock;

use crate::report::error::Error;
use crate::report::kinds;
use crate::store::tables::file;

/// The style of all pages.
pub(super) static STYLE: LazyLock<String> =
    LazyLock::new(|| format!("{}{}", kinds::style(), include_str!("../../reports/style.css")));
/// The script of all pages with charts.
pub(super) static SCRIPT: LazyLock<String> = LazyLock::new(|| {
    format!("{FOLD}(async () => {{\n\"use strict\";\n{}{CHARTS}}})();\n", kinds::script())
});
const CHARTS: &str = concat!(
    include_str!("../../reports/charts/base.js"),
    include_str!("../../reports/charts/links.js"),
    include_str!("../../reports/charts/svg.js"),
    include_str!("../../reports/charts/cloud.js"),
    include_str!("../../reports/charts/fit.js"),
    include_str!("../../reports/charts/timeline.js"),
    include_str!("../../reports/charts/laps.js"),
    include_str!("../../reports/charts/main.js"),
);
/// The script of the tyre explorer.
pub(super) static EXPLORER_SCRIPT: LazyLock<String> = LazyLock::new(|| {
    format!("(async () => {{\n\"use strict\";\n{}{EXPLORER}}})();\n", kinds::script())
});
const EXPLORER: &str = concat!(
    include_str!("../../reports/charts/base.js"),
    include_str!("../../reports/charts/links.js"),
    include_str!("../../reports/charts/svg.js"),
    include_str!("../../reports/charts/tyre_model.js"),
    include_str!("../../reports/charts/explorer.js"),
);
const FOLD: &str = include_str!("../../reports/charts/fold.js");
/// The script of long tables.
pub(super) const LONG_SCRIPT: &str = include_str!("../../reports/charts/long.js");
/// The script of pages with long tables and without charts.
pub(super) const INDEX_SCRIPT: &str = concat!(
    include_str!("../../reports/charts/fold.js"),
    include_str!("../../reports/charts/long.js")
);
pub(super) const UPLOT_SCRIPT: &str = include_str!("../../reports/vendor/uplot/uPlot.iife.min.js");
pub(super) const UPLOT_STYLE: &str = include_str!("../../reports/vendor/uplot/uPlot.min.css");

/// The folder of the shared files, below that of the pages.
pub(crate) const FOLDER: &str = "assets";
/// Largest number of pages that each hold all they need, where nothing else is asked for.
pub(crate) const MAX_SELF_CONTAINED: usize = 50;
/// Largest number of sessions whose pages are all written, where nothing else is asked for.
pub(crate) const MAX_WRITTEN: usize = 1000;
/// The shared file that names the pages of sessions that there are: pages written one by one are
/// links without a new page of the run.
const WRITTEN: &str = "pages.js";
/// First bytes of a shared file.
const ASSET_MARK: &str = "/* roadbench report */\n";

/// Form of the pages of the sessions.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Pages {
    /// Self-contained up to 50 sessions, shared above, on demand above 1000; pages that are there stay
    /// as they are.
    #[default]
    Auto,
    /// Each page is one file that opens wherever it is.
    SelfContained,
    /// Script and style once in `assets`, beside the pages.
    Shared,
    /// Of a session only those that are there; `report --open` writes one more.
    OnDemand,
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
            Pages::Shared | Pages::OnDemand => Source::Folder,
            Pages::Auto if pages > MAX_SELF_CONTAINED => Source::Folder,
            Pages::Auto => Source::Page,
        }
    }

    /// Whether a session's page is written only when somebody asks for it, given the number of sessions.
    pub(super) fn on_demand(self, sessions: usize) -> bool {
        self == Pages::OnDemand || self == Pages::Auto && sessions > MAX_WRITTEN
    }

    /// Whether an existing page with that source may be kept.
    pub(super) fn accepts(self, source: Source) -> bool {
        match self {
            Pages::Auto | Pages::OnDemand => true,
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

/// Writes which pages of sessions there are.
pub(super) fn write_written<'a>(
    folder: &Path,
    pages: impl Iterator<Item = &'a str>,
) -> Result<(), Error> {
    // names of pages are letters, digits and `-_.`
    let names = serde_json::to_string(&pages.filter(|p| !p.is_empty()).collect::<Vec<_>>())?;
    let text = format!("{ASSET_MARK}window.roadbenchPages = {names};\n");
    Ok(file::write_bytes(folder.join(FOLDER).join(WRITTEN), text.as_bytes())?)
}

/// Whether the page of the run looks up which pages there are.
pub(super) fn has_written(folder: &Path) -> bool {
    folder.join(FOLDER).join(WRITTEN).is_file()
}

/// Removes the shared files of other versions, and all of them unless they are `needed`; the list of
/// pages unless pages are written on `demand`. A file that cannot be removed stays.
pub(super) fn remove_stale(folder: &Path, needed: bool, demand: bool) {
    let current = name();
    let assets = folder.join(FOLDER);
    let Ok(entries) = std::fs::read_dir(&assets) else { return };
    for path in entries.flatten().map(|e| e.path()) {
        let kept = needed && path.file_stem().is_some_and(|s| s == current.as_str())
            || demand && path.file_name().is_some_and(|n| n == WRITTEN);
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
        assert!(!Pages::Auto.on_demand(MAX_WRITTEN) && Pages::Auto.on_demand(MAX_WRITTEN + 1));
        assert!(!Pages::Shared.on_demand(10_000) && Pages::OnDemand.on_demand(1));
    }
}
