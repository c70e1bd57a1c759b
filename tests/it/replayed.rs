//! A ride simulated on the motorcycle that it was ridden on, whatever it has: nothing is left.

use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::Session;
use roadbench::internals::diagnose::Settings;
use roadbench::internals::diagnose::road;
use roadbench::internals::diagnose::road::replay::{From, replay};
use roadbench::internals::diagnose::road::samples::picks;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::segment::Segment;
use roadbench::internals::simulate::effects::{ALL, Effect};
use roadbench::internals::simulate::hidden::{Case, Kind};
use roadbench::internals::simulate::motorcycle::Plant;
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::statistics::smooth::smooth;
use roadbench::internals::{filter, segment, simulate};

/// What is compared, and below what nobody would see a difference: half a white noise of usual sensors.
const COMPARED: [(Channel, f64); 7] = [
    (Channel::VelocityX, 0.02),
    (Channel::AccelerationX, 0.05),
    (Channel::AccelerationY, 0.05),
    (Channel::Roll, 0.003),
    (Channel::YawRate, 0.004),
    (Channel::WheelSpeedFront, 0.1),
    (Channel::WheelSpeedRear, 0.1),
];

/// Rms of measured less replayed in all manoeuvres, by channel.
fn misfit(session: &Session, segments: &[Segment], plant: &Plant) -> [f64; 7] {
    let shown = replay(session, segments, plant, From::Manoeuvres);
    let picks = picks(session, segments);
    COMPARED.map(|(channel, _)| {
        let column = |s: &Session| smooth(s.get(channel).expect("a channel"), s.rate);
        let (measured, shown) = (column(session), column(&shown));
        let at = picks.iter().flat_map(|(_, at)| at.iter().copied());
        let (n, sum) = at
            .map(|i| (measured[i] - shown[i]).powi(2))
            .filter(|x| x.is_finite())
            .fold((0.0, 0.0), |(n, sum), x| (n + 1.0, sum + x));
        f64::sqrt(sum / n)
    })
}

fn ridden(scenario: &Scenario, machine: &Machine) -> (Session, Vec<Segment>) {
    let session = simulate::session(scenario, machine, 0).session;
    let pipeline = Pipeline::onroad();
    let mut filtered = session.clone();
    filter::run(&mut filtered, &pipeline.filter);
    let segments = segment::run(&filtered, &machine.bike, &pipeline.segment);
    (session, segments)
}

/// Hidden sizes, in usual ones.
const SIZE: f64 = 3.0;
/// Errors of the usual motorcycle, in those of a ride with nothing hidden, from which an effect shows.
const SHOWS: f64 = 1.25;
/// Share of what an effect adds to the squared error that may be left by its true size.
const LEFT: f64 = 1.0 / 3.0;
/// Known, not understood: what the replayed rider does of himself about these grows with them.
const RIDERS: [(&str, &[Channel]); 3] = [
    ("road_bank", &[Channel::AccelerationY, Channel::Roll, Channel::YawRate]),
    ("front_compliance", &[Channel::AccelerationY, Channel::Roll, Channel::YawRate]),
    // of the yaw rate 0.110 -> 0.018 rad/s, 0.007 of itself; of the lateral acceleration 0.81 -> 0.10 m/s2, 0.03
    (
        "rider_lean",
        &[
            Channel::VelocityX,
            Channel::AccelerationY,
            Channel::YawRate,
            Channel::WheelSpeedFront,
            Channel::WheelSpeedRear,
        ],
    ),
];

#[test]
fn the_true_effect_leaves_nothing_of_itself() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let usual = scenario.machine(0);
    let (session, segments) = ridden(&scenario, &usual);
    let floor = misfit(&session, &segments, &usual.plant);
    // whether an effect shows, and the channels in which its true size leaves something
    let of = |effect: &Effect| {
        let (mut wrong, mut is_shown) = (Vec::new(), false);
        let mut machine = usual.clone();
        let mut error = machine.plant.model_error;
        (effect.set)(&mut error, SIZE * effect.typical);
        machine.plant = machine.plant.with(&error);
        let (session, segments) = ridden(&scenario, &machine);
        let without = misfit(&session, &segments, &usual.plant);
        let with = misfit(&session, &segments, &machine.plant);
        for (k, (channel, small)) in COMPARED.into_iter().enumerate() {
            let shows = without[k] > SHOWS * floor[k] && without[k] - floor[k] > 0.1 * small;
            is_shown |= shows;
            let left =
                (with[k].powi(2) - floor[k].powi(2)) / (without[k].powi(2) - floor[k].powi(2));
            let riders = RIDERS.iter().any(|(e, c)| *e == effect.name && c.contains(&channel));
            // a ride with something hidden is another ride: its floor is not quite the same; a channel of which
            // nothing was simulated is wrong, too
            // which a rider's own doing may be as far off as a twentieth of what it is without
            let most = if riders { 1.9 * floor[k] + 0.05 * without[k] } else { 1.5 * floor[k] };
            let off = with[k].is_nan() || with[k] > most + small;
            if off || (shows && left > LEFT && !riders) {
                let (name, channel) = (effect.name, channel.name());
                let (floor, without, with) = (floor[k], without[k], with[k]);
                wrong.push(format!(
                    "{name} {channel}: {without:.4} -> {with:.4}, {floor:.4} of itself"
                ));
            }
        }
        (is_shown, wrong)
    };
    let found: Vec<(bool, Vec<String>)> = ALL.par_iter().map(of).collect();
    let shown = ALL.iter().zip(&found).filter(|(_, (is_shown, _))| *is_shown);
    let shown: Vec<&str> = shown.map(|(effect, _)| effect.name).collect();
    let wrong: Vec<String> = found.iter().flat_map(|(_, wrong)| wrong.clone()).collect();
    // the others are smaller than the replay's own error
    println!("{} of {} effects show: {shown:?}", shown.len(), ALL.len());
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(2 * shown.len() >= ALL.len(), "{shown:?}");
}

/// Of a velocity sensor beside its place that is not among the candidates the residuals say that the rear side-force
/// ratio is another; simulated with it the manoeuvres that the fit had not seen get worse.
#[test]
fn a_name_that_makes_the_simulation_worse_is_taken_back() {
    let effect = Effect::named("velocity_lever_arm").expect("known");
    let hidden = vec![(effect, 3.0 * effect.typical)];
    let case = Case { hidden, ..Case::draw(5, 0, Kind::Null, [1.0, 1.0]) };
    let folder = tempfile::tempdir().expect("folder");
    let (log, bike) = case.write(folder.path()).expect("written");
    let bike = Bike::read(&bike).expect("bike");
    let others = ALL.iter().filter(|e| e.name != effect.name);
    let settings = Settings { nulls: 19, effects: others.copied().collect(), advise: false };
    let found = road::log(&log, &[], &bike, &Pipeline::onroad(), &settings).expect("diagnosed");
    let told: Vec<_> =
        found.identification.causes.iter().filter(|c| c.verdict.is_cause()).collect();
    let told: Vec<_> = told.iter().map(|c| (c.candidate.name, c.value(), c.std_error())).collect();
    assert!(told.is_empty(), "{told:?}");
    let taken_back = |name: &str| {
        let row = found.causes.iter().find(|c| c.effect == name).expect("a row");
        row.reason.contains("makes the simulation of manoeuvres that were left out worse")
    };
    let rows = || found.causes.iter().map(|c| format!("{} {}: {}", c.effect, c.verdict, c.reason));
    assert!(taken_back("side_force_ratio_rear"), "{}", rows().collect::<Vec<_>>().join("\n"));
    assert!(found.replays.iter().all(|r| r.extended.is_none()));
    assert!(found.simulation_errors.iter().all(|e| e.ratio.is_none()));
    assert!(found.model.effects.is_empty());
}

/// On a rear tyre with a twentieth of its cornering stiffness some bends cannot be ridden; the straights can.
#[test]
fn bends_that_cannot_be_ridden_are_left_out() {
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let session = simulate::session(&scenario, &machine, 0).session;
    let roll = session.get(Channel::Roll).expect("roll").to_vec();
    let lost = |plant: &Plant| {
        let shown = replay(&session, &[], plant, From::Session);
        let ridden = shown.get(Channel::Roll).expect("roll").to_vec();
        let share = |leaned: bool| {
            let own = roll.iter().zip(&ridden).filter(|(r, _)| (r.abs() > 0.3) == leaned);
            let (lost, all) =
                own.fold((0, 0), |(lost, all), (_, x)| (lost + u32::from(x.is_nan()), all + 1));
            f64::from(lost) / f64::from(all)
        };
        [share(true), share(false)]
    };
    let mut plant = machine.plant.clone();
    assert_eq!(lost(&plant), [0.0; 2]);
    plant.tyres[1].stiffness.ct *= 0.05;
    let [bends, straights] = lost(&plant);
    assert!(bends > 0.1 && straights < 0.02, "{bends}, {straights}");
}
