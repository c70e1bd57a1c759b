//! `roadbench diagnose` on rides that hide one thing, or nothing.

use roadbench::channel::Channel;
use roadbench::diagnose::base;
use roadbench::diagnose::effects;
use roadbench::diagnose::name::Verdict;
use roadbench::diagnose::ride::{Diagnosis, Settings, diagnose};
use roadbench::diagnose::samples::Samples;
use roadbench::diagnose::world::World;
use roadbench::estimate::{Formulation, zeros};
use roadbench::fit::chain::{self, Data};
use roadbench::pipeline::Pipeline;
use roadbench::session::Session;
use roadbench::simulate::scenario::{BUILTIN, Machine, Scenario};
use roadbench::{filter, segment};

/// A noisy ride on the paper's plan, shorter, whose sensors are on time and read zero where it is.
fn scenario() -> Scenario {
    let (_, text) = BUILTIN.iter().find(|(name, _)| *name == "paper").expect("built in");
    let text = text
        .lines()
        .filter(|l| !l.starts_with("latency") && !l.starts_with("bias"))
        .map(|l| match l.starts_with("plans") {
            true => r#"plans = [{ kind = "paper", coasts = 10, brakings = 6, laps = 8 }]"#,
            false => l,
        })
        .collect::<Vec<_>>()
        .join("\n");
    Scenario::parse(&text, "short").expect("scenario")
}

fn ride(number: usize, change: impl Fn(&mut Machine), damage: impl Fn(&mut Session)) -> Diagnosis {
    let scenario = scenario();
    let mut machine = scenario.machine(number);
    change(&mut machine);
    let mut session = roadbench::simulate::session(&scenario, &machine, number).session;
    damage(&mut session);
    diagnose(&session, &machine.bike, &Pipeline::onroad(), &settings(12)).expect("diagnosed")
}

fn settings(nulls: usize) -> Settings {
    Settings { nulls, ..Settings::default() }
}

fn told(d: &Diagnosis) -> Vec<(&str, f64, f64)> {
    d.naming
        .causes
        .iter()
        .filter(|c| matches!(c.verdict, Verdict::Named | Verdict::Ambiguous))
        .map(|c| (c.effect.name, c.value, c.std_error))
        .collect()
}

/// On perfect data the base has nothing left, and its numbers are the plant's.
#[test]
fn the_base_is_the_generating_model() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let session = roadbench::simulate::session(&scenario, &machine, 0).session;
    let pipeline = Pipeline::onroad();
    let mut filtered = session.clone();
    filter::run(&mut filtered, &pipeline.filter);
    let segments = segment::run(&filtered, &machine.bike, &pipeline.segment);
    let (zeros, _) = zeros::run(&filtered, &machine.bike);
    let data = Data::gather(&filtered, &segments, &machine.bike, zeros, &pipeline.estimate);
    let solution = chain::solve(&data, &machine.bike, Formulation::Corrected, &pipeline.fit);
    let samples = Samples::gather(&session, &segments);
    let fitted = base::fit(&samples, &World::new(&machine.bike, &solution)).world;
    let plant = &machine.plant;
    for (name, got, truth, most) in [
        ("drag", fitted.drag, plant.drag, 0.01),
        ("rolling", fitted.rolling_resistance, plant.tyres[0].rolling_resistance, 0.01),
        ("gain front", fitted.brake_gain[0], plant.brake_gain[0], 0.01),
        ("gain rear", fitted.brake_gain[1], plant.brake_gain[1], 0.01),
        ("radius front", fitted.radius[0], plant.tyres[0].rolling_radius, 0.0005),
        ("radius rear", fitted.radius[1], plant.tyres[1].rolling_radius, 0.0005),
        ("peak front", fitted.friction[0].d, plant.tyres[0].friction.d, 0.01),
        ("peak rear", fitted.friction[1].d, plant.tyres[1].friction.d, 0.01),
        ("k front", fitted.stiffness[0][0], 12.5, 0.015),
        ("k rear", fitted.stiffness[1][0], 13.2, 0.015),
    ] {
        assert!((got / truth - 1.0).abs() < most, "{name}: {got} for {truth}");
    }
}

#[test]
fn a_ride_with_nothing_wrong_names_nothing() {
    let d = ride(0, |_| {}, |_| {});
    println!("alarm {:.2}: {:?}", d.naming.alarm, told(&d));
    assert!(told(&d).is_empty(), "{:?}", told(&d));
    assert_eq!(d.causes.len(), effects::ALL.len());
    assert!(d.causes.iter().all(|c| c.verdict != "named"));
}

#[test]
fn a_late_velocity_is_named_with_its_size() {
    let latency = 0.03;
    let d = ride(
        1,
        |_| {},
        |session| {
            let by = (latency * session.rate).round() as usize;
            for channel in [Channel::VelocityX, Channel::VelocityY] {
                let x = session.get(channel).expect("there");
                let late = (0..x.len()).map(|i| x[i.saturating_sub(by)]).collect();
                session.set(channel, late);
            }
        },
    );
    let named = told(&d);
    println!("{named:?}");
    let (name, value, sd) = named[0];
    assert_eq!(name, "latency");
    assert!((value - latency).abs() < 2.5 * sd && sd < 0.01, "{value} +- {sd}");
    assert_eq!(named.len(), 1, "{named:?}");
    let first = &d.causes[0];
    assert!(first.gain_heldout.expect("gain") > 30.0 && first.false_alarm_rate == 0.0);
    // and the misfit that it made is seen, and gone with it
    let slip = d
        .discrepancies
        .iter()
        .filter(|r| r.channel.starts_with("slip") && r.structured)
        .max_by(|a, b| a.rmse_base.total_cmp(&b.rmse_base))
        .expect("structured");
    assert!(slip.rmse_extended.expect("extended") < 0.6 * slip.rmse_base, "{slip:?}");
}

#[test]
fn a_steering_zero_is_named_with_its_size() {
    let zero = 0.012;
    let d = ride(
        2,
        |_| {},
        |session| {
            let steer = session.get_mut(Channel::SteerAngle).expect("there");
            steer.iter_mut().for_each(|x| *x -= zero);
        },
    );
    let named = told(&d);
    println!("{named:?}");
    let (name, value, sd) = named[0];
    assert_eq!(name, "steer_zero");
    assert!((value - zero).abs() < 3.0 * sd && sd < 0.004, "{value} +- {sd}");
}

#[test]
fn what_a_diagnosis_needs_is_said() {
    let scenario = scenario();
    let machine = scenario.machine(0);
    let mut session = roadbench::simulate::session(&scenario, &machine, 0).session;
    session.remove(Channel::WheelSpeedRear);
    let why =
        diagnose(&session, &machine.bike, &Pipeline::onroad(), &settings(8)).expect_err("lacks");
    assert!(why.message.contains("wheel_speed_rear"), "{}", why.message);
}
