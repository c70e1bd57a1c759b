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
        log("0/0 and no speed in the middle", Warned("no_fix"), |r, x| {
            if within(r, 20.0, 3.0) {
                (x[0], x[1], x[2]) = (0.0, 0.0, 0.0);
            }
        }),
        log("latitude 0 alone", Warned("no_fix"), |r, x| {
            if within(r, 20.0, 3.0) {
                x[1] = 0.0;
            }
        }),
        log("a speed of 0 for a while", Warned("zero_speed"), |r, x| {
            if within(r, 20.0, 3.0) {
                x[0] = 0.0;
            }
        }),
        log("a wheel that is lost", Right, |r, x| {
            if within(r, 30.0, 3.0) {
                x[3] = 0.0;
            }
        }),
    ]);
}

/// What a logger writes again in every row until the next fix is no sample; nor is a position that froze.
#[test]
fn repeats_of_a_fix_are_no_samples() {
    let rows = ride(600, 0.1);
    let held = |every: usize| {
        let rows = rows.clone();
        move |r: &Row, x: &mut [f64; 4]| {
            let fix = &rows[(10.0 * r.t).round() as usize / every * every];
            (x[0], x[1], x[2]) = (fix.kmh(), fix.lat, fix.lon);
        }
    };
    let at_twenty = rows[200];
    hold(vec![
        log("5 Hz in 10 Hz", Warned("repeated_fixes"), held(2)),
        log("2 Hz in 10 Hz", Warned("repeated_fixes"), held(5)),
        log("frozen in the middle", Warned("stuck"), |r, x| {
            if (20.0..24.0).contains(&r.t) {
                (x[1], x[2]) = (at_twenty.lat, at_twenty.lon);
            }
        }),
        log("90/180 before the first fix", Warned("no_fix"), |r, x| {
            if r.t < 2.0 {
                (x[1], x[2]) = (90.0, 180.0);
            }
        }),
    ]);
}

/// A lean that is counted from the horizontal is brought upright.
#[test]
fn a_lean_from_0_to_180() {
    let rows = ride(600, 0.1);
    let mut text = csv("Time (s)", &rows, |_, r| format!("{:.2}", r.t));
    text = text
        .lines()
        .map(|line| match line.rsplit_once(',').map(|(rest, lean)| (rest, lean.parse::<f64>())) {
            // a measured lean is larger than the ideal one
            Some((rest, Ok(lean))) => format!("{rest},{:.1}\n", 1.06 * lean + 90.0),
            _ => format!("{line}\n"),
        })
        .collect();
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.csv");
    std::fs::write(&path, text).expect("written");
    let (session, _, map) = read(&path).expect("read");
    assert!(map.contains("offset = -90.0"), "{map}");
    let roll = session.get(Channel::Roll).expect("a lean");
    let off = roll.iter().zip(&rows).map(|(x, r)| (x.to_degrees() - 1.06 * r.lean).abs());
    assert!(off.fold(0.0, f64::max) < 1.0, "{map}");
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
