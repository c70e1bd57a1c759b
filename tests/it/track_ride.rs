//! Physics of a session on the track: two laps of the built-in scenario.

use roadbench::GRAVITY;
use roadbench::internals::contract::channel::Channel;
use roadbench::internals::simulate::ride::Sample;
use roadbench::internals::simulate::track::{Track, TrackRide, doings, ride};
use roadbench::internals::simulate::tyre_truth;

/// One ride for all that is looked at: it takes longer than everything else.
#[test]
fn two_laps_are_ridden_as_on_a_track() {
    let track = Track::load("track").expect("built in").expect("a track");
    let ridden = ride(&Track { laps: 2, ..track }, 0).expect("comes round");
    it_leans_brakes_and_drives_like_a_track_rider(&ridden);
    lean_is_that_of_speed_and_yaw_rate_and_friction_stays_below_the_tyres(&ridden);
    laps_close_on_themselves_and_take_about_as_long(&ridden);
}

fn it_leans_brakes_and_drives_like_a_track_rider(r: &TrackRide) {
    let most =
        |f: &dyn Fn(&Sample) -> f64| r.ride.samples.iter().map(f).fold(f64::NEG_INFINITY, f64::max);
    let lean = most(&|s| s.wheels[1].camber.abs()).to_degrees();
    assert!((45.0..58.0).contains(&lean), "{lean}");
    let fastest = most(&|s| s.motion.velocity.norm());
    assert!((45.0..65.0).contains(&fastest), "{fastest}");
    let slowest = -most(&|s| -s.motion.velocity.norm());
    assert!(slowest > 10.0, "{slowest}");
    // along the heading, with the hill's share taken off by the road's axes
    let held_back = most(&|s| {
        let v = s.motion.velocity;
        -v.dot(&s.motion.acceleration) / v.norm()
    });
    assert!((7.5..11.5).contains(&held_back), "{held_back}");
    assert!(r.hands.iter().all(|h| (1..=6).contains(&h.gear)), "always in gear");
    let both = |what: &str| doings(r).iter().filter(|d| d.what == what).count();
    for what in [
        "drive",
        "engine_braking",
        "front_braking",
        "combined_braking",
        "trail_braking",
        "corner_drive",
        "gear_change",
    ] {
        assert!(both(what) >= 2, "{what}: {}", both(what));
    }
}

/// What the wheels push is what the mass is accelerated by: lean, speed and yaw rate belong together.
fn lean_is_that_of_speed_and_yaw_rate_and_friction_stays_below_the_tyres(r: &TrackRide) {
    let friction = r.entry.model.road.friction;
    let m = &r.entry.model.motorcycle;
    let loads = m.static_loads();
    let tyres = m.tyres.as_ref().expect("shod");
    let peak =
        [0, 1].map(|k| tyre_truth::bench(tyres[k].as_ref(), loads[k], friction).peak_friction);
    let (mut n, mut sum) = (0, 0.0);
    for s in &r.ride.samples {
        let spin = s.motion.rotation * s.motion.spin;
        let expected = -(s.motion.velocity.norm() * spin.z / GRAVITY).atan();
        if expected.abs() > 0.6 && s.motion.spin.x.abs() < 0.1 {
            n += 1;
            sum += s.wheels[1].camber / expected;
        }
        for k in 0..2 {
            let w = &s.wheels[k];
            if w.load > 0.3 * loads[k] {
                let used = w.force[0].hypot(w.force[1]) / w.load;
                // light tyres grip better, and lean adds to the side force
                assert!(used < 1.25 * peak[k], "wheel {k}: {used} of {}", peak[k]);
            }
        }
    }
    // round tyres and spinning wheels want 5 to 20 % more lean than a wheel without width
    let ratio = sum / f64::from(n);
    assert!(n > 500 && (1.03..1.22).contains(&ratio), "{n} {ratio}");
}

fn laps_close_on_themselves_and_take_about_as_long(r: &TrackRide) {
    assert_eq!(r.crossings.len(), 3);
    let rate = r.ride.session.rate;
    let at = |t: f64| r.ride.samples[((t * rate) as usize).min(r.ride.samples.len() - 1)].position;
    for t in &r.crossings[1..] {
        let p = at(*t);
        assert!(p[0].abs() < 2.0 && p[1].abs() < 8.0, "{p:?}");
    }
    let laps = [r.crossings[1], r.crossings[2] - r.crossings[1]];
    assert!(laps.iter().all(|t| (85.0..130.0).contains(t)), "{laps:?}");
    let astray = r.hands.iter().map(|h| h.left.abs()).fold(0.0, f64::max);
    assert!(astray < 25.0, "{astray}");
}

#[test]
fn a_session_depends_on_seed_and_number_alone() {
    let track = Track::load("track").expect("built in").expect("a track");
    let same = ride(&Track { laps: 1, ..track.clone() }, 0).expect("comes round");
    let again = ride(&Track { laps: 1, ..track }, 0).expect("comes round");
    for channel in [Channel::Roll, Channel::WheelSpeedRear, Channel::BrakePressureRear] {
        assert_eq!(same.ride.session.get(channel), again.ride.session.get(channel));
    }
}

#[test]
fn a_wrong_key_is_named() {
    let parse = |text: &str| {
        Track::parse(text, std::path::Path::new("t.toml")).expect_err("wrong").to_string()
    };
    let base = "name = 't'\ndescription = 'd'\n";
    assert!(parse(&format!("{base}laps = 0\n")).contains("`laps` = 0"));
    assert!(parse(&format!("{base}laps = 2\nloggers = ['sextant']\n")).contains("sextant"));
    assert!(parse(&format!("{base}laps = 2\nfriction = [1.5, 1.2]\n")).contains("friction"));
    assert!(parse(&format!("{base}laps = 2\n[sensors.rol]\nwhite = 1.0\n")).contains("rol"));
}
