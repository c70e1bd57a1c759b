//! `roadbench bike new`: from a log, a name and the sizes on the tyres to the first coefficient; what guesses cost.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use assert_cmd::Command;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::coefficient::{self as kind, Id, Part};
use roadbench::internals::ingest::write_session;
use roadbench::internals::motorcycle::catalogue::{Catalogue, Owner, file};
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::hidden::Kind;
use roadbench::internals::simulate::population::bike::BikeFile;
use roadbench::internals::simulate::population::ride;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::registry::Row;
use roadbench::internals::store::tables::rows::{
    Coefficient, EvidenceRow, Rejected, Status, WarningRow,
};

const LOGS: &str = "fixtures/archive/sessions/bike=archive_01/date=2026-05-01";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn log(name: &str) -> PathBuf {
    root().join(LOGS).join(format!("{name}.parquet"))
}

/// Runs the program in a folder: exit code, what it said on stdout, on stderr.
fn roadbench(folder: &Path, line: &str) -> (i32, String, String) {
    let log = log("archive_s0001").display().to_string();
    let words =
        line.split_whitespace().map(|w| if w == "LOG" { log.clone() } else { w.to_owned() });
    let output = Command::cargo_bin("roadbench")
        .expect("binary")
        .current_dir(folder)
        .args(words)
        .output()
        .expect("ran");
    let text = |bytes| String::from_utf8(bytes).expect("UTF-8");
    (output.status.code().expect("not killed"), text(output.stdout), text(output.stderr))
}

/// The commands that a message shows between backticks.
fn shown(message: &str) -> Vec<String> {
    let one_line = message.split_whitespace().collect::<Vec<_>>().join(" ");
    let parts = one_line.split('`').skip(1).step_by(2);
    parts.filter_map(|p| p.strip_prefix("roadbench ").map(str::to_owned)).collect()
}

fn rows<T: Row + serde::de::DeserializeOwned + Send>(folder: &Path) -> Vec<T> {
    read::rows(&folder.join("out")).expect("a table")
}

/// Only what the program itself says is typed; placeholders are replaced by what is on the motorcycle.
#[test]
fn a_new_user_gets_coefficients_by_typing_what_the_program_says() {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    let (code, _, said) = roadbench(here, "run LOG --out out");
    assert_eq!(code, 2, "{said}");
    let command = shown(&said).pop().expect(&said);
    assert_eq!(command, "bike new NAME");
    // the log's bike is not known yet: a motorcycle of another name
    let sizes = "--front 120/70ZR17 --rear 180/55ZR17 --weight 242";
    let (code, out, said) = roadbench(here, &format!("bike new other --class naked {sizes}"));
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("cg_height") && out.contains("guess from the class"), "{out}");
    let (code, _, said) = roadbench(here, "run LOG --bikes bikes --out out");
    assert_eq!(code, 1, "{said}");
    let row: Vec<Rejected> = rows(here);
    assert_eq!(row[0].code, "no_bike_file");
    let commands = shown(&row[0].message);
    let command = commands[0]
        .replace("CLASS", "naked")
        .replacen("SIZE", "120/70ZR17", 1)
        .replacen("SIZE", "180/55ZR17", 1)
        .replace("KG", "242");
    assert!(command.starts_with("bike new archive_01 "), "{command}");
    let (code, _, said) = roadbench(here, &command);
    assert_eq!(code, 0, "{said}");
    let (code, out, said) = roadbench(here, "run LOG --bikes bikes --out out");
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("is uncertain"), "what the guesses cost:\n{out}");
    let found: Vec<Coefficient> = rows(here);
    let good = found.iter().filter(|c| c.status == Status::Ok).count();
    assert!(good >= 10, "{good} of {}", found.len());
    let warnings: Vec<WarningRow> = rows(here);
    assert!(warnings.iter().all(|w| w.code != "default_bike"));
}

#[test]
fn a_default_stands_in_with_wide_intervals_and_a_warning() {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    let (code, out, said) = roadbench(here, "bike new default --class naked");
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("with a warning"), "{out}");
    let (code, _, said) = roadbench(here, "run LOG --bikes bikes --out out");
    assert_eq!(code, 0, "{said}");
    let warnings: Vec<WarningRow> = rows(here);
    let warning = warnings.iter().find(|w| w.code == "default_bike").expect("said");
    assert_eq!(shown(&warning.message), ["bike new archive_01"]);
    let found: Vec<Coefficient> = rows(here);
    let width = |rows: &[Coefficient], tyre: &str, name: &str| {
        let row = rows.iter().find(|c| c.tyre == tyre && c.coefficient == name).expect(name);
        row.ci95_high.expect("an interval") - row.ci95_low.expect("an interval")
    };
    let wide = width(&found, "front", "mf_d");
    // the motorcycle's own file narrows it and takes the warning away
    let own = root().join("fixtures/archive/bikes/archive_01.toml");
    std::fs::copy(own, here.join("bikes/archive_01.toml")).expect("a bike file");
    let (code, _, said) = roadbench(here, "run LOG --bikes bikes --out out");
    assert_eq!(code, 0, "{said}");
    let warnings: Vec<WarningRow> = rows(here);
    assert!(warnings.iter().all(|w| w.code != "default_bike"));
    let narrow = width(&rows(here), "front", "mf_d");
    assert!(wide > 1.5 * narrow, "{wide} {narrow}");
}

#[test]
fn bad_usage_names_everything_and_writes_nothing() {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    for (line, parts) in [
        ("bike new", &["NAME", "class", "naked"][..]),
        ("bike new a/b --class cruiser --front wide --set x=1", &["a/b", "cruiser", "wide", "`x`"]),
        ("bike new mine --model Unicorn", &["Unicorn", "class"]),
        ("bike new mine --class naked --scales 130", &["2 numbers"]),
        ("bike new mine --class naked --lifted 0.3,140", &["scales"]),
        ("bike new mine --class naked --weight 2000", &["2000"]),
        ("bike new mine --class naked --weight 270,5", &["--weight", "such as 270.5"]),
        ("bike new mine --class naked --weight 200 --scales 100,170", &["`mass`", "200", "270"]),
        ("bike new mine --class naked --weight 270 --set mass=300", &["`mass`", "270", "300"]),
        ("bike new mine --class naked --set mass=310 --set mass=300", &["`mass`", "310", "300"]),
        ("convert LOG --bike a/b --out x.parquet", &["a/b"]),
    ] {
        let (code, _, said) = roadbench(here, line);
        assert_eq!(code, 2, "{line}: {said}");
        assert!(parts.iter().all(|part| said.contains(part)), "{line}: {said}");
        assert!(!here.join("bikes").exists(), "{line}");
    }
    assert_eq!(roadbench(here, "bike new mine --class naked").0, 0);
    std::fs::write(here.join("bikes/mine.toml"), "mass = 1").expect("written");
    let (code, _, said) = roadbench(here, "bike new mine --class naked");
    assert!(code == 2 && said.contains("--force"), "{said}");
    assert_eq!(std::fs::read_to_string(here.join("bikes/mine.toml")).expect("there"), "mass = 1");
}

#[test]
fn numbers_that_hardly_fit_together_are_written_with_a_warning() {
    let folder = tempfile::tempdir().expect("folder");
    for (name, options, part) in [
        ("swapped", "--front 180/55ZR17 --rear 120/70ZR17", "swapped"),
        ("behind", "--set cg_to_front=1.40", "of the weight is on the front wheel"),
    ] {
        let line = format!("bike new {name} --class naked {options}");
        let (code, _, said) = roadbench(folder.path(), &line);
        let said = said.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(code == 0 && said.starts_with("warning:") && said.contains(part), "{said}");
    }
    let (_, _, said) = roadbench(folder.path(), "bike new usual --class naked --weight 260");
    assert_eq!(said, "");
}

#[test]
fn all_missing_keys_are_in_one_message() {
    let e = Bike::parse("mass = 260.0\nfront.radius = 0.3\n", "b", Path::new("b.toml"));
    let e = e.expect_err("seven are missing").to_string();
    for key in [
        "`wheelbase`",
        "`cg_to_front`",
        "`cg_height`",
        "`caster_angle`",
        "`front.width`",
        "`rear.radius`",
        "`rear.width`",
        "`roadbench bike new`",
    ] {
        assert!(e.contains(key), "{key}: {e}");
    }
}

#[test]
fn convert_writes_the_bike_id_that_it_is_given() {
    let folder = tempfile::tempdir().expect("folder");
    let here = folder.path();
    let (code, out, said) = roadbench(here, "convert LOG --bike mine --out mine.parquet");
    assert_eq!(code, 0, "{said}");
    assert!(out.contains("bike \"mine\""), "{out}");
    let (_, out, _) = roadbench(here, "inspect mine.parquet");
    assert!(out.contains("bike mine"), "{out}");
}

/// Relative changes of coefficients over those of numbers of the bike file, from the evidence of rides of the archive.
fn elasticities() -> BTreeMap<(String, String), f64> {
    let sizes = ["120/70ZR17", "180/55ZR17"].map(|s| Some(s.to_owned()));
    let mut all: BTreeMap<(String, String), Vec<f64>> = BTreeMap::new();
    for name in ["archive_s0001", "archive_s0002"] {
        let owner = Owner {
            class: Some("naked".into()),
            sizes: sizes.clone(),
            weight: Some(242.0),
            ..Owner::default()
        };
        let portrait = owner.portrait(Catalogue::builtin()).expect("a portrait");
        let text = file::text(&portrait, "archive_01").expect("a bike file");
        let bike = Bike::parse(&text, "archive_01", Path::new("guess.toml")).expect("a bike");
        let input = Input {
            log: log(name).into(),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        let outcome = pipeline::run(&input, &bike, &Pipeline::onroad()).expect("a session");
        for row in &outcome.evidence {
            let EvidenceRow { tyre, coefficient, value, source, sensitivity, status, .. } = row;
            let Some((taken, sd)) = row.source_value.zip(row.source_std_error) else { continue };
            let number = portrait.numbers.iter().any(|n| n.key == *source);
            if number && *status == Status::Ok && *value != 0.0 && taken != 0.0 {
                let leaf = source.trim_start_matches("front.").trim_start_matches("rear.");
                let key = (leaf.to_owned(), format!("{tyre} {coefficient}"));
                // of both wheels' numbers the one that matters to this coefficient
                let is = (sensitivity / value) / (sd / taken);
                all.entry(key).or_default().push(is);
            }
        }
    }
    let largest =
        |x: Vec<f64>| x.into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    all.into_iter().map(|(key, x)| (key, largest(x))).collect()
}

/// The costs that the wizard names are those that rides show.
#[test]
fn costs_of_the_catalogue_are_those_of_rides() {
    let found = elasticities();
    for ((key, of), elasticity) in &found {
        if elasticity.abs() > 0.05 {
            println!("{key}: {{ of = \"{of}\", elasticity = {elasticity:.2} }}");
        }
    }
    let mut checked = 0;
    for measure in &Catalogue::builtin().measures {
        for cost in &measure.costs {
            let is =
                found.get(&(measure.key.clone(), cost.of.clone())).copied().unwrap_or(f64::NAN);
            let ratio = is.abs() / cost.elasticity;
            assert!(
                (0.6..1.7).contains(&ratio),
                "{} {}: {is}, not {}",
                measure.key,
                cost.of,
                cost.elasticity
            );
            checked += 1;
        }
    }
    assert!(checked >= 10, "{checked}");
}

/// Machines that nobody measured: class, tyre sizes and weight alone, and the intervals hold all the same. The figures over a
/// hundred are in the book.
#[test]
fn guesses_on_machines_of_a_population_are_as_uncertain_as_they_say() {
    let work = tempfile::tempdir().expect("folder");
    let pipeline = Pipeline::onroad();
    let (mut inside, mut all) = (0, 0);
    for number in 0..2 {
        let case = ride::case(61_803, number, Kind::Null, [1.0, 1.0]);
        let ridden = ride::ride(&case, BikeFile::Wizard).expect("a ride");
        let log = work.path().join(format!("{number}.parquet"));
        write_session(&log, &ridden.ride.session, false).expect("written");
        let input = Input {
            log: log.into(),
            maps: &[],
            input_hash: String::new(),
            pipeline_hash: String::new(),
            signals: false,
        };
        let outcome = pipeline::run(&input, &ridden.tour.bike, &pipeline).expect("a session");
        let truth = ridden.truth(&pipeline.estimate);
        for row in outcome.coefficients.iter().filter(|c| c.status == Status::Ok) {
            let part = Part::from_name(&row.tyre).expect("a part");
            let id = Id::from((part, kind::Coefficient::from_name(&row.coefficient).expect("one")));
            let known = truth.iter().find(|(t, x)| *t == id && x.is_finite());
            let interval = row.ci95_low.zip(row.ci95_high);
            if let (Some((_, truth)), Some((low, high))) = (known, interval) {
                all += 1;
                inside += usize::from((low..=high).contains(truth));
            }
        }
    }
    assert!(all >= 20, "{all}");
    assert!(10 * inside >= 9 * all, "{inside} of {all}");
}
