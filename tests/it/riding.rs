//! Rides on the nonlinear motorcycle: the paper's study, replays, falls, refusals.

use std::path::{Path, PathBuf};
use std::process::Command;

use assert_cmd::prelude::*;
use roadbench::internals::contract::bike::Axle;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{Input, Outcome, Pipeline};
use roadbench::internals::simulate::multibody::Motorcycle;
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::ride::{self, MultibodyRide};
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::simulate::{compare, replay};
use roadbench::internals::tyre::custom::Custom;
use roadbench::internals::{GRAVITY, filter, ingest, pipeline, segment};

fn tour(text: &str) -> Tour {
    Tour::parse(text, Path::new("test.toml")).unwrap_or_else(|e| panic!("{e}"))
}

/// A shorter ride than the built-in `characterise`, with its sensors.
fn short_characterisation() -> Tour {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "pipelines/scenarios/characterise.toml"].iter().collect();
    let text = std::fs::read_to_string(path).expect("scenario");
    let shorter = text
        .replace("coasts = 16, brakings = 6, laps = 12", "coasts = 8, brakings = 4, laps = 6")
        .replace("sessions = 3", "sessions = 1");
    assert_ne!(text, shorter);
    tour(&shorter)
}

fn run_pipeline(tour: &Tour, ridden: &MultibodyRide, folder: &Path) -> Outcome {
    let path = folder.join("log.parquet");
    write_session(&path, &ridden.session, false).expect("log");
    let input = Input {
        log: (&path).into(),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    pipeline::run(&input, &tour.bike, &Pipeline::onroad()).expect("characterisation")
}

fn custom(tour: &Tour, outcome: &Outcome, axle: Axle) -> Custom {
    let value = |tyre: &str, name: &str| {
        let row = outcome.coefficients.iter().find(|c| c.tyre == tyre && c.coefficient == name);
        row.and_then(|c| c.value)
    };
    let bike = &tour.bike;
    let behind = if axle == Axle::Front { bike.cg_to_rear() } else { bike.cg_to_front };
    Custom::characterised(
        |c| value(axle.name(), c.name()),
        bike.wheel(axle),
        bike.mass * GRAVITY * behind / bike.wheelbase,
        value("vehicle", "rolling_resistance").expect("rolling resistance"),
        tour.model.road.friction,
    )
    .expect("a tyre to simulate")
}

/// The paper's validation, from noisy riding on one motorcycle to the lane change on another; the
/// stops with the front brake simulated again.
#[test]
fn the_papers_study_again() {
    let folder = tempfile::tempdir().expect("folder");
    let ride_plan = short_characterisation();
    let period = ride::period(ride_plan.rate);
    let skill = Skill::learn(&ride_plan.model, period).expect("rides");
    let ridden = ride::ride(&ride_plan, &skill, 0);
    assert_eq!(ridden.fall, None);
    let outcome = run_pipeline(&ride_plan, &ridden, folder.path());
    let front = custom(&ride_plan, &outcome, Axle::Front);
    let rear = custom(&ride_plan, &outcome, Axle::Rear);

    let own = Tour::load("lane_change").expect("built in").expect("nonlinear");
    let mut given = own.clone();
    given.fit(Some(Box::new(front)), Some(Box::new(rear)));
    let skill = Skill::learn(&own.model, period).expect("rides");
    let (reference, other) = (ride::ride(&own, &skill, 0), ride::ride(&given, &skill, 0));
    let rows = compare::peaks(&reference, &other);
    let error = |channel: &str| {
        let row = rows.iter().find(|r| r.channel == channel).expect("channel");
        row.error.abs()
    };
    // not worse than the paper (its section 5): peak errors
    for (channel, paper) in [
        ("steer_torque", 0.118),
        ("steer_angle", 0.028),
        ("slip_ratio_front_braking", 0.126),
        ("slip_ratio_rear_driving", 0.03),
        ("slip_angle_front_entry", 0.336),
        ("moment_z_rear", 0.34),
    ] {
        println!("{channel}: {:.3}, paper {paper}", error(channel));
        assert!(error(channel) < paper, "{channel}: {:.3}, paper {paper}", error(channel));
    }
    // may be worse than the paper (0.063, 0.088 there), and known why: with load this tyre's slip stiffness changes less
    // (0.14) than a usual one's (0.2); the front yaw moment hangs on the assumed twisting stiffness and trail
    for (channel, reached) in [("slip_ratio_rear_braking", 0.12), ("moment_z_front", 0.20)] {
        println!("{channel}: {:.3}", error(channel));
        assert!(error(channel) < reached, "{channel}: {:.3}", error(channel));
    }
    // forces follow from the motion whatever the tyre
    assert!(error("force_y_front") < 0.05 && error("force_y_rear") < 0.05);

    // a second ride's braking manoeuvres, pressures in
    let tyres: [Box<dyn roadbench::internals::tyre::tyre_model::TyreModel>; 2] =
        [Box::new(front), Box::new(rear)];
    let mut braked = ride_plan.clone();
    let [front, rear] = tyres;
    braked.fit(Some(front), Some(rear));
    let second = ride::ride(&ride_plan, &Skill::learn(&ride_plan.model, period).expect("rides"), 1);
    let path = folder.path().join("second.parquet");
    write_session(&path, &second.session, false).expect("log");
    let onroad = Pipeline::onroad();
    let raw = ingest::read(&path, &[]).expect("reads");
    let (mut session, _) = ingest::run(raw, &onroad.ingest).expect("ingests");
    filter::run(&mut session, &onroad.filter);
    let segments = segment::run(&session, &braked.bike, &onroad.segment);
    let steering = replay::steering(&braked.model, session.rate).expect("rides");
    let mut count = 0;
    for s in segments.iter().filter(|s| {
        s.used && s.kind == roadbench::internals::segment::manoeuvre::ManoeuvreKind::FrontBraking
    }) {
        let from = s.start.saturating_sub(30);
        let replay =
            replay::braking(&braked.model, &steering, &session, from..s.end).expect("replay");
        let p = replay.peaks(0);
        // the paper's: 11.3 for 10.9 m/s2 measured
        let off = (p.deceleration[1] / p.deceleration[0] - 1.0).abs();
        assert!(off < 0.037, "{:?}", p);
        count += 1;
    }
    assert!(count >= 3, "{count} brakings");
}

#[test]
fn a_ride_is_reproducible_and_finite() {
    let own = Tour::load("lane_change").expect("built in").expect("nonlinear");
    let skill = Skill::learn(&own.model, ride::period(own.rate)).expect("rides");
    let (a, b) = (ride::ride(&own, &skill, 0), ride::ride(&own, &skill, 0));
    for channel in a.session.channels() {
        assert_eq!(a.session.get(channel), b.session.get(channel), "{channel}");
        let finite = a.session.get(channel).is_some_and(|x| x.iter().all(|x| x.is_finite()));
        assert!(finite, "{channel}");
    }
    // it did change lanes: 3 m to the left, on its wheels, and inside the ellipse
    let last = a.samples.last().expect("samples");
    assert!((last.position[1] - 3.0).abs() < 0.1, "{:?}", last.position);
    let lateral = a.session.get(Channel::AccelerationY).expect("channel");
    let most = lateral.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!((3.5..7.0).contains(&most), "{most}");
}

const FALLS: &str = r#"
name = "slippery"
description = "Leans far more than the road holds."
motorcycle = "sports_small"
start_speed = 9.0
manoeuvres = [
  { kind = "decreasing_radius", direction = "left", speed = 9.0, rate = 0.2, lean = 0.9, grip = 1.0 },
]
[road]
friction = 0.4
"#;

#[test]
fn a_fall_is_reported_and_what_was_ridden_is_kept() {
    let folder = tempfile::tempdir().expect("folder");
    let scenario = folder.path().join("slippery.toml");
    std::fs::write(&scenario, FALLS).expect("scenario");
    let out = folder.path().join("out");
    let run = Command::cargo_bin("roadbench")
        .expect("binary")
        .args(["simulate".as_ref(), scenario.as_os_str(), "--out".as_ref(), out.as_os_str()])
        .output()
        .expect("runs");
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(1), "{said}");
    assert!(said.contains("fell over at") && said.contains("its log ends there"), "{said}");
    let tour = tour(FALLS);
    let skill = Skill::learn(&tour.model, ride::period(tour.rate)).expect("rides");
    let ridden = ride::ride(&tour, &skill, 0);
    assert!(ridden.fall.is_some() && ridden.session.len > 100);
    assert_eq!(ridden.session.meta.site.as_deref(), Some("simulated, partial: fell"));
    for channel in ridden.session.channels() {
        let x = ridden.session.get(channel).expect("channel");
        assert!(x.iter().all(|x| x.is_finite()), "{channel}");
    }
}

#[test]
fn machines_that_cannot_stand_are_refused_by_key() {
    let path: PathBuf =
        [env!("CARGO_MANIFEST_DIR"), "pipelines/motorcycles/sports_small.toml"].iter().collect();
    let text = std::fs::read_to_string(path).expect("motorcycle");
    let refused = |from: &str, to: &str| {
        let changed = text.replacen(from, to, 1);
        assert_ne!(changed, text, "{from}");
        Motorcycle::parse(&changed, "bad", Path::new("bad.toml")).expect_err(to).to_string()
    };
    for (from, to, words) in [
        ("mass = 208.16", "mass = -208.16", "frame.mass"),
        ("axis_x = 1.1640784860185978", "axis_x = 1.0", "trail"),
        ("\nx = 1.4\n", "\nx = 0.5\n", "wheelbase"),
        ("x = 0.6786221738344809", "x = 2.4", "centre of mass"),
        ("z = 0.2915", "z = 0.45", "front.wheel.z"),
        ("sharp2004_front_120_70", "sharp2004_front", "front.tyre"),
        ("ixz = 2.50", "ixz = 42.50", "frame.ixz"),
        ("spin_inertia = 0.484", "spin_inertai = 0.484", "spin_inertia"),
        ("stiffness = 5142.5", "stiffness = \"soft\"", "swing_arm.stiffness"),
    ] {
        let message = refused(from, to);
        assert!(message.contains(words) && message.contains("bad.toml"), "{to}: {message}");
    }
}

#[test]
fn scenarios_with_wrong_numbers_are_refused_by_key() {
    for (from, to, words) in [
        ("friction = 0.4", "friction = -0.4", "friction"),
        ("speed = 9.0, rate", "speed = 900.0, rate", "`speed` = 900"),
        ("kind = \"decreasing_radius\"", "kind = \"loop\"", "loop"),
        ("motorcycle = \"sports_small\"", "motorcycle = \"sports_smal\"", "sports_small"),
        ("start_speed = 9.0", "step = 0.1", "`step`"),
        ("start_speed = 9.0", "start_sped = 9.0", "start_sped"),
        ("[road]", "[sensors.steer]\nwhite = 1.0\n[road]", "steer"),
    ] {
        let changed = FALLS.replacen(from, to, 1);
        assert_ne!(changed, FALLS, "{from}");
        let message = Tour::parse(&changed, Path::new("bad.toml")).expect_err(to).to_string();
        assert!(message.contains(words) && message.contains("bad.toml"), "{to}: {message}");
    }
}
