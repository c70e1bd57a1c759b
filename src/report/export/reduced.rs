//! A fitted tyre as a property file of MF-Tyre 6.2 (`FITTYP` = 62), for readers that do not know
//! the motorcycle set, and where a ride gave only half of the tyre.
//!
//! Reduced: what follows in closed form at small angles, nothing is shaped. The mapping, with
//! `Fz0` = `FNOMIN`, `R0` = `UNLOADED_RADIUS`:
//!
//! ```text
//! PCX1 = c   PDX1 = d   PKX1 = b c d   PKX2 = slip_stiffness_load PKX1   PEX1 = e1   PEX4 = -e2 / e1
//! PDX2, PKX3: friction over load   PKY2, PKY7, PDY2: side force per load over load, where a diagnosis identified them
//! PKY1 = -k_alpha0 / sin(2 atan(1 / PKY2)), PKY2 = 20, PKY4 = 2   (stiffness ~ load)
//! PKY6 = -k_gamma0   QSX2 = k_x / R0   QDZ1 = t_p0 / R0   QDZ8 = -k_t / R0   QSY1 = c_rol
//! LATERAL_STIFFNESS = k_alpha0 Fz0 / r_l                          (relaxation length)
//! ```
//!
//! The slip ratio, slip angle and camber of the contract have the signs of the TYDEX W axes,
//! so that `Fy = -Fz (k_alpha0 alpha + k_gamma0 gamma)`, `Mx = -k_x Fz gamma` and
//! `Mz = -k_t Fz gamma` at small angles carry over as written. Source of the target form:
//! Pacejka (2012), Tire and Vehicle Dynamics, 3rd ed., chapter 4.3.2.

use super::check::{self, LargestErrors};
use super::file::{self, File, NO_LOAD, origin};
use super::fit::proportional;
use super::fit_62::PKY2;
use super::fitted::Fitted;
use super::over_load::OverLoad;
use super::tyre::{Characterised, Setting};
use crate::contract::coefficient::Coefficient as C;
use crate::report::export::error::Error;
use crate::statistics::number_format::short;

/// Where `PKX2` comes from.
pub(crate) const GAIN: &str = "PKX1 times slip_stiffness_load";

/// The property file of one tyre, and, where it holds both halves, how well it gives the tyre back.
///
/// # Errors
/// A sentence: the file could not be read back.
pub fn write(
    fitted: &Fitted,
    c: &Characterised,
    setting: &Setting<'_>,
) -> Result<(String, Option<LargestErrors>), Error> {
    let body = body(fitted, c, setting);
    let mut top = File::default();
    file::head(&mut top, fitted, c, "Magic Formula 6.2, reduced set");
    let whole = c.longitudinal && c.lateral;
    let worst = if whole { Some(check::largest_errors(&body, c, false)?) } else { None };
    if let Some(worst) = &worst {
        top.comment(
            "Largest differences from the characterised tyre over what was ridden, read back (the",
        );
        top.comment(
            "lateral part is right at small angles only; the sets 5.2 and 6.2 are right over all):",
        );
        for line in worst.lines() {
            top.comment(&line);
        }
    }
    if !c.longitudinal {
        top.comment(
            "The ride gave no longitudinal friction: its section is left out (USE_MODE 2).",
        );
    }
    if !c.lateral {
        top.comment("The ride gave no lateral stiffness: its section is left out (USE_MODE 1).");
    }
    file::road(&mut top, c);
    file::effects(&mut top, c);
    Ok((top.0 + &body, worst))
}

fn body(fitted: &Fitted, c: &Characterised, setting: &Setting<'_>) -> String {
    let tyre = c.axle;
    let t = &c.tyre.tyre;
    let (load, radius) = (c.load(), t.rolling_radius);
    let over_load = OverLoad::of(c);
    let k_alpha = over_load.side_force[0] * t.stiffness.k_alpha(0.0, t.side_force_ratio);
    let mut file = File::default();
    file::units(&mut file);
    file.section("MODEL");
    file.number("FITTYP", 62.0, "set: Magic Formula 6.2");
    let mode = 10.0 + file::use_mode(c, false);
    file.number("USE_MODE", mode, "set: pure slip with relaxation; combined slip is not fitted");
    file.text("TYRESIDE", "SYMMETRIC", "set: the fits go both ways");
    file.number("LONGVL", file::LONGVL, "placeholder: reference speed, m/s");
    file.number("VXLOW", 1.0, "placeholder");
    file::body(&mut file, fitted, c, setting);

    file.section("STRUCTURAL");
    match fitted.value(tyre, C::RelaxationLength) {
        Ok((fitted, row)) if fitted > 0.0 => {
            let length = t.relaxation_length;
            let note = format!("from relaxation_length = {} m ({})", short(length), origin(row));
            let note = c.noted(&note, "relaxation_length");
            let usual = if c.lateral { "" } else { "placeholder: of a usual stiffness; " };
            let note = format!("{usual}{note}");
            file.number("LATERAL_STIFFNESS", k_alpha * load / length, &note);
        }
        _ => {
            let note = "from a relaxation length equal to the rolling radius: placeholder";
            file.number("LATERAL_STIFFNESS", k_alpha * load / radius, note);
        }
    }
    let [per_load, gain] = over_load.slip_stiffness_of(t.friction.stiffness());
    let length = c.tyre.longitudinal_relaxation.max(1e-3);
    file.number("LONGITUDINAL_STIFFNESS", per_load * load / length, &file::over_lag(c));
    let pky2 = PKY2.min(proportional(over_load.side_force_gain()));
    let exponent = over_load.friction_exponent;
    let along = OverLoad::carcass(c, |at: f64| {
        let dfz = at / load - 1.0;
        at * (per_load + gain * dfz) * (exponent * dfz).exp()
    });
    let across = OverLoad::carcass(c, |at| (2.0 * (at / load / pky2).atan()).sin());
    file::carcass(&mut file, [along, across]);

    file::ranges(&mut file, c, c.with_bike);
    if c.longitudinal {
        longitudinal(&mut file, fitted, c, &over_load);
    }
    file.section("OVERTURNING_COEFFICIENTS");
    file.coefficient("QSX2", fitted.value(tyre, C::OverturningStiffness), 1.0 / radius);
    if c.lateral {
        lateral(&mut file, fitted, c, k_alpha, &over_load);
    }
    file.section("ROLLING_COEFFICIENTS");
    file::rolling(&mut file, fitted, c, setting);

    file.section("ALIGNING_COEFFICIENTS");
    file.number("QBZ1", 0.0, "placeholder: the trail does not shrink with slip");
    file.number("QCZ1", 1.1, "placeholder: no effect with QBZ1 = 0");
    match fitted.value(tyre, C::PneumaticTrail0) {
        Ok((trail, row)) if c.error.pneumatic_trail != 0.0 => {
            let trail = trail * c.error.relative_trail(1.0);
            let note = format!("from a trail of {} m ({})", short(trail), origin(row));
            file.number("QDZ1", trail / radius, &c.noted(&note, "pneumatic_trail"));
        }
        found => file.coefficient("QDZ1", found, 1.0 / radius),
    }
    match fitted.value(tyre, C::TwistingStiffness) {
        Ok((fitted, row)) if fitted != t.twisting_stiffness => {
            let note = format!("from twisting_stiffness = {} ({})", short(fitted), origin(row));
            let note = c.noted(&note, "twisting_stiffness");
            file.number("QDZ8", -t.twisting_stiffness / radius / t.reference_friction, &note);
        }
        found => file.coefficient("QDZ8", found, -1.0 / radius / t.reference_friction),
    }
    file.0
}

fn longitudinal(file: &mut File, fitted: &Fitted, c: &Characterised, over_load: &OverLoad) {
    let mf = &c.tyre.tyre.friction;
    let row = |coefficient: C| {
        fitted.value(c.axle, coefficient).map_or(String::new(), |(_, r)| origin(r))
    };
    file.section("LONGITUDINAL_COEFFICIENTS");
    // the form has the odd part as a share of the even one
    let e1 = if mf.e1.abs() < 1e-6 { 1e-6 } else { mf.e1 };
    file.number("PCX1", mf.c, &row(C::MfC));
    let road = c.tyre.tyre.reference_friction;
    let [d, slope] = over_load.friction.map(|share| mf.d * share / road);
    file.number("PDX1", d, &c.friction_note(&row(C::MfD)));
    file.number("PEX1", e1, &row(C::MfE1));
    let [stiffness, gain] = over_load.slip_stiffness_of(mf.stiffness());
    file.number("PKX1", stiffness, &format!("mf_b mf_c mf_d; mf_b {}", row(C::MfB)));
    file.number("PKX2", gain, &format!("{GAIN} {}", row(C::SlipStiffnessLoad)));
    file.number("PEX4", -mf.e2 / e1, &format!("-mf_e2/mf_e1; mf_e2 {}", row(C::MfE2)));
    file::friction_over_load(file, c, slope, over_load.friction_exponent);
    for key in ["PEX2", "PEX3", "PHX1", "PHX2", "PVX1", "PVX2"] {
        file.number(key, 0.0, NO_LOAD);
    }
}

fn lateral(
    file: &mut File,
    fitted: &Fitted,
    c: &Characterised,
    k_alpha: f64,
    over_load: &OverLoad,
) {
    let row = |coefficient: C| {
        fitted.value(c.axle, coefficient).map_or(String::new(), |(_, r)| origin(r))
    };
    let t = &c.tyre.tyre;
    let d = t.friction.d / t.reference_friction;
    file.section("LATERAL_COEFFICIENTS");
    file.number("PCY1", 1.3, "placeholder: the ride does not reach the lateral peak");
    let gain = over_load.side_force_gain();
    let (peak, pky2) = (d * over_load.side_force[0], PKY2.min(proportional(gain)));
    let over = |else_: &str| match gain == 0.0 {
        true => else_.to_owned(),
        false => c.noted("", "stiffness_load"),
    };
    let from = match c.longitudinal {
        true => "placeholder: the longitudinal peak mf_d",
        false => "placeholder: the ride gave no peak of friction",
    };
    file.number("PDY1", peak, from);
    file.number("PDY2", peak * gain, &over(NO_LOAD));
    file.number("PEY1", 0.0, "placeholder");
    let share = (2.0 * (1.0 / pky2).atan()).sin();
    file.number(
        "PKY1",
        -k_alpha / share,
        &format!(
            "from cornering_stiffness_0 = {} 1/rad, {}; stiffness over load at FNOMIN",
            short(k_alpha),
            row(C::CorneringStiffness0)
        ),
    );
    file.number("PKY2", pky2, &over("set: stiffness proportional to load"));
    file.number("PKY3", 0.0, "set: at small camber; the change with camber is in the toml export");
    file.number("PKY4", 2.0, "set");
    // the fitted one, changed as much as the product of the two that it is of
    let value = |coefficient: C| fitted.value(c.axle, coefficient).map(|(value, _)| value);
    let product = k_alpha * t.side_force_ratio;
    let k_gamma = match (value(C::CamberStiffness0), value(C::CorneringStiffness0)) {
        (Ok(fitted), Ok(k)) => match value(C::SideForceRatio) {
            Ok(ratio) if k * ratio > 0.0 => fitted * product / (k * ratio),
            _ => product,
        },
        _ => product,
    };
    let note = c.noted(&row(C::CamberStiffness0), "side_force_ratio_front");
    file.number("PKY6", -k_gamma, &c.noted(&note, "side_force_ratio_rear"));
    file.number("PKY7", -k_gamma * gain, &over(NO_LOAD));
    for key in ["PDY3", "PEY2", "PEY3", "PEY4", "PKY5", "PHY1", "PHY2"] {
        file.number(key, 0.0, NO_LOAD);
    }
    for key in ["PVY1", "PVY2", "PVY3", "PVY4"] {
        file.number(key, 0.0, "set: no offset");
    }
}
