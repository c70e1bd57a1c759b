//! A fitted tyre as a property file of the motorcycle Magic Formula: the set of MF-MCTyre 1.1
//! (`FITTYP` = 52), which Adams calls `PAC_MC`.
//!
//! Source of the form: Pacejka (2012), *Tire and Vehicle Dynamics*, 3rd ed., section 11.6; de Vries
//! and Pacejka (1998). The longitudinal curve carries over exactly, with
//! `PCX1 = c, PDX1 = d, PKX1 = b c d, PEX1 = e1, PEX4 = -e2/e1`; the lateral one and combined slip
//! are shaped to the characterised tyre ([`super::fit`]). The file tells how far its reader ends up
//! from the characterised tyre, read back and compared over what was ridden and over the ranges in the file.

use super::check::{self, LargestErrors};
use super::file::{self, File, NO_LOAD, origin};
use super::fit;
use super::fitted::Fitted;
use super::reduced::GAIN;
use super::tyre::{Characterised, Setting};
use crate::contract::coefficient::Coefficient as C;
use crate::report::export::error::Error;
use crate::statistics::number_format::short;
use crate::tyre::mf_mc::MfMc;

/// Relative loss of the relaxation length of the slip ratio when the load rises by the nominal load: `Fz (1 - x dfz)` is closest to
/// one value from half of the nominal load to its double.
const PTX2: f64 = 0.4;

/// The property file of one tyre, and how well it gives the tyre back.
///
/// # Errors
/// A sentence: the fit fails, or the file could not be read back.
pub fn write(
    fitted: &Fitted,
    c: &Characterised,
    setting: &Setting<'_>,
) -> Result<(String, LargestErrors), Error> {
    let set = fit::motorcycle(c)?;
    let body = body(fitted, c, setting, &set);
    let worst = check::largest_errors(&body, c, c.with_bike)?;
    let beyond = check::largest_errors_beyond(&body, c, c.with_bike)?;
    let mut top = File::default();
    file::head(&mut top, fitted, c, "motorcycle Magic Formula 5.2");
    file::differences(&mut top, c, &worst, &beyond);
    file::peak(&mut top, c, set.pDy[0]);
    file::road(&mut top, c);
    file::effects(&mut top, c);
    Ok((top.0 + &body, worst))
}

fn body(fitted: &Fitted, c: &Characterised, setting: &Setting<'_>, set: &MfMc) -> String {
    let row = |coefficient: C| {
        fitted.value(c.axle, coefficient).map_or(String::new(), |(_, r)| origin(r))
    };
    let mut f = File::default();
    file::units(&mut f);

    f.section("MODEL");
    f.text("PROPERTY_FILE_FORMAT", "PAC_MC", "set: MF-MCTyre");
    f.number("FITTYP", 52.0, "set: MF-MCTyre 1.1, motorcycle Magic Formula");
    let mode = file::use_mode(c, c.with_bike);
    let note = match c.with_bike {
        true => "set: combined slip is the characterised tyre's rule, not ridden",
        false => "set: no combined slip without the bike file (--bikes)",
    };
    f.number("USE_MODE", mode, note);
    f.text("TYRESIDE", "SYMMETRIC", "set: the fits go both ways");
    f.number("LONGVL", file::LONGVL, "placeholder: reference speed, m/s");
    f.number("VXLOW", 1.0, "placeholder");
    file::body(&mut f, fitted, c, setting);
    f.section("ROADBENCH");
    f.comment("keys that no other reader knows");
    let note = "overturning_stiffness and the deflection at the nominal load, m";
    f.number("CROWN_RADIUS", set.carcass.crown, note);
    f.number(
        "LAG_X",
        set.lag_x,
        &format!("relaxation length of the slip ratio, m; {}", c.lag_from),
    );
    file::ranges(&mut f, c, c.with_bike);

    longitudinal(&mut f, c, set, &row);
    overturning(&mut f, c, set, &row);
    lateral(&mut f, fitted, c, set, &row);
    f.section("ROLLING_COEFFICIENTS");
    file::rolling(&mut f, fitted, c, setting);
    aligning(&mut f, set, c, &row);
    f.0
}

fn longitudinal(f: &mut File, c: &Characterised, set: &MfMc, row: &dyn Fn(C) -> String) {
    f.section("LONGITUDINAL_COEFFICIENTS");
    f.number("PCX1", set.pCx1, &row(C::MfC));
    f.number("PDX1", set.pDx[0], &c.friction_note(&row(C::MfD)));
    f.number("PEX1", set.pEx[0], &row(C::MfE1));
    f.number("PEX4", set.pEx[3], &format!("-mf_e2/mf_e1; mf_e2 {}", row(C::MfE2)));
    f.number("PKX1", set.pKx[0], &format!("mf_b mf_c mf_d; mf_b {}", row(C::MfB)));
    f.number("PKX2", set.pKx[1], &format!("{GAIN} {}", row(C::SlipStiffnessLoad)));
    file::friction_over_load(f, c, set.pDx[1], set.pKx[2]);
    for key in ["PEX2", "PEX3", "PHX1", "PHX2", "PVX1", "PVX2"] {
        f.number(key, 0.0, NO_LOAD);
    }
    let lag = short(set.lag_x);
    let note = format!("from a relaxation length of the slip ratio of {lag} m ({})", c.lag_from);
    f.number("PTX1", set.lag_x / set.R0, &note);
    f.number("PTX2", -set.lag_x / set.R0 * PTX2, "set: as little change with load as the form can");
    f.number("PTX3", 0.0, "set");
    let note = "shaped";
    f.number("RBX1", set.rBx[0], note);
    f.number("RBX2", set.rBx[1], note);
    f.number("RCX1", set.rCx1, note);
}

fn overturning(f: &mut File, c: &Characterised, set: &MfMc, row: &dyn Fn(C) -> String) {
    let k_x = c.tyre.tyre.overturning_stiffness;
    f.section("OVERTURNING_COEFFICIENTS");
    f.number("QSX1", 0.0, "set: no offset");
    let [arm, ..] = set.overturning.unwrap_or_default();
    let note = format!(
        "from overturning_stiffness = {} m ({}), times {:.3}: the form has camber for its tangent",
        short(k_x),
        row(C::OverturningStiffness),
        arm * set.R0 / k_x
    );
    f.number("QSX2", arm, &note);
    f.number("QSX3", 0.0, "set");
}

fn lateral(
    f: &mut File,
    fitted: &Fitted,
    c: &Characterised,
    set: &MfMc,
    row: &dyn Fn(C) -> String,
) {
    f.section("LATERAL_COEFFICIENTS");
    file::side_force(f, fitted, c);
    let t = &c.tyre.tyre;
    let k = t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let stiffness = |c: C, k: f64| format!("shaped; {c} is {} 1/rad, {}", short(k), row(c));
    let peak = "shaped, see the head; no ride reaches the peak";
    let is_shaped = c.error.stiffness_load != 0.0;
    let shaped = |else_: &str| match is_shaped {
        true => c.noted("set: to first order in load", "stiffness_load"),
        false => else_.to_owned(),
    };
    for (key, value, note) in [
        ("PCY1", set.pCy[0], "shaped"),
        ("PCY2", set.pCy[1], "shaped"),
        ("PDY1", set.pDy[0], peak),
        ("PDY2", set.pDy[1], &shaped("set")),
        ("PDY3", set.pDy[2], "shaped"),
        ("PEY1", set.pEy[0], "shaped"),
        ("PEY2", set.pEy[1], "shaped"),
        ("PEY3", 0.0, "set: both sides alike"),
        ("PEY4", set.pEy[2], "shaped"),
        ("PEY5", set.pEy[3], "shaped"),
    ] {
        f.number(key, value, note);
    }
    f.number("PKY1", set.pKy[0], &stiffness(C::CorneringStiffness0, k));
    f.number("PKY2", set.pKy[1], "set");
    f.number("PKY3", set.pKy[2], &shaped("set: stiffness proportional to load"));
    f.number("PKY4", set.pKy[3], "set");
    f.number("PKY5", set.pKy[4], "shaped");
    let k = k * t.side_force_ratio;
    f.number("PKY6", set.pKy[5], &stiffness(C::CamberStiffness0, k));
    f.number("PKY7", set.pKy[6], &shaped("set: stiffness proportional to load"));
    for key in ["PHY1", "PHY2", "PVY1", "PVY2"] {
        f.number(key, 0.0, "set: no offset");
    }
    let [length, curve, most] = set.relaxation.unwrap_or_default();
    let note = format!(
        "from relaxation_length = {} m ({}), over UNLOADED_RADIUS",
        short(c.tyre.tyre.relaxation_length),
        c.noted(&row(C::RelaxationLength), "relaxation_length")
    );
    f.number("PTY1", length, &note);
    f.number("PTY2", curve, "set: with PTY3 the same relaxation length at every load");
    f.number("PTY3", most, "set");
    for (key, value) in
        [("RBY1", set.rBy[0]), ("RBY2", set.rBy[1]), ("RBY3", set.rBy[2]), ("RCY1", set.rCy1)]
    {
        f.number(key, value, "shaped");
    }
    for key in ["RVY1", "RVY2", "RVY3", "RVY4", "RVY5", "RVY6"] {
        f.number(key, 0.0, "set: braking moves the tyre to no side");
    }
}

fn aligning(f: &mut File, set: &MfMc, c: &Characterised, row: &dyn Fn(C) -> String) {
    f.section("ALIGNING_COEFFICIENTS");
    f.number("QCZ1", set.qCz1, "set");
    f.number("QBZ1", set.qBz[0], "shaped to eq. 11, how slip shortens the trail");
    for key in ["QBZ2", "QBZ5", "QBZ6", "QBZ9", "QBZ10"] {
        f.number(key, 0.0, "set");
    }
    let trail = file::trail(c, &row(C::PneumaticTrail0));
    f.number("QDZ1", set.qDz[0], &c.noted(&trail, "pneumatic_trail"));
    let root = "shaped: the trail grows with the root of the load";
    f.number("QDZ2", set.qDz[1], &c.noted(&c.noted(root, "pneumatic_trail"), "stiffness_load"));
    for key in ["QDZ3", "QDZ4"] {
        f.number(key, 0.0, "set");
    }
    let note = format!("from twisting_stiffness ({})", row(C::TwistingStiffness));
    f.number("QDZ8", set.qDzr[0], &c.noted(&note, "twisting_stiffness"));
    let [.., arm] = set.overturning.unwrap_or_default();
    for key in ["SSZ1", "SSZ2", "SSZ4"] {
        f.number(key, 0.0, "set");
    }
    f.number("SSZ3", arm, "as QSX2: the contact moves sideways under the wheel plane");
    for key in ["QDZ9", "QDZ10", "QDZ11", "QEZ1", "QEZ2", "QEZ5", "QHZ1", "QHZ2", "QHZ3", "QHZ4"] {
        f.number(key, 0.0, "set");
    }
}
