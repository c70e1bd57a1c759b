//! A fitted tyre as a Magic Formula property file (`.tir`), for simulators that read MF-Tyre
//! 6.2 files for motorcycles.
//!
//! The file says of every number where it comes from: `fitted` (with its 95 % interval),
//! `assumed` (the bike file's value that the fit used), `set` (follows from the form of the
//! model) or `placeholder` (nothing in the ride gives it; a number is there because readers
//! ask for one). The mapping, with `Fz0` = `FNOMIN`, `R0` = `UNLOADED_RADIUS`:
//!
//! ```text
//! PCX1 = c   PDX1 = d   PKX1 = b c d   PEX1 = e1   PEX4 = -e2 / e1
//! PKY1 = -k_alpha0 / sin(2 atan(1 / PKY2)), PKY2 = 20, PKY4 = 2   (stiffness ~ load)
//! PKY6 = -k_gamma0   QSX2 = k_x / R0   QDZ1 = t_p0 / R0   QDZ8 = -k_t / R0   QSY1 = c_rol
//! LATERAL_STIFFNESS = k_alpha0 Fz0 / r_l                          (relaxation length)
//! ```
//!
//! The slip ratio, slip angle and camber of the contract have the signs of the TYDEX W axes,
//! so that `Fy = -Fz (k_alpha0 alpha + k_gamma0 gamma)`, `Mx = -k_x Fz gamma` and
//! `Mz = -k_t Fz gamma` at small angles carry over as written. Source of the target form:
//! Pacejka (2012), Tire and Vehicle Dynamics, 3rd ed., chapter 4.3.2.

use std::fmt::Write as _;

use crate::GRAVITY;
use crate::bike::{Axle, Bike};
use crate::report::number;
use crate::report::tyre::Fitted;
use crate::rows::{Coefficient, Status};

/// `PKY2`: so large that the stiffness is proportional to load, as the fitted model has it
/// (within 1 % up to twice the nominal load).
const PKY2: f64 = 20.0;

/// What the file needs and a ride does not give.
#[derive(Debug, Clone, Copy, Default)]
pub struct Setting<'a> {
    /// The bike file, for dimensions and static load.
    pub bike: Option<&'a Bike>,
    /// Nominal load, N, instead of the bike's static load.
    pub load: Option<f64>,
}

/// The property file of one tyre.
///
/// # Errors
/// A sentence that names the coefficient the session does not have.
pub fn write(fitted: &Fitted, axle: Axle, setting: &Setting<'_>) -> Result<String, String> {
    let tyre = axle.name();
    let need = |name: &str| {
        fitted.value(tyre, name).map_err(|e| {
            format!("a .tir file cannot do without it: {e}; --format toml writes what there is")
        })
    };
    let (b, _) = need("mf_b")?;
    let (c, c_row) = need("mf_c")?;
    let (d, d_row) = need("mf_d")?;
    let (e1, e1_row) = need("mf_e1")?;
    let (k_alpha, k_alpha_row) = need("cornering_stiffness_0")?;
    let (k_gamma, k_gamma_row) = need("camber_stiffness_0")?;
    let (radius, radius_row) = need("effective_rolling_radius")?;
    let e2 = fitted.value(tyre, "mf_e2").ok();
    let (load, load_note) = nominal_load(axle, setting);
    let wheel = setting.bike.map(|bike| bike.wheel(axle));
    let mut file = File::default();

    head(&mut file, fitted, tyre);
    file.section("MODEL");
    file.number("FITTYP", 62.0, "set: Magic Formula 6.2");
    file.number("USE_MODE", 13.0, "set: pure slip with relaxation; combined slip is not fitted");
    file.text("TYRESIDE", "SYMMETRIC", "set: the fits go both ways");
    file.number("LONGVL", 16.7, "placeholder: reference speed, m/s");
    file.number("VXLOW", 1.0, "placeholder");

    file.section("DIMENSION");
    let note = format!("{}, used as free radius too: DREFF = FREFF = 0", said(radius_row));
    file.number("UNLOADED_RADIUS", radius, &note);
    match wheel {
        Some(w) => file.number("WIDTH", w.width, "assumed: bike file"),
        None => file.number("WIDTH", 0.15, "placeholder: give the bike file with --bikes"),
    }
    file.number("ASPECT_RATIO", 0.6, "placeholder");
    file.number("RIM_RADIUS", 0.2159, "placeholder: 17 inch");
    file.number("RIM_WIDTH", 0.1, "placeholder");

    file.section("INERTIA");
    file.number("MASS", 5.0, "placeholder");
    match wheel.and_then(|w| w.wheel_inertia) {
        Some(i) => file.number("IYY", i, "assumed: bike file; the whole wheel, not the tyre"),
        None => file.number("IYY", 0.4, "placeholder"),
    }

    file.section("VERTICAL");
    file.number("FNOMIN", load, &load_note);
    match wheel {
        Some(w) => file.number("VERTICAL_STIFFNESS", w.vertical_stiffness, "assumed: bike file"),
        None => file.number("VERTICAL_STIFFNESS", 180_000.0, "placeholder"),
    }
    file.number("VERTICAL_DAMPING", 500.0, "placeholder");
    file.number("BREFF", 1.0, "set: no effect with DREFF = 0");
    file.number("DREFF", 0.0, "set: the rolling radius is the fitted one at every load");
    file.number("FREFF", 0.0, "set");

    file.section("STRUCTURAL");
    match fitted.value(tyre, "relaxation_length") {
        Ok((length, row)) if length > 0.0 => {
            let note = format!("from relaxation_length = {} m ({})", short(length), said(row));
            file.number("LATERAL_STIFFNESS", k_alpha * load / length, &note);
        }
        _ => {
            let note = "from a relaxation length equal to the rolling radius: placeholder";
            file.number("LATERAL_STIFFNESS", k_alpha * load / radius, note);
        }
    }

    ranges(&mut file);
    file.section("LONGITUDINAL_COEFFICIENTS");
    file.number("PCX1", c, &said(c_row));
    file.number("PDX1", d, &said(d_row));
    file.number("PEX1", e1, &said(e1_row));
    file.number("PKX1", b * c * d, "fitted: mf_b mf_c mf_d");
    match e2 {
        Some((e2, row)) if e1 != 0.0 => {
            file.number("PEX4", -e2 / e1, &format!("-mf_e2/mf_e1; mf_e2 {}", said(row)));
        }
        Some(_) => file.number("PEX4", 0.0, "mf_e1 is 0: mf_e2 has no place in this form"),
        None => file.number("PEX4", 0.0, "placeholder: mf_e2 is not available"),
    }
    for key in ["PDX2", "PEX2", "PEX3", "PKX2", "PKX3", "PHX1", "PHX2", "PVX1", "PVX2"] {
        file.number(key, 0.0, "set: no load dependence per load, no offset");
    }

    file.section("OVERTURNING_COEFFICIENTS");
    moment(&mut file, "QSX2", fitted.value(tyre, "overturning_stiffness"), 1.0 / radius);

    file.section("LATERAL_COEFFICIENTS");
    file.number("PCY1", 1.3, "placeholder: the ride does not reach the lateral peak");
    file.number("PDY1", d, "placeholder: the longitudinal peak mf_d");
    file.number("PEY1", 0.0, "placeholder");
    let share = (2.0 * (1.0 / PKY2).atan()).sin();
    file.number(
        "PKY1",
        -k_alpha / share,
        &format!(
            "from cornering_stiffness_0 = {} 1/rad, {}; stiffness over load at FNOMIN",
            short(k_alpha),
            said(k_alpha_row)
        ),
    );
    file.number("PKY2", PKY2, "set: stiffness proportional to load");
    file.number("PKY3", 0.0, "set: at small camber; the change with camber is in the toml export");
    file.number("PKY4", 2.0, "set");
    file.number("PKY6", -k_gamma, &said(k_gamma_row));
    for key in ["PDY2", "PDY3", "PEY2", "PEY3", "PEY4", "PKY5", "PKY7", "PHY1", "PHY2"] {
        file.number(key, 0.0, "set: no load dependence per load, no offset");
    }
    for key in ["PVY1", "PVY2", "PVY3", "PVY4"] {
        file.number(key, 0.0, "set: no offset");
    }

    file.section("ROLLING_COEFFICIENTS");
    moment(&mut file, "QSY1", fitted.value("vehicle", "rolling_resistance"), 1.0);

    file.section("ALIGNING_COEFFICIENTS");
    file.number("QBZ1", 0.0, "placeholder: the trail does not shrink with slip");
    file.number("QCZ1", 1.1, "placeholder: no effect with QBZ1 = 0");
    moment(&mut file, "QDZ1", fitted.value(tyre, "pneumatic_trail_0"), 1.0 / radius);
    moment(&mut file, "QDZ8", fitted.value(tyre, "twisting_stiffness"), -1.0 / radius);
    Ok(file.0)
}

fn nominal_load(axle: Axle, setting: &Setting<'_>) -> (f64, String) {
    if let Some(load) = setting.load {
        return (load, "set: --load".to_owned());
    }
    match setting.bike {
        Some(bike) => {
            let arm = match axle {
                Axle::Front => bike.cg_to_rear(),
                Axle::Rear => bike.cg_to_front,
            };
            let load = bike.mass * GRAVITY * arm / bike.wheelbase;
            (load, "assumed: static load from the bike file".to_owned())
        }
        None => (1500.0, "placeholder: give the bike file with --bikes, or --load".to_owned()),
    }
}

fn head(file: &mut File, fitted: &Fitted, tyre: &str) {
    let session = &fitted.session;
    let model = match tyre {
        "front" => session.tyre_front.as_deref(),
        _ => session.tyre_rear.as_deref(),
    };
    file.comment(&format!("{tyre} tyre of {}, fitted by roadbench", session.ident.bike_id));
    file.comment(&format!("session {}", session.ident.session_id));
    if let Some(model) = model {
        file.comment(&format!("tyre model {model}"));
    }
    file.comment(&format!("input {}", session.provenance.input_hash));
    file.comment("fitted: from the ride, with the 95 % interval; assumed: from the bike file;");
    file.comment("set: follows from the model; placeholder: not from this tyre, replace it.");
    file.section("MDI_HEADER");
    file.text("FILE_TYPE", "tir", "");
    file.number("FILE_VERSION", 3.0, "");
    file.text("FILE_FORMAT", "ASCII", "");
    file.section("UNITS");
    for (key, unit) in [
        ("LENGTH", "meter"),
        ("FORCE", "newton"),
        ("ANGLE", "radians"),
        ("MASS", "kg"),
        ("TIME", "second"),
    ] {
        file.text(key, unit, "");
    }
}

fn ranges(file: &mut File) {
    let note = "placeholder: see the report for what was ridden";
    file.section("LONG_SLIP_RANGE");
    file.number("KPUMIN", -0.5, note);
    file.number("KPUMAX", 0.5, note);
    file.section("SLIP_ANGLE_RANGE");
    file.number("ALPMIN", -0.17, note);
    file.number("ALPMAX", 0.17, note);
    file.section("INCLINATION_ANGLE_RANGE");
    file.number("CAMMIN", -0.9, note);
    file.number("CAMMAX", 0.9, note);
}

fn moment(file: &mut File, key: &str, value: Result<(f64, &Coefficient), String>, factor: f64) {
    match value {
        Ok((value, row)) => {
            let note = format!("from {} = {} ({})", row.coefficient, short(value), said(row));
            file.number(key, value * factor, &note);
        }
        Err(_) => file.number(key, 0.0, "placeholder: not available from this session"),
    }
}

fn short(value: f64) -> String {
    number::fixed(value, number::decimals_of(value, None))
}

/// Where a coefficient comes from, for its comment.
fn said(row: &Coefficient) -> String {
    let shown = crate::report::page::Shown::of(row).interval(" to ");
    let interval = if shown.is_empty() { String::new() } else { format!(", 95 % {shown}") };
    match row.status {
        Status::Ok => format!("fitted{interval}"),
        Status::Assumed => "assumed: bike file".to_owned(),
        Status::PoorlyDetermined | Status::NotAvailable => {
            format!("fitted but POORLY DETERMINED{interval}")
        }
    }
}

#[derive(Default)]
struct File(String);

// writing to a String cannot fail
impl File {
    fn section(&mut self, name: &str) {
        let _ = writeln!(self.0, "\n[{name}]");
    }

    fn comment(&mut self, text: &str) {
        let _ = writeln!(self.0, "$ {}", one_line(text));
    }

    fn number(&mut self, key: &str, value: f64, note: &str) {
        self.put(key, &format!("{:?}", rounded(value)), note);
    }

    fn text(&mut self, key: &str, value: &str, note: &str) {
        self.put(key, &format!("'{value}'"), note);
    }

    fn put(&mut self, key: &str, value: &str, note: &str) {
        let note = if note.is_empty() { String::new() } else { format!("  $ {}", one_line(note)) };
        let _ = writeln!(self.0, "{}", format!("{key:<20} = {value:<14}{note}").trim_end());
    }
}

/// Seven significant digits: more than any interval leaves.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let decimals = (6.0 - value.abs().log10().floor()).clamp(0.0, 15.0);
    number::round(value, decimals as usize)
}

/// A log's text cannot start a line of its own.
fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
