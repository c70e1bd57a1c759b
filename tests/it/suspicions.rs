//! The paper's suspicions on short multibody rides: what `examples/suspicions` shows at length.

// the example's code, of which not all is needed here
#[allow(dead_code)]
#[path = "../../examples/suspicions/common.rs"]
pub mod common;
#[allow(dead_code)]
#[path = "../../examples/suspicions/load.rs"]
mod load;
#[allow(dead_code)]
#[path = "../../examples/suspicions/twist.rs"]
mod twist;

use common::machine;
use roadbench::internals::contract::verdict::Verdict;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::road::diagnose;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::rider::Disturbance;
use roadbench::internals::simulate::scenario::Scenario;

/// Few manoeuvres, seen by a perfect logger.
fn short(scenario: &mut Scenario) {
    for plan in &mut scenario.plans {
        (plan.coasts, plan.brakings, plan.laps) = (4, 2, 3);
    }
    scenario.sensors.clear();
    scenario.disturbance = Disturbance::default();
}

/// Slip angles under a heavier load: with a load-sensitive tyre they are wrong, the sensitivity is found
/// from rides at two loads, and with it the lane change, which no fit has seen, comes right. Without
/// the sensitivity nothing is found and nothing was wrong.
#[test]
fn load_sensitivity_explains_the_slip_angles_of_a_loaded_lane_change() {
    let found = load::study(-0.3, 1, short);
    for k in 0..2 {
        assert!((found.sensitivity[k].0 + 0.3).abs() < 0.06, "{found:?}");
        let [before, after] = found.error[k];
        assert!(before > 0.4 && after < 0.3 * before, "{found:?}");
    }
    let control = load::study(0.0, 1, short);
    for k in 0..2 {
        assert!(control.sensitivity[k].0.abs() < 0.06, "{control:?}");
        // so few corners leave an error of their own
        assert!(control.error[k][0] < 0.5 * found.error[k][0], "{control:?}");
    }
}

/// A twisting stiffness assumed 0.008 m/rad too large makes the yaw moments of the lane change wrong by
/// a fifth or more; with the true one they are right.
#[test]
fn the_twisting_stiffness_explains_the_yaw_moment() {
    let [before, after] = twist::study(-0.008, 0, short);
    for k in 0..2 {
        assert!(before[k] > 0.15 && after[k] < 0.06, "{before:?} {after:?}");
    }
}

/// A velocity sensor half a metre off, on a motorcycle with suspension and toroidal tyres: it is named
/// with its size, and neither toroid nor dive nor anything else is taken for more: they are in the base.
#[test]
fn a_sensor_off_its_place_is_named_on_a_motorcycle_that_is_not_the_model() {
    let hidden = [("velocity_lever_arm", -0.6)];
    let (mut scenario, machine) = machine("naturalistic", 1, &hidden);
    for plan in &mut scenario.plans {
        (plan.coasts, plan.brakings, plan.laps) = (6, 4, 6);
    }
    let (ridden, bike) = multibody::session(&scenario, &machine, 1).expect("ridden");
    assert_eq!(ridden.fall, None);
    let settings = Settings { nulls: 12, ..Settings::default() };
    let d = diagnose(&ridden.session, &bike, &Pipeline::onroad(), &settings).expect("diagnosed");
    let named: Vec<(&str, f64)> = d
        .identification
        .causes
        .iter()
        .filter(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
        .map(|c| (c.candidate.name, c.value()))
        .collect();
    let [(name, value)] = named[..] else { panic!("{named:?}") };
    assert!(name == "velocity_lever_arm" && (value + 0.6).abs() < 0.08, "{named:?}");
}
