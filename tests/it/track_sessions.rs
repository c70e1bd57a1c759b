//! A session on the track from the files of four loggers to coefficients, nothing edited by hand: a small version of
//! the study `examples/track_sessions`.

use roadbench::internals::contract::channel::Channel;
use roadbench::internals::contract::coefficient::Coefficient as C;
use roadbench::internals::ingest::maps::propose::physics::Verdict;
use roadbench::internals::pipeline::Pipeline;
use roadbench::internals::simulate::loggers::Profile;
use roadbench::internals::simulate::track;
use roadbench::internals::store::tables::rows::{Coefficient, Status};

#[path = "../../examples/track_sessions/case.rs"]
#[allow(dead_code)]
mod case;
use super::channels_by_physics::truth as channels;

use case::{Asked, PROFILES, asked, drafted, read, segmented, varied};
use channels::{Planted, check};

/// Of the ride, and which of its sessions; the study reports on others.
const SEED: u64 = 5150;
const NUMBER: usize = 13;

fn row<'a>(rows: &'a [Coefficient], asked: &Asked) -> Option<&'a Coefficient> {
    let own = |c: &&Coefficient| {
        c.tyre == asked.id.part.name() && c.coefficient == asked.id.coefficient.name()
    };
    rows.iter().find(own)
}

#[test]
fn what_each_logger_can_carry_comes_out_and_no_channel_is_wrong() {
    let track = varied(SEED);
    let ridden = track::ride(&track, NUMBER).expect("comes round");
    let work = tempfile::tempdir().expect("a folder");
    for profile in PROFILES {
        let name = profile.name();
        let read = read(profile, &ridden, SEED, work.path(), &Pipeline::onroad());
        let score = channels::score(&read.judged, name);
        assert_eq!(score.wrong, Vec::<String>::new(), "{name}");
        let entries = &read.judged.verdicts.entries;
        let untimed = entries.iter().any(|e| profile == Profile::Satellite && e.untimed());
        let missing: &[&str] = if untimed { &["throttle <- throttle"] } else { &[] };
        assert_eq!(score.missing, missing, "{name}");
        let outcome = read.outcome.unwrap_or_else(|why| panic!("{name}: {why}"));
        let seconds = segmented(&ridden, &outcome, read.earlier);
        assert!(seconds.as_rear_used < 0.05 * seconds.engine, "{name}: {seconds:?}");
        let wheels = matches!(profile, Profile::Superbike | Profile::Factory);
        for asked in asked(&ridden, read.circumference) {
            let words = asked.words;
            // without wheels and levers only what lean, turn and speed tell; nothing measures the satellite's lean
            let by_lean = asked.id.coefficient == C::LateralFrictionCt;
            let carries = wheels || (profile == Profile::Phone && by_lean);
            let Some(row) = row(&outcome.coefficients, &asked) else {
                assert!(!carries || words.is_empty(), "{name}: no row of the {words}");
                continue;
            };
            if !carries {
                assert_eq!(row.status, Status::NotAvailable, "{name}: {words}");
                continue;
            }
            let (low, high) = (row.ci95_low, row.ci95_high);
            match asked.bound {
                true => {
                    let given = matches!(row.status, Status::LowerBound | Status::Ok);
                    assert!(given, "{name}: {words}: {:?}", row.reason);
                    let low = low.expect("a bound");
                    assert!((0.3..=asked.truth).contains(&low), "{name}: {words}: {low}");
                }
                // laps hardly determine it
                false if asked.id.coefficient == C::Drag && row.value.is_none() => {}
                false => {
                    assert_eq!(row.status, Status::Ok, "{name}: {words}: {:?}", row.reason);
                    let [low, high] = [low, high].map(|x| x.expect("an interval"));
                    let truth = asked.truth;
                    assert!(
                        (low..=high).contains(&truth),
                        "{name}: {words}: {truth} in {low} to {high}"
                    );
                }
            }
        }
    }
}

/// A satellite logger's throttle is in force with a delay that is right, or not in force: of these logs one shows it too
/// badly.
#[test]
fn a_throttle_whose_delay_does_not_show_is_not_put_in_force() {
    let work = tempfile::tempdir().expect("a folder");
    let mut untimed = 0;
    for (seed, number) in [(7102, 19), (7102, 2), (7103, 5)] {
        let ridden = track::ride(&varied(seed), number).expect("comes round");
        let drafted = drafted(Profile::Satellite, &ridden, seed, work.path());
        let score = channels::score(&drafted.judged, "satellite");
        assert_eq!(score.wrong, Vec::<String>::new(), "{seed} {number}");
        let own = |e: &&Verdict| e.channel == Channel::Throttle;
        let all = &drafted.judged.verdicts.entries;
        let throttle = all.iter().find(own).expect("found");
        let in_force = drafted.judged.draft.contains("\n[channel.throttle]");
        assert_eq!(in_force, !throttle.untimed(), "{}", drafted.judged.draft);
        untimed += usize::from(throttle.untimed());
        // a delay that is 0.2 s wrong is found all the same, and a right map is not objected to
        let late = Some(Planted::Delay(Channel::Throttle));
        let checked = |planted| check(&drafted.judged, "satellite", drafted.circumference, planted);
        let found = checked(late);
        assert!(found.found && found.named && found.mended, "{seed} {number}: {found:?}");
        assert_eq!(checked(None).false_alarms, 0, "{seed} {number}");
    }
    assert!((1..3).contains(&untimed), "{untimed} of 3");
}
