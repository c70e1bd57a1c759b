//! No cause is half known: every effect acts in the residuals, on the reduced-order motorcycle and on
//! the multibody one.

use rayon::prelude::*;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::residual_channel::ResidualChannel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::diagnose::road;
use roadbench::internals::diagnose::road::parameters::{BASE, Parameter, Parameters};
use roadbench::internals::diagnose::road::problem::Problem;
use roadbench::internals::diagnose::road::residuals::{Blocks, blocks};
use roadbench::internals::diagnose::road::samples::Samples;
use roadbench::internals::diagnose::road::workings::LinearisationCache;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::segment::manoeuvre::Direction;
use roadbench::internals::simulate;
use roadbench::internals::simulate::effects::physics::Multibody;
use roadbench::internals::simulate::effects::remove::remove;
use roadbench::internals::simulate::effects::{ALL, Effect, ModelError};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::manoeuvre::{Braked, Manoeuvre};
use roadbench::internals::simulate::motorcycle::Plant;
use roadbench::internals::simulate::pilot::Skill;
use roadbench::internals::simulate::plan::Phase;
use roadbench::internals::simulate::rider::Disturbance;
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::tour::Tour;
use roadbench::internals::simulate::{multibody_ride as multibody, simulate_phases};
use roadbench::internals::statistics::random::Random;

/// A difference of a signal, over its largest value, that is no rounding.
const CHANGED: f64 = 1e-6;

/// A stop with both brakes, coasting on warm brakes, a bend.
const RIDE: [Manoeuvre; 3] = [
    Manoeuvre::Brake { wheels: Braked::Both, from: 14.0, rise: 2e6, slip: -0.08, until: 8.0 },
    Manoeuvre::Coast { from: 12.0, until: 11.0 },
    Manoeuvre::Corner { direction: Direction::Left, radius: 25.0, speed: 10.0, turn: 1.2 },
];

/// A machine whose bike file is true.
fn machine() -> (Scenario, Machine) {
    let mut scenario = Scenario::builtin("perfect").expect("scenario").certain();
    scenario.rate = 50.0;
    let machine = scenario.machine(0);
    (scenario, machine)
}

fn planted(effect: &Effect) -> ModelError {
    let mut error = ModelError::default();
    (effect.set)(&mut error, effect.typical);
    error
}

/// Largest change of any channel, over the channel's largest value.
fn change(a: &Session, b: &Session) -> f64 {
    assert!(a.len > 500 && b.len > 500, "{} and {} samples", a.len, b.len);
    let of = |channel: Channel| {
        let (Some(x), Some(y)) = (a.get(channel), b.get(channel)) else { return 0.0 };
        let largest = x.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let most = x.iter().zip(y).fold(0.0_f64, |m, (x, y)| m.max((x - y).abs()));
        if largest > 0.0 { most / largest } else { most }
    };
    Channel::ALL.iter().map(|c| of(*c)).fold(0.0, f64::max)
}

/// The ride on the reduced-order motorcycle.
fn reduced(plant: &Plant) -> Session {
    let mut random = Random::new(1, "phases");
    let phases: Vec<Phase> = RIDE.iter().flat_map(|m| m.phases(&mut random)).collect();
    let random = Random::new(1, "ride");
    let meta = Meta::default();
    let mut session =
        simulate_phases(plant, &phases, Disturbance::default(), random, 50.0, 120.0, meta).session;
    plant.model_error.measure(&mut session);
    session
}

/// The ride on the multibody motorcycle.
fn tour(scenario: &Scenario, machine: &Machine) -> Tour {
    let mut tour = multibody::tour(scenario, machine, 0).expect("stands");
    tour.manoeuvres = RIDE.to_vec();
    tour.start_speed = 12.0;
    tour
}

/// Fails for an effect that either simulator lacks without its file saying why.
#[test]
fn every_effect_changes_a_ride_on_both_motorcycles() {
    let (scenario, machine) = machine();
    let nominal = tour(&scenario, &machine);
    let skill =
        Skill::learn(&nominal.model, roadbench::internals::simulate::ride::period(nominal.rate))
            .expect("runs straight");
    let multibody = |machine: &Machine| {
        let ridden =
            roadbench::internals::simulate::ride::ride(&tour(&scenario, machine), &skill, 0);
        assert!(ridden.fall.is_none(), "{:?}", ridden.fall);
        ridden.session
    };
    let [usual, usual_multibody] = [reduced(&machine.plant), multibody(&machine)];
    let faults: Vec<String> = ALL
        .par_iter()
        .flat_map_iter(|effect| {
            let plant = machine.plant.clone().with(&planted(effect));
            let own = change(&usual, &reduced(&plant));
            let many = change(&usual_multibody, &multibody(&Machine { plant, ..machine.clone() }));
            let mut faults = Vec::new();
            if own < CHANGED {
                faults.push(format!("{}: not on the reduced-order motorcycle", effect.name));
            }
            match effect.multibody {
                Multibody::Hooks if many < CHANGED => {
                    faults.push(format!("{}: not on the multibody motorcycle", effect.name));
                }
                Multibody::Inherent(why) if many >= CHANGED || why.is_empty() => {
                    faults.push(format!("{}: its hooks act on the multibody one", effect.name));
                }
                _ => {}
            }
            faults
        })
        .collect();
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Samples and fitted base parameters of a ride with nothing hidden.
fn base() -> (Samples, Parameters) {
    let (kind, plan) = (Kind::Null, "paper");
    let case =
        Case { seed: 0, number: 2, kind, plan, hidden: Vec::new(), foreign: None, odd: Vec::new() };
    let (session, machine) = case.ride().expect("ridden");
    let fitted = road::fitted(&session, &machine.bike, &Pipeline::onroad()).expect("fitted");
    (fitted.samples, fitted.base.values)
}

/// Parameters with one of them a step away.
fn moved(parameters: &Parameters, parameter: &Parameter) -> Parameters {
    let mut near = parameters.clone();
    parameter.set(&mut near, parameter.get(parameters) + 0.003 * parameter.scale);
    near
}

/// Largest difference; of values of which one is not finite, infinity unless both are the same.
fn farthest(a: &[f64], b: &[f64]) -> f64 {
    let off = |(a, b): (&f64, &f64)| match (a - b).abs() {
        off if off.is_finite() => off,
        _ if a.to_bits() == b.to_bits() => 0.0,
        _ => f64::INFINITY,
    };
    a.iter().zip(b).map(off).fold(0.0, f64::max)
}

fn far(a: &Blocks, b: &Blocks) -> f64 {
    a.iter().zip(b).map(|(a, b)| farthest(a, b)).fold(0.0, f64::max)
}

fn bits(blocks: &Blocks) -> Vec<u64> {
    blocks.iter().flatten().map(|x| x.to_bits()).collect()
}

/// Slopes of the residuals of block means are those of the block means of residuals, but for what is over within a
/// block.
#[test]
fn block_means_tell_the_slopes_of_all_that_lasts() {
    let (samples, parameters) = base();
    let all: Vec<Parameter> =
        BASE.iter().copied().chain(ALL.iter().map(Effect::parameter)).collect();
    let problem = Problem::new(&samples, &parameters, [1.0; 8], &all);
    let linear = problem.linear_of_means(&parameters);
    let workings = LinearisationCache::of(&samples, &parameters);
    let size = |x: &mut dyn Iterator<Item = f64>| {
        x.filter(|x| x.is_finite()).map(|x| x * x).sum::<f64>().sqrt()
    };
    for (parameter, column) in all.iter().zip(&linear.columns) {
        let whole = workings.column(parameter, 0.003);
        let pairs = || column.iter().flatten().zip(whole.iter().flatten());
        let off = size(&mut pairs().map(|(a, b)| a - b));
        let all = size(&mut pairs().map(|(_, b)| *b));
        // a fit along slopes that are off by so little ends where it would
        assert!(off < 0.1 * all, "{}: {off} of {all}", parameter.name);
    }
}

/// Fails for an effect or a parameter without a residual, where a posture leaves out what attitudes depend on, and
/// where a reach does not: then what is kept of other parameters gives other residuals than their own.
#[test]
fn every_effect_changes_residuals_and_what_it_does_not_reach_stays() {
    let (samples, mut parameters) = base();
    // with all of them there already: one may act through another
    for effect in ALL {
        effect.parameter().set(&mut parameters, 0.3 * effect.typical);
    }
    let (usual, workings) =
        (blocks(&samples, &parameters), LinearisationCache::of(&samples, &parameters));
    assert!(far(&workings.blocks, &usual) < 1e-9);
    let all: Vec<Parameter> =
        BASE.iter().copied().chain(ALL.iter().map(Effect::parameter)).collect();
    let shared: usize = all
        .par_iter()
        .map(|parameter| {
            let near = moved(&parameters, parameter);
            let own = blocks(&samples, &near);
            assert!(bits(&own) != bits(&usual), "{} changes no residual", parameter.name);
            let (shared, reach) = workings.near(parameter, parameter.get(&near));
            let change = far(&own, &usual);
            for (c, channel) in ResidualChannel::ALL.into_iter().enumerate() {
                // what is not reached is the same to the bit, the rest is worked out by short series
                let (right, most) = match reach.acts_on(channel) {
                    true => (&shared[c], 3e-4 * change + 1e-9),
                    false => (&usual[c], 0.0),
                };
                let off = farthest(&own[c], right);
                let (channel, parameter) = (channel.name(), parameter.name);
                assert!(off <= most, "{channel} over {parameter}: {off} of {change}");
            }
            usize::from(!reach.attitude)
        })
        .sum();
    // what the cache is for: most share
    assert!(2 * shared > all.len(), "{shared} of {}", all.len());
}

/// What the sensors of a model error do to a ride is removed to the last digit where it is a shift,
/// and to a thousandth of the signal where it is interpolated.
#[test]
fn sensor_effects_are_taken_out_again() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let clean = simulate::session(&scenario, &machine, 0).session;
    for (name, size, channel, most) in [
        ("steer_zero", 0.01, Channel::SteerAngle, 1e-12),
        ("roll_zero", -0.01, Channel::Roll, 1e-12),
        ("velocity_lever_arm", 0.4, Channel::VelocityY, 1e-12),
        ("latency", 0.03, Channel::VelocityX, 0.02),
    ] {
        let mut error = ModelError::default();
        (Effect::named(name).expect("known").set)(&mut error, size);
        let mut session = clean.clone();
        error.measure(&mut session);
        let mut bike = machine.bike.clone();
        assert!(remove(&error, &mut session, &mut bike).is_empty());
        let (a, b) = (clean.get(channel).expect("there"), session.get(channel).expect("there"));
        let n = a.len() - 10;
        let off = (10..n).map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
        assert!(off < most, "{name}: {off}");
    }
}
