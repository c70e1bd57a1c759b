//! `roadbench report`.

use std::path::{Path, PathBuf};

use clap::builder::NonEmptyStringValueParser;

use crate::batch::store::intact;
use crate::batch::store::local_copy::LocalCopy;
use crate::batch::store::mark;
use crate::batch::store::reading::Reading;
use crate::cli::browser;
use crate::cli::choices::{FigureFormat, PageKind};
use crate::cli::failure::Failure;
use crate::cli::location::require_folder;
use crate::cli::say::{note, say};
use crate::contract::bike::Axle;
use crate::report::session::{bench_points, bench_values};
use crate::report::static_figures::write;
use crate::report::{self, Error, summary};
use crate::store::objects::Location;
use crate::store::objects::files::read_text;
use crate::store::tables::file;
use crate::store::tables::output;
use crate::store::tables::output::{Outputs, Refusal};
use crate::store::tables::registry;
use crate::tyre::tydex;

/// Rebuild the HTML report from the tables
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The folder that `roadbench run --out` wrote.
    out: PathBuf,
    /// Values or points of a tyre bench to show beside the estimates.
    ///
    /// Values are CSV with the columns tyre, coefficient, value and if known std_error, camber, bike_id; kept in the
    /// folder as bench.csv. Points that a bench measured are TYDEX files: front=FILE.tdx,rear=FILE.tdx, drawn with the
    /// friction of every session; kept as bench_front.tdx and bench_rear.tdx.
    #[arg(long, value_name = "FILE|TYRE=FILE.tdx", value_delimiter = ',')]
    #[arg(value_parser = NonEmptyStringValueParser::new())]
    bench: Vec<String>,
    #[command(flatten)]
    pages: Pages,
    #[command(flatten)]
    copies: Copies,
    /// Only this session's figures.
    #[arg(long, value_name = "ID", requires = "figures")]
    session: Option<String>,
    /// Write the page of this session alone, unless it is there and up to date, print its path and open
    /// it in the browser.
    #[arg(long, value_name = "SESSION", conflicts_with_all = ["figures", "markdown"])]
    open: Option<String>,
    /// The bike of the session, where several have one of that name.
    #[arg(long, value_name = "BIKE", requires = "open")]
    bike: Option<String>,
    /// With --open: only write the page and print its path.
    #[arg(long, requires = "open")]
    no_browser: bool,
}

/// What the report's pages are like.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Pages {
    /// What the pages of the sessions are like.
    ///
    /// By default each is one file that opens anywhere, of more than 50 they share script and style in
    /// `report/assets`, and of more than 1000 only those are there that `report --open` was asked for.
    #[arg(long = "pages", value_name = "KIND", default_value = "auto", hide_default_value = true)]
    pub kind: PageKind,
}

/// The report for other places than a browser.
#[derive(Debug, Default, clap::Args)]
pub(crate) struct Copies {
    /// Folder for every plot as a file, in the format of --figure-format.
    ///
    /// Earlier figures whose session or coefficient is gone are removed; other files in it stay.
    #[arg(long, value_name = "DIR")]
    figures: Option<PathBuf>,
    /// What files the figures become.
    ///
    /// PNG has three pixels to the SVG's one (1860 x 1260 for most) and its text in DejaVu Sans, whatever fonts
    /// the machine has.
    #[arg(long, value_name = "FORMAT", default_value = "svg", requires = "figures")]
    figure_format: FigureFormat,
    /// File for the summary in Markdown, for pull requests and chat.
    #[arg(long, value_name = "FILE")]
    markdown: Option<PathBuf>,
}

impl Copies {
    /// Whether anything was asked for.
    pub(crate) fn asked(&self) -> bool {
        self.figures.is_some() || self.markdown.is_some()
    }

    /// Says where it will be written.
    ///
    /// # Errors
    /// It cannot be.
    pub(crate) fn declare(&self, outputs: &mut Outputs) -> Result<(), Refusal> {
        if let Some(to) = &self.figures {
            outputs.folder("--figures", &to.into())?;
        }
        match &self.markdown {
            Some(file) => outputs.file("--markdown", &file.into()),
            None => Ok(()),
        }
    }

    /// Writes what was asked for, from the tables in `out`; figures of `only` one session.
    ///
    /// # Errors
    /// A table cannot be read, or a file cannot be written.
    pub(crate) fn write(&self, out: &Path, only: Option<&str>) -> Result<(), Error> {
        if let Some(to) = &self.figures {
            let count = write::figures(out, to, self.figure_format.into(), only)?;
            tracing::info!("{count} figures: {}", to.display());
        }
        if let Some(file) = &self.markdown {
            let summary = summary::markdown(out)?;
            output::write(file, summary.as_bytes())?;
            tracing::info!("summary: {}", file.display());
        }
        Ok(())
    }
}

/// Runs the command; prints where the report is.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: Arguments) -> Result<(), Failure> {
    let out = arguments.out;
    require_folder(&out)?;
    let benches = arguments.bench.iter().map(|bench| read_bench(bench));
    let benches = benches.collect::<Result<Vec<_>, Failure>>()?;
    mark::require(&Location::from(&out))?;
    if let Some(session) = &arguments.session {
        report::open::require_session(&out, session).map_err(failure)?;
    }
    let mut outputs = Outputs::default();
    outputs.tables(&(&out).into());
    arguments.copies.declare(&mut outputs)?;
    outputs.apart_from_files(arguments.bench.iter().map(|bench| bench_file(bench).1))?;
    let _reading = Reading::of(&out).map_err(|e| Failure::Output(e.to_string()))?;
    for (name, bytes) in &benches {
        file::write_bytes(out.join(name), bytes).map_err(|e| Failure::Output(e.to_string()))?;
    }
    let kind = arguments.pages.kind.into();
    if let Some(session) = &arguments.open {
        let tables: Vec<&str> = registry::read_by_reports().collect();
        intact::require_session(&out, &tables, session)?;
        let page = report::open(&out, session, arguments.bike.as_deref(), kind).map_err(failure)?;
        say!("{}", page.display());
        if !arguments.no_browser {
            browser::open(&page);
        }
        return Ok(());
    }
    let only = arguments.session.as_deref();
    // without what is damaged
    let copy = LocalCopy::of_whole_folder(&out)?;
    report::build(copy.folder(), kind, true)
        .and_then(|()| arguments.copies.write(copy.folder(), only))
        .map_err(failure)?;
    copy.publish(["report"])?;
    note!("{}", out.join("report").join("index.html").display());
    // as a run that cannot make its tables whole: what could be made is there, and the exit code says that it is not all
    copy.left_out(&Location::from(&out)).map_or(Ok(()), |why| Err(Failure::Output(why)))
}

/// The tyre that bench points are of, and their file; of bench values the file alone.
fn bench_file(bench: &str) -> (Option<Axle>, &Path) {
    let of_tyre = bench.split_once('=').and_then(|(tyre, path)| {
        Some((Axle::BOTH.into_iter().find(|axle| axle.name() == tyre)?, Path::new(path)))
    });
    of_tyre.map_or((None, Path::new(bench)), |(axle, path)| (Some(axle), path))
}

/// Reads bench values, or bench points of a tyre (`front=FILE.tdx`); the name by which the folder keeps them, and the bytes.
fn read_bench(bench: &str) -> Result<(String, Vec<u8>), Failure> {
    Ok(match bench_file(bench) {
        (Some(axle), path) => {
            let bytes = std::fs::read(path)
                .map_err(|e| Failure::usage(format!("cannot read {}: {e}", path.display())))?;
            let found = bench_points::check(&bytes, path).map_err(Failure::usage)?;
            for remark in &found.remarks {
                tracing::warn!("{}: {remark}", path.display());
            }
            (bench_points::file_name(axle), bytes)
        }
        (None, _) if tydex::is_name(bench) => {
            return Err(Failure::Usage(format!(
                "--bench {bench}: which tyre was measured? Give front={bench} or rear={bench}"
            )));
        }
        (None, path) => {
            let fail = |message: String| Failure::Usage(format!("{bench}: {message}"));
            let text = read_text(path).map_err(|e| fail(e.to_string()))?;
            bench_values::parse(&text).map_err(|e| fail(e.to_string()))?;
            (bench_values::FILE.to_owned(), text.into_bytes())
        }
    })
}

/// What is wrong with a report, by kind.
pub(super) fn failure(e: Error) -> Failure {
    match e {
        Error::NotAnOutput { .. } | Error::Read(_) | Error::NoSession(_) => {
            Failure::Usage(e.to_string())
        }
        Error::Write(_) | Error::Figure { .. } | Error::Template(_) | Error::Data(_) => {
            Failure::Output(e.to_string())
        }
    }
}
