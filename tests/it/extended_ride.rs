//! The extended tyre: simulated with its identified causes it is nearer to the true one.

use rayon::prelude::*;
use roadbench::internals::contract::bike::{Axle, Bike};
use roadbench::internals::diagnose::{Settings, road};
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::segment::manoeuvre::Direction;
use roadbench::internals::simulate::effects::physics::Multibody;
use roadbench::internals::simulate::effects::{ALL, Effect, ModelError, tyre_file};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::manoeuvre::{Braked, Manoeuvre};
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::simulate::{multibody_ride as multibody, ride};
use roadbench::internals::tyre::custom::Custom;
use roadbench::internals::tyre::paper::Input;
use roadbench::internals::tyre::tyre_model::TyreModel;

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
    let load = machine.plant.vehicle.static_loads();
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

/// From end to end: what hides in the simulator's tyres is named, and the exported tyre leans nearer to them than the
/// one without.
#[test]
fn a_named_side_force_ratio_brings_the_exported_tyre_nearer_to_the_true_one() {
    let (axle, name) = (Axle::Rear, "side_force_ratio_rear");
    let effect = Effect::named(name).expect("known");
    let size = 4.0 * effect.typical;
    let case = Case { hidden: vec![(effect, size)], ..Case::draw(5, 0, Kind::Null, [1.0, 1.0]) };
    let folder = tempfile::tempdir().expect("folder");
    let (log, bike_path) = case.write(folder.path()).expect("written");
    let bike = Bike::read(&bike_path).expect("bike");
    let settings = Settings { nulls: 12, ..Settings::default() };
    let d = road::log(&log, &[], &bike, &Pipeline::onroad(), &settings).expect("diagnosed");
    assert!(d.model.effects.contains_key(name), "{name}: {:?}", d.model.effects);
    let path = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let (model, log) = (path("model.toml"), log.to_string_lossy());
    std::fs::write(&model, d.model.to_toml()).expect("written");
    let bikes = bike_path.parent().expect("folder").to_string_lossy();
    let tyre = |out: &str, more: &[&str]| {
        let out = path(out);
        let run = ["run", &log, "--bikes", &bikes, "--out", &out, "--progress", "never"];
        roadbench(&[&run[..], more].concat());
        let session = d.model.session_id.as_str();
        let export = ["export", &out, "--session", session, "--format", "simulator"];
        let end = ["--bikes", &bikes, "--tyre", axle.name()];
        tyre_file::parse(&roadbench(&[&export[..], &end, more].concat())).expect("a tyre")
    };
    let plant = case.machine().expect("machine").1.plant;
    let load = plant.vehicle.static_loads()[axle as usize];
    let custom = Custom::new(plant.tyres[axle as usize], load);
    let truth = tyre_file::extended(custom, &error_of(effect, size), axle, 1.0);
    let (extended, without) = (tyre("extended", &["--model", &model]), tyre("without", &[]));
    for camber in [0.2, 0.5] {
        let of = |tyre: &dyn TyreModel| {
            let input = Input { slip_ratio: 0.0, slip_angle: 0.0, camber, load, friction: 1.0 };
            tyre.forces(&input).force_y / load
        };
        let off = |tyre: &dyn TyreModel| (of(tyre) / of(truth.as_ref()) - 1.0).abs();
        let (with, plain) = (off(extended.as_ref()), off(without.as_ref()));
        assert!(with < 0.5 * plain, "{name} at {camber}: {with} extended, {plain} without");
    }
}
