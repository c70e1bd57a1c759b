//! Formats that are met and not read: what they are, and which export is read instead.

use crate::ingest::format::Head;

/// Ending of the name in lower case, what the file is and what to do.
#[rustfmt::skip]
const UNREAD: &[(&str, &str)] = &[
    (".xrk", "an AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".xrz", "a packed AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".gpx", "a GPX track, which is not read: export CSV with time, speed and position in the app that recorded it"),
    (".db3", "a ROS 2 bag in SQLite, which is not read: write it as MCAP with `ros2 bag convert`"),
    (".bag", "a ROS 1 bag, which is not read: write it as MCAP with `mcap convert`"),
    (".sst", "a suspension telemetry log, which is not read: export CSV from the program that shows it"),
    (".trc", "a PEAK trace, which is not read: export ASC or BLF, or write one with `can_logconvert` of python-can"),
    (".gz", "compressed: unpack it first (`gunzip`)"),
    (".zip", "an archive: unpack it first (`unzip`)"),
];

/// What to say of a log that no format claims, if its name or first bytes are known.
pub fn advice(head: &Head<'_>) -> Option<&'static str> {
    let of = |ending: &str| UNREAD.iter().find(|u| u.0 == ending).map(|u| u.1);
    let by_bytes = match head.bytes {
        [0x1f, 0x8b, ..] => of(".gz"),
        bytes if bytes.starts_with(b"SQLite format 3\0") => of(".db3"),
        bytes if bytes.starts_with(b"#ROSBAG") => of(".bag"),
        _ => None,
    };
    let by_name = || {
        let fits = |ending: &str| head.has_extension(ending.trim_start_matches('.'));
        UNREAD.iter().find(|u| fits(u.0)).map(|u| u.1)
    };
    by_bytes.or_else(by_name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::objects::Location;
    use std::path::PathBuf;

    #[test]
    fn what_is_not_read_says_what_is() {
        let told = |name: &str, bytes: &[u8]| {
            let log = Location::from(PathBuf::from(name));
            advice(&Head { log: &log, bytes })
        };
        for (name, bytes, wanted) in [
            ("a.XRK", &b"<hCNF"[..], "RaceStudio"),
            ("lap.gpx", b"<?xml version", "CSV"),
            ("a.asc.gz", b"\x1f\x8b\x08", "gunzip"),
            ("a.bin", b"\x1f\x8b\x08", "gunzip"),
            ("bag", b"SQLite format 3\0", "ros2 bag convert"),
            ("a.trc", b";$FILEVERSION=2.0", "python-can"),
        ] {
            let told = told(name, bytes).expect(name);
            assert!(told.contains(wanted), "{name}: {told}");
        }
        assert_eq!(told("a.csv", b"time,velocity_x"), None);
    }
}
