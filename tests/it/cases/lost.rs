//! Positions and wheels that are lost for a while: the motion still decides.

use super::Expected::{Right, Warned};
use super::*;

/// 60 s at 10 Hz with wheels; `lost` changes what is logged.
fn log(what: &'static str, expected: Expected, lost: impl Fn(&Row, &mut [f64; 4])) -> Case {
    let rows = ride(600, 0.1);
    let mut text =
        "Time (s),GPS Speed (km/h),Latitude (deg),Longitude (deg),Lean (deg),Wheel Speed F (km/h)\n".to_owned();
    for r in &rows {
        // a wheel is no copy of the receiver's speed
        let wheel = 1.01 * r.kmh() + 1.2 * (7.0 * r.t).sin();
        let mut logged = [r.kmh(), r.lat, r.lon, wheel];
        lost(r, &mut logged);
        let [v, lat, lon, wheel] = logged;
        let _ = writeln!(text, "{:.2},{v:.2},{lat:.7},{lon:.7},{:.1},{wheel:.2}", r.t, r.lean);
    }
    Case { rows, ..case(what, text, expected) }
}

#[test]
fn the_motion_decides_all_the_same() {
    let within = |r: &Row, from: f64, length: f64| (from..from + length).contains(&r.t);
    hold(vec![
        log("nothing lost", Right, |_, _| {}),
        log("0/0 before the first fix", Warned("no_fix"), |r, x| {
            if within(r, 0.0, 2.0) {
                (x[1], x[2]) = (0.0, 0.0);
            }
        }),
        log("0/0 in the middle", Warned("no_fix"), |r, x| {
            if within(r, 20.0, 3.0) {
                (x[1], x[2]) = (0.0, 0.0);
            }
        }),
        log("a wheel that is lost", Right, |r, x| {
            if within(r, 30.0, 3.0) {
                x[3] = 0.0;
            }
        }),
    ]);
}

/// Positions that jump stay in the log; the draft is by the motion.
#[test]
fn positions_that_jump_for_a_while_do_not_stop_the_draft() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.csv");
    type Fault = fn(&Row, &mut [f64; 4]);
    let kinds: [(&'static str, Fault); 2] = [
        ("far away", |_, x| x[1] += 0.05),
        ("off the globe", |_, x| (x[1], x[2]) = (9999.0, 9999.0)),
    ];
    for (what, bad) in kinds {
        let case = log(what, Right, |r, x| {
            if (25.0..27.0).contains(&r.t) {
                bad(r, x);
            }
        });
        std::fs::write(&path, &case.bytes).expect("written");
        let (session, _, map) = read(&path).expect("read");
        for channel in [Channel::VelocityX, Channel::Latitude, Channel::Longitude] {
            assert!(session.has(channel), "{what}: {channel}\n{map}");
        }
        assert!(map.contains("speed over ground from the position"), "{what}:\n{map}");
    }
}
