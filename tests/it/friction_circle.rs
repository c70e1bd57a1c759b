//! Forces at any friction, in the model, the C header and the simulation unit alike: bounded by the friction circle,
//! and no less on a road that grips more.

use std::io::Write;
use std::path::Path;
use std::process::{Command as Process, Stdio};

use roadbench::internals::contract::bike::Axle;
use roadbench::internals::report::export::tyre::Characterised;
use roadbench::internals::simulate::effects::ModelError;
use roadbench::internals::simulate::effects::extended_tyre::ExtendedTyre;
use roadbench::internals::tyre::custom::Custom;
use roadbench::internals::tyre::paper::{Input, Tyre};
use roadbench::internals::tyre::{MagicFormula, Stiffness};

use crate::export::there;
use crate::lane_change_forms::{Study, answer, record};

const FRICTIONS: [f64; 9] = [0.2, 0.35, 0.45, 0.5, 0.6, 0.75, 0.9, 1.1, 1.4];

/// Inputs over the whole range, all frictions of one after the other.
fn inputs(loads: &[f64]) -> Vec<Input> {
    let mut out = Vec::new();
    for &load in loads {
        for slip_ratio in [-1.2, -1.0, -0.5, -0.2, -0.1, -0.03, 0.0, 0.01, 0.05, 0.15, 0.6, 2.0] {
            for angle in [-30.0, -12.0, -5.0, -2.0, -0.5, 0.0, 0.2, 1.0, 3.0, 8.0, 20.0_f64] {
                for camber in (-6..=6).map(|i| 10.0 * f64::from(i)) {
                    for friction in FRICTIONS {
                        out.push(Input {
                            slip_ratio,
                            slip_angle: angle.to_radians(),
                            camber: camber.to_radians(),
                            load,
                            friction,
                        });
                    }
                }
            }
        }
    }
    out
}

/// Largest |F| over the friction circle, and the largest |F| over `mu Fz`; the forces are those of the inputs.
fn largest(
    tyre: &Tyre,
    inputs: &[Input],
    forces: &[[f64; 2]],
    share: &dyn Fn(f64) -> f64,
) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for (input, [x, y]) in inputs.iter().zip(forces) {
        assert!(x.is_finite() && y.is_finite(), "{input:?}: {x} {y}");
        let circle = tyre.friction.d.max(tyre.lateral_peak) / tyre.reference_friction;
        let mu_load = input.friction * input.load;
        let force = x.hypot(*y) / mu_load;
        most = [most[0].max(force / (circle * share(input.load))), most[1].max(force)];
    }
    assert!(most[0] <= 1.0 + 1e-9, "{most:?}");
    // the range reaches the circle: the test is of something
    assert!(most[0] > 0.999, "{most:?}");
    most
}

/// Without slip ratio no side force is less on a road that grips more.
fn is_monotone(inputs: &[Input], forces: &[[f64; 2]]) {
    for (inputs, forces) in inputs.chunks(FRICTIONS.len()).zip(forces.chunks(FRICTIONS.len())) {
        if inputs[0].slip_ratio != 0.0 {
            continue;
        }
        for (pair, input) in forces.windows(2).zip(inputs) {
            let rise = pair[1][1].abs() - pair[0][1].abs();
            assert!(rise >= -1e-9 * input.load, "{input:?}: {pair:?}");
            // and it pulls to the same side
            assert!(pair[1][1] * pair[0][1] >= 0.0, "{input:?}: {pair:?}");
        }
    }
}

/// The tyre of the audit: at a friction of 0.5 and 45 degrees it had a side force of 1e15 loads.
fn audited() -> Tyre {
    Tyre {
        friction: MagicFormula { b: 12.0, c: 1.6, d: 1.1, e1: 0.1, e2: 0.1 },
        stiffness: Stiffness { ct: -0.885, c1: -0.0107, c3: 0.06 },
        side_force_ratio: 0.078,
        twisting_stiffness: 0.039,
        overturning_stiffness: 0.07,
        rolling_radius: 0.31,
        rolling_resistance: 0.015,
        relaxation_length: 0.31,
        vertical_stiffness: 141e3,
        camber_force_decay: 1.0,
        camber_moment_decay: 1.0,
        reference_friction: 1.0,
        peak_slip: 0.12,
        lateral_peak: 0.0,
    }
}

#[test]
fn the_models_forces_stay_within_the_circle_at_every_friction() {
    let loads = [60.0, 300.0, 1300.0, 2600.0, 6000.0];
    let inputs = inputs(&loads);
    for c3 in [-0.05, -0.02, 0.0, 0.06, 0.3] {
        for (reference_friction, lateral_peak) in [(1.0, 0.0), (0.75, 1.3), (1.2, 0.0)] {
            let stiffness = Stiffness { c3, ..audited().stiffness };
            let tyre = Tyre { stiffness, reference_friction, lateral_peak, ..audited() };
            let custom = Custom { slip_stiffness_load: 0.2, ..Custom::new(tyre, 1300.0) };
            for (friction_load, stiffness_load) in [(0.0, 0.0), (0.15, -0.4), (-0.1, 0.3)] {
                let error = ModelError { friction_load, stiffness_load, ..ModelError::default() };
                let whole = ExtendedTyre::boxed(custom, &error, 1.0);
                let forces: Vec<[f64; 2]> = inputs
                    .iter()
                    .map(|i| whole.forces(i))
                    .map(|o| {
                        assert!(o.moment_x.is_finite() && o.moment_z.is_finite(), "{o:?}");
                        [o.force_x, o.force_y]
                    })
                    .collect();
                let share = |load: f64| (1.0 - friction_load * (load / 1300.0 - 1.0)).max(0.2);
                let most = largest(&tyre, &inputs, &forces, &share);
                is_monotone(&inputs, &forces);
                if c3 == 0.06 && friction_load == 0.0 {
                    println!("{reference_friction}: {} inputs, |F| <= {most:.4?}", inputs.len());
                }
            }
        }
    }
}

/// What a compiled tyre says of all inputs.
fn said(program: &Path, inputs: &[Input]) -> Vec<[f64; 5]> {
    let mut child =
        Process::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("begun");
    let mut to = child.stdin.take().expect("pipe");
    let records: Vec<u8> = inputs.iter().flat_map(record).collect();
    let writer = std::thread::spawn(move || to.write_all(&records).expect("written"));
    let output = child.wait_with_output().expect("ended");
    writer.join().expect("written");
    output.stdout.chunks(40).map(answer).collect()
}

#[test]
fn header_and_unit_are_the_model_at_every_friction_and_know_what_was_ridden() {
    if !there("python3") || !there(&std::env::var("CC").unwrap_or("cc".into())) {
        return;
    }
    let study = Study::new();
    for axle in Axle::BOTH {
        let c: Characterised = study.tyre(axle);
        let t = c.tyre.tyre;
        let mut inputs = inputs(&[60.0, 700.0, c.load(), 2600.0, 6000.0]);
        // and what was ridden
        for slip_ratio in [-0.05, -0.02, 0.0] {
            for camber in [-0.4, -0.2, 0.0, 0.2, 0.4] {
                for friction in [0.75, 1.0] {
                    inputs.push(Input {
                        slip_ratio,
                        slip_angle: 0.0,
                        camber,
                        load: c.load(),
                        friction,
                    });
                }
            }
        }
        let grid = inputs.len() - 30;
        for unit in [false, true] {
            let found = said(&study.program(axle, unit), &inputs);
            assert_eq!(found.len(), inputs.len());
            let forces: Vec<[f64; 2]> = found.iter().map(|f| [f[0], f[1]]).collect();
            let most = largest(&t, &inputs[..grid], &forces[..grid], &|_| 1.0);
            is_monotone(&inputs[..grid], &forces[..grid]);
            // nor is the whole force, at any slip
            for (pair, input) in forces[..grid].windows(2).zip(&inputs) {
                let rise = pair[1][0].hypot(pair[1][1]) - pair[0][0].hypot(pair[0][1]);
                let is_last = input.friction == FRICTIONS[FRICTIONS.len() - 1];
                assert!(is_last || rise >= -1e-9 * input.load, "{input:?}: {pair:?}");
            }
            let mut ridden = [0; 2];
            for (input, f) in inputs.iter().zip(&found) {
                let o = c.forces(input);
                let wanted = [o.force_x, o.force_y, o.moment_x, o.moment_z];
                for (w, f) in wanted.iter().zip(f) {
                    assert!((w - f).abs() < 1e-11 * input.load, "{input:?}: {wanted:?} {f}");
                }
                assert_eq!(f[4] != 0.0, c.ridden(input), "{input:?}");
                ridden[usize::from(f[4] != 0.0)] += 1;
                let other_road = (input.friction - 0.75).abs() > 1e-3;
                let upright = input.camber.abs() < 0.15 || input.slip_angle != 0.0;
                let both = input.slip_ratio.abs() > 0.02 && !upright;
                assert!(f[4] == 0.0 || !other_road && !both, "{input:?}");
            }
            assert!(ridden[1] > 5, "{ridden:?}");
            println!(
                "{axle:?} unit {unit}: {} inputs, |F| <= {most:.4?}, ridden {ridden:?}",
                inputs.len()
            );
        }
    }
}

/// No row of combined slip is called ridden, and no row leaves the circle.
#[test]
fn tables_call_no_combined_slip_ridden_and_stay_within_the_circle() {
    let study = Study::new();
    for axle in Axle::BOTH {
        let c = study.tyre(axle);
        let circle = c.tyre.tyre.circle(0.75);
        study.export(axle, &["csv"], "tyre.csv");
        let text = std::fs::read_to_string(study.path("tyre.csv")).expect("written");
        let (mut ridden, mut combined) = (0, 0);
        for line in text.lines().filter(|l| !l.starts_with('#')).skip(1) {
            let words: Vec<&str> = line.split(',').collect();
            // intervals, which may be empty, come last
            let n: Vec<f64> = words[2..11].iter().map(|w| w.parse().expect("a number")).collect();
            assert!(n[4].hypot(n[5]) <= circle * n[3] + 1e-3, "{line}");
            // above a twentieth of both peaks, with room for the rounding of the text
            let t = &c.tyre.tyre;
            let side =
                t.stiffness.k_alpha(n[2], t.side_force_ratio) * (n[1] + t.side_force_ratio * n[2]);
            let is_combined =
                n[0].abs() > 0.051 * t.peak_slip && side.abs() > 0.051 * c.ridden_side();
            assert!(!is_combined || n[8] == 0.0, "{line}");
            combined += usize::from(is_combined);
            ridden += usize::from(n[8] == 1.0);
        }
        assert!(ridden > 100 && combined > 500, "{ridden} {combined}");
    }
}
