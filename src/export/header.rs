//! A fitted tyre as a C99 header that evaluates it (`tyre.h` with the numbers filled in).

use std::fmt::Write as _;

use super::ends::Ends;
use super::file::one_line;
use super::fitted::Fitted;
use super::tyre::{Characterised, effects_of};

const TEMPLATE: &str = include_str!("tyre.h");

/// The header of some tyres of one session.
///
/// # Errors
/// A sentence that names the tyre of which a half was not ridden: the header evaluates whole tyres.
pub fn write(fitted: &Fitted, tyres: &[Characterised]) -> Result<String, String> {
    let session = &fitted.session;
    let mut numbers = String::new();
    for tyre in tyres {
        if let Some(half) = tyre.missing_half() {
            return Err(half);
        }
        numbers.push_str(&number(tyre));
    }
    let mut who = String::new();
    let models = [&session.tyre_front, &session.tyre_rear];
    for line in [
        format!(
            "Tyres of {}, session {}, fitted by roadbench {}.",
            session.ident.bike_id, session.ident.session_id, session.provenance.version
        ),
        format!("Input {}", session.provenance.input_hash),
        format!("Pipeline {}", session.provenance.pipeline_hash),
    ]
    .into_iter()
    .chain(models.into_iter().flatten().map(|m| format!("Tyre model {m}")))
    .chain(effects_of(tyres, &[]))
    {
        let _ = writeln!(who, " * {}", comment(&line));
    }
    let first = tyres.first().map_or("front", |t| t.axle.name());
    Ok(TEMPLATE
        .replace("@@WHO@@", who.trim_end())
        .replace("@@FIRST@@", first)
        .replace("@@TYRES@@\n", &numbers))
}

fn number(c: &Characterised) -> String {
    let (t, ends) = (&c.tyre.tyre, Ends::of(c));
    let mut out = format!("\nstatic const roadbench_tyre roadbench_{} = {{\n", c.axle.name());
    for (name, value) in [
        ("mf_b", t.friction.b),
        ("mf_c", t.friction.c),
        ("mf_d", t.friction.d),
        ("mf_e1", t.friction.e1),
        ("mf_e2", t.friction.e2),
        ("ct", t.stiffness.ct),
        ("c1", t.stiffness.c1),
        ("c3", t.stiffness.c3),
        ("side_force_ratio", t.side_force_ratio),
        ("twisting_stiffness", t.twisting_stiffness),
        ("overturning_stiffness", t.overturning_stiffness),
        ("rolling_radius", t.rolling_radius),
        ("rolling_resistance", t.rolling_resistance),
        ("relaxation_length", t.relaxation_length),
        ("nominal_load", c.tyre.nominal_load),
        ("slip_stiffness_load", c.tyre.slip_stiffness_load),
        ("vertical_stiffness", t.vertical_stiffness),
        ("camber_force_decay", t.camber_force_decay),
        ("camber_moment_decay", t.camber_moment_decay),
        ("reference_friction", t.reference_friction),
        ("peak_slip", t.peak_slip),
        ("deflection_share", c.tyre.deflection_share),
        ("width_over_front", c.crown),
        ("friction_load", c.error.friction_load),
        ("stiffness_load", c.error.stiffness_load),
        ("pneumatic_trail", c.error.pneumatic_trail),
        ("rolling_speed", c.error.rolling_speed),
        ("radius_load", c.error.radius_load),
        ("radius_camber", c.error.radius_camber),
        ("radius_speed", c.error.radius_speed),
        ("slip_ratio_min", ends.slip_ratio[0]),
        ("slip_ratio_max", ends.slip_ratio[1]),
        ("slip_angle_max", ends.slip_angle),
        ("camber_max", ends.camber),
        ("load_min", ends.load[0]),
        ("load_max", ends.load[1]),
        ("side_friction_max", c.ridden_side()),
    ] {
        // the shortest digits that read back to the same number
        let _ = writeln!(out, "    .{name} = {value:?},");
    }
    out + "};\n"
}

/// A log's text can neither end the comment nor begin a trigraph or a continued line.
fn comment(text: &str) -> String {
    one_line(text).replace("*/", "* /").replace("/*", "/ *").replace(['\\', '?'], "_")
}
