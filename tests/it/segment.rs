//! Segments against the simulator's labels.

use std::collections::BTreeMap;

use roadbench::internals::contract::bike::Bike;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::session::{Meta, Session};
use roadbench::internals::filter;
use roadbench::internals::ingest;
use roadbench::internals::segment;
use roadbench::internals::segment::Segment;
use roadbench::internals::segment::manoeuvre::{Direction, ManoeuvreKind};
use roadbench::internals::simulate::{self, Simulated, scenario::Scenario};

/// Seconds found right, found, true; by kind.
type Score = BTreeMap<ManoeuvreKind, [f64; 3]>;

fn add(score: &mut Score, truth: &Simulated, session: &Session, bike: &Bike) {
    let mut session = session.clone();
    filter::run(&mut session, &filter::Config::default());
    let segments = segment::run(&session, bike, &segment::Config::default());
    let mut label = vec![ManoeuvreKind::Other; session.len];
    for &(kind, start, end, _) in &truth.labels {
        let at = |t: f64| ((t * session.rate).round() as usize).min(session.len);
        label[at(start)..at(end)].fill(kind);
    }
    let dt = 1.0 / session.rate;
    let mut confusion: BTreeMap<(ManoeuvreKind, ManoeuvreKind), f64> = BTreeMap::new();
    for s in &segments {
        for kind in &label[s.start..s.end] {
            *confusion.entry((*kind, s.kind)).or_default() += dt;
        }
    }
    for ((truth, found), seconds) in confusion {
        if truth == found {
            score.entry(found).or_default()[0] += seconds;
        } else if seconds > 2.0 {
            println!("  {} as {}: {seconds:.1} s", truth.name(), found.name());
        }
        score.entry(found).or_default()[1] += seconds;
        score.entry(truth).or_default()[2] += seconds;
    }
}

fn f1([right, found, truth]: [f64; 3]) -> f64 {
    2.0 * right / (found + truth)
}

/// Two bikes, each on the paper's plan and on a naturalistic one.
fn sessions() -> Vec<(Bike, Simulated)> {
    let scenario = Scenario::builtin("archive").expect("scenario");
    let mut out = Vec::new();
    for bike in 0..2 {
        let machine = scenario.machine(bike);
        for number in 0..2 {
            let simulated = simulate::session(&scenario, &machine, 6 * bike + number);
            out.push((machine.bike.clone(), simulated));
        }
    }
    out
}

/// F1 by kind, with all channels and without those of hands and feet.
fn scores(sessions: &[(Bike, Simulated)]) -> [BTreeMap<ManoeuvreKind, f64>; 2] {
    let hidden =
        [Channel::BrakePressureFront, Channel::BrakePressureRear, Channel::Throttle, Channel::Gear];
    [&[][..], &hidden[..]].map(|remove| {
        println!("without {remove:?}");
        let mut score = Score::new();
        for (bike, truth) in sessions {
            println!(" {}", truth.session.meta.session_id);
            let mut session = truth.session.clone();
            for &channel in remove {
                session.remove(channel);
            }
            add(&mut score, truth, &session, bike);
        }
        for (kind, seconds) in &score {
            println!("{:18} F1 {:.3} {seconds:.1?}", kind.name(), f1(*seconds));
        }
        score.into_iter().map(|(kind, seconds)| (kind, f1(seconds))).collect()
    })
}

#[test]
fn every_kind_is_found_with_and_without_pedals_and_gears() {
    for score in scores(&sessions()) {
        // the fit finds changes of lean
        let found = |k: &ManoeuvreKind| k.is_on_road() && *k != ManoeuvreKind::ChangingLean;
        for kind in ManoeuvreKind::ALL.iter().copied().filter(found) {
            // the first and last degrees of a bend are labelled `other`, but hardly to be seen
            let least = if kind == ManoeuvreKind::Other { 0.85 } else { 0.95 };
            assert!(score[&kind] >= least, "{}: {:.3}", kind.name(), score[&kind]);
        }
    }
}

/// The two studies' own sensors and plans; minutes.
#[test]
#[ignore = "minutes; prints F1"]
fn more_bikes() {
    for name in ["paper", "naturalistic"] {
        let scenario = Scenario::builtin(name).expect(name);
        let sessions: Vec<_> = (0..4)
            .map(|number| {
                let machine = scenario.machine(number);
                let simulated = simulate::session(&scenario, &machine, number);
                (machine.bike, simulated)
            })
            .collect();
        scores(&sessions);
    }
}

/// A channel over time, s.
type Made = (Channel, fn(f64) -> f64);

/// 60 s at 50 Hz of what a function of time says.
fn made(channels: &[Made]) -> Session {
    let mut session = Session::new(Meta::default(), 50.0, 3000);
    for &(channel, f) in channels {
        session.set(channel, (0..3000).map(|i| f(f64::from(i) / 50.0)).collect());
    }
    session
}

fn bike() -> Bike {
    Scenario::builtin("archive").expect("scenario").machine(0).bike
}

fn cut(session: &Session) -> Vec<Segment> {
    let segments = segment::run(session, &bike(), &segment::Config::default());
    let mut next = 0;
    for s in &segments {
        assert!(s.start == next && s.end > s.start, "not in order, or a hole: {s:?}");
        assert!((0.0..=1.0).contains(&s.quality));
        assert_eq!(s.used, s.reason.is_none(), "{s:?}");
        next = s.end;
    }
    assert!(segments.is_empty() || next == session.len);
    segments
}

#[test]
fn hopeless_sessions_are_told_from_good_ones_without_a_fuss() {
    assert!(cut(&made(&[(Channel::Roll, f64::sin)])).is_empty());
    assert!(cut(&Session::new(Meta::default(), 50.0, 0)).is_empty());
    let mut one = Session::new(Meta::default(), 50.0, 1);
    one.set(Channel::VelocityX, vec![3.0]);
    assert_eq!(cut(&one).len(), 1);
    let nothing = cut(&made(&[(Channel::VelocityX, |_| f64::NAN), (Channel::Gear, |_| f64::NAN)]));
    assert_eq!((nothing.len(), nothing[0].kind), (1, ManoeuvreKind::Other));
    let gap = |t: f64| if (20.0..30.0).contains(&t) { f64::NAN } else { 10.0 };
    let found = cut(&made(&[(Channel::VelocityX, gap)]));
    let other = found.iter().find(|s| s.kind == ManoeuvreKind::Other).expect("the gap");
    assert_eq!((other.start, other.end), (1000, 1500));
    assert_eq!(other.reason.as_deref(), Some("no forward velocity recorded"));
    let all: Vec<Made> =
        Channel::ALL.iter().map(|&c| (c, (|_| f64::NAN) as fn(f64) -> f64)).collect();
    assert_eq!(cut(&made(&all)).len(), 1);
    assert_eq!(cut(&made(&[(Channel::VelocityX, |_| 0.0)]))[0].kind, ManoeuvreKind::Other);
}

/// Beside a gap there is no acceleration; what is missing neither coasts nor carries coasting on.
#[test]
fn coasting_does_not_reach_over_gaps() {
    let bike = bike();
    let rate = 5.0;
    let mut v = vec![20.0];
    for i in 0..300 {
        let last: f64 = v[i];
        let resistance = bike.drag * last * last / bike.mass + 9.81 * bike.rolling_resistance;
        v.push(last - resistance / rate);
    }
    // a second of hard braking between two gaps of two seconds, too short for a slope
    let at = |t: f64| (t * rate) as usize;
    v[at(20.0)..at(25.0)].fill(f64::NAN);
    let island = at(22.0)..at(23.0);
    for i in island.clone() {
        v[i] = 15.0 - 3.0 * (i - island.start) as f64 / rate;
    }
    let mut session = Session::new(Meta::default(), rate, v.len());
    session.set(Channel::VelocityX, v);
    let coasting: Vec<Segment> =
        cut(&session).into_iter().filter(|s| s.kind == ManoeuvreKind::Coasting).collect();
    assert!(coasting.iter().any(|s| s.used), "the ride does coast");
    assert!(coasting.iter().all(|s| s.end <= island.start || s.start >= island.end));
}

#[test]
fn reasons_name_what_is_wrong() {
    // both brakes at once, 4 m/s²
    let braking = made(&[
        (Channel::VelocityX, |t| if t < 20.0 { 20.0 } else { (20.0 - 4.0 * (t - 20.0)).max(0.0) }),
        (Channel::BrakePressureFront, |t| if t < 20.0 { 0.0 } else { 1e6 }),
        (Channel::BrakePressureRear, |t| if t < 20.0 { 0.0 } else { 6e5 }),
    ]);
    let found = cut(&braking);
    let both = found.iter().find(|s| s.kind == ManoeuvreKind::CombinedBraking).expect("braking");
    assert!(!both.used && both.reason.as_deref().is_some_and(|r| r.contains("both brakes")));
    assert!((both.start as f64 / 50.0 - 20.0).abs() < 0.1);
    // a bend that is all rolling, and one ridden steadily the other way
    let bends = made(&[
        (Channel::VelocityX, |_| 12.0),
        (Channel::Roll, |t| {
            if t < 25.0 {
                0.5 * (2.5 * t).sin()
            } else {
                -0.5 * ((t - 30.0).clamp(0.0, 1.0) - (t - 45.0).clamp(0.0, 1.0))
            }
        }),
    ]);
    let found = cut(&bends);
    let first = found.iter().find(|s| s.kind == ManoeuvreKind::Cornering).expect("bend");
    assert!(!first.used && first.reason.as_deref().is_some_and(|r| r.contains("no steady lean")));
    let last = found.iter().rfind(|s| s.kind == ManoeuvreKind::Cornering).expect("bend");
    assert!(last.used && last.direction == Some(Direction::Left), "{last:?}");
}

#[test]
fn straights_are_out_or_back_by_heading_or_its_rate() {
    // out, round to the left in pi seconds from 20 s, back
    let turn = |t: f64| if (20.0..20.0 + std::f64::consts::PI).contains(&t) { 1.0 } else { 0.0 };
    for with_yaw in [true, false] {
        let mut session = made(&[(Channel::VelocityX, |_| 8.0), (Channel::YawRate, turn)]);
        if with_yaw {
            let yaw = |i: usize| (i as f64 / 50.0 - 20.0).clamp(0.0, std::f64::consts::PI);
            session.set(
                Channel::Yaw,
                (0..3000).map(|i| (yaw(i) + 3.0).sin().atan2((yaw(i) + 3.0).cos())).collect(),
            );
        }
        let found = cut(&session);
        let kinds: Vec<_> = found.iter().map(|s| (s.kind, s.direction)).collect();
        let (first, last) = (found[0].direction, found[found.len() - 1].direction);
        assert_eq!(
            (first, last),
            (Some(Direction::Outbound), Some(Direction::Inbound)),
            "{kinds:?}"
        );
        assert!(kinds.contains(&(ManoeuvreKind::Cornering, Some(Direction::Left))), "{kinds:?}");
    }
}

#[test]
fn real_recordings_are_covered_without_gaps() {
    let data = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data");
    for name in ["emoto_kiro/Primeira_Saida.txt", "tudelft_sbw_bicycle/sil_avg_5.log"] {
        let path = data.join(name);
        if !path.exists() {
            println!("{} is not there: skipped", path.display());
            continue;
        }
        let raw = ingest::read(&path, ingest::maps::file::shipped()).expect(name);
        let (mut session, _) = ingest::run(raw, &ingest::Config::default()).expect(name);
        filter::run(&mut session, &filter::Config::default());
        let found = cut(&session);
        assert!(found.len() > 10, "{name}: {found:?}");
        // neither has a gear or a brake: nothing may claim to know which brake
        assert!(
            !found.iter().any(|s| matches!(
                s.kind,
                ManoeuvreKind::FrontBraking | ManoeuvreKind::RearBraking
            ))
        );
    }
}

#[test]
#[ignore = "prints time and reasons"]
fn times_and_reasons() {
    let (bike, simulated) = sessions().swap_remove(0);
    let now = std::time::Instant::now();
    let found = segment::run(&simulated.session, &bike, &segment::Config::default());
    println!("{} segments in {} samples: {:?}", found.len(), simulated.session.len, now.elapsed());
    let mut reasons: BTreeMap<(ManoeuvreKind, String), usize> = BTreeMap::new();
    for s in &found {
        let reason = s.reason.as_deref().unwrap_or("used").to_owned();
        *reasons.entry((s.kind, reason)).or_default() += 1;
    }
    for ((kind, reason), count) in reasons {
        println!("{count:4} {}: {reason}", kind.name());
    }
}
