//! A fitted tyre as a TYDEX file: what a bench would measure of it.
//!
//! Sweeps over what was ridden at the least, the nominal and the largest load: slip ratio upright, slip angle
//! at several cambers, camber without slip, and all three at the nominal load.

use super::ends::{Ends, steps};
use super::file::{LONGVL, one_line};
use super::fitted::Fitted;
use super::origins;
use super::tyre::Characterised;
use crate::report::export::error::Error;
use crate::tyre::paper::Input;
use crate::tyre::tydex::Point;
use crate::tyre::tydex::write::{Head, write as text};

/// Points of a sweep of slip ratio, slip angle, camber.
const POINTS: [usize; 3] = [41, 21, 29];
/// Cambers at which the slip angle is swept, and slip ratios, slip angles and cambers of the combined points.
const CAMBERS: usize = 7;
const COMBINED: [usize; 3] = [13, 7, 5];
/// Effects that change nothing in the forces.
const NO_CHANNEL: [&str; 4] = ["rolling_speed", "radius_load", "radius_camber", "radius_speed"];

/// The file of one tyre.
///
/// # Errors
/// A sentence: a half of the tyre was not ridden.
pub(crate) fn write(fitted: &Fitted, c: &Characterised) -> Result<String, Error> {
    if let Some(half) = c.missing_half() {
        return Err(Error::NoValue(half));
    }
    let session = &fitted.session;
    let mut header = vec![
        ("MEASID", "Measurement ID", session.ident.session_id.clone()),
        ("SUPPLIER", "Data Supplier", format!("roadbench {}", crate::VERSION)),
    ];
    if let Some(start) = &session.ident.start_time {
        header.push(("DATE", "Date", start.chars().take(10).collect()));
    }
    let model = match c.axle.name() {
        "front" => &session.tyre_front,
        _ => &session.tyre_rear,
    };
    if let Some(model) = model {
        header.push(("IDENTITY", "Identity of the tyre", model.clone()));
    }
    let t = &c.tyre.tyre;
    let mut comments = vec![
        format!(
            "{} tyre of {}, session {}: evaluated from coefficients, not measured",
            c.axle.name(),
            session.ident.bike_id,
            session.ident.session_id
        ),
        format!("input {}", session.provenance.input_hash),
        format!("pipeline {}", session.provenance.pipeline_hash),
        "W axes, SI units; rolling resistance is not in FX. Sweeps over what was ridden of each:"
            .into(),
        "slip ratio upright, slip angle at cambers, camber, and all three at the nominal load"
            .into(),
        "(combined slip is the model's rule, not ridden)".into(),
        format!(
            "friction of the road {}, rolling radius {:.5} m, relaxation length {:.4} m",
            t.reference_friction, t.rolling_radius, t.relaxation_length
        ),
    ];
    comments.extend(c.adjustment());
    comments.extend(origins::lines(fitted, c).iter().map(|line| one_line(line)));
    comments.extend(c.effects(&NO_CHANNEL).iter().map(|line| one_line(line)));
    let head = Head {
        header,
        comments,
        constants: vec![
            ("FNOMIN", "Nominal load", "N", c.load()),
            ("TRAJVELH", "Trajectory velocity", "m/s", LONGVL),
        ],
    };
    let measured = |input: &Input| {
        let o = c.forces(input);
        Point {
            slip_ratio: input.slip_ratio,
            slip_angle: input.slip_angle,
            camber: input.camber,
            load: input.load,
            force_x: Some(o.force_x),
            force_y: Some(o.force_y),
            moment_x: Some(o.moment_x),
            moment_z: Some(o.moment_z),
        }
    };
    let points: Vec<Point> = sweeps(c).iter().map(measured).collect();
    Ok(text(&head, &points))
}

/// The inputs of all sweeps, none of a side force that was not ridden.
fn sweeps(c: &Characterised) -> Vec<Input> {
    let ends = Ends::of(c);
    let both = |most: f64, n: usize| steps([-most, most], n);
    let [n_slip, n_angle, n_camber] = POINTS;
    let most = c.ridden_side() * (1.0 + 1e-9);
    let mut inputs = Vec::new();
    for load in [ends.load[0], c.load(), ends.load[1]] {
        for s in steps(ends.slip_ratio, n_slip) {
            inputs.push(c.input(s, 0.0, 0.0, load));
        }
        for g in both(ends.camber, CAMBERS) {
            for a in both(ends.slip_angle, n_angle) {
                inputs.push(c.input(0.0, a, g, load));
            }
        }
        for g in both(ends.camber, n_camber) {
            inputs.push(c.input(0.0, 0.0, g, load));
        }
    }
    let [n_slip, n_angle, n_camber] = COMBINED;
    for s in steps(ends.slip_ratio, n_slip) {
        for a in both(ends.slip_angle, n_angle) {
            for g in both(ends.camber, n_camber) {
                inputs.push(c.input(s, a, g, c.load()));
            }
        }
    }
    inputs.retain(|i| {
        let pure = c.free_forces(&Input { slip_ratio: 0.0, ..*i });
        pure.force_y.abs() <= most * i.load
    });
    inputs
}
