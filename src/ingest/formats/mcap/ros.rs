//! ROS messages: their definition, and their numbers as ROS 1 and ROS 2 (CDR) write them.

use std::collections::HashMap;

use super::fault::Fault;
use super::limits::LISTED;

/// How messages are written.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Wire {
    /// One field after the other.
    Ros1,
    /// With four bytes in front, each number at a multiple of its size.
    Cdr,
}

/// How messages of a type are built.
#[derive(Debug)]
pub(super) struct Definition {
    /// Fields by type; the message itself is the first.
    types: Vec<Vec<Field>>,
    wire: Wire,
}

#[derive(Debug)]
struct Field {
    name: String,
    kind: FieldType,
    count: Count,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum FieldType {
    /// Bytes, whether it has a sign, whether it is a float.
    Number {
        size: usize,
        signed: bool,
        float: bool,
    },
    Text,
    WideText,
    /// Seconds and nanoseconds.
    Stamp {
        signed: bool,
    },
    Message(usize),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

/// Types within types go so deep.
const DEEPEST: usize = 32;

/// So many messages may be within one without a byte of their own: of types that hold nothing but
/// each other there could be more than can be walked through.
const MOST_EMPTY: usize = 1000;

impl Definition {
    /// From the text of a `.msg` file and of those that it needs, as MCAP keeps them.
    ///
    /// # Errors
    /// A sentence about what cannot be understood.
    pub(super) fn parse(name: &str, text: &[u8], wire: Wire) -> Result<Self, Fault> {
        let text = String::from_utf8_lossy(text);
        let mut sections: Vec<(String, Vec<&str>)> = vec![(name.to_owned(), Vec::new())];
        for line in text.lines() {
            let line = line.split('#').next().unwrap_or_default().trim();
            if line.len() > 2 && line.bytes().all(|b| b == b'=') {
                sections.push((String::new(), Vec::new()));
            } else if let Some((section, lines)) = sections.last_mut() {
                match line.strip_prefix("MSG:") {
                    Some(name) => *section = name.trim().to_owned(),
                    None if !line.is_empty() => lines.push(line),
                    None => {}
                }
            }
        }
        let places: HashMap<String, usize> =
            sections.iter().enumerate().rev().map(|(i, (name, _))| (short(name), i)).collect();
        let mut types = Vec::with_capacity(sections.len());
        for (section, lines) in &sections {
            let fields: Result<Vec<Option<Field>>, Fault> =
                lines.iter().map(|line| field(line, section, &places)).collect();
            types.push(fields?.into_iter().flatten().collect());
        }
        Ok(Definition { types, wire })
    }

    /// Every number of a message by its path.
    ///
    /// # Errors
    /// The message is shorter than its definition requires.
    pub(super) fn numbers(
        &self,
        data: &[u8],
        take: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Fault> {
        let (data, big_endian, widest) = match self.wire {
            Wire::Ros1 => (data, false, 1),
            Wire::Cdr => {
                let (head, rest) = data.split_at_checked(4).ok_or("it is too short")?;
                // from 6 on it is XCDR 2, where nothing is at multiples of more than 4
                (rest, head[1] & 1 == 0, if head[1] >= 6 { 4 } else { 8 })
            }
        };
        let mut walk =
            Walk { types: &self.types, wire: self.wire, data, at: 0, seen: 0, big_endian, widest };
        walk.message(0, &mut String::new(), 0, take)
    }
}

/// `sensor_msgs/msg/Imu` is `sensor_msgs/Imu`.
fn short(name: &str) -> String {
    name.replace("/msg/", "/")
}

/// A line of a definition; `None` for constants.
fn field(
    line: &str,
    section: &str,
    places: &HashMap<String, usize>,
) -> Result<Option<Field>, Fault> {
    let mut words = line.split_whitespace();
    let (Some(kind), Some(name)) = (words.next(), words.next()) else {
        return Err(Fault::from(format!("`{line}` is no field")));
    };
    // `uint8 NAME=1`, `uint8 NAME = 1`; a default value has no `=`
    if name.contains('=') || words.next().is_some_and(|w| w.starts_with('=')) {
        return Ok(None);
    }
    let (kind, count) = match kind.split_once('[') {
        None => (kind, Count::One),
        Some((kind, inside)) => match inside.trim_end_matches(']') {
            "" => (kind, Count::Any),
            bound if bound.starts_with("<=") => (kind, Count::Any),
            number => {
                let count =
                    number.parse().map_err(|_| Fault::from(format!("`{line}` is no field")))?;
                (kind, Count::Fixed(count))
            }
        },
    };
    // `string<=10`
    let kind = kind.split("<=").next().unwrap_or(kind);
    let number = |size, signed, float| FieldType::Number { size, signed, float };
    let kind = match kind {
        "bool" | "uint8" | "byte" | "char" => number(1, false, false),
        "int8" => number(1, true, false),
        "uint16" => number(2, false, false),
        "int16" => number(2, true, false),
        "uint32" => number(4, false, false),
        "int32" => number(4, true, false),
        "uint64" => number(8, false, false),
        "int64" => number(8, true, false),
        "float32" => number(4, true, true),
        "float64" => number(8, true, true),
        "string" => FieldType::Text,
        "wstring" => FieldType::WideText,
        "time" => FieldType::Stamp { signed: false },
        "duration" => FieldType::Stamp { signed: true },
        other => {
            let package = section.split('/').next().unwrap_or_default();
            let candidates =
                [short(other), format!("{package}/{other}"), format!("std_msgs/{other}")];
            match candidates.iter().find_map(|name| places.get(name)) {
                Some(at) => FieldType::Message(*at),
                None => match short(other).as_str() {
                    // these often go without saying
                    "builtin_interfaces/Time" => FieldType::Stamp { signed: true },
                    "builtin_interfaces/Duration" => FieldType::Stamp { signed: true },
                    _ => return Err(Fault::from(format!("type `{other}` is not defined"))),
                },
            }
        }
    };
    Ok(Some(Field { name: name.to_owned(), kind, count }))
}

/// On its way through a message.
struct Walk<'a> {
    types: &'a [Vec<Field>],
    wire: Wire,
    data: &'a [u8],
    at: usize,
    /// Messages within the message so far.
    seen: usize,
    big_endian: bool,
    widest: usize,
}

impl Walk<'_> {
    fn message(
        &mut self,
        kind: usize,
        path: &mut String,
        depth: usize,
        take: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Fault> {
        if depth > DEEPEST {
            return Err(Fault::from("its types contain each other".to_owned()));
        }
        self.seen += 1;
        if self.seen > self.data.len() + MOST_EMPTY {
            return Err(Fault::from("its types hold nothing but each other".to_owned()));
        }
        let types = self.types;
        for field in types.get(kind).into_iter().flatten() {
            let length = path.len();
            if !path.is_empty() {
                path.push('.');
            }
            path.push_str(&field.name);
            let count = match field.count {
                Count::One => None,
                Count::Fixed(count) => Some(count),
                Count::Any => Some(self.length()?),
            };
            match count {
                None => self.value(field.kind, path, depth, take)?,
                Some(count) if count > self.data.len() => {
                    return Err(Fault::from("it is shorter than it says".to_owned()));
                }
                Some(count) => {
                    let shown = path.len();
                    for i in 0..count {
                        if count <= LISTED {
                            path.push_str(&format!(".{i}"));
                            self.value(field.kind, path, depth, take)?;
                            path.truncate(shown);
                        } else {
                            self.value(field.kind, path, depth, &mut |_, _| {})?;
                        }
                    }
                }
            }
            path.truncate(length);
        }
        Ok(())
    }

    fn value(
        &mut self,
        kind: FieldType,
        path: &mut String,
        depth: usize,
        take: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Fault> {
        match kind {
            FieldType::Number { size, signed, float } => {
                let raw = self.raw(size)?;
                take(path, number(raw, size, signed, float));
            }
            FieldType::Text => {
                let length = self.length()?;
                self.bytes(length)?;
            }
            FieldType::WideText => {
                let length = self.length()?;
                self.bytes(length.saturating_mul(2))?;
            }
            FieldType::Stamp { signed } => {
                let length = path.len();
                let second = if self.wire == Wire::Cdr { ".nanosec" } else { ".nsec" };
                for part in [".sec", second] {
                    let raw = self.raw(4)?;
                    path.push_str(part);
                    take(path, number(raw, 4, signed, false));
                    path.truncate(length);
                }
            }
            FieldType::Message(at) => self.message(at, path, depth + 1, take)?,
        }
        Ok(())
    }

    fn bytes(&mut self, count: usize) -> Result<&[u8], Fault> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.data.len());
        let end = end.ok_or("it is shorter than it says")?;
        let bytes = &self.data[self.at..end];
        self.at = end;
        Ok(bytes)
    }

    fn raw(&mut self, size: usize) -> Result<u64, Fault> {
        if self.wire == Wire::Cdr {
            self.at = self.at.next_multiple_of(size.min(self.widest));
        }
        let big_endian = self.big_endian;
        let bytes = self.bytes(size)?;
        let add = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
        Ok(if big_endian { bytes.iter().fold(0, add) } else { bytes.iter().rev().fold(0, add) })
    }

    fn length(&mut self) -> Result<usize, Fault> {
        Ok(usize::try_from(self.raw(4)?).unwrap_or(usize::MAX))
    }
}

fn number(raw: u64, size: usize, signed: bool, float: bool) -> f64 {
    match (float, size) {
        (true, 4) => f64::from(f32::from_bits(raw as u32)),
        (true, _) => f64::from_bits(raw),
        (false, _) if signed => {
            let shift = 64 - 8 * size;
            ((raw << shift) as i64 >> shift) as f64
        }
        _ => raw as f64,
    }
}

/// Units that the common messages have by definition (REP 103).
pub(super) fn unit(schema: &str, path: &str) -> Option<&'static str> {
    let schema = short(schema);
    let package = schema.split(['/', '.']).next()?;
    if !matches!(package, "sensor_msgs" | "geometry_msgs" | "nav_msgs" | "foxglove") {
        return None;
    }
    if path.contains("covariance") || path.contains("stamp") {
        return None;
    }
    let last = path.rsplit('.').next()?;
    let has = |name: &str| path.split('.').any(|part| part == name);
    match last {
        "latitude" | "longitude" => Some("deg"),
        "altitude" => Some("m"),
        "x" | "y" | "z" if has("angular_velocity") || has("angular") => Some("rad/s"),
        "x" | "y" | "z" if has("linear_acceleration") => Some("m/s^2"),
        "x" | "y" | "z" if has("linear") => Some("m/s"),
        "x" | "y" | "z" if has("position") || has("translation") => Some("m"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "uint8 ON=1 # a constant\nHeader header\nstring<=10 name\nfloat64[2] pair\n\
        float32[] list\nPoint at\n====\nMSG: std_msgs/Header\nuint32 seq\ntime stamp\n\
        string frame_id\n====\nMSG: geometry_msgs/Point\nint16 x\nbool ok true\n";

    fn numbers(definition: &Definition, data: &[u8]) -> Result<Vec<(String, f64)>, String> {
        let mut found = Vec::new();
        definition.numbers(data, &mut |path, value| found.push((path.to_owned(), value)))?;
        Ok(found)
    }

    #[test]
    fn both_ways_of_writing() {
        // by the definition of the formats, not by this code
        let mut plain: Vec<u8> = Vec::new();
        plain.extend([7, 0, 0, 0, 5, 0, 0, 0, 9, 0, 0, 0, 1, 0, 0, 0, b'f', 1, 0, 0, 0, b'n']);
        plain.extend(1.5_f64.to_le_bytes());
        plain.extend((-2.5_f64).to_le_bytes());
        plain.extend([1, 0, 0, 0]);
        plain.extend(0.5_f32.to_le_bytes());
        plain.extend([0xFE, 0xFF, 1]);
        let definition =
            Definition::parse("geometry_msgs/Thing", TEXT.as_bytes(), Wire::Ros1).expect("parsed");
        let found = numbers(&definition, &plain).expect("read");
        let names: Vec<&str> = found.iter().map(|(n, _)| n.as_str()).collect();
        assert_eq!(
            names,
            [
                "header.seq",
                "header.stamp.sec",
                "header.stamp.nsec",
                "pair.0",
                "pair.1",
                "list.0",
                "at.x",
                "at.ok"
            ]
        );
        let values: Vec<f64> = found.iter().map(|(_, v)| *v).collect();
        assert_eq!(values, [7.0, 5.0, 9.0, 1.5, -2.5, 0.5, -2.0, 1.0]);
        for cut in 0..plain.len() {
            assert!(numbers(&definition, &plain[..cut]).is_err(), "{cut}");
        }
        let mut cdr: Vec<u8> = vec![0, 1, 0, 0];
        cdr.extend([7, 0, 0, 0, 5, 0, 0, 0, 9, 0, 0, 0, 2, 0, 0, 0, b'f', 0, 0, 0]);
        cdr.extend([2, 0, 0, 0, b'n', 0, 0, 0, 0, 0, 0, 0]);
        cdr.extend(1.5_f64.to_le_bytes());
        cdr.extend((-2.5_f64).to_le_bytes());
        cdr.extend([1, 0, 0, 0]);
        cdr.extend(0.5_f32.to_le_bytes());
        cdr.extend([0xFE, 0xFF, 1]);
        let definition = Definition::parse("geometry_msgs/msg/Thing", TEXT.as_bytes(), Wire::Cdr)
            .expect("parsed");
        let found = numbers(&definition, &cdr).expect("read");
        assert_eq!(found[2].0, "header.stamp.nanosec");
        assert_eq!(found.iter().map(|(_, v)| *v).collect::<Vec<f64>>(), values);
    }

    #[test]
    fn lists_that_lie_and_types_that_turn_in_circles() {
        let definition = Definition::parse("a/B", b"uint8[] list", Wire::Ros1).expect("parsed");
        assert!(numbers(&definition, &[0xFF, 0xFF, 0xFF, 0xFF, 1]).is_err());
        let definition = Definition::parse("a/B", b"B b", Wire::Ros1).expect("parsed");
        assert!(numbers(&definition, &[]).is_err());
        assert!(Definition::parse("a/B", b"Unknown u", Wire::Cdr).is_err());
        // each twice in the one before: 2^30 of the last, and no byte of data
        let mut text = "T0 a\nT0 b\n".to_owned();
        for i in 0..30 {
            text += &format!("====\nMSG: a/T{i}\nT{0} a\nT{0} b\n", i + 1);
        }
        text += "====\nMSG: a/T30\n";
        let definition = Definition::parse("a/B", text.as_bytes(), Wire::Ros1).expect("parsed");
        assert!(numbers(&definition, &[]).expect_err("no end").contains("nothing but"));
    }

    #[test]
    fn units_that_are_so_by_definition() {
        assert_eq!(unit("sensor_msgs/msg/Imu", "angular_velocity.z"), Some("rad/s"));
        assert_eq!(unit("sensor_msgs/NavSatFix", "latitude"), Some("deg"));
        assert_eq!(unit("sensor_msgs/msg/Imu", "angular_velocity_covariance.0"), None);
        assert_eq!(unit("my_msgs/Wheels", "linear.x"), None);
    }
}
