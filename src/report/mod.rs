//! The report: a pure function of the tables.
//!
//! [`write()`] reads the tables of an output folder and writes `report/index.html` and one page
//! per session beside it, and one per diagnosed session ([`diagnosis_pages`]). A page opens from disk,
//! offline: it holds all it needs, or, of many, its data alone, with style and script in a folder
//! beside them ([`assets`]). The templates are in `reports/`; the chart library is embedded whole.
//!
//! Texts from logs are hostile until escaped: the templates escape every value, and the data
//! inside a script is packed ([`figures::pack`]).

use std::collections::BTreeSet;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use minijinja::syntax::SyntaxConfig;
use minijinja::value::Serde;
use minijinja::{Environment, Value, context};
use rayon::prelude::*;

use crate::tables::{file, rows};
use assets::Source;

pub use assets::Pages;

pub mod assets;
pub mod bars;
pub mod bench;
pub mod diagnosis;
pub mod diagnosis_pages;
pub mod drawing;
pub mod extended;
pub mod figures;
pub mod fleet;
pub mod forces;
pub mod index;
pub mod markdown;
pub mod names;
pub mod number;
pub mod page;
pub mod plots_diagnosis;
pub mod publish;
pub mod ratios;
pub mod still;
pub mod svg;
pub mod tables;
pub mod tables_diagnosis;
pub mod tables_fleet;
pub mod terminal;
pub mod words;
pub mod words_diagnosis;

/// What can go wrong with a report.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The folder holds none of our tables.
    #[error(
        "{path} holds no `sessions`, `rejected`, `causes` or `discrepancies` tables: name the \
         folder that `roadbench run` or `roadbench diagnose` wrote with --out"
    )]
    NotAnOutput {
        /// The folder.
        path: PathBuf,
    },
    /// A table cannot be read.
    #[error("cannot read {path}: {message}")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why not.
        message: String,
    },
    /// A page cannot be written.
    #[error(transparent)]
    Write(#[from] file::Error),
    /// A figure cannot be drawn as PNG.
    #[error("cannot draw {path}: {message}")]
    Figure {
        /// The file.
        path: PathBuf,
        /// Why not.
        message: String,
    },
    /// A template is wrong: our own mistake.
    #[error("report template: {0}")]
    Template(#[from] minijinja::Error),
    /// A page's data cannot be written as JSON: our own mistake.
    #[error("report data: {0}")]
    Data(#[from] serde_json::Error),
}

const STYLE: &str = include_str!("../../reports/style.css");
const SCRIPT: &str = concat!(
    "(async () => {\n\"use strict\";\n",
    include_str!("../../reports/charts/base.js"),
    include_str!("../../reports/charts/cloud.js"),
    include_str!("../../reports/charts/fit.js"),
    include_str!("../../reports/charts/timeline.js"),
    include_str!("../../reports/charts/main.js"),
    "})();\n",
);
const LONG_SCRIPT: &str = include_str!("../../reports/charts/long.js");
const UPLOT_SCRIPT: &str = include_str!("../../reports/vendor/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../../reports/vendor/uplot/uPlot.min.css");
const TEMPLATES: &[(&str, &str)] = &[
    ("base.html", include_str!("../../reports/base.html")),
    ("scripts.html", include_str!("../../reports/scripts.html")),
    ("run.html", include_str!("../../reports/run.html")),
    ("session.html", include_str!("../../reports/session.html")),
    ("fleet.html", include_str!("../../reports/fleet.html")),
    ("diagnosis.html", include_str!("../../reports/diagnosis.html")),
];

/// Tables of which one at least makes a folder an output.
const SIGNS: [&str; 4] = ["sessions", "rejected", "causes", "discrepancies"];

/// First bytes of every page, by which a rebuild knows its own.
const MARK: &str = "<!doctype html>\n<!-- roadbench report -->";

/// Whether a file of the report's folder is one that was built here.
pub fn is_own(file: &[u8]) -> bool {
    file.starts_with(MARK.as_bytes()) || assets::is_own(file)
}

/// Builds `out/report/` from the tables in `out`; pages of an earlier build go.
///
/// # Errors
/// The folder holds no tables, one cannot be read, or a page cannot be written.
pub fn write(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, true)
}

/// As [`write()`], but a session's page that was made of just its tables stays as it is.
///
/// # Errors
/// As [`write()`].
pub fn update(out: &Path) -> Result<(), Error> {
    build(out, Pages::Auto, false)
}

/// As [`write()`], or without `all` as [`update()`], with pages of a kind.
///
/// # Errors
/// As [`write()`].
pub fn build(out: &Path, kind: Pages, all: bool) -> Result<(), Error> {
    check(out)?;
    let sessions = tables::sessions(out)?;
    let bench = bench::read(out)?;
    let coefficients = tables::coefficients(out)?;
    let warnings = tables::warnings(out)?;
    let force_rows = tables::forces(out)?;
    // the rows of every manoeuvre of an archive would be most of the memory
    let plot_files = tables::session_files(out, "plots")?;
    let manoeuvre_files = tables::session_files(out, "manoeuvres")?;
    let mut pages = names::pages(sessions.iter().map(|s| tables::key(&s.ident)));
    if kind == Pages::None {
        pages.iter_mut().for_each(String::clear);
    }
    let environment = environment()?;
    let folder = out.join("report");
    let diagnosed = diagnosis_pages::Diagnosed::read(out, &sessions, &pages)?;
    let source = kind.source(sessions.len().max(diagnosed.pages().count()));
    let sharing = AtomicBool::new(source == Source::Folder);
    if source == Source::Folder {
        assets::write(&folder)?;
    }
    diagnosed.write(&environment, &folder, source)?;

    // pages are independent of each other: their order of writing shows nowhere
    sessions.par_iter().zip(&pages).try_for_each(|(session, name)| -> Result<(), Error> {
        if name.is_empty() {
            return Ok(());
        }
        let key = tables::key(&session.ident);
        let made_of = made_of(session, diagnosed.page_of(&session.ident), &bench.text);
        let there = is_made_of(&folder.join(name), &made_of).filter(|s| !all && kind.takes(*s));
        if let Some(source) = there {
            sharing.fetch_or(source == Source::Folder, Ordering::Relaxed);
            return Ok(());
        }
        let coefficients = run_of(&coefficients, key, |c| tables::key(&c.ident));
        let files = manoeuvre_files.get(&(key.0.to_owned(), key.1.to_owned()));
        let manoeuvres = tables::manoeuvres(files.map_or(&[], Vec::as_slice), key.0, key.1)?;
        let warnings = run_of(&warnings, key, |w| tables::key(&w.ident));
        let force_rows = run_of(&force_rows, key, |f| tables::key(&f.ident));
        let files = plot_files.get(&(key.0.to_owned(), key.1.to_owned()));
        let points = tables::plots(files.map_or(&[], Vec::as_slice), key.0, key.1)?;
        let mut figures = figures::build(&points, &manoeuvres);
        bench.draw(key.0, &mut figures.charts);
        let mut page = page::build(session, coefficients, &manoeuvres, warnings);
        page.compare(&bench);
        figures::share_time(&mut figures.panels);
        let html = environment.get_template("session.html")?.render(context! {
            page => Serde(page),
            charts => Serde(figures::heads(&figures.charts)),
            panels => Serde(figures::heads(&figures.panels)),
            residuals => Serde(figures::residuals(&figures.charts)),
            bins => crate::plots::BINS,
            absent => page::absent_charts(&figures),
            offroad => page::is_offroad(&figures),
            forces => Serde(forces::table(force_rows)),
            diagnosis => diagnosed.page_of(&session.ident),
            data => Value::from_safe_string(figures::pack::pack(&figures)?),
            ..assets::context(source)
        })?;
        let html = html.replacen(MARK, &format!("{MARK}\n{made_of}, {} -->", source.word()), 1);
        Ok(file::write_bytes(&folder.join(name), html.as_bytes())?)
    })?;

    let rejected = tables::rejected(out)?;
    let fleet = tables_fleet::fleet(out)?;
    let mut index = index::build(&sessions, &pages, &coefficients, &warnings, rejected, &fleet);
    index.diagnoses = diagnosed.entries();
    if !fleet.is_empty() && !sessions.is_empty() {
        index.fleet = Some(write_fleet(out, &environment, &sessions, &pages)?);
    }
    let html = environment.get_template("run.html")?.render(context! {
        run => Serde(&index),
        long_script => Value::from_safe_string(LONG_SCRIPT.to_owned()),
        ..assets::context(Source::Page)
    })?;
    file::write_bytes(&folder.join("index.html"), html.as_bytes())?;
    let own: Vec<&str> = pages
        .iter()
        .map(String::as_str)
        .chain(diagnosed.pages())
        .chain(index.fleet.map(|_| fleet::PAGE))
        .collect();
    remove_stale(&folder, &own);
    let sharing = sharing.into_inner();
    if sharing {
        assets::write(&folder)?; // pages that stayed may have lost them
    }
    assets::remove_stale(&folder, sharing);
    Ok(())
}

/// Writes the page over all sessions; how many events it tells of.
fn write_fleet(
    out: &Path,
    environment: &Environment<'_>,
    sessions: &[rows::SessionRow],
    pages: &[String],
) -> Result<usize, Error> {
    let (page, charts) = publish::over_all(out, sessions, pages)?;
    let figures = figures::Figures { charts, ..figures::Figures::default() };
    let html = environment.get_template("fleet.html")?.render(context! {
        page => Serde(&page),
        charts => Serde(figures::heads(&figures.charts)),
        data => Value::from_safe_string(figures::pack::pack(&figures)?),
        ..assets::context(Source::Page)
    })?;
    file::write_bytes(&out.join("report").join(fleet::PAGE), html.as_bytes())?;
    Ok(page.events.len())
}

/// Whether a folder is an output.
fn check(out: &Path) -> Result<(), Error> {
    match SIGNS.iter().any(|table| out.join(table).is_dir()) {
        true => Ok(()),
        false => Err(Error::NotAnOutput { path: out.to_owned() }),
    }
}

fn environment() -> Result<Environment<'static>, minijinja::Error> {
    let mut environment = Environment::new();
    environment.set_syntax(SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).build()?);
    environment.add_filter("svg", |drawing: String| Value::from_safe_string(drawing));
    for (name, text) in TEMPLATES {
        environment.add_template(name, text)?;
    }
    Ok(environment)
}

/// The rows of a session in rows sorted by their keys.
fn run_of<'a, R>(
    rows: &'a [R],
    session: (&str, &str),
    key: impl Fn(&R) -> (&str, &str),
) -> &'a [R] {
    let start = rows.partition_point(|r| key(r) < session);
    let length = rows[start..].partition_point(|r| key(r) == session);
    &rows[start..start + length]
}

/// What a session's page is made of: its tables' own provenance, its diagnosis, the templates.
fn made_of(session: &rows::SessionRow, diagnosis: Option<&str>, bench: &str) -> String {
    let provenance = &session.provenance;
    let mut hasher = blake3::Hasher::new();
    for part in [&provenance.input_hash, &provenance.pipeline_hash, &provenance.version] {
        hasher.update(part.as_bytes()).update(b"\n");
    }
    hasher.update(session.path.as_bytes()).update(b"\n").update(bench.as_bytes());
    hasher.update(diagnosis.unwrap_or_default().as_bytes()).update(b"\n");
    let own = [STYLE, SCRIPT, UPLOT_SCRIPT, UPLOT_STYLE];
    for text in TEMPLATES.iter().map(|(_, text)| *text).chain(own) {
        hasher.update(text.as_bytes());
    }
    format!("<!-- made of {}", hasher.finalize().to_hex())
}

/// Where a page that is there and was made of just that has its script and style from.
fn is_made_of(page: &Path, made_of: &str) -> Option<Source> {
    let mut head = Vec::new();
    let most = MARK.len() + made_of.len() + 64;
    std::fs::File::open(page).ok()?.take(most as u64).read_to_end(&mut head).ok()?;
    let rest = head.strip_prefix(MARK.as_bytes())?.strip_prefix(b"\n")?;
    let rest = rest.strip_prefix(made_of.as_bytes())?.strip_prefix(b", ")?;
    [Source::Page, Source::Folder].into_iter().find(|s| rest.starts_with(s.word().as_bytes()))
}

/// Takes away pages of an earlier build whose session is gone. One that cannot be removed is
/// left: it is linked from nowhere.
fn remove_stale(folder: &Path, pages: &[&str]) {
    let kept: BTreeSet<&str> = pages.iter().copied().collect();
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if !name.ends_with(".html") || name == "index.html" || kept.contains(name.as_ref()) {
            continue;
        }
        if std::fs::read(entry.path()).is_ok_and(|page| is_own(&page)) {
            let _ = std::fs::remove_file(entry.path());
        }
    }
}
