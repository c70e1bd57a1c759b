//! Delimited text, through a channel map.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use ::csv::{ByteRecord, ReaderBuilder};

use crate::ingest::map::{ChannelMap, Column, CsvLayout, TimeSource, of_format};
use crate::ingest::{Error, HEAD_LEN, Head, Raw, Reader, ident, warning};
use crate::objects::source::{self, Source};
use crate::session::Meta;
use crate::warning::Warning;

/// The format.
pub const READER: Reader =
    Reader { name: "csv", sniff, identify, read, map, own_clock: false, look: None };

/// Share of a column's cells that may be unreadable before the log is refused.
const BAD_CELLS: f64 = 0.01;

/// Text of any encoding: no control characters but tabs and line ends.
fn sniff(head: &Head<'_>) -> bool {
    head.bytes.iter().all(|b| !b.is_ascii_control() || matches!(b, b'\t' | b'\r' | b'\n'))
}

fn identify(path: &Path, maps: &[ChannelMap]) -> Result<Meta, Error> {
    let (map, columns) = choose(path, maps)?;
    let mut meta = ident::or(ident::from_path(path), map.meta.clone());
    if let TimeSource::Column { name, factor, epoch: true } = &map.time {
        let (mut reader, _) = open(path, &map.csv)?;
        let mut record = ByteRecord::new();
        let at = columns.iter().position(|c| c == name);
        if let Some(at) = at
            && reader.read_byte_record(&mut record).unwrap_or(false)
            && let Some(Cell::Number(stamp)) = record.get(at).map(|c| cell(c, &map.csv))
        {
            meta.start_time = start_time(stamp * factor).or(meta.start_time);
        }
    }
    Ok(meta)
}

/// Unix seconds as RFC 3339, to the millisecond.
fn start_time(seconds: f64) -> Option<String> {
    let ms = (seconds * 1e3).round();
    if !(0.0..4e12).contains(&ms) {
        return None;
    }
    jiff::Timestamp::from_millisecond(ms as i64).ok().map(|t| t.to_string())
}

fn map(path: &Path, maps: &[ChannelMap]) -> Result<Option<ChannelMap>, Error> {
    choose(path, maps).map(|(map, header)| Some(map.fitted(&header)))
}

fn read(path: &Path, maps: &[ChannelMap]) -> Result<Raw, Error> {
    let (map, header) = choose(path, maps)?;
    let map = map.fitted(&header);
    let needed = map.needed();
    let places = needed
        .iter()
        .map(|name| header.iter().position(|h| h == name).ok_or_else(|| map.missing(name, &header)))
        .collect::<Result<Vec<usize>, Error>>()?;
    let (mut decoded, mut warnings) = decode(path, &map.csv, &needed, &places)?;
    let rows = decoded.first().map_or(0, Vec::len);
    let time = match &map.time {
        TimeSource::Rate(rate) => (0..rows).map(|i| i as f64 / rate).collect(),
        TimeSource::Column { factor, .. } => {
            let mut stamps = decoded.remove(0);
            stamps.iter_mut().for_each(|t| *t *= factor);
            stamps
        }
        TimeSource::Own => {
            return Err(Error::new("no_time", format!("channel map {}: no `[time]`", map.name)));
        }
    };
    let time = Arc::new(time);
    let names = if matches!(map.time, TimeSource::Rate(_)) { &needed[..] } else { &needed[1..] };
    let columns: Vec<Column> = names
        .iter()
        .zip(decoded)
        .map(|(name, values)| Column { name: (*name).into(), time: Arc::clone(&time), values })
        .collect();
    let unread: Vec<&str> =
        header.iter().map(String::as_str).filter(|h| !needed.contains(h)).collect();
    if !unread.is_empty() {
        warnings.push(warning(
            "unknown_column",
            None,
            unread.len(),
            None,
            format!("not read by channel map {}: {}", map.name, unread.join(", ")),
        ));
    }
    Ok(Raw {
        meta: identify(path, maps)?,
        tracks: map.apply(&columns)?,
        warnings,
        euler_yaw: map.euler_yaw,
    })
}

/// The map for a file and the file's header under that map's layout.
fn choose<'a>(path: &Path, maps: &'a [ChannelMap]) -> Result<(&'a ChannelMap, Vec<String>), Error> {
    let candidates = of_format(maps, "csv");
    let mut seen = Vec::new();
    for &map in &candidates {
        let header = header(path, &map.csv)?;
        if map.detects(&header) {
            return Ok((map, header));
        }
        seen = header;
    }
    // a single map that was asked for is used even if it does not claim the file
    if let ([map], false) = (&candidates[..], maps.is_empty()) {
        return Ok((map, seen));
    }
    let tried: Vec<&str> = candidates.iter().map(|m| m.name.as_str()).collect();
    Err(Error::new(
        "no_channel_map",
        format!(
            "no channel map fits {} (tried {}); its header is `{}`; write a map for it, see \
             `roadbench schema channel_map`",
            path.display(),
            tried.join(", "),
            seen.join(", ").chars().take(300).collect::<String>()
        ),
    ))
}

fn header(path: &Path, layout: &CsvLayout) -> Result<Vec<String>, Error> {
    open(path, layout).map(|(_, header)| header)
}

type Rows = ::csv::Reader<BufReader<Source>>;

/// A reader that stands on the first row of data, and the header.
fn open(path: &Path, layout: &CsvLayout) -> Result<(Rows, Vec<String>), Error> {
    let fail = |e: std::io::Error| Error::unreadable(path, &e);
    let mut file = BufReader::new(source::open(path).map_err(fail)?);
    let mut line = Vec::new();
    for _ in 0..=layout.skip_rows {
        line.clear();
        (&mut file).take(HEAD_LEN).read_until(b'\n', &mut line).map_err(fail)?;
    }
    let text = String::from_utf8_lossy(&line);
    let text = text.trim_start_matches('\u{feff}').trim();
    let text = text.strip_prefix(layout.header_prefix.as_str()).unwrap_or(text);
    let header: Vec<String> = builder(layout)
        .from_reader(text.as_bytes())
        .records()
        .next()
        .and_then(Result::ok)
        .map(|r| r.iter().map(|cell| cell.trim().to_owned()).collect())
        .unwrap_or_default();
    for _ in 0..layout.rows_after_header {
        line.clear();
        (&mut file).take(HEAD_LEN).read_until(b'\n', &mut line).map_err(fail)?;
    }
    Ok((builder(layout).from_reader(file), header))
}

fn builder(layout: &CsvLayout) -> ReaderBuilder {
    let mut builder = ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(layout.delimiter as u8);
    builder
}

/// The columns at `places`, decoded; NaN where there is no number.
fn decode(
    path: &Path,
    layout: &CsvLayout,
    names: &[&str],
    places: &[usize],
) -> Result<(Vec<Vec<f64>>, Vec<Warning>), Error> {
    let (mut reader, _) = open(path, layout)?;
    let first_line = layout.skip_rows + layout.rows_after_header + 2;
    let mut columns = vec![Vec::new(); places.len()];
    let mut bad: Vec<Option<(usize, u64, String)>> = vec![None; places.len()];
    let mut record = ByteRecord::new();
    loop {
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(e) => {
                let io = std::io::Error::other(e.to_string());
                return Err(Error::unreadable(path, &io));
            }
        }
        for ((column, &place), bad) in columns.iter_mut().zip(places).zip(&mut bad) {
            let value = match record.get(place).map_or(Cell::Missing, |c| cell(c, layout)) {
                Cell::Number(x) => x,
                Cell::Missing => f64::NAN,
                Cell::Bad => {
                    let line = record.position().map_or(0, |p| p.line() - 1) + first_line as u64;
                    let text = || String::from_utf8_lossy(&record[place]).into_owned();
                    bad.get_or_insert_with(|| (0, line, text())).0 += 1;
                    f64::NAN
                }
            };
            column.push(value);
        }
    }
    let rows = columns.first().map_or(0, Vec::len);
    let mut warnings = Vec::new();
    for (name, bad) in names.iter().zip(bad) {
        let Some((count, line, text)) = bad else { continue };
        let text: String = text.chars().take(40).collect();
        let message = format!(
            "column `{name}`: {count} of {rows} cells are not numbers, the first is `{text}` in \
             line {line}"
        );
        if count as f64 > BAD_CELLS * rows as f64 {
            let hint = "; name it in the map's `csv.missing` if it means no sample";
            return Err(Error::new("bad_cell", message + hint));
        }
        let message = message + "; taken as missing";
        warnings.push(warning("bad_cell", None, count, None, message));
    }
    Ok((columns, warnings))
}

enum Cell {
    Number(f64),
    Missing,
    Bad,
}

/// One cell. Infinities are no measurement, so they are missing.
fn cell(bytes: &[u8], layout: &CsvLayout) -> Cell {
    let Ok(text) = std::str::from_utf8(bytes) else { return Cell::Bad };
    let text = text.trim();
    if text.is_empty() || layout.missing.iter().any(|m| m == text) {
        return Cell::Missing;
    }
    let parsed = if layout.decimal == ',' && text.contains(',') {
        text.replace(',', ".").parse::<f64>()
    } else {
        text.parse::<f64>()
    };
    match parsed {
        Ok(x) if x.is_finite() => Cell::Number(x),
        Ok(_) => Cell::Missing,
        Err(_) => Cell::Bad,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::channel::Channel;

    const MAP: &str = "name = 'x'\nformat = 'csv'\n[csv]\ndelimiter = ';'\ndecimal = ','\n\
         skip_rows = 1\nrows_after_header = 1\nmissing = ['n/a']\n[detect]\ncolumns = ['v']\n\
         [time]\ncolumn = 't'\nunit = 'ms'\n[channel.velocity_x]\nfrom = 'v'\nunit = 'km/h'\n";

    fn log(text: &str) -> (tempfile::TempDir, std::path::PathBuf) {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("ride.csv");
        std::fs::write(&path, text).expect("written");
        (folder, path)
    }

    fn maps() -> Vec<ChannelMap> {
        vec![ChannelMap::parse(MAP, "x.toml").expect("a map")]
    }

    #[test]
    fn decimal_comma_units_row_prefix_and_missing_cells() {
        let (_folder, path) =
            log("logger 3\n# t;extra;v\nms;;km/h\n0;1;36,0\n10;;n/a\n20;2;\n30;2\n40;1;7,2e1\n");
        let raw = read(&path, &maps()).expect("read");
        let track = &raw.tracks[0];
        assert_eq!(track.channel, Channel::VelocityX);
        assert_eq!(*track.time, [0.0, 0.01, 0.02, 0.03, 0.04]);
        assert_eq!(track.values[0], 10.0);
        assert!(track.values[1..4].iter().all(|v| v.is_nan()));
        assert_eq!(track.values[4], 20.0);
        assert_eq!(raw.warnings[0].code, "unknown_column");
        assert!(raw.warnings[0].message.contains("extra"));
    }

    #[test]
    fn unreadable_cells_name_column_and_line() {
        let (_folder, path) = log("l\nt;v\n;\n0;1\n10;oops\n20;3\n");
        let error = read(&path, &maps()).expect_err("a third is bad");
        assert_eq!(error.code, "bad_cell");
        assert!(error.message.contains("`v`") && error.message.contains("line 5"), "{error}");
        let mut text = "l\nt;v\n;\n".to_owned();
        (0..500).for_each(|i| text += &format!("{i};{}\n", if i == 7 { "oops" } else { "1" }));
        let (_folder, path) = log(&text);
        let raw = read(&path, &maps()).expect("rare enough");
        assert!(raw.tracks[0].values[7].is_nan());
        assert!(raw.warnings.iter().any(|w| w.code == "bad_cell" && w.message.contains("line 11")));
    }

    #[test]
    fn an_unknown_header_says_what_was_tried() {
        let (_folder, path) = log("a,b\n1,2\n");
        let error = read(&path, &[]).expect_err("no map");
        assert_eq!(error.code, "no_channel_map");
        assert!(error.message.contains("session_csv") && error.message.contains("a, b"), "{error}");
        let error = read(&path, &maps()).expect_err("forced map");
        assert_eq!(error.code, "missing_column");
    }

    #[test]
    fn unix_stamps_give_the_start_time() {
        assert_eq!(start_time(1_692_117_187.464).as_deref(), Some("2023-08-15T16:33:07.464Z"));
        assert_eq!(start_time(f64::NAN), None);
    }
}
