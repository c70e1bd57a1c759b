//! `roadbench tyre`.

use std::path::Path;

use clap::ValueHint;
use clap::builder::NonEmptyStringValueParser;

use crate::cli::failure::Failure;
use crate::cli::location::location;
use crate::cli::say;
use crate::cli::say::{note, put, say};
use crate::cli::tyre_measured::against_measured;
use crate::contract::coefficient::Coefficient as C;
use crate::report::static_figures::panels::{Panel, Series, Style, panels};
use crate::simulate::effects::tyre_file;
use crate::simulate::lateral_bench::LateralBench;
use crate::simulate::tyre_truth::{Bench, bench};
use crate::statistics::number_format::fixed;
use crate::store::objects::Location;
use crate::store::tables::file;
use crate::store::tables::output;
use crate::store::tables::output::Outputs;
use crate::store::tables::rows::BenchRow;
use crate::tyre::magic_formula::slip_ratio;
use crate::tyre::tydex;

/// Evaluate a tyre on a virtual test bench, alone or against another
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// A published set, or a .tir or .toml file.
    #[arg(value_parser = NonEmptyStringValueParser::new())]
    tyre: String,
    /// Another tyre to compare it with, or what a bench measured: a TYDEX file (.tdx), at whose points
    /// the tyre is then evaluated.
    #[arg(long, value_name = "TYRE|FILE.tdx", value_parser = NonEmptyStringValueParser::new())]
    against: Option<String>,
    /// Load, N; bench data have their own.
    #[arg(long, default_value_t = 1300.0)]
    load: f64,
    /// Friction of the bench.
    #[arg(long, default_value_t = 1.0)]
    friction: f64,
    /// Folder for the table (bench.parquet) and the figure (bench.svg).
    #[arg(short, long, value_parser = location(), value_hint = ValueHint::AnyPath)]
    out: Option<Location>,
}

/// What is written into the folder; of a bench's points the figure alone.
const FILES: [&str; 2] = ["bench.parquet", "bench.svg"];
/// Cambers of the table, degrees.
const CAMBERS: [f64; 5] = [0.0, 10.0, 20.0, 30.0, 45.0];
/// Slip angles of the table, degrees.
const SLIPS: [f64; 7] = [-3.0, -2.0, -1.0, 0.0, 1.0, 2.0, 3.0];

/// Runs the command.
///
/// # Errors
/// See [`Failure`].
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let Arguments { load, friction, .. } = *arguments;
    if !(10.0..=20_000.0).contains(&load) || !(0.01..=3.0).contains(&friction) {
        return Err(Failure::Usage(format!(
            "--load {load} N must be between 10 and 20000, --friction {friction} between 0.01 and 3"
        )));
    }
    if let Some(out) = &arguments.out {
        let mut outputs = Outputs::default();
        outputs.folder("--out", out)?;
        FILES.iter().try_for_each(|name| outputs.file("--out", &out.join(name)))?;
        outputs.apart_from_files([&arguments.tyre].into_iter().chain(&arguments.against))?;
    }
    let read = |name: &str| {
        if Path::new(name).is_dir() {
            return Err(Failure::Usage(format!(
                "{name} is a folder; of the output of a run write a tyre first: `roadbench export {name} --session ID \
                 --tyre front --format tir -o front.tir`"
            )));
        }
        tyre_file::load(name).map_err(Failure::usage)
    };
    let mut tyres = vec![(arguments.tyre.clone(), read(&arguments.tyre)?)];
    if let Some(name) = arguments.against.as_deref().filter(|name| tydex::is_name(name)) {
        let (name, tyre) = (Path::new(name), tyres[0].1.as_ref());
        let drawing = arguments.out.as_ref().map(|out| out.join(FILES[1]));
        return against_measured((&arguments.tyre, tyre), name, friction, drawing.as_ref());
    }
    if let Some(name) = &arguments.against {
        tyres.push((name.clone(), read(name)?));
    }
    let benches: Vec<LateralBench<'_>> = tyres
        .iter()
        .map(|(_, tyre)| LateralBench { tyre: tyre.as_ref(), load, friction })
        .collect();
    print_upright(&benches);
    print_lateral(&benches);
    let Some(out) = &arguments.out else { return Ok(()) };
    let names: Vec<&str> = tyres.iter().map(|(name, _)| name.as_str()).collect();
    let rows: Vec<BenchRow> =
        names.iter().zip(&benches).flat_map(|(name, bench)| bench.rows(name)).collect();
    let fail = |e: file::Error| Failure::Output(e.to_string());
    let [table, path] = FILES.map(|name| out.join(name));
    output::write_rows(table, &rows).map_err(fail)?;
    output::write(&path, figure(&names, &benches).as_bytes()).map_err(fail)?;
    note!("figure: {path}");
    Ok(())
}

/// Stiffnesses, peak, radius and relaxation length upright; of two tyres their ratio too.
fn print_upright(benches: &[LateralBench<'_>]) {
    let Some(LateralBench { load, friction, .. }) = benches.first() else { return };
    let found: Vec<Bench> = benches.iter().map(|b| bench(b.tyre, b.load, b.friction)).collect();
    let load = *load;
    say!("at {load} N and friction {friction}, upright:");
    let line = |what: &str, unit: &str, f: &dyn Fn(&Bench) -> f64| {
        put!("  {what:26} {unit:>6}");
        for b in &found {
            let x = f(b);
            let decimals = if x.abs() < 100.0 { 5 } else { 1 };
            put!(" {:>10}", fixed(x, decimals));
        }
        if let [a, b] = found.as_slice()
            && (f(a) / f(b)).is_finite()
        {
            put!(" {:+8.1}%", 100.0 * (f(a) / f(b) - 1.0));
        }
        say!();
    };
    line("cornering stiffness / load", "1/rad", &|b| b.cornering_stiffness);
    line("camber stiffness / load", "1/rad", &|b| b.camber_stiffness);
    line(C::TwistingStiffness.spec().short, "m/rad", &|b| b.twisting_stiffness);
    line(C::OverturningStiffness.spec().short, "m", &|b| b.overturning_stiffness);
    line("pneumatic trail", "m", &|b| b.trail);
    line("peak braking friction", "1", &|b| b.peak_friction);
    line("peak braking force", "N", &|b| b.peak_friction * load);
    line("slip ratio of that peak", "1", &|b| slip_ratio(b.peak_slip));
    line("rolling radius", "m", &|b| b.rolling_radius);
    line("relaxation length", "m", &|b| b.relaxation_length);
}

/// Width of a camber.
const LABEL: usize = 9;

/// Lateral friction over slip angle and camber; of two tyres their difference too.
fn print_lateral(benches: &[LateralBench<'_>]) {
    say!("\nlateral friction Fy/Fz; leaning left (camber -), slip angle across, deg:");
    let cell = if benches.len() > 1 { 14 } else { 9 };
    let whole = LABEL + cell * SLIPS.len() <= say::line_width();
    // where they do not fit, those in between are left out
    let slips: Vec<f64> = SLIPS
        .into_iter()
        .filter(|slip| whole || slip.rem_euclid(2.0) != 0.0 || *slip == 0.0)
        .collect();
    put!("{:>LABEL$}", "camber");
    slips.iter().for_each(|slip| put!("{slip:>cell$}"));
    say!();
    for camber in CAMBERS {
        put!("{:>5} deg", 0.0 - camber);
        for slip in &slips {
            let values: Vec<String> =
                benches.iter().map(|b| fixed(b.at(*slip, -camber), 3)).collect();
            put!("{:>cell$}", values.join("/"));
        }
        say!();
    }
    let [one, other] = benches else { return };
    say!("\nlargest and rms difference over slip angles of -3 to 3 deg:");
    for camber in CAMBERS {
        let [most, rms] = one.difference(other, -camber);
        say!("{:>5} deg  largest {most:.3}  rms {rms:.3}", 0.0 - camber);
    }
}

fn figure(names: &[&str], benches: &[LateralBench<'_>]) -> String {
    let series = |(k, (name, bench)): (usize, (&&str, &LateralBench<'_>)), camber: f64| Series {
        label: name.rsplit('/').next().unwrap_or(name).to_owned(),
        points: bench.curve(-camber),
        colour: k,
        style: if k == 0 { Style::Line } else { Style::Dashed },
    };
    let panel = |camber: f64| Panel {
        title: format!("Camber {} deg", -camber),
        x: "slip angle, deg".into(),
        y: "Fy/Fz".into(),
        series: names.iter().zip(benches).enumerate().map(|one| series(one, camber)).collect(),
    };
    panels(&[0.0, 10.0, 20.0, 30.0].map(panel), 2)
}
