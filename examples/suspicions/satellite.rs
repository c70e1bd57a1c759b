//! "A standard GNSS, and about 30 km/h in the corners: both increase the relative error of the speed
//! vector, which is used to compute the slip angles" (Discussion).

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::road::attitude::{Attitude, Posture};
use roadbench::internals::diagnose::road::parameters::Parameters;
use roadbench::internals::diagnose::road::samples::Samples;
use roadbench::internals::pipeline::{self, Characterised, Pipeline};
use roadbench::internals::segment::manoeuvre::ManoeuvreKind;
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::simulate::multibody_ride as multibody;
use roadbench::internals::simulate::ride::MultibodyRide;
use roadbench::internals::tyre::formulation::Formulation;

use super::common::*;

/// Speeds that count as different, m/s.
const SPEEDS: [f64; 4] = [5.0, 9.0, 14.0, 30.0];

/// Rms errors of the rear slip angle in corners, by speed, rad.
pub fn errors(session: &Session, truth: &MultibodyRide, bike: &Bike) -> [f64; 3] {
    let pipeline = Pipeline::onroad();
    let Characterised { segments, solution, .. } =
        pipeline::characterise(session.clone(), bike, &pipeline, Formulation::Corrected);
    let world = Parameters::new(bike, &solution);
    let posture = Posture::of(&world);
    let samples = Samples::gather(session, &segments);
    let mut sums = [(0.0, 0.0); 3];
    for (kind, range) in &samples.manoeuvres {
        for i in range.clone().filter(|_| *kind == ManoeuvreKind::Cornering) {
            let k = SPEEDS.windows(2).position(|w| (w[0]..w[1]).contains(&samples.v[i]));
            let estimated = Attitude::of(&samples, &posture, i, true).alpha[1];
            let at = (samples.time[i] * session.rate).round() as usize;
            if let Some(k) = k
                && estimated.is_finite()
            {
                sums[k].0 += (estimated - truth.samples[at].wheels[1].kinematic[1]).powi(2);
                sums[k].1 += 1.0;
            }
        }
    }
    sums.map(|(sum, n): (f64, f64)| (sum / n).sqrt())
}

/// A ride whose velocity has an effect and so many times the usual errors: what is said of it, slip
/// angle errors and rear cornering stiffness before, and after the identified causes are removed.
pub fn study(plan: &'static str, number: usize, hidden: &[(&str, f64)], noise: f64) {
    let (mut scenario, machine) = machine(plan, number, hidden);
    for name in ["velocity_x", "velocity_y"] {
        if let Some(sensor) = scenario.sensors.get_mut(name) {
            sensor.white *= noise;
            sensor.slow *= noise;
        }
    }
    let tour = multibody::tour(&scenario, &machine, number).expect("stands");
    let ridden = ride(&tour, number);
    let d = diagnosed(&ridden, &tour.bike);
    let truth = machine.plant.tyres[1];
    let k = truth.stiffness.k_alpha(0.0, truth.side_force_ratio);
    let mut session = ridden.session.clone();
    let mut bike = tour.bike.clone();
    let say = |session: &Session, bike: &Bike| {
        let e = errors(session, &ridden, bike).map(|e| e.to_degrees());
        let own = MultibodyRide { session: session.clone(), ..ridden.clone() };
        let stiffness = value(&characterise(&own, bike), "rear", "cornering_stiffness_0");
        format!(
            "slip angle off by {} deg at 5-9 / 9-14 / over 14 m/s, rear cornering stiffness {:+.0} %",
            e.map(|e| if e.is_nan() { "-".into() } else { format!("{e:.2}") }).join(" / "),
            100.0 * (stiffness.unwrap_or(f64::NAN) / k - 1.0)
        )
    };
    let named: Vec<String> = hidden.iter().map(|(n, v)| format!("{n} {v}")).collect();
    println!("  {plan}, {noise} times the noise, {}", named.join(", "));
    println!("    {}", say(&session, &bike));
    println!("    named: {}", told(&d));
    for (name, _) in hidden {
        println!("    {}", about(&d, name));
        let cause = d.identification.causes.iter().find(|c| c.candidate.name == *name);
        let effect = Effect::named(name).expect("known");
        if let (Some(remove), Some(cause)) = (effect.remove, cause) {
            remove(&mut session, &mut bike, cause.value());
        }
    }
    if !hidden.is_empty() {
        println!("    taken out: {}", say(&session, &bike));
    }
}

/// Prints the study.
pub fn print() {
    println!("5. Satellite speed in slow corners?");
    for (plan, number) in [("paper", 0), ("naturalistic", 1)] {
        study(plan, number, &[], 1.0);
        study(plan, number, &[], 4.0);
        study(plan, number, &[("velocity_lever_arm", -0.6)], 1.0);
        study(plan, number, &[("latency", 0.05)], 1.0);
    }
}
