//! Layouts of delimited text: separators, decimals, line ends, encodings, cells too many or too few.

use super::Expected::{Refused, Right, Warned};
use super::*;

/// The usual text with one line changed.
fn changed(line: usize, change: impl Fn(&str) -> String) -> String {
    let text = plain();
    let lines: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(i, l)| if i == line { change(l) } else { l.to_owned() })
        .collect();
    lines.join("\n") + "\n"
}

/// Every line of numbers changed.
fn rows(change: impl Fn(&str) -> String) -> String {
    let text = plain();
    let lines: Vec<String> = text
        .lines()
        .enumerate()
        .map(|(i, l)| if i > 0 { change(l) } else { l.to_owned() })
        .collect();
    lines.join("\n") + "\n"
}

/// A row with something instead of the comma behind a cell.
fn joined(line: &str, behind: usize, between: &str) -> String {
    let cells: Vec<&str> = line.split(',').collect();
    format!("{}{between}{}", cells[..=behind].join(","), cells[behind + 1..].join(","))
}

fn utf16(text: &str, mark: bool, little: bool) -> Vec<u8> {
    let letters = mark.then_some(0xfeff).into_iter().chain(text.encode_utf16());
    letters.flat_map(|u| if little { u.to_le_bytes() } else { u.to_be_bytes() }).collect()
}

#[test]
fn separators_and_decimals() {
    let comma = |text: &str| text.replace('.', ",");
    hold(vec![
        case("commas", plain(), Right),
        case("tabs", plain().replace(',', "\t"), Right),
        case("semicolons", plain().replace(',', ";"), Right),
        case("semicolons and decimal commas", comma(&plain().replace(',', ";")), Right),
        case("tabs and decimal commas", comma(&plain().replace(',', "\t")), Right),
        case("bars", plain().replace(',', "|"), Right),
        case("bars with blanks", plain().replace(',', " | "), Right),
        case(
            "blanks",
            plain().replace("GPS Speed (km/h)", "Speed_kmh").replace(" (", "_(").replace(',', " "),
            Right,
        ),
        case("aligned with blanks", plain().replace(',', "    "), Right),
        case(
            "decimal commas in quotes",
            rows(|l| {
                l.split(',').map(|c| format!("\"{}\"", comma(c))).collect::<Vec<_>>().join(",")
            }),
            Right,
        ),
        case("everything in quotes", rows(|l| format!("\"{}\"", l.replace(',', "\",\""))), Right),
        case("decimal commas without quotes", rows(comma), Refused("line 2")),
        case("blanks behind commas", plain().replace(',', ", "), Right),
    ]);
}

#[test]
fn encodings_and_line_ends() {
    let text = plain();
    let with_mark = format!("\u{feff}{text}");
    let cut = text.rfind("29.00").expect("a row");
    let lost = [&text.as_bytes()[..cut + 12], &[0; 700][..]].concat();
    let middle = text.find("15.00").expect("a row");
    let went_on =
        [&text.as_bytes()[..middle], b"14.9", &[0; 300][..], &text.as_bytes()[middle..]].concat();
    let latin: Vec<u8> =
        text.replace("Lean (deg)", "Schr\u{e4}glage (\u{b0})").chars().map(|c| c as u8).collect();
    let named = |names: [&str; 3], encoding: &'static encoding_rs::Encoding| {
        let [speed, lat, lon] = names;
        let text =
            text.replace("GPS Speed", speed).replace("Latitude", lat).replace("Longitude", lon);
        encoding.encode(&text).0.into_owned()
    };
    let russian = named(["Скорость GPS", "Широта", "Долгота"], encoding_rs::WINDOWS_1251);
    let japanese = named(["GPS速度", "緯度", "経度"], encoding_rs::SHIFT_JIS);
    hold(vec![
        case("\\r\\n", text.replace('\n', "\r\n"), Right),
        case("\\r", text.replace('\n', "\r"), Right),
        case("a mark", with_mark, Right),
        case("UTF-16", utf16(&text, true, true), Right),
        case("UTF-16, big end first", utf16(&text, true, false), Right),
        case("UTF-16 without a mark", utf16(&text, false, true), Right),
        case("Latin-1", latin, Right),
        case("windows-1251", russian, Right),
        case("Shift_JIS", japanese, Right),
        case("zeros of a lost power", lost, Warned("cut_off")),
        case("zeros, and on in the same file", went_on, Warned("bad_line")),
        case("cut off", text[..cut + 12].to_owned(), Warned("cut_off")),
    ]);
}

#[test]
fn rows_that_are_none() {
    let names = "Time (s),GPS Speed (km/h),Latitude (deg),Longitude (deg),Lean (deg)";
    let glued = |l: &str| joined(l, 1, ";");
    let short = |l: &str| l.rsplit_once(',').expect("cells").0.to_owned();
    let bare = plain().replace(" (s)", "").replace(" (km/h)", "").replace(" (deg)", "");
    let broken = plain().replacen("Time (s)", "\"Time\n(s)\"", 1).replacen(
        "GPS Speed (km/h)",
        "\"GPS Speed\r\n(km/h)\"",
        1,
    );
    let mut long = "SECONDS;PID;VALUE;UNITS\n".to_owned();
    for r in usual() {
        let values =
            [("Speed", r.kmh()), ("Latitude", r.lat), ("Longitude", r.lon), ("Lean", r.lean)];
        for (name, value) in values {
            let _ = writeln!(long, "{:.2};{name};{value};-", r.t);
        }
    }
    let below = |row: &str| bare.replacen('\n', &format!("\n{row}\n"), 1);
    hold(vec![
        case("a row of fewer cells", changed(20, short), Warned("bad_line")),
        case("a row of more cells", changed(20, |l| format!("{l},7")), Warned("bad_line")),
        case("a row of glued cells", changed(20, glued), Warned("bad_line")),
        case("glued cells", rows(glued), Refused("line 2")),
        case("one name too few", plain().replacen(",Lean (deg)", "", 1), Refused("line 2")),
        case("one name too many", plain().replacen('\n', ",Brake F (bar)\n", 1), Refused("line 2")),
        case("the names again", changed(30, |l| format!("{names}\n{l}")), Warned("bad_line")),
        case("a comment within", changed(30, |l| format!("# lap 2\n{l}")), Warned("bad_line")),
        case("a comment above", format!("# my logger 1.2\n# of 2026\n{}", plain()), Right),
        case("a comment below the names", plain().replacen('\n', "\n# begins\n", 1), Right),
        case("keys above", format!("Logger;X1\nDriver;N. N.\n\n{}", plain()), Right),
        case("units below", below("s,km/h,deg,deg,deg"), Right),
        case("units in brackets below", below("[s],[km/h],[deg],[deg],[deg]"), Right),
        case("line breaks in the names", broken, Right),
        case("no names", plain().split_once('\n').expect("names").1, Refused("names in front")),
        case("one value in a line", long, Refused("one value in a line")),
        case("blank lines", plain().replace('\n', "\n\n"), Right),
    ]);
}

#[test]
fn cells_that_are_none() {
    let speed = |l: &str, cell: &str| {
        let mut cells: Vec<&str> = l.split(',').collect();
        cells[1] = cell;
        cells.join(",")
    };
    let with_unit = |l: &str| joined(l, 1, " km/h,");
    hold(vec![
        case("an empty column", rows(|l| joined(l, 1, ",,")).replacen(",Lat", ",,Lat", 1), Right),
        case("a comma at every end", plain().replace('\n', ",\n"), Right),
        case("a comma at the rows' ends", rows(|l| format!("{l},")), Right),
        case("a comma at the names' end", plain().replacen('\n', ",\n", 1), Right),
        case("units behind the numbers", rows(with_unit).replace("Speed (km/h)", "Speed"), Right),
        case("9999 for none", changed(20, |l| speed(l, "9999")), Warned("no_sample")),
        case("-9999.0 for none", changed(20, |l| speed(l, "-9999.0")), Warned("no_sample")),
        case("65535 for none", changed(20, |l| speed(l, "65535")), Warned("no_sample")),
        case("nan", changed(20, |l| speed(l, "NaN")), Warned("gap")),
        case("none of a spreadsheet", changed(20, |l| speed(l, "#N/A")), Warned("gap")),
        case("nothing", changed(20, |l| speed(l, "")), Warned("gap")),
        case("words", rows(|l| speed(l, "fast")), Refused("")),
    ]);
}

#[test]
fn columns_of_one_name() {
    // the first is 10 % too fast
    let twice = |l: &str| {
        let cells: Vec<&str> = l.split(',').collect();
        let fast =
            cells[1].parse::<f64>().map_or(cells[1].to_owned(), |v| format!("{:.2}", 1.1 * v));
        format!("{},{fast},{}", cells[0], cells[1..].join(","))
    };
    let text = rows(twice);
    let names =
        "Time (s),GPS Speed (km/h),GPS Speed (km/h),Latitude (deg),Longitude (deg),Lean (deg)";
    let (_, numbers) = text.split_once('\n').expect("names");
    hold(vec![case("two speeds", format!("{names}\n{numbers}"), Right)]);
}

#[test]
fn packed_logs_and_those_that_are_not() {
    let named = |what: &'static str, file: &'static str, bytes: Vec<u8>, expected: Expected| Case {
        file,
        ..case(what, bytes, expected)
    };
    hold(vec![
        named("plain text called .gz", "ride.csv.gz", plain().into_bytes(), Right),
        named("xz", "ride.csv.xz", b"\xfd7zXZ\0\0\x04\xe6\xd6\xb4F".to_vec(), Refused("unxz")),
        named("bzip2", "ride.csv", b"BZh91AY&SY\xe6\x83\x9f".to_vec(), Refused("bunzip2")),
    ]);
}
