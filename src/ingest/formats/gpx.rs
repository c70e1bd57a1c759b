//! GPX tracks, 1.0 and 1.1, and Garmin's TCX: what many apps, watches and navigation devices export.
//!
//! ```text
//! <trk><trkseg><trkpt lat="45.1" lon="9.2"><ele>80.1</ele><time>2026-05-01T12:02:04.2Z</time>
//!   <speed>12.3</speed>                                                           in 1.0
//!   <extensions><gpxtpx:TrackPointExtension><gpxtpx:speed>12.3</gpxtpx:speed>     in 1.1, Garmin and others
//!
//! <Track><Trackpoint><Time>2026-05-01T12:02:04.2Z</Time><AltitudeMeters>80.1</AltitudeMeters>           in TCX
//!   <Position><LatitudeDegrees>45.1</LatitudeDegrees><LongitudeDegrees>9.2</LongitudeDegrees></Position>
//!   <Extensions><ns3:TPX><ns3:Speed>12.3</ns3:Speed>
//! ```
//!
//! Every number within a point is a channel, called by its element's name without the name space. TCX's are
//! called as those of GPX (`ele`, `speed`). Where no point has a `speed`, `speed_from_positions` is the speed along the track. Routes and waypoints are no recordings.

use std::collections::HashMap;
use std::sync::Arc;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::contract::rejection::RejectionCode;
use crate::contract::session::Meta;
use crate::ingest::checks::aids::Aids;
use crate::ingest::clock::stamps;
use crate::ingest::error::Error;
use crate::ingest::formats::csv::{start_time, text};
use crate::ingest::formats::format::{Format, Head};
use crate::ingest::formats::listing::{Decoded, Listing, SourceChannel};
use crate::ingest::maps::{ShippedMap, shipped_map};
use crate::ingest::motion::track;
use crate::ingest::raw::Column;
use crate::ingest::warning::warning;
use crate::store::objects::{Location, source};

#[derive(Debug)]
pub(super) struct Gpx;

/// The speed that is computed where none was recorded.
const COMPUTED: &str = "speed_from_positions";
/// Mark of a TCX.
const TCX: &[u8] = b"<TrainingCenterDatabase";
/// Half the span of a receiver's computed speed, s: enough for 25 Hz whose positions are rounded to 1 cm.
const SPAN: f64 = 0.25;
/// More kinds of numbers than any app writes.
const MOST_NAMES: usize = 100;

impl Format for Gpx {
    const NAME: &'static str = "gpx";
    const DESCRIPTION: &'static str = "GPX and Garmin TCX tracks";
    const CHANNEL_NAMES: &'static str = "element: `speed`, `ele`";
    const EXTENSIONS: &'static [&'static str] = &["gpx", "tcx"];
    const MAPS: &'static [ShippedMap] = &[shipped_map!("gpx")];

    fn sniff(head: &Head<'_>) -> bool {
        let utf8 = text::is_utf16(head.bytes).then(|| text::whole(head.bytes).into_bytes());
        let bytes = utf8.as_deref().unwrap_or(head.bytes);
        let start = &bytes[..bytes.len().min(4096)];
        let gpx = |w: &[u8]| w == b"<gpx " || w == b"<gpx>" || w == b"<gpx\n" || w == b"<gpx\r";
        start.windows(5).any(gpx) || start.windows(TCX.len()).any(|w| w == TCX)
    }

    fn list(log: &Location, _: &Aids) -> Result<Listing, Error> {
        let track = Track::read(log)?;
        let mut facts = track.facts.clone();
        let speed = track.speed_unit(&mut facts);
        let channel = |name: &str, samples: usize| SourceChannel {
            name: name.to_owned(),
            unit: unit_of(name, speed).map(str::to_owned),
            samples: Some(samples as u64),
            ..SourceChannel::default()
        };
        let mut channels = vec![channel("lat", track.time.len()), channel("lon", track.time.len())];
        channels.extend(track.names.iter().zip(&track.numbers).map(|(n, v)| channel(n, v.len())));
        if track.number("speed").is_none() {
            channels.push(channel(COMPUTED, track.time.len()));
        }
        let mut warnings = Vec::new();
        if let Some(why) = &track.broken {
            let message = format!("the text is cut off or damaged ({why}); read up to there");
            warnings.push(warning("truncated", None, 1, None, message));
        }
        if track.without_time > 0 {
            let message = format!("{} points have no time and are left out", track.without_time);
            warnings.push(warning("time_missing", None, track.without_time, None, message));
        }
        let start_time = track.time.first().and_then(|t| start_time(*t));
        let meta = Meta { start_time, ..Meta::default() };
        Ok(Listing { channels, meta, facts, warnings, ..Listing::default() })
    }

    fn decode(log: &Location, _: &Aids, wanted: &[&SourceChannel]) -> Result<Decoded, Error> {
        let track = Track::read(log)?;
        let whole = Arc::new(track.time.clone());
        let column = |channel: &&SourceChannel| {
            let all = |values: Vec<f64>| (Arc::clone(&whole), values);
            let (time, values) = match channel.name.as_str() {
                "lat" => all(track.position[0].clone()),
                "lon" => all(track.position[1].clone()),
                COMPUTED if track.number("speed").is_none() => all(track.speed()),
                name => {
                    let numbers = track.number(name).unwrap_or(&[]);
                    let values = numbers.iter().map(|n| n.1).collect();
                    if numbers.len() == whole.len() {
                        all(values)
                    } else {
                        (Arc::new(numbers.iter().map(|n| track.time[n.0]).collect()), values)
                    }
                }
            };
            Column { name: channel.full(), time, values }
        };
        Ok(Decoded { columns: wanted.iter().map(column).collect(), ..Decoded::default() })
    }
}

/// The points of all tracks, one after the other.
#[derive(Debug, Default)]
struct Track {
    /// Since 1970, s.
    time: Vec<f64>,
    /// Degrees north and east.
    position: [Vec<f64>; 2],
    /// Names of the numbers.
    names: Vec<String>,
    /// Of each name the points that have it, with their numbers.
    numbers: Vec<Vec<(usize, f64)>>,
    /// First points of segments: between two of them nothing was recorded.
    segments: Vec<usize>,
    without_time: usize,
    facts: Vec<(String, String)>,
    broken: Option<String>,
}

/// A point that is being read.
#[derive(Default)]
struct Point {
    position: [f64; 2],
    time: Option<f64>,
    numbers: Vec<(usize, f64)>,
}

impl Track {
    fn read(log: &Location) -> Result<Self, Error> {
        let bytes = source::read(log).map_err(|e| Error::unreadable(log, &e))?;
        let mut track = Track::default();
        let utf8 = text::is_utf16(&bytes).then(|| text::whole(&bytes).into_bytes());
        if let Err(e) = track.parse(utf8.as_deref().unwrap_or(&bytes)) {
            track.broken = Some(e);
        }
        if !track.time.is_empty() {
            return Ok(track);
        }
        let message = if track.without_time > 0 {
            format!(
                "none of the {} track points of {log} has a time: it is a planned route or was exported without; \
                 export the recorded track",
                track.without_time
            )
        } else {
            let why = track.broken.map(|why| format!(" ({why})")).unwrap_or_default();
            format!(
                "{log} has no track point (`trkpt`, `Trackpoint`){why}; export the recorded track"
            )
        };
        Err(Error::new(RejectionCode::NoSamples, message))
    }

    fn parse(&mut self, bytes: &[u8]) -> Result<(), String> {
        let mut reader = Reader::from_reader(bytes);
        let mut place: HashMap<String, usize> = HashMap::new();
        let mut point: Option<Point> = None;
        // elements within the point, the innermost last, and the text of that one
        let mut within: Vec<String> = Vec::new();
        let mut text = String::new();
        let mut top = String::new();
        loop {
            let event = reader.read_event().map_err(|e| e.to_string())?;
            match event {
                Event::Eof => break,
                Event::Start(e) => {
                    text.clear();
                    let name = String::from_utf8_lossy(e.local_name().as_ref()).into_owned();
                    match name.as_str() {
                        "trkpt" | "Trackpoint" => (point, within) = (Some(begun(&e)?), Vec::new()),
                        "trkseg" | "Track" => self.segments.push(self.time.len()),
                        "gpx" => self.creator(&e),
                        _ => {}
                    }
                    if point.is_some() && name != "trkpt" && name != "Trackpoint" {
                        within.push(name);
                    } else {
                        top = name;
                    }
                }
                Event::Empty(e) if e.local_name().as_ref() == b"trkpt" => {
                    begun(&e)?;
                    self.without_time += 1;
                }
                Event::Text(t) => text += &String::from_utf8_lossy(&t),
                Event::End(e) => {
                    match (&mut point, e.local_name().as_ref()) {
                        (Some(_), b"trkpt" | b"Trackpoint") => {
                            self.add(point.take().unwrap_or_default())
                        }
                        (Some(point), name) => {
                            let name = String::from_utf8_lossy(name);
                            self.within(point, &name, text.trim(), &mut place);
                            within.pop();
                        }
                        (None, b"name") if top == "name" && !text.trim().is_empty() => {
                            self.facts.push(("name".to_owned(), text.trim().to_owned()));
                        }
                        _ => {}
                    }
                    text.clear();
                }
                _ => {}
            }
        }
        match point {
            Some(_) => Err("the last point is incomplete".to_owned()),
            None => Ok(()),
        }
    }

    fn creator(&mut self, gpx: &BytesStart<'_>) {
        let creator = gpx.attributes().flatten().find(|a| a.key.as_ref() == b"creator");
        if let Some(creator) = creator {
            let text = String::from_utf8_lossy(&creator.value).into_owned();
            self.facts.push(("creator".to_owned(), text));
        }
    }

    /// An element within a point is at its end.
    fn within(
        &mut self,
        point: &mut Point,
        name: &str,
        text: &str,
        place: &mut HashMap<String, usize>,
    ) {
        let axis = ["LatitudeDegrees", "LongitudeDegrees"].iter().position(|n| *n == name);
        if let Some(axis) = axis {
            point.position[axis] = degrees(text, axis);
            return;
        }
        let name = match name {
            "AltitudeMeters" => "ele",
            "Speed" => "speed",
            "Time" => "time",
            other => other,
        };
        if name == "time" {
            point.time = stamps::text::unix(text).or(point.time);
            return;
        }
        let Some(number) = text.parse::<f64>().ok().filter(|x| x.is_finite()) else { return };
        let at = match place.get(name) {
            Some(at) => *at,
            None if self.names.len() == MOST_NAMES => return,
            None => {
                place.insert(name.to_owned(), self.names.len());
                self.names.push(name.to_owned());
                self.numbers.push(Vec::new());
                self.names.len() - 1
            }
        };
        match point.numbers.iter_mut().find(|n| n.0 == at) {
            // an extension may say again what the point says
            Some(_) => {}
            None => point.numbers.push((at, number)),
        }
    }

    fn add(&mut self, point: Point) {
        let Some(time) = point.time else {
            self.without_time += 1;
            return;
        };
        let at = self.time.len();
        self.time.push(time);
        for (axis, degrees) in self.position.iter_mut().zip(point.position) {
            axis.push(degrees);
        }
        for (place, number) in point.numbers {
            self.numbers[place].push((at, number));
        }
    }

    fn number(&self, name: &str) -> Option<&[(usize, f64)]> {
        let at = self.names.iter().position(|n| n == name)?;
        Some(self.numbers[at].as_slice()).filter(|numbers| !numbers.is_empty())
    }

    /// m/s by GPX 1.0 and Garmin's extension; of the others, which do not say it, what the positions say.
    fn speed_unit(&self, facts: &mut Vec<(String, String)>) -> &'static str {
        let Some(numbers) = self.number("speed") else { return "m/s" };
        let mut speed = vec![f64::NAN; self.time.len()];
        numbers.iter().for_each(|(at, v)| speed[*at] = *v);
        let position = [self.position[0].as_slice(), self.position[1].as_slice()];
        let ratio = track::ratio(&self.time, position, &speed);
        let known = [("km/h", 3.6), ("mph", 1.0 / 0.44704)];
        let near = |factor: f64| ratio.is_some_and(|r| (r / factor - 1.0).abs() < 0.06);
        let Some((unit, _)) = known.into_iter().find(|k| near(k.1)) else { return "m/s" };
        let message = format!(
            "{unit} instead of m/s: it is {:.3} times the speed of the positions",
            ratio.unwrap_or(f64::NAN)
        );
        facts.push(("unit of `speed`".to_owned(), message));
        unit
    }

    /// Speed along the track, segment by segment.
    fn speed(&self) -> Vec<f64> {
        let mut out = Vec::with_capacity(self.time.len());
        let bounds = self.segments.iter().copied().filter(|s| *s > 0);
        for end in bounds.chain([self.time.len()]) {
            let start = out.len();
            if end > start {
                let position = [&self.position[0][start..end], &self.position[1][start..end]];
                out.extend(track::speed(&self.time[start..end], position, SPAN));
            }
        }
        out
    }
}

/// A point at its first element: degrees north and east.
fn begun(element: &BytesStart<'_>) -> Result<Point, String> {
    let mut position = [f64::NAN; 2];
    for attribute in element.attributes() {
        let attribute = attribute.map_err(|e| e.to_string())?;
        let axis = match attribute.key.as_ref() {
            b"lat" => 0,
            b"lon" => 1,
            _ => continue,
        };
        position[axis] = degrees(&String::from_utf8_lossy(&attribute.value), axis);
    }
    Ok(Point { position, ..Point::default() })
}

/// A position on one axis; NaN where the text is none.
fn degrees(text: &str, axis: usize) -> f64 {
    let most = [90.0, 180.0][axis];
    text.trim().parse().ok().filter(|x: &f64| x.abs() <= most).unwrap_or(f64::NAN)
}

/// Units of the standard and of Garmin's extension.
fn unit_of(name: &str, speed: &'static str) -> Option<&'static str> {
    match name {
        "lat" | "lon" | "course" | "bearing" | "heading" | "magvar" => Some("deg"),
        "ele" | "geoidheight" => Some("m"),
        "speed" => Some(speed),
        COMPUTED => Some("m/s"),
        "atemp" | "wtemp" => Some("degC"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn track(points: &str) -> Track {
        let mut track = Track::default();
        let text = format!(
            "<?xml version=\"1.0\"?>\n<gpx version=\"1.1\" creator=\"x\"><trk><name>lap</name><trkseg>{points}"
        );
        track.broken = track.parse(text.as_bytes()).err();
        track
    }

    #[test]
    fn points_with_and_without_extensions() {
        let track = track(
            "<trkpt lat=\"45.5\" lon=\"9.25\"><ele>80.5</ele><time>2026-05-01T12:00:00.5Z</time>\
             <extensions><a:T xmlns:a=\"u\"><a:speed>12.5</a:speed><a:course>271</a:course></a:T></extensions></trkpt>\
             <trkpt lat=\"45.6\" lon=\"9.25\"><time>2026-05-01T14:00:01+02:00</time></trkpt>\
             <trkpt lat=\"45.7\" lon=\"9.25\"/></trkseg></trk></gpx>",
        );
        assert_eq!(track.broken, None);
        assert_eq!(track.time, [1_777_636_800.5, 1_777_636_801.0]);
        assert_eq!(track.position, [vec![45.5, 45.6], vec![9.25, 9.25]]);
        assert_eq!(track.number("speed"), Some(&[(0, 12.5)][..]));
        assert_eq!(track.number("course"), Some(&[(0, 271.0)][..]));
        assert_eq!((track.without_time, track.segments.len()), (1, 1));
        assert!(track.facts.contains(&("name".to_owned(), "lap".to_owned())));
    }

    #[test]
    fn a_tcx_is_a_track_too() {
        let mut track = Track::default();
        let text = "<TrainingCenterDatabase><Activities><Activity><Lap><TotalTimeSeconds>9</TotalTimeSeconds><Track>\
            <Trackpoint><Time>2026-05-01T12:00:00.5Z</Time><Position><LatitudeDegrees>45.5</LatitudeDegrees>\
            <LongitudeDegrees>9.25</LongitudeDegrees></Position><AltitudeMeters>80</AltitudeMeters><Extensions>\
            <ns3:TPX><ns3:Speed>12.5</ns3:Speed></ns3:TPX></Extensions></Trackpoint>\
            <Trackpoint><Time>2026-05-01T12:00:01.5Z</Time></Trackpoint></Track></Lap></Activity></Activities>\
            </TrainingCenterDatabase>";
        track.parse(text.as_bytes()).expect("whole");
        assert_eq!(track.time, [1_777_636_800.5, 1_777_636_801.5]);
        assert_eq!((track.position[0][0], track.position[1][0]), (45.5, 9.25));
        assert!(track.position[0][1].is_nan());
        assert_eq!(track.number("ele"), Some(&[(0, 80.0)][..]));
        assert_eq!(track.number("speed"), Some(&[(0, 12.5)][..]));
        let log = Location::from(std::path::PathBuf::from("ride"));
        assert!(Gpx::sniff(&Head { log: &log, bytes: text.as_bytes() }));
    }

    #[test]
    fn what_breaks_off_is_read_up_to_there() {
        let track = track(
            "<trkpt lat=\"45.5\" lon=\"9.25\"><time>2026-05-01T12:00:00Z</time></trkpt><trkpt lat=\"45.5\" lon=\"9.2",
        );
        assert_eq!(track.time.len(), 1);
        assert!(track.broken.is_some());
    }
}
