//! What every page shares: its template, its first bytes, and what it was made of.

use std::collections::BTreeSet;
use std::io::Read;
use std::path::Path;

use minijinja::syntax::SyntaxConfig;
use minijinja::{Environment, Value, context};

use crate::report::assets::{self, SCRIPT, STYLE, Source, UPLOT_SCRIPT, UPLOT_STYLE};
use crate::store::objects::replace::sync_folder;
use crate::store::tables::rows::SessionRow;

const TEMPLATES: &[(&str, &str)] = &[
    ("base.html", include_str!("../../reports/base.html")),
    ("scripts.html", include_str!("../../reports/scripts.html")),
    ("list.html", include_str!("../../reports/list.html")),
    ("run.html", include_str!("../../reports/run.html")),
    ("bike.html", include_str!("../../reports/bike.html")),
    ("what_changed.html", include_str!("../../reports/what_changed.html")),
    ("bike_tables.html", include_str!("../../reports/bike_tables.html")),
    ("session.html", include_str!("../../reports/session.html")),
    ("laps.html", include_str!("../../reports/laps.html")),
    ("tyres.html", include_str!("../../reports/tyres.html")),
    ("fleet.html", include_str!("../../reports/fleet.html")),
    ("comparison.html", include_str!("../../reports/comparison.html")),
    ("diagnosis.html", include_str!("../../reports/diagnosis.html")),
];

/// First bytes of every page, by which a later build recognises a page of roadbench's.
pub(super) const MARK: &str = "<!doctype html>\n<!-- roadbench report -->";

/// Whether a file of the report's folder was built by roadbench.
pub(crate) fn is_own(file: &[u8]) -> bool {
    file.starts_with(MARK.as_bytes()) || assets::is_own(file)
}

/// The templates, with a filter `svg` for drawings that need no escaping.
///
/// # Errors
/// A template does not parse: a mistake in this program.
pub(super) fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.add_filter("svg", |drawing: String| Value::from_safe_string(drawing));
    for (name, text) in TEMPLATES {
        environment.add_template(name, text)?;
    }
    Ok(environment)
}

/// Style and script of the templates; all of it this program's own text.
pub(super) fn context(source: Source) -> Value {
    let own = |text: &str| Value::from_safe_string(text.to_owned());
    let embedded = context! {
        mark => own(MARK),
        style => own(&STYLE),
        script => own(&SCRIPT),
        uplot_script => own(UPLOT_SCRIPT),
        uplot_style => own(UPLOT_STYLE),
        version => crate::VERSION,
    };
    match source {
        Source::Page => embedded,
        Source::Folder => context! { assets => own(&assets::stem()), ..embedded },
    }
}

/// Inputs of a session's page: its tables' own provenance and how many `rows` of it they have, its diagnosis (page
/// and causes), the bench values, the pages that it leads to, the templates. As the start of an HTML comment.
pub(super) fn fingerprint(
    session: &SessionRow,
    rows: &[usize],
    diagnosis: [&str; 2],
    bench: &str,
    links: [&str; 2],
) -> String {
    let provenance = &session.provenance;
    let mut hasher = blake3::Hasher::new();
    for part in [&provenance.input_hash, &provenance.pipeline_hash, &provenance.version] {
        hasher.update(part.as_bytes()).update(b"\n");
    }
    rows.iter().for_each(|n| _ = hasher.update(format!("{n}\n").as_bytes()));
    hasher.update(session.path.as_bytes()).update(b"\n").update(bench.as_bytes());
    for link in diagnosis.into_iter().chain(links) {
        hasher.update(link.as_bytes()).update(b"\n");
    }
    let own = [STYLE.as_str(), SCRIPT.as_str(), UPLOT_SCRIPT, UPLOT_STYLE];
    for text in TEMPLATES.iter().map(|(_, text)| *text).chain(own) {
        hasher.update(text.as_bytes());
    }
    format!("<!-- made of {}", hasher.finalize().to_hex())
}

/// Puts a [`fingerprint`] and the source of style and script at the head of a page.
pub(super) fn stamped(html: &str, fingerprint: &str, source: Source) -> String {
    html.replacen(MARK, &format!("{MARK}\n{fingerprint}, {} -->", source.name()), 1)
}

/// Where an existing page has its script and style from, if it has this very [`fingerprint`].
pub(super) fn source_if_current(page: &Path, fingerprint: &str) -> Option<Source> {
    let mut head = Vec::new();
    let most = MARK.len() + fingerprint.len() + 64;
    std::fs::File::open(page).ok()?.take(most as u64).read_to_end(&mut head).ok()?;
    let rest = head.strip_prefix(MARK.as_bytes())?.strip_prefix(b"\n")?;
    let rest = rest.strip_prefix(fingerprint.as_bytes())?.strip_prefix(b", ")?;
    [Source::Page, Source::Folder].into_iter().find(|s| rest.starts_with(s.name().as_bytes()))
}

/// Names of all pages in the folder, whichever run wrote them.
pub(super) fn written(folder: &Path) -> BTreeSet<String> {
    let Ok(entries) = std::fs::read_dir(folder) else { return BTreeSet::new() };
    entries.flatten().map(|e| e.file_name().to_string_lossy().into_owned()).collect()
}

/// Removes pages of an earlier build that are not among `pages`. One that cannot be removed stays:
/// no page links to it.
pub(super) fn remove_stale(folder: &Path, pages: &[&str]) {
    let kept: BTreeSet<&str> = pages.iter().copied().collect();
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    let mut is_changed = false;
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !name.ends_with(".html") || name == "index.html" || kept.contains(name.as_ref()) {
            continue;
        }
        if std::fs::read(entry.path()).is_ok_and(|page| is_own(&page)) {
            is_changed |= std::fs::remove_file(entry.path()).is_ok();
        }
    }
    if is_changed {
        // the page of a session that was forgotten must not come back after a power cut
        let _ = sync_folder(folder);
    }
}
