//! Physics of the reduced-order motorcycle on built-in rides.

use roadbench::internals::simulate::reduced::session;
use roadbench::internals::simulate::scenario::Scenario;

#[test]
fn the_ride_ends_stays_upright_and_is_reproducible() {
    let scenario = Scenario::builtin("paper").expect("scenario");
    let machine = scenario.machine(0);
    let a = session(&scenario, &machine, 0);
    assert!(a.session.duration() > 300.0 && a.session.duration() < 2000.0);
    let roll = a.states.iter().map(|s| s.roll.abs()).fold(0.0, f64::max);
    assert!((0.5..0.85).contains(&roll), "largest lean {roll} rad");
    let b = session(&scenario, &machine, 0);
    for channel in a.session.channels() {
        let (x, y) = (a.session.get(channel), b.session.get(channel));
        assert_eq!(x, y, "{channel}");
    }
}

#[test]
fn measured_kinematics_are_consistent() {
    // v' = ax + r vy along the whole ride, for an undisturbed logger
    let scenario = Scenario::builtin("perfect").expect("scenario");
    let machine = scenario.machine(0);
    let s = session(&scenario, &machine, 0);
    let rate = scenario.rate;
    let along = |i: usize| s.trace[i].acceleration[0] + s.states[i].yaw_rate * s.states[i].vy;
    let mut errors = Vec::new();
    let mut integral = 0.0;
    for i in 1..s.states.len() - 1 {
        let derivative = (s.states[i + 1].vx - s.states[i - 1].vx) * rate / 2.0;
        errors.push((derivative - along(i)).abs());
        integral += along(i) / rate;
    }
    // brakes and throttle step between samples, so a few samples differ; nothing adds up
    errors.sort_by(f64::total_cmp);
    let most = errors[errors.len() * 99 / 100];
    assert!(most < 0.05, "{most}");
    assert!(integral.abs() < 0.5, "standstill to standstill: {integral}");
}
