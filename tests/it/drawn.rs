//! The five figures of how the method works, drawn from the tables that `run` and `diagnose` write for one ride of the
//! bundled archive. `ROADBENCH_BLESS=1 cargo nextest run -E 'test(drawn::)'` draws them anew into `book/src/images`.
//!
//! A figure of the book and one drawn now have the same words; numbers may differ by 2 % or 3 pixels, as machines round
//! differently.

mod diagnosis;
mod estimation;
mod slips;
mod svg;
mod table;

use std::path::{Path, PathBuf};

use assert_cmd::Command;

use table::Tables;

const RIDE: &str =
    "fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet";
const TRUTH: &str = "fixtures/archive/truth/coefficients/bike=archive_01/archive_s0001.parquet";

/// Each figure's file in `book/src/images`, the chapter that shows it, and how it is drawn.
type Figure = (&'static str, &'static str, fn(&Tables) -> String);
const FIGURES: [Figure; 5] = [
    ("method_flow.svg", "introduction.md", estimation::flow),
    ("method_slips.svg", "estimation.md", slips::slips_and_cambers),
    ("method_friction.svg", "estimation.md", estimation::friction),
    ("method_corner.svg", "estimation.md", estimation::corner),
    ("method_diagnosis.svg", "diagnosis.md", diagnosis::diagnosis),
];

fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Runs the program in the repository.
fn roadbench(arguments: &[&str]) {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    let output = command.current_dir(here("")).args(arguments).output().expect("the binary ran");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// An SVG as words and numbers.
fn pieces(svg: &str) -> Vec<&str> {
    svg.split([' ', ',', '"', '<', '>', '\n']).filter(|piece| !piece.is_empty()).collect()
}

/// Whether two pieces of an SVG are the same, be it with another rounding.
fn is_same(a: &str, b: &str) -> bool {
    let number = |text: &str| text.trim_start_matches(['M', 'L']).parse::<f64>().ok();
    match (number(a), number(b)) {
        (Some(x), Some(y)) => (x - y).abs() <= 3.0_f64.max(0.02 * x.abs()),
        _ => a == b,
    }
}

/// The first piece in which two drawings differ.
fn difference<'a>(shown: &'a str, drawn: &'a str) -> Option<(&'a str, &'a str)> {
    let (a, b) = (pieces(shown), pieces(drawn));
    let unlike = a.iter().zip(&b).find(|(a, b)| !is_same(a, b)).map(|(a, b)| (*a, *b));
    unlike.or((a.len() != b.len()).then_some(("length", "another length")))
}

#[test]
fn figures_of_the_method_are_those_of_the_bundled_archive() {
    let folder = tempfile::tempdir().expect("folder");
    let place = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (run, causes) = (place("run"), place("causes"));
    let common = [RIDE, "--bikes", "fixtures/archive/bikes", "--progress", "never", "--out"];
    roadbench(&[&["run", "--signals"], &common[..], &[run.as_str()]].concat());
    roadbench(&[&["diagnose"], &common[..], &[causes.as_str()]].concat());
    let tables = Tables {
        run: PathBuf::from(run),
        causes: PathBuf::from(causes),
        ride: here(RIDE),
        truth: here(TRUTH),
    };
    let mut wrong = Vec::new();
    for (name, chapter, draw) in FIGURES {
        let drawn = draw(&tables);
        let path = here("book/src/images").join(name);
        if std::env::var_os("ROADBENCH_BLESS").is_some() {
            std::fs::write(&path, &drawn).expect("written");
        }
        let shown = std::fs::read_to_string(&path).unwrap_or_default();
        if let Some((was, is)) = difference(&shown, &drawn) {
            wrong.push(format!("{name}: {was} is now {is}; ROADBENCH_BLESS=1 draws it anew"));
        }
        let page = std::fs::read_to_string(here("book/src").join(chapter)).expect("a chapter");
        if !page.contains(&format!("](images/{name})")) {
            wrong.push(format!("{chapter} does not show {name}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_moved_curve_or_another_word_is_a_difference() {
    let svg = "<path d=\"M10.0,20.0 L30.0,40.0\"/><text>peak 1.06</text>";
    assert_eq!(difference(svg, svg), None);
    assert_eq!(difference(svg, &svg.replace("40.0", "41.5")), None, "rounding");
    assert_eq!(difference(svg, &svg.replace("40.0", "60.0")), Some(("40.0", "60.0")));
    assert_eq!(difference(svg, &svg.replace("peak", "top")), Some(("peak", "top")));
    assert_eq!(difference(svg, &svg.replace(" L30.0,40.0", "")), Some(("L30.0", "/")));
}
