//! Slip angles that the diagnosis works out from a log, against those of the wheels.

use roadbench::internals::diagnose::road::attitude::{Attitude, Posture};
use roadbench::internals::diagnose::road::fitted;
use roadbench::internals::diagnose::road::parameters::Parameters;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::rider::Disturbance;

use crate::suspicions::common::machine;

/// In a bend the springs give and the frame comes down between its wheels; a front wheel that is being steered goes
/// aside behind its axis. On a perfect log of a sprung motorcycle slip angles with both are much nearer to the truth.
#[test]
fn slip_angles_know_springs_and_steering() {
    let (mut scenario, machine) = machine("paper", 1, &[]);
    for plan in &mut scenario.plans {
        (plan.coasts, plan.brakings, plan.laps) = (4, 2, 3);
    }
    scenario.sensors.clear();
    scenario.disturbance = Disturbance::default();
    let (ridden, bike) = multibody::session(&scenario, &machine, 1).expect("ridden");
    let fitted = fitted(&ridden.session, &bike, &Pipeline::onroad()).expect("fitted");
    let samples = &fitted.samples;
    let values = &fitted.base.values;
    let bends = || {
        let is_bend = |kind: &ManoeuvreKind| *kind == ManoeuvreKind::Cornering;
        samples.manoeuvres.iter().filter(move |(k, _)| is_bend(k)).flat_map(|(_, r)| r.clone())
    };
    let error = |values: &Parameters, k: usize| {
        let posture = Posture::of(values);
        let errors: Vec<f64> = bends()
            .map(|i| {
                let at = (samples.time[i] * ridden.session.rate).round() as usize;
                let truth = ridden.samples[at].wheels[k].kinematic[1];
                Attitude::of(samples, &posture, i, true).alpha[k] - truth
            })
            .collect();
        let n = errors.len() as f64;
        let mean = errors.iter().sum::<f64>() / n;
        (errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n).sqrt()
    };
    let mut rigid = values.clone();
    (rigid.vehicle.sag, rigid.vehicle.normal_trail) = ([0.0; 2], 0.0);
    for k in 0..2 {
        let [with, without] = [error(values, k), error(&rigid, k)];
        println!("wheel {k}: {with:.2e} rad, without {without:.2e}");
        assert!(with < 0.7 * without, "wheel {k}: {with} {without}");
    }
}
