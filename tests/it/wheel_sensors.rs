//! Sensors of the wheels: slip angles, measuring wheels, brake torques. A small version of the study
//! `examples/wheel_sensors`, and the messages for the user.

#[path = "../../examples/wheel_sensors.rs"]
#[allow(dead_code)]
mod study;

use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::coefficient::{Coefficient, Id};
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::ride::MultibodyRide;
use roadbench::internals::simulate::sensors::{Sensor, Sensors};
use roadbench::internals::simulate::wheel_sensors::of_multibody;
use roadbench::internals::store::objects::Location;
use study::{known, median, ridden, sets};

const PLAN: &str = "naturalistic";

#[test]
fn a_log_without_lateral_velocity_has_slip_angles_and_crowns_by_sensors() {
    let missing = [Channel::VelocityY, Channel::SteerAngle];
    let all = sets();
    let asked: Vec<_> = all
        .into_iter()
        .filter(|(name, _)| ["none", "slip angles", "measuring wheels"].contains(name))
        .collect();
    let tallies = ridden(1, 7, PLAN, &asked, &missing);
    let tally = |axle: Axle, c: Coefficient, place: usize| {
        tallies.get(&(Id::from((axle, c)), place)).cloned().unwrap_or_default()
    };
    let mut inside = 0;
    for axle in Axle::BOTH {
        let name = axle.name();
        for (c, by, most) in
            [(Coefficient::SlipCamberC1, 1, 0.25), (Coefficient::OverturningStiffness, 2, 0.08)]
        {
            let [without, with] = [tally(axle, c, 0), tally(axle, c, by)];
            assert!(without.widths.is_empty(), "{name} {c}: known without: {:?}", without.widths);
            assert_eq!(with.widths.len(), 1, "{name} {c}");
            let width = median(&with.widths);
            assert!(width < most, "{name} {c}: {width}");
            inside += with.inside;
        }
    }
    // 95 % intervals; the study has many rides
    assert!(inside >= 3, "{inside} of 4");
}

/// What `run` makes of a ride's log with some sensors.
fn outcome(
    ride: &MultibodyRide,
    bike: &roadbench::internals::contract::bike::Bike,
    channels: &[Channel],
    change: impl Fn(Channel, &mut Vec<f64>),
) -> pipeline::Outcome {
    let named: Sensors =
        channels.iter().map(|c| (c.name().to_owned(), Sensor::default())).collect();
    let mut log = ride.session.clone();
    let seen = ride.samples.iter().map(|s| (s.wheels, s.action));
    of_multibody(&mut log, seen, &named);
    for &channel in channels {
        if let Some(x) = log.get_mut(channel) {
            let mut changed = x.to_vec();
            change(channel, &mut changed);
            log.set(channel, changed);
        }
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.parquet");
    roadbench::internals::ingest::write_session(&path, &log, false).expect("written");
    let input = Input {
        log: Location::from(path.as_path()),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    pipeline::run(&input, bike, &Pipeline::onroad()).map_err(|e| e.message).expect("read")
}

#[test]
fn sensors_are_shown_beside_the_estimate_and_wrong_ones_are_said() {
    let ridden = known(7, 0, PLAN).expect("ridden");
    let (ride, bike) = (&ridden.ride, &ridden.bike);
    let channels = [
        Channel::WheelForceYFront,
        Channel::WheelForceZFront,
        Channel::WheelForceXRear,
        Channel::SlipAngleRear,
    ];
    let right = outcome(ride, bike, &channels, |_, _| {});
    let said = |of: &pipeline::Outcome| -> Vec<String> {
        let own = of.warnings.iter().filter(|w| w.code == "sensor_disagrees");
        own.map(|w| w.message.clone()).collect()
    };
    assert!(said(&right).is_empty(), "{:?}", said(&right));
    for name in [
        "measured_force_y_front",
        "measured_load_front",
        "measured_force_x_rear",
        "measured_slip_angle_rear",
    ] {
        let points: Vec<_> =
            right.plots.iter().filter(|p| p.plot == name && p.series == "data").collect();
        assert!(points.len() > 20, "{name}: {}", points.len());
        // estimated over measured, through the middle of the cloud
        let [both, square] = points.iter().fold([0.0, 0.0], |[a, b], p| {
            let (x, y) = (p.x, p.y.unwrap_or(0.0));
            [a + x * y, b + x * x]
        });
        let most = if name.contains("slip") { 0.35 } else { 0.05 };
        assert!((both / square - 1.0).abs() < most, "{name}: {}", both / square);
    }
    let wrong = outcome(ride, bike, &channels, |channel, x| {
        let factor = match channel {
            Channel::WheelForceYFront => -1.0,
            Channel::WheelForceZFront => 1.3,
            _ => 1.0,
        };
        x.iter_mut().for_each(|x| *x *= factor);
    });
    let said = said(&wrong);
    assert_eq!(said.len(), 2, "{said:?}");
    assert!(said.iter().any(|w| w.contains("wheel_force_y_front: its sign")), "{said:?}");
    assert!(said.iter().any(|w| w.contains("wheel_force_z_front: shows 13")), "{said:?}");
    // a wrong sensor moves no sum of forces
    let friction = |of: &pipeline::Outcome| {
        let own = |c: &&roadbench::internals::store::tables::rows::Coefficient| {
            c.tyre == "front" && c.coefficient == "lateral_friction_ct"
        };
        of.coefficients.iter().find(own).and_then(|c| c.value).expect("a value")
    };
    assert_eq!(friction(&right), friction(&wrong));
}

#[test]
fn brakings_with_both_brakes_are_used_where_torques_tell_the_shares() {
    let ridden = known(7, 0, study::TRACK).expect("ridden");
    let used = |channels: &[Channel]| {
        let of = outcome(&ridden.ride, &ridden.bike, channels, |_, _| {});
        let combined: Vec<_> =
            of.manoeuvres.iter().filter(|m| m.kind == "combined_braking").collect();
        [combined.iter().filter(|m| m.used).count(), combined.len()]
    };
    let [without, all] = used(&[]);
    assert!(without == 0 && all > 0, "{without} of {all}");
    let with = used(&[Channel::BrakeTorqueFront, Channel::BrakeTorqueRear]);
    assert_eq!(with, [all, all]);
}
