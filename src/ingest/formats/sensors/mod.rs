//! A ZIP archive with one text for each sensor, as phones' apps and GoPro extractors write them; and one such text of a
//! GoPro alone.
//!
//! Every text becomes a stream, each on its own clock ([`streams`](super::streams)): `Gyroscope/x`, `GPS5/GPS (Lat.)`. The
//! session's single clock is made later, as for every log. [`apps`] knows names, units and clocks of each source.
//! Texts without numbers, pictures and videos are passed by.

use crate::contract::rejection::RejectionCode;
use crate::ingest::checks::aids::Aids;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::{start_time, text};
use crate::ingest::formats::format::{Format, Head, guarded};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::formats::streams::Streams;
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::store::objects::{Location, source};

mod apps;
mod archive;
mod fixes;
mod parts;
mod table;

use apps::App;
use archive::Entry;

/// Texts of sensors.
#[derive(Debug)]
pub(super) struct Sensors;

const ZIP: &[u8] = b"PK\x03\x04";
/// Paths that are met in archives of sensors, for the head of a file.
const KNOWN: [&[u8]; 8] = [
    b"Accelerometer.csv",
    b"Gyroscope.csv",
    b"Location.csv",
    b"TotalAcceleration.csv",
    b"Linear Accelerometer.csv",
    b"-GPS5.csv",
    b"-ACCL.csv",
    b"-GYRO.csv",
];

impl Format for Sensors {
    const NAME: &'static str = "sensors";
    const DESCRIPTION: &'static str =
        "A ZIP of CSV, one for each sensor: Sensor Logger, phyphox, GoPro telemetry";
    const CHANNEL_NAMES: &'static str = "`Gyroscope/x`, `Location/speed`";
    const EXTENSIONS: &'static [&'static str] = &["zip"];
    const MAPS: &'static [ShippedMap] =
        &[shipped_map!("sensor_logger"), shipped_map!("phyphox"), shipped_map!("gopro")];

    fn sniff(head: &Head<'_>) -> bool {
        if head.bytes.starts_with(ZIP) {
            let has = |name: &&[u8]| head.bytes.windows(name.len()).any(|w| w == *name);
            return KNOWN.iter().any(has) || head.has_extension("zip");
        }
        is_gopro(head.bytes)
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        Ok(read(log)?.listing())
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        Ok(read(log)?.decoded(wanted))
    }
}

/// Whether a text is one sensor of a GoPro.
fn is_gopro(bytes: &[u8]) -> bool {
    let first = text::is_text(bytes).then(|| table::names(bytes));
    first.is_some_and(|names| App::of(&names) == Some(App::GoPro))
}

fn read(log: &Location) -> Result<Streams, Error> {
    let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
    let csv = |path: &str| path.to_ascii_lowercase().ends_with(".csv");
    let entries = if bytes.starts_with(ZIP) {
        guarded(log, || archive::entries(&bytes, csv))?
    } else {
        let path = format!("{}.csv", log.file_stem());
        vec![Entry { path, bytes, broken: None }]
    };
    let mut streams = of_entries(log, entries)?;
    // seconds since the start of a recording are no date
    let stamps = streams.all.iter().flat_map(|s| s.time.iter().copied());
    if stamps.filter(|t| t.is_finite()).fold(f64::INFINITY, f64::min) > DATED {
        streams.start_by_stamps();
    }
    Ok(streams)
}

/// Stamps beyond this count from 1970, s.
const DATED: f64 = 1e8;
/// Rows of a text from which on it is worth a word that it is not read.
const ROWS: usize = 10;

fn of_entries(log: &Location, entries: Vec<Entry>) -> Result<Streams, Error> {
    let mut streams = Streams::default();
    let mut app: Option<App> = None;
    let (mut passed_by, mut lost) = (Vec::new(), Vec::new());
    let (mut clock, mut empty) = ((None, Vec::new()), 0);
    for mut entry in entries {
        if entry.path.ends_with("meta/time.csv") {
            clock = apps::pauses(&String::from_utf8_lossy(&entry.bytes));
            continue;
        }
        let own = App::of(&table::names(&entry.bytes));
        if let Some(why) = entry.broken.take() {
            let message = format!(
                "`{}` cannot be unpacked whole ({why}); read as far as it goes",
                entry.path
            );
            streams.warn("truncated", 1, message);
        }
        let is_table = || table::rows(&entry.bytes) > ROWS;
        if own.is_none_or(|own| app.is_some_and(|app| app != own)) && is_table() {
            lost.push(format!("`{}`", entry.name()));
        }
        let (Some(own), stem) = (own, entry.stem().to_owned()) else {
            passed_by.push(entry.name().to_owned());
            continue;
        };
        let of = *app.get_or_insert(own);
        if of != own {
            passed_by.push(entry.name().to_owned());
            continue;
        }
        let label = Location::Local(format!("{log}: {}", entry.path).into());
        match table::read(&label, &stem, entry.bytes, of.dates(), &mut streams)? {
            Some(text) => {
                let mut stream = of.stream(text, &mut streams);
                if of != App::GoPro && stream.group.contains("Location") {
                    fixes::keep_best(&mut stream, &mut streams);
                }
                // the same sensor twice: of a second recording in the archive
                let twice = streams.all.iter().any(|s| s.group == stream.group);
                if twice {
                    return Err(Error::new(
                        RejectionCode::AmbiguousColumn,
                        several(log, &stream.group),
                    ));
                }
                streams.all.push(stream);
            }
            None => empty += 1,
        }
    }
    let Some(app) = app else {
        return Err(Error::new(RejectionCode::NoChannels, nothing(log, &passed_by)));
    };
    app.finish(&mut streams, &clock.1);
    if !lost.is_empty() {
        let names: String = lost.join(", ").chars().take(200).collect();
        let message = format!(
            "not read of the archive: {names}: they are no texts of {}; unpack them and convert each by a map of its own",
            app.name()
        );
        streams.warn("unknown_column", lost.len(), message);
    }
    if app == App::Phyphox {
        parts::join(&mut streams).map_err(|rides| {
            let names = rides.join("`, `");
            let message = format!(
                "{log} holds {} rides, `{names}`, whose clocks overlap: unpack it and convert each of them by itself",
                rides.len()
            );
            Error::new(RejectionCode::AmbiguousColumn, message)
        })?;
    }
    streams.meta.start_time = clock.0.and_then(start_time).or(streams.meta.start_time.take());
    for stream in &mut streams.all {
        stream.add_speed(["latitude", "longitude"], &["speed"]);
        stream.add_speed(["Latitude", "Longitude"], &["Velocity", "Speed"]);
        stream.add_speed(["GPS (Lat.)", "GPS (Long.)"], &["GPS (2D speed)", "GPS (2D)"]);
    }
    streams.facts.push(("written by".to_owned(), app.name().to_owned()));
    if empty > 0 {
        streams.facts.push(("sensors without samples".to_owned(), empty.to_string()));
    }
    if !passed_by.is_empty() {
        let names: String = passed_by.join(", ").chars().take(200).collect();
        streams.facts.push(("not read".to_owned(), names));
    }
    if streams.is_empty() {
        let message = format!(
            "none of the sensors in {log} has a sample; record anew, with location and motion on"
        );
        return Err(Error::new(RejectionCode::NoSamples, message));
    }
    Ok(streams)
}

fn several(log: &Location, sensor: &str) -> String {
    format!(
        "{log} has `{sensor}` more than once: it holds several recordings; make an archive of each of them"
    )
}

fn nothing(log: &Location, files: &[String]) -> String {
    let names: String = files.join(", ").chars().take(200).collect();
    let names = if names.is_empty() { "no CSV".to_owned() } else { names };
    format!(
        "{log} is an archive of {names}: none is a sensor's text of Sensor Logger, phyphox or GoPro telemetry; \
         if it holds a log, unpack it first (`unzip`)"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(name: &str, bytes: &[u8]) -> (tempfile::TempDir, Location) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).expect("written");
        (folder, Location::from(path))
    }

    const LOCATION: &str = "time,seconds_elapsed,speed,latitude,longitude\n\
        1777636900000000000,0.0,10,45.0,9.0\n1777636901000000000,1.0,11,45.0001,9.0\nx,2.0,11,45.0,9.0\n";
    const GYRO: &str = "time,seconds_elapsed,z,y,x\n1777636900010000000,0.01,0.1,0.2,0.3\n\
        1777636900020000000,0.02,0.1,0.2,0.3\n";

    #[test]
    fn each_sensor_keeps_its_own_clock() {
        let bytes = archive::packed(&[
            ("Location.csv", LOCATION),
            ("Gyroscope.csv", GYRO),
            ("Metadata.csv", "version,device name\n3,phone\n"),
            ("Annotation.csv", "time,seconds_elapsed,text\n"),
        ]);
        let (_folder, log) = log("ride.zip", &bytes);
        let head = Head { log: &log, bytes: &bytes };
        assert!(Sensors::sniff(&head));
        let streams = read(&log).expect("read");
        let groups: Vec<(&str, usize)> =
            streams.all.iter().map(|s| (s.group.as_str(), s.time.len())).collect();
        assert_eq!(groups, [("Location", 2), ("Gyroscope", 2)]);
        assert!((streams.all[1].time[1] - 1_777_636_900.02).abs() < 1e-6);
        assert_eq!(streams.meta.start_time.as_deref(), Some("2026-05-01T12:01:40Z"));
        assert!(
            streams.warnings.iter().any(|w| w.code == "time_missing" || w.code == "bad_line"),
            "{:?}",
            streams.warnings
        );
    }

    #[test]
    fn what_is_not_read_of_an_archive_is_said() {
        let ride = |start: u32| {
            let row = |i: u32| format!("{},54.0,47.0,8.{i:03}\n", start + i);
            let rows: String = (0..20).map(row).collect();
            format!("Time (s),GPS Speed (km/h),Latitude (deg),Longitude (deg)\n{rows}")
        };
        let (a, b) = (ride(0), ride(20));
        let (_folder, log) =
            log("ride.zip", &archive::packed(&[("part1.csv", &a), ("part2.csv", &b)]));
        let streams = read(&log).expect("parts of one ride");
        assert_eq!((streams.all.len(), streams.all[0].time.len()), (1, 40));
        assert_eq!(streams.meta.start_time, None, "elapsed seconds are no date");
        let (_folder, log) =
            self::log("ride.zip", &archive::packed(&[("a/1.csv", &a), ("b/2.csv", &a)]));
        let error = read(&log).expect_err("two rides");
        assert!(error.message.contains("`1`, `2`"), "{error}");
        let other = format!("rpm,gear\n{}", "3000,2\n".repeat(20));
        let bytes = archive::packed(&[
            ("ride.csv", &a),
            ("obd.csv", &other),
            ("Metadata.csv", "a,b\n1,2\n"),
        ]);
        let (_folder, log) = self::log("ride.zip", &bytes);
        let streams = read(&log).expect("one ride");
        let said: Vec<&str> = streams.warnings.iter().map(|w| w.message.as_str()).collect();
        assert!(
            said.len() == 1 && said[0].contains("`obd.csv`") && !said[0].contains("Metadata"),
            "{said:?}"
        );
    }

    #[test]
    fn archives_of_anything_else_say_what_to_do() {
        for (files, words) in [
            (&[("notes.csv", "a,b\n1,2\n")][..], "unzip"),
            (&[("a/Location.csv", LOCATION), ("b/Location.csv", LOCATION)], "several recordings"),
            (&[("Location.csv", "time,seconds_elapsed,speed\n")], "has a sample"),
        ] {
            let (_folder, log) = log("ride.zip", &archive::packed(files));
            let error = read(&log).expect_err(words);
            assert!(error.message.contains(words), "{error}");
        }
    }
}
