//! Formats that are met and not read: what they are, and which export is read instead.

use crate::ingest::formats::format::Head;

/// Ending of the name in lower case, what the file is and what to do.
#[rustfmt::skip]
const UNREAD: &[(&str, &str)] = &[
    (".xrk", "an AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".xrz", "a packed AiM log, which is not read: open it in RaceStudio and export CSV with all channels"),
    (".db3", "a ROS 2 bag in SQLite, which is not read: write it as MCAP with `ros2 bag convert`"),
    (".bag", "a ROS 1 bag, which is not read: write it as MCAP with `mcap convert`"),
    (".gz", "compressed: call it `.gz` after the ending of what is in it (`ride.asc.gz`), or unpack it (`gunzip`)"),
    (".zst", "compressed: call it `.zst` after the ending of what is in it (`ride.csv.zst`), or unpack it (`unzstd`)"),
    (".bz2", "packed with bzip2, which is not read: unpack it (`bunzip2`), or pack it as `.gz` or `.zst`"),
    (".xz", "packed with xz, which is not read: unpack it (`unxz`), or pack it as `.gz` or `.zst`"),
    (".7z", "packed with 7-Zip, which is not read: unpack it, or pack it as `.zip`, `.gz` or `.zst`"),
    (".rar", "packed with RAR, which is not read: unpack it, or pack it as `.zip`, `.gz` or `.zst`"),
    (".lz4", "packed with LZ4, which is not read: unpack it (`unlz4`), or pack it as `.gz` or `.zst`"),
    (".zip", "an archive: unpack it first (`unzip`)"),
    (".fit", "called a FIT file, but without the header of one: it is damaged or another kind of \
              file; export the activity again as FIT, GPX or TCX"),
    (".kml", "a KML file of Google Earth, which is not read: export the track as GPX, or convert it with `gpsbabel -i kml -o gpx`"),
    (".kmz", "a packed KML file of Google Earth, which is not read: export the track as GPX"),
    (".nmea", "called an NMEA log, but without a sentence that roadbench reads (`$GPRMC,...`, \
               `$GPGGA,...`): have the receiver write RMC and GGA"),
    (".ubx", "called a u-blox log, but without a UBX message: have the receiver write UBX NAV-PVT, \
              or NMEA RMC and GGA"),
    (".xlsx", "a workbook of a spreadsheet, which is not read: save the sheet as CSV"),
    (".xls", "a workbook of a spreadsheet, which is not read: save the sheet as CSV"),
    (".ods", "a workbook of a spreadsheet, which is not read: save the sheet as CSV"),
    (".json", "JSON, which is not read: export CSV, or write the samples as one table with a column for each channel"),
    (".mat", "a MATLAB file, which is not read: write it as CSV (`writetable`) or Parquet (`parquetwrite`)"),
    (".h5", "an HDF5 file, which is not read: write its samples as CSV or Parquet"),
    (".mp4", "a video, which is not read: take the telemetry out as CSV or GPX first (GoPro: Telemetry Extractor, gopro2gpx)"),
    (".rkd", "a Race-Keeper log, which is not read: export CSV with RK-ExportTool, which is beside it, or GPX with rkd-telemetry-extractor"),
    (".rcz", "a session of RaceChrono, a format that is not published and not read: export CSV v3 \
              or VBO from the app"),
    (".ibt", "a log of iRacing, which is not read: convert it to MoTeC `.ld`, or export CSV"),
    (".drk", "an old AiM log, which is not read: open it in Race Studio 2 and export CSV with all channels"),
    (".feather", "an Arrow file, which is not read: write it as Parquet"),
    (".pdf", "a PDF, which is no log: export the samples as CSV"),
    (".html", "a page of HTML, which is no log: was it downloaded without logging in?"),
];

/// Whether that is said of a file that is packed in a way that is not read.
pub(crate) fn is_packed(advice: &str) -> bool {
    advice.starts_with("packed with")
}

/// Message about a log that no format claims, if its name or first bytes are known.
pub(crate) fn advice(head: &Head<'_>) -> Option<&'static str> {
    let of = |ending: &str| UNREAD.iter().find(|u| u.0 == ending).map(|u| u.1);
    let by_bytes = match head.bytes {
        [0x1f, 0x8b, ..] => of(".gz"),
        [0x28, 0xb5, 0x2f, 0xfd, ..] => of(".zst"),
        bytes if bytes.starts_with(b"BZh") => of(".bz2"),
        bytes if bytes.starts_with(b"\xfd7zXZ\0") => of(".xz"),
        bytes if bytes.starts_with(b"7z\xbc\xaf\x27\x1c") => of(".7z"),
        bytes if bytes.starts_with(b"Rar!\x1a\x07") => of(".rar"),
        [0x04, 0x22, 0x4d, 0x18, ..] => of(".lz4"),
        bytes if bytes.starts_with(b"SQLite format 3\0") => of(".db3"),
        bytes if bytes.starts_with(b"#ROSBAG") => of(".bag"),
        bytes if bytes.starts_with(b"<hCNF") => of(".xrk"),
        [0xd0, 0xcf, 0x11, 0xe0, ..] => of(".xls"),
        bytes if bytes.starts_with(b"\x89HDF\r\n") => of(".h5"),
        bytes if bytes.starts_with(b"MATLAB 5.0") => of(".mat"),
        bytes if bytes.starts_with(b"ARROW1") => of(".feather"),
        bytes if bytes.starts_with(b"%PDF") => of(".pdf"),
        bytes if bytes.get(4..8) == Some(b"ftyp") => of(".mp4"),
        bytes if bytes.starts_with(b"PK\x03\x04") && has(bytes, b"xl/") => of(".xlsx"),
        bytes if bytes.starts_with(b"PK\x03\x04") && has(bytes, b"opendocument.spreadsheet") => {
            of(".ods")
        }
        bytes => by_text(bytes).and_then(of),
    };
    let by_name = || {
        let fits = |ending: &str| head.has_extension(ending.trim_start_matches('.'));
        UNREAD.iter().find(|u| fits(u.0)).map(|u| u.1)
    };
    by_bytes.or_else(by_name)
}

fn has(bytes: &[u8], words: &[u8]) -> bool {
    bytes[..bytes.len().min(4096)].windows(words.len()).any(|w| w == words)
}

/// The ending of texts that are no table.
fn by_text(bytes: &[u8]) -> Option<&'static str> {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    match text {
        [b'{', ..] => Some(".json"),
        [b'[', rest @ ..] if rest.trim_ascii_start().starts_with(b"{") => Some(".json"),
        _ if has(text, b"<kml") => Some(".kml"),
        _ if text.len() > 5 && text[..5].eq_ignore_ascii_case(b"<html") => Some(".html"),
        _ if text.len() > 9 && text[..9].eq_ignore_ascii_case(b"<!doctype") => Some(".html"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::objects::Location;
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
            ("ride.xrz", b"\x78\x9c", "RaceStudio"),
            ("outing", b"<hCNF", "RaceStudio"),
            ("outing.rkd", b"\x89RKD", "RK-ExportTool"),
            ("ride.rcz", b"PK\x03\x04\x14\0", "VBO"),
            ("ride.fit", b"\x0e\x10", "GPX or TCX"),
            ("ride.nmea", b"\x00\x01", "RMC and GGA"),
            ("ride.ubx", b"\x00\x01", "NAV-PVT"),
            ("ride.csv", b"PK\x03\x04\x14\0\x06\0\x08\0xl/workbook.xml", "save the sheet as CSV"),
            ("ride.csv.bz2", b"BZh91AY&SY", "bunzip2"),
            ("ride.csv", b"\xfd7zXZ\0\0\x04", "unxz"),
            ("ride.csv", b"\n<?xml version=\"1.0\"?><kml xmlns=\"x\">", "GPX"),
            ("ride.log", b"[\n {\"t\": 0}]", "JSON"),
        ] {
            let told = told(name, bytes).expect(name);
            assert!(told.contains(wanted), "{name}: {told}");
        }
        assert_eq!(told("a.csv", b"time,velocity_x"), None);
    }
}
