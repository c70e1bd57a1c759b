//! Motorcycles whose rides are written down, so that what changed is known.

use super::entries::entries;
use super::evidence::{Evidence, Quantity, Way};
use super::numbers::{Point, Series};
use super::related::{are_related, moves};
use super::rides::{Ride, Rides};
use super::timeline::{Mark, draw};
use crate::simulate::effects::Effect;
use crate::store::tables::changes::place;
use crate::store::tables::rows::{ChangeRow, Circumstances, EventRow, Ident};

/// Rides on consecutive days; the tyres change with the ride `swap`.
fn rides(count: usize, swap: usize) -> Rides {
    let of = |k: usize| Ride {
        ident: ident(k),
        circumstances: Circumstances {
            rider_id: Some(if k % 3 == 1 { "anna" } else { "ben" }.to_owned()),
            tyre_rear: Some(if k < swap { "hard" } else { "soft" }.to_owned()),
            ..Circumstances::default()
        },
        page: format!("s{k:02}.html"),
        is_of_run: true,
    };
    Rides::new((0..count).map(of).collect())
}

fn ident(k: usize) -> Ident {
    Ident {
        bike_id: "a".into(),
        session_id: format!("s{k:02}"),
        start_time: Some(format!("2026-05-{:02}T10:00:00Z", k + 1)),
    }
}

fn event(kind: &str, tyre: &str, coefficients: &str, first: usize, last: usize) -> EventRow {
    EventRow {
        bike_id: "a".into(),
        kind: kind.into(),
        tyre: tyre.into(),
        coefficients: coefficients.into(),
        first_session: ident(first).session_id,
        last_session: ident(last).session_id,
        first_time: ident(first).start_time,
        n_sessions: (last - first + 1) as i64,
        size: Some(0.12),
        evidence: 12.0,
        ..EventRow::default()
    }
}

fn change(rides: &str, first: usize, n: usize, cause: &str, moved: &str) -> ChangeRow {
    ChangeRow {
        ident: ident(first),
        rides: rides.into(),
        n_rides: n as i64,
        verdict: "named".into(),
        cause: Some(cause.into()),
        t: Some(9.0),
        moved: Some(moved.into()),
        sentence: format!("{cause} differs"),
        ..ChangeRow::default()
    }
}

#[test]
fn an_event_has_the_sentence_of_a_change() {
    let rides = rides(12, 7);
    let swap = event("tyre_swap", "rear", "rear mf_d, rear effective_rolling_radius", 7, 11);
    let evidence = Evidence::of_event(&swap, &rides);
    // 12 % over 12 standard deviations: 1.96 % to each side
    assert_eq!(
        evidence.row.sentence,
        "the rear peak friction differs by 12.0 % (10.0 to 14.0) from the 7 rides before, as if another rear tyre was fitted"
    );
    assert_eq!(place(&evidence.row), "since s07 (2026-05-08, rear tyre soft)");
    assert!(
        evidence.detail.starts_with("Also moved: the rear rolling radius."),
        "{}",
        evidence.detail
    );
    let odd = Evidence::of_event(&event("outlier", "front", "front mf_c", 3, 3), &rides);
    assert!(
        odd.row.sentence.ends_with("from the motorcycle's 11 other rides, the cause is not known"),
        "{}",
        odd.row.sentence
    );
    assert_eq!(place(&odd.row), "s03 (2026-05-04)");
    let stretch = Evidence::of_event(&event("change", "front", "front mf_c", 2, 4), &rides);
    assert_eq!(place(&stretch.row), "s02 to s04 (3 rides)");
    let drift = Evidence::of_event(&event("drift", "front", "front mf_d", 0, 11), &rides);
    assert!(drift.row.sentence.contains("drifts by 12.0 %"), "{}", drift.row.sentence);
    assert!(drift.members.iter().all(|m| *m));
}

#[test]
fn what_both_ways_say_of_the_same_rides_is_one_entry() {
    let rides = rides(12, 7);
    let events = [
        event("tyre_swap", "rear", "rear mf_d, rear effective_rolling_radius", 7, 11),
        event("outlier", "front", "front mf_d", 2, 2),
    ];
    let changes = [
        // one ride later, the same radius: the two ways place it differently
        change("since", 8, 4, "radius_rear", "radius_rear 2.0 mm (t 9.0)"),
        // the same ride, but nothing of a friction curve
        change(
            "ride",
            2,
            1,
            "rider_lean",
            "rider_lean 0.1 m/rad (t 9.0), overturning_stiffness 3 mm (t 4.0)",
        ),
        change("ride", 10, 1, "wind", "wind 2.0 m/s (t 20.0)"),
        ChangeRow { verdict: "as_before".into(), ..change("ride", 0, 1, "wind", "") },
    ];
    let all = entries(&changes, &events, &rides);
    let seen: Vec<(String, Vec<Way>)> =
        all.iter().map(|e| (e.place(), e.evidence.iter().map(|e| e.way).collect())).collect();
    assert_eq!(
        seen,
        [
            // of one ride the surest first
            ("s02 (2026-05-03)".to_owned(), vec![Way::Coefficients]),
            ("s02 (2026-05-03)".to_owned(), vec![Way::Rides]),
            ("since s08 (2026-05-09)".to_owned(), vec![Way::Rides, Way::Coefficients]),
            ("s10 (2026-05-11)".to_owned(), vec![Way::Rides]),
        ]
    );
    // the tyre that the log names is not lost with the second way's place
    let details = |i: usize| -> Vec<String> {
        all[i].shown(&rides).lines.into_iter().map(|line| line.detail).collect()
    };
    let both = details(2);
    assert!(!both[0].contains("rear tyre soft"), "{both:?}");
    assert!(both[1].starts_with("Since s07 (2026-05-08, rear tyre soft). "), "{both:?}");
    // of the same rides it says nothing twice
    assert!(!details(3).concat().contains("s10"));
}

#[test]
fn entries_of_other_rides_or_other_quantities_stay_apart() {
    let rides = rides(12, 7);
    let swap = event("tyre_swap", "rear", "rear mf_d", 7, 11);
    let apart = |row: ChangeRow| entries(&[row], std::slice::from_ref(&swap), &rides).len();
    let friction = "mf_d_rear 0.1 (t 9.0)";
    assert_eq!(apart(change("since", 7, 5, "mf_d_rear", friction)), 1);
    assert_eq!(apart(change("since", 4, 8, "mf_d_rear", friction)), 2, "another date");
    assert_eq!(apart(change("ride", 7, 1, "mf_d_rear", friction)), 2, "one ride only");
    assert_eq!(apart(change("drift", 0, 12, "mf_d_rear", friction)), 2, "a drift");
    assert_eq!(apart(change("since", 7, 5, "mf_d_front", "mf_d_front 0.1 (t 9.0)")), 2);
    // a rider who rides every third ride is no stretch of rides
    let anna = ChangeRow {
        in_common: Some("rider anna".into()),
        ..change("rider", 1, 4, "mf_d_rear", friction)
    };
    assert_eq!(Evidence::of_change(&anna, &rides).members.iter().filter(|m| **m).count(), 4);
    assert_eq!(apart(anna), 2);
}

#[test]
fn a_drift_of_both_ways_is_one_entry_at_its_first_ride() {
    let rides = rides(12, 12);
    let events = [event("drift", "rear", "rear mf_d", 0, 11)];
    let changes = [
        change("ride", 0, 1, "latency", "latency 60 ms (t 9.0)"),
        change("drift", 0, 12, "mf_d_rear", "mf_d_rear 0.1 (t 9.0)"),
    ];
    let all = entries(&changes, &events, &rides);
    assert_eq!(all.len(), 2);
    assert_eq!((all[0].place(), all[0].evidence.len()), ("over 12 rides".to_owned(), 2));
}

/// Which coefficients an effect moves follows from what it declares to act on.
#[test]
fn effects_move_the_coefficients_that_they_act_on() {
    let of = |name: &str, tyre: &str, coefficient: &str| {
        moves(Effect::named(name).expect("an effect"), tyre, coefficient)
    };
    assert!(of("rider_lean", "vehicle", "overturning_stiffness"));
    assert!(!of("rider_lean", "front", "mf_d"), "the roll balance has no friction curve");
    assert!(of("side_force_ratio_front", "front", "cornering_stiffness_0"));
    assert!(!of("side_force_ratio_front", "rear", "cornering_stiffness_0"), "the other tyre");
    assert!(of("wind", "vehicle", "drag"));
    let number = |name: &str| Quantity::Number(name.to_owned());
    let drag = Quantity::Coefficient { tyre: "vehicle".into(), name: "drag".into() };
    assert!(are_related(&[number("drag")], std::slice::from_ref(&drag)));
    // sizes of effects that merely move along do not count
    assert!(!are_related(&[number("radius_front"), number("wind")], std::slice::from_ref(&drag)));
}

#[test]
fn a_time_line_marks_the_rides_and_the_date_of_a_change() {
    let rides = rides(10, 10);
    let value = |k: usize| if k >= 6 { 2.0 } else { 1.0 };
    let series = Series {
        title: "Wind".into(),
        key: "wind".into(),
        unit: "m/s".into(),
        source: "size of the effect alone",
        points: (0..10)
            .map(|k| Point {
                ride: k,
                value: value(k),
                ends: [value(k) - 0.1, value(k) + 0.1],
                is_determined: k != 9,
            })
            .collect(),
    };
    let mark = |first: usize, label: &str| Mark {
        members: (0..10).map(|k| k >= first).collect(),
        is_drift: false,
        label: label.into(),
    };
    let line = draw(&series, &rides, &[mark(6, "wind"), mark(6, "tyre swap")]).expect("ten rides");
    let count = |path: &str| path.matches('M').count();
    assert_eq!(line.rides.each_ref().map(|p| count(p)), [6, 3, 1]);
    assert_eq!(line.intervals.each_ref().map(|p| count(p)), [6, 4]);
    // one line for both causes, at the sixth of nine days
    let [rule] = &line.rules[..] else { panic!("{:?}", line.rules) };
    assert_eq!(rule.label, "wind, tyre swap");
    assert!(rule.path.starts_with("M252.0 "), "{}", rule.path);
    // the level before and the level after, on the ordinate from 0.87 to 2.13
    assert!(line.levels.contains("M252.0") && line.levels.contains("M52.0"), "{}", line.levels);
    assert_eq!(line.hints[6].text, "s06 (2026-05-07): 2.00 m/s (1.90 to 2.10)");
    assert_eq!(
        (line.dates[0].label.as_str(), line.dates[1].label.as_str()),
        ("2026-05-01", "2026-05-10")
    );
    let few = Series { points: series.points[..1].to_vec(), ..series };
    assert!(draw(&few, &rides, &[]).is_none());
}
