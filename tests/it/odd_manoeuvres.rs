//! A manoeuvre that is not as the others of its ride is found at its place, and nothing is said of a ride without one.
//! The study `examples/odd_manoeuvres` counts over many rides and on the multibody motorcycle.

use std::fs;
use std::path::Path;

use assert_cmd::Command;
use roadbench::internals::simulate::scenario::BUILTIN;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::{OutlyingManoeuvre, TruthSegment, WarningRow};

const ODD: &str = r#"
[[odd_manoeuvres]]
kind = "front_braking"
number = 2
friction = -0.3

[[odd_manoeuvres]]
kind = "coasting"
number = 3
head_wind = 9.0
"#;

/// Rides one session with something odd and runs it; what the terminal says.
fn ridden(folder: &Path, odd: &str) -> String {
    let at = |name: &str| folder.join(name);
    let (_, text) = BUILTIN.iter().find(|(name, _)| *name == "naturalistic").expect("built in");
    let text = text.replace("bikes = 200", "bikes = 1") + odd;
    fs::write(at("odd.toml"), text).expect("written");
    let command = |arguments: &[&str]| {
        let mut command = Command::cargo_bin("roadbench").expect("built");
        let done = command.current_dir(folder).args(arguments).assert().success();
        String::from_utf8_lossy(&done.get_output().stdout).into_owned()
    };
    command(&["simulate", "odd.toml", "--out", "archive"]);
    command(&["run", "archive", "--out", "out"])
}

#[test]
fn one_odd_stop_and_one_gust_are_found_at_their_places_and_said_everywhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = ridden(folder.path(), ODD).split_whitespace().collect::<Vec<_>>().join(" ");
    let out = folder.path().join("out");
    let rows: Vec<OutlyingManoeuvre> = read::rows(&out).expect("rows");
    let segments = folder.path().join("archive/truth/segments");
    let files = walkdir::WalkDir::new(segments).into_iter().flatten();
    let files = files.filter(|e| e.file_type().is_file());
    let truth: Vec<TruthSegment> =
        files.flat_map(|file| read::file_rows(file.path()).expect("rows")).collect();
    let of = |kind: &str, number: usize| {
        truth.iter().filter(|t| t.kind == kind).nth(number - 1).expect("ridden")
    };
    let quantities: Vec<&str> = rows.iter().map(|r| r.quantity.as_str()).collect();
    for (quantity, place) in
        [("friction_front", of("front_braking", 2)), ("resistance", of("coasting", 3))]
    {
        let row = rows.iter().find(|r| r.quantity == quantity);
        let row = row.unwrap_or_else(|| panic!("{quantity} in {quantities:?}"));
        assert!(row.start < place.end && row.end > place.start, "{row:?} {place:?}");
        assert!(
            row.chance.is_some_and(|c| c < 0.01) && row.distance.is_some_and(|d| d > 10.0),
            "{row:?}"
        );
    }
    assert_eq!(rows.len(), 2, "{rows:#?}");
    let stop = rows.iter().find(|r| r.quantity == "friction_front").expect("found");
    assert!(stop.ci95_low < -0.3 && -0.3 < stop.ci95_high, "{stop:?}");
    assert!(stop.ci95_high - stop.ci95_low < 0.15, "{stop:?}");

    // one wording: table of warnings, terminal, page
    let warnings: Vec<WarningRow> = read::rows(&out).expect("rows");
    let odd: Vec<&WarningRow> =
        warnings.iter().filter(|w| w.code == "outlying_manoeuvre").collect();
    assert_eq!(odd.len(), 2);
    for warning in &odd {
        assert!(said.contains(&warning.message), "{}\n{said}", warning.message);
    }
    let stop_said = odd.iter().any(|w| w.message.contains("less friction of the front tyre ("));
    assert!(stop_said && odd.iter().any(|w| w.message.contains("more resistance (")), "{odd:#?}");
    let page = out.join("report");
    let pages = fs::read_dir(&page).expect("a report").flatten().map(|e| e.path());
    let texts = pages.filter(|p| p.extension().is_some_and(|e| e == "html"));
    let texts: Vec<String> = texts.map(|p| fs::read_to_string(p).expect("text")).collect();
    for words in ["less friction of the front tyre (", "more resistance ("] {
        let says = |text: &String| {
            let lead = text.split("Unlike the others:</strong>").skip(1);
            lead.filter_map(|rest| rest.split("</p>").next()).any(|line| line.contains(words))
        };
        assert!(texts.iter().any(says), "no page begins with {words}");
    }
}

#[test]
fn nothing_is_said_of_a_ride_without_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let said = ridden(folder.path(), "");
    let rows: Vec<OutlyingManoeuvre> = read::rows(&folder.path().join("out")).expect("rows");
    assert!(rows.is_empty(), "{rows:#?}");
    assert!(!said.contains("outlying"), "{said}");
}
