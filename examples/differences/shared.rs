//! Changes that several rides share: those of one rider, or more and more with time.

use rayon::prelude::*;
use roadbench::internals::diagnose::reference::{Ride, changes};
use roadbench::internals::simulate::effects::Effect;
use roadbench::internals::store::tables::rows::{ChangeRow, Circumstances};

use super::{Arguments, Failure, Said, is_change, of_machine};

/// What is hidden.
const HIDDEN: &[&str] = &[
    "wind",
    "road_grade",
    "latency",
    "steer_zero",
    "roll_zero",
    "pad_heat",
    "rolling_resistance_speed",
];

/// The share of a ride of so many.
type Share = fn(usize, usize) -> f64;

/// How rides share it: the name of their set in the table, and each one's share.
const SHARED: [(&str, Share); 3] = [
    ("rider", |k, _| f64::from(u8::from(is_anna(k)))),
    ("since", |k, n| f64::from(u8::from(k >= 2 * n / 3))),
    // with time, as is looked for
    ("drift", |k, n| hours(k) / hours(n - 1)),
];

/// Hours of a ride since the first one: two rides a day.
fn hours(k: usize) -> f64 {
    (24 * (k / 2) + k % 2) as f64
}

/// Every third ride, not in the rhythm of sites and nights.
fn is_anna(k: usize) -> bool {
    k % 7 % 3 == 1
}

/// Two rides a night on two sites, with two riders.
pub(super) fn placed(mut ride: Ride, k: usize) -> Ride {
    let text = |s: &str| Some(s.to_owned());
    ride.ident.start_time = Some(format!("2026-05-{:02}T{}:00:00Z", k / 2 + 1, 10 + k % 2));
    ride.circumstances = Circumstances {
        rider_id: text(if is_anna(k) { "anna" } else { "ben" }),
        site: text(if k / 2 % 3 == 1 { "north" } else { "south" }),
        ..Circumstances::default()
    };
    ride
}

/// What is said of one machine's rides.
fn said(rides: &[Said]) -> Vec<ChangeRow> {
    let rides = rides.iter().enumerate().map(|(k, said)| {
        let mut ride = placed(said.ride(), k);
        ride.ident.session_id = format!("ride {k:02}");
        ride
    });
    let rides = rides.collect();
    changes(rides).into_iter().filter(is_change).collect()
}

pub(super) fn study(a: &Arguments) -> Result<(), Failure> {
    let n = a.shared;
    let mut counts = [[0_usize; 4]; SHARED.len()];
    let mut intervals = [0_usize; 2];
    let (mut quiet, mut surplus) = (0, 0);
    for number in 0..a.machines {
        let ride = |k: usize, hidden: Option<(&'static Effect, f64)>| {
            of_machine(a.seed, number, k, hidden)
        };
        let plain: Vec<Said> =
            (0..n).into_par_iter().map(|k| ride(k, None)).collect::<Result<_, _>>()?;
        let alarms = said(&plain);
        quiet += usize::from(alarms.is_empty());
        alarms
            .iter()
            .for_each(|row| println!("machine {number}, nothing hidden: FALSE {}", row.sentence));
        for name in HIDDEN {
            let effect = Effect::named(name)?;
            let size = a.size * effect.typical;
            for (set, (kind, share)) in SHARED.iter().enumerate() {
                let of = |k: usize| match size * share(k, n) {
                    0.0 => Ok(plain[k].clone()),
                    size => ride(k, Some((effect, size))),
                };
                let rides: Vec<Said> = (0..n).into_par_iter().map(of).collect::<Result<_, _>>()?;
                let rows = said(&rides);
                let is_cause = |r: &&ChangeRow| {
                    let rivals = r.rivals.iter().flat_map(|r| r.split(", "));
                    r.cause.as_deref().into_iter().chain(rivals).any(|c| c == *name)
                };
                let right = rows.iter().filter(is_cause).find(|r| r.rides == *kind);
                let place = match (right, rows.iter().any(|r| is_cause(&r)), rows.is_empty()) {
                    (Some(_), _, _) => 0,
                    (None, true, _) => 1,
                    (None, false, false) => 2,
                    (None, false, true) => 3,
                };
                counts[set][place] += 1;
                surplus += rows.len() - usize::from(right.is_some());
                let own = right.filter(|r| r.cause.as_deref() == Some(*name));
                if let Some((low, high)) = own.and_then(|r| r.ci95_low.zip(r.ci95_high)) {
                    intervals[usize::from((low..=high).contains(&size))] += 1;
                }
                let mark = ["right", "other rides", "OTHER CAUSE", "-"][place];
                println!("machine {number}, {kind}, {name} {size}: {mark}");
                rows.iter().for_each(|r| println!("    {}: {}", r.rides, r.sentence));
            }
        }
    }
    println!("nothing hidden: {quiet} of {} machines as before", a.machines);
    for ((kind, _), [right, other, wrong, unseen]) in SHARED.iter().zip(counts) {
        println!(
            "{kind}: {right} right, {other} of other rides, {wrong} other cause, {unseen} not seen"
        );
    }
    println!("{surplus} rows that are not the right one");
    println!("intervals: {} of {} contain the size", intervals[1], intervals[0] + intervals[1]);
    Ok(())
}
