//! A fitted tyre as a property file of Magic Formula 6.2 (`FITTYP` = 62), fitted over the ridden camber.
//!
//! Source of the form: Pacejka (2012), *Tire and Vehicle Dynamics*, 3rd ed., chapter 4.3.2. The longitudinal curve
//! carries over exactly; the lateral one and combined slip are shaped to the characterised tyre ([`super::fit_62`]).
//! The file tells how far its reader ends up from the characterised tyre, over what was ridden and over its ranges.

use super::check::{self, LargestErrors};
use super::file::{self, File, NO_LOAD, origin};
use super::fit_62;
use super::fitted::Fitted;
use super::reduced::GAIN;
use super::tyre::{Characterised, Setting};
use crate::contract::coefficient::Coefficient as C;
use crate::report::export::error::Error;
use crate::statistics::number_format::short;
use crate::tyre::mf_62::Mf62;

/// The property file of one tyre, and how well it gives the tyre back.
///
/// # Errors
/// A sentence: the fit fails, or the file could not be read back.
pub(crate) fn write(
    fitted: &Fitted,
    c: &Characterised,
    setting: &Setting<'_>,
) -> Result<(String, LargestErrors), Error> {
    let set = fit_62::magic_formula_62(c)?;
    let body = body(fitted, c, setting, &set);
    let worst = check::largest_errors(&body, c, c.with_bike)?;
    let beyond = check::largest_errors_beyond(&body, c, c.with_bike)?;
    let mut top = File::default();
    file::head(&mut top, fitted, c, "Magic Formula 6.2");
    file::differences(&mut top, c, &worst, &beyond);
    file::peak(&mut top, c, set.pDy[0]);
    file::road(&mut top, c);
    file::effects(&mut top, c);
    Ok((top.0 + &body, worst))
}

fn body(fitted: &Fitted, c: &Characterised, setting: &Setting<'_>, set: &Mf62) -> String {
    let row = |coefficient: C| {
        fitted.value(c.axle, coefficient).map_or(String::new(), |(_, r)| origin(r))
    };
    let mut f = File::default();
    file::units(&mut f);
    f.section("MODEL");
    f.number("FITTYP", 62.0, "set: Magic Formula 6.2");
    let note = match c.with_bike {
        true => "set: relaxation; combined slip is the characterised tyre's rule, not ridden",
        false => "set: relaxation; no combined slip without the bike file (--bikes)",
    };
    f.number("USE_MODE", 10.0 + file::use_mode(c, c.with_bike), note);
    f.text("TYRESIDE", "SYMMETRIC", "set: the fits go both ways");
    f.number("LONGVL", file::LONGVL, "placeholder: reference speed, m/s");
    f.number("VXLOW", 1.0, "placeholder");
    file::body(&mut f, fitted, c, setting);
    f.section("ROADBENCH");
    f.comment("keys that no other reader knows");
    let note = "overturning_stiffness and the deflection at the nominal load, m";
    f.number("CROWN_RADIUS", set.carcass.crown, note);
    f.section("STRUCTURAL");
    f.number("LONGITUDINAL_STIFFNESS", set.stiffness[0], &file::over_lag(c));
    let note = format!(
        "cornering stiffness over a relaxation length of {} m ({})",
        short(c.tyre.tyre.relaxation_length),
        c.noted(&row(C::RelaxationLength), "relaxation_length")
    );
    f.number("LATERAL_STIFFNESS", set.stiffness[1], &note);
    file::carcass(&mut f, [set.pcfx, set.pcfy].map(|p| [p[0], p[1]]));
    file::ranges(&mut f, c, c.with_bike);
    longitudinal(&mut f, c, set, &row);
    overturning(&mut f, c, set, &row);
    lateral(&mut f, fitted, c, set, &row);
    f.section("ROLLING_COEFFICIENTS");
    file::rolling(&mut f, fitted, c, setting);
    f.number("QSY7", 1.0, "set: in proportion to load");
    aligning(&mut f, c, set, &row);
    f.0
}

fn longitudinal(f: &mut File, c: &Characterised, set: &Mf62, row: &dyn Fn(C) -> String) {
    f.section("LONGITUDINAL_COEFFICIENTS");
    f.number("PCX1", set.pCx[0], &row(C::MfC));
    f.number("PDX1", set.pDx[0], &c.friction_note(&row(C::MfD)));
    f.number("PDX3", 0.0, "set: camber does not change the friction");
    f.number("PEX1", set.pEx[0], &row(C::MfE1));
    f.number("PEX4", set.pEx[3], &format!("-mf_e2/mf_e1; mf_e2 {}", row(C::MfE2)));
    f.number("PKX1", set.pKx[0], &format!("mf_b mf_c mf_d; mf_b {}", row(C::MfB)));
    f.number("PKX2", set.pKx[1], &format!("{GAIN} {}", row(C::SlipStiffnessLoad)));
    file::friction_over_load(f, c, set.pDx[1], set.pKx[2]);
    zeros(f, "PEX2 PEX3 PHX1 PHX2 PVX1 PVX2", NO_LOAD);
    numbers(
        f,
        &[
            ("RBX1", set.rBx[0]),
            ("RBX2", set.rBx[1]),
            ("RBX3", set.rBx[2]),
            ("RCX1", set.rCx[0]),
            ("REX1", set.rEx[0]),
        ],
    );
    zeros(f, "REX2 RHX1", "set: both sides alike, at every load");
}

fn overturning(f: &mut File, c: &Characterised, set: &Mf62, row: &dyn Fn(C) -> String) {
    f.section("OVERTURNING_COEFFICIENTS");
    let k_x = c.tyre.tyre.overturning_stiffness;
    let from = format!(
        "from overturning_stiffness = {} m ({}): closest to the tangent of the camber",
        short(k_x),
        row(C::OverturningStiffness)
    );
    f.number("QSX2", set.qsx[1], &from);
    f.number("QSX12", set.qsx[11], "as QSX2, by the square of the camber");
    zeros(f, "QSX1 QSX3 QSX4 QSX5 QSX6 QSX7 QSX8 QSX9 QSX10 QSX11 QSX13 QSX14", "set");
}

fn lateral(
    f: &mut File,
    fitted: &Fitted,
    c: &Characterised,
    set: &Mf62,
    row: &dyn Fn(C) -> String,
) {
    f.section("LATERAL_COEFFICIENTS");
    file::side_force(f, fitted, c);
    let t = &c.tyre.tyre;
    let k = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let stiffness = |c: C, k: f64| format!("shaped; {c} is {} 1/rad, {}", short(k), row(c));
    let over_load = |else_: &str| match c.error.stiffness_load != 0.0 {
        true => c.noted("set: to first order in load", "stiffness_load"),
        false => else_.to_owned(),
    };
    f.number("PCY1", set.pCy[0], "shaped");
    f.number("PDY1", set.pDy[0], "shaped, see the head; no ride reaches the peak");
    f.number("PDY2", set.pDy[1], &over_load("set"));
    numbers(
        f,
        &[("PDY3", set.pDy[2]), ("PEY1", set.pEy[0]), ("PEY4", set.pEy[3]), ("PEY5", set.pEy[4])],
    );
    f.number("PKY1", set.pKy[0], &stiffness(C::CorneringStiffness0, k));
    f.number("PKY2", set.pKy[1], &over_load("set: stiffness proportional to load"));
    f.number("PKY3", set.pKy[2], "shaped");
    f.number("PKY4", set.pKy[3], "set");
    f.number("PKY5", set.pKy[4], "shaped");
    let k = k * t.side_force_ratio;
    f.number("PKY6", set.pKy[5], &stiffness(C::CamberStiffness0, k));
    f.number("PKY7", set.pKy[6], &over_load("set: stiffness proportional to load"));
    f.number("PVY3", set.pVy[2], "shaped");
    f.number("PVY4", set.pVy[3], &over_load("set"));
    zeros(f, "PEY2 PEY3 PHY1 PHY2 PVY1 PVY2", "set: both sides alike, at every load");
    numbers(
        f,
        &[
            ("RBY1", set.rBy[0]),
            ("RBY2", set.rBy[1]),
            ("RBY4", set.rBy[3]),
            ("RCY1", set.rCy[0]),
            ("REY1", set.rEy[0]),
        ],
    );
    zeros(f, "RBY3 REY2 RHY1 RHY2", "set: both sides alike, at every load");
    zeros(f, "RVY1 RVY2 RVY3 RVY4 RVY5 RVY6", "set: braking moves the tyre to no side");
}

fn aligning(f: &mut File, c: &Characterised, set: &Mf62, row: &dyn Fn(C) -> String) {
    f.section("ALIGNING_COEFFICIENTS");
    f.number("QCZ1", set.qCz[0], "set");
    f.number("QBZ1", set.qBz[0], "shaped to eq. 11, how slip shortens the trail");
    let trail = file::trail(c, &row(C::PneumaticTrail0));
    f.number("QDZ1", set.qDz[0], &c.noted(&trail, "pneumatic_trail"));
    let root = "shaped: the trail grows with the root of the load";
    f.number("QDZ2", set.qDz[1], &c.noted(&c.noted(root, "pneumatic_trail"), "stiffness_load"));
    let note = format!("from twisting_stiffness ({})", row(C::TwistingStiffness));
    f.number("QDZ8", set.qDz[7], &c.noted(&note, "twisting_stiffness"));
    f.number("QDZ10", set.qDz[9], "as QDZ8: the form has the sine of the camber");
    f.number("SSZ3", set.ssz[2], "the contact moves sideways under the wheel plane");
    zeros(f, "QBZ2 QBZ3 QBZ4 QBZ5 QBZ6 QBZ9 QBZ10 QDZ3 QDZ4 QDZ6 QDZ7 QDZ9 QDZ11", "set");
    zeros(f, "QEZ1 QEZ2 QEZ3 QEZ4 QEZ5 QHZ1 QHZ2 QHZ3 QHZ4 SSZ1 SSZ2 SSZ4", "set");
}

fn numbers(f: &mut File, keys: &[(&str, f64)]) {
    for (key, value) in keys {
        f.number(key, *value, "shaped");
    }
}

fn zeros(f: &mut File, keys: &str, note: &str) {
    for key in keys.split(' ') {
        f.number(key, 0.0, note);
    }
}
