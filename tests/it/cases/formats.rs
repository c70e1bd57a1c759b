//! VBO as apps write it, TCX, and formats that are not read.

use super::Expected::{Refused, Right, Warned};
use super::*;

/// How a VBO is written.
struct Vbo {
    names: &'static str,
    titles: bool,
    speed: (&'static str, f64),
    /// Degrees instead of minutes; east positive.
    degrees: bool,
    east: bool,
    between: char,
}

const USUAL: Vbo = Vbo {
    names: "sats time lat long velocity heading",
    titles: true,
    speed: ("velocity kmh", 3.6),
    degrees: false,
    east: false,
    between: ' ',
};

fn vbo(how: &Vbo) -> String {
    let mut text = "File created on 25/10/2026 at 10:00:00\n\n".to_owned();
    if how.titles {
        let _ = write!(
            text,
            "[header]\nsatellites\ntime\nlatitude\nlongitude\n{}\nheading\n\n",
            how.speed.0
        );
    }
    if !how.names.is_empty() {
        let _ = write!(text, "[column names]\n{}\n\n", how.names);
    }
    text += "[data]\n";
    for r in usual() {
        let factor = if how.degrees { 1.0 } else { 60.0 };
        let sign = if how.east { 1.0 } else { -1.0 };
        let line = format!(
            "011 1000{:05.2} {:+.7} {:+.7} {:07.3} {:06.2}\n",
            r.t,
            factor * r.lat,
            sign * factor * r.lon,
            how.speed.1 * r.v,
            r.course
        );
        text += &line.replace(' ', &how.between.to_string());
    }
    text
}

fn of_vbo(what: &'static str, text: String, expected: Expected) -> Case {
    Case { file: "ride.vbo", ..case(what, text, expected) }
}

#[test]
fn vbo_of_many_apps() {
    hold(vec![
        of_vbo("as Racelogic", vbo(&USUAL), Right),
        of_vbo("lng", vbo(&Vbo { names: "sats time lat lng velocity heading", ..USUAL }), Right),
        of_vbo(
            "longitude",
            vbo(&Vbo { names: "Satellites Time Latitude Longitude Speed Heading", ..USUAL }),
            Right,
        ),
        of_vbo(
            "units in names",
            vbo(&Vbo { names: "sats time lat long velocity_kmh heading", titles: false, ..USUAL }),
            Right,
        ),
        of_vbo("knots", vbo(&Vbo { speed: ("velocity knots", 3600.0 / 1852.0), ..USUAL }), Right),
        of_vbo(
            "knots unsaid",
            vbo(&Vbo { speed: ("velocity", 3600.0 / 1852.0), ..USUAL }),
            Warned("speed_unit"),
        ),
        of_vbo(
            "mph, but km/h said",
            vbo(&Vbo { speed: ("velocity kmh", 1.0 / 0.44704), ..USUAL }),
            Warned("speed_unit"),
        ),
        of_vbo("east positive", vbo(&Vbo { east: true, ..USUAL }), Right),
        of_vbo("degrees, east positive", vbo(&Vbo { east: true, degrees: true, ..USUAL }), Right),
        of_vbo("degrees, west positive", vbo(&Vbo { degrees: true, ..USUAL }), Right),
        of_vbo("commas", vbo(&Vbo { between: ',', ..USUAL }), Right),
        of_vbo("tabs", vbo(&Vbo { between: '\t', ..USUAL }), Right),
        of_vbo("decimal commas", vbo(&USUAL).replace('.', ","), Right),
        of_vbo("no header", vbo(&Vbo { titles: false, ..USUAL }), Right),
        of_vbo("no names", vbo(&Vbo { names: "", ..USUAL }), Right),
        of_vbo("neither", vbo(&Vbo { names: "", titles: false, ..USUAL }), Refused("")),
        of_vbo("\\r", vbo(&USUAL).replace('\n', "\r"), Right),
        of_vbo("a short row", vbo(&USUAL).replace("011 100020.00 ", "011 "), Warned("bad_line")),
        of_vbo(
            "a name too many",
            vbo(&Vbo { names: "sats time lat long velocity heading height", ..USUAL }),
            Refused("line"),
        ),
        of_vbo(
            "no fix at first",
            vbo(&USUAL)
                .lines()
                .map(|l| match l.split_once("011 100000") {
                    Some((_, rest)) => format!(
                        "000 100000{} +0000.00000 +00000.00000 {}\n",
                        &rest[..3],
                        rest.split(' ').skip(3).collect::<Vec<_>>().join(" ")
                    ),
                    None => format!("{l}\n"),
                })
                .collect(),
            Warned("no_fix"),
        ),
    ]);
}

fn tcx() -> String {
    let mut text =
        "<?xml version=\"1.0\"?>\n<TrainingCenterDatabase><Activities><Activity><Lap><Track>\n"
            .to_owned();
    for r in usual() {
        let _ = writeln!(
            text,
            "<Trackpoint><Time>2026-10-25T10:00:{:06.3}Z</Time><Position><LatitudeDegrees>{:.7}</LatitudeDegrees>\
             <LongitudeDegrees>{:.7}</LongitudeDegrees></Position><Extensions><TPX><Speed>{:.3}</Speed></TPX>\
             </Extensions></Trackpoint>",
            r.t, r.lat, r.lon, r.v
        );
    }
    text + "</Track></Lap></Activity></Activities></TrainingCenterDatabase>\n"
}

/// RMC alone, twice a second.
fn nmea() -> String {
    let minutes = |degrees: f64, width: usize| {
        let whole = degrees.trunc();
        format!("{:0width$}{:010.7}", whole, 60.0 * (degrees - whole))
    };
    let mut text = String::new();
    for r in usual() {
        let body = format!(
            "GPRMC,1000{:05.2},A,{},N,{},E,{:.3},{:.2},251026,,,A",
            r.t,
            minutes(r.lat, 2),
            minutes(r.lon, 3),
            r.v * 3600.0 / 1852.0,
            r.course
        );
        let sum = body.bytes().fold(0, |sum, b| sum ^ b);
        let _ = write!(text, "${body}*{sum:02X}\r\n");
    }
    text
}

#[test]
fn other_formats_are_read_or_say_which_export_is() {
    let of = |what, file, bytes: &[u8], words| Case { file, ..case(what, bytes, Refused(words)) };
    hold(vec![
        Case { file: "ride.tcx", ..case("TCX", tcx(), Right) },
        Case { file: "ride.txt", ..case("NMEA", nmea(), Right) },
        Case {
            file: "ride.nmea",
            ..case(
                "NMEA, a bad sum",
                nmea().replacen("100010.00,A,", "100010.00,A,1", 1),
                Warned("bad_line"),
            )
        },
        of(
            "NMEA, every sum wrong",
            "ride.txt",
            b"$GPRMC,100000.00,A,4700.0,N,00800.0,E,27.0,89,251026,,*5A\r\n",
            "checksum",
        ),
        of(
            "KML",
            "ride.kml",
            b"<?xml version=\"1.0\"?>\n<kml xmlns=\"x\"><Document/></kml>\n",
            "GPX",
        ),
        of("FIT, cut off", "ride.fit", b"\x0e\x10\x5d\x08\x10\0\0\0.FIT\0\0", "as FIT"),
        of("no FIT", "ride.fit", b"SIMPLE  =                    T", "GPX or TCX"),
        of("RaceChrono", "ride.rcz", b"PK\x03\x04\x14\0\x06\0", "CSV v3 or VBO"),
        of("a workbook", "ride.xlsx", b"PK\x03\x04\x14\0\x06\0xl/workbook.xml", "CSV"),
        of("JSON", "ride.json", b"{\"samples\": [1, 2]}\n", "CSV"),
        of("a page", "ride.csv", b"<!DOCTYPE html><html><body>Sign in</body></html>\n", "HTML"),
        of("a video", "ride.mp4", b"\0\0\0\x20ftypmp42\0\0\0\0", "telemetry"),
        of("words", "ride.txt", b"Dear diary,\ntoday I rode a bicycle.\n", "row of numbers"),
    ]);
}

/// `inspect` of a text in a folder with bike files: exit code and what is said.
fn inspect(text: &str, arguments: &[&str]) -> (Option<i32>, String) {
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("ride.vbo"), text).expect("written");
    std::fs::create_dir(folder.path().join("bikes")).expect("a folder");
    let mut command = assert_cmd::Command::cargo_bin("roadbench").expect("binary");
    let output =
        command.current_dir(folder.path()).args(["inspect", "ride.vbo"]).args(arguments).output();
    let output = output.expect("ran");
    (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned())
}

#[test]
fn a_log_that_names_no_bike_is_listed_all_the_same() {
    let (code, said) = inspect(&vbo(&USUAL), &["--bikes", "bikes"]);
    assert_eq!(code, Some(0), "{said}");
    assert!(
        said.contains("velocity_x") && said.contains("no_bike_id") && said.contains("--bike ID"),
        "{said}"
    );
}

/// A box that stands on end has gravity in its longitudinal acceleration.
#[test]
fn a_box_on_end_is_not_level() {
    let how = Vbo { names: "sats time lat long velocity heading LongAcc", ..USUAL };
    let text: String = vbo(&how)
        .lines()
        .map(|l| if l.starts_with("011 ") { format!("{l} -0.930\n") } else { format!("{l}\n") })
        .collect();
    let (code, said) = inspect(&text, &[]);
    assert_eq!(code, Some(0), "{said}");
    let line = said.lines().find(|l| l.starts_with("acceleration_x")).expect("listed");
    assert!(!line.contains("plausible") && said.contains("acceleration_x is left out"), "{said}");
}
