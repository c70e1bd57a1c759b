//! `roadbench tyre --against FILE.tdx`: a tyre at the points that a bench measured.

use std::path::Path;

use crate::cli::failure::Failure;
use crate::cli::say::{note, put, say};
use crate::report::static_figures::panels::{Panel, Series, Style, panels};
use crate::simulate::bench_points::{
    BenchPoints, Both, FRICTION_X, FRICTION_Y, MOMENT_X, MOMENT_Z, Quantity,
};
use crate::store::objects::Location;
use crate::store::tables::output;
use crate::tyre::tydex::Point;
use crate::tyre::tydex::read::read;
use crate::tyre::tyre_model::TyreModel;

/// Sweeps of the slip angle in the figure.
const SWEEPS: usize = 3;

/// Compares a tyre (and its name) with a TYDEX file, and draws both into a file where one is given.
///
/// # Errors
/// The file is none, or the figure cannot be written.
pub(crate) fn against_measured(
    (name, tyre): (&str, &dyn TyreModel),
    measured: &Path,
    friction: f64,
    drawing: Option<&Location>,
) -> Result<(), Failure> {
    let found = read(measured).map_err(Failure::usage)?;
    for remark in &found.remarks {
        tracing::warn!("{}: {remark}", measured.display());
    }
    let bench = BenchPoints { tyre, points: &found.points, friction };
    say!(
        "{} points of {} and the tyre at the same slips, cambers and loads (median {:.0} N), friction {friction}:",
        found.points.len(),
        measured.display(),
        bench.load()
    );
    print_both(&bench);
    print_differences(&bench);
    let Some(path) = drawing else { return Ok(()) };
    output::write(path, figure(name, &bench).as_bytes())
        .map_err(|e| Failure::Output(e.to_string()))?;
    note!("figure: {path}");
    Ok(())
}

fn print_both(bench: &BenchPoints<'_>) {
    say!("  {:<26} {:>6} {:>7} {:>10} {:>10}", "", "", "points", "measured", "tyre");
    let line = |what: &str, unit: &str, found: Option<Both>| {
        put!("  {what:<26} {unit:>6}");
        match found {
            None => put!(" {:>7} {:>10} {:>10}", 0, "-", "-"),
            Some(Both { points, measured, model }) => {
                put!(" {points:>7} {measured:>10.4} {model:>10.4}");
                if (model / measured).is_finite() {
                    put!(" {:>+8.1}%", 100.0 * (model / measured - 1.0));
                }
            }
        }
        say!();
    };
    line("slip stiffness / load", "1", bench.slip_stiffness());
    line("cornering stiffness / load", "1/rad", bench.cornering_stiffness());
    line("camber stiffness / load", "1/rad", bench.camber_stiffness());
    line("largest Fx / load", "1", bench.peak(FRICTION_X));
    line("largest Fy / load", "1", bench.peak(FRICTION_Y));
}

fn print_differences(bench: &BenchPoints<'_>) {
    say!("\ndifference of the tyre from the points:");
    say!(
        "  {:<26} {:>6} {:>7} {:>10} {:>10} {:>9}",
        "",
        "",
        "points",
        "rms",
        "largest",
        "rms/peak"
    );
    for (what, unit, quantity) in [
        ("Fx / load", "1", FRICTION_X),
        ("Fy / load", "1", FRICTION_Y),
        ("Mx / load", "m", MOMENT_X),
        ("Mz / load", "m", MOMENT_Z),
    ] {
        let Some(d) = bench.difference(quantity) else { continue };
        put!("  {what:<26} {unit:>6} {:>7} {:>10.5} {:>10.5}", d.points, d.rms, d.largest);
        if d.peak > 0.0 {
            put!(" {:>8.1}%", 100.0 * d.rms / d.peak);
        }
        say!();
    }
}

/// Points and the tyre's curve: slip ratio upright, then the slip angle at the cambers with most points.
fn figure(name: &str, bench: &BenchPoints<'_>) -> String {
    let name = name.rsplit('/').next().unwrap_or(name);
    let mut sweeps = vec![Sweep::Braked(bench.braked())];
    let cambers = bench.sweeps().into_iter().take(SWEEPS);
    sweeps.extend(cambers.map(|(camber, points)| Sweep::Steered(camber, points)));
    let all: Vec<Panel> = sweeps.iter().filter_map(|sweep| sweep.panel(name, bench)).collect();
    panels(&all, 2)
}

/// Points with one slip changed.
enum Sweep {
    /// The slip ratio, upright and straight on.
    Braked(Vec<Point>),
    /// The slip angle, at a camber in degrees.
    Steered(i64, Vec<Point>),
}

impl Sweep {
    /// None of a sweep with one abscissa.
    fn panel(&self, name: &str, bench: &BenchPoints<'_>) -> Option<Panel> {
        let (points, title, x_label, y_label) = match self {
            Sweep::Braked(points) => (points, "Upright".to_owned(), "slip ratio", "Fx/Fz"),
            Sweep::Steered(camber, points) => {
                (points, format!("Camber {camber} deg"), "slip angle, deg", "Fy/Fz")
            }
        };
        let (measured, of): Quantity = match self {
            Sweep::Braked(_) => FRICTION_X,
            Sweep::Steered(..) => FRICTION_Y,
        };
        let x = |p: &Point| match self {
            Sweep::Braked(_) => p.slip_ratio,
            Sweep::Steered(..) => p.slip_angle.to_degrees(),
        };
        let dots: Vec<(f64, f64)> =
            points.iter().filter_map(|p| Some((x(p), measured(p)?))).collect();
        let low = dots.iter().map(|d| d.0).fold(f64::MAX, f64::min);
        let high = dots.iter().map(|d| d.0).fold(f64::MIN, f64::max);
        if dots.is_empty() || low == high {
            return None;
        }
        let load = BenchPoints { points, ..*bench }.load();
        let curve = |i: i32| {
            let x = low + (high - low) * f64::from(i) / 100.0;
            let [slip_ratio, slip_angle, camber] = match self {
                Sweep::Braked(_) => [x, 0.0, 0.0],
                Sweep::Steered(camber, _) => [0.0, x.to_radians(), (*camber as f64).to_radians()],
            };
            let point = Point { slip_ratio, slip_angle, camber, load, ..Point::default() };
            (x, bench.model(&point, of))
        };
        Some(Panel {
            title: format!("{title}, {load:.0} N"),
            x: x_label.into(),
            y: y_label.into(),
            series: vec![
                Series { label: "measured".into(), points: dots, colour: 0, style: Style::Points },
                Series {
                    label: name.into(),
                    points: (0..=100).map(curve).collect(),
                    colour: 1,
                    style: Style::Line,
                },
            ],
        })
    }
}
