//! The tyres of a fleet: which was on a wheel when, what all its rides say of it, and each tyre model over the motorcycles.
//!
//! A tyre is another one after a swap that the rolling radius shows ([`changes`](super::changes)) or where the logs name
//! another model. Sessions that an event calls outliers, or ridden by a wrong bike file, take no part in what it moved.
//!
//! A model is what its tyres have in common: `y_b = theta + b_b + e_b` with the spread `b` between tyres by
//! DerSimonian and Laird (1986), as logarithms where all are of one sign. What is wrong with a number of the tyre in the bike
//! files, with a rule or with the model is wrong on every motorcycle alike and does not average out; a motorcycle's own numbers do.

use std::collections::BTreeMap;

use super::analysis::BikeAnalysis;
use super::combine::{Estimate, Key, Ride, Shared, combine};
use super::events::Event;
use super::evidence::Piece;
use super::ratio;
use crate::contract::bike::Axle;
use crate::contract::coefficient::Coefficient;
use crate::contract::error_source::MODEL;
use crate::contract::fleet_event::EventKind;
use crate::statistics::interval::t95;
use crate::statistics::order;

/// Spread between tyres of one model where there are too few to tell, a share.
const BETWEEN_TYRES: f64 = 0.02;
/// The same of a rolling radius: a tread of 5 mm that wears from a radius of 0.3 m, pressure and tolerance, an estimate.
const BETWEEN_RADII: f64 = 0.01;
/// Tyres that an assumed spread counts for, as rides do in [`compare`](super::compare).
const ASSUMED: f64 = 3.0;
/// Fewest tyres that tell it.
const TYRES: usize = 4;

/// One coefficient of one tyre on one motorcycle, over all its rides.
#[derive(Debug, Clone, PartialEq)]
pub struct OnBike {
    /// Value over all rides, with interval.
    pub estimate: Estimate,
    /// Tyre model, where the logs name it.
    pub model: Option<String>,
    /// Unit of the coefficient.
    pub unit: String,
    /// First and last session on that tyre.
    pub sessions: [String; 2],
}

/// A motorcycle's tyres and what its rides say of its own numbers.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BikeTyres {
    /// Id of the bike.
    pub bike: String,
    /// Coefficients of its tyres, and its own.
    pub tyres: Vec<OnBike>,
    pub shared: Vec<Shared>,
    /// Sessions that took part.
    pub rides: usize,
    /// Whether each coefficient is its rides' median, because together they could not be solved.
    pub alone: bool,
}

/// A tyre model over the motorcycles.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// Tyre, `front` or `rear`.
    pub tyre: String,
    /// Tyre model, as the logs give it.
    pub model: String,
    /// Name of the coefficient in the tables.
    pub coefficient: String,
    /// Unit of the coefficient.
    pub unit: String,
    /// Mean over the tyres of that model, in `unit`.
    pub value: f64,
    pub std_error: f64,
    /// Ends of the 95 % interval.
    pub interval: [f64; 2],
    /// Tyres that took part, and their rides.
    pub tyres: usize,
    pub rides: usize,
    /// Spread between tyres beyond their errors.
    pub between: f64,
    /// Median of the tyres.
    pub median: f64,
}

/// Combines the rides of a motorcycle.
pub fn of_bike(bike: &BikeAnalysis, pieces: &[Piece]) -> BikeTyres {
    let history = &bike.history;
    let place: BTreeMap<&str, usize> =
        history.sessions.iter().enumerate().map(|(i, s)| (s.as_str(), i)).collect();
    let specimens = Axle::BOTH.map(|axle| specimens(bike, axle, pieces, &place));
    let specimen = |piece: &Piece, at: usize| {
        let axle = Axle::BOTH.iter().position(|a| a.name() == piece.tyre);
        axle.map_or(0, |a| specimens[a][at])
    };
    let mut rides: BTreeMap<usize, Ride<'_>> = BTreeMap::new();
    for piece in pieces {
        let Some(&at) = place.get(piece.session.as_str()) else { continue };
        let column =
            history.keys.iter().position(|k| k.0 == piece.tyre && k.1 == piece.coefficient);
        if column.is_some_and(|c| bike.events.iter().any(|e| excludes(e, c, at))) {
            continue;
        }
        let key = Key {
            tyre: piece.tyre.clone(),
            specimen: specimen(piece, at),
            coefficient: piece.coefficient.clone(),
        };
        let ride = rides.entry(at).or_default();
        ride.session = &piece.session;
        ride.pieces.push((key, piece));
    }
    let mut rides: Vec<Ride<'_>> = rides.into_values().collect();
    rides.iter_mut().for_each(|r| r.pieces.sort_by(|a, b| a.0.cmp(&b.0)));
    let found = combine(&rides);
    let tyres = found.estimates.into_iter().filter_map(|estimate| {
        let own = |p: &&(Key, &Piece)| p.0 == estimate.key;
        let mut of_key = rides.iter().filter_map(|r| Some((r, r.pieces.iter().find(own)?.1)));
        let (first, piece) = of_key.next()?;
        let last = of_key.next_back().map_or(first, |l| l.0);
        Some(OnBike {
            model: piece.tyre_model.clone(),
            unit: piece.unit.clone(),
            sessions: [first.session.to_owned(), last.session.to_owned()],
            estimate,
        })
    });
    BikeTyres {
        bike: bike.bike.clone(),
        tyres: tyres.collect(),
        shared: found.shared,
        rides: rides.len(),
        alone: found.alone,
    }
}

/// Whether an event takes a session out of a coefficient.
fn excludes(event: &Event, column: usize, session: usize) -> bool {
    matches!(event.kind, EventKind::Outlier | EventKind::BikeFile)
        && event.affects(column)
        && event.sessions().contains(&session)
}

/// Which of the tyres of an axle was on in each session of the history.
fn specimens(
    bike: &BikeAnalysis,
    axle: Axle,
    pieces: &[Piece],
    place: &BTreeMap<&str, usize>,
) -> Vec<usize> {
    let n = bike.history.sessions.len();
    let mut named: Vec<Option<&str>> = vec![None; n];
    for piece in pieces.iter().filter(|p| p.tyre == axle.name()) {
        if let (Some(&at), Some(model)) = (place.get(piece.session.as_str()), &piece.tyre_model) {
            named[at] = Some(model);
        }
    }
    let mut swapped = vec![0; n];
    for (group, sessions) in ratio::tyres(&bike.history, &bike.events, axle).iter().enumerate() {
        sessions.iter().for_each(|i| swapped[*i] = group);
    }
    let mut known: Vec<(usize, Option<&str>)> = Vec::new();
    (0..n)
        .map(|i| {
            let this = (swapped[i], named[i]);
            known.iter().position(|k| *k == this).unwrap_or_else(|| {
                known.push(this);
                known.len() - 1
            })
        })
        .collect()
}

/// Every tyre model of which there is a name.
pub fn models(bikes: &[BikeTyres]) -> Vec<Model> {
    let mut groups: BTreeMap<(&str, &str, &str), Vec<&OnBike>> = BTreeMap::new();
    for tyre in bikes.iter().flat_map(|b| &b.tyres) {
        let Some(model) = &tyre.model else { continue };
        let key = &tyre.estimate.key;
        groups.entry((&key.tyre, model, &key.coefficient)).or_default().push(tyre);
    }
    groups.into_iter().filter_map(|(key, tyres)| model(key, &tyres)).collect()
}

/// Whether a shared error is the same on every motorcycle with a tyre of the model: all but the motorcycle's own numbers.
fn common(source: &str) -> bool {
    // METHOD: how much of the model's error is the motorcycle's and how much the tyre's no fleet has shown; the safe side
    let assumed =
        [MODEL, "crown_split", "trail_rule", "slip_difference", "roll_scale", "pitch_gyration"];
    assumed.contains(&source) || source.starts_with("front.") || source.starts_with("rear.")
}

/// Variance that shared errors of all tyres add to their weighted mean, beyond their part in each tyre.
fn in_common(tyres: &[&OnBike], weights: &[f64], one_sign: bool) -> f64 {
    let mut sums: BTreeMap<&str, (f64, f64)> = BTreeMap::new();
    for (tyre, weight) in tyres.iter().zip(weights) {
        let size = if one_sign { tyre.estimate.value } else { 1.0 };
        for (source, part) in tyre.estimate.parts.iter().filter(|p| common(&p.0)) {
            let part = weight * part / size;
            let sum = sums.entry(source).or_default();
            *sum = (sum.0 + part, sum.1 + part * part);
        }
    }
    let total: f64 = weights.iter().sum();
    sums.values().map(|(sum, squares)| (sum * sum - squares).max(0.0)).sum::<f64>()
        / (total * total)
}

fn model((tyre, name, coefficient): (&str, &str, &str), tyres: &[&OnBike]) -> Option<Model> {
    let value = |t: &&&OnBike| t.estimate.value;
    let one_sign = tyres.iter().all(|t| value(&t) > 0.0) || tyres.iter().all(|t| value(&t) < 0.0);
    let sign = tyres.first()?.estimate.value.signum();
    let scale = |t: &OnBike| match one_sign {
        true => ((sign * t.estimate.value).ln(), t.estimate.std_error / t.estimate.value.abs()),
        false => (t.estimate.value, t.estimate.std_error),
    };
    let tyres: Vec<&OnBike> = tyres
        .iter()
        .copied()
        .filter(|t| scale(t).0.is_finite() && scale(t).1.is_finite() && scale(t).1 > 0.0)
        .collect();
    let scaled: Vec<(f64, f64)> = tyres.iter().map(|t| scale(t)).collect();
    let n = scaled.len();
    if n == 0 {
        return None;
    }
    let mean = |tau2: f64| {
        let weights: f64 = scaled.iter().map(|(_, sd)| 1.0 / (sd * sd + tau2)).sum();
        let sum: f64 = scaled.iter().map(|(y, sd)| y / (sd * sd + tau2)).sum();
        (sum / weights, 1.0 / weights)
    };
    let tau2 = if n >= TYRES {
        let (at, _) = mean(0.0);
        let q: f64 = scaled.iter().map(|(y, sd)| ((y - at) / sd).powi(2)).sum();
        let [w, w2] = [1, 2].map(|p| scaled.iter().map(|(_, sd)| sd.powi(-2 * p)).sum::<f64>());
        ((q - (n as f64 - 1.0)) / (w - w2 / w)).max(0.0)
    } else {
        let is_radius = coefficient == Coefficient::EffectiveRollingRadius.name();
        let share = if is_radius { BETWEEN_RADII } else { BETWEEN_TYRES };
        (if one_sign { share } else { share * scaled[0].0.abs() }).powi(2)
    };
    let (y, own) = mean(tau2);
    let weights: Vec<f64> = scaled.iter().map(|(_, sd)| 1.0 / (sd * sd + tau2)).collect();
    let common = in_common(&tyres, &weights, one_sign);
    let variance = own + common;
    let half = if n >= TYRES {
        t95(n as f64 + 1.0) * variance.sqrt()
    } else {
        // the spread alone is assumed; a tyre's own interval is as sure as its rides made it
        let of_tyre = |tyre: &OnBike| {
            let ([low, high], sd) = (tyre.estimate.interval, scale(tyre).1);
            let half = if one_sign { 0.5 * (high / low).ln().abs() } else { 0.5 * (high - low) };
            // no logarithm of an interval around zero
            half.max(t95(f64::INFINITY) * sd)
        };
        let total: f64 = weights.iter().sum();
        let squares = weights.iter().map(|w| (w / total).powi(2)).sum::<f64>();
        let spread = t95(n as f64 - 1.0 + ASSUMED) * (tau2 * squares).sqrt();
        let of_tyres = tyres.iter().zip(&weights).map(|(t, w)| (w / total * of_tyre(t)).powi(2));
        let of_common = t95(f64::INFINITY) * common.sqrt();
        (spread * spread + of_tyres.sum::<f64>() + of_common * of_common).sqrt()
    };
    let back = |y: f64| if one_sign { sign * y.exp() } else { y };
    let (low, high) = (back(y - half), back(y + half));
    let size = if one_sign { back(y).abs() } else { 1.0 };
    let mut values: Vec<f64> = tyres.iter().map(|t| t.estimate.value).collect();
    Some(Model {
        tyre: tyre.to_owned(),
        model: name.to_owned(),
        coefficient: coefficient.to_owned(),
        unit: tyres[0].unit.clone(),
        value: back(y),
        std_error: variance.sqrt() * size,
        interval: [low.min(high), low.max(high)],
        tyres: n,
        rides: tyres.iter().map(|t| t.estimate.rides).sum(),
        between: tau2.sqrt() * size,
        median: order::median(&mut values)?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::error_source::OWN;
    use crate::fleet::{Observation, analyse};
    use crate::statistics::random::Random;

    /// Sessions of one bike: value of each of the coefficients (tyre, name, level) in each session.
    struct Sessions {
        rows: Vec<Observation>,
        pieces: Vec<Piece>,
    }

    const ERROR: f64 = 0.01;

    fn sessions(
        n: usize,
        keys: &[(&str, &str, f64)],
        factor: impl Fn(usize, usize) -> f64,
        model: impl Fn(usize) -> Option<&'static str>,
    ) -> Sessions {
        let mut random = Random::new(3, "tyres");
        let mut out = Sessions { rows: Vec::new(), pieces: Vec::new() };
        for i in 0..n {
            for (k, (tyre, coefficient, level)) in keys.iter().enumerate() {
                let value = level * factor(k, i) * (1.0 + ERROR * random.normal());
                let session = format!("s{i:02}");
                out.rows.push(Observation {
                    bike: "b".into(),
                    tyre: (*tyre).into(),
                    coefficient: (*coefficient).into(),
                    session: session.clone(),
                    day: Some(20_000.0 + i as f64),
                    value,
                    error: ERROR * value,
                    determined: true,
                    ..Observation::default()
                });
                let piece = |source: &str, shared, shift: f64| Piece {
                    session: session.clone(),
                    tyre: (*tyre).into(),
                    tyre_model: model(i).map(str::to_owned),
                    coefficient: (*coefficient).into(),
                    value,
                    source: source.into(),
                    shared,
                    shift: shift * value,
                    ..Piece::default()
                };
                out.pieces.extend([piece(OWN, false, ERROR), piece(MODEL, true, 0.02)]);
            }
        }
        out
    }

    fn combined(sessions: &Sessions) -> BikeTyres {
        of_bike(&analyse(&sessions.rows)[0], &sessions.pieces)
    }

    fn of<'a>(found: &'a BikeTyres, coefficient: &str) -> Vec<&'a OnBike> {
        found.tyres.iter().filter(|t| t.estimate.key.coefficient == coefficient).collect()
    }

    const FRONT: [(&str, &str, f64); 2] =
        [("front", "effective_rolling_radius", 0.3), ("front", "mf_d", 1.1)];

    #[test]
    fn a_swap_that_the_radius_shows_is_another_tyre() {
        let found =
            combined(&sessions(40, &FRONT, |_, i| if i < 20 { 1.0 } else { 1.1 }, |_| None));
        let frictions = of(&found, "mf_d");
        assert_eq!(frictions.len(), 2, "{found:?}");
        for (tyre, truth) in frictions.iter().zip([1.1, 1.21]) {
            assert_eq!(tyre.estimate.rides, 20);
            assert!((tyre.estimate.value / truth - 1.0).abs() < 0.01, "{tyre:?}");
        }
        assert_eq!(frictions[1].sessions, ["s20", "s39"]);
    }

    #[test]
    fn a_model_that_the_logs_name_is_another_tyre_and_comes_back() {
        let name = |i: usize| Some(if (10..30).contains(&i) { "b" } else { "a" });
        let found = combined(&sessions(40, &FRONT, |_, _| 1.0, name));
        let frictions = of(&found, "mf_d");
        let named: Vec<_> = frictions.iter().map(|t| t.model.as_deref()).collect();
        assert_eq!(named, [Some("a"), Some("b")], "{found:?}");
        assert!(frictions.iter().all(|t| t.estimate.rides == 20), "{found:?}");
        let all = models(&[found]);
        assert_eq!(all.iter().filter(|m| m.coefficient == "mf_d").count(), 2, "{all:?}");
    }

    #[test]
    fn outlying_sessions_and_those_of_a_wrong_file_take_no_part() {
        let wild = |k: usize, i: usize| if k == 1 && i == 7 { 1.5 } else { 1.0 };
        let found = combined(&sessions(40, &FRONT, wild, |_| None));
        assert_eq!(of(&found, "mf_d")[0].estimate.rides, 39, "{found:?}");
        assert_eq!(of(&found, "effective_rolling_radius")[0].estimate.rides, 40);
        // both axles and the drag move together and no radius
        let keys = [
            ("front", "effective_rolling_radius", 0.3),
            ("front", "mf_d", 1.1),
            ("rear", "mf_d", 1.2),
            ("vehicle", "drag", 0.4),
        ];
        let wrong = |k: usize, i: usize| if k > 0 && (10..22).contains(&i) { 1.15 } else { 1.0 };
        let found = combined(&sessions(40, &keys, wrong, |_| None));
        for coefficient in ["mf_d", "drag", "effective_rolling_radius"] {
            let rides: Vec<usize> =
                of(&found, coefficient).iter().map(|t| t.estimate.rides).collect();
            assert!(rides.iter().all(|n| *n == 28), "{coefficient}: {rides:?}");
        }
        assert!((of(&found, "drag")[0].estimate.value / 0.4 - 1.0).abs() < 0.01);
    }

    /// A night that is added later, or read first, makes no difference.
    #[test]
    fn the_order_in_which_sessions_come_makes_no_difference() {
        let all = sessions(40, &FRONT, |_, i| if i < 20 { 1.0 } else { 1.1 }, |_| None);
        let mut other = Sessions { rows: all.rows.clone(), pieces: all.pieces.clone() };
        other.rows.sort_by(|a, b| b.session.cmp(&a.session));
        other.pieces.sort_by(|a, b| b.session.cmp(&a.session));
        assert_eq!(combined(&all), combined(&other));
    }

    /// Of ten motorcycles with tyres of one model: what is wrong with the model does not average out, their scatter does.
    #[test]
    fn an_error_of_the_tyre_is_the_same_on_every_motorcycle() {
        let one = combined(&sessions(10, &FRONT, |_, _| 1.0, |_| Some("a")));
        let found = models(&vec![one.clone(); 10]);
        let friction = found.iter().find(|m| m.coefficient == "mf_d").expect("a model");
        let relative = friction.std_error / friction.value;
        assert!((0.02..0.0215).contains(&relative), "{friction:?}");
        assert_eq!((friction.tyres, friction.rides), (10, 100));
        // a number of each motorcycle's own does
        let mut own = one;
        for tyre in &mut own.tyres {
            tyre.estimate.parts.iter_mut().for_each(|p| p.0 = "mass".into());
        }
        let found = models(&vec![own; 10]);
        let friction = found.iter().find(|m| m.coefficient == "mf_d").expect("a model");
        assert!(friction.std_error / friction.value < 0.008, "{friction:?}");
    }

    /// One tyre of a model: its own interval, wider by what others of that model may differ, and not more.
    #[test]
    fn a_model_of_one_tyre_is_as_wide_as_the_tyre_and_the_spread() {
        let one = combined(&sessions(10, &FRONT, |_, _| 1.0, |_| Some("a")));
        let half = |[low, high]: [f64; 2]| 0.5 * (high / low).ln();
        for (coefficient, spread) in
            [("effective_rolling_radius", BETWEEN_RADII), ("mf_d", BETWEEN_TYRES)]
        {
            let found = models(std::slice::from_ref(&one));
            let model = found.iter().find(|m| m.coefficient == coefficient).expect("a model");
            let own = half(of(&one, coefficient)[0].estimate.interval);
            let wide = half(model.interval);
            assert_eq!(model.tyres, 1);
            // Student's 97.5 % quantile of three degrees of freedom
            assert!((wide / own.hypot(3.182 * spread) - 1.0).abs() < 0.01, "{own} {model:?}");
        }
        // a second tyre, which is as good, narrows it
        let two = models(&[one.clone(), one]);
        let friction = two.iter().find(|m| m.coefficient == "mf_d").expect("a model");
        assert!(half(friction.interval) < 0.065, "{friction:?}");
    }
}
