//! Positions in every notation that loggers write.

use super::Expected::{Right, Warned};
use super::*;

/// The ride west of Greenwich: mirrored, with its bends.
fn west() -> Vec<Row> {
    let mirror = |r: &Row| Row { lon: -r.lon, lean: -r.lean, course: 360.0 - r.course, ..*r };
    usual().iter().map(mirror).collect()
}

/// A log with semicolons whose position is written so.
fn with(names: &str, rows: &[Row], position: impl Fn(&Row) -> String) -> String {
    let mut text = format!("Time (s);GPS Speed (km/h);{names};Lean (deg)\n");
    for r in rows {
        let _ = writeln!(text, "{:.2};{:.2};{};{:.1}", r.t, r.kmh(), position(r), r.lean);
    }
    text
}

/// Degrees and minutes in one number.
fn packed(degrees: f64) -> f64 {
    let whole = degrees.abs().floor();
    100.0 * whole + 60.0 * (degrees.abs() - whole)
}

#[test]
fn letters_of_the_hemisphere() {
    let pair = "Latitude;Longitude";
    let of = |what: &'static str, text: String| Case { rows: west(), ..case(what, text, Right) };
    let plus = |r: &Row| -r.lon;
    hold(vec![
        of("behind a blank", with(pair, &west(), |r| format!("{:.7} N;{:.7} W", r.lat, plus(r)))),
        of("glued behind", with(pair, &west(), |r| format!("{:.7}N;{:.7}W", r.lat, plus(r)))),
        of("in front", with(pair, &west(), |r| format!("N{:.7};W{:.7}", r.lat, plus(r)))),
        of(
            "in the names",
            with("Latitude (N);Longitude (W)", &west(), |r| format!("{:.7};{:.7}", r.lat, plus(r))),
        ),
        of(
            "in columns behind",
            with("Latitude;Longitude;N/S;E/W", &west(), |r| {
                format!("{:.7};{:.7};N;W", r.lat, plus(r))
            }),
        ),
        of(
            "in columns beside",
            with("lat;lat_ref;lon;lon_ref", &west(), |r| {
                format!("{:.7};N;{:.7};W", r.lat, plus(r))
            }),
        ),
        of(
            "as NMEA",
            with("Latitude;NS;Longitude;EW", &west(), |r| {
                format!("{:010.5};N;{:011.5};W", packed(r.lat), packed(r.lon))
            }),
        ),
        of(
            "as NMEA, glued",
            with(pair, &west(), |r| format!("{:010.5}N;{:011.5}W", packed(r.lat), packed(r.lon))),
        ),
        of(
            "of seconds",
            with(pair, &west(), |r| {
                let parts =
                    |x: f64| (x.floor(), (60.0 * x.fract()).floor(), (3600.0 * x.fract()) % 60.0);
                let ((a, b, c), (d, e, f)) = (parts(r.lat), parts(plus(r)));
                format!("{a}\u{b0}{b:02}'{c:07.4}\"N;{d}\u{b0}{e:02}'{f:07.4}\"W")
            }),
        ),
    ]);
}

#[test]
fn other_scales_and_both_in_one_cell() {
    let rows = usual();
    let scaled = |names: &str, scale: f64| {
        with(names, &rows, |r| format!("{:.0};{:.0}", r.lat * scale, r.lon * scale))
    };
    let semicircles = 2_147_483_648.0 / 180.0;
    hold(vec![
        case("whole numbers", scaled("lat;lon", 1e7), Warned("position_notation")),
        case("E7", scaled("lat_e7;lon_e7", 1e7), Right),
        case("E6", scaled("LatitudeE6;LongitudeE6", 1e6), Right),
        case("1e-7 deg", scaled("Latitude (1e-7 deg);Longitude (1e-7 deg)", 1e7), Right),
        case(
            "semicircles",
            scaled("position_lat (semicircles);position_long (semicircles)", semicircles),
            Right,
        ),
        case(
            "minutes",
            with("Latitude (min);Longitude (min)", &rows, |r| {
                format!("{:.5};{:.5}", 60.0 * r.lat, 60.0 * r.lon)
            }),
            Right,
        ),
        case(
            "degrees and minutes",
            with("Lat (ddmm.mmmm);Lon (dddmm.mmmm)", &rows, |r| {
                format!("{:010.5};{:011.5}", packed(r.lat), packed(r.lon))
            }),
            Right,
        ),
        case(
            "both",
            with("Position", &rows, |r| format!("{:.7}, {:.7}", r.lat, r.lon)),
            Warned("position_notation"),
        ),
        case("WKT", with("geom", &rows, |r| format!("POINT({:.7} {:.7})", r.lon, r.lat)), Right),
    ]);
}

/// Drafts a map for a ride with a course and an east that may be mirrored: the lean, and the map.
fn lean_of(course: impl Fn(&Row) -> f64, east: impl Fn(&Row) -> f64) -> (Session, String) {
    let mut text =
        "Time (s),GPS Speed (km/h),Latitude,Longitude,Course (deg),Lean (deg)\n".to_owned();
    let rows = ride(240, 0.25);
    for r in &rows {
        let (v, lon, course) = (r.kmh(), east(r), course(r));
        // a lean without an error, or as small as the ideal one, is taken for a calculated one
        let lean = 1.06 * r.lean + 2.0 * (0.9 * r.t).sin();
        let _ = writeln!(text, "{:.2},{v:.2},{:.7},{lon:.7},{course:.2},{lean:.1}", r.t, r.lat);
    }
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("ride.csv");
    std::fs::write(&path, text).expect("written");
    let (session, _, map) = read(&path).expect("read");
    let lean = session.get(Channel::Roll).expect("a lean");
    for r in rows.iter().skip(8).step_by(12) {
        let Some(x) = lean.get((r.t * session.rate).round() as usize) else { break };
        assert!((x - r.lean.to_radians()).abs() < 0.15, "{x} at {} s, not {}\n{map}", r.t, r.lean);
    }
    (session, map)
}

#[test]
fn a_mirrored_position_does_not_turn_the_lean() {
    // the letters are lost: the course tells
    let (session, map) = lean_of(|r| r.course, |r| 120.0 - r.lon);
    assert!(session.get(Channel::Longitude).is_none(), "{map}");
    assert!(map.contains("a letter `W` was lost"), "{map}");
    // nor does a course that is positive to the left take a right position away
    let (session, map) = lean_of(|r| 360.0 - r.course, |r| r.lon);
    assert!(session.get(Channel::Longitude).is_some(), "{map}");
}

/// A lean that is off the ideal one, but no larger, may be an app's: it is put in force by its owner only.
#[test]
fn a_lean_no_larger_than_the_turn_asks_for_is_a_guess() {
    let drafted = |larger: f64| {
        let mut text = "Time (s),GPS Speed (km/h),Latitude,Longitude,Lean (deg)\n".to_owned();
        for r in &ride(240, 0.25) {
            let lean = larger * r.lean + 2.0 * (0.9 * r.t).sin();
            let _ = writeln!(text, "{:.2},{:.2},{:.7},{:.7},{lean:.1}", r.t, r.kmh(), r.lat, r.lon);
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ride.csv");
        std::fs::write(&path, text).expect("written");
        let (session, _, map) = read(&path).expect("read");
        (session.has(Channel::Roll), map)
    };
    let (in_force, map) = drafted(1.06);
    assert!(in_force && map.contains("measured"), "{map}");
    let (in_force, map) = drafted(0.99);
    let said = map.replace("\n# ", " ");
    assert!(!in_force && said.contains("no larger than the turn asks for"), "{map}");
}
