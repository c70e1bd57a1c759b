//! The paper's lane change on every form in which a fitted tyre leaves the program: property files 5.2 and 6.2, the
//! simulator's own, the C header and the simulation unit. Each rides like the characterised tyre, on either motorcycle
//! and on the friction of the ride and another. `ROADBENCH_LANE_CHANGE=all` rides and prints every combination.

use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command as Process, Stdio};
use std::sync::{Arc, Mutex};

use assert_cmd::Command;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::report::export::fitted::Fitted;
use roadbench::internals::report::export::tyre::{Characterised, Setting};
use roadbench::internals::simulate::effects::tyre_file;
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::simulate::{compare, ride};
use roadbench::internals::tyre::paper::{Input, Output};
use roadbench::internals::tyre::tyre_model::{Carcass, Reference, Relaxation, TyreModel};

use crate::export::{here, there};
use crate::shared::{copy_folder, folder_of};

const SESSION: &str = "characterise_sports_small_s0001";

/// A tyre in C behind a pipe: five numbers in, five out ([`PROGRAM`]).
struct Pipe {
    child: Child,
    to: ChildStdin,
    from: ChildStdout,
}

impl Drop for Pipe {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A tyre whose forces a compiled program answers; the rest is that of the characterised one.
#[derive(Clone)]
struct Compiled {
    pipe: Arc<Mutex<Pipe>>,
    like: Box<dyn TyreModel>,
}

impl std::fmt::Debug for Compiled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Compiled")
    }
}

impl TyreModel for Compiled {
    fn forces(&self, input: &Input) -> Output {
        let mut pipe = self.pipe.lock().expect("alone");
        pipe.to.write_all(&record(input)).expect("written");
        let mut bytes = [0; 40];
        pipe.from.read_exact(&mut bytes).expect("answered");
        let [force_x, force_y, moment_x, moment_z, _] = answer(&bytes);
        Output { force_x, force_y, moment_x, moment_z }
    }

    fn relaxation(&self, load: f64, speed: f64) -> Relaxation {
        self.like.relaxation(load, speed)
    }

    fn rolling_resistance(&self, input: &Input, speed: f64) -> f64 {
        self.like.rolling_resistance(input, speed)
    }

    fn carcass(&self) -> Carcass {
        self.like.carcass()
    }

    fn reference(&self) -> Reference {
        self.like.reference()
    }

    fn boxed_clone(&self) -> Box<dyn TyreModel> {
        Box::new(self.clone())
    }
}

/// An input as the program reads it.
pub fn record(input: &Input) -> Vec<u8> {
    let Input { slip_ratio, slip_angle, camber, load, friction } = *input;
    [slip_ratio, slip_angle, camber, load, friction]
        .into_iter()
        .flat_map(f64::to_ne_bytes)
        .collect()
}

/// What the program says: both forces, both moments, whether it was ridden.
pub fn answer(bytes: &[u8]) -> [f64; 5] {
    std::array::from_fn(|i| f64::from_ne_bytes(bytes[8 * i..8 * i + 8].try_into().expect("eight")))
}

/// Answers records of five numbers with five, from the header or (`OF_UNIT`) from the unit's functions.
const PROGRAM: &str = r#"#include <stdio.h>
#ifdef OF_UNIT
#include "roadbench_tyre.c"
static void evaluate(const double in[5], double out[5])
{
    static fmi3Instance unit;
    const fmi3ValueReference inputs[] = {SLIP_RATIO, CAMBER, LOAD, FRICTION};
    const fmi3ValueReference outputs[] = {FORCE_X, FORCE_Y, MOMENT_X, MOMENT_Z}, ridden = RIDDEN;
    const double values[] = {in[0], in[2], in[3], in[4]};
    fmi3Boolean yes = fmi3False;
    if (!unit) {
        unit = fmi3InstantiateModelExchange("tyre", TOKEN, "", fmi3False, fmi3False, NULL, NULL);
    }
    fmi3SetFloat64(unit, inputs, 4, values, 4);
    fmi3SetContinuousStates(unit, &in[1], 1);
    fmi3GetFloat64(unit, outputs, 4, out, 4);
    fmi3GetBoolean(unit, &ridden, 1, &yes, 1);
    out[4] = yes;
}
#else
#include "roadbench_tyre.h"
static void evaluate(const double in[5], double out[5])
{
    const roadbench_input i = {in[0], in[1], in[2], in[3], in[4]};
    const roadbench_output o = roadbench_forces(&TYRE, &i);
    out[0] = o.force_x, out[1] = o.force_y, out[2] = o.moment_x, out[3] = o.moment_z;
    out[4] = roadbench_ridden(&TYRE, &i);
}
#endif
int main(void)
{
    double in[5], out[5];
    while (fread(in, sizeof in, 1, stdin) == 1) {
        evaluate(in, out);
        if (fwrite(out, sizeof out, 1, stdout) != 1 || fflush(stdout)) {
            return 1;
        }
    }
    return 0;
}
"#;

/// As much of the standard's types as the unit needs.
const FMI: &str = r#"#include <stddef.h>
#include <stdbool.h>
#include <stdint.h>
typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean;
typedef bool fmi3Clock;
typedef char fmi3Char;
typedef const fmi3Char *fmi3String;
typedef uint8_t fmi3Byte;
typedef const fmi3Byte *fmi3Binary;
#define fmi3True true
#define fmi3False false
#define fmi3Version "3.0"
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef enum { fmi3Independent, fmi3Constant, fmi3Fixed, fmi3Tunable, fmi3Discrete, fmi3Dependent } fmi3DependencyKind;
typedef enum { fmi3IntervalNotYetKnown, fmi3IntervalUnchanged, fmi3IntervalChanged } fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean, fmi3Boolean,
    fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean *, fmi3Float64 *);
typedef void (*fmi3LockPreemptionCallback)(void);
typedef void (*fmi3UnlockPreemptionCallback)(void);
"#;

/// Compiles the program over a header or the unpacked sources of a unit in a folder.
pub fn compile(folder: &Path, axle: Axle, unit: bool) -> PathBuf {
    std::fs::write(folder.join("fmi3Functions.h"), FMI).expect("header");
    std::fs::write(folder.join("program.c"), PROGRAM).expect("program");
    let binary = folder.join("program");
    let compiler = std::env::var("CC").unwrap_or("cc".into());
    let tyre = format!("-DTYRE=roadbench_{}", axle.name());
    let mut command = Process::new(compiler);
    command.args(["-std=c99", "-O1", &tyre]).current_dir(folder);
    if unit {
        command.arg("-DOF_UNIT");
    }
    let built = command.args(["program.c", "-o"]).arg(&binary).arg("-lm").output().expect("ran");
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    binary
}

fn roadbench(folder: &Path, arguments: &[&str]) {
    Command::cargo_bin("roadbench")
        .expect("built")
        .current_dir(folder)
        .args(arguments)
        .assert()
        .success();
}

/// One ride of the characterisation, and its exports.
pub struct Study {
    folder: tempfile::TempDir,
}

impl Study {
    /// Rides and runs, or takes what another test has ridden.
    pub fn new() -> Self {
        let once = folder_of("characterised_once", |folder| {
            let text = std::fs::read_to_string(here("pipelines/scenarios/characterise.toml"));
            let text = text.expect("scenario").replace("sessions = 3", "sessions = 1");
            std::fs::write(folder.join("one.toml"), text).expect("written");
            roadbench(folder, &["simulate", "one.toml", "--out", "ride"]);
            roadbench(folder, &["run", "ride", "--out", "results"]);
        });
        let study = Study { folder: tempfile::tempdir().expect("folder") };
        for name in ["ride", "results"] {
            copy_folder(&once.join(name), &study.path(name));
        }
        study
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// A file of a tyre as it was ridden, at 0.75.
    pub fn export(&self, axle: Axle, format: &[&str], out: &str) {
        let of = ["export", "results", "--session", SESSION, "--bikes", "ride/bikes", "--out", out];
        let as_ridden = ["--tyre", axle.name(), "--friction", "0.75", "--format"];
        roadbench(self.folder.path(), &[&of[..], &as_ridden, format].concat());
    }

    /// The characterised tyre.
    pub fn tyre(&self, axle: Axle) -> Characterised {
        let bike = Bike::read(&self.path("ride/bikes/sports_small.toml")).expect("bike");
        let fitted = Fitted::read(&self.path("results"), SESSION, None).expect("session");
        let setting = Setting { bike: Some(&bike), friction: 0.75, ..Setting::default() };
        Characterised::new(&fitted, axle, &setting).expect("tyre")
    }

    /// The compiled program of the C header or of the simulation unit.
    pub fn program(&self, axle: Axle, unit: bool) -> PathBuf {
        let name = format!("{}_{unit}", axle.name());
        let folder = self.path(&name);
        std::fs::create_dir_all(&folder).expect("folder");
        if !unit {
            self.export(axle, &["c"], &format!("{name}/roadbench_tyre.h"));
            return compile(&folder, axle, false);
        }
        self.export(axle, &["fmu"], &format!("{name}/tyre.fmu"));
        let unpacked = Process::new("python3")
            .args(["-m", "zipfile", "-e", "tyre.fmu", "."])
            .current_dir(&folder)
            .status();
        assert!(unpacked.is_ok_and(|status| status.success()), "unpacked");
        compile(&folder.join("sources"), axle, true);
        folder.join("sources/program")
    }

    /// A tyre in one of the [`FORMS`].
    fn form(&self, form: &str, axle: Axle) -> Box<dyn TyreModel> {
        let end = axle.name();
        let file = |format: &[&str], name: String| {
            self.export(axle, format, &name);
            let path = self.path(&name).to_string_lossy().into_owned();
            tyre_file::load(&path).unwrap_or_else(|e| panic!("{e}"))
        };
        match form {
            "tir 5.2" => file(&["tir", "--set", "5.2"], format!("{end}_52.tir")),
            "tir 6.2" => file(&["tir", "--set", "6.2"], format!("{end}_62.tir")),
            "simulator" => file(&["simulator"], format!("{end}.toml")),
            _ => {
                let mut child = Process::new(self.program(axle, form == "unit"))
                    .stdin(Stdio::piped())
                    .stdout(Stdio::piped())
                    .spawn()
                    .expect("begun");
                let (to, from) = (child.stdin.take(), child.stdout.take());
                let (to, from) = (to.expect("pipe"), from.expect("pipe"));
                let pipe = Arc::new(Mutex::new(Pipe { child, to, from }));
                let like = tyre_file::load(&self.path(&format!("{end}.toml")).to_string_lossy());
                Box::new(Compiled { pipe, like: like.expect("the simulator's, made before") })
            }
        }
    }
}

const FORMS: [&str; 5] = ["simulator", "tir 5.2", "tir 6.2", "C header", "unit"];
/// Motorcycle and friction: what is characterised and what the paper's lane change rides first.
const ROADS: [(&str, f64); 4] = [
    ("sports_touring", 0.75),
    ("sports_small", 1.0),
    ("sports_small", 0.75),
    ("sports_touring", 1.0),
];
/// Channels of which the peaks are compared, and how far a property file may be off the characterised
/// tyre, and that off the motorcycle's own.
const CHANNELS: [(&str, f64, f64); 12] = [
    ("steer_torque", 0.12, 0.14),
    ("steer_angle", 0.04, 0.04),
    ("roll", 0.03, 0.03),
    ("slip_ratio_rear_braking", 0.05, 0.08),
    ("slip_ratio_front_braking", 0.05, 0.04),
    ("slip_angle_front", 0.35, 0.50),
    ("slip_angle_rear", 0.15, 0.12),
    ("force_y_front", 0.03, 0.03),
    ("force_y_rear", 0.03, 0.03),
    ("moment_x_front", 0.15, 0.10),
    ("moment_z_front", 0.20, 0.20),
    ("moment_z_rear", 0.30, 0.10),
];

/// The lane change of a motorcycle on a road.
fn lane_change(motorcycle: &str, friction: f64) -> Tour {
    let path = here("pipelines/scenarios/lane_change.toml");
    let text = std::fs::read_to_string(&path).expect("scenario");
    let text = text
        .replace("\nmotorcycle = \"sports_touring\"", &format!("\nmotorcycle = \"{motorcycle}\""));
    let text = text.replace("\nfriction = 0.75", &format!("\nfriction = {friction}"));
    Tour::parse(&text, &path).expect("scenario")
}

#[test]
fn every_form_rides_the_lane_change_as_the_fitted_tyre_does() {
    if !there("python3") || !there(&std::env::var("CC").unwrap_or("cc".into())) {
        return;
    }
    let study = Study::new();
    let all = std::env::var("ROADBENCH_LANE_CHANGE").is_ok_and(|what| what == "all");
    let forms = FORMS.map(|form| Axle::BOTH.map(|axle| study.form(form, axle)));
    let mut faults = Vec::new();
    let names: Vec<&str> = CHANNELS.iter().map(|(name, ..)| *name).collect();
    println!("| motorcycle | friction | form | {} |", names.join(" | "));
    for (motorcycle, friction) in &ROADS[..if all { 4 } else { 2 }] {
        let own = lane_change(motorcycle, *friction);
        let skill = Skill::learn(&own.model, ride::period(own.rate)).expect("ridable");
        let reference = ride::ride(&own, &skill, 0);
        assert!(reference.fall.is_none(), "{motorcycle} on its own tyres: {:?}", reference.fall);
        let mut fitted = Vec::new();
        for (form, [front, rear]) in FORMS.iter().zip(&forms) {
            let mut tour = own.clone();
            tour.fit(Some(front.clone()), Some(rear.clone()));
            let ridden = ride::ride(&tour, &skill, 0);
            if let Some(fall) = ridden.fall {
                faults.push(format!("{motorcycle} {friction} {form}: {fall}"));
                continue;
            }
            let peaks = compare::peaks(&reference, &ridden);
            let of =
                |name: &str| peaks.iter().find(|p| p.channel == name).expect("a channel").other;
            let own =
                |name: &str| peaks.iter().find(|p| p.channel == name).expect("a channel").error;
            let values: Vec<f64> = names.iter().map(|name| of(name)).collect();
            if fitted.is_empty() {
                fitted.clone_from(&values);
            }
            let mut row = String::new();
            for (k, (name, of_file, of_own)) in CHANNELS.iter().enumerate() {
                let (off, error) = (values[k] / fitted[k] - 1.0, own(name));
                row += &format!(" {:.1} % ({:.1} %) |", 100.0 * off, 100.0 * error);
                // the compiled ones are the same equations: what differs is rounding, which a rider feeds back
                let most = if form.starts_with("tir") { *of_file } else { 1e-3 };
                if off.abs() > most || error.abs() > of_own + most {
                    faults.push(format!(
                        "{motorcycle} {friction} {form} {name}: {off:.3}, {error:.3}"
                    ));
                }
            }
            println!("| {motorcycle} | {friction} | {form} |{row}");
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// The relaxation length of a file is the fitted one at every load, and its friction that of the road.
#[test]
fn a_property_file_has_the_relaxation_length_and_the_friction_of_the_ride() {
    let study = Study::new();
    for axle in Axle::BOTH {
        let c = study.tyre(axle);
        let fitted = c.whole().relaxation(1.0, 20.0);
        for form in ["tir 5.2", "tir 6.2"] {
            let file = study.form(form, axle);
            for share in [0.3, 0.5, 1.0, 1.8, 2.5] {
                let found = file.relaxation(share * c.load(), 20.0);
                let off = (found.lateral / fitted.lateral - 1.0).abs();
                assert!(off < 0.02, "{axle:?} {form} {share}: {found:?} for {fitted:?}");
                let off = (found.longitudinal / fitted.longitudinal - 1.0).abs();
                assert!(off < 0.03, "{axle:?} {form} {share}: {found:?} for {fitted:?}");
            }
            for friction in [0.5, 0.75, 1.0] {
                let most = |tyre: &dyn TyreModel| {
                    let braked = (1..300).map(|i| Input {
                        slip_ratio: -f64::from(i) * 2e-3,
                        slip_angle: 0.0,
                        camber: 0.0,
                        load: c.load(),
                        friction,
                    });
                    braked.map(|i| tyre.forces(&i).force_x.abs()).fold(0.0, f64::max)
                };
                let (found, wanted) = (most(file.as_ref()), most(c.whole()));
                assert!((found / wanted - 1.0).abs() < 1e-3, "{axle:?} {form} {friction}");
            }
        }
        let text = std::fs::read_to_string(study.path(&format!("{}_52.tir", axle.name())));
        let text = text.expect("written above");
        for said in ["on a road of friction 0.75", "PTX1", "PTX2", "PTY1", "PTY2", "PTY3"] {
            assert!(text.contains(said), "{said} is not in {text}");
        }
    }
}

/// A motorcycle that falls is said to fall, when, and nothing is said of its peaks.
#[test]
fn a_fall_is_said_and_its_peaks_are_not_compared() {
    let folder = tempfile::tempdir().expect("folder");
    let text =
        roadbench::internals::tyre::published::text("sharp2004_front_120_70").expect("published");
    // a side force that comes after two metres
    let late: Vec<String> = text
        .lines()
        .map(|line| match line.trim_start().starts_with("LAG_C0") {
            true => "LAG_C0 = 2e-4".to_owned(),
            false => line.to_owned(),
        })
        .collect();
    std::fs::write(folder.path().join("late.tir"), late.join("\n")).expect("written");
    let mut command = Command::cargo_bin("roadbench").expect("built");
    let arguments =
        ["simulate", "lane_change", "--front-tyre", "late.tir", "--compare", "--out", "o"];
    let output = command.current_dir(folder.path()).args(arguments).output().expect("ran");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(!output.status.success(), "{said}");
    assert!(said.contains("on the given tyres the motorcycle fell over at "), "{said}");
    assert!(said.contains("no peaks are compared"), "{said}");
    assert!(!said.contains("steer_torque") && !said.contains('%'), "{said}");
    let peaks = folder.path().join("o/compare/peaks.parquet");
    let peaks: Vec<roadbench::internals::store::tables::rows::PeakRow> =
        roadbench::internals::store::tables::read::file_rows(&peaks).expect("a table");
    assert!(peaks.is_empty());
}
