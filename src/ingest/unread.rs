//! Formats that are met and not read: what they are, and which export is read instead.

use crate::ingest::format::Head;

/// Ending of the name in lower case, what the file is and what to do.
#[rustfmt::skip]
const UNREAD: &[(&str, &str)] = &[
    (".xrk", "an AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".xrz", "a packed AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".db3", "a ROS 2 bag in SQLite, which is not read: write it as MCAP with `ros2 bag convert`"),
    (".bag", "a ROS 1 bag, which is not read: write it as MCAP with `mcap convert`"),
    (".gz", "compressed: call it `.gz` behind the ending of what is in it (`ride.asc.gz`), or unpack it (`gunzip`)"),
    (".zst", "compressed: call it `.zst` behind the ending of what is in it (`ride.csv.zst`), or unpack it (`unzstd`)"),
    (".zip", "an archive: unpack it first (`unzip`)"),
];

/// What to say of a log that no format claims, if its name or first bytes are known.
pub fn advice(head: &Head<'_>) -> Option<&'static str> {
    let of = |ending: &str| UNREAD.iter().find(|u| u.0 == ending).map(|u| u.1);
    let by_bytes = match head.bytes {
        [0x1f, 0x8b, ..] => of(".gz"),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => of(".zst"),
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
            ("a.zip", b"PK", "unzip"),
            ("a.bin", b"\x1f\x8b\x08", "gunzip"),
            ("bag", b"SQLite format 3\0", "ros2 bag convert"),
        ] {
            let told = told(name, bytes).expect(name);
            assert!(told.contains(wanted), "{name}: {told}");
        }
        assert_eq!(told("a.csv", b"time,velocity_x"), None);
    }
}
