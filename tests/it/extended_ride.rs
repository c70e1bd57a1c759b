//! The tyre extended: the simulator rides what a diagnosis named of it, and it is nearer to the true one.

use rayon::prelude::*;
use roadbench::contract::bike::{Axle, Bike};
use roadbench::diagnose::{Settings, road};
use roadbench::effects::physics::Multibody;
use roadbench::effects::{ALL, Effect, ModelError, tyre_file};
use roadbench::manoeuvre::Direction;
use roadbench::model::custom::Custom;
use roadbench::model::tyre::Input;
use roadbench::model::tyre_model::TyreModel;
use roadbench::pipeline::Pipeline;
use roadbench::simulate::hidden::{Case, Kind};
use roadbench::simulate::manoeuvre::{Braked, Manoeuvre};
use roadbench::simulate::pilot::Skill;
use roadbench::simulate::scenario::{Machine, Scenario};
use roadbench::simulate::tour::Tour;
use roadbench::simulate::{multibody, ride};

use super::export::roadbench;

/// A stop with both brakes, coasting, a bend.
const RIDE: [Manoeuvre; 3] = [
    Manoeuvre::Brake { wheels: Braked::Both, from: 14.0, rise: 2e6, slip: -0.08, until: 8.0 },
    Manoeuvre::Coast { from: 12.0, until: 11.0 },
    Manoeuvre::Corner { direction: Direction::Left, radius: 25.0, speed: 10.0, turn: 1.2 },
];

pub fn of_tyres() -> Vec<&'static Effect> {
    ALL.iter().filter(|e| !e.tyres.is_empty()).collect()
}

fn error_of(effect: &Effect, size: f64) -> ModelError {
    let mut error = ModelError::default();
    (effect.set)(&mut error, size);
    error
}

/// The effects of tyres are those that the tyre's files and the book list.
#[test]
fn eleven_effects_are_the_tyres() {
    let names: Vec<&str> = of_tyres().iter().map(|e| e.name).collect();
    let all = [
        "rolling_speed",
        "radius_speed",
        "radius_camber",
        "radius_load",
        "side_force_ratio_front",
        "side_force_ratio_rear",
        "stiffness_load",
        "twisting_stiffness",
        "pneumatic_trail",
        "relaxation_length",
        "friction_load",
    ];
    assert_eq!(names, all);
}

/// A file of the plain tyre with an effect in it rides as the plain motorcycle in which the effect is planted: to
/// the last digit.
#[test]
fn a_tyre_file_with_an_effect_rides_as_the_effect_planted() {
    let mut scenario = Scenario::builtin("perfect").expect("scenario").certain();
    scenario.rate = 50.0;
    let machine = scenario.machine(0);
    let tour = |machine: &Machine| -> Tour {
        let mut tour = multibody::tour(&scenario, machine, 0).expect("stands");
        tour.manoeuvres = RIDE.to_vec();
        tour.start_speed = 12.0;
        tour
    };
    let plain = tour(&machine);
    let skill = Skill::learn(&plain.model, ride::period(plain.rate)).expect("runs straight");
    let load = multibody::static_loads(&machine.plant);
    let custom = |k: usize| Custom::new(machine.plant.tyres[k], load[k]);
    let session = |tour: &Tour| {
        let ridden = ride::ride(tour, &skill, 0);
        assert!(ridden.fall.is_none(), "{:?}", ridden.fall);
        ridden.session
    };
    let usual = session(&plain);
    let shod = |tyres: [Box<dyn TyreModel>; 2]| {
        let mut tour = plain.clone();
        let [front, rear] = tyres;
        tour.fit(Some(front), Some(rear));
        session(&tour)
    };
    of_tyres().par_iter().for_each(|effect| {
        let (size, name) = (effect.typical, effect.name);
        let filed = shod([0, 1].map(|k| {
            let mut text = toml::to_string(&custom(k)).expect("text");
            if effect.tyres.contains(&Axle::BOTH[k]) {
                text += &format!("\n[effects]\n{name} = {size:?}\n");
            }
            tyre_file::parse(&text).expect("a tyre")
        }));
        let plant = machine.plant.clone().with(&error_of(effect, size));
        let planted = session(&tour(&Machine { plant, ..machine.clone() }));
        let mut differs = false;
        for channel in usual.channels() {
            let (file, plant) = (filed.get(channel), planted.get(channel));
            differs |= file != usual.get(channel);
            match effect.multibody {
                Multibody::Hooks => assert_eq!(file, plant, "{name}: {channel}"),
                // a motorcycle of springs and toroids is not planted with it
                Multibody::Inherent(_) => assert_eq!(plant, usual.get(channel), "{name}"),
            }
        }
        assert!(differs, "{name} changes nothing");
    });
}

/// From end to end: what hides in the simulator's tyres is named, and the exported tyre is nearer to them at other
/// loads than the one without.
#[test]
#[ignore = "not met: stiffness_load of -0.5 is not named on this ride"]
fn a_named_load_dependence_brings_the_exported_tyre_nearer_to_the_true_one() {
    for (name, size, number) in [("stiffness_load", -0.5, 1), ("friction_load", 0.5, 3)] {
        let hidden = vec![(Effect::named(name).expect("known"), size)];
        let (kind, plan) = (Kind::Single, "naturalistic");
        let case = Case { seed: 0, number, kind, plan, hidden, foreign: None };
        let folder = tempfile::tempdir().expect("folder");
        let (log, bike_path) = case.write(folder.path()).expect("written");
        let bike = Bike::read(&bike_path).expect("bike");
        let settings = Settings { nulls: 16, ..Settings::default() };
        let d = road::log(&log, &[], &bike, &Pipeline::onroad(), &settings).expect("diagnosed");
        let Some(found) = d.model.effects.get(name) else {
            panic!("{name} is not named: {:?}", d.model.effects);
        };
        println!("{name}: {} found for {size}", found.value);
        let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
        let model = path("model.toml");
        std::fs::write(&model, d.model.to_toml()).expect("written");
        let bikes = bike_path.parent().expect("folder").to_string_lossy().into_owned();
        let log = log.to_string_lossy().into_owned();
        let out = path("out");
        roadbench(&[
            "run",
            &log,
            "--bikes",
            &bikes,
            "--out",
            &out,
            "--model",
            &model,
            "--progress",
            "never",
        ]);
        let session = d.model.session_id.clone();
        let export = |end: &str, more: &[&str]| {
            let base = ["export", &out, "--session", &session, "--format", "simulator"];
            let text = roadbench(&[&base[..], &["--bikes", &bikes, "--tyre", end], more].concat());
            tyre_file::parse(&text).expect("a tyre")
        };
        let plant = case.machine().expect("machine").1.plant;
        let rest = multibody::static_loads(&plant);
        for (k, end) in ["front", "rear"].into_iter().enumerate() {
            let truth = tyre_file::extended(
                Custom::new(plant.tyres[k], rest[k]),
                &error_of(Effect::named(name).expect("known"), size),
                Axle::BOTH[k],
                1.0,
            );
            let (extended, without) = (export(end, &["--model", &model]), export(end, &[]));
            for share in [0.5, 1.5] {
                let of = |tyre: &dyn TyreModel| {
                    let load = share * rest[k];
                    let input = |slip_ratio| Input {
                        slip_ratio,
                        slip_angle: 0.0,
                        camber: 0.0,
                        load,
                        friction: 1.0,
                    };
                    match name {
                        "friction_load" => (1..200)
                            .map(|i| -tyre.forces(&input(-0.002 * f64::from(i))).force_x / load)
                            .fold(0.0, f64::max),
                        _ => {
                            let input = Input { slip_angle: 0.005, ..input(0.0) };
                            -tyre.forces(&input).force_y / load / 0.005
                        }
                    }
                };
                let truth = of(truth.as_ref());
                let off = |tyre: &dyn TyreModel| of(tyre) / truth - 1.0;
                let (with, plain) = (off(extended.as_ref()), off(without.as_ref()));
                println!("{name} {end} at {share}: {with:+.3} extended, {plain:+.3} without");
                // at the front's braked loads the friction without is that of these loads
                let may_be_as_good = name == "friction_load" && end == "front" && share > 1.0;
                assert!(
                    with.abs() < plain.abs() || may_be_as_good && with.abs() < 0.05,
                    "{name} {end} at {share}: {with} extended, {plain} without"
                );
            }
        }
    }
}
