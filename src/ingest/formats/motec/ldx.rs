//! Beacons of a MoTeC log, from the `.ldx` beside it.
//!
//! MoTeC publishes no description; files show
//!
//! ```text
//! <LDXFile ..> .. <MarkerGroup Name="Beacons" ..><Marker .. ClassName="BCN" Time="2.58129811370032370e+08"/> ..
//! ```
//!
//! with times in microseconds since the start of the log. A channel `Beacon` within the log holds codes that nobody
//! describes and is not read.

use std::io::ErrorKind;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::contract::warning::Warning;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

/// Largest file that is read, bytes: one of an hour has some kilobytes.
const LARGEST: usize = 1 << 22;

/// When the logger passed its start line, s since the start; none where there is no such file beside the log.
pub(super) fn beacons(log: &Location) -> (Vec<f64>, Vec<Warning>) {
    let Some(folder) = log.parent() else { return (Vec::new(), Vec::new()) };
    let beside = folder.join(format!("{}.ldx", log.file_stem()));
    let said = |why: String| {
        let message =
            format!("{beside}, which has the laps of the log, {why}; laps are found by position");
        vec![warning("lap_markers", None, 1, None, message)]
    };
    match source::read(&beside) {
        Ok(bytes) if bytes.len() > LARGEST => (Vec::new(), said("is too large".into())),
        Ok(bytes) => match times(&String::from_utf8_lossy(&bytes)) {
            Ok(times) => (times, Vec::new()),
            Err(why) => (Vec::new(), said(format!("is damaged ({why})"))),
        },
        Err(e) if e.kind() == ErrorKind::NotFound => (Vec::new(), Vec::new()),
        Err(e) => (Vec::new(), said(format!("cannot be read ({e})"))),
    }
}

/// Seconds of the beacons, in the order of the file.
fn times(text: &str) -> Result<Vec<f64>, String> {
    let mut reader = Reader::from_str(text);
    let (mut within, mut out) = (false, Vec::new());
    loop {
        match reader.read_event().map_err(|e| e.to_string())? {
            Event::Start(tag) if tag.name().as_ref() == b"MarkerGroup" => {
                within = value(&tag, b"Name").as_deref() == Some("Beacons");
            }
            Event::End(tag) if tag.name().as_ref() == b"MarkerGroup" => within = false,
            Event::Start(tag) | Event::Empty(tag) if within && tag.name().as_ref() == b"Marker" => {
                let time = value(&tag, b"Time").and_then(|t| t.trim().parse::<f64>().ok());
                out.extend(time.filter(|t| t.is_finite()).map(|t| t * 1e-6));
            }
            Event::Eof => return Ok(out),
            _ => {}
        }
    }
}

fn value(tag: &BytesStart<'_>, key: &[u8]) -> Option<String> {
    let found = tag.attributes().flatten().find(|a| a.key.as_ref() == key)?;
    Some(String::from_utf8_lossy(&found.value).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beacons_are_those_of_their_group_in_seconds() {
        let text = "<?xml version=\"1.0\"?>\n<LDXFile Version=\"1.6\"><Layers><Layer><MarkerBlock>\
            <MarkerGroup Name=\"Beacons\" Index=\"1\">\
            <Marker Version=\"100\" ClassName=\"BCN\" Name=\"Auto 2\" Time=\"6.62360432425654292e+08\"/>\
            <Marker Version=\"100\" ClassName=\"BCN\" Name=\"Auto 1\" Time=\"2.58129811370032370e+08\"/>\
            <Marker Name=\"odd\" Time=\"soon\"/></MarkerGroup>\
            <MarkerGroup Name=\"Notes\"><Marker Time=\"1e6\"/></MarkerGroup></MarkerBlock></Layer></Layers></LDXFile>";
        let found = times(text).expect("whole");
        assert_eq!(
            found.iter().map(|t| (t * 1e3).round()).collect::<Vec<_>>(),
            [662_360.0, 258_130.0]
        );
        assert!(times("<a><b></a>").is_err());
        for n in 0..text.len() {
            let _ = times(&text[..n]);
        }
    }

    #[test]
    fn the_file_beside_the_log_is_read_and_damage_is_said() {
        let folder = tempfile::tempdir().expect("a folder");
        let log = Location::from(folder.path().join("ride.ld"));
        assert_eq!(beacons(&log), (Vec::new(), Vec::new()));
        let write =
            |text: &str| std::fs::write(folder.path().join("ride.ldx"), text).expect("written");
        write("<MarkerGroup Name=\"Beacons\"><Marker Time=\"2e7\"/></MarkerGroup>");
        assert_eq!(beacons(&log).0, [20.0]);
        write("<MarkerGroup Name=\"Beacons\"></Marker>");
        let (times, warnings) = beacons(&log);
        assert!(times.is_empty() && warnings[0].message.contains("ride.ldx"), "{warnings:?}");
    }
}
