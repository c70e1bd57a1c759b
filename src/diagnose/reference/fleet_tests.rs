//! Motorcycles of a fleet, whose numbers are drawn: what they teach each other of the scatter between rides.

use super::numbers::Ride;
use super::tests::{put, put_trace, ride};
use super::*;
use crate::statistics::random::Random;
use crate::store::tables::changes::is_change;

const BIKES: usize = 7;
const RIDES: usize = 9;

/// So many motorcycles of nine rides each; `more` changes each ride after it is drawn.
fn fleet(
    seed: u64,
    bikes: usize,
    more: impl Fn(usize, usize, &mut Ride, &mut Random),
) -> Vec<Ride> {
    let of = |bike: usize, k: usize| {
        let mut ride = ride(1000 * seed + bike as u64, k, &[]);
        let mut random = Random::new(seed, &format!("ride {k} of {bike}"));
        more(bike, k, &mut ride, &mut random);
        let id = format!("bike {bike}");
        ride.ident.bike_id = id.clone();
        ride.estimates.iter_mut().for_each(|row| row.ident.bike_id = id.clone());
        ride.traces.iter_mut().for_each(|row| row.ident.bike_id = id.clone());
        ride
    };
    (0..bikes).flat_map(|bike| (0..RIDES).map(move |k| (bike, k))).map(|(b, k)| of(b, k)).collect()
}

/// Changes of fleets of so many seeds.
fn count(seeds: u64, of: impl Fn(u64) -> Vec<Ride>) -> usize {
    (0..seeds).map(|seed| changes(of(seed)).iter().filter(|r| is_change(r)).count()).sum()
}

/// A zero that is another one in every ride of every motorcycle, by twelve standard errors, where two are stated: none of
/// it is a change. With what is stated alone 20 fleets have about 14.
#[test]
fn what_varies_on_every_motorcycle_is_no_change_of_one() {
    let of = |seed: u64| {
        fleet(seed, BIKES, |_, _, ride, random| put(ride, "radius_front", 12.0 * random.normal()))
    };
    let false_rows = count(20, of);
    assert!(false_rows <= 7, "{false_rows} in 20 fleets");
}

/// A radius scatters between rides by its standard error, where two are stated, on every motorcycle. A ride that differs by
/// seven standard errors is seen more often in a fleet than on a motorcycle alone.
#[test]
fn what_no_motorcycle_varies_in_shows_smaller_changes() {
    let of = |seed: u64, bikes: usize| {
        fleet(seed, bikes, |bike, k, ride, _| {
            put(ride, "radius_front", if (bike, k) == (0, 5) { 7.0 } else { 0.0 });
        })
    };
    let is_it = |r: &&ChangeRow| is_change(r) && r.ident.bike_id == "bike 0";
    let seen = |bikes: usize| {
        (0..60).filter(|seed| changes(of(*seed, bikes)).iter().any(|r| is_it(&r))).count()
    };
    let [alone, of_fleet] = [seen(1), seen(BIKES)];
    assert!(of_fleet >= 10 && of_fleet > alone + 4, "{of_fleet} in a fleet, {alone} alone");
}

/// A tyre is changed on every motorcycle, each on another day: what they teach is not that radii jump, and all are found.
#[test]
fn changes_of_every_motorcycle_do_not_hide_each_other() {
    let rides = fleet(3, BIKES, |bike, k, ride, _| {
        put(ride, "radius_front", if k >= 3 + bike % 4 { 20.0 } else { 0.0 });
    });
    let rows: Vec<ChangeRow> = changes(rides).into_iter().filter(is_change).collect();
    assert_eq!(rows.len(), BIKES, "{rows:#?}");
    assert!(rows.iter().all(|r| r.rides == "since" && r.cause.as_deref() == Some("radius_front")));
}

/// In circles one way, every fourth ride, a zero moves a crown, on a road it does not: rides in circles are no change because
/// of the zeros that every ride has.
#[test]
fn a_number_that_a_zero_moves_in_some_rides_only_is_no_change_of_them() {
    let of = |seed: u64| {
        fleet(seed, BIKES, |_, k, ride, random| {
            let zero = 3.0 * random.normal();
            let slope = if k % 4 == 2 { 4.0 } else { 0.0 };
            put(ride, "latency", zero);
            put(ride, "radius_front", slope * zero);
            put_trace(ride, "latency", "radius_front", slope);
        })
    };
    let false_rows = count(10, of);
    assert!(false_rows <= 5, "{false_rows} in 10 fleets");
}

/// A latency since a date moves a radius to first order by -0.2 of it in some rides and by 0.3 in others, as they are fitted
/// at other optima. The remainder where it is taken out is no change of its own.
#[test]
fn what_a_change_leaves_where_traces_differ_is_no_change() {
    let of = |k: usize| {
        let mut ride = ride(3, k, if k >= 7 { &[("latency", 60.0)] } else { &[] });
        put_trace(&mut ride, "latency", "radius_front", if k == 9 { 0.3 } else { -0.2 });
        put(
            &mut ride,
            "radius_front",
            if k == 9 {
                120.0
            } else if k > 6 {
                -12.0
            } else {
                0.0
            },
        );
        ride
    };
    let rows = changes((0..14).map(of).collect());
    let rows: Vec<&ChangeRow> = rows.iter().filter(|r| is_change(r)).collect();
    let [row] = &rows[..] else { panic!("{rows:#?}") };
    assert_eq!((row.cause.as_deref(), row.rides.as_str()), (Some("latency"), "since"));
}
