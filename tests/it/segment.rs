//! Segments against the simulator's labels.

use std::collections::BTreeMap;

use roadbench::bike::Bike;
use roadbench::channel::Channel;
use roadbench::filter;
use roadbench::segment::{self, Kind};
use roadbench::session::Session;
use roadbench::simulate::{self, Simulated, scenario::Scenario};

/// Seconds found right, found, true; by kind.
type Score = BTreeMap<Kind, [f64; 3]>;

fn add(score: &mut Score, truth: &Simulated, session: &Session, bike: &Bike) {
    let mut session = session.clone();
    filter::run(&mut session, &filter::Config::default());
    let segments = segment::run(&session, bike, &segment::Config::default());
    let mut label = vec![Kind::Other; session.len];
    for &(kind, start, end, _) in &truth.labels {
        let at = |t: f64| ((t * session.rate).round() as usize).min(session.len);
        label[at(start)..at(end)].fill(kind);
    }
    let dt = 1.0 / session.rate;
    let mut confusion: BTreeMap<(Kind, Kind), f64> = BTreeMap::new();
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

#[test]
fn every_kind_is_found_with_and_without_pedals_and_gears() {
    let sessions = sessions();
    let hidden =
        [Channel::BrakePressureFront, Channel::BrakePressureRear, Channel::Throttle, Channel::Gear];
    for remove in [&[][..], &hidden[..]] {
        println!("without {remove:?}");
        let mut score = Score::new();
        for (bike, truth) in &sessions {
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
    }
}
