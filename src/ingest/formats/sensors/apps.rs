//! How apps and programs that write a text for each sensor name things: Sensor Logger, phyphox, GoPro telemetry.
//!
//! | source | texts | stamps | units |
//! |---|---|---|---|
//! | Sensor Logger (phones) | `Accelerometer.csv`, `Location.csv`, ... | `time`, ns since 1970 | none written: [`UNITS`] |
//! | phyphox (phones) | `Accelerometer.csv`, `Location.csv`, `meta/time.csv` | `Time (s)`, without pauses | after the names |
//! | gopro-telemetry, Telemetry Extractor | `...-ACCL.csv`, `...-GYRO.csv`, `...-GPS5.csv` | `cts`, ms of the video | after the first name |

use super::table::Text;
use crate::ingest::formats::csv::start_time;
use crate::ingest::formats::streams::{Line, Stream, Streams};

/// Who wrote the texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum App {
    SensorLogger,
    Phyphox,
    GoPro,
}

/// Units of Sensor Logger: text, columns, unit. An empty text is any other.
const UNITS: &[(&str, &[&str], &str)] = &[
    ("Accelerometer", &["x", "y", "z"], "m/s2"),
    ("TotalAcceleration", &["x", "y", "z"], "m/s2"),
    ("Gravity", &["x", "y", "z"], "m/s2"),
    ("Gyroscope", &["x", "y", "z"], "rad/s"),
    ("GyroscopeUncalibrated", &["x", "y", "z"], "rad/s"),
    ("Magnetometer", &["x", "y", "z"], "uT"),
    ("MagnetometerUncalibrated", &["x", "y", "z"], "uT"),
    ("Orientation", &["roll", "pitch", "yaw"], "rad"),
    ("Barometer", &["pressure"], "mbar"),
    ("Barometer", &["relativeAltitude"], "m"),
    ("", &["latitude", "longitude", "bearing", "bearingAccuracy"], "deg"),
    ("", &["altitude", "altitudeAboveMeanSeaLevel", "horizontalAccuracy", "verticalAccuracy"], "m"),
    ("", &["speed", "speedAccuracy"], "m/s"),
];

/// Columns of Sensor Logger's texts that are no samples.
const NO_SAMPLES: [&str; 2] = ["time", "seconds_elapsed"];

/// Columns of GPS9 that Telemetry Extractor gives the units of others.
const WRONG_UNITS: [&str; 4] = ["GPS (days)", "GPS (secs)", "GPS (DOP)", "GPS (fix)"];

impl App {
    /// Who wrote a text, by the names of its columns.
    pub(super) fn of(names: &[String]) -> Option<Self> {
        let has = |name: &str| names.iter().any(|n| n == name);
        match names.first().map(String::as_str) {
            Some("time") if has("seconds_elapsed") => Some(App::SensorLogger),
            Some("Time (s)") if names.len() > 1 => Some(App::Phyphox),
            Some("cts") if names.len() > 1 => Some(App::GoPro),
            _ => None,
        }
    }

    /// Description, for people.
    pub(super) fn name(self) -> &'static str {
        match self {
            App::SensorLogger => "Sensor Logger",
            App::Phyphox => "phyphox",
            App::GoPro => "GoPro telemetry",
        }
    }

    /// The column of dates beside the clock.
    pub(super) fn dates(self) -> Option<&'static str> {
        (self == App::GoPro).then_some("date")
    }

    /// s of a unit of its stamps.
    fn factor(self) -> f64 {
        match self {
            App::SensorLogger => 1e-9,
            App::Phyphox => 1.0,
            App::GoPro => 1e-3,
        }
    }

    /// A text as a stream.
    pub(super) fn stream(self, text: Text, streams: &mut Streams) -> Stream {
        let Text { stem, names, mut columns } = text;
        let group = match self {
            App::GoPro => stem.rsplit('-').next().unwrap_or(&stem).to_owned(),
            _ => stem,
        };
        let mut stream = Stream::new(&group);
        stream.time = std::mem::take(&mut columns[0]);
        let factor = self.factor();
        stream.time.iter_mut().for_each(|t| *t *= factor);
        let mut first: Option<(String, Option<String>)> = None;
        for (name, values) in names.iter().zip(columns).skip(1) {
            if NO_SAMPLES.contains(&name.as_str()) {
                continue;
            }
            if self.dates() == Some(name.as_str()) {
                start(streams, &stream.time, &values);
                continue;
            }
            let (plain, unit) = self.name_and_unit(&group, name, first.as_ref());
            if first.is_none() {
                first = Some((plain.clone(), unit.clone()));
            }
            stream.lines.push(Line { name: plain, unit, values });
        }
        self.take_invalid_out(&mut stream, streams);
        stream
    }

    /// The name of a column without its unit, and the unit. Of GoPro's lists the columns after the first are called by
    /// their number alone.
    fn name_and_unit(
        self,
        group: &str,
        name: &str,
        first: Option<&(String, Option<String>)>,
    ) -> (String, Option<String>) {
        if self == App::SensorLogger {
            let of = |known: &&(&str, &[&str], &str)| {
                (known.0 == group || known.0.is_empty()) && known.1.contains(&name)
            };
            return (name.to_owned(), UNITS.iter().find(of).map(|u| u.2.to_owned()));
        }
        if let (App::GoPro, Some((of, unit)), true) =
            (self, first, name.bytes().all(|b| b.is_ascii_digit()))
        {
            return (format!("{of} #{name}"), unit.clone());
        }
        let (open, close) = if self == App::GoPro { ('[', ']') } else { ('(', ')') };
        let parts = name.strip_suffix(close).and_then(|n| n.rsplit_once(open));
        match parts {
            Some((plain, unit)) if !plain.trim().is_empty() => {
                let plain = plain.trim().to_owned();
                let unit = (!WRONG_UNITS.contains(&plain.as_str())).then(|| unit.to_owned());
                (plain, unit)
            }
            _ => (name.to_owned(), None),
        }
    }

    /// Removes the values that mean "not valid": negative speeds and bearings, and all of its numbers without a fix.
    fn take_invalid_out(self, stream: &mut Stream, streams: &mut Streams) {
        match self {
            App::SensorLogger => {
                for line in &mut stream.lines {
                    if ["speed", "bearing", "course"].contains(&line.name.as_str()) {
                        line.values.iter_mut().filter(|v| **v < 0.0).for_each(|v| *v = f64::NAN);
                    }
                }
            }
            App::GoPro if stream.group.starts_with("GPS") => {
                let fix = ["fix", "GPS (fix)"].iter().find_map(|name| stream.get(name));
                let Some(lost) = fix.map(|f| f.iter().map(|f| *f < 2.0).collect::<Vec<bool>>())
                else {
                    return;
                };
                for line in stream.lines.iter_mut().filter(|l| l.unit.is_some()) {
                    let without = line.values.iter_mut().zip(&lost).filter(|(_, lost)| **lost);
                    without.for_each(|(v, _)| *v = f64::NAN);
                }
                let count = lost.iter().filter(|l| **l).count();
                let message = format!(
                    "{count} samples of {} were written without a fix: left out",
                    stream.group
                );
                streams.warn("no_fix", count, message);
            }
            _ => {}
        }
    }

    /// Steps that need all streams.
    pub(super) fn finish(self, streams: &mut Streams, pauses: &[Pause]) {
        match self {
            App::SensorLogger => total_acceleration(streams),
            App::Phyphox => put_pauses_in(streams, pauses),
            App::GoPro => {}
        }
    }
}

/// The start of a video by the first row that has a date (s since 1970) and a stamp.
fn start(streams: &mut Streams, time: &[f64], dates: &[f64]) {
    let first = time.iter().zip(dates).find(|(t, d)| t.is_finite() && d.is_finite());
    if let (None, Some((time, date))) = (&streams.meta.start_time, first) {
        streams.meta.start_time = start_time(date - time);
    }
}

/// iPhones write the acceleration without gravity and gravity, each by itself; what an accelerometer feels is their sum.
fn total_acceleration(streams: &mut Streams) {
    let of = |name: &str| streams.all.iter().find(|s| s.group == name);
    let (None, Some(own), Some(gravity)) =
        (of("TotalAcceleration"), of("Accelerometer"), of("Gravity"))
    else {
        return;
    };
    let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-4;
    if own.time.len() != gravity.time.len() || !own.time.iter().zip(&gravity.time).all(near) {
        return;
    }
    let mut total =
        Stream { group: "TotalAcceleration".to_owned(), time: own.time.clone(), lines: vec![] };
    for axis in ["x", "y", "z"] {
        let (Some(a), Some(b)) = (own.get(axis), gravity.get(axis)) else { return };
        let values = a.iter().zip(b).map(|(a, b)| a + b).collect();
        total.lines.push(Line { name: axis.to_owned(), unit: Some("m/s2".to_owned()), values });
    }
    streams.all.push(total);
    let told = "Accelerometer and Gravity together, which have the same stamps";
    streams.facts.push(("TotalAcceleration".to_owned(), told.to_owned()));
}

/// A run of the clock of phyphox: from this stamp on, s, it is so much later than at the first start, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pause {
    pub from: f64,
    pub later: f64,
}

/// The clock of phyphox stands still while it pauses: samples after a pause are as much later.
fn put_pauses_in(streams: &mut Streams, pauses: &[Pause]) {
    let waited = pauses.last().map_or(0.0, |p| p.later);
    if waited <= 0.0 {
        return;
    }
    for stream in &mut streams.all {
        for time in &mut stream.time {
            let later = pauses.iter().rev().find(|p| p.from <= *time).map_or(0.0, |p| p.later);
            *time += later;
        }
    }
    let told = format!("{:.1} s in all, put between the samples", waited);
    streams.facts.push(("pauses".to_owned(), told));
}

/// Start (s since 1970) and pauses of `meta/time.csv`: event, experiment time, system time.
pub(super) fn pauses(text: &str) -> (Option<f64>, Vec<Pause>) {
    let (mut start, mut pauses) = (None, Vec::new());
    for line in text.lines().skip(1) {
        let between = [';', '\t'].into_iter().find(|c| line.contains(*c)).unwrap_or(',');
        let cells: Vec<String> =
            line.split(between).map(|c| c.trim().trim_matches('"').replace(',', ".")).collect();
        let [event, experiment, system, ..] = cells.as_slice() else { continue };
        let (Ok(experiment), Ok(system)) = (experiment.parse::<f64>(), system.parse::<f64>())
        else {
            continue;
        };
        if event == "START" {
            let start = *start.get_or_insert(system - experiment);
            pauses.push(Pause { from: experiment, later: system - experiment - start });
        }
    }
    (start, pauses)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(stem: &str, names: &[&str], columns: &[&[f64]]) -> Text {
        Text {
            stem: stem.to_owned(),
            names: names.iter().map(|n| (*n).to_owned()).collect(),
            columns: columns.iter().map(|c| c.to_vec()).collect(),
        }
    }

    #[test]
    fn sensor_logger_has_its_units_and_negative_is_not_valid() {
        let mut streams = Streams::default();
        let location = text(
            "Location",
            &["time", "seconds_elapsed", "speed", "bearing", "latitude"],
            &[
                &[1.7776369e18, 1.7776369e18],
                &[0.0, 1.0],
                &[-1.0, 12.5],
                &[-1.0, 90.0],
                &[45.0, 45.0],
            ],
        );
        let stream = App::SensorLogger.stream(location, &mut streams);
        assert_eq!(stream.time[0], 1_777_636_900.0);
        let names: Vec<(&str, Option<&str>)> =
            stream.lines.iter().map(|l| (l.name.as_str(), l.unit.as_deref())).collect();
        assert_eq!(
            names,
            [("speed", Some("m/s")), ("bearing", Some("deg")), ("latitude", Some("deg"))]
        );
        assert!(stream.lines[0].values[0].is_nan() && stream.lines[0].values[1] == 12.5);
    }

    #[test]
    fn gravity_and_acceleration_are_added_where_they_share_stamps() {
        let sensor = |name: &str, z: f64| {
            let names = ["time", "seconds_elapsed", "z", "y", "x"];
            text(name, &names, &[&[1e18], &[0.0], &[z], &[0.5], &[0.25]])
        };
        let mut streams = Streams::default();
        for (name, z) in [("Accelerometer", 0.1), ("Gravity", 9.7)] {
            let stream = App::SensorLogger.stream(sensor(name, z), &mut streams);
            streams.all.push(stream);
        }
        App::SensorLogger.finish(&mut streams, &[]);
        let total = &streams.all[2];
        assert_eq!(
            (total.get("z"), total.get("x")),
            (Some(&[9.799999999999999][..]), Some(&[0.5][..]))
        );
    }

    #[test]
    fn pauses_of_phyphox_are_put_back() {
        let (start, pauses) = pauses(
            "\"event\",\"experiment time\",\"system time\",\"system time text\"\n\
             \"START\",0.000000000E0,1759650000.000,\"x\"\n\"PAUSE\",1.330E0,1759650001.330,\"x\"\n\
             \"START\",1.330E0,1759650005.330,\"x\"\n",
        );
        assert_eq!(start, Some(1_759_650_000.0));
        let sensor =
            text("Gyroscope", &["Time (s)", "X (rad/s)"], &[&[0.5, 1.2, 1.4], &[1.0, 2.0, 3.0]]);
        let mut streams = Streams::default();
        let stream = App::Phyphox.stream(sensor, &mut streams);
        streams.all.push(stream);
        App::Phyphox.finish(&mut streams, &pauses);
        let time = &streams.all[0].time;
        assert!(time[..2] == [0.5, 1.2] && (time[2] - 5.4).abs() < 1e-6, "{time:?}");
        assert_eq!(streams.all[0].lines[0].name, "X");
        assert_eq!(streams.all[0].lines[0].unit.as_deref(), Some("rad/s"));
    }

    #[test]
    fn columns_of_gopro_have_the_unit_of_their_list_and_none_without_a_fix() {
        let mut streams = Streams::default();
        let names = ["cts", "date", "Accelerometer [m/s²]", "1", "2", "temperature [°C]"];
        let column = [0.0, 5.0];
        let accl = text(
            "GX01_HERO11 Black-ACCL",
            &names,
            &[&column, &[1.7e9, 1.7e9], &column, &column, &column, &column],
        );
        let stream = App::GoPro.stream(accl, &mut streams);
        let said: Vec<(&str, Option<&str>)> =
            stream.lines.iter().map(|l| (l.name.as_str(), l.unit.as_deref())).collect();
        let unit = Some("m/s²");
        assert_eq!(
            said[..3],
            [("Accelerometer", unit), ("Accelerometer #1", unit), ("Accelerometer #2", unit)]
        );
        assert_eq!((stream.group.as_str(), stream.time[1]), ("ACCL", 0.005));
        assert_eq!(streams.meta.start_time.as_deref(), Some("2023-11-14T22:13:20Z"));
        let names = ["cts", "GPS (Lat.) [deg]", "GPS (2D speed) [m/s]", "fix", "precision"];
        let gps = text(
            "Camera-GPS5",
            &names,
            &[&column, &[45.0, 45.1], &[0.1, 0.2], &[0.0, 3.0], &[9999.0, 150.0]],
        );
        let stream = App::GoPro.stream(gps, &mut streams);
        let speed = stream.get("GPS (2D speed)").expect("there");
        assert!(speed[0].is_nan() && speed[1] == 0.2);
        assert_eq!(streams.warnings[0].code, "no_fix");
    }
}
