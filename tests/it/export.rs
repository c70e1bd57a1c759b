//! Exports of a ride of the bundled archive, read by what is not roadbench: an independent Magic
//! Formula in Python, and a C compiler.

use std::path::{Path, PathBuf};
use std::process::Command as Process;

use assert_cmd::Command;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::contract::coefficient::Coefficient as C;
use roadbench::internals::report::export::effects::Place;
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::export::parameters;
use roadbench::internals::report::export::tyre::{Characterised, Setting};
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::simulate::effects::extended_model::ExtendedModel;
use roadbench::internals::simulate::effects::models::Models;
use roadbench::internals::store::tables::read;
use roadbench::internals::store::tables::rows::TyreParameters;
use roadbench::internals::tyre::paper::Input;
use roadbench::internals::tyre::tyre_model::TyreModel;

pub const SESSION: &str = "archive_s0001";
const LOG: &str = "fixtures/archive/sessions/bike=archive_01/date=2026-05-01/archive_s0001.parquet";
pub const BIKES: &str = "fixtures/archive/bikes";

pub fn here(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Runs the binary in the repository and gives back what it says.
pub fn roadbench(arguments: &[&str]) -> String {
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    let output = command.current_dir(here("")).args(arguments).output().expect("the binary ran");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).expect("text")
}

/// An output folder with one session in it.
pub fn ridden() -> (tempfile::TempDir, String) {
    ridden_with(&[])
}

/// The same with more arguments.
pub fn ridden_with(more: &[&str]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("folder");
    let out = folder.path().join("out").to_string_lossy().into_owned();
    let base = ["run", LOG, "--bikes", BIKES, "--out", &out, "--progress", "never"];
    roadbench(&[&base[..], more].concat());
    (folder, out)
}

/// Whether a program is there; where tests must not be skipped (`.ci/run`) it has to be.
pub fn there(program: &str) -> bool {
    let found = Process::new(program).arg("--version").output().is_ok_and(|o| o.status.success());
    assert!(
        found || std::env::var_os("ROADBENCH_TEST_ALL").is_none(),
        "ROADBENCH_TEST_ALL is set, but there is no {program}"
    );
    if !found {
        eprintln!("not tested: there is no {program}");
    }
    found
}

#[test]
fn an_independent_reader_gets_the_fitted_forces_from_the_property_file() {
    if !there("python3") {
        return;
    }
    let (folder, out) = ridden();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (toml, csv) = (at("tyre.toml"), at("tyre.csv"));
    let export = |format: &str, more: &[&str], file: &str| {
        let base = ["export", &out, "--session", SESSION, "--format", format, "--out", file];
        roadbench(&[&base[..], more].concat())
    };
    export("toml", &[], &toml);
    export("csv", &["--bikes", BIKES], &csv);
    for (end, set, form) in [
        ("front", "5.2", "FITTYP               = 52.0"),
        ("rear", "5.2", "FITTYP               = 52.0"),
        ("front", "6.2", "FITTYP               = 62.0"),
        ("rear", "6.2", "FITTYP               = 62.0"),
    ] {
        let tir = at("tyre.tir");
        export("tir", &["--tyre", end, "--bikes", BIKES, "--set", set], &tir);
        let text = std::fs::read_to_string(&tir).expect("the file");
        for section in [
            "[UNITS]",
            "[LONG_SLIP_RANGE]",
            "[SLIP_ANGLE_RANGE]",
            "[INCLINATION_ANGLE_RANGE]",
            "[VERTICAL_FORCE_RANGE]",
            "extrapolated beyond as the estimated tyre is",
            "No ride reaches the lateral peak",
            form,
            "$ session archive_s0001",
            "$ Axes of ISO 8855",
        ] {
            assert!(text.contains(section), "{section} is not in {text}");
        }
        let script = here("tests/independent/motorcycle_tir.py");
        let output = Process::new("python3")
            .arg(script)
            .args([&tir, &toml, &csv])
            .arg(end)
            .output()
            .expect("python3 ran");
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.success(), "{end} {set}: {error}");
        let said: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
        println!("{end} {set}: {said}");
        let share = |value: &serde_json::Value| value.as_f64().expect("a share");
        assert!(said["points"].as_u64().is_some_and(|n| n > 5000), "{said}");
        // the promise: within 2 % of the peak over what was ridden; along the wheel over all of the file's slip ratios
        assert!(share(&said["Fx"]) < 1e-6 && share(&said["Fy"]) < 0.02, "{end} {set}: {said}");
        // beyond it the form has a peak, which the estimated tyre has not
        assert!(share(&said["beyond"]["Fy"]) < 0.3, "{end} {set}: {said}");
        assert!(share(&said["beyond"]["most"]) < 1.1, "{end} {set}: {said}");
        assert!(share(&said["beyond"]["peak off"]) < 0.01, "{end} {set}: {said}");
        // the look-up tables are the same tyre
        assert!(share(&said["tables"]["longitudinal Fx"]) < 1e-4, "{end} {set}: {said}");
        assert!(share(&said["tables"]["lateral Fy"]) < 0.02, "{end} {set}: {said}");
        // what the file itself says of its differences is what the reader sees
        let head = |what: &str, nth: usize| -> f64 {
            let line = text.lines().filter(|l| l.contains(what)).nth(nth).expect("in the head");
            let words: Vec<&str> = line.split_whitespace().collect();
            let at = words.iter().position(|w| *w == "%").expect("a share");
            words[at - 1].parse::<f64>().expect("a number") / 100.0
        };
        for (what, key) in [
            ("Fy, slip angle and camber", "lateral Fy"),
            ("Mx, slip angle and camber", "lateral Mx"),
            ("Mz, slip angle and camber", "lateral Mz"),
            ("Fx and Fy, combined slip", "combined Fy"),
        ] {
            let (told, seen) = (head(what, 0), share(&said["tables"][key]));
            assert!(
                seen < 1.3 * told + 0.002,
                "{end} {set}: {what} {told} in the head, {seen} seen"
            );
        }
        let told = head("Fy, slip angle and camber", 1);
        let seen = share(&said["beyond"]["Fy"]);
        assert!((seen - told).abs() < 0.3 * told, "{end} {set}: beyond {told} told, {seen} seen");
    }
}

#[test]
fn the_c_header_is_the_tyre_to_the_last_digits() {
    compare_header(&[]);
}

#[test]
fn the_c_header_of_an_extended_tyre_is_it_to_the_last_digits() {
    compare_header(&[
        ("friction_load", 0.12),
        ("stiffness_load", -0.2),
        ("side_force_ratio_front", 0.02),
        ("side_force_ratio_rear", -0.01),
        ("twisting_stiffness", 0.01),
        ("pneumatic_trail", 0.4),
        ("relaxation_length", 0.1),
        ("radius_load", 0.005),
        ("radius_camber", 0.02),
        ("radius_speed", 0.003),
        ("rolling_speed", 0.0004),
    ]);
}

/// Exports a session with some effects, compiles the header and holds it against the library.
fn compare_header(effects: &[(&str, f64)]) {
    let compiler = std::env::var("CC").unwrap_or("cc".into());
    if !there(&compiler) {
        return;
    }
    let place = tempfile::tempdir().expect("folder");
    let path = place.path().join("model.toml");
    let mut model = format!("session_id = \"{SESSION}\"\nbike_id = \"archive_01\"\n");
    for (name, size) in effects {
        let unit = Effect::named(name).expect("known").unit;
        model +=
            &format!("[effects.{name}]\nvalue = {size}\nstd_error = 0.001\nunit = \"{unit}\"\n");
    }
    std::fs::write(&path, &model).expect("model");
    let models = Models::of_one(ExtendedModel::parse(&model, "model").expect("model"));
    let given = ["--model", &path.to_string_lossy()].map(str::to_owned);
    let given: Vec<&str> = given.iter().map(String::as_str).collect();
    // freed of them, so that each becomes part of the tyre
    let (folder, out) = ridden_with(&given);
    let header = folder.path().join("tyre.h");
    let base = ["export", &out, "--session", SESSION, "--format", "c", "--bikes", BIKES];
    let text = roadbench(&[&base[..], &["--friction", "0.9"], &given].concat());
    std::fs::write(&header, text).expect("header");

    let bike = Bike::read(&here(BIKES).join("archive_01.toml")).expect("bike");
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    let fitted = fitted.with_models(Path::new(&out), &models).expect("warnings");
    let setting =
        Setting { bike: Some(&bike), friction: 0.9, named: &fitted.named, ..Setting::default() };
    let mut points = Vec::new();
    // beyond the ranges too: a locked wheel, a spinning one, the air, ice
    for s in [-1.3, -1.0, -0.4, -0.08, -0.01, 0.0, 0.02, 0.3, 4.0] {
        for a in [-0.6, -0.03, 0.0, 0.004, 0.2] {
            for g in [-1.1, -0.5, -1e-8, 0.0, 0.7] {
                for load in [-5.0, 0.0, 300.0, 1300.0, 4000.0] {
                    for friction in [0.05, 0.9, 1.2] {
                        points.push(Input {
                            slip_ratio: s,
                            slip_angle: a,
                            camber: g,
                            load,
                            friction,
                        });
                    }
                }
            }
        }
    }
    let mut rows = String::new();
    for p in &points {
        let numbers = [p.slip_ratio, p.slip_angle, p.camber, p.load, p.friction];
        let words: Vec<String> = numbers.iter().map(|x| format!("{x:?}")).collect();
        rows += &format!("    {{{}}},\n", words.join(", "));
    }
    let program = format!(
        "#include <stdio.h>\n#include \"tyre.h\"\n\n\
         static const roadbench_input points[] = {{\n{rows}}};\n\n\
         int main(void)\n{{\n    for (size_t i = 0; i < sizeof points / sizeof *points; i++) {{\n\
         const roadbench_output f = roadbench_forces(&roadbench_front, &points[i]);\n\
         const roadbench_output r = roadbench_forces(&roadbench_rear, &points[i]);\n\
         const double load = points[i].load, g = points[i].camber;\n\
         printf(\"%.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g %.17g\\n\",\n\
         f.force_x, f.force_y, f.moment_x, f.moment_z,\n\
         roadbench_rolling_radius(&roadbench_front, load, g, 25.0),\n\
         roadbench_rolling_force_at(&roadbench_front, load, 25.0),\n\
         r.force_x, r.force_y, r.moment_x, r.moment_z,\n\
         roadbench_rolling_radius(&roadbench_rear, load, g, 25.0),\n\
         roadbench_rolling_force_at(&roadbench_rear, load, 25.0));\n    }}\n\
         return roadbench_ridden(&roadbench_front, points) != 0\n\
         || !(roadbench_rolling_force(&roadbench_rear, 1000.0) < 0.0)\n\
         || !(roadbench_slip_angle_rate(&roadbench_rear, 30.0, 0.1, 0.0) > 0.0);\n}}\n"
    );
    let source = folder.path().join("compare.c");
    let binary = folder.path().join("compare");
    std::fs::write(&source, program).expect("program");
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O1"];
    let built = Process::new(&compiler)
        .args(strict)
        .arg(&source)
        .arg("-o")
        .arg(&binary)
        .arg("-lm")
        .output()
        .expect("the compiler ran");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let ran = Process::new(&binary).output().expect("the program ran");
    assert!(ran.status.success(), "the program says no");
    let said = String::from_utf8(ran.stdout).expect("numbers");
    let found: Vec<Vec<f64>> = said
        .lines()
        .map(|l| l.split(' ').map(|w| w.parse().expect("a number")).collect())
        .collect();
    assert_eq!(found.len(), points.len());
    for (k, axle) in [Axle::Front, Axle::Rear].into_iter().enumerate() {
        let c = Characterised::new(&fitted, axle, &setting).expect("tyre");
        let tyre = c.whole();
        let wanted: Vec<[f64; 6]> = points
            .iter()
            .map(|p| {
                let o = tyre.forces(p);
                let radius = tyre.rolling_radius(p.load, 1.0 - p.camber.cos(), 25.0);
                let lever = c.tyre.tyre.rolling_radius;
                // the header's is a force, of either sign of a load
                let rolling = match p.load > 0.0 {
                    true => -tyre.rolling_resistance(p, 25.0) / lever,
                    false => f64::NAN,
                };
                [o.force_x, o.force_y, o.moment_x, o.moment_z, radius, rolling]
            })
            .collect();
        let left = c.named.iter().filter(|one| one.place(axle) == Place::InRecording).count();
        assert_eq!(left, 0);
        for j in 0..6 {
            let peak = wanted.iter().fold(0.0_f64, |most, w| most.max(w[j].abs()));
            let off = wanted.iter().zip(&found).map(|(w, f)| (f[6 * k + j] - w[j]).abs());
            let off = off.fold(0.0_f64, f64::max) / peak;
            println!("{axle:?} {j}: {off:.1e} of {peak:.0}");
            assert!(off < 1e-12, "{axle:?} {j}: {off:e}");
        }
    }
}

#[test]
fn the_simulator_takes_an_exported_property_file() {
    let (folder, out) = ridden();
    let tir = folder.path().join("front.tir").to_string_lossy().into_owned();
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    for set in ["5.2", "6.2"] {
        let base = ["export", &out, "--session", SESSION, "--format", "tir", "--tyre", "front"];
        roadbench(&[&base[..], &["--bikes", BIKES, "--set", set, "--out", &tir]].concat());
        let said = roadbench(&["tyre", &tir, "--load", "1172"]);
        compare_bench(&said, &fitted);
    }
}

/// What `tyre` says of a property file is what was fitted.
fn compare_bench(said: &str, fitted: &Fitted) {
    for (line, coefficient, within) in [
        ("cornering stiffness / load", C::CorneringStiffness0, 0.03),
        ("camber stiffness / load", C::CamberStiffness0, 0.03),
        ("crown radius", C::OverturningStiffness, 0.02),
        ("peak braking friction", C::MfD, 0.001),
        ("rolling radius", C::EffectiveRollingRadius, 1e-4),
        ("relaxation length", C::RelaxationLength, 0.01),
    ] {
        let text = said.lines().find_map(|l| l.trim().strip_prefix(line)).expect(line);
        let word = text.split_whitespace().last().expect("a number");
        let (found, (wanted, _)) = (
            word.parse::<f64>().expect("a number"),
            fitted.value(Axle::Front, coefficient).expect(line),
        );
        assert!((found / wanted - 1.0).abs() < within, "{line}: {found} for {wanted}");
    }
}

/// One tyre, wherever it is: the row of `tyre_parameters` is the tyre that `export` writes, and upright its stiffness is
/// the coefficient's.
#[test]
fn the_row_of_parameters_is_the_exported_tyre() {
    let (_folder, out) = ridden();
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    let bike = Bike::read(&here(BIKES).join("archive_01.toml")).expect("bike");
    let rows: Vec<TyreParameters> = read::rows(Path::new(&out)).expect("rows");
    assert_eq!(rows.iter().map(|r| r.tyre.as_str()).collect::<Vec<_>>(), ["front", "rear"]);
    for (row, axle) in rows.iter().zip(Axle::BOTH) {
        let setting = Setting { bike: Some(&bike), ..Setting::default() };
        let exported = Characterised::new(&fitted, axle, &setting).expect("tyre");
        let tyre = parameters::tyre(row);
        for (slip, angle, camber, share) in [
            (-0.05, 0.0, 0.0, 1.0),
            (-0.3, 0.05, -0.6, 1.5),
            (0.04, -0.02, 0.4, 0.6),
            (0.0, 0.1, 0.2, 2.0),
        ] {
            let input = exported.input(slip, angle, camber, share * row.load_at_rest);
            assert_eq!(tyre.forces(&input), exported.forces(&input), "{axle:?} {input:?}");
        }
        let stiffness =
            fitted.row(axle, C::CorneringStiffness0).and_then(|c| c.value).expect("value");
        let upright = tyre.tyre.stiffness.k_alpha(0.0, tyre.tyre.side_force_ratio);
        assert!((upright / stiffness - 1.0).abs() < 1e-9, "{upright} {stiffness}");
        assert!((row.load_at_rest / bike.static_load(axle) - 1.0).abs() < 1e-12);
        assert!(row.longitudinal && row.lateral && row.ridden_camber.is_some_and(|g| g > 0.3));
    }
}

/// Coefficients are no tyre of the simulator: the message says which format is.
#[test]
fn coefficients_given_as_a_tyre_say_which_format_is() {
    let (folder, out) = ridden();
    let file = folder.path().join("tyre.toml").to_string_lossy().into_owned();
    roadbench(&["export", &out, "--session", SESSION, "--format", "toml", "--out", &file]);
    let mut command = Command::cargo_bin("roadbench").expect("binary");
    let output = command.args(["tyre", &file]).output().expect("the binary ran");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("a file of coefficients") && said.contains("--format simulator"),
        "{said}"
    );
}

/// A session ridden with numbers of the front tyre in the bike file that no ride gives; `more` are lines of `[front]`.
fn ridden_on(more: &str) -> (tempfile::TempDir, String, String) {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (out, bikes) = (at("out"), at("bikes"));
    let own = std::fs::read_to_string(here(BIKES).join("archive_01.toml")).expect("bike");
    std::fs::create_dir(&bikes).expect("folder");
    let bike = own.replace("[front]\n", &format!("[front]\n{more}"));
    std::fs::write(Path::new(&bikes).join("archive_01.toml"), bike).expect("bike");
    roadbench(&["run", LOG, "--bikes", &bikes, "--out", &out, "--progress", "never"]);
    (folder, out, bikes)
}

/// One number is one number: what the fits took from the bike file, or in its place, is in every export, with where it
/// is from.
#[test]
fn what_no_ride_gives_is_the_same_number_in_every_export() {
    let given = "longitudinal_relaxation = 0.2\ndeflection_share = 0.45\n";
    for (more, lag, share, from) in
        [(given, 0.2, 0.45, "bike file"), ("", 0.07, 1.0 / 3.0, "usual value")]
    {
        let (_folder, out, bikes) = ridden_on(more);
        let export = |format: &str, more: &[&str]| {
            let base = ["export", &out, "--session", SESSION, "--bikes", &bikes, "--tyre", "front"];
            roadbench(&[&base[..], &["--format", format], more].concat())
        };
        let rows: Vec<TyreParameters> = read::rows(Path::new(&out)).expect("rows");
        assert_eq!((rows[0].longitudinal_relaxation, rows[0].deflection_share), (lag, share));
        let tyre = parameters::tyre(&rows[0]);
        assert_eq!((tyre.longitudinal_relaxation, tyre.deflection_share), (lag, share));
        let text = export("simulator", &[]);
        let table: toml::Table = text.parse().expect("a tyre");
        assert_eq!(table["longitudinal_relaxation"].as_float(), Some(lag), "{text}");
        assert_eq!(table["deflection_share"].as_float(), Some(share), "{text}");
        for key in ["longitudinal_relaxation", "deflection_share"] {
            let line = text.lines().find(|l| l.starts_with('#') && l.contains(key)).expect(key);
            assert!(line.contains(&format!("(assumed: {from})")), "{line}");
        }
        let header = export("c", &[]);
        assert!(header.contains(&format!(".deflection_share = {share:?},")), "{header}");
        assert!(header.contains(&format!("(assumed: {from})")), "{header}");
        for (set, key) in [
            ("5.2", "PTX1 "),
            ("5.2", "LAG_X "),
            ("6.2", "LONGITUDINAL_STIFFNESS "),
            ("reduced", "LONGITUDINAL_STIFFNESS "),
        ] {
            let tir = export("tir", &["--set", set]);
            let line = tir.lines().find(|l| l.starts_with(key)).expect(key);
            assert!(line.contains(&format!("assumed: {from}")), "{set}: {line}");
        }
        let tir = export("tir", &[]);
        assert!(tir.contains(&format!("LAG_X                = {lag:?} ")), "{tir}");
    }
}

/// `assumed` says from what: a rule is no bike file.
#[test]
fn what_is_assumed_says_what_it_is_from() {
    let (_folder, out) = ridden();
    let base = ["export", &out, "--session", SESSION, "--bikes", BIKES, "--tyre", "front"];
    let tir = roadbench(&[&base[..], &["--format", "tir"]].concat());
    for says in [
        "mf_e2 assumed: wheel not both braked and driven",
        "side_force_ratio assumed: bike file",
        "m (assumed: rule, 95 % ",
        // the stiffness that handling is computed with, and the trail that no ride gives
        "cornering_stiffness_0 is 8.873 1/rad, fitted, 95 % ",
        "from pneumatic_trail_0 (assumed: rule, 95 % ",
        "slip_stiffness_load assumed: usual value",
    ] {
        assert!(tir.contains(says), "{says}: {tir}");
    }
    let toml = roadbench(&[&base[..], &["--format", "toml"]].concat());
    assert!(!toml.contains("from the bike file;"), "{toml}");
}

/// The slip over camber of an exported tyre is not that of the table: every file says from what to what, and how far
/// the side force is from the fitted one.
#[test]
fn an_export_says_that_its_slip_over_camber_is_adjusted_and_what_that_costs() {
    let (_folder, out) = ridden();
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    let value = |c: C| fitted.value(Axle::Front, c).expect("value").0;
    let (c1, c3) = (value(C::SlipCamberC1), value(C::SlipCamberC3));
    let base = ["export", &out, "--session", SESSION, "--bikes", BIKES, "--tyre", "front"];
    let export = |more: &[&str]| roadbench(&[&base[..], more].concat());
    let says = format!("adjusted, from {c1:.5} and {c3:.5} (fitted, eq. 37) to ");
    let mut texts = vec![];
    for set in ["5.2", "6.2", "reduced"] {
        texts.push(export(&["--format", "tir", "--set", set]));
    }
    texts.extend(["csv", "c", "tydex", "simulator"].map(|format| export(&["--format", format])));
    for text in &texts {
        assert!(text.contains(&says) && text.contains("its side force is "), "{says}: {text}");
    }
    assert!(export(&["--format", "toml"]).contains("are as fitted (eq. 37)"));

    // what is said is what the exported tyre does at the fitted slip angles
    let tyre: toml::Table = texts[6].parse().expect("a tyre");
    assert_ne!(tyre["tyre"]["stiffness"]["c1"].as_float(), Some(c1));
    let bike = Bike::read(&here(BIKES).join("archive_01.toml")).expect("bike");
    let setting = Setting { bike: Some(&bike), ..Setting::default() };
    let c = Characterised::new(&fitted, Axle::Front, &setting).expect("tyre");
    let [least, most] = c.adjusted.expect("adjusted").side_force;
    let [low, high] = c.ranges.camber.expect("ridden");
    assert!(high < 0.0, "left-hand corners only");
    for (camber, share) in [(high, least), (low, most)] {
        let slip_angle = c1 * camber + c3 * camber.powi(3);
        let force = c.free_forces(&c.input(0.0, slip_angle, camber, 1000.0)).force_y / 1000.0;
        let off = force / (value(C::LateralFrictionCt) * camber.tan()) - 1.0;
        assert!((off - share).abs() < 1e-9, "{camber}: {off} {share}");
    }
    assert!(least < -0.03 && most > 0.03, "{least} {most}");
}
