//! What a set of channels cannot tell apart is not determined: drag and rolling resistance without anything that shows
//! coasting, an acceleration without anything that shows turning, values that nothing on wheels has.

use std::sync::atomic::{AtomicBool, Ordering};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;
use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel::{self, *};
use roadbench::internals::contract::coefficient::{Coefficient as C, Id, Part, shows_coasting};
use roadbench::internals::contract::reason::ReasonCode;
use roadbench::internals::contract::session::Session;
use roadbench::internals::ingest::write_session;
use roadbench::internals::pipeline::{self, Input, Pipeline};
use roadbench::internals::simulate::scenario::{Machine, Scenario};
use roadbench::internals::simulate::{session, truth};
use roadbench::internals::store::objects::Location;
use roadbench::internals::store::tables::rows::Status;

const RESISTANCE: [C; 2] = [C::Drag, C::RollingResistance];

/// The channels of a session that are in a set.
pub(crate) fn only(whole: &Session, set: &[Channel]) -> Session {
    let mut out = whole.clone();
    for channel in whole.channels().collect::<Vec<_>>() {
        if !set.contains(&channel) {
            out.remove(channel);
        }
    }
    out
}

pub(crate) fn ride(number: usize) -> (Machine, Session, Vec<(Id, f64)>) {
    let scenario = Scenario::builtin("archive").expect("scenario");
    let machine = scenario.machine(number);
    let ride = session(&scenario, &machine, number);
    let known = truth::coefficients(&machine.plant, &ride, &Pipeline::onroad().estimate);
    (machine, ride.session, known)
}

/// A session as `run` characterises its log.
pub(crate) fn characterised(bike: &Bike, session: &Session) -> pipeline::Outcome {
    let folder = tempfile::tempdir().expect("folder");
    let log = folder.path().join("ride.parquet");
    write_session(&log, session, false).expect("written");
    let input = Input {
        log: Location::from(log.as_path()),
        maps: &[],
        input_hash: String::new(),
        pipeline_hash: String::new(),
        signals: false,
    };
    pipeline::run(&input, bike, &Pipeline::onroad()).expect("a ride")
}

/// Drag and rolling resistance with their 95 % intervals, where `run` calls them determined.
fn resistance(machine: &Machine, session: &Session) -> [Option<[f64; 3]>; 2] {
    let rows = characterised(&machine.bike, session).coefficients;
    RESISTANCE.map(|c| {
        let row = rows.iter().find(|r| r.coefficient == c.name()).expect("a row");
        if !shows_coasting(session) {
            assert_eq!(row.status, Status::NotAvailable);
            assert_eq!(row.reason_code.as_deref(), Some(ReasonCode::UnknownCoasting.name()));
        }
        let known = [row.value?, row.ci95_low?, row.ci95_high?];
        (row.status == Status::Ok).then_some(known)
    })
}

#[test]
fn without_a_gear_or_a_throttle_nothing_tells_coasting_from_drive() {
    let (machine, whole, _) = ride(0);
    for (set, known) in [
        (&[VelocityX][..], false),
        (&[VelocityX, Latitude, Longitude, Roll, YawRate, AccelerationX], false),
        (&[VelocityX, WheelSpeedFront, WheelSpeedRear, Roll, YawRate], false),
        (&[VelocityX, Throttle], false),
        (&[VelocityX, BrakePressureFront, BrakePressureRear], false),
        (&[VelocityX, WheelSpeedFront, WheelSpeedRear, AccelerationX, Throttle, YawRate], true),
        (&[VelocityX, Gear], true),
    ] {
        let session = only(&whole, set);
        assert_eq!(shows_coasting(&session), known, "{set:?}");
        assert_eq!(resistance(&machine, &session)[0].is_some(), known, "{set:?}");
    }
    // a gear that says nothing
    let mut stuck = only(&whole, &[VelocityX, Gear]);
    stuck.set(Gear, vec![0.0; stuck.len]);
    assert!(!shows_coasting(&stuck) && resistance(&machine, &stuck) == [None; 2]);
}

/// Of the subsets, those that give a resistance give the true one.
#[test]
fn resistances_of_random_channel_sets_hold_the_truth() {
    let tried = AtomicBool::new(false);
    let holds: Vec<bool> = (0..20_usize)
        .into_par_iter()
        .flat_map_iter(|number| {
            let (machine, whole, truth) = ride(number);
            let mut dice = Pcg64Mcg::seed_from_u64(number as u64);
            let drawn = whole.channels().filter(|_| dice.random_bool(0.7));
            let set: Vec<Channel> = drawn.chain([VelocityX]).collect();
            let session = only(&whole, &set);
            let shown = shows_coasting(&session);
            tried.fetch_or(!shown, Ordering::Relaxed);
            let found = resistance(&machine, &session);
            assert!(shown || found == [None; 2], "{set:?}");
            [0, 1].into_iter().filter_map(move |k| {
                let id = Id::from((Part::Vehicle, RESISTANCE[k]));
                let (_, true_value) = *truth.iter().find(|(i, _)| *i == id).expect("known");
                let [value, low, high] = found[k]?;
                let holds = (low..=high).contains(&true_value);
                if !holds {
                    println!(
                        "{id} {value:.4} [{low:.4}, {high:.4}], true {true_value:.4}: {set:?}"
                    );
                }
                Some(holds)
            })
        })
        .collect();
    let (held, all) = (holds.iter().filter(|h| **h).count(), holds.len());
    println!("{held} of {all} intervals hold");
    assert!(tried.into_inner() && all >= 16, "{all}");
    // 95 % of them, and what chance allows of so few
    assert!(held as f64 >= 0.88 * all as f64, "{held} of {all}");
}

/// An accelerometer 0.05 m/s² off, on a ride whose bends nothing shows: its zero cannot be found on the straights.
#[test]
fn an_acceleration_whose_zero_nothing_shows_is_not_taken_for_a_slope() {
    let (machine, whole, truth) = ride(1);
    let mut session = only(&whole, &[VelocityX, AccelerationX, Gear]);
    let off: Vec<f64> = whole.get(AccelerationX).expect("there").iter().map(|a| a + 0.05).collect();
    session.set(AccelerationX, off);
    let found = resistance(&machine, &session);
    assert!(found[0].is_some());
    for (c, found) in RESISTANCE.into_iter().zip(found) {
        let Some([value, low, high]) = found else { continue };
        let id = Id::from((Part::Vehicle, c));
        let (_, true_value) = truth.iter().find(|(i, _)| *i == id).expect("known");
        assert!((low..=high).contains(true_value), "{id} {value} [{low}, {high}] {true_value}");
    }
}

/// A receiver's speed that comes once a second: its straight lines bend where the brake or the throttle begins.
#[test]
fn drag_of_a_speed_once_a_second_is_unbiased() {
    let id = Id::from((Part::Vehicle, C::Drag));
    let errors: Vec<[f64; 2]> = (0..8_usize)
        .into_par_iter()
        .filter_map(|number| {
            let (machine, whole, truth) = ride(number);
            let mut session = only(&whole, &[VelocityX, Gear, Throttle, YawRate]);
            let every = session.rate.round() as usize;
            let speed = whole.get(VelocityX).expect("there");
            let last = speed.len() - 1;
            // the line between the fixes, as a log is brought to its rate
            let between = |i: usize| {
                let from = i - i % every;
                let to = (from + every).min(last);
                let share = (i - from) as f64 / (to - from).max(1) as f64;
                speed[from] + share * (speed[to] - speed[from])
            };
            session.set(VelocityX, (0..=last).map(between).collect());
            session.velocity_spacing = 1.0;
            // determined or poorly so
            let rows = characterised(&machine.bike, &session).coefficients;
            let row = rows.iter().find(|r| r.coefficient == C::Drag.name()).expect("a row");
            let [value, low, high] = [row.value?, row.ci95_low?, row.ci95_high?];
            let (_, known) = truth.iter().find(|(i, _)| *i == id).expect("known");
            println!("{number}: {value:.3} [{low:.3}, {high:.3}], true {known:.3}");
            Some([value / known - 1.0, 0.5 * (high - low) / known])
        })
        .collect();
    let held = errors.iter().filter(|[error, half]| error.abs() <= *half).count();
    let mean = errors.iter().map(|[error, _]| error).sum::<f64>() / errors.len() as f64;
    println!("{held} of {} intervals hold, mean error {mean:+.3}", errors.len());
    assert!(errors.len() >= 5, "{errors:?}");
    assert!(held + 1 >= errors.len() && mean.abs() < 0.15, "{held}, {mean}");
}

#[test]
fn a_value_beyond_its_bounds_is_impossible_and_the_reason_says_which() {
    for &coefficient in C::ALL {
        let [low, high] = coefficient.spec().bounds;
        assert!(low < high, "{coefficient}");
        let span = high - low;
        assert!(coefficient.impossible(0.5 * (low + high)).is_none(), "{coefficient}");
        for value in [low - 0.01 * span, high + 0.01 * span] {
            let reason = coefficient.impossible(value).expect("beyond");
            assert!(reason.contains("impossible"), "{reason}");
        }
    }
    assert!(C::RollingResistance.impossible(-0.0057).is_some());
    assert!(C::LateralFrictionCt.impossible(0.53).is_some());
    // those of real motorcycles, bicycles and cars
    for (coefficient, values) in [
        (C::Drag, &[0.1, 0.45, 0.9][..]),
        (C::RollingResistance, &[0.003, 0.02, 0.05]),
        (C::LateralFrictionCt, &[-0.7, -1.05, -1.2]),
        (C::MfD, &[0.3, 1.1, 1.6]),
        (C::OverturningStiffness, &[0.01, 0.12]),
    ] {
        for value in values {
            assert_eq!(coefficient.impossible(*value), None);
        }
    }
}
