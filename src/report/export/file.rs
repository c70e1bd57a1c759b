//! Property files line by line, and the sections that every set has.
//!
//! The file says of every number where it comes from: `fitted` (with its 95 % interval),
//! `assumed` (no ride gave it; the line says whether the bike file, a rule or a usual value did), `set` (follows from the form of the
//! model), `shaped` (fitted to the characterised tyre over the ranges) or `placeholder` (nothing
//! in the ride gives it; a number is there because readers ask for one).

use std::fmt::Write as _;

use super::check::LargestErrors;
use super::fitted::Fitted;
use super::tyre::{Characterised, Setting};
use super::validity::Validity;
use crate::contract::bike::USUAL_WHEEL_INERTIA;
use crate::contract::coefficient::{Coefficient as C, Part};
use crate::report::export::error::Error;
use crate::report::labels;
use crate::statistics::number_format::{self, short};
use crate::store::tables::rows::{Coefficient, Status};

/// Reference speed, m/s.
pub(crate) const LONGVL: f64 = 16.7;
/// Note of a coefficient that the form has and the tyre has not.
pub(crate) const NO_LOAD: &str = "set: no load dependence per load, no offset";

/// A property file as it grows.
#[derive(Default)]
pub(crate) struct File(pub String);

// writing to a String cannot fail
impl File {
    /// `[NAME]`.
    pub(crate) fn section(&mut self, name: &str) {
        let _ = writeln!(self.0, "\n[{name}]");
    }

    /// A line of its own for people.
    pub(crate) fn comment(&mut self, text: &str) {
        let _ = writeln!(self.0, "$ {}", one_line(text));
    }

    /// A number and where it comes from.
    pub(crate) fn number(&mut self, key: &str, value: f64, note: &str) {
        self.put(key, &format!("{:?}", rounded(value)), note);
    }

    pub(crate) fn text(&mut self, key: &str, value: &str, note: &str) {
        self.put(key, &format!("'{value}'"), note);
    }

    fn put(&mut self, key: &str, value: &str, note: &str) {
        let note = if note.is_empty() { String::new() } else { format!("  $ {}", one_line(note)) };
        let _ = writeln!(self.0, "{}", format!("{key:<20} = {value:<14}{note}").trim_end());
    }

    /// A coefficient of the session, over what the key is normalised by.
    pub(crate) fn coefficient(
        &mut self,
        key: &str,
        value: Result<(f64, &Coefficient), Error>,
        factor: f64,
    ) {
        match value {
            Ok((value, row)) => {
                let note = format!("from {} = {} ({})", row.coefficient, short(value), origin(row));
                self.number(key, value * factor, &note);
            }
            Err(_) => self.number(key, 0.0, "placeholder: not available from this session"),
        }
    }
}

/// Whose tyre it is and how the file is to be read, up to the units. `model` names the set.
pub(crate) fn head(file: &mut File, fitted: &Fitted, c: &Characterised, model: &str) {
    let (session, end) = (&fitted.session, c.axle.name());
    let tyre = match end {
        "front" => session.tyre_front.as_deref(),
        _ => session.tyre_rear.as_deref(),
    };
    file.comment(&format!("{end} tyre of {}, fitted by roadbench: {model}", session.ident.bike_id));
    file.comment(&format!("session {}", session.ident.session_id));
    if let Some(start) = &session.ident.start_time {
        file.comment(&format!("ridden {start}"));
    }
    if let Some(tyre) = tyre {
        file.comment(&format!("tyre model {tyre}"));
    }
    let from = &session.provenance;
    file.comment(&format!("input {}", from.input_hash));
    file.comment(&format!("pipeline {}, roadbench {}", from.pipeline_hash, from.version));
    file.comment(
        "Axes of ISO 8855 / TYDEX W: x forward, y left, z up. A positive slip ratio drives. A",
    );
    file.comment(
        "positive slip angle or camber pulls to the right (negative Fy); in a left-hand corner",
    );
    file.comment(
        "camber is negative and Fy positive. Forces act where the wheel plane meets the road.",
    );
    file.comment(
        "fitted: from the ride, with the 95 % interval; assumed: not from the ride, from what",
    );
    file.comment("the line says; shaped: fitted to the characterised tyre over what was ridden;");
    file.comment("set: follows from the model; placeholder: not from this tyre, replace it.");
    for line in c.adjustment() {
        file.comment(&line);
    }
}

/// Effects of the rolling radius: property files of this form have one radius at every load.
const NO_KEY: [&str; 3] = ["radius_load", "radius_camber", "radius_speed"];

/// Identified causes of a diagnosis: the tyre that has each, or that no tyre has it.
pub(crate) fn effects(file: &mut File, c: &Characterised) {
    for line in c.effects(&NO_KEY) {
        file.comment(&line);
    }
}

/// The note of the trail, which no ride gives: `from` is where the coefficient is from.
pub(crate) fn trail(c: &Characterised, from: &str) -> String {
    match c.with_bike {
        true => format!("from pneumatic_trail_0 ({from}): eq. 12 with VERTICAL_STIFFNESS"),
        false => "placeholder: give --bikes".to_owned(),
    }
}

/// The note of a longitudinal stiffness: over which relaxation length, and where that is from.
pub(crate) fn over_lag(c: &Characterised) -> String {
    let lag = short(c.tyre.longitudinal_relaxation);
    let usual = if c.longitudinal { "" } else { "placeholder: a usual " };
    format!(
        "{usual}slip stiffness over a relaxation length of the slip ratio of {lag} m ({})",
        c.lag_from
    )
}

/// Friction over load: the peak's gain and what the slip stiffness has of it.
pub(crate) fn friction_over_load(file: &mut File, c: &Characterised, peak: f64, exponent: f64) {
    let note = |else_: &str| match c.error.friction_load == 0.0 {
        true => else_.to_owned(),
        false => c.noted("", "friction_load"),
    };
    file.number("PDX2", peak, &note(NO_LOAD));
    file.number("PKX3", exponent, &note(NO_LOAD));
}

/// Origin of the lateral coefficients.
pub(crate) fn side_force(file: &mut File, fitted: &Fitted, c: &Characterised) {
    let row = |coefficient: C| {
        fitted.value(c.axle, coefficient).map_or(String::new(), |(_, r)| origin(r))
    };
    file.comment(&format!("from lateral_friction_ct {}", row(C::LateralFrictionCt)));
    for coefficient in [C::SlipCamberC1, C::SlipCamberC3] {
        let line = format!("     {coefficient} {}", row(coefficient));
        let adjusted = if c.adjusted.is_some() { "; adjusted, see the head" } else { "" };
        file.comment(&format!("{line}{adjusted}"));
    }
    let ratio = c.noted(&row(C::SideForceRatio), "side_force_ratio_front");
    file.comment(&format!("     side_force_ratio {}", c.noted(&ratio, "side_force_ratio_rear")));
}

/// Rolling resistance: the ride's, else the one that the tyre has.
pub(crate) fn rolling(file: &mut File, fitted: &Fitted, c: &Characterised, setting: &Setting<'_>) {
    match fitted.value(Part::Vehicle, C::RollingResistance) {
        Err(_) => {
            let note = setting.origin("aerodynamics.rolling_resistance");
            file.number("QSY1", c.tyre.tyre.rolling_resistance, note);
        }
        found => file.coefficient("QSY1", found, 1.0),
    }
    rolling_over_speed(file, c);
}

/// Rolling resistance over speed, where it depends on it.
fn rolling_over_speed(file: &mut File, c: &Characterised) {
    if c.error.rolling_speed != 0.0 {
        let note = c.noted("times LONGVL", "rolling_speed");
        file.number("QSY3", c.error.rolling_resistance(0.0, LONGVL), &note);
    }
}

/// `[MDI_HEADER]` and `[UNITS]`.
pub(crate) fn units(file: &mut File) {
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

/// `USE_MODE` of what the ride gave: 1 longitudinal, 2 lateral, 3 both, 4 both combined.
pub(crate) fn use_mode(c: &Characterised, with_combined: bool) -> f64 {
    match (c.longitudinal, c.lateral) {
        (true, true) if with_combined => 4.0,
        (true, true) => 3.0,
        (true, false) => 1.0,
        _ => 2.0,
    }
}

/// `[DIMENSION]`, `[INERTIA]` and `[VERTICAL]`.
pub(crate) fn body(file: &mut File, fitted: &Fitted, c: &Characterised, setting: &Setting<'_>) {
    let wheel = setting.bike.map(|bike| bike.wheel(c.axle));
    file.section("DIMENSION");
    if let Ok((radius, row)) = fitted.value(c.axle, C::EffectiveRollingRadius) {
        let note = format!("{}, used as free radius too: DREFF = FREFF = 0", origin(row));
        file.number("UNLOADED_RADIUS", radius, &note);
    }
    match wheel {
        Some(w) => file.number("WIDTH", w.width, "assumed: bike file"),
        None => file.number("WIDTH", 0.15, "placeholder: give the bike file with --bikes"),
    }
    file.number("ASPECT_RATIO", 0.6, "placeholder");
    file.number("RIM_RADIUS", 0.2159, "placeholder: 17 inch");
    file.number("RIM_WIDTH", 0.1, "placeholder");

    file.section("INERTIA");
    file.number("MASS", 5.0, "placeholder");
    let inertia = setting
        .bike
        .map_or(USUAL_WHEEL_INERTIA[c.axle as usize], |bike| bike.wheel_inertia(c.axle));
    let note = setting.origin_at(c.axle, "wheel_inertia");
    file.number("IYY", inertia, &format!("{note}; the whole wheel, not the tyre"));

    file.section("VERTICAL");
    let note = match (setting.load, setting.bike) {
        (Some(_), _) => "set: --load",
        (None, Some(_)) => "assumed: static load from the bike file",
        (None, None) => "placeholder: give the bike file with --bikes, or --load",
    };
    file.number("FNOMIN", c.load(), note);
    let note = setting.origin_at(c.axle, "vertical_stiffness");
    file.number("VERTICAL_STIFFNESS", c.tyre.tyre.vertical_stiffness, note);
    file.number("VERTICAL_DAMPING", c.tyre.vertical_damping, "placeholder");
    file.number("BREFF", 1.0, "set: no effect with DREFF = 0");
    file.number("DREFF", 0.0, "set: the rolling radius is the fitted one at every load");
    file.number("FREFF", 0.0, "set");
}

/// Lines of the head about the differences from the estimated tyre, read back.
pub(crate) fn differences(
    file: &mut File,
    c: &Characterised,
    ridden: &LargestErrors,
    all: &LargestErrors,
) {
    file.comment(
        "Largest differences from the characterised tyre over what was ridden, read back:",
    );
    for line in ridden.lines() {
        file.comment(&line);
    }
    let peak = Validity::of(c).peak;
    file.comment(
        "and over all ranges of this file, as far as the characterised tyre's side force is no",
    );
    file.comment(&format!(
        "larger than {peak:.2} of the load (it is linear in the slip angle for ever):"
    ));
    for line in all.lines() {
        file.comment(&line);
    }
}

/// Lines of the head about the lateral peak.
pub(crate) fn peak(file: &mut File, c: &Characterised, peak: f64) {
    let assumed = Validity::of(c).peak / c.tyre.tyre.reference_friction;
    file.comment(&format!(
        "No ride reaches the lateral peak: PDY1 = {peak:.3} is shaped between 1.0 and 1.15 times {assumed:.3},"
    ));
    file.comment(
        "the larger of the longitudinal peak mf_d and 1.15 times the side force that was ridden.",
    );
}

/// Lines of the head about the road of the ride.
pub(crate) fn road(file: &mut File, c: &Characterised) {
    let friction = c.tyre.tyre.reference_friction;
    file.comment(&format!(
        "Ridden on a road of friction {friction} (--friction). PDX1, PDY1 and what goes with them are those of a"
    ));
    file.comment(&format!(
        "road of 1: on the road of the ride a reader takes LMUX = LMUY = {friction}, or that road's friction."
    ));
}

/// Stiffness of the carcass over load, along and across.
pub(crate) fn carcass(file: &mut File, [along, across]: [[f64; 2]; 2]) {
    let note = "set: as the slip stiffness, for one relaxation length at every load";
    file.number("PCFX1", along[0], note);
    file.number("PCFX2", along[1], note);
    file.number("PCFX3", 0.0, "set");
    file.number("PCFY1", across[0], note);
    file.number("PCFY2", across[1], note);
    file.number("PCFY3", 0.0, "set");
}

/// The ranges in which the file may be used: wider than what was ridden, see [`super::validity`].
pub(crate) fn ranges(file: &mut File, c: &Characterised, with_bike: bool) {
    let validity = Validity::of(c);
    let ends = validity.ends;
    let r = &c.ranges;
    let beyond = "extrapolated beyond as the estimated tyre is";
    // of a half that was not ridden there is no estimated tyre
    let of = |half: bool| match half {
        true => beyond,
        false => "placeholder: the ride did not give this half of the tyre",
    };
    let note = |range: Option<[f64; 2]>, both: bool, beyond: &str| match range {
        None => format!("not ridden, {beyond}"),
        Some([low, high]) => {
            let symmetric = if both { ", both sides alike" } else { "" };
            format!("ridden {low:.4} to {high:.4}{symmetric}; {beyond}")
        }
    };
    file.comment("Ranges to simulate in, wider than what was ridden: each says where it was.");
    file.section("LONG_SLIP_RANGE");
    let text = note(r.slip_ratio, false, of(c.longitudinal));
    file.number("KPUMIN", ends.slip_ratio[0], &text);
    file.number("KPUMAX", ends.slip_ratio[1], &text);
    file.section("SLIP_ANGLE_RANGE");
    let linear = validity.peak_angle.min(ends.slip_angle);
    let side = match c.lateral {
        true => format!("{beyond} to {linear:.3} (upright), then the form's own peak"),
        false => of(false).to_owned(),
    };
    let text = note(r.slip_angle, true, &side);
    file.number("ALPMIN", -ends.slip_angle, &text);
    file.number("ALPMAX", ends.slip_angle, &text);
    file.section("INCLINATION_ANGLE_RANGE");
    let text = note(r.camber, true, of(c.lateral));
    file.number("CAMMIN", -ends.camber, &text);
    file.number("CAMMAX", ends.camber, &text);
    file.section("VERTICAL_FORCE_RANGE");
    let [low, high] = c.loads;
    let text = match (with_bike, r.acceleration_x) {
        (true, Some([slowest, fastest])) => format!(
            "ridden {low:.0} to {high:.0} (accelerations of {slowest:.1} to {fastest:.1} m/s2 and the bike file); \
             {beyond}"
        ),
        (true, None) => format!("ridden at the static load; {beyond}"),
        (false, _) => format!("not known what was ridden, give --bikes; {beyond}"),
    };
    file.number("FZMIN", ends.load[0], &text);
    file.number("FZMAX", ends.load[1], &text);
    if c.lateral {
        let most = c.ridden_side();
        file.comment(&format!(
            "side force was ridden up to {most:.2} of the load; beyond it the file is extrapolated"
        ));
    }
}

/// Where a coefficient comes from, for its comment.
pub(crate) fn origin(row: &Coefficient) -> String {
    let shown = crate::report::coefficient_text::CoefficientText::of(row).interval(" to ");
    let interval = if shown.is_empty() { String::new() } else { format!(", 95 % {shown}") };
    match row.status {
        Status::Ok => format!("fitted{interval}"),
        Status::Assumed => format!("assumed: {}{interval}", labels::assumed(row)),
        Status::LowerBound => format!("not reached by the ride{interval}"),
        Status::PoorlyDetermined => format!("fitted but POORLY DETERMINED{interval}"),
        Status::NotAvailable => format!("NOT AVAILABLE from this ride{interval}"),
    }
}

/// Eight significant digits: more than any interval leaves, so few that rounding is no error.
fn rounded(value: f64) -> f64 {
    if value == 0.0 || !value.is_finite() {
        return 0.0;
    }
    let decimals = (7.0 - value.abs().log10().floor()).clamp(0.0, 15.0);
    number_format::round(value, decimals as usize)
}

/// A log's text cannot start a line of its own.
pub(crate) fn one_line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
