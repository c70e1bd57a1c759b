//! A changed tyre as the cause of a step.
//!
//! ```text
//! of the same rides    several numbers of one tyre differ, nothing else does, and it is a step, no slope
//!                      or one number differs, and the logs say another tyre
//! ```
//!
//! No single number is that of a tyre of another model: radius, crown, friction and stiffness all differ. The search reports the
//! surest of them as a change whose cause is not known, with the others or their remainders beside it. Here they become one change.
//! A single ride is never one on another tyre: such a ride has the log of another motorcycle, or an odd sensor. A worn tyre
//! drifts. One radius alone is not enough, unless the log says more: a pressure or another scale of the wheel's speed moves it, too.

use std::collections::BTreeSet;

use super::numbers::History;
use super::search::{Change, LISTED, MOVED, Moved, NEAR, SHADOW};
use super::sets::{Kind, Rides};
use super::sums::AllRides;
use crate::contract::bike::Axle;
use crate::contract::fleet_event::Affected;
use crate::contract::instant;
use crate::simulate::effects::Effect;

/// Rides from which on a change is a tyre's where no log says so, as for events of coefficients.
const LASTING: usize = 3;
/// Numbers of one tyre, without its end.
const OF_TYRE: [&str; 7] =
    ["radius", "mf_b", "mf_d", "mf_e1", "mf_e2", "cornering_stiffness", "stiffness_decay"];
/// Numbers of the crowns of both tyres.
const CROWN: [&str; 2] = ["overturning_stiffness", "crown_ratio"];
/// Further numbers that a tyre moves, and its pressure too.
const ALSO: [&str; 4] =
    ["deflection_share", "slip_stiffness_load", "vertical_stiffness_front", "rolling_resistance"];

/// The tyre that a number of the nominal model is of.
fn axle_of(name: &str) -> Option<Axle> {
    let is_of = |axle: &Axle| {
        let bare = name.strip_suffix(axle.name()).and_then(|bare| bare.strip_suffix('_'));
        bare.is_some_and(|bare| OF_TYRE.contains(&bare))
    };
    Axle::BOTH.into_iter().find(is_of)
}

/// Whether a tyre moves a number that is of both.
fn is_shared(name: &str) -> bool {
    CROWN.contains(&name) || ALSO.contains(&name)
}

/// Changes of a motorcycle, those that a changed tyre explains as one each, where the first of them was.
pub(crate) fn explained(history: &History, mut changes: Vec<Change>) -> Vec<Change> {
    let mut sets: Vec<Rides> = Vec::new();
    for change in &changes {
        if !sets.contains(&change.rides) {
            sets.push(change.rides.clone());
        }
    }
    for rides in sets {
        let own: Vec<&Change> = changes.iter().filter(|c| c.rides == rides).collect();
        let Some(swap) = Swap::of(history, &own) else { continue };
        // the remainder of a large step can begin a ride or two beside it
        let is_part = |c: &Change| is_near(&c.rides, &rides) && swap.includes(history, c);
        let Some(at) = changes.iter().position(is_part) else { continue };
        let (parts, mut others): (Vec<Change>, Vec<Change>) =
            changes.into_iter().partition(is_part);
        match swap.merged(history, &parts) {
            Some(change) => others.insert(at, change),
            None => others.extend(parts),
        }
        changes = others;
    }
    changes
}

/// A changed tyre with what shows it.
struct Swap {
    rides: Rides,
    affected: Affected,
    /// The surest numbers of the tyre.
    moved: Vec<Moved>,
    /// Size over its error of the surest.
    clearest: f64,
}

impl Swap {
    /// The changes that it explains as one: the surest of its own with all that moved.
    fn merged(&self, history: &History, parts: &[Change]) -> Option<Change> {
        let chance = parts.iter().map(|c| c.chance).fold(1.0, f64::min);
        let is_own = |c: &&Change| self.is_own(&history.numbers[c.cause].name);
        let surest = parts.iter().filter(|c| c.rides == self.rides).find(is_own)?.clone();
        Some(Change {
            rivals: Vec::new(),
            moved: self.moved.clone(),
            chance,
            swap: Some(self.affected),
            ..surest
        })
    }

    /// What changes of the same rides show; `None` where it is not a tyre.
    fn of(history: &History, own: &[&Change]) -> Option<Swap> {
        let rides = &own.first()?.rides;
        if matches!(rides.kind, Kind::One | Kind::Drift) {
            return None;
        }
        let numbers = AllRides::new(history).differences(rides);
        let known = numbers.iter().enumerate().filter_map(|(number, d)| {
            let by = (*d)?;
            (by.chance() < MOVED).then_some(Moved { number, by })
        });
        let mut moved: Vec<Moved> = known.collect();
        // sizes of effects follow from the numbers that moved
        moved.retain(|m| history.numbers[m.number].effect.is_none());
        moved.sort_by(|a, b| a.by.chance().total_cmp(&b.by.chance()));
        let name = |m: &Moved| history.numbers[m.number].name.as_str();
        let is_reported = |axle: Axle| {
            let is_it = |c: &&Change| {
                let number = &history.numbers[c.cause];
                number.effect.is_none() && axle_of(&number.name) == Some(axle)
            };
            own.iter().any(is_it)
        };
        let of_axle =
            |axle: Axle| moved.iter().filter(move |m| axle_of(name(m)) == Some(axle)).count();
        let is_radius =
            |axle: Axle| moved.iter().any(|m| name(m) == format!("radius_{}", axle.name()));
        let is_crown = moved.iter().any(|m| CROWN.contains(&name(m)));
        let axles: Vec<Axle> = Axle::BOTH.into_iter().filter(|axle| is_reported(*axle)).collect();
        let is_said = |axle: &Axle| is_said(history, rides, *axle);
        let said: Vec<Axle> = axles.iter().copied().filter(is_said).collect();
        let is_several = |axle: Axle| match axles.len() {
            // another scale of the speed moves both radii
            2 => of_axle(axle) > 1,
            _ => of_axle(axle) > 1 || is_radius(axle) && is_crown,
        };
        // a rider or a site is no tyre, unless the logs say so
        let is_lasting = matches!(rides.kind, Kind::Since | Kind::Chosen);
        let axles = match said.is_empty() {
            false => said.clone(),
            true if is_lasting && axles.iter().all(|axle| is_several(*axle)) => axles,
            true => return None,
        };
        let affected = match axles.as_slice() {
            [Axle::Front] => Affected::Front,
            [Axle::Rear] => Affected::Rear,
            [_, _] => Affected::Both,
            _ => return None,
        };
        let is_own = |m: &Moved| axle_of(name(m)).is_some_and(|axle| affected.includes(axle));
        let is_tyre = |m: &Moved| is_own(m) || is_shared(name(m));
        let clearest = moved.iter().filter(|m| is_own(m)).map(clear).fold(0.0, f64::max);
        let listed = moved.iter().filter(|m| is_tyre(m)).take(LISTED).cloned().collect();
        let surest = moved.iter().find(|m| is_own(m))?.number;
        let swap = Swap { rides: rides.clone(), affected, moved: listed, clearest };
        if said.is_empty() {
            // a number that is much less clear moved along with the tyre's surest
            let is_alone = moved.iter().all(|m| is_tyre(m) || clear(m) < SHADOW * clearest)
                && own.iter().all(|c| swap.includes(history, c));
            if rides.counts()[0] < LASTING || !is_alone || !is_step(history, rides, surest) {
                return None;
            }
        }
        Some(swap)
    }

    /// Whether a number of the nominal model is that of a changed tyre.
    fn is_own(&self, name: &str) -> bool {
        axle_of(name).is_some_and(|axle| self.affected.includes(axle))
    }

    /// Whether a change of these rides is of the changed tyre: of its number, of what describes a tyre, or of what moves the same
    /// numbers. The last must be less clear than the tyre's surest number: a rider who leans moves the crown, but no radius.
    fn includes(&self, history: &History, change: &Change) -> bool {
        let number = &history.numbers[change.cause];
        let Some(effect) = number.effect else {
            return self.is_own(&number.name) || is_shared(&number.name);
        };
        let is_its =
            |effect: &Effect| effect.tyres.iter().any(|axle| self.affected.includes(*axle));
        let is_alike = |name: &&'static str| self.is_own(name) || CROWN.contains(name);
        is_its(effect)
            || effect.confounded_with.iter().any(is_alike) && change.t.abs() < self.clearest
    }
}

/// Size over its error, without its sign.
fn clear(m: &Moved) -> f64 {
    m.by.t().abs()
}

/// Whether the logs say that these rides, and no others, are on other tyres at one end.
fn is_said(history: &History, rides: &Rides, axle: Axle) -> bool {
    let tyre = |i: usize| {
        let around = &history.circumstances[i];
        let name = match axle {
            Axle::Front => around.tyre_front.as_deref(),
            Axle::Rear => around.tyre_rear.as_deref(),
        };
        name.filter(|name| !name.is_empty())
    };
    let of = |is_in: bool| -> Option<BTreeSet<&str>> {
        (0..history.len()).filter(|i| rides.has(*i) == is_in).map(tyre).collect()
    };
    of(true).zip(of(false)).is_some_and(|(inside, others)| inside.is_disjoint(&others))
}

/// Whether two sets are the same, or steps that begin at almost the same ride.
fn is_near(a: &Rides, b: &Rides) -> bool {
    let is_step = a.kind == Kind::Since && b.kind == Kind::Since;
    a == b || is_step && a.first().abs_diff(b.first()) <= NEAR
}

/// Whether a number is nearer to two levels than to a line over time, which a worn tyre has.
fn is_step(history: &History, rides: &Rides, number: usize) -> bool {
    if rides.kind != Kind::Since {
        return true;
    }
    let values = &history.values[number];
    let time = |i: usize| {
        let start = history.rides[i].start_time.as_deref();
        start.and_then(instant::microseconds).map_or(i as f64, |t| t as f64 * 1e-6)
    };
    let known: Vec<usize> = (0..values.len()).filter(|i| values[*i].is_finite()).collect();
    let left = |x: &dyn Fn(usize) -> f64| {
        let mean = |of: &dyn Fn(usize) -> f64| {
            known.iter().map(|i| of(*i)).sum::<f64>() / known.len() as f64
        };
        let (mx, my) = (mean(x), mean(&|i| values[i]));
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            known.iter().map(|i| of(x(*i) - mx, values[*i] - my)).sum()
        };
        let [xx, xy, yy] = [sum(&|x, _| x * x), sum(&|x, y| x * y), sum(&|_, y| y * y)];
        if xx > 0.0 { yy - xy * xy / xx } else { yy }
    };
    // at two times both are the same line
    left(&|i| rides.share(i)) <= left(&time) * (1.0 + 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::reference::changes;
    use crate::diagnose::reference::numbers::Ride;
    use crate::statistics::random::Random;
    use crate::store::tables::changes::{is_change, place};
    use crate::store::tables::rows::{ChangeRow, Circumstances, EffectTrace, EstimateRow, Ident};

    /// Numbers with their standard errors, and an effect that has the crown's trace.
    const NUMBERS: [(&str, f64); 9] = [
        ("radius_front", 1e-4),
        ("radius_rear", 1e-4),
        ("cornering_stiffness_front", 0.02),
        ("cornering_stiffness_rear", 0.02),
        ("mf_d_front", 0.01),
        ("overturning_stiffness", 1e-3),
        ("drag", 1e-3),
        ("brake_gain_front", 5e-7),
        ("rider_lean", 0.01),
    ];
    const FRONT: [(&str, f64); 3] = [
        ("radius_front", -30.0),
        ("cornering_stiffness_front", -9.0),
        ("overturning_stiffness", 12.0),
    ];

    /// A ride with numbers off by so many standard errors.
    fn ride(seed: u64, k: usize, off: &[(&str, f64)]) -> Ride {
        let ident = Ident {
            session_id: format!("s{k:02}"),
            bike_id: "a".into(),
            start_time: Some(format!("2026-05-{:02}T10:00:00Z", k + 1)),
        };
        let mut random = Random::new(seed, &format!("tyre {k}"));
        let row = |(name, std_error): &(&str, f64)| EstimateRow {
            ident: ident.clone(),
            parameter: (*name).to_owned(),
            part: if *name == "rider_lean" { "effect" } else { "nominal" }.to_owned(),
            unit: "1".to_owned(),
            value: std_error
                * (30.0
                    + random.normal()
                    + off.iter().filter(|(n, _)| n == name).map(|(_, size)| size).sum::<f64>()),
            std_error: *std_error,
        };
        let estimates = NUMBERS.iter().map(row).collect();
        let trace = |(name, slope): (&str, f64)| EffectTrace {
            ident: ident.clone(),
            effect: "rider_lean".to_owned(),
            parameter: name.to_owned(),
            slope,
        };
        let traces = [("rider_lean", 1.0), ("overturning_stiffness", -0.9)].map(trace).to_vec();
        Ride { ident, circumstances: Circumstances::default(), estimates, traces }
    }

    /// The changes of so many rides.
    fn found(n: usize, of: impl Fn(usize) -> Ride) -> Vec<ChangeRow> {
        changes((0..n).map(of).collect()).into_iter().filter(is_change).collect()
    }

    #[test]
    fn several_numbers_of_one_tyre_since_a_date_are_another_tyre() {
        let mut right = 0;
        for seed in 0..20 {
            let rows = found(14, |k| ride(seed, k, if k >= 8 { &FRONT } else { &[] }));
            let is_swap = |r: &&ChangeRow| r.cause.as_deref() == Some("tyre_swap_front");
            let Some(row) = rows.iter().find(is_swap) else { continue };
            // one in twenty motorcycles may have a false change beside it
            right += usize::from(rows.len() == 1 && place(row) == "since s08 (2026-05-09)");
            assert_eq!(row.verdict, "named");
            // what moved has sizes, a tyre has none
            assert_eq!((row.value, row.ci95_low, row.unit.as_deref()), (None, None, None));
            let moved = row.moved.as_deref().unwrap_or_default();
            assert!(FRONT.iter().all(|(name, _)| moved.contains(name)), "{moved}");
            assert!(row.sentence.starts_with("the front rolling radius differs by -"), "{row:?}");
            assert!(row.sentence.ends_with("as if another front tyre was fitted"), "{row:?}");
        }
        assert!(right >= 17, "{right} of 20");
    }

    /// The log names the tyre: its radius alone is enough.
    #[test]
    fn one_number_is_a_tyre_where_the_log_says_so() {
        let of = |seed: u64, k: usize, is_said: bool| {
            let mut ride = ride(seed, k, if k >= 8 { &[("radius_rear", -40.0)] } else { &[] });
            let tyre = if is_said && k >= 8 { "B" } else { "A" };
            ride.circumstances.tyre_rear = Some(tyre.to_owned());
            ride
        };
        let cause = |is_said: bool| {
            let rows = found(12, |k| of(3, k, is_said));
            let [row] = &rows[..] else { panic!("{rows:#?}") };
            (place(row), row.cause.clone(), row.verdict.clone())
        };
        let said = ("since s08 (2026-05-09, rear tyre B)", "tyre_swap_rear", "named");
        let (place, key, verdict) = cause(true);
        assert_eq!((place.as_str(), key.as_deref().unwrap_or_default(), verdict.as_str()), said);
        // else it may be its pressure, or the scale of its wheel's speed
        let (_, key, verdict) = cause(false);
        assert_eq!((key.as_deref(), verdict.as_str()), (Some("radius_rear"), "changed"));
    }

    /// A tyre does not change for one ride, nor bit by bit, nor with the brakes, nor with the scale of the speed.
    #[test]
    fn what_else_moves_a_tyres_numbers_is_no_other_tyre() {
        let with = |more: &[(&'static str, f64)]| [&FRONT[..], more].concat();
        let radii = [("radius_front", -30.0), ("radius_rear", -30.0)];
        let brakes = with(&[("brake_gain_front", -40.0)]);
        let is_swap = |rows: &[ChangeRow]| {
            let is_it = |r: &ChangeRow| {
                r.cause.as_deref().is_some_and(|c| Affected::of_swap_key(c).is_some())
            };
            rows.iter().any(is_it)
        };
        let mut seen = [0; 5];
        for seed in 0..20 {
            let part = |k: usize| k as f64 / 13.0;
            let worn: Vec<Vec<(&str, f64)>> = (0..14)
                .map(|k| FRONT.iter().map(|(n, size)| (*n, size * part(k))).collect())
                .collect();
            let all = [
                found(14, |k| ride(seed, k, if k == 8 { &FRONT } else { &[] })),
                found(14, |k| ride(seed, k, &worn[k])),
                found(5, |k| ride(seed, k, &worn[3 * k])),
                found(14, |k| ride(seed, k, if k >= 8 { &brakes } else { &[] })),
                found(14, |k| ride(seed, k, if k >= 8 { &radii } else { &[] })),
            ];
            for (count, rows) in seen.iter_mut().zip(&all) {
                assert!(!is_swap(rows), "{seed}: {rows:#?}");
                *count += usize::from(!rows.is_empty());
            }
        }
        // they are reported as something else
        assert!([0, 1, 3, 4].iter().all(|i| seen[*i] == 20), "{seen:?}");
    }

    /// Both tyres at one date and a brake at another.
    #[test]
    fn both_tyres_are_one_change_and_another_date_is_another() {
        let rear = [("radius_rear", 90.0), ("cornering_stiffness_rear", 12.0)];
        let both = [&FRONT[..], &rear].concat();
        let braked = [&both[..], &[("brake_gain_front", -60.0)]].concat();
        let rows = found(16, |k| {
            ride(
                5,
                k,
                if k >= 11 {
                    &braked
                } else if k >= 6 {
                    &both
                } else {
                    &[]
                },
            )
        });
        let causes: Vec<_> = rows.iter().map(|r| r.cause.clone().unwrap_or_default()).collect();
        assert_eq!(causes, ["tyre_swap_both", "brake_gain_front"], "{rows:#?}");
    }
}
