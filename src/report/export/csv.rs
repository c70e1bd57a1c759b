//! A fitted tyre as look-up tables: one row per point, in columns that any tool reads.

use std::fmt::Write as _;

use super::ends::{Ends, steps};
use super::file::one_line;
use super::fitted::Fitted;
use super::force_bands::ForceBands;
use super::origins;
use super::tyre::{Characterised, effects_of};
use crate::tyre::paper::Input;

/// Effects that change nothing in the tables.
const NO_COLUMN: [&str; 4] = ["rolling_speed", "radius_load", "radius_camber", "radius_speed"];
/// Values per direction: slip ratio, slip angle, camber, load.
const POINTS: [usize; 4] = [41, 21, 17, 5];
/// Values per direction of the combined table.
const COMBINED: [usize; 4] = [13, 9, 9, 1];

/// The tables of some tyres of one session.
pub(crate) fn write(fitted: &Fitted, tyres: &[Characterised]) -> String {
    let session = &fitted.session;
    let mut out = String::new();
    let mut comment = |line: &str| {
        let _ = writeln!(out, "# {}", one_line(line));
    };
    comment(&format!(
        "tyres of {}, session {}, fitted by roadbench {}",
        session.ident.bike_id, session.ident.session_id, session.provenance.version
    ));
    comment(&format!("input {}", session.provenance.input_hash));
    comment(&format!("pipeline {}", session.provenance.pipeline_hash));
    comment(
        "ISO 8855: x forward, y left, z up; slip_ratio positive driving; a positive slip angle or camber",
    );
    comment(
        "pulls to the right. Forces act where the wheel plane meets the road; rolling resistance is not in Fx.",
    );
    comment(
        "table: longitudinal (slip ratio, upright), lateral (slip angle and camber, no slip ratio), combined",
    );
    comment("(all three at the nominal load; the model's rule, not ridden).");
    comment(
        "ridden: 1 where slip ratio, slip angle, camber, load and side force are each within what was ridden, either side",
    );
    comment(
        "alike; not that they were ridden together. 0 beyond, and where both forces are above a twentieth of their peaks.",
    );
    comment(
        "Both forces together stay within the friction circle, of the larger of the peak of Fx and of",
    );
    comment("the side force over load that was ridden.");
    comment(
        "ci95: ends of the 95 % interval of Fx (longitudinal) and of Fy and Mx (lateral), as in the session's charts;",
    );
    comment(
        "empty where it is not known: beyond what was ridden, at the friction circle, Mz, both forces together, and",
    );
    comment("of a tyre with effects of a diagnosis.");
    for line in tyres.iter().flat_map(Characterised::adjustment) {
        comment(&line);
    }
    comment(
        "The forces are made of these numbers. Fx has no interval far from the loads under which the wheel was braked.",
    );
    for line in tyres.iter().flat_map(|c| origins::lines(fitted, c)) {
        comment(&line);
    }
    for line in effects_of(tyres, &NO_COLUMN) {
        comment(&line);
    }
    for tyre in tyres {
        let t = &tyre.tyre.tyre;
        comment(&format!(
            "{}: nominal load {:.1} N, rolling radius {:.5} m, rolling resistance {:.5}, relaxation length \
             {:.4} m, road friction {}",
            tyre.axle.name(),
            tyre.load(),
            t.rolling_radius,
            t.rolling_resistance,
            t.relaxation_length,
            t.reference_friction
        ));
    }
    out.push_str(
        "tyre,table,slip_ratio_1,slip_angle_rad,camber_rad,load_N,Fx_N,Fy_N,Mx_Nm,Mz_Nm,ridden,",
    );
    out.push_str(
        "Fx_ci95_low_N,Fx_ci95_high_N,Fy_ci95_low_N,Fy_ci95_high_N,Mx_ci95_low_Nm,Mx_ci95_high_Nm\n",
    );
    for tyre in tyres {
        let bands = ForceBands::new(fitted, tyre);
        let along = |input: &Input| [bands.force_x(input), None, None];
        let across = |input: &Input| [None, bands.force_y(input), bands.moment_x(input)];
        let unknown = |_: &Input| [None; 3];
        let ends = Ends::of(tyre);
        let angle = [-ends.slip_angle, ends.slip_angle];
        let camber = [-ends.camber, ends.camber];
        let [n_slip, n_angle, n_camber, n_load] = POINTS;
        let loads = steps(ends.load, n_load);
        if tyre.longitudinal {
            let slips = steps(ends.slip_ratio, n_slip);
            let over = [&slips[..], &[0.0], &[0.0], &loads];
            rows(&mut out, tyre, "longitudinal", over, along);
        }
        if tyre.lateral {
            let (angles, cambers) = (steps(angle, n_angle), steps(camber, n_camber));
            let over = [&[0.0], &angles[..], &cambers, &loads];
            rows(&mut out, tyre, "lateral", over, across);
        }
        if tyre.longitudinal && tyre.lateral {
            let [n_slip, n_angle, n_camber, _] = COMBINED;
            let (slips, angles) = (steps(ends.slip_ratio, n_slip), steps(angle, n_angle));
            let cambers = steps(camber, n_camber);
            let load = [tyre.load()];
            rows(&mut out, tyre, "combined", [&slips, &angles, &cambers, &load], unknown);
        }
    }
    out
}

/// Ends of Fx, N, of Fy, N, and of Mx, N m.
type Intervals = [Option<[f64; 2]>; 3];

fn rows(
    out: &mut String,
    tyre: &Characterised,
    table: &str,
    over: [&[f64]; 4],
    intervals: impl Fn(&Input) -> Intervals,
) {
    let [slips, angles, cambers, loads] = over;
    for &load in loads {
        for &camber in cambers {
            for &angle in angles {
                for &slip in slips {
                    let input = tyre.input(slip, angle, camber, load);
                    let (o, ridden) = (tyre.forces(&input), u8::from(tyre.ridden(&input)));
                    let _ = write!(
                        out,
                        "{},{table},{slip:.6},{angle:.6},{camber:.6},{load:.3},{:.4},{:.4},{:.5},{:.5},{ridden}",
                        tyre.axle.name(),
                        plain(o.force_x),
                        plain(o.force_y),
                        plain(o.moment_x),
                        plain(o.moment_z)
                    );
                    for (ends, decimals) in intervals(&input).into_iter().zip([4, 4, 5]) {
                        let _ = match ends {
                            None => write!(out, ",,"),
                            Some([low, high]) => {
                                let (low, high) = (plain(low), plain(high));
                                write!(out, ",{low:.decimals$},{high:.decimals$}")
                            }
                        };
                    }
                    out.push('\n');
                }
            }
        }
    }
}

/// No negative zero.
fn plain(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x }
}
