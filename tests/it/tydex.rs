//! TYDEX files: what a bench machine writes is read in SI units, what `export` writes is read as it was, and what is
//! wrong is said with its line.

use std::path::Path;

use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::export::tyre::{Characterised, Setting};
use roadbench::internals::tyre::paper::Input;
use roadbench::internals::tyre::tydex::read::{parse, read};
use roadbench::internals::tyre::tydex::write::{Head, write};
use roadbench::internals::tyre::tydex::{Bench, Point};

use super::export::{BIKES, SESSION, here, ridden, roadbench};

const BENCH: &str = "fixtures/bench/rear_180_55.tdx";

fn text(text: &str) -> Result<Bench, String> {
    parse(text.as_bytes(), Path::new("bench.tdx")).map_err(|e| e.to_string())
}

/// A file of some channels (each a name, a unit and a factor) and lines of values.
fn file(channels: &[(&str, &str, &str)], rows: &str) -> String {
    let mut out =
        "**HEADER\nRELEASE   Release                       1.3\n**MEASURCHANNELS\n".to_owned();
    for (name, unit, factor) in channels {
        out += &format!("{name:<10}{:<30}{unit:<10}{factor:<10}0         0\n", "what it is");
    }
    out + "**MEASURDATA\n" + rows + "\n**END\n"
}

#[test]
fn a_bench_machines_file_is_read_in_si_units() {
    let bench = read(&here(BENCH)).expect("readable");
    let degree = std::f64::consts::PI / 180.0;
    // the last line has no slip angle
    assert_eq!(bench.points.len(), 11);
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * b.abs().max(1.0), "{a} {b}");
    let p = bench.points[0];
    close(p.slip_angle, -2.0 * degree);
    close(p.load, 1.3012e3);
    close(p.force_y.expect("FYW"), 10.0 * (38.5 + 0.5));
    close(p.moment_z.expect("MZW"), -7.9);
    assert_eq!(p.moment_x, None);
    let leaning = bench.points[5];
    close(leaning.camber, -30.0 * degree);
    assert_eq!(leaning.moment_z, None, "-9999 is no moment");
    let braked = bench.points[9];
    close(braked.slip_ratio, -0.05);
    close(braked.force_x.expect("FX"), -905.5);
    assert_eq!(braked.moment_z, None);
    assert!(bench.head.iter().any(|(name, value)| name == "SUPPLIER" && value.contains("Prüf")));
    assert!(bench.remarks.iter().any(|r| r.contains("1 points without")), "{:?}", bench.remarks);
}

/// Forces and moments about the wheel centre, leaning or upright, are the same in the contact.
#[test]
fn axes_of_the_wheel_centre_are_brought_to_the_contact() {
    let (gamma, radius) = (-0.5_f64, 0.3);
    let [x, y, z, mx, mz] = [-400.0, 700.0, 1300.0, 18.0, 25.0];
    // vectors in the contact's axes; the centre lies up and to the left of a wheel that leans left (z tilts to +y)
    let up = [0.0, -gamma.sin(), gamma.cos()];
    let centre = up.map(|e| radius * e);
    let force = [x, y, z];
    // M_centre = M_contact + (contact - centre) x F
    let r = centre.map(|e| -e);
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
    };
    let moved = cross(r, force);
    let moment = [mx + moved[0], moved[1], mz + moved[2]];
    let axis = [0.0, gamma.cos(), gamma.sin()];
    let along = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let slips = |more: &str| format!("-0.1 0.02 {gamma} {radius} {more}");
    let mut channels = vec![
        ("LONGSLIP", "-", "1"),
        ("SLIPANGL", "rad", "1"),
        ("INCLANGL", "rad", "1"),
        ("DSTGRWHC", "m", "1"),
    ];
    channels.extend([("FX", "N", "1"), ("FYH", "N", "1"), ("FZH", "N", "1")]);
    channels.extend([("MXH", "Nm", "1"), ("MZH", "Nm", "1")]);
    let row = slips(&format!("{x} {y} {z} {} {}", moment[0], moment[2]));
    let upright = text(&file(&channels, &row)).expect("H axes").points[0];
    for (found, wanted) in [
        (upright.force_y, y),
        (Some(upright.load), z),
        (upright.moment_x, mx),
        (upright.moment_z, mz),
    ] {
        assert!((found.expect("there") - wanted).abs() < 1e-9, "{upright:?}");
    }
    channels.truncate(5);
    channels.extend([("FYC", "N", "1"), ("FZC", "N", "1"), ("MXC", "Nm", "1")]);
    let row = slips(&format!("{x} {} {} {}", along(force, axis), along(force, up), moment[0]));
    let leaning = text(&file(&channels, &row)).expect("C axes").points[0];
    for (found, wanted) in [(leaning.force_y, y), (Some(leaning.load), z), (leaning.moment_x, mx)] {
        assert!((found.expect("there") - wanted).abs() < 1e-9, "{leaning:?}");
    }
}

#[test]
fn points_that_are_written_are_read_to_the_written_digits() {
    let points: Vec<Point> = (0..400)
        .map(|i| {
            let t = f64::from(i);
            Point {
                slip_ratio: (0.37 * t).sin() * 0.4,
                slip_angle: (0.11 * t).cos() * 0.02,
                camber: (0.05 * t).sin() * 0.9,
                load: 300.0 + 7.123_456 * t,
                force_x: Some((0.37 * t).sin() * 1_234.567_89),
                force_y: (i % 7 != 0).then(|| (1.3 * t).cos() * 98.765_432_1),
                moment_x: Some(1e-7 * t),
                moment_z: Some(-12.345_678 * t),
            }
        })
        .collect();
    let head =
        Head { comments: vec!["**MEASURDATA\nis no section here".into()], ..Head::default() };
    let back = text(&write(&head, &points)).expect("readable").points;
    assert_eq!(back.len(), points.len());
    let mut worst = 0.0_f64;
    for (a, b) in points.iter().zip(&back) {
        let all = |p: &Point| {
            [
                Some(p.slip_ratio),
                Some(p.slip_angle),
                Some(p.camber),
                Some(p.load),
                p.force_x,
                p.force_y,
                p.moment_x,
                p.moment_z,
            ]
        };
        for (x, y) in all(a).into_iter().zip(all(b)) {
            assert_eq!(x.is_some(), y.is_some());
            let (Some(x), Some(y)) = (x, y) else { continue };
            // six decimals of what is small, seven digits of what is large
            let off = (x - y).abs() / x.abs().max(1.0);
            worst = worst.max(off);
            assert!(off <= 5.1e-7, "{x} became {y}");
        }
    }
    println!("largest difference {worst:.1e}");
    assert!(worst > 0.0, "digits are cut somewhere, or nothing was compared");
}

#[test]
fn what_is_wrong_is_said_with_its_line() {
    let usual = [("SLIPANGL", "deg", "1"), ("FZW", "N", "1"), ("FYW", "N", "1")];
    let refused = |text_: &str| text(text_).expect_err("refused");
    for (text_, says) in [
        (file(&usual, "1 1300 -10\n2 1300"), "line 9: 2 values, but the file has 3 channels"),
        (file(&usual, "1 1300 -10\n2 l300 -20"), "line 9: `l300` is not a number"),
        (file(&usual, "1 -1300 -10\n2 -1300 -20"), "loads are not positive"),
        (file(&[("SLIPANGL", "gon", "1"), ("FZW", "N", "1")], "1 1300"), "line 4: unit `gon`"),
        (file(&[("SLIPANGL", "deg", "1"), ("FYW", "N", "1")], "1 30"), "no load"),
        (file(&[usual[0], usual[1], usual[1]], "1 2 3"), "line 6: channel `FZW` is there twice"),
        (
            file(&usual, "").replace("MEASURCHANNELS", "MEASURCHANELS"),
            "is `**MEASURCHANNELS` meant?",
        ),
        (file(&usual, ""), "no points"),
        ("slip,force\n1,2\n".into(), "line 1: a TYDEX file begins with **HEADER"),
        (String::new(), "it is empty"),
    ] {
        let message = refused(&text_);
        assert!(message.contains("bench.tdx") && message.contains(says), "{message}: {says}");
    }
    // any cut of a whole file gives points or an error
    let whole = std::fs::read(here(BENCH)).expect("fixture");
    for cut in 0..whole.len() {
        let _ = parse(&whole[..cut], Path::new("cut.tdx"));
    }
}

#[test]
fn an_exported_tyre_is_read_back_and_compared_by_the_commands() {
    let (folder, out) = ridden();
    let at = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let bike = Bike::read(&here(BIKES).join("archive_01.toml")).expect("bike");
    let fitted = Fitted::read(Path::new(&out), SESSION, None).expect("session");
    let setting = Setting { bike: Some(&bike), ..Setting::default() };
    for axle in Axle::BOTH {
        let (tdx, simulator) = (at("tyre.tdx"), at("tyre.toml"));
        for (format, to) in [("tydex", &tdx), ("simulator", &simulator)] {
            let base = ["export", &out, "--session", SESSION, "--format", format, "--out", to];
            roadbench(&[&base[..], &["--tyre", axle.name(), "--bikes", BIKES]].concat());
        }
        let found = read(Path::new(&tdx)).expect("readable");
        assert!(found.points.len() > 500 && found.remarks.is_empty(), "{:?}", found.remarks);
        let c = Characterised::new(&fitted, axle, &setting).expect("tyre");
        let mut worst = 0.0_f64;
        for p in &found.points {
            let Point { slip_ratio, slip_angle, camber, load, .. } = *p;
            let input = Input { slip_ratio, slip_angle, camber, load, friction: 1.0 };
            let o = c.forces(&input);
            for (x, y) in [
                (p.force_x, o.force_x),
                (p.force_y, o.force_y),
                (p.moment_x, o.moment_x),
                (p.moment_z, o.moment_z),
            ] {
                worst = worst.max((x.expect("written") - y).abs() / load);
            }
        }
        println!("{axle:?}: {} points, {worst:.1e} of the load", found.points.len());
        // the slip stiffness of some 20 makes the last digit of the slip ratio count
        assert!(worst < 2e-5, "{axle:?} {worst:e}");
        let said = roadbench(&["tyre", &simulator, "--against", &tdx, "--out", &at("bench")]);
        for line in ["Fx / load", "Fy / load", "Mx / load", "Mz / load"] {
            let words: Vec<&str> = said
                .lines()
                .find_map(|l| l.trim().strip_prefix(line))
                .expect(line)
                .split_whitespace()
                .collect();
            let rms: f64 = words[2].parse().expect("rms");
            assert!(rms < 2e-5, "{line}: {said}");
        }
        let figure = std::fs::read_to_string(Path::new(&at("bench")).join("bench.svg"));
        assert!(figure.expect("figure").contains("<circle"), "no points are drawn");
    }
    // another tyre is another one
    let said = roadbench(&["tyre", "sharp2004_rear_180_55", "--against", BENCH]);
    assert!(said.contains("11 points") && said.contains("cornering stiffness / load"), "{said}");

    // and in the report
    let bench = format!("front={},rear={BENCH}", at("tyre.tdx"));
    roadbench(&["report", &out, "--bench", &bench]);
    let labels: Vec<String> = walkdir::WalkDir::new(Path::new(&out).join("report"))
        .into_iter()
        .filter_map(Result::ok)
        .filter(|e| e.path().extension().is_some_and(|x| x == "html"))
        .map(|e| std::fs::read_to_string(e.path()).expect("page"))
        .filter(|text| text.contains("id=\"data\""))
        .map(|text| crate::page::data(&text).to_string() + &text)
        .collect();
    for label in ["straight and upright", "no slip angle", "upright"] {
        let label = format!("tyre bench, {label}");
        assert!(labels.iter().any(|text| text.contains(&label)), "no page has {label}");
    }
}

#[test]
fn a_bench_file_of_no_tyre_is_asked_for_it() {
    let mut command = assert_cmd::Command::cargo_bin("roadbench").expect("binary");
    let folder = tempfile::tempdir().expect("folder");
    let output = command
        .current_dir(here(""))
        .args(["report", &folder.path().to_string_lossy(), "--bench", BENCH])
        .output()
        .expect("ran");
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(said.contains("Give front=fixtures/bench/rear_180_55.tdx or rear="), "{said}");
}
